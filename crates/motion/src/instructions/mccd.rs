//! MCCD, Motion Coordinated Change Dynamics (spec/coordinated-instructions.md §14, the reference page MCCD).

use arcline_instruction_set::enumerations::Scope;
use arcline_instruction_set::operands::Mccd;
use arcline_instruction_set::{Call, Flag, MotionError, SystemId};

use super::programmed::{Change, ChangeOperands, Rates};
use crate::dynamics::{Dynamics, Maxima};
use crate::execution::Execution;
use crate::machine::CoordinateSystem;
use crate::motion::Motion;
use crate::system::{Activity, Planned};
use crate::verify;

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let index = motion.target_system(call)?;
    let Mccd {
        motion_type: _,
        change_speed,
        speed,
        speed_units,
        change_accel,
        accel_rate,
        accel_units,
        change_decel,
        decel_rate,
        decel_units,
        change_accel_jerk,
        accel_jerk,
        change_decel_jerk,
        decel_jerk,
        jerk_units,
        scope,
    } = motion.operands(call)?;
    let operands = ChangeOperands {
        rates: Rates {
            speed,
            speed_units,
            accel_rate,
            accel_units,
            decel_rate,
            decel_units,
            accel_jerk,
            decel_jerk,
            jerk_units,
        },
        change_speed: *change_speed,
        change_accel: *change_accel,
        change_decel: *change_decel,
        change_accel_jerk: *change_accel_jerk,
        change_decel_jerk: *change_decel_jerk,
    };
    let system = &motion.systems[index];
    let active = system.active().filter(|_| system.activity == Activity::Moving);
    let driven = active.is_some_and(|active| active.driven_by.is_some());
    operands.verify_mode(driven)?;
    verify::axes_ready(&motion.systems[index], &motion.axes)?;
    verify::not_homing(&motion.systems[index], &motion.axes)?;
    let s_curve = active.is_some_and(|active| active.dynamics.is_s_curve());
    verify::stoppable(&motion.systems[index], &motion.axes, s_curve)?;
    let system = &mut motion.systems[index];
    let active = match (system.activity, system.active()) {
        (Activity::Moving, Some(active)) => *active,
        (Activity::Stopping, _) => return verify::not_stopping(system, &motion.axes),
        _ => return Err(MotionError::IllegalDynamicChange),
    };
    let maxima = maxima(&system.description);
    let read = maxima.map(|maxima| operands.change(&maxima));
    // Every move that is changed must be of the mode of the change.
    let modes = [false, true].map(|driven| operands.verify_mode(driven));
    let change = |planned: &Planned| {
        modes[usize::from(planned.driven_by.is_some())]?;
        changed(&read[usize::from(planned.only_turns)], planned)
    };
    let dynamics = change(&active)?;
    if *scope == Scope::ActiveAndPending {
        // None is changed where one of them cannot be.
        for waiting in system.travel.waiting() {
            modes[usize::from(waiting.data.driven_by.is_some())]?;
            read[usize::from(waiting.data.only_turns)].verify(waiting.data.dynamics.is_s_curve())?;
        }
        let base = system.time_base(&motion.clock);
        system.travel.change_waiting(&dynamics.limits(), &base, |waiting| {
            if let Ok(dynamics) = change(&waiting.data) {
                waiting.data.dynamics = dynamics;
                waiting.limits = dynamics.limits();
            }
        });
    }
    system.change_active(dynamics, &motion.clock);
    calculate_again(motion, index, active.execution);
    motion.done(execution);
    Ok(())
}

/// What had been calculated for the active move is given anew at the next update.
fn calculate_again(motion: &mut Motion, index: SystemId, active: Execution) {
    let tick = motion.clock.tick;
    motion.systems[index].calculated.1 = tick + 1;
    let available = Flag::CalculatedDataAvailable;
    motion.controls.flag(active, available, false);
}

/// The dynamics of a move with what a call changes, no faster than the joints of robots let it be.
fn changed(change: &Change, planned: &Planned) -> Result<Dynamics, MotionError> {
    let mut dynamics = change.of(planned.dynamics)?;
    dynamics.keep_to(&planned.path_limits);
    Ok(dynamics)
}

/// The maxima of what moves, and of what only turns; a turn's jerks are in percent of time.
fn maxima(system: &CoordinateSystem) -> [Maxima; 2] {
    let moves = Maxima::from(system);
    let turns = system.orientation.map_or(moves, |turn| Maxima {
        speed: turn.max_speed,
        acceleration: turn.max_acceleration,
        deceleration: turn.max_deceleration,
        acceleration_jerk: turn.max_acceleration * turn.max_acceleration / turn.max_speed,
        deceleration_jerk: turn.max_deceleration * turn.max_deceleration / turn.max_speed,
    });
    [moves, turns]
}

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
use crate::verify::{self, members};

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
    verify::ready(members(&motion.systems[index], &motion.axes))?;
    verify::not_homing(members(&motion.systems[index], &motion.axes))?;
    let s_curve = active.is_some_and(|active| active.dynamics.is_s_curve());
    verify::system_stoppable(&motion.systems[index], &motion.axes, s_curve)?;
    let system = &mut motion.systems[index];
    let active = match (system.activity, system.active()) {
        (Activity::Moving, Some(active)) => *active,
        (Activity::Stopping, _) => return verify::system_not_stopping(system, &motion.axes),
        _ => return Err(MotionError::IllegalDynamicChange),
    };
    let maxima = maxima(&system.description);
    let read = maxima.map(|maxima| operands.change(&maxima));
    // The mode of the change must be that of every move that it changes.
    let modes = [false, true].map(|driven| operands.verify_mode(driven));
    let change = |planned: &Planned| {
        modes[usize::from(planned.driven_by.is_some())]?;
        changed(&read[usize::from(planned.only_turns)], planned)
    };
    let dynamics = change(&active)?;
    if *scope == Scope::ActiveAndPending {
        // No move changes unless all of them can.
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

/// Makes the next update calculate the Calculated Data of the active move again.
fn calculate_again(motion: &mut Motion, index: SystemId, active: Execution) {
    let tick = motion.clock.tick;
    motion.systems[index].calculated.1 = tick + 1;
    let available = Flag::CalculatedDataAvailable;
    motion.controls.flag(active, available, false);
}

/// The dynamics of a move with the changes of a call, within the limits of the robots' joints.
fn changed(change: &Change, planned: &Planned) -> Result<Dynamics, MotionError> {
    let mut dynamics = change.of(planned.dynamics)?;
    dynamics.keep_to(&planned.path_limits);
    Ok(dynamics)
}

/// The maxima of motion along X, Y, Z, and of a rotation alone; the jerks of a rotation are in percent of time.
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

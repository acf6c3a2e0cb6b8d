//! MCCD, Motion Coordinated Change Dynamics (spec/coordinated-instructions.md §14, the MCCD seed).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError};
use arcline_planner::ContourQueue;

use super::place;
use super::programmed::ChangeLayout;
use crate::control::Execution;
use crate::dynamics::{Dynamics, Maxima};
use crate::machine::CoordinateSystem;
use crate::motion::Motion;
use crate::system::{Activity, Planned};
use crate::verify;

/// Places of MCCD's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    dynamics: ChangeLayout,
    scope: usize,
}

/// Scope: Active and Pending Motion.
const ACTIVE_AND_PENDING: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        Layout {
            dynamics: ChangeLayout::of(Mnemonic::Mccd),
            scope: place(Mnemonic::Mccd, "Scope"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mccd;
    let index = motion.target_system(call)?;
    motion.verify_operands(call)?;
    let system = &mut motion.systems[index];
    let active = system.active().filter(|_| system.activity == Activity::Moving);
    let driven = active.is_some_and(|active| active.lead.is_some());
    layout.dynamics.verify_mode(call, driven)?;
    verify::axes_ready(&motion.systems[index], &motion.axes)?;
    let system = &mut motion.systems[index];
    let active = match (system.activity, system.active()) {
        (Activity::Moving, Some(active)) => active,
        (Activity::Stopping, _) => return verify::not_stopping(system, &motion.axes),
        _ => return Err(MotionError::IllegalDynamicChange),
    };
    verify::stoppable(system, &motion.axes, active.dynamics.is_s_curve())?;
    let [moves, turns] = maxima(&system.description);
    let change = |planned: &Planned| {
        let maxima = if planned.only_turns { &turns } else { &moves };
        changed(&layout, call, maxima, planned)
    };
    let dynamics = change(&active)?;
    if system.contour_in_force().is_some() {
        change_contour(motion, index, call, active.dynamics.speed, dynamics.speed)?;
        motion.done(execution);
        return Ok(());
    }
    if call.word(layout.scope) == ACTIVE_AND_PENDING {
        if let Some(contour) = &mut system.contour {
            change_unplanned(contour, change)?;
        }
        for waiting in system.planner.pending() {
            layout.dynamics.verify_mode(call, waiting.data.lead.is_some())?;
            change(&waiting.data)?;
        }
        for waiting in system.planner.pending_mut() {
            waiting.data.dynamics = change(&waiting.data)?;
            waiting.limits = waiting.data.dynamics.limits();
        }
    }
    if let Some(active) = system.planner.active_data() {
        active.dynamics = dynamics;
    }
    let clock = system.clock(&motion.clock);
    system.planner.change_limits(dynamics.limits(), &clock);
    system.stale = true;
    // What had been calculated is given anew at the next update.
    let tick = motion.clock.tick;
    system.calculated.1 = tick + 1;
    motion
        .controls
        .flag(active.execution, Flag::CalculatedDataAvailable, false, tick);
    motion.done(execution);
    Ok(())
}

/// On a planned contour a new speed is a pace, at most the planned one; everything else is for the moves that have not
/// been planned yet.
fn change_contour(
    motion: &mut Motion,
    index: usize,
    call: &Call,
    programmed: f64,
    speed: f64,
) -> Result<(), MotionError> {
    let layout = motion.layouts.mccd;
    let system = &mut motion.systems[index];
    let maxima = Maxima::from(&system.description);
    let change = |planned: &Planned| changed(&layout, call, &maxima, planned);
    let Some(contour) = &mut system.contour else {
        return Ok(());
    };
    if call.word(layout.scope) == ACTIVE_AND_PENDING {
        change_unplanned(contour, change)?;
    }
    if layout.dynamics.changes_speed(call) && programmed > 0.0 {
        contour.set_share(speed / programmed, &motion.clock);
        system.stale = true;
    }
    Ok(())
}

/// The dynamics of a move with what the call changes, no faster than the joints of robots let it be.
fn changed(layout: &Layout, call: &Call, maxima: &Maxima, planned: &Planned) -> Result<Dynamics, MotionError> {
    let mut dynamics = layout.dynamics.change(call, maxima, planned.dynamics)?;
    dynamics.keep_to(&planned.pace);
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

/// All of the moves that have not been planned yet, or none.
fn change_unplanned(
    contour: &mut ContourQueue<Planned>,
    change: impl Fn(&Planned) -> Result<Dynamics, MotionError>,
) -> Result<(), MotionError> {
    for waiting in contour.unplanned_mut() {
        change(&waiting.data)?;
    }
    for waiting in contour.unplanned_mut() {
        waiting.data.dynamics = change(&waiting.data)?;
        waiting.limits = waiting.data.dynamics.limits();
    }
    Ok(())
}

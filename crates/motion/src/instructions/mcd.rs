//! MCD, Motion Change Dynamics (spec/axis-and-data-types.md §3.6).

use arcline_instruction_set::{AxisIndex, Call, Flag, Mnemonic, MotionError};
use arcline_planner::profile::{KinematicState, Lead, Limits, Profile};

use super::axis_moves;
use super::place;
use super::programmed::ChangeLayout;
use crate::axis::generator::{Goal, Program};
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::motion::Motion;

/// Places of MCD's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    dynamics: ChangeLayout,
    motion_type: usize,
}

/// Motion Type: the move of the axis; otherwise its jog.
const MOVE: i32 = 1;

impl Layout {
    pub(super) fn new() -> Self {
        Layout {
            dynamics: ChangeLayout::of(Mnemonic::Mcd),
            motion_type: place(Mnemonic::Mcd, "Motion Type"),
        }
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mcd;
    let axis = motion.target_axis(call)?;
    motion.verify_operands(call)?;
    let slot = if call.word(layout.motion_type) == MOVE {
        Slot::Move
    } else {
        Slot::Jog
    };
    let clock = motion.clock;
    let state = &mut motion.axes[usize::from(axis)];
    let guide = state.sum.get(slot).and_then(|generator| generator.guide);
    layout.dynamics.verify_mode(call, guide.is_some())?;
    let running = state.sum.get(slot).and_then(|generator| generator.program);
    axis_moves::verify_axis(state, running.is_some_and(|program| program.dynamics.is_s_curve()))?;
    axis_moves::not_stopping(state)?;
    let (maxima, bounds) = (state.dynamics, state.bounds);
    let Some(generator) = state.sum.get_mut(slot) else {
        return Err(MotionError::IllegalDynamicChange);
    };
    let Some(Program {
        dynamics: programmed,
        goal,
    }) = running
    else {
        // Without a program it only brakes.
        return Err(MotionError::NotAllowedWhileStopping(AxisIndex(0)));
    };
    let dynamics = layout.dynamics.read(call, &maxima).of(programmed)?;
    let now = axis_moves::steady(generator.planned_state(&clock), &dynamics.limits());
    let (before, paused) = (generator.in_force, programmed.speed == 0.0);
    let (goal, mut limits) = match goal {
        Goal::Position(_) => (goal, dynamics.limits()),
        Goal::Velocity(velocity) => {
            // The direction is kept in the sign of a speed of 0 too.
            let velocity = dynamics.speed.copysign(velocity);
            (Goal::Velocity(velocity), dynamics.jog_limits(now.velocity, velocity))
        }
    };
    if dynamics.speed == 0.0 && bounds.overshoot {
        limits = pause(now, &limits, before.as_ref());
    }
    // What pauses may brake with more jerk than it goes on with.
    let rest = (paused && bounds.overshoot)
        .then(|| Lead::before_rest(now, &limits))
        .flatten();
    let lead = axis_moves::relief(bounds, now, &limits, before.as_ref()).or(rest);
    let profile = Profile::led(lead, now, |from| match goal {
        Goal::Position(target) => Profile::to_position_two_stage(from, target, &limits),
        Goal::Velocity(velocity) => Profile::to_velocity(from, velocity, &limits),
    });
    generator.follow(profile, generator.clock(&clock).now());
    generator.keeps(&limits);
    generator.program = Some(Program { dynamics, goal });
    // What had been calculated is given anew at the next update.
    let calculated = generator.events.as_mut().and_then(|events| {
        events.due = Some(clock.tick + 1);
        generator.execution
    });
    state.stale = true;
    if let Some(changed) = calculated {
        let available = Flag::CalculatedDataAvailable;
        motion.controls.flag(changed, available, false, clock.tick);
    }
    motion.done(execution);
    Ok(())
}

/// The limits with which a pause takes no more way than with those so far (spec/coordinated-instructions.md §5.4).
fn pause(from: KinematicState, limits: &Limits, before: Option<&Limits>) -> Limits {
    let reach = |limits: &Limits| Profile::stop(from, limits).reach();
    match before {
        Some(before) if reach(limits) > reach(before) * (1.0 + NEARLY) => Limits {
            speed: limits.speed,
            ..*before
        },
        _ => *limits,
    }
}

/// Share of a way that is rounding.
const NEARLY: f64 = 1e-9;

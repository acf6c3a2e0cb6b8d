//! MCD, Motion Change Dynamics (spec/axis-and-data-types.md §3.6).

use arcline_instruction_set::enumerations::McdMotionType;
use arcline_instruction_set::operands::Mcd;
use arcline_instruction_set::{AxisIndex, Call, Flag, MotionError};
use arcline_planner::profile::{AccelerationRemovalPhase, KinematicState, Limits, Profile};

use super::axis_moves;
use super::programmed::{ChangeOperands, Rates};
use crate::axis::generator::{Goal, ProgrammedMotion};
use crate::axis::generator_kind::GeneratorKind;
use crate::execution::Execution;
use crate::motion::Motion;
use crate::tolerance::DISTANCE_SHARE;
use crate::verify::{self, alone};

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mcd {
        motion_type,
        change_speed,
        speed,
        change_accel,
        accel_rate,
        change_decel,
        decel_rate,
        change_accel_jerk,
        accel_jerk,
        change_decel_jerk,
        decel_jerk,
        speed_units,
        accel_units,
        decel_units,
        jerk_units,
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
    let kind = match *motion_type {
        McdMotionType::Jog => GeneratorKind::Jog,
        McdMotionType::Move => GeneratorKind::Move,
    };
    let clock = motion.clock;
    let state = &mut motion.axes[axis];
    let follower = state.sum.get(kind).and_then(|generator| generator.follower);
    operands.verify_mode(follower.is_some())?;
    let running = state.sum.get(kind).and_then(|generator| generator.program);
    axis_moves::verify_axis(state, running.is_some_and(|program| program.dynamics.is_s_curve()))?;
    verify::not_stopping(alone(state))?;
    let (maxima, dynamics_bits) = (state.dynamics, state.dynamics_bits);
    let Some(generator) = state.sum.get_mut(kind) else {
        return Err(MotionError::IllegalDynamicChange);
    };
    let Some(ProgrammedMotion {
        dynamics: programmed,
        goal,
    }) = running
    else {
        // A generator without a program only brakes.
        return Err(MotionError::NotAllowedWhileStopping(AxisIndex(0)));
    };
    let dynamics = operands.change(&maxima).of(programmed)?;
    let now = axis_moves::steady(generator.planned_state(&clock), &dynamics.limits());
    let (before, paused) = (generator.in_force, programmed.speed == 0.0);
    let (goal, mut limits) = match goal {
        Goal::Position(_) => (goal, dynamics.limits()),
        Goal::Velocity(velocity) => {
            // A speed of 0 carries the direction in its sign, too.
            let velocity = dynamics.speed.copysign(velocity);
            (Goal::Velocity(velocity), dynamics.jog_limits(now.velocity, velocity))
        }
    };
    if dynamics.speed == 0.0 && dynamics_bits.overshoot {
        limits = pause(now, &limits, before.as_ref());
    }
    // An axis that pauses brakes with its stop jerk, which may be higher than the jerk with which it continues.
    let rest = (paused && dynamics_bits.overshoot)
        .then(|| AccelerationRemovalPhase::before_rest(now, &limits))
        .flatten();
    let removal_phase = axis_moves::removal_phase(dynamics_bits, now, &limits, before.as_ref()).or(rest);
    let profile = Profile::after_removal(removal_phase, now, |from| match goal {
        Goal::Position(target) => Profile::to_position_two_stage(from, target, &limits),
        Goal::Velocity(velocity) => Profile::to_velocity(from, velocity, &limits),
    });
    generator.follow(profile, generator.clock(&clock).now());
    generator.set_limits_in_force(&limits);
    generator.program = Some(ProgrammedMotion { dynamics, goal });
    // The next update calculates the Calculated Data again.
    let calculated = generator.events.as_mut().and_then(|events| {
        events.due = Some(clock.tick + 1);
        generator.execution
    });
    state.stale = true;
    if let Some(changed) = calculated {
        let available = Flag::CalculatedDataAvailable;
        motion.controls.flag(changed, available, false);
    }
    motion.done(execution);
    Ok(())
}

/// The limits of a pause whose distance is no longer than under the earlier limits (spec/coordinated-instructions.md §5.4).
fn pause(from: KinematicState, limits: &Limits, before: Option<&Limits>) -> Limits {
    let reach = |limits: &Limits| Profile::stop(from, limits).reach();
    match before {
        Some(before) if reach(limits) > reach(before) * (1.0 + DISTANCE_SHARE) => Limits {
            speed: limits.speed,
            ..*before
        },
        _ => *limits,
    }
}

//! MAS, Motion Axis Stop (spec/axis-and-data-types.md §3.1).

use arcline_instruction_set::enumerations::MasStopType;
use arcline_instruction_set::operands::{Mas, StopOperands};
use arcline_instruction_set::{Call, Flag, MotionError};
use arcline_planner::profile::{Jerk, Limits};

use super::programmed::{positive, stop_change};
use crate::axis::generator_kind::GeneratorKind;
use crate::dynamics::{Maxima, resolve, speed_for_jerk};
use crate::execution::Execution;
use crate::motion::Motion;
use crate::verify::{self, alone};

/// Deceleration and jerk of the stop of a motion at `speed`; the maxima are those of the axis.
fn limits(operands: &StopOperands, own: &Maxima, speed: f64, s_curve: bool) -> Result<Limits, MotionError> {
    let changed = stop_change(operands, own);
    let mut limits = own.stop(s_curve);
    if let Some(deceleration) = changed.deceleration {
        limits.deceleration = deceleration;
        limits.acceleration = deceleration;
    }
    positive(limits.deceleration, operands.decel_rate.index)?;
    if let Some(programmed) = changed.jerk.filter(|_| s_curve) {
        let jerk = resolve(programmed, speed_for_jerk(speed, own.speed), limits.deceleration);
        positive(jerk, operands.decel_jerk.index)?;
        limits.jerk = Some(Jerk {
            acceleration: jerk,
            deceleration: jerk,
        });
    }
    Ok(limits)
}

/// The motion that a Stop Type stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stopped {
    /// All motion of the axis.
    All,
    Kind(GeneratorKind),
    /// A kind of motion that the controller does not have.
    Nothing,
}

fn stopped(stop_type: MasStopType) -> Stopped {
    match stop_type {
        MasStopType::All => Stopped::All,
        MasStopType::Jog => Stopped::Kind(GeneratorKind::Jog),
        MasStopType::Move => Stopped::Kind(GeneratorKind::Move),
        MasStopType::Gear => Stopped::Kind(GeneratorKind::Gear),
        MasStopType::Home => Stopped::Kind(GeneratorKind::Home),
        MasStopType::TimeCam => Stopped::Kind(GeneratorKind::TimeCam),
        MasStopType::PositionCam => Stopped::Kind(GeneratorKind::PositionCam),
        MasStopType::MasterOffsetMove => Stopped::Kind(GeneratorKind::MasterOffset),
        MasStopType::Tune | MasStopType::Test | MasStopType::DirectControl => Stopped::Nothing,
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let axis = motion.target_axis(call)?;
    let Mas { stop_type, rates } = motion.operands(call)?;
    let stopped = stopped(*stop_type);
    let state = &motion.axes[axis];
    verify::switched_on(alone(state))?;
    verify::stoppable(alone(state))?;
    let initiated = Flag::Dn.mask() | Flag::Ip.mask();
    if matches!(stopped, Stopped::All | Stopped::Kind(GeneratorKind::Home)) {
        motion.axes[axis].end_passive_homing(&mut motion.controls);
    }
    match stopped {
        Stopped::All => motion.axes[axis].end_pending_cams(None, &mut motion.controls),
        Stopped::Kind(kind) => motion.axes[axis].end_pending_cams(Some(kind), &mut motion.controls),
        Stopped::Nothing => {}
    }
    let state = &motion.axes[axis];
    match stopped {
        Stopped::All if state.in_motion() => {
            let limits = limits(
                &rates,
                &state.dynamics,
                state.command.velocity.abs(),
                state.is_s_curve(),
            )?;
            for index in motion.systems.ids() {
                if motion.systems[index].has(axis) && motion.axes[axis].is_coordinated() {
                    motion.abort_system(index, |_| false);
                }
            }
            motion.controls.write(execution, initiated, 0);
            motion.stop_axis_at(axis, &limits, Some(execution));
            motion.unlink_slave(axis);
        }
        Stopped::Kind(kind) if state.sum.is_active(kind) => {
            let generator = state.sum.get(kind);
            let (speed, s_curve) = generator.map_or((0.0, false), |generator| {
                (generator.now.velocity.abs(), generator.s_curve)
            });
            let limits = limits(&rates, &state.dynamics, speed, s_curve)?;
            motion.controls.write(execution, initiated, 0);
            motion.axes[axis].stop_generator(kind, &limits, Some(execution), &mut motion.controls, &motion.clock);
        }
        // No motion of that kind is under way; a transform that moves no axis now is still cancelled.
        other => {
            if other == Stopped::All {
                motion.cancel_transforms_of(axis);
                motion.unlink_slave(axis);
            }
            let nothing_to_stop = Flag::Dn.mask() | Flag::Pc.mask();
            motion.controls.write(execution, nothing_to_stop, 0);
        }
    }
    Ok(())
}

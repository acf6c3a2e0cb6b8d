//! MAS, Motion Axis Stop (spec/axis-and-data-types.md §3.1).

use arcline_instruction_set::{Call, Flag, Mnemonic, MotionError};
use arcline_planner::profile::{Jerk, Limits};

use super::axis_moves::{stoppable, switched_on};
use super::place;
use super::programmed::positive;
use crate::axis::sum::Slot;
use crate::control::Execution;
use crate::dynamics::{in_units, jerk_in_units, resolve};
use crate::motion::Motion;

/// Places of MAS's operands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    stop_type: usize,
    change_decel: usize,
    decel_rate: usize,
    decel_units: usize,
    change_decel_jerk: usize,
    decel_jerk: usize,
    jerk_units: usize,
}

impl Layout {
    pub(super) fn new() -> Self {
        let place = |name| place(Mnemonic::Mas, name);
        Layout {
            stop_type: place("Stop Type"),
            change_decel: place("Change Decel"),
            decel_rate: place("Decel Rate"),
            decel_units: place("Decel Units"),
            change_decel_jerk: place("Change Decel Jerk"),
            decel_jerk: place("Decel Jerk"),
            jerk_units: place("Jerk Units"),
        }
    }

    /// Deceleration and jerk of the stop of a motion at `speed`.
    fn limits(
        &self,
        motion: &Motion,
        axis: u16,
        call: &Call,
        speed: f64,
        s_curve: bool,
    ) -> Result<Limits, MotionError> {
        let own = &motion.axes[usize::from(axis)].dynamics;
        let mut limits = own.stop(s_curve);
        if call.is_one(self.change_decel) {
            limits.deceleration = in_units(
                call.number(self.decel_rate),
                call.word(self.decel_units),
                own.deceleration,
            );
            limits.acceleration = limits.deceleration;
        }
        positive(limits.deceleration, self.decel_rate)?;
        if s_curve && call.is_one(self.change_decel_jerk) {
            let programmed = jerk_in_units(
                call.number(self.decel_jerk),
                call.word(self.jerk_units),
                own.deceleration_jerk,
            );
            let reference = if speed > 0.0 { speed } else { own.speed };
            let jerk = resolve(programmed, reference, limits.deceleration);
            positive(jerk, self.decel_jerk)?;
            limits.jerk = Some(Jerk {
                acceleration: jerk,
                deceleration: jerk,
            });
        }
        Ok(limits)
    }
}

/// What a Stop Type stops; `None`: everything on the axis.
fn stopped(stop_type: i32) -> Option<Option<Slot>> {
    match stop_type {
        0 => Some(None),
        1 => Some(Some(Slot::Jog)),
        2 => Some(Some(Slot::Move)),
        3 => Some(Some(Slot::Gear)),
        4 => Some(Some(Slot::Home)),
        7 => Some(Some(Slot::TimeCam)),
        8 => Some(Some(Slot::PositionCam)),
        9 => Some(Some(Slot::MasterOffset)),
        _ => None,
    }
}

pub(super) fn execute(motion: &mut Motion, execution: Execution, call: &Call) -> Result<(), MotionError> {
    let layout = motion.layouts.mas;
    let axis = motion.target_axis(call)?;
    let at = usize::from(axis);
    motion.verify_operands(call)?;
    let state = &motion.axes[at];
    switched_on(state)?;
    stoppable(state)?;
    let tick = motion.clock.tick;
    let initiated = Flag::Dn.mask() | Flag::Ip.mask();
    if matches!(stopped(call.word(layout.stop_type)), Some(None | Some(Slot::Home))) {
        motion.end_passive_homing(axis);
    }
    if let Some(kind) = stopped(call.word(layout.stop_type)) {
        motion.end_pending_cams(axis, kind);
    }
    let state = &motion.axes[at];
    match stopped(call.word(layout.stop_type)) {
        Some(None) if state.in_motion() => {
            let limits = layout.limits(motion, axis, call, state.command.velocity.abs(), state.is_s_curve())?;
            for index in 0..motion.systems.len() {
                if motion.systems[index].has(axis) && motion.axes[at].is_coordinated() {
                    motion.abort_system(index, |_| false);
                }
            }
            motion.controls.write(execution, initiated, 0, tick);
            motion.stop_axis_at(axis, &limits, Some(execution));
            motion.unlink_slave(axis);
        }
        Some(Some(slot)) if state.sum.is_active(slot) => {
            let generator = state.sum.get(slot);
            let (speed, s_curve) = generator.map_or((0.0, false), |generator| {
                (generator.now.velocity.abs(), generator.s_curve)
            });
            let limits = layout.limits(motion, axis, call, speed, s_curve)?;
            motion.controls.write(execution, initiated, 0, tick);
            motion.stop_generator(axis, slot, &limits, Some(execution));
        }
        // Nothing of that kind is under way; a transform that leads nobody now is cancelled all the same.
        other => {
            if other == Some(None) {
                motion.cancel_transforms_of(axis);
                motion.unlink_slave(axis);
            }
            let nothing_to_stop = Flag::Dn.mask() | Flag::Pc.mask();
            motion.controls.write(execution, nothing_to_stop, 0, tick);
        }
    }
    Ok(())
}

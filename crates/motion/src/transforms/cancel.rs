//! The end of a transform: the source moves the target no longer, and the target's motion brakes (spec/coordinated-instructions.md §15.1,
//! §19.7).

use arcline_instruction_set::AxisId;
use arcline_planner::Instant;
use arcline_planner::profile::{Limits, Profile};
use arcline_profile::KinematicState;

use super::sides::{Positions, SideState};
use super::transform::Transform;
use super::{TransformId, Transforms};
use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::axis::state::AxisState;
use crate::dynamics::stop_limits;
use crate::execution::Execution;
use crate::machine::CoordinateSystem;
use crate::stop::AxisSet;
use crate::system::Systems;
use crate::tolerance::NO_ROOM_UNITS;

/// The rates at which the axes of a cancelled transform come to rest separately. `None` is the maximum of the coordinate system for which
/// the transform moved the axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Release {
    /// Units/s².
    pub(crate) deceleration: Option<f64>,
    /// Units/s³, if the motion of the transform is an S-curve.
    pub(crate) jerk: Option<f64>,
}

/// A transform that was cancelled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cancelled {
    /// Its instruction, if it has not ended yet.
    pub(crate) execution: Option<Execution>,
    /// The axes that brake.
    pub(crate) braking: AxisSet,
}

impl Transforms {
    /// Ends a transform; the motion that it caused brakes from `now` on.
    pub(crate) fn cancel(
        &mut self,
        id: TransformId,
        release: &Release,
        axes: &mut Axes,
        systems: &Systems,
        now: Instant,
    ) -> Option<Cancelled> {
        let transform = self.active.get_mut(id.index())?.take()?;
        let s_curve = transform.source.iter().any(|axis| axes[*axis].is_s_curve());
        let own_s_curve = transform.target.iter().any(|axis| {
            let mut own = axes[*axis]
                .sum
                .active()
                .filter(|(kind, _)| *kind != GeneratorKind::Transform);
            own.any(|(_, generator)| generator.s_curve)
        });
        // Every axis leaves the transform before any of them brakes, so positions stay unchanged.
        self.keep_feedback(id, &transform);
        for (axis, feedback) in transform.source.iter().zip(&transform.feedback) {
            let membership = &mut axes[*axis].transforms;
            membership.settled += feedback.position;
            membership.source_of &= !id.bit();
            self.release(*axis, axes);
        }
        for (axis, state) in transform.target.iter().zip(&transform.target_set_points) {
            let membership = &mut axes[*axis].transforms;
            membership.rest = state.position;
            membership.target_of = None;
            self.release(*axis, axes);
        }
        let mut braking = AxisSet::default();
        let sides = [
            (
                transform.source,
                &transform.feedback,
                transform.source_system,
                own_s_curve,
            ),
            (
                transform.target,
                &transform.target_set_points,
                id.target_system(),
                s_curve,
            ),
        ];
        for (side, motions, system, s_curve) in sides {
            let limits = release.limits(&systems[system].description, s_curve);
            for (axis, moved) in side.iter().zip(motions) {
                if brake(&mut axes[*axis], moved, &limits, now) {
                    braking.insert(*axis);
                }
            }
        }
        Some(Cancelled {
            execution: transform.execution,
            braking,
        })
    }

    /// Stores the feedback of a cancelled transform in earlier transforms of its source: with joints, both feedbacks together differ from one
    /// after the other.
    fn keep_feedback(&mut self, id: TransformId, cancelled: &Transform) {
        for other in self.active.iter_mut().take(id.index()).flatten() {
            for (axis, kept) in other.source.iter().zip(&mut other.cancelled_feedback) {
                if let Some(index) = cancelled.source.index_of(*axis) {
                    *kept += cancelled.feedback[index].position;
                }
            }
        }
    }

    /// Includes the feedback of cancelled transforms in that of the others, once all axes of transforms stand.
    pub(crate) fn merge_cancelled_feedback(&mut self, axes: &Axes) {
        let kept = |(_, transform): (TransformId, &Transform)| transform.cancelled_feedback != Positions::default();
        if !self.iter().any(kept) {
            return;
        }
        let adds = |transform: &Transform| transform.robot().is_some() && transform.feedback != SideState::default();
        let moves =
            |(_, transform): (TransformId, &Transform)| adds(transform) || self.moves_either_side(axes, transform);
        if !self.iter().any(moves) {
            for transform in self.active.iter_mut().flatten() {
                transform.cancelled_feedback = Positions::default();
            }
        }
    }

    /// Ends the part of an axis in one transform.
    fn release(&self, axis: AxisId, axes: &mut Axes) {
        let state = &mut axes[axis];
        if state.is_transformed() {
            self.compose(axis, axes);
        } else {
            state.transforms.controlled = false;
            state.end(GeneratorKind::Transform);
        }
    }
}

/// Brakes an axis that a cancelled transform moved. Returns true if the axis moves.
fn brake(axis: &mut Axis, moved: &KinematicState, limits: &Limits, now: Instant) -> bool {
    let limits = &within_travel(axis, moved, limits);
    let stands = moved.velocity == 0.0 && (moved.acceleration == 0.0 || limits.jerk.is_none());
    let brakes = !stands && axis.state == AxisState::Running;
    if brakes {
        axis.brake_after_transform(*moved, limits, now);
    }
    brakes
}

impl Release {
    fn limits(&self, system: &CoordinateSystem, s_curve: bool) -> Limits {
        let rate = self.deceleration.unwrap_or(system.max_deceleration);
        let jerk = self.jerk.unwrap_or(system.max_deceleration_jerk);
        stop_limits(system.max_speed, rate, s_curve.then_some(jerk))
    }
}

/// The limits with which an axis stops within its travel: `limits` if they suffice, otherwise a harder deceleration without a jerk limit.
fn within_travel(axis: &Axis, moved: &KinematicState, limits: &Limits) -> Limits {
    let [down, up] = axis.faults.room(axis.command.position);
    let room = if moved.velocity < 0.0 { -down } else { up };
    let from = KinematicState {
        position: 0.0,
        velocity: moved.velocity,
        acceleration: limits.jerk.map_or(0.0, |_| moved.acceleration),
    };
    if room.is_infinite() || Profile::stop(from, limits).end().position.abs() <= room {
        return *limits;
    }
    let deceleration = 0.5 * moved.velocity * moved.velocity / room.max(NO_ROOM_UNITS);
    Limits {
        deceleration: deceleration.max(limits.deceleration),
        jerk: None,
        ..*limits
    }
}

//! The set-points and the feedback of transforms within a tick (spec/coordinated-instructions.md §19, §20).
//!
//! The source moves the target: without motion of its own, the target is at the position to which the [`Map`] takes the source. The
//! target's own motion moves the source (feedback), so that both stay at the same point. Between Cartesian frames the feedback is a rotation
//! of the added motion. With a robot's joints the map is not linear: the target's own motion adds to the position that the source
//! gives it *before* any feedback ([`Transform::target_before`]), and the feedback of the source follows from the sum.
//!
//! Not here: the order of the computation (`crate::order`), the errors of MCT (`instructions::mct`), the reaction to a
//! robot that cannot follow (`crate::motion`). Nothing allocates. Units: position units, seconds.

use arcline_instruction_set::{AxisId, AxisIndex, MotionError};
use arcline_profile::KinematicState;

use super::guard;
use super::sides::{SideState, add, positions};
use super::transform::{Map, Transform};
use super::{TransformId, Transforms};
use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::generator::Generator;
use crate::axis::generator_kind::GeneratorKind;
use crate::tolerance::JOINT_AT_ONCE_DEG;

/// A step of the computation of the transform with this index in one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TransformStep {
    /// The position of the target before any feedback to the source.
    Before(TransformId),
    /// The motion that the target's own motion adds to the source.
    Feedback(TransformId),
    /// The position of the target by the whole source.
    SetPoints(TransformId),
}

impl Transforms {
    /// Computes a step of a transform at the present tick. `period`: seconds. Real-time.
    pub(crate) fn compute(&mut self, step: TransformStep, axes: &mut Axes, period: f64) {
        match step {
            TransformStep::Before(id) => self.compute_before(id, axes, period),
            TransformStep::Feedback(id) => self.compute_feedback(id, axes, period),
            TransformStep::SetPoints(id) => self.compute_set_points(id, axes, period),
        }
    }

    /// Computes the position of the target before any feedback to the source.
    fn compute_before(&mut self, id: TransformId, axes: &Axes, period: f64) {
        let Some(transform) = self.get(id).filter(|transform| transform.failed.is_none()) else {
            return;
        };
        let mut source = SideState::default();
        let cancelled = transform.cancelled_feedback;
        for ((axis, point), cancelled) in transform.source.iter().zip(&mut source).zip(cancelled) {
            *point = self.before_feedback(axes, *axis, id);
            point.position -= cancelled;
        }
        let target = transform.target_of(&source).and_then(|target| {
            if !transform.is_moved_by_feedback() {
                within_speeds(transform, axes, [&transform.target_before, &target], period)?;
            }
            Ok(target)
        });
        let Some(transform) = self.get_mut(id) else { return };
        match target {
            Ok(target) => (transform.source_before, transform.target_before) = (source, target),
            Err(error) => transform.fail(error, period),
        }
        if let (Map::Robot(robot), None) = (&mut transform.map, transform.failed) {
            let mut joints = positions(&transform.target_before);
            for (joint, offset) in joints.iter_mut().zip(transform.offset) {
                *joint -= offset;
            }
            robot.follow(&source, &joints);
        }
    }

    /// Computes the motion that the target's own motion adds to the source.
    fn compute_feedback(&mut self, id: TransformId, axes: &Axes, period: f64) {
        let Some(transform) = self.get(id) else { return };
        let target_moves = transform.target.iter().any(|axis| self.moves_by_itself(axes, *axis));
        let feedback = transform.feedback_of(&self.added_to(axes, transform));
        let feedback = feedback.and_then(|feedback| {
            within_speeds_back(transform, axes, &feedback, period)?;
            Ok(feedback)
        });
        let Some(transform) = self.get_mut(id) else { return };
        transform.target_moves = target_moves;
        match feedback {
            _ if transform.failed.is_some() => {}
            Ok(feedback) => {
                transform.feedback = feedback;
                transform.follow_turn();
            }
            Err(error) => transform.fail(error, period),
        }
    }

    /// Computes the position of the target by the whole source.
    fn compute_set_points(&mut self, id: TransformId, axes: &mut Axes, period: f64) {
        let Some(transform) = self.get(id) else { return };
        let s_curve = transform.source.iter().any(|axis| axes[*axis].is_s_curve());
        let source_moves = self.source_moves(axes, id, transform);
        let target = self.set_points_of(axes, id, transform).and_then(|target| {
            within_speeds(transform, axes, [&transform.target_set_points, &target], period)?;
            Ok(target)
        });
        let Some(transform) = self.get_mut(id) else { return };
        transform.source_moves = source_moves;
        match target {
            _ if transform.failed.is_some() => {}
            Ok(target) => transform.target_set_points = target,
            Err(error) => transform.fail(error, period),
        }
        for axis in transform.target.iter() {
            if let Some(generator) = axes[*axis].sum.get_mut(GeneratorKind::Transform) {
                generator.s_curve = s_curve;
            }
        }
    }

    fn set_points_of(&self, axes: &Axes, id: TransformId, transform: &Transform) -> Result<SideState, MotionError> {
        let source = self.source_without_feedback(axes, id, transform);
        let Map::Robot(robot) = &transform.map else {
            return transform.target_of(&source);
        };
        if source == transform.source_before {
            return Ok(transform.target_before);
        }
        // Later targets move the source as well: this target follows the source with all feedback.
        let mut whole = source;
        for (whole, feedback) in whole.iter_mut().zip(&transform.feedback) {
            add(whole, feedback);
        }
        let added = self.added_to(axes, transform);
        let mut moved = *transform;
        let mut own = *robot;
        own.note_joints(positions(&transform.with(&added)));
        moved.map = Map::Robot(own);
        let mut target = moved.target_of(&whole)?;
        for (target, added) in target.iter_mut().zip(&added) {
            target.position -= added.position;
            target.velocity -= added.velocity;
            target.acceleration -= added.acceleration;
        }
        Ok(target)
    }

    /// Computes the part of an axis's command that comes from all its transforms.
    pub(crate) fn compose(&self, axis: AxisId, axes: &mut Axes) {
        if !axes[axis].is_transformed() {
            return;
        }
        let mut total = self.set_point(axes, axis);
        add(&mut total, &self.feedback_to(axes, axis, None));
        self.show_controlled(axis, axes);
        let state = &mut axes[axis];
        state.sum.set(GeneratorKind::Transform, total);
        state.command = state.sum.command();
    }

    /// Begins a transform whose instruction has been verified.
    pub(crate) fn begin(&mut self, id: TransformId, mut transform: Transform, axes: &mut Axes) {
        for axis in transform.axes() {
            let state = &mut axes[axis];
            if !state.is_transformed() {
                state.transforms.rest = state.command.position;
                state.transforms.settled = 0.0;
                state.sum.begin(GeneratorKind::Transform, Generator::followed(false));
            }
            state.stale = true;
        }
        let target_axes = transform.target;
        for (index, axis) in target_axes.iter().enumerate() {
            transform.added_at_start[index] = self.added(axes, *axis).position;
        }
        let source = self.source_without_feedback(axes, id, &transform);
        // No error is possible: the transform has been verified for this position.
        let placed = transform.target_of(&source).unwrap_or_default();
        transform.source_before = source;
        for (index, axis) in target_axes.iter().enumerate() {
            let membership = &mut axes[*axis].transforms;
            transform.offset[index] = membership.rest - placed[index].position;
            transform.target_before[index] = KinematicState::at_rest(membership.rest);
            transform.target_set_points[index] = KinematicState::at_rest(membership.rest);
            membership.target_of = Some(id);
        }
        for axis in transform.source.iter() {
            axes[*axis].transforms.source_of |= id.bit();
        }
        if let Some(index) = self.active.get_mut(id.index()) {
            *index = Some(transform);
        }
    }

    /// Includes the own displacement of a robot's target in the source's position, once all axes stand: the arm solution is then that of its
    /// joints.
    pub(crate) fn settle(&mut self, id: TransformId, axes: &mut Axes) {
        let Some(transform) = self.get(id).filter(|transform| transform.failed.is_none()) else {
            return;
        };
        let moves = transform.target.iter().any(|axis| self.moves_by_itself(axes, *axis))
            || self.source_moves(axes, id, transform);
        let added = self.added_to(axes, transform);
        if moves || added == SideState::default() || transform.robot().is_none() {
            return;
        }
        let mut settled = *transform;
        let whole = settled.with(&added);
        for (index, axis) in transform.source.iter().enumerate() {
            axes[*axis].transforms.settled += settled.feedback[index].position;
            settled.source_before[index].position += settled.feedback[index].position;
        }
        settled.feedback = SideState::default();
        for (index, (axis, added)) in transform.target.iter().zip(&added).enumerate() {
            settled.added_at_start[index] = self.added(axes, *axis).position;
            settled.offset[index] -= added.position;
        }
        if let Map::Robot(robot) = &mut settled.map {
            robot.settle(&settled.source_before, &whole);
        }
        self.active[id.index()] = Some(settled);
    }

    /// The transform whose target has this axis, and the axis's index there.
    fn transform_of_target(&self, axes: &Axes, axis: AxisId) -> Option<(&Transform, usize)> {
        let transform = self.get(axes[axis].transforms.target_of?)?;
        Some((transform, transform.target.index_of(axis)?))
    }

    /// Transforms whose sources have this axis, except one.
    fn fed_back_by(&self, axes: &Axes, axis: AxisId, but: Option<TransformId>) -> impl Iterator<Item = &Transform> {
        let mut left = axes[axis].transforms.source_of & !but.map_or(0, TransformId::bit);
        std::iter::from_fn(move || {
            let index = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            self.active.get(index)
        })
        .flatten()
    }

    /// The sum of the feedback of all transforms to an axis, except one.
    fn feedback_to(&self, axes: &Axes, axis: AxisId, but: Option<TransformId>) -> KinematicState {
        let mut total = KinematicState::default();
        for transform in self.fed_back_by(axes, axis, but) {
            if let Some(index) = transform.source.index_of(axis) {
                add(&mut total, &transform.feedback[index]);
            }
        }
        total
    }

    /// The position of an axis by its transforms without any feedback to it.
    fn set_point(&self, axes: &Axes, axis: AxisId) -> KinematicState {
        let membership = &axes[axis].transforms;
        let mut point = match self.transform_of_target(axes, axis) {
            Some((transform, index)) => transform.target_set_points[index],
            None => KinematicState::at_rest(membership.rest),
        };
        point.position += membership.settled;
        point
    }

    fn source_without_feedback(&self, axes: &Axes, id: TransformId, transform: &Transform) -> SideState {
        let mut source = SideState::default();
        for (axis, point) in transform.source.iter().zip(&mut source) {
            *point = self.without_feedback(axes, *axis, id);
        }
        source
    }

    /// An axis without the feedback of one transform.
    fn without_feedback(&self, axes: &Axes, axis: AxisId, id: TransformId) -> KinematicState {
        let mut total = seen(&axes[axis], self.set_point(axes, axis));
        add(&mut total, &self.feedback_to(axes, axis, Some(id)));
        total
    }

    /// An axis without the feedback of one transform and of later ones, before the complete feedback is known.
    fn before_feedback(&self, axes: &Axes, axis: AxisId, id: TransformId) -> KinematicState {
        let membership = &axes[axis].transforms;
        let mut point = match self.transform_of_target(axes, axis) {
            Some((transform, index)) => transform.target_before[index],
            None => KinematicState::at_rest(membership.rest),
        };
        point.position += membership.settled;
        let mut total = seen(&axes[axis], point);
        for (_, other) in self.iter().take_while(|(other, _)| *other < id) {
            if let Some(index) = other.source.index_of(axis) {
                add(&mut total, &other.feedback[index]);
            }
        }
        total
    }

    /// The motion of an axis apart from the transform whose target it belongs to, since the axis became part of a transform.
    fn added(&self, axes: &Axes, axis: AxisId) -> KinematicState {
        let state = &axes[axis];
        let mut added = state.sum.motion_of(|kind| kind != GeneratorKind::Transform);
        added.position =
            state.sum.seen_from(GeneratorKind::Transform, Some(0.0)).unwrap_or(0.0) + state.transforms.settled;
        add(&mut added, &self.feedback_to(axes, axis, None));
        added
    }

    /// The motion of each axis of a target apart from the transform, since the transform began or since the displacement was included in the source's position.
    pub(super) fn added_to(&self, axes: &Axes, transform: &Transform) -> SideState {
        let mut added = SideState::default();
        for ((index, axis), added) in transform.target.iter().enumerate().zip(&mut added) {
            *added = self.added(axes, *axis);
            added.position -= transform.added_at_start[index];
        }
        added
    }

    /// The own motion of a target moves the axis by feedback; one transform does not count.
    fn is_fed_back(&self, axes: &Axes, axis: AxisId, but: Option<TransformId>) -> bool {
        self.fed_back_by(axes, axis, but)
            .any(|transform| transform.target_moves)
    }

    /// An axis moves by other means than the transform whose target it belongs to.
    pub(super) fn moves_by_itself(&self, axes: &Axes, axis: AxisId) -> bool {
        axes[axis].moves_itself() || self.is_fed_back(axes, axis, None)
    }

    /// An axis of the source moves by other means than the feedback of this transform, and so moves the target.
    pub(super) fn source_moves(&self, axes: &Axes, id: TransformId, transform: &Transform) -> bool {
        transform.source.iter().any(|axis| {
            let by_source = self
                .transform_of_target(axes, *axis)
                .is_some_and(|(other, _)| other.source_moves);
            axes[*axis].moves_itself() || by_source || self.is_fed_back(axes, *axis, Some(id))
        })
    }

    /// Updates whether a transform moves an axis, in the status of the axis.
    pub(crate) fn show_controlled(&self, axis: AxisId, axes: &mut Axes) {
        let by_source = self
            .transform_of_target(axes, axis)
            .is_some_and(|(transform, _)| transform.source_moves);
        let fed_back = self.is_fed_back(axes, axis, None);
        axes[axis].transforms.controlled = by_source || fed_back;
    }
}

/// An axis with all its motion at a point of the transform generator's frame.
fn seen(state: &Axis, point: KinematicState) -> KinematicState {
    let mut total = state.sum.motion_of(|kind| kind != GeneratorKind::Transform);
    let position = state.sum.seen_from(GeneratorKind::Transform, Some(point.position));
    total.position = position.unwrap_or(state.command.position);
    total.velocity += point.velocity;
    total.acceleration += point.acceleration;
    total
}

/// Checks the motion of joints that the source moves in an update against their maximum speeds. `period`: seconds between both states.
///
/// # Errors
/// 69, or 68 if a joint would turn at once; the joints then brake from their earlier motion.
fn within_speeds(
    transform: &Transform,
    axes: &Axes,
    [before, now]: [&SideState; 2],
    period: f64,
) -> Result<(), MotionError> {
    if !transform.has_robot_target() {
        return Ok(());
    }
    for (index, axis) in transform.target.iter().enumerate() {
        let (now, before) = (&now[index], &before[index]);
        if guard::too_far(before, now, axes[*axis].dynamics.speed, period) {
            let at_once = (now.position - before.position).abs() > JOINT_AT_ONCE_DEG;
            return Err(if at_once {
                MotionError::TransformAtOrigin
            } else {
                MotionError::MaxJointVelocityExceeded(AxisIndex(index as u8))
            });
        }
    }
    Ok(())
}

/// Checks the motion of a source's joints by feedback in an update against their maximum speeds. `period`: seconds between both states.
///
/// # Errors
/// As [`within_speeds`].
fn within_speeds_back(
    transform: &Transform,
    axes: &Axes,
    feedback: &SideState,
    period: f64,
) -> Result<(), MotionError> {
    if transform.robot().is_none() || transform.has_robot_target() {
        return Ok(());
    }
    for (index, axis) in transform.source.iter().enumerate() {
        // Only a part of the joint's motion comes from the target.
        let most = axes[*axis].dynamics.speed + transform.source_before[index].velocity.abs();
        if guard::too_far(&transform.feedback[index], &feedback[index], most, period) {
            return Err(MotionError::MaxJointVelocityExceeded(AxisIndex(index as u8)));
        }
    }
    Ok(())
}

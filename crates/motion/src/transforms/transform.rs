//! An active transform: its two sides, and the map between them (spec/coordinated-instructions.md §19).
//!
//! Not here: the axes ([`super::compute`]), the order of the computation (`crate::order`), and the map itself ([`super::robot`]).
//! Nothing allocates. Units: position units, degrees of joints, seconds.

use arcline_instruction_set::{AxisId, MotionError, SystemId};

pub(crate) use super::robot::Map;
use super::robot::RobotMap;
use super::sides::{Positions, SideAxes, SideState, add, at_rest, positions, side, vectors};
use crate::execution::Execution;

/// An active transform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    pub(crate) execution: Option<Execution>,
    /// Index of the source system; the index of the target system is that of the transform in [`super::Transforms`].
    pub(crate) source_system: SystemId,
    pub(super) map: Map,
    /// Axes of the source, in the order of its system.
    pub(crate) source: SideAxes,
    /// Axes of the target, in the order of its system.
    pub(crate) target: SideAxes,
    /// The target minus the transformed source at the start, in the frames of its axes' generators.
    pub(super) offset: Positions,
    /// The displacement of the target apart from transforms at the start.
    pub(super) added_at_start: Positions,
    /// The feedback of later transforms of the same source that were cancelled: part of the source's position, but not of
    /// `source_before`.
    pub(super) cancelled_feedback: Positions,
    /// The motion of the source before the feedback of this transform and of later ones.
    pub(super) source_before: SideState,
    /// The motion of the target by `source_before`, in the frames of its axes' generators.
    pub(super) target_before: SideState,
    /// The motion of the target by the whole source, in the frames of its axes' generators.
    pub(super) target_set_points: SideState,
    /// The motion that the target's own motion adds to the source.
    pub(super) feedback: SideState,
    /// The source moves, or is reserved for motion, and so moves the target.
    pub(super) source_moves: bool,
    /// The target moves, or is reserved for motion, apart from this transform, and so moves the source.
    pub(super) target_moves: bool,
    /// The error for which the source can move the target no longer; the target continues straight until it brakes.
    pub(super) failed: Option<MotionError>,
    /// The transform has failed: every motion of either side brakes, and then it ends.
    pub(crate) braking: bool,
}

impl Transform {
    /// A transform at rest, before [`super::Transforms::begin`]. `source_system`: its index.
    pub(crate) fn new(
        execution: Option<Execution>,
        source_system: SystemId,
        map: Map,
        source: &[AxisId],
        target: &[AxisId],
    ) -> Self {
        Transform {
            execution,
            source_system,
            map,
            source: source.iter().copied().collect(),
            target: target.iter().copied().collect(),
            offset: Positions::default(),
            added_at_start: Positions::default(),
            cancelled_feedback: Positions::default(),
            source_before: SideState::default(),
            target_before: SideState::default(),
            target_set_points: SideState::default(),
            feedback: SideState::default(),
            source_moves: false,
            target_moves: false,
            failed: None,
            braking: false,
        }
    }

    /// A transform with identical frames.
    #[cfg(test)]
    pub(crate) fn between(source: &[AxisId], target: &[AxisId]) -> Self {
        use arcline_planner::geometry::{Frame, Point as Vector};
        let map = Map::Frames(Frame::new(Vector::zeros(), Vector::zeros()));
        Transform::new(None, SystemId(0), map, source, target)
    }

    /// The axes of the source, then those of the target.
    pub(crate) fn axes(&self) -> impl Iterator<Item = AxisId> {
        self.source.iter().chain(self.target.iter()).copied()
    }

    /// An axis is on either side.
    pub(crate) fn has(&self, axis: AxisId) -> bool {
        self.axes().any(|own| own == axis)
    }

    /// The robot on one of the sides.
    pub(crate) fn robot(&self) -> Option<&RobotMap> {
        match &self.map {
            Map::Frames(_) => None,
            Map::Robot(robot) => Some(robot),
        }
    }

    /// The motion of the target that belongs to that of the source, in the frames of its axes' generators.
    ///
    /// # Errors
    /// The error of a position that a robot cannot reach.
    pub(super) fn target_of(&self, source: &SideState) -> Result<SideState, MotionError> {
        let mut placed = match &self.map {
            Map::Frames(frame) => {
                let [position, velocity, acceleration] = vectors(source);
                side([
                    frame.transform_point(&position),
                    frame.transform_vector(&velocity),
                    frame.transform_vector(&acceleration),
                ])
            }
            Map::Robot(robot) => robot.target_of(source)?,
        };
        for (point, offset) in placed.iter_mut().zip(self.offset) {
            point.position += offset;
        }
        Ok(placed)
    }

    /// The feedback to the source of a motion that is added to the target.
    ///
    /// # Errors
    /// The error of a position that a robot cannot reach.
    pub(super) fn feedback_of(&self, added: &SideState) -> Result<SideState, MotionError> {
        match &self.map {
            Map::Frames(frame) => Ok(side(
                vectors(added).map(|vector| frame.inverse_transform_vector(&vector)),
            )),
            Map::Robot(_) if *added == SideState::default() => Ok(SideState::default()),
            Map::Robot(robot) => {
                let mut back = robot.source_of(&self.with(added))?;
                for (back, before) in back.iter_mut().zip(&self.source_before) {
                    back.position -= before.position;
                    back.velocity -= before.velocity;
                    back.acceleration -= before.acceleration;
                }
                Ok(back)
            }
        }
    }

    /// The motion of the target before any feedback, plus an added motion.
    pub(super) fn with(&self, added: &SideState) -> SideState {
        let mut whole = self.target_before;
        for ((whole, added), offset) in whole.iter_mut().zip(added).zip(self.offset) {
            whole.position -= offset;
            add(whole, added);
        }
        whole
    }

    /// The feedback of other transforms moves the target away from its position before feedback.
    pub(super) fn is_moved_by_feedback(&self) -> bool {
        positions(&self.target_before) != positions(&self.target_set_points)
    }

    /// Its target is a robot's joints.
    pub(super) fn has_robot_target(&self) -> bool {
        self.robot().is_some_and(RobotMap::has_robot_target)
    }

    /// Converts a step of the source to one of the target; none for a robot's joints.
    pub(super) fn turned(&self, step: &SideState) -> SideState {
        match &self.map {
            Map::Frames(frame) => side(vectors(step).map(|vector| frame.transform_vector(&vector))),
            Map::Robot(_) => SideState::default(),
        }
    }

    /// Takes the present motion of the source, so that the angles of its orientation continue from there.
    pub(super) fn follow_turn(&mut self) {
        if let Map::Robot(robot) = &mut self.map
            && robot.wrist().is_some()
        {
            let mut whole = self.source_before;
            for (whole, back) in whole.iter_mut().zip(&self.feedback) {
                add(whole, back);
            }
            robot.follow_turn(&whole);
        }
    }

    /// Marks the transform as failed: the target continues straight for an update.
    pub(super) fn fail(&mut self, error: MotionError, period: f64) {
        self.failed = Some(error);
        for point in self
            .target_before
            .iter_mut()
            .chain(&mut self.target_set_points)
            .chain(&mut self.feedback)
        {
            point.position += point.velocity * period;
            point.acceleration = 0.0;
        }
    }

    /// The position of the source that belongs to that of the target.
    ///
    /// # Errors
    /// The error of a position that a robot cannot reach.
    pub(crate) fn source_of(&self, target: &Positions) -> Result<Positions, MotionError> {
        let target = at_rest(target);
        match &self.map {
            Map::Frames(frame) => {
                let [position, velocity, acceleration] = vectors(&target);
                Ok(positions(&side([
                    frame.inverse_transform_point(&position),
                    velocity,
                    acceleration,
                ])))
            }
            Map::Robot(robot) => Ok(positions(&robot.source_of(&target)?)),
        }
    }

    /// Checks that the target can follow a moving source at this position.
    pub(crate) fn verify(&self, source: &Positions) -> Result<(), MotionError> {
        self.target_of(&at_rest(source)).map(drop)
    }
}

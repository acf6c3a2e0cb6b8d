//! The status of transforms in axes and coordinate systems: the side that moves the other one, frames, turns and solutions of a
//! robot.
//!
//! Not here: the words of their tags (`crate::status`). Nothing allocates.

use arcline_instruction_set::SystemId;
use arcline_kinematics::{Configuration, Turns};
use arcline_planner::geometry::Point as Vector;

use super::compute::TransformStep;
use super::present::Present;
use super::sides::Positions;
use super::{TransformId, Transforms};
use crate::axes::Axes;

/// A coordinate system's part in active transforms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Role {
    pub(crate) source: bool,
    pub(crate) target: bool,
    pub(crate) robot: RobotShown,
}

/// The status of the robot with a wrist whose joints a coordinate system has, or that it moves by a transform.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RobotShown {
    /// IDs of the tool frame and the work frame.
    pub(crate) frames: [i32; 2],
    pub(crate) solution: (Configuration, Turns),
    /// The tool centre in the frame of the end of the arm.
    pub(crate) tool: Vector,
    /// A transform with frames is active, and none of its axes moves.
    pub(crate) tool_change: bool,
}

impl Present<'_> {
    /// A coordinate system's part in the active transforms.
    pub(crate) fn role(&self, index: SystemId) -> Role {
        Role {
            source: self
                .transforms
                .iter()
                .any(|(_, transform)| transform.source_system == index),
            target: self.transforms.get(TransformId::of_target(index)).is_some(),
            robot: self.robot_shown(index),
        }
    }

    /// The status of the robot with a wrist whose joints a coordinate system has, or of the first one that it moves by a transform.
    fn robot_shown(&self, index: SystemId) -> RobotShown {
        let system = &self.systems[index];
        if !system.is_oriented() {
            return RobotShown::default();
        }
        let mut transforms = self.transforms.iter();
        let own = transforms.find(|(id, transform)| id.target_system() == index || transform.source_system == index);
        let linked = own.and_then(|(id, transform)| Some((id, transform, transform.robot()?.wrist()?)));
        let robot = linked.map_or(index, |(id, ..)| id.target_system());
        let joints = &self.systems[robot].description.axes;
        let solution = match &self.systems[robot].wrist {
            Some(Ok(wrist)) => {
                let mut at = Positions::default();
                for (at, axis) in at.iter_mut().zip(joints) {
                    *at = self.axes[*axis].command.position;
                }
                wrist.solution(&at)
            }
            _ => Default::default(),
        };
        let Some((_, transform, wrist)) = linked else {
            return RobotShown {
                solution,
                ..RobotShown::default()
            };
        };
        let [work, tool] = wrist.ids;
        RobotShown {
            frames: [tool, work],
            solution,
            tool: wrist.tool(),
            tool_change: !transform.braking && !self.transforms.moves_either_side(self.axes, transform),
        }
    }
}

impl Transforms {
    /// Updates the side that moves the other one, as far as a step determines it, after the motions that ended in this update.
    pub(crate) fn show(&mut self, step: TransformStep, axes: &Axes) {
        match step {
            TransformStep::Before(_) => {}
            TransformStep::Feedback(id) => {
                let Some(transform) = self.get(id) else { return };
                let mut target = transform.target.iter();
                let moves = target.any(|axis| self.moves_by_itself(axes, *axis));
                if let Some(transform) = self.get_mut(id) {
                    transform.target_moves = moves;
                }
            }
            TransformStep::SetPoints(id) => {
                let Some(transform) = self.get(id) else { return };
                let moves = self.source_moves(axes, id, transform);
                if let Some(transform) = self.get_mut(id) {
                    transform.source_moves = moves;
                }
            }
        }
    }
}

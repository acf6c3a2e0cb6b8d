//! What axes and coordinate systems show of transforms under way: who leads whom, frames, turns and solutions of a robot.
//!
//! Not here: the words of their tags (`crate::status`). Nothing allocates.

use arcline_kinematics::{Configuration, Turns};
use arcline_planner::geometry::Point as Vector;

use super::transform::{Link, Positions};
use crate::motion::Motion;
use crate::order::Step;

/// A coordinate system's part in transforms under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Role {
    pub(crate) source: bool,
    pub(crate) target: bool,
    pub(crate) robot: RobotShown,
}

/// What a coordinate system shows of the robot with a wrist that it is, or that it leads.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RobotShown {
    /// IDs of the tool frame and the work frame.
    pub(crate) frames: [i32; 2],
    pub(crate) solution: (Configuration, Turns),
    /// The tool centre in the frame of the end of the arm.
    pub(crate) tool: Vector,
    /// A transform with frames is under way, and nothing that is part of it moves.
    pub(crate) tool_change: bool,
}

impl Motion {
    /// What a coordinate system shows of the robot with a wrist that it is, or that it leads first.
    pub(crate) fn robot_shown(&self, index: usize) -> RobotShown {
        let system = &self.systems[index];
        if !system.is_oriented() {
            return RobotShown::default();
        }
        let mut links = self.links();
        let own = links.find(|(target, link)| *target == index || link.from == index);
        let linked = own.and_then(|(target, link)| Some((target, link, link.robot()?.wrist()?)));
        let robot = linked.map_or(index, |(target, ..)| target);
        let joints = &self.systems[robot].description.axes;
        let solution = match &self.systems[robot].wrist {
            Some(Ok(wrist)) => {
                let mut at = Positions::default();
                for (at, axis) in at.iter_mut().zip(joints) {
                    *at = self.axes[usize::from(*axis)].command.position;
                }
                wrist.solution(&at)
            }
            _ => Default::default(),
        };
        let Some((_, link, wrist)) = linked else {
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
            tool_change: !link.braking && !self.moves_either_side(link),
        }
    }

    /// Who leads whom once what has come to its end in this update is over.
    pub(crate) fn show_transforms(&mut self) {
        for place in 0..self.order.len() {
            match self.order.step(place) {
                Some(Step::Back(index)) => {
                    let index = usize::from(index);
                    if let Some(link) = self.links[index] {
                        let leads = link.target().iter().any(|axis| self.leads_by_itself(*axis));
                        self.set_leads(index, |link| link.leads_back = leads);
                    }
                }
                Some(Step::Lead(index)) => {
                    let index = usize::from(index);
                    if let Some(link) = self.links[index] {
                        let leads = link.source().iter().any(|axis| self.leads_on(*axis, index));
                        self.set_leads(index, |link| link.leads = leads);
                    }
                }
                Some(Step::Whole(axis)) if self.axes[usize::from(axis)].is_linked() => self.show_controlled(axis),
                _ => {}
            }
        }
    }

    fn set_leads(&mut self, index: usize, set: impl FnOnce(&mut Link)) {
        if let Some(link) = &mut self.links[index] {
            set(link);
        }
    }

    pub(super) fn show_controlled(&mut self, axis: u16) {
        let led = self.leader(axis).is_some_and(|(link, _)| link.leads);
        let led_back = self.is_led_back(axis, None);
        self.axes[usize::from(axis)].linked.controlled = led || led_back;
    }
}

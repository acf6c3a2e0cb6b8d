//! What axes and coordinate systems show of transforms under way: who leads whom, frames, turns and solutions of a robot.
//!
//! Not here: the words of their tags (`crate::status`). Nothing allocates.

use super::order::Step;
use super::pair::{Link, Positions};
use crate::motion::Motion;
use crate::status::Turn;

impl Motion {
    /// What a coordinate system shows of the robot with a wrist that it is, or that it leads first.
    pub(crate) fn turn_of(&self, index: usize) -> Turn {
        let system = &self.systems[index];
        if !system.is_oriented() {
            return Turn::default();
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
            return Turn {
                solution,
                ..Turn::default()
            };
        };
        let [work, tool] = wrist.ids;
        Turn {
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

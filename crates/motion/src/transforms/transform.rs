//! A transform under way: its two sides, and what one makes of the other (spec/coordinated-instructions.md §19).
//!
//! Not here: the axes, and when something is computed ([`super::transform`]); what a robot makes of positions
//! ([`super::robot`]). Nothing allocates. Units: position units, degrees of joints, seconds.

use arcline_instruction_set::MotionError;
use arcline_profile::KinematicState;

pub(crate) use super::robot::Map;
use super::robot::{RobotMap, at_rest, positions, side, vectors};
use crate::control::Execution;
use crate::machine::MAX_SYSTEM_AXES;

/// Position, velocity and acceleration of each axis of one side.
pub(crate) type Side = [KinematicState; MAX_SYSTEM_AXES];

/// A position of each axis of one side.
pub(crate) type Positions = [f64; MAX_SYSTEM_AXES];

/// A transform under way. It is kept at the place of its target system.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) execution: Option<Execution>,
    /// Place of the source system.
    pub(crate) from: usize,
    pub(super) map: Map,
    pub(super) source: [u16; MAX_SYSTEM_AXES],
    pub(super) target: [u16; MAX_SYSTEM_AXES],
    /// Axes of the source and of the target.
    pub(super) counts: [usize; 2],
    /// What the target was off the transformed source at the start, in the frames of its axes' generators.
    pub(super) offset: Positions,
    /// What had been added to the target at the start.
    pub(super) added_from: Positions,
    /// What later targets had led the source back by when their transforms were cancelled: part of where it is, but not of `above`.
    pub(super) beside: Positions,
    /// Where the source is without what this target and later ones lead it back by.
    pub(super) above: Side,
    /// Where that leads the target, in the frames of its axes' generators.
    pub(super) down: Side,
    /// Where the target is led to, in the frames of its axes' generators.
    pub(super) led: Side,
    /// What the target's own motion adds to the source.
    pub(super) back: Side,
    /// Whether the source moves, or is held to be moved, and so leads.
    pub(super) leads: bool,
    /// The same of the target's own motion.
    pub(super) leads_back: bool,
    /// Why the target could not be led on; it goes on straight meanwhile.
    pub(super) failed: Option<MotionError>,
    /// It has failed: what moves either side brakes, and then it ends.
    pub(crate) braking: bool,
}

impl Link {
    pub(crate) fn new(execution: Option<Execution>, from: usize, map: Map, source: &[u16], target: &[u16]) -> Self {
        let mut link = Link {
            execution,
            from,
            map,
            source: [0; MAX_SYSTEM_AXES],
            target: [0; MAX_SYSTEM_AXES],
            counts: [source, target].map(|axes| axes.len().min(MAX_SYSTEM_AXES)),
            offset: Positions::default(),
            added_from: Positions::default(),
            beside: Positions::default(),
            above: Side::default(),
            down: Side::default(),
            led: Side::default(),
            back: Side::default(),
            leads: false,
            leads_back: false,
            failed: None,
            braking: false,
        };
        for (places, axes) in [(&mut link.source, source), (&mut link.target, target)] {
            for (place, axis) in places.iter_mut().zip(axes) {
                *place = *axis;
            }
        }
        link
    }

    /// One that turns and shifts nothing.
    #[cfg(test)]
    pub(crate) fn between(source: &[u16], target: &[u16]) -> Self {
        use arcline_planner::geometry::{Frame, Point as Vector};
        let map = Map::Frames(Frame::new(Vector::zeros(), Vector::zeros()));
        Link::new(None, 0, map, source, target)
    }

    /// Axes of the source, in the order of its system.
    pub(crate) fn source(&self) -> &[u16] {
        &self.source[..self.counts[0]]
    }

    /// Axes of the target, in the order of its system.
    pub(crate) fn target(&self) -> &[u16] {
        &self.target[..self.counts[1]]
    }

    /// Whether an axis is on either side.
    pub(crate) fn has(&self, axis: u16) -> bool {
        self.source().contains(&axis) || self.target().contains(&axis)
    }

    /// The robot at one end.
    pub(crate) fn robot(&self) -> Option<&RobotMap> {
        match &self.map {
            Map::Frames(_) => None,
            Map::Robot(robot) => Some(robot),
        }
    }

    /// Where the target is while the source is there, in the frames of its axes' generators.
    ///
    /// # Errors
    /// Where a robot cannot be.
    pub(super) fn place(&self, source: &Side) -> Result<Side, MotionError> {
        let mut placed = match &self.map {
            Map::Frames(frame) => {
                let [position, velocity, acceleration] = vectors(source);
                side([frame.place(&position), frame.turn(&velocity), frame.turn(&acceleration)])
            }
            Map::Robot(robot) => robot.place(source)?,
        };
        for (point, offset) in placed.iter_mut().zip(self.offset) {
            point.position += offset;
        }
        Ok(placed)
    }

    /// What has been added to the target leads the source by this.
    ///
    /// # Errors
    /// Where a robot cannot be.
    pub(super) fn turn_back(&self, added: &Side) -> Result<Side, MotionError> {
        match &self.map {
            Map::Frames(frame) => Ok(side(vectors(added).map(|vector| frame.turn_back(&vector)))),
            Map::Robot(_) if *added == Side::default() => Ok(Side::default()),
            Map::Robot(robot) => {
                let mut back = robot.place_back(&self.with(added))?;
                for (back, above) in back.iter_mut().zip(&self.above) {
                    back.position -= above.position;
                    back.velocity -= above.velocity;
                    back.acceleration -= above.acceleration;
                }
                Ok(back)
            }
        }
    }

    /// Where the source leads the target, with what is added to that.
    pub(super) fn with(&self, added: &Side) -> Side {
        let mut whole = self.down;
        for ((whole, added), offset) in whole.iter_mut().zip(added).zip(self.offset) {
            whole.position -= offset;
            add(whole, added);
        }
        whole
    }

    /// Whether others lead the target elsewhere than where the source leads it without them.
    pub(super) fn is_led_aside(&self) -> bool {
        positions(&self.down) != positions(&self.led)
    }

    /// Whether its target is a robot's joints.
    pub(super) fn leads_joints(&self) -> bool {
        self.robot().is_some_and(RobotMap::leads_joints)
    }

    /// A step of the source as one of the target; none behind a robot's joints.
    pub(super) fn turned(&self, step: &Side) -> Side {
        match &self.map {
            Map::Frames(frame) => side(vectors(step).map(|vector| frame.turn(&vector))),
            Map::Robot(_) => Side::default(),
        }
    }

    /// Where the source is now, so that the angles of its orientation go on from there.
    pub(super) fn follow_turn(&mut self) {
        if let Map::Robot(robot) = &mut self.map
            && robot.wrist().is_some()
        {
            let mut whole = self.above;
            for (whole, back) in whole.iter_mut().zip(&self.back) {
                add(whole, back);
            }
            robot.follow_turn(&whole);
        }
    }

    /// It cannot be led on: the target goes straight on for an update.
    pub(super) fn fail(&mut self, error: MotionError, period: f64) {
        self.failed = Some(error);
        for point in self.down.iter_mut().chain(&mut self.led).chain(&mut self.back) {
            point.position += point.velocity * period;
            point.acceleration = 0.0;
        }
    }

    /// Where the source is while the target is there.
    ///
    /// # Errors
    /// Where a robot cannot be.
    pub(crate) fn source_of(&self, target: &Positions) -> Result<Positions, MotionError> {
        let target = at_rest(target);
        match &self.map {
            Map::Frames(frame) => {
                let [position, velocity, acceleration] = vectors(&target);
                Ok(positions(&side([frame.place_back(&position), velocity, acceleration])))
            }
            Map::Robot(robot) => Ok(positions(&robot.place_back(&target)?)),
        }
    }

    /// Whether the target could be led while the source is there, and moves.
    pub(crate) fn verify(&self, source: &Positions) -> Result<(), MotionError> {
        self.place(&at_rest(source)).map(drop)
    }
}

/// One motion on top of another.
pub(super) fn add(total: &mut KinematicState, more: &KinematicState) {
    total.position += more.position;
    total.velocity += more.velocity;
    total.acceleration += more.acceleration;
}

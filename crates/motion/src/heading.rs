//! The orientation of a coordinate system with Rx, Ry, Rz: where a path move turns it to, and its axes on the way
//! (spec/coordinated-instructions.md §22.8, §23.3).
//!
//! The axes show fixed X-Y-Z angles: Ry within a quarter turn of 0, Rx and Rz in the turn that goes on. Beyond a quarter turn of Ry
//! the other two change by half a turn at once, as the reference's mirror rule has it. Real-time: nothing allocates. Units: degrees.

use arcline_planner::Sample;
use arcline_planner::geometry::{Point, Turn, angle_rates, angles, continued, rotation};

use crate::axis::sum::Slot;
use crate::machine::MAX_PRIMARY_AXES;
use crate::motion::Motion;
use crate::system::{Activity, component};

/// The same orientation with Rx and Rz above -180 up to 180 and Ry from -90 to 90 (§22.8).
pub(crate) fn normal(given: &Point) -> Point {
    let upright = Point::new(0.0, 0.0, 0.0);
    let found = angles(&rotation(given), &upright);
    // Angles that are in their range stay as they were given.
    let kept = given.y.abs() <= 90.0
        && [given.x, given.z]
            .iter()
            .all(|angle| *angle > -180.0 && *angle <= 180.0);
    if kept { *given } else { found.map(above_half_turn) }
}

/// -180 and what rounds to it is 180.
fn above_half_turn(angle: f64) -> f64 {
    if angle <= -180.0 + ROUNDING {
        angle + 360.0
    } else {
        angle
    }
}

/// The turn between two triples of angles, of which `to` says with whole turns beyond half a turn of Rz how far a counted joint
/// is to turn.
pub(crate) fn turn(from: &Point, to: &Point) -> Turn {
    let [start, end] = [from, to].map(rotation);
    let shortest = Turn::new(&start, &end, 0.0);
    let mut passed = *from;
    for look in 1..=LOOKS {
        let share = f64::from(look) / f64::from(LOOKS);
        passed = continued(&shortest.at(share).rotation, &passed);
    }
    let missing = (to.z - passed.z) / 360.0;
    // Half a turn is what the mirror rule leaves.
    let turns = if missing.abs() <= 0.5 + ROUNDING {
        0.0
    } else {
        missing.round()
    };
    Turn::new(&start, &end, turns)
}

impl Motion {
    /// Rx, Ry, Rz at the end of the last move in the queue that turns, or where the axes are commanded to be.
    pub(crate) fn heading(&self, index: usize) -> Point {
        let system = &self.systems[index];
        let queued = if system.activity == Activity::Moving {
            let active = system.planner.active().map(|running| running.motion.data.heading);
            let pending = system.planner.pending().map(|waiting| waiting.data.heading);
            active.into_iter().chain(pending).flatten().next_back()
        } else {
            None
        };
        queued.unwrap_or_else(|| self.angles_of(index))
    }

    /// The turn of a move behind the queue that keeps the orientation; none where there is no orientation.
    pub(crate) fn still(&self, index: usize) -> Option<Turn> {
        self.systems[index].description.orientation?;
        let heading = rotation(&self.heading(index));
        Some(Turn::new(&heading, &heading, 0.0))
    }

    /// Where the axes Rx, Ry, Rz are commanded to be.
    fn angles_of(&self, index: usize) -> Point {
        let mut angles = Point::zeros();
        for (axis, angle) in self.systems[index].description.oriented().iter().zip(angles.iter_mut()) {
            *angle = self
                .axes
                .get(usize::from(*axis))
                .map_or(0.0, |axis| axis.command.position);
        }
        angles
    }

    /// A deceleration along the path, of a share of the Maximum Deceleration, with which the turn of the active move keeps to that
    /// share of its own maximum too. What only turns has that as its own.
    pub(crate) fn kept_by_turn(&self, index: usize, deceleration: f64) -> f64 {
        let system = &self.systems[index];
        let (Some(turns), Some(running)) = (system.description.orientation, system.planner.active()) else {
            return deceleration;
        };
        let (motion, share) = (&running.motion, deceleration / system.description.max_deceleration);
        let Some(turn) = &motion.turn else {
            return deceleration;
        };
        let own = share * turns.max_deceleration;
        if motion.data.only_turns {
            own
        } else if turn.angle() > 0.0 {
            deceleration.min(own * motion.path.length() / turn.angle())
        } else {
            deceleration
        }
    }

    /// The axes' part of a turn at the present tick.
    pub(crate) fn seat_turned(&mut self, index: usize, sample: &Sample) {
        let Some(turned) = &sample.turned else { return };
        let mut near = Point::zeros();
        for (axis, angle) in self.systems[index].description.oriented().iter().zip(near.iter_mut()) {
            let generator = self
                .axes
                .get(usize::from(*axis))
                .and_then(|axis| axis.sum.get(Slot::System));
            *angle = generator.map_or(0.0, |generator| generator.now.position);
        }
        let shown = angles(&turned.rotation, &near);
        let [velocity, acceleration] = angle_rates(&shown, &turned.rate, &turned.change);
        self.seat_angles(index, [shown, velocity, acceleration]);
    }

    /// The axes stand exactly at the end of the active move's turn.
    pub(crate) fn hold_heading(&mut self, index: usize) {
        let active = self.systems[index].planner.active();
        if let Some(end) = active.and_then(|running| running.motion.data.heading) {
            self.seat_angles(index, [end, Point::zeros(), Point::zeros()]);
        }
    }

    fn seat_angles(&mut self, index: usize, [position, velocity, acceleration]: [Point; 3]) {
        for (place, axis) in self.systems[index].description.oriented().iter().enumerate() {
            if let Some(axis) = self
                .axes
                .get_mut(usize::from(*axis))
                .filter(|_| place < MAX_PRIMARY_AXES)
            {
                axis.set_coordinated(arcline_drive::Motion {
                    position: component(&position, place),
                    velocity: component(&velocity, place),
                    acceleration: component(&acceleration, place),
                });
            }
        }
    }
}

/// Looks at a turn of at most half a turn: its angles do not go further than a quarter between two.
const LOOKS: u32 = 16;
/// Of a share of a turn.
const ROUNDING: f64 = 1e-9;

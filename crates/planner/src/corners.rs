//! Corners so close to each other that several may lie within one update: their changes of direction add up.
//!
//! Not here: a single corner (`junction`). Position units, seconds. Real-time: nothing allocates, at most [`MOST`] corners are examined.

use arcline_geometry::{Path, Point};

use crate::junction::{corner_speed, turn};

/// The corners before the newest move, the nearest first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    near: [Corner; MOST],
    count: usize,
    /// The coarse update period, seconds; 0: each corner counts separately.
    period: f64,
}

/// A passed corner.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// Its distance to the start of the newest move, along the path.
    distance: f64,
    /// The sum of its change of direction and those of the corners behind it.
    turn: Point,
}

/// Corners at least this many updates apart, at the speed of the second, never lie within the same update.
const APART: f64 = 2.0;
/// Most corners within one update.
const MOST: usize = 8;

impl Corners {
    pub(crate) fn new(period: f64) -> Self {
        let none = Corner {
            distance: 0.0,
            turn: Point::zeros(),
        };
        Corners {
            near: [none; MOST],
            count: 0,
            period,
        }
    }

    /// Forgets the corners, for a path that begins at rest or from another motion.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes the corner between the newest move and the next one. Returns the highest speed, units/s, at which this corner, together with earlier
    /// ones within the same update, changes no axis's velocity by more than its step.
    pub(crate) fn pass(&mut self, before: &Path, next: &Path, corner_step: &Point) -> f64 {
        let own = turn(before, next);
        let is_corner = own != Point::zeros();
        let mut speed = f64::INFINITY;
        for corner in &mut self.near[..self.count] {
            corner.distance += before.length();
            corner.turn += own;
            let apart = corner.distance / (APART * self.period);
            speed = speed.min(apart.max(corner_speed(&corner.turn, corner_step)));
        }
        if !is_corner || self.period <= 0.0 {
            return f64::INFINITY;
        }
        if self.count == MOST {
            speed = speed.min(self.near[MOST - 1].distance / (APART * self.period));
        }
        self.count = (self.count + 1).min(MOST);
        self.near[..self.count].rotate_right(1);
        self.near[0] = Corner {
            distance: 0.0,
            turn: own,
        };
        speed
    }
}

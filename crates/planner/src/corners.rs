//! Corners that lie so near to each other that one update may see several of them: their turns add up.
//!
//! Not here: one corner alone (`junction`). Position units, seconds. Real-time: nothing allocates, [`MOST`] corners are looked at.

use arcline_geometry::{Path, Point};

use crate::junction::{corner_speed, turn};

/// The corners before the newest move, the nearest first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    near: [Corner; MOST],
    count: usize,
    /// The coarse update period, seconds; 0: each corner counts for itself.
    period: f64,
}

/// A corner that was passed.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// From it to the start of the newest move, along the path.
    distance: f64,
    /// How much it and those behind it turn.
    turn: Point,
}

/// Corners that are so many updates apart, at the speed of the second, are never seen by the same one.
const APART: f64 = 2.0;
/// Corners that may lie within one update.
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

    /// The path begins anew, from rest or out of another motion.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Takes the place between the newest move so far and the next one. Returns the highest speed, units/s, at which the corner
    /// there, with those before it that would lie in the same update, changes no axis's velocity by more than its step.
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

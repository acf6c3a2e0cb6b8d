//! A finished plan: the motion of every axis at every instant.
//!
//! Between knots the jerk of each axis is constant (a cubic spline in time), so position, velocity
//! and acceleration are continuous and the limits can be checked exactly at the knots. Units:
//! position units and seconds.

use crate::arc_length::length;
use crate::{AxisLimits, ContourMove, Point, Rates};

/// Position, velocity and acceleration of the axes at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxesState {
    /// Position units.
    pub position: Point,
    /// Position units / s.
    pub velocity: Point,
    /// Position units / s².
    pub acceleration: Point,
}

/// A planned motion from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    pub(crate) knots: Vec<Knot>,
    /// The times at which the motion passes the ends of the moves, ascending.
    pub(crate) move_ends: Vec<MoveEnd>,
    pub(crate) end: Point,
    /// The splice with the trajectory that it extends, seconds; 0 if it extends none.
    pub(crate) splice: f64,
    /// The rates of the moves for which it was planned; set when it is finished.
    pub(crate) rates: Vec<Rates>,
    pub(crate) least: Rates,
    pub(crate) axes: AxisLimits,
    pub(crate) most: Peaks,
    /// The instant at which it begins to slow down for its end, seconds; set when it is finished.
    pub(crate) brakes_from: f64,
    /// Lengths of the curve from its first knot to each of them; set when it is finished.
    pub(crate) arc_lengths: Vec<f64>,
}

/// The times at which a motion passes the end of a move, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MoveEnd {
    pub(crate) time: f64,
    /// The beginning and the end of the rounding of the corner there; twice `time` without one.
    pub(crate) rounding: [f64; 2],
}

impl MoveEnd {
    /// Without a rounded corner.
    pub(crate) fn plain(time: f64) -> MoveEnd {
        MoveEnd {
            time,
            rounding: [time; 2],
        }
    }

    /// The same with all instants changed.
    pub(crate) fn map(&self, mut change: impl FnMut(f64) -> f64) -> MoveEnd {
        MoveEnd {
            time: change(self.time),
            rounding: self.rounding.map(change),
        }
    }
}

/// A stretch of constant jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    knot: Knot,
    /// Its end, seconds.
    pub until: f64,
}

impl Piece {
    /// The state at a time, seconds; it continues beyond its ends.
    #[must_use]
    pub fn at(&self, t: f64) -> AxesState {
        self.knot.at(t - self.knot.time)
    }

    /// Length of the curve from its beginning to a time, seconds.
    #[must_use]
    pub fn length(&self, t: f64) -> f64 {
        length(&self.knot, t - self.knot.time)
    }

    /// Jerk of the axes, position units / s³.
    #[must_use]
    pub fn jerk(&self) -> Point {
        self.knot.jerk
    }
}

/// The state at the beginning of a piece of constant jerk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Knot {
    pub(crate) time: f64,
    pub(crate) state: AxesState,
    pub(crate) jerk: Point,
}

impl Knot {
    /// All its values are numbers.
    pub(crate) fn is_finite(&self) -> bool {
        let AxesState {
            position,
            velocity,
            acceleration,
        } = self.state;
        (self.time + (position + velocity + acceleration + self.jerk).sum()).is_finite()
    }
}

/// Extreme values of each axis over a whole trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peaks {
    /// Largest magnitude of the velocity of each axis.
    pub velocity: Point,
    /// Largest magnitude of the acceleration of each axis.
    pub acceleration: Point,
    /// Largest magnitude of the jerk of each axis.
    pub jerk: Point,
    /// Largest speed along the path at the knots, which is nearly the largest of all.
    pub speed: f64,
}

impl Trajectory {
    /// No motion: rest at a point.
    #[must_use]
    pub fn rest(at: Point) -> Trajectory {
        Trajectory {
            knots: Vec::new(),
            end: at,
            ..Trajectory::of(Vec::new())
        }
    }

    /// From its knots only.
    pub(crate) fn of(knots: Vec<Knot>) -> Trajectory {
        Trajectory {
            knots,
            move_ends: Vec::new(),
            end: Point::zeros(),
            splice: 0.0,
            rates: Vec::new(),
            least: Rates::UNLIMITED,
            axes: AxisLimits {
                speed: Point::repeat(f64::INFINITY),
                acceleration: Point::repeat(f64::INFINITY),
                jerk: None,
            },
            most: Peaks::NONE,
            brakes_from: 0.0,
            arc_lengths: Vec::new(),
        }
    }

    /// Records the rates and limits for which it was planned, and its extreme values.
    pub(crate) fn planned_for(mut self, moves: &[ContourMove], axes: &AxisLimits) -> Trajectory {
        self.rates.clear();
        self.rates.extend(moves.iter().map(|one| Rates {
            speed: one.speed,
            acceleration: one.acceleration,
            deceleration: one.deceleration,
            jerk: one.jerk,
        }));
        self.least = self.rates.iter().fold(Rates::UNLIMITED, Rates::least);
        self.axes = *axes;
        self.most = self.measured();
        self.brakes_from = self.last_braking();
        self.arc_lengths = self.measure_arc_lengths();
        self
    }

    /// The same motion at another pace, with all times divided by it.
    pub(crate) fn at_pace(&self, pace: f64) -> Trajectory {
        let knot = |knot: &Knot| Knot {
            time: knot.time / pace,
            state: AxesState {
                position: knot.state.position,
                velocity: knot.state.velocity * pace,
                acceleration: knot.state.acceleration * (pace * pace),
            },
            jerk: knot.jerk * (pace * pace * pace),
        };
        Trajectory {
            move_ends: self.move_ends.iter().map(|end| end.map(|time| time / pace)).collect(),
            end: self.end,
            brakes_from: self.brakes_from / pace,
            ..Trajectory::of(self.knots.iter().map(knot).collect())
        }
    }

    /// The programmed rates of a move.
    #[must_use]
    pub fn rates(&self, index: usize) -> Option<&Rates> {
        self.rates.get(index)
    }

    /// The lowest programmed rates of all its moves; the jerk is that of the S-curves.
    #[must_use]
    pub fn least_rates(&self) -> &Rates {
        &self.least
    }

    /// The limits of the axes for which it was planned.
    #[must_use]
    pub fn axes(&self) -> &AxisLimits {
        &self.axes
    }

    /// The index of the piece at `t`, for [`Trajectory::pieces`]. Real-time safe: a binary search.
    #[must_use]
    pub fn piece_at(&self, t: f64) -> usize {
        self.knots.partition_point(|knot| knot.time <= t).saturating_sub(1)
    }

    /// A piece of constant jerk.
    #[must_use]
    pub fn piece(&self, index: usize) -> Option<Piece> {
        let (knot, next) = (self.knots.get(index)?, self.knots.get(index + 1)?);
        Some(Piece {
            knot: *knot,
            until: next.time,
        })
    }

    /// Time from rest to rest in seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.knots.last().map_or(0.0, |knot| knot.time)
    }

    /// The exact end position.
    #[must_use]
    pub fn end(&self) -> Point {
        self.end
    }

    /// The state `t` seconds after the start: at rest before 0, at the exact end from
    /// [`Trajectory::duration`] on. Real-time safe: a binary search over the knots.
    #[must_use]
    pub fn at(&self, t: f64) -> AxesState {
        let behind = self.knots.partition_point(|knot| knot.time <= t);
        if behind >= self.knots.len() {
            return AxesState::rest(self.end);
        }
        let Some(knot) = behind.checked_sub(1).and_then(|index| self.knots.get(index)) else {
            return AxesState::rest(self.knots[0].state.position);
        };
        knot.at(t - knot.time)
    }

    /// The index of the move in execution `t` seconds after the start, in the planned list; the last one when all have ended. Real-time safe: a
    /// binary search.
    #[must_use]
    pub fn move_at(&self, t: f64) -> usize {
        let ended = self.move_ends.partition_point(|end| end.time <= t);
        ended.min(self.move_ends.len().saturating_sub(1))
    }

    /// The time at which the motion passes the end of a move (the nearest point to a rounded corner), in seconds.
    #[must_use]
    pub fn move_end(&self, index: usize) -> Option<f64> {
        self.move_ends.get(index).map(|end| end.time)
    }

    /// The beginning and the end of the rounding of the corner at the end of a move, seconds; both equal without one.
    #[must_use]
    pub fn rounding(&self, index: usize) -> Option<[f64; 2]> {
        self.move_ends.get(index).map(|end| end.rounding)
    }

    /// The splice with the trajectory that it extends ([`crate::extend`]), seconds; 0 if it extends none.
    #[must_use]
    pub fn splice(&self) -> f64 {
        self.splice
    }

    /// The instant at which it begins to slow down for its end, seconds.
    #[must_use]
    pub fn brakes_from(&self) -> f64 {
        self.brakes_from
    }

    /// The number of planned moves.
    #[must_use]
    pub fn moves(&self) -> usize {
        self.move_ends.len()
    }

    /// The number of its pieces of constant jerk.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.knots.len().saturating_sub(1)
    }

    /// The largest velocities, accelerations and jerks, exact.
    #[must_use]
    pub fn peaks(&self) -> Peaks {
        self.most
    }

    fn last_braking(&self) -> f64 {
        let slows = |knot: &&Knot| knot.state.velocity.dot(&knot.state.acceleration) <= 0.0;
        let slowing = self.knots.iter().rev().take_while(slows);
        slowing.last().map_or(self.duration(), |knot| knot.time)
    }

    fn measured(&self) -> Peaks {
        let mut peaks = Peaks::NONE;
        for pair in self.knots.windows(2) {
            let (knot, next) = (&pair[0], &pair[1]);
            peaks.speed = peaks.speed.max(knot.state.velocity.norm());
            peaks.jerk = peaks.jerk.sup(&knot.jerk.abs());
            peaks.acceleration = peaks.acceleration.sup(&knot.state.acceleration.abs());
            peaks.velocity = peaks.velocity.sup(&knot.state.velocity.abs());
            for axis in 0..3 {
                // The velocity has an extreme where the acceleration passes zero.
                let turn = -knot.state.acceleration[axis] / knot.jerk[axis];
                if turn > 0.0 && turn < next.time - knot.time {
                    let there = knot.at(turn).velocity[axis].abs();
                    peaks.velocity[axis] = peaks.velocity[axis].max(there);
                }
            }
        }
        peaks
    }

    /// Appends a motion that starts at the end of this one, both at rest there. The moves of the other one continue the numbers of this one.
    pub fn append(&mut self, next: Trajectory) {
        let shift = self.duration();
        if !next.knots.is_empty() {
            // The first knot of the next trajectory replaces the last knot, which is a rest without length.
            self.knots.pop();
        }
        self.knots.extend(next.knots.into_iter().map(|knot| Knot {
            time: knot.time + shift,
            ..knot
        }));
        self.move_ends
            .extend(next.move_ends.iter().map(|end| end.map(|time| time + shift)));
        self.end = next.end;
    }
}

impl Peaks {
    const NONE: Peaks = Peaks {
        velocity: Point::new(0.0, 0.0, 0.0),
        acceleration: Point::new(0.0, 0.0, 0.0),
        jerk: Point::new(0.0, 0.0, 0.0),
        speed: 0.0,
    };
}

impl Knot {
    pub(crate) fn at(&self, u: f64) -> AxesState {
        let AxesState {
            position,
            velocity,
            acceleration,
        } = self.state;
        AxesState {
            position: position + (velocity + (acceleration / 2.0 + self.jerk * (u / 6.0)) * u) * u,
            velocity: velocity + (acceleration + self.jerk * (u / 2.0)) * u,
            acceleration: acceleration + self.jerk * u,
        }
    }
}

impl AxesState {
    /// Rest at a point.
    #[must_use]
    pub fn rest(position: Point) -> AxesState {
        AxesState {
            position,
            velocity: Point::zeros(),
            acceleration: Point::zeros(),
        }
    }
}

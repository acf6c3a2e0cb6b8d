//! The check that a ramp of the pace keeps every limit for which its trajectory was planned.
//!
//! A trajectory `q(s)` runs at a pace `r`, its own seconds per second. The motion of the axes is then
//!
//! ```text
//! velocity      q' r
//! acceleration  q'' r² + q' r'
//! jerk          q''' r³ + 3 q'' r r' + q' r''
//! ```
//!
//! so a ramp may use the margin that the trajectory itself leaves, which can be zero. A lower pace increases the margin: everywhere, to at
//! least a share `1 - r²` of the accelerations and `1 - r³` of the jerks. If that suffices for the ramp, the guard samples nothing;
//! otherwise it samples the sums above knot by knot, in steps so short that the values between them are bounded.
//! Position units, seconds. Nothing allocates; the work is bounded by [`WORK`].

use crate::tolerance::{PACE_SHARE, ROUNDING_SHARE};
use arcline_contour::{AxesState as Axes, AxisLimits, Peaks, Piece, Rates, Trajectory};
use arcline_geometry::Point;
use arcline_profile::Profile;

/// The limits of a trajectory that a different pace must keep.
pub(super) struct Guard<'a> {
    trajectory: &'a Trajectory,
    /// Vector deceleration and jerk that are permitted in any case: those of a stop.
    extra: [f64; 2],
    /// The rows of the axes and, last, of the vector.
    rows: [Row; 4],
    s_curve: bool,
}

/// Largest magnitudes of velocity and acceleration, and the limits of acceleration and jerk.
#[derive(Clone, Copy)]
struct Row {
    velocity: f64,
    acceleration: f64,
    most_acceleration: f64,
    most_jerk: f64,
}

/// The pace, its first and its second derivative.
#[derive(Clone, Copy)]
struct Rate {
    pace: f64,
    first: f64,
    second: f64,
}

impl<'a> Guard<'a> {
    /// `extra`: vector deceleration and jerk that are permitted besides those of the moves.
    pub(super) fn new(trajectory: &'a Trajectory, extra: [f64; 2]) -> Self {
        let Peaks {
            velocity, acceleration, ..
        } = trajectory.peaks();
        let AxisLimits {
            acceleration: axes,
            jerk: axes_jerk,
            ..
        } = *trajectory.axes();
        let least = trajectory.least_rates();
        let row = |axis: usize| Row {
            velocity: velocity[axis],
            acceleration: acceleration[axis],
            most_acceleration: axes[axis],
            most_jerk: axes_jerk.map_or(f64::INFINITY, |jerk| jerk[axis]),
        };
        let vector = Row {
            velocity: velocity.norm(),
            acceleration: acceleration.norm(),
            most_acceleration: least.acceleration.min(least.deceleration),
            most_jerk: least.jerk.unwrap_or(f64::INFINITY),
        };
        Guard {
            trajectory,
            extra,
            rows: [row(0), row(1), row(2), vector],
            s_curve: least.jerk.is_some(),
        }
    }

    /// The ramp of the pace, whose position is the trajectory's own time, keeps all limits from `since` (seconds) to its end and, at its final
    /// pace, from then on. The pace stays within 0 and 1.
    pub(super) fn allows(&self, ramp: &Profile, since: f64) -> bool {
        let times = ramp.segment_times();
        // Between the ends of its segments the pace is monotone.
        let inside = |pace: f64| (-PACE_SHARE..=1.0 + PACE_SHARE).contains(&pace);
        if !inside(ramp.end().velocity) || !times.iter().all(|&t| t < since || inside(ramp.at(t).velocity)) {
            return false;
        }
        let mut left = WORK;
        for (time_index, &from) in times.iter().enumerate() {
            let from = from.max(since);
            let until = times.get(time_index + 1).copied().unwrap_or(ramp.duration());
            if until <= from {
                continue;
            }
            let segment = RampSegment::new(ramp, from, until - from);
            match self.allows_segment(&segment, &mut left) {
                Verdict::WithinLimits => {}
                Verdict::Exceeded => return false,
                Verdict::AtTheEnd => return true,
            }
        }
        true
    }

    fn allows_segment(&self, segment: &RampSegment, left: &mut usize) -> Verdict {
        let cells = (segment.length / CELL_S).ceil().max(1.0);
        for cell in 0..cells as usize {
            let Some(less) = left.checked_sub(1) else {
                return Verdict::Exceeded;
            };
            *left = less;
            let begin = segment.length * cell as f64 / cells;
            let end = segment.length * (cell + 1) as f64 / cells;
            if segment.at(begin).0 >= self.trajectory.duration() {
                return Verdict::AtTheEnd;
            }
            if self.has_room(segment, begin, end) {
                continue;
            }
            if !self.allows_cell(segment, begin, end, left) {
                return Verdict::Exceeded;
            }
        }
        Verdict::WithinLimits
    }

    /// The margin that a lower pace leaves everywhere on the trajectory suffices for a stretch of a ramp.
    fn has_room(&self, segment: &RampSegment, begin: f64, end: f64) -> bool {
        let ((_, a), (_, b)) = (segment.at(begin), segment.at(end));
        let first = a.first.abs().max(b.first.abs());
        let pace = a.pace.max(b.pace) + first * (end - begin);
        let (square, cube) = (1.0 - pace * pace, 1.0 - pace * pace * pace);
        self.rows.iter().all(|row| {
            let accelerates = row.velocity * first <= square * row.most_acceleration;
            let jerks = 3.0 * row.acceleration * pace * first + row.velocity * a.second.abs();
            square > 0.0 && accelerates && (!self.s_curve || jerks <= cube * row.most_jerk)
        })
    }

    fn allows_cell(&self, segment: &RampSegment, begin: f64, end: f64, left: &mut usize) -> bool {
        let steps = ((end - begin) / STEP_S).ceil().max(1.0);
        let width = (end - begin) / steps;
        let (mut before, _) = segment.at(begin);
        let mut time_index = self.trajectory.piece_at(before);
        for step in 0..steps as usize {
            let (from, until) = (begin + width * step as f64, begin + width * (step + 1) as f64);
            let (behind, _) = segment.at(until);
            let mut at = from;
            // Samples both sides of every knot of the stretch, and both ends.
            loop {
                let Some(less) = left.checked_sub(1) else {
                    return false;
                };
                *left = less;
                let Some(piece) = self.trajectory.piece(time_index) else {
                    return true;
                };
                let leaves = piece.until < behind;
                let next = if leaves {
                    let share = (piece.until - before) / (behind - before);
                    (from + width * share).clamp(at, until)
                } else {
                    until
                };
                if !self.allows_at(&piece, segment, at, width) || !self.allows_at(&piece, segment, next, width) {
                    return false;
                }
                if !leaves {
                    break;
                }
                at = next;
                time_index += 1;
            }
            before = behind;
        }
        true
    }

    fn allows_at(&self, piece: &Piece, segment: &RampSegment, at: f64, width: f64) -> bool {
        let (own, rate) = segment.at(at);
        let axes = piece.at(own.min(piece.until));
        let Some(rates) = self.trajectory.rates(self.trajectory.move_at(own)) else {
            return true;
        };
        let limits = self.trajectory.axes();
        let Rate { pace, first, second } = rate;
        // The largest deviation of the sums within a step: their second derivative times width², over eight.
        let bend = width * width;
        let hidden = second.abs() + first * first;

        let acceleration = axes.acceleration * (pace * pace) + axes.velocity * first;
        let own_jerk = piece.jerk();
        let within = |value: f64, limit: f64, own: f64, hidden: f64| {
            let most = limit.max(own.abs());
            value.abs() + hidden <= most * (1.0 + ROUNDING_SHARE)
        };
        let bent = |axis: usize| bend * (own_jerk[axis].abs() * first.abs() + axes.acceleration[axis].abs() * hidden);
        let kept = (0..3).all(|axis| {
            let own = axes.acceleration[axis];
            within(acceleration[axis], limits.acceleration[axis], own, bent(axis))
        });
        if !kept || !self.allows_vector(&axes, &acceleration, rates, bend * own_jerk.norm() * first.abs()) {
            return false;
        }
        let Some(own_limit) = rates.jerk else {
            return true;
        };
        let jerk = own_jerk * (pace * pace * pace) + axes.acceleration * (3.0 * pace * first) + axes.velocity * second;
        let bent = |limit: f64| 2.0 * bend * hidden * limit.min(f64::MAX);
        let of_axes = limits.jerk.is_none_or(|limit| {
            (0..3).all(|axis| {
                let hides = if limit[axis].is_finite() {
                    bent(limit[axis])
                } else {
                    0.0
                };
                within(jerk[axis], limit[axis], own_jerk[axis], hides)
            })
        });
        let vector = own_limit.max(self.extra[1]);
        of_axes && within(jerk.norm(), vector, own_jerk.norm(), bent(vector))
    }

    /// Checks the programmed rates: the larger one in any direction, and each one along the path.
    fn allows_vector(&self, axes: &Axes, acceleration: &Point, rates: &Rates, hidden: f64) -> bool {
        let down = rates.deceleration.max(self.extra[0]);
        let up = rates.acceleration;
        let most = up.max(down).max(axes.acceleration.norm());
        if acceleration.norm() + hidden > most * (1.0 + ROUNDING_SHARE) {
            return false;
        }
        let speed = axes.velocity.norm();
        if speed <= 0.0 {
            return true;
        }
        let along = axes.velocity.dot(acceleration) / speed;
        let own = axes.velocity.dot(&axes.acceleration) / speed;
        along + hidden <= up.max(own) * (1.0 + ROUNDING_SHARE)
            && hidden - along <= down.max(-own) * (1.0 + ROUNDING_SHARE)
    }
}

/// The verdict on a segment of a ramp.
enum Verdict {
    WithinLimits,
    Exceeded,
    /// The trajectory ends within the segment.
    AtTheEnd,
}

/// A stretch of a ramp in which the second derivative of the pace is constant.
struct RampSegment {
    length: f64,
    /// The trajectory's own time at its start, and the pace there.
    own: f64,
    rate: Rate,
}

impl RampSegment {
    fn new(ramp: &Profile, from: f64, length: f64) -> Self {
        // Accelerations may jump at the ends.
        let (early, late) = (ramp.at(from + 0.25 * length), ramp.at(from + 0.75 * length));
        let second = (late.acceleration - early.acceleration) / (0.5 * length);
        let begin = ramp.at(from);
        RampSegment {
            length,
            own: begin.position,
            rate: Rate {
                pace: begin.velocity,
                first: early.acceleration - second * 0.25 * length,
                second,
            },
        }
    }

    /// The trajectory's own time, and the pace.
    fn at(&self, t: f64) -> (f64, Rate) {
        let Rate { pace, first, second } = self.rate;
        (
            self.own + (pace + (first / 2.0 + second * (t / 6.0)) * t) * t,
            Rate {
                pace: pace + (first + second * (t / 2.0)) * t,
                first: first + second * t,
                second,
            },
        )
    }
}

/// Most cells and samples for one ramp; a ramp that needs more is not allowed.
const WORK: usize = 1500;
/// Seconds of a ramp that are examined as a whole before they are sampled.
const CELL_S: f64 = 0.004;
/// Seconds between two samples of a ramp.
const STEP_S: f64 = 0.000_5;

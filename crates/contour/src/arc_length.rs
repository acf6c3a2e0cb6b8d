//! The length of a motion's curve, and the instant at which a part of it is left.
//!
//! A piece of constant jerk has a polynomial as its velocity; its length is integrated (Gauss and Legendre, five points,
//! exact if the direction stays). Real-time: bounded, nothing allocates but [`Trajectory::measure_arc_lengths`]. Units: position
//! units and seconds.

use arcline_profile::numeric::newton;

use crate::tolerance::LENGTH_SHARE;
use crate::trajectory::{Knot, Trajectory};

impl Trajectory {
    /// Lengths of the curve from its first knot to each of them.
    pub(crate) fn measure_arc_lengths(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let pieces = self
            .knots
            .windows(2)
            .map(|pair| length(&pair[0], pair[1].time - pair[0].time));
        let behind = pieces.map(|piece| {
            sum += piece;
            sum
        });
        let first = self.knots.first().map(|_| 0.0);
        first.into_iter().chain(behind).collect()
    }

    /// Length of the curve from its first knot to a time.
    #[must_use]
    pub fn arc_length(&self, t: f64) -> f64 {
        let behind = self
            .knots
            .partition_point(|knot| knot.time <= t)
            .min(self.arc_lengths.len());
        let Some(index) = behind.checked_sub(1) else {
            return 0.0;
        };
        if index + 1 == self.knots.len() {
            return self.arc_lengths[index];
        }
        self.arc_lengths[index] + length(&self.knots[index], t - self.knots[index].time)
    }

    /// The instant at which the motion had this distance left along its curve before a time; `None`: before its first knot.
    #[must_use]
    pub fn time_before(&self, until: f64, distance: f64) -> Option<f64> {
        let from = self.arc_length(until) - distance;
        if from < 0.0 {
            return None;
        }
        Some(self.time_at_length(from))
    }

    /// The time at which the motion has covered a length of its curve from its first knot; its end for more.
    #[must_use]
    pub fn time_at_length(&self, wanted: f64) -> f64 {
        let Some(index) = self
            .arc_lengths
            .partition_point(|&behind| behind <= wanted)
            .checked_sub(1)
        else {
            return self.knots.first().map_or(0.0, |first| first.time);
        };
        let knot = &self.knots[index];
        let Some(next) = self.knots.get(index + 1) else {
            return knot.time;
        };
        let wanted = wanted - self.arc_lengths[index];
        let off = |at: f64| (length(knot, at) - wanted, knot.at(at).velocity.norm());
        knot.time
            + newton(0.0, next.time - knot.time, MOST_STEPS, off, |step| {
                step.is_closed(LENGTH_SHARE).then_some(step.next)
            })
    }
}

/// Length of the curve over the first seconds of a piece.
pub(crate) fn length(knot: &Knot, seconds: f64) -> f64 {
    let speed = |share: f64| knot.at(seconds * 0.5 * (1.0 + share)).velocity.norm();
    let sum = POINTS.iter().map(|(at, weight)| weight * (speed(*at) + speed(-at)));
    0.5 * seconds * (MIDDLE * speed(0.0) + sum.sum::<f64>())
}

/// Four of the five points, without the middle one, in halves of the piece, with their weights.
const POINTS: [(f64, f64); 2] = [
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];
const MIDDLE: f64 = 128.0 / 225.0;
/// Steps of the bracketed Newton method.
const MOST_STEPS: usize = 40;

#[cfg(test)]
mod tests {
    use crate::{AxisLimits, ContourMove, Path, Point, plan};
    use arcline_geometry::Line;

    #[test]
    fn the_time_before_a_distance_has_it_left() {
        let unlimited = Point::repeat(f64::INFINITY);
        let limits = AxisLimits {
            speed: unlimited,
            acceleration: unlimited,
            jerk: None,
        };
        let corners = [[0.0, 0.0], [100.0, 0.0], [100.0, 40.0], [30.0, 90.0]].map(|[x, y]| Point::new(x, y, 0.0));
        let moves: Vec<ContourMove> = corners
            .windows(2)
            .map(|ends| ContourMove {
                path: Path::Line(Line::new(ends[0], ends[1])),
                speed: 50.0,
                acceleration: 500.0,
                deceleration: 400.0,
                jerk: Some(9000.0),
                tolerance: 3.0,
                deviation: crate::Deviation::Anywhere,
            })
            .collect();
        let whole = plan(&moves, &limits);
        let steps = 100_000_u32;
        let mut before = whole.at(0.0).position;
        let mut summed = 0.0;
        for step in 1..=steps {
            let here = whole.at(whole.duration() * f64::from(step) / f64::from(steps)).position;
            summed += (here - before).norm();
            before = here;
        }
        let length = whole.arc_length(whole.duration());
        assert!((length - summed).abs() < 1e-6 * summed, "{length} or {summed}");
        assert_eq!(whole.arc_length(-1.0), 0.0);
        let mut last = f64::INFINITY;
        for distance in [0.0, 1e-3, 1.0, 30.0, 77.7, length - 1e-3] {
            let at = whole
                .time_before(whole.duration(), distance)
                .expect("it is on the curve");
            assert!((length - whole.arc_length(at) - distance).abs() < 1e-9, "{distance}");
            assert!(at < last, "less is left later");
            last = at;
        }
        assert_eq!(whole.time_before(whole.duration(), length + 1.0), None);
    }
}

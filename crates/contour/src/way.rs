//! How far a motion goes: the length of its curve, and when so much of it is left.
//!
//! A piece of constant jerk has a polynomial for its velocity; the length of it is integrated (Gauss and Legendre, five places,
//! exact where it does not turn). Real-time: bounded, nothing allocates but [`Trajectory::measure_ways`]. Units: position
//! units and seconds.

use crate::trajectory::{Knot, Trajectory};

impl Trajectory {
    /// Lengths of the curve from its first knot to each of them.
    pub(crate) fn measure_ways(&self) -> Vec<f64> {
        let mut way = 0.0;
        let pieces = self
            .knots
            .windows(2)
            .map(|pair| length(&pair[0], pair[1].time - pair[0].time));
        let behind = pieces.map(|piece| {
            way += piece;
            way
        });
        let first = self.knots.first().map(|_| 0.0);
        first.into_iter().chain(behind).collect()
    }

    /// Length of the curve from its first knot to a time.
    #[must_use]
    pub fn way(&self, t: f64) -> f64 {
        let behind = self.knots.partition_point(|knot| knot.time <= t).min(self.ways.len());
        let Some(place) = behind.checked_sub(1) else {
            return 0.0;
        };
        if place + 1 == self.knots.len() {
            return self.ways[place];
        }
        self.ways[place] + length(&self.knots[place], t - self.knots[place].time)
    }

    /// When the motion had so far to go along its curve until a time; `None`: before its first knot.
    #[must_use]
    pub fn time_before(&self, until: f64, distance: f64) -> Option<f64> {
        let way = self.way(until) - distance;
        if way < 0.0 {
            return None;
        }
        let place = self.ways.partition_point(|&behind| behind <= way).checked_sub(1)?;
        let knot = &self.knots[place];
        let Some(next) = self.knots.get(place + 1) else {
            return Some(knot.time);
        };
        let wanted = way - self.ways[place];
        let (mut low, mut high) = (0.0, next.time - knot.time);
        let mut at = 0.5 * high;
        for _ in 0..MOST_STEPS {
            let off = length(knot, at) - wanted;
            if off < 0.0 {
                low = at;
            } else {
                high = at;
            }
            let speed = knot.at(at).velocity.norm();
            let newton = at - off / speed;
            at = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if high - low <= EXACT * high {
                break;
            }
        }
        Some(knot.time + at)
    }
}

/// Length of the curve over the first seconds of a piece.
fn length(knot: &Knot, seconds: f64) -> f64 {
    let speed = |share: f64| knot.at(seconds * 0.5 * (1.0 + share)).velocity.norm();
    let sum = PLACES
        .iter()
        .map(|(place, weight)| weight * (speed(*place) + speed(-place)));
    0.5 * seconds * (MIDDLE * speed(0.0) + sum.sum::<f64>())
}

/// Places of the five besides the middle, by half of the piece, and weights.
const PLACES: [(f64, f64); 2] = [
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];
const MIDDLE: f64 = 128.0 / 225.0;
/// Looks at one piece.
const MOST_STEPS: u32 = 40;
/// Share of a piece that is rounding.
const EXACT: f64 = 1e-15;

#[cfg(test)]
mod tests {
    use crate::{AxisLimits, ContourMove, Path, Point, plan};
    use arcline_geometry::Line;

    #[test]
    fn what_is_left_of_a_way_is_found_again() {
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
        let way = whole.way(whole.duration());
        assert!((way - summed).abs() < 1e-6 * summed, "{way} or {summed}");
        assert_eq!(whole.way(-1.0), 0.0);
        let mut last = f64::INFINITY;
        for distance in [0.0, 1e-3, 1.0, 30.0, 77.7, way - 1e-3] {
            let at = whole.time_before(whole.duration(), distance).expect("it is on the way");
            assert!((way - whole.way(at) - distance).abs() < 1e-9, "{distance}");
            assert!(at < last, "less is left later");
            last = at;
        }
        assert_eq!(whole.time_before(whole.duration(), way + 1.0), None);
    }
}

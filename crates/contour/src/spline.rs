//! The motion of a cubic B-spline in time. Position units and seconds.

use crate::Point;
use crate::trajectory::{AxesState, Knot, Trajectory};

impl Trajectory {
    /// The cubic B-spline with control points `points`, the `i`-th of them at the `i`-th knot, whose
    /// knots are `spans` seconds apart; it starts and ends at rest.
    pub(crate) fn spline(points: &[Point], spans: &[f64]) -> Trajectory {
        let count = points.len();
        let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
            return Trajectory::rest(Point::zeros());
        };
        if count < 2 || spans.len() + 1 != count {
            return Trajectory::rest(last);
        }
        let ends = spans.len() - 1;
        let span = |i: isize| spans[i.clamp(0, ends as isize) as usize];
        let node = |i: isize| {
            if i <= 0 {
                first
            } else {
                points[(i as usize).min(count - 1)]
            }
        };
        let velocity = |i: isize| (node(i + 1) - node(i)) * 3.0 / (span(i - 1) + span(i) + span(i + 1));
        let acceleration = |i: isize| (velocity(i) - velocity(i - 1)) * 2.0 / (span(i - 1) + span(i));
        let mut knots = Vec::with_capacity(count + 2);
        let mut time = 0.0;
        let mut here = Point::zeros();
        for i in -1..=count as isize {
            let next = acceleration(i + 1);
            // Velocity at the knot: the two neighbours weighted by the other's span.
            let (before, behind) = (span(i - 1), span(i));
            let at = (velocity(i - 1) * behind + velocity(i) * before) / (before + behind);
            // Position: the control point, less the distance by which the curve cuts the corner.
            let position = position_at_knot(
                [node(i - 1), node(i), node(i + 1)],
                [span(i - 2), before, behind, span(i + 1)],
            );
            let state = if i < 0 {
                AxesState::rest(first)
            } else if i == count as isize {
                AxesState::rest(last)
            } else {
                AxesState {
                    position,
                    velocity: at,
                    acceleration: here,
                }
            };
            let jerk = if i == count as isize {
                Point::zeros()
            } else {
                (next - here) / behind
            };
            knots.push(Knot { time, state, jerk });
            time += behind;
            here = next;
        }
        Trajectory {
            end: last,
            ..Trajectory::of(knots)
        }
    }
}

/// De Boor's formula at the middle knot: three control points, the four spans about them.
fn position_at_knot(points: [Point; 3], spans: [f64; 4]) -> Point {
    let [h0, h1, h2, h3] = spans;
    let left = points[0] + (points[1] - points[0]) * ((h0 + h1) / (h0 + h1 + h2));
    let right = points[1] + (points[2] - points[1]) * (h1 / (h1 + h2 + h3));
    left + (right - left) * (h1 / (h1 + h2))
}

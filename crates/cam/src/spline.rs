//! From points to a profile: straight segments, and runs of cubic ones as clamped splines.
//!
//! Letters: `h` length of a segment, `d` its mean slope, `m` slope at a point.

use crate::{CamSegment, Profile};

/// The connection of a point to the next one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentType {
    /// A straight line.
    Linear,
    /// A cubic. Its first and second derivatives are continuous at cubic neighbours, its first derivative at linear ones.
    Cubic,
}

/// A point of a cam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Position of the master.
    pub x: f64,
    /// Position of the slave.
    pub y: f64,
    /// The connection to the next point; ignored at the last one.
    pub kind: SegmentType,
}

/// The reason why points form no profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CalculateError {
    /// Fewer than two points.
    #[error("{count} points, expected 2 or more")]
    TooFew {
        /// The number of points.
        count: usize,
    },
    /// A master position not above that of the previous point.
    #[error("the master of point {point} does not rise")]
    Order {
        /// The point, from 0.
        point: usize,
    },
    /// A number that is not finite, or that leads to one.
    #[error("point {point} is not finite")]
    NotFinite {
        /// The point, from 0.
        point: usize,
    },
}

impl Profile {
    /// The profile through points. A cubic segment at an end of the profile has the given slope there; at a linear segment, it has the slope of
    /// that.
    ///
    /// Not real-time: it allocates, and takes a time proportional to the points.
    ///
    /// # Errors
    /// The first point that is not finite or whose master position does not increase.
    pub fn calculate(points: &[Point], start_slope: f64, end_slope: f64) -> Result<Self, CalculateError> {
        if points.len() < 2 {
            return Err(CalculateError::TooFew { count: points.len() });
        }
        for (index, point) in points.iter().enumerate() {
            if !(point.x.is_finite() && point.y.is_finite()) {
                return Err(CalculateError::NotFinite { point: index });
            }
            if index > 0 && point.x <= points[index - 1].x {
                return Err(CalculateError::Order { point: index });
            }
        }
        let mut segments: Vec<CamSegment> = points
            .iter()
            .map(|point| CamSegment {
                x: point.x,
                y: point.y,
                coefficients: [0.0; 3],
                kind: point.kind,
            })
            .collect();
        let last = points.len() - 1;
        let mean = |index: usize| (points[index + 1].y - points[index].y) / (points[index + 1].x - points[index].x);
        let mut from = 0;
        while from < last {
            if points[from].kind == SegmentType::Linear {
                segments[from].coefficients[0] = mean(from);
                from += 1;
                continue;
            }
            let run = points[from..last]
                .iter()
                .take_while(|point| point.kind == SegmentType::Cubic);
            let to = from + run.count();
            let first = if from == 0 { start_slope } else { mean(from - 1) };
            let end = if to == last { end_slope } else { mean(to) };
            let slopes = slopes(&points[from..=to], first, end);
            for index in from..to {
                let h = points[index + 1].x - points[index].x;
                let (m0, m1) = (slopes[index - from], slopes[index - from + 1]);
                let d = mean(index);
                segments[index].coefficients = [m0, (3.0 * d - 2.0 * m0 - m1) / h, (m0 + m1 - 2.0 * d) / (h * h)];
            }
            from = to;
        }
        let bad = segments
            .iter()
            .position(|segment| !segment.coefficients.iter().all(|number| number.is_finite()));
        match (bad, Profile::from_segments(segments)) {
            (None, Some(profile)) => Ok(profile),
            (index, _) => Err(CalculateError::NotFinite {
                point: index.unwrap_or(0),
            }),
        }
    }
}

/// Slopes at the points of a spline whose second derivative is continuous, with given slopes at its ends.
///
/// For every inner point `m₋/h₋ + 2 m (1/h₋ + 1/h₊) + m₊/h₊ = 3 (d₋/h₋ + d₊/h₊)`: a system of three diagonals, solved
/// from the front to the back and back again; it is diagonally dominant, so errors do not grow.
fn slopes(points: &[Point], first: f64, end: f64) -> Vec<f64> {
    let count = points.len();
    let mut slopes = vec![0.0; count];
    slopes[0] = first;
    slopes[count - 1] = end;
    let h = |index: usize| points[index + 1].x - points[index].x;
    let d = |index: usize| (points[index + 1].y - points[index].y) / h(index);
    // The factor of the next slope in the reduced equation of a point, and its right side.
    let mut share = vec![0.0; count];
    let mut right = vec![0.0; count];
    right[0] = first;
    for index in 1..count - 1 {
        let (before, behind) = (1.0 / h(index - 1), 1.0 / h(index));
        let pivot = 2.0 * (before + behind) - before * share[index - 1];
        share[index] = behind / pivot;
        right[index] = (3.0 * (d(index - 1) * before + d(index) * behind) - before * right[index - 1]) / pivot;
    }
    for index in (1..count - 1).rev() {
        slopes[index] = right[index] - share[index] * slopes[index + 1];
    }
    slopes
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use SegmentType::{Cubic, Linear};

    fn points(given: &[(f64, f64, SegmentType)]) -> Vec<Point> {
        given
            .iter()
            .map(|(x, y, kind)| Point {
                x: *x,
                y: *y,
                kind: *kind,
            })
            .collect()
    }

    #[test]
    fn known_profiles() {
        // A cubic from rest to rest: y = 3u² − 2u³.
        let rest = Profile::calculate(&points(&[(0.0, 0.0, Cubic), (1.0, 1.0, Cubic)]), 0.0, 0.0).expect("a profile");
        assert_eq!(rest.segments()[0].coefficients, [0.0, 3.0, -2.0]);
        assert_eq!(rest.at(0.5).y, 0.5);
        assert_eq!(rest.at(0.5).slope, 1.5);
        // Points of a cubic with its slopes give the cubic.
        let cubic = |x: f64| 1.0 + x * (2.0 + x * (-3.0 + x));
        let given: Vec<_> = [-1.0, -0.25, 0.5, 2.0, 2.5].map(|x| (x, cubic(x), Cubic)).to_vec();
        let slope = |x: f64| 2.0 - 6.0 * x + 3.0 * x * x;
        let profile = Profile::calculate(&points(&given), slope(-1.0), slope(2.5)).expect("a profile");
        for k in 0..=35 {
            let x = -1.0 + 0.1 * f64::from(k);
            let value = profile.at(x);
            assert!((value.y - cubic(x)).abs() < 1e-12, "{x}: {value:?}");
            assert!((value.slope - slope(x)).abs() < 1e-11, "{x}: {value:?}");
            assert!((value.curvature - (6.0 * x - 6.0)).abs() < 1e-10, "{x}: {value:?}");
        }
        // A line, a cubic between two lines, a line: the slopes of the lines.
        let mixed = [
            (0.0, 0.0, Linear),
            (1.0, 2.0, Cubic),
            (2.0, 3.0, Linear),
            (4.0, 3.0, Linear),
        ];
        let mixed = Profile::calculate(&points(&mixed), 9.0, 9.0).expect("a profile");
        assert_eq!(mixed.segments()[0].coefficients, [2.0, 0.0, 0.0]);
        assert_eq!((mixed.at(1.0).slope, mixed.at(2.0).slope), (2.0, 0.0));
        assert_eq!(mixed.at(1.0).segment, 1);
        assert_eq!(
            (mixed.start(), mixed.end(), mixed.rise()),
            ((0.0, 0.0), (4.0, 3.0), 3.0)
        );
    }

    #[test]
    fn beyond_its_ends_a_slave_stands() {
        let line = Profile::calculate(&points(&[(1.0, 5.0, Linear), (3.0, 9.0, Linear)]), 0.0, 0.0).expect("a profile");
        #[rustfmt::skip]
        let cases = [
            // x,            y,   slope, segment
            (1.0,            5.0, 2.0,   0),
            (3.0,            9.0, 2.0,   0),
            (0.999,          5.0, 0.0,   0),
            (3.001,          9.0, 0.0,   0),
            (f64::INFINITY,  9.0, 0.0,   0),
        ];
        for (x, y, slope, segment) in cases {
            let value = line.at(x);
            assert_eq!((value.y, value.slope, value.segment), (y, slope, segment), "{x}");
        }
    }

    #[test]
    fn points_that_make_no_profile() {
        let calculate = |given: &[(f64, f64, SegmentType)]| Profile::calculate(&points(given), 0.0, 0.0);
        assert_eq!(
            calculate(&[(0.0, 0.0, Cubic)]),
            Err(CalculateError::TooFew { count: 1 })
        );
        #[rustfmt::skip]
        let cases = [
            (vec![(0.0, 0.0, Cubic), (0.0, 1.0, Cubic)], CalculateError::Order { point: 1 }),
            (vec![(0.0, 0.0, Cubic), (1.0, 1.0, Cubic), (0.5, 1.0, Cubic)], CalculateError::Order { point: 2 }),
            (vec![(f64::NAN, 0.0, Cubic), (1.0, 1.0, Cubic)], CalculateError::NotFinite { point: 0 }),
            (vec![(0.0, 0.0, Linear), (1.0, f64::INFINITY, Linear)], CalculateError::NotFinite { point: 1 }),
            (vec![(0.0, 0.0, Linear), (1e-300, 1e300, Linear)], CalculateError::NotFinite { point: 0 }),
        ];
        for (given, expected) in cases {
            assert_eq!(calculate(&given), Err(expected), "{given:?}");
        }
    }

    proptest! {
        /// The profile passes through every point, first derivatives are continuous except between lines, second ones within cubic
        /// runs, and the end slopes are the given ones.
        #[test]
        fn profiles_go_through_their_points(
            steps in proptest::collection::vec((0.01f64..50.0, -100.0f64..100.0, any::<bool>()), 2..40),
            start_slope in -5.0f64..5.0,
            end_slope in -5.0f64..5.0,
        ) {
            let mut x = -20.0;
            let given: Vec<Point> = steps.iter().map(|(step, y, cubic)| {
                x += step;
                Point { x, y: *y, kind: if *cubic { Cubic } else { Linear } }
            }).collect();
            let profile = Profile::calculate(&given, start_slope, end_slope).expect("points that rise");
            let last = given.len() - 1;
            for (index, point) in given.iter().enumerate() {
                prop_assert_eq!(profile.at(point.x).y, point.y);
                if index == 0 || index == last {
                    continue;
                }
                let [before, behind] = [&profile.segments()[index - 1], &profile.segments()[index]];
                let h = point.x - before.x;
                let [a1, a2, a3] = before.coefficients;
                let scale = 1.0 + a1.abs() + (a2 * h).abs() + (a3 * h * h).abs();
                prop_assert!((before.y + h * (a1 + h * (a2 + h * a3)) - point.y).abs() < 1e-9 * (1.0 + scale * h));
                if before.kind == Linear && behind.kind == Linear {
                    continue;
                }
                let slope = a1 + h * (2.0 * a2 + 3.0 * h * a3);
                prop_assert!((slope - behind.coefficients[0]).abs() < 1e-9 * scale, "slopes at {index}");
                if before.kind == Cubic && behind.kind == Cubic {
                    let curvature = 2.0 * a2 + 6.0 * h * a3;
                    let most = 1.0 + (2.0 * a2).abs() + (6.0 * h * a3).abs() + (2.0 * behind.coefficients[1]).abs();
                    prop_assert!((curvature - 2.0 * behind.coefficients[1]).abs() < 1e-8 * most, "curvature at {index}");
                }
            }
            if given[0].kind == Cubic {
                prop_assert_eq!(profile.at(given[0].x).slope, start_slope);
            }
            if given[last - 1].kind == Cubic {
                let slope = profile.at(given[last].x).slope;
                prop_assert!((slope - end_slope).abs() < 1e-6 * (1.0 + slope.abs()), "{slope}");
            }
        }
    }
}

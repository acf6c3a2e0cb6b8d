//! Arcs of a plane: from centre or radius to points on them. Angles in radians, counterclockwise positive.

use std::f64::consts::{PI, TAU};

use crate::Problem;
use crate::tolerance::{
    MOST_RADIUS_DIFFERENCE_MM, PART_SHARE, RADIUS_DIFFERENCE_MM, RADIUS_DIFFERENCE_SHARE, SAME_POINT_MM,
};

/// Two coordinates of the plane, the first axis turning to the second counterclockwise.
pub(crate) type Flat = [f64; 2];

/// Longest part of an arc, radians: three points of a longer one would say too little about its centre.
const LONGEST_PART_RAD: f64 = 1.5 * PI;

/// An arc that has been checked.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Arc {
    center: Flat,
    /// Of the start.
    angle: f64,
    /// Signed.
    sweep: f64,
    start_radius: f64,
    end_radius: f64,
    end: Flat,
}

impl Arc {
    /// By its centre; an end at the start is a full circle. `scale` is one millimetre in units of the machine.
    pub(crate) fn about(start: Flat, end: Flat, center: Flat, is_ccw: bool, scale: f64) -> Result<Self, Problem> {
        let (a, b) = (sub(start, center), sub(end, center));
        let (start_radius, end_radius) = (a[0].hypot(a[1]), b[0].hypot(b[1]));
        if start_radius <= SAME_POINT_MM * scale {
            return Err(Problem::NoArc {
                what: "the centre of the arc is its start",
            });
        }
        let difference = (start_radius - end_radius).abs();
        if difference > MOST_RADIUS_DIFFERENCE_MM * scale
            || difference > RADIUS_DIFFERENCE_MM * scale && difference > RADIUS_DIFFERENCE_SHARE * start_radius
        {
            return Err(Problem::Radii {
                start: start_radius,
                end: end_radius,
            });
        }
        let angle = a[1].atan2(a[0]);
        let chord = sub(end, start);
        let sweep = if chord[0].hypot(chord[1]) <= SAME_POINT_MM * scale {
            TAU
        } else {
            let turned = (b[1].atan2(b[0]) - angle).rem_euclid(TAU);
            if is_ccw { turned } else { TAU - turned }
        };
        Ok(Self {
            center,
            angle,
            sweep: if is_ccw { sweep } else { -sweep },
            start_radius,
            end_radius,
            end,
        })
    }

    /// By its radius; a negative one means the longer arc.
    pub(crate) fn with_radius(start: Flat, end: Flat, radius: f64, is_ccw: bool, scale: f64) -> Result<Self, Problem> {
        let chord = sub(end, start);
        let distance = chord[0].hypot(chord[1]);
        if distance <= SAME_POINT_MM * scale {
            return Err(Problem::NoArc {
                what: "an arc with R ends where it starts: a full circle needs its centre",
            });
        }
        let squared = radius * radius - 0.25 * distance * distance;
        // Half a circle whose radius was rounded.
        let slack = RADIUS_DIFFERENCE_MM * scale * radius.abs();
        if squared < -slack {
            return Err(Problem::TooShort { radius, distance });
        }
        let height = squared.max(0.0).sqrt() / distance;
        let side = if is_ccw == (radius > 0.0) { height } else { -height };
        let center = [
            0.5 * (start[0] + end[0]) - side * chord[1],
            0.5 * (start[1] + end[1]) + side * chord[0],
        ];
        Self::about(start, end, center, is_ccw, scale)
    }

    /// Position units.
    pub(crate) fn length(&self) -> f64 {
        0.5 * (self.start_radius + self.end_radius) * self.sweep.abs()
    }

    /// Via and end point of each part, as few parts as are short enough.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (Flat, Flat)> {
        // A rounding error must not make a part more.
        let count = (self.sweep.abs() / LONGEST_PART_RAD - PART_SHARE).ceil().max(1.0);
        let this = *self;
        (0..count as usize).map(move |part| {
            let share = |halves: f64| (part as f64 + halves) / count;
            let end = if part + 1 == count as usize {
                this.end
            } else {
                this.at(share(1.0))
            };
            (this.at(share(0.5)), end)
        })
    }

    /// A point of it, 0 its start, 1 its end.
    fn at(&self, share: f64) -> Flat {
        let radius = self.start_radius + share * (self.end_radius - self.start_radius);
        let angle = self.angle + share * self.sweep;
        [
            self.center[0] + radius * angle.cos(),
            self.center[1] + radius * angle.sin(),
        ]
    }
}

fn sub(a: Flat, b: Flat) -> Flat {
    [a[0] - b[0], a[1] - b[1]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn arcs_are_where_they_should_be() {
        type Case<'a> = (&'a str, Result<Arc, Problem>, &'a [(Flat, Flat)]);
        #[rustfmt::skip]
        let cases: &[Case<'_>] = &[
            // why,                        arc,                                                            via, end of each part
            ("a quarter, ccw",             Arc::about([10.0, 0.0], [0.0, 10.0], [0.0; 2], true, 1.0),      &[([50_f64.sqrt(), 50_f64.sqrt()], [0.0, 10.0])]),
            ("the rest of it, cw",         Arc::about([10.0, 0.0], [0.0, 10.0], [0.0; 2], false, 1.0),     &[([-50_f64.sqrt(), -50_f64.sqrt()], [0.0, 10.0])]),
            ("half, cw",                   Arc::about([0.0; 2], [10.0, 0.0], [5.0, 0.0], false, 1.0),      &[([5.0, 5.0], [10.0, 0.0])]),
            ("a full circle, ccw",         Arc::about([5.0, 0.0], [5.0, 0.0], [0.0; 2], true, 1.0),        &[([0.0, 5.0], [-5.0, 0.0]), ([0.0, -5.0], [5.0, 0.0])]),
            ("by a radius, cw",            Arc::with_radius([0.0; 2], [10.0, 10.0], 10.0, false, 1.0),     &[([10.0 - 50_f64.sqrt(), 50_f64.sqrt()], [10.0, 10.0])]),
            ("the longer way, cw",         Arc::with_radius([0.0; 2], [10.0, 10.0], -10.0, false, 1.0),    &[([-50_f64.sqrt(), 10.0 + 50_f64.sqrt()], [10.0, 10.0])]),
            ("by a radius, ccw",           Arc::with_radius([0.0; 2], [10.0, 10.0], 10.0, true, 1.0),      &[([50_f64.sqrt(), 10.0 - 50_f64.sqrt()], [10.0, 10.0])]),
            ("half by a rounded radius",   Arc::with_radius([0.0; 2], [10.0, 0.0], 4.999, true, 1.0),      &[([5.0, -5.0], [10.0, 0.0])]),
        ];
        for (why, arc, expected) in cases {
            let arc = arc.as_ref().unwrap_or_else(|problem| panic!("{why}: {problem}"));
            let parts: Vec<(Flat, Flat)> = arc.parts().collect();
            assert_eq!(parts.len(), expected.len(), "{why}: {parts:?}");
            for (found, expected) in parts.iter().zip(*expected) {
                for (found, expected) in [(found.0, expected.0), (found.1, expected.1)] {
                    let off = sub(found, expected);
                    assert!(off[0].hypot(off[1]) < 1e-9, "{why}: {parts:?}");
                }
            }
        }
    }

    #[test]
    fn words_that_make_no_arc_are_reported() {
        #[rustfmt::skip]
        let cases = [
            ("radii that differ",    Arc::about([10.0, 0.0], [0.0, 11.0], [0.0; 2], true, 1.0),       "the radius is 10 at the start of the arc and 11 at its end"),
            ("no radius",            Arc::about([0.0; 2], [0.0, 11.0], [0.0; 2], true, 1.0),          "the centre of the arc is its start"),
            ("R and no way",         Arc::with_radius([1.0; 2], [1.0; 2], 5.0, true, 1.0),            "an arc with R ends where it starts"),
            ("too short",            Arc::with_radius([0.0; 2], [10.0, 0.0], 4.0, true, 1.0),         "a radius of 4 does not span the 10"),
        ];
        for (why, arc, expected) in cases {
            let problem = arc.expect_err(why).to_string();
            assert!(problem.contains(expected), "{why}: {problem}");
        }
    }

    proptest! {
        /// All points are on the circle, and the chords of the parts add up to the length.
        #[test]
        fn parts_follow_the_circle(
            center in [-500.0..500.0, -500.0..500.0_f64], radius in 0.1..500.0_f64,
            from in 0.0..TAU, sweep in 0.01..TAU, is_ccw: bool,
        ) {
            let point = |angle: f64| [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()];
            let signed = if is_ccw { sweep } else { -sweep };
            let arc = Arc::about(point(from), point(from + signed), center, is_ccw, 1.0).expect("an arc");
            prop_assert!((arc.length() - radius * sweep).abs() < 1e-6 * radius.max(1.0), "{arc:?}");
            let mut last = point(from);
            for (via, end) in arc.parts() {
                for at in [via, end] {
                    let off = sub(at, center);
                    prop_assert!((off[0].hypot(off[1]) - radius).abs() < 1e-6, "{at:?}");
                }
                // A via point is as far from both ends of its part.
                let (a, b) = (sub(via, last), sub(end, via));
                prop_assert!((a[0].hypot(a[1]) - b[0].hypot(b[1])).abs() < 1e-6);
                last = end;
            }
            prop_assert_eq!(last, point(from + signed));
        }
    }
}

//! The rest of a rotation without a target: it continues about fixed axes until it is at rest.
//!
//! One axis is that of its rate, the other that of its acceleration across the rate. Not here: its deceleration. Angles
//! are radians, those of an orientation degrees.

use nalgebra::Matrix3;

use crate::rotation::about;
use crate::{Point, RotationState, angles, rotation};

/// An orientation that rotates about one fixed axis, and then about another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spin {
    from: Matrix3<f64>,
    /// Unit axes; 0 without a rotation.
    axes: [Point; 2],
    /// The fixed angles at its ends, degrees.
    shown: [Point; 2],
    to: Matrix3<f64>,
    /// The total angle about each axis.
    whole: [f64; 2],
}

/// An angle about an axis and its first two derivatives, radians per unit of its variable.
type Angle = [f64; 3];

impl Spin {
    /// From fixed angles, degrees, about axes. `course`: the angles about both axes at a share of the duration, 0 to 1.
    #[must_use]
    pub fn new(from: &Point, axes: [Point; 2], course: impl Fn(f64) -> [Angle; 2]) -> Spin {
        let mut spin = Spin {
            from: rotation(from),
            axes,
            shown: [*from; 2],
            to: rotation(from),
            whole: course(1.0).map(|[angle, ..]| angle),
        };
        for sample in 1..=SAMPLES {
            spin.to = spin
                .rotation_state(&course(f64::from(sample) / f64::from(SAMPLES)))
                .orientation;
            spin.shown[1] = angles(&spin.to, &spin.shown[1]);
        }
        spin
    }

    /// Its end state, at rest.
    #[must_use]
    pub fn ended(&self) -> RotationState {
        RotationState::at_rest(self.to, self.shown[1])
    }

    /// The state at these angles about the axes. Real-time.
    #[must_use]
    pub fn at(&self, about: &[Angle; 2]) -> RotationState {
        let [first, last] = self.shown;
        let gone: f64 = about.iter().map(|[angle, ..]| angle.abs()).sum();
        let whole: f64 = self.whole.iter().map(|angle| angle.abs()).sum();
        let share = if whole > 0.0 { (gone / whole).min(1.0) } else { 1.0 };
        RotationState {
            near: if share >= 1.0 {
                last
            } else {
                first + (last - first) * share
            },
            ..self.rotation_state(about)
        }
    }

    fn rotation_state(&self, [first, second]: &[Angle; 2]) -> RotationState {
        let [a, b] = self.axes;
        let outer = about(&a, first[0]);
        let carried = outer * b * second[1];
        RotationState {
            orientation: outer * about(&b, second[0]) * self.from,
            rate: a * first[1] + carried,
            change: a * first[2] + outer * b * second[2] + (a * first[1]).cross(&carried),
            near: self.shown[0],
        }
    }
}

/// Samples of a spin, to follow its angles: even in time, so that the angles of two whole turns change by less than half a turn from one to
/// the next.
const SAMPLES: u32 = 64;

#[cfg(test)]
mod tests {
    use super::*;

    /// The rates agree with differences of the rotation, and the ends with the axes.
    #[test]
    fn it_turns_about_both_axes_at_once() {
        let axes = [Point::new(0.6, 0.0, 0.8), Point::new(0.8, 0.0, -0.6)];
        let course = |share: f64| {
            let left = 1.0 - share;
            [
                [2.0 * (1.0 - left * left), 4.0 * left, -4.0],
                [
                    0.5 * share * share * left,
                    share * left - 0.5 * share * share,
                    left - 2.0 * share,
                ],
            ]
        };
        let from = Point::new(10.0, -20.0, 170.0);
        let spin = Spin::new(&from, axes, course);
        assert_eq!(spin.at(&course(0.0)).angles(), angles(&rotation(&from), &from));
        let end = rotation(&spin.ended().near) - spin.ended().orientation;
        assert!(end.abs().max() < 1e-12, "{end}");
        assert!(spin.ended().near.z > 180.0, "Rz goes on: {}", spin.ended().near);
        let step = 1e-5;
        for share in [0.1, 0.4, 0.8] {
            let now = spin.at(&course(share));
            let [before, after] = [-step, step].map(|t| spin.at(&course(share + t)));
            let slope = (after.orientation - before.orientation) * now.orientation.transpose() / (2.0 * step);
            assert!(
                (slope - now.rate.cross_matrix()).abs().max() < 1e-6,
                "{slope} {}",
                now.rate
            );
            let bend = (after.rate - before.rate) / (2.0 * step);
            assert!((bend - now.change).abs().max() < 1e-6, "{bend} {}", now.change);
        }
    }
}

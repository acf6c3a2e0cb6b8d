//! Two links in a plane, as in articulated and SCARA arms (spec/coordinated-instructions.md §22.2).
//!
//! Units: any for lengths, radians.

use crate::number::root;
use crate::{Elbow, KinematicsError, Number};

/// Two links of a plane arm, both longer than 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TwoLinks {
    pub(crate) first: f64,
    pub(crate) second: f64,
}

impl TwoLinks {
    /// The end of the arm for the angles of the first link and of the second one, both against the axis of `u`.
    pub(crate) fn end<N: Number>(&self, first: N, second: N) -> [N; 2] {
        let ((sin1, cos1), (sin2, cos2)) = (first.sin_cos(), second.sin_cos());
        [
            cos1 * self.first + cos2 * self.second,
            sin1 * self.first + sin2 * self.second,
        ]
    }

    /// The angle of the first link, and of the second one against the first, each above -pi up to pi.
    ///
    /// # Errors
    /// `Reach` if the arm is too short, or cannot fold that far, or is stretched or folded to its end while it moves; its joint is
    /// `bend`. `Origin` if the end is at the shoulder, where the first link may have any direction.
    pub(crate) fn angles<N: Number>(&self, [u, w]: [N; 2], elbow: Elbow, bend: u8) -> Result<[N; 2], KinematicsError> {
        let (a, b) = (self.first, self.second);
        let square = u * u + w * w;
        let (longest, shortest) = ((a + b) * (a + b), (a - b) * (a - b));
        if square.value() <= N::NEAREST_SHARE * N::NEAREST_SHARE * longest {
            return Err(KinematicsError::Origin);
        }
        let inverse = 1.0 / (2.0 * a * b);
        // 1 - cos and 1 + cos of the bend, neither with a significant cancellation.
        let stretched = (N::constant(longest) - square) * inverse;
        let folded = (square - shortest) * inverse;
        if stretched.value().min(folded.value()) < N::LEAST_BEND_SHARE {
            return Err(KinematicsError::Reach { joint: bend });
        }
        let product = stretched * folded;
        let sin = root(product);
        let sin = match elbow {
            Elbow::Right => sin,
            Elbow::Left => -sin,
        };
        let cos = (folded - stretched) * 0.5;
        let (along, across) = (cos * b + a, sin * b);
        let first = (w * along - u * across).atan2(u * along + w * across);
        Ok([first, sin.atan2(cos)])
    }
}

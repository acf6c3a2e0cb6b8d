//! One bracketed root of a monotone function that may have corners, plateaus and square roots.

use crate::tolerance::{BRACKET_SHARE, ROUNDED_SHARE};

/// The point in `0..=length` at which `f`, non-decreasing with `f(0) = at_start <= 0` and
/// `f(length) = at_end >= 0`, is 0 to within `tolerance`: inverse quadratic interpolation inside a
/// bracket that is halved if interpolation is not safe (T. R. Chandrupatla, 1997). At most
/// [`MAX_EVALUATIONS`] evaluations; the best one is returned.
pub(crate) fn solve(length: f64, at_start: f64, at_end: f64, tolerance: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    // (a, b) is the bracket, b the newer end, c the end before.
    let (mut b, mut fb) = (0.0, at_start);
    let (mut a, mut fa) = (length, at_end);
    let mut share = if fa > fb {
        (-fb / (fa - fb)).clamp(0.02, 0.98)
    } else {
        0.5
    };
    // From b towards a.
    for _ in 0..MAX_EVALUATIONS {
        if fb.abs() <= tolerance || fa.abs() <= tolerance || (a - b).abs() <= BRACKET_SHARE * length {
            break;
        }
        let x = b + share * (a - b);
        let fx = f(x);
        let (c, fc);
        if (fx > 0.0) == (fb > 0.0) {
            (c, fc) = (b, fb);
        } else {
            (c, fc) = (a, fa);
            (a, fa) = (b, fb);
        }
        (b, fb) = (x, fx);
        let xi = (b - a) / (c - a);
        let phi = (fb - fa) / (fc - fa);
        share = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fb / (fa - fb) * fc / (fa - fc) + (c - b) / (a - b) * fb / (fc - fb) * fa / (fc - fa)
        } else {
            0.5
        };
        let least = (ROUNDED_SHARE * length / (a - b).abs()).min(0.5);
        share = if share.is_nan() {
            0.5
        } else {
            share.clamp(least, 1.0 - least)
        };
    }
    if fa.abs() < fb.abs() { a } else { b }
}

pub(crate) const MAX_EVALUATIONS: usize = 64;

//! How far the rounding of a corner reaches along the pieces on both sides. Lengths in position units.

use crate::limits::Smoothness;
use crate::tolerance::SAME_DIRECTION_SINE;
use arcline_geometry::Path;

/// How far a corner's rounding reaches along the pieces on both sides: as far as superposition would draw one that uses all of
/// the tolerance (`crate::path::rounding`), at most ten tolerances. A line that goes on straight has none.
pub(crate) fn most_reach(before: &Path, behind: &Path, tolerance: f64, smoothness: Smoothness) -> f64 {
    let most = MOST_REACH_TOLERANCES * tolerance;
    match (before, behind) {
        (Path::Line(_), Path::Line(_)) => reach_of_lines(before, behind, tolerance, smoothness).min(most),
        _ => most,
    }
}

/// How far a rounding of two lines reaches to either side that is a tolerance off; 0 where they go on straight.
pub(crate) fn reach_of_lines(before: &Path, behind: &Path, tolerance: f64, smoothness: Smoothness) -> f64 {
    let (u1, u2) = (before.end_tangent(), behind.start_tangent());
    let (sine, cosine) = (u1.cross(&u2).norm(), u1.dot(&u2));
    if sine <= SAME_DIRECTION_SINE && cosine > 0.0 {
        return 0.0;
    }
    let order = match smoothness {
        Smoothness::Trapezoid => 4.0,
        Smoothness::SCurve => 8.0,
    };
    // Up to 90 degrees the distance from the nearer leg counts, beyond it the one from the
    // corner, at most what a right angle gives; both agree at 90 degrees.
    if cosine >= 0.0 {
        order * tolerance / sine
    } else {
        order * tolerance * core::f64::consts::FRAC_1_SQRT_2 / (0.5 * (1.0 - cosine)).sqrt()
    }
}

/// Tolerances that a rounding reaches from its corner at most ([`crate::Deviation::Corners`]).
pub(crate) const MOST_REACH_TOLERANCES: f64 = 10.0;

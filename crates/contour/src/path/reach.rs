//! The length of a corner's rounding along the pieces on both sides. Lengths in position units.

use crate::limits::Smoothness;
use crate::tolerance::SAME_DIRECTION_SINE;
use arcline_geometry::Path;

/// The length of a corner's rounding along the pieces on both sides: that of a superposition which uses all of the tolerance
/// (`crate::path::rounding`), at most ten tolerances. Collinear lines have none.
pub(crate) fn most_reach(before: &Path, behind: &Path, tolerance: f64, smoothness: Smoothness) -> f64 {
    let most = MOST_REACH_TOLERANCES * tolerance;
    match (before, behind) {
        (Path::Line(_), Path::Line(_)) => reach_of_lines(before, behind, tolerance, smoothness).min(most),
        _ => most,
    }
}

/// The length to either side of the rounding of two lines that deviates by a tolerance; 0 for collinear lines.
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
    // Up to 90 degrees the distance from the nearer leg counts, beyond that the one from the
    // corner, limited to the value of a right angle; both agree at 90 degrees.
    if cosine >= 0.0 {
        order * tolerance / sine
    } else {
        order * tolerance * core::f64::consts::FRAC_1_SQRT_2 / (0.5 * (1.0 - cosine)).sqrt()
    }
}

/// Largest length of a rounding from its corner, in tolerances ([`crate::Deviation::Corners`], spec/motion-core.md §6.4).
pub(crate) const MOST_REACH_TOLERANCES: f64 = 10.0;

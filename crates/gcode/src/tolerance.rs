//! Tolerances of G-code: thresholds for rounding, for a program's digits and for arcs that are refused, with the unit in the name. Units: mm, which
//! a program in inches converts; shares have none. "Not measured" means that a figure is a choice.

/// Points closer than this are equal, mm: a thousandth of the last digit of usual programs (three decimals).
pub(crate) const SAME_POINT_MM: f64 = 1e-6;
/// A distance shorter than this is no motion, mm: a thousandth of the last digit of usual programs, and the distance at which `arcline_geometry` takes two
/// points for one.
pub(crate) const NO_MOTION_MM: f64 = 1e-6;
/// An arc shorter than this is a line, mm: a tenth of the last digit of usual programs, so the centre of such an arc is rounding. Not measured.
pub(crate) const STRAIGHT_ARC_MM: f64 = 1e-4;
/// Difference of the radii at start and end that is always allowed, mm: the rounding of six coordinates of three decimals, 0.0005 mm each, with a
/// margin (docs/GCODE.md).
pub(crate) const RADIUS_DIFFERENCE_MM: f64 = 0.005;
/// A larger difference that is allowed, as a share of the radius (docs/GCODE.md). Not measured.
pub(crate) const RADIUS_DIFFERENCE_SHARE: f64 = 1e-3;
/// Difference that is never allowed, mm (docs/GCODE.md). Not measured.
pub(crate) const MOST_RADIUS_DIFFERENCE_MM: f64 = 0.5;
/// Excess of the number of an arc's parts that is rounding, as a share of a part: far above the rounding of an angle, far below an arc's digits.
pub(crate) const PART_SHARE: f64 = 1e-9;

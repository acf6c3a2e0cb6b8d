//! The sizes of the largest machine, and the default jerk of an axis or a coordinate system.

/// Largest number of axes of one machine.
pub const MAX_AXES: usize = 256;

/// Largest number of coordinate systems of one machine.
pub const MAX_SYSTEMS: usize = 64;

/// Largest number of transforms of one machine.
pub const MAX_TRANSFORMS: usize = 64;

/// Largest number of axes of one coordinate system that moves interpolate as a vector: X, Y, Z.
pub const MAX_PRIMARY_AXES: usize = 3;

/// Largest number of execution targets of output cams of one axis: a bit of OutputCamStatus each.
pub const MAX_OUTPUT_TARGETS: usize = 32;

/// Largest number of axes of one coordinate system: X, Y, Z, Rx, Ry, Rz, or the joints J1 to J6.
pub const MAX_SYSTEM_AXES: usize = 6;

/// Deepest queue of pending moves behind the active one.
pub const MAX_QUEUE_DEPTH: usize = 1000;

/// The default jerk maximum, which equals "100 % of time" at full speed and full rate: `rate² / speed`
/// (spec/axis-and-data-types.md §9.2), u/s³.
pub fn default_jerk(speed: f64, rate: f64) -> f64 {
    if speed > 0.0 { rate * rate / speed } else { 0.0 }
}

/// The first three of the values that each axis of a coordinate system has: those of its primary axes, or of an arm's joints.
pub(crate) fn three<T: Copy>(of: &[T; MAX_SYSTEM_AXES]) -> [T; MAX_PRIMARY_AXES] {
    [of[0], of[1], of[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_jerk_is_full_time() {
        // The value seen in exported projects (spec/axis-and-data-types.md §9.2).
        assert!((default_jerk(92.083336, 894.4814) - 8688.8).abs() < 0.1);
        assert_eq!(default_jerk(0.0, 1.0), 0.0);
    }
}

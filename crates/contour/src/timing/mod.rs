//! The times of a motion's control points.

pub(crate) mod control_points;
pub(crate) mod first_guess;
pub(crate) mod grid;
pub(crate) mod resample;
pub(crate) mod speed_profile;
pub(crate) mod warp;

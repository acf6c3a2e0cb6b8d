//! Where the control points of a motion stand in time.

pub(crate) mod control_points;
pub(crate) mod first_guess;
pub(crate) mod grid;
pub(crate) mod resample;
pub(crate) mod speed_profile;
pub(crate) mod warp;

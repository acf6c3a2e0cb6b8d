//! Speed over time along one dimension: trapezoids and S-curves with four independent limits,
//! from any state.
//!
//! A [`Profile`] is planned once from a state and limits and then sampled; it knows neither paths
//! nor ticks. Position, velocity, acceleration and jerk are in position units and seconds (in
//! master driven mode: master units in place of seconds).
//!
//! The limits belong to the sign of speeding up, not to the direction of travel
//! (spec/motion-core.md §3.1): `acceleration` and its jerk hold while `|v|` grows, `deceleration`
//! and its jerk while it shrinks, and the smaller acceleration when the motion passes through rest.
//!
//! All functions are safe in the tick: no allocation, no unbounded loop, no panic, and a result for
//! every input (non-finite input counts as 0, magnitudes are clamped to 1e-30 to 1e30).
#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod bounded;
mod builder;
mod early;
mod kinematic_state;
mod limits;
mod lookahead;
pub mod numeric;
mod passing;
mod peak;
mod position;
mod profile;
mod ramp;
mod root;
mod tolerance;
mod trapezoid;

#[cfg(test)]
mod tests;

pub use bounded::{AccelerationRemovalPhase, DynamicsBits, MOST_OVERSHOOT};
pub use kinematic_state::KinematicState;
pub use limits::{Jerk, Limits, jerk_from_percent_of_time};
pub use lookahead::{entry_speed, exit_speed, stop_distance};
pub use passing::{Passing, passing_speed};
pub use profile::{Phase, Profile, ProfileSegment};

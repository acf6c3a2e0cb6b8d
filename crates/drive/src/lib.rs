//! The seam between motion and the drives of a machine, and a simulated machine behind it.
//!
//! Once in a tick, set-points of all axes go out and feedback of all axes comes in ([`Drives::exchange`]). Positions on the seam are
//! those of the machine: what instructions redefine changes nothing here. [`simulated`] is the implementation that is in the
//! product; a fieldbus or a plant model is another one. Not here: faults' actions, axis states, the configuration. Units: position
//! units, seconds. Nothing allocates after an implementation was made.

#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod exchange;
pub mod simulated;

pub use arcline_profile::KinematicState;
pub use exchange::{
    ArmLatch, DriveInput, DriveState, Drives, ExchangeLost, Feedback, Following, HOME_LATCH, Inputs, LATCHES, Latch,
    REGISTRATION_LATCHES, Saturation, SetPoint, Settled, Trigger, WrittenInput,
};

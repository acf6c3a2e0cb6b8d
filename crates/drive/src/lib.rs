//! The interface between motion and the drives of a machine, and a simulated machine that implements it.
//!
//! Once in a tick, set-points of all axes go out and feedback of all axes comes in ([`Drives::exchange`]). Positions in the exchange are
//! machine positions: redefined positions do not affect them. [`simulated`] is the implementation in the product; a fieldbus or a plant model
//! is another one. Not here: fault actions, axis states, the configuration. Units: position units, seconds. Nothing allocates after the
//! creation of an implementation.

#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod exchange;
pub mod simulated;

pub use arcline_profile::KinematicState;
pub use exchange::{
    ArmLatch, DriveInput, DriveInputs, DriveState, Drives, ExchangeLost, Feedback, Following, HOME_LATCH, LATCHES,
    Latch, REGISTRATION_LATCHES, Saturation, SetPoint, Settled, Trigger, WrittenInput,
};

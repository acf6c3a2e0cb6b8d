//! The controller's thread: a sequence of ticks at absolute times, and the rings that connect it to the rest of the server.
//!
//! [`spawn`] splits once: the [`ServerRings`] is for the code that talks to the controller, the [`Handle`] for the code that
//! ends the process. Without a thread, [`link`] and [`step`] do the same on a clock of the caller. Not here:
//! motion, tags, sockets. The loop allocates nothing, takes no lock and makes no system call but its sleep (reading the
//! clock needs none). Times are nanoseconds on the monotonic clock.

#![deny(unsafe_code)]

mod clock;
mod commands;
mod contour;
mod meter;
mod rings;
mod samples;
mod schedule;
mod stops;
mod tap;
mod thread;

pub use clock::{Clock, Stepper, Steps, thread_time};
pub use commands::{COMMANDS, CommandSender, Full, STOPS};
pub use contour::Planning;
pub use meter::Meter;
pub use rings::{ACCEPTED, Answer, EVENTS, FullRings, Rings, Room, ServerRings, link, rings_with};
pub use samples::Samples;
pub use schedule::{Report, Shortfall, prepare_beside_tick};
pub use stops::Stops;
pub use tap::step_seen;
pub use thread::{Handle, Options, SpawnError, spawn, step};

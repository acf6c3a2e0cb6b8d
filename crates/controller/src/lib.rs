//! The controller: a sequence of ticks over a machine, and the memory of its tags.
//!
//! Not here: threads, real clocks, sockets, files, logs. A caller drives [`Controller::tick`] from a real-time
//! thread, or its three parts on a virtual clock.

#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod controller;
mod drives;
pub mod image;
pub mod machine;
mod overtaken;
pub mod samples;
mod snapshot;

pub use arcline_drive as drive;
pub use arcline_motion::{
    AcceptedMove, AxisSnapshot, CONTROL_SLOTS, CallData, Cause, ContourRequest, ContourRests, Event, FaultChange,
    Input, InstructionWrite, Path, Point, RefusedCommand, SystemSnapshot, Ticket, Trajectory, UNNAMED, WrittenValues,
};
pub use controller::{
    Command, Controller, MAX_COMMANDS_PER_TICK, Overtaking, PlannedContour, Port, Series, StopRequest,
};
pub use drives::simulated;
pub use snapshot::Snapshot;

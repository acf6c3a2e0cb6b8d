//! Motion instructions as a Logix-like controller executes them: axes, coordinate systems, the life of every
//! instruction and every status bit, tick by tick.
//!
//! [`Motion::begin`] advances the motion to the next tick, [`Motion::execute`] executes an instruction at that tick, and [`Motion::finish`]
//! ends the tick. Not here: threads, clocks, rings, tag memory, names (a call holds indices), logs. Nothing allocates after
//! [`Motion::new`]; the work of a tick is bounded by the machine's description.
//!
//! Source: spec/coordinated-instructions.md and spec/axis-and-data-types.md; sections are named where used.

#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod axes;
mod axis;
mod call_data;
mod cause;
mod contour;
mod control;
mod dynamics;
mod events;
mod execution;
mod feed_override;
mod instructions;
pub mod machine;
mod masters;
mod motion;
mod order;
mod output;
mod path_data;
mod range;
mod rotary;
mod settings;
mod snapshot;
mod status;
mod stop;
mod system;
mod tolerance;
mod transforms;
mod verify;

pub use arcline_cam as cam;
pub use arcline_contour::Trajectory;
pub use arcline_planner::ContourRests;
pub use arcline_planner::geometry::{Path, Point};
pub use call_data::{Calculation, CallData, Frame, Frames, Results};
pub use cause::{Cause, FaultChange, RefusedCommand};
pub use contour::ContourRequest;
pub use control::{CONTROL_SLOTS, Event, UNNAMED};
pub use events::{InstructionWrite, WrittenValues};
pub use execution::Ticket;
pub use feed_override::MAX_OVERRIDE;
pub use motion::{AcceptedMove, Input, Motion};
pub use output::{BitCompensation, CamElement, MAX_OUTPUT_ELEMENTS, OUTPUT_BITS, OutputCam, OutputCamError};
pub use path_data::{DynamicsData, PathData, PathMove};
pub use snapshot::{AxisSnapshot, SystemSnapshot};
pub use stop::AxisSet;

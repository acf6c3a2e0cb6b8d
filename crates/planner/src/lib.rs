//! Paths with profiles: the motion of a coordinate system at any instant.
//!
//! A [`Move`] is a geometric path with the limits of its speed along it, and perhaps a rotation of the orientation. A [`Planner`] holds the
//! active move and the pending ones behind it, and evaluates the active one in closed form: nothing is integrated from tick to tick, so the
//! trajectory is the same at every update period (spec/motion-core.md §1, §12). `junction` describes the junction of two moves, `hand_over`
//! the change from one to the next, `queue` the speeds that the queue permits, `change` all changes, and `merge` a merge. A [`ContourQueue`]
//! has moves that are planned as one curve outside of the tick. [`Travel`] is the common interface to both.
//!
//! Not here: instructions, status bits, axes, drives, and the order of a tick. Units:
//! position units, seconds; master units in place of seconds for moves that are functions of a master's displacement
//! ([`Parameter`]). Nothing here allocates after [`Planner::new`].

#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod change;
mod clock;
mod contour;
mod corners;
mod course;
mod hand_over;
mod junction;
mod look_ahead;
mod merge;
mod merge_within;
mod move_event;
mod move_trajectory;
mod path_with_residual;
mod planner;
mod queue;
mod ramp_out;
mod rotation_residual;
mod running;
mod stopping;
mod tolerance;
mod travel;

pub use clock::{Clock, Instant, MasterMotion, MasterRate, TimeBase};
pub use contour::{
    Continues, ContourBatch, ContourEvent, ContourQueue, ContourRests, ContourStopping, Extension, InstalledPlan,
};
pub use course::Course;
pub use junction::Ending;
pub use move_event::{EventTime, MoveEvent};
pub use move_trajectory::Sample;
pub use planner::{Planner, QueueFull};
pub use rotation_residual::{AngularState, RotationResidual};
pub use running::{InitialMotion, Move, Parameter, Running};
pub use stopping::Stopping;
pub use tolerance::SAME_INSTANT_S;
pub use travel::{PathStopping, Travel};

pub use arcline_geometry as geometry;
pub use arcline_profile as profile;

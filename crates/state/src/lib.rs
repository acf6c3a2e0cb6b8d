//! The retained state: the data that a machine retains over a restart, in a file that survives the death of its writer, and of the system, at
//! any instant.
//!
//! One file holds a whole [`RetainedState`] and behind it the later changes, each in a [`Record`] with a checksum. A record is part of one `write`, so
//! the file has it before the writer answers, and the end of the process cannot remove it. A record that the end of the process cut off was
//! never answered. The [`Writer`] synchronises the file from time to time and notes in it the length that the disk has (the horizon), so that a
//! reader distinguishes the remains of a crash of the system behind that point from damage before it. When the file has grown, the writer
//! writes the state anew beside it, synchronises that file and renames it over the old one. A file that is not whole in any other way is
//! [`Damage`], and its reader never guesses.
//!
//! Not here: machines, tags and ticks (names and types are text, values bytes), threads, clocks and logs. Positions are in
//! position units of their axis.

#![forbid(unsafe_code)]

mod codec;
mod damage;
mod disk;
mod format;
mod horizon;
mod locked_file;
#[doc(hidden)]
pub mod planted;
#[cfg(any(test, feature = "recording"))]
pub mod recording;
mod state;
mod store;
#[cfg(test)]
mod tests;
mod writer;

pub use codec::Record;
pub use damage::{Damage, Limit};
pub use disk::{Disk, OpenError, System};
pub use format::{FORMAT, FileContents, MAX_FILE, parse};
pub use locked_file::{LockedFile, ReadError};
pub use state::{Axis, AxisState, Change, MAX_AXES, MAX_TAG_BYTES, MAX_TAGS, MAX_TEXT, MAX_TOTAL, RetainedState, Tag};
pub use writer::{Action, Ended, Failure, NotPersisted, Pace, Report, Task, Writer};

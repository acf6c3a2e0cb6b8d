//! The retained state: what a machine keeps over a restart, as a file that survives the death of its writer at any
//! instant.
//!
//! One file holds a whole [`State`] and behind it the changes since, each in a record with a checksum. A change is one
//! record and one `write`, so it is there when the call returns, whatever then becomes of the process; a record that the
//! end of the process cut off never counted. When the changes have grown, the state is written anew beside the file,
//! synchronised and renamed over it ([`Store`]). A file that is not whole in any other way is [`Damage`], and its
//! reader never guesses.
//!
//! Not here: machines, tags and ticks (names and types are text, values bytes), threads, clocks and logs. Positions are in
//! position units of their axis.

#![forbid(unsafe_code)]

mod codec;
mod damage;
mod format;
mod state;
mod store;
#[cfg(test)]
mod tests;

pub use damage::{Damage, Limit};
pub use format::{FORMAT, Kept, MAX_FILE, parse};
pub use state::{Axis, AxisState, Change, MAX_AXES, MAX_TAG_BYTES, MAX_TAGS, MAX_TEXT, MAX_TOTAL, State, Tag};
pub use store::{OpenError, Place, ReadError, Store};

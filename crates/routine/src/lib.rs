//! Routines of a Logix project (spec/programs.md): ladder, Structured Text and add-on instructions.
//!
//! Text in: [`Rung`], [`Text`] and [`Expression`] are parsed with their places and print as they were. [`load`] compiles a
//! [`source::Project`] to a [`Cell`]: every name is resolved to bytes of one memory, and all that does not run is a
//! [`Finding`]. [`Cell::tick`] scans the tasks that are due; instructions of motion go to a [`Host`].
//!
//! Not here: files, XML, clocks, motion itself, the network. Scans allocate nothing. Times are in ns of virtual time.
#![forbid(unsafe_code)]
#![warn(clippy::disallowed_methods)]

mod cell;
mod code;
mod compile;
mod docs;
mod error;
mod expression;
mod lexer;
mod listing;
mod memory;
mod monitor;
mod no_machine;
mod readers;
pub mod rll;
mod run;
pub mod source;
pub mod st;
mod steps;
mod table;
mod types;

pub use cell::{Cell, Condition, Loaded, Names, Writes, load};
pub use compile::Directory;
pub use docs::ladder_page;
pub use error::{Finding, FindingKind, Line, SyntaxError};
pub use expression::{Binary, Expression, MAX_DEPTH, MAX_TEXT, Step, TagReference, Unary};
pub use listing::{Language, ListedElement, ListedLine, ListedOperand, ListedRoutine, ListedRung, Listing, Use};
pub use memory::Tag;
pub use monitor::{Monitor, MonitorSample, MonitoredValue};
pub use no_machine::NoMachine;
pub use rll::Rung;
pub use run::{Fault, Host, Memory, Pace};
pub use st::Text;

/// Stack of a thread that loads or scans a project, bytes: routines call one another, and expressions are deep.
pub const STACK: usize = 256 << 20;

#[cfg(test)]
mod tests;

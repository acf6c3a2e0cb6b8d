//! Imports, exports, and one after the other.

mod modules;
mod partial;
mod reading;
mod round_trip;

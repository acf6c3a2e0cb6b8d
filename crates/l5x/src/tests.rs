//! Imports, exports, and one after the other.

mod partial;
mod reading;
mod round_trip;

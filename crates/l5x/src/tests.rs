//! Imports, exports, and one after the other.

mod reading;
mod round_trip;

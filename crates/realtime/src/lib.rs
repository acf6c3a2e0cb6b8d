//! arcline-realtime.

//! arcline-proto.

//! arcline-config.

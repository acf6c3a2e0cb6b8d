//! arcline-client.

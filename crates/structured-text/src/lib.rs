//! arcline-structured-text.

//! arcline-tag.

//! arcline-instruction-set.

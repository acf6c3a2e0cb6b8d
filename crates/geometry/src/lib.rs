//! arcline-geometry.

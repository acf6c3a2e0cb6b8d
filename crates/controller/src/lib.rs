//! arcline-controller.

//! arcline-planner.

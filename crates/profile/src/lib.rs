//! arcline-profile.

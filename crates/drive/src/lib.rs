//! arcline-drive.

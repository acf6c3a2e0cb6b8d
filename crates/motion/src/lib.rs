//! arcline-motion.

pub mod machine;

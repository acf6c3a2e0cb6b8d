//! arcline-motion.

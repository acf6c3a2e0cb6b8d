//! The crate of the simulation's tests: the whole server on one thread, `cargo test -p arcline-sim`.

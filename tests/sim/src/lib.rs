//! Nothing but tests: the whole server on one thread, `cargo test -p arcline-sim`.

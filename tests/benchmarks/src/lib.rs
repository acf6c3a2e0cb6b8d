//! The crate of the benchmarks: `cargo bench -p arcline-benchmarks`.

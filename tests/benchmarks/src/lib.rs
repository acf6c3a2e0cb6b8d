//! Nothing but benchmarks: `cargo bench -p arcline-benchmarks`.

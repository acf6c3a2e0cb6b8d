//! Random programs, each a Structured Text program that its seed reproduces and that is printed when it fails.
//!
//! [`arcline_tests::random::seeds`] says how many a run takes: a tenth in a plain `cargo test`, all in `.ci/run campaigns`, 100,000 in
//! `tests/nightly`.

mod dynamics;
mod machine;
mod robots;
mod sequences;
mod streams;

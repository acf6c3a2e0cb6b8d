//! Tests that no single crate can hold.

pub mod bench;

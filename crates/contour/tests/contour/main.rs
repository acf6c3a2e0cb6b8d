//! Plans of random reference paths, at once and extended while they run.

mod common;
mod extend;
mod properties;
mod straightness;
mod streams;

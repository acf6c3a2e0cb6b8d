//! Transforms: pairs of coordinate systems that lead each other (spec/coordinated-instructions.md §19, §20).
//!
//! What a transform makes of positions is in [`robot`] and [`transform`], what it makes of the axes in [`compute`]; whether a robot
//! can follow in [`reach`], [`ahead`] and [`guard`]. Nothing allocates.

pub(crate) mod ahead;
mod cancel;
mod compute;
mod failing;
mod guard;
pub(crate) mod reach;
pub(crate) mod robot;
pub(crate) mod shown;
pub(crate) mod transform;

pub(crate) use cancel::Release;

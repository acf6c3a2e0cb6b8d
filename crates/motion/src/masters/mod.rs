//! Motions that are functions of a master axis: gears, cams, and moves that a link to a master drives.
//!
//! A follower is computed behind its master in the same tick (`crate::order`). Nothing allocates.

pub(crate) mod cam;
pub(crate) mod displacement;
pub(crate) mod follower;
pub(crate) mod gear;
pub(crate) mod link_numbers;
pub(crate) mod links;
pub(crate) mod master;

use arcline_instruction_set::enumerations::Reference;
use arcline_profile::KinematicState;

/// A master at the present tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MasterAt {
    /// Its motion, without the offset that its position was redefined by.
    pub(crate) point: KinematicState,
    /// The position that was read: command or actual.
    pub(crate) read: Reference,
    /// The offset of redefined positions: the position that the axis shows minus the one in `point`.
    pub(crate) redefined: f64,
}

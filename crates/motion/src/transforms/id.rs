//! The identity of a transform.

use crate::machine::MAX_SYSTEMS;

/// A transform, by the index of its target system: a coordinate system is the target of one transform at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TransformId(u8);

impl TransformId {
    /// The transform of a target system, by the index of that in the machine.
    pub(crate) fn of_target(system: usize) -> Self {
        const { assert!(MAX_SYSTEMS <= 64) };
        TransformId(system as u8)
    }

    /// The index of the target system.
    pub(crate) fn target_system(self) -> usize {
        usize::from(self.0)
    }

    /// The transform's bit in a set of transforms.
    pub(super) fn bit(self) -> u64 {
        1 << self.0
    }
}

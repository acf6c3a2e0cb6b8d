//! The identity of a transform.

use crate::machine::MAX_SYSTEMS;
use arcline_instruction_set::SystemId;

/// A transform, by the index of its target system: a coordinate system is the target of one transform at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TransformId(u8);

impl TransformId {
    /// The transform of a target system, by the index of that in the machine.
    pub(crate) fn of_target(system: SystemId) -> Self {
        const { assert!(MAX_SYSTEMS <= 64) };
        TransformId(system.0 as u8)
    }

    /// Index among all coordinate systems.
    pub(crate) fn index(self) -> usize {
        usize::from(self.0)
    }

    /// The target system.
    pub(crate) fn target_system(self) -> SystemId {
        SystemId(u16::from(self.0))
    }

    /// The transform's bit in a set of transforms.
    pub(super) fn bit(self) -> u64 {
        1 << self.0
    }
}

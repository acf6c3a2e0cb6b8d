//! An active stop of a coordinate system (MCS).

use crate::execution::Execution;
use crate::machine::MAX_AXES;
use arcline_instruction_set::AxisId;

/// A running stop, and the axes that it waits for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    pub(crate) execution: Execution,
    /// The stop includes coordinated moves (all Stop Types but Coordinated Transform): no move begins meanwhile.
    pub(crate) of_moves: bool,
    /// Axes that brake separately (Stop Types All and Coordinated Transform).
    pub(crate) braking: AxisSet,
}

/// A set of axes of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxisSet([u64; MAX_AXES / 64]);

impl AxisSet {
    /// Adds an axis.
    pub fn insert(&mut self, axis: AxisId) {
        if let Some(word) = self.0.get_mut(usize::from(axis.0 / 64)) {
            *word |= 1 << (axis.0 % 64);
        }
    }

    /// Adds all of some axes if the set contains one of them.
    pub(crate) fn join(&mut self, axes: &[AxisId]) {
        if axes.iter().any(|axis| self.contains(*axis)) {
            axes.iter().for_each(|axis| self.insert(*axis));
        }
    }

    pub(crate) fn extend(&mut self, other: AxisSet) {
        for (word, more) in self.0.iter_mut().zip(other.0) {
            *word |= more;
        }
    }

    /// The set contains an axis.
    pub fn contains(&self, axis: AxisId) -> bool {
        self.0
            .get(usize::from(axis.0 / 64))
            .is_some_and(|word| word & (1 << (axis.0 % 64)) != 0)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.iter().all(|word| *word == 0)
    }
}

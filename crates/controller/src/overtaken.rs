//! What stops have overtaken.
//!
//! A stop that comes ahead of commands that were sent before it ([`crate::Overtaking`]) must not be undone by them: such a command is
//! refused if it would begin motion of an axis of the stop, or switch that axis on. Not here: the order itself, which is that of the
//! port.

use arcline_instruction_set::{AxisId, Call};
use arcline_motion::AxisSet;

use crate::machine::MAX_AXES;

/// For each axis, how many commands were sent before the newest stop that came ahead of some of them.
#[derive(Clone, Debug)]
pub(crate) struct Overtaken {
    before: [u64; MAX_AXES],
    /// The largest of them.
    newest: u64,
}

impl Default for Overtaken {
    fn default() -> Self {
        Overtaken {
            before: [0; MAX_AXES],
            newest: 0,
        }
    }
}

impl Overtaken {
    /// A stop of some axes came ahead of commands; so many were sent before it. Real-time.
    pub(crate) fn note(&mut self, axes: AxisSet, sent_before: u64) {
        // Stops come in the order in which they were sent.
        self.newest = sent_before;
        for (axis, before) in self.before.iter_mut().enumerate() {
            if axes.contains(AxisId::from_index(axis)) {
                *before = sent_before;
            }
        }
    }

    /// Whether a call before which so many commands were taken is refused: one of its axes was stopped since it was sent. Real-time.
    pub(crate) fn refuses(&self, call: &Call, taken_before: u64, axes: impl FnOnce() -> AxisSet) -> bool {
        if self.newest <= taken_before || !(call.mnemonic.begins_motion() || call.mnemonic.switches_on()) {
            return false;
        }
        let axes = axes();
        let mut before = self.before.iter().enumerate();
        before.any(|(axis, before)| *before > taken_before && axes.contains(AxisId::from_index(axis)))
    }
}

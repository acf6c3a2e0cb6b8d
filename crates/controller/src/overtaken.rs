//! Commands that a stop has overtaken.
//!
//! Commands sent before an overtaking stop ([`crate::Overtaking`]) must not undo it: the controller refuses such a command if it would begin
//! motion of an axis of the stop, or switch that axis on. Not here: the order itself, which the port determines.

use arcline_instruction_set::{AxisId, Call};
use arcline_motion::AxisSet;

use crate::machine::MAX_AXES;

/// For each axis, the number of commands sent before the newest overtaking stop.
#[derive(Clone, Debug)]
pub(crate) struct Overtaken {
    before: [u64; MAX_AXES],
    /// The largest of these numbers.
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
    /// Records an overtaking stop of some axes; `sent_before`: the number of commands sent before it. Real-time.
    pub(crate) fn note(&mut self, axes: AxisSet, sent_before: u64) {
        // Stops arrive in the order in which they were sent.
        self.newest = sent_before;
        for (axis, before) in self.before.iter_mut().enumerate() {
            if axes.contains(AxisId::from_index(axis)) {
                *before = sent_before;
            }
        }
    }

    /// A call is refused: a stop of one of its axes was sent after it. `taken_before`: the number of commands taken before the call. Real-time.
    pub(crate) fn refuses(&self, call: &Call, taken_before: u64, axes: impl FnOnce() -> AxisSet) -> bool {
        if self.newest <= taken_before || !(call.mnemonic.begins_motion() || call.mnemonic.switches_on()) {
            return false;
        }
        let axes = axes();
        let mut before = self.before.iter().enumerate();
        before.any(|(axis, before)| *before > taken_before && axes.contains(AxisId::from_index(axis)))
    }
}

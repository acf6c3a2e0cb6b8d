//! Wires between tags and axes (spec/programs.md §15). A wire of a tag passes its value before the first rung of a tick, one of an axis
//! behind the last one. Its delay is that of a filter: a value passes after it has been present for that time.

use super::{ExecutionState, Scan};
use crate::code::{Code, End, FixedBit};

/// The state of a wire.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Signal {
    /// The last passed value; `None` before the first one.
    given: Option<bool>,
    /// The value at its beginning, and the time of its last change, ns.
    seen: Option<(bool, u64)>,
}

impl Signal {
    /// The value that the wire passes now.
    fn value(&mut self, is_on: bool, now: u64, delay: u64) -> bool {
        match self.seen {
            Some((before, _)) if before == is_on => {}
            _ => self.seen = Some((is_on, now)),
        }
        let Some(given) = self.given else { return is_on };
        let since = self.seen.map_or(now, |(_, since)| since);
        if now.saturating_sub(since) >= delay {
            is_on
        } else {
            given
        }
    }
}

impl ExecutionState {
    /// Forgets the values of the wires, so that each passes its present value again.
    pub(crate) fn begin_wires(&mut self) {
        self.wires.fill(Signal::default());
    }
}

impl Scan<'_> {
    /// The wires that end in tags.
    pub(crate) fn latch_inputs(&mut self, now: u64) {
        let code: &Code = self.code;
        for (number, wire) in code.wires.iter().enumerate() {
            let End::Bit(to, lost) = wire.to else { continue };
            let value = self.wire_value(number, wire.from, now, wire.delay);
            // The inputs of a module whose connection is lost keep their values.
            if lost.is_none_or(|lost| !self.has(lost.at, lost.mask)) {
                self.set(to.at, to.mask, value);
            }
        }
        if !code.wires.is_empty() {
            self.host.inputs_latched(&mut self.s.memory);
        }
    }

    /// The wires that end in inputs of axes: those that have changed.
    pub(crate) fn give_outputs(&mut self, now: u64) {
        let code: &Code = self.code;
        for (number, wire) in code.wires.iter().enumerate() {
            let End::Input(input) = wire.to else { continue };
            let before = self.s.wires.get(number).and_then(|signal| signal.given);
            let value = self.wire_value(number, wire.from, now, wire.delay);
            if before != Some(value) {
                self.host.axis_input(input, value);
            }
        }
    }

    fn wire_value(&mut self, number: usize, from: FixedBit, now: u64, delay: u64) -> bool {
        let is_on = self.has(from.at, from.mask);
        let Some(signal) = self.s.wires.get_mut(number) else {
            return is_on;
        };
        let value = signal.value(is_on, now, delay);
        signal.given = Some(value);
        value
    }
}

//! One trace: its signals, its trigger and its progress. The store has the rows themselves.

use arcline_controller::samples::Column;
use arcline_instruction_set::Mnemonic;

use super::store::Store;

/// The settings of a trace.
#[derive(Clone, PartialEq, Debug)]
pub struct Config {
    /// The signals, in order.
    pub signals: Vec<Column>,
    /// Ticks in front of the trigger.
    pub before: u32,
    /// Ticks from the trigger on; 0: until it is stopped.
    pub length: u32,
    /// Every nth tick; 1 for all.
    pub every: u16,
    /// When it begins.
    pub trigger: Trigger,
}

/// When a trace begins.
#[derive(Clone, PartialEq, Debug)]
pub enum Trigger {
    /// Now.
    None,
    /// A signal rises to a level or above.
    Rises(Column, f64),
    /// A signal falls to a level or below.
    Falls(Column, f64),
    /// A signal becomes another number than 0.
    BecomesTrue(Column),
    /// A signal becomes 0.
    BecomesFalse(Column),
    /// An instruction sets one of these flags: that of a tag, or any of a kind.
    Instruction {
        /// Name of a motion control or instruction tag, or a mnemonic.
        of: String,
        /// Bits of FLAGS.
        flags: u32,
    },
}

/// The phase of a trace.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Phase {
    /// The trace waits for its trigger.
    Armed,
    /// The trace records.
    Running,
    /// The trace has all its ticks.
    Complete,
    /// A client stopped the trace.
    Stopped,
}

/// A trace.
#[derive(Clone, Debug)]
pub(super) struct Capture {
    pub(super) config: Config,
    pub(super) phase: Phase,
    pub(super) trigger: u64,
    /// Its first tick, and the one behind its last.
    pub(super) first: u64,
    pub(super) end: u64,
    /// Ticks that the store had missed when it began.
    missing_before: u64,
    /// Whether the condition of the trigger held at the tick before `watched`; `None`: not known.
    held: Option<bool>,
    /// The next tick to evaluate.
    watched: u64,
}

impl Capture {
    pub(super) fn new(config: Config, store: &Store) -> Self {
        let mut capture = Capture {
            config,
            phase: Phase::Armed,
            trigger: 0,
            first: 0,
            end: 0,
            missing_before: 0,
            held: None,
            watched: 0,
        };
        capture.arm(store);
        capture
    }

    /// Waits for the trigger, from now on.
    pub(super) fn arm(&mut self, store: &Store) {
        self.phase = Phase::Armed;
        (self.trigger, self.first, self.end) = (0, 0, 0);
        self.held = None;
        self.watched = store.next().unwrap_or(0);
        self.missing_before = store.missing();
        if self.config.trigger == Trigger::None {
            self.begin(self.watched, store);
        }
    }

    pub(super) fn stop(&mut self) {
        if matches!(self.phase, Phase::Armed | Phase::Running) {
            self.phase = Phase::Stopped;
        }
    }

    /// Evaluates the rows that the store has received since the last call.
    pub(super) fn follow(&mut self, store: &Store) {
        if self.phase == Phase::Armed {
            let mut begins = None;
            for (tick, row) in store.rows_from(self.watched) {
                // The execution of an instruction shows in its event, which may come behind the rows of its tick.
                let Some(holds) = self.config.trigger.holds(row) else {
                    break;
                };
                self.watched = tick + 1;
                if self.held.replace(holds) == Some(false) && holds {
                    begins = Some(tick);
                    break;
                }
            }
            if let Some(tick) = begins {
                self.begin(tick, store);
            }
        }
        if self.phase == Phase::Running {
            let next = store.next().unwrap_or(0).max(self.first);
            self.end = next;
            if self.config.length > 0 {
                let last = self.trigger + u64::from(self.config.length);
                self.end = next.min(last);
                if next >= last {
                    self.phase = Phase::Complete;
                }
            }
        }
    }

    /// An instruction changed.
    pub(super) fn event(&mut self, tick: u64, tag: &str, mnemonic: Mnemonic, set: u32, store: &Store) {
        let Trigger::Instruction { of, flags } = &self.config.trigger else {
            return;
        };
        // A tag is named with its member or without.
        let named = of.eq_ignore_ascii_case(tag) || of.parse() == Ok(mnemonic);
        if self.phase == Phase::Armed && named && set & flags != 0 && tick >= self.watched {
            self.begin(tick, store);
        }
    }

    /// Ticks missing inside the trace.
    pub(super) fn missing(&self, store: &Store) -> u64 {
        match self.phase {
            Phase::Armed => 0,
            _ => store.missing() - self.missing_before,
        }
    }

    fn begin(&mut self, tick: u64, store: &Store) {
        self.phase = Phase::Running;
        self.trigger = tick;
        let oldest = store.first().unwrap_or(tick).min(tick);
        self.first = tick.saturating_sub(self.config.before.into()).max(oldest);
        self.end = self.first;
    }
}

impl Trigger {
    /// Whether the condition holds in a row; `None`: rows do not show the condition.
    fn holds(&self, row: &[f64]) -> Option<bool> {
        match self {
            Self::None | Self::Instruction { .. } => None,
            Self::Rises(column, level) => Some(column.of(row) >= *level),
            Self::Falls(column, level) => Some(column.of(row) <= *level),
            Self::BecomesTrue(column) => Some(column.of(row) != 0.0),
            Self::BecomesFalse(column) => Some(column.of(row) == 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAG: u32 = 0x1000_0000;

    /// A store of ticks 0 to `to` whose column 1 is the tick's distance from 50, and column 2 a word with bit 3 from 60 on.
    fn fill(store: &mut Store, to: u64) {
        for tick in store.next().unwrap_or(0)..to {
            let word = if tick >= 60 { 8.0 } else { 0.0 };
            store.append(&[tick as f64, (tick as f64 - 50.0).abs(), word]);
        }
    }

    fn config(trigger: Trigger) -> Config {
        Config {
            signals: vec![Column::Number(1)],
            before: 5,
            length: 10,
            every: 1,
            trigger,
        }
    }

    #[test]
    fn a_trace_begins_when_its_condition_becomes_true() {
        let word = Column::Number(2);
        let bit = Column::Bit { column: 2, mask: 8 };
        #[rustfmt::skip]
        let cases = [
            ("now",                      Trigger::None,                              Some(20)),
            ("falls to the level",       Trigger::Falls(Column::Number(1), 10.0),    Some(40)),
            ("rises to the level",       Trigger::Rises(Column::Number(1), 40.0),    Some(90)),
            ("above the level already",  Trigger::Rises(Column::Number(1), 20.0),    Some(70)),
            ("never reached",            Trigger::Rises(Column::Number(1), 1e6),     None),
            ("a word becomes true",      Trigger::BecomesTrue(word),                 Some(60)),
            ("a bit becomes true",       Trigger::BecomesTrue(bit),                  Some(60)),
            ("a bit becomes false",      Trigger::BecomesFalse(bit),                 None),
        ];
        for (why, trigger, expected) in cases {
            let mut store = Store::new(3, 1000);
            fill(&mut store, 20);
            let mut capture = Capture::new(config(trigger), &store);
            // In pieces of seven ticks, as they come.
            for to in (21..200).step_by(7) {
                fill(&mut store, to);
                capture.follow(&store);
            }
            let begun = (capture.phase != Phase::Armed).then_some(capture.trigger);
            assert_eq!(begun, expected, "{why}");
            if let Some(trigger) = expected {
                let shown = (capture.phase, capture.first, capture.end);
                assert_eq!(shown, (Phase::Complete, trigger - 5, trigger + 10), "{why}");
            }
        }
    }

    #[test]
    fn an_instruction_begins_a_trace() {
        #[rustfmt::skip]
        let cases = [
            ("its tag",                 "move1", 30, FLAG,       true),
            ("any of its kind",         "mclm",  30, FLAG,       true),
            ("another tag",             "Move2", 30, FLAG,       false),
            ("another kind",            "MCS",   30, FLAG,       false),
            ("another flag",            "Move1", 30, 0x8000_0000, false),
            ("before it was armed",     "Move1", 10, FLAG,       false),
        ];
        for (why, of, tick, set, expected) in cases {
            let mut store = Store::new(3, 1000);
            fill(&mut store, 20);
            let trigger = Trigger::Instruction {
                of: of.to_owned(),
                flags: FLAG,
            };
            let mut capture = Capture::new(config(trigger), &store);
            fill(&mut store, 35);
            // The rows are seen, again and again, before the event is.
            for _ in 0..40 {
                capture.follow(&store);
            }
            capture.event(tick, "Move1", Mnemonic::Mclm, set, &store);
            assert_eq!(capture.phase == Phase::Running, expected, "{why}");
            if expected {
                assert_eq!((capture.trigger, capture.first), (30, 25), "{why}");
            }
        }
    }

    #[test]
    fn dropped_rows_are_not_in_the_capture() {
        let mut store = Store::new(3, 1000);
        fill(&mut store, 3);
        let capture = Capture::new(config(Trigger::None), &store);
        assert_eq!((capture.trigger, capture.first), (3, 0));
    }

    #[test]
    fn armed_again_it_waits_again() {
        let mut store = Store::new(3, 1000);
        let mut capture = Capture::new(config(Trigger::BecomesTrue(Column::Number(2))), &store);
        fill(&mut store, 100);
        capture.follow(&store);
        assert_eq!((capture.phase, capture.trigger), (Phase::Complete, 60));
        capture.arm(&store);
        fill(&mut store, 200);
        capture.follow(&store);
        assert_eq!(capture.phase, Phase::Armed, "it is true already");
        capture.stop();
        assert_eq!(capture.phase, Phase::Stopped);
    }
}

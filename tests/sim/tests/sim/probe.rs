//! The effect of a loss of power: contents of the state file are drawn without any loss, and checked as a start would read them (W2). So a
//! scenario tries hundreds of losses, and those at the instants that matter: while the disk synchronises.

use std::path::Path;

use arcline_state::recording::{Crashes, Recording, Rules};
use arcline_state::{RetainedState, parse};
use arcline_tests::random::Random;

use crate::actors::tags::{PAIR, TAGS};
use crate::history::History;
use crate::record::Record;

/// The values of the tags whose writes are checked.
pub(crate) type Values = Vec<(&'static str, i32)>;

/// Draws contents of a file.
pub(crate) struct Probe {
    random: Random,
}

impl Probe {
    pub(crate) fn new(random: Random) -> Self {
        Probe { random }
    }

    /// Looks now and then: when a synchronisation is about to end.
    pub(crate) fn is_due(&mut self) -> bool {
        self.random.below(3) == 0
    }

    /// Checks the possible contents of the file behind the newest call. They must have all writes that were answered as persistent by `durable`.
    pub(crate) fn look(&mut self, disk: &Recording, file: &Path, history: &History, durable: u64, record: &Record) {
        record.sometimes("what a power loss would leave is judged");
        disk.with_calls(|calls| {
            let behind = Crashes::behind(calls, file);
            for rules in [Rules::Ordered, Rules::Weak] {
                let random = &mut |below| self.random.below(below as u64) as usize;
                behind.each(rules, CONTENTS, random, &mut |content| {
                    judge(content, rules, history, durable, record);
                });
            }
        });
    }
}

/// Judges one content.
fn judge(content: Option<&[u8]>, rules: Rules, history: &History, durable: u64, record: &Record) {
    // Without a file the machine starts from its configuration.
    let state = match content.map(parse) {
        None => RetainedState::default(),
        Some(Ok(kept)) => kept.state,
        Some(Err(damage)) => {
            let why = format!("a loss of power ({rules:?}) would set the file aside: {damage}");
            return record.violated("W2", &why);
        }
    };
    let values = values_of(&state);
    for wrong in history.lost(&values, durable) {
        record.broken(format!("{wrong} (after a loss of power now, {rules:?})"));
    }
    judge_pair(&values, record);
}

/// The file has a message that writes two tags as a whole or not at all.
pub(crate) fn judge_pair(values: &Values, record: &Record) {
    let of = |tag| values.iter().find(|(name, _)| *name == tag).map(|(_, value)| *value);
    if of(PAIR[0]) != of(PAIR[1]) {
        record.violated("W2", "a message that writes two tags was kept half");
    }
}

fn values_of(state: &RetainedState) -> Values {
    let value = |name: &'static str| {
        let tag = state.tags.iter().find(|tag| tag.name == name);
        let bytes = tag.and_then(|tag| tag.bytes.first_chunk().copied());
        (name, bytes.map_or(0, i32::from_le_bytes))
    };
    TAGS.into_iter().chain(PAIR).map(value).collect()
}

/// The number of contents to check by each set of rules, of each file that the name may point at; all contents if there are no more.
const CONTENTS: usize = 8;

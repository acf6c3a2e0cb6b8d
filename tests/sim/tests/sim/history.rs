//! The writes and reads of clients, and whether a register could have these values: W1 to W3 of the invariants.
//!
//! All rules are about the messages of clients: the order of requests and answers, not the code of the server. Each write has a value of its
//! own, so a read names its write. The check is the one of Gibbons and Korach (1997) for registers with unique values, O(n log n).

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard};

use crate::record::lock;

/// The reads and writes of a scenario. Clones are the same ones.
#[derive(Clone, Default)]
pub(crate) struct History(Arc<Mutex<Inner>>);

#[derive(Default)]
struct Inner {
    clock: u64,
    /// When the server has started.
    started: u64,
    /// The value of each tag when the server started.
    initial: BTreeMap<&'static str, i32>,
    /// Values from before that start, which a loss of power may bring back: the start could not write them anew.
    older: BTreeMap<&'static str, BTreeSet<i32>>,
    writes: BTreeMap<&'static str, BTreeMap<i32, Write>>,
    reads: BTreeMap<&'static str, Vec<Read>>,
    /// Values of refused writes: no read may show them.
    refused: BTreeSet<i32>,
}

#[derive(Clone, Copy, Debug)]
struct Write {
    asked: u64,
    /// `u64::MAX`: there was no answer.
    answered: u64,
    /// The server has answered that the file has the value.
    persistent: bool,
}

#[derive(Clone, Copy, Debug)]
struct Read {
    value: i32,
    asked: u64,
    answered: u64,
}

/// The answer to a write.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum WriteAnswer {
    /// Success.
    Persistent,
    /// 0x19: the tag has the value, and a restart may lose it.
    NotPersistent,
    /// Another error: nothing has changed.
    Refused,
}

/// The writes of a start with the values that it found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Wrote {
    /// The values are in a new file, which the disk has.
    Anew,
    /// The disk failed: it has the earlier file.
    Nothing,
}

impl History {
    /// The present; later calls are later.
    pub(crate) fn clock(&self) -> u64 {
        let mut inner = self.lock();
        inner.clock += 1;
        inner.clock
    }

    /// A client sends a write.
    pub(crate) fn asks(&self, tag: &'static str, value: i32) {
        let asked = self.clock();
        let write = Write {
            asked,
            answered: u64::MAX,
            persistent: false,
        };
        self.lock().writes.entry(tag).or_default().insert(value, write);
    }

    /// Whether the write has an answer.
    pub(crate) fn has(&self, tag: &'static str, value: i32, answer: WriteAnswer) {
        let answered = self.clock();
        let mut inner = self.lock();
        let writes = inner.writes.entry(tag).or_default();
        if answer == WriteAnswer::Refused {
            writes.remove(&value);
            inner.refused.insert(value);
        } else if let Some(write) = writes.get_mut(&value) {
            write.answered = answered;
            write.persistent = answer == WriteAnswer::Persistent;
        }
    }

    /// A client has read a value that it asked for at a time. An answer of the server before this one, which the network held
    /// back, is not judged.
    pub(crate) fn read(&self, tag: &'static str, value: i32, asked: u64) {
        let answered = self.clock();
        let mut inner = self.lock();
        if asked > inner.started {
            inner
                .reads
                .entry(tag)
                .or_default()
                .push(Read { value, asked, answered });
        }
    }

    /// A server has started and shows these values: the first one, or one that reads the file of another. All writes that were answered
    /// as persistent by `durable` must be there. `wrote`: whether the start has put the values on the disk.
    pub(crate) fn start(&self, values: &[(&'static str, i32)], durable: u64, wrote: Wrote) -> Vec<String> {
        let mut wrong = self.check();
        let mut inner = self.lock();
        if !inner.initial.is_empty() {
            wrong.extend(inner.lost(values, durable));
        }
        let initial = std::mem::replace(&mut inner.initial, values.iter().copied().collect());
        let writes = std::mem::take(&mut inner.writes);
        inner.reads.clear();
        inner.clock += 1;
        inner.started = inner.clock;
        match wrote {
            Wrote::Anew => inner.older.clear(),
            Wrote::Nothing => {
                for (tag, value) in initial {
                    inner.older.entry(tag).or_default().insert(value);
                }
                for (tag, writes) in writes {
                    inner.older.entry(tag).or_default().extend(writes.into_keys());
                }
            }
        }
        wrong
    }

    /// Writes that had to be there if the server started now with these values, and would not be.
    pub(crate) fn lost(&self, values: &[(&'static str, i32)], durable: u64) -> Vec<String> {
        self.lock().lost(values, durable)
    }

    /// The reads that no register could have shown since the start of the server.
    pub(crate) fn check(&self) -> Vec<String> {
        let inner = self.lock();
        let mut wrong = Vec::new();
        for (tag, reads) in &inner.reads {
            let none = BTreeMap::new();
            let writes = inner.writes.get(tag).unwrap_or(&none);
            let initial = inner.initial.get(tag).copied().unwrap_or_default();
            wrong.extend(check_register(tag, initial, writes, reads, &inner.refused));
        }
        wrong
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        lock(&self.0)
    }
}

impl Inner {
    /// Writes that had to be there after a restart, and are not (W2).
    fn lost(&self, values: &[(&'static str, i32)], durable: u64) -> Vec<String> {
        let mut wrong = Vec::new();
        // When the write of each recovered value was asked for and answered; 0 for the value at the start before.
        let mut found = BTreeMap::new();
        for (tag, value) in values {
            let write = self.writes.get(tag).and_then(|writes| writes.get(value));
            match write {
                Some(write) => found.insert(*tag, (write.asked, write.answered)),
                None if self.initial.get(tag) == Some(value) || self.is_older(tag, *value) => {
                    found.insert(*tag, (0, 0))
                }
                None => {
                    wrong.push(format!("W2: {tag} is {value} after the restart, which no client wrote"));
                    continue;
                }
            };
        }
        let newest = found.values().map(|(asked, _)| *asked).max().unwrap_or_default();
        for (tag, (_, answered)) in &found {
            for (value, write) in self.writes.get(tag).into_iter().flatten() {
                let is_later = write.persistent && *answered < write.asked;
                if is_later && write.answered <= durable {
                    wrong.push(format!("W2: {tag} lost {value}, which was answered and had to survive"));
                } else if is_later && write.answered < newest {
                    wrong.push(format!("W2: {tag} lost {value}, though a later write is there"));
                }
            }
        }
        wrong
    }

    fn is_older(&self, tag: &str, value: i32) -> bool {
        self.older.get(tag).is_some_and(|values| values.contains(&value))
    }
}

/// All operations on one value.
struct Cluster {
    value: i32,
    /// The earliest end of one of them.
    from: u64,
    /// The latest begin of one of them.
    to: u64,
}

fn check_register(
    tag: &str,
    initial: i32,
    writes: &BTreeMap<i32, Write>,
    reads: &[Read],
    refused: &BTreeSet<i32>,
) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut clusters: BTreeMap<i32, Cluster> = BTreeMap::new();
    let mut cluster = |value, from, to| {
        let known = clusters.entry(value).or_insert(Cluster { value, from, to });
        known.from = known.from.min(from);
        known.to = known.to.max(to);
    };
    cluster(initial, 0, 0);
    for (value, write) in writes {
        if write.answered != u64::MAX || reads.iter().any(|read| read.value == *value) {
            cluster(*value, write.answered, write.asked);
        }
    }
    for read in reads {
        let write = writes.get(&read.value);
        if refused.contains(&read.value) {
            wrong.push(format!("W3: {tag} showed {}, whose write was refused", read.value));
        } else if write.is_none() && read.value != initial {
            wrong.push(format!(
                "W1: {tag} showed {}, which was not written since the start",
                read.value
            ));
        } else if write.is_some_and(|write| read.answered < write.asked) {
            wrong.push(format!("W1: {tag} showed {} before it was written", read.value));
        } else {
            cluster(read.value, read.answered, read.asked);
        }
    }
    // Each of two values certainly came before the other one, so one came back.
    let (mut forward, backward): (Vec<&Cluster>, Vec<&Cluster>) =
        clusters.values().partition(|cluster| cluster.from < cluster.to);
    forward.sort_by_key(|cluster| cluster.from);
    for pair in forward.windows(2) {
        if pair[1].from < pair[0].to {
            wrong.push(format!(
                "W1: {tag} had {} and {} at the same time",
                pair[0].value, pair[1].value
            ));
        }
    }
    for other in backward {
        let at = forward.partition_point(|cluster| cluster.from < other.to);
        if let Some(around) = at.checked_sub(1).map(|at| forward[at])
            && around.from < other.to
            && other.from < around.to
        {
            wrong.push(format!("W1: {tag} had {} while it had {}", other.value, around.value));
        }
    }
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn after_a_start_on_a_failing_disk_older_values_may_come_back() {
        let history = History::default();
        let start = |value, durable, wrote| history.start(&[("T", value)], durable, wrote);
        assert_eq!(start(0, 0, Wrote::Anew), Vec::<String>::new());
        history.asks("T", 1);
        history.has("T", 1, WriteAnswer::Persistent);
        // A kill: the system has the write, the disk does not, and the start cannot write it anew.
        assert_eq!(start(1, u64::MAX, Wrote::Nothing), Vec::<String>::new());
        // A loss of power brings back the values on the disk; values that are written anew then stay.
        assert_eq!(start(0, 0, Wrote::Anew), Vec::<String>::new());
        assert_eq!(start(1, 0, Wrote::Anew).len(), 1, "1 was not written since");
    }

    #[test]
    fn registers_are_judged_by_the_answers_to_their_clients() {
        let write = |asked, answered| Write {
            asked,
            answered,
            persistent: true,
        };
        let read = |value, asked, answered| Read { value, asked, answered };
        #[rustfmt::skip]
        let cases = [
            ("a read behind a write",           vec![(1, write(1, 2))],                    vec![read(1, 3, 4)], 0),
            ("an old value behind a write",     vec![(1, write(1, 2))],                    vec![read(0, 3, 4)], 1),
            ("either value during a write",     vec![(1, write(1, 9))],                    vec![read(0, 2, 3), read(1, 4, 5)], 0),
            ("back again during a write",       vec![(1, write(1, 9))],                    vec![read(1, 2, 3), read(0, 4, 5)], 1),
            ("a write that was never answered", vec![(1, write(1, u64::MAX))],             vec![read(0, 2, 3), read(1, 4, 5)], 0),
            ("a write that was overwritten",    vec![(1, write(1, 2)), (2, write(3, 4))],  vec![read(1, 5, 6)], 1),
            ("two writes in any order",         vec![(1, write(1, 8)), (2, write(2, 7))],  vec![read(1, 9, 10), read(1, 11, 12)], 0),
            ("two writes in both orders",       vec![(1, write(1, 8)), (2, write(2, 7))],  vec![read(1, 9, 10), read(2, 11, 12), read(1, 13, 14)], 1),
            ("a value of nobody",               vec![],                                    vec![read(5, 1, 2)], 1),
        ];
        for (why, writes, reads, wrong) in cases {
            let writes = writes.into_iter().collect();
            let found = check_register("T", 0, &writes, &reads, &BTreeSet::new());
            assert_eq!(usize::from(!found.is_empty()), wrong, "{why}: {found:?}");
        }
    }
}

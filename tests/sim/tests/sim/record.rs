//! The observations of a scenario: a log whose hash is compared between two runs of a seed, and the interesting states that were reached.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The record of a scenario. Clones are the same one.
#[derive(Clone, Default)]
pub(crate) struct Record(Arc<Mutex<Inner>>);

#[derive(Default)]
struct Inner {
    now: u64,
    hash: Fnv,
    newest: VecDeque<String>,
    all: Option<Vec<String>>,
    /// The hash of the client's messages, by actor.
    seen: BTreeMap<&'static str, Fnv>,
    violations: Vec<String>,
    reached: BTreeMap<&'static str, u64>,
}

/// FNV-1a, 64 bits.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Fnv(pub(crate) u64);

impl Default for Fnv {
    fn default() -> Self {
        Fnv(0xCBF2_9CE4_8422_2325)
    }
}

impl Fnv {
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }
}

impl Record {
    /// Makes a record with every line of the log, to compare two runs.
    pub(crate) fn with_lines() -> Self {
        let record = Record::default();
        record.lock().all = Some(Vec::new());
        record
    }

    pub(crate) fn begin(&self, now: u64) {
        self.lock().now = now;
    }

    pub(crate) fn now(&self) -> u64 {
        self.lock().now
    }

    /// Notes an event.
    pub(crate) fn note(&self, actor: &str, event: &str) {
        let mut inner = self.lock();
        let line = format!("{:6} {actor}: {event}", inner.now);
        inner.hash.add(line.as_bytes());
        if let Some(all) = &mut inner.all {
            all.push(line.clone());
        }
        if inner.newest.len() == LINES {
            inner.newest.pop_front();
        }
        inner.newest.push_back(line);
    }

    /// Adds bytes to the hash without a line.
    pub(crate) fn mix(&self, bytes: &[u8]) {
        self.lock().hash.add(bytes);
    }

    /// Adds bytes that the client of an actor received.
    pub(crate) fn saw(&self, actor: &'static str, bytes: &[u8]) {
        let mut inner = self.lock();
        let now = inner.now;
        let seen = inner.seen.entry(actor).or_default();
        seen.add(&now.to_le_bytes());
        seen.add(bytes);
        inner.hash.add(bytes);
        if let Some(all) = &mut inner.all {
            all.push(format!("{now:6} {actor} saw {bytes:02X?}"));
        }
    }

    /// An invariant does not hold.
    pub(crate) fn violated(&self, invariant: &str, why: &str) {
        self.broken(format!("{invariant}: {why}"));
    }

    /// The same, in one text that begins with the invariant.
    pub(crate) fn broken(&self, line: String) {
        self.note("VIOLATION", &line);
        self.lock().violations.push(line);
    }

    /// An interesting state was reached.
    pub(crate) fn sometimes(&self, state: &'static str) {
        *self.lock().reached.entry(state).or_default() += 1;
    }

    pub(crate) fn hash(&self) -> u64 {
        self.lock().hash.0
    }

    /// The hashes of the messages of the clients.
    pub(crate) fn seen(&self) -> BTreeMap<&'static str, Fnv> {
        self.lock().seen.clone()
    }

    pub(crate) fn violations(&self) -> Vec<String> {
        self.lock().violations.clone()
    }

    pub(crate) fn is_violated(&self) -> bool {
        !self.lock().violations.is_empty()
    }

    pub(crate) fn reached(&self) -> BTreeMap<&'static str, u64> {
        self.lock().reached.clone()
    }

    /// The newest lines, or all that were asked for.
    pub(crate) fn lines(&self) -> Vec<String> {
        let inner = self.lock();
        match &inner.all {
            Some(all) => all.clone(),
            None => inner.newest.iter().cloned().collect(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        lock(&self.0)
    }
}

/// Locks the state that the actors and the world share; the panic of one of them is a violation of its own.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Lines of the log that a failure shows.
const LINES: usize = 200;

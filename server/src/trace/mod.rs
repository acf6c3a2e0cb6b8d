//! The samples of the newest ticks, and traces of them (docs/TRACE.md).
//!
//! A thread of its own takes the rows out of the real-time thread's ring; readers of the trace do too, so that no reader waits for that
//! thread. The lock is held for as long as a block of rows is copied. The tick has no part in it.

mod capture;
pub(crate) mod history;
mod store;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use arcline_controller::machine::Machine;
use arcline_controller::samples::{self, Column};
use arcline_instruction_set::Mnemonic;
use arcline_realtime::Samples;
use tokio::time::Instant;

pub use capture::{Config, Phase, Trigger};

use capture::Capture;
use history::History;
use store::Store;

/// The rows of a machine and the traces of them. Clones are the same ones.
#[derive(Clone, Debug)]
pub struct Trace(Arc<Mutex<Inner>>);

#[derive(Debug)]
struct Inner {
    samples: Option<Samples>,
    store: Store,
    history: History,
    captures: BTreeMap<u32, Used>,
    newest: u32,
}

#[derive(Debug)]
struct Used {
    capture: Capture,
    /// The time of the last request for it.
    at: Instant,
}

/// The ticks whose rows the store has.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct StoredTicks {
    /// The oldest tick.
    pub first: u64,
    /// The tick behind the newest.
    pub next: u64,
    /// The number of ticks that it can have.
    pub capacity: u64,
    /// Ticks that were never recorded.
    pub missing: u64,
}

/// The state of a trace.
#[derive(Clone, PartialEq, Debug)]
pub struct TraceStatus {
    /// The phase.
    pub phase: Phase,
    /// The tick of its trigger; 0 while armed.
    pub trigger: u64,
    /// Its first tick; 0 while armed.
    pub first: u64,
    /// The tick behind its newest.
    pub next: u64,
    /// Signals.
    pub signals: usize,
    /// Every nth tick.
    pub every: u16,
    /// Ticks that are missing.
    pub missing: u64,
}

/// Rows of a trace, without a gap.
#[derive(Clone, PartialEq, Debug)]
pub struct Block {
    /// The state of the trace.
    pub standing: TraceStatus,
    /// The tick of the first row; without rows where to ask next.
    pub first: u64,
    /// Rows.
    pub rows: usize,
    /// The rows, one after the other.
    pub values: Vec<f64>,
}

/// A piece of the past.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Past {
    /// The tick of its first row.
    pub(crate) first: u64,
    /// Ticks of a row.
    pub(crate) every: u64,
    pub(crate) signals: usize,
    /// Numbers of each signal in a row: 1, or [`history::OF_SIGNAL`].
    pub(crate) of_signal: usize,
    /// The values row by row; empty if the store has none.
    pub(crate) values: Vec<f64>,
}

/// There are as many traces as there may be.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("there are {TRACES} traces already")]
pub struct NoRoom;

impl Trace {
    /// Stores the rows of a ring.
    pub(crate) fn new(machine: &Machine, samples: Option<Samples>) -> Self {
        let width = samples::width(machine);
        let rows = (KEPT.as_nanos() as u64 / machine.period_ns.max(1)) as usize;
        let rows = rows.min(KEPT_BYTES / (width * size_of::<f64>()));
        Trace(Arc::new(Mutex::new(Inner {
            samples,
            store: Store::new(width, rows),
            history: History::new(machine),
            captures: BTreeMap::new(),
            newest: 0,
        })))
    }

    /// Starts the thread that takes the rows; it ends when the last handle of the trace is dropped.
    pub(crate) fn spawn(&self) -> std::io::Result<()> {
        let trace = Arc::downgrade(&self.0);
        let run = move || {
            while let Some(inner) = Weak::upgrade(&trace) {
                lock(&inner).refresh();
                drop(inner);
                std::thread::sleep(PAUSE);
            }
        };
        std::thread::Builder::new()
            .name("arcline-trace".to_owned())
            .spawn(run)
            .map(drop)
    }

    /// Makes one turn of that thread.
    pub(crate) fn step(&self) {
        lock(&self.0).refresh();
    }

    /// The ticks whose rows the store has.
    pub fn stored_ticks(&self) -> StoredTicks {
        let mut inner = lock(&self.0);
        inner.refresh();
        let store = &inner.store;
        StoredTicks {
            first: store.first().unwrap_or(0),
            next: store.next().unwrap_or(0),
            capacity: store.most() as u64,
            missing: store.missing(),
        }
    }

    /// Makes a trace and arms it.
    ///
    /// # Errors
    /// There are too many.
    pub fn create(&self, config: Config) -> Result<u32, NoRoom> {
        let mut inner = lock(&self.0);
        inner.refresh();
        inner.captures.retain(|_, used| used.at.elapsed() < IDLE);
        if inner.captures.len() >= TRACES {
            return Err(NoRoom);
        }
        let most = inner.store.most() as u32 / 2;
        let config = Config {
            before: config.before.min(most),
            every: config.every.max(1),
            ..config
        };
        // Never 0, never one that is there.
        let next = |instance: u32| instance.wrapping_add(1).max(1);
        let mut instance = next(inner.newest);
        while inner.captures.contains_key(&instance) {
            instance = next(instance);
        }
        inner.newest = instance;
        let capture = Capture::new(config, &inner.store);
        let at = Instant::now();
        inner.captures.insert(instance, Used { capture, at });
        Ok(instance)
    }

    /// Every trace, ascending.
    pub fn instances(&self) -> Vec<u32> {
        lock(&self.0).captures.keys().copied().collect()
    }

    /// Deletes a trace. False: there is none.
    pub fn delete(&self, instance: u32) -> bool {
        lock(&self.0).captures.remove(&instance).is_some()
    }

    /// Arms a trace again. False: there is none.
    pub fn arm(&self, instance: u32) -> bool {
        self.with(instance, |capture, store| capture.arm(store)).is_some()
    }

    /// Stops a trace. False: there is none.
    pub fn stop(&self, instance: u32) -> bool {
        self.with(instance, |capture, _| capture.stop()).is_some()
    }

    /// The state of a trace; `None`: there is no such trace.
    pub fn standing(&self, instance: u32) -> Option<TraceStatus> {
        self.with(instance, standing)
    }

    /// The rows of a trace from a tick on, at most `most`; `None`: there is no such trace.
    pub fn read(&self, instance: u32, from: u64, most: usize) -> Option<Block> {
        self.with(instance, |capture, store| {
            let standing = standing(capture, store);
            let every = u64::from(capture.config.every);
            let wanted = |tick: u64| (tick - standing.first).is_multiple_of(every);
            let mut block = Block {
                first: from.max(standing.first),
                standing: standing.clone(),
                rows: 0,
                values: Vec::new(),
            };
            let mut expected = None;
            let rows = store
                .rows_from(block.first)
                .take_while(|(tick, _)| *tick < standing.next);
            for (tick, row) in rows.filter(|(tick, _)| wanted(*tick)) {
                if block.rows == most || expected.is_some_and(|expected| tick != expected) {
                    break;
                }
                if block.rows == 0 {
                    block.first = tick;
                }
                expected = Some(tick + every);
                block
                    .values
                    .extend(capture.config.signals.iter().map(|signal| signal.of(row)));
                block.rows += 1;
            }
            block
        })
    }

    /// Rows of everything from a tick on without a gap: the tick of the first one, how many, and the values of columns.
    pub(crate) fn rows(&self, from: u64, columns: &[Column], most: usize) -> (u64, usize, Vec<f64>) {
        let mut inner = lock(&self.0);
        inner.refresh();
        let mut values = Vec::new();
        let (mut first, mut count) = (from, 0);
        for (tick, row) in inner.store.rows_from(from).take(most) {
            if count == 0 {
                first = tick;
            } else if tick != first + count as u64 {
                break;
            }
            values.extend(columns.iter().map(|column| column.of(row)));
            count += 1;
        }
        (first, count, values)
    }

    /// The stored past before a tick, newest first: every tick as long as the store has its row, then a few ticks at a time. `columns` are those
    /// of [`history::columns`].
    pub(crate) fn past(&self, before: u64, columns: &[Column], most: usize) -> Past {
        let mut inner = lock(&self.0);
        inner.refresh();
        let mut run = inner.store.run_before(before, most).peekable();
        if let Some((first, _)) = run.peek() {
            let first = *first;
            let mut values = Vec::with_capacity(most * columns.len());
            run.for_each(|(_, row)| values.extend(columns.iter().map(|column| column.of(row))));
            return Past {
                first,
                every: 1,
                signals: columns.len(),
                of_signal: 1,
                values,
            };
        }
        let (first, rows) = inner.history.before(before, most / PAST_SHARE);
        let wide = rows.first().map_or(0, |row| row.len());
        Past {
            first,
            every: inner.history.every(),
            signals: wide / history::OF_SIGNAL,
            of_signal: history::OF_SIGNAL,
            values: rows.concat(),
        }
    }

    /// An instruction's status changed.
    pub(crate) fn event(&self, tick: u64, tag: &str, mnemonic: Mnemonic, set: u32) {
        let mut inner = lock(&self.0);
        let Inner { captures, store, .. } = &mut *inner;
        for used in captures.values_mut() {
            used.capture.event(tick, tag, mnemonic, set, store);
        }
    }

    fn with<R>(&self, instance: u32, work: impl FnOnce(&mut Capture, &Store) -> R) -> Option<R> {
        let mut inner = lock(&self.0);
        inner.refresh();
        let Inner { captures, store, .. } = &mut *inner;
        let used = captures.get_mut(&instance)?;
        used.at = Instant::now();
        Some(work(&mut used.capture, store))
    }
}

impl Inner {
    fn refresh(&mut self) {
        if let Some(samples) = &mut self.samples {
            samples.take(|rows| {
                self.store.append(rows);
                self.history.append(rows);
            });
        }
        for used in self.captures.values_mut() {
            used.capture.follow(&self.store);
        }
    }
}

fn standing(capture: &mut Capture, store: &Store) -> TraceStatus {
    TraceStatus {
        phase: capture.phase,
        trigger: capture.trigger,
        first: capture.first,
        next: capture.end,
        signals: capture.config.signals.len(),
        every: capture.config.every,
        missing: capture.missing(store),
    }
}

fn lock(inner: &Mutex<Inner>) -> MutexGuard<'_, Inner> {
    inner.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The least time for which the store keeps rows, unless they take too much memory.
const KEPT: Duration = Duration::from_secs(30);
/// Memory for it, bytes.
const KEPT_BYTES: usize = 64 << 20;
/// Rows of ticks for one row of a few ticks in one read: such a row has at least three times as many numbers.
const PAST_SHARE: usize = 4;
/// Traces at a time.
pub const TRACES: usize = 32;
/// A trace that no client has read for this time makes room for another.
const IDLE: Duration = Duration::from_secs(60);
/// Time between two reads of the ring of rows, which has room for seconds.
const PAUSE: Duration = Duration::from_millis(10);

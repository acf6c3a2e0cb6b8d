//! The losses that the server logs, in the scenario of this thread.

use std::cell::Cell;
use std::fmt::Debug;

use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

thread_local! {
    static LOST: Cell<u64> = const { Cell::new(0) };
}

/// A server starts.
pub(crate) fn begin() {
    LOST.set(0);
}

/// The number of changes that the server has logged as lost.
pub(crate) fn lost() -> u64 {
    LOST.get()
}

/// Hears the log of every server of this process.
pub(crate) fn listen() {
    // Another test of this process may listen already.
    let _ = tracing::subscriber::set_global_default(Log);
}

struct Log;

impl Subscriber for Log {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::WARN && metadata.fields().field("lost").is_some()
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        event.record(&mut Lost);
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

/// Adds the lost changes of a log entry.
struct Lost;

impl Visit for Lost {
    fn record_u64(&mut self, field: &Field, value: u64) {
        if field.name() == "lost" {
            LOST.set(LOST.get() + value);
        }
    }

    fn record_debug(&mut self, _: &Field, _: &dyn Debug) {}
}

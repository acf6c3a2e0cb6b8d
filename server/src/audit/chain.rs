//! The lines of the audit: JSON with a number without gaps and the hash of the line before.

use std::time::SystemTime;

use ring::digest::{SHA256, digest};
use serde::Serialize;
use time::OffsetDateTime;

use super::{Event, EventKind};

/// A line; the order of its keys is fixed.
#[derive(Serialize, Debug)]
struct Line<'e> {
    n: u64,
    t: String,
    boot: &'e str,
    door: &'e str,
    from: &'e str,
    role: &'e str,
    #[serde(rename = "what")]
    kind: EventKind,
    object: &'e str,
    #[serde(skip_serializing_if = "Option::is_none")]
    old: Option<&'e str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    new: Option<&'e str>,
    count: u64,
    result: &'e str,
    prev: &'e str,
}

/// The end of the chain: the number of the next line, and the hash of the last one.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Chain {
    pub(super) next: u64,
    pub(super) prev: String,
    /// Distinguishes the runs of the server.
    pub(super) boot: String,
}

impl Chain {
    /// Returns the line of an event, without a line feed. The chain continues behind this line only after a call of [`Chain::wrote`].
    pub(super) fn line(&self, event: &Event, count: u64) -> String {
        let values = event.values.as_ref();
        let line = Line {
            n: self.next,
            t: moment(event.at),
            boot: &self.boot,
            door: event.door,
            from: &event.from,
            role: event.role,
            kind: event.kind,
            object: &event.object,
            old: values.map(|(old, _)| old.as_str()),
            new: values.map(|(_, new)| new.as_str()),
            count,
            result: event.result,
            prev: &self.prev,
        };
        // Numbers and texts always are JSON.
        serde_json::to_string(&line).unwrap_or_default()
    }

    /// A line is in the file.
    pub(super) fn wrote(&mut self, line: &str) {
        self.next += 1;
        self.prev = hash(line.as_bytes());
    }
}

/// The hash before the first line.
pub(super) fn first() -> String {
    "0".repeat(64)
}

/// SHA-256, hexadecimal.
pub(super) fn hash(line: &[u8]) -> String {
    crate::tls::hex(digest(&SHA256, line).as_ref())
}

/// `2026-11-22T09:15:02.123456Z`.
fn moment(at: SystemTime) -> String {
    let at = OffsetDateTime::from(at);
    let (date, time) = (at.date(), at.time());
    format!(
        "{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z",
        date.year(),
        u8::from(date.month()),
        date.day(),
        time.hour(),
        time.minute(),
        time.second(),
        time.microsecond()
    )
}

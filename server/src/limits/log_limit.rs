//! Bounds the log lines that a peer can cause: ten lines of one kind and address a minute, then one line with the number of those left out.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use super::counted;

/// Lines of one kind and address in [`SPAN`].
const LINES: u32 = 10;
/// The time in which they are counted.
const SPAN: Duration = Duration::from_secs(60);
/// Kinds and addresses that are remembered; beyond, all others share one count.
const REMEMBERED: usize = 1024;

/// The lines of each kind and address.
#[derive(Debug, Default)]
pub(crate) struct LogLimit(Mutex<HashMap<(&'static str, Option<IpAddr>), Counted>>);

#[derive(Clone, Copy, Debug)]
struct Counted {
    since: Instant,
    lines: u32,
}

/// The lines that the log may have of an event.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Lines {
    /// One line; this number of lines was left out before it.
    One(u32),
    /// The last line of this minute: it says that the log leaves out the others.
    Last,
    /// No line.
    None,
}

impl LogLimit {
    /// Counts an event.
    pub(crate) fn lines(&self, kind: &'static str, address: Option<IpAddr>) -> Lines {
        self.lines_at(kind, address, Instant::now())
    }

    /// Logs a warning of an event if the log has room for it.
    pub(crate) fn warn(&self, kind: &'static str, address: Option<IpAddr>, text: impl FnOnce() -> String) {
        let peer = address.map_or_else(|| "-".to_owned(), |address| address.to_string());
        match self.lines(kind, address) {
            Lines::One(0) => tracing::warn!(%peer, "{kind}: {}", text()),
            Lines::One(more) => tracing::warn!(%peer, more, "{kind}: {}", text()),
            Lines::Last => tracing::warn!(%peer, "{kind}: {}; more of these are not logged for a minute", text()),
            Lines::None => {}
        }
    }

    fn lines_at(&self, kind: &'static str, address: Option<IpAddr>, now: Instant) -> Lines {
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut key = (kind, address.map(counted));
        if counts.len() >= REMEMBERED && !counts.contains_key(&key) {
            counts.retain(|_, counted| now.duration_since(counted.since) < SPAN);
            if counts.len() >= REMEMBERED {
                key = (kind, None);
            }
        }
        let fresh = Counted { since: now, lines: 0 };
        let counted = counts.entry(key).or_insert(fresh);
        let mut left_out = 0;
        if now.duration_since(counted.since) >= SPAN {
            left_out = counted.lines.saturating_sub(LINES);
            *counted = fresh;
        }
        counted.lines = counted.lines.saturating_add(1);
        match counted.lines {
            lines if lines < LINES => Lines::One(left_out),
            LINES => Lines::Last,
            _ => Lines::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_lines_a_minute_then_their_number() {
        let log = LogLimit::default();
        let now = Instant::now();
        let peer = |last: u8| Some(IpAddr::from([10, 0, 0, last]));
        let mut written = 0;
        for _ in 0..1_000 {
            written += u32::from(log.lines_at("full", peer(1), now) != Lines::None);
        }
        assert_eq!(written, LINES, "of one address");
        assert_eq!(log.lines_at("full", peer(2), now), Lines::One(0), "another address");
        assert_eq!(log.lines_at("refused", peer(1), now), Lines::One(0), "another kind");
        assert_eq!(
            log.lines_at("full", peer(1), now + SPAN),
            Lines::One(990),
            "a minute later"
        );
    }

    #[test]
    fn its_memory_is_bounded() {
        let log = LogLimit::default();
        let now = Instant::now();
        for number in 0..100_000_u32 {
            log.lines_at("full", Some(IpAddr::from(number.to_be_bytes())), now);
        }
        assert!(log.0.lock().expect("not poisoned").len() <= REMEMBERED + 1);
    }
}

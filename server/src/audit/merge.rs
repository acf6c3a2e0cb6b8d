//! Merges plain writes of one client to one tag within a second: the first value before, the last value after, and their number.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::time::Instant;

use super::Event;

/// Writes that wait for more of their kind, at most; beyond, they are written at once.
const WAITING: usize = 4096;
/// A wait without a record that is due.
const IDLE: Duration = Duration::from_secs(3600);

/// The writes that wait.
#[derive(Debug, Default)]
pub(super) struct Merge(BTreeMap<(Arc<str>, String), (Instant, Event, u64)>);

impl Merge {
    /// Takes an event. Returns the lines that it makes at once: itself, unless it waits.
    pub(super) fn take(&mut self, event: Event) -> Vec<(Event, u64)> {
        if !event.is_plain_write {
            // The earlier writes of the same client stand before this event.
            let own: Vec<_> = self.0.keys().filter(|(from, _)| *from == event.from).cloned().collect();
            let before = own.iter().filter_map(|key| self.0.remove(key));
            let mut lines: Vec<_> = before.map(|(_, event, count)| (event, count)).collect();
            lines.push((event, 1));
            return lines;
        }
        let key = (event.from.clone(), event.object.clone());
        let is_full = self.0.len() >= WAITING;
        match self.0.get_mut(&key) {
            Some((_, first, count)) => {
                if let (Some(first), Some(last)) = (&mut first.values, event.values) {
                    first.1 = last.1;
                }
                *count += 1;
                Vec::new()
            }
            None if is_full => vec![(event, 1)],
            None => {
                self.0.insert(key, (Instant::now(), event, 1));
                Vec::new()
            }
        }
    }

    /// The lines of writes that have waited for this time.
    pub(super) fn ready(&mut self, after: Duration) -> Vec<(Event, u64)> {
        let now = Instant::now();
        let due: Vec<_> = self
            .0
            .iter()
            .filter(|(_, (since, ..))| now.duration_since(*since) >= after)
            .map(|(key, _)| key.clone())
            .collect();
        let lines = due.iter().filter_map(|key| self.0.remove(key));
        let mut lines: Vec<_> = lines.collect();
        lines.sort_by_key(|(since, ..)| *since);
        lines.into_iter().map(|(_, event, count)| (event, count)).collect()
    }

    /// The time until the oldest merged write is due.
    pub(super) fn due(&self, after: Duration) -> Duration {
        let first = self.0.values().map(|(since, ..)| *since).min();
        first.map_or(IDLE, |since| after.saturating_sub(since.elapsed()))
    }
}

//! Turns of the connections that keep the network's threads busy.
//!
//! A thread of the network takes its connections one after another. Two hundred that each ask for half a millisecond of work would keep
//! a stop of another one waiting for a tenth of a second. So work that is known to be long takes turns: one connection of them for each
//! thread at a time, and between two of them the thread polls all others. A message is long work if it is long itself, or if its
//! connection has used more than its share of a thread lately; a stop never is (`Router::is_stop`).
//!
//! Not here: the length of a turn, which the bounds of a message and a packet limit (`connection`, `router`).

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::{Semaphore, SemaphorePermit};

/// A message that is shorter may be done at once, bytes of its data.
pub(crate) const SHORT: usize = 256;
/// Work of a connection that is not counted, since 200 such messages take no longer than 10 ms.
const FREE: Duration = Duration::from_micros(50);
/// The share of a thread that a connection may use without taking turns is 1 / `SHARES`: 200 connections leave it some.
const SHARES: u32 = 256;

/// The turns of all connections.
#[derive(Debug)]
pub(crate) struct Turns {
    threads: Semaphore,
    /// The connection that had the newest turn.
    newest: AtomicU64,
}

impl Turns {
    /// Makes the turns of a number of threads.
    pub(crate) fn new(threads: usize) -> Self {
        Self {
            threads: Semaphore::new(threads.max(1)),
            newest: AtomicU64::new(u64::MAX),
        }
    }

    /// Whether all turns are taken, so that a connection must wait for one.
    pub(crate) fn are_taken(&self) -> bool {
        self.threads.available_permits() == 0
    }

    /// The turn of a connection, by its session's number, in the order of the calls. Until it is dropped, as many others as there are other threads
    /// have one. If another connection had the one before, everything that is ready and needs no turn comes first. `None`: never, as
    /// nothing closes them.
    pub(crate) async fn take(&self, session: u64) -> Option<SemaphorePermit<'_>> {
        let thread = self.threads.acquire().await.ok()?;
        if self.newest.swap(session, Ordering::Relaxed) != session {
            tokio::task::yield_now().await;
        }
        Some(thread)
    }
}

/// The time of a thread that one connection has used.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Share {
    /// Until this time, since the epoch of the connection, its messages take turns.
    paid: Duration,
}

impl Share {
    /// Whether the connection has used more than its share.
    pub(crate) fn is_used(&self, now: Duration) -> bool {
        now < self.paid
    }

    /// Adds the time that a message took.
    pub(crate) fn pay(&mut self, now: Duration, took: Duration) {
        if took > FREE {
            self.paid = self.paid.max(now) + took * SHARES;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn a_share_is_used_by_long_work_and_comes_back() {
        let ms = Duration::from_millis;
        let mut share = Share::default();
        share.pay(ms(10), FREE);
        assert!(!share.is_used(ms(10)), "short work is free");
        share.pay(ms(10), ms(1));
        assert!(share.is_used(ms(265)));
        assert!(!share.is_used(ms(266)), "256 times as long as the work took");
    }

    /// A task that needs no turn comes between any two that do, on one thread.
    #[tokio::test]
    async fn others_come_between_two_turns() {
        let turns = Arc::new(Turns::new(1));
        let order = Arc::new(std::sync::Mutex::new(Vec::new()));
        let mut tasks = Vec::new();
        for (session, name) in ["first", "second"].into_iter().enumerate() {
            let (turns, order) = (turns.clone(), order.clone());
            tasks.push(tokio::spawn(async move {
                let _turn = turns.take(session as u64).await.expect("never closed");
                let another = order.clone();
                tokio::spawn(async move { another.lock().expect("no panic").push("another") });
                order.lock().expect("no panic").push(name);
            }));
        }
        for task in tasks {
            task.await.expect("no panic");
        }
        assert!(!turns.are_taken());
        assert_eq!(order.lock().expect("no panic")[..3], ["first", "another", "second"]);
    }
}

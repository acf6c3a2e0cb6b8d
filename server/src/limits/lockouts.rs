//! Locks against guessing: five failures in a minute lock for 30 s, each further one twice as long, up to 15 minutes; an hour without a
//! failure forgets them.
//!
//! A lock is of an address, or of an address and a user, never of a user alone: a stranger elsewhere locks no operator out. On this
//! computer a lock is a second long, since all clients there have one address.

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use super::counted;

/// Failures in [`SPAN`] that lock.
const FAILURES: u32 = 5;
const SPAN: Duration = Duration::from_secs(60);
const FIRST: Duration = Duration::from_secs(30);
const LONGEST: Duration = Duration::from_secs(15 * 60);
const ON_LOOPBACK: Duration = Duration::from_secs(1);
const FORGOTTEN: Duration = Duration::from_secs(3600);
/// Addresses and users that are remembered; beyond, the one that failed first is forgotten.
const REMEMBERED: usize = 4096;

/// The failures of addresses and users.
#[derive(Debug, Default)]
pub(crate) struct Lockouts(Mutex<HashMap<(IpAddr, Option<String>), Failures>>);

#[derive(Clone, Copy, Debug)]
struct Failures {
    count: u32,
    since: Instant,
    last: Instant,
    /// The number of lockouts.
    locks: u32,
    until: Option<Instant>,
}

impl Lockouts {
    /// The time for which an address, or a user from there, is still locked.
    pub(crate) fn locked(&self, peer: IpAddr, user: Option<&str>, now: Instant) -> Option<Duration> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let peer = counted(peer);
        [None, user]
            .into_iter()
            .filter_map(|user| {
                let until = known.get(&(peer, user.map(str::to_owned)))?.until?;
                until.checked_duration_since(now).filter(|left| !left.is_zero())
            })
            .max()
    }

    /// Counts a failure of an address, and of a user from there if there is one. Returns whether the failure locks one of them.
    pub(crate) fn failed(&self, peer: IpAddr, user: Option<&str>, now: Instant) -> bool {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let peer = counted(peer);
        let mut locks = false;
        let keys = [Some(None), user.map(|user| Some(user.to_owned()))];
        for key in keys.into_iter().flatten() {
            known.retain(|_, failures| now.duration_since(failures.last) < FORGOTTEN);
            if known.len() >= REMEMBERED
                && let Some(oldest) = known
                    .iter()
                    .min_by_key(|(_, failures)| failures.last)
                    .map(|(key, _)| key.clone())
            {
                known.remove(&oldest);
            }
            let failures = known.entry((peer, key)).or_insert(Failures {
                count: 0,
                since: now,
                last: now,
                locks: 0,
                until: None,
            });
            failures.last = now;
            if now.duration_since(failures.since) >= SPAN {
                (failures.count, failures.since) = (0, now);
            }
            failures.count += 1;
            if failures.count >= FAILURES {
                let twice = FIRST.saturating_mul(1 << failures.locks.min(8)).min(LONGEST);
                let time = if peer.is_loopback() { ON_LOOPBACK } else { twice };
                failures.until = Some(now + time);
                failures.locks += 1;
                (failures.count, failures.since) = (FAILURES - 1, now);
                locks = true;
            }
        }
        locks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_failures_lock_the_address_and_no_other() {
        let lockouts = Lockouts::default();
        let now = Instant::now();
        let [stranger, operator, here] = [[10, 0, 0, 1], [10, 0, 0, 2], [127, 0, 0, 1]].map(IpAddr::from);
        for _ in 0..4 {
            assert!(!lockouts.failed(stranger, Some("anna"), now));
        }
        assert_eq!(lockouts.locked(stranger, Some("anna"), now), None, "four");
        assert!(lockouts.failed(stranger, Some("anna"), now), "the fifth locks");
        assert_eq!(lockouts.locked(stranger, Some("anna"), now), Some(FIRST));
        assert_eq!(lockouts.locked(stranger, Some("bert"), now), Some(FIRST), "the address");
        assert_eq!(
            lockouts.locked(operator, Some("anna"), now),
            None,
            "the same user elsewhere"
        );
        let mut at = now;
        let mut locks = Vec::new();
        for _ in 0..8 {
            at += LONGEST;
            lockouts.failed(stranger, None, at);
            locks.push(lockouts.locked(stranger, None, at).map_or(0, |left| left.as_secs()));
        }
        // A minute has passed since the one before, so each begins to count anew.
        assert_eq!(locks, [0; 8]);
        at += SPAN;
        let mut longest = Duration::ZERO;
        for _ in 0..20 {
            lockouts.failed(stranger, None, at);
            longest = longest.max(lockouts.locked(stranger, None, at).unwrap_or_default());
        }
        assert_eq!(longest, LONGEST);
        at += FORGOTTEN;
        lockouts.failed(stranger, None, at);
        assert_eq!(lockouts.locked(stranger, None, at), None, "forgotten");
        for _ in 0..100 {
            lockouts.failed(here, Some("anna"), now);
        }
        assert_eq!(lockouts.locked(here, Some("anna"), now), Some(ON_LOOPBACK));
        for number in 0..10_000_u32 {
            lockouts.failed(IpAddr::from(number.to_be_bytes()), None, now);
        }
        assert!(lockouts.0.lock().expect("not poisoned").len() <= REMEMBERED);
    }
}

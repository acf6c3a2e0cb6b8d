//! Rates: token buckets, one of a connection or one for each address.

use std::collections::HashMap;
use std::net::IpAddr;

use tokio::time::Instant;

use super::counted;

/// Addresses that are remembered; beyond, all others share one bucket.
const REMEMBERED: usize = 1024;

/// A token bucket: a number of events a second, and a number of them that may come at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rate {
    per_second: f64,
    tokens: f64,
    at: Instant,
}

impl Rate {
    pub(crate) fn new(per_second: u32, now: Instant) -> Self {
        Self {
            per_second: per_second.into(),
            tokens: per_second.into(),
            at: now,
        }
    }

    /// Counts an event if it is within the rate. Returns whether it is.
    pub(crate) fn allows(&mut self, now: Instant) -> bool {
        self.tokens = self.tokens_at(now);
        self.at = now;
        let allows = self.tokens >= 1.0;
        if allows {
            self.tokens -= 1.0;
        }
        allows
    }

    fn tokens_at(&self, now: Instant) -> f64 {
        let since = now.saturating_duration_since(self.at).as_secs_f64();
        (self.tokens + since * self.per_second).min(self.per_second)
    }

    fn is_full(&self, now: Instant) -> bool {
        self.tokens_at(now) >= self.per_second
    }
}

/// A rate for each address.
#[derive(Debug)]
pub(crate) struct AddressRate {
    per_second: u32,
    rates: HashMap<Option<IpAddr>, Rate>,
}

impl AddressRate {
    pub(crate) fn new(per_second: u32) -> Self {
        Self {
            per_second,
            rates: HashMap::new(),
        }
    }

    /// Counts an event of an address if it is within the rate. Returns whether it is.
    pub(crate) fn allows(&mut self, address: IpAddr, now: Instant) -> bool {
        let mut key = Some(counted(address));
        if self.rates.len() >= REMEMBERED && !self.rates.contains_key(&key) {
            // A bucket that is full again need not be remembered.
            self.rates.retain(|_, rate| !rate.is_full(now));
            if self.rates.len() >= REMEMBERED {
                key = None;
            }
        }
        let fresh = Rate::new(self.per_second, now);
        self.rates.entry(key).or_insert(fresh).allows(now)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn ten_a_second_and_address() {
        let mut rate = AddressRate::new(10);
        let now = Instant::now();
        let [one, other] = [[10, 0, 0, 1], [10, 0, 0, 2]].map(IpAddr::from);
        let allowed = |rate: &mut AddressRate, address, now| (0..1_000).filter(|_| rate.allows(address, now)).count();
        assert_eq!(allowed(&mut rate, one, now), 10);
        assert_eq!(allowed(&mut rate, other, now), 10, "of its own");
        assert_eq!(allowed(&mut rate, one, now + Duration::from_millis(500)), 5);
        for number in 0..100_000_u32 {
            rate.allows(IpAddr::from(number.to_be_bytes()), now);
        }
        assert!(rate.rates.len() <= REMEMBERED + 1, "its memory is bounded");
    }
}

//! Rates: a token bucket for each address.

use std::collections::HashMap;
use std::net::IpAddr;
use std::time::Instant;

use super::counted;

/// Addresses that are remembered; beyond, all others share one bucket.
const REMEMBERED: usize = 1024;

/// Events a second, for each address; so many may come at once.
#[derive(Debug)]
pub(crate) struct AddressRate {
    per_second: f64,
    buckets: HashMap<Option<IpAddr>, (f64, Instant)>,
}

impl AddressRate {
    pub(crate) fn new(per_second: u32) -> Self {
        Self {
            per_second: per_second.into(),
            buckets: HashMap::new(),
        }
    }

    /// Whether an event of an address is within the rate; counts it if so.
    pub(crate) fn allows(&mut self, address: IpAddr, now: Instant) -> bool {
        let full = self.per_second;
        let mut key = Some(counted(address));
        if self.buckets.len() >= REMEMBERED && !self.buckets.contains_key(&key) {
            // A bucket that is full again need not be remembered.
            self.buckets
                .retain(|_, (tokens, at)| *tokens + now.duration_since(*at).as_secs_f64() * full < full);
            if self.buckets.len() >= REMEMBERED {
                key = None;
            }
        }
        let (tokens, at) = self.buckets.entry(key).or_insert((full, now));
        *tokens = (*tokens + now.duration_since(*at).as_secs_f64() * full).min(full);
        *at = now;
        let allows = *tokens >= 1.0;
        if allows {
            *tokens -= 1.0;
        }
        allows
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
        assert!(rate.buckets.len() <= REMEMBERED + 1, "its memory is bounded");
    }
}

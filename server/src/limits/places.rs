//! Places that peers share by address: while all are taken, a newcomer gets the place of the address that has the most of them.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio_util::sync::CancellationToken;

use super::counted;

/// A number of places.
#[derive(Debug)]
pub(crate) struct Places {
    most: usize,
    /// The most places of one address.
    most_of_one: usize,
    full: Full,
    taken: Mutex<Taken>,
}

/// The newcomers that get a place while all are taken.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Full {
    /// Every newcomer: the oldest place of the address with the most is closed, also of the newcomer's own address.
    ClosesOldest,
    /// A newcomer whose address has at least two places less than another one: the oldest place of that address is closed.
    ClosesOldestOfLargerShare,
}

#[derive(Debug, Default)]
struct Taken {
    next: u64,
    /// The places by age, the oldest first.
    places: BTreeMap<u64, (IpAddr, CancellationToken)>,
    counts: HashMap<IpAddr, usize>,
}

/// A place; free again when it is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    places: Arc<Places>,
    number: u64,
    close: CancellationToken,
}

impl Places {
    pub(crate) fn new(most: usize, full: Full) -> Arc<Self> {
        Self::with_share(most, most, full)
    }

    /// Makes places of which one address has `most_of_one` at most.
    pub(crate) fn with_share(most: usize, most_of_one: usize, full: Full) -> Arc<Self> {
        Arc::new(Self {
            most,
            most_of_one,
            full,
            taken: Mutex::default(),
        })
    }

    /// A place for a peer; `None`: all are taken, and none is closed for this peer.
    pub(crate) fn enter(self: &Arc<Self>, peer: IpAddr) -> Option<Place> {
        let peer = counted(peer);
        let mut taken = self.lock();
        let own = taken.counts.get(&peer).copied().unwrap_or(0);
        if own >= self.most_of_one && self.full == Full::ClosesOldestOfLargerShare && self.most_of_one < self.most {
            return None;
        }
        if taken.places.len() >= self.most {
            let (largest, most) = taken
                .counts
                .iter()
                .map(|(address, count)| (*address, *count))
                .max_by_key(|(_, count)| *count)?;
            if self.full == Full::ClosesOldestOfLargerShare && most < own + 2 {
                return None;
            }
            taken.close_oldest_of(largest);
        }
        let number = taken.next;
        taken.next += 1;
        let close = CancellationToken::new();
        taken.places.insert(number, (peer, close.clone()));
        *taken.counts.entry(peer).or_default() += 1;
        Some(Place {
            places: self.clone(),
            number,
            close,
        })
    }

    /// Places that are taken.
    pub(crate) fn taken(&self) -> usize {
        self.lock().places.len()
    }

    fn lock(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Taken {
    fn close_oldest_of(&mut self, address: IpAddr) {
        let oldest = self.places.iter().find(|(_, (peer, _))| *peer == address);
        let oldest = oldest.map(|(number, _)| *number);
        if let Some(close) = oldest.and_then(|number| self.remove(number)) {
            close.cancel();
        }
    }

    fn remove(&mut self, number: u64) -> Option<CancellationToken> {
        let (peer, close) = self.places.remove(&number)?;
        if let Some(count) = self.counts.get_mut(&peer) {
            *count -= 1;
            if *count == 0 {
                self.counts.remove(&peer);
            }
        }
        Some(close)
    }
}

impl Place {
    /// Is cancelled when a newcomer gets this place.
    pub(crate) fn close(&self) -> CancellationToken {
        self.close.clone()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.lock().remove(self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peer(last: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, last])
    }

    #[test]
    fn one_address_does_not_keep_others_out() {
        for full in [Full::ClosesOldest, Full::ClosesOldestOfLargerShare] {
            let places = Places::new(32, full);
            let stranger: Vec<Place> = (0..32).map(|_| places.enter(peer(1)).expect("free")).collect();
            let operators: Vec<Option<Place>> = (2..18).map(|last| places.enter(peer(last))).collect();
            assert!(operators.iter().all(Option::is_some), "{full:?}: 16 newcomers");
            let closed = stranger.iter().filter(|place| place.close().is_cancelled()).count();
            assert_eq!(closed, 16, "{full:?}: of the stranger");
            let lost = operators
                .iter()
                .flatten()
                .filter(|place| place.close().is_cancelled())
                .count();
            assert_eq!(lost, 0, "{full:?}: of the operators");
            drop((stranger, operators));
            assert!(places.lock().counts.is_empty() && places.lock().places.is_empty());
        }
    }

    #[test]
    fn newcomers_of_the_same_address() {
        for (full, enters) in [(Full::ClosesOldest, true), (Full::ClosesOldestOfLargerShare, false)] {
            let places = Places::new(2, full);
            let _both = [places.enter(peer(1)), places.enter(peer(1))];
            assert_eq!(places.enter(peer(1)).is_some(), enters, "{full:?}");
        }
    }

    #[test]
    fn two_addresses_with_equal_shares_do_not_close_each_other() {
        let places = Places::new(4, Full::ClosesOldestOfLargerShare);
        let _held: Vec<_> = [1, 1, 2, 2].map(|last| places.enter(peer(last)).expect("free")).into();
        assert!(places.enter(peer(1)).is_none() && places.enter(peer(2)).is_none());
        assert!(places.enter(peer(3)).is_some(), "a third address");
    }
}

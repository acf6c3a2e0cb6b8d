//! Limits the number of clients, in all and from one address. While it is reached, a newcomer gets the place of the oldest client
//! without a session, else of the oldest one without a request in its session, else of the oldest client of the address
//! with the most, if that address has at least two clients more than the newcomer's. So neither silent sockets nor sessions of one
//! address keep a client of another address out (spec/ethernet-ip.md §18).

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio_util::sync::CancellationToken;

use crate::limits::counted;
use arcline_state::planted::is_planted;

/// The most of each.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct ClientLimits {
    /// TCP connections.
    pub(crate) clients: usize,
    /// TCP connections from one address.
    pub(crate) clients_of_one: usize,
    /// Class 3 connections of all clients at one address.
    pub(crate) connections_of_one: usize,
}

/// The clients that are connected.
#[derive(Debug)]
pub(crate) struct ClientLimiter {
    limits: ClientLimits,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    next: u64,
    /// The clients by age, the oldest first.
    clients: BTreeMap<u64, Client>,
    addresses: BTreeMap<IpAddr, Address>,
}

#[derive(Debug)]
struct Client {
    peer: IpAddr,
    progress: ClientProgress,
    close: CancellationToken,
}

/// The progress of a client. Of two clients, the one with the lesser progress loses its place first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum ClientProgress {
    /// No session.
    Silent,
    /// A session without a request.
    Registered,
    /// A session with a request.
    Asking,
}

/// The clients and connections of one address.
#[derive(Debug, Default)]
struct Address {
    clients: usize,
    connections: usize,
}

/// The slot of one client; free again when it is dropped.
#[derive(Debug)]
pub(crate) struct ClientSlot {
    limiter: Arc<ClientLimiter>,
    number: u64,
    progress: ClientProgress,
    close: CancellationToken,
}

impl ClientLimiter {
    pub(crate) fn new(limits: ClientLimits) -> Arc<Self> {
        Arc::new(Self {
            limits,
            state: Mutex::default(),
        })
    }

    /// A slot for a new client; `None`: all slots have clients that ask, and no other address has more of them.
    pub(crate) fn enter(self: &Arc<Self>, peer: IpAddr) -> Option<ClientSlot> {
        let peer = counted(peer);
        let mut state = self.lock();
        let own = state.clients_of(peer);
        if own >= self.limits.clients_of_one
            && !state.close_oldest(ClientProgress::Registered, |_, client| client.peer == peer)
        {
            return None;
        }
        if state.clients.len() >= self.limits.clients && !state.close_for(peer) {
            return None;
        }
        let number = state.next;
        state.next += 1;
        let close = CancellationToken::new();
        let client = Client {
            peer,
            progress: ClientProgress::Silent,
            close: close.clone(),
        };
        state.clients.insert(number, client);
        state.addresses.entry(peer).or_default().clients += 1;
        Some(ClientSlot {
            limiter: self.clone(),
            number,
            progress: ClientProgress::Silent,
            close,
        })
    }

    /// The number of clients that have a slot.
    pub(crate) fn clients(&self) -> usize {
        self.lock().clients.len()
    }

    /// Closes the oldest client without a session: the system has no more sockets.
    pub(crate) fn make_room(&self) {
        self.lock().close_oldest(ClientProgress::Registered, |_, _| true);
    }

    /// Counts one more class 3 connection of an address if the limit allows it. Returns whether the limit allows it.
    pub(crate) fn acquire_connection(&self, peer: IpAddr) -> bool {
        let peer = counted(peer);
        let mut state = self.lock();
        let address = state.addresses.entry(peer).or_default();
        let free = address.connections < self.limits.connections_of_one;
        address.connections += usize::from(free);
        state.forget(peer);
        free
    }

    /// `count` connections of an address have gone.
    pub(crate) fn release_connections(&self, peer: IpAddr, count: usize) {
        let peer = counted(peer);
        let mut state = self.lock();
        if let Some(address) = state.addresses.get_mut(&peer) {
            address.connections = address.connections.saturating_sub(count);
        }
        state.forget(peer);
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn clients_of(&self, peer: IpAddr) -> usize {
        self.addresses.get(&peer).map_or(0, |address| address.clients)
    }

    /// Closes a client for a newcomer.
    fn close_for(&mut self, peer: IpAddr) -> bool {
        let own = self.clients_of(peer);
        // A new client of an address does not close the clients of addresses that have fewer.
        let may = |state: &Self, client: &Client| client.peer == peer || state.clients_of(client.peer) > own;
        if self.close_oldest(ClientProgress::Asking, may) {
            return true;
        }
        let largest = self.addresses.iter().max_by_key(|(_, address)| address.clients);
        match largest.map(|(address, clients)| (*address, clients.clients)) {
            Some((largest, clients)) if clients >= own + 2 => {
                let oldest = self.clients.iter().find(|(_, client)| client.peer == largest);
                let oldest = oldest.map(|(number, _)| *number);
                oldest.is_some_and(|number| self.close(number))
            }
            _ => false,
        }
    }

    /// Closes the oldest client of the least progress before `before`.
    fn close_oldest(&mut self, before: ClientProgress, which: impl Fn(&Self, &Client) -> bool) -> bool {
        let clients = self.clients.iter();
        let early = clients.filter(|(_, client)| client.progress < before && which(self, client));
        // Of clients of the same progress the first, which is the oldest.
        let oldest = early
            .min_by_key(|(_, client)| client.progress)
            .map(|(number, _)| *number);
        oldest.is_some_and(|number| self.close(number))
    }

    fn close(&mut self, number: u64) -> bool {
        let client = self.remove(number);
        client.inspect(|client| client.close.cancel()).is_some()
    }

    fn remove(&mut self, number: u64) -> Option<Client> {
        let client = self.clients.remove(&number)?;
        if let Some(address) = self.addresses.get_mut(&client.peer) {
            address.clients = address.clients.saturating_sub(1);
        }
        self.forget(client.peer);
        Some(client)
    }

    /// An address without clients and connections takes no memory.
    fn forget(&mut self, peer: IpAddr) {
        if self
            .addresses
            .get(&peer)
            .is_some_and(|address| address.clients == 0 && address.connections == 0)
        {
            self.addresses.remove(&peer);
        }
    }
}

impl ClientSlot {
    /// The client has come so far.
    pub(crate) fn reach(&mut self, progress: ClientProgress) {
        if self.progress >= progress {
            return;
        }
        self.progress = progress;
        if let Some(client) = self.limiter.lock().clients.get_mut(&self.number) {
            client.progress = progress;
        }
    }

    /// Is cancelled when the client is to be closed.
    pub(crate) fn close(&self) -> CancellationToken {
        self.close.clone()
    }
}

impl Drop for ClientSlot {
    fn drop(&mut self) {
        if is_planted("slot of a client without a session") && self.progress == ClientProgress::Silent {
            return;
        }
        self.limiter.lock().remove(self.number);
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    fn peer(last: u8) -> IpAddr {
        Ipv4Addr::new(10, 0, 0, last).into()
    }

    #[test]
    fn silent_clients_go_first_and_those_that_ask_stay() {
        let limiter = ClientLimiter::new(ClientLimits {
            clients: 3,
            clients_of_one: 2,
            connections_of_one: 2,
        });
        let mut first = limiter.enter(peer(1)).expect("room");
        first.reach(ClientProgress::Asking);
        let silent = limiter.enter(peer(1)).expect("room");
        let third = limiter.enter(peer(1)).expect("the silent one goes");
        drop(silent);
        assert_eq!(limiter.lock().clients.len(), 2);
        let mut third = third;
        third.reach(ClientProgress::Asking);
        assert!(limiter.enter(peer(1)).is_none(), "two clients from there ask");
        let mut other = limiter.enter(peer(2)).expect("another address");
        other.reach(ClientProgress::Asking);
        let mut fourth = limiter.enter(peer(3)).expect("the oldest of the address with two");
        assert!(first.close().is_cancelled() && !third.close().is_cancelled());
        fourth.reach(ClientProgress::Asking);
        assert!(limiter.enter(peer(4)).is_none(), "every address has one");
        drop(first);
        drop((third, other, fourth));
        assert!(limiter.lock().clients.is_empty() && limiter.lock().addresses.is_empty());
    }

    #[test]
    fn sessions_of_one_address_keep_no_client_out() {
        let limiter = ClientLimiter::new(ClientLimits {
            clients: 2_048,
            clients_of_one: 2_048,
            connections_of_one: 1,
        });
        for progress in [ClientProgress::Registered, ClientProgress::Asking] {
            let mut stranger: Vec<ClientSlot> = (0..2_048).map(|_| limiter.enter(peer(1)).expect("room")).collect();
            stranger.iter_mut().for_each(|slot| slot.reach(progress));
            let newcomers: Vec<_> = (2..12).map(|last| limiter.enter(peer(last))).collect();
            assert!(newcomers.iter().all(Option::is_some), "{progress:?}");
            let same = limiter.enter(peer(1)).is_some();
            assert_eq!(
                same,
                progress == ClientProgress::Registered,
                "{progress:?}: a newcomer of the same address"
            );
        }
    }

    #[test]
    fn connections_of_one_address_are_counted() {
        let limiter = ClientLimiter::new(ClientLimits {
            clients: 9,
            clients_of_one: 9,
            connections_of_one: 2,
        });
        assert!(limiter.acquire_connection(peer(1)) && limiter.acquire_connection(peer(1)));
        assert!(!limiter.acquire_connection(peer(1)));
        assert!(limiter.acquire_connection(peer(2)));
        limiter.release_connections(peer(1), 1);
        assert!(limiter.acquire_connection(peer(1)));
        limiter.release_connections(peer(1), 2);
        limiter.release_connections(peer(2), 1);
        assert!(limiter.lock().addresses.is_empty());
    }
}

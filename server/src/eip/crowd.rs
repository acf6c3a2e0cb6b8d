//! How many clients there may be, in all and from one address, and who goes when it is full: the oldest that has
//! registered no session, so that silent sockets keep nobody out (spec/ethernet-ip.md §18).

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio_util::sync::CancellationToken;

/// How many there may be.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Limits {
    /// TCP connections.
    pub(crate) clients: usize,
    /// TCP connections from one address.
    pub(crate) clients_of_one: usize,
    /// Class 3 connections of all clients at one address.
    pub(crate) connections_of_one: usize,
}

/// Everybody who is connected.
#[derive(Debug)]
pub(crate) struct Crowd {
    limits: Limits,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    next: u64,
    /// By age, the oldest first.
    clients: BTreeMap<u64, Client>,
    addresses: HashMap<IpAddr, Address>,
}

#[derive(Debug)]
struct Client {
    peer: IpAddr,
    registered: bool,
    leave: CancellationToken,
}

/// What there is of one address.
#[derive(Debug, Default)]
struct Address {
    clients: usize,
    connections: usize,
}

/// A client's place; free again when it is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    crowd: Arc<Crowd>,
    number: u64,
    registered: bool,
    leave: CancellationToken,
}

impl Crowd {
    pub(crate) fn new(limits: Limits) -> Arc<Self> {
        Arc::new(Self {
            limits,
            state: Mutex::default(),
        })
    }

    /// A place for a client that has come; `None`: it is full of clients with sessions.
    pub(crate) fn enter(self: &Arc<Self>, peer: IpAddr) -> Option<Place> {
        let mut state = self.lock();
        if state.addresses.get(&peer).map_or(0, |address| address.clients) >= self.limits.clients_of_one
            && !state.send_away(|client| client.peer == peer)
        {
            return None;
        }
        if state.clients.len() >= self.limits.clients && !state.send_away(|_| true) {
            return None;
        }
        let number = state.next;
        state.next += 1;
        let leave = CancellationToken::new();
        let client = Client {
            peer,
            registered: false,
            leave: leave.clone(),
        };
        state.clients.insert(number, client);
        state.addresses.entry(peer).or_default().clients += 1;
        Some(Place {
            crowd: self.clone(),
            number,
            registered: false,
            leave,
        })
    }

    /// Sends the oldest client without a session away: the system has no more sockets.
    pub(crate) fn make_room(&self) {
        self.lock().send_away(|_| true);
    }

    /// Whether the clients of an address may have one more class 3 connection; counts it if so.
    pub(crate) fn acquire_connection(&self, peer: IpAddr) -> bool {
        let mut state = self.lock();
        let address = state.addresses.entry(peer).or_default();
        let free = address.connections < self.limits.connections_of_one;
        address.connections += usize::from(free);
        state.forget(peer);
        free
    }

    /// `count` connections of an address have gone.
    pub(crate) fn release_connections(&self, peer: IpAddr, count: usize) {
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
    fn send_away(&mut self, which: impl Fn(&Client) -> bool) -> bool {
        let mut silent = self
            .clients
            .iter()
            .filter(|(_, client)| !client.registered && which(client));
        let Some(number) = silent.next().map(|(number, _)| *number) else {
            return false;
        };
        if let Some(client) = self.remove(number) {
            client.leave.cancel();
        }
        true
    }

    fn remove(&mut self, number: u64) -> Option<Client> {
        let client = self.clients.remove(&number)?;
        if let Some(address) = self.addresses.get_mut(&client.peer) {
            address.clients = address.clients.saturating_sub(1);
        }
        self.forget(client.peer);
        Some(client)
    }

    /// An address of which there is nothing takes no memory.
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

impl Place {
    /// The client has a session: it stays.
    pub(crate) fn register(&mut self) {
        if self.registered {
            return;
        }
        self.registered = true;
        if let Some(client) = self.crowd.lock().clients.get_mut(&self.number) {
            client.registered = true;
        }
    }

    /// Tells when the client has to go.
    pub(crate) fn leave(&self) -> CancellationToken {
        self.leave.clone()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.crowd.lock().remove(self.number);
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
    fn who_is_silent_goes_first_and_who_has_a_session_stays() {
        let crowd = Crowd::new(Limits {
            clients: 3,
            clients_of_one: 2,
            connections_of_one: 2,
        });
        let mut first = crowd.enter(peer(1)).expect("room");
        first.register();
        let silent = crowd.enter(peer(1)).expect("room");
        let third = crowd.enter(peer(1)).expect("the silent one goes");
        drop(silent);
        assert_eq!(crowd.lock().clients.len(), 2);
        let mut third = third;
        third.register();
        assert!(crowd.enter(peer(1)).is_none(), "two sessions from there");
        let mut other = crowd.enter(peer(2)).expect("another address");
        other.register();
        assert!(crowd.enter(peer(3)).is_none(), "three sessions in all");
        drop(first);
        assert!(crowd.enter(peer(3)).is_some());
        drop((third, other));
        assert!(crowd.lock().clients.is_empty() && crowd.lock().addresses.is_empty());
    }

    #[test]
    fn connections_of_one_address_are_counted() {
        let crowd = Crowd::new(Limits {
            clients: 9,
            clients_of_one: 9,
            connections_of_one: 2,
        });
        assert!(crowd.acquire_connection(peer(1)) && crowd.acquire_connection(peer(1)));
        assert!(!crowd.acquire_connection(peer(1)));
        assert!(crowd.acquire_connection(peer(2)));
        crowd.release_connections(peer(1), 1);
        assert!(crowd.acquire_connection(peer(1)));
        crowd.release_connections(peer(1), 2);
        crowd.release_connections(peer(2), 1);
        assert!(crowd.lock().addresses.is_empty());
    }
}

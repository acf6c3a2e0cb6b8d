//! Limits the number of clients, in all and from one address. When it is reached, the oldest client without a session is
//! closed, so that silent sockets keep no client out (spec/ethernet-ip.md §18).

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio_util::sync::CancellationToken;

/// The most of each.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) struct Limits {
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
    close: CancellationToken,
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
    registered: bool,
    close: CancellationToken,
}

impl ClientLimiter {
    pub(crate) fn new(limits: Limits) -> Arc<Self> {
        Arc::new(Self {
            limits,
            state: Mutex::default(),
        })
    }

    /// A slot for a new client; `None`: all slots have clients with sessions.
    pub(crate) fn enter(self: &Arc<Self>, peer: IpAddr) -> Option<ClientSlot> {
        let mut state = self.lock();
        if state.addresses.get(&peer).map_or(0, |address| address.clients) >= self.limits.clients_of_one
            && !state.close_oldest(|client| client.peer == peer)
        {
            return None;
        }
        if state.clients.len() >= self.limits.clients && !state.close_oldest(|_| true) {
            return None;
        }
        let number = state.next;
        state.next += 1;
        let close = CancellationToken::new();
        let client = Client {
            peer,
            registered: false,
            close: close.clone(),
        };
        state.clients.insert(number, client);
        state.addresses.entry(peer).or_default().clients += 1;
        Some(ClientSlot {
            limiter: self.clone(),
            number,
            registered: false,
            close,
        })
    }

    /// Closes the oldest client without a session: the system has no more sockets.
    pub(crate) fn make_room(&self) {
        self.lock().close_oldest(|_| true);
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
    fn close_oldest(&mut self, which: impl Fn(&Client) -> bool) -> bool {
        let mut silent = self
            .clients
            .iter()
            .filter(|(_, client)| !client.registered && which(client));
        let Some(number) = silent.next().map(|(number, _)| *number) else {
            return false;
        };
        if let Some(client) = self.remove(number) {
            client.close.cancel();
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
    /// The client has a session: it stays.
    pub(crate) fn register(&mut self) {
        if self.registered {
            return;
        }
        self.registered = true;
        if let Some(client) = self.limiter.lock().clients.get_mut(&self.number) {
            client.registered = true;
        }
    }

    /// Is cancelled when the client is to be closed.
    pub(crate) fn close(&self) -> CancellationToken {
        self.close.clone()
    }
}

impl Drop for ClientSlot {
    fn drop(&mut self) {
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
    fn who_is_silent_goes_first_and_who_has_a_session_stays() {
        let limiter = ClientLimiter::new(Limits {
            clients: 3,
            clients_of_one: 2,
            connections_of_one: 2,
        });
        let mut first = limiter.enter(peer(1)).expect("room");
        first.register();
        let silent = limiter.enter(peer(1)).expect("room");
        let third = limiter.enter(peer(1)).expect("the silent one goes");
        drop(silent);
        assert_eq!(limiter.lock().clients.len(), 2);
        let mut third = third;
        third.register();
        assert!(limiter.enter(peer(1)).is_none(), "two sessions from there");
        let mut other = limiter.enter(peer(2)).expect("another address");
        other.register();
        assert!(limiter.enter(peer(3)).is_none(), "three sessions in all");
        drop(first);
        assert!(limiter.enter(peer(3)).is_some());
        drop((third, other));
        assert!(limiter.lock().clients.is_empty() && limiter.lock().addresses.is_empty());
    }

    #[test]
    fn connections_of_one_address_are_counted() {
        let limiter = ClientLimiter::new(Limits {
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

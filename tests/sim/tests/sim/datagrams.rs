//! The datagrams of implicit I/O between clients and the server: they are lost, late or twice, and never out of order.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::os::fd::BorrowedFd;
use std::sync::{Arc, Mutex};

use arcline_server::stepped::Datagrams;
use arcline_tests::random::Random;

use crate::network::Weather;
use crate::record::lock;

/// The datagrams of a scenario. Clones are the same ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct Post(Arc<Mutex<Inner>>);

#[derive(Debug, Default)]
struct Inner {
    /// ms of the scenario.
    now: u64,
    /// The time before which all datagrams are lost.
    held_until: u64,
    to_server: Vec<(u64, Vec<u8>, SocketAddr)>,
    arrived: VecDeque<(Vec<u8>, SocketAddr)>,
    to_clients: BTreeMap<SocketAddr, Vec<(u64, Vec<u8>)>>,
}

/// The socket of a client.
pub(crate) struct Mailbox {
    post: Post,
    pub(crate) address: SocketAddr,
    weather: Weather,
    random: Random,
    last: u64,
}

impl Post {
    /// Begins a millisecond: the due datagrams arrive.
    pub(crate) fn begin(&self, now: u64) {
        let mut inner = lock(&self.0);
        inner.now = now;
        let is_held = now < inner.held_until;
        let (due, later) = std::mem::take(&mut inner.to_server)
            .into_iter()
            .partition(|(due, _, _)| *due <= now);
        inner.to_server = later;
        let due: Vec<(u64, Vec<u8>, SocketAddr)> = due;
        if !is_held {
            inner
                .arrived
                .extend(due.into_iter().map(|(_, bytes, from)| (bytes, from)));
        }
    }

    /// Everything is lost before a time.
    pub(crate) fn hold(&self, until: u64) {
        lock(&self.0).held_until = until;
    }

    /// The server has ended: nothing has arrived for the next one.
    pub(crate) fn lose_server(&self) {
        lock(&self.0).arrived.clear();
    }

    /// The time until which all datagrams are or were lost.
    pub(crate) fn held_until(&self) -> u64 {
        lock(&self.0).held_until
    }

    /// A socket of a client.
    pub(crate) fn open(&self, address: SocketAddr, weather: Weather, random: Random) -> Mailbox {
        lock(&self.0).to_clients.insert(address, Vec::new());
        Mailbox {
            post: self.clone(),
            address,
            weather,
            random,
            last: 0,
        }
    }
}

impl Mailbox {
    /// Sends a datagram to the server. When it arrives, ms; `None`: it is lost.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> Option<u64> {
        let (chance, late) = (self.random.below(100), self.random.below(self.weather.delay + 1));
        let mut inner = lock(&self.post.0);
        let due = self.last.max(inner.now + 1 + late);
        if chance < LOST_PERCENT || due < inner.held_until {
            return None;
        }
        self.last = due;
        inner.to_server.push((due, bytes.to_vec(), self.address));
        if chance >= 100 - TWICE_PERCENT {
            inner.to_server.push((due + 2, bytes.to_vec(), self.address));
        }
        Some(due)
    }

    /// The next datagram from the server: when it was sent, ms, and its bytes.
    pub(crate) fn receive(&self) -> Option<(u64, Vec<u8>)> {
        let mut inner = lock(&self.post.0);
        let waiting = inner.to_clients.get_mut(&self.address)?;
        (!waiting.is_empty()).then(|| waiting.remove(0))
    }
}

impl Drop for Mailbox {
    fn drop(&mut self) {
        lock(&self.post.0).to_clients.remove(&self.address);
    }
}

/// The server's end.
impl Datagrams for Post {
    fn receive(&self, buf: &mut [u8]) -> io::Result<(usize, SocketAddr)> {
        let arrived = lock(&self.0).arrived.pop_front();
        let (bytes, from) = arrived.ok_or(io::ErrorKind::WouldBlock)?;
        buf[..bytes.len()].copy_from_slice(&bytes);
        Ok((bytes.len(), from))
    }

    fn send(&self, bytes: &[u8], to: SocketAddr) -> io::Result<()> {
        let mut inner = lock(&self.0);
        let (now, is_held) = (inner.now, inner.now < inner.held_until);
        if let Some(waiting) = inner.to_clients.get_mut(&to).filter(|_| !is_held) {
            waiting.push((now, bytes.to_vec()));
        }
        Ok(())
    }

    fn send_through(&self, _: Ipv4Addr) -> io::Result<()> {
        Ok(())
    }

    fn descriptor(&self) -> Option<BorrowedFd<'_>> {
        None
    }
}

const LOST_PERCENT: u64 = 5;
const TWICE_PERCENT: u64 = 5;

//! A [`Host`] for tests, of this crate and of others (feature `test-util`): without sockets, and the same in every run.

use std::net::{IpAddr, Ipv4Addr, SocketAddrV4};
use std::time::Duration;

use super::host::without_io;
use super::{Host, IoOpen, IoOpened};
use crate::cip::CipStatus;
use crate::connection::{ConnectionKey, ConnectionType, Count, Counters};
use crate::identity::Identity;
use crate::io::{IO_PORT, IoConnections, Originator};

/// The numbers that session handles and connection ids are made of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Draws {
    /// The next number each time, so that a test can name a session and the connections that it opens.
    Counting(u32),
    /// A linear congruential generator, from this number on.
    Mixed(u32),
    /// The same number each time.
    Constant(u32),
    /// The source of randomness fails.
    Fails,
}

impl Draws {
    fn draw(&mut self) -> Option<u32> {
        match self {
            Self::Counting(last) => *last = last.wrapping_add(1),
            Self::Mixed(last) => *last = last.wrapping_mul(1_664_525).wrapping_add(1_013_904_223),
            Self::Constant(_) => {}
            Self::Fails => return None,
        }
        match *self {
            Self::Counting(number) | Self::Mixed(number) | Self::Constant(number) => Some(number),
            Self::Fails => None,
        }
    }
}

/// The I/O of a [`TestHost`].
#[derive(Debug)]
pub struct TestIo {
    /// Class 0 and 1 connections.
    pub connections: IoConnections,
    /// The originator's address.
    pub peer: IpAddr,
    /// The multicast group of this device.
    pub group: Ipv4Addr,
    /// The time since the beginning of the test.
    pub now: Duration,
}

/// The part of a server that its sessions share, in a test.
#[derive(Debug)]
pub struct TestHost {
    /// The next numbers.
    pub draws: Draws,
    /// Class 3 connections that are open.
    pub open: usize,
    /// How many may be.
    pub most: usize,
    /// The Connection Manager's counts.
    pub counters: Counters,
    /// I/O connections; without them a Forward Open of class 0 or 1 is refused.
    pub io: Option<TestIo>,
    /// The device.
    pub identity: Identity,
}

impl TestHost {
    /// A host without a limit of connections and without I/O.
    #[must_use]
    pub fn new(draws: Draws) -> Self {
        Self {
            draws,
            open: 0,
            most: usize::MAX,
            counters: Counters::default(),
            io: None,
            identity: Identity::new("Arcline", 1),
        }
    }

    /// A host with I/O.
    #[must_use]
    pub fn with_io(draws: Draws, io: TestIo) -> Self {
        Self {
            io: Some(io),
            ..Self::new(draws)
        }
    }

    /// The I/O of a host that was made with it.
    ///
    /// # Panics
    /// When it was made without.
    pub fn io(&mut self) -> &mut TestIo {
        self.io.as_mut().expect("the host was made with I/O")
    }
}

impl Host for TestHost {
    fn random(&mut self) -> Option<u32> {
        self.draws.draw()
    }

    fn acquire_connection(&mut self) -> bool {
        let free = self.open < self.most;
        self.open += usize::from(free);
        free
    }

    fn release_connections(&mut self, count: usize) {
        self.open -= count;
    }

    fn count(&mut self, count: Count) {
        self.counters.add(count);
    }

    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn open_io(&mut self, open: &IoOpen<'_>) -> Result<IoOpened, CipStatus> {
        let Some(io) = &mut self.io else {
            return Err(without_io(open));
        };
        let originator = Originator {
            address: io.peer,
            port: open.port,
            group: Some(io.group),
        };
        let draws = &mut self.draws;
        let reply = (io.connections).open(open.open, open.application, originator, io.now, || draws.draw())?;
        let multicast = open.open.t_to_o.connection_type == ConnectionType::Multicast;
        Ok(IoOpened {
            reply,
            listens: SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, IO_PORT),
            group: multicast.then_some(SocketAddrV4::new(io.group, IO_PORT)),
        })
    }

    fn close_io(&mut self, key: ConnectionKey) -> bool {
        self.io
            .as_mut()
            .is_some_and(|io| io.connections.close(key, io.peer).is_ok())
    }
}

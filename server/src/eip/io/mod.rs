//! Implicit I/O: class 0 and 1 connections over one UDP socket (spec/ethernet-ip.md §14, docs/IO.md).
//!
//! The choice of connections that may open, and the times of datagrams, are those of [`IoConnections`] in `arcline-proto`. This module has the
//! socket, the turns that receive and send datagrams, the thread that makes the turns, and the meaning of the assemblies. The tick has no
//! part in it: inputs come from its snapshots, and outputs go through the ring of its commands.

mod lateness;
pub(crate) mod layout;
mod outputs;
pub(crate) mod page;
mod socket;
mod thread;
mod turn;

use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use arcline_config::IoLoss;
use arcline_controller::machine::Machine;
use arcline_proto::cip::CipStatus;
use arcline_proto::connection::{ConnectionKey, Count};
use arcline_proto::cpf::ConnectionId;
use arcline_proto::io::{Assemblies, Ended, IoConnections, IoEvent, IoSettings, Originator, Ownership};
use arcline_proto::session::{Host, IoOpen, IoOpened};
use bytes::{Bytes, BytesMut};
use rustix::event::{EventfdFlags, eventfd};
use rustix::fd::OwnedFd;
use tokio::time::Instant;
use tracing::{debug, warn};

use self::layout::{Head, status};
use self::outputs::Outputs;
use crate::eip::device::Device;
use crate::plant::Plant;

pub use socket::Datagrams;
pub(crate) use thread::IoThread;
pub(crate) use turn::IoTurns;

/// Connections of all originators.
const MAX_CONNECTIONS: usize = 64;

/// The assemblies, and the newest outputs, with or without a connection.
#[derive(Debug)]
pub(crate) struct AssemblyData {
    assemblies: Assemblies,
    reaction: IoLoss,
    outputs: Mutex<Outputs>,
}

impl AssemblyData {
    /// The assemblies of a machine.
    pub(crate) fn new(machine: &Machine, reaction: IoLoss) -> Self {
        Self {
            assemblies: layout::assemblies(machine),
            reaction,
            outputs: Mutex::default(),
        }
    }

    /// The assemblies that connections can use.
    pub(crate) fn assemblies(&self) -> &Assemblies {
        &self.assemblies
    }

    /// The input assembly of the newest tick.
    pub(crate) fn input(&self, plant: &Plant, ownership: Ownership) -> Bytes {
        let mut out = BytesMut::with_capacity(self.assemblies.input.size.into());
        let head = self.head(ownership);
        plant.with_snapshot(|snapshot| layout::encode_input(head, snapshot, &mut out));
        out.freeze()
    }

    /// Replaces the contents of `out` by the input assembly of the newest tick; while the plant is busy, it refreshes the head only.
    fn refresh_input(&self, plant: &Plant, ownership: Ownership, out: &mut BytesMut) {
        let head = self.head(ownership);
        let done = plant.try_with_snapshot(|snapshot| {
            out.clear();
            layout::encode_input(head, snapshot, out);
        });
        if done.is_none() {
            if out.is_empty() {
                out.extend_from_slice(&self.input(plant, ownership));
            } else {
                layout::renew_head(head, out);
            }
        }
    }

    fn head(&self, ownership: Ownership) -> Head {
        let mut head = {
            let outputs = lock(&self.outputs);
            Head {
                command: outputs.word(),
                status: if outputs.refused() { status::REFUSED } else { 0 },
                ..Head::default()
            }
        };
        head.status |= match ownership {
            Ownership::Free => 0,
            Ownership::Idle => status::OWNED,
            Ownership::Run => status::OWNED | status::RUN,
        };
        head
    }

    /// The output assembly as it was last applied; zeros when no client commands.
    pub(crate) fn output(&self) -> Bytes {
        let outputs = lock(&self.outputs);
        let mut data = outputs.data().to_vec();
        data.resize(self.assemblies.output.size.into(), 0);
        data.into()
    }

    /// Applies an output assembly of the right size.
    pub(crate) fn apply(&self, data: &[u8], plant: &Plant) {
        lock(&self.outputs).apply(data, plant);
    }

    /// No client commands any more: applies the reaction that is configured.
    fn lose(&self, why: &str, plant: &Plant) {
        warn!(why, reaction = self.reaction.word(), "the owner of the outputs is lost");
        lock(&self.outputs).lose(self.reaction, plant);
    }
}

/// The connections and their socket.
#[derive(Debug)]
pub(crate) struct Io {
    connections: Mutex<IoConnections>,
    socket: Arc<dyn Datagrams>,
    local: SocketAddr,
    epoch: Instant,
    /// Through which of our addresses a group is reached.
    groups: Mutex<BTreeMap<Ipv4Addr, Ipv4Addr>>,
    /// Wakes the thread.
    wake: OwnedFd,
}

impl Io {
    /// Binds the socket; port 0 picks a free one.
    ///
    /// # Errors
    /// The address cannot be bound.
    pub(crate) fn bind(address: SocketAddr, assemblies: Assemblies) -> io::Result<Self> {
        let socket = UdpSocket::bind(address)?;
        socket.set_nonblocking(true)?;
        if address.is_ipv4() {
            // Attribute 8 of the TCP/IP Interface.
            socket.set_multicast_ttl_v4(1)?;
        }
        let local = socket.local_addr()?;
        Self::over(Arc::new(socket), local, assemblies)
    }

    /// Over a socket at an address.
    ///
    /// # Errors
    /// The system has no descriptor left.
    pub(crate) fn over(socket: Arc<dyn Datagrams>, local: SocketAddr, assemblies: Assemblies) -> io::Result<Self> {
        let settings = IoSettings {
            assemblies,
            max_connections: MAX_CONNECTIONS,
            min_interval: lateness::SHORTEST,
            volatile: layout::TICK,
            local,
        };
        Ok(Self {
            connections: Mutex::new(IoConnections::new(settings)),
            socket,
            local,
            epoch: Instant::now(),
            groups: Mutex::default(),
            wake: eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)?,
        })
    }

    /// The address that was really bound.
    pub(crate) fn local(&self) -> SocketAddr {
        self.local
    }

    /// The number of open connections.
    pub(crate) fn open_connections(&self) -> usize {
        lock(&self.connections).len()
    }

    /// The present ownership of the outputs.
    pub(crate) fn ownership(&self) -> Ownership {
        lock(&self.connections).outputs()
    }

    /// Opens a connection for the far end of a TCP connection whose near end is `local`; `group` is where it can be sent
    /// inputs by multicast.
    pub(crate) fn open(
        &self,
        open: &IoOpen<'_>,
        peer: IpAddr,
        local: Ipv4Addr,
        group: Ipv4Addr,
        device: &Device,
        random: impl FnMut() -> Option<u32>,
    ) -> Result<IoOpened, CipStatus> {
        let originator = Originator {
            address: peer,
            port: open.port,
            group: self.local.is_ipv4().then_some(group),
        };
        let (opened, group) = {
            let mut connections = lock(&self.connections);
            let opened = connections.open(open.open, open.application, originator, self.now(), random);
            // A watchdog may have expired meanwhile.
            apply_events(device, &mut connections);
            let id = opened.as_ref().ok().map(|reply| reply.o_to_t_id);
            (opened, id.and_then(|id| connections.group(id)))
        };
        let group = match group {
            Some(SocketAddr::V4(group)) => {
                lock(&self.groups).insert(*group.ip(), local);
                Some(group)
            }
            _ => None,
        };
        // A new watchdog began.
        self.wake();
        let own = match self.local.ip() {
            IpAddr::V4(ip) if ip != local => ip,
            _ => Ipv4Addr::UNSPECIFIED,
        };
        Ok(IoOpened {
            reply: opened?,
            listens: SocketAddrV4::new(own, self.local.port()),
            group,
        })
    }

    /// Sends the datagrams of a group through the address at which its connections opened.
    fn route(&self, group: Ipv4Addr) {
        let via = lock(&self.groups).get(&group).copied();
        if let Some(via) = via
            && let Err(error) = self.socket.send_through(via)
        {
            debug!(%error, %group, %via, "no way to a multicast group");
        }
    }

    /// Lets a connection produce.
    pub(crate) fn start(&self, id: ConnectionId) {
        lock(&self.connections).start(id, self.now());
        self.wake();
    }

    /// Closes a connection that was opened from the same address.
    pub(crate) fn close(&self, key: ConnectionKey, peer: IpAddr, device: &Device) -> bool {
        let closed = {
            let mut connections = lock(&self.connections);
            let closed = connections.close(key, peer).is_ok();
            apply_events(device, &mut connections);
            closed
        };
        self.wake();
        closed
    }

    fn now(&self) -> Duration {
        self.epoch.elapsed()
    }

    fn wake(&self) {
        // Only a full counter refuses, and then the thread is awake.
        let _ = rustix::io::write(&self.wake, &1_u64.to_ne_bytes());
    }
}

/// Applies the events of the connections, in their order and before the connections' lock is released: a client that sees the outputs
/// lost, by a reply or by opening a connection of its own, sees the effect, and motion that it begins then is not stopped by it.
fn apply_events(device: &Device, connections: &mut IoConnections) {
    let (plant, exchange) = (&device.plant, device.assembly_data());
    while let Some(event) = connections.poll_event() {
        match event {
            IoEvent::Outputs(data) => exchange.apply(&data, plant),
            IoEvent::Idle => exchange.lose("their owner has gone idle", plant),
            IoEvent::Ended {
                application,
                cause,
                outputs_lost,
                ..
            } => {
                debug!(?application, ?cause, "I/O connection ended");
                if cause == Ended::TimedOut {
                    (&*device).count(Count::ConnectionTimeouts);
                }
                if outputs_lost {
                    let why = match cause {
                        Ended::TimedOut => "their owner was silent for too long",
                        Ended::Closed | Ended::NothingToHear => "their owner has closed its connection",
                    };
                    exchange.lose(why, plant);
                }
            }
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

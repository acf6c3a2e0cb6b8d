//! The TCP and UDP sockets of the EtherNet/IP port.
//!
//! A permit for every TCP connection is taken before it is accepted, so a crowd waits in the system's backlog instead of
//! in our memory. The work of a connection is [`connection`](super::connection)'s.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4};
use std::sync::Arc;
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream, UdpSocket};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinSet;
use tracing::{Instrument, debug, error, info_span, warn};

use super::device::{Device, Settings};
use super::io::IoThread;
use super::{connection, datagram};
use crate::plant::Plant;

/// Pause after the system refused to accept (out of file descriptors): long enough not to spin.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);
/// Tries to find a port that is free for both TCP and UDP.
const PORT_TRIES: usize = 16;

/// The bound sockets; connections are accepted by the system from now on and served by [`Listener::serve`].
#[derive(Debug)]
pub struct Listener {
    tcp: TcpListener,
    udp: UdpSocket,
    local: SocketAddr,
    device: Arc<Device>,
}

impl Listener {
    /// Binds TCP and UDP to one port of `address`, and UDP to that of implicit I/O; port 0 picks a free one.
    ///
    /// # Errors
    /// An address cannot be bound.
    pub async fn bind(address: SocketAddr, plant: Plant, settings: Settings) -> Result<Self, BindError> {
        let failed = |address| move |error| BindError { address, error };
        let (tcp, udp) = bind_both(address).await.map_err(failed(address))?;
        let local = tcp.local_addr().map_err(failed(address))?;
        let io = settings.io;
        let device = Device::new(plant, settings).map_err(failed(io.unwrap_or(address)))?;
        let device = Arc::new(device);
        Ok(Self {
            tcp,
            udp,
            local,
            device,
        })
    }

    /// The address that was really bound.
    pub fn local_addr(&self) -> SocketAddr {
        self.local
    }

    /// The address of implicit I/O that was really bound, if there is one.
    pub fn io_addr(&self) -> Option<SocketAddr> {
        self.device.io().map(|io| io.local())
    }

    /// Serves until the future is dropped; that closes every connection.
    pub async fn serve(self) {
        // Ends with this future.
        let _io = self.device.io().and_then(|io| {
            IoThread::spawn(self.device.clone(), io.clone())
                .inspect_err(|error| error!(%error, "no thread for implicit I/O: nothing is produced"))
                .ok()
        });
        let permits = Arc::new(Semaphore::new(
            self.device.settings.max_clients.clamp(1, Semaphore::MAX_PERMITS),
        ));
        let mut connections = JoinSet::new();
        let datagrams = datagram::serve(&self.udp, self.local, &self.device);
        let accept = async {
            loop {
                let permit = permits
                    .clone()
                    .acquire_owned()
                    .await
                    .expect("the semaphore is never closed");
                match self.tcp.accept().await {
                    Ok((stream, peer)) => {
                        let span = info_span!("connection", %peer);
                        connections.spawn(serve_one(stream, permit, self.device.clone()).instrument(span));
                    }
                    Err(error) => {
                        warn!(%error, "cannot accept a connection");
                        tokio::time::sleep(ACCEPT_PAUSE).await;
                    }
                }
                while connections.try_join_next().is_some() {}
            }
        };
        tokio::join!(accept, datagrams);
    }
}

/// An address that cannot be bound.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen on {address}: {error}")]
pub struct BindError {
    /// Which.
    pub address: SocketAddr,
    /// Why.
    #[source]
    pub error: io::Error,
}

async fn serve_one(stream: TcpStream, permit: OwnedSemaphorePermit, device: Arc<Device>) {
    if let Err(error) = stream.set_nodelay(true) {
        debug!(%error, "cannot switch off Nagle's algorithm");
    }
    let (Ok(local), Ok(peer)) = (stream.local_addr(), stream.peer_addr()) else {
        return;
    };
    let local = reachable(local, peer).await;
    debug!("connected");
    let ended = connection::serve(stream, local, peer.ip(), device).await;
    connection::report(&ended);
    drop(permit);
}

/// TCP and UDP on the same port. With port 0 the one that TCP got may be taken for UDP: try again.
async fn bind_both(address: SocketAddr) -> io::Result<(TcpListener, UdpSocket)> {
    let mut tries = if address.port() == 0 { PORT_TRIES } else { 1 };
    loop {
        tries -= 1;
        let tcp = TcpListener::bind(address).await?;
        match UdpSocket::bind(tcp.local_addr()?).await {
            Ok(udp) => return Ok((tcp, udp)),
            Err(_) if tries > 0 => {}
            Err(error) => return Err(error),
        }
    }
}

/// An IPv4 address at which `peer` reaches the socket bound to `local`: never 0.0.0.0, which a browser could not connect
/// back to. Connecting a UDP socket sends nothing; it only asks the routing table. IPv6 has no place in an identity item:
/// such a listener tells the loopback address.
pub(super) async fn reachable(local: SocketAddr, peer: SocketAddr) -> SocketAddrV4 {
    let bound = ipv4(local.ip()).filter(|ip| !ip.is_unspecified());
    let ip = match bound {
        Some(ip) => Some(ip),
        None => route_source(peer).await,
    };
    SocketAddrV4::new(ip.unwrap_or(Ipv4Addr::LOCALHOST), local.port())
}

async fn route_source(peer: SocketAddr) -> Option<Ipv4Addr> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).await.ok()?;
    socket.connect((ipv4(peer.ip())?, peer.port())).await.ok()?;
    ipv4(socket.local_addr().ok()?.ip()).filter(|ip| !ip.is_unspecified())
}

fn ipv4(ip: IpAddr) -> Option<Ipv4Addr> {
    match ip {
        IpAddr::V4(ip) => Some(ip),
        IpAddr::V6(ip) => ip.to_ipv4_mapped(),
    }
}

//! The TCP and UDP sockets of the EtherNet/IP port.
//!
//! Every TCP connection gets a slot of the [`limiter`](super::limiter) or is closed at once; no client waits in the system's
//! backlog. The work of a connection is [`connection`](super::connection)'s.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4};
use std::sync::Arc;
use std::time::Duration;

use arcline_config::{AllowList, PlainAccess};
use tokio::net::{TcpListener, TcpStream, UdpSocket};
use tokio::task::JoinSet;
use tracing::{Instrument, debug, error, info_span};

use super::accept::Accept;
use super::connection::{self, Incoming};
use super::datagram;
use super::device::{Device, Settings};
use super::io::IoThread;
use super::limiter::ClientSlot;
use crate::plant::Plant;
use crate::plant::roles::role_of_address;
use crate::tls::Tls;
use crate::work_threads::WorkThreads;

/// Pause after the system refused to accept (out of file descriptors): long enough not to spin.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);
/// Silence before a peer is asked whether it is there, and from one question to the next.
const KEEP_ALIVE_IDLE: Duration = Duration::from_secs(5);
const KEEP_ALIVE_EVERY: Duration = Duration::from_secs(1);
/// Questions without an answer that end a connection.
const KEEP_ALIVE_PROBES: u32 = 5;
/// The longest time for which sent bytes may stay without acknowledgement.
const UNACKNOWLEDGED: Duration = Duration::from_secs(10);
/// Tries to find a port that is free for both TCP and UDP.
const PORT_TRIES: usize = 16;

/// The bound sockets; connections are accepted by the system from now on and served by [`Listener::serve`].
#[derive(Debug)]
pub struct Listener {
    endpoints: Vec<Endpoint>,
    /// The local address of the first listener.
    local: SocketAddr,
    device: Arc<Device>,
}

/// The sockets of one address.
#[derive(Debug)]
struct Endpoint {
    /// `None`: plain EtherNet/IP is off.
    tcp: Option<TcpListener>,
    /// `None`: of TLS, which has no discovery.
    udp: Option<UdpSocket>,
    local: SocketAddr,
    /// The side of TLS; `None`: plain.
    tls: Option<Arc<Tls>>,
}

impl Listener {
    /// Binds TCP and UDP to one port of `address`, and UDP to that of implicit I/O; port 0 picks a free one.
    ///
    /// # Errors
    /// An address cannot be bound.
    pub async fn bind(address: SocketAddr, plant: Plant, mut settings: Settings) -> Result<Self, BindError> {
        let failed = |address| move |error| BindError { address, error };
        let mut endpoints = Vec::new();
        for address in [address].iter().chain(&settings.config.listen_also).copied() {
            let (tcp, udp) = bind_both(address, settings.config.security.plain)
                .await
                .map_err(failed(address))?;
            let local = udp.local_addr().map_err(failed(address))?;
            endpoints.push(Endpoint {
                tcp,
                udp: Some(udp),
                local,
                tls: None,
            });
        }
        if let (Some(tls), Some(address)) = (&settings.tls, settings.config.security.tls) {
            let tcp = TcpListener::bind(address).await.map_err(failed(address))?;
            endpoints.push(Endpoint {
                local: tcp.local_addr().map_err(failed(address))?,
                tcp: Some(tcp),
                udp: None,
                tls: Some(tls.clone()),
            });
        }
        let local = endpoints.first().map_or(address, |endpoint| endpoint.local);
        settings.config.listen = address;
        let io = settings.config.io.address(address);
        let device = Device::new(plant, settings, WorkThreads::Pool).map_err(failed(io.unwrap_or(address)))?;
        let device = Arc::new(device);
        Ok(Self {
            endpoints,
            local,
            device,
        })
    }

    /// Every address that was really bound, the first one first.
    pub fn local_addrs(&self) -> Vec<SocketAddr> {
        let plain = self.endpoints.iter().filter(|endpoint| endpoint.tls.is_none());
        plain.map(|endpoint| endpoint.local).collect()
    }

    /// The first address that was really bound.
    pub fn local_addr(&self) -> SocketAddr {
        self.local
    }

    /// The address of EtherNet/IP over TLS that was really bound, if there is one.
    pub fn tls_addr(&self) -> Option<SocketAddr> {
        let tls = self.endpoints.iter().find(|endpoint| endpoint.tls.is_some());
        tls.map(|endpoint| endpoint.local)
    }

    /// The address of implicit I/O that was really bound, if there is one.
    pub fn io_addr(&self) -> Option<SocketAddr> {
        self.device.io().map(|io| io.local())
    }

    /// Serves until the future is dropped; that closes every connection.
    pub async fn serve(self) {
        // The thread ends with this future.
        let _io = self.device.io().and_then(|io| {
            IoThread::spawn(self.device.clone(), io.clone())
                .inspect_err(|error| error!(%error, "no thread for implicit I/O: nothing is produced"))
                .ok()
        });
        let endpoints = self.endpoints.iter().map(|endpoint| endpoint.serve(&self.device));
        let certificates = async {
            if let Some(tls) = &self.device.settings.tls {
                tls.watch(&self.device.plant).await;
            }
        };
        tokio::join!(futures_util::future::join_all(endpoints), certificates);
    }
}

impl Endpoint {
    async fn serve(&self, device: &Arc<Device>) {
        let datagrams = async {
            if let Some(udp) = &self.udp {
                datagram::serve(udp, self.local, device).await;
            }
        };
        let accept = async {
            match (&self.tcp, &self.tls) {
                (None, _) => {}
                (Some(tcp), None) => accept_clients(tcp, device).await,
                (Some(tcp), Some(tls)) => {
                    let allow = &device.settings.config.security.tls_allow;
                    accept_each(tcp, device, allow, |stream, slot, device| {
                        serve_tls(stream, slot, device, tls.clone())
                    })
                    .await;
                }
            }
        };
        tokio::join!(accept, datagrams);
    }
}

/// Serves every client that comes in, until the future is dropped; that closes every connection.
pub(super) async fn accept_clients<A: Accept>(listener: &A, device: &Arc<Device>) {
    let allow = &device.settings.config.security.plain_allow;
    accept_each(listener, device, allow, serve_one::<A>).await;
}

async fn accept_each<A: Accept, F>(
    listener: &A,
    device: &Arc<Device>,
    allow: &AllowList,
    serve: impl Fn(A::Stream, ClientSlot, Arc<Device>) -> F,
) where
    F: Future<Output = ()> + Send + 'static,
{
    let mut connections = JoinSet::new();
    loop {
        let accepted = tokio::select! {
            biased;
            // The memory of a connection that has ended is free at once, not when the next client comes.
            Some(_) = connections.join_next() => continue,
            accepted = listener.accept() => accepted,
        };
        match accepted {
            Ok((_, peer)) if !allow.allows(peer.ip()) => {
                device.plant.log_limit().warn("allow", Some(peer.ip()), || {
                    format!(
                        "a client was closed: {} is in no network of the listener's list",
                        peer.ip()
                    )
                });
            }
            Ok((stream, peer)) => match device.limiter.enter(peer.ip()) {
                Some(slot) => {
                    let span = info_span!("connection", %peer);
                    connections.spawn(serve(stream, slot, device.clone()).instrument(span));
                }
                None => device.plant.log_limit().warn("full", Some(peer.ip()), || {
                    "a client was closed, since all places of EtherNet/IP are taken".to_owned()
                }),
            },
            Err(error) => {
                let text = || format!("cannot accept a connection: {error}");
                device.plant.log_limit().warn("accept", None, text);
                device.limiter.make_room();
                tokio::time::sleep(ACCEPT_PAUSE).await;
            }
        }
    }
}

/// An address that cannot be bound.
#[derive(Debug, thiserror::Error)]
#[error("cannot listen on {address}: {error}")]
pub struct BindError {
    /// Which.
    pub address: SocketAddr,
    /// The error of the system.
    #[source]
    pub error: io::Error,
}

async fn serve_one<A: Accept>(stream: A::Stream, slot: ClientSlot, device: Arc<Device>) {
    let Some((local, peer)) = A::prepare(&stream, &device).await else {
        return;
    };
    debug!("connected");
    let incoming = Incoming {
        slot: Some(slot),
        local,
        peer,
        role: role_of_address(&device.settings.config.security, peer),
        tls: None,
    };
    let ended = connection::serve_in(incoming, stream, device).await;
    connection::report(&ended);
}

/// Serves a client when it has shown a certificate.
async fn serve_tls(stream: TcpStream, slot: ClientSlot, device: Arc<Device>, tls: Arc<Tls>) {
    let Some((local, peer)) = TcpListener::prepare(&stream, &device).await else {
        return;
    };
    let (stream, client) = match tls.accept(stream, peer).await {
        Ok(accepted) => accepted,
        Err(failed) => return tls.log_failed(device.plant.log_limit(), peer, &failed),
    };
    let role = tls.role_of(&client);
    debug!(
        client = client.name(),
        role = role.word(),
        "a client showed its certificate"
    );
    let incoming = Incoming {
        slot: Some(slot),
        local,
        peer,
        role,
        tls: Some((tls, client)),
    };
    let ended = connection::serve_in(incoming, stream, device).await;
    connection::report(&ended);
}

impl Accept for TcpListener {
    type Stream = TcpStream;

    async fn accept(&self) -> io::Result<(TcpStream, SocketAddr)> {
        TcpListener::accept(self).await
    }

    async fn prepare(stream: &TcpStream, device: &Device) -> Option<(SocketAddrV4, IpAddr)> {
        if let Err(error) = stream.set_nodelay(true) {
            debug!(%error, "cannot switch off Nagle's algorithm");
        }
        let (Ok(local), Ok(peer)) = (stream.local_addr(), stream.peer_addr()) else {
            return None;
        };
        let local = reachable(local, peer).await;
        device.adapters.prepare(*local.ip());
        if let Err(error) = keep_alive(stream) {
            debug!(%error, "a pulled cable will be noticed late");
        }
        Some((local, peer.ip()))
    }
}

/// Makes the system probe a silent peer and give up bytes that the peer does not acknowledge. A pulled cable ends the connection within some
/// seconds; the silence of a healthy client does not.
fn keep_alive(stream: &TcpStream) -> rustix::io::Result<()> {
    use rustix::net::sockopt;
    sockopt::set_socket_keepalive(stream, true)?;
    sockopt::set_tcp_keepidle(stream, KEEP_ALIVE_IDLE)?;
    sockopt::set_tcp_keepintvl(stream, KEEP_ALIVE_EVERY)?;
    sockopt::set_tcp_keepcnt(stream, KEEP_ALIVE_PROBES)?;
    sockopt::set_tcp_user_timeout(stream, UNACKNOWLEDGED.as_millis() as u32)
}

/// TCP and UDP on the same port. With port 0 the one that TCP got may be taken for UDP: try again.
async fn bind_both(address: SocketAddr, plain: PlainAccess) -> io::Result<(Option<TcpListener>, UdpSocket)> {
    if plain == PlainAccess::Off {
        return Ok((None, UdpSocket::bind(address).await?));
    }
    let mut tries = if address.port() == 0 { PORT_TRIES } else { 1 };
    loop {
        tries -= 1;
        let tcp = TcpListener::bind(address).await?;
        match UdpSocket::bind(tcp.local_addr()?).await {
            Ok(udp) => return Ok((Some(tcp), udp)),
            Err(_) if tries > 0 => {}
            Err(error) => return Err(error),
        }
    }
}

/// An IPv4 address at which `peer` reaches the socket bound to `local`: never 0.0.0.0, which a browser could not connect
/// back to. Connecting a UDP socket sends nothing; it only asks the routing table. An identity item has no room for IPv6:
/// such a listener shows the loopback address.
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

//! The listener on a network of the caller's: clients come in through a channel, and everything behind them is the listener's.

use std::fmt;
use std::future::Future;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4};
use std::os::fd::OwnedFd;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::{Mutex, mpsc};

use super::accept::Accept;
use super::connection::Socket;
use super::device::{Device, Settings};
use super::io::IoTurns;
use super::listener::accept_clients;
use crate::plant::Plant;
use crate::work_threads::WorkThreads;

/// Both directions of a connection.
pub trait Duplex: AsyncRead + AsyncWrite + Unpin + Send {}

impl<S: AsyncRead + AsyncWrite + Unpin + Send> Duplex for S {}

/// A client that comes in: its stream and its address; or the error of an accept.
pub(crate) type Incoming = io::Result<(Box<dyn Duplex>, SocketAddr)>;

/// The EtherNet/IP interface on such a network.
#[derive(Debug)]
pub(crate) struct SteppedInterface {
    device: Arc<Device>,
    incoming: mpsc::UnboundedSender<Incoming>,
    io: Option<IoTurns>,
}

/// The number of clients and connections that the server serves.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Held {
    /// Connections of the network that are served.
    pub clients: usize,
    /// Class 3 connections that are open.
    pub connections: usize,
    /// Class 0 and 1 connections that are open.
    pub io: usize,
    /// Connections of browsers, and viewers.
    pub browsers: usize,
}

impl SteppedInterface {
    /// Serves clients on the runtime of the caller.
    ///
    /// # Errors
    /// The address of implicit I/O cannot be bound.
    pub(crate) fn start(plant: Plant, settings: Settings) -> io::Result<Self> {
        let device = Arc::new(Device::new(plant, settings, WorkThreads::Caller)?);
        let (incoming, clients) = mpsc::unbounded_channel();
        let served = device.clone();
        tokio::spawn(async move {
            let network = Network(Mutex::new(clients));
            accept_clients(&network, &served).await;
        });
        let io = device.io().map(|io| IoTurns::new(device.clone(), io.clone()));
        Ok(SteppedInterface { device, incoming, io })
    }

    /// A turn of implicit I/O.
    pub(crate) fn exchange(&mut self) {
        if let Some(io) = &mut self.io {
            io.turn();
        }
    }

    /// A client comes in.
    pub(crate) fn connect(&self, client: Incoming) {
        // The task that takes it lives as long as the runtime.
        let _ = self.incoming.send(client);
    }

    /// The number of clients and connections that the server serves.
    pub(crate) fn held(&self) -> Held {
        Held {
            clients: self.device.limiter.clients(),
            connections: self.device.open_connections(),
            io: self.device.io().map_or(0, |io| io.open_connections()),
            browsers: 0,
        }
    }
}

/// The network's end at which clients come in.
struct Network(Mutex<mpsc::UnboundedReceiver<Incoming>>);

impl Accept for Network {
    type Stream = Remote;

    async fn accept(&self) -> io::Result<(Remote, SocketAddr)> {
        match self.0.lock().await.recv().await {
            Some(incoming) => incoming.map(|(stream, peer)| (Remote { stream, peer }, peer)),
            None => std::future::pending().await,
        }
    }

    fn prepare(stream: &Remote, _: &Device) -> impl Future<Output = Option<(SocketAddrV4, IpAddr)>> + Send {
        std::future::ready(Some((LOCAL, stream.peer.ip())))
    }
}

/// The server's end of a connection.
struct Remote {
    stream: Box<dyn Duplex>,
    peer: SocketAddr,
}

impl fmt::Debug for Remote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Remote({})", self.peer)
    }
}

impl Socket for Remote {
    fn far_end(&self) -> Option<SocketAddr> {
        Some(self.peer)
    }

    fn duplicate(&self) -> Option<OwnedFd> {
        None
    }

    fn ended(&self) -> impl Future<Output = ()> + Send {
        std::future::pending()
    }
}

impl AsyncRead for Remote {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut *self.stream).poll_read(cx, buf)
    }
}

impl AsyncWrite for Remote {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut *self.stream).poll_write(cx, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut *self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut *self.stream).poll_shutdown(cx)
    }
}

/// The device's address in that network.
const LOCAL: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(10, 0, 0, 1), 44818);

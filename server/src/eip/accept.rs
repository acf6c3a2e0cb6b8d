//! The seam between the listener and the sockets of the system: how clients come in.

use std::future::Future;
use std::io;
use std::net::{IpAddr, SocketAddr, SocketAddrV4};

use tokio::io::{AsyncRead, AsyncWrite};

use super::connection::Socket;
use super::device::Device;

/// A source of client connections: a TCP listener, or the network of a simulation (`stepped`).
pub(crate) trait Accept: 'static {
    /// The connection of a client.
    type Stream: AsyncRead + AsyncWrite + Unpin + Socket + Send + 'static;

    /// Waits for the next client. Returns its stream and its address.
    ///
    /// # Errors
    /// The system's, such as a lack of file descriptors.
    fn accept(&self) -> impl Future<Output = io::Result<(Self::Stream, SocketAddr)>> + Send;

    /// Prepares a stream to be served: the local address at which its client reaches the device, and the client's address. `None`: it has
    /// closed already.
    fn prepare(stream: &Self::Stream, device: &Device) -> impl Future<Output = Option<(SocketAddrV4, IpAddr)>> + Send;
}

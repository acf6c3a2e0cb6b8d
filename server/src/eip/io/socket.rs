//! The seam between implicit I/O and its socket.

use std::fmt::Debug;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};

use rustix::net::sockopt::set_ip_multicast_if;

/// A socket for datagrams that never waits: UDP of the system, or the network of a simulation (`stepped`).
pub trait Datagrams: Debug + Send + Sync {
    /// Takes the next datagram that has arrived into `buf`: its length and its sender.
    ///
    /// # Errors
    /// Nothing has arrived, or the system's.
    fn receive(&self, buf: &mut [u8]) -> io::Result<(usize, SocketAddr)>;

    /// Sends a datagram.
    ///
    /// # Errors
    /// The system's.
    fn send(&self, bytes: &[u8], to: SocketAddr) -> io::Result<()>;

    /// Sends all further datagrams to groups through the adapter with this address.
    ///
    /// # Errors
    /// The system's.
    fn send_through(&self, adapter: Ipv4Addr) -> io::Result<()>;

    /// The descriptor that shows that a datagram has arrived, if there is one.
    fn descriptor(&self) -> Option<BorrowedFd<'_>>;
}

/// A socket that does not block.
impl Datagrams for UdpSocket {
    fn receive(&self, buf: &mut [u8]) -> io::Result<(usize, SocketAddr)> {
        self.recv_from(buf)
    }

    fn send(&self, bytes: &[u8], to: SocketAddr) -> io::Result<()> {
        self.send_to(bytes, to).map(drop)
    }

    fn send_through(&self, adapter: Ipv4Addr) -> io::Result<()> {
        Ok(set_ip_multicast_if(self, &adapter)?)
    }

    fn descriptor(&self) -> Option<BorrowedFd<'_>> {
        Some(self.as_fd())
    }
}

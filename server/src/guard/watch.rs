//! A watch on the socket of a client that jogs, beside the task that reads the socket: arriving data are a sign of life, and the watch
//! detects the close of the socket at once. It reads no data.

use std::io::{self, ErrorKind};
use std::os::fd::OwnedFd;
use std::time::Duration;

use rustix::io::Errno;
use rustix::net::{RecvFlags, recv};
use tokio::io::Interest;
use tokio::net::TcpStream;
use tokio_util::sync::CancellationToken;
use tracing::debug;

use super::{Guard, Signs};

/// The time that the task which reads a socket has for the data before the end: an UnRegisterSession closes in order.
const GRACE: Duration = Duration::from_millis(20);

/// Looks until the socket closes, or `ended`.
pub(super) async fn socket(guard: Guard, session: u64, socket: OwnedFd, signs: Signs, ended: CancellationToken) {
    let socket = match TcpStream::from_std(socket.into()) {
        Ok(socket) => socket,
        Err(error) => {
            debug!(%error, "the socket of a jogging client is not watched");
            return;
        }
    };
    if ended.run_until_cancelled(closed(&socket, &signs)).await.is_none() {
        return;
    }
    if !is_reset(&socket) && ended.run_until_cancelled(tokio::time::sleep(GRACE)).await.is_none() {
        return;
    }
    guard.lose(session);
}

/// Waits until the far end sends nothing more.
async fn closed(socket: &TcpStream, signs: &Signs) {
    while let Ok(ready) = socket.ready(Interest::READABLE).await {
        if ready.is_read_closed() {
            return;
        }
        signs.heard();
        // Clear the readiness as if everything had been read, so that the next data wake this task again.
        let _ = socket.try_io(Interest::READABLE, || {
            Err::<(), _>(io::Error::from(ErrorKind::WouldBlock))
        });
    }
}

/// Whether the peer has reset the connection, and not only ended its sending.
fn is_reset(socket: &TcpStream) -> bool {
    let mut byte = [0_u8; 1];
    let peeked = recv(socket, &mut byte[..], RecvFlags::PEEK | RecvFlags::DONTWAIT);
    matches!(peeked, Err(error) if error != Errno::AGAIN && error != Errno::INTR)
}

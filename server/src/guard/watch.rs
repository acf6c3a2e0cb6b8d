//! A look at the socket of a client that jogs, beside the task that reads it: what comes is a sign of life, and that it closes is known
//! at once. Nothing is read.

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

/// How long the task that reads a socket has for what came before its end: an UnRegisterSession closes in order.
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
        // As if everything had been read: what comes next is told again.
        let _ = socket.try_io(Interest::READABLE, || {
            Err::<(), _>(io::Error::from(ErrorKind::WouldBlock))
        });
    }
}

/// Whether the far end has cut the connection, and not only said that it sends nothing more.
fn is_reset(socket: &TcpStream) -> bool {
    let mut byte = [0_u8; 1];
    let peeked = recv(socket, &mut byte[..], RecvFlags::PEEK | RecvFlags::DONTWAIT);
    matches!(peeked, Err(error) if error != Errno::AGAIN && error != Errno::INTR)
}

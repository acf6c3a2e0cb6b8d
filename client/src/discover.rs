//! Finds servers by ListIdentity over UDP.

use std::net::{SocketAddr, SocketAddrV4};
use std::time::Duration;

use bytes::Bytes;
use tokio::net::UdpSocket;
use tokio::time::{Instant, timeout_at};

use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, SessionHandle};
use arcline_proto::identity::Identity;

use crate::ClientError;

/// Highest number of answers.
const MAX_ANSWERS: usize = 1024;
/// Milliseconds over which servers may spread their answers; in the first two bytes of the sender context.
const SPREAD_MS: u16 = 200;

/// A server that answered.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Discovered {
    /// The address that sent the answer.
    pub from: SocketAddr,
    /// The address in the answer, on which the server says it listens.
    pub listens: SocketAddrV4,
    /// Its identity.
    pub identity: Identity,
}

/// Asks `address` (a broadcast address and port 44818, or one server) for identities, and listens for `wait`.
/// Answers that cannot be read are left out; each server is listed once.
///
/// # Errors
/// [`ClientError::Connect`] when no socket can be had or nothing can be sent.
///
/// ```no_run
/// # async fn example() -> Result<(), arcline_client::ClientError> {
/// let wait = std::time::Duration::from_millis(500);
/// for found in arcline_client::discover("255.255.255.255:44818", wait).await? {
///     println!("{} {}", found.from, found.identity.name());
/// }
/// # Ok(())
/// # }
/// ```
pub async fn discover(address: &str, wait: Duration) -> Result<Vec<Discovered>, ClientError> {
    let failed = |source| ClientError::Connect {
        address: address.to_owned(),
        source,
    };
    let socket = UdpSocket::bind("0.0.0.0:0").await.map_err(failed)?;
    socket.set_broadcast(true).map_err(failed)?;
    let [low, high] = SPREAD_MS.to_le_bytes();
    let context = [low, high, b'a', b'r', b'c', b'l', b'i', b'n'];
    let request = EncapFrame::request(Command::LIST_IDENTITY, SessionHandle::default(), context, Bytes::new());
    socket.send_to(&request.to_bytes(), address).await.map_err(failed)?;

    let deadline = Instant::now() + wait;
    let mut found: Vec<Discovered> = Vec::new();
    let mut buffer = [0; 1500];
    while let Ok(Ok((length, from))) = timeout_at(deadline, socket.recv_from(&mut buffer)).await {
        let answer = buffer.get(..length).and_then(read_answer);
        if let Some((listens, identity)) = answer
            && found.len() < MAX_ANSWERS
            && !found.iter().any(|known| known.from == from)
        {
            found.push(Discovered {
                from,
                listens,
                identity,
            });
        }
    }
    Ok(found)
}

fn read_answer(datagram: &[u8]) -> Option<(SocketAddrV4, Identity)> {
    let frame = FrameDecoder::default().decode_datagram(datagram)?;
    if frame.header.command != Command::LIST_IDENTITY {
        return None;
    }
    Identity::decode_list(&frame.data)
}

//! Discovery over UDP: ListIdentity, ListServices and ListInterfaces, unicast and broadcast (spec/ethernet-ip.md §2).
//!
//! The answers themselves come from [`discovery`] of `arcline-proto`. This module has the socket, the address to which a peer can connect
//! back, and the random delay that spreads the answers to a broadcast.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use arcline_proto::discovery;
use bytes::Bytes;
use tokio::net::UdpSocket;
use tokio::task::JoinSet;
use tokio::time::Instant;
use tracing::debug;

use super::device::Device;
use super::listener::reachable;
use crate::limits::AddressRate;

/// Delayed answers that may wait at a time; more requests are dropped, as UDP may drop them.
const MAX_WAITING: usize = 64;
/// Answers to one address a second: an answer is longer than its request, and its sender may be forged.
const ANSWERS: u32 = 10;
/// The longest datagram that the server reads; a list request has 24 bytes.
const MAX_DATAGRAM: usize = 1500;

/// Answers datagrams for ever.
pub(super) async fn serve(socket: &UdpSocket, local: SocketAddr, device: &Arc<Device>) {
    let mut buf = [0_u8; MAX_DATAGRAM];
    let mut waiting: JoinSet<(Bytes, SocketAddr)> = JoinSet::new();
    let mut rate = AddressRate::new(ANSWERS);
    loop {
        let received = tokio::select! {
            received = socket.recv_from(&mut buf) => received,
            Some(ready) = waiting.join_next(), if !waiting.is_empty() => {
                if let Ok((bytes, peer)) = ready {
                    send(socket, &bytes, peer).await;
                }
                continue;
            }
        };
        let (length, peer) = match received {
            Ok(received) => received,
            Err(error) => {
                // An ICMP error for an earlier datagram; the socket remains usable.
                debug!(%error, "UDP receive");
                tokio::task::yield_now().await;
                continue;
            }
        };
        let Some(datagram) = buf.get(..length) else { continue };
        if !device.settings.config.security.plain_allow.allows(peer.ip()) {
            continue;
        }
        if !peer.ip().is_loopback() && !rate.allows(peer.ip(), Instant::now()) {
            continue;
        }
        let address = reachable(local, peer).await;
        let capability = device.settings.session.capability;
        let Some(answer) = discovery::answer(datagram, &device.settings.identity, capability, address) else {
            continue;
        };
        let bytes = answer.frame.to_bytes();
        // Only a socket on all addresses receives broadcasts.
        let delay = if local.ip().is_unspecified() {
            random_up_to(answer.max_delay)
        } else {
            Duration::ZERO
        };
        if delay.is_zero() {
            send(socket, &bytes, peer).await;
        } else if waiting.len() < MAX_WAITING {
            waiting.spawn(async move {
                tokio::time::sleep(delay).await;
                (bytes, peer)
            });
        }
    }
}

async fn send(socket: &UdpSocket, bytes: &[u8], peer: SocketAddr) {
    if let Err(error) = socket.send_to(bytes, peer).await {
        debug!(%error, %peer, "UDP send");
    }
}

/// Spreads the answers to a broadcast. If the random numbers fail, only the spread is lost.
fn random_up_to(limit: Duration) -> Duration {
    limit.mul_f64(f64::from(getrandom::u32().unwrap_or_default()) / f64::from(u32::MAX))
}

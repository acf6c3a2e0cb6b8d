//! One TCP connection: frames in, the session's rules, requests to the router, replies out.
//!
//! Requests of one connection are executed one after the other, in the order in which they came. While a peer does not
//! read its replies, nothing more is read from it; after [`Settings::write_timeout`](super::Settings) it is closed.

use std::net::{IpAddr, SocketAddrV4};
use std::sync::Arc;
use std::time::Duration;

use arcline_proto::encap::{EncapStatus, Frame, FrameError};
use arcline_proto::session::{CloseReason, Event, ServerSession};
use futures_util::{FutureExt, SinkExt, StreamExt};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::time::{Instant, sleep_until, timeout};
use tokio_util::codec::Framed;
use tracing::debug;

use super::codec::{FrameCodec, StreamError};
use super::crowd::Place;
use super::device::{Device, Seat};
use super::router::Router;

/// Frames that are taken from one connection before the others get their turn.
const BATCH: usize = 32;

/// How long a changed inactivity time-out may go unnoticed.
const LOOK: Duration = Duration::from_secs(1);

/// Why a connection ended.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Ended {
    /// The peer closed the socket.
    #[error("the peer closed the socket")]
    ByPeer,
    /// The session ended by its own rules.
    #[error(transparent)]
    Session(#[from] CloseReason),
    /// The socket or the stream failed.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// The peer does not read.
    #[error("the peer did not read its replies in time")]
    SlowReader,
    /// Too many clients, and this one had no session.
    #[error("too many clients, and this one had no session")]
    Crowded,
}

/// Serves a stream that has no place among the device's clients.
#[cfg(test)]
pub(crate) async fn serve<S>(stream: S, local: SocketAddrV4, peer: IpAddr, device: Arc<Device>) -> Ended
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    serve_in(None, stream, local, peer, device).await
}

/// Serves a stream that was accepted at `local` from `peer` until it ends, in a place among the device's clients.
pub(crate) async fn serve_in<S>(
    place: Option<Place>,
    stream: S,
    local: SocketAddrV4,
    peer: IpAddr,
    device: Arc<Device>,
) -> Ended
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let leave = place.as_ref().map(Place::leave).unwrap_or_default();
    let codec = FrameCodec::new(device.settings.session.frame_limit);
    let epoch = Instant::now();
    let mut connection = Connection {
        framed: Framed::new(stream, codec),
        session: ServerSession::new(device.session_settings.clone(), local, Duration::ZERO),
        router: Router::new(device.clone(), local),
        local,
        peer,
        place,
        device,
        epoch,
    };
    let ended = tokio::select! {
        ended = connection.run() => ended,
        () = leave.notified() => Ended::Crowded,
    };
    let mut seat = Seat {
        device: &connection.device,
        local,
        peer,
    };
    connection.session.handle_disconnect(&mut seat);
    ended
}

struct Connection<S> {
    framed: Framed<S, FrameCodec>,
    session: ServerSession,
    router: Router,
    local: SocketAddrV4,
    peer: IpAddr,
    place: Option<Place>,
    device: Arc<Device>,
    epoch: Instant,
}

impl<S: AsyncRead + AsyncWrite + Unpin> Connection<S> {
    async fn run(&mut self) -> Ended {
        match self.serve_frames().await {
            Ok(never) => match never {},
            Err(ended) => {
                // What was answered before the end still leaves, if the peer takes it.
                let _ = self.flush().await;
                ended
            }
        }
    }

    async fn serve_frames(&mut self) -> Result<std::convert::Infallible, Ended> {
        loop {
            self.session.set_inactivity(self.device.inactivity());
            // A client may set another inactivity time-out: that is looked at now and then.
            let look = self.now() + LOOK;
            let due = self.session.poll_timeout().map(|time| self.epoch + time.min(look));
            let next = tokio::select! {
                next = self.framed.next() => next,
                () = sleep_until(due.unwrap_or(self.epoch)), if due.is_some() => {
                    let now = self.now();
                    let (device, local, peer) = (&*self.device, self.local, self.peer);
                    let mut seat = Seat { device, local, peer };
                    self.session.handle_timeout(now, &mut seat);
                    self.carry_out().await?;
                    continue;
                }
            };
            self.take(next).await?;
            // Whatever has come in the meantime is answered in the same segment.
            for _ in 1..BATCH {
                let Some(next) = self.framed.next().now_or_never() else {
                    break;
                };
                self.take(next).await?;
            }
            self.flush().await?;
            tokio::task::yield_now().await;
        }
    }

    /// Handles one frame, or the end of the stream.
    async fn take(&mut self, next: Option<Result<Frame, StreamError>>) -> Result<(), Ended> {
        let now = self.now();
        match next {
            Some(Ok(frame)) => {
                let (device, local, peer) = (&*self.device, self.local, self.peer);
                let mut seat = Seat { device, local, peer };
                self.session.handle_frame(&frame, now, &mut seat);
            }
            Some(Err(StreamError::Frame(error))) => {
                let FrameError::TooLong { header, .. } = error;
                self.send(Frame::error(&header, EncapStatus::INVALID_LENGTH).to_bytes())
                    .await?;
                return Err(StreamError::Frame(error).into());
            }
            Some(Err(error)) => return Err(error.into()),
            None => return Err(Ended::ByPeer),
        }
        if let Some(place) = &mut self.place
            && self.session.is_registered()
        {
            place.register();
        }
        self.carry_out().await
    }

    /// Does what the session wants until it wants no more.
    async fn carry_out(&mut self) -> Result<(), Ended> {
        while let Some(event) = self.session.poll_event() {
            match event {
                Event::Outgoing(bytes) => self.send(bytes).await?,
                Event::Request {
                    id,
                    request,
                    reply_budget,
                    transport,
                } => {
                    let reply = self.router.handle(&request, reply_budget, transport).await;
                    let now = self.now();
                    self.session.reply(id, &reply, now);
                }
                Event::IoReady(id) => {
                    self.flush().await?;
                    if let Some(io) = self.device.io() {
                        io.start(id);
                    }
                }
                Event::Close(reason) => return Err(reason.into()),
            }
        }
        Ok(())
    }

    /// Queues a frame; waits for the peer when the queue is full.
    async fn send(&mut self, bytes: bytes::Bytes) -> Result<(), Ended> {
        let limit = self.device.settings.write_timeout;
        timeout(limit, self.framed.feed(bytes))
            .await
            .map_err(|_| Ended::SlowReader)?
            .map_err(Ended::from)
    }

    async fn flush(&mut self) -> Result<(), Ended> {
        if self.framed.write_buffer().is_empty() {
            return Ok(());
        }
        let limit = self.device.settings.write_timeout;
        timeout(limit, self.framed.flush())
            .await
            .map_err(|_| Ended::SlowReader)?
            .map_err(Ended::from)
    }

    fn now(&self) -> Duration {
        self.epoch.elapsed()
    }
}

/// Says once why a connection ended: a peer's fault is not ours, so it is only worth a debug line.
pub(crate) fn report(ended: &Ended) {
    debug!(reason = %ended, "connection closed");
}

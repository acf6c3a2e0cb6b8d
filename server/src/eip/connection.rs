//! One TCP connection: frames in, the session's rules, requests to the router, replies out.
//!
//! Requests of one connection are executed one after the other, in the order in which they came. While a peer does not
//! read its replies, nothing more is read from it; after [`Settings::write_timeout`](super::Settings) it is closed.

use std::future::Future;
use std::net::{IpAddr, SocketAddr, SocketAddrV4};
use std::os::fd::{AsFd as _, OwnedFd};
use std::pin::{Pin, pin};
use std::sync::{Arc, Weak};
use std::task::Poll;
use std::time::Duration;

use arcline_proto::encap::{EncapStatus, Frame, FrameDecoder, FrameError};
use arcline_proto::session::{CloseReason, Event, ServerSession};
use bytes::{Bytes, BytesMut};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, Sleep, sleep_until, timeout};
use tracing::{debug, warn};

use super::crowd::Place;
use super::device::{Device, Seat};
use super::router::Router;
use crate::guard::Signs;

/// How long the frames of one connection are taken before the others get their turn: whatever a client sends, the others wait for
/// one of its messages, or for as many as take no longer than this.
const TURN: Duration = Duration::from_micros(50);

/// Turns before replies that wait to be sent together leave.
const TURNS: u32 = 16;

/// Room for what a peer sends before it waits for an answer, bytes; more than that makes the buffer grow.
const READ: usize = 4096;

/// Replies that wait to be sent together, bytes; more are sent at once.
const WRITE: usize = 16 * 1024;

/// How long a changed inactivity time-out may go unnoticed.
const LOOK: Duration = Duration::from_secs(1);

/// From one question to the next of a peer that wants its answer for nothing else than to go on asking.
const BRISK: Duration = Duration::from_micros(200);

/// How often it is looked whether such a peer has asked again before the thread sleeps: to be woken takes longer than such a
/// peer does. A peer that takes its time finds the thread asleep, so that this costs no more than its questions.
const LOOKS: u32 = 40;

/// Why a connection ended.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Ended {
    /// The peer closed the socket.
    #[error("the peer closed the socket")]
    ByPeer,
    /// The session ended by its own rules.
    #[error(transparent)]
    Session(#[from] CloseReason),
    /// The socket failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The peer sent what is no frame.
    #[error(transparent)]
    Frame(#[from] FrameError),
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
    S: AsyncRead + AsyncWrite + Unpin + Socket,
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
    S: AsyncRead + AsyncWrite + Unpin + Socket,
{
    let leave = place.as_ref().map(Place::leave).unwrap_or_default();
    let epoch = Instant::now();
    let number = device.number_session();
    let name = match stream.far_end() {
        Some(address) => address.to_string(),
        None => peer.to_string(),
    };
    let face: Weak<Device> = Arc::downgrade(&device);
    let signs = device.plant.guard().enter(number, &name, face);
    let mut connection = Connection {
        number,
        stream,
        decoder: FrameDecoder::new(device.settings.session.frame_limit),
        input: BytesMut::with_capacity(READ),
        output: Output::default(),
        session: ServerSession::new(device.session_settings.clone(), local, Duration::ZERO),
        router: Router::new(device.clone(), local, number),
        local,
        peer,
        place,
        device,
        epoch,
        now: Duration::ZERO,
        is_brisk: false,
        signs,
    };
    let ended = leave.run_until_cancelled(connection.run()).await;
    let ended = ended.unwrap_or(Ended::Crowded);
    connection.session.handle_disconnect(&mut Seat {
        device: &connection.device,
        local,
        peer,
        session: number,
    });
    let in_order = matches!(ended, Ended::Session(CloseReason::Unregistered));
    connection.device.end_session(number, in_order);
    connection.device.plant.guard().leave(number);
    ended
}

struct Connection<S> {
    /// The session's number.
    number: u64,
    stream: S,
    decoder: FrameDecoder,
    /// What has come and was not taken yet.
    input: BytesMut,
    /// What waits to be sent.
    output: Output,
    session: ServerSession,
    router: Router,
    local: SocketAddrV4,
    peer: IpAddr,
    place: Option<Place>,
    device: Arc<Device>,
    epoch: Instant,
    /// The time since the epoch when something was waited for last: what is done at once takes none.
    now: Duration,
    /// Whether the peer asked its last question as soon as it had its answer.
    is_brisk: bool,
    /// What the guard of jogs hears of the peer.
    signs: Signs,
}

/// Frames that wait to be sent: the only one as it is, several in one piece.
#[derive(Debug, Default)]
struct Output {
    first: Bytes,
    others: BytesMut,
}

impl Output {
    fn push(&mut self, frame: Bytes) {
        if self.is_empty() {
            self.first = frame;
            return;
        }
        if self.others.is_empty() {
            self.others.extend_from_slice(&std::mem::take(&mut self.first));
        }
        self.others.extend_from_slice(&frame);
    }

    fn len(&self) -> usize {
        self.first.len() + self.others.len()
    }

    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn take(&mut self) -> Bytes {
        if self.first.is_empty() {
            self.others.split().freeze()
        } else {
            std::mem::take(&mut self.first)
        }
    }
}

/// What a stream is on which a client came in.
pub(crate) trait Socket {
    /// The far end, if it has an address.
    fn far_end(&self) -> Option<SocketAddr>;
    /// Another descriptor of the same socket, if it is one of the system's.
    fn duplicate(&self) -> Option<OwnedFd>;
}

impl Socket for TcpStream {
    fn far_end(&self) -> Option<SocketAddr> {
        self.peer_addr().ok()
    }

    fn duplicate(&self) -> Option<OwnedFd> {
        let duplicate = self.as_fd().try_clone_to_owned();
        duplicate
            .inspect_err(|error| warn!(%error, "the socket of a client that jogs is not looked at"))
            .ok()
    }
}

#[cfg(test)]
impl Socket for tokio::io::DuplexStream {
    fn far_end(&self) -> Option<SocketAddr> {
        None
    }

    fn duplicate(&self) -> Option<OwnedFd> {
        None
    }
}

impl<S: AsyncRead + AsyncWrite + Unpin + Socket> Connection<S> {
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
        let mut timer = pin!(sleep_until(self.epoch + LOOK));
        let mut turns = 0;
        loop {
            let more = self.take_frames().await?;
            turns += 1;
            // What came together is answered together, but for what takes its time.
            if !more || turns % TURNS == 0 {
                self.flush().await?;
            }
            if more {
                tokio::task::yield_now().await;
            } else {
                turns = 0;
                self.wait(timer.as_mut()).await?;
            }
        }
    }

    /// Waits until more has come, and does what is due meanwhile.
    async fn wait(&mut self, mut timer: Pin<&mut Sleep>) -> Result<(), Ended> {
        self.session.set_inactivity(self.device.inactivity());
        // A client may set another inactivity time-out: that is looked at now and then.
        let next = self.now + LOOK;
        let due = self.epoch + self.session.poll_timeout().map_or(next, |time| time.min(next));
        // To wind the timer costs more than to wake up in vain: only when it would be too late, or has run down.
        if due < timer.deadline() || timer.is_elapsed() {
            timer.as_mut().reset(due);
        }
        self.input.reserve(READ);
        let mut read = pin!(self.stream.read_buf(&mut self.input));
        let looks = if self.is_brisk { LOOKS } else { 0 };
        let came = match look(read.as_mut(), looks).await {
            Some(came) => Some(came),
            None => {
                std::future::poll_fn(|cx| {
                    if let Poll::Ready(came) = read.as_mut().poll(cx) {
                        return Poll::Ready(Some(came));
                    }
                    timer.as_mut().poll(cx).map(|()| None)
                })
                .await
            }
        };
        let before = std::mem::replace(&mut self.now, self.epoch.elapsed());
        self.is_brisk = self.now.saturating_sub(before) < BRISK;
        match came {
            Some(Ok(0)) => Err(Ended::ByPeer),
            Some(came) => {
                self.signs.heard();
                came.map(|_| ()).map_err(Ended::from)
            }
            None => {
                let mut seat = Seat {
                    device: &self.device,
                    local: self.local,
                    peer: self.peer,
                    session: self.number,
                };
                self.session.handle_timeout(self.now, &mut seat);
                self.carry_out().await
            }
        }
    }

    /// Handles what has come, for a turn at most. Whether there may be more.
    async fn take_frames(&mut self) -> Result<bool, Ended> {
        let began = std::time::Instant::now();
        loop {
            match self.decoder.decode(&mut self.input) {
                Ok(Some(frame)) => self.take(&frame).await?,
                Ok(None) => return Ok(false),
                Err(error) => {
                    let FrameError::TooLong { header, .. } = error;
                    self.output
                        .push(Frame::error(&header, EncapStatus::INVALID_LENGTH).to_bytes());
                    return Err(error.into());
                }
            }
            if began.elapsed() >= TURN {
                return Ok(true);
            }
        }
    }

    /// Handles one frame.
    async fn take(&mut self, frame: &Frame) -> Result<(), Ended> {
        let mut seat = Seat {
            device: &self.device,
            local: self.local,
            peer: self.peer,
            session: self.number,
        };
        self.session.handle_frame(frame, self.now, &mut seat);
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
                    let mut handled = pin!(self.router.handle(&request, reply_budget, transport));
                    let reply = match at_once(handled.as_mut()).await {
                        Poll::Ready(reply) => reply,
                        Poll::Pending => {
                            let reply = handled.await;
                            self.now = self.epoch.elapsed();
                            reply
                        }
                    };
                    self.session.reply(id, &reply, self.now);
                    if self.signs.is_wanted()
                        && let Some(socket) = self.stream.duplicate()
                    {
                        self.device.plant.guard().watch(self.number, socket);
                    }
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

    /// Queues a frame; waits for the peer when there are many.
    async fn send(&mut self, frame: Bytes) -> Result<(), Ended> {
        self.output.push(frame);
        if self.output.len() < WRITE {
            return Ok(());
        }
        self.flush().await
    }

    async fn flush(&mut self) -> Result<(), Ended> {
        if self.output.is_empty() {
            return Ok(());
        }
        let mut bytes = self.output.take();
        // Nearly always the socket takes all at once: then no time is told.
        if let Poll::Ready(written) = at_once(pin!(self.stream.write_buf(&mut bytes))).await {
            written?;
        }
        if bytes.is_empty() {
            return Ok(());
        }
        let rest = self.stream.write_all(&bytes);
        let written = timeout(self.device.settings.write_timeout, rest).await;
        self.now = self.epoch.elapsed();
        written.map_err(|_| Ended::SlowReader)?.map_err(Ended::from)
    }
}

/// What a future is without waiting.
async fn at_once<F: Future>(mut future: Pin<&mut F>) -> Poll<F::Output> {
    std::future::poll_fn(|cx| Poll::Ready(future.as_mut().poll(cx))).await
}

/// What a future is within so many looks, between which everything else has its turn.
async fn look<F: Future>(mut future: Pin<&mut F>, times: u32) -> Option<F::Output> {
    for _ in 0..times {
        if let Poll::Ready(output) = at_once(future.as_mut()).await {
            return Some(output);
        }
        tokio::task::yield_now().await;
    }
    None
}

/// Says once why a connection ended: a peer's fault is not ours, so it is only worth a debug line.
pub(crate) fn report(ended: &Ended) {
    debug!(reason = %ended, "connection closed");
}

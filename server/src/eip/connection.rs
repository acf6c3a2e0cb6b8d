//! One TCP connection: frames in, the session's rules, requests to the router, replies out.
//!
//! The server executes the requests of one connection one after the other, in the order in which they came. While a peer does not
//! read its replies, the server reads no more from it; after [`Settings::write_timeout`](super::Settings) it closes the connection.

use std::future::Future;
use std::net::{IpAddr, SocketAddr, SocketAddrV4};
use std::os::fd::{AsFd as _, OwnedFd};
use std::pin::{Pin, pin};
use std::sync::{Arc, Weak};
use std::task::Poll;
use std::time::Duration;

use arcline_config::Role;
use arcline_proto::cip::{CipStatus, Reply, Request};
use arcline_proto::session::{CloseReason, Event, ServerSession, Transport};
use arcline_state::planted::is_planted;
use bytes::{Bytes, BytesMut};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, Interest};
use tokio::net::TcpStream;
use tokio::time::{Instant, Sleep, sleep_until, timeout};
use tokio_rustls::server::TlsStream;
use tracing::{debug, warn};

use super::device::Device;
use super::limiter::{ClientProgress, ClientSlot};
use super::router::Router;
use super::session_host::SessionHost;
use super::turns::{SHORT, Share};
use crate::guard::Signs;
use crate::limits::Rate;
use crate::plant::ClientIdentity;
use crate::tls::{Tls, TlsClient};
use crate::watch;

/// The longest turn of one connection, in which it takes its frames. Another connection waits for one message of a client, or for as many
/// messages as fit into this time.
const TURN: Duration = Duration::from_micros(50);

/// Turns before replies that wait to be sent together leave.
const TURNS: u32 = 16;

/// The buffer for the requests that a peer sends before it waits for an answer, bytes. The buffer grows if a peer sends more.
const READ: usize = 4096;

/// Replies that wait to be sent together, bytes; more are sent at once.
const WRITE: usize = 16 * 1024;

/// The longest sleep of a connection for which nothing is due.
const IDLE: Duration = Duration::from_secs(3600);

/// A peer whose next request comes within this time after the one before polls: it sends each request as soon as it has the
/// reply.
const POLLING: Duration = Duration::from_micros(200);

/// Reads of the socket of a peer that polls before the thread sleeps: to wake the thread takes longer than such a peer needs
/// for its next request. Before other peers the thread sleeps at once.
const BUSY_POLLS: u32 = 40;

/// The end of a connection.
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
    /// The peer does not read.
    #[error("the peer did not read its replies in time")]
    SlowReader,
    /// Too many clients: a newcomer got the place of this one.
    #[error("too many clients: a newcomer got its place")]
    Crowded,
    /// The client's certificate does not hold any more.
    #[error("its certificate does not hold any more")]
    Revoked,
}

/// A client that came in.
#[derive(Debug)]
pub(crate) struct Incoming {
    /// Its slot among the device's clients; `None`: it takes none.
    pub(crate) slot: Option<ClientSlot>,
    /// The near end.
    pub(crate) local: SocketAddrV4,
    /// The far end.
    pub(crate) peer: IpAddr,
    /// Its role.
    pub(crate) role: Role,
    /// The side of TLS and the client's certificate; `None`: its connection is not encrypted.
    pub(crate) tls: Option<(Arc<Tls>, TlsClient)>,
}

/// Serves a stream of an engineer that takes no slot of the device's clients.
#[cfg(test)]
pub(crate) async fn serve<S>(stream: S, local: SocketAddrV4, peer: IpAddr, device: Arc<Device>) -> Ended
where
    S: AsyncRead + AsyncWrite + Unpin + Socket,
{
    let incoming = Incoming {
        slot: None,
        local,
        peer,
        role: Role::Engineer,
        tls: None,
    };
    serve_in(incoming, stream, device).await
}

/// Serves the stream of a client until it ends.
pub(crate) async fn serve_in<S>(incoming: Incoming, stream: S, device: Arc<Device>) -> Ended
where
    S: AsyncRead + AsyncWrite + Unpin + Socket,
{
    let Incoming {
        slot,
        local,
        peer,
        role,
        tls,
    } = incoming;
    let close = slot.as_ref().map(ClientSlot::close).unwrap_or_default();
    let epoch = Instant::now();
    let number = device.number_session();
    let mut name = match stream.far_end() {
        Some(address) => address.to_string(),
        None => peer.to_string(),
    };
    let is_encrypted = tls.is_some();
    if let Some((_, client)) = &tls {
        name.push_str(&format!(" {}", client.name()));
    }
    let session_settings = match is_encrypted {
        true => &device.session_settings,
        false => &device.plain_settings,
    };
    let interface: Weak<Device> = Arc::downgrade(&device);
    let signs = device
        .plant
        .enter(number, ClientIdentity::of_address(&name, Some(peer)), role, interface);
    // Held as long as the certificate holds.
    let certified = tls.map(|(tls, client)| {
        tls.enter(number, client, &device.plant, close.clone());
        tls
    });
    let rate = device.settings.config.security.max_requests_of(role);
    let mut connection = Connection {
        stream,
        input: BytesMut::with_capacity(READ),
        output: Output::default(),
        session: ServerSession::new(session_settings.clone(), local, Duration::ZERO),
        router: Router::new(device.clone(), local, number),
        slot,
        inactivity: device.watch_inactivity(),
        host: SessionHost {
            device,
            local,
            peer,
            session: number,
            is_encrypted,
        },
        epoch,
        now: Duration::ZERO,
        is_polling: false,
        signs,
        share: Share::default(),
        rate: Some(rate)
            .filter(|rate| *rate > 0)
            .map(|rate| Rate::new(rate, Instant::now())),
    };
    let ended = close.run_until_cancelled(connection.run()).await;
    // Says goodbye to a TLS peer, if that takes no time.
    let _ = at_once(pin!(connection.stream.shutdown())).await;
    let is_revoked = certified.is_some_and(|tls| !tls.leave(number));
    let ended = ended.unwrap_or(if is_revoked { Ended::Revoked } else { Ended::Crowded });
    connection.session.handle_disconnect(&mut connection.host);
    let in_order = matches!(ended, Ended::Session(CloseReason::Unregistered));
    let device = &connection.host.device;
    device.end_session(number, in_order);
    device.plant.leave(number);
    ended
}

struct Connection<S> {
    stream: S,
    /// Bytes that were read and that the session has not taken yet.
    input: BytesMut,
    /// Frames that wait to be sent.
    output: Output,
    session: ServerSession,
    router: Router,
    slot: Option<ClientSlot>,
    /// The silence after which the socket is closed, which a client may set.
    inactivity: watch::Receiver<Option<Duration>>,
    host: SessionHost,
    epoch: Instant,
    /// The time since the epoch at the last wait; work that needs no wait takes no time.
    now: Duration,
    /// Whether the peer sent its last request as soon as it had the reply to the one before.
    is_polling: bool,
    /// The signs of life of the peer for the guard of jogs.
    signs: Signs,
    /// The time of a network thread that the connection has used.
    share: Share,
    /// The most requests a second; `None`: any number.
    rate: Option<Rate>,
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

/// The socket beneath the stream of a client.
pub(crate) trait Socket {
    /// The far end, if it has an address.
    fn far_end(&self) -> Option<SocketAddr>;
    /// Another descriptor of the same socket, if it is one of the system's.
    fn duplicate(&self) -> Option<OwnedFd>;
    /// Waits until the far end sends nothing more, and leaves the bytes that have come; for ever where the socket is none of the system's.
    fn ended(&self) -> impl Future<Output = ()> + Send;
}

impl Socket for TlsStream<TcpStream> {
    fn far_end(&self) -> Option<SocketAddr> {
        self.get_ref().0.far_end()
    }

    fn duplicate(&self) -> Option<OwnedFd> {
        self.get_ref().0.duplicate()
    }

    fn ended(&self) -> impl Future<Output = ()> + Send {
        self.get_ref().0.ended()
    }
}

impl Socket for TcpStream {
    fn far_end(&self) -> Option<SocketAddr> {
        self.peer_addr().ok()
    }

    fn duplicate(&self) -> Option<OwnedFd> {
        let duplicate = self.as_fd().try_clone_to_owned();
        duplicate
            .inspect_err(|error| warn!(%error, "the socket of a jogging client is not watched"))
            .ok()
    }

    async fn ended(&self) {
        // This interest alone is not ready when there are bytes to read.
        while let Ok(ready) = self.ready(Interest::PRIORITY).await {
            if ready.is_read_closed() {
                return;
            }
        }
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

    fn ended(&self) -> impl Future<Output = ()> + Send {
        std::future::pending()
    }
}

impl<S: AsyncRead + AsyncWrite + Unpin + Socket> Connection<S> {
    async fn run(&mut self) -> Ended {
        match self.serve_frames().await {
            Ok(never) => match never {},
            Err(ended) => {
                // Send the replies from before the end, if the peer takes them.
                let _ = self.flush().await;
                ended
            }
        }
    }

    async fn serve_frames(&mut self) -> Result<std::convert::Infallible, Ended> {
        let mut timer = pin!(sleep_until(self.epoch + IDLE));
        let mut turns = 0;
        loop {
            let more = self.take_input().await?;
            turns += 1;
            // Requests that come together are answered together, except the slow ones.
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

    /// Waits for more input, and does due work meanwhile.
    async fn wait(&mut self, mut timer: Pin<&mut Sleep>) -> Result<(), Ended> {
        self.session.set_inactivity(*self.inactivity.borrow_and_update());
        let due = self.epoch + self.session.poll_timeout().unwrap_or(self.now + IDLE);
        // Setting the timer costs more than a wake-up in vain: set it only if it would fire too late, or has fired.
        if due < timer.deadline() || timer.is_elapsed() {
            timer.as_mut().reset(due);
        }
        self.input.reserve(READ);
        let mut read = pin!(self.stream.read_buf(&mut self.input));
        let polls = if self.is_polling { BUSY_POLLS } else { 0 };
        let came = match busy_poll(read.as_mut(), polls).await {
            Some(came) => Some(came),
            None => {
                let mut changed = pin!(self.inactivity.changed());
                std::future::poll_fn(|cx| {
                    if let Poll::Ready(came) = read.as_mut().poll(cx) {
                        return Poll::Ready(Some(came));
                    }
                    // The inactivity time-out has changed: calculate the next due time again.
                    let is_changed = changed.as_mut().poll(cx).is_ready();
                    let is_due = timer.as_mut().poll(cx).is_ready();
                    if is_changed || is_due {
                        Poll::Ready(None)
                    } else {
                        Poll::Pending
                    }
                })
                .await
            }
        };
        let before = std::mem::replace(&mut self.now, self.epoch.elapsed());
        self.is_polling = self.now.saturating_sub(before) < POLLING;
        match came {
            Some(Ok(0)) if is_planted("end of a connection ignored") => std::future::pending().await,
            Some(Ok(0)) => Err(Ended::ByPeer),
            Some(came) => {
                self.signs.heard();
                came.map(|_| ()).map_err(Ended::from)
            }
            None => {
                self.session.handle_timeout(self.now, &mut self.host);
                self.apply_events().await.map(drop)
            }
        }
    }

    /// Gives the session its input, for a turn at most. Returns whether there may be more input.
    async fn take_input(&mut self) -> Result<bool, Ended> {
        let began = Instant::now();
        loop {
            self.session.handle_input(&mut self.input, self.now, &mut self.host);
            if let Some(slot) = &mut self.slot
                && self.session.is_registered()
            {
                slot.reach(ClientProgress::Registered);
            }
            // The session stops behind each request.
            if !self.apply_events().await? {
                return Ok(false);
            }
            if began.elapsed() >= TURN {
                return Ok(true);
            }
        }
    }

    /// Applies the events of the session until there are no more. Returns whether a request was among them.
    async fn apply_events(&mut self) -> Result<bool, Ended> {
        let mut answered = false;
        while let Some(event) = self.session.poll_event() {
            match event {
                Event::Outgoing(bytes) => self.send(bytes).await?,
                Event::Request {
                    id,
                    request,
                    reply_budget,
                    transport,
                } => {
                    if let Some(slot) = &mut self.slot {
                        slot.reach(ClientProgress::Asking);
                    }
                    let reply = if self.is_within_rate(&request) {
                        self.answer(&request, reply_budget, transport).await?
                    } else {
                        Reply::error(request.service, CipStatus::RESOURCE_UNAVAILABLE)
                    };
                    self.session.reply(id, &reply, self.now);
                    answered = true;
                    if self.signs.is_wanted()
                        && let Some(socket) = self.stream.duplicate()
                    {
                        self.host.device.plant.guard().watch(self.host.session, socket);
                    }
                }
                Event::IoReady(id) => {
                    self.flush().await?;
                    if let Some(io) = self.host.device.io() {
                        io.start(id);
                    }
                }
                Event::Close(reason) => return Err(reason.into()),
            }
        }
        Ok(answered)
    }

    /// Whether a request is within the rate of the client's role; a stop always is.
    fn is_within_rate(&mut self, request: &Request) -> bool {
        let Some(rate) = &mut self.rate else { return true };
        rate.allows(Instant::now()) || self.router.is_stop(request)
    }

    /// Answers a request, in a turn of its own if it is long work.
    async fn answer(&mut self, request: &Request, budget: usize, transport: Transport) -> Result<Reply, Ended> {
        let is_long = request.data.len() > SHORT || self.share.is_used(self.now) && !self.router.is_stop(request);
        if is_long && self.host.device.turns.are_taken() {
            // Replies that are ready do not wait with it.
            self.flush().await?;
        }
        let turn = match is_long {
            true => self.host.device.turns.take(self.host.session).await,
            false => None,
        };
        let began = Instant::now();
        let mut handled = pin!(self.router.handle(request, budget, transport));
        let reply = at_once(handled.as_mut()).await;
        self.share.pay(self.now, began.elapsed());
        drop(turn);
        Ok(match reply {
            Poll::Ready(reply) => reply,
            Poll::Pending => {
                if self.host.device.plant.is_stepped() {
                    // Requests of a client that has ended its side are answered, but no more ticks pass for it.
                    tokio::select! {
                        biased;
                        reply = handled.as_mut() => return Ok(reply),
                        () = self.stream.ended() => self.signs.leave(),
                    }
                }
                let reply = handled.await;
                self.now = self.epoch.elapsed();
                reply
            }
        })
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
        // Nearly always the socket takes all at once: then the clock is not read.
        if let Poll::Ready(written) = at_once(pin!(self.stream.write_buf(&mut bytes))).await {
            written?;
        }
        if bytes.is_empty() && at_once(pin!(self.stream.flush())).await.is_ready() {
            return Ok(());
        }
        let rest = async {
            self.stream.write_all(&bytes).await?;
            // TLS holds the bytes that the socket did not take.
            self.stream.flush().await
        };
        let written = timeout(self.host.device.settings.write_timeout, rest).await;
        self.now = self.epoch.elapsed();
        written.map_err(|_| Ended::SlowReader)?.map_err(Ended::from)
    }
}

/// Polls a future once, without waiting.
async fn at_once<F: Future>(mut future: Pin<&mut F>) -> Poll<F::Output> {
    std::future::poll_fn(|cx| Poll::Ready(future.as_mut().poll(cx))).await
}

/// The output of a future if it is ready within this number of polls, between which other tasks run.
async fn busy_poll<F: Future>(mut future: Pin<&mut F>, times: u32) -> Option<F::Output> {
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

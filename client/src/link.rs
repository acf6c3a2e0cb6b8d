//! One TCP connection to a server: the task that owns the socket, and the handle that asks it.
//!
//! [`ClientSession`] makes and reads the frames; here are the socket, the clock and the waiting callers. One request is
//! outstanding on the connection. A caller may stop waiting at any time: the task reads the late answer and drops it.
//! Nothing here depends on the meaning of a request.

use std::collections::BTreeMap;
use std::net::SocketAddrV4;
use std::time::Duration;

use bytes::BytesMut;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::{mpsc, oneshot};
use tokio::time::Instant;

use arcline_proto::cip::{Reply, Request};
use arcline_proto::client::{self as session, Call, ClientSession, Connected, OpenOptions, Outcome};
use arcline_proto::connection::ConnectionKey;
use arcline_proto::cpf::ConnectionId;
use arcline_proto::identity::{Identity, VENDOR_ID};

use crate::ClientError;

/// A router message outside a connection fits this, bytes.
const UNCONNECTED_BUDGET: usize = 504;
/// Size of the second Forward Open, when the server refuses the large one.
const SMALL_CONNECTION: u16 = 500;
/// Code of the multiplier 512: the watchdog is about 17 minutes.
const LONGEST_MULTIPLIER: u8 = 7;
/// Jobs that may wait for the socket.
const QUEUED_REQUESTS: usize = 16;

/// Asks the task that owns the socket. Cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    jobs: mpsc::Sender<Job>,
    timeout: Duration,
    budget: usize,
}

#[derive(Debug)]
struct Job {
    what: What,
    answer: oneshot::Sender<Outcome>,
}

#[derive(Debug)]
enum What {
    Register,
    Identify,
    Open(OpenOptions),
    Message(Request),
    /// Forward Close, UnRegisterSession, and the end.
    Close,
}

impl Link {
    /// Registers a session and opens a class 3 connection of up to `size` bytes; when the server refuses both kinds of
    /// Forward Open, requests go unconnected.
    pub(crate) async fn open<S>(stream: S, size: u16, timeout: Duration) -> Result<Self, ClientError>
    where
        S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
    {
        let (jobs, queue) = mpsc::channel(QUEUED_REQUESTS);
        tokio::spawn(Wire::new(stream, timeout).serve(queue));
        let mut this = Self {
            jobs,
            timeout,
            budget: UNCONNECTED_BUDGET,
        };
        this.ask(What::Register).await?;
        for size in [size, size.min(SMALL_CONNECTION)] {
            match this.ask(What::Open(open_options(size))).await {
                Ok(Outcome::Opened { budget, .. }) => {
                    this.budget = budget;
                    break;
                }
                Ok(_) | Err(ClientError::Refused { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(this)
    }

    /// Bytes of the longest router request or reply.
    pub(crate) fn budget(&self) -> usize {
        self.budget
    }

    /// Asks the message router.
    pub(crate) async fn request(&self, request: Request) -> Result<Reply, ClientError> {
        let service = request.service;
        let length = request.to_bytes().map_err(session::ClientError::from)?.len();
        if length > self.budget {
            return Err(ClientError::TooLarge {
                what: "the request's length",
                claimed: length,
                limit: self.budget,
            });
        }
        match self.ask(What::Message(request)).await? {
            Outcome::Reply(reply) if reply.service == service => Ok(reply),
            _ => Err(ClientError::Malformed {
                what: "a reply is for another service",
            }),
        }
    }

    /// The identity of the server, and the address at which it says it listens.
    pub(crate) async fn identify(&self) -> Result<(SocketAddrV4, Identity), ClientError> {
        match self.ask(What::Identify).await? {
            Outcome::Identity(Some(found)) => Ok(found),
            _ => Err(ClientError::Malformed {
                what: "a ListIdentity reply holds no identity",
            }),
        }
    }

    /// Closes connection and session.
    pub(crate) async fn close(&self) {
        // The connection is closed, with or without an answer of the server.
        let _ = self.ask(What::Close).await;
    }

    async fn ask(&self, what: What) -> Result<Outcome, ClientError> {
        let (answer, answered) = oneshot::channel();
        self.jobs
            .send(Job { what, answer })
            .await
            .map_err(|_| ClientError::Closed)?;
        match answered.await {
            Ok(Outcome::Failed(session::ClientError::TimedOut)) => Err(ClientError::Timeout { after: self.timeout }),
            Ok(Outcome::Failed(error)) => Err(error.into()),
            Ok(outcome) => Ok(outcome),
            Err(_) => Err(ClientError::Closed),
        }
    }
}

fn open_options(size: u16) -> OpenOptions {
    let random = random_bits();
    let key = ConnectionKey {
        serial: random as u16,
        vendor: VENDOR_ID,
        originator: (random >> 16) as u32,
    };
    let options = OpenOptions::new(key, ConnectionId((random >> 32) as u32 | 1));
    OpenOptions {
        size,
        multiplier: LONGEST_MULTIPLIER,
        ..options
    }
}

/// The side of the task: socket, session, and the waiting callers.
struct Wire<S> {
    stream: S,
    session: ClientSession,
    input: BytesMut,
    start: Instant,
    connection: Option<Connected>,
    waiting: BTreeMap<Call, oneshot::Sender<Outcome>>,
    life: Life,
}

/// How far the end has come.
enum Life {
    Open,
    /// Waits for the Forward Close to be confirmed.
    Closing(Call, oneshot::Sender<Outcome>),
    /// UnRegisterSession has been said.
    Closed,
}

impl<S: AsyncRead + AsyncWrite + Unpin> Wire<S> {
    fn new(stream: S, timeout: Duration) -> Self {
        Self {
            stream,
            session: ClientSession::new(timeout),
            input: BytesMut::new(),
            start: Instant::now(),
            connection: None,
            waiting: BTreeMap::new(),
            life: Life::Open,
        }
    }

    /// Runs until every handle is dropped, the session is closed, or the connection breaks.
    async fn serve(mut self, mut jobs: mpsc::Receiver<Job>) {
        loop {
            let over = self.settle();
            if self.send().await.is_err() {
                self.session.handle_disconnect();
                self.settle();
                break;
            }
            if over || matches!(self.life, Life::Closed) {
                break;
            }
            let due = self.start + self.session.poll_timeout().unwrap_or(FAR);
            tokio::select! {
                // A dropped client closes the session; no caller waits for that.
                job = jobs.recv(), if matches!(self.life, Life::Open) => {
                    self.start(job.unwrap_or_else(|| Job { what: What::Close, answer: oneshot::channel().0 }));
                }
                read = self.stream.read_buf(&mut self.input) => match read {
                    // A stream that cannot be read on has failed every call, which `settle` sees.
                    Ok(1..) => drop(self.session.handle_input(&mut self.input)),
                    Ok(0) | Err(_) => {
                        self.session.handle_disconnect();
                        self.settle();
                        break;
                    }
                },
                () = tokio::time::sleep_until(due) => self.session.handle_timeout(self.start.elapsed()),
            }
        }
        // Best effort: the peer may have closed the socket.
        let _ = self.stream.shutdown().await;
    }

    async fn send(&mut self) -> std::io::Result<()> {
        while let Some(bytes) = self.session.poll_transmit() {
            self.stream.write_all(&bytes).await?;
        }
        Ok(())
    }

    /// Hands out the results of the calls; true at the end of the session.
    fn settle(&mut self) -> bool {
        let mut over = false;
        while let Some(event) = self.session.poll_event() {
            if let Outcome::Opened { connection, .. } = event.outcome {
                self.connection = Some(connection);
            }
            over |= matches!(
                event.outcome,
                Outcome::Failed(session::ClientError::Lost | session::ClientError::Frame(_))
            );
            if matches!(&self.life, Life::Closing(call, _) if *call == event.call) {
                self.unregister();
            } else if let Some(answer) = self.waiting.remove(&event.call) {
                // Nobody waits for it any more: that is allowed.
                let _ = answer.send(event.outcome);
            }
        }
        over
    }

    fn unregister(&mut self) {
        self.session.unregister();
        if let Life::Closing(_, answer) = std::mem::replace(&mut self.life, Life::Closed) {
            let _ = answer.send(Outcome::Closed);
        }
    }

    fn start(&mut self, job: Job) {
        let now = self.start.elapsed();
        let call = match (job.what, self.connection) {
            (What::Register, _) => Ok(self.session.register(now)),
            (What::Identify, _) => Ok(self.session.identify(now)),
            (What::Open(options), _) => self.session.open(options, now),
            (What::Message(request), Some(connection)) => self.session.request_connected(connection, &request, now),
            (What::Message(request), None) => self.session.request(&request, None, now),
            (What::Close, connection) => {
                let close = connection.and_then(|connection| self.session.close(connection, now).ok());
                match close {
                    Some(call) => self.life = Life::Closing(call, job.answer),
                    None => {
                        self.session.unregister();
                        self.life = Life::Closed;
                        drop(job.answer.send(Outcome::Closed));
                    }
                }
                return;
            }
        };
        match call {
            Ok(call) => drop(self.waiting.insert(call, job.answer)),
            Err(error) => drop(job.answer.send(Outcome::Failed(error))),
        }
    }
}

/// No deadline: a day.
const FAR: Duration = Duration::from_secs(86_400);

/// Distinguishes connections; not for secrets.
fn random_bits() -> u64 {
    use std::hash::{BuildHasher, Hasher};
    std::collections::hash_map::RandomState::new().build_hasher().finish()
}

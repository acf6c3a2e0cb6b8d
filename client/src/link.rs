//! One TCP connection to a server: the task that owns the socket, and the handle that asks it.
//!
//! [`ClientSession`] makes and reads the frames; here are the socket, the clock and the waiting callers. One request is
//! outstanding on the connection. A caller may stop waiting at any time: the task reads the late answer and drops it.
//!
//! A class 3 connection that was lost (a reply did not come in time, or the server refused a packet) is opened again by the
//! next request, once. A request that had no reply is repeated only if it [reads](is_read); any other may have been carried
//! out, so its caller gets the error. A TCP connection that was lost stays lost: the server has dropped its data of this client (jogs,
//! executions, control), so the program that uses the client decides whether to connect again.

use std::collections::BTreeMap;
use std::net::SocketAddrV4;
use std::sync::Arc;
use std::time::Duration;

use bytes::BytesMut;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::sync::{Mutex, mpsc, oneshot};
use tokio::time::Instant;

use arcline_proto::cip::{Reply, Request, class, service, split_multiple};
use arcline_proto::client::{self as session, Call, ClientSession, Connected, OpenOptions, Outcome};
use arcline_proto::connection::ConnectionKey;
use arcline_proto::cpf::ConnectionId;
use arcline_proto::encap::Command;
use arcline_proto::epath::Target;
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
    /// Size of the class 3 connection, bytes; `None`: requests go unconnected.
    size: Option<u16>,
    /// Held while the connection is opened again.
    reopening: Arc<Mutex<()>>,
}

#[derive(Debug)]
struct Job {
    work: Work,
    answer: oneshot::Sender<Outcome>,
}

#[derive(Debug)]
enum Work {
    Register,
    Identify,
    /// Opens a class 3 connection, unless one is open.
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
            size: None,
            reopening: Arc::default(),
        };
        this.ask(Work::Register).await?;
        for size in [size, size.min(SMALL_CONNECTION)] {
            match this.ask(Work::Open(open_options(size))).await {
                Ok(Outcome::Opened { budget, .. }) => {
                    this.budget = budget;
                    this.size = Some(size);
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

    /// Asks the message router. Opens a lost connection again, and repeats the request if that is safe.
    pub(crate) async fn request(&self, request: Request) -> Result<Reply, ClientError> {
        let length = request.to_bytes().map_err(session::ClientError::from)?.len();
        if length > self.budget {
            return Err(ClientError::TooLarge {
                what: "the request's length",
                claimed: length,
                limit: self.budget,
            });
        }
        let first = self.outcome(Work::Message(request.clone())).await?;
        let Some(size) = self.size.filter(|_| may_repeat(&first, &request)) else {
            return self.reply(&request, first);
        };
        self.reopen(size).await?;
        let second = self.outcome(Work::Message(request.clone())).await?;
        self.reply(&request, second)
    }

    /// Opens the class 3 connection again, unless another caller has done it.
    async fn reopen(&self, size: u16) -> Result<(), ClientError> {
        let _alone = self.reopening.lock().await;
        self.ask(Work::Open(open_options(size))).await.map(drop)
    }

    fn reply(&self, request: &Request, outcome: Outcome) -> Result<Reply, ClientError> {
        match self.checked(outcome)? {
            Outcome::Reply(reply) if reply.service == request.service => Ok(reply),
            _ => Err(ClientError::Malformed {
                what: "a reply is for another service",
            }),
        }
    }

    /// The identity of the server, and the address at which it says it listens.
    pub(crate) async fn identify(&self) -> Result<(SocketAddrV4, Identity), ClientError> {
        match self.ask(Work::Identify).await? {
            Outcome::Identity(Some(found)) => Ok(found),
            _ => Err(ClientError::Malformed {
                what: "a ListIdentity reply holds no identity",
            }),
        }
    }

    /// Closes connection and session.
    pub(crate) async fn close(&self) {
        // The connection is closed, with or without an answer of the server.
        let _ = self.ask(Work::Close).await;
    }

    async fn ask(&self, work: Work) -> Result<Outcome, ClientError> {
        let outcome = self.outcome(work).await?;
        self.checked(outcome)
    }

    async fn outcome(&self, work: Work) -> Result<Outcome, ClientError> {
        let (answer, answered) = oneshot::channel();
        self.jobs
            .send(Job { work, answer })
            .await
            .map_err(|_| ClientError::Closed)?;
        answered.await.map_err(|_| ClientError::Closed)
    }

    fn checked(&self, outcome: Outcome) -> Result<Outcome, ClientError> {
        match outcome {
            Outcome::Failed(session::ClientError::TimedOut) => Err(ClientError::Timeout { after: self.timeout }),
            Outcome::Failed(error) => Err(error.into()),
            outcome => Ok(outcome),
        }
    }
}

/// Whether a request on a class 3 connection with this outcome can be sent again without being carried out twice.
fn may_repeat(outcome: &Outcome, request: &Request) -> bool {
    match outcome {
        Outcome::Failed(session::ClientError::NotOpen) => true,
        // The server refused the packet, so it has not read the request.
        Outcome::Failed(session::ClientError::Encapsulation { command, .. }) => *command == Command::SEND_UNIT_DATA,
        Outcome::Failed(session::ClientError::TimedOut) => is_read(request),
        _ => false,
    }
}

/// Whether a request reads and changes nothing.
fn is_read(request: &Request) -> bool {
    match request.service {
        service::GET_ATTRIBUTES_ALL
        | service::GET_ATTRIBUTE_LIST
        | service::GET_ATTRIBUTE_SINGLE
        | service::GET_INSTANCE_ATTRIBUTE_LIST => true,
        // The codes mean other services on other classes.
        service::READ_TAG | service::READ_TAG_FRAGMENTED => Target::new(&request.path)
            .is_ok_and(|target| matches!(target.class, None | Some(class::SYMBOL | class::TEMPLATE))),
        service::MULTIPLE_SERVICE_PACKET => {
            split_multiple(&request.data).is_ok_and(|parts| parts.iter().all(|part| part.as_ref().is_ok_and(is_read)))
        }
        _ => false,
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
    connection: Option<Opened>,
    /// The parameters of the connection that is being opened.
    opening: Option<OpenOptions>,
    waiting: BTreeMap<Call, oneshot::Sender<Outcome>>,
    life: Life,
}

/// A class 3 connection that was opened; it may have been lost since.
#[derive(Clone)]
struct Opened {
    connected: Connected,
    budget: usize,
    options: OpenOptions,
}

/// The progress of the end.
enum Life {
    Open,
    /// Waits for the Forward Close to be confirmed.
    Closing(Call, oneshot::Sender<Outcome>),
    /// UnRegisterSession has been sent.
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
            opening: None,
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
                    self.start(job.unwrap_or_else(|| Job { work: Work::Close, answer: oneshot::channel().0 }));
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
            if let (Outcome::Opened { connection, budget }, Some(options)) = (&event.outcome, &self.opening) {
                self.connection = Some(Opened {
                    connected: *connection,
                    budget: *budget,
                    options: options.clone(),
                });
            }
            over |= matches!(
                event.outcome,
                Outcome::Failed(session::ClientError::Lost | session::ClientError::EncapFrame(_))
            );
            if matches!(&self.life, Life::Closing(call, _) if *call == event.call) {
                self.unregister();
            } else if let Some(answer) = self.waiting.remove(&event.call) {
                // The caller may have given up waiting.
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
        let call = match (job.work, &self.connection) {
            (Work::Register, _) => Ok(self.session.register(now)),
            (Work::Identify, _) => Ok(self.session.identify(now)),
            (Work::Open(_), Some(opened)) if self.session.is_open(opened.connected) => {
                let outcome = Outcome::Opened {
                    connection: opened.connected,
                    budget: opened.budget,
                };
                drop(job.answer.send(outcome));
                return;
            }
            (Work::Open(options), lost) => {
                if let Some(lost) = lost {
                    // The server may or may not still have it: no caller waits for the answer.
                    let _ = self.session.close_lost(&lost.options, now);
                }
                self.opening = Some(options.clone());
                self.session.open(options, now)
            }
            (Work::Message(request), Some(opened)) => self.session.request_connected(opened.connected, &request, now),
            (Work::Message(request), None) => self.session.request(&request, None, now),
            (Work::Close, opened) => {
                let close = opened
                    .as_ref()
                    .and_then(|opened| self.session.close(opened.connected, now).ok());
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use arcline_proto::cip::join_multiple;
    use arcline_proto::encap::EncapStatus;
    use arcline_proto::epath::Epath;
    use bytes::Bytes;

    fn tag(code: u8) -> Request {
        Request::new(code, Epath::symbol("Speed"), Bytes::from_static(&[1, 0]))
    }

    fn object(code: u8, class: u16) -> Request {
        Request::new(code, Epath::object(class, 1), Bytes::new())
    }

    fn several(requests: &[Request]) -> Request {
        let data = join_multiple(requests).unwrap();
        Request::new(
            service::MULTIPLE_SERVICE_PACKET,
            Epath::object(class::MESSAGE_ROUTER, 1),
            data,
        )
    }

    #[test]
    fn only_reads_are_repeated_after_a_lost_reply() {
        let read = || tag(service::READ_TAG);
        #[rustfmt::skip]
        let cases = [
            ("a tag",                          read(),                                              true),
            ("a part of a tag",                tag(service::READ_TAG_FRAGMENTED),                   true),
            ("attributes of an execution",     object(service::GET_ATTRIBUTE_LIST, 0x0303),         true),
            ("the list of tags",               object(service::GET_INSTANCE_ATTRIBUTE_LIST, 0x6B),  true),
            ("a template",                     object(service::READ_TAG, 0x6C),                     true),
            ("reads together",                 several(&[read(), read()]),                          true),
            ("a read and a write together",    several(&[read(), tag(service::WRITE_TAG)]),         false),
            ("a write",                        tag(service::WRITE_TAG),                             false),
            ("a change of bits",               tag(service::READ_MODIFY_WRITE_TAG),                 false),
            ("an attribute that is set",       object(service::SET_ATTRIBUTE_SINGLE, 0x0300),       false),
            ("the same code on another class", object(service::READ_TAG, 0x0302),                   false),
            ("an instruction",                 object(0x32, 0x0302),                                false),
            ("a trace that begins",            object(0x06, 0x0304),                                false),
        ];
        for (why, request, repeated) in cases {
            let late = Outcome::Failed(session::ClientError::TimedOut);
            assert_eq!(may_repeat(&late, &request), repeated, "{why}");
            let unsent = Outcome::Failed(session::ClientError::NotOpen);
            assert!(may_repeat(&unsent, &request), "{why}, which was not sent");
            let unread = Outcome::Failed(session::ClientError::Encapsulation {
                command: Command::SEND_UNIT_DATA,
                status: EncapStatus::INCORRECT_DATA,
            });
            assert!(may_repeat(&unread, &request), "{why}, which the server has not read");
            let lost = Outcome::Failed(session::ClientError::Lost);
            assert!(!may_repeat(&lost, &request), "{why}, of a broken TCP connection");
        }
    }
}

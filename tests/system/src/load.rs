//! A load: many connections that ask one question again and again, each as soon as it has its answer, and the times of the
//! answers. Against any EtherNet/IP server, and against an echo of the same sizes.
//!
//! It checks only that every answer is a success of the right length. Times are nanoseconds.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use arcline_client::Tls;
use arcline_proto::cip::{Request, join_multiple, service};
use arcline_proto::connection::{
    ConnectionKey, ForwardOpen, ForwardOpenReply, NetworkParameters, TRANSPORT_CLASS_3, TickTime,
};
use arcline_proto::cpf::{ConnectionId, Packet};
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, Header, MAX_DATA, RegisterSession, SessionHandle};
use arcline_proto::epath::Epath;
use arcline_proto::logix::ReadTag;
use bytes::{Bytes, BytesMut};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

/// The question of a connection.
#[derive(Clone, Debug)]
pub enum Question {
    /// As many bytes as a frame, to be answered by as many: an echo server's protocol.
    Echo {
        /// Bytes of a request, at least 8.
        request: u32,
        /// Bytes of a reply.
        reply: u32,
    },
    /// A message over a class 3 connection of this size.
    Connected(Request, u16),
    /// A message without a connection.
    Unconnected(Request),
}

/// A read of one element of a tag.
#[must_use]
pub fn read(tag: &str) -> Request {
    let data = ReadTag { elements: 1, offset: 0 }.to_bytes();
    Request::new(service::READ_TAG, Epath::symbol(tag), data)
}

/// Reads of several tags in one Multiple Service Packet.
///
/// # Panics
/// When a name is too long for a path.
#[must_use]
pub fn read_all(tags: impl IntoIterator<Item = String>) -> Request {
    let reads: Vec<Request> = tags.into_iter().map(|tag| read(&tag)).collect();
    let data = join_multiple(&reads).expect("short paths");
    Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data)
}

/// A load.
#[derive(Clone, Debug)]
pub struct Load {
    /// The address of the server.
    pub server: SocketAddr,
    /// The question.
    pub question: Question,
    /// The number of connections at a time.
    pub connections: usize,
    /// The time of the load.
    pub time: Duration,
    /// The time from one question to the next; `None`: each question follows the answer to the one before.
    pub pace: Option<Duration>,
    /// Over TLS, with this certificate.
    pub tls: Option<Tls>,
}

/// A TCP connection, or TLS over one.
trait Stream: AsyncRead + AsyncWrite + Unpin + Send {}

impl<S: AsyncRead + AsyncWrite + Unpin + Send> Stream for S {}

/// The result of a load.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Times from question to answer, sorted.
    pub times: Vec<u32>,
    /// Answers that were none, or no success, and connections that ended.
    pub errors: usize,
    /// The first of these errors.
    pub first_error: Option<String>,
    /// The time in which questions were asked.
    pub elapsed: Duration,
    /// Bytes of a request and of its reply.
    pub sizes: (u32, u32),
}

impl Outcome {
    /// Answers a second.
    #[must_use]
    pub fn rate(&self) -> f64 {
        self.times.len() as f64 / self.elapsed.as_secs_f64()
    }

    /// The time that a share of the answers did not exceed, µs.
    #[must_use]
    pub fn percentile(&self, share: f64) -> f64 {
        let place = (self.times.len().saturating_sub(1) as f64 * share).round();
        self.times
            .get(place as usize)
            .map_or(f64::NAN, |time| f64::from(*time) / 1e3)
    }

    /// Adds another run of the same load.
    pub fn add(&mut self, other: Self) {
        self.times.extend(other.times);
        self.times.sort_unstable();
        self.errors += other.errors;
        self.first_error = self.first_error.take().or(other.first_error);
        self.elapsed += other.elapsed;
        self.sizes = other.sizes;
    }
}

impl Load {
    /// Carries it out on the calling thread.
    ///
    /// # Panics
    /// When there is no runtime to be had.
    #[must_use]
    pub fn run(&self) -> Outcome {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .expect("a runtime");
        runtime.block_on(self.carry_out())
    }

    async fn carry_out(&self) -> Outcome {
        let mut open = Vec::with_capacity(self.connections);
        let mut all = Outcome::default();
        for number in 0..self.connections {
            match Asker::connect(self, number).await {
                Ok(asker) => open.push(asker),
                Err(why) => all.fail(why),
            }
        }
        let began = Instant::now();
        let share = |number: usize| {
            self.pace
                .map(|pace| pace.mul_f64(number as f64 / self.connections as f64))
        };
        let tasks: Vec<_> = open
            .into_iter()
            .enumerate()
            .map(|(number, asker)| {
                let pace = self.pace.zip(share(number));
                tokio::spawn(asker.ask(began, self.time, pace))
            })
            .collect();
        for task in tasks {
            match task.await {
                Ok(outcome) => {
                    all.times.extend(outcome.times);
                    all.errors += outcome.errors;
                    all.first_error = all.first_error.take().or(outcome.first_error);
                    all.sizes = outcome.sizes;
                }
                Err(error) => all.fail(error.to_string()),
            }
        }
        all.elapsed = began.elapsed();
        all.times.sort_unstable();
        all
    }
}

impl Outcome {
    fn fail(&mut self, why: String) {
        self.errors += 1;
        self.first_error.get_or_insert(why);
    }
}

/// One connection.
struct Asker {
    stream: Box<dyn Stream>,
    /// The frame that is sent, again and again.
    frame: Vec<u8>,
    /// The offset of the sequence count of class 3 in the frame.
    sequence_at: Option<usize>,
    /// For an echo: the number of bytes that come back.
    echo: Option<u32>,
    input: BytesMut,
}

impl Asker {
    async fn connect(load: &Load, number: usize) -> Result<Self, String> {
        let (server, question) = (load.server, &load.question);
        let told = |error: std::io::Error| error.to_string();
        let stream = TcpStream::connect(server).await.map_err(told)?;
        stream.set_nodelay(true).map_err(told)?;
        let stream: Box<dyn Stream> = match &load.tls {
            Some(tls) => Box::new(tls.connect(stream, &server.to_string()).await.map_err(told)?),
            None => Box::new(stream),
        };
        let mut this = Self {
            stream,
            frame: Vec::new(),
            sequence_at: None,
            echo: None,
            input: BytesMut::with_capacity(8192),
        };
        if let Question::Echo { request, reply } = question {
            this.frame = vec![0; *request as usize];
            this.frame[..4].copy_from_slice(&request.to_le_bytes());
            this.frame[4..8].copy_from_slice(&reply.to_le_bytes());
            this.echo = Some(*reply);
            return Ok(this);
        }
        let register = EncapFrame::request(
            Command::REGISTER_SESSION,
            SessionHandle(0),
            [0; 8],
            RegisterSession::CURRENT.to_bytes(),
        );
        let session = this.exchange(&register.to_bytes()).await?.header.session;
        let (command, packet) = match question {
            Question::Connected(request, size) => {
                let id = this.open(session, *size, number).await?;
                let packet = Packet::connected(id, 0, &message(request));
                this.sequence_at = Some(SEQUENCE_AT);
                (Command::SEND_UNIT_DATA, packet)
            }
            Question::Unconnected(request) => (Command::SEND_RR_DATA, Packet::unconnected(message(request))),
            Question::Echo { .. } => unreachable!("answered above"),
        };
        this.frame = EncapFrame::request(command, session, [0; 8], packet.to_bytes())
            .to_bytes()
            .to_vec();
        Ok(this)
    }

    async fn open(&mut self, session: SessionHandle, size: u16, number: usize) -> Result<ConnectionId, String> {
        let parameters = NetworkParameters::explicit(size);
        let open = ForwardOpen {
            time: TickTime::DEFAULT,
            o_to_t_id: ConnectionId(0),
            t_to_o_id: ConnectionId(0x4C4F_0000 | number as u32),
            key: ConnectionKey {
                serial: number as u16,
                vendor: 0x1337,
                originator: std::process::id(),
            },
            multiplier: 7,
            o_to_t_rpi: 2_000_000,
            o_to_t: parameters,
            t_to_o_rpi: 2_000_000,
            t_to_o: parameters,
            transport: TRANSPORT_CLASS_3,
            path: Epath::object(2, 1),
        };
        let large = size > 511;
        let code = if large {
            service::LARGE_FORWARD_OPEN
        } else {
            service::FORWARD_OPEN
        };
        let data = open.to_bytes(large).map_err(|error| error.to_string())?;
        let packet = Packet::unconnected(message(&Request::new(code, Epath::object(6, 1), data)));
        let ask = EncapFrame::request(Command::SEND_RR_DATA, session, [0; 8], packet.to_bytes());
        let reply = self.exchange(&ask.to_bytes()).await?;
        let packet = Packet::decode(&reply.data).map_err(|error| error.to_string())?;
        let reply = packet.unconnected_message().map_err(|error| error.to_string())?;
        let reply = arcline_proto::cip::Reply::decode(reply).ok_or("a cut reply")?;
        if !reply.status.is_success() {
            return Err(format!("Forward Open: {}", reply.status));
        }
        ForwardOpenReply::decode(&reply.data)
            .map(|reply| reply.o_to_t_id)
            .ok_or_else(|| "a cut Forward Open reply".to_owned())
    }

    async fn exchange(&mut self, request: &[u8]) -> Result<EncapFrame, String> {
        let told = |error: std::io::Error| error.to_string();
        self.stream.write_all(request).await.map_err(told)?;
        loop {
            if let Some(frame) = FrameDecoder::new(MAX_DATA)
                .decode(&mut self.input)
                .map_err(|error| error.to_string())?
            {
                return Ok(frame);
            }
            if self.stream.read_buf(&mut self.input).await.map_err(told)? == 0 {
                return Err("the server closed the connection".to_owned());
            }
        }
    }

    async fn ask(mut self, began: Instant, time: Duration, pace: Option<(Duration, Duration)>) -> Outcome {
        let mut outcome = Outcome::default();
        let mut due = began + pace.map_or(Duration::ZERO, |(_, phase)| phase);
        let mut sequence = 0_u16;
        while began.elapsed() < time {
            if let Some((pace, _)) = pace {
                tokio::time::sleep_until(due.into()).await;
                due += pace;
            }
            sequence = sequence.wrapping_add(1);
            if let Some(at) = self.sequence_at {
                self.frame[at..at + 2].copy_from_slice(&sequence.to_le_bytes());
            }
            let asked = Instant::now();
            match self.once().await {
                Ok(reply) => {
                    let took = u32::try_from(asked.elapsed().as_nanos()).unwrap_or(u32::MAX);
                    outcome.times.push(took);
                    outcome.sizes = (self.frame.len() as u32, reply);
                }
                Err(why) => {
                    outcome.fail(why);
                    break;
                }
            }
        }
        outcome
    }

    /// Asks once; bytes of the reply.
    async fn once(&mut self) -> Result<u32, String> {
        let told = |error: std::io::Error| error.to_string();
        self.stream.write_all(&self.frame).await.map_err(told)?;
        let length = loop {
            let length = match self.echo {
                Some(reply) => Some(reply as usize),
                None => self
                    .input
                    .get(2..4)
                    .map(|length| Header::LEN + usize::from(u16::from_le_bytes([length[0], length[1]]))),
            };
            if let Some(length) = length.filter(|length| *length <= self.input.len()) {
                break length;
            }
            if self.stream.read_buf(&mut self.input).await.map_err(told)? == 0 {
                return Err("the server closed the connection".to_owned());
            }
        };
        if self.echo.is_none() {
            // In class 3 there are an address and a sequence count in front of the reply.
            let reply = match self.sequence_at {
                Some(at) => at + 2,
                None => SEQUENCE_AT - 4,
            };
            let statuses = (self.input.get(8..12), self.input.get(reply + 2));
            if statuses != (Some(&[0; 4]), Some(&0)) {
                return Err(format!("statuses {statuses:02X?} in {length} bytes"));
            }
        }
        self.input.clear();
        Ok(length as u32)
    }
}

/// The offset of the sequence count of a class 3 message in its frame: behind the header, interface handle and time-out, the
/// item count, an address of 4 bytes and the head of the data item.
const SEQUENCE_AT: usize = Header::LEN + 6 + 2 + 8 + 4;

fn message(request: &Request) -> Bytes {
    request.to_bytes().expect("a short path")
}

/// An echo server: nothing but tokio's runtime as it comes, and as many bytes back as a request says. It says where it is and
/// serves until its process ends.
///
/// # Panics
/// When there is no port to be had.
pub fn serve_echo() {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .expect("a runtime");
    runtime.block_on(async {
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("a port");
        println!("ready eip={}", listener.local_addr().expect("bound"));
        loop {
            let Ok((mut stream, _)) = listener.accept().await else {
                continue;
            };
            tokio::spawn(async move {
                let _ = stream.set_nodelay(true);
                let mut buf = vec![0; 65_536];
                let mut held = 0;
                while let Ok(count @ 1..) = stream.read(&mut buf[held..]).await {
                    held += count;
                    let number =
                        |at: usize| u32::from_le_bytes([buf[at], buf[at + 1], buf[at + 2], buf[at + 3]]) as usize;
                    if held < 8 || held < number(0) {
                        continue;
                    }
                    let reply = number(4);
                    if stream.write_all(&buf[..reply]).await.is_err() {
                        return;
                    }
                    held = 0;
                }
            });
        }
    });
}

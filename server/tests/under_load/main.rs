//! STOP under the load of others: a server with one network thread, over real sockets, and clients that ask for as much as they can for a
//! few seconds. Each load is measured beside an idle control. A process of its own: it would make other tests late.

mod class_1;
mod instructions;
mod lost;
mod turns;

use arcline_config::{IoListen, ServerConfig};
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use arcline_instruction_set::{Mnemonic, UnboundOperand};
use arcline_proto::cip::{Request, join_multiple, service};
use arcline_proto::cpf::Packet;
use arcline_proto::encap::{Command, EncapFrame, FrameDecoder, MAX_DATA, RegisterSession, SessionHandle};
use arcline_proto::epath::Epath;
use arcline_proto::logix::{WireType, WriteTag};
use arcline_server::eip::{Listener, Settings};
use arcline_server::hmi::Hmi;
use arcline_server::plant::{Call, CallRefused, Command as Do, Outcome, Plant, Principal};
use bytes::{Bytes, BytesMut};
use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::json;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::runtime::{Builder, Runtime};
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

/// The longest time from STOP to the ramp. Seconds were measured before STOP had a thread of its own, and 89 to 166 ms of stops that travel as
/// instructions before those overtook others.
const BOUND: Duration = Duration::from_millis(20);
/// The greatest memory of a load beyond that of the idle server, KiB; 300 clients took 2 GB before the queues had bounds.
const MEMORY: u64 = 100 << 10;
/// The time of a load before STOP is pressed.
const WARM: Duration = Duration::from_millis(400);
/// Longest wait for a message that must come.
const SOON: Duration = Duration::from_secs(20);
/// The jogged axis of the default machine, S, and its place.
const S: u16 = 3;

type Page = WebSocketStream<MaybeTlsStream<TcpStream>>;

/// The tests of this process take turns: the load of one must not be that of another.
static ALONE: Mutex<()> = Mutex::new(());

/// A server as on two processors: one network thread, and the client's runtime beside it.
struct Server {
    _alone: MutexGuard<'static, ()>,
    plant: Plant,
    eip: SocketAddr,
    hmi: SocketAddr,
    clients: Runtime,
    server: Option<Runtime>,
    tick: Option<arcline_realtime::Handle>,
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            server.shutdown_background();
        }
        drop(self.tick.take());
    }
}

impl Server {
    fn start() -> Self {
        Self::start_with(arcline_config::DEFAULT)
    }

    fn start_with(config: &str) -> Self {
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let network = Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .expect("a runtime");
        let (plant, tick, eip, hmi) = network.block_on(async {
            let project = arcline_config::load(config, "default").expect("it is valid");
            let (plant, tick) = Plant::start(&project).expect("a thread");
            let any = "127.0.0.1:0".parse().expect("an address");
            let settings = Settings::new(&ServerConfig {
                io: IoListen::At(any),
                ..ServerConfig::default()
            });
            let listener = Listener::bind(any, plant.clone(), settings).await.expect("a port");
            let hmi = Hmi::bind(any, plant.clone()).await.expect("a port");
            let addresses = (listener.local_addr(), hmi.local_addr().expect("it listens"));
            tokio::spawn(listener.serve());
            tokio::spawn(hmi.serve());
            (plant, tick, addresses.0, addresses.1)
        });
        Server {
            _alone: alone,
            plant,
            eip,
            hmi,
            clients: Builder::new_multi_thread()
                .worker_threads(1)
                .enable_all()
                .build()
                .expect("a runtime"),
            server: Some(network),
            tick: Some(tick),
        }
    }

    fn page(&self) -> Page {
        let hmi = self.hmi;
        self.clients.block_on(async move {
            let mut request = format!("ws://{hmi}/ws").into_client_request().expect("an address");
            let origin = format!("http://{hmi}").parse().expect("a header");
            request.headers_mut().insert("origin", origin);
            connect_async(request).await.expect("a place").0
        })
    }

    fn velocity(&self) -> f64 {
        self.plant
            .with_snapshot(|snapshot| snapshot.axes[usize::from(S)].command[1].abs())
    }

    fn jog(&self) {
        self.until("it stands", |speed| speed == 0.0);
        let operands = [0.0, 50.0, 0.0, 5000.0, 0.0, 5000.0, 0.0].map(UnboundOperand::Number);
        let call = Call {
            mnemonic: Mnemonic::Maj,
            target: Some(S),
            control: None,
            operands: &operands,
            text: None,
        };
        let began = Instant::now();
        // The load may have taken the room for instructions that begin motion.
        let done = loop {
            let jog = self.plant.apply(Principal::Server, Do::Call(call.clone()));
            let done = self.clients.block_on(jog);
            if done != Err(CallRefused::Busy.into()) || began.elapsed() > SOON {
                break done;
            }
        };
        let Ok(Outcome::Executed(executed)) = done else {
            panic!("{done:?}")
        };
        assert!(
            !executed.control.has(arcline_instruction_set::Flag::Er),
            "{:?}",
            executed.control
        );
        self.until("the jog has its speed", |speed| speed == 50.0);
    }

    fn until(&self, what: &str, is: impl Fn(f64) -> bool) -> Duration {
        let began = Instant::now();
        while !is(self.velocity()) {
            assert!(began.elapsed() < SOON, "{what}: not in time");
            std::thread::sleep(Duration::from_micros(200));
        }
        began.elapsed()
    }

    /// The time from the page's STOP to the ramp.
    fn stop(&self, page: &mut Page) -> Duration {
        let began = Instant::now();
        self.clients.block_on(async {
            let stop = json!({"id": 1, "do": "stop"}).to_string();
            page.send(Message::text(stop)).await.expect("it is open");
        });
        self.until("STOP", |speed| speed < 50.0);
        let took = began.elapsed();
        // STOP is over with its answer; until then it may stop motion that begins behind it.
        let answer = async {
            while let Some(message) = page.next().await {
                let message = message.expect("the page goes on");
                if message.to_text().is_ok_and(|text| text.contains("\"ok\":{}")) {
                    return;
                }
            }
            panic!("the page is closed");
        };
        let answered = self
            .clients
            .block_on(async { tokio::time::timeout(SOON, answer).await });
        answered.expect("STOP is answered");
        let released = self.clients.block_on(self.plant.apply(Principal::Server, Do::Release));
        assert_eq!(released, Ok(Outcome::Done));
        took
    }
}

/// A load that keeps the server busy until it is dropped.
struct Load {
    begin: Begin,
    over: Arc<AtomicBool>,
    /// Clients that have sent their first message.
    started: Arc<AtomicU64>,
    done: Arc<AtomicU64>,
    tasks: Vec<tokio::task::JoinHandle<()>>,
}

impl Drop for Load {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Release);
        self.tasks.iter().for_each(tokio::task::JoinHandle::abort);
    }
}

impl Load {
    fn new(begin: Begin) -> Self {
        Load {
            begin,
            over: Arc::default(),
            started: Arc::default(),
            done: Arc::default(),
            tasks: Vec::new(),
        }
    }

    /// Begins, and waits until the server is busy with it.
    fn begin(&mut self, server: &Server) {
        self.connect(server);
        let began = Instant::now();
        while !self.has_started() {
            assert!(began.elapsed() < SOON, "not all clients are connected");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(WARM);
    }

    fn connect(&mut self, server: &Server) {
        (self.begin)(self, server);
    }

    /// Whether all clients have sent a message.
    fn has_started(&self) -> bool {
        self.started.load(Ordering::Acquire) == self.tasks.len() as u64
    }

    /// A client that sends the same bytes again and again, `ahead` messages ahead of the answers.
    fn client(&mut self, server: &Server, ahead: u64, messages: Vec<Bytes>) {
        let (eip, over, done) = (server.eip, self.over.clone(), self.done.clone());
        let started = self.started.clone();
        self.tasks.push(server.clients.spawn(async move {
            let Ok(mut stream) = TcpStream::connect(eip).await else {
                return;
            };
            let register = EncapFrame::request(
                Command::REGISTER_SESSION,
                SessionHandle(0),
                [0; 8],
                RegisterSession::CURRENT.to_bytes(),
            );
            let (mut buf, decoder) = (BytesMut::new(), FrameDecoder::new(MAX_DATA));
            if stream.write_all(&register.to_bytes()).await.is_err() {
                return;
            }
            let (mut session, mut sent, mut answered) = (None, 0, 0);
            while !over.load(Ordering::Acquire) {
                while let Some(session) = session
                    && sent < answered + ahead
                {
                    let message = messages[sent as usize % messages.len()].clone();
                    let data = Packet::unconnected(message).to_bytes();
                    let frame = EncapFrame::request(Command::SEND_RR_DATA, session, [0; 8], data);
                    if stream.write_all(&frame.to_bytes()).await.is_err() {
                        return;
                    }
                    started.fetch_add(u64::from(sent == 0), Ordering::Release);
                    sent += 1;
                }
                match decoder.decode(&mut buf) {
                    Ok(Some(frame)) if session.is_none() => session = Some(frame.header.session),
                    Ok(Some(_)) => {
                        answered += 1;
                        done.fetch_add(1, Ordering::Relaxed);
                    }
                    Ok(None) => match stream.read_buf(&mut buf).await {
                        Ok(1..) => {}
                        Ok(0) | Err(_) => return,
                    },
                    Err(_) => return,
                }
            }
        }));
    }

    /// A page that asks the same again and again.
    fn page(&mut self, server: &Server, ahead: u64, text: String) {
        let (mut page, over, done) = (server.page(), self.over.clone(), self.done.clone());
        let started = self.started.clone();
        self.tasks.push(server.clients.spawn(async move {
            let (mut sent, mut answered) = (0, 0);
            while !over.load(Ordering::Acquire) {
                while sent < answered + ahead {
                    if page.send(Message::text(text.clone())).await.is_err() {
                        return;
                    }
                    started.fetch_add(u64::from(sent == 0), Ordering::Release);
                    sent += 1;
                }
                match page.next().await {
                    Some(Ok(Message::Text(text))) if text.contains("\"id\"") => {
                        answered += 1;
                        done.fetch_add(1, Ordering::Relaxed);
                    }
                    Some(Ok(_)) => {}
                    Some(Err(_)) | None => return,
                }
            }
        }));
    }
}

/// As many Get Attributes All of an object as one packet takes.
fn packet_of_attributes(class: u16) -> Bytes {
    let one = Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(class, 1), Bytes::new());
    packet(&vec![one; 660])
}

fn packet(requests: &[Request]) -> Bytes {
    let data = join_multiple(requests).expect("short paths");
    let packet = Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data);
    packet.to_bytes().expect("a short path")
}

/// EnableIn of an instruction, on and off, as often as a packet has room for.
fn toggle(tag: &str) -> Vec<Bytes> {
    let pairs: Vec<Request> = (0..40).map(|place| write_enable(tag, place % 2 == 0)).collect();
    vec![packet(&pairs)]
}

fn write_enable(tag: &str, on: bool) -> Request {
    let path = Epath::from_tag(&format!("{tag}.EnableIn").parse().expect("a path")).0;
    let write = WriteTag {
        data_type: WireType::Atomic(0xC1),
        elements: 1,
        offset: 0,
        data: Bytes::copy_from_slice(&[u8::from(on)]),
    };
    Request::new(service::WRITE_TAG, path, write.to_bytes())
}

/// Begins a load.
type Begin = fn(&mut Load, &Server);

/// The loads under which stops are measured.
#[rustfmt::skip]
const LOADS: [(&str, Begin); 7] = [
    ("nothing",                      |_, _| {}),
    ("32 pipelined packets of 0xF6", |load, server| load.client(server, 32, vec![packet_of_attributes(0xF6)])),
    ("200 clients toggle EnableIn",  |load, server| (0..200).for_each(|_| load.client(server, 1, toggle("Move1")))),
    ("300 clients toggle EnableIn",  |load, server| (0..300).for_each(|_| load.client(server, 1, toggle("Move1")))),
    ("a search of 250,000 stars",    |load, server| load.page(server, 2, json!({"id": 1, "do": "tags", "pattern": "*".repeat(250_000)}).to_string())),
    ("pages search",                 |load, server| (0..8).for_each(|_| load.page(server, 4, json!({"id": 1, "do": "tags", "pattern": "*a*e*i*o*u*"}).to_string()))),
    ("pages check 240 KiB",          |load, server| (0..4).for_each(|_| load.page(server, 2, json!({"id": 1, "do": "check", "text": LOOP.repeat(6000)}).to_string()))),
];
const LOOP: &str = "WHILE TRUE DO X1 := X1 + 1; END_WHILE;\n";

impl Server {
    /// Measures a stop under each load, three times; none may be late in all, and no load may take too much memory.
    fn under_loads(&self, what: &str, bound: Duration, mut stop: impl FnMut(&Server, &mut Load) -> Duration) {
        let (mut wrong, mut idle) = (Vec::new(), None);
        for (why, begin) in LOADS {
            forget_peak();
            let mut all = Vec::new();
            for _ in 0..TRIES {
                let mut load = Load::new(begin);
                let took = stop(self, &mut load);
                println!(
                    "{why}: {what} after {took:?}, {} answers",
                    load.done.load(Ordering::Relaxed)
                );
                all.push(took);
            }
            let peak = peak();
            let growth = peak.saturating_sub(*idle.get_or_insert(peak));
            println!("{why}: {peak} KiB, {growth} more than idle");
            // On a machine that is busy with other programs, one try may be late.
            if !all.iter().any(|took| *took <= bound) || growth > MEMORY {
                wrong.push((why, all, growth));
            }
        }
        assert!(wrong.is_empty(), "{what}: late, or too much memory (KiB): {wrong:?}");
    }
}

/// The number of tries of each; the best counts.
const TRIES: usize = 3;

/// The most memory that this process has had since [`forget_peak`], KiB.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells it");
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak = peak.and_then(|peak| peak.trim().strip_suffix("kB")?.trim().parse().ok());
    peak.expect("a number of KiB")
}

/// The peak is that of now.
fn forget_peak() {
    std::fs::write("/proc/self/clear_refs", "5").expect("Linux resets the peak");
}

#[test]
fn stop_waits_for_no_client() {
    let server = Server::start();
    let mut page = server.page();
    server.under_loads("STOP", BOUND, |server, load| {
        server.jog();
        load.begin(server);
        server.stop(&mut page)
    });
}

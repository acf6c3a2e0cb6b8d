//! No request keeps the network's thread for long: the dearest request of each kind, and the longest time for which the thread did nothing
//! else, by the thread's CPU time, so that other work of the machine does not count.

use std::fmt::Write as _;

use arcline_proto::cip::class;
use arcline_proto::logix::ReadTag;
use arcline_realtime::thread_time;

use super::*;

/// The longest turn, in a debug build too.
const LONGEST: Duration = Duration::from_millis(10);
/// Bytes of the requests of a packet, with their offsets.
const PACKET: usize = 5280;
/// The number of requests of each kind; the best counts, since pushes to pages come in between.
const TIMES: usize = 4;

/// Reads the clock of the network's only thread again and again: the time between two reads is one turn of others.
struct Turns {
    longest: Arc<AtomicU64>,
    looks: Arc<AtomicU64>,
    task: tokio::task::JoinHandle<()>,
}

impl Turns {
    fn of(server: &Server) -> Self {
        let longest = Arc::new(AtomicU64::new(0));
        let looks = Arc::new(AtomicU64::new(0));
        let (seen, looked) = (longest.clone(), looks.clone());
        let runtime = server.server.as_ref().expect("it runs");
        let task = runtime.spawn(async move {
            let mut last = thread_time();
            loop {
                tokio::task::yield_now().await;
                let now = thread_time();
                let turn = u64::try_from((now - last).as_nanos()).expect("years");
                seen.fetch_max(turn, Ordering::Relaxed);
                looked.fetch_add(1, Ordering::Release);
                last = now;
            }
        });
        Turns { longest, looks, task }
    }

    /// The longest turn while `work` ran.
    fn during(&self, work: impl FnOnce()) -> Duration {
        self.longest.store(0, Ordering::Relaxed);
        work();
        // An answer may be sent before its turn is over.
        let looks = self.looks.load(Ordering::Acquire);
        while self.looks.load(Ordering::Acquire) < looks + 2 {
            std::thread::sleep(Duration::from_micros(200));
        }
        Duration::from_nanos(self.longest.load(Ordering::Relaxed))
    }
}

impl Drop for Turns {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// A session that asks one request after another.
pub(super) struct Session {
    stream: TcpStream,
    session: SessionHandle,
    buf: BytesMut,
}

impl Session {
    pub(super) async fn open(eip: SocketAddr) -> Self {
        let mut session = Session {
            stream: TcpStream::connect(eip).await.expect("a place"),
            session: SessionHandle(0),
            buf: BytesMut::new(),
        };
        let reply = session
            .exchange(Command::REGISTER_SESSION, RegisterSession::CURRENT.to_bytes())
            .await;
        session.session = reply.header.session;
        session
    }

    pub(super) async fn exchange(&mut self, command: Command, data: Bytes) -> EncapFrame {
        self.send(command, data).await;
        self.reply().await
    }

    pub(super) async fn send(&mut self, command: Command, data: Bytes) {
        let frame = EncapFrame::request(command, self.session, [0; 8], data);
        self.stream.write_all(&frame.to_bytes()).await.expect("it is open");
    }

    pub(super) async fn reply(&mut self) -> EncapFrame {
        let decoder = FrameDecoder::new(MAX_DATA);
        loop {
            if let Some(frame) = decoder.decode(&mut self.buf).expect("a frame") {
                return frame;
            }
            assert!(self.stream.read_buf(&mut self.buf).await.expect("it is open") > 0);
        }
    }

    pub(super) async fn ask(&mut self, message: Bytes) -> EncapFrame {
        self.exchange(Command::SEND_RR_DATA, Packet::unconnected(message).to_bytes())
            .await
    }
}

/// Large tags, many tags, and structures.
fn config() -> String {
    let mut text = arcline_config::DEFAULT.to_owned();
    text += r#"
[[data_type]]
name = "Point"
members = [{ name = "At", type = "REAL[6]" }, { name = "Name", type = "STRING" }, { name = "Valid", type = "BOOL" }]
[[tag]]
name = "Points"
type = "Point[500]"
[[tag]]
name = "Numbers"
type = "LREAL[18000]"
"#;
    for number in 0..2500 {
        write!(text, "[[tag]]\nname = \"Tag{number}\"\ntype = \"DINT\"\n").expect("a String takes everything");
    }
    text
}

fn request(service: u8, path: Epath, data: &[u8]) -> Request {
    Request::new(service, path, Bytes::copy_from_slice(data))
}

fn path_of(tag: &str) -> Epath {
    Epath::from_tag(&tag.parse().expect("a path")).0
}

fn read(tag: &str, elements: u16) -> Request {
    let read = ReadTag { elements, offset: 0 };
    request(service::READ_TAG, path_of(tag), &read.to_bytes())
}

/// The dearest requests of the EtherNet/IP side.
fn messages() -> Vec<(&'static str, Bytes)> {
    let one = |request: Request| request.to_bytes().expect("a short path");
    let many = |request: Request| {
        let bytes = 2 + request.to_bytes().expect("a short path").len();
        packet(&vec![request; PACKET / bytes])
    };
    let all = |class: u16| many(request(service::GET_ATTRIBUTES_ALL, Epath::object(class, 1), &[]));
    // Name, type, dimensions and access of every symbol from the first on.
    let symbols = [4_u16, 1, 2, 8, 10].map(u16::to_le_bytes).concat();
    let create = |number: usize| {
        let path = path_of(&format!("Made{number}"));
        request(service::CREATE, path, &[0])
    };
    let mut ids = 600_u16.to_le_bytes().to_vec();
    (0..600).for_each(|id: u16| ids.extend_from_slice(&(id % 30).to_le_bytes()));
    vec![
        ("660 Get Attributes All of 0xF5", all(0xF5)),
        ("660 Get Attributes All of 0xF6", all(0xF6)),
        ("660 Get Attributes All of an axis", all(0x301)),
        ("660 Get Attributes All of a coordinate system", all(0x302)),
        ("660 Get Attributes All of an execution", all(0x303)),
        ("660 Get Attributes All of the identity", all(class::IDENTITY)),
        (
            "Get Attribute List of 600",
            one(request(service::GET_ATTRIBUTE_LIST, Epath::object(0x302, 1), &ids)),
        ),
        (
            "a page of symbols",
            one(request(
                service::GET_INSTANCE_ATTRIBUTE_LIST,
                Epath::object(class::SYMBOL, 0),
                &symbols,
            )),
        ),
        (
            "a packet of pages of symbols",
            many(request(
                service::GET_INSTANCE_ATTRIBUTE_LIST,
                Epath::object(class::SYMBOL, 0),
                &symbols,
            )),
        ),
        ("500 structures", one(read("Points", 500))),
        ("a packet of 500 structures each", many(read("Points", 500))),
        (
            "a packet of names that are not there",
            many(read("NoSuchTagAnywhere", 1)),
        ),
        ("a packet of reads of the newest tag", many(read("Tag2499", 1))),
        (
            "tags that cannot be created",
            packet(&(0..150).map(create).collect::<Vec<_>>()),
        ),
    ]
}

/// The dearest requests of the page.
fn asks() -> Vec<(&'static str, serde_json::Value)> {
    let program = "WHILE TRUE DO X1 := X1 + 1; END_WHILE;\n".repeat(6000);
    let names: Vec<String> = (0..200).map(|place| format!("Points[{place}]")).collect();
    vec![
        ("values of a large tag", json!({"do": "read", "names": ["Numbers"]})),
        ("values of 500 structures", json!({"do": "read", "names": ["Points"]})),
        ("values of 200 tags", json!({"do": "read", "names": names})),
        (
            "watched values of a large tag",
            json!({"do": "watch", "names": ["Numbers"]}),
        ),
        ("no watched values", json!({"do": "watch", "names": []})),
        ("a search", json!({"do": "tags", "pattern": "*a*e*i*o*u*"})),
        ("a list of tags", json!({"do": "tags", "pattern": ""})),
        ("a check of 240 KiB", json!({"do": "check", "text": program})),
        ("the past", json!({"do": "past"})),
        ("events", json!({"do": "events"})),
        (
            "a line",
            json!({"do": "line", "instruction": "MCLM", "operands": {"Coordinate System": "CS1"}}),
        ),
    ]
}

#[test]
fn no_request_keeps_the_thread_of_others_for_long() {
    let server = Server::start_with(&config());
    let mut long = Vec::new();
    let mut judge = |why: &str, took: Duration| {
        println!("{why}: {:.2} ms", took.as_secs_f64() * 1e3);
        if took > LONGEST {
            long.push((why.to_owned(), took));
        }
    };
    let turns = Turns::of(&server);
    let mut session = server.clients.block_on(Session::open(server.eip));
    for (why, message) in messages() {
        let tries = (0..TIMES).map(|_| {
            turns.during(|| {
                server.clients.block_on(session.ask(message.clone()));
            })
        });
        judge(why, tries.min().unwrap_or_default());
    }
    let mut page = server.page();
    for (why, mut ask) in asks() {
        ask["id"] = 7.into();
        let text = ask.to_string();
        let tries = (0..TIMES).map(|_| {
            turns.during(|| {
                server.clients.block_on(async {
                    page.send(Message::text(text.clone())).await.expect("it is open");
                    loop {
                        match page.next().await.expect("it is open").expect("a message") {
                            Message::Text(answer) if answer.contains("\"id\":7") => break,
                            _ => {}
                        }
                    }
                });
            })
        });
        judge(why, tries.min().unwrap_or_default());
    }
    // Some pushes of large watched values, and of the state.
    let text = json!({"id": 8, "do": "watch", "names": ["Numbers"]}).to_string();
    server
        .clients
        .block_on(page.send(Message::text(text)))
        .expect("it is open");
    let pushes = turns.during(|| std::thread::sleep(Duration::from_millis(600)));
    judge("pushes", pushes);
    assert!(long.is_empty(), "longer than {LONGEST:?}: {long:?}");
}

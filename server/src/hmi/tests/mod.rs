//! The HMI over a real socket: a WebSocket client for viewers, plain HTTP for the rest.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use arcline_realtime::Handle;
use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::{Value, json};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::sync::Semaphore;
use tokio::task::JoinHandle;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

use super::Hmi;
use crate::plant::Plant;

/// A delta `PICKER`, and the system `CART` that can lead it.
const ROBOT: &str = include_str!("../../../../docs/images/tool-path.toml");
/// Longest wait for a message that must come.
const SOON: Duration = Duration::from_secs(10);

/// A machine that runs, and its HMI.
struct Bench {
    address: SocketAddr,
    plant: Plant,
    /// One for each simulation that may run.
    simulations: Arc<Semaphore>,
    serving: JoinHandle<()>,
    _tick: Handle,
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.serving.abort();
    }
}

impl Bench {
    async fn start() -> Self {
        Self::with(arcline_config::DEFAULT).await
    }

    async fn with(config: &str) -> Self {
        let project = arcline_config::load(config, "machine.toml").expect("it is valid");
        let (plant, tick) = Plant::start(&project).expect("a thread");
        let hmi = Hmi::bind("127.0.0.1:0".parse().expect("an address"), plant.clone())
            .await
            .expect("a free port");
        Bench {
            address: hmi.local_addr().expect("it listens"),
            plant,
            simulations: hmi.shared.previews.turns(),
            serving: tokio::spawn(hmi.serve()),
            _tick: tick,
        }
    }

    /// The whole answer to `GET path`.
    async fn get(&self, path: &str, host: &str) -> String {
        let mut stream = TcpStream::connect(self.address).await.expect("it accepts");
        let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).await.expect("it reads");
        let mut answer = Vec::new();
        timeout(SOON, stream.read_to_end(&mut answer))
            .await
            .expect("in time")
            .expect("it answers");
        String::from_utf8_lossy(&answer).into_owned()
    }

    async fn json(&self, path: &str) -> Value {
        let answer = self.get(path, "localhost").await;
        let (_, body) = answer.split_once("\r\n\r\n").expect("a head and a body");
        serde_json::from_str(body).expect("JSON")
    }

    async fn viewer(&self) -> Viewer {
        let origin = format!("http://{}", self.address);
        let socket = self.connect(Some(&origin)).await.expect("a place");
        Viewer::of(socket).await
    }

    async fn connect(&self, origin: Option<&str>) -> Result<Socket, Error> {
        let origin = origin.map(|origin| ("origin", origin));
        self.connect_with(origin.as_slice()).await
    }

    async fn connect_with(&self, headers: &[(&str, &str)]) -> Result<Socket, Error> {
        let mut request = format!("ws://{}/ws", self.address).into_client_request()?;
        for (name, value) in headers {
            let name: tokio_tungstenite::tungstenite::http::HeaderName = name.parse().expect("a name");
            request.headers_mut().insert(name, value.parse().expect("a header"));
        }
        connect_async(request).await.map(|(socket, _)| socket)
    }
}

type Socket = WebSocketStream<MaybeTlsStream<TcpStream>>;

/// Kinds of pushes that tell each change once.
const ONCE: [&str; 3] = ["event", "program", "session"];

struct Viewer {
    socket: Socket,
    next: u64,
    /// Answers and pushes of [`ONCE`] that came while something else was waited for, oldest first.
    kept: Vec<Value>,
    /// The text of the newest program, which only the first push of it has.
    program_text: Option<Value>,
}

impl Viewer {
    /// The viewer of a socket, greeted.
    async fn of(socket: Socket) -> Self {
        let mut viewer = Viewer {
            socket,
            next: 1,
            kept: Vec::new(),
            program_text: None,
        };
        viewer.push("hello").await;
        viewer
    }

    async fn send(&mut self, text: impl Into<String>) {
        let text: String = text.into();
        self.socket.send(Message::text(text)).await.expect("it reads");
    }

    /// The next text; `None`: the server closed.
    async fn text(&mut self) -> Option<Value> {
        loop {
            match timeout(SOON, self.socket.next()).await.expect("in time") {
                Some(Ok(Message::Text(text))) => {
                    let text: Value = serde_json::from_str(&text).ok()?;
                    if text["push"] == "program" && text["text"].is_string() {
                        self.program_text = Some(text["text"].clone());
                    }
                    return Some(text);
                }
                Some(Ok(Message::Close(_)) | Err(_)) | None => return None,
                Some(Ok(_)) => {}
            }
        }
    }

    /// The next push of a kind.
    async fn push(&mut self, kind: &str) -> Value {
        self.next_where(kind, |text| text["push"] == kind).await
    }

    /// The next text, of those kept first, for which a condition holds. An answer, or a push that does not come again, is kept meanwhile.
    async fn next_where(&mut self, what: &str, is: impl Fn(&Value) -> bool) -> Value {
        if let Some(place) = self.kept.iter().position(&is) {
            return self.kept.remove(place);
        }
        let deadline = Instant::now() + SOON;
        loop {
            assert!(Instant::now() < deadline, "no {what}");
            let text = self.text().await.expect("it is open");
            if is(&text) {
                return text;
            }
            if text.get("id").is_some() || ONCE.iter().any(|kind| text["push"] == *kind) {
                self.kept.push(text);
            }
        }
    }

    /// Sends a request, and returns its number.
    async fn request(&mut self, mut message: Value) -> u64 {
        let id = self.next;
        self.next += 1;
        message["id"] = id.into();
        self.send(message.to_string()).await;
        id
    }

    /// Asks, and waits for the answer: `ok`, or the error as it is.
    async fn ask(&mut self, message: Value) -> Result<Value, Value> {
        let id = self.request(message).await;
        self.result(id).await
    }

    /// The result of a request: `ok`, or the error as it is.
    async fn result(&mut self, id: u64) -> Result<Value, Value> {
        let mut answer = self.answer(id).await;
        match answer.get_mut("ok") {
            Some(ok) => Ok(ok.take()),
            None => Err(answer["error"].take()),
        }
    }

    /// Answers that came while something else was waited for.
    fn other_answers(&self) -> Vec<&Value> {
        self.kept.iter().filter(|text| text.get("id").is_some()).collect()
    }

    /// The whole answer to a request.
    async fn answer(&mut self, id: impl Into<Value>) -> Value {
        let id = id.into();
        self.next_where(&format!("answer {id}"), |text| text["id"] == id).await
    }
}

#[tokio::test]
async fn the_page_comes_with_headers_that_keep_others_out() {
    let bench = Bench::start().await;
    let answer = bench.get("/", "localhost").await;
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    for header in [
        "content-type: text/html; charset=utf-8",
        "content-security-policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        "x-content-type-options: nosniff",
        "x-frame-options: DENY",
        "referrer-policy: no-referrer",
        "cross-origin-opener-policy: same-origin",
        "cross-origin-resource-policy: same-origin",
        "cache-control: no-cache",
    ] {
        assert!(answer.contains(header), "{header} is missing in {answer}");
    }
    let none = bench.get("/assets/none.js", "localhost").await;
    assert!(none.starts_with("HTTP/1.1 404"), "{none}");
    assert!(none.contains("content-security-policy"), "{none}");
}

#[tokio::test]
async fn a_name_of_a_stranger_is_refused() {
    let bench = Bench::start().await;
    for path in ["/", "/api/machine", "/ws"] {
        let answer = bench.get(path, "evil.example").await;
        assert!(answer.starts_with("HTTP/1.1 421"), "{path}: {answer}");
        assert!(!answer.contains("\"axes\""), "{answer}");
    }
}

/// Requests that two servers may read differently: one answer at most, and the bytes behind are no request (RFC 9112, 11.2).
#[tokio::test]
async fn a_request_that_can_be_read_in_two_ways_is_refused() {
    let bench = Bench::start().await;
    let behind = "GET /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let length = behind.len();
    let post = "POST /login HTTP/1.1\r\nHost: localhost\r\n";
    let get = "GET / HTTP/1.1\r\n";
    #[rustfmt::skip]
    let cases = [
        ("a length and pieces",    format!("{post}Content-Length: {length}\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n{behind}")),
        ("pieces and a length",    format!("{post}Transfer-Encoding: chunked\r\nContent-Length: 3\r\n\r\n0\r\n\r\n{behind}")),
        ("pieces",                 format!("{post}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n{behind}")),
        ("pieces in disguise",     format!("{post}Transfer-Encoding: xchunked\r\nContent-Length: 0\r\n\r\n{behind}")),
        ("a header with a space",  format!("{post}Transfer-Encoding : chunked\r\nContent-Length: 0\r\n\r\n{behind}")),
        ("two lengths",            format!("{post}Content-Length: 0\r\nContent-Length: {length}\r\n\r\n{behind}")),
        ("a length with a sign",   format!("{post}Content-Length: +0\r\n\r\n{behind}")),
        ("a list of lengths",      format!("{post}Content-Length: 0, {length}\r\n\r\n{behind}")),
        ("two hosts",              format!("{get}Host: localhost\r\nHost: evil.example\r\n\r\n{behind}")),
        ("two equal hosts",        format!("{get}Host: localhost\r\nHost: localhost\r\n\r\n{behind}")),
        ("a line that goes on",    format!("{get}Host: localhost\r\nX-A: 1\r\n Host: evil.example\r\n\r\n{behind}")),
        ("a bare CR in a value",   format!("{get}Host: localhost\r\nX-A: 1\rHost: evil.example\r\n\r\n{behind}")),
        ("a NUL in a value",       format!("{get}Host: localhost\r\nX-A: 1\0\r\n\r\n{behind}")),
    ];
    for (why, bytes) in &cases {
        let answer = exchange(&bench, bytes).await;
        assert!(answer.starts_with("HTTP/1.1 400"), "{why}: {answer}");
        assert_eq!(
            answer.matches("HTTP/1.1 ").count(),
            1,
            "{why}: the connection ends: {answer}"
        );
    }
    // hyper takes a bare LF for the end of a line: the same request as with CRLF, and the one behind it.
    for end in ["\r\n", "\n"] {
        let bytes = format!("GET /assets/none.js HTTP/1.1{end}Host: localhost{end}{end}{behind}");
        let bytes = bytes.replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n");
        let answer = exchange(&bench, &bytes).await;
        let statuses: Vec<&str> = answer.lines().filter(|line| line.starts_with("HTTP/1.1 ")).collect();
        let expected: &[&str] = match end {
            "\n" => &["HTTP/1.1 404 Not Found", "HTTP/1.1 200 OK"],
            // The first one closes here.
            _ => &["HTTP/1.1 404 Not Found"],
        };
        assert_eq!(statuses, expected, "{end:?}: {answer}");
    }
}

/// All that comes until the server closes.
async fn exchange(bench: &Bench, bytes: &str) -> String {
    let mut stream = TcpStream::connect(bench.address).await.expect("it accepts");
    stream.write_all(bytes.as_bytes()).await.expect("it reads");
    let mut answer = Vec::new();
    // A reset behind the answer is an end too: not all of the request was read.
    let _ = timeout(SOON, stream.read_to_end(&mut answer)).await.expect("in time");
    String::from_utf8_lossy(&answer).into_owned()
}

#[tokio::test]
async fn the_machine_is_as_configured() {
    let bench = Bench::start().await;
    let machine = bench.json("/api/machine").await;
    assert_eq!(machine["group"], "Motion");
    assert_eq!(machine["period_s"], 0.001);
    let names = |of: &Value| -> Vec<String> {
        let all = of.as_array().expect("a list");
        all.iter()
            .filter_map(|one| one["name"].as_str().map(str::to_owned))
            .collect()
    };
    assert_eq!(names(&machine["axes"]), ["X", "Y", "Z", "S", "A", "B", "C"]);
    assert_eq!(names(&machine["coordinate_systems"]), ["CS1", "CS2", "CS3", "XY"]);
    assert_eq!(machine["coordinate_systems"][3]["axes"], json!(["X", "Y"]));
    assert_eq!(machine["axes"][0]["travel"], Value::Null);
}

#[tokio::test]
async fn forms_are_made_from_the_catalogue() {
    let bench = Bench::start().await;
    let catalogue = bench.json("/api/instructions").await;
    let all = catalogue["instructions"].as_array().expect("a list");
    assert_eq!(all.len(), arcline_instruction_set::Mnemonic::ALL.len());
    let mccm = all.iter().find(|one| one["mnemonic"] == "MCCM").expect("MCCM");
    assert_eq!(mccm["target_position"]["rows"].as_array().map(Vec::len), Some(8));
    let operand = |member: &str| {
        let operands = mccm["operands"].as_array().expect("a list");
        operands.iter().find(|one| one["member"] == member).expect("an operand")
    };
    assert_eq!(
        operand("ViaCenterRadius")["single_when"],
        json!({"member": "CircleType", "in": [2]})
    );
    assert_eq!(operand("Speed")["unit"], json!({"member": "SpeedUnits"}));
    assert_eq!(operand("Speed")["range"], json!({"min": 0.0, "max": null}));
    assert_eq!(
        operand("CommandTolerance")["shown_when"],
        json!([{"member": "TerminationType", "in": [6]}])
    );
    assert_eq!(
        operand("AccelJerk")["range"]["max_when"],
        json!({"member": "JerkUnits", "in": [2, 6], "max": 100.0})
    );
    let errors = catalogue["errors"].as_array().expect("a list");
    assert!(errors.iter().any(|error| error["err"] == 13 && error["remedy"] != ""));
    let faults = catalogue["faults"].as_array().expect("a list");
    assert!(
        faults
            .iter()
            .any(|fault| fault["word"] == "overcurrent" && fault["meaning"] != "")
    );
}

#[tokio::test]
async fn only_pages_of_the_server_become_viewers() {
    let bench = Bench::start().await;
    let foreign = [
        None,
        Some("http://evil.example"),
        Some("null"),
        Some("http://localhost:1"),
    ];
    for origin in foreign {
        match bench.connect(origin).await {
            Err(Error::Http(answer)) => assert_eq!(answer.status(), 403, "{origin:?}"),
            other => panic!("{origin:?}: {other:?}"),
        }
    }
    bench.viewer().await;
}

#[tokio::test]
async fn bytes_that_are_no_message_are_an_error_and_no_end() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    #[rustfmt::skip]
    let cases = [
        ("not JSON",            "{".to_owned(),                              Value::Null),
        ("no request",          "[]".to_owned(),                             Value::Null),
        ("an unknown request",  r#"{"id":7,"do":"explode"}"#.to_owned(),     json!(7)),
        ("nested too deep",     "[".repeat(100_000),                         Value::Null),
    ];
    for (why, text, id) in cases {
        viewer.send(text).await;
        let answer = loop {
            let text = viewer.text().await.expect("it stays open");
            if text.get("push").is_none() {
                break text;
            }
        };
        assert_eq!(answer["id"], id, "{why}");
        assert!(answer["error"]["text"].is_string(), "{why}: {answer}");
    }
    assert_eq!(viewer.ask(json!({"do": "ping"})).await, Ok(json!({})));
}

#[tokio::test]
async fn a_message_that_is_too_long_ends_its_viewer_only() {
    let bench = Bench::start().await;
    let (mut good, mut bad) = (bench.viewer().await, bench.viewer().await);
    let long = format!("{{\"do\":\"ping\",\"x\":\"{}\"}}", "x".repeat(300 * 1024));
    // The server may close before it has read all of it.
    let _ = bad.socket.send(Message::text(long)).await;
    while bad.text().await.is_some() {}
    assert_eq!(good.ask(json!({"do": "ping"})).await, Ok(json!({})));
}

#[tokio::test]
async fn viewers_are_bounded() {
    let bench = Bench::start().await;
    let mut viewers = Vec::new();
    for _ in 0..super::VIEWERS {
        viewers.push(bench.viewer().await);
    }
    let origin = format!("http://{}", bench.address);
    match bench.connect(Some(&origin)).await {
        Err(Error::Http(answer)) => assert_eq!(answer.status(), 503),
        other => panic!("{other:?}"),
    }
    viewers.pop();
    let again = async {
        while bench.connect(Some(&origin)).await.is_err() {
            tokio::task::yield_now().await;
        }
    };
    timeout(SOON, again).await.expect("its place is free again");
}

#[tokio::test]
async fn the_state_is_pushed() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let first = viewer.push("status").await;
    assert_eq!(first["axes"].as_array().map(Vec::len), Some(7));
    let x = &first["axes"][0];
    assert_eq!((&x["name"], &x["state"]), (&json!("X"), &json!("Running")));
    assert_eq!(
        (&x["servo_on"], &x["homed"], &x["moving"]),
        (&json!(true), &json!(true), &json!(false))
    );
    assert!(
        x["bits"]
            .as_array()
            .is_some_and(|bits| bits.contains(&json!("ServoActionStatus")))
    );
    assert_eq!(x["faults"], json!([]));
    let system = &first["coordinate_systems"][0];
    assert_eq!(
        (&system["name"], &system["override"], &system["held"]),
        (&json!("CS1"), &json!(100.0), &json!(false))
    );
    let second = viewer.push("status").await;
    assert!(second["tick"].as_u64() > first["tick"].as_u64(), "{first} {second}");
}

mod costs;
mod driving;
mod interfaces;
mod login;
mod looking;
mod movers;
mod previews;
mod programs;
pub(crate) mod roles;
mod secured;

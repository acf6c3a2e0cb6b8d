//! Jogs whose client is lost, hangs or no longer holds the button, under the load of others: from its last message to the stop.

use super::*;

/// Silence after which the server stops the jog of a page.
const KEEP_WITHIN: Duration = Duration::from_millis(150);
/// Time between two confirmations of a page.
const KEEP_EVERY: Duration = Duration::from_millis(50);

impl Server {
    /// Sends a message of the page, and waits for its answer.
    fn ask(&self, page: &mut Page, mut message: serde_json::Value) {
        message["id"] = 5.into();
        let answer = async {
            page.send(Message::text(message.to_string())).await.expect("it is open");
            loop {
                match page.next().await.expect("it is open").expect("a message") {
                    Message::Text(answer) if answer.contains("\"id\":5") => return answer,
                    _ => {}
                }
            }
        };
        let answer = self
            .clients
            .block_on(async { tokio::time::timeout(SOON, answer).await });
        let answer = answer.expect("an answer in time");
        assert!(answer.contains("\"ok\""), "{message}: {answer}");
    }

    fn keep(&self, page: &mut Page) {
        let keep = json!({"do": "keep", "axis": "S"}).to_string();
        let sent = self.clients.block_on(page.send(Message::text(keep)));
        sent.expect("it is open");
    }

    /// The time from the last confirmation of a jog to its ramp; `None` if the jog was over before, since this machine sent confirmations late.
    fn dead_man(&self, page: &mut Page, load: &mut Load) -> Option<Duration> {
        self.until("it stands", |speed| speed == 0.0);
        self.ask(page, json!({"do": "jog", "axis": "S", "speed": 50.0}));
        let began = Instant::now();
        self.keep(page);
        if load.tasks.is_empty() {
            load.connect(self);
        }
        let mut busy_since = None;
        while busy_since.is_none_or(|since: Instant| since.elapsed() < WARM) {
            assert!(began.elapsed() < SOON, "not all clients are connected");
            std::thread::sleep(KEEP_EVERY);
            self.keep(page);
            if load.has_started() && busy_since.is_none() {
                busy_since = Some(Instant::now());
            }
        }
        if self.velocity() != 50.0 {
            return None;
        }
        let began = Instant::now();
        self.keep(page);
        self.until("the dead-man", |speed| speed < 50.0);
        Some(began.elapsed())
    }
}

#[test]
fn the_dead_man_waits_for_no_other_client() {
    let server = Server::start();
    let mut page = server.page();
    server.ask(&mut page, json!({"do": "take", "object": "S"}));
    server.under_loads("the dead-man", KEEP_WITHIN + BOUND, |server, load| {
        let mut tries = (0..10).filter_map(|_| server.dead_man(&mut page, load));
        tries.next().expect("a jog that its page can confirm in time")
    });
}

/// A client that jogs and then says nothing, with its socket open or closed, while others keep the network's thread busy.
#[test]
fn a_lost_client_stops_under_load() {
    let server = Server::start();
    for (why, closes, bound) in [
        ("its socket is closed", true, Duration::from_millis(250)),
        ("it hangs", false, Duration::from_millis(2600)),
    ] {
        let mut load = Load::new(|load, server| load.client(server, 32, vec![packet_of_attributes(0xF6)]));
        load.connect(&server);
        let mut client = server
            .clients
            .block_on(TcpStream::connect(server.eip))
            .expect("a place");
        let jogged = server.clients.block_on(jog_over(&mut client));
        assert!(jogged.is_some(), "{why}: it jogs");
        server.until("the jog has its speed", |speed| speed == 50.0);
        let began = Instant::now();
        let kept = if closes {
            drop(client);
            None
        } else {
            Some(client)
        };
        server.until(why, |speed| speed == 0.0);
        let took = began.elapsed();
        println!("{why}: at rest after {took:?}");
        assert!(took < bound, "{why}: {took:?}");
        drop((kept, load));
    }
}

/// Jogs S at 50 units/s over a session of its own.
async fn jog_over(stream: &mut TcpStream) -> Option<()> {
    use arcline_proto::logix::{Typed, encode_operands};
    use arcline_tag::{Elementary, Value};
    let (mut buf, decoder) = (BytesMut::new(), FrameDecoder::new(MAX_DATA));
    let register = RegisterSession::CURRENT.to_bytes();
    let mut session = SessionHandle(0);
    let mut operands = vec![Typed::ShortString("Lost".to_owned())];
    operands.extend(
        [0.0, 50.0, 0.0, 5000.0, 0.0, 0.001, 0.0]
            .map(|number| Typed::Numbers(Elementary::Lreal, vec![Value::Lreal(number)])),
    );
    let mut data = BytesMut::new();
    encode_operands(&operands, &mut data);
    let (class, service) = Mnemonic::Maj.instruction().service();
    let maj = Request::new(service, Epath::object(class, u32::from(S) + 1), data.freeze());
    let maj = Packet::unconnected(maj.to_bytes().ok()?).to_bytes();
    for (command, data) in [(Command::REGISTER_SESSION, register), (Command::SEND_RR_DATA, maj)] {
        let frame = EncapFrame::request(command, session, [0; 8], data);
        stream.write_all(&frame.to_bytes()).await.ok()?;
        let reply = loop {
            if let Some(frame) = decoder.decode(&mut buf).ok()? {
                break frame;
            }
            if stream.read_buf(&mut buf).await.ok()? == 0 {
                return None;
            }
        };
        session = reply.header.session;
    }
    Some(())
}

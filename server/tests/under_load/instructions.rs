//! Stops that travel as instructions, as a PLC sends them, under the load of others: from the bytes of the request to the ramp.

use arcline_proto::logix::{Typed, encode_operands};
use arcline_tag::{Elementary, Value};

use super::turns::Session;
use super::*;

/// The default machine with tags of stops.
fn config() -> String {
    let mut text = arcline_config::DEFAULT.to_owned();
    for (tag, kind, target) in [
        ("StopAxis", "MAS", "S"),
        ("StopGroup", "MGS", "Motion"),
        ("StopSystem", "MCS", "CS2"),
    ] {
        text += &format!("[[instruction]]\ntag = \"{tag}\"\ntype = \"{kind}\"\ntarget = \"{target}\"\n");
    }
    text
}

/// `EnableIn` of a tag, on or off.
fn enable(tag: &str, on: bool) -> Bytes {
    write_enable(tag, on).to_bytes().expect("a short path")
}

/// The service of a stop of S or of everything that S is part of, at the maxima.
fn service_of(mnemonic: Mnemonic) -> Bytes {
    let control = Typed::ShortString(format!("By{}", mnemonic.name()));
    let kind = Typed::Numbers(Elementary::Lreal, vec![Value::Lreal(0.0)]);
    let mut data = BytesMut::new();
    encode_operands(&[control, kind], &mut data);
    let (class, service) = mnemonic.instruction().service();
    // S is axis 4, and the third axis of coordinate system 2.
    let instance = match mnemonic {
        Mnemonic::Mcs => 2,
        Mnemonic::Mgs | Mnemonic::Mgsd => 1,
        _ => u32::from(S) + 1,
    };
    let request = Request::new(service, Epath::object(class, instance), data.freeze());
    request.to_bytes().expect("a short path")
}

/// The way in which a client sends a stop.
enum By {
    /// A CIP message, and the one that takes `EnableIn` back, if it was set.
    Cip(Bytes, Option<Bytes>),
    /// Run in a form of the page.
    Page(&'static str),
}

/// The ways to stop S.
fn stops() -> Vec<(&'static str, By)> {
    let tag = |name| By::Cip(enable(name, true), Some(enable(name, false)));
    let service = |mnemonic| By::Cip(service_of(mnemonic), None);
    vec![
        ("MAS by its tag", tag("StopAxis")),
        ("MGS by its tag", tag("StopGroup")),
        ("MCS by its tag", tag("StopSystem")),
        ("MAS by a service", service(Mnemonic::Mas)),
        ("MGS by a service", service(Mnemonic::Mgs)),
        ("MCS by a service", service(Mnemonic::Mcs)),
        ("MAS by the page", By::Page("MAS(S, ByPage, All);")),
        ("MGS by the page", By::Page("MGS(Motion, ByPage, Programmed);")),
    ]
}

/// A client and a page that jog and stop.
struct Clients<'s> {
    server: &'s Server,
    cip: Session,
    page: Page,
}

impl Clients<'_> {
    /// The time from the request to the ramp of a jog.
    fn stop(&mut self, name: &str, by: &By) -> Duration {
        self.server.jog();
        let runtime = &self.server.clients;
        let began = Instant::now();
        match by {
            By::Cip(message, _) => {
                let data = Packet::unconnected(message.clone()).to_bytes();
                runtime.block_on(self.cip.send(Command::SEND_RR_DATA, data));
            }
            By::Page(text) => {
                let ask = json!({"id": 9, "do": "execute", "text": text}).to_string();
                runtime.block_on(async { self.page.send(Message::text(ask)).await.expect("it is open") });
            }
        }
        self.server.until(name, |speed| speed < 50.0);
        let took = began.elapsed();
        match by {
            By::Cip(_, back) => {
                runtime.block_on(self.cip.reply());
                if let Some(back) = back {
                    runtime.block_on(self.cip.ask(back.clone()));
                }
            }
            By::Page(_) => runtime.block_on(async {
                loop {
                    match self.page.next().await.expect("it is open").expect("a message") {
                        Message::Text(answer) if answer.contains("\"id\":9") => break,
                        _ => {}
                    }
                }
            }),
        }
        took
    }
}

#[test]
fn stop_instructions_wait_for_no_others() {
    let server = Server::start_with(&config());
    let mut clients = Clients {
        server: &server,
        cip: server.clients.block_on(Session::open(server.eip)),
        page: server.page(),
    };
    #[rustfmt::skip]
    let loads: [(&str, Begin); 6] = [
        ("nothing",                      |_, _| {}),
        ("32 pipelined packets of 0xF6", |load, server| load.client(server, 32, vec![packet_of_attributes(0xF6)])),
        ("200 clients toggle EnableIn",  |load, server| (0..200).for_each(|_| load.client(server, 1, toggle("Move1")))),
        ("200 that toggle 4 ahead",      |load, server| (0..200).for_each(|_| load.client(server, 4, toggle("Move1")))),
        ("200 that toggle a stop",       |load, server| (0..200).for_each(|_| load.client(server, 1, toggle("Stop1")))),
        ("200 clients read 0xF6",        |load, server| (0..200).for_each(|_| load.client(server, 1, vec![packet_of_attributes(0xF6)]))),
    ];
    let mut late = Vec::new();
    for (why, begin) in loads {
        let mut load = Load::new(begin);
        load.begin(&server);
        for (stop, by) in stops() {
            let took: Vec<Duration> = (0..TRIES).map(|_| clients.stop(stop, &by)).collect();
            let answers = load.done.load(Ordering::Relaxed);
            println!("{why}: {stop} after {took:?}, {answers} answers");
            // On a machine that is busy with other programs, one try may be late.
            if took.iter().all(|took| *took > BOUND) {
                late.push((why, stop, took));
            }
        }
    }
    assert!(late.is_empty(), "stops came late: {late:?}");
}

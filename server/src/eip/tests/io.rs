//! Implicit I/O over a real socket: a scanner by hand, commands, lost owners, the Assembly object.

use std::net::SocketAddr;

use arcline_config::IoLoss;
use arcline_controller::Snapshot;
use arcline_instruction_set::{Mnemonic, UnboundOperand};
use arcline_proto::connection::{ConnectionType, Count};
use arcline_proto::cpf::Item;
use arcline_proto::epath::Segment;
use arcline_proto::io::{Datagram, Ownership};
use tokio::net::UdpSocket;

use super::*;
use crate::eip::io::layout::{INPUT, INPUT_ONLY, LISTEN_ONLY, OUTPUT, command, status};
use crate::eip::pages;
use crate::pages::compare_or_write_part;
use crate::plant::{Call, Command as PlantCommand, Outcome, Principal};

/// Bytes of the assemblies of the default machine: four coordinate systems, seven axes.
const INPUT_SIZE: u16 = 12 + 4 * 24 + 7 * 20;
const OUTPUT_SIZE: u16 = 4 + 4 * 4;

/// A device with I/O.
pub(super) fn bench(reaction: IoLoss) -> Bench {
    Bench::with(|settings| {
        settings.config.io = IoListen::At("127.0.0.1:0".parse().expect("an address"));
        settings.config.io_loss = reaction;
    })
}

fn key(serial: u16) -> ConnectionKey {
    ConnectionKey {
        serial,
        vendor: 0x1337,
        originator: 42,
    }
}

/// A Forward Open at 5 ms, with a timeout of 16 intervals.
pub(super) fn open(serial: u16, output: u32) -> ForwardOpen {
    let parameters = |size| NetworkParameters {
        variable: false,
        priority: 2,
        ..NetworkParameters::explicit(size)
    };
    let size = if output == OUTPUT { OUTPUT_SIZE + 6 } else { 2 };
    ForwardOpen {
        time: TickTime::DEFAULT,
        o_to_t_id: ConnectionId(0),
        t_to_o_id: ConnectionId(u32::from(serial)),
        key: key(serial),
        multiplier: 2,
        o_to_t_rpi: 5000,
        o_to_t: parameters(size),
        t_to_o_rpi: 5000,
        t_to_o: parameters(INPUT_SIZE + 2),
        transport: 1,
        path: Epath(vec![
            Segment::Class(4),
            Segment::Instance(151),
            Segment::ConnectionPoint(output),
            Segment::ConnectionPoint(INPUT),
        ]),
    }
}

/// One connection's originator.
struct Scanner {
    udp: UdpSocket,
    target: SocketAddr,
    id: ConnectionId,
    sequence: u32,
}

/// The contents of a datagram.
struct Input {
    sequence: u32,
    count: u16,
    data: Vec<u8>,
}

impl Input {
    fn word(&self, offset: usize) -> u32 {
        let bytes = self.data[offset..offset + 4].try_into().expect("four bytes");
        u32::from_le_bytes(bytes)
    }

    fn real(&self, offset: usize) -> f32 {
        f32::from_bits(self.word(offset))
    }
}

impl Client {
    /// Sends a Forward Open with the port of a scanner; the reply and where the target listens.
    pub(super) async fn open_io(&mut self, open: &ForwardOpen, port: u16) -> (Reply, Option<SocketAddrV4>) {
        let (reply, items) = self.open_items(open, port).await;
        let listens = items.iter().find_map(|item| match item {
            Item::SockaddrOToT(address) => Some(*address),
            _ => None,
        });
        (reply, listens)
    }

    /// The same with all items of the reply.
    async fn open_items(&mut self, open: &ForwardOpen, port: u16) -> (Reply, Vec<Item>) {
        let request = Request::new(
            service::FORWARD_OPEN,
            Epath::object(6, 1),
            open.to_bytes(false).expect("a short path"),
        );
        let mut packet = Packet::unconnected(request.to_bytes().expect("a short path"));
        packet
            .items
            .push(Item::SockaddrTToO(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, port)));
        let frame = self.exchange(Command::SEND_RR_DATA, packet.to_bytes()).await;
        let packet = Packet::decode(&frame.data).expect("a packet");
        let reply = Reply::decode(packet.unconnected_message().expect("a message")).expect("a reply");
        (reply, packet.items)
    }

    async fn scan(&mut self, open: &ForwardOpen) -> Scanner {
        let udp = UdpSocket::bind("127.0.0.1:0").await.expect("a port");
        let port = udp.local_addr().expect("bound").port();
        let (reply, listens) = self.open_io(open, port).await;
        assert!(reply.status.is_success(), "{}", reply.status);
        let reply = ForwardOpenReply::decode(&reply.data).expect("a Forward Open reply");
        assert_eq!((reply.o_to_t_api, reply.t_to_o_api), (open.o_to_t_rpi, open.t_to_o_rpi));
        let listens = listens.expect("item 0x8000");
        assert!(listens.ip().is_unspecified(), "the address of the TCP connection");
        Scanner {
            udp,
            target: SocketAddr::new(PEER, listens.port()),
            id: reply.o_to_t_id,
            sequence: 0,
        }
    }

    pub(super) async fn assembly(&mut self, code: u8, instance: u32, attribute: u16, data: &[u8]) -> Reply {
        self.ask(&Request::new(
            code,
            Epath::attribute(4, instance, attribute),
            Bytes::copy_from_slice(data),
        ))
        .await
    }

    pub(super) async fn close_io(&mut self, serial: u16) -> CipStatus {
        let connected = Connected {
            id: ConnectionId(0),
            sequence: 0,
            key: key(serial),
        };
        self.close(&connected).await.status
    }
}

pub(super) fn output(word: u32, overrides: [f32; 4]) -> Vec<u8> {
    let mut data = word.to_le_bytes().to_vec();
    overrides.iter().for_each(|percent| data.extend(percent.to_le_bytes()));
    data
}

impl Scanner {
    async fn send(&mut self, data: &[u8]) {
        self.sequence += 1;
        let mut out = BytesMut::new();
        Datagram {
            id: self.id,
            sequence: self.sequence,
            data,
        }
        .encode(&mut out);
        self.udp.send_to(&out, self.target).await.expect("sent");
    }

    async fn send_output(&mut self, run: bool, word: u32, overrides: [f32; 4]) {
        let mut data = (self.sequence as u16).wrapping_add(1).to_le_bytes().to_vec();
        data.extend(u32::from(run).to_le_bytes());
        data.extend(output(word, overrides));
        self.send(&data).await;
    }

    async fn input(&self) -> Input {
        let mut buf = [0; 1500];
        let receive = self.udp.recv_from(&mut buf);
        let (length, from) = tokio::time::timeout(PATIENCE, receive)
            .await
            .expect("in time")
            .expect("a datagram");
        assert_eq!(from, self.target, "it leaves from the port of I/O");
        let datagram = Datagram::decode(&buf[..length]).expect("a datagram");
        let (count, data) = datagram.data.split_first_chunk().expect("class 1");
        assert_eq!(data.len(), usize::from(INPUT_SIZE));
        Input {
            sequence: datagram.sequence,
            count: u16::from_le_bytes(*count),
            data: data.to_vec(),
        }
    }

    /// Sends the same output until the inputs say so.
    async fn until(
        &mut self,
        what: &str,
        run: bool,
        word: u32,
        overrides: [f32; 4],
        done: impl Fn(&Input) -> bool,
    ) -> Input {
        let look = async {
            loop {
                self.send_output(run, word, overrides).await;
                let input = self.input().await;
                if done(&input) {
                    return input;
                }
            }
        };
        tokio::time::timeout(PATIENCE, look)
            .await
            .unwrap_or_else(|_| panic!("{what}: never"))
    }
}

/// The offsets of the fields of the first coordinate system and of the axis X.
const STATUS: usize = 4;
const ECHO: usize = 8;
const OVERRIDE: usize = 12 + 8;
const AXIS_X: usize = 12 + 4 * 24;
const MOTION_STATUS_X: usize = AXIS_X + 8;
const POSITION_X: usize = AXIS_X + 16;

impl Bench {
    fn snapshot<R>(&self, read: impl FnOnce(&Snapshot) -> R) -> R {
        self.device.plant.with_snapshot(read)
    }

    async fn until_snapshot(&self, what: &str, done: impl Fn(&Snapshot) -> bool) {
        let look = async {
            while !self.snapshot(&done) {
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
        };
        tokio::time::timeout(PATIENCE, look)
            .await
            .unwrap_or_else(|_| panic!("{what}: never"));
    }

    /// CS1 sets out on a way of ten minutes along X, and the axis C jogs.
    async fn set_out(&self) {
        let plant = &self.device.plant;
        let number = UnboundOperand::Number;
        let line = [
            number(0.0),
            UnboundOperand::Array(vec![60_000.0, 0.0, 0.0]),
            number(100.0),
            number(0.0),
            number(5000.0),
            number(0.0),
            number(5000.0),
            number(0.0),
            number(0.0),
        ];
        let call = Call {
            mnemonic: Mnemonic::Mclm,
            target: Some(0),
            control: Some("Line"),
            operands: &line,
            text: None,
        };
        let done = plant.apply(Principal::Server, PlantCommand::Call(call)).await;
        let Ok(Outcome::Executed(executed)) = done else {
            panic!("{done:?}")
        };
        assert_eq!(executed.control.err, 0);
        self.until_snapshot("X moves", |snapshot| snapshot.axes[0].command[1] > 50.0)
            .await;
    }

    fn counted(&self, count: Count) -> u16 {
        self.device.counters().of(count)
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn inputs_come_at_once_and_tell_the_state() {
    let bench = bench(IoLoss::Stop);
    let mut client = bench.client().await;
    let mut scanner = client.scan(&open(1, OUTPUT)).await;
    let first = scanner.input().await;
    assert_eq!((first.sequence, first.count), (1, 1), "right after the reply");
    assert_eq!(first.word(STATUS), status::OWNED);
    let input = scanner
        .until("in run", true, 0, [100.0; 4], |input| {
            input.word(STATUS) == status::OWNED | status::RUN
        })
        .await;
    let expected = bench.snapshot(|snapshot| {
        (
            snapshot.systems[0].status,
            snapshot.axes[0].status,
            snapshot.axes[0].cip_status,
        )
    });
    assert_eq!(
        (input.word(12), input.word(AXIS_X + 4), input.word(AXIS_X + 12)),
        expected
    );
    assert!(input.word(0) > 0, "the tick");

    // The TCP connection goes, the I/O connection stays; the word is an echo.
    drop(client);
    scanner
        .until("the echo", true, 0x100, [100.0; 4], |input| input.word(ECHO) == 0x100)
        .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_command_word_holds_resumes_overrides_and_stops() {
    let bench = bench(IoLoss::Finish);
    let mut client = bench.client().await;
    let mut scanner = client.scan(&open(1, OUTPUT)).await;
    bench.set_out().await;
    let all = [100.0; 4];
    let at = |percent: f32| move |input: &Input| input.real(OVERRIDE) == percent;
    scanner.until("hold", true, command::HOLD, all, at(0.0)).await;
    bench
        .until_snapshot("X holds", |snapshot| snapshot.axes[0].command[1] == 0.0)
        .await;
    scanner.until("resume", true, command::RESUME, all, at(100.0)).await;
    scanner
        .until("override", true, command::OVERRIDE, [50.0, 40.0, 30.0, 20.0], at(50.0))
        .await;
    let overrides = bench.snapshot(|snapshot| snapshot.systems.iter().map(|s| s.feed_override).collect::<Vec<_>>());
    assert_eq!(overrides, [0.5, 0.4, 0.3, 0.2]);
    scanner
        .until("a change", true, command::OVERRIDE, [60.0; 4], at(60.0))
        .await;
    let refused = scanner
        .until(
            "out of range",
            true,
            command::OVERRIDE,
            [201.0, 70.0, f32::NAN, 70.0],
            |input| input.word(STATUS) & status::REFUSED != 0,
        )
        .await;
    assert_eq!(refused.real(OVERRIDE), 60.0, "it stays as it was");
    // Held by a bit that stays, and taken again when it falls.
    scanner
        .until("hold wins", true, command::OVERRIDE | command::HOLD, [80.0; 4], at(0.0))
        .await;
    scanner
        .until("and ends", true, command::OVERRIDE, [80.0; 4], at(80.0))
        .await;
    scanner
        .until("stop", true, command::STOP, all, |input| {
            input.word(ECHO) == command::STOP && input.word(MOTION_STATUS_X) & 0x1_0007 == 0
        })
        .await;
    let stopped = bench.snapshot(|snapshot| snapshot.axes[0].command);
    assert_eq!(stopped[1], 0.0);
    // The bit stays set, and does not stop later motion.
    let input = scanner.input().await;
    assert_eq!(f64::from(input.real(POSITION_X)) as f32, stopped[0] as f32);
    bench.set_out().await;
    scanner
        .until("goes on", true, command::STOP, all, |input| {
            f64::from(input.real(POSITION_X)) > stopped[0] + 10.0
        })
        .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn lost_outputs_have_the_configured_reaction() {
    type Check = fn(&Snapshot) -> bool;
    let stopped: Check = |snapshot| snapshot.axes[0].command[1] == 0.0 && snapshot.systems[0].feed_override == 1.0;
    let held: Check = |snapshot| snapshot.axes[0].command[1] == 0.0 && snapshot.systems[0].feed_override == 0.0;
    let moving: Check = |snapshot| snapshot.axes[0].command[1] > 50.0;
    for (reaction, check) in [(IoLoss::Stop, stopped), (IoLoss::Hold, held), (IoLoss::Finish, moving)] {
        for way in ["silence", "close", "close without the wire", "idle"] {
            let bench = bench(reaction);
            let mut client = bench.client().await;
            let mut scanner = client.scan(&open(1, OUTPUT)).await;
            bench.set_out().await;
            scanner
                .until("run", true, 0, [100.0; 4], |input| {
                    input.word(STATUS) & status::RUN != 0
                })
                .await;
            let io = bench.device.io().expect("I/O");
            let zeros = vec![0; usize::from(OUTPUT_SIZE)];
            match way {
                "silence" => {}
                "close" => assert!(client.close_io(1).await.is_success()),
                "close without the wire" => {
                    assert!(io.close(key(1), PEER, &bench.device));
                    // The reaction comes before the reply: it does not stop motion that the originator begins after the reply.
                    assert_eq!(bench.device.assembly_data().output(), zeros, "{reaction:?}");
                }
                _ => scanner.send_output(false, command::HOLD, [0.0; 4]).await,
            }
            let ownership = if way == "idle" {
                Ownership::Idle
            } else {
                Ownership::Free
            };
            let look = async {
                while io.ownership() != ownership {
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
            };
            tokio::time::timeout(PATIENCE, look).await.expect("in time");
            bench.until_snapshot(&format!("{reaction:?} after {way}"), check).await;
            let timeouts = bench.counted(Count::ConnectionTimeouts);
            assert_eq!(timeouts, u16::from(way == "silence"), "{reaction:?} after {way}");
            assert_eq!(bench.device.assembly_data().output(), zeros);
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn openings_that_are_refused_and_counted() {
    let bench = bench(IoLoss::Stop);
    let mut client = bench.client().await;
    let _owner = client.scan(&open(1, OUTPUT)).await;
    let mut wrong_output = open(2, OUTPUT);
    wrong_output.o_to_t.size -= 1;
    let mut wrong_input = open(2, INPUT_ONLY);
    wrong_input.t_to_o.size += 4;
    let mut again_longer = open(1, OUTPUT);
    again_longer.o_to_t.size += 2;
    let mut null = open(2, OUTPUT);
    null.o_to_t.connection_type = ConnectionType::Null;
    null.t_to_o.connection_type = ConnectionType::Null;
    let mut fast = open(2, INPUT_ONLY);
    fast.t_to_o_rpi = 999;
    let mut multicast = open(2, INPUT_ONLY);
    multicast.o_to_t.connection_type = ConnectionType::Multicast;
    let failed = CipStatus::connection;
    #[rustfmt::skip]
    let cases = [
        ("a second owner",   open(2, OUTPUT), failed(0x0106)),
        ("the same again",   open(1, OUTPUT), failed(0x0100)),
        ("the same, longer", again_longer,    failed(0x0100)),
        ("null, of nothing", null,            failed(0x0132)),
        ("output size",      wrong_output,    failed(0x0127).with(OUTPUT_SIZE + 6)),
        ("input size",       wrong_input,     failed(0x0128).with(INPUT_SIZE + 2)),
        ("RPI",              fast,            failed(0x0111)),
        ("multicast out",    multicast,       failed(0x0123)),
        ("no such assembly", open(2, 7),      failed(0x012A)),
    ];
    let count = cases.len();
    for (why, open, expected) in cases {
        let mut open = open;
        if why == "no such assembly" {
            open.o_to_t.size = 2;
        }
        let (reply, listens) = client.open_io(&open, 1).await;
        assert_eq!(reply.status, expected, "{why}");
        assert_eq!(listens, None, "{why}");
    }
    // A client on another TCP connection sees the same, and may close the connections from its address.
    let mut other = bench.client().await;
    assert_eq!(other.open_io(&open(1, OUTPUT), 1).await.0.status, failed(0x0100));
    let listener = other.scan(&open(3, LISTEN_ONLY)).await;
    assert_eq!(listener.input().await.sequence, 1);
    assert!(other.close_io(1).await.is_success());
    assert_eq!(other.close_io(3).await, failed(0x0107), "nothing was left to hear");
    assert_eq!(
        [
            Count::OpenRequests,
            Count::OpenOtherRejects,
            Count::OpenResourceRejects,
            Count::CloseRequests,
            Count::CloseOtherRejects
        ]
        .map(|count| bench.counted(count)),
        [count as u16 + 3, count as u16 + 1, 0, 2, 1]
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn without_io_class_1_is_refused() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let (reply, _) = client.open_io(&open(1, OUTPUT), 1).await;
    assert_eq!(reply.status, CipStatus::connection(0x011C));
}

#[tokio::test(flavor = "multi_thread")]
async fn the_assembly_object() {
    let bench = bench(IoLoss::Stop);
    let mut client = bench.client().await;
    let get = service::GET_ATTRIBUTE_SINGLE;
    #[rustfmt::skip]
    let sizes = [(INPUT, INPUT_SIZE), (OUTPUT, OUTPUT_SIZE), (151, 0), (INPUT_ONLY, 0), (LISTEN_ONLY, 0)];
    for (instance, size) in sizes {
        let reply = client.assembly(get, instance, 4, &[]).await;
        assert_eq!(reply.data[..], size.to_le_bytes(), "size of {instance}");
        let reply = client.assembly(get, instance, 3, &[]).await;
        assert_eq!(
            (reply.status, reply.data.len()),
            (CipStatus::SUCCESS, usize::from(size)),
            "data of {instance}"
        );
    }
    let status_of = |reply: Reply| codes(reply.status);
    assert_eq!(status_of(client.assembly(get, 99, 3, &[]).await), (0x05, 0));
    assert_eq!(status_of(client.assembly(get, INPUT, 5, &[]).await), (0x14, 0));

    // The assembly object commands the outputs as long as no connection owns them.
    let set = service::SET_ATTRIBUTE_SINGLE;
    let data = output(command::OVERRIDE, [50.0; 4]);
    assert_eq!(status_of(client.assembly(set, INPUT, 3, &[0; 248]).await), (0x0E, 0));
    assert_eq!(status_of(client.assembly(set, OUTPUT, 3, &data[1..]).await), (0x13, 0));
    let mut long = data.clone();
    long.extend([1, 2, 3]);
    assert_eq!(status_of(client.assembly(set, OUTPUT, 3, &long).await), (0x15, 0));
    assert_eq!(status_of(client.assembly(set, OUTPUT, 3, &data).await), (0, 0));
    bench
        .until_snapshot("the override", |snapshot| snapshot.systems[3].feed_override == 0.5)
        .await;
    assert_eq!(client.assembly(get, OUTPUT, 3, &[]).await.data[..], data);
    let _owner = client.scan(&open(1, OUTPUT)).await;
    assert_eq!(status_of(client.assembly(set, OUTPUT, 3, &data).await), (0x0C, 0));
}

#[test]
fn the_tables_of_the_page_are_new() {
    compare_or_write_part("docs/IO.md", "connections", &pages::connections());
    compare_or_write_part("docs/IO.md", "input assembly", &pages::input_assembly());
}

/// Inputs by multicast: the reply names the group and an id of ours, and the group is sent each datagram once.
#[tokio::test(flavor = "multi_thread")]
async fn inputs_are_sent_to_a_group() {
    let bench = bench(IoLoss::Stop);
    let mut client = bench.client().await;
    let mut wanted = open(1, INPUT_ONLY);
    wanted.t_to_o.connection_type = ConnectionType::Multicast;
    // Host 1 of 127.0.0.0/8: the first group, as in attribute 9 of the TCP/IP Interface.
    let group = SocketAddrV4::new(Ipv4Addr::new(239, 192, 1, 0), 2222);
    let heard = UdpSocket::bind(group).await.expect("nobody else has the group");
    heard
        .join_multicast_v4(*group.ip(), Ipv4Addr::LOCALHOST)
        .expect("a group of the loopback interface");
    let mut ids = Vec::new();
    for serial in [1, 2] {
        wanted.key = key(serial);
        let (reply, items) = client.open_items(&wanted, 0).await;
        assert!(reply.status.is_success(), "{}", reply.status);
        assert!(
            matches!(items.as_slice(), [_, _, Item::SockaddrOToT(_), Item::SockaddrTToO(told)] if *told == group),
            "{items:?}"
        );
        ids.push(ForwardOpenReply::decode(&reply.data).expect("opened").t_to_o_id);
    }
    assert_eq!(ids[0], ids[1]);
    assert_ne!(ids[0], wanted.t_to_o_id);
    let mut last = None;
    for _ in 0..20 {
        let mut buf = [0; 2048];
        let received = tokio::time::timeout(PATIENCE, heard.recv(&mut buf)).await;
        let length = received.expect("in time").expect("a datagram");
        let datagram = Datagram::decode(&buf[..length]).expect("a datagram");
        assert_eq!(datagram.data.len(), usize::from(INPUT_SIZE) + 2);
        if datagram.id == ids[0] {
            let expected = last.map_or(datagram.sequence, |last: u32| last.wrapping_add(1));
            assert_eq!(datagram.sequence, expected, "each once");
            last = Some(datagram.sequence);
        }
    }
    assert!(last.is_some());
}

/// A change of state leaves at once; while nothing changes, only the interval sends.
#[tokio::test(flavor = "multi_thread")]
async fn a_change_of_state_leaves_before_the_interval_is_over() {
    let bench = bench(IoLoss::Stop);
    let mut client = bench.client().await;
    let mut wanted = open(1, INPUT_ONLY);
    wanted.transport = 0x11;
    // 10 s, the longest: an input that comes before was sent by a change.
    wanted.t_to_o_rpi = 10_000_000;
    wanted.o_to_t_rpi = 10_000_000;
    wanted.multiplier = 0;
    wanted.path.0.insert(
        0,
        Segment::Network {
            kind: 0x43,
            data: Bytes::from_static(&[1]),
        },
    );
    let scanner = client.scan(&wanted).await;
    let first = scanner.input().await;
    assert_eq!((first.sequence, first.count), (1, 1));
    let real = WireType::Atomic(0xCA);
    let percent = 50_f32.to_le_bytes();
    assert!(client.write("FeedOverride[0]", real, &percent).await.is_success());
    let changed = loop {
        // Another value may change first: the drives settle when the machine starts.
        let input = scanner.input().await;
        if input.real(12 + 8) == 50.0 {
            break input;
        }
    };
    assert_eq!(u32::from(changed.count), changed.sequence, "new data each time");
}

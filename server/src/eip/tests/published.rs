//! Published failures of other stacks (spec/ethernet-ip.md §20), each a test named after it. Those of the decoders and
//! of connections that come and go are in `proto/tests/published.rs`.
//!
//! `ARCLINE_SOCKETS` and `ARCLINE_FUZZ` make the long ones longer.

use arcline_proto::cip::{Request, join_multiple, service};
use arcline_proto::connection::UnconnectedSend;
use arcline_proto::encap::{Command, EncapFrame};
use arcline_proto::epath::Epath;
use arcline_tag::Elementary;
use std::net::SocketAddr;
use std::time::Instant;
use tokio::net::TcpStream;

use super::hostile::messages;
use super::*;
use crate::eip::Listener;

/// A size of a test, from an environment variable.
fn scale(variable: &str, default: usize) -> usize {
    std::env::var(variable).map_or(default, |text| text.parse().expect("a number"))
}

/// A generator whose sequence is the same in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).expect("31 bits") % end
    }

    /// One of the messages, with some of its bytes others, or cut, or longer.
    fn message(&mut self, from: &[Bytes]) -> Bytes {
        let mut message = from[self.below(from.len())].to_vec();
        for _ in 0..=self.below(4) {
            let place = self.below(message.len());
            message[place] = u8::try_from(self.below(256)).expect("below 256");
        }
        match self.below(4) {
            0 => message.truncate(1 + self.below(message.len())),
            1 => message.extend(vec![0xFF; self.below(300)]),
            _ => {}
        }
        message.into()
    }
}

#[tokio::test]
async fn opener_cve_2020_13556_2022_43604_2022_43605_attribute_counts() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let objects = [
        (0x01, 1),
        (0x02, 1),
        (0x06, 1),
        (0x6B, 1),
        (0x6C, 0xFCE),
        (0x8B, 1),
        (0xAC, 1),
        (0xF5, 1),
        (0x302, 1),
    ];
    for (class, instance) in objects {
        for code in [
            service::GET_ATTRIBUTE_LIST,
            service::SET_ATTRIBUTE_LIST,
            service::GET_INSTANCE_ATTRIBUTE_LIST,
        ] {
            for count in [0_u16, 1, 2, 3, 4, 255, 256, 0x7FFF, 0x8000, u16::MAX] {
                for length in 0..10 {
                    let mut data = count.to_le_bytes().to_vec();
                    data.extend([6, 0, 1, 0, 2, 0, 0xFF, 0xFF, 3, 0].iter().take(length));
                    client
                        .ask(&Request::new(code, Epath::object(class, instance), data))
                        .await;
                }
            }
        }
    }
    assert_eq!(client.read("aDint").await.data.len(), 4, "it still works");
}

#[tokio::test]
async fn opener_131_87_half_open_and_silent_sockets() {
    let sockets = scale("ARCLINE_SOCKETS", 400);
    let (plant, _thread) = plant();
    let mut settings = settings_of("Patient");
    settings.config.max_clients = settings.config.max_clients.min(sockets / 2);
    settings.session.register_timeout = Duration::from_millis(300);
    let any = SocketAddr::from(([127, 0, 0, 1], 0));
    let listener = Listener::bind(any, plant, settings).await.expect("a port");
    let address = listener.local_addr();
    let server = tokio::spawn(listener.serve());
    let register = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        [0; 8],
        RegisterSession::CURRENT.to_bytes(),
    )
    .to_bytes();
    let mut silent = Vec::new();
    for number in 0..sockets {
        let mut stream = TcpStream::connect(address).await.expect("a connection");
        // Some say nothing, the others stop somewhere on the way. One that is closed already cannot be written to.
        let _ = stream.write_all(&register[..number % register.len()]).await;
        silent.push(stream);
    }
    let mut client = TcpStream::connect(address).await.expect("a connection");
    client.write_all(&register).await.expect("sent");
    let mut reply = [0; 28];
    let limit = PATIENCE * u32::try_from(1 + sockets / 1000).expect("few");
    tokio::time::timeout(limit, client.read_exact(&mut reply))
        .await
        .expect("in time")
        .expect("an answer");
    for mut stream in silent {
        let mut byte = [0];
        let end = tokio::time::timeout(PATIENCE, stream.read(&mut byte))
            .await
            .expect("closed in time");
        assert!(matches!(end, Ok(0) | Err(_)), "closed by the server");
    }
    server.abort();
}

#[tokio::test]
async fn openplc_cve_2024_34026_nothing_nests() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut packet = read("aDint", 1);
    let mut send = read("aDint", 1);
    for depth in 0..40 {
        let data = join_multiple(std::slice::from_ref(&packet)).expect("short");
        packet = Request::new(service::MULTIPLE_SERVICE_PACKET, Epath::object(2, 1), data);
        let route = Epath(vec![]);
        let inside = UnconnectedSend {
            time: TickTime::DEFAULT,
            message: send.to_bytes().expect("short"),
            route,
        };
        send = Request::new(
            service::UNCONNECTED_SEND,
            Epath::object(6, 1),
            inside.to_bytes().expect("short"),
        );
        let expected = if depth == 0 { [0, 0] } else { [0x1E, 0x08] };
        let got = [
            client.ask(&packet).await.status.general(),
            client.ask(&send).await.status.general(),
        ];
        assert_eq!(got, expected, "{depth} deep");
    }
}

#[tokio::test]
async fn rta_499es_cve_2020_25159_netstax_cve_2026_78012_long_paths() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for kind in 0..=u8::MAX {
        for filler in [[kind, 0], [kind, 1], [kind, 4], [kind, 0xFF], [0x91, kind]] {
            for words in [254_u8, 255] {
                let mut message = vec![service::READ_TAG, words];
                message.extend(filler.iter().cycle().take(2 * usize::from(words)));
                message.extend([1, 0]);
                let status = client.raw(message.into()).await.status;
                assert!(!status.is_success(), "{words} words of {filler:02X?}");
            }
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn logix_cve_2026_11317_configuration_and_positions_stay() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut state = Vec::new();
    // The last of the messages moves axes, as it should.
    let mut harmless = messages();
    harmless.pop();
    let mut random = Random(1);
    for round in 0..=1 {
        let mut seen = Vec::new();
        for axis in ["X", "Y", "Z"] {
            seen.push(client.read(&format!("{axis}.CommandPosition")).await.data);
            seen.push(client.read(&format!("{axis}.ActualPosition")).await.data);
        }
        let tags = bench.device.plant.with_image(|image| {
            let tags = image.tags().iter();
            tags.map(|tag| format!("{} {}", tag.name, tag.id.0)).collect::<Vec<_>>()
        });
        state.push((seen, tags));
        if round == 0 {
            for _ in 0..scale("ARCLINE_FUZZ", 3000) {
                client.raw(random.message(&harmless)).await;
            }
        }
    }
    assert_eq!(state[0], state[1]);
}

#[tokio::test]
async fn compactlogix_cve_2025_11694_connections_of_others() {
    let bench = Bench::new();
    let mut owner = bench.client().await;
    let mut owned = owner.open(500, 1).await;
    let identity = Request::new(service::GET_ATTRIBUTES_ALL, Epath::object(1, 1), Bytes::new());
    assert!(owner.ask_connected(&mut owned, &identity).await.status.is_success());

    // Another socket cannot close it, nor send over it, with the right id or a guessed one.
    let mut other = bench.client().await;
    assert_eq!(
        codes(other.close(&owned).await.status),
        (0x01, 0x0107),
        "another's connection"
    );
    for id in [owned.id.0, owned.id.0.wrapping_add(1), owned.id.0 ^ 0x8000_0000, 0, 1] {
        let mut intruder = bench.client().await;
        let set = write("aDint", Elementary::Dint.into(), 1, &[9, 9, 9, 9])
            .to_bytes()
            .expect("short");
        let packet = Packet::connected(ConnectionId(id), owned.sequence.wrapping_add(1), &set);
        let frame = EncapFrame::request(Command::SEND_UNIT_DATA, intruder.session, [0; 8], packet.to_bytes());
        intruder.send(&frame.to_bytes()).await;
        assert_eq!(intruder.frame().await, None, "{id:#X}: no answer but the end");
    }
    assert_eq!(bench.device.open_connections(), 1);
    assert_eq!(&owner.read("aDint").await.data[..], [0; 4], "nothing was written");
    // Nor does another sequence count than the next disturb the owner.
    for sequence in [0, 0x7FFF, 0xFFFF, 2] {
        owned.sequence = sequence;
        assert!(owner.repeat(&owned, &identity).await.status.is_success(), "{sequence}");
    }

    // Ids cannot be guessed: no two differ by the same.
    let mut ids = Vec::new();
    for serial in 10..30 {
        ids.push(owner.open(500, serial).await.id.0);
    }
    let mut steps: Vec<u32> = ids.windows(2).map(|pair| pair[1].wrapping_sub(pair[0])).collect();
    steps.sort_unstable();
    steps.dedup();
    assert_eq!(steps.len(), 19, "{ids:08X?}");
    assert!(!ids.contains(&0));
}

#[tokio::test(flavor = "multi_thread")]
async fn logix_cve_2022_1797_malformed_data_in_an_open_connection() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(4002, 1).await;
    let mut random = Random(2);
    let messages = messages();
    for _ in 0..scale("ARCLINE_FUZZ", 3000) {
        connected.sequence = connected.sequence.wrapping_add(1);
        let message = random.message(&messages);
        let packet = Packet::connected(connected.id, connected.sequence, &message);
        let frame = client.exchange(Command::SEND_UNIT_DATA, packet.to_bytes()).await;
        let packet = Packet::decode(&frame.data).expect("a packet");
        let (id, sequence, reply) = packet.connected_message().expect("class 3");
        assert_eq!((id.0, sequence), (0x0102_0304, connected.sequence), "{message:02X?}");
        assert!(reply.len() <= 4000 && Reply::decode(&reply).is_some(), "{message:02X?}");
    }
    let opened = bench.device.open_connections();
    assert!((1..=33).contains(&opened), "{opened} connections");
    assert_eq!(
        // Plain tags may have been deleted: that is a service.
        client
            .ask_connected(&mut connected, &read("X.ActualPosition", 1))
            .await
            .data
            .len(),
        6
    );
    drop(client);
    let gone = async {
        while bench.device.open_connections() > 0 {
            tokio::task::yield_now().await;
        }
    };
    tokio::time::timeout(PATIENCE, gone).await.expect("all freed");
}

#[tokio::test(flavor = "multi_thread")]
async fn micro850_cve_2025_7693_forward_close_cut_and_altered() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut connected = client.open(500, 7).await;
    let close = arcline_proto::connection::ForwardClose {
        time: TickTime::DEFAULT,
        key: connected.key,
        path: Epath::object(2, 1),
    };
    let data = close.to_bytes().expect("short");
    let message = Request::new(service::FORWARD_CLOSE, Epath::object(6, 1), data)
        .to_bytes()
        .expect("short");
    for cut in 0..message.len() {
        client.raw(message.slice(..cut)).await;
        if bench.device.open_connections() == 0 {
            connected = client.open(500, 7).await;
        }
    }
    for place in 0..message.len() {
        for value in 0..=u8::MAX {
            let mut altered = message.to_vec();
            altered[place] = value;
            client.raw(altered.into()).await;
            if bench.device.open_connections() == 0 {
                connected = client.open(500, 7).await;
            }
        }
    }
    assert!(
        client
            .ask_connected(&mut connected, &read("aDint", 1))
            .await
            .status
            .is_success()
    );
    assert!(client.close(&connected).await.status.is_success());
    assert_eq!(bench.device.open_connections(), 0);
}

#[tokio::test]
async fn libplctag_pr_664_671_367_lengths_of_strings() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let string = WireType::Structure(0x0FCE);
    for (length, seen) in [(-1_i32, 0), (i32::MIN, 0), (83, 82), (i32::MAX, 82), (82, 82), (0, 0)] {
        let mut data = length.to_le_bytes().to_vec();
        data.resize(88, b'x');
        client.write("aString", string, &data).await;
        let back = client.read("aString").await.data;
        let back = i32::from_le_bytes([back[0], back[1], back[2], back[3]]);
        assert_eq!(back, seen, "written as {length}");
    }
    for elements in [0_u16, 2, 4, 0x7FFF, u16::MAX] {
        let status = client.ask(&read("aString", elements)).await.status;
        assert!(!status.is_success(), "{elements} elements of one");
        let status = client.ask(&write("Strings", string, elements, &[0; 88])).await.status;
        assert!(!status.is_success(), "{elements} elements of three, one sent");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn rslinx_cve_2020_13573_the_next_request_is_answered_at_once() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let mut random = Random(3);
    let messages = messages();
    for _ in 0..300 {
        let hostile = random.message(&messages);
        client.raw(hostile.clone()).await;
        // The best of a few, since other tests run beside this one.
        let mut best = Duration::MAX;
        for _ in 0..50 {
            let began = Instant::now();
            client.read("aReal").await;
            best = best.min(began.elapsed());
            if best < Duration::from_millis(10) {
                break;
            }
        }
        assert!(best < Duration::from_millis(10), "{best:?} after {hostile:02X?}");
    }
}

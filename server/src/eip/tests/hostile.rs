//! To any bytes from a peer the server answers with an error or silence, never a panic, and the next request is answered.

use arcline_proto::cip::{Request, join_multiple, service};
use arcline_proto::connection::UnconnectedSend;
use arcline_proto::encap::{Command, EncapFrame};
use arcline_proto::epath::Epath;
use arcline_tag::Elementary;

use super::*;

/// Messages that exercise every service there is.
pub(super) fn messages() -> Vec<Bytes> {
    let key = ConnectionKey {
        serial: 1,
        vendor: 2,
        originator: 3,
    };
    let inner = read("aDint", 1);
    let send = UnconnectedSend {
        time: TickTime::DEFAULT,
        message: inner.to_bytes().expect("short"),
        route: Epath(vec![]),
    };
    let object = |service, class, data: &'static [u8]| Request::new(service, Epath::object(class, 1), data);
    let requests = [
        inner.clone(),
        read("Move1.Position[2]", 3),
        write("aDint", Elementary::Dint.into(), 1, &[1, 2, 3, 4]),
        Request::new(
            service::READ_TAG_FRAGMENTED,
            path("Dints"),
            vec![0xB8, 0x0B, 0, 0, 0, 0],
        ),
        Request::new(
            service::READ_MODIFY_WRITE_TAG,
            path("aDint"),
            vec![4, 0, 0, 0, 0, 0, 255, 255, 255, 255],
        ),
        Request::new(
            service::MULTIPLE_SERVICE_PACKET,
            Epath::object(2, 1),
            join_multiple(&[inner.clone(), inner]).expect("short"),
        ),
        Request::new(
            service::UNCONNECTED_SEND,
            Epath::object(6, 1),
            send.to_bytes().expect("short"),
        ),
        forward_open(500, key),
        object(service::GET_ATTRIBUTE_LIST, 0x6C, &[4, 0, 4, 0, 5, 0, 2, 0, 1, 0]),
        object(service::GET_INSTANCE_ATTRIBUTE_LIST, 0x6B, &[3, 0, 1, 0, 2, 0, 8, 0]),
        object(
            service::SET_ATTRIBUTE_LIST,
            0x8B,
            &[2, 0, 6, 0, 1, 0, 0, 0, 0, 0, 0, 0, 10, 0, 0],
        ),
        object(0x32, 0x302, &[0xDA, 0, 1, 0, 1, b'M', 0xC4, 0, 1, 0, 0, 0, 0, 0]),
    ];
    requests
        .iter()
        .map(|request| request.to_bytes().expect("short"))
        .collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn messages_cut_or_altered_anywhere_are_answered() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for message in messages() {
        for cut in 0..message.len() {
            client.raw(message.slice(..cut)).await;
        }
        for place in 0..message.len() {
            for value in [0, 1, 0x7F, 0x80, 0xFF] {
                let mut altered = message.to_vec();
                altered[place] = value;
                client.raw(altered.into()).await;
            }
        }
    }
    assert!(
        client
            .write("aDint", Elementary::Dint.into(), &7_i32.to_le_bytes())
            .await
            .is_success()
    );
    assert_eq!(
        &client.read("aDint").await.data[..],
        7_i32.to_le_bytes(),
        "it still works"
    );
}

#[tokio::test]
async fn a_stream_cut_anywhere_harms_no_client() {
    let bench = Bench::new();
    let mut other = bench.client().await;
    let register = EncapFrame::request(
        Command::REGISTER_SESSION,
        SessionHandle(0),
        [0; 8],
        RegisterSession::CURRENT.to_bytes(),
    );
    let nop = EncapFrame::request(Command::NOP, SessionHandle(0), [0; 8], Bytes::from_static(&[0; 9]));
    let bytes = [register.to_bytes(), nop.to_bytes()].concat();
    for cut in 0..bytes.len() {
        let mut stream = bench.stream();
        stream.write_all(&bytes[..cut]).await.expect("written");
        drop(stream);
    }
    assert_eq!(other.read("aDint").await.data.len(), 4);
}

#[tokio::test(start_paused = true)]
async fn a_peer_that_never_reads_is_closed() {
    let bench = Bench::new();
    let client = bench.client().await;
    let request = read("Dints", 100).to_bytes().expect("short");
    let frame = EncapFrame::request(
        Command::SEND_RR_DATA,
        client.session,
        [0; 8],
        Packet::unconnected(request).to_bytes(),
    );
    let bytes = frame.to_bytes();
    let (_unread, mut write) = tokio::io::split(client.stream);
    let flood = async { while write.write_all(&bytes).await.is_ok() {} };
    tokio::time::timeout(Duration::from_secs(600), flood)
        .await
        .expect("the device gave up on us");
}

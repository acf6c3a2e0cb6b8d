//! What clients ask that none of the six in `tests/` asks, as they send it. Each test is named after the client that needs
//! the answer; the requests are as captured, without the encapsulation.

use super::*;

/// Bytes of hex text; blanks are for the reader.
fn bytes(text: &str) -> Bytes {
    let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
    let pair = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).expect("digits"), 16).expect("digits");
    digits.chunks(2).map(pair).collect()
}

/// The reply to a message without connection, from its service code on.
async fn answer(client: &mut Client, request: &str) -> Bytes {
    client.raw(bytes(request)).await.to_bytes()
}

#[tokio::test]
async fn ethernet_ip_of_npm_reads_and_sets_the_wall_clock_as_a_date() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    let read = "52 02 20062401 047d 0800  0e03 208b 2401 3005  0100 0100";
    let now = answer(&mut client, read).await;
    assert_eq!((&now[..4], now.len()), (&bytes("8e000000")[..], 4 + 28));

    // 2030-01-03 04:05:06.789.
    let date = "ee070000 01000000 03000000 04000000 05000000 06000000";
    let set = format!("52 02 20062401 047d 2400  1003 208b 2401 3005 {date} 080a0c00  0100 0100");
    assert_eq!(answer(&mut client, &set).await, bytes("90000000"));
    let shown = bytes(&format!("8e000000 {date}"));
    // To the minute: it goes on.
    let minute = 4 + 20;
    assert_eq!(answer(&mut client, read).await[..minute], shown[..minute]);
    let universal = answer(&mut client, "0e03 208b 2401 3007").await;
    assert_eq!(universal[..minute], shown[..minute], "local time is UTC");
    let micros = answer(&mut client, "0e03 208b 2401 3006").await;
    let micros = u64::from_le_bytes(micros[4..].try_into().expect("eight bytes"));
    assert_eq!(micros / 60_000_000, 1_893_643_500 / 60, "the same minute");

    #[rustfmt::skip]
    let refused = [
        ("no such day",        "ee070000 02000000 1e000000 00000000 00000000 00000000 00000000", "90000900"),
        ("a negative year",    "ffffffff 01000000 01000000 00000000 00000000 00000000 00000000", "90000900"),
        ("a field is missing", "ee070000 01000000 03000000 04000000 05000000 06000000",          "90001300"),
    ];
    for (why, date, reply) in refused {
        let set = format!("1003 208b 2401 3005 {date}");
        assert_eq!(answer(&mut client, &set).await, bytes(reply), "{why}");
    }
    assert_eq!(
        answer(&mut client, read).await[..minute],
        shown[..minute],
        "nothing of that was taken"
    );
}

/// Revision, highest instance, highest class attribute, highest instance attribute: its own tests expect these four of
/// a CompactLogix.
#[tokio::test]
async fn cippy_reads_all_attributes_of_a_class() {
    let bench = Bench::new();
    let mut client = bench.client().await;
    for (why, request, reply) in [
        ("Identity", "0102 2001 2400", "81000000 0100 0100 0700 0a00"),
        ("Connection Manager", "0102 2006 2400", "81000000 0100 0100 0700 6400"),
    ] {
        assert_eq!(answer(&mut client, request).await, bytes(reply), "{why}");
    }
}

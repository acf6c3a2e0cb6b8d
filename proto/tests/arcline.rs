//! The layouts of Arcline's own classes, byte for byte and in both directions (docs/TRACE.md; spec/contract.md §4).

use arcline_proto::arcline::execution::Ending;
use arcline_proto::arcline::motion::{Accepted, decode_instances, encode_instances};
use arcline_proto::arcline::trace::{
    ListSignals, MAX_SIGNALS, ReadRows, Rows, SignalList, State, TooLong, TraceRequest, Trigger,
};
use arcline_proto::cip::CipStatus;

fn hex(text: &str) -> Vec<u8> {
    let digits: Vec<u32> = text.chars().filter_map(|digit| digit.to_digit(16)).collect();
    digits.chunks(2).map(|pair| (pair[0] * 16 + pair[1]) as u8).collect()
}

fn request(trigger: Trigger) -> TraceRequest {
    TraceRequest {
        signals: vec!["X.A".to_owned()],
        before: 5,
        length: 7,
        every: 2,
        trigger,
    }
}

#[test]
fn a_trace_is_requested_as_documented() {
    let signal = || "X.B".to_owned();
    for (why, trigger, bytes) in [
        ("at once", Trigger::Now, "00"),
        (
            "at a level from below",
            Trigger::Rises {
                signal: signal(),
                level: 1.5,
            },
            "01 03 58 2e 42 | 000000000000f83f",
        ),
        (
            "at a level from above",
            Trigger::Falls {
                signal: signal(),
                level: -2.0,
            },
            "02 03 58 2e 42 | 00000000000000c0",
        ),
        (
            "when a bit is set",
            Trigger::BecomesTrue { signal: signal() },
            "03 03 58 2e 42",
        ),
        (
            "when a bit is cleared",
            Trigger::BecomesFalse { signal: signal() },
            "04 03 58 2e 42",
        ),
        (
            "at a bit of an instruction",
            Trigger::Instruction {
                name: "M1".to_owned(),
                flags: 0x0800_0000,
            },
            "05 02 4d 31 | 00000008",
        ),
    ] {
        let request = request(trigger);
        let expected = hex(&format!("05000000 07000000 0200 | {bytes} | 0100 03 58 2e 41"));
        assert_eq!(request.to_bytes().as_deref(), Ok(&expected[..]), "{why}");
        assert_eq!(TraceRequest::decode(&expected).as_ref(), Ok(&request), "{why}");
        for cut in 0..expected.len() {
            let decoded = TraceRequest::decode(&expected[..cut]);
            assert_eq!(decoded, Err(CipStatus::NOT_ENOUGH_DATA), "{why}, cut at {cut}");
        }
        let surplus = [&expected[..], &[0]].concat();
        assert_eq!(TraceRequest::decode(&surplus), Err(CipStatus::TOO_MUCH_DATA), "{why}");
    }
}

#[test]
fn requests_that_cannot_be_are_refused() {
    for (why, bytes) in [
        (
            "there is no trigger 6",
            "00000000 00000000 0000 | 06 | 0100 03 58 2e 41",
        ),
        (
            "a level is finite",
            "00000000 00000000 0000 | 01 01 58 000000000000f07f | 0100 03 58 2e 41",
        ),
        ("no signal", "00000000 00000000 0000 | 00 | 0000"),
        ("257 signals", "00000000 00000000 0000 | 00 | 0101"),
        ("a name is UTF-8", "00000000 00000000 0000 | 00 | 0100 01 ff"),
    ] {
        assert_eq!(
            TraceRequest::decode(&hex(bytes)),
            Err(CipStatus::INVALID_PARAMETER),
            "{why}"
        );
    }
    let many = TraceRequest {
        signals: vec!["X".to_owned(); usize::from(MAX_SIGNALS) + 1],
        ..request(Trigger::Now)
    };
    assert_eq!(many.to_bytes(), Err(TooLong::Signals { count: 257 }));
    let long = TraceRequest {
        signals: vec!["X".repeat(256)],
        ..request(Trigger::Now)
    };
    assert_eq!(long.to_bytes(), Err(TooLong::Name { bytes: 256 }));
}

#[test]
fn signals_are_listed_as_many_as_fit() {
    assert_eq!(ListSignals { first: 258 }.to_bytes()[..], [2, 1]);
    assert_eq!(ListSignals::decode(&[2, 1]), Ok(ListSignals { first: 258 }));
    assert_eq!(ListSignals::decode(&[2]), Err(CipStatus::NOT_ENOUGH_DATA));
    assert_eq!(ListSignals::decode(&[2, 1, 0]), Err(CipStatus::TOO_MUCH_DATA));
    let whole = hex("0900 0200 | 02 41 42 | 01 43");
    for (room, count) in [(9, 2), (8, 1), (7, 1), (6, 0)] {
        let bytes = SignalList::encode(9, ["AB", "C"], room);
        let list = SignalList::decode(&bytes).expect("a list");
        assert_eq!((list.total, list.names.len()), (9, count), "{room} bytes");
    }
    assert_eq!(SignalList::encode(9, ["AB", "C"], 9)[..], whole);
    for cut in 0..whole.len() {
        assert_eq!(SignalList::decode(&whole[..cut]), None, "cut at {cut}");
    }
}

#[test]
fn rows_are_laid_out_as_documented() {
    let read = ReadRows { from: 258, most: 3 };
    assert_eq!(read.to_bytes()[..], hex("0201000000000000 0300"));
    assert_eq!(ReadRows::decode(&read.to_bytes()), Ok(read));
    let rows = Rows {
        state: State::Complete,
        signals: 2,
        every: 3,
        first: 100,
        samples: vec![1.5, -2.0],
    };
    let bytes = hex("02 00 0100 0200 0300 6400000000000000 | 000000000000f83f 00000000000000c0");
    assert_eq!(rows.to_bytes()[..], bytes);
    assert_eq!(Rows::decode(&bytes), Some(rows));
    for cut in 0..bytes.len() {
        assert_eq!(Rows::decode(&bytes[..cut]), None, "cut at {cut}");
    }
    let empty = hex("01 00 0500 0000 0100 0000000000000000");
    assert_eq!(Rows::decode(&empty), None, "rows without samples would never end");
    for (room, signals, rows) in [(31, 2, 0), (32, 2, 1), (48, 2, 2), (0, 1, 0)] {
        assert_eq!(Rows::fit(room, signals), rows, "{room} bytes, {signals} signals");
    }
    for code in 0..=3 {
        assert_eq!(State::from_code(code).code(), code);
    }
}

#[test]
fn an_execution_is_laid_out_as_documented() {
    let accepted = Accepted {
        instance: 258,
        control: std::array::from_fn(|index| index as u8),
    };
    let bytes = hex("02010000 000102030405060708090a0b0c0d0e0f");
    assert_eq!(accepted.to_bytes()[..], bytes);
    assert_eq!(Accepted::decode(&bytes), Some(accepted));
    assert_eq!(Accepted::decode(&bytes[..19]), None);
    let ending = Ending {
        code: 2,
        name: "X".to_owned(),
        detail: "overcurrent".to_owned(),
        time: 1.5,
        utc_micros: 258,
    };
    let bytes = hex("02 01 58 0b 6f766572 63757272 656e74 000000000000f83f 0201000000000000");
    assert_eq!(ending.to_bytes()[..], bytes);
    assert_eq!(Ending::decode(&bytes), Some(ending));
    for cut in 0..bytes.len() {
        assert_eq!(Ending::decode(&bytes[..cut]), None, "cut at {cut}");
    }
    assert_eq!(encode_instances([3, 258])[..], hex("0200 0300 0201"));
    assert_eq!(decode_instances(&hex("0200 0300 0201")), Some(vec![3, 258]));
    assert_eq!(decode_instances(&hex("0200 0300 02")), None);
}

//! Tags, events, frames of samples.

use super::*;

#[tokio::test]
async fn tags_are_listed_read_watched_and_written() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let page = viewer
        .ask(json!({"do": "tags", "pattern": "feed"}))
        .await
        .expect("a page");
    assert_eq!(
        page,
        json!({"tags": [{"name": "FeedOverride", "type": "REAL", "dims": [4], "access": "read/write"}], "more": false})
    );
    let all = viewer.ask(json!({"do": "tags"})).await.expect("a page");
    let names: Vec<&str> = all["tags"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|tag| tag["name"].as_str())
        .collect();
    assert!(names.contains(&"Move1") && names.contains(&"CS1"), "{names:?}");
    let behind = viewer
        .ask(json!({"do": "tags", "after": "Stop1"}))
        .await
        .expect("a page");
    assert!(
        behind["tags"]
            .as_array()
            .is_some_and(|tags| tags.iter().all(|tag| tag["name"].as_str() > Some("T")))
    );

    let names = json!([
        "Move1.Speed",
        "FeedOverride",
        "Move1.CoordinateSystem",
        "CS1.MoveStatus",
        "Move1.MotionControl",
        "Nobody"
    ]);
    let read = viewer.ask(json!({"do": "read", "names": names})).await.expect("values");
    let values = &read["values"];
    assert_eq!(
        (&values["Move1.Speed"], &values["CS1.MoveStatus"]),
        (&json!(100.0), &json!(false))
    );
    assert_eq!(values["FeedOverride"], json!([100.0, 100.0, 100.0, 100.0]));
    assert_eq!(values["Move1.CoordinateSystem"], "CS1");
    assert_eq!(values["Move1.MotionControl"]["EN"], false);
    assert_eq!(values["Nobody"]["error"], "there is no tag \"Nobody\"");
    assert_eq!(read["read_only"], json!(["CS1.MoveStatus"]));

    assert_eq!(
        viewer
            .ask(json!({"do": "write", "tag": "Move1.Speed", "value": 12.5}))
            .await,
        Ok(json!({}))
    );
    viewer
        .ask(json!({"do": "watch", "names": ["Move1.Speed", "MotionInhibit"]}))
        .await
        .expect("values");
    let push = viewer.push("values").await;
    assert_eq!(push["values"], json!({"Move1.Speed": 12.5, "MotionInhibit": false}));
    assert_eq!(
        viewer
            .ask(json!({"do": "write", "tag": "Move1.Speed", "value": 13.5}))
            .await,
        Ok(json!({}))
    );
    let push = viewer.push("values").await;
    assert_eq!(push["values"], json!({"Move1.Speed": 13.5}), "only what has changed");
    #[rustfmt::skip]
    let cases = [
        ("no such tag",       json!({"do": "write", "tag": "Nobody", "value": 1})),
        ("read only",         json!({"do": "write", "tag": "X.CommandPosition", "value": 1})),
        ("no value",          json!({"do": "write", "tag": "Move1.Speed", "value": {}})),
        ("a text",            json!({"do": "write", "tag": "Move1.Speed", "value": "fast"})),
        ("without right",     json!({"do": "write", "tag": "Move1.EnableIn", "value": true})),
        ("everything's",      json!({"do": "write", "tag": "FeedOverride[0]", "value": 50})),
        ("too many names",    json!({"do": "read", "names": vec!["X"; 201]})),
    ];
    for (why, message) in cases {
        assert!(viewer.ask(message).await.is_err(), "{why}");
    }
    assert_eq!(
        viewer
            .ask(json!({"do": "write", "tag": "Move1.CoordinateSystem", "value": "CS2"}))
            .await,
        Ok(json!({}))
    );
    let read = viewer
        .ask(json!({"do": "read", "names": ["move1.coordinatesystem"]}))
        .await
        .expect("values");
    assert_eq!(read["values"]["move1.coordinatesystem"], "CS2");
}

#[tokio::test]
async fn written_values_fit_their_type_exactly() {
    let tags = ["SINT", "LINT", "ULINT", "REAL", "STRING", "TIMER"];
    let tags = tags.map(|kind| format!("\n[[tag]]\nname = \"A{kind}\"\ntype = \"{kind}\"\n"));
    let bench = Bench::with(&(arcline_config::DEFAULT.to_owned() + &tags.concat())).await;
    let mut viewer = bench.viewer().await;
    #[rustfmt::skip]
    let cases = [
        // tag,             written,                         then it is
        ("ASINT",           json!(-128),                     Ok(json!(-128))),
        ("ASINT",           json!(2.5),                      Err("ASINT is SINT, 2.5 is not a whole number")),
        ("ASINT",           json!(2.0),                      Ok(json!(2))),
        ("ASINT",           json!(128),                      Err("ASINT is SINT, 128 does not fit")),
        ("ASINT",           json!(1e300),                    Err("ASINT is SINT, 1e+300 does not fit")),
        ("ASINT",           json!("one"),                    Err("ASINT is SINT, \"one\" does not fit")),
        ("ASINT.7",         json!(1),                        Ok(json!(true))),
        ("ALINT",           json!("-9223372036854775807"),   Ok(json!("-9223372036854775807"))),
        ("ALINT",           json!("9223372036854775808"),    Err("ALINT is LINT, \"9223372036854775808\" does not fit")),
        ("ALINT",           json!(9007199254740992_i64),     Ok(json!(9007199254740992_i64))),
        ("AULINT",          json!("18446744073709551615"),   Ok(json!("18446744073709551615"))),
        ("AULINT",          json!(u64::MAX - 1),             Ok(json!("18446744073709551614"))),
        ("AULINT",          json!(-1),                       Err("AULINT is ULINT, -1 does not fit")),
        ("AREAL",           json!(0.1),                      Ok(json!(0.1))),
        ("ASTRING",         json!("9223372036854775808"),    Ok(json!("9223372036854775808"))),
        ("ASTRING",         json!(5),                        Err("ASTRING is a STRING, expected a text in quotes")),
        ("ATIMER",          json!(5),                        Err("ATIMER is a TIMER, expected one of its members")),
        ("ATIMER.DN",       json!(true),                     Ok(json!(true))),
    ];
    for (tag, value, expected) in cases {
        let written = viewer.ask(json!({"do": "write", "tag": tag, "value": value})).await;
        match expected {
            Ok(expected) => {
                assert_eq!(written, Ok(json!({})), "{tag} := {value}");
                let read = viewer.ask(json!({"do": "read", "names": [tag]})).await.expect("values");
                assert_eq!(read["values"][tag], expected, "{tag} := {value}");
            }
            Err(why) => assert_eq!(written.expect_err(tag)["text"], why, "{tag} := {value}"),
        }
    }
}

#[tokio::test]
async fn an_instruction_tag_moves_with_the_right() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    viewer
        .ask(json!({"do": "write", "tag": "Move1.Position[0]", "value": 5}))
        .await
        .expect("plain data");
    viewer
        .ask(json!({"do": "write", "tag": "Move1.EnableIn", "value": true}))
        .await
        .expect("it has the right");
    viewer.status(|status| status["axes"][0]["command"] == 5.0).await;
    let events = viewer.ask(json!({"do": "events"})).await.expect("events");
    let events = events["events"].as_array().expect("a list");
    let pc = events
        .iter()
        .find(|event| event["set"].as_array().is_some_and(|set| set.contains(&json!("PC"))));
    let pc = pc.expect("it is complete");
    assert_eq!(
        (&pc["tag"], &pc["object"], &pc["viewer"]),
        (&json!("Move1"), &json!("CS1"), &json!("127.0.0.1 #1"))
    );
    let last = events.last().expect("events")["seq"].clone();
    let none = viewer.ask(json!({"do": "events", "since": last})).await;
    assert_eq!(none, Ok(json!({"events": []})));
}

/// The answer and the events have the text of an error from `arcline explain`.
#[tokio::test]
async fn an_error_is_explained_from_one_source() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    let wrong = "MCLM(CS1, P, Absolute, [1, 0, 0], -1, Unitspersec);";
    let error = viewer.execute(wrong).await.expect_err("a speed below 0");
    let told =
        arcline_instruction_set::explain(13, 4, Some(arcline_instruction_set::Mnemonic::Mclm)).expect("13 exists");
    let expected = json!({
        "text": told.headline, "cause": told.cause, "concerns": told.concerns, "remedy": told.remedy,
        "err": 13, "exerr": 4, "member": "Speed",
    });
    assert_eq!(error, expected);
    let events = viewer.ask(json!({"do": "events"})).await.expect("events");
    let events = events["events"].as_array().expect("a list");
    assert_eq!(events.last().expect("an event")["error"], expected);
}

/// A frame of samples: its first tick, signals, and values by row.
pub(super) fn decode(frame: &[u8]) -> (u64, usize, Vec<f64>) {
    let word = |at: usize| u32::from_le_bytes(*frame[at..].first_chunk().expect("4 bytes")) as usize;
    assert!([b"ARC1", b"ARC2"].contains(&frame.first_chunk().expect("4 bytes")));
    let (rows, signals) = (word(4), word(8));
    let first = u64::from_le_bytes(*frame[16..].first_chunk().expect("8 bytes"));
    let (bases, samples) = frame[24..].split_at(8 * signals);
    let bases: Vec<f64> = bases
        .chunks_exact(8)
        .map(|base| f64::from_le_bytes(*base.first_chunk().expect("8 bytes")))
        .collect();
    let samples: Vec<f64> = samples
        .chunks_exact(4)
        .zip(bases.iter().cycle())
        .map(|(sample, base)| base + f64::from(f32::from_le_bytes(*sample.first_chunk().expect("4 bytes"))))
        .collect();
    assert_eq!(samples.len(), rows * signals);
    (first, signals, samples)
}

impl Viewer {
    /// The next frame of samples.
    pub(super) async fn frame(&mut self) -> (u64, usize, Vec<f64>) {
        loop {
            let message = timeout(SOON, self.socket.next()).await.expect("in time");
            if let Some(Ok(Message::Binary(frame))) = message {
                return decode(&frame);
            }
        }
    }
}

#[tokio::test]
async fn frames_have_every_tick() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let on = viewer.ask(json!({"do": "trace", "on": true})).await.expect("frames");
    assert_eq!(
        (&on["signals"][0], &on["period_s"]),
        (&json!("X.CommandPosition"), &json!(0.001))
    );
    let (mut expected, mut rows) = (None, 0);
    while rows < 500 {
        let (first, signals, values) = viewer.frame().await;
        assert_eq!(signals, 32);
        assert!(
            expected.is_none_or(|expected| expected == first),
            "{first} is not {expected:?}"
        );
        rows += values.len() / signals;
        expected = Some(first + (values.len() / signals) as u64);
    }
    viewer
        .ask(json!({"do": "trace", "on": false}))
        .await
        .expect("no frames");
    viewer.status(|_| true).await;
}

/// A later viewer receives the past, piece by piece, as exactly as the server keeps it.
#[tokio::test]
async fn a_new_viewer_is_told_the_past() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    let line = "MCLM(CS1, P, Absolute, [30, 0, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";
    viewer.execute(line).await.expect("it has the right");
    let status = viewer.status(|status| status["axes"][0]["command"] == 30.0).await;
    let tick = status["tick"].as_u64().expect("a tick");
    // The thread of the trace may be behind the state.
    while bench.plant.trace().stored_ticks().next <= tick {
        tokio::task::yield_now().await;
    }
    let now = bench.plant.trace().stored_ticks().next;
    let (mut before, mut rows) = (now, 0);
    let mut positions = Vec::new();
    loop {
        let id = 1000 + rows;
        viewer
            .send(json!({"id": id, "do": "history", "before": before}).to_string())
            .await;
        let message = loop {
            if let Message::Binary(frame) = timeout(SOON, viewer.socket.next())
                .await
                .expect("in time")
                .expect("open")
                .expect("well")
            {
                break frame;
            }
        };
        let told = viewer.answer(id).await;
        let count = told["ok"]["rows"].as_u64().expect("rows");
        if count == 0 {
            break;
        }
        assert_eq!(
            (&message[..4], &told["ok"]["every"]),
            (&b"ARC2"[..], &json!(1)),
            "the newest rows are exact"
        );
        let (first, signals, values) = decode(&message);
        assert_eq!((first, signals), (told["ok"]["first"].as_u64().expect("a tick"), 32));
        assert_eq!(first + count, before, "nothing is missing");
        positions.splice(0..0, values.iter().step_by(signals).copied());
        (before, rows) = (first, rows + count);
    }
    assert_eq!(before, bench.plant.trace().stored_ticks().first);
    assert_eq!((positions.first(), positions.last()), (Some(&0.0), Some(&30.0)));
    assert!(positions.is_sorted(), "it went one way");
}

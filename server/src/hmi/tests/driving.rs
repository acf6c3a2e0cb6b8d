//! Rights, instructions, jogs with their dead-man, stops, overrides.

use super::*;

/// A call that takes a while: X from 0 to 400 at 50 units/s.
const SLOW: &str = "MCLM(CS1, Slow, Absolute, [400, 0, 0], 50, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";

impl Viewer {
    pub(super) async fn take(&mut self, object: &str) {
        let taken = self.ask(json!({"do": "take", "object": object})).await;
        assert_eq!(taken, Ok(json!({})), "{object}");
    }

    pub(super) async fn execute(&mut self, text: &str) -> Result<Value, Value> {
        self.ask(json!({"do": "execute", "text": text})).await
    }

    /// The first status for which a condition holds.
    pub(super) async fn status(&mut self, mut is: impl FnMut(&Value) -> bool) -> Value {
        for _ in 0..200 {
            let status = self.push("status").await;
            if is(&status) {
                return status;
            }
        }
        panic!("it never came to it");
    }
}

/// The state of an axis or coordinate system in a status.
fn one<'v>(status: &'v Value, list: &str, name: &str) -> &'v Value {
    let all = status[list].as_array().expect("a list");
    all.iter().find(|one| one["name"] == name).expect(name)
}

fn x(status: &Value) -> &Value {
    one(status, "axes", "X")
}

fn cs1(status: &Value) -> &Value {
    one(status, "coordinate_systems", "CS1")
}

#[tokio::test]
async fn one_viewer_drives_and_everybody_stops() {
    let bench = Bench::start().await;
    let (mut one, mut two) = (bench.viewer().await, bench.viewer().await);
    let refused = one.execute(SLOW).await.expect_err("it has no right");
    assert_eq!(refused["text"], "You do not have control of CS1.");
    one.take("CS1").await;
    let refused = two.execute(SLOW).await.expect_err("the other has it");
    assert!(
        refused["holder"].as_str().is_some_and(|holder| holder.contains('#')),
        "{refused}"
    );
    let refused = two
        .ask(json!({"do": "take", "object": "XY"}))
        .await
        .expect_err("X is taken");
    assert_eq!(
        refused["holder"],
        two.status(|_| true).await["drivers"]["CS1"],
        "{refused}"
    );
    one.execute(SLOW).await.expect("it has the right");
    let moving = two.status(|status| x(status)["moving"] == true).await;
    assert_eq!(moving["drivers"]["X"], moving["drivers"]["CS1"]);
    assert_eq!(
        two.ask(json!({"do": "stop", "object": "CS1"})).await,
        Ok(json!({})),
        "stop is everyone's"
    );
    two.status(|status| x(status)["moving"] == false).await;
    one.execute(SLOW.replace("Slow", "Again").as_str())
        .await
        .expect("it still has the right");
    assert_eq!(two.ask(json!({"do": "stop"})).await, Ok(json!({})), "everything");
    two.status(|status| x(status)["moving"] == false).await;
    let taken = two.ask(json!({"do": "take", "object": "X", "force": true})).await;
    assert_eq!(taken, Ok(json!({})));
    assert!(one.execute(SLOW).await.is_err(), "the right was taken");
    drop(two);
    one.status(|status| status["drivers"] == json!({})).await;
}

#[tokio::test]
async fn an_error_has_its_cause_and_its_remedy() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    let error = viewer
        .execute("MCLM(CS1, Bad, Absolute, [1, 0, 0], -5, Unitspersec)")
        .await
        .expect_err("the speed is below 0");
    assert_eq!(
        (&error["err"], &error["exerr"], &error["member"]),
        (&json!(13), &json!(4), &json!("Speed"))
    );
    assert_eq!(error["text"], "ERR 13 Parameter Out Of Range, operand 4 (Speed)");
    assert!(error["cause"].is_string() && error["remedy"].is_string(), "{error}");
    let event = viewer.push("event").await;
    let event = event["events"]
        .as_array()
        .and_then(|events| events.last())
        .expect("an event");
    assert_eq!(
        (&event["tag"], &event["instruction"], &event["object"]),
        (&json!("Bad"), &json!("MCLM"), &json!("CS1"))
    );
    assert_eq!(event["error"]["remedy"], error["remedy"]);
    assert!(
        event["text"]
            .as_str()
            .is_some_and(|text| text.starts_with("MCLM(CS1, Bad")),
        "{event}"
    );
    assert!(event["viewer"].is_string());
    let error = viewer
        .execute("MCLM(CS1, M, Absolute, [1, 0]);")
        .await
        .expect_err("too few numbers");
    assert_eq!(error["member"], "Position", "{error}");
    let error = viewer
        .execute("MCLM(CS1, M, Sideways, [1, 0, 0]);")
        .await
        .expect_err("no such word");
    assert_eq!((&error["line"], &error["column"]), (&json!(1), &json!(14)), "{error}");
    let error = viewer
        .execute("MCLM(CS9, M, Absolute, [1, 0, 0]);")
        .await
        .expect_err("no CS9");
    assert_eq!((&error["line"], &error["column"]), (&json!(1), &json!(6)), "{error}");
    let error = viewer.execute("a := 1;").await.expect_err("no call");
    assert_eq!(error["line"], 1, "{error}");
}

#[tokio::test]
async fn a_form_becomes_a_line() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let line = |operands: Value| json!({"do": "line", "instruction": "MCLM", "operands": operands});
    let text = viewer
        .ask(line(
            json!({"CoordinateSystem": "CS1", "MotionControl": "M1", "Position": [1.5, 0, -2],
            "Speed": 20, "SpeedUnits": "Unitspersec"}),
        ))
        .await
        .expect("it is whole");
    assert_eq!(
        text["text"],
        "MCLM(CS1, M1, Absolute, [1.5, 0, -2], 20, Unitspersec, 100, %ofMaximum, 100, %ofMaximum, S-curve, 100, 100, \
         %ofTime);"
    );
    viewer.take("CS1").await;
    viewer
        .execute(text["text"].as_str().expect("a text"))
        .await
        .expect("it can be executed as it stands");
    #[rustfmt::skip]
    let cases = [
        ("no target",         json!({"Position": [1, 2, 3]}),                                            json!("CoordinateSystem")),
        ("out of range",      json!({"CoordinateSystem": "CS1", "Position": [1, 2, 3], "AccelRate": 0}), json!("AccelRate")),
        ("no word",           json!({"CoordinateSystem": "CS1", "Position": [1, 2, 3], "Profile": "x"}), json!("Profile")),
        ("no numbers",        json!({"CoordinateSystem": "CS1"}),                                        json!("Position")),
        ("no such operand",   json!({"CoordinateSystem": "CS1", "Position": [1, 2, 3], "Colour": 1}),    Value::Null),
        ("something smuggled", json!({"CoordinateSystem": "CS1, A); MSF(X", "Position": [1, 2, 3]}),     Value::Null),
    ];
    for (why, operands, member) in cases {
        let error = viewer.ask(line(operands)).await.expect_err(why);
        assert_eq!(error["member"], member, "{why}: {error}");
    }
    let other = viewer
        .ask(json!({"do": "line", "instruction": "MSO", "operands": {"Axis": "X"}}))
        .await;
    assert_eq!(other, Ok(json!({"text": "MSO(X, HMI_MSO);"})));
}

/// Ticks from `from` on until X does not move any more.
async fn stood_after(bench: &Bench, from: u64) -> u64 {
    timeout(SOON, async {
        loop {
            let (tick, speed) = bench
                .plant
                .with_snapshot(|snapshot| (snapshot.tick, snapshot.axes[0].command[1]));
            if tick > from && speed == 0.0 {
                return tick - from;
            }
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    })
    .await
    .expect("it stops")
}

#[tokio::test]
async fn a_jog_ends_with_the_hand_that_holds_it() {
    let bench = Bench::start().await;
    let speed = 100.0;
    // At 10,000 units/s², and as long as a reader needs to see it.
    let ramp = 10;
    // On a machine that is busy with other tests, one try may be late.
    let mut late = Vec::new();
    let ends = [
        ("button", "stopped by MAS"),
        (
            "silence",
            "stopped by the dead-man switch: its button was not kept pressed",
        ),
        ("socket", "stopped by the loss of its client"),
        ("STOP", "stopped by a stop of the whole machine"),
    ];
    for (end, cause) in ends {
        let mut within = None;
        for _ in 0..10 {
            let mut viewer = bench.viewer().await;
            viewer.take("X").await;
            let jog = json!({"do": "jog", "axis": "X", "speed": speed});
            assert_eq!(viewer.ask(jog).await, Ok(json!({})), "{end}");
            let instance = bench.plant.newest_instance().expect("a jog");
            for _ in 0..8 {
                tokio::time::sleep(Duration::from_millis(50)).await;
                viewer.send(json!({"do": "keep", "axis": "X"}).to_string()).await;
            }
            let (tick, moving) = bench
                .plant
                .with_snapshot(|snapshot| (snapshot.tick, snapshot.axes[0].command[1]));
            let keeper = match end {
                "button" => {
                    assert_eq!(viewer.ask(json!({"do": "jog_end", "axis": "X"})).await, Ok(json!({})));
                    Some(viewer)
                }
                "STOP" => {
                    assert_eq!(viewer.ask(json!({"do": "stop"})).await, Ok(json!({})));
                    Some(viewer)
                }
                "silence" => Some(viewer),
                _ => {
                    drop(viewer);
                    None
                }
            };
            let ticks = stood_after(&bench, tick).await;
            drop(keeper);
            if moving == speed && ticks <= 250 + ramp {
                let ended = bench.plant.instruction_ending(instance).expect("it is told");
                assert_eq!(ended.ending.to_string(), cause, "{end}");
                within = Some(ticks);
                break;
            }
            late.push((end, moving, ticks));
            // The next try may jog again.
            let release = crate::plant::Command::Release;
            let released = bench.plant.apply(crate::plant::Principal::Server, release).await;
            assert!(released.is_ok(), "{released:?}");
        }
        assert!(within.is_some(), "{end}: {late:?}");
    }
}

#[tokio::test]
async fn the_dead_man_stops_at_full_deceleration_whatever_anybody_programmed() {
    #[rustfmt::skip]
    let cases = [
        ("its own deceleration, silence",         "",                                             false),
        ("its own deceleration, hand off",        "",                                             true),
        ("a weak stop of the jog, silence",       "MAS(X, Weak, Jog, Yes, 0.001, Unitspersec2);", false),
        ("a weak stop of everything, silence",    "MAS(X, Weak, All, Yes, 0.001, Unitspersec2);", false),
        ("a weak stop of everything, hand off",   "MAS(X, Weak, All, Yes, 0.001, Unitspersec2);", true),
    ];
    for (why, weak, hand_off) in cases {
        let bench = Bench::start().await;
        let (mut one, mut two) = (bench.viewer().await, bench.viewer().await);
        one.take("X").await;
        let jog = json!({"do": "jog", "axis": "X", "speed": 100.0, "accel": 10_000.0, "decel": 0.001});
        assert_eq!(one.ask(jog).await, Ok(json!({})), "{why}");
        for _ in 0..4 {
            tokio::time::sleep(Duration::from_millis(20)).await;
            one.send(json!({"do": "keep", "axis": "X"}).to_string()).await;
        }
        if !weak.is_empty() {
            two.execute(weak).await.expect("a stop needs no right");
        }
        if hand_off {
            one.ask(json!({"do": "jog_end", "axis": "X"}))
                .await
                .expect("it has ended");
        }
        let tick = bench.plant.with_snapshot(|snapshot| snapshot.tick);
        let ticks = stood_after(&bench, tick).await;
        // 1 s for a soft stop and its ramp; the rest is for a machine that is busy with other tests.
        assert!(ticks < 3000, "{why}: {ticks} ms");
    }
}

#[tokio::test]
async fn requests_from_before_stop_begin_no_motion_after_it() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    // Longer than one read of the socket: the request waits for its turn.
    let slow = format!("{SLOW}{}", " ".repeat(200_000));
    viewer
        .send(json!({"id": 101, "do": "execute", "text": slow}).to_string())
        .await;
    viewer.send(json!({"id": 102, "do": "stop"}).to_string()).await;
    let mut answers = std::collections::BTreeMap::new();
    while answers.len() < 2 {
        let text = viewer.text().await.expect("it is open");
        if let Some(id) = text["id"].as_u64() {
            answers.insert(id, text);
        }
    }
    assert_eq!(answers[&102]["ok"], json!({}));
    viewer.status(|status| x(status)["moving"] == false).await;
}

#[tokio::test]
async fn every_motion_names_its_mover_and_no_other_viewer_jogs_it() {
    let bench = Bench::start().await;
    let (mut one, mut two) = (bench.viewer().await, bench.viewer().await);
    one.take("CS1").await;
    one.execute(SLOW).await.expect("it has the right");
    let moving = two.status(|status| x(status)["moving"] == true).await;
    let mover = moving["drivers"]["CS1"].as_str().expect("the viewer's name").to_owned();
    assert_eq!(cs1(&moving)["moved_by"], json!(mover));
    assert_eq!(x(&moving)["moved_by"], json!(mover), "its coordinate system moves it");
    let taken = two.ask(json!({"do": "take", "object": "X", "force": true})).await;
    assert_eq!(taken, Ok(json!({})));
    let jog = json!({"do": "jog", "axis": "X", "speed": 1.0});
    let refused = two.ask(jog.clone()).await.expect_err("the move still runs");
    assert_eq!(
        refused["text"],
        format!("X is moved by {mover}; it can be jogged when that motion has ended")
    );
    assert_eq!(two.ask(json!({"do": "stop", "object": "CS1"})).await, Ok(json!({})));
    let rest = two.status(|status| x(status)["moving"] == false).await;
    assert_eq!(x(&rest)["moved_by"], json!(null));
    assert_eq!(two.ask(jog).await, Ok(json!({})));
}

#[tokio::test]
async fn a_jog_without_right_or_beyond_the_limit_is_refused() {
    let bench = Bench::start().await;
    let (mut one, mut two) = (bench.viewer().await, bench.viewer().await);
    one.take("X").await;
    let jog = |speed: f64| json!({"do": "jog", "axis": "X", "speed": speed});
    assert!(two.ask(jog(1.0)).await.is_err(), "the other has the right");
    let error = one.ask(jog(1000.5)).await.expect_err("too fast");
    assert_eq!(error["text"], "the speed is 1000.5, expected -1000 to 1000");
    assert!(
        one.ask(json!({"do": "keep", "axis": "X"})).await.is_err(),
        "nothing is jogged"
    );
    assert_eq!(one.ask(jog(-5.0)).await, Ok(json!({})));
    assert!(two.ask(json!({"do": "keep", "axis": "X"})).await.is_err(), "not by it");
    two.ask(json!({"do": "take", "object": "X", "force": true}))
        .await
        .expect("by force");
    two.status(|status| x(status)["moving"] == false).await;
}

#[tokio::test]
async fn paths_are_drawn_as_programmed() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    viewer.execute(SLOW).await.expect("it has the right");
    let next = "MCLM(CS1, Next, Incremental, [0, 10, 0], 50, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2, \
        Trapezoidal, 100, 100, %ofTime, CommandToleranceProgrammed, Disabled, Programmed, 2.5);";
    // A path comes once, perhaps before the answer.
    let executed = viewer.request(json!({"do": "execute", "text": next})).await;
    let status = viewer
        .status(|status| cs1(status)["path"]["pending"] != json!([]) && cs1(status).get("path").is_some())
        .await;
    viewer.result(executed).await.expect("there is room");
    let system = cs1(&status);
    assert_eq!(system["path"]["active"], json!([[0.0, 0.0, 0.0], [400.0, 0.0, 0.0]]));
    assert_eq!(
        system["path"]["pending"],
        json!([[[400.0, 0.0, 0.0], [400.0, 10.0, 0.0]]])
    );
    assert_eq!(
        system["path"]["tolerance"],
        json!([{"centre": [400.0, 10.0, 0.0], "radius": 2.5}])
    );
    assert_eq!(system["pending"], json!([{"tag": "Next", "instruction": "MCLM"}]));
    let status = viewer
        .status(|status| cs1(status)["active"]["progress"].as_f64() > Some(0.0))
        .await;
    let active = &cs1(&status)["active"];
    assert_eq!(
        (&active["tag"], &active["instruction"]),
        (&json!("Slow"), &json!("MCLM"))
    );
    assert!(
        active["remaining"].as_f64().is_some_and(|left| left < 400.0),
        "{active}"
    );
    let stopped = viewer.request(json!({"do": "stop", "object": "CS1"})).await;
    let status = viewer
        .status(|status| cs1(status).get("path").is_some_and(|path| path["active"] == json!([])))
        .await;
    viewer.result(stopped).await.expect("it stops");
    assert_eq!(
        (&cs1(&status)["active"], &cs1(&status)["pending"]),
        (&Value::Null, &json!([]))
    );
}

#[tokio::test]
async fn an_override_is_its_drivers_but_a_hold_is_everyones() {
    let bench = Bench::start().await;
    let (mut one, mut two) = (bench.viewer().await, bench.viewer().await);
    one.take("CS1").await;
    let change = |percent: f64| json!({"do": "override", "coordinate_system": "CS1", "percent": percent});
    assert_eq!(one.ask(change(50.0)).await, Ok(json!({})));
    assert!(one.ask(change(250.0)).await.is_err(), "at most 200");
    assert!(two.ask(change(60.0)).await.is_err(), "not its driver");
    two.status(|status| cs1(status)["override"] == 50.0).await;
    assert_eq!(
        two.ask(json!({"do": "hold", "coordinate_system": "CS1"})).await,
        Ok(json!({}))
    );
    two.status(|status| cs1(status)["held"] == true).await;
    assert!(
        two.ask(json!({"do": "resume", "coordinate_system": "CS1"}))
            .await
            .is_err()
    );
    assert_eq!(
        one.ask(json!({"do": "resume", "coordinate_system": "CS1"})).await,
        Ok(json!({}))
    );
    one.status(|status| cs1(status)["override"] == 50.0 && cs1(status)["held"] == false)
        .await;
}

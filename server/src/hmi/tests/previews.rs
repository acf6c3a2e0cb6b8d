//! Previews and dry runs: they show the motion, and the machine does not move.

use super::*;

fn preview(text: &str) -> Value {
    json!({"do": "preview", "text": text})
}

fn peak<'v>(told: &'v Value, axis: &str) -> &'v Value {
    let peaks = told["peaks"].as_array().expect("a list");
    peaks.iter().find(|peak| peak["axis"] == axis).expect(axis)
}

fn close(value: &Value, expected: f64) -> bool {
    value
        .as_f64()
        .is_some_and(|value| (value - expected).abs() < 1e-6 * expected.abs().max(1.0))
}

#[tokio::test]
async fn a_preview_shows_path_duration_and_peaks() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    // 100 units at 100 units/s with 1,000 units/s^2: 0.1 s to gain and lose speed, 1.1 s in all.
    let line = "MCLM(CS1, P, Absolute, [100, 0, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";
    let told = viewer
        .ask(preview(line))
        .await
        .expect("it can be executed, without any right");
    assert!(close(&told["duration_s"], 1.1), "{}", told["duration_s"]);
    assert_eq!(told["ticks"], 1100);
    assert!(
        close(&peak(&told, "X")["velocity"], 100.0) && close(&peak(&told, "X")["acceleration"], 1000.0),
        "{told}"
    );
    assert_eq!(peak(&told, "Y")["velocity"], 0.0);
    assert_eq!(told["limit"], Value::Null);
    let path = &told["paths"][0];
    assert_eq!(path["coordinate_system"], "CS1");
    let points = path["points"].as_array().expect("points");
    assert_eq!(
        (&points[0], points.last()),
        (&json!([0.0, 0.0, 0.0]), Some(&json!([100.0, 0.0, 0.0])))
    );
    assert_eq!(told["paths"].as_array().map(Vec::len), Some(1));
    let moved = bench.plant.with_snapshot(|snapshot| snapshot.axes[0].command[0]);
    assert_eq!(moved, 0.0, "nothing moved");
}

/// A program that only computes uses up the real time of a dry run, not more.
#[tokio::test]
async fn a_dry_run_without_end_keeps_its_limit() {
    let bench = Bench::start().await;
    let sum = "1+".repeat(50_000);
    let [computes, waits] = [
        format!("WHILE TRUE DO n := {sum}1; END_WHILE;"),
        String::from("WHILE TRUE DO DELAY(1); END_WHILE;"),
    ];
    for text in [computes, waits] {
        let program = super::super::program::checked(&bench.plant, &text).expect("a loop");
        let began = std::time::Instant::now();
        let told =
            super::super::preview::simulate_here(&bench.plant, program, Duration::from_secs(1)).expect("it began");
        assert_eq!(told.duration_s, None);
        let limit = told.limit.map(|limit| limit.text);
        assert_eq!(limit.as_deref(), Some("not at its end after 1 s of computing"));
        // One tick computes for some 0.1 s.
        assert!(began.elapsed() < SOON, "{:?}", began.elapsed());
    }
}

#[tokio::test]
async fn a_preview_of_a_robot_shows_its_tool() {
    let bench = Bench::with(ROBOT).await;
    let machine = bench.json("/api/machine").await;
    let robots: Vec<&Value> = machine["coordinate_systems"]
        .as_array()
        .expect("systems")
        .iter()
        .map(|system| &system["robot"])
        .collect();
    assert_eq!(robots, [false, true]);
    let mut viewer = bench.viewer().await;
    let line = "MCLM(PICKER, P, Incremental, [10, 10, 10], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";
    let told = viewer.ask(preview(line)).await.expect("it can be executed");
    let path = &told["paths"][0];
    assert_eq!(path["coordinate_system"], "PICKER");
    let points = path["points"].as_array().expect("points");
    let ends = [&points[0], &points[points.len() - 1]];
    let [from, to] = ends.map(|point| [0, 1, 2].map(|k| point[k].as_f64().expect("a number")));
    // All arms alike: straight down, by the loop of one of them (spec/coordinated-instructions.md §22.6).
    let height = |angle: f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        -30.0 - 120.0 * sin - (260.0_f64.powi(2) - (40.0 + 120.0 * cos).powi(2)).sqrt()
    };
    for (point, angle) in [(from, 20.0), (to, 30.0)] {
        assert!(point[0].abs() < 1e-6 && point[1].abs() < 1e-6, "{point:?}");
        assert!((point[2] - height(angle)).abs() < 1e-6, "{point:?} at {angle}");
    }
    viewer.ask(json!({"do": "trace", "on": true})).await.expect("it tells");
    let (_, signals, values) = viewer.frame().await;
    assert_eq!(signals, 6 * 4 + 2 + 3, "those of axes and systems, and the tool");
    let tool = &values[signals - 3..signals];
    assert!(
        (tool[2] - height(20.0)).abs() < 1e-3 && tool[0].abs() < 1e-3,
        "{tool:?}"
    );
}

#[tokio::test]
async fn a_preview_begins_where_the_machine_will_be() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    let slow = "MCLM(CS1, Slow, Absolute, [400, 0, 0], 50, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";
    viewer.execute(slow).await.expect("it has the right");
    let next = "MCLM(CS1, P, Incremental, [0, 10, 0], 50, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";
    let told = viewer.ask(preview(next)).await.expect("it can be executed");
    let points = told["paths"][0]["points"].as_array().expect("points");
    assert_eq!(
        (&points[0], points.last()),
        (&json!([400.0, 0.0, 0.0]), Some(&json!([400.0, 10.0, 0.0])))
    );
    viewer.ask(json!({"do": "stop"})).await.expect("it stops");
}

#[tokio::test]
async fn the_first_limit_and_errors_are_told() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let fast = "MAM(X, P, Absolute, 500, 2000, Unitspersec, 9000, Unitspersec2, 9000, Unitspersec2);";
    let told = viewer.ask(preview(fast)).await.expect("it can be executed");
    let limit = told["limit"]["text"].as_str().expect("a limit");
    assert!(
        limit.starts_with("X: speed 100") && limit.contains("maximum 1000 mm/s, at 0.11"),
        "{limit}"
    );
    let error = viewer
        .ask(preview("MCLM(CS1, P, Absolute, [1, 0, 0], -1, Unitspersec);"))
        .await
        .expect_err("out of range");
    assert_eq!(
        (&error["err"], &error["member"], &error["line"]),
        (&json!(13), &json!("Speed"), &json!(1))
    );
    let jog = viewer
        .ask(preview(
            "MAJ(X, P, Forward, 5, Unitspersec, 100, Unitspersec2, 100, Unitspersec2);",
        ))
        .await;
    assert!(jog.is_ok(), "a jog has no end, and its preview one: {jog:?}");
}

#[tokio::test]
async fn a_dry_run_knows_the_program_to_the_tick() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let program = "MCLM(CS1, P1, Absolute, [30, 0, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2,
        Trapezoidal, 100, 100, %ofTime, CommandToleranceProgrammed, Disabled, Programmed, 5);
MCLM(CS1, P2, Absolute, [30, 40, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
WAIT(P2.PC);
DELAY(0.25);
";
    let told = viewer
        .ask(json!({"do": "dry_run", "text": program}))
        .await
        .expect("it runs");
    assert_eq!(
        told["paths"][0]["blends"],
        json!([{"centre": [30.0, 0.0, 0.0], "radius": 5.0}])
    );
    let events = told["events"].as_array().expect("events");
    let last = events.last().expect("an event");
    assert_eq!((&last["tag"], &last["set"]), (&json!("P2"), &json!(["PC"])));
    assert_eq!(told["ticks"].as_u64(), last["tick"].as_u64().map(|tick| tick + 250));
    let wrong = program.replace("WAIT(P2.PC)", "MCLM(CS1, P3, Absolute, [1, 0, 0], 5, Unitspersec, 0)");
    let error = viewer
        .ask(json!({"do": "dry_run", "text": wrong}))
        .await
        .expect_err("ACCEL is 0");
    assert_eq!(
        (&error["line"], &error["err"], &error["member"]),
        (&json!(4), &json!(13), &json!("AccelRate"))
    );
}

/// A jerk counts against the axis's maxima where an S-curve is asked for; the steps of a trapezoid do not.
#[tokio::test]
async fn a_jerk_above_the_maximum_is_a_limit() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let fast = |profile: &str, jerk: u32| {
        format!(
            "MAM(X, P, Absolute, 50, 200, Unitspersec, 5000, Unitspersec2, 5000, Unitspersec2, {profile}, {jerk}, {jerk}, Unitspersec3);"
        )
    };
    #[rustfmt::skip]
    let cases = [
        ("above the maximum of 200000", fast("S-curve", 250_000),     true),
        ("at the maximum",              fast("S-curve", 200_000),     false),
        ("a trapezoid",                 fast("Trapezoidal", 250_000), false),
    ];
    for (why, line, exceeds) in cases {
        let told = viewer.ask(preview(&line)).await.expect(why);
        let limit = told["limit"]["text"].as_str();
        assert_eq!(
            limit.is_some_and(
                |text| text.starts_with("X: jerk 250000") && text.contains("maximum 200000 mm/s³, at 0.00")
            ),
            exceeds,
            "{why}: {limit:?}"
        );
        assert!(exceeds || limit.is_none(), "{why}: {limit:?}");
    }
    let program = format!(
        "{}WAIT(P.PC); {}",
        fast("Trapezoidal", 100),
        fast("S-curve", 250_000).replace("50,", "0,")
    );
    let told = viewer
        .ask(json!({"do": "dry_run", "text": program}))
        .await
        .expect("it runs");
    assert!(
        told["limit"]["text"]
            .as_str()
            .is_some_and(|text| text.starts_with("X: jerk 250000")),
        "an S-curve after a trapezoid: {told}"
    );
}

/// Several viewers preview at once: each gets its answer, and a stop waits for none of them.
#[tokio::test]
async fn previews_wait_for_each_other_and_nothing_waits_for_them() {
    let bench = Bench::start().await;
    let line = "MAM(X, P, Absolute, 5, 50, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);";
    let one = bench.simulations.clone().acquire_owned().await.expect("it is open");
    let mut viewers = Vec::new();
    for _ in 0..6 {
        let mut viewer = bench.viewer().await;
        for id in 100..100 + crate::hmi::viewer::SIMULATIONS {
            let request = json!({"id": id, "do": "preview", "text": line});
            viewer.send(request.to_string()).await;
        }
        viewers.push(viewer);
    }
    for viewer in &mut viewers {
        viewer.ask(json!({"do": "stop"})).await.expect("at once");
        let refused = viewer.ask(preview(line)).await.expect_err("too many");
        assert!(
            refused["text"]
                .as_str()
                .is_some_and(|text| text.contains("wait already")),
            "{refused}"
        );
        assert!(
            viewer.other_answers().is_empty(),
            "before the simulations: {:?}",
            viewer.other_answers()
        );
    }
    // The preview of a viewer that goes leaves the queue.
    viewers.pop();
    drop(one);
    for viewer in &mut viewers {
        for id in 100..100 + crate::hmi::viewer::SIMULATIONS {
            let answer = viewer.answer(id).await;
            assert!(answer["ok"]["ticks"].is_u64(), "{answer}");
        }
        viewer.ask(preview(line)).await.expect("there is room again");
    }
}

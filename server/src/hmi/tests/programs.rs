//! Programs: checked, run, stepped, ended.

use super::*;

impl Viewer {
    /// The next push of the program in that state.
    pub(super) async fn program(&mut self, state: &str) -> Value {
        for _ in 0..200 {
            let push = self.push("program").await;
            if push["state"] == state {
                return push;
            }
            assert_ne!(push["state"], "failed", "{push}");
        }
        panic!("it was never {state}");
    }

    pub(super) async fn run(&mut self, text: &str) -> Result<Value, Value> {
        self.ask(json!({"do": "run", "text": text})).await
    }
}

const MOVES: &str = "// two moves
n := 0;
MCLM(CS1, P1, Absolute, [3, 0, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
MCLM(CS1, P2, Absolute, [3, 4, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
MCLM(CS1, P3, Absolute, [0, 0, 0], 100, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);
WAIT(P3.PC);
n := n + 1;
";

#[tokio::test]
async fn errors_are_reported_at_their_line() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let checked = viewer.ask(json!({"do": "check", "text": MOVES})).await;
    assert_eq!(checked, Ok(json!({"errors": []})));
    let wrong = MOVES.replace("WAIT(P3.PC)", "WAIT(P4.PC)");
    let checked = viewer
        .ask(json!({"do": "check", "text": wrong}))
        .await
        .expect("an answer");
    assert_eq!(
        (&checked["errors"][0]["line"], &checked["errors"][0]["column"]),
        (&json!(6), &json!(6)),
        "{checked}"
    );
    let refused = viewer.run(&wrong).await.expect_err("it cannot run");
    assert_eq!(refused["line"], 6);
}

#[tokio::test]
async fn a_program_runs_to_its_end() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    assert_eq!(viewer.push("program").await["state"], "idle");
    viewer.run(MOVES).await.expect("it runs");
    let failed = viewer.program("failed").await;
    assert_eq!(
        (&failed["line"], &viewer.program_text),
        (&json!(3), &Some(json!(MOVES)))
    );
    assert_eq!(failed["error"]["text"], "You do not have control of CS1.");
    viewer.take("CS1").await;
    viewer.run(MOVES).await.expect("it runs");
    viewer.program("ended").await;
    let position = bench.plant.with_snapshot(|snapshot| snapshot.axes[0].command[0]);
    assert_eq!(position, 0.0);
}

#[tokio::test]
async fn an_instruction_that_errs_ends_it_at_its_line() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    viewer
        .run("DELAY(0.01);\nMCLM(CS1, P1, Absolute, [3, 0, 0], -1, Unitspersec);")
        .await
        .expect("it runs");
    let failed = viewer.program("failed").await;
    assert_eq!((&failed["line"], &failed["error"]["err"]), (&json!(2), &json!(13)));
    assert!(failed["error"]["remedy"].is_string());
}

/// The condition of a WAIT can no longer come true: another client has stopped the move, or the tag was never executed.
#[tokio::test]
async fn a_wait_that_cannot_come_true_ends_it_with_the_reason() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    let waits = "MCLM(CS1, Down, Absolute, [400, 0, 0], 50, Unitspersec, 1000, Unitspersec2, 1000, Unitspersec2);\nWAIT(Down.PC);";
    viewer.run(waits).await.expect("it runs");
    wait_for(&bench, "Down.IP").await;
    let stop = crate::plant::Call {
        mnemonic: arcline_instruction_set::Mnemonic::Mcs,
        target: Some(0),
        control: Some("Halt"),
        operands: &[],
        text: None,
    };
    let stopped = bench
        .plant
        .apply(crate::plant::Principal::Server, crate::plant::Command::Call(stop));
    assert!(stopped.await.is_ok());
    let failed = viewer.program("failed").await;
    assert_eq!(failed["line"], 2, "{failed}");
    let text = failed["error"]["text"].as_str().expect("a text");
    assert_eq!(
        text, "WAIT can no longer come true: Down (MCLM, line 1) was stopped by MCS Halt",
        "{failed}"
    );
}

/// Waits until a bit of a tag is on.
async fn wait_for(bench: &Bench, path: &str) {
    let path = path.parse().expect("a path");
    let began = std::time::Instant::now();
    while !bench
        .plant
        .with_image(|image| image.read(&path).is_ok_and(|value| value.as_bool()))
    {
        assert!(began.elapsed() < Duration::from_secs(20), "not in time");
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
}

#[tokio::test]
async fn it_steps_pauses_and_ends() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    assert!(viewer.ask(json!({"do": "step"})).await.is_err(), "nothing runs");
    viewer.take("CS1").await;
    let program = MOVES
        .replace("n := 0", "Move1.Speed := 40")
        .replace("n := n + 1", "Move1.Speed := 60");
    viewer
        .ask(json!({"do": "run", "text": program, "step": true}))
        .await
        .expect("it runs");
    for line in [2, 3, 4] {
        let paused = viewer.program("paused").await;
        assert_eq!(paused["line"], line);
        viewer.ask(json!({"do": "step"})).await.expect("a statement");
    }
    assert_eq!(viewer.program("paused").await["line"], 5);
    assert!(viewer.run(MOVES).await.is_err(), "one at a time");
    let speed = viewer
        .ask(json!({"do": "read", "names": ["Move1.Speed"]}))
        .await
        .expect("a value");
    assert_eq!(speed["values"]["Move1.Speed"], 40.0);
    viewer.ask(json!({"do": "continue"})).await.expect("it goes on");
    viewer.program("ended").await;

    viewer
        .run("WHILE TRUE DO DELAY(0.01); END_WHILE;")
        .await
        .expect("it runs");
    viewer.program("running").await;
    viewer.ask(json!({"do": "pause"})).await.expect("it pauses");
    viewer.program("paused").await;
    viewer.ask(json!({"do": "end"})).await.expect("it ends");
    viewer.program("ended").await;
}

/// A paused program moves with the control of the viewer that started it: others may pause and end it, not continue it.
#[tokio::test]
async fn another_viewer_does_not_continue_a_paused_program() {
    let bench = Bench::start().await;
    let (mut viewer, mut stranger) = (bench.viewer().await, bench.viewer().await);
    viewer.take("CS1").await;
    viewer
        .ask(json!({"do": "run", "text": MOVES, "step": true}))
        .await
        .expect("it runs");
    viewer.program("paused").await;
    for request in ["step", "continue"] {
        let error = stranger.ask(json!({"do": request})).await.expect_err(request);
        assert!(
            error["text"]
                .as_str()
                .is_some_and(|text| text.contains("alone steps and continues it")),
            "{request}: {error}"
        );
    }
    let line = viewer.ask(json!({"do": "read", "names": ["Move1.Speed"]})).await;
    assert!(line.is_ok());
    stranger.ask(json!({"do": "pause"})).await.expect("it stays paused");
    stranger.ask(json!({"do": "end"})).await.expect("every viewer ends it");
    viewer.program("ended").await;
}

/// A program that only computes ends when a viewer says so, however long its expressions are.
#[tokio::test]
async fn a_program_that_computes_without_end_ends() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let sum = "1+".repeat(50_000);
    viewer
        .run(&format!("WHILE TRUE DO n := {sum}1; END_WHILE;"))
        .await
        .expect("it runs");
    viewer.program("running").await;
    viewer.ask(json!({"do": "end"})).await.expect("it ends");
    viewer.program("ended").await;
}

#[tokio::test]
async fn a_stop_and_the_end_of_its_viewer_end_it() {
    let bench = Bench::start().await;
    let mut other = bench.viewer().await;
    let mut viewer = bench.viewer().await;
    viewer.take("CS1").await;
    viewer
        .run("WHILE TRUE DO DELAY(0.01); END_WHILE;")
        .await
        .expect("it runs");
    other.program("running").await;
    other.ask(json!({"do": "stop"})).await.expect("stop is everyone's");
    other.program("ended").await;
    viewer
        .run("WHILE TRUE DO DELAY(0.01); END_WHILE;")
        .await
        .expect("it runs");
    other.program("running").await;
    drop(viewer);
    other.program("ended").await;
}

/// GSV and SSV of a program of the page: SSV needs control of the object, GSV does not.
#[tokio::test]
async fn a_program_sets_attributes() {
    let bench = Bench::start().await;
    let mut viewer = bench.viewer().await;
    let program = "GSV(CoordinateSystem, CS1, DynamicsConfigurationBits, Move1.Speed);
SSV(CoordinateSystem, CS1, DynamicsConfigurationBits, Move1.Speed - 4);
GSV(CoordinateSystem, CS1, DynamicsConfigurationBits, Move2.Speed);
";
    let refused = "SSV(CoordinateSystem, CS1, DynamicsConfigurationBits, 3);";
    viewer.run(refused).await.expect("it runs");
    let failed = viewer.program("failed").await;
    assert_eq!(failed["error"]["text"], "You do not have control of CS1.");
    viewer.take("CS1").await;
    viewer.run(program).await.expect("it runs");
    viewer.program("ended").await;
    let speeds = ["Move1.Speed", "Move2.Speed"];
    let read = viewer
        .ask(json!({"do": "read", "names": speeds}))
        .await
        .expect("values");
    assert_eq!(
        read["values"],
        json!({"Move1.Speed": 7.0, "Move2.Speed": 3.0}),
        "{read}"
    );
    viewer
        .run("n := 1;\nSSV(CoordinateSystem, CS1, DynamicsConfigurationBits, 64);")
        .await
        .expect("it runs");
    let failed = viewer.program("failed").await;
    assert_eq!(
        (&failed["line"], &failed["error"]["text"]),
        (
            &json!(2),
            &json!("DynamicsConfigurationBits cannot be 64, expected a whole number from 0 to 7")
        )
    );
}

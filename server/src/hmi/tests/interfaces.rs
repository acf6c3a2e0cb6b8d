//! One table of programs on each of their three interfaces: the simulator, the page, and the client over EtherNet/IP.

use arcline_client::{Client, ProgramError, Runner};
use arcline_config::{IoListen, Project};
use arcline_structured_text::{Interpreter, Policy, Program, RunError, SyntaxError};

use super::*;
use crate::eip::{Listener, Settings};
use arcline_simulation::{Blind, End, ImageNames, Options};

/// The end of a program.
#[derive(Clone, PartialEq, Debug)]
enum Ended {
    /// The program and all its motion have ended, the machine at X and Y.
    At(f64, f64),
    /// The program did not begin: an error at a line and column.
    Unread(u64, u64, String),
    /// An error of a motion instruction ended it: ERR and EXERR.
    Erred(u64, i64, i64),
    /// Another error ended it.
    Failed(u64, String),
}

struct Row {
    why: &'static str,
    program: &'static str,
    ended: Ended,
}

fn row(why: &'static str, program: &'static str, ended: Ended) -> Row {
    Row { why, program, ended }
}

fn failed(line: u64, text: &str) -> Ended {
    Ended::Failed(line, text.to_owned())
}

fn unread(line: u64, column: u64, text: &str) -> Ended {
    Ended::Unread(line, column, text.to_owned())
}

/// Each program begins where the one before has ended, at X 0 and Y 0.
fn rows() -> Vec<Row> {
    vec![
        row("nothing to do", "", Ended::At(0.0, 0.0)),
        row(
            "motion that nobody waits for comes to its end",
            "MCLM(XY, F1, 1, [3, 4], 200, 0, 5000, 0, 5000);\nMCLM(XY, F1, 1, [-3, -4], 200, 0, 5000, 0, 5000);",
            Ended::At(0.0, 0.0),
        ),
        row(
            "moves wait for room in the queue",
            "FOR i := 1 TO 5 DO MCLM(XY, F2, 1, [1, 1], 200, 0, 5000, 0, 5000); END_FOR;\n\
             FOR i := 1 TO 5 DO MCLM(XY, F2, 1, [-1, -1], 200, 0, 5000, 0, 5000); END_FOR;",
            Ended::At(0.0, 0.0),
        ),
        row(
            "a merge takes over at once although the queue is full: M1 alone takes 2 s",
            "MCLM(XY, M1, 0, [100, 0], 50, 0, 5000, 0, 5000);\nMCLM(XY, M2, 0, [100, 50], 50, 0, 5000, 0, 5000);\n\
             DELAY(0.05);\nMCLM(XY, M3, 0, [0, 0], 50, 0, 5000, 0, 5000, 0, 0, 0, 0, 0, 1, 1);\nWAIT(M3.AC OR M3.ER);\n\
             IF M1.PC OR M2.PC THEN DELAY(-1); END_IF;",
            Ended::At(0.0, 0.0),
        ),
        row(
            "the same with Merge All Motion",
            "MCLM(XY, M1, 0, [100, 0], 50, 0, 5000, 0, 5000);\nMCLM(XY, M2, 0, [100, 50], 50, 0, 5000, 0, 5000);\n\
             DELAY(0.05);\nMCLM(XY, M3, 0, [0, 0], 50, 0, 5000, 0, 5000, 0, 0, 0, 0, 0, 1, 2);\nWAIT(M3.AC OR M3.ER);\n\
             IF M1.PC OR M2.PC THEN DELAY(-1); END_IF;",
            Ended::At(0.0, 0.0),
        ),
        row(
            "more statements than a tick has",
            "n := 0;\nWHILE n < 250000 DO n := n + 1; END_WHILE;\nMove1.Speed := n;\nIF Move1.Speed <> 250000 THEN DELAY(-1); END_IF;",
            Ended::At(0.0, 0.0),
        ),
        row(
            "an operand out of its range",
            "DELAY(0.002);\nMCLM(XY, F3, 0, [3, 0], -1, 0);",
            Ended::Erred(2, 13, 4),
        ),
        row(
            "an axis that another instruction has: homing while the axis is on its way",
            "MAM(X, F4, 0, 0, 10, 0, 100, 0, 100);\nMAM(X, F4, 7, 0, 10, 0, 100, 0, 100);",
            Ended::Erred(2, 13, 2),
        ),
        row(
            "a WAIT for a move that the program has stopped",
            "MAM(X, F5, 1, 400, 10, 0, 1000, 0, 1000);\nMAS(X, F6, Move, Yes, 1000, 0);\nWAIT(F6.PC);\nMAM(X, F7, 0, 0, 200, 0, 5000, 0, 5000);\n\
             WAIT(F7.PC);\nWAIT(F5.PC);",
            failed(
                6,
                "WAIT can no longer come true: F5 (MAM, line 1) was stopped by MAS F6",
            ),
        ),
        row(
            "a WAIT for a bit that an ended instruction has not",
            "MAM(X, F8, 1, 0, 10, 0, 1000, 0, 1000);\nWAIT(F8.PC AND F8.ER);",
            failed(2, "WAIT can no longer come true: F8 (MAM, line 1) has ended"),
        ),
        row(
            "an operand of an instruction tag out of its range",
            "Move1.EnableIn := 0;\nMove1.Speed := -5;\nMove1.EnableIn := 1;\nWAIT(Move1.MotionControl.PC);",
            Ended::Erred(3, 13, 4),
        ),
        row(
            "a negative delay",
            "\nDELAY(-1);",
            failed(2, "DELAY is -1 s, expected 0 or more"),
        ),
        row(
            "an index that is none",
            "n := 1.5;\nMove1.Position[n] := 1;",
            failed(2, "the array index is 1.5, expected a whole number, 0 or more"),
        ),
        row(
            "a step of 0",
            "n := 0;\nFOR i := 0 TO 3 BY n DO ; END_FOR;",
            failed(2, "the step of FOR is 0, expected a number other than 0"),
        ),
        row(
            "a truth value among numbers",
            "n := TRUE;\nn := n + 1;",
            failed(2, "found a BOOL, expected a number"),
        ),
        row(
            "a word that the operand does not have",
            "n := 1;\nMCLM(XY, F9, Absolut, [3, 0], 1, 0);",
            unread(
                2,
                14,
                "operand 2 (Move Type) has no word `Absolut`, did you mean `Absolute`?",
            ),
        ),
        row(
            "no such axis",
            "MSO(Xx, F9);",
            unread(1, 5, "there is no axis `Xx`, did you mean `X`?"),
        ),
        row(
            "a statement that is none",
            "WAIT(TRUE)",
            unread(
                1,
                11,
                "found the end of the program, expected `;` at the end of the statement",
            ),
        ),
    ]
}

fn unread_at(error: &SyntaxError) -> Ended {
    unread(error.line as u64, error.column as u64, &error.problem.to_string())
}

fn simulated(project: &Project, text: &str) -> Ended {
    let image = project.image();
    let checked = Program::parse(text).and_then(|mut program| program.check(&ImageNames(&image)).map(|()| program));
    let program = match checked {
        Ok(program) => program,
        Err(error) => return unread_at(&error),
    };
    let options = Options {
        until: 60.0,
        policy: Policy::default(),
    };
    let mut runner = arcline_simulation::Runner::new(Arc::new(project.machine.clone()), image);
    match runner.run(Interpreter::new(program), options, &mut Blind) {
        End::Finished => {
            let simulation = runner.simulation();
            let at: Vec<f64> = simulation.controller().trace().map(|axis| axis[0]).collect();
            Ended::At(at[0], at[1])
        }
        End::Erred(erred) => Ended::Erred(erred.line as u64, erred.err.into(), erred.exerr.into()),
        End::Wrong(RunError::Runtime(error)) => failed(error.line as u64, &error.problem.to_string()),
        End::Wrong(RunError::Hopeless(error)) => failed(error.line as u64, &error.problem()),
        End::Wrong(RunError::Driver { line, error }) => failed(line as u64, &error.to_string()),
        end => panic!("{end:?}"),
    }
}

impl Bench {
    /// A client over EtherNet/IP, and the listener that serves it.
    pub(super) async fn client(&self) -> (Client, JoinHandle<()>) {
        let mut project = arcline_config::load(arcline_config::DEFAULT, "machine.toml").expect("it is valid");
        project.server.io = IoListen::Off;
        let any = "127.0.0.1:0".parse().expect("an address");
        let listener = Listener::bind(any, self.plant.clone(), Settings::new(&project.server)).await;
        let listener = listener.expect("a free port");
        let address = listener.local_addr().to_string();
        let serving = tokio::spawn(listener.serve());
        (Client::connect(&address).await.expect("it listens"), serving)
    }

    fn at(&self) -> Ended {
        let [x, y] = self
            .plant
            .with_snapshot(|snapshot| [0, 1].map(|axis| snapshot.axes[axis].command[0]));
        Ended::At(x, y)
    }

    async fn over_the_network(&self, client: &Client, text: &str) -> Ended {
        let ran = async {
            let mut runner = Runner::program(client, text).await?;
            runner.run(&mut |_| {}).await?;
            runner.finish(&mut |_| {}).await
        };
        match ran.await {
            Ok(()) => self.at(),
            Err(ProgramError::Syntax(error)) => unread_at(&error),
            Err(ProgramError::Runtime(error)) => failed(error.line as u64, &error.problem.to_string()),
            Err(ProgramError::Hopeless(error)) => failed(error.line as u64, &error.problem()),
            Err(ProgramError::Client { line, source }) => match source.motion() {
                Some((err, exerr)) => Ended::Erred(line as u64, err.into(), exerr.into()),
                None => failed(line as u64, &source.to_string()),
            },
        }
    }

    async fn on_the_page(&self, viewer: &mut Viewer, text: &str) -> Ended {
        let whole = |value: &Value| value.as_i64().expect("a whole number");
        let error = match viewer.ask(json!({"do": "run", "text": text})).await {
            Err(error) => error,
            Ok(_) => loop {
                let push = viewer.push("program").await;
                match push["state"].as_str() {
                    Some("ended") => return self.at(),
                    Some("failed") => break push["error"].clone(),
                    _ => {}
                }
            },
        };
        let (line, text) = (whole(&error["line"]) as u64, error["text"].as_str().unwrap_or_default());
        match (&error["column"], &error["err"]) {
            (Value::Number(column), _) => unread(line, column.as_u64().unwrap_or_default(), text),
            (_, err @ Value::Number(_)) => Ended::Erred(line, whole(err), whole(&error["exerr"])),
            _ => failed(line, text),
        }
    }
}

/// A network client does not learn the cause for which an instruction by EnableIn ended: it has no instance.
#[tokio::test]
async fn a_wait_for_an_instruction_tag_ends_when_its_instruction_has_been_stopped() {
    let program = "Move1.EnableIn := 0;\nMove1.Speed := 10;\nMove1.Position[0] := 400;\nMove1.EnableIn := 1;\nMCS(CS1, Halt, 2);\nWAIT(Halt.PC);\n";
    let project = arcline_config::load(arcline_config::DEFAULT, "machine.toml").expect("it is valid");
    let bench = Bench::start().await;
    let (client, serving) = bench.client().await;
    let mut viewer = bench.viewer().await;
    viewer.push("program").await;
    viewer.take("CS1").await;
    for condition in ["Move1.MotionControl.PC", "Move1.PC"] {
        let program = format!("{program}WAIT({condition});");
        let simulation = simulated(&project, &program);
        let why = |how: &str| failed(7, &format!("WAIT can no longer come true: Move1 (MCLM, line 4) {how}"));
        assert_eq!(simulation, why("was stopped by MCS Halt"), "{condition}");
        let over = timeout(SOON, bench.over_the_network(&client, &program)).await;
        assert_eq!(over, Ok(why("has ended without PC")), "{condition}");
        let page = timeout(SOON, bench.on_the_page(&mut viewer, &program)).await;
        assert_eq!(page, Ok(why("has ended without PC")), "{condition}");
    }
    // An operand is written by clients: a WAIT for it never is without hope.
    let operand = format!("{program}WAIT(Move1.PC OR Move1.Speed = 11);");
    let waits = timeout(SOON, bench.over_the_network(&client, &operand));
    // Again and again: the program itself writes 10 when it begins.
    let written = async {
        loop {
            tokio::time::sleep(Duration::from_millis(100)).await;
            client.write("Move1.Speed", 11.0).await.expect("it is writable");
        }
    };
    let ended = tokio::select! {
        ended = waits => ended,
        () = written => panic!("it writes for ever"),
    };
    assert!(matches!(ended, Ok(Ended::At(..))), "{ended:?}");
    serving.abort();
}

#[tokio::test]
async fn programs_end_alike_on_every_interface() {
    let bench = Bench::start().await;
    let project = arcline_config::load(arcline_config::DEFAULT, "machine.toml").expect("it is valid");
    let (client, serving) = bench.client().await;
    let mut viewer = bench.viewer().await;
    viewer.push("program").await;
    for Row { why, program, ended } in rows() {
        let project = project.clone();
        let simulation = tokio::task::spawn_blocking(move || simulated(&project, program));
        assert_eq!(simulation.await.expect("it ends"), ended, "simulate, {why}:\n{program}");
        let over = bench.over_the_network(&client, program).await;
        assert_eq!(over, ended, "client, {why}:\n{program}");
        for object in ["CS1", "XY", "X"] {
            viewer.take(object).await;
        }
        let page = bench.on_the_page(&mut viewer, program).await;
        assert_eq!(page, ended, "page, {why}:\n{program}");
        for object in ["CS1", "XY", "X"] {
            let given = viewer.ask(json!({"do": "release", "object": object})).await;
            assert!(given.is_ok(), "{given:?}");
        }
    }
    serving.abort();
}

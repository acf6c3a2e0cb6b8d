//! Series: the moves that a program executes together, and its reaction to one that fails or finds no room.

use arcline_instruction_set::{MotionError, UnboundOperand};
use arcline_tag::{TagPath, Value};

use crate::calls::{Called, Calls};
use crate::{
    Driver, EvaluatedCall, Interpreter, Moves, MovesEnd, ObjectAttribute, OnError, Outcome, Pause, Policy, Program,
    ProgramRun, Progress, QueueFull, Reading, RunError, Stopped, immediately,
};

/// A machine with one queue; it records the requests of a program.
struct Machine {
    /// Moves that it takes together; 1: no series.
    longest: usize,
    /// Moves that its queue has room for, and the number that each pause adds.
    room: usize,
    freed: usize,
    /// The line whose move fails.
    fails: usize,
    /// The line before which a viewer pauses the program.
    paused: usize,
    log: Vec<String>,
}

impl Default for Machine {
    fn default() -> Self {
        Machine {
            longest: 4,
            room: usize::MAX,
            freed: 0,
            fails: 0,
            paused: 0,
            log: Vec::new(),
        }
    }
}

/// ERR of the move that fails.
const FAILED: i16 = 13;

impl Machine {
    fn take(&mut self, call: &EvaluatedCall) -> Result<usize, i16> {
        if self.room == 0 {
            return Err(MotionError::CoordinateSystemQueueFull.err());
        }
        if call.line == self.fails {
            return Err(FAILED);
        }
        self.room -= 1;
        Ok(call.line)
    }
}

impl Driver for Machine {
    type Error = i16;
    type Execution = usize;

    const MOST_READS: usize = 0;

    async fn turn(&mut self, line: usize) -> Result<(), i16> {
        if line == self.paused {
            self.log.push(format!("paused before {line}"));
            self.paused = 0;
        }
        Ok(())
    }

    fn try_turn(&mut self, line: usize) -> bool {
        line != self.paused
    }

    fn longest_series(&self) -> usize {
        self.longest
    }

    async fn moves(&mut self, series: &[EvaluatedCall]) -> Result<Moves<usize, i16>, i16> {
        let mut moves = Moves {
            executed: Vec::new(),
            end: MovesEnd::Sent,
        };
        // A packet has room for three.
        for call in series.iter().take(3) {
            match self.take(call) {
                Ok(line) => moves.executed.push(line),
                Err(FAILED) => moves.end = MovesEnd::Failed(FAILED),
                Err(_) => moves.end = MovesEnd::NoRoom { depth: 1 },
            }
            if moves.end != MovesEnd::Sent {
                break;
            }
        }
        self.log.push(format!("moves {:?} of {}", moves.executed, series.len()));
        Ok(moves)
    }

    async fn has_room(&mut self, _call: &EvaluatedCall) -> Result<bool, i16> {
        Ok(self.room > 0)
    }

    async fn call(&mut self, call: &EvaluatedCall) -> Result<usize, i16> {
        self.log.push(format!("{} {}", call.mnemonic, call.line));
        self.take(call)
    }

    async fn read(&mut self, path: &TagPath, _calls: &Calls<usize>) -> Result<Reading, i16> {
        self.log.push(format!("read {path}"));
        Ok(Reading::Value(Value::Bool(true)))
    }

    async fn read_array(&mut self, path: &TagPath) -> Result<Vec<f64>, i16> {
        self.log.push(format!("read {path}"));
        Ok(vec![1.0, 2.0])
    }

    async fn write(&mut self, path: &TagPath, _value: Value) -> Result<(), i16> {
        self.log.push(format!("write {path}"));
        Ok(())
    }

    async fn attribute(&mut self, _of: &ObjectAttribute) -> Result<f64, i16> {
        Ok(0.0)
    }

    async fn set_attribute(&mut self, _of: &ObjectAttribute, _value: f64) -> Result<(), i16> {
        Ok(())
    }

    async fn pause(&mut self, pause: Pause<'_>) -> Result<(), i16> {
        self.room = self.room.saturating_add(self.freed);
        self.log.push(match pause {
            Pause::Queue { depth } => format!("wait for a queue of {depth}"),
            Pause::Room(call) => format!("wait for room for {}", call.line),
            other => format!("{other:?}"),
        });
        Ok(())
    }

    async fn progress(&mut self, _called: &Called<usize>) -> Result<Progress<i16>, i16> {
        Ok(Progress::Ended)
    }

    async fn stopped(&mut self, _called: &Called<usize>) -> Result<Option<Stopped<i16>>, i16> {
        Ok(None)
    }

    async fn outcome(&mut self, _tag: &str, _called: Option<&Called<usize>>) -> Result<Outcome, i16> {
        unreachable!("no WAIT is in vain")
    }

    fn err(error: &i16) -> Option<i16> {
        Some(*error)
    }

    fn report(&mut self, called: &Called<usize>, error: &i16) {
        self.log.push(format!("line {} errs with {error}", called.line));
    }
}

/// A line of Structured Text with a move that takes a place in a queue.
const MOVE: &str = "MCLM(CS1, M, Absolute, [1, 2], 5, Unitspersec);";

/// Runs statements, `M` for [`MOVE`], one a line. Returns the machine's records, and the line and error of the program's end.
fn run(statements: &[&str], policy: Policy, machine: Machine) -> (Vec<String>, Result<Vec<usize>, String>) {
    let lines = statements.iter().map(|line| if *line == "M" { MOVE } else { line });
    let text = lines.collect::<Vec<_>>().join("\n");
    let program = Program::parse(&text).unwrap_or_else(|error| panic!("{error}"));
    let mut machine = machine;
    let mut run = ProgramRun::new(Interpreter::new(program), policy);
    let end = immediately(run.run(&mut machine)).map_err(|error| match error {
        RunError::Driver { line, error } => format!("line {line}: {error}"),
        error => error.to_string(),
    });
    let executed = run.calls().executed().map(|called| called.line).collect();
    (machine.log, end.map(|()| executed))
}

/// Why, statements, policy, machine, and the machine's records.
type Case = (
    &'static str,
    &'static [&'static str],
    Policy,
    Machine,
    &'static [&'static str],
);

#[test]
fn moves_between_which_nothing_else_is_asked_are_executed_together() {
    let longer = Machine::default;
    let single = || Machine {
        longest: 1,
        ..Machine::default()
    };
    let errs = Policy {
        queue_full: QueueFull::Error,
        ..Policy::default()
    };
    #[rustfmt::skip]
    let cases: [Case; 9] = [
        ("in a row",               &["M", "M", "M"],                     Policy::default(), longer(), &["moves [1, 2, 3] of 3"]),
        ("more than are sent",     &["M", "M", "M", "M"],                Policy::default(), longer(), &["moves [1, 2, 3] of 4", "moves [4] of 1"]),
        ("more than are gathered", &["M", "M", "M", "M", "M"],           Policy::default(), longer(), &["moves [1, 2, 3] of 4", "moves [4, 5] of 2"]),
        ("a tag between them",     &["M", "n := X.Y;", "M"],             Policy::default(), longer(), &["moves [1] of 1", "read X.Y", "write n", "moves [3] of 1"]),
        ("another instruction",    &["M", "MCS(CS1, S, All);", "M"],     Policy::default(), longer(), &["moves [1] of 1", "MCS 2", "moves [3] of 1"]),
        ("a move that merges",     &["M", "MCLM(CS1, M, 0, [1], 5, 0, 9, 0, 9, 0, 0, 9, 9, 0, 0, 1);"],
                                                                         Policy::default(), longer(), &["moves [1] of 1", "MCLM 2"]),
        ("a tag as an operand",    &["M", "MCLM(CS1, M, 0, P, 5, 0);"],  Policy::default(), longer(), &["moves [1] of 1", "read P", "moves [2] of 1"]),
        ("no series",              &["M", "M"],                          Policy::default(), single(), &["MCLM 1", "MCLM 2"]),
        ("an error when full",     &["M", "M"],                          errs,              longer(), &["MCLM 1", "MCLM 2"]),
    ];
    for (why, statements, policy, machine, expected) in cases {
        let (log, end) = run(statements, policy, machine);
        assert_eq!(log, expected, "{why}");
        assert!(end.is_ok(), "{why}: {end:?}");
    }
}

#[test]
fn a_move_that_fails_ends_the_program_at_its_line() {
    let machine = || Machine {
        fails: 2,
        ..Machine::default()
    };
    let (log, end) = run(&["M", "M", "M", "M"], Policy::default(), machine());
    assert_eq!(
        log,
        ["moves [1] of 4", "line 2 errs with 13"],
        "nothing behind it is executed"
    );
    assert_eq!(end, Err("line 2: 13".to_owned()));
    let policy = Policy {
        on_error: OnError::KeepGoing,
        ..Policy::default()
    };
    let (log, end) = run(&["M", "M", "M", "M"], policy, machine());
    assert_eq!(log, ["moves [1] of 4", "line 2 errs with 13", "moves [3, 4] of 2"]);
    assert_eq!(end, Ok(vec![1, 3, 4]));
}

/// An error of the program itself comes behind the moves in front of it.
#[test]
fn moves_in_front_of_an_error_of_the_program_are_executed() {
    let (log, end) = run(&["M", "M", "DELAY(-1);"], Policy::default(), Machine::default());
    assert_eq!(log, ["moves [1, 2] of 2"]);
    assert!(end.is_err_and(|error| error.starts_with("line 3: ")));
}

#[test]
fn a_series_waits_for_room_with_no_more_moves_than_the_queue_takes() {
    let machine = |longest| Machine {
        longest,
        room: 1,
        freed: 2,
        ..Machine::default()
    };
    let (log, end) = run(&["M", "M", "M", "M"], Policy::default(), machine(4));
    let queue = "wait for a queue of 1";
    assert_eq!(
        log,
        [
            "moves [1] of 4",
            queue,
            "moves [2, 3] of 2",
            "moves [] of 1",
            queue,
            "moves [4] of 1"
        ]
    );
    assert_eq!(end, Ok(vec![1, 2, 3, 4]));
    let (log, end) = run(&["M", "M"], Policy::default(), machine(1));
    assert_eq!(log, ["MCLM 1", "wait for room for 2", "MCLM 2"], "the same one by one");
    assert_eq!(end, Ok(vec![1, 2]));
}

#[test]
fn a_pause_of_the_program_comes_behind_the_moves_before_it() {
    let machine = Machine {
        paused: 3,
        ..Machine::default()
    };
    let (log, _) = run(&["M", "M", "M"], Policy::default(), machine);
    assert_eq!(log, ["moves [1, 2] of 2", "paused before 3", "moves [3] of 1"]);
}

/// A driver without a service for series: the first move of each by itself.
#[test]
fn a_series_can_be_executed_move_by_move() {
    let call = |line| EvaluatedCall {
        mnemonic: arcline_instruction_set::Mnemonic::Mclm,
        target: "CS1".into(),
        control: None,
        operands: vec![UnboundOperand::Number(0.0)],
        line,
    };
    let series = [call(1), call(2)];
    #[rustfmt::skip]
    let cases = [
        ("it has room",  Machine::default(),                           (vec![1], MovesEnd::Sent)),
        ("it has none",  Machine { room: 0, ..Machine::default() },    (vec![], MovesEnd::NoRoom { depth: 0 })),
        ("it fails",     Machine { fails: 1, ..Machine::default() },   (vec![], MovesEnd::Failed(FAILED))),
    ];
    for (why, mut machine, (executed, end)) in cases {
        let moves = immediately(machine.first_move(&series));
        assert_eq!(moves, Ok(Moves { executed, end }), "{why}");
    }
}

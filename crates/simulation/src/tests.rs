//! Steps, concurrent programs, and the format of numbers.

use std::io::{self, Write};
use std::sync::{Arc, Mutex};

use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Controller, Event};
use arcline_structured_text::{Interpreter, Policy, Program};

use crate::record::number;
use crate::{Blind, End, Observer, Options, Passed, Record, RunLimits, Runner, Simulation};

#[test]
fn numbers_are_short_and_read_back() {
    #[rustfmt::skip]
    let cases = [
        (0.0, "0"), (-0.0, "-0"), (1.0, "1"), (100.0, "100"), (0.1, "0.1"), (-2.5, "-2.5"), (1.0 / 3.0, "0.3333333333333333"),
        (0.001, "0.001"), (3600.0, "3600"), (1e-9, "1e-9"),
    ];
    for (value, expected) in cases {
        let mut text = Vec::new();
        number(&mut text, value);
        let text = String::from_utf8(text).expect("ASCII");
        assert_eq!(text, expected);
        assert_eq!(text.parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
    }
}

/// The embedded default machine, tick 0 open.
fn runner() -> Runner {
    let project =
        arcline_config::load(arcline_config::DEFAULT, "default").expect("the embedded configuration is valid");
    Runner::of(Simulation::of_project(&project))
}

fn program(text: &str) -> Interpreter {
    Interpreter::new(Program::parse(text).unwrap_or_else(|error| panic!("{text}: {error}")))
}

/// Rows of the trace and events, as text.
#[derive(Clone, Default)]
struct Text(Arc<Mutex<Vec<u8>>>);

impl Write for Text {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().expect("no thread panics").extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

struct Seen(Record);

impl Observer for Seen {
    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        self.0.event(event, time, image.control_name(event.control));
    }
    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool {
        self.0.row(tick, tick as f64 * machine.period(), controller.trace());
        true
    }
}

fn seen(work: impl FnOnce(&mut Seen)) -> String {
    let text = Text::default();
    let mut seen = Seen(Record::new(Box::new(text.clone())));
    work(&mut seen);
    seen.0.finish().expect("memory takes everything");
    let bytes = std::mem::take(&mut *text.0.lock().expect("no thread panics"));
    String::from_utf8(bytes).expect("ASCII")
}

const MOVES: &str = "MCLM(XY, M1, Absolute, [20, 5], 200, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2);\n\
                     WAIT(M1.PC);\nDELAY(0.05);\n\
                     MCLM(XY, M2, Absolute, [0, 0], 200, Unitspersec, 2000, Unitspersec2, 2000, Unitspersec2);\nWAIT(M2.PC);\n";
const ON_Z: &str = "MAM(Z, A1, Absolute, 3, 50, Unitspersec, 500, Unitspersec2, 500, Unitspersec2);\nWAIT(A1.PC);\n";

#[test]
fn a_program_in_steps_of_any_length_is_the_program_in_one_run() {
    let options = Options {
        until: 60.0,
        policy: Policy::default(),
    };
    let whole = seen(|seen| {
        let end = runner().run(program(MOVES), options, seen);
        assert!(matches!(end, End::Finished), "{end:?}");
    });
    for ticks in [1, 7, 100_000] {
        let stepped = seen(|seen| {
            let mut runner = runner();
            runner.simulation().begin();
            let id = runner.start(program(MOVES), Policy::default());
            while runner.runs(id) {
                let limits = RunLimits { ticks, until: 60.0 };
                assert_ne!(runner.step(limits, seen), Passed::Left);
            }
            assert!(matches!(runner.end_of(id), Some(Ok(()))));
        });
        // The last step may end after the program.
        let common = whole.len().min(stepped.len());
        assert!(common > 20_000, "{common} bytes");
        assert_eq!(whole[..common], stepped[..common], "steps of {ticks}");
    }
}

/// The rows of the trace that an observer sees, and all events.
struct Rows {
    needs_every_tick: bool,
    rows: Vec<(u64, Vec<u64>)>,
    events: Vec<(Event, f64)>,
}

impl Observer for Rows {
    fn needs_every_tick(&self) -> bool {
        self.needs_every_tick
    }
    fn event(&mut self, event: &Event, time: f64, _: &Image) {
        self.events.push((*event, time));
    }
    fn tick(&mut self, tick: u64, _: &Machine, controller: &mut Controller) -> bool {
        let row = controller.trace().flatten().map(f64::to_bits);
        self.rows.push((tick, row.collect()));
        true
    }
}

#[test]
fn a_run_that_passes_over_uneventful_ticks_is_the_same_run() {
    let options = Options {
        until: 60.0,
        policy: Policy::default(),
    };
    let rows = |needs_every_tick| {
        let mut rows = Rows {
            needs_every_tick,
            rows: Vec::new(),
            events: Vec::new(),
        };
        let text = [MOVES, ON_Z].concat();
        let end = runner().run(program(&text), options, &mut rows);
        assert!(matches!(end, End::Finished), "{end:?}");
        rows
    };
    let (all, few) = (rows(true), rows(false));
    assert_eq!(all.events, few.events);
    assert!(
        few.rows.len() * 5 < all.rows.len(),
        "{} of {}",
        few.rows.len(),
        all.rows.len()
    );
    assert_eq!(all.rows.last(), few.rows.last());
    for (tick, row) in few.rows {
        assert_eq!(all.rows[tick as usize], (tick, row));
    }
}

#[test]
fn programs_run_beside_each_other_and_fail_alone() {
    let mut runner = runner();
    runner.simulation().begin();
    let moves = runner.start(program(MOVES), Policy::default());
    let on_z = runner.start(program(ON_Z), Policy::default());
    let wrong = runner.start(program("MAM(S, A2, Absolute, 3, -50, Unitspersec);"), Policy::default());
    assert!(!runner.runs(wrong), "it failed at once");
    let Some(Err(End::Erred(erred))) = runner.end_of(wrong) else {
        panic!("{:?}", runner.end_of(wrong));
    };
    assert_eq!((erred.err, erred.exerr, erred.line), (13, 4, 1));
    assert_eq!(
        runner.step(RunLimits { ticks: 20, until: 60.0 }, &mut Blind),
        Passed::Ticks
    );
    assert!(runner.runs(moves), "{:?}", runner.end_of(moves));
    assert!(runner.runs(on_z), "{:?}", runner.end_of(on_z));
    assert_eq!(runner.simulation().tick(), 20);
    assert_eq!(
        runner.step(
            RunLimits {
                ticks: 2000,
                until: 60.0
            },
            &mut Blind
        ),
        Passed::Ticks
    );
    assert!(matches!(runner.end_of(moves), Some(Ok(()))));
    assert!(matches!(runner.end_of(on_z), Some(Ok(()))));
    let simulation = runner.simulation();
    let at: Vec<f64> = simulation.controller().trace().map(|axis| axis[0]).collect();
    assert_eq!(at[..3], [0.0, 0.0, 3.0]);
}

#[test]
fn a_removed_program_goes_on_no_more_and_its_motion_does() {
    let mut runner = runner();
    runner.simulation().begin();
    let moves = runner.start(program(MOVES), Policy::default());
    runner.step(RunLimits { ticks: 20, until: 60.0 }, &mut Blind);
    runner.remove(moves);
    assert!(!runner.runs(moves) && runner.end_of(moves).is_none());
    runner.step(
        RunLimits {
            ticks: 2000,
            until: 60.0,
        },
        &mut Blind,
    );
    let simulation = runner.simulation();
    let at: Vec<f64> = simulation.controller().trace().map(|axis| axis[0]).collect();
    assert_eq!(at[..2], [20.0, 5.0], "the second move was never called");
    assert_eq!(simulation.executed(), 1);
}

#[test]
fn a_wait_in_vain_ends_its_program_alone() {
    let mut runner = runner();
    runner.simulation().begin();
    let vain = runner.start(program("WAIT(X.ActualPosition > 1);"), Policy::default());
    let counts = runner.start(program("DELAY(100);"), Policy::default());
    runner.step(
        RunLimits {
            ticks: 70_000,
            until: 1e9,
        },
        &mut Blind,
    );
    let Some(Err(End::Wrong(wrong))) = runner.end_of(vain) else {
        panic!("{:?}", runner.end_of(vain));
    };
    assert!(wrong.to_string().contains("every axis is at rest"), "{wrong}");
    assert!(runner.runs(counts));
}

#[test]
fn time_and_observers_end_a_step() {
    let mut runner = runner();
    runner.simulation().begin();
    assert_eq!(
        runner.step(RunLimits { ticks: 9, until: 0.005 }, &mut Blind),
        Passed::Time
    );
    assert_eq!(runner.simulation().tick(), 5);
    struct Enough;
    impl Observer for Enough {
        fn tick(&mut self, tick: u64, _: &Machine, _: &mut Controller) -> bool {
            tick < 8
        }
    }
    assert_eq!(
        runner.step(RunLimits { ticks: 9, until: 1.0 }, &mut Enough),
        Passed::Left
    );
    assert_eq!(runner.simulation().tick(), 8);
}

/// A program that waits for a tag continues after another program, or the caller, has written it.
#[test]
fn a_wait_for_a_plain_tag_sees_the_writes_of_others() {
    let text = [arcline_config::DEFAULT, "\n[[tag]]\nname = \"Go\"\ntype = \"DINT\"\n"].concat();
    let project = arcline_config::load(&text, "test").expect("it is valid");
    let mut runner = Runner::of(Simulation::of_project(&project));
    runner.simulation().begin();
    let ticks = |ticks| RunLimits {
        ticks,
        until: f64::INFINITY,
    };
    let first = runner.start(program("WAIT(Go = 1); WAIT(Go = 2);"), Policy::default());
    runner.step(ticks(50), &mut Blind);
    assert!(runner.runs(first), "nothing has written it");
    let second = runner.start(program("DELAY(0.02); Go := 1;"), Policy::default());
    runner.step(ticks(50), &mut Blind);
    assert!(
        runner.runs(first) && !runner.runs(second),
        "it waits for the second value"
    );
    let written = runner
        .simulation()
        .write_tag("Go", &arcline_tag::WriteValue::Integer(2));
    written.expect("a DINT");
    runner.step(ticks(2), &mut Blind);
    assert!(!runner.runs(first));
}

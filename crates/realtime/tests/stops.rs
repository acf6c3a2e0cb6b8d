//! Requests to stop come before every command, and a stop under way only becomes harder. On a virtual clock.

mod machine;

use arcline_controller::{Command, Controller, Ticket};
use arcline_instruction_set::{Argument, AxisId, Call, ControlSlot, JogEnd, MAX_OPERANDS, Mnemonic};
use arcline_realtime::{COMMANDS, Rings, ServerRings, link, step};
use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use machine::machine;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

/// The axis that jogs: Y, a virtual one, 10,000 units/s² and 200,000 units/s³ at most.
const Y: u16 = 1;

/// An instruction of Y with some operands; the others are 0.
fn call(mnemonic: Mnemonic, control: u32, operands: &[(&str, f64)]) -> Call {
    let mut arguments = [Argument::None; MAX_OPERANDS];
    let instruction = mnemonic.instruction();
    for place in instruction.operands_behind_control() {
        arguments[place] = Argument::Number(0.0);
    }
    for (name, number) in operands {
        arguments[instruction.operand(name).expect(name)] = Argument::Number(*number);
    }
    for name in ["Event Distance", "Calculated Data"] {
        if let Some(place) = instruction.operand(name) {
            arguments[place] = Argument::None;
        }
    }
    Call {
        mnemonic,
        target: Some(Y),
        control: ControlSlot(control),
        arguments,
    }
}

/// A jog of 100 units/s with a deceleration of 0.001 units/s².
fn jog(control: u32, profile: f64) -> Call {
    #[rustfmt::skip]
    let operands = [
        ("Speed", 100.0), ("Accel Rate", 5000.0), ("Decel Rate", 0.001), ("Profile", profile),
        ("Accel Jerk", 100.0), ("Decel Jerk", 100.0), ("Jerk Units", 2.0),
    ];
    call(Mnemonic::Maj, control, &operands)
}

/// A stop at 0.001 units/s² of everything (0) or of the jog (1).
fn weak_stop(stop_type: f64) -> Call {
    #[rustfmt::skip]
    let operands = [
        ("Stop Type", stop_type), ("Change Decel", 1.0), ("Decel Rate", 0.001),
        ("Change Decel Jerk", 1.0), ("Decel Jerk", 0.001), ("Jerk Units", 0.0),
    ];
    call(Mnemonic::Mas, 99, &operands)
}

struct Bench {
    controller: Controller,
    rings: Rings,
    link: ServerRings,
    tickets: u64,
}

impl Bench {
    fn new() -> Self {
        let machine = machine(1_000_000);
        let (rings, link) = link(&machine);
        Bench {
            controller: Controller::new(&machine),
            rings,
            link,
            tickets: 0,
        }
    }

    fn send(&mut self, call: Call) -> Ticket {
        self.tickets += 1;
        let ticket = Ticket(self.tickets);
        self.link.commands.push(Command::Call(ticket, call)).expect("room");
        ticket
    }

    /// As the server sends instructions that stop or switch off.
    fn send_stop(&mut self, call: Call) -> Ticket {
        self.tickets += 1;
        let ticket = Ticket(self.tickets);
        let command = Command::Call(ticket, call);
        self.link.commands.push_stop(command).expect("room");
        ticket
    }

    /// Velocity of Y after some ticks.
    fn after(&mut self, ticks: u32) -> f64 {
        for _ in 0..ticks {
            assert_no_alloc(|| step(&mut self.controller, &mut self.rings));
            while self.link.answers.pop().is_ok() {}
        }
        self.velocity()
    }

    fn velocity(&mut self) -> f64 {
        self.link.snapshots.update();
        self.link.snapshots.output_buffer().axes[usize::from(Y)].command[1]
    }

    /// Y jogs at its full speed.
    fn jogging(profile: f64) -> (Self, Ticket) {
        let mut bench = Bench::new();
        let ticket = bench.send(jog(1, profile));
        assert_eq!(bench.after(200), 100.0, "it jogs");
        (bench, ticket)
    }
}

#[test]
fn a_jog_ends_at_full_deceleration_whatever_was_programmed() {
    // 100 units/s at 10,000 units/s²: 10 ticks; at 200,000 units/s³: 45 ticks.
    let profiles = [("trapezoidal", 0.0, 12), ("S-curve", 1.0, 50)];
    #[rustfmt::skip]
    let cases: [(&str, &[f64], &[f64]); 6] = [
        ("nothing besides",              &[],         &[]),
        ("a weak stop of the jog",       &[1.0],      &[]),
        ("a weak stop of everything",    &[0.0],      &[]),
        ("of the jog, and then of all",  &[1.0, 0.0], &[]),
        ("a weak stop of all behind it", &[],         &[0.0]),
        ("weak stops on both sides",     &[1.0],      &[1.0, 0.0]),
    ];
    for (profile, operand, ticks) in profiles {
        for (why, before, behind) in cases {
            let why = format!("{why}, {profile}");
            let (mut bench, ticket) = Bench::jogging(operand);
            for stop in before {
                bench.send(weak_stop(*stop));
                let speed = bench.after(100);
                assert!(speed > 99.0, "{why}: a weak stop is weak: {speed}");
            }
            bench.link.stops.end_jog(AxisId(Y), ticket, JogEnd::Lost);
            bench.after(1);
            for stop in behind {
                bench.send(weak_stop(*stop));
                bench.after(1);
            }
            let speed = bench.after(ticks);
            assert_eq!(speed, 0.0, "{why}: it stands after {ticks} ticks");
            assert_eq!(bench.after(1000), 0.0, "{why}: it stays");
        }
    }
}

#[test]
fn the_jog_of_another_instruction_goes_on() {
    let (mut bench, ticket) = Bench::jogging(0.0);
    let newer = bench.send(jog(2, 0.0));
    bench.after(10);
    bench.link.stops.end_jog(AxisId(Y), ticket, JogEnd::Lost);
    assert_eq!(bench.after(100), 100.0, "another instruction jogs the axis now");
    bench.link.stops.end_jog(AxisId(0), newer, JogEnd::Silent);
    assert_eq!(bench.after(100), 100.0, "another axis");
    bench.link.stops.end_jog(AxisId(Y), newer, JogEnd::Silent);
    assert_eq!(bench.after(20), 0.0);
}

#[test]
fn a_stop_of_everything_is_not_behind_the_commands_that_wait() {
    let (mut bench, _) = Bench::jogging(0.0);
    for control in 0..COMMANDS - 1 {
        let command = Command::RungFalse(ControlSlot(1000 + control as u32));
        bench.link.commands.push(command).expect("room");
    }
    // The last of all begins to move.
    bench.send(jog(2, 0.0));
    for _ in 0..100_000 {
        bench.link.stops.stop_all();
    }
    assert!(
        bench.after(2) <= 90.0,
        "it brakes at 10 units/s a tick from the first one on"
    );
    let mut fastest = 0.0_f64;
    for _ in 0..200 {
        fastest = bench.after(1).max(fastest);
    }
    assert!(fastest <= 80.0, "the jog that was sent before never begins: {fastest}");
    assert_eq!(bench.after(1), 0.0);
    bench.send(jog(3, 0.0));
    assert_eq!(bench.after(200), 100.0, "what is sent behind it moves");
}

/// Commands that the controller takes before it comes to one that is sent behind them, and more than one tick takes.
fn wait_before(bench: &mut Bench) {
    for control in 0..900 {
        let command = Command::RungFalse(ControlSlot(1000 + control));
        bench.link.commands.push(command).expect("room");
    }
}

#[test]
fn a_stop_instruction_overtakes_waiting_calls_which_begin_no_motion() {
    let stop = call(Mnemonic::Mas, 50, &[]);
    let move_of_y = |control| {
        let operands = [
            ("Position", 500.0),
            ("Speed", 100.0),
            ("Accel Rate", 5000.0),
            ("Decel Rate", 5000.0),
        ];
        call(Mnemonic::Mam, control, &operands)
    };
    let mut bench = Bench::jogging(0.0).0;
    wait_before(&mut bench);
    let overtaken = [bench.send(jog(2, 0.0)), bench.send(move_of_y(3))];
    bench.send_stop(stop);
    let behind = bench.send(jog(4, 0.0));
    assert!(bench.after(2) <= 90.0, "it brakes in the tick that the stop comes to");
    let mut fastest = 0.0_f64;
    let mut answers = std::collections::BTreeMap::new();
    for _ in 0..20 {
        assert_no_alloc(|| step(&mut bench.controller, &mut bench.rings));
        while let Ok(answer) = bench.link.answers.pop() {
            answers.insert(answer.ticket, answer.control);
        }
        if !answers.contains_key(&behind) {
            fastest = bench.velocity().max(fastest);
        }
    }
    assert!(
        fastest <= 90.0,
        "what was sent before the stop begins nothing: {fastest}"
    );
    for ticket in overtaken {
        assert_eq!(answers[&ticket].err, 3, "execution collision");
    }
    assert_eq!(answers[&behind].err, 0, "what was sent behind it moves");
    assert_eq!(bench.after(200), 100.0);
}

#[test]
fn a_stop_leaves_waiting_calls_of_other_axes() {
    let mut bench = Bench::new();
    wait_before(&mut bench);
    bench.send(jog(2, 0.0));
    let mut other = call(Mnemonic::Mas, 50, &[]);
    other.target = Some(0);
    bench.send_stop(other);
    assert_eq!(bench.after(200), 100.0, "X was stopped, Y jogs");
}

/// An axis that was switched off stays off, with any waiting calls.
#[test]
fn a_shutdown_is_not_reset_by_waiting_calls() {
    let mut bench = Bench::jogging(0.0).0;
    wait_before(&mut bench);
    bench.send(call(Mnemonic::Masr, 60, &[]));
    bench.send(jog(2, 0.0));
    bench.send_stop(call(Mnemonic::Masd, 50, &[]));
    assert_eq!(bench.after(3), 0.0, "it is shut down");
    assert_eq!(bench.after(200), 0.0, "and stays so");
}

/// While one tick takes all that waits, a stop is executed at its turn.
#[test]
fn a_stop_overtakes_nothing_while_the_controller_keeps_up() {
    let mut bench = Bench::new();
    let jogged = bench.send(jog(2, 0.0));
    let stopped = bench.send_stop(call(Mnemonic::Mas, 50, &[]));
    assert_no_alloc(|| step(&mut bench.controller, &mut bench.rings));
    let answers: Vec<_> = std::iter::from_fn(|| bench.link.answers.pop().ok()).collect();
    let answers: Vec<_> = answers
        .iter()
        .map(|answer| (answer.ticket, answer.control.err))
        .collect();
    assert_eq!(answers, [(jogged, 0), (stopped, 0)]);
    assert_eq!(bench.after(20), 0.0);
}

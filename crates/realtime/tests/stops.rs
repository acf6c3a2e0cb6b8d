//! Requests to stop come before every command, and a stop under way only becomes harder. On a virtual clock.

mod machine;

use arcline_controller::{Command, Controller, Ticket};
use arcline_instruction_set::{Argument, AxisId, Call, ControlSlot, JogEnd, MAX_OPERANDS, Mnemonic};
use arcline_realtime::{COMMANDS, Link, Rings, link, step};
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
    for place in instruction.given_operands() {
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
    link: Link,
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

    /// Velocity of Y after some ticks.
    fn after(&mut self, ticks: u32) -> f64 {
        for _ in 0..ticks {
            assert_no_alloc(|| step(&mut self.controller, &mut self.rings));
            while self.link.answers.pop().is_ok() {}
        }
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

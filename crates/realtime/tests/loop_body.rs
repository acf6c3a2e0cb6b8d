//! The loop body allocates nothing, and the reports of a tick are out before its snapshot.

mod machine;

use arcline_controller::{Command, Controller, Ticket};
use arcline_instruction_set::{Argument, Call, ControlSlot, Flag, MAX_OPERANDS, Mnemonic, RealArray};
use arcline_realtime::{Options, ServerRings, link, spawn, step};
use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use machine::machine;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

/// A line at 100 units/s and 2000 units/s², trapezoidal, termination type 1.
fn line(control: ControlSlot, to: [f64; 2]) -> Call {
    let mut arguments = [Argument::None; MAX_OPERANDS];
    let instruction = Mnemonic::Mclm.instruction();
    for place in instruction.operands_behind_control() {
        arguments[place] = Argument::Number(0.0);
    }
    let operands = [
        ("Speed", 100.0),
        ("Accel Rate", 2000.0),
        ("Decel Rate", 2000.0),
        ("Termination Type", 1.0),
    ];
    for (name, number) in
        operands
            .into_iter()
            .chain([("Accel Jerk", 100.0), ("Decel Jerk", 100.0), ("Jerk Units", 2.0)])
    {
        arguments[instruction.operand(name).expect(name)] = Argument::Number(number);
    }
    arguments[instruction.operand("Position").expect("an operand")] = Argument::Array(RealArray::from_slice(&to));
    for name in ["Event Distance", "Calculated Data"] {
        arguments[instruction.operand(name).expect(name)] = Argument::None;
    }
    Call {
        mnemonic: Mnemonic::Mclm,
        target: Some(0),
        control,
        arguments,
    }
}

#[test]
fn a_tick_allocates_nothing_and_is_whole_when_it_is_published() {
    let machine = machine(1_000_000);
    let (mut rings, mut link) = link(&machine);
    let mut controller = Controller::new(&machine);
    let mut control = 0;
    for ticket in 1..=3 {
        let call = line(ControlSlot(ticket as u32), [10.0 * ticket as f64, 5.0]);
        link.commands.push(Command::Call(Ticket(ticket), call)).expect("room");
    }
    link.commands.push(Command::RungFalse(ControlSlot(1))).expect("room");
    let mut answers = Vec::new();
    let mut rest = None;
    for _ in 0..1000 {
        assert_no_alloc(|| step(&mut controller, &mut rings));
        assert!(link.snapshots.update(), "every tick publishes");
        let snapshot = link.snapshots.output_buffer();
        while let Ok(event) = link.events.pop() {
            assert!(event.tick <= snapshot.tick);
            if event.control == ControlSlot(1) {
                control = (control & !event.clear) | event.set;
            }
        }
        while let Ok(answer) = link.answers.pop() {
            answers.push((answer.ticket, answer.tick, answer.control.has(Flag::Er)));
        }
        if control & Flag::Pc.mask() != 0 && rest.is_none() {
            rest = Some((snapshot.tick, snapshot.axes[0].command[0]));
        }
    }
    // One runs, one is pending, the third finds the queue full.
    assert_eq!(
        answers,
        [(Ticket(1), 0, false), (Ticket(2), 0, false), (Ticket(3), 0, true)]
    );
    let (_, position) = rest.expect("the first move ended");
    // The next move has begun within that tick, by its acceleration of 2000 units/s² no more than 1e-3 units.
    assert!(
        (10.0..10.001).contains(&position),
        "position and bits are of one tick: {position}"
    );
    assert_eq!(control & Flag::En.mask(), 0, "the rung was false");
    assert_eq!(link.meter.health().lost_events, 0);
}

#[test]
fn contours_are_planned_beside_the_tick_and_freed_there() {
    let mut machine = machine(1_000_000);
    machine.systems[0].queue_depth = 10;
    machine.systems[0].corner = arcline_controller::machine::Corner::Precise;
    let (mut rings, mut link) = link(&machine);
    let mut planning = link
        .planning
        .take()
        .expect("the machine has a precise coordinate system");
    let mut controller = Controller::new(&machine);
    for round in 0..3u64 {
        for place in 1..=2 {
            let ticket = 2 * round + place;
            let mut call = line(
                ControlSlot(ticket as u32),
                [10.0 * ticket as f64, 5.0 * (ticket % 3) as f64],
            );
            if place == 1 {
                // Command Tolerance Programmed, 0.5 units.
                for (name, number) in [("Termination Type", 6.0), ("Command Tolerance", 0.5)] {
                    let operand = call.mnemonic.instruction().operand(name).expect(name);
                    call.arguments[operand] = Argument::Number(number);
                }
            }
            link.commands.push(Command::Call(Ticket(ticket), call)).expect("room");
        }
        assert_no_alloc(|| step(&mut controller, &mut rings));
        assert!(planning.step(), "the tick has asked for a plan");
        for _ in 0..1000 {
            assert_no_alloc(|| step(&mut controller, &mut rings));
        }
        assert!(!planning.step(), "one request, one plan");
        link.snapshots.update();
        let ends = [20.0, 40.0, 60.0][round as usize];
        assert_eq!(link.snapshots.output_buffer().axes[0].command, [ends, 0.0, 0.0]);
    }
}

#[test]
fn a_contour_is_extended_in_time_or_ends_at_rest() {
    for late in [false, true] {
        let mut machine = machine(1_000_000);
        machine.systems[0].queue_depth = 10;
        machine.systems[0].corner = arcline_controller::machine::Corner::Precise;
        let (mut rings, mut link) = link(&machine);
        let mut planning = link.planning.take().expect("contours");
        let mut controller = Controller::new(&machine);
        let queue = |link: &mut ServerRings, ticket: u64, to: [f64; 2]| {
            let mut call = line(ControlSlot(ticket as u32), to);
            for (name, number) in [("Termination Type", 6.0), ("Command Tolerance", 0.5)] {
                let operand = call.mnemonic.instruction().operand(name).expect(name);
                call.arguments[operand] = Argument::Number(number);
            }
            link.commands.push(Command::Call(Ticket(ticket), call)).expect("room");
        };
        queue(&mut link, 1, [100.0, 0.0]);
        for _ in 0..13 {
            assert_no_alloc(|| step(&mut controller, &mut rings));
        }
        assert!(planning.step(), "nothing more has come");
        for _ in 0..50 {
            assert_no_alloc(|| step(&mut controller, &mut rings));
        }
        queue(&mut link, 2, [200.0, 0.0]);
        for _ in 0..20 {
            assert_no_alloc(|| step(&mut controller, &mut rings));
        }
        let mut stopped = false;
        let mut position = 0.0;
        for tick in 0..20_000 {
            if !late || tick > 5000 {
                planning.step();
            }
            assert_no_alloc(|| step(&mut controller, &mut rings));
            link.snapshots.update();
            let [at, velocity, _] = link.snapshots.output_buffer().axes[0].command;
            position = at;
            stopped |= velocity == 0.0 && at < 200.0;
        }
        assert_eq!((position, stopped), (200.0, late), "late: {late}");
    }
}

#[test]
fn the_thread_ticks_counts_and_stops_all_motion() {
    let machine = machine(250_000);
    let (mut link, handle) = spawn(&machine, Options::default()).expect("a thread");
    link.commands
        .push(Command::Call(Ticket(1), line(ControlSlot(1), [100_000.0, 0.0])))
        .expect("room");
    // A condition, not a time: the move is under way.
    loop {
        link.snapshots.update();
        if link.snapshots.output_buffer().axes[0].command[1] > 50.0 {
            break;
        }
        std::thread::yield_now();
    }
    handle.stop();
    link.snapshots.update();
    let last = link.snapshots.output_buffer();
    assert_eq!(last.axes[0].command[1], 0.0, "it stands still");
    let health = link.meter.health();
    assert_eq!(health.ticks, last.tick + 1);
    assert_eq!(health.lateness.histogram.iter().sum::<u64>(), health.ticks);
    assert!(health.compute.max > 0.0 && health.compute.max >= health.compute.last);
    assert_eq!((health.lost_events, health.lost_answers), (0, 0));
}

//! The step clock and the fast one, on their threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use arcline_controller::{Command, Ticket, UNNAMED};
use arcline_instruction_set::{Mnemonic, bind};
use arcline_realtime::{Clock, Options, ServerRings, Steps, spawn};

/// Longest wait for events that take microseconds.
const DEADLINE: Duration = Duration::from_secs(20);

fn started(clock: Clock) -> (ServerRings, arcline_realtime::Handle, arcline_config::Project) {
    let project =
        arcline_config::load(arcline_config::DEFAULT, "default").expect("the embedded configuration is valid");
    let options = Options {
        clock,
        ..Options::default()
    };
    let (link, handle) = spawn(&project.machine, options).expect("a thread");
    (link, handle, project)
}

fn wait(what: &str, mut is_so: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < DEADLINE, "{what}");
        std::thread::yield_now();
    }
}

fn step(link: &ServerRings, ticks: u32, until: Option<Box<dyn FnMut() -> bool + Send>>) -> u32 {
    let (done, passed) = mpsc::channel();
    let stepper = link.stepper.as_ref().expect("the machine is on the step clock");
    stepper.step(Steps {
        ticks,
        until,
        abandoned: Arc::default(),
        done: Box::new(move |ticks| done.send(ticks).expect("the test waits")),
    });
    passed.recv_timeout(DEADLINE).expect("the steps end")
}

#[test]
fn commands_are_executed_at_the_open_tick_and_no_tick_passes_unasked() {
    let (mut link, handle, project) = started(Clock::Step);
    let image = project.image();
    let call = bind(Mnemonic::Mso, Some(0), UNNAMED, &[], &image).expect("MSO has no operands");
    link.commands
        .push(Command::Call(Ticket(1), call))
        .expect("the ring is empty");
    wait("the instruction is answered", || link.answers.peek().is_ok());
    assert_eq!(link.answers.pop().map(|answer| answer.tick), Ok(0));
    link.snapshots.update();
    assert_eq!(link.snapshots.output_buffer().tick, 0);
    assert_eq!(step(&link, 25, None), 25);
    wait("the snapshot comes", || {
        link.snapshots.update();
        link.snapshots.output_buffer().tick == 25
    });
    let mut looks = 0;
    let until = Box::new(move || {
        looks += 1;
        looks > 10
    });
    assert_eq!(step(&link, 1000, Some(until)), 10, "the present tick counts too");
    assert_eq!(step(&link, 0, None), 0);
    assert_eq!(link.meter.health().ticks, 35);
    // Every tick that is over has one row of samples.
    let mut samples = link.samples.take().expect("nobody took them");
    let (mut numbers, width) = (0, samples.width());
    samples.take(|rows| numbers += rows.len());
    assert_eq!(numbers, 35 * width);
    handle.stop();
}

#[test]
fn abandoned_steps_end_at_the_present_tick() {
    let (link, handle, _) = started(Clock::Step);
    let stepper = link.stepper.as_ref().expect("the machine is on the step clock");
    let abandoned = Arc::new(AtomicBool::new(false));
    let (done, passed) = mpsc::channel();
    stepper.step(Steps {
        ticks: u32::MAX,
        until: None,
        abandoned: abandoned.clone(),
        done: Box::new(move |ticks| done.send(ticks).expect("the test waits")),
    });
    wait("ticks pass", || link.meter.health().ticks > 0);
    abandoned.store(true, Ordering::Release);
    let passed = passed.recv_timeout(DEADLINE).expect("the steps end");
    assert_eq!(link.meter.health().ticks, u64::from(passed));
    // And others step.
    assert_eq!(step(&link, 5, None), 5);
    assert_eq!(link.meter.health().ticks, u64::from(passed) + 5);
    handle.stop();
}

#[test]
fn a_fast_clock_lets_so_many_times_as_many_ticks_pass() {
    let (link, handle, _) = started(Clock::Fast(20.0));
    let began = Instant::now();
    let first = link.meter.health().ticks;
    wait("2 s of the machine pass", || link.meter.health().ticks >= first + 2000);
    // Real time would be 2 s; a busy computer is late, never early.
    let took = began.elapsed();
    assert!(took > Duration::from_millis(90), "{took:?}");
    assert!(took < Duration::from_secs(2), "{took:?}: no faster than real time");
    handle.stop();
}

//! Streams of moves on planned contours: a trajectory is extended while it is travelled, so that nothing stops at the end of
//! a window.

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::is_long;

const TOLERANCE: f64 = 0.02;
const RADIUS: f64 = 75.0;
/// Length of a move.
const STEP: f64 = 0.5;
const SPEED: f64 = 200.0;
const RATE: f64 = 5000.0;

/// XY with precise corners, enforced limits of its axes and a queue.
fn precise(depth: usize) -> Bench {
    Bench::replacing(
        "name = \"XY\"",
        &format!("name = \"XY\"\nqueue_depth = {depth}\ncorner = \"precise\"\naxis_limits = \"enforce\""),
    )
}

/// A circle through the origin in short lines: move `place` of it, the last one of `count` with an end.
fn chord(place: usize, count: usize) -> String {
    let angle = STEP / RADIUS * (place + 1) as f64;
    let (x, y) = (RADIUS * angle.sin(), RADIUS * (1.0 - angle.cos()));
    let end = if place + 1 == count { "1" } else { "6, 0, 0, 0.02" };
    format!("MCLM(XY, M{place}, 0, [{x}, {y}], {SPEED}, 0, {RATE}, 0, {RATE}, 0, 1, 100000, 100000, 0, {end})")
}

fn off_circle(bench: &Bench) -> f64 {
    (bench.position("X").hypot(bench.position("Y") - RADIUS) - RADIUS).abs()
}

fn speed(bench: &Bench) -> f64 {
    bench.axis("X").command[1].hypot(bench.axis("Y").command[1])
}

/// Queues moves of the stream until one finds no room; the next one to queue.
fn feed(bench: &mut Bench, from: usize, count: usize) -> usize {
    for place in from..count {
        match bench.call(&chord(place, count)) {
            OK => {}
            refused => {
                assert_eq!(refused, (43, 0), "a full queue, nothing else");
                return place;
            }
        }
    }
    count
}

/// Travels a stream, with actions at some ticks; checks path and acceleration at every tick. Returns the ticks it
/// took and the least speed apart from the first and last 0.1 s.
fn travel(depth: usize, count: usize, mut at: impl FnMut(&mut Bench, u64)) -> (u64, f64, Vec<[u64; 2]>) {
    let mut bench = precise(depth);
    let mut fed = 0;
    let (mut speeds, mut trace) = (Vec::new(), Vec::new());
    let mut last = [0.0; 2];
    let name = format!("M{}", count - 1);
    while !bench.control(&name).has(Flag::Pc) {
        fed = feed(&mut bench, fed, count);
        let now = bench.now();
        at(&mut bench, now);
        bench.tick();
        assert!(off_circle(&bench) <= TOLERANCE * 1.001, "tick {}", bench.now());
        let next = ["X", "Y"].map(|axis| bench.axis(axis).command[1]);
        for (before, after) in last.iter().zip(&next) {
            let acceleration = (after - before) / 0.001;
            assert!(acceleration.abs() <= 1.5 * RATE, "tick {}: {acceleration}", bench.now());
        }
        last = next;
        speeds.push(speed(&bench));
        trace.push(["X", "Y"].map(|axis| bench.position(axis).to_bits()));
        assert!(bench.now() < 60_000, "it never ends");
    }
    for place in 0..count {
        assert!(bench.control(&format!("M{place}")).has(Flag::Pc), "M{place}");
    }
    let angle = STEP / RADIUS * count as f64;
    assert_eq!(bench.position("X"), RADIUS * angle.sin());
    assert_eq!(bench.position("Y"), RADIUS * (1.0 - angle.cos()));
    let inner = &speeds[100..speeds.len() - 100];
    let least = inner.iter().copied().fold(f64::INFINITY, f64::min);
    (bench.now(), least, trace)
}

#[test]
fn short_moves_through_a_queue_of_100_never_stop() {
    let moves = if is_long() { 3000 } else { 1000 };
    let (ticks, least, _) = travel(100, moves, |_, _| {});
    // 0.5 mm each at 200 mm/s, 0.09 s more for speeding up and slowing down.
    assert!(ticks < moves as u64 * 5 / 2 + 150, "{ticks} ticks, as slow as {least}");
    assert!(least > 0.9 * SPEED, "as slow as {least}");
}

#[test]
fn a_stream_is_repeated_to_the_last_bit() {
    let run = || travel(100, 300, |_, _| {});
    assert_eq!(run().2, run().2);
}

#[test]
fn an_override_and_a_hold_keep_the_path_across_splices() {
    let (ticks, least, _) = travel(100, 500, |bench, now| match now {
        120 => bench.set_override("XY", 0.5),
        330 => bench.set_override("XY", 0.0),
        500 => bench.set_override("XY", 1.5),
        600 => bench.set_override("XY", 1.0),
        _ => {}
    });
    assert_eq!(least, 0.0, "it was held");
    // At full speed 1.34 s; at half of it for 0.2 s, at rest for nearly as long.
    assert!(ticks > 1450 && ticks < 1900, "{ticks} ticks");
}

#[test]
fn a_change_of_dynamics_applies_to_the_queued_moves() {
    let (ticks, least, _) = travel(100, 400, |bench, now| {
        if now == 150 {
            assert_eq!(bench.call("MCCD(XY, C, CoordinatedMove, Yes, 100, Unitspersec)"), OK);
        }
    });
    // A hundred moves at half of the speed, to rest, then it goes on as programmed.
    assert!(ticks < 1650, "{ticks} ticks, as slow as {least}");
}

#[test]
fn a_stop_in_a_stream_rests_on_the_path() {
    for after in [150, 163, 187, 240] {
        let mut bench = precise(100);
        let mut fed = 0;
        for _ in 0..after {
            fed = feed(&mut bench, fed, 2000);
            bench.tick();
        }
        bench.execute("MCS(XY, S1, CoordinatedMove, Yes, 4000, 0, Yes, 90000, Unitspersec3)");
        while !bench.control("S1").has(Flag::Pc) {
            bench.tick();
            assert!(off_circle(&bench) <= TOLERANCE * 1.001, "tick {}", bench.now());
        }
        assert_eq!(speed(&bench), 0.0);
        let active = (0..fed).any(|place| bench.control(&format!("M{place}")).has(Flag::Ip));
        assert!(!active, "every move has ended");
        assert_eq!(
            bench.call("MCLM(XY, B, 0, [0, 0], 200, 0, 5000, 0, 5000, 0, 1, 100000, 100000, 0, 1)"),
            OK
        );
        bench.until("B", Flag::Pc);
        assert_eq!((bench.position("X"), bench.position("Y")), (0.0, 0.0));
    }
}

#[test]
fn a_second_move_that_comes_late_is_joined_without_a_stop() {
    let line = |tag: &str, x: f64, y: f64, end: &str| {
        format!("MCLM(XY, {tag}, 0, [{x}, {y}], 200, 0, 5000, 0, 5000, 0, 1, 100000, 100000, 0, {end})")
    };
    let mut bench = precise(20);
    bench.execute(&line("M1", 60.0, 0.0, "6, 0, 0, 0.1"));
    bench.run(150);
    bench.execute(&line("M2", 60.0, 60.0, "1"));
    let mut least = f64::INFINITY;
    while !bench.control("M1").has(Flag::Pc) {
        bench.tick();
        least = least.min(speed(&bench));
    }
    assert!(least > 5.0, "the corner is passed at {least}");
    bench.until("M2", Flag::Pc);
    assert_eq!((bench.position("X"), bench.position("Y")), (60.0, 60.0));
}

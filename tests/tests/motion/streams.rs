//! Streams: a toolpath of chords that a program sends while the motion is under way.

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::Random;

use crate::contours::Watch;

/// Moves that can wait, as a dense toolpath needs it.
const QUEUE: u32 = 400;

/// XY with planned contours inside the limits of its axes.
fn machine() -> Bench {
    let keys = format!("name = \"XY\"\nqueue_depth = {QUEUE}\ncorner = \"precise\"\naxis_limits = \"enforce\"");
    Bench::replacing("name = \"XY\"", &keys)
}

/// The chord of a number along a wave, 0.25 mm long at 200 mm/s.
fn chord(number: u32, last: u32) -> String {
    chord_as(Profile::Trapezoid, number, last)
}

#[derive(Clone, Copy, Debug)]
enum Profile {
    Trapezoid = 0,
    SCurve = 1,
}

fn chord_as(profile: Profile, number: u32, last: u32) -> String {
    let profile = profile as u8;
    let x = 0.25 * f64::from(number);
    let (x, y) = (
        (1000.0 * x).round() / 1000.0,
        (1000.0 * 5.0 * (x / 15.0).sin()).round() / 1000.0,
    );
    let end = if number == last { "1" } else { "6, 0, 0, 0.01" };
    format!("MCLM(XY, M, 0, [{x}, {y}], 200, 0, 5000, 0, 5000, 0, {profile}, 100000, 100000, 0, {end})")
}

/// Sends chords, `each_tick` a tick while the queue has room, until the last one is at its end. Returns the ticks from the first chord to the first
/// motion, and the number of chords sent until then.
fn run(each_tick: u32, chords: u32) -> (u64, u32) {
    let mut bench = machine();
    let (mut sent, mut began) = (0, None);
    while sent < chords || bench.system("XY").status & 4 != 0 {
        let room = bench.system("XY").queue_room.min(each_tick);
        for _ in 0..room.min(chords - sent) {
            sent += 1;
            assert_eq!(bench.call(&chord(sent, chords)), OK, "chord {sent}");
        }
        let full = bench.system("XY").queue_room == 0;
        assert!(!full || sent > QUEUE, "{sent} chords fill the queue");
        bench.tick();
        if bench.axis("X").command[1] != 0.0 {
            began.get_or_insert((bench.now(), sent));
        }
    }
    let rests = bench.system("XY").contour_rests;
    assert_eq!((rests.starved, rests.unplanned), (0, 0), "{each_tick} chords a tick");
    assert_eq!(
        bench.position("X"),
        0.25 * f64::from(chords),
        "{each_tick} chords a tick"
    );
    began.expect("it moves")
}

/// A series brings 64 moves a tick. 64 moves do not wait for others, and here a plan comes in the tick of its request.
#[test]
fn the_first_move_of_a_fast_stream_starts_within_20_ms() {
    for (each_tick, most) in [(64, 3), (16, 6), (8, 10)] {
        let (ticks, sent) = run(each_tick, 1500);
        assert!(
            ticks <= most,
            "{each_tick} chords a tick: the first move starts after {ticks} ms, {sent} chords sent"
        );
    }
}

/// A program that is only a quarter faster than its machine.
#[test]
fn a_stream_that_just_keeps_up_never_rests() {
    run(1, 1000);
}

/// Sends the chords of some numbers, as fast as there is room.
fn send(bench: &mut Bench, chords: std::ops::RangeInclusive<u32>, last: u32) {
    for number in chords {
        assert_eq!(bench.call(&chord(number, last)), OK, "chord {number}");
    }
}

/// Lets ticks pass until the coordinate system is at rest.
fn to_rest(bench: &mut Bench) {
    for _ in 0..10_000 {
        bench.tick();
        if bench.system("XY").status & 4 == 0 {
            return;
        }
    }
    panic!("XY never comes to rest");
}

/// The sender pauses until the machine has come to rest, and goes on within a second: the sender was too slow, not the planner.
#[test]
fn a_program_that_pauses_starves_its_stream() {
    let mut bench = machine();
    send(&mut bench, 1..=200, 400);
    to_rest(&mut bench);
    let rests = bench.system("XY").contour_rests;
    assert_eq!((rests.starved, rests.unplanned), (0, 0), "more moves may never come");
    send(&mut bench, 201..=400, 400);
    to_rest(&mut bench);
    let rests = bench.system("XY").contour_rests;
    assert_eq!((rests.starved, rests.unplanned), (1, 0));
    assert_eq!(bench.position("X"), 100.0);
}

/// A stream that begins seconds after the end of another is a new one.
#[test]
fn a_second_stream_is_no_rest_of_the_first() {
    let mut bench = machine();
    send(&mut bench, 1..=200, 400);
    to_rest(&mut bench);
    bench.run(1_500);
    send(&mut bench, 201..=400, 400);
    to_rest(&mut bench);
    let rests = bench.system("XY").contour_rests;
    assert_eq!((rests.starved, rests.unplanned), (0, 0));
}

/// A merge at any instant of a stream takes over at once, within the limits of the axes and the programmed speed, and ends at its target;
/// the stream that is sent behind it runs without a rest.
#[test]
fn a_merge_at_any_instant_of_a_stream_keeps_the_limits_and_another_stream_goes_on() {
    for seed in 0..24 {
        let mut random = Random(seed);
        let profile = if seed % 2 == 0 {
            Profile::Trapezoid
        } else {
            Profile::SCurve
        };
        let (merge, at) = (1 + random.below(2), 3 + random.below(450));
        let shown = format!("seed {seed}, {profile:?}, merge {merge} at {at}");
        let mut bench = machine();
        for number in 1..=390 {
            assert_eq!(bench.call(&chord_as(profile, number, 400)), OK, "{shown}");
        }
        bench.run(at);
        let mut watch = match profile {
            Profile::Trapezoid => Watch::new(&bench).without_jerk(),
            Profile::SCurve => Watch::new(&bench),
        };
        let target = [random.between(-60.0, 60.0), random.between(-60.0, 60.0)];
        let [x, y] = target;
        let number = profile as u8;
        let call = format!(
            "MCLM(XY, Merged, 0, [{x}, {y}], 200, 0, 5000, 0, 5000, 0, {number}, 100000, 100000, 0, 1, {merge}, 0)"
        );
        assert_eq!(bench.call(&call), OK, "{shown}");
        assert!(!bench.control("M").has(Flag::Ip), "{shown}: {}", bench.bits("M"));
        let begun = bench.now();
        while !bench.control("Merged").has(Flag::Pc) {
            watch.tick(&mut bench);
            let speed = bench.system("XY").path_speed;
            assert!(speed <= 200.0 * 1.000_001, "{shown}: {speed}");
            assert!(bench.now() < begun + 5_000, "{shown}: {}", bench.bits("Merged"));
        }
        assert_eq!([bench.position("X"), bench.position("Y")], target, "{shown}");
        // The wave again, from its beginning.
        for number in 0..=390 {
            assert_eq!(bench.call(&chord_as(profile, number, 390)), OK, "{shown}");
        }
        while bench.system("XY").status & 4 != 0 {
            watch.tick(&mut bench);
        }
        let rests = bench.system("XY").contour_rests;
        assert_eq!((rests.starved, rests.unplanned), (0, 0), "{shown}");
        assert_eq!(bench.position("X"), 0.25 * 390.0, "{shown}");
    }
}

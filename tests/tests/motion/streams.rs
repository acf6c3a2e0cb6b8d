//! Streams: a toolpath of chords that a program sends while the motion is under way.

use arcline_tests::bench::{Bench, OK};

/// Moves that can wait, as a dense toolpath needs it.
const QUEUE: u32 = 400;

/// XY with planned contours inside the limits of its axes.
fn machine() -> Bench {
    let keys = format!("name = \"XY\"\nqueue_depth = {QUEUE}\ncorner = \"precise\"\naxis_limits = \"enforce\"");
    Bench::replacing("name = \"XY\"", &keys)
}

/// The chord of a number along a wave, 0.25 mm long at 200 mm/s.
fn chord(number: u32, last: u32) -> String {
    let x = 0.25 * f64::from(number);
    let (x, y) = (
        (1000.0 * x).round() / 1000.0,
        (1000.0 * 5.0 * (x / 15.0).sin()).round() / 1000.0,
    );
    let end = if number == last { "1" } else { "6, 0, 0, 0.01" };
    format!("MCLM(XY, M, 0, [{x}, {y}], 200, 0, 5000, 0, 5000, 0, 0, 100000, 100000, 0, {end})")
}

/// Sends chords, so many a tick while the queue has room, until the last one is at its end. The ticks from the first chord to the first
/// motion, and the chords that were sent until then.
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

/// A series brings 64 moves a tick: more than enough of them have come after 10 ms.
#[test]
fn the_first_move_of_a_fast_stream_starts_within_20_ms() {
    for each_tick in [64, 16, 8] {
        let (ticks, sent) = run(each_tick, 1500);
        assert!(
            ticks <= 20,
            "{each_tick} chords a tick: the first move starts after {ticks} ms, {sent} chords sent"
        );
    }
}

/// A program that is only a quarter faster than its machine.
#[test]
fn a_stream_that_just_keeps_up_never_rests() {
    run(1, 1000);
}

//! Dense toolpaths through a queue of 1,000 moves, sent a little faster than they are travelled: the motion begins at once and never rests
//! on the way, inside the limits at every tick.

use arcline_tests::random::is_long;
use arcline_tests::streams::{Feed, Latency, STREAMS, limits, travel};

#[test]
fn a_stream_that_is_sent_faster_than_it_is_travelled_never_rests() {
    for stream in STREAMS {
        for jerk in [None, Some(100_000.0)] {
            let moves = stream.moves(if is_long() { 1500 } else { 300 }, jerk);
            let kept = limits(jerk);
            let feed = Feed {
                depth: 1000,
                per_tick: 16.0,
                latency: Latency::Seconds(0.01),
            };
            let told = travel(&moves, jerk, feed, |_, _, sample| {
                let Some(sample) = sample else { return };
                assert!(sample.velocity.norm() <= stream.speed * (1.0 + 1e-9), "{}", stream.name);
                for axis in 0..3 {
                    let (acceleration, most) = (sample.acceleration[axis].abs(), kept.acceleration[axis]);
                    assert!(acceleration <= most * (1.0 + 1e-9), "{}: {acceleration}", stream.name);
                }
            });
            let shown = format!(
                "{}, jerk {jerk:?}: {:?}",
                stream.name,
                (told.plans, told.not_found, told.late)
            );
            assert_eq!((told.unplanned, told.starved), (0, 0), "{shown}");
            assert!(told.began <= 0.021, "{shown}: began after {} s", told.began);
        }
    }
}

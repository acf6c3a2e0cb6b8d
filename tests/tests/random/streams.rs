//! Random toolpaths through a queue of 1,000 moves that is kept filled: chords, islands of tiny moves, lines, arcs between lines and sudden corners. Plans
//! come 20 ms after they were asked for. The motion never rests on the way, within its limits at every tick.
#![allow(missing_docs)]

use arcline_tests::random::seeds;
use arcline_tests::streams::{Feed, Latency, Wild, limits, travel};

const MOVES: usize = 200;
/// Seeds that rested: a curve that was left for evenly rounded corners, too coarse in those that it passed first, or never left as it was too fast for them.
const FOUND: [u64; 5] = [111, 293, 460, 735, 804];

#[test]
fn a_trapezoid_stream_that_is_sent_fast_enough_never_rests() {
    let mut rests = 0;
    for seed in seeds(120).chain(FOUND) {
        let wild = Wild::new(seed, MOVES);
        if wild.jerk.is_some() {
            continue;
        }
        let kept = limits(wild.jerk);
        let feed = Feed {
            depth: 1000,
            per_tick: 16.0,
            latency: Latency::Seconds(0.02),
        };
        let told = travel(&wild.moves, wild.jerk, feed, |_, _, sample| {
            let Some(sample) = sample else { return };
            assert!(
                sample.velocity.norm() <= wild.speed * (1.0 + 1e-9),
                "seed {seed}: {wild}"
            );
            for axis in 0..3 {
                let (acceleration, most) = (sample.acceleration[axis].abs(), kept.acceleration[axis]);
                assert!(
                    acceleration <= most * (1.0 + 1e-9),
                    "seed {seed}: {acceleration}, {wild}"
                );
            }
        });
        rests += told.unplanned;
        if told.unplanned > 0 {
            println!("seed {seed} rests {} times: {wild}", told.unplanned);
        }
    }
    assert_eq!(rests, 0);
}

//! The computing time of plans beside the motion, and its growth with the number of moves: `cargo bench -p arcline-benchmarks --bench streams`
//! [`-- STREAM`]. Each stream goes through a queue of 1,000 that is always full, once with 1,000, 10,000 and 100,000 moves; `FRONT=out.csv` writes,
//! for the plot of docs/MOTION.md, the planned part of the motion at each instant.

#![allow(missing_docs)]

use std::io::Write;

use arcline_tests::streams::{Feed, Latency, STREAMS, travel};

const COUNTS: [usize; 3] = [1_000, 10_000, 100_000];
const FEED: Feed = Feed {
    depth: 1000,
    per_tick: f64::INFINITY,
    latency: Latency::Measured,
};

fn main() {
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    // As every benchmark with --test: that it runs, not how fast.
    let counts = if std::env::args().any(|argument| argument == "--test") {
        vec![100]
    } else {
        COUNTS.to_vec()
    };
    let most = std::env::var("ARCLINE_MOVES").ok().and_then(|text| text.parse().ok());
    println!(
        "stream   profile     moves  motion s  planning s   share  moves/s  longest ms  plans  not found  late  rests"
    );
    for stream in STREAMS
        .iter()
        .filter(|stream| only.as_ref().is_none_or(|only| stream.name.contains(only)))
    {
        for jerk in [None, Some(100_000.0)] {
            for count in counts
                .iter()
                .copied()
                .filter(|&count| most.is_none_or(|most| count <= most))
            {
                let moves = stream.moves(count, jerk);
                let told = travel(&moves, jerk, FEED, |_, _, _| {});
                println!(
                    "{:8} {} {count:7} {:9.3} {:11.3} {:7.3} {:8.0} {:11.1} {:6} {:10} {:5} {:6}",
                    stream.name,
                    if jerk.is_some() { "S-curve  " } else { "trapezoid" },
                    told.motion,
                    told.planning,
                    told.planning / told.motion,
                    count as f64 / told.planning,
                    told.longest * 1e3,
                    told.plans,
                    told.not_found,
                    told.late,
                    told.unplanned,
                );
                if let Ok(path) = std::env::var("FRONT") {
                    let mut file = std::fs::File::create(path).expect("a file");
                    for [wall, travelled, planned] in told.fronts {
                        writeln!(file, "{wall},{travelled},{planned}").expect("written");
                    }
                }
            }
        }
    }
}

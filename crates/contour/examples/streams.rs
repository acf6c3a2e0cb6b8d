//! How long planning a dense toolpath takes: `streams [MOVES]` plans the surface of `run_streams.py` (chords of 0.25 mm at 200 mm/s,
//! tolerance 0.01 mm) in a queue of 1,000 moves and prints planning time, time of motion and extensions that were not found.
#![allow(clippy::disallowed_methods, reason = "an example may read the clock")]

use arcline_contour::{AxisLimits, ContourMove, Deviation, Path, Point, begin, extend};
use std::time::Instant;

const QUEUE: usize = 1000;
/// Seconds of motion that are left when an extension is asked for, and how long it may take.
const AHEAD: f64 = 0.5;
const LEAD: f64 = 0.1;

fn surface(u: f64) -> Point {
    let (x, y) = (60.0 * (u / 60.0).sin() + 8.0 * (u / 7.0).sin(), 40.0 * (u / 47.0).sin());
    let exact = Point::new(x, y + 5.0 * (u / 9.0).cos(), 6.0 * (u / 13.0).sin());
    exact.map(|part| (part * 1000.0).round() / 1000.0)
}

fn moves(count: usize, jerk: Option<f64>) -> Vec<ContourMove> {
    let points: Vec<Point> = (0..=count).map(|k| surface(0.25 * k as f64)).collect();
    let path = points.windows(2).map(|ends| Path::line(ends[0], ends[1]));
    path.map(|path| ContourMove {
        path,
        speed: 200.0,
        acceleration: 10_000.0,
        deceleration: 10_000.0,
        jerk: jerk.map(|jerk| 10.0 * jerk),
        tolerance: 0.01,
        deviation: Deviation::Corners,
    })
    .collect()
}

fn main() {
    let count = std::env::args()
        .nth(1)
        .and_then(|text| text.parse().ok())
        .unwrap_or(5000);
    for jerk in [None, Some(100_000.0)] {
        let moves = moves(count, jerk);
        let limits = AxisLimits {
            speed: Point::repeat(500.0),
            acceleration: Point::repeat(5000.0),
            jerk: jerk.map(Point::repeat),
        };
        let begun = Instant::now();
        let mut known = QUEUE.min(count);
        let mut running = begin(&moves[..known], &limits);
        known = running.moves();
        let first = begun.elapsed().as_secs_f64();
        let (mut passed, mut now, mut before, mut rests, mut calls) = (0, 0.0, 0.0, 0, 0);
        while known < count {
            now = (running.duration() - AHEAD).max(now);
            let on = running.move_at(now);
            passed += on;
            calls += 1;
            let queue = &moves[passed..(passed + QUEUE).min(count)];
            if let Some(longer) = extend(&running, on, queue, &limits, now, now + LEAD) {
                known = passed + longer.moves();
                running = longer;
            } else {
                rests += 1;
                before += running.duration();
                (passed, now) = (known, 0.0);
                known = (known + QUEUE).min(count);
                running = begin(&moves[passed..known], &limits);
                known = passed + running.moves();
            }
        }
        let (took, motion) = (begun.elapsed().as_secs_f64(), before + running.duration());
        println!(
            "{} {count} moves: {motion:.3} s of motion, {rests} rests, planned in {took:.3} s ({calls} extensions, first plan \
             {first:.3} s), {:.3} of the motion, {:.0} moves/s",
            if jerk.is_some() { "S-curve  " } else { "trapezoid" },
            took / motion,
            count as f64 / took
        );
    }
}

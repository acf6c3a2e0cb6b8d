//! A change of all moves of a deep queue: what it costs in the tick of an MCCD of Active and Pending Motion, and in those behind it.
//!
//! 1,000 pieces of 0.1 units, each with rates of its own, so that every joint binds the look-ahead. Prints the least of many runs,
//! so that what else the machine does is left out; with `--test` it runs once.

#![allow(clippy::disallowed_methods, missing_docs)] // the clock is what a benchmark reads
use std::hint::black_box;
use std::time::Instant;

use arcline_planner::geometry::{Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, Ending, Move, Parameter, Planner};

const PIECES: usize = 1000;

/// As much as a coordinate system keeps with a move.
type Data = [u64; 30];

fn deep(clock: &Clock) -> Planner<Data> {
    let mut planner = Planner::new(PIECES, Point::zeros());
    planner.set_rate(0.001, clock);
    for piece in 0..=PIECES {
        let at = |place: usize| Point::new(0.1 * place as f64, 0.0, 0.0);
        let motion = Move {
            path: Path::line(at(piece), at(piece + 1)),
            rotation: None,
            corner: f64::INFINITY,
            last_speed: 1.0,
            limits: Limits {
                speed: 200.0,
                acceleration: (1000 + piece % 5) as f64,
                deceleration: (1000 + piece % 7) as f64,
                jerk: Some(Jerk {
                    acceleration: 20_000.0,
                    deceleration: 20_000.0,
                }),
            },
            ending: Ending::Contour { constrained: true },
            parameter: Parameter::TIME,
            data: [0; 30],
        };
        if piece == 0 {
            planner.start(motion, clock.now(), clock);
        } else {
            planner.enqueue(motion, clock).expect("there is room");
        }
    }
    planner
}

fn main() {
    let runs = if std::env::args().any(|argument| argument == "--test") {
        1
    } else {
        500
    };
    let clock = Clock::at(0, 1_000_000);
    let mut planner = deep(&clock);
    let (mut change, mut behind) = (f64::INFINITY, [f64::INFINITY; 6]);
    for run in 0..runs {
        let speed = 100.0 + f64::from(run % 3);
        let from = Instant::now();
        let mut limits = planner.active().expect("it moves").motion.limits;
        let factor = if run % 2 == 0 { 1.1 } else { 1.0 / 1.1 };
        let harder = |limits: &mut Limits| {
            limits.speed = speed;
            limits.deceleration *= factor;
        };
        harder(&mut limits);
        planner.change_pending(&limits, &clock, |waiting| harder(&mut waiting.limits));
        planner.change_limits(limits, &clock);
        change = change.min(from.elapsed().as_secs_f64() * 1e6);
        for least in &mut behind {
            let from = Instant::now();
            black_box(&mut planner).continue_look_ahead(&clock);
            *least = least.min(from.elapsed().as_secs_f64() * 1e6);
        }
    }
    println!("change of {PIECES} pending moves: {change:.1} µs; look-ahead of the ticks behind it: {behind:.1?} µs");
}

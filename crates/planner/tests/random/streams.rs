//! Streams of short moves on planned contours: the trajectory is extended again and again while it is travelled, and comes to
//! rest at its old end only where no extension was found in time.
//!
//! `ARCLINE_CASES` sets how many streams of each kind are travelled (1 unless told), `ARCLINE_MOVES` how many moves each has
//! (200, and half of the places), and with `ARCLINE_LATENCY=measured` a plan comes as late as it kept a processor busy (Linux), in place of 10 ms.

use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove};
use arcline_planner::geometry::{Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, ContourEvent, ContourQueue, Ending, InstalledPlan, Move, Parameter};

use super::{Random, seeds_of_long};

/// Pending places: half of a second at least, as is advised.
const DEPTH: usize = 200;
const TOLERANCE: f64 = 0.05;
const SPEED: f64 = 200.0;

/// Legs of a kind: how long, and by how much each turns.
struct Kind {
    name: &'static str,
    length: (f64, f64),
    turn: (f64, f64),
    /// Every other leg turns to the other side: sharp corners close together, of which the least time is hardest to find. They
    /// may rest now and then, and are travelled only in long streams.
    to_and_fro: bool,
}

#[rustfmt::skip]
const KINDS: &[Kind] = &[
    Kind { name: "chords of a circle", length: (0.5, 0.5), turn: (0.0067, 0.0067), to_and_fro: false },
    Kind { name: "curves",             length: (0.4, 1.5), turn: (0.02, 0.3),      to_and_fro: false },
    Kind { name: "flat waves",         length: (0.3, 2.0), turn: (-0.4, 0.4),      to_and_fro: false },
    Kind { name: "any corners",        length: (0.4, 6.0), turn: (-1.5, 1.5),      to_and_fro: false },
    Kind { name: "zig-zags",           length: (0.5, 3.0), turn: (1.2, 2.6),       to_and_fro: true },
];

/// Moves of a long stream.
const LONG: usize = 1000;

/// The results of streams.
#[derive(Clone, Copy, Debug, Default)]
struct Told {
    asked: usize,
    not_found: usize,
    late: usize,
    /// Rests where moves were waiting.
    rests: usize,
    /// The longest time that an extension took, and all of them, seconds.
    longest: f64,
    took: f64,
    /// Seconds that the streams took.
    whole: f64,
}

fn legs(kind: &Kind, random: &mut Random, count: usize, s_curve: bool) -> Vec<Move<usize>> {
    let (mut from, mut heading) = (Point::new(1.0, -2.0, 0.5), random.between(-3.0, 3.0));
    let rates = Limits {
        speed: SPEED,
        acceleration: 4000.0,
        deceleration: 4000.0,
        jerk: s_curve.then_some(Jerk {
            acceleration: 90_000.0,
            deceleration: 90_000.0,
        }),
    };
    (0..count)
        .map(|data| {
            let side = if kind.to_and_fro && data % 2 == 1 { -1.0 } else { 1.0 };
            heading += side * random.between(kind.turn.0, kind.turn.1);
            let length = random.between(kind.length.0, kind.length.1);
            let to = from + Point::new(libm::cos(heading), libm::sin(heading), 0.0) * length;
            let path = Path::line(from, to);
            from = to;
            Move {
                path,
                rotation: None,
                corner: f64::INFINITY,
                limits: rates,
                last_speed: rates.speed,
                ending: if data + 1 == count {
                    Ending::Stop
                } else {
                    Ending::Blend { tolerance: TOLERANCE }
                },
                parameter: Parameter::TIME,
                data,
            }
        })
        .collect()
}

/// Seconds for which this thread has kept a processor busy.
fn busy() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Travels moves that are queued as soon as there is room.
fn travel(moves: &[Move<usize>], s_curve: bool, period_ns: u64, told: &mut Told) {
    let period = period_ns as f64 * 1e-9;
    let limits = AxisLimits {
        speed: Point::new(300.0, 300.0, 200.0),
        acceleration: Point::new(5000.0, 5000.0, 4000.0),
        jerk: s_curve.then(|| Point::new(100_000.0, 100_000.0, 80_000.0)),
    };
    let measured = std::env::var("ARCLINE_LATENCY").is_ok_and(|latency| latency == "measured");
    let mut clock = Clock::at(0, period_ns);
    let mut queue = ContourQueue::new(DEPTH.min(moves.len() / 2));
    let (mut sent, mut done) = (0, 0);
    let mut coming = None;
    while done < moves.len() {
        clock.tick += 1;
        queue.steer(&clock);
        while let Some(event) = queue.event(&clock) {
            queue.pass(&clock);
            done += 1;
            if event == ContourEvent::End {
                queue.finish();
                told.rests += usize::from(done < moves.len());
                break;
            }
        }
        while let Some(next) = moves.get(sent)
            && queue.push(*next, &clock).is_ok()
        {
            sent += 1;
        }
        let mut asked: Vec<ContourMove> = Vec::new();
        if let Some(batch) = queue.batch(&clock, &clock, |motion| asked.push(motion)) {
            let from = if measured { busy() } else { 0.0 };
            let planned = match &batch.extends {
                Some(extension) => extension.plan(&asked, &limits),
                None => Some(arcline_contour::begin(&asked, &limits)),
            };
            let took = if measured { busy() - from } else { 0.01 };
            if batch.extends.is_some() {
                told.asked += 1;
                told.not_found += usize::from(planned.is_none());
                told.longest = told.longest.max(took);
                told.took += took;
            }
            let due = clock.tick + (took / period).ceil() as u64;
            coming = Some((due, batch.generation, planned.map(Arc::new)));
        }
        if let Some((_, generation, planned)) = coming.take_if(|(due, ..)| *due <= clock.tick) {
            let found = planned.is_some();
            match queue.install(generation, planned, &clock) {
                Ok(InstalledPlan::Started | InstalledPlan::Extended(_)) => {}
                Err(_) => told.late += usize::from(found),
            }
        }
        assert!(clock.tick as f64 * period < 600.0, "it does not end");
    }
    told.whole += clock.tick as f64 * period;
}

#[test]
fn streams_are_extended_in_time() {
    let count = std::env::var("ARCLINE_MOVES").ok();
    let count = count.and_then(|count| count.parse().ok()).unwrap_or(200);
    let mut total = Told::default();
    for kind in KINDS.iter().filter(|kind| count >= LONG || !kind.to_and_fro) {
        let ways = [(true, 1_000_000), (true, 250_000), (false, 250_000)];
        // One S-curve of two in a plain run.
        for (s_curve, period_ns) in ways.into_iter().skip(usize::from(!crate::is_long())) {
            let mut told = Told::default();
            for seed in seeds_of_long(1, 1000) {
                let moves = legs(kind, &mut Random(seed), count, s_curve);
                travel(&moves, s_curve, period_ns, &mut told);
            }
            let shape = if s_curve { "S-curve" } else { "trapezoid" };
            println!("{}, {shape}, {period_ns} ns: {told:?}", kind.name);
            total.asked += told.asked;
            total.rests += if kind.to_and_fro { 0 } else { told.rests };
        }
    }
    println!("{total:?}");
    assert!(total.asked > 40, "{total:?}");
    assert_eq!(total.rests, 0, "{total:?}");
}

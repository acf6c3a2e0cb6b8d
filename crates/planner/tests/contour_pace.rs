//! Overrides, holds, resumes, shares and stops at any instant of planned contours: no limit of any axis or of the moves is
//! exceeded, the curve is not left, and everything comes to its end.
//!
//! `ARCLINE_CASES` sets how many contours are travelled (8 unless told).
#![allow(missing_docs)]

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_planner::geometry::{Path, Point};
use arcline_planner::precise::{self, AxisLimits, ContourMove, Trajectory};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, ContourPassage, ContourQueue, Ending, Move, Parameter};

/// 4 kHz.
const PERIOD_NS: u64 = 250_000;
const PERIOD: f64 = 0.000_25;
const TOLERANCE: f64 = 0.05;
/// Share of a limit that is rounding.
const ROUNDING: f64 = 1e-6;

fn cases() -> u64 {
    let set = std::env::var("ARCLINE_CASES").ok();
    set.and_then(|count| count.parse().ok()).unwrap_or(8)
}

/// A generator of its own, so that a seed means the same contour for ever (SplitMix64).
struct Random(u64);

impl Random {
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.share()
    }

    fn of<V: Copy>(&mut self, values: &[V]) -> V {
        values[((values.len() as f64) * self.share()) as usize % values.len()]
    }
}

/// Legs of some kind: zig-zags, curves of short lines, corners far apart, or all of it.
fn moves(random: &mut Random, s_curve: bool) -> Vec<Move<usize>> {
    let kind = random.of(&[0, 1, 2, 3]);
    let count = 4 + (24.0 * random.share()) as usize;
    let speed = random.of(&[60.0, 150.0, 300.0]);
    let (mut from, mut heading) = (Point::new(1.0, -2.0, 0.5), random.between(-3.0, 3.0));
    let rates = Limits {
        speed,
        acceleration: random.between(2500.0, 7000.0),
        deceleration: random.between(2500.0, 7000.0),
        jerk: s_curve.then(|| Jerk {
            acceleration: random.between(60_000.0, 150_000.0),
            deceleration: random.between(60_000.0, 150_000.0),
        }),
    };
    (0..count)
        .map(|data| {
            let side = if data % 2 == 0 { 1.0 } else { -1.0 };
            let (length, turn) = match kind {
                0 => (random.between(0.5, 3.0), side * random.between(1.2, 2.6)),
                1 => (random.between(0.4, 1.5), random.between(0.05, 0.3)),
                2 => (random.between(5.0, 25.0), random.between(-2.0, 2.0)),
                _ => (random.between(0.4, 12.0), random.between(-1.5, 1.5)),
            };
            heading += turn;
            let to = from + Point::new(libm::cos(heading), libm::sin(heading), 0.0) * length;
            let path = Path::line(from, to);
            from = to;
            let last = data + 1 == count;
            Move {
                path,
                turn: None,
                corner: f64::INFINITY,
                limits: rates,
                ending: if last || random.share() < 0.05 {
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

fn off(moves: &[Move<usize>], q: &Point) -> f64 {
    let distance = |one: &Move<usize>| {
        let (a, d) = (one.path.start(), one.path.end() - one.path.start());
        let t = ((q - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
        (a + d * t - q).norm()
    };
    moves.iter().map(distance).fold(f64::INFINITY, f64::min)
}

/// What is done to a contour.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Plot {
    /// Overrides, holds and shares, again and again.
    Storm,
    /// One hold, and on again.
    Hold,
    /// One stop.
    Stop,
}

struct Ride {
    seed: u64,
    random: Random,
    queue: ContourQueue<usize>,
    clock: Clock,
    moves: Vec<Move<usize>>,
    limits: AxisLimits,
    s_curve: bool,
    /// What a stop may use.
    stop: Option<Limits>,
    last: Option<(Point, Point, Point)>,
    done: usize,
    /// Plans by the move that they begin with: they are the same in every ride over the same moves.
    plans: Plans,
}

type Plans = BTreeMap<usize, Arc<Trajectory>>;

impl Ride {
    fn new(seed: u64, plans: Plans) -> Self {
        let mut random = Random(seed);
        let s_curve = random.share() < 0.7;
        let moves = moves(&mut random, s_curve);
        let limits = AxisLimits {
            speed: Point::new(300.0, random.between(80.0, 300.0), 200.0),
            acceleration: Point::new(5000.0, random.between(2000.0, 6000.0), 4000.0),
            jerk: s_curve.then(|| Point::new(100_000.0, random.between(40_000.0, 120_000.0), 80_000.0)),
        };
        let clock = Clock::at(0, PERIOD_NS);
        let mut queue = ContourQueue::new(100);
        for motion in &moves {
            queue.push(*motion, &clock).expect("there is room");
        }
        Ride {
            seed,
            random,
            queue,
            clock,
            moves,
            limits,
            s_curve,
            stop: None,
            last: None,
            done: 0,
            plans,
        }
    }

    fn plan(&mut self) {
        let mut asked: Vec<ContourMove> = Vec::new();
        let Some(batch) = self.queue.batch(&self.clock, |motion| asked.push(motion)) else {
            return;
        };
        assert!(batch.extends.is_none(), "everything is known");
        let limits = &self.limits;
        let plan = self.plans.entry(self.done);
        let plan = plan.or_insert_with(|| Arc::new(precise::plan(&asked, limits)));
        self.queue
            .install(batch.generation, Some(Arc::clone(plan)), &self.clock)
            .expect("it is wanted");
    }

    fn fail(&self, what: &str) -> ! {
        panic!("seed {}, tick {}: {what}", self.seed, self.clock.tick)
    }

    /// A tick; false when everything is over.
    fn tick(&mut self) -> bool {
        self.clock.tick += 1;
        self.queue.steer(&self.clock);
        loop {
            match self.queue.passage(&self.clock) {
                None => break,
                Some(ContourPassage::Next) => {
                    self.queue.pass();
                    self.done += 1;
                }
                Some(ContourPassage::End) if self.stop.is_some() => {
                    let sample = self.queue.sample(&self.clock).expect("it stands");
                    if sample.velocity.norm() > 1e-9 {
                        self.fail("stopped, but not at rest");
                    }
                    return false;
                }
                Some(ContourPassage::End) => {
                    let end = self.queue.moves().next().expect("the last one").path.end();
                    let sample = self.queue.sample(&self.clock).expect("it stands");
                    if sample.position != end {
                        self.fail("the end is not exact");
                    }
                    self.queue.pass();
                    self.queue.finish();
                    self.done += 1;
                    self.last = None;
                    if self.done == self.moves.len() {
                        return false;
                    }
                }
            }
        }
        self.plan();
        self.check();
        true
    }

    fn check(&mut self) {
        let Some(sample) = self.queue.sample(&self.clock) else {
            return;
        };
        let distance = off(&self.moves, &sample.position);
        if distance > TOLERANCE * 1.001 {
            self.fail(&format!("off the path by {distance}"));
        }
        let most = 1.0 + ROUNDING;
        let first = self.moves[0].limits;
        let rate = first.acceleration.max(first.deceleration);
        let rate = self.stop.map_or(rate, |stop| rate.max(stop.deceleration));
        let jerk = first.jerk.map(|jerk| jerk.acceleration.min(jerk.deceleration));
        let stop_jerk = self
            .stop
            .and_then(|stop| stop.jerk)
            .map_or(0.0, |jerk| jerk.deceleration);
        if sample.velocity.norm() > first.speed * most || sample.acceleration.norm() > rate * most {
            self.fail(&format!(
                "vector {} {}",
                sample.velocity.norm(),
                sample.acceleration.norm()
            ));
        }
        for axis in 0..3 {
            let (v, a) = (sample.velocity[axis].abs(), sample.acceleration[axis].abs());
            if v > self.limits.speed[axis] * most || a > self.limits.acceleration[axis] * most {
                self.fail(&format!("axis {axis}: velocity {v}, acceleration {a}"));
            }
        }
        if let Some((position, velocity, acceleration)) = self.last {
            let moved = sample.position - position - (sample.velocity + velocity) * (0.5 * PERIOD);
            let most_moved = if self.s_curve {
                1e5 * PERIOD.powi(3)
            } else {
                1e4 * PERIOD.powi(2)
            };
            if moved.norm() > most_moved {
                self.fail(&format!("a step by {}", moved.norm()));
            }
            let change = (sample.acceleration - acceleration) / PERIOD;
            // What rounding leaves of a difference.
            let slack = 1e-3;
            if let Some(limits) = self.limits.jerk {
                for axis in 0..3 {
                    if change[axis].abs() > limits[axis] * most + slack {
                        self.fail(&format!("axis {axis}: jerk {} of {}", change[axis], limits[axis]));
                    }
                }
            }
            if let Some(limit) = jerk
                && change.norm() > limit.max(stop_jerk) * most + slack
            {
                self.fail(&format!("vector jerk {} of {limit}", change.norm()));
            }
        }
        self.last = Some((sample.position, sample.velocity, sample.acceleration));
    }

    fn speed(&self) -> f64 {
        self.queue
            .sample(&self.clock)
            .map_or(0.0, |sample| sample.velocity.norm())
    }

    /// Returns the seconds from a stop or a hold to rest, with the speed where it began.
    fn run(mut self, plot: Plot) -> (Plans, Option<(f64, f64)>) {
        let at = (self.random.between(0.01, 1.2) / PERIOD) as u64;
        let mut asked = None;
        let mut answer = None;
        loop {
            match plot {
                Plot::Storm if self.clock.tick < 20_000 => {
                    if self.random.share() < 0.005 {
                        let rate = self.random.of(&[0.0, 0.1, 0.5, 0.9, 1.0, 1.0]);
                        self.queue.set_rate(rate, &self.clock);
                    }
                    if self.random.share() < 0.002 {
                        let share = self.random.of(&[0.0, 0.3, 1.0, 1.0]);
                        self.queue.set_share(share, &self.clock);
                    }
                }
                Plot::Storm if self.clock.tick == 20_000 => {
                    self.queue.set_share(1.0, &self.clock);
                    self.queue.set_rate(1.0, &self.clock);
                }
                Plot::Hold if self.clock.tick == at && self.queue.is_running() => {
                    self.queue.set_rate(0.0, &self.clock);
                    asked = Some((self.clock.tick, self.speed()));
                }
                Plot::Stop if self.clock.tick == at && self.queue.is_running() => {
                    let limits = Limits {
                        speed: 100.0,
                        acceleration: 3000.0,
                        deceleration: self.random.between(1000.0, 9000.0),
                        jerk: self.s_curve.then(|| Jerk {
                            acceleration: 90_000.0,
                            deceleration: self.random.between(20_000.0, 200_000.0),
                        }),
                    };
                    asked = Some((self.clock.tick, self.speed()));
                    self.stop = Some(limits);
                    self.queue.stop(&limits, &self.clock);
                }
                _ => {}
            }
            let more = self.tick();
            if let Some((from, speed)) = asked
                && answer.is_none()
                && (self.speed() < 1e-9 || !more)
            {
                answer = Some(((self.clock.tick - from) as f64 * PERIOD, speed));
                if plot == Plot::Hold {
                    self.queue.set_rate(1.0, &self.clock);
                }
            }
            if !more {
                return (self.plans, answer);
            }
            if self.clock.tick > 200_000 {
                self.fail("it does not end");
            }
        }
    }
}

#[test]
fn no_change_of_the_pace_exceeds_a_limit() {
    for seed in 0..cases() {
        let mut plans = Plans::new();
        for plot in [Plot::Storm, Plot::Hold, Plot::Stop] {
            let rest;
            (plans, rest) = Ride::new(seed, plans).run(plot);
            // 0.1 s are what the jerk limits alone take.
            if let Some((time, speed)) = rest {
                assert!(time < 0.6, "seed {seed}, {plot:?}: {time} s from {speed} to rest");
                println!("{seed} {plot:?} from {speed:.1}: {time:.3} s");
            }
        }
    }
}

//! Overrides, holds, resumes, shares and stops at any instant of planned contours: no limit of any axis or of the moves is
//! exceeded, the curve is not left, and everything comes to its end.
//!
//! `ARCLINE_CASES` sets how many contours are travelled (6 unless told).

use std::collections::BTreeMap;
use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove, Trajectory};
use arcline_planner::geometry::{Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, ContourEvent, ContourQueue, Ending, Move, Parameter};

use super::{Random, seeds_of_long};

/// 4 kHz.
const PERIOD_NS: u64 = 250_000;
const PERIOD: f64 = 0.000_25;
const TOLERANCE: f64 = 0.05;
/// The highest override and the highest change of a speed, together.
const FASTEST: f64 = 1.3 * 1.25;
/// Seconds in which every change is over.
const SETTLED: f64 = 0.6;
/// Share of a limit that is rounding.
const ROUNDING: f64 = 1e-6;

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
                rotation: None,
                corner: f64::INFINITY,
                limits: rates,
                last_speed: rates.speed,
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

/// The changes of a contour.
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
    /// The limits of a stop.
    stop: Option<Limits>,
    last: Option<(Point, Point, Point)>,
    /// The override, and when something was changed last.
    rate: f64,
    changed: u64,
    /// When a pause ended last.
    paused: Option<u64>,
    /// The programmed speed of the move before the active one.
    before: f64,
    done: usize,
    /// Plans by the move that they begin with: they are the same in every ride over the same moves.
    plans: Plans,
    /// A plan made anew, the tick at which it comes, and what it is for.
    coming: Option<(u64, u32, Option<Arc<Trajectory>>)>,
    /// Plans made anew that came, and of these those that came into force.
    anew: [usize; 2],
}

/// The result of a ride.
struct Ridden {
    plans: Plans,
    /// Seconds from a stop or a hold to rest, and the speed where it began.
    rest: Option<(f64, f64)>,
    anew: [usize; 2],
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
            rate: 1.0,
            changed: 0,
            paused: None,
            before: 0.0,
            done: 0,
            plans,
            coming: None,
            anew: [0; 2],
        }
    }

    fn plan(&mut self) {
        if let Some((_, generation, planned)) = self.coming.take_if(|(due, ..)| *due <= self.clock.tick) {
            self.anew[0] += 1;
            if self.queue.install(generation, planned, &self.clock).is_ok() {
                self.anew[1] += 1;
            }
        }
        let mut asked: Vec<ContourMove> = Vec::new();
        let Some(batch) = self.queue.batch(&self.clock, &self.clock, |motion| asked.push(motion)) else {
            return;
        };
        if let Some(extension) = batch.extends {
            let planned = extension.plan(&asked, &self.limits).map(Arc::new);
            // Most are in time, some are not.
            let due = self.clock.tick + (self.random.of(&[0.0, 0.005, 0.02, 0.06]) / PERIOD) as u64;
            self.coming = Some((due, batch.generation, planned));
            return;
        }
        // Only what is as programmed is the same in every ride.
        if asked
            .iter()
            .zip(&self.moves[self.done..])
            .any(|(one, motion)| one.speed != motion.limits.speed)
        {
            let plan = Some(Arc::new(arcline_contour::plan(&asked, &self.limits)));
            self.queue
                .install(batch.generation, plan, &self.clock)
                .expect("it is wanted");
            return;
        }
        let limits = &self.limits;
        let plan = self.plans.entry(self.done);
        let plan = plan.or_insert_with(|| Arc::new(arcline_contour::plan(&asked, limits)));
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
            match self.queue.event(&self.clock) {
                None => break,
                Some(ContourEvent::Next) => {
                    self.before = self.queue.pass(&self.clock).expect("it was active").limits.speed;
                    self.done += 1;
                }
                Some(ContourEvent::End) if self.stop.is_some() => {
                    let sample = self.queue.sample(&self.clock).expect("it stands");
                    if sample.velocity.norm() > 1e-9 {
                        self.fail("stopped, but not at rest");
                    }
                    return false;
                }
                Some(ContourEvent::End) => {
                    let end = self.queue.moves().next().expect("the last one").path.end();
                    let sample = self.queue.sample(&self.clock).expect("it stands");
                    if sample.position != end {
                        self.fail("the end is not exact");
                    }
                    self.queue.pass(&self.clock);
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
        let most_jerk = |jerk: Jerk| jerk.acceleration.max(jerk.deceleration);
        // A plan has the lower jerk of a move; what brakes it to rest has the programmed one, which may be higher.
        let jerk = if self.pauses() {
            first.jerk.map(most_jerk)
        } else {
            first.jerk.map(|jerk| jerk.acceleration.min(jerk.deceleration))
        };
        let stop_jerk = self.stop.and_then(|stop| stop.jerk).map_or(0.0, most_jerk);
        if sample.velocity.norm() > FASTEST * first.speed * most || sample.acceleration.norm() > rate * most {
            self.fail(&format!(
                "vector {} {}",
                sample.velocity.norm(),
                sample.acceleration.norm()
            ));
        }
        // The requested speed is reached.
        let programmed = self
            .queue
            .moves()
            .map(|motion| motion.limits.speed)
            .fold(self.before, f64::max);
        let calm = (self.clock.tick - self.changed) as f64 * PERIOD > SETTLED;
        if calm && self.stop.is_none() && sample.velocity.norm() > self.rate * programmed * most + 1e-9 {
            self.fail(&format!(
                "{} with {} of {programmed}",
                sample.velocity.norm(),
                self.rate
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
            // Rounding of a difference.
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

    /// A change of dynamics: of the active move, or of all.
    fn change(&mut self) {
        let share = self.random.of(&[0.5, 0.8, 1.0, 1.25]);
        let rates = self.random.of(&[0.7, 1.0, 1.0]);
        let count = self.random.of(&[1, usize::MAX]);
        for motion in self.queue.moves_mut().take(count) {
            let own = self.moves[motion.data].limits;
            motion.limits = Limits {
                speed: own.speed * share,
                acceleration: own.acceleration * rates,
                deceleration: own.deceleration * rates,
                jerk: own.jerk.map(|jerk| Jerk {
                    acceleration: jerk.acceleration * rates,
                    deceleration: jerk.deceleration * rates,
                }),
            };
        }
        self.changed = self.clock.tick;
        self.queue.change(&self.clock);
    }

    /// It comes to rest for a while, or is on its way on after that.
    fn pauses(&self) -> bool {
        let since = self
            .paused
            .map_or(f64::INFINITY, |tick| (self.clock.tick - tick) as f64 * PERIOD);
        self.rate == 0.0 || since < SETTLED
    }

    fn set_rate(&mut self, rate: f64) {
        if self.rate == 0.0 {
            self.paused = Some(self.clock.tick);
        }
        (self.rate, self.changed) = (rate, self.clock.tick);
        self.queue.set_rate(rate, &self.clock);
    }

    fn speed(&self) -> f64 {
        self.queue
            .sample(&self.clock)
            .map_or(0.0, |sample| sample.velocity.norm())
    }

    fn run(mut self, plot: Plot) -> Ridden {
        let at = (self.random.between(0.01, 1.2) / PERIOD) as u64;
        let mut asked = None;
        let mut answer = None;
        loop {
            match plot {
                Plot::Storm if self.clock.tick < 6_000 => {
                    if self.random.share() < 0.002 {
                        let rate = self.random.of(&[0.0, 0.1, 0.5, 0.9, 1.0, 1.3]);
                        self.set_rate(rate);
                    }
                    if self.random.share() < 0.0006 {
                        self.change();
                    }
                }
                Plot::Storm if self.clock.tick == 6_000 => {
                    self.set_rate(1.0);
                }
                Plot::Hold if self.clock.tick == at && self.queue.is_running() => {
                    self.set_rate(0.0);
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
                    self.set_rate(1.0);
                }
            }
            if !more {
                return Ridden {
                    plans: self.plans,
                    rest: answer,
                    anew: self.anew,
                };
            }
            if self.clock.tick > 200_000 {
                self.fail("it does not end");
            }
        }
    }
}

#[test]
fn no_change_of_the_pace_exceeds_a_limit() {
    let mut anew = [0; 2];
    for seed in seeds_of_long(24, 1000) {
        let mut plans = Plans::new();
        for plot in [Plot::Storm, Plot::Hold, Plot::Stop] {
            let ridden = Ride::new(seed, plans).run(plot);
            plans = ridden.plans;
            for (sum, count) in anew.iter_mut().zip(ridden.anew) {
                *sum += count;
            }
            // 0.1 s are what the jerk limits alone take.
            if let Some((time, speed)) = ridden.rest {
                assert!(time < SETTLED, "seed {seed}, {plot:?}: {time} s from {speed} to rest");
            }
        }
    }
    let [came, in_force] = anew;
    println!("{came} plans made anew, {in_force} of them in force");
    assert!(
        2 * in_force > came,
        "{came} plans made anew, {in_force} of them in force"
    );
}

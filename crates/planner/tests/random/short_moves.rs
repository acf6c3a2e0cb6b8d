//! Programs of short moves of every termination type: in no update does an axis change its velocity by more than its step in a
//! corner and what the programmed rates give.
//!
//! `ARCLINE_CASES` sets how many programs are run (2,000 unless told).

use std::fmt::Write;

use arcline_planner::geometry::{Arc, CirclePoint, Dimension, Direction, Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, Ending, Move, MoveEvent, Parameter, Planner};

use super::{Random, seeds};

const PERIOD_NS: u64 = 1_000_000;
const PERIOD: f64 = 0.001;
/// Change of velocity that each axis may make in a corner, units/s.
const STEP: [f64; 2] = [10.0, 4.0];
/// No program takes longer, ticks.
const LONGEST: u64 = 60_000;

/// The actions of a program besides its moves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meanwhile {
    Nothing,
    Overrides,
    Changes,
    Stop,
}

struct Program {
    moves: Vec<Move<usize>>,
    depth: usize,
    /// Ticks between a move and the next one, at least.
    pause: u64,
    meanwhile: Meanwhile,
}

fn ending(random: &mut Random) -> Ending {
    let tolerance = random.between(0.01, 3.0);
    random.of(&[
        Ending::Stop,
        Ending::Blend { tolerance },
        Ending::Blend {
            tolerance: f64::INFINITY,
        },
        Ending::Contour { constrained: true },
        Ending::Contour { constrained: false },
        Ending::Contour { constrained: false },
        Ending::Contour { constrained: false },
    ])
}

fn limits(random: &mut Random, s_curve: bool) -> Limits {
    let rate = |random: &mut Random| random.of(&[300.0, 1000.0, 3000.0]);
    let jerk = |random: &mut Random| random.of(&[5_000.0, 40_000.0]);
    Limits {
        speed: random.of(&[20.0, 60.0, 100.0, 200.0]),
        acceleration: rate(random),
        deceleration: rate(random),
        jerk: s_curve.then(|| Jerk {
            acceleration: jerk(random),
            deceleration: jerk(random),
        }),
    }
}

/// An arc with a radius at which no axis notices the centripetal acceleration.
fn arc(random: &mut Random, from: Point, heading: &mut f64, length: f64) -> Option<Path> {
    let radius = random.between(200.0, 500.0);
    let side = random.of(&[-1.0, 1.0]);
    let (sin, cos) = libm::sincos(*heading);
    let center = from + Point::new(-sin, cos, 0.0) * (side * radius);
    let turned = side * length / radius;
    let (sin, cos) = libm::sincos(turned);
    let arm = from - center;
    let to = center + Point::new(arm[0] * cos - arm[1] * sin, arm[0] * sin + arm[1] * cos, 0.0);
    *heading += turned;
    let direction = if side > 0.0 {
        Direction::CounterClockwise
    } else {
        Direction::Clockwise
    };
    Arc::new(Dimension::Two, from, to, CirclePoint::Center(center), direction)
        .ok()
        .map(Path::Arc)
}

fn program(random: &mut Random) -> Program {
    let s_curve = random.share() < 0.5;
    let same = random.share() < 0.5;
    let common = limits(random, s_curve);
    let count = 3 + (random.share() * 12.0) as usize;
    let (mut from, mut heading) = (Point::new(1.0, -2.0, 0.0), random.between(-3.0, 3.0));
    let shortest: f64 = random.of(&[0.002, 0.05, 0.5]);
    let moves = (0..count)
        .map(|data| {
            heading += match (random.share() * 5.0) as u32 {
                0 => std::f64::consts::PI,
                1 => 0.0,
                2 => random.between(-0.05, 0.05),
                _ => random.between(-2.5, 2.5),
            };
            let length = if random.share() < 0.3 {
                random.between(20.0, 60.0)
            } else {
                shortest * libm::pow(40.0, random.share())
            };
            let line = from + Point::new(libm::cos(heading), libm::sin(heading), 0.0) * length;
            let path = match random.share() < 0.2 {
                true => arc(random, from, &mut heading, length).unwrap_or(Path::line(from, line)),
                false => Path::line(from, line),
            };
            from = path.end();
            Move {
                path,
                rotation: None,
                corner: f64::INFINITY,
                limits: if same { common } else { limits(random, s_curve) },
                last_speed: common.speed,
                ending: if data + 1 == count {
                    Ending::Stop
                } else {
                    ending(random)
                },
                parameter: Parameter::TIME,
                data,
            }
        })
        .collect();
    Program {
        moves,
        depth: random.of(&[1, 1, 2, 5, 20]),
        pause: random.of(&[0, 0, 0, 3, 40]),
        meanwhile: random.of(&[
            Meanwhile::Nothing,
            Meanwhile::Nothing,
            Meanwhile::Overrides,
            Meanwhile::Changes,
            Meanwhile::Stop,
        ]),
    }
}

/// As Structured Text, for the report of a failure.
fn text(program: &Program) -> String {
    let mut text = format!(
        "// queue_depth = {}, {} ticks between moves, {:?}\n",
        program.depth, program.pause, program.meanwhile
    );
    for Move {
        path,
        limits,
        ending,
        data,
        ..
    } in &program.moves
    {
        let end = path.end();
        let (word, tolerance) = match ending {
            Ending::Stop => (1, 0.0),
            Ending::Blend { tolerance } if tolerance.is_infinite() => (3, 0.0),
            Ending::Blend { tolerance } => (6, *tolerance),
            Ending::Contour { constrained: true } => (4, 0.0),
            Ending::Contour { constrained: false } => (5, 0.0),
        };
        let (shape, jerks) = match limits.jerk {
            Some(jerk) => ("S-curve", (jerk.acceleration, jerk.deceleration)),
            None => ("Trapezoidal", (100.0, 100.0)),
        };
        let (mnemonic, circle) = match path {
            Path::Line(_) => ("MCLM", String::new()),
            Path::Arc(arc) => {
                let (center, normal) = (arc.center(), arc.normal());
                let direction = u8::from(normal[2] > 0.0);
                ("MCCM", format!(" 1, [{}, {}], {direction},", center[0], center[1]))
            }
        };
        let _ = writeln!(
            text,
            "{mnemonic}(XY, M{data}, 0, [{}, {}],{circle} {}, 0, {}, 0, {}, 0, {shape}, {}, {}, 0, {word}, 0, 0, {tolerance});",
            end[0], end[1], limits.speed, limits.acceleration, limits.deceleration, jerks.0, jerks.1,
        );
    }
    text
}

fn run(seed: u64) -> Result<(), String> {
    let mut random = Random(seed);
    let program = program(&mut random);
    let fail = |why: String| Err(format!("seed {seed}: {why}\n{}", text(&program)));
    let step = Point::new(STEP[0], STEP[1], 0.0);
    let mut planner = Planner::new(program.depth, step).with_period(PERIOD);
    let mut clock = Clock::at(0, PERIOD_NS);
    let (mut sent, mut due, mut stopped) = (0, 0, false);
    let mut rate = 0.0_f64;
    for motion in &program.moves {
        rate = rate.max(motion.limits.acceleration).max(motion.limits.deceleration);
    }
    let mut velocity = Point::zeros();
    while sent < program.moves.len() || planner.active().is_some() {
        while let Some(event) = planner.event(&clock) {
            match event {
                MoveEvent::Reached(_) if stopped => {
                    planner.clear_active();
                }
                MoveEvent::HandOver(at) | MoveEvent::Reached(at) if planner.next().is_some() => {
                    planner.hand_over(at, &clock);
                }
                _ => {
                    planner.clear_active();
                }
            }
        }
        planner.continue_look_ahead(&clock);
        if stopped && planner.active().is_none() {
            return Ok(());
        }
        while !stopped && sent < program.moves.len() && clock.tick >= due && !planner.is_full() {
            let motion = program.moves[sent];
            if planner.active().is_none() {
                planner.start(motion, clock.now(), &clock);
            } else if planner.enqueue(motion, &clock).is_err() {
                break;
            }
            sent += 1;
            due = clock.tick + program.pause;
        }
        let sample = planner.sample(&clock);
        let now = sample.map_or(Point::zeros(), |sample| sample.velocity);
        if !now.iter().all(|part| part.is_finite()) {
            return fail(format!("not finite at tick {}", clock.tick));
        }
        // Two moves are superposed at most; the rest is what the arcs turn.
        let ramps = 2.0 * rate * PERIOD + 0.4;
        for axis in 0..2 {
            let change = (now[axis] - velocity[axis]).abs();
            if change > (1.0 + 1e-6) * STEP[axis] + ramps {
                return fail(format!(
                    "tick {}: axis {axis} changes by {change} units/s, {} is allowed",
                    clock.tick,
                    STEP[axis] + ramps
                ));
            }
        }
        velocity = now;
        if !stopped && clock.tick % 16 == 5 && planner.active().is_some() && random.share() < 0.5 {
            match program.meanwhile {
                Meanwhile::Nothing => {}
                Meanwhile::Overrides => {
                    let share = random.of(&[0.3, 0.7, 1.0, 1.3]);
                    planner.set_rate(share, &clock);
                }
                Meanwhile::Changes => {
                    let own = program.moves[0].limits.jerk.is_some();
                    planner.change_limits(limits(&mut random, own), &clock);
                    rate = rate.max(3000.0);
                }
                Meanwhile::Stop if clock.tick > 150 => {
                    while planner.cancel_pending().is_some() {}
                    let own = program.moves[0].limits.jerk.is_some();
                    planner.stop(&limits(&mut random, own), &clock);
                    rate = rate.max(3000.0);
                    stopped = true;
                }
                Meanwhile::Stop => {}
            }
        }
        clock.tick += 1;
        if clock.tick > LONGEST {
            return fail(format!("not at its end after {LONGEST} ticks"));
        }
    }
    Ok(())
}

#[test]
fn no_corner_of_short_moves_steps_beyond_the_limits_of_the_axes() {
    let failures: Vec<String> = seeds(2000).filter_map(|seed| run(seed).err()).collect();
    assert!(
        failures.is_empty(),
        "{} programs fail; the first ones:\n{}",
        failures.len(),
        failures[..failures.len().min(3)].join("\n")
    );
}

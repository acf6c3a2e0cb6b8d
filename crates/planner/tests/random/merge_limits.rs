//! Merges within the limits of the axes: out of any motion that keeps them, along lines and arcs, with changes on the way.
//!
//! `ARCLINE_CASES` sets how many merges are travelled (300 unless told).

use arcline_contour::AxisLimits;
use arcline_planner::geometry::{Arc, CirclePoint, Dimension, Direction, Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, Ending, InitialMotion, Move, MoveEvent, Parameter, Planner};

use super::{Random, seeds};

const PERIOD_NS: u64 = 250_000;
const PERIOD: f64 = 0.000_25;
const MOST: f64 = 1.0 + 1e-6;

/// A velocity and an acceleration from which every axis can stay within its speed.
fn initial(random: &mut Random, axes: &AxisLimits, kind: u64) -> InitialMotion {
    let mut velocity = Point::zeros();
    let mut acceleration = Point::zeros();
    for axis in 0..2 {
        let (most, rate) = (axes.speed[axis], axes.acceleration[axis]);
        velocity[axis] = random.between(-most, most);
        if !kind.is_multiple_of(3) {
            acceleration[axis] = random.between(-rate, rate);
        }
        if kind.is_multiple_of(5) {
            velocity[axis] *= 0.05;
        }
        let swing = axes.jerk.map_or(0.0, |jerk| {
            acceleration[axis] * acceleration[axis].abs() / (2.0 * jerk[axis])
        });
        let turn = velocity[axis] + swing;
        velocity[axis] -= turn - turn.clamp(-most, most);
        if velocity[axis].abs() > most {
            acceleration[axis] = 0.0;
            velocity[axis] = velocity[axis].clamp(-most, most);
        }
    }
    InitialMotion {
        velocity,
        acceleration,
        before: None,
    }
}

fn path(random: &mut Random, initial: &InitialMotion) -> Path {
    let from = Point::new(3.0, -4.0, 0.5);
    let chord = Point::new(random.between(-60.0, 60.0), random.between(-60.0, 60.0), 0.0);
    match (random.share() * 5.0) as u32 {
        // Straight on: the velocity is kept.
        0 => Path::line(from, from + initial.velocity),
        1 => Path::line(from, from + chord * 0.02),
        2 => {
            let side = Point::new(-chord[1], chord[0], 0.0);
            let center = from + chord * 0.5 + side * random.between(0.1, 0.6);
            let normal = Point::new(0.0, 0.0, 1.0);
            let angle = random.between(0.5, 5.0);
            let (sin, cos) = libm::sincos(angle);
            let radius = from - center;
            let end = center + radius * cos + normal.cross(&radius) * sin;
            let direction = Direction::CounterClockwise;
            let arc = Arc::new(Dimension::Three, from, end, CirclePoint::Center(center), direction);
            Path::Arc(arc.expect("the points are on a circle"))
        }
        3 => Path::line(from, from),
        _ => Path::line(from, from + chord),
    }
}

#[test]
fn no_merge_exceeds_a_limit_of_an_axis() {
    seeds(300).for_each(travel);
}

/// Onto a short move out of a fast one: an override took the share of the speed that the compensation leaves a second time.
#[test]
fn a_merge_that_formerly_took_too_long_is_within_its_time() {
    travel(2_078_000_622);
}

fn travel(seed: u64) {
    let mut random = Random(seed);
    let s_curve = random.share() < 0.7;
    let unlimited = f64::INFINITY;
    let axes = AxisLimits {
        speed: Point::new(300.0, random.between(80.0, 300.0), unlimited),
        acceleration: Point::new(5000.0, random.between(2000.0, 6000.0), unlimited),
        jerk: s_curve.then(|| Point::new(100_000.0, random.between(40_000.0, 120_000.0), unlimited)),
    };
    let initial = initial(&mut random, &axes, seed);
    let rate = random.between(1000.0, 9000.0);
    let jerk = random.between(20_000.0, 200_000.0);
    let limits = Limits {
        speed: random.between(20.0, 400.0),
        acceleration: rate,
        deceleration: random.between(1000.0, 9000.0),
        jerk: s_curve.then_some(Jerk {
            acceleration: jerk,
            deceleration: random.between(20_000.0, 200_000.0),
        }),
    };
    let motion = Move {
        path: path(&mut random, &initial),
        rotation: None,
        corner: f64::INFINITY,
        limits,
        last_speed: limits.speed,
        ending: Ending::Stop,
        parameter: Parameter::TIME,
        data: (),
    };
    let mut clock = Clock::at(0, PERIOD_NS);
    let mut planner = Planner::new(10, Point::zeros());
    let plot = seed % 4;
    if plot == 1 {
        planner.set_rate(random.between(0.2, 2.0), &clock);
    }
    planner.merge_within(motion, initial, &axes, &clock);
    planner.set_rate(if plot == 1 { 1.7 } else { 1.0 }, &clock);
    let first = planner.sample(&clock).expect("it moves");
    assert!(
        (first.velocity - initial.velocity).norm() < 1e-9,
        "seed {seed}: it steps"
    );
    let mut last = first;
    let at = (random.between(0.0, 0.4) / PERIOD) as u64;
    let fail = |tick: u64, what: String| panic!("seed {seed}, tick {tick}: {what}");
    loop {
        match (plot, clock.tick == at) {
            (2, true) => planner.set_rate(random.between(0.0, 2.0), &clock),
            (3, true) => planner.stop(&limits, &clock),
            _ => {}
        }
        if clock.tick == at + 800 {
            planner.set_rate(1.0, &clock);
        }
        clock.tick += 1;
        if let Some(MoveEvent::Reached(_) | MoveEvent::HandOver(_)) = planner.event(&clock) {
            break;
        }
        let now = planner.sample(&clock).expect("it moves");
        for axis in 0..2 {
            let (v, a) = (now.velocity[axis], now.acceleration[axis]);
            if v.abs() > axes.speed[axis] * MOST || a.abs() > axes.acceleration[axis] * MOST {
                fail(clock.tick, format!("axis {axis}: velocity {v}, acceleration {a}"));
            }
            if let Some(jerk) = axes.jerk {
                let change = (a - last.acceleration[axis]) / PERIOD;
                if change.abs() > jerk[axis] * MOST + 1e-3 {
                    fail(clock.tick, format!("axis {axis}: jerk {change} of {}", jerk[axis]));
                }
            }
        }
        let moved = now.position - last.position - (now.velocity + last.velocity) * (0.5 * PERIOD);
        if moved.norm() > 1e4 * PERIOD * PERIOD {
            fail(clock.tick, format!("a step by {}", moved.norm()));
        }
        last = now;
        if clock.tick > 100_000 {
            fail(clock.tick, "it does not end".to_owned());
        }
    }
    if plot != 3 {
        let end = planner.sample(&clock).expect("it stands").position;
        let off = (end - motion.path.end()).norm();
        assert!(off < 1e-9, "seed {seed}: off the end by {off}");
    }
}

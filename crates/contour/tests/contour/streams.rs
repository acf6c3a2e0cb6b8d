//! Streams as CAM systems post them, through a queue of 1,000 moves: dense chords, arcs between lines, sudden corners, islands of tiny
//! moves between long ones. Within tolerance and limits, without a step at any splice, and never at rest before the end.

use crate::common::{PROFILES, Profile, arc_through, check_peaks, distance, profile};
use arcline_contour::{AxisLimits, ContourMove, ExtensionRequest, Path, Point, Trajectory, begin, extend};
use proptest::prelude::*;

const QUEUE: usize = 1000;
/// Seconds that are left when an extension is asked for, at most, and that it may take.
const AHEAD: f64 = 0.5;
const LEAD: f64 = 0.05;

/// A part of a toolpath.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// A number of chords of a curve that was measured: their length (mm), the mean change of direction at each (rad) and the spread about it.
    Rough(usize, f64, f64, f64),
    /// A number of chords of a curve: their length (mm), the change of direction at each (rad) and its growth from chord to chord.
    Chords(usize, f64, f64, f64),
    /// A line.
    Line(f64),
    /// An arc through a point beside the middle, as a share of the chord.
    Arc(f64, f64),
    /// A corner.
    Corner(f64),
}

fn part() -> impl Strategy<Value = Part> {
    prop_oneof![
        4 => (40..250_usize, 0.05..0.5_f64, -0.03..0.03_f64, -3e-4..3e-4_f64).prop_map(|(n, l, t, c)| Part::Chords(n, l, t, c)),
        1 => (5..40_usize, 0.01..0.1_f64, -0.2..0.2_f64, -1e-2..1e-2_f64).prop_map(|(n, l, t, c)| Part::Chords(n, l, t, c)),
        1 => (30..150_usize, 0.1..0.5_f64, -0.02..0.02_f64, 0.0..0.06_f64).prop_map(|(n, l, t, s)| Part::Rough(n, l, t, s)),
        1 => (1.0..30.0_f64).prop_map(Part::Line),
        1 => (2.0..20.0_f64, -0.4..0.4_f64).prop_map(|(l, b)| Part::Arc(l, b)),
        1 => (-2.8..2.8_f64).prop_map(Part::Corner),
    ]
}

/// A course of parts, rounded to a thousandth as CAM systems do.
fn course(parts: &[Part], speed: f64, tolerance: f64, profile: Profile) -> Vec<ContourMove> {
    let rounded = |p: Point| p.map(|c| (c * 1000.0).round() / 1000.0);
    let (mut from, mut heading, mut height) = (Point::new(1.0, -2.0, 0.5), 0.3_f64, 0.0_f64);
    let mut moves = Vec::new();
    let mut go = |from: &mut Point, heading: f64, height: f64, length: f64, bulge: f64| {
        let ahead = Point::new(libm::cos(heading), libm::sin(heading), 0.2 * libm::sin(height)) * length;
        let to = rounded(*from + ahead);
        if (to - *from).norm() < 5e-4 {
            return;
        }
        let via = (*from + to) * 0.5 + Point::new(-(to - *from).y, (to - *from).x, 0.0) * bulge;
        let arc = arc_through(*from, via, to).filter(|_| bulge.abs() > 0.05);
        moves.push(ContourMove {
            speed,
            ..profile.contour_move(arc.unwrap_or_else(|| Path::line(*from, to)), tolerance)
        });
        *from = to;
    };
    for &part in parts {
        match part {
            Part::Chords(count, length, turn, change) => {
                for k in 0..count {
                    heading += turn + change * (k as f64 - 0.5 * count as f64);
                    height += 0.02;
                    go(&mut from, heading, height, length, 0.0);
                }
            }
            Part::Rough(count, length, turn, spread) => {
                for k in 0..count {
                    let noise = 43_758.547 * libm::sin(12.9898 * k as f64);
                    heading += turn + spread * (2.0 * (noise - noise.floor()) - 1.0);
                    go(&mut from, heading, height, length, 0.0);
                }
            }
            Part::Line(length) => go(&mut from, heading, height, length, 0.0),
            Part::Arc(length, bulge) => go(&mut from, heading, height, length, bulge),
            Part::Corner(turn) => heading += turn,
        }
    }
    moves
}

/// Distance from the nearest of the moves about one.
fn off(moves: &[ContourMove], on: usize, q: &Point) -> f64 {
    let near = &moves[on.saturating_sub(20)..(on + 21).min(moves.len())];
    near.iter()
        .map(|one| distance(&one.path, q).0)
        .fold(f64::INFINITY, f64::min)
}

/// One stretch that is travelled: `passed` moves lie before the first of the trajectory.
fn check(
    trajectory: &Trajectory,
    (from, to): (f64, f64),
    (moves, passed): (&[ContourMove], usize),
    speed: f64,
) -> Result<(), TestCaseError> {
    let count = ((to - from) / 2.5e-4).ceil().max(1.0) as usize;
    for k in 0..count {
        let t = from + (to - from) * (k as f64 + 0.37) / count as f64;
        let state = trajectory.at(t);
        prop_assert!(state.velocity.norm() <= speed * (1.0 + 1e-9));
        let on = passed + trajectory.move_at(t);
        let tolerance = moves[on].tolerance;
        let off = off(moves, on, &state.position);
        prop_assert!(off <= tolerance * (1.0 + 1e-4), "off by {off} at {t}, on move {on}");
    }
    Ok(())
}

fn check_splice(old: &Trajectory, new: &Trajectory, now: f64, limits: &AxisLimits) -> Result<(), TestCaseError> {
    check_peaks(&new.peaks(), limits)?;
    let at = new.splice();
    for k in 0..=10 {
        let t = now + (at - now) * f64::from(k) / 10.0 * (1.0 - 1e-12);
        prop_assert_eq!(new.at(t), old.at(t));
    }
    let (left, right) = (new.at(at - 1e-9), new.at(at));
    prop_assert!((left.position - right.position).norm() < 1e-6);
    prop_assert!((left.velocity - right.velocity).norm() < 1e-4);
    if limits.jerk.is_some() {
        prop_assert!((left.acceleration - right.acceleration).norm() < 1e-2);
    }
    Ok(())
}

/// Travels a stream; returns the rests on the way and the seconds that it took.
fn travel(moves: &[ContourMove], limits: &AxisLimits, speed: f64) -> Result<(usize, f64), TestCaseError> {
    let mut running = begin(&moves[..QUEUE.min(moves.len())], limits);
    check_peaks(&running.peaks(), limits)?;
    let (mut passed, mut now, mut before, mut rests, mut retry) = (0, 0.0, 0.0, 0, 0.0_f64);
    loop {
        let known = passed + running.moves();
        if known == moves.len() {
            check(&running, (now, running.duration()), (moves, passed), speed)?;
            prop_assert_eq!(
                running.at(running.duration()).position,
                moves[moves.len() - 1].path.end()
            );
            return Ok((rests, before + running.duration()));
        }
        let ask = (running.duration() - AHEAD).max(now).max(retry).min(running.duration());
        check(&running, (now, ask), (moves, passed), speed)?;
        let on = running.move_at(ask);
        passed += on;
        now = ask;
        let queue = &moves[passed..(passed + QUEUE).min(moves.len())];
        let request = ExtensionRequest {
            running: &running,
            passed: on,
            moves: queue,
            limits,
            now,
            earliest: now + LEAD,
        };
        if let Some(longer) = extend(&request) {
            check_splice(&running, &longer, now, limits)?;
            running = longer;
            retry = 0.0;
        } else if running.duration() - now > 0.1 {
            retry = now + 0.3 * (running.duration() - now);
            passed -= on;
        } else {
            passed -= on;
            check(&running, (now, running.duration()), (moves, passed), speed)?;
            rests += 1;
            before += running.duration();
            passed = known;
            running = begin(&moves[passed..(passed + QUEUE).min(moves.len())], limits);
            (now, retry) = (0.0, 0.0);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.div_ceil(32), ..ProptestConfig::default() })]

    #[test]
    fn streams_never_rest(
        parts in prop::collection::vec(part(), 3..16),
        speed in 50.0..400.0_f64,
        tolerance in 0.005..0.02_f64,
        profile in profile(),
    ) {
        let moves = course(&parts, speed, tolerance, profile);
        prop_assume!(moves.len() > 30);
        let (rests, _) = travel(&moves, &profile.limits(), speed)?;
        prop_assert_eq!(rests, 0);
    }
}

/// The curve is farthest from its path where it passes a joint, between the points that are measured elsewhere: it was outside there by up to a tenth of
/// the tolerance.
#[test]
fn a_curve_is_inside_where_it_passes_a_joint() {
    let found = [
        (0.3, 0.03, 0.01, 0.005),
        (0.5, 0.03, 0.01, 0.005),
        (0.5, 0.015, 0.03, 0.01),
        (0.8, 0.03, 0.03, 0.01),
        (0.5, 0.015, 0.065, 0.01),
    ];
    for (chord, turn, spread, tolerance) in found {
        for profile in PROFILES {
            let moves = course(&[Part::Rough(400, chord, turn, spread)], 300.0, tolerance, profile);
            let travelled = travel(&moves, &profile.limits(), 300.0);
            let (rests, _) = travelled.expect("it is inside");
            assert_eq!(rests, 0, "{profile:?}, chords of {chord} at {tolerance}");
        }
    }
}

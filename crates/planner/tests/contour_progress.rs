//! The reports of a planned contour at every tick: the distance covered on its active move, the phase of its speed, and its roundings of corners.

use std::sync::Arc;

use arcline_contour::{AxisLimits, ContourMove};
use arcline_planner::geometry::{Path, Point};
use arcline_planner::profile::{Jerk, Limits, Phase};
use arcline_planner::{Clock, ContourEvent, ContourQueue, Ending, InstalledPlan, Move, Parameter};

const PERIOD_NS: u64 = 1_000_000;

fn limits(s_curve: bool) -> (Limits, AxisLimits) {
    let jerk = 90_000.0;
    (
        Limits {
            speed: 100.0,
            acceleration: 2000.0,
            deceleration: 2000.0,
            jerk: s_curve.then_some(Jerk {
                acceleration: jerk,
                deceleration: jerk,
            }),
        },
        AxisLimits {
            speed: Point::repeat(300.0),
            acceleration: Point::repeat(3000.0),
            jerk: s_curve.then(|| Point::repeat(100_000.0)),
        },
    )
}

/// The way of a motion: moves of which the later ones come while it is travelled.
fn moves(s_curve: bool) -> Vec<Move<usize>> {
    let corners = [
        [0.0, 0.0],
        [60.0, 0.0],
        [60.0, 40.0],
        [61.0, 41.0],
        [20.0, 70.0],
        [-30.0, 70.0],
    ];
    let corners = corners.map(|[x, y]| Point::new(x, y, 0.0));
    let ends = corners.windows(2).enumerate();
    ends.map(|(number, ends)| Move {
        path: Path::line(ends[0], ends[1]),
        rotation: None,
        corner: f64::INFINITY,
        limits: limits(s_curve).0,
        last_speed: limits(s_curve).0.speed,
        ending: if number + 2 == corners.len() {
            Ending::Stop
        } else {
            Ending::Blend { tolerance: 0.5 }
        },
        parameter: Parameter::TIME,
        data: number,
    })
    .collect()
}

#[test]
fn progress_status_and_transitions_of_a_contour_at_every_tick() {
    for s_curve in [false, true] {
        for known in [5, 3] {
            let mut queue = ContourQueue::new(20);
            let mut clock = Clock::at(0, PERIOD_NS);
            let moves = moves(s_curve);
            for one in &moves[..known] {
                queue.push(*one, &clock).expect("there is room");
            }
            let (mut done, mut extended) = (0, 0);
            let (mut last, mut length) = (0.0_f64, 0.0_f64);
            let (mut before, mut summed) = (None::<Point>, 0.0);
            let mut transitions = Vec::new();
            for tick in 1..20_000 {
                clock = Clock::at(tick, PERIOD_NS);
                if tick == 300 {
                    for one in &moves[known..] {
                        queue.push(*one, &clock).expect("there is room");
                    }
                }
                let mut asked: Vec<ContourMove> = Vec::new();
                if let Some(batch) = queue.batch(&clock, &clock, |one| asked.push(one)) {
                    let axes = limits(s_curve).1;
                    let plan = match &batch.extends {
                        None => Some(arcline_contour::plan(&asked, &axes)),
                        Some(extension) => extension.plan(&asked, &axes),
                    };
                    if let Ok(InstalledPlan::Extended(_)) = queue.install(batch.generation, plan.map(Arc::new), &clock)
                    {
                        extended += 1;
                    }
                }
                let mut ended = false;
                while let Some(event) = queue.event(&clock) {
                    assert!(
                        (last - length).abs() < 0.2 + 0.02 * length,
                        "{last} of {length} at the end"
                    );
                    last = 0.0;
                    done += 1;
                    if event == ContourEvent::End {
                        ended = true;
                        break;
                    }
                    queue.pass(&clock);
                }
                if ended {
                    break;
                }
                let Some(sample) = queue.sample(&clock) else { continue };
                length = queue.length();
                let gone = sample.along.position;
                assert!(
                    gone >= last && gone <= length + 1e-9,
                    "{gone} of {length} behind {last}"
                );
                if let Some(before) = before {
                    summed += (sample.position - before).norm();
                }
                before = Some(sample.position);
                last = gone;
                assert!((sample.velocity.norm() - sample.along.velocity).abs() < 1e-9);
                // Steady speed shows as such.
                if (sample.along.velocity - 100.0).abs() < 1e-3 && sample.along.acceleration.abs() < 20.0 {
                    assert_eq!(sample.phase, Phase::Steady, "at {tick}");
                }
                transitions.push(queue.in_transition(&clock));
            }
            assert_eq!(done, moves.len());
            assert_eq!(extended, usize::from(known < moves.len()));
            // Beginnings of transitions: two corners and, one tick or none between them, the two of the short move.
            let begins = transitions.windows(2).filter(|pair| !pair[0] && pair[1]).count();
            assert!((3..=4).contains(&begins), "{begins} transitions");
            assert!(!transitions[0] && !transitions[transitions.len() - 1]);
            let programmed: f64 = moves.iter().map(|one| one.path.length()).sum();
            assert!((summed - programmed).abs() < 5.0, "{summed} of {programmed}");
        }
    }
}

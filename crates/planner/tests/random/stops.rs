//! A stop that is looked at before it begins is the stop that then takes place, whatever waits behind the active move and
//! however the active move was changed; one that overshoots its end among them.

use arcline_planner::geometry::{Line, Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, Ending, Move, MoveEvent, Parameter, Planner};

use super::{Random, seeds};

/// Change of the velocity of an axis that a corner may make, units/s.
const CORNER_STEP: f64 = 5.0;
const ENDINGS: [Ending; 5] = [
    Ending::Stop,
    Ending::Contour { constrained: true },
    Ending::Blend {
        tolerance: f64::INFINITY,
    },
    Ending::Blend { tolerance: 0.7 },
    Ending::Blend { tolerance: 5.0 },
];

fn limits(random: &mut Random) -> Limits {
    let jerk = random.of(&[200.0, 2_000.0, 20_000.0]);
    Limits {
        speed: random.between(10.0, 120.0),
        acceleration: random.between(200.0, 2000.0),
        deceleration: random.between(200.0, 2000.0),
        jerk: (random.share() < 0.7).then(|| Jerk {
            acceleration: jerk,
            deceleration: jerk * random.between(0.5, 2.0),
        }),
    }
}

fn queue(random: &mut Random) -> Vec<Move<usize>> {
    let (mut from, mut direction) = (Point::zeros(), Point::x());
    (0..4)
        .map(|data| {
            if random.share() < 0.5 {
                let (sin, cos) = random.between(-1.5, 1.5).sin_cos();
                direction = Point::new(
                    cos * direction.x - sin * direction.y,
                    sin * direction.x + cos * direction.y,
                    0.0,
                );
            }
            let to = from + direction * random.between(0.5, 20.0);
            let path = Path::Line(Line::new(from, to));
            from = to;
            Move {
                path,
                rotation: None,
                corner: f64::INFINITY,
                limits: limits(random),
                last_speed: 1.0,
                ending: random.of(&ENDINGS),
                parameter: Parameter::TIME,
                data,
            }
        })
        .collect()
}

/// Runs one queue with a change of the active move up to the instant of a stop; `None`: it is over before.
fn until_the_stop(random: &mut Random) -> Option<(Planner<usize>, Clock)> {
    let moves = queue(random);
    let mut planner = Planner::new(moves.len(), Point::repeat(CORNER_STEP));
    let mut clock = Clock::at(0, 1_000_000);
    planner.start(moves[0], clock.now(), &clock);
    for motion in &moves[1..] {
        planner.enqueue(*motion, &clock).expect("there is room for all");
    }
    let [change, stop] = [0.3, 0.8].map(|most| (1000.0 * random.between(0.0, most)) as u64);
    for _ in 0..stop {
        if clock.tick == change {
            planner.change_limits(limits(random), &clock);
        }
        clock.tick += 1;
        for _ in 0..8 {
            let Some(MoveEvent::HandOver(at) | MoveEvent::Reached(at)) = planner.event(&clock) else {
                break;
            };
            planner.hand_over(at, &clock)?;
        }
        planner.continue_look_ahead(&clock);
    }
    Some((planner, clock))
}

fn stop_is_as_predicted(seed: u64) {
    let mut random = Random(seed);
    let Some((mut planner, clock)) = until_the_stop(&mut random) else {
        return;
    };
    let rates = limits(&mut random);
    let Some(stopping) = planner.stopping(&rates, &clock) else {
        return;
    };
    let instants: Vec<Clock> = (0..=40)
        .map(|step| clock.later(stopping.duration() * f64::from(step) / 40.0))
        .collect();
    let predicted: Vec<_> = instants
        .iter()
        .map(|instant| planner.sample_stopping(&stopping, instant))
        .collect();
    while planner.cancel_pending().is_some() {}
    planner.stop_soonest(&rates, &clock);
    for (instant, predicted) in instants.iter().zip(predicted) {
        let sample = planner
            .sample(instant)
            .expect("the active move is stopped, and not over");
        let off = (sample.position - predicted.position).norm();
        assert!(
            off < 1e-9,
            "seed {seed}: {} s after the stop at {}, not {}",
            clock.now().elapsed(instant),
            sample.position,
            predicted.position
        );
    }
}

#[test]
fn stops_are_as_predicted() {
    seeds(20_000).for_each(stop_is_as_predicted);
}

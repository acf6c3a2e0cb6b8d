//! A queue of many short moves is seen to its end.
#![allow(missing_docs)]

use arcline_planner::geometry::{Line, Path, Point};
use arcline_planner::profile::{Jerk, Limits, stop_distance};
use arcline_planner::{Clock, Ending, Move, Parameter, Passage, Planner};

const PIECE: f64 = 0.1;
const COUNT: usize = 1000;
const LIMITS: Limits = Limits {
    speed: 200.0,
    acceleration: 1000.0,
    deceleration: 1000.0,
    jerk: Some(Jerk {
        acceleration: 20_000.0,
        deceleration: 20_000.0,
    }),
};

/// Pieces along X. `limits` of each of them.
fn queue(limits: impl Fn(usize) -> Limits) -> (Planner<usize>, Clock) {
    let clock = Clock::at(0, 1_000_000);
    let mut planner = Planner::new(COUNT, Point::zeros());
    planner.set_rate(0.0, &clock);
    for data in 0..COUNT {
        let at = |place: usize| Point::from([PIECE * place as f64, 0.0, 0.0]);
        let motion = Move {
            path: Path::Line(Line::new(at(data), at(data + 1))),
            turn: None,
            corner: f64::INFINITY,
            limits: limits(data),
            ending: Ending::Contour { constrained: true },
            parameter: Parameter::TIME,
            data,
        };
        if data == 0 {
            planner.start(motion, clock.now(), &clock);
        } else {
            planner.enqueue(motion, &clock).expect("there is room");
        }
    }
    planner.set_rate(1.0, &clock);
    (planner, clock)
}

/// Travels everything; the highest speed and the ticks it took.
fn travel(
    planner: &mut Planner<usize>,
    mut clock: Clock,
    mut each: impl FnMut(&mut Planner<usize>, &Clock),
) -> (f64, u64) {
    let (mut top, mut last) = (0.0_f64, 0.0);
    while planner.active().is_some() {
        clock.tick += 1;
        assert!(clock.tick < 100_000, "it does not end");
        for _ in 0..64 {
            let at = match planner.passage(&clock) {
                None => break,
                Some(Passage::HandOver(at) | Passage::Reached(at)) => at,
            };
            if planner.hand_over(at, &clock).is_none() {
                planner.clear_active();
                break;
            }
        }
        planner.look_on(&clock);
        each(planner, &clock);
        if let Some(sample) = planner.sample(&clock) {
            assert!(sample.position[0] >= last - 1e-9, "it turns back at {last}");
            last = sample.position[0];
            top = top.max(sample.along.velocity);
        }
    }
    assert!((last - PIECE * COUNT as f64).abs() < 0.2, "it ends at {last}");
    (top, clock.tick)
}

#[test]
fn a_thousand_short_pieces_reach_the_programmed_speed() {
    let way = stop_distance(LIMITS.speed, &LIMITS);
    assert!(way > 200.0 * PIECE, "{way}");
    let (mut planner, clock) = queue(|_| LIMITS);
    let (top, ticks) = travel(&mut planner, clock, |_, _| {});
    assert!((top - LIMITS.speed).abs() < 1e-9, "{top}");
    // As one move over the whole length: v/a + a/j for the ramps, L/v for the rest.
    let ramps = LIMITS.speed / LIMITS.acceleration + 1000.0 / 20_000.0;
    let expected = (PIECE * COUNT as f64 / LIMITS.speed + ramps) / clock.period();
    assert!((ticks as f64 - expected).abs() <= 1.5, "{ticks} ticks, not {expected}");
}

#[test]
fn other_speeds_within_a_run_are_kept_and_others_reached() {
    // A slower stretch in the middle: its speed is not exceeded in it, and met when it begins.
    let slow = |data: usize| (500..700).contains(&data);
    let limits = |data| Limits {
        speed: if slow(data) { 50.0 } else { 200.0 },
        ..LIMITS
    };
    let (mut planner, clock) = queue(limits);
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    travel(&mut planner, clock, |planner, clock| {
        let (Some(sample), Some(active)) = (planner.sample(clock), planner.active()) else {
            return;
        };
        // Active from where braking begins; the slow stretch itself begins at 50.
        if slow(active.motion.data) && (50.0..70.0).contains(&sample.position[0]) {
            least = least.min(sample.along.velocity);
            most = most.max(sample.along.velocity);
        }
    });
    assert!(
        (least - 50.0).abs() < 1e-6 && (most - 50.0).abs() < 1e-6,
        "{least} {most}"
    );
}

#[test]
fn rates_that_change_from_piece_to_piece_are_seen_to_the_end_of_the_queue() {
    // The acceleration is 0 between any two pieces, so that all of them bind; still, the speed grows over many.
    let limits = |data: usize| Limits {
        deceleration: if data.is_multiple_of(2) { 1000.0 } else { 1100.0 },
        jerk: None,
        ..LIMITS
    };
    let (mut planner, clock) = queue(limits);
    let (top, _) = travel(&mut planner, clock, |_, _| {});
    // v^2 = 2 a L over half of the way: about 316 units/s, so the speed limit is reached.
    assert!((top - LIMITS.speed).abs() < 1e-9, "{top}");
}

#[test]
fn changes_anywhere_in_it_stay_on_the_path() {
    let limits = |data: usize| Limits {
        speed: if data.is_multiple_of(3) { 150.0 } else { 200.0 },
        deceleration: if data.is_multiple_of(2) { 1000.0 } else { 1100.0 },
        ..LIMITS
    };
    let (mut planner, clock) = queue(limits);
    let mut rate = 1.0;
    travel(&mut planner, clock, |planner, clock| {
        if clock.tick.is_multiple_of(37) && clock.tick < 5000 {
            rate = if rate == 1.0 { 0.3 } else { 1.0 };
            planner.set_rate(rate, clock);
        } else if clock.tick == 5000 {
            planner.set_rate(2.0, clock);
        }
    });
}

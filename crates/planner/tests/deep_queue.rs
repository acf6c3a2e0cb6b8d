//! A queue of many short moves is seen to its end.
#![allow(missing_docs)]

use arcline_planner::geometry::{Line, Path, Point};
use arcline_planner::profile::{Jerk, Limits, stop_distance};
use arcline_planner::{Clock, Ending, Move, MoveEvent, Parameter, Planner};

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
            rotation: None,
            corner: f64::INFINITY,
            limits: limits(data),
            last_speed: limits(data).speed,
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

/// A change of the limits of pending moves.
type Change = fn(&mut Limits);

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
            let at = match planner.event(&clock) {
                None => break,
                Some(MoveEvent::HandOver(at) | MoveEvent::Reached(at)) => at,
            };
            if planner.hand_over(at, &clock).is_none() {
                planner.clear_active();
                break;
            }
        }
        planner.continue_look_ahead(&clock);
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
    let distance = stop_distance(LIMITS.speed, &LIMITS);
    assert!(distance > 200.0 * PIECE, "{distance}");
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

/// Travels 100 mm with changes of all moves at some ticks. `each` sees the speed of every tick and the limits of the active move.
fn change_all(at: &[(u64, Change)], mut each: impl FnMut(u64, f64, &Move<usize>)) -> u64 {
    let (mut planner, mut clock) = queue(|_| LIMITS);
    while planner.active().is_some() {
        clock.tick += 1;
        assert!(clock.tick < 100_000, "it does not end");
        for _ in 0..64 {
            let at = match planner.event(&clock) {
                None => break,
                Some(MoveEvent::HandOver(at) | MoveEvent::Reached(at)) => at,
            };
            if planner.hand_over(at, &clock).is_none() {
                planner.clear_active();
                break;
            }
        }
        planner.continue_look_ahead(&clock);
        for (_, change) in at.iter().filter(|(tick, _)| *tick == clock.tick) {
            let mut limits = planner.active().expect("it is under way").motion.limits;
            change(&mut limits);
            planner.change_pending(&limits, &clock, |waiting| change(&mut waiting.limits));
            planner.change_limits(limits, &clock);
        }
        if let (Some(sample), Some(active)) = (planner.sample(&clock), planner.active()) {
            each(clock.tick, sample.along.velocity, &active.motion);
        }
    }
    clock.tick
}

#[test]
fn a_change_of_a_thousand_moves_looks_as_if_all_were_looked_at_at_once() {
    let slower: Change = |limits| limits.speed = 150.0;
    // From 200 to 150 within 25 mm, and no slower than that until the end comes near.
    let (mut least, mut last) = (f64::INFINITY, 200.0_f64);
    change_all(&[(400, slower)], |tick, speed, motion| {
        if tick >= 400 {
            assert_eq!(motion.limits.speed, 150.0, "{tick}");
        }
        if (400..580).contains(&tick) {
            assert!(speed <= last + 1e-9, "{speed} after {last} at {tick}");
            (least, last) = (least.min(speed), speed);
        }
    });
    assert!((least - 150.0).abs() < 1e-9, "{least}");
}

#[test]
fn changes_that_follow_each_other_within_a_look_ahead_all_count() {
    let harder: Change = |limits| limits.deceleration *= 2.0;
    let slower: Change = |limits| limits.speed -= 50.0;
    // Each in the middle of the one before it.
    let at = [(300, harder), (302, slower), (303, harder), (309, slower)];
    let mut seen = 0;
    change_all(&at, |tick, speed, motion| {
        if tick >= 309 {
            let expected = (100.0, 4000.0);
            assert_eq!((motion.limits.speed, motion.limits.deceleration), expected, "{tick}");
            seen += usize::from((speed - 100.0).abs() < 1e-9);
        }
    });
    assert!(seen > 300, "{seen} ticks at the new speed");
}

#[test]
fn a_pause_of_a_thousand_moves_takes_effect_at_once_and_is_ended_by_another_change() {
    let pause: Change = |limits| limits.speed = 0.0;
    let resume: Change = |limits| limits.speed = 120.0;
    let mut paused = 0;
    let ticks = change_all(&[(350, pause), (900, resume)], |tick, speed, _| {
        // From 200 at 1000 and 20,000: 250 ms.
        if (605..900).contains(&tick) {
            assert_eq!(speed, 0.0, "{tick}");
            paused += 1;
        }
    });
    assert!(paused > 290 && ticks > 1300, "{paused} {ticks}");
}

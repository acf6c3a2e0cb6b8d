//! The bounds on the speed of a change and of a merge whose jerk removes a present acceleration too slowly
//! (spec/coordinated-instructions.md §5.4, §6.3): one rule for both.

use arcline_planner::geometry::{Path, Point};
use arcline_planner::profile::{Jerk, Limits};
use arcline_planner::{Clock, Ending, InitialMotion, Move, Parameter, Planner};

const NEARLY: f64 = 1.0 + 1e-9;

fn limits(speed: f64, jerk: f64) -> Limits {
    Limits {
        speed,
        acceleration: 1000.0,
        deceleration: 1000.0,
        jerk: Some(Jerk {
            acceleration: jerk,
            deceleration: jerk,
        }),
    }
}

fn straight(limits: Limits) -> Move<()> {
    Move {
        path: Path::line(Point::zeros(), Point::new(1000.0, 0.0, 0.0)),
        rotation: None,
        corner: f64::INFINITY,
        limits,
        last_speed: limits.speed,
        ending: Ending::Stop,
        parameter: Parameter::TIME,
        data: (),
    }
}

fn top(mut clock: Clock, planner: &Planner<()>) -> f64 {
    let mut top = 0.0_f64;
    for _ in 0..2000 {
        clock.tick += 1;
        top = top.max(planner.sample(&clock).expect("it moves").velocity.norm());
    }
    top
}

/// 25 units/s and 1000 units/s² are present; the figures of the pages are 25 + 1000² / 2j.
#[test]
fn an_override_below_1_does_not_lower_the_ceiling() {
    #[rustfmt::skip]
    let rows = [
        ("a change: the figures of the pages", false, 0.5, 5000.0, 125.0),
        ("a change: 1.5 times the programmed speed", false, 0.5, 3000.0, 150.0),
        ("a change, nearly held", false, 0.05, 3000.0, 150.0),
        ("a change: an override above 1 raises the ceiling", false, 1.2, 2000.0, 180.0),
        ("a merge: the programmed speed", true, 0.5, 5000.0, 100.0),
        ("a merge, nearly held", true, 0.05, 5000.0, 100.0),
        ("a merge: an override above 1 raises the ceiling", true, 1.2, 5000.0, 120.0),
    ];
    for (why, merges, rate, jerk, expected) in rows {
        let mut clock = Clock::at(0, 1_000_000);
        let mut planner = Planner::new(10, Point::zeros());
        planner.start(straight(limits(100.0, 20_000.0)), clock.now(), &clock);
        clock.tick = 50;
        let now = planner.sample(&clock).expect("it moves");
        assert!((now.velocity[0] - 25.0).abs() < 1e-9 && (now.acceleration[0] - 1000.0).abs() < 1e-6);
        planner.set_rate(rate, &clock);
        if merges {
            let initial = InitialMotion {
                velocity: now.velocity,
                acceleration: now.acceleration,
                before: planner.before(),
            };
            planner.merge(straight(limits(100.0, jerk)), initial, &clock);
        } else {
            planner.change_limits(limits(100.0, jerk), &clock);
        }
        let top = top(clock, &planner);
        assert!(
            top <= expected * NEARLY && top > 0.99 * expected,
            "{why}: {top}, not {expected}"
        );
    }
}

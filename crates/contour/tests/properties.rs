//! Properties of plans on random courses: within the tolerance and all limits, exact at the end,
//! never slower than stopping at every corner.

use arcline_contour::{AxisLimits, ContourMove, Deviation, Path, Point, Trajectory, plan};
use arcline_geometry::{Arc, CirclePoint, Dimension, Direction};
use proptest::prelude::*;

const SPEED: f64 = 200.0;

fn limits(jerk: bool) -> AxisLimits {
    AxisLimits {
        speed: Point::new(300.0, 150.0, 200.0),
        acceleration: Point::new(5000.0, 3000.0, 4000.0),
        jerk: jerk.then(|| Point::new(100_000.0, 60_000.0, 80_000.0)),
    }
}

fn contour_move(path: Path, tolerance: f64, jerk: bool) -> ContourMove {
    ContourMove {
        path,
        speed: SPEED,
        acceleration: 4000.0,
        deceleration: 3500.0,
        jerk: jerk.then_some(90_000.0),
        tolerance,
        deviation: Deviation::Corners,
    }
}

/// A polyline or, where `bulge` is not small, arcs through a point beside the chord.
fn course(steps: &[(f64, f64, f64, f64)], tolerance: f64, jerk: bool) -> Vec<ContourMove> {
    let mut from = Point::new(1.0, -2.0, 0.5);
    let mut moves = Vec::new();
    for &(x, y, z, bulge) in steps {
        let to = from + Point::new(x, y, z);
        let side = (to - from).cross(&Point::new(0.3, -0.2, 1.0)) * (0.5 * bulge);
        let arc = Arc::new(
            Dimension::Three,
            from,
            to,
            CirclePoint::Via((from + to) * 0.5 + side),
            Direction::from_word(0).expect("0 is a direction"),
        );
        let path = match arc {
            Ok(arc) if bulge.abs() > 0.2 => Path::Arc(arc),
            _ => Path::line(from, to),
        };
        moves.push(contour_move(path, tolerance, jerk));
        from = to;
    }
    moves
}

fn distance(path: &Path, q: &Point) -> f64 {
    let count = 400;
    let length = path.length();
    let step = length / f64::from(count);
    let mut best = (f64::INFINITY, 0.0);
    for k in 0..=count {
        let s = step * f64::from(k);
        let d = (path.at(s).position - q).norm();
        if d < best.0 {
            best = (d, s);
        }
    }
    let (mut low, mut high) = ((best.1 - step).max(0.0), (best.1 + step).min(length));
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if (path.at(a).position - q).norm() < (path.at(b).position - q).norm() {
            high = b;
        } else {
            low = a;
        }
    }
    (path.at(0.5 * (low + high)).position - q).norm().min(best.0)
}

fn check(moves: &[ContourMove], jerk: bool) -> Result<(), TestCaseError> {
    let limits = limits(jerk);
    let trajectory = plan(moves, &limits);
    let end = moves[moves.len() - 1].path.end();
    let last = trajectory.at(trajectory.duration());
    prop_assert_eq!(last.position, end);
    prop_assert_eq!(trajectory.at(trajectory.duration() + 1.0).position, end);
    prop_assert_eq!(last.velocity, Point::zeros());
    prop_assert_eq!(trajectory.at(0.0).position, moves[0].path.start());
    let peaks = trajectory.peaks();
    for axis in 0..3 {
        prop_assert!(peaks.velocity[axis] <= limits.speed[axis] * (1.0 + 1e-9), "{peaks:?}");
        prop_assert!(
            peaks.acceleration[axis] <= limits.acceleration[axis] * (1.0 + 1e-9),
            "{peaks:?}"
        );
        if let Some(most) = limits.jerk {
            prop_assert!(peaks.jerk[axis] <= most[axis] * (1.0 + 1e-9), "{peaks:?}");
        }
    }
    let count = 1500;
    let mut before = 0;
    for k in 0..=count {
        let t = trajectory.duration() * f64::from(k) / f64::from(count);
        let state = trajectory.at(t);
        prop_assert!(state.velocity.norm() <= SPEED * (1.0 + 1e-9));
        let off = moves
            .iter()
            .map(|m| distance(&m.path, &state.position))
            .fold(f64::INFINITY, f64::min);
        prop_assert!(off <= moves[0].tolerance * 1.001 + 2e-3, "off by {off} at {t}");
        let now = trajectory.move_at(t);
        prop_assert!(now >= before);
        before = now;
    }
    prop_assert_eq!(trajectory.moves(), moves.len());
    let stops: f64 = moves
        .iter()
        .map(|one| plan(core::slice::from_ref(one), &limits).duration())
        .sum();
    prop_assert!(
        trajectory.duration() <= stops * 1.005 + 1e-9,
        "{} s, with stops {stops} s",
        trajectory.duration()
    );
    Ok(())
}

fn step() -> impl Strategy<Value = (f64, f64, f64, f64)> {
    (-20.0..20.0_f64, -20.0..20.0_f64, -5.0..5.0_f64, -1.0..1.0_f64)
}

fn flat() -> impl Strategy<Value = (f64, f64, f64, f64)> {
    (0.2..4.0_f64, -3.0..3.0_f64).prop_map(|(x, y)| (x, y, 0.0, 0.0))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn lines_and_arcs_in_space(steps in prop::collection::vec(step(), 1..6), tolerance in 0.01..0.5_f64, jerk in any::<bool>()) {
        check(&course(&steps, tolerance, jerk), jerk)?;
    }

    #[test]
    fn polylines_in_a_plane(steps in prop::collection::vec(flat(), 2..20), tolerance in 0.01..0.3_f64, jerk in any::<bool>()) {
        check(&course(&steps, tolerance, jerk), jerk)?;
    }
}

#[test]
fn nothing_to_do_is_a_rest() {
    assert_eq!(plan(&[], &limits(true)).duration(), 0.0);
    let here = Point::new(1.0, 2.0, 3.0);
    let still = contour_move(Path::line(here, here), 0.1, true);
    let trajectory: Trajectory = plan(&[still, still], &limits(true));
    assert_eq!(
        (trajectory.duration(), trajectory.end(), trajectory.moves()),
        (0.0, here, 2)
    );
}

#[test]
fn a_single_line_takes_the_closed_form_time() {
    let line = Path::line(Point::zeros(), Point::new(100.0, 0.0, 0.0));
    let one = ContourMove {
        acceleration: 5000.0,
        deceleration: 5000.0,
        jerk: None,
        ..contour_move(line, 0.0, false)
    };
    // 0.04 s each to speed up and slow down over 4 mm, 92 mm at 200 mm/s.
    let duration = plan(&[one], &limits(false)).duration();
    assert!((duration - 0.54).abs() < 1e-9, "{duration}");
}

#[test]
fn a_reversal_and_moves_without_length_are_planned() {
    let (a, b) = (Point::zeros(), Point::new(20.0, 0.0, 0.0));
    for jerk in [false, true] {
        let moves: Vec<ContourMove> = [Path::line(a, b), Path::line(b, b), Path::line(b, a)]
            .map(|path| contour_move(path, 0.1, jerk))
            .to_vec();
        let trajectory = plan(&moves, &limits(jerk));
        assert_eq!(trajectory.end(), a);
        assert!(
            trajectory.duration() > 0.2 && trajectory.duration() < 0.5,
            "{}",
            trajectory.duration()
        );
        let farthest = (0..1000)
            .map(|k| trajectory.at(f64::from(k) * 5e-4).position.x)
            .fold(0.0, f64::max);
        assert!(farthest > 19.8, "turns at {farthest}");
    }
}

#[test]
fn long_slow_legs_cost_no_more_nodes_than_short_ones() {
    let (a, b, c) = (
        Point::zeros(),
        Point::new(5000.0, 0.0, 0.0),
        Point::new(5000.0, 5000.0, 0.0),
    );
    for (jerk, deviation, most) in [
        (false, Deviation::Anywhere, 4000),
        (true, Deviation::Anywhere, 4000),
        // Between the corner's rounding and the cruise the tube is narrow, and there is a little acceleration across for longer.
        (false, Deviation::Corners, 6000),
        (true, Deviation::Corners, 6000),
    ] {
        let moves = [Path::line(a, b), Path::line(b, c)].map(|path| ContourMove {
            speed: 50.0,
            deviation,
            ..contour_move(path, 0.05, jerk)
        });
        let limits = limits(jerk);
        let trajectory = plan(&moves, &limits);
        let stops: f64 = moves.iter().map(|one| plan(&[*one], &limits).duration()).sum();
        assert!(
            trajectory.duration() < stops && trajectory.duration() > 199.9,
            "{} {stops}",
            trajectory.duration()
        );
        assert!(trajectory.pieces() < most, "{} pieces", trajectory.pieces());
    }
}

#[test]
fn a_corner_without_tolerance_is_a_stop() {
    let (a, b, c) = (Point::zeros(), Point::new(20.0, 0.0, 0.0), Point::new(20.0, 20.0, 0.0));
    let moves = [
        contour_move(Path::line(a, b), 0.0, true),
        contour_move(Path::line(b, c), 0.0, true),
    ];
    let trajectory = plan(&moves, &limits(true));
    let corner = trajectory.at(trajectory.move_end(0).expect("two moves"));
    assert_eq!((corner.position, corner.velocity), (b, Point::zeros()));
}

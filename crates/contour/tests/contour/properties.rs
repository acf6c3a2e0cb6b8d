//! Properties of plans on random courses: within the tolerance and all limits, exact at the end,
//! never slower than stopping at every corner.

use crate::common::{PROFILES, Profile, SPEED, arc_through, check_peaks, off, profile, with_stops};
use arcline_contour::{ContourMove, Deviation, Path, Point, Trajectory, begin, plan};
use proptest::prelude::*;

/// A polyline or, where `bulge` is not small, arcs through a point beside the chord.
fn course(steps: &[(f64, f64, f64, f64)], tolerance: f64, profile: Profile) -> Vec<ContourMove> {
    let mut from = Point::new(1.0, -2.0, 0.5);
    let mut moves = Vec::new();
    for &(x, y, z, bulge) in steps {
        let to = from + Point::new(x, y, z);
        let side = (to - from).cross(&Point::new(0.3, -0.2, 1.0)) * (0.5 * bulge);
        let arc = arc_through(from, (from + to) * 0.5 + side, to).filter(|_| bulge.abs() > 0.2);
        moves.push(profile.contour_move(arc.unwrap_or_else(|| Path::line(from, to)), tolerance));
        from = to;
    }
    moves
}

fn check(moves: &[ContourMove], profile: Profile) -> Result<(), TestCaseError> {
    let limits = profile.limits();
    let trajectory = plan(moves, &limits);
    let end = moves[moves.len() - 1].path.end();
    let last = trajectory.at(trajectory.duration());
    prop_assert_eq!(last.position, end);
    prop_assert_eq!(trajectory.at(trajectory.duration() + 1.0).position, end);
    prop_assert_eq!(last.velocity, Point::zeros());
    prop_assert_eq!(trajectory.at(0.0).position, moves[0].path.start());
    check_peaks(&trajectory.peaks(), &limits)?;
    let count = 1500;
    let mut before = 0;
    for k in 0..=count {
        let t = trajectory.duration() * f64::from(k) / f64::from(count);
        let state = trajectory.at(t);
        prop_assert!(state.velocity.norm() <= SPEED * (1.0 + 1e-9));
        let off = off(moves, &state.position);
        prop_assert!(off <= moves[0].tolerance * 1.001 + 2e-3, "off by {off} at {t}");
        let now = trajectory.move_at(t);
        prop_assert!(now >= before);
        before = now;
    }
    prop_assert_eq!(trajectory.moves(), moves.len());
    let stops = with_stops(moves, &limits);
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
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.div_ceil(16), ..ProptestConfig::default() })]

    #[test]
    fn lines_and_arcs_in_space(steps in prop::collection::vec(step(), 1..6), tolerance in 0.01..0.5_f64, profile in profile()) {
        check(&course(&steps, tolerance, profile), profile)?;
    }

    #[test]
    fn polylines_in_a_plane(steps in prop::collection::vec(flat(), 2..20), tolerance in 0.01..0.3_f64, profile in profile()) {
        check(&course(&steps, tolerance, profile), profile)?;
    }
}

#[test]
fn nothing_to_do_is_a_rest() {
    assert_eq!(plan(&[], &Profile::SCurve.limits()).duration(), 0.0);
    let here = Point::new(1.0, 2.0, 3.0);
    let still = Profile::SCurve.contour_move(Path::line(here, here), 0.1);
    let trajectory: Trajectory = plan(&[still, still], &Profile::SCurve.limits());
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
        ..Profile::Trapezoid.contour_move(line, 0.0)
    };
    // 0.04 s each to speed up and slow down over 4 mm, 92 mm at 200 mm/s.
    let duration = plan(&[one], &Profile::Trapezoid.limits()).duration();
    assert!((duration - 0.54).abs() < 1e-9, "{duration}");
}

#[test]
fn a_reversal_and_moves_without_length_are_planned() {
    let (a, b) = (Point::zeros(), Point::new(20.0, 0.0, 0.0));
    for profile in PROFILES {
        let moves: Vec<ContourMove> = [Path::line(a, b), Path::line(b, b), Path::line(b, a)]
            .map(|path| profile.contour_move(path, 0.1))
            .to_vec();
        let trajectory = plan(&moves, &profile.limits());
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
    for (profile, deviation, most) in [
        (Profile::Trapezoid, Deviation::Anywhere, 4000),
        (Profile::SCurve, Deviation::Anywhere, 4000),
        // Between the corner's rounding and the cruise the tube is narrow, and there is a little acceleration across for longer.
        (Profile::Trapezoid, Deviation::Corners, 6000),
        (Profile::SCurve, Deviation::Corners, 6000),
    ] {
        let moves = [Path::line(a, b), Path::line(b, c)].map(|path| ContourMove {
            speed: 50.0,
            deviation,
            ..profile.contour_move(path, 0.05)
        });
        let limits = profile.limits();
        let trajectory = plan(&moves, &limits);
        let stops = with_stops(&moves, &limits);
        assert!(
            trajectory.duration() < stops && trajectory.duration() > 199.9,
            "{profile:?} {deviation:?} {} {stops} {}",
            trajectory.duration(),
            trajectory.pieces()
        );
        assert!(trajectory.pieces() < most, "{} pieces", trajectory.pieces());
    }
}

/// They took 24,000 nodes: minutes, with an S-curve.
#[test]
fn slow_large_arcs_cost_no_more_nodes_than_their_number_allows() {
    let (a, b, c) = (
        Point::zeros(),
        Point::new(300.0, 400.0, 0.0),
        Point::new(900.0, 100.0, 0.0),
    );
    let limits = Profile::SCurve.limits();
    let moves = [
        (a, Point::new(100.0, 300.0, 0.0), b),
        (b, Point::new(700.0, 400.0, 0.0), c),
    ]
    .map(|(from, via, to)| {
        let arc = arc_through(from, via, to).expect("three points that are not on a line");
        ContourMove {
            speed: 20.0,
            ..Profile::SCurve.contour_move(arc, 1.0)
        }
    });
    let trajectory = plan(&moves, &limits);
    let length: f64 = moves.iter().map(|one| one.path.length()).sum();
    assert!(trajectory.pieces() < 5000, "{} pieces", trajectory.pieces());
    assert!(
        trajectory.duration() < length / 20.0 * 1.01,
        "{} s",
        trajectory.duration()
    );
    check_peaks(&trajectory.peaks(), &limits).expect("within the limits");
}

#[test]
fn a_corner_without_tolerance_is_a_stop() {
    let (a, b, c) = (Point::zeros(), Point::new(20.0, 0.0, 0.0), Point::new(20.0, 20.0, 0.0));
    let moves = [
        Profile::SCurve.contour_move(Path::line(a, b), 0.0),
        Profile::SCurve.contour_move(Path::line(b, c), 0.0),
    ];
    let trajectory = plan(&moves, &Profile::SCurve.limits());
    let corner = trajectory.at(trajectory.move_end(0).expect("two moves"));
    assert_eq!((corner.position, corner.velocity), (b, Point::zeros()));
}

/// The first moves of a stream, from very short to very long ones: within all limits, near the path and exact at the end.
fn check_beginning(moves: &[ContourMove], profile: Profile) -> Result<(), TestCaseError> {
    let limits = profile.limits();
    let trajectory = begin(moves, &limits);
    prop_assert!(trajectory.moves() > 0);
    let planned = &moves[..trajectory.moves()];
    let end = planned[planned.len() - 1].path.end();
    prop_assert_eq!(trajectory.at(trajectory.duration()).position, end);
    prop_assert_eq!(trajectory.at(0.0).position, moves[0].path.start());
    check_peaks(&trajectory.peaks(), &limits)?;
    let count = 300;
    for k in 0..=count {
        let t = trajectory.duration() * f64::from(k) / f64::from(count);
        let state = trajectory.at(t);
        prop_assert!(state.velocity.norm() <= SPEED * (1.0 + 1e-9), "{state:?}");
        let off = off(planned, &state.position);
        prop_assert!(off <= moves[0].tolerance * 1.001 + 2e-3, "off by {off} at {t}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.div_ceil(8), ..ProptestConfig::default() })]

    #[test]
    fn beginnings_of_streams(
        steps in prop::collection::vec(step(), 1..8),
        scale in -2.5..1.5_f64,
        tolerance in 0.01..0.5_f64,
        profile in profile(),
    ) {
        let scale = libm::exp10(scale);
        let steps: Vec<_> = steps.into_iter().map(|(x, y, z, bulge)| (x * scale, y * scale, z * scale, bulge)).collect();
        check_beginning(&course(&steps, tolerance, profile), profile)?;
    }
}

//! A contour's line stays a line: outside the rounding of its corners a long piece deviates by at most a hundredth of the
//! tolerance, planned at once and extended while it runs, within the limits of the axes.

use crate::common::{
    PROFILES, Profile, Windows, ahead, arc_through, check_peaks, distance, profile, travel, with_stops,
};
use arcline_contour::{ContourMove, Deviation, Path, Point, Trajectory, plan};
use proptest::prelude::*;

/// A leg: its length in tolerances, the turn of the direction before it, and how much it is bent (an arc where that is much).
type Leg = (f64, f64, f64);

fn course(legs: &[Leg], tolerance: f64, profile: Profile) -> Vec<ContourMove> {
    let (mut from, mut heading) = (Point::new(1.0, -2.0, 0.5), 0.3_f64);
    legs.iter()
        .map(|&(tolerances, turn, bulge)| {
            heading += turn;
            let to = ahead(from, heading, tolerances * tolerance);
            let via = (from + to) * 0.5 + Point::new(-(to - from).y, (to - from).x, 0.0) * (0.5 * bulge);
            let arc = arc_through(from, via, to).filter(|_| bulge.abs() > 0.1);
            if let Some(arc) = &arc {
                let end = arc.end_tangent();
                heading = libm::atan2(end.y, end.x);
            }
            let path = arc.unwrap_or_else(|| Path::line(from, to));
            from = to;
            profile.contour_move(path, tolerance)
        })
        .collect()
}

/// A line is a chord of a curve: short, between flat corners, or among short lines with small changes of direction.
fn is_chord(moves: &[ContourMove], k: usize) -> bool {
    let joints = |k: usize| {
        let both = [k.checked_sub(1), Some(k).filter(|&k| k + 1 < moves.len())];
        both.into_iter().flatten()
    };
    let turn = |joint: usize| (moves[joint + 1].path.start_tangent() - moves[joint].path.end_tangent()).norm();
    let most = joints(k).map(turn).fold(0.0, f64::max);
    let long = |k: usize| {
        let tolerances = joints(k).map(|joint| moves[joint].tolerance);
        let line = matches!(moves[k].path, Path::Line(_));
        let length = if line { moves[k].path.length() } else { f64::INFINITY };
        length / tolerances.fold(f64::INFINITY, f64::min)
    };
    let flat = long(k) <= 100.0 && long(k) * most / 8.0 <= 0.5;
    let inner = k > 0 && k + 1 < moves.len();
    let among = || (k - 1..=k + 1).all(|near| long(near) <= 250.0);
    most > 0.0 && (flat || inner && most <= 0.35 && among())
}

/// A share of what is allowed: the worst between two instants.
fn used(trajectory: &Trajectory, moves: &[ContourMove], from: f64, to: f64) -> (f64, f64) {
    let count = ((to - from) / 5e-4).ceil().max(1.0) as usize;
    let mut worst = (0.0, from);
    for k in 0..=count {
        let t = from + (to - from) * k as f64 / count as f64;
        let q = trajectory.at(t).position;
        let used = (0..moves.len())
            .map(|k| {
                let length = moves[k].path.length();
                let (off, along) = distance(&moves[k].path, &q);
                // The tolerance of a corner belongs to the move before it; the first move starts and the last one ends at none.
                let at_start = (k > 0).then(|| moves[k - 1].tolerance);
                let at_end = (k + 1 < moves.len()).then_some(moves[k].tolerance);
                // The nearer corner says how far, each corner how far along the move its rounding reaches.
                let nearer = if along < 0.5 * length {
                    at_start.or(at_end)
                } else {
                    at_end.or(at_start)
                };
                let tolerance = nearer.unwrap_or(moves[k].tolerance);
                let open = length <= 50.0 * tolerance
                    || is_chord(moves, k)
                    || at_start.is_some_and(|start| along < 10.0 * start)
                    || at_end.is_some_and(|end| length - along < 10.0 * end);
                off / (tolerance * if open { 1.0 } else { 0.01 })
            })
            .fold(f64::INFINITY, f64::min);
        if used > worst.0 {
            worst = (used, t);
        }
    }
    worst
}

fn check(
    trajectory: &Trajectory,
    moves: &[ContourMove],
    (from, to): (f64, f64),
    profile: Profile,
) -> Result<(), TestCaseError> {
    check_peaks(&trajectory.peaks(), &profile.limits())?;
    let (worst, at) = used(trajectory, moves, from, to);
    prop_assert!(worst <= 1.001, "{worst} of what is allowed, at {at} s");
    Ok(())
}

fn leg() -> impl Strategy<Value = Leg> {
    let length = prop_oneof![2 => 51.0..300.0_f64, 1 => 2.0..50.0_f64];
    let turn =
        prop_oneof![3 => -2.9..2.9_f64, 1 => -0.05..0.05_f64, 1 => Just(0.0), 1 => Just(core::f64::consts::FRAC_PI_2)];
    let bulge = prop_oneof![3 => Just(0.0), 1 => -1.2..1.2_f64];
    (length, turn, bulge)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.div_ceil(32), ..ProptestConfig::default() })]

    #[test]
    fn long_pieces_keep_their_shape(
        legs in prop::collection::vec(leg(), 2..10),
        tolerance in prop_oneof![3 => Just(0.01), 2 => 0.01..0.1_f64, 1 => 0.1..0.4_f64],
        other in prop_oneof![2 => Just(1.0), 1 => 0.2..5.0_f64],
        profile in profile(),
    ) {
        let mut moves = course(&legs, tolerance, profile);
        for every_second in moves.iter_mut().skip(1).step_by(2) {
            every_second.tolerance *= other;
        }
        let limits = profile.limits();
        let whole = plan(&moves, &limits);
        check(&whole, &moves, (0.0, whole.duration()), profile)?;
        let stops = with_stops(&moves, &limits);
        prop_assert!(whole.duration() <= stops * 1.005 + 1e-9, "{} s, with stops {stops} s", whole.duration());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.div_ceil(50), ..ProptestConfig::default() })]

    #[test]
    fn extensions_keep_long_pieces_too(
        legs in prop::collection::vec(leg(), 5..10),
        window in 3..6_usize,
        tolerance in prop_oneof![4 => 0.02..0.06_f64, 1 => 0.06..0.2_f64],
        profile in profile(),
    ) {
        let moves = course(&legs, tolerance, profile);
        let check = |trajectory: &Trajectory, from: f64, to: f64| check(trajectory, &moves, (from, to), profile);
        travel(&moves, Windows { moves: window, ahead: 0.4 }, &profile.limits(), check, |_| Ok(()))?;
    }
}

#[test]
fn the_square_of_the_manual_has_straight_sides() {
    for profile in PROFILES {
        let quarter = core::f64::consts::FRAC_PI_2;
        let moves = course(
            &[(100.0, 0.0, 0.0), (100.0, quarter, 0.0), (100.0, quarter, 0.0)],
            1.0,
            profile,
        );
        let limits = profile.limits();
        let whole = plan(&moves, &limits);
        check(&whole, &moves, (0.0, whole.duration()), profile).expect("straight sides");
        let anywhere: Vec<ContourMove> = moves
            .iter()
            .map(|one| ContourMove {
                deviation: Deviation::Anywhere,
                ..*one
            })
            .collect();
        let free = plan(&anywhere, &limits).duration();
        assert!(
            whole.duration() < free * 1.05,
            "{} s, anywhere {free} s",
            whole.duration()
        );
        let corner = whole.rounding(0).expect("two moves");
        assert!(
            corner[0] < corner[1] && whole.at(corner[0]).velocity.norm() > 10.0,
            "{corner:?}"
        );
    }
}

/// The curve was outside between two knots, just where the rounding ends on the line behind the arc.
#[test]
fn a_line_behind_an_arc_is_straight_from_the_end_of_the_rounding_on() {
    let legs = [
        (183.68692658958182, 1.2321658004245941, 0.10583555114802434),
        (167.19479968126166, 2.583111823044874, 0.0),
        (280.4116164294605, 0.022482651591217772, 0.0),
        (268.552984339612, -1.098043749789028, 0.5603533029662259),
        (31.712154936133746, 0.013120648875106146, 0.0),
        (202.57985731183481, core::f64::consts::FRAC_PI_2, 0.0),
    ];
    let moves = course(&legs, 0.01, Profile::SCurve);
    let whole = plan(&moves, &Profile::SCurve.limits());
    check(&whole, &moves, (0.0, whole.duration()), Profile::SCurve).expect("a straight line");
}

/// The curve was outside in the middle of a short line, where the tolerance of its second corner begins.
#[test]
fn a_short_line_between_two_tolerances_keeps_both() {
    let legs = [
        (51.0, -0.031182301337533955, -0.46167174055807175),
        (276.9964461757847, core::f64::consts::FRAC_PI_2, 0.0),
        (25.159830544204418, -1.435750634111521, 0.0),
        (16.88048779338941, 1.1278229827028503, 0.0),
        (252.27528673817025, -0.03440120297938323, 0.0),
        (216.60109658619962, 0.0, -1.1717984121597353),
        (234.7437851971077, -0.018913718460637614, 0.0),
    ];
    let mut moves = course(&legs, 0.01, Profile::Trapezoid);
    for every_second in moves.iter_mut().skip(1).step_by(2) {
        every_second.tolerance *= 4.104546640807881;
    }
    let whole = plan(&moves, &Profile::Trapezoid.limits());
    check(&whole, &moves, (0.0, whole.duration()), Profile::Trapezoid).expect("both tolerances");
}

/// The wide rounding at the start of a line reaches beyond its middle, where the narrow tolerance of its other corner begins.
#[test]
fn a_wide_rounding_may_reach_beyond_the_middle_of_a_line() {
    let mut legs = vec![
        (72.48706777211034, -0.3726753986985328, 0.0),
        (2.0, 0.0, 0.2370077781917841),
    ];
    legs.extend([(51.0, 0.0, 0.0); 5]);
    let mut moves = course(&legs, 0.01, Profile::SCurve);
    for every_second in moves.iter_mut().skip(1).step_by(2) {
        every_second.tolerance *= 4.817471024203573;
    }
    let whole = plan(&moves, &Profile::SCurve.limits());
    check(&whole, &moves, (0.0, whole.duration()), Profile::SCurve).expect("both tolerances");
    // The rounding of the arc's second corner: 10 tolerances of 0.048.
    let (third, middle) = (&moves[2].path, 0.5 * moves[2].path.length());
    let off_behind_the_middle = (0..=1000)
        .map(|k| whole.at(whole.duration() * f64::from(k) / 1000.0).position)
        .map(|q| distance(third, &q))
        .filter(|&(_, along)| along > 1.1 * middle && along < 1.6 * middle)
        .map(|(off, _)| off)
        .fold(0.0, f64::max);
    assert!(
        off_behind_the_middle > 1e-3 && off_behind_the_middle <= 0.01,
        "{off_behind_the_middle}"
    );
}

//! Arcs and lines against spec/coordinated-instructions.md §27.4 and spec/motion-core.md §9, §13.

#![allow(clippy::disallowed_methods)] // expectations may use the platform's functions
use arcline_geometry::{Arc, CirclePoint, Dimension, Direction, Path, Point};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn at(x: f64, y: f64) -> Point {
    Point::new(x, y, 0.0)
}

fn word(direction: i32) -> Direction {
    Direction::from_word(direction).expect("0 to 3")
}

#[test]
fn circles_of_the_reference() {
    use CirclePoint::{Center, Radius, Via};
    let s = at(1.0, 0.0);
    let o = at(0.0, 0.0);
    #[rustfmt::skip]
    let cases = [
        // why, end, circle, directions, Ok((sweep, signed by the normal; centre; ends in)) or ERR
        ("quarter, counter-clockwise", at(0.0, 1.0), Center(o), vec![1], Ok((FRAC_PI_2, o, at(0.0, 1.0)))),
        ("three quarters, clockwise", at(0.0, 1.0), Center(o), vec![0], Ok((-1.5 * PI, o, at(0.0, 1.0)))),
        ("full circle clockwise", at(0.0, 1.0), Center(o), vec![2], Ok((-TAU, o, s))),
        ("end equal to start is a circle", s, Center(o), vec![0, 2], Ok((-TAU, o, s))),
        ("end equal to start, the other way", s, Center(o), vec![1, 3], Ok((TAU, o, s))),
        ("radii 14 % apart", at(0.0, 1.14), Center(o), vec![1], Ok((FRAC_PI_2, o, at(0.0, 1.14)))),
        ("radii 16 % apart", at(0.0, 1.16), Center(o), vec![1], Err(46)),
        ("centre in the start", at(0.0, 0.0), Center(at(1.0, 0.0)), vec![0, 1, 2, 3], Err(46)),
        ("tiny circle", at(1.0, 0.0), Center(at(1.0005, 0.0)), vec![0, 1, 2, 3], Err(49)),
        ("radius, the short way", at(0.0, 1.0), Radius(1.0), vec![1], Ok((FRAC_PI_2, o, at(0.0, 1.0)))),
        ("radius, short, clockwise", at(0.0, 1.0), Radius(1.0), vec![0], Ok((-FRAC_PI_2, at(1.0, 1.0), at(0.0, 1.0)))),
        ("radius, the long way", at(0.0, 1.0), Radius(-1.0), vec![1], Ok((1.5 * PI, at(1.0, 1.0), at(0.0, 1.0)))),
        ("radius, long, clockwise", at(0.0, 1.0), Radius(-1.0), vec![0], Ok((-1.5 * PI, o, at(0.0, 1.0)))),
        ("radius, full circle", at(0.0, 1.0), Radius(1.0), vec![3], Ok((TAU, o, s))),
        ("half circle by radius", at(-1.0, 0.0), Radius(1.0), vec![1], Ok((PI, o, at(-1.0, 0.0)))),
        ("half circle, radius short by rounding", at(-1.0, 0.0), Radius(1.0 - 0.9e-9), vec![0], Ok((-PI, o, at(-1.0, 0.0)))),
        ("radius below 0.001", at(0.0, 1.0), Radius(0.0005), vec![0, 1, 2, 3], Err(49)),
        ("radius too short", at(0.0, 1.0), Radius(0.7), vec![0, 1, 2, 3], Err(49)),
        ("radius, no chord", s, Radius(1.0), vec![0, 1, 2, 3], Err(45)),
        ("via", at(-1.0, 0.0), Via(at(0.0, 1.0)), vec![0, 1], Ok((PI, o, at(-1.0, 0.0)))),
        ("via below", at(-1.0, 0.0), Via(at(0.0, -1.0)), vec![0, 1], Ok((-PI, o, at(-1.0, 0.0)))),
        ("via, full", at(-1.0, 0.0), Via(at(0.0, 1.0)), vec![2, 3], Ok((TAU, o, s))),
        ("via on the line", at(3.0, 0.0), Via(at(2.0, 0.0)), vec![0, 1, 2, 3], Err(44)),
        ("via in the start", at(3.0, 0.0), Via(s), vec![0], Err(44)),
        ("via in the end", at(3.0, 1.0), Via(at(3.0, 1.0)), vec![0], Err(44)),
        ("via, no chord", s, Via(at(3.0, 1.0)), vec![0], Err(45)),
    ];
    for (why, end, circle, directions, expected) in cases {
        for direction in directions {
            let arc = Arc::new(Dimension::Two, s, end, circle, word(direction));
            match (arc, expected) {
                (Ok(arc), Ok((sweep, center, last))) => {
                    let found = arc.sweep() * arc.normal().z.signum();
                    assert!((found - sweep).abs() < 1e-12, "{why}: sweep {found}");
                    assert!((arc.center() - center).norm() < 1e-4, "{why}: centre {}", arc.center());
                    assert_eq!(arc.end(), last, "{why}");
                    assert_eq!(
                        (arc.at(0.0).position, arc.at(arc.length()).position),
                        (s, last),
                        "{why}"
                    );
                    // The formula of spec/coordinated-instructions.md §13.4 is that of a circle; the spiral between two radii is longer.
                    let excess = arc.length() / (sweep.abs() * 0.5 * (arc.radius() + arc.end_radius())) - 1.0;
                    let is_circle = arc.radius() == arc.end_radius();
                    let allowed = if is_circle { -1e-12..1e-12 } else { 1e-12..5e-3 };
                    assert!(allowed.contains(&excess), "{why}: {excess}");
                }
                (Err(error), Err(expected)) => assert_eq!(error.err(), expected, "{why}: {error}"),
                (found, expected) => panic!("{why}: {found:?}, expected {expected:?}"),
            }
        }
    }
}

#[test]
fn arcs_in_space() {
    let (x, y) = (Point::x(), Point::y());
    let o = Point::zeros();
    let arc = |end, circle, direction| Arc::new(Dimension::Three, x, end, circle, word(direction));
    let error = |found: Result<Arc, arcline_geometry::ArcError>| found.expect_err("refused").err();
    assert_eq!(error(arc(-x, CirclePoint::Center(o), 0)), 44);
    assert_eq!(error(arc(x, CirclePoint::Center(o), 0)), 45);
    assert_eq!(error(arc(y * 1.2, CirclePoint::Center(o), 0)), 46);
    assert_eq!(error(arc(y, CirclePoint::Radius(1.0), 0)), 25);
    let short = arc(y, CirclePoint::Center(o), 0).expect("shortest");
    let long = arc(y, CirclePoint::Center(o), 1).expect("longest");
    let full = arc(y, CirclePoint::Center(o), 3).expect("longest, full");
    assert!((short.sweep() - FRAC_PI_2).abs() < 1e-15 && short.normal().z > 0.0);
    assert!((long.sweep() - 1.5 * PI).abs() < 1e-15 && long.normal().z < 0.0);
    assert!(full.sweep() == TAU && full.normal().z < 0.0 && full.end() == x);
}

#[test]
fn edges() {
    // A whole turn but 1e-9 rad is neither a full circle nor nothing.
    let end = at(1000.0 * (1e-8f64).cos(), -1000.0 * (1e-8f64).sin());
    let arc = Arc::new(
        Dimension::Two,
        at(1000.0, 0.0),
        end,
        CirclePoint::Center(at(0.0, 0.0)),
        word(1),
    )
    .expect("an arc");
    assert!((arc.sweep() - (TAU - 1e-8)).abs() < 1e-14, "{}", arc.sweep());
    let arc = Arc::new(
        Dimension::Two,
        at(1000.0, 0.0),
        end,
        CirclePoint::Center(at(0.0, 0.0)),
        word(0),
    )
    .expect("an arc");
    assert!((arc.sweep() - 1e-8).abs() < 1e-17, "{}", arc.sweep());
    // Far from the origin: the error is that of the coordinates.
    let o = at(1e6, -1e6);
    let arc = Arc::new(
        Dimension::Two,
        o + at(1e-3, 0.0),
        o + at(0.0, 1e-3),
        CirclePoint::Via(o + at(6e-4, 8e-4)),
        word(0),
    )
    .expect("an arc");
    assert!((arc.length() - 1e-3 * FRAC_PI_2).abs() < 1e-8, "{}", arc.length());
    // Via next to the start and to the end.
    for angle in [1e-4f64, FRAC_PI_2 - 1e-4] {
        let via = at(angle.cos(), angle.sin());
        let arc = Arc::new(
            Dimension::Two,
            at(1.0, 0.0),
            at(0.0, 1.0),
            CirclePoint::Via(via),
            word(0),
        )
        .expect("an arc");
        assert!((arc.length() - FRAC_PI_2).abs() < 1e-10, "{}", arc.length());
    }
    let none = Path::line(at(1.0, 2.0), at(1.0, 2.0));
    assert_eq!((none.length(), none.at(5.0).position), (0.0, at(1.0, 2.0)));
}

/// Derivatives by arc length from differences of the position and of the lower derivatives.
fn check_smooth(path: &Path, s: f64, size: f64) -> Result<(), TestCaseError> {
    let h = 1e-5 * size;
    let (before, here, after) = (path.at(s - h), path.at(s), path.at(s + h));
    let slope = |low: Point, high: Point| (high - low) / (2.0 * h);
    prop_assert!((here.tangent.norm() - 1.0).abs() < 1e-14);
    prop_assert!((slope(before.position, after.position) - here.tangent).norm() < 1e-8);
    prop_assert!((slope(before.tangent, after.tangent) - here.curvature).norm() * size < 1e-8);
    prop_assert!((slope(before.curvature, after.curvature) - here.curvature_change).norm() * size * size < 1e-7);
    prop_assert!(here.curvature.dot(&here.tangent).abs() * size < 1e-13);
    Ok(())
}

fn point() -> impl Strategy<Value = Point> {
    (-100.0..100.0, -100.0..100.0, -100.0..100.0).prop_map(|(x, y, z)| Point::new(x, y, z))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases * 8))]

    #[test]
    fn via_in_space(start in point(), via in point(), end in point(), full in any::<bool>(), share in 0.0..1.0) {
        let sine = (via - start).cross(&(end - start)).norm() / ((via - start).norm() * (end - start).norm());
        prop_assume!(sine > 1e-2 && (end - via).norm() > 1.0);
        let arc = Arc::new(Dimension::Three, start, end, CirclePoint::Via(via), word(if full { 2 } else { 0 })).expect("an arc");
        let (r, c) = (arc.radius(), arc.center());
        let last = if full { start } else { end };
        prop_assert_eq!((arc.at(0.0).position, arc.at(arc.length()).position), (start, last));
        let sample = arc.at(share * arc.length()).position;
        prop_assert!(((sample - c).norm() - r).abs() <= 1e-12 * r);
        prop_assert!((arc.at(arc.length() * (1.0 - 1e-16)).position - last).norm() <= 1e-12 * r);
        // The via point is passed.
        let x = via - c;
        let e1 = (start - c) / r;
        let angle = x.dot(&arc.normal().cross(&e1)).atan2(x.dot(&e1)).rem_euclid(TAU);
        prop_assert!(full || angle < arc.sweep());
        prop_assert!((arc.at(angle * r).position - via).norm() < 1e-9 * r);
        check_smooth(&Path::Arc(arc), share * arc.length(), r)?;
    }

    #[test]
    fn center_in_space(c in point(), a in point(), b in point(), mismatch in -0.149..0.149f64, exact in any::<bool>(), word_ in 0..2, share in 0.0..1.0) {
        prop_assume!(a.norm() > 1.0 && b.norm() > 1.0 && a.cross(&b).norm() > 1e-2 * a.norm() * b.norm());
        let r = a.norm();
        let mismatch = if exact { 0.0 } else { mismatch };
        let (start, end) = (c + a, c + b * (r * (1.0 + mismatch) / b.norm()));
        let arc = Arc::new(Dimension::Three, start, end, CirclePoint::Center(c), word(word_)).expect("an arc");
        let cosine = (a.dot(&b) / (a.norm() * b.norm())).clamp(-1.0, 1.0);
        let shortest = cosine.acos();
        let expected = if word_ == 0 { shortest } else { TAU - shortest };
        prop_assert!((arc.sweep() - expected).abs() < 1e-7);
        prop_assert_eq!((arc.at(0.0).position, arc.at(arc.length()).position), (start, end));
        // Continuous with the exact end points.
        prop_assert!((arc.at(arc.length() * (1.0 - 3e-16)).position - end).norm() < 1e-12 * (r + c.norm()));
        // The radius runs linearly with the angle.
        let sample = arc.at(share * arc.length()).position - c;
        let e1 = a / r;
        let angle = sample.dot(&arc.normal().cross(&e1)).atan2(sample.dot(&e1)).rem_euclid(TAU);
        let expected = r * (1.0 + mismatch * angle / arc.sweep());
        prop_assert!((sample.norm() - expected).abs() < 1e-11 * (r + c.norm()) || angle > arc.sweep());
        check_smooth(&Path::Arc(arc), share * arc.length(), r.min(arc.length()))?;
        // Length by the chords between many angles of the exact curve.
        let n = 400;
        let on_curve = |k: i32| {
            let angle = arc.sweep() * f64::from(k) / f64::from(n);
            (e1 * angle.cos() + arc.normal().cross(&e1) * angle.sin()) * (r * (1.0 + mismatch * angle / arc.sweep()))
        };
        let chords: f64 = (0..n).map(|k| (on_curve(k + 1) - on_curve(k)).norm()).sum();
        prop_assert!((arc.length() - chords).abs() < 1e-4 * chords);
    }

    #[test]
    fn radius_in_the_plane(start in point(), end in point(), more in 0.0..5.0f64, long in any::<bool>(), direction in 0..2, share in 0.0..1.0) {
        let (start, end) = (at(start.x, start.y), at(end.x, end.y));
        let half = 0.5 * (end - start).norm();
        prop_assume!(half > 0.1);
        let radius = half * (1.0 + more);
        let signed = if long { -radius } else { radius };
        let arc = Arc::new(Dimension::Two, start, end, CirclePoint::Radius(signed), word(direction)).expect("an arc");
        prop_assert!((arc.radius() - radius).abs() < 1e-12 * radius);
        prop_assert_eq!(arc.sweep() > PI + 1e-7, long && more > 1e-12);
        prop_assert_eq!(arc.normal().z > 0.0, direction == 1);
        prop_assert!((arc.at(share * arc.length()).position.z) == 0.0);
        prop_assert!((arc.at(arc.length() * (1.0 - 3e-16)).position - end).norm() < 1e-11 * radius);
    }

    #[test]
    fn lines(start in point(), end in point(), share in -1.0..2.0) {
        let path = Path::line(start, end);
        let s = share * path.length();
        prop_assert_eq!((path.at(0.0).position, path.at(path.length()).position), (start, end));
        let expected: Point = start + (end - start) * share;
        prop_assert!((path.at(s).position - expected).norm() < 1e-12);
    }
}

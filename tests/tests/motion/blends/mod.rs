//! The transition from one move to the next: termination types, merges, changes and stops in between
//! (spec/coordinated-instructions.md §6, §7, §27; spec/motion-core.md §6).

mod changes;
mod merges;
mod space;
mod stops;

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::coordinate_motion_status as cms;
use arcline_tests::bench::{Bench, OK};

/// A line on XY at 200 units/s with ramps of 2000 units/s².
fn line(tag: &str, x: f64, y: f64, profile: &str, termination: &str) -> String {
    format!("MCLM(XY, {tag}, 0, [{x}, {y}], 200, 0, 2000, 0, 2000, 0, {profile}, 100, 100, 2, {termination})")
}

const S_CURVE: &str = "1";
const TRAPEZOID: &str = "0";

/// Ticks a machine until it rests and returns every commanded point of X and Y.
fn record(bench: &mut Bench) -> Vec<[f64; 2]> {
    let mut points = vec![[bench.position("X"), bench.position("Y")]];
    for _ in 0..200_000 {
        bench.tick();
        points.push([bench.position("X"), bench.position("Y")]);
        let moving = bench.system("XY").status & 4 != 0 || bench.system("CS1").status & 4 != 0;
        if !moving {
            return points;
        }
    }
    panic!("it never comes to rest");
}

fn nearest(points: &[[f64; 2]], to: [f64; 2]) -> f64 {
    let distances = points.iter().map(|[x, y]| (x - to[0]).hypot(y - to[1]));
    distances.fold(f64::INFINITY, f64::min)
}

/// The largest change of the velocity between two ticks, units/s².
fn peak_acceleration(points: &[[f64; 2]], period: f64) -> f64 {
    let second = |p: &[[f64; 2]], k: usize| (p[2][k] - 2.0 * p[1][k] + p[0][k]) / (period * period);
    points
        .windows(3)
        .map(|p| second(p, 0).hypot(second(p, 1)))
        .fold(0.0, f64::max)
}

#[test]
fn matched_ramps_miss_the_corner_by_half_the_blend_distance_at_a_right_angle() {
    // Matched trapezoids at a right angle miss the corner by Db/2 sin 45°, Db = v²/2d = 10 (spec/motion-core.md §6.1).
    for (termination, db) in [
        ("3", 10.0),
        ("2", 0.5),
        ("6, 0, 0, 4", 4.0),
        ("6, 0, 0, 40", 10.0),
        ("6", 0.0),
        ("1", 0.0),
    ] {
        let mut bench = Bench::replacing("coarse_update_period_ms = 1.0", "coarse_update_period_ms = 0.25");
        bench.execute(&line("M1", 100.0, 0.0, TRAPEZOID, termination));
        bench.execute(&line("M2", 100.0, 100.0, TRAPEZOID, "1"));
        let points = record(&mut bench);
        let missed = nearest(&points, [100.0, 0.0]);
        // Below full braking both ramps meet at lower speeds; the distances keep the law.
        let expected = db / 2.0 * std::f64::consts::FRAC_1_SQRT_2;
        assert!(
            (missed - expected).abs() < 1e-3 * expected.max(1e-3),
            "{termination}: {missed}, not {expected}"
        );
        assert_eq!(points.last(), Some(&[100.0, 100.0]), "{termination}: the end is exact");
        let peak = peak_acceleration(&points, 0.000_25);
        assert!(peak <= 2000.0 * 2.0_f64.sqrt() * 1.000_1, "{termination}: {peak}");
    }
}

#[test]
fn blended_cycles_save_exactly_the_overlap() {
    for (profile, ramp) in [(TRAPEZOID, 0.1), (S_CURVE, 0.2)] {
        let mut bench = Bench::new();
        bench.execute(&line("M1", 100.0, 0.0, profile, "3"));
        bench.execute(&line("M2", 100.0, 100.0, profile, "1"));
        bench.until("M2", Flag::Pc);
        // Each move takes 100/200 + ramp; the two overlap by one ramp.
        let expected = 2.0 * (0.5 + ramp) - ramp;
        assert_eq!(bench.now(), (expected * 1000.0_f64).round() as u64, "profile {profile}");
    }
}

/// Bits of a coordinate system that show a waiting move.
const WAITING: u32 = cms::MOVE_PENDING_STATUS | cms::MOVE_PENDING_QUEUE_FULL_STATUS;
/// The same, and that two moves overlap.
const SEEN: u32 = WAITING | cms::MOVE_TRANSITION_STATUS;

/// Two lines, at the first transition point: the first is under way, the second waits.
fn at_the_first_transition_point(termination: &str) -> Bench {
    let mut bench = Bench::new();
    bench.execute(&line("M1", 100.0, 0.0, S_CURVE, termination));
    bench.execute(&line("M2", 100.0, 100.0, S_CURVE, "1"));
    bench.run(250);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN IP AC", "EN DN IP"),
        "TP1"
    );
    assert_eq!(bench.system("XY").motion_status & SEEN, WAITING);
    bench
}

#[test]
fn bits_at_the_transition_points_of_a_stop() {
    // Types 4 and 5 show the same bits; the corner is then passed at a speed: each axis may change its own by 10000 · 1 ms.
    for (termination, speed) in [("0", 0.0), ("1", 0.0), ("4", 10.0), ("5", 10.0)] {
        let mut bench = at_the_first_transition_point(termination);
        let mut least = f64::INFINITY;
        while !bench.control("M1").has(Flag::Pc) {
            bench.tick();
            least = if bench.now() < 300 {
                f64::INFINITY
            } else {
                least.min(bench.system("XY").path_speed)
            };
        }
        assert!(
            (least - speed).abs() < 0.5,
            "type {termination}: {least} at TP2, not {speed}"
        );
        let shown = bench.bits("M2");
        assert!(
            shown.starts_with("EN DN IP AC") && bench.bits("M1") == "EN DN PC",
            "TP2 of type {termination}: {shown}"
        );
        bench.run(220);
        assert_eq!(bench.bits("M1"), "EN DN PC");
        assert_eq!(bench.system("XY").motion_status & SEEN, 0);
        bench.until("M2", Flag::Pc);
        assert_eq!(
            (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
            ("EN DN PC", "EN DN PC"),
            "TP3"
        );
    }
}

#[test]
fn bits_at_the_transition_points_of_a_blend() {
    for termination in ["2", "3", "6, 0, 0, 5"] {
        let mut bench = at_the_first_transition_point(termination);
        bench.until("M1", Flag::Pc);
        assert!(bench.position("X") < 100.0, "the blend begins before the end point");
        assert_eq!(bench.bits("M1"), "EN DN PC", "TP2");
        assert!(bench.bits("M2").starts_with("EN DN IP AC"));
        let status = bench.system("XY").motion_status;
        assert_eq!(status & SEEN, cms::MOVE_TRANSITION_STATUS);
        assert_eq!(
            status & (cms::ACCEL_STATUS | cms::DECEL_STATUS),
            0,
            "neither during a blend"
        );
        assert_eq!(
            bench.call(&line("M3", 0.0, 100.0, S_CURVE, "1")),
            OK,
            "there is room again"
        );
        while bench.system("XY").motion_status & cms::MOVE_TRANSITION_STATUS != 0 {
            bench.tick();
        }
        assert_eq!(bench.position("X"), 100.0, "TP3: on the second path");
        bench.until("M3", Flag::Pc);
        assert_eq!(bench.bits("M2"), "EN DN PC", "TP4");
    }
}

#[test]
fn a_late_successor_still_blends() {
    let mut bench = Bench::new();
    bench.execute(&line("M1", 100.0, 0.0, S_CURVE, "3"));
    bench.run(600);
    assert!(bench.axis("X").command[1] < 200.0, "it brakes already");
    bench.execute(&line("M2", 100.0, 100.0, S_CURVE, "1"));
    bench.tick();
    let points = record(&mut bench);
    let missed = nearest(&points, [100.0, 0.0]);
    assert!(missed > 0.1 && missed < 5.0, "{missed}");
    assert_eq!(points.last(), Some(&[100.0, 100.0]));
}

#[test]
fn half_moves_bound_the_tolerance_in_a_sequence() {
    // Ddec = 2.5; L2 = 3 with type 2 and CT 4: min(4, 10, 1.5) = 1.5 (spec/coordinated-instructions.md §27.5, with v 10, d 20).
    let slow = |tag: &str, x: f64, y: f64, termination: &str| {
        format!("MCLM(XY, {tag}, 0, [{x}, {y}], 10, 0, 20, 0, 20, 0, 0, 1, 1, 2, {termination})")
    };
    for (termination, second, next, begins_at) in [
        ("6, 0, 0, 1", 10.0, "1", 9.0),
        ("6, 0, 0, 4", 10.0, "1", 7.5),
        ("3", 10.0, "1", 7.5),
        ("6, 0, 0, 4", 3.0, "6, 0, 0, 4", 8.5),
    ] {
        let mut bench = Bench::new();
        bench.execute(&slow("M1", 10.0, 0.0, termination));
        bench.execute(&slow("M2", 10.0, second, next));
        bench.until("M1", Flag::Pc);
        let x = bench.position("X");
        // The blend may be deferred so that both ramps end together; here they match, or the second is shorter.
        assert!(x >= begins_at - 1e-9, "{termination}: at {x}, not before {begins_at}");
        if second == 10.0 {
            assert!(
                x < begins_at + 0.011,
                "{termination}: at {x}, not later than {begins_at}"
            );
        }
    }
}

#[test]
fn there_and_back_are_one_path() {
    let path = |corners: [[f64; 2]; 3]| {
        let mut bench = Bench::new();
        bench.execute(&line("M0", corners[0][0], corners[0][1], TRAPEZOID, "1"));
        bench.until("M0", Flag::Pc);
        bench.tick();
        bench.execute(&line("M1", corners[1][0], corners[1][1], TRAPEZOID, "3"));
        bench.execute(&line("M2", corners[2][0], corners[2][1], TRAPEZOID, "1"));
        record(&mut bench)
    };
    let there = path([[0.0, 0.0], [100.0, 0.0], [100.0, 100.0]]);
    let back = path([[100.0, 100.0], [100.0, 0.0], [0.0, 0.0]]);
    for point in &there {
        assert!(nearest(&back, *point) < 0.11, "{point:?} within one update of sampling");
    }
}

#[test]
fn collinear_moves_stay_on_the_line_and_change_speed_where_the_type_says() {
    let two = |termination: &str, v1: f64, v2: f64| {
        let mut bench = Bench::new();
        let at = |tag: &str, x: f64, v: f64, t: &str| {
            format!("MCLM(XY, {tag}, 0, [{x}, 0], {v}, 0, 2000, 0, 2000, 0, 0, 1, 1, 2, {t})")
        };
        bench.execute(&at("M1", 100.0, v1, termination));
        bench.execute(&at("M2", 200.0, v2, "1"));
        bench.until("M1", Flag::Pc);
        let handed_over = bench.position("X");
        let mut at_end = (0.0, 0.0);
        let mut before = bench.axis("X").command;
        while bench.control("M2").has(Flag::Ip) {
            assert_eq!(bench.position("Y"), 0.0);
            assert_eq!(
                bench.system("XY").motion_status & cms::MOVE_TRANSITION_STATUS,
                0,
                "never off the path"
            );
            bench.tick();
            let now = bench.axis("X").command;
            assert!(
                (now[1] - before[1]).abs() <= 2.000_001,
                "{termination}: a step in speed"
            );
            if before[0] <= 100.0 && now[0] > 100.0 {
                at_end = (before[1], now[1]);
            }
            before = now;
        }
        assert_eq!(bench.position("X"), 200.0);
        (handed_over, at_end.0)
    };
    // (type, v1, v2) -> (where M1 completes, speed at its programmed end)
    for (termination, v1, v2, completes, speed) in [
        ("6, 0, 0, 10", 200.0, 100.0, 90.0, 100.0),
        ("6, 0, 0, 10", 100.0, 200.0, 90.0, 200.0),
        ("3", 200.0, 100.0, 92.5, 100.0),
        ("3", 100.0, 200.0, 100.0, 100.0),
        ("4", 200.0, 100.0, 92.5, 100.0),
        ("5", 200.0, 100.0, 92.5, 100.0),
        ("5", 100.0, 200.0, 100.0, 100.0),
        ("1", 200.0, 100.0, 100.0, 0.0),
    ] {
        let (x, v) = two(termination, v1, v2);
        assert!(
            (0.0..0.21).contains(&(x - completes)),
            "{termination} {v1} {v2}: completes at {x}, not {completes}"
        );
        assert!(
            (v - speed).abs() < 2.1,
            "{termination} {v1} {v2}: {v} at the end, not {speed}"
        );
    }
}

#[test]
fn a_stop_goes_on_along_the_moves_that_the_speed_was_kept_for() {
    let mut bench = Bench::replacing("name = \"XY\"", "name = \"XY\"\nqueue_depth = 10");
    bench.execute("MCLM(XY, M1, 0, [100, 0], 200, 0, 2000, 0, 2000, 0, 0, 1, 1, 2, 4)");
    bench.execute("MCCM(XY, M2, 0, [100, 100], 1, [100, 50], 1, 200, 0, 2000, 0, 2000, 0, 0, 100, 100, 2, 4)");
    bench.execute("MCLM(XY, M3, 0, [0, 100], 200, 0, 2000, 0, 2000, 0, 0, 1, 1, 2, 1)");
    while bench.position("X") < 98.0 {
        bench.tick();
    }
    // From 200 at 500 units/s² it takes 40 units to rest.
    bench.execute("MCS(XY, S, CoordinatedMove, Yes, 500, Unitspersec2)");
    while !bench.control("S").has(Flag::Pc) {
        bench.tick();
        let (x, y) = (bench.position("X"), bench.position("Y"));
        let off = if x <= 100.0 && y < 50.0 {
            y
        } else {
            (x - 100.0).hypot(y - 50.0) - 50.0
        };
        assert!(off.abs() < 1e-9, "{x} {y}");
    }
    let angle = (bench.position("X") - 100.0).atan2(50.0 - bench.position("Y"));
    assert!((angle * 50.0 - 38.0).abs() < 0.5, "{angle}");
}

#[test]
fn tangent_contours_keep_the_speed_and_corners_do_not() {
    let mut bench = Bench::new();
    bench.execute(&line("M1", 100.0, 0.0, S_CURVE, "4"));
    bench.execute("MCCM(XY, M2, 0, [100, 100], 1, [100, 50], 1, 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 4)");
    bench.until("M1", Flag::Pc);
    assert!((bench.system("XY").path_speed - 200.0).abs() < 1e-9);
    bench.until("M2", Flag::Pc);
    assert_eq!((bench.position("X"), bench.position("Y")), (100.0, 100.0));

    // A corner of 90 degrees: each axis may change its speed by 10000 · 1 ms = 10 units/s.
    for constrained in ["4", "5"] {
        let mut bench = Bench::new();
        bench.execute(&line("M1", 100.0, 0.0, S_CURVE, constrained));
        bench.execute(&line("M2", 100.0, 100.0, S_CURVE, "1"));
        bench.until("M1", Flag::Pc);
        let points = record(&mut bench);
        assert!(
            points.iter().all(|[x, _]| (x - 100.0).abs() < 1e-9),
            "the corner is not cut"
        );
        assert!(bench.now() < 1400, "faster than a stop");
    }
}

#[test]
fn unconstrained_contours_overshoot_an_end_that_cannot_be_met() {
    let mut bench = Bench::new();
    bench.execute(&line("M1", 100.0, 0.0, TRAPEZOID, "5"));
    bench.execute(&line("M2", 103.0, 0.0, TRAPEZOID, "1"));
    let points = record(&mut bench);
    let furthest = points.iter().map(|[x, _]| *x).fold(0.0, f64::max);
    assert!(
        (furthest - 110.0).abs() < 1e-2,
        "200 units/s need 10 units to stop: {furthest}"
    );
    assert_eq!((bench.position("X"), bench.bits("M2").as_str()), (103.0, "EN DN PC"));
    let mut bench = Bench::new();
    bench.execute(&line("M1", 100.0, 0.0, TRAPEZOID, "4"));
    bench.execute(&line("M2", 103.0, 0.0, TRAPEZOID, "1"));
    let points = record(&mut bench);
    assert!(points.iter().all(|[x, _]| *x <= 103.0), "type 4 slows down in time");
}

#[test]
fn a_merge_takes_over_at_once() {
    for (profile, merge) in [(S_CURVE, "CoordinatedMotion"), (TRAPEZOID, "AllMotion")] {
        let mut bench = Bench::new();
        bench.execute(&line("M1", 500.0, 0.0, profile, "1"));
        bench.execute(&line("M2", 500.0, 500.0, profile, "1"));
        bench.run(500);
        let speed = bench.axis("X").command[1];
        bench.execute(&line("M3", 100.0, 200.0, profile, &format!("1, {merge}")));
        assert_eq!(
            (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
            ("EN DN", "EN DN")
        );
        assert_eq!(bench.bits("M3"), "EN DN IP AC");
        let points = record(&mut bench);
        assert!(
            ((points[1][0] - points[0][0]) / 0.001 - speed).abs() < 5.0,
            "the velocity is continuous"
        );
        assert_eq!(points.last(), Some(&[100.0, 200.0]));
        assert!(peak_acceleration(&points, 0.001) <= 4000.0 * 1.05);
        assert_eq!(bench.bits("M3"), "EN DN PC");
    }
}

#[test]
fn a_merge_along_the_motion_keeps_its_speed() {
    let mut bench = Bench::new();
    bench.execute(&line("M1", 500.0, 0.0, S_CURVE, "1"));
    bench.run(500);
    bench.execute("MCLM(XY, M2, 0, [300, 0], 100, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1, CoordinatedMotion, Current)");
    bench.run(300);
    assert!(
        (bench.axis("X").command[1] - 200.0).abs() < 1e-9,
        "Merge Speed Current is the present speed"
    );
    bench.until("M2", Flag::Pc);
    assert_eq!(bench.position("X"), 300.0);
}

#[test]
fn a_merge_to_the_present_position_comes_back_to_it() {
    let mut bench = Bench::new();
    bench.execute(&line("M1", 500.0, 0.0, S_CURVE, "1"));
    bench.run(500);
    let here = bench.position("X");
    bench.execute("MCLM(XY, M2, 1, [0, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1, CoordinatedMotion)");
    bench.until("M2", Flag::Pc);
    assert_eq!(bench.position("X"), here);
}

#[test]
fn all_motion_takes_axes_from_another_system_and_brakes_the_rest() {
    let mut bench = Bench::new();
    bench.execute("MCLM(CS2, M1, 0, [500, 0, 500], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)");
    bench.run(500);
    let shared = "MCLM(XY, M2, 0, [0, 0], 200, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1";
    assert_eq!(bench.call(&format!("{shared}, CoordinatedMotion)")), (52, 0));
    assert_eq!(bench.call(&format!("{shared}, AllMotion)").replace("M2", "M3")), OK);
    assert_eq!(bench.bits("M1"), "EN DN");
    bench.until("M3", Flag::Pc);
    bench.until_rest();
    assert_eq!((bench.position("X"), bench.axis("S").command[1]), (0.0, 0.0));
}

#[test]
fn a_stop_inside_a_blend_stops_both_moves() {
    let mut bench = Bench::new();
    bench.execute(&line("M1", 100.0, 0.0, S_CURVE, "3"));
    bench.execute(&line("M2", 100.0, 100.0, S_CURVE, "1"));
    bench.until("M1", Flag::Pc);
    bench.run(60);
    bench.execute("MCS(XY, S1, CoordinatedMove)");
    bench.until("S1", Flag::Pc);
    assert_eq!((bench.axis("X").command[1], bench.axis("Y").command[1]), (0.0, 0.0));
    assert_eq!(bench.bits("M2"), "EN DN");
    assert_eq!(bench.system("XY").motion_status & cms::MOVE_TRANSITION_STATUS, 0);
}

#[test]
fn every_update_period_gives_one_trajectory_through_a_sequence() {
    let run = |period_ms: &str, every: u64| {
        let period = format!("coarse_update_period_ms = {period_ms}");
        let mut bench = Bench::replacing("coarse_update_period_ms = 1.0", &period);
        let mut deep = Vec::new();
        bench.execute(&line("M1", 100.0, 0.0, S_CURVE, "3"));
        bench.execute(&line("M2", 100.0, 100.0, S_CURVE, "6, 0, 0, 3"));
        for _ in 0..400 {
            deep.push([bench.position("X"), bench.position("Y")]);
            bench.run(every);
        }
        deep
    };
    let reference = run("1.0", 4);
    for (period, every) in [("0.25", 16), ("4.0", 1), ("2.0", 2)] {
        for (a, b) in reference.iter().zip(run(period, every)) {
            assert!(
                (a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9,
                "{period} ms: {a:?} {b:?}"
            );
        }
    }
}

#[test]
fn a_deep_queue_takes_its_configured_number_of_moves() {
    let mut bench = Bench::replacing("name = \"XY\"", "name = \"XY\"\nqueue_depth = 20");
    for place in 0..21 {
        let tag = format!("M{place}");
        assert_eq!(
            bench.call(&line(&tag, 10.0 * f64::from(place + 1), 0.0, S_CURVE, "4")),
            OK
        );
    }
    assert_eq!(bench.call(&line("M21", 0.0, 0.0, S_CURVE, "4")), (43, 0));
    let status = bench.system("XY").motion_status;
    assert_ne!(status & cms::MOVE_PENDING_QUEUE_FULL_STATUS, 0);
    bench.until("M0", Flag::Pc);
    assert_eq!(
        bench.system("XY").motion_status & cms::MOVE_PENDING_QUEUE_FULL_STATUS,
        0
    );
    bench.until("M20", Flag::Pc);
    assert_eq!(bench.position("X"), 210.0);
    // One profile over the whole length would take 1.25 s; a stop after each of the 21 pieces, 3 s.
    assert!(bench.now() < 2200, "{} ms", bench.now());
}

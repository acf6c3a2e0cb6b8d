//! MCCP, MCSV, MAPC and MATC: profiles in tags, the slave's positions, the end of a cam, waiting cams, and the bits
//! (spec/axis-and-data-types.md §3.9).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::motion_status::{
    MASTER_OFFSET_MOVE_LOCK_STATUS, MASTER_OFFSET_MOVE_STATUS, POSITION_CAM_LOCK_STATUS, POSITION_CAM_PENDING_STATUS,
    POSITION_CAM_STATUS, TIME_CAM_LOCK_STATUS, TIME_CAM_PENDING_STATUS, TIME_CAM_STATUS,
};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::machine;

/// The operands from Speed on: a trapezoid at 100 units/s.
const TRAPEZOID: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
/// The operands from Speed on: an S-curve at 100 units/s.
const S_CURVE: &str = "100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2";
const LINEAR: u8 = 0;
const CUBIC: u8 = 1;

/// The machine for gears, with cam tags.
fn with_cams(period_ms: f64) -> Bench {
    let tags = "[[tag]]\nname = \"Cam\"\ntype = \"CAM[8]\"\n[[tag]]\nname = \"P1\"\ntype = \"CAM_PROFILE[8]\"\n\
                [[tag]]\nname = \"P2\"\ntype = \"CAM_PROFILE[8]\"\n[[tag]]\nname = \"Short\"\ntype = \"CAM_PROFILE[2]\"\n\
                [[tag]]\nname = \"Y\"\ntype = \"REAL[3]\"\n\
                [[data_type]]\nname = \"Recipe\"\nmembers = [{ name = \"N\", type = \"DINT\" }, \
                { name = \"Points\", type = \"CAM[4]\" }, { name = \"Curve\", type = \"CAM_PROFILE[4]\" }]\n\
                [[tag]]\nname = \"Mix\"\ntype = \"Recipe[2]\"\n";
    Bench::with(&format!("{}{tags}", machine(period_ms)))
}

fn bench() -> Bench {
    with_cams(1.0)
}

/// Calculates a profile of points into a tag.
fn calculate(bench: &mut Bench, profile: &str, points: &[(f64, f64, u8)]) {
    bench.cam("Cam", points);
    let call = format!("MCCP(Calc, Cam, {}, 0, 0, {profile})", points.len());
    assert_eq!(bench.call(&call), OK);
}

#[track_caller]
fn near(is: f64, expected: f64, why: &str) {
    assert!((is - expected).abs() < 1e-9, "{why}: {is} is not {expected}");
}

/// Whether a position cam is under way, locked, pending.
fn position_cam(bench: &Bench, axis: &str) -> (bool, bool, bool) {
    let word = bench.axis(axis).motion_status;
    let has = |bit| word & bit != 0;
    (
        has(POSITION_CAM_STATUS),
        has(POSITION_CAM_LOCK_STATUS),
        has(POSITION_CAM_PENDING_STATUS),
    )
}

fn time_cam(bench: &Bench, axis: &str) -> (bool, bool, bool) {
    let word = bench.axis(axis).motion_status;
    let has = |bit| word & bit != 0;
    (
        has(TIME_CAM_STATUS),
        has(TIME_CAM_LOCK_STATUS),
        has(TIME_CAM_PENDING_STATUS),
    )
}

/// A move from rest to rest over `length`: `rise · (3u² − 2u³)`.
fn smooth(x: f64, length: f64, rise: f64) -> f64 {
    let u = (x / length).clamp(0.0, 1.0);
    rise * u * u * (3.0 - 2.0 * u)
}

#[test]
fn profiles_are_calculated_into_tags() {
    let mut bench = bench();
    assert_eq!(bench.read("P1[0].Status"), 0.0);
    let mut points = vec![
        (0.0, 0.0, CUBIC),
        (10.0, 5.0, CUBIC),
        (20.0, 20.0, LINEAR),
        (30.0, 25.0, LINEAR),
    ];
    calculate(&mut bench, "P1", &points);
    assert_eq!(bench.bits("Calc"), "EN DN");
    assert_eq!(
        (
            bench.read("P1[0].Status"),
            bench.read("P1[3].Status"),
            bench.read("P1[4].Status")
        ),
        (2.0, 2.0, 0.0)
    );
    // At the points, in a line, and between the points of the spline, whose slopes are 0, m and 0.5: 3(0.5+1.5) = 4m + 0.5.
    let m = (3.0 * 2.0 - 0.5) / 4.0;
    #[rustfmt::skip]
    let cases = [
        // master, slave,                                     slope, its derivative
        (0.0,      0.0,                                       0.0,   (6.0 * 0.5 - 2.0 * m) / 10.0),
        (10.0,     5.0,                                       m,     (6.0 * 1.5 - 4.0 * m - 1.0) / 10.0),
        (5.0,      2.5 - 10.0 * m / 8.0,                      1.5 * 0.5 - 0.25 * m, m / 10.0),
        (25.0,     22.5,                                      0.5,   0.0),
        (30.0,     25.0,                                      0.5,   0.0),
    ];
    for (master, slave, slope, curvature) in cases {
        assert_eq!(bench.call(&format!("MCSV(V, P1, {master}, Y[0], Y[1], Y[2])")), OK);
        for (place, expected) in [slave, slope, curvature].into_iter().enumerate() {
            let is = bench.read(&format!("Y[{place}]"));
            assert!(
                (is - expected).abs() < 1e-5,
                "{master}, {place}: {is} is not {expected}"
            );
        }
    }
    // An omitted operand is not written.
    bench.write("Y[0]", 7.0);
    assert_eq!(bench.call("MCSV(V, P1, 5, 0, Y[1], None)"), OK);
    assert_eq!(bench.read("Y[0]"), 7.0);
    // A shorter profile leaves no point of the longer one.
    points.truncate(2);
    calculate(&mut bench, "P1", &points);
    assert_eq!((bench.read("P1[1].Status"), bench.read("P1[2].Status")), (2.0, 0.0));
    assert_eq!(bench.call("MCSV(V, P1, 11, Y[0], Y[1], Y[2])"), (13, 2));
    // Members of structures, and parts of arrays.
    for (place, x) in [0.0, 1.0].into_iter().enumerate() {
        bench.write(&format!("Mix[1].Points[{place}].Master"), x);
        bench.write(&format!("Mix[1].Points[{place}].Slave"), 3.0 * x);
    }
    assert_eq!(bench.call("MCCP(Calc, Mix[1].Points, 2, 0, 0, Mix[1].Curve[2])"), OK);
    assert_eq!(bench.call("MCSV(V, Mix[1].Curve[2], 0.5, Y[0], 0, 0)"), OK);
    assert_eq!(bench.read("Y[0]"), 1.5);
    assert_eq!(bench.call("MCSV(V, Mix[0].Curve, 0.5, Y[0], 0, 0)"), (32, 0));
}

#[test]
fn invalid_points_make_no_profile() {
    let rising: &[(f64, f64, u8)] = &[(0.0, 0.0, CUBIC), (1.0, 1.0, CUBIC), (2.0, 0.0, LINEAR)];
    let with = |place: usize, point: (f64, f64, u8)| {
        let mut points = rising.to_vec();
        points[place] = point;
        points
    };
    #[rustfmt::skip]
    let cases = [
        // why,                         points,                            length, profile,   error,    SEGMENT
        ("one point",                   rising.to_vec(),                   1,      "P1",      (26, 0),  0),
        ("more than there are",         rising.to_vec(),                   9,      "P1",      (26, 0),  0),
        ("no room for all",             rising.to_vec(),                   3,      "Short",   (27, 0),  0),
        ("no room behind an element",   rising.to_vec(),                   3,      "P1[6]",   (27, 0),  0),
        ("a type",                      with(1, (1.0, 1.0, 2)),            3,      "P1",      (28, 1),  1),
        ("the type of the last point",  with(2, (2.0, 1.0, 9)),            3,      "P1",      (28, 2),  2),
        ("no rise",                     with(2, (1.0, 1.0, CUBIC)),        3,      "P1",      (29, 2),  2),
        ("a master that is no number",  with(0, (f64::NAN, 1.0, CUBIC)),   3,      "P1",      (29, 1),  1),
        ("a slave that is no number",   with(1, (1.0, f64::NAN, CUBIC)),   3,      "P1",      (13, 1),  1),
        ("they end before that",        with(2, (1.0, 1.0, CUBIC)),        2,      "P1",      OK,       0),
    ];
    for (why, points, length, profile, expected, segment) in cases {
        let mut bench = bench();
        bench.cam("Cam", &points);
        assert_eq!(
            bench.call(&format!("MCCP(Calc, Cam, {length}, 0, 0, {profile})")),
            expected,
            "{why}"
        );
        let shown = bench.control("Calc");
        assert_eq!(
            (shown.segment, bench.read("P1[0].Status")),
            (segment, if expected == OK { 2.0 } else { 0.0 }),
            "{why}"
        );
    }
    let mut bench = bench();
    calculate(&mut bench, "P1", rising);
    assert_eq!(bench.call("MCCP(Calc, Cam, 1, 0, 0, P1)"), (26, 0));
    assert_eq!(bench.read("P1[0].Status"), 2.0, "what was there is there still");
}

#[test]
fn a_slave_is_a_function_of_its_master_at_every_period() {
    // A cubic over 10 units of the master, entered at its beginning, scaled, with the master on its way there and back.
    for period in [0.25, 1.0, 4.0] {
        for (direction, sign) in [("Same", 1.0), ("Opposite", -1.0)] {
            let mut bench = with_cams(period);
            calculate(&mut bench, "P1", &[(0.0, 0.0, CUBIC), (10.0, 4.0, CUBIC)]);
            let cam = format!(
                "MAPC(A1, B1, C, {direction}, P1, 2, 1.5, Persistent, Immediate, 0, 0, Command, Bidirectional)"
            );
            assert_eq!(bench.call(&cam), OK);
            for to in [25.0, 1.3, 16.7, -2.0] {
                bench.call(&format!("MAM(B1, M, 0, {to}, {S_CURVE})"));
                while !bench.control("M").has(Flag::Pc) {
                    bench.tick();
                    let [position, velocity, _] = bench.axis("B1").command;
                    let x = position / 1.5;
                    near(
                        bench.position("A1"),
                        2.0 * sign * smooth(x, 10.0, 4.0),
                        &format!("{period} ms at {x}"),
                    );
                    if (0.0..10.0).contains(&x) {
                        let u = x / 10.0;
                        let slope = 4.0 / 10.0 * 6.0 * u * (1.0 - u);
                        near(
                            bench.axis("A1").command[1],
                            2.0 * sign * slope * velocity / 1.5,
                            "velocity",
                        );
                    }
                }
            }
            assert_eq!(
                position_cam(&bench, "A1"),
                (true, false, false),
                "outside of its profile"
            );
            assert_eq!(bench.bits("C"), "EN DN IP");
        }
    }
}

#[test]
fn once_ends_at_the_end_of_its_profile() {
    let run = |entry: f64, to: f64| {
        let mut bench = bench();
        calculate(
            &mut bench,
            "P1",
            &[(0.0, 0.0, CUBIC), (20.0, 7.0, LINEAR), (50.0, 10.0, CUBIC)],
        );
        let cam = format!("MAPC(A1, B1, C, Same, P1, 1, 1, Once, Immediate, 0, {entry}, Command, Bidirectional)");
        assert_eq!(bench.call(&cam), OK);
        assert_eq!(position_cam(&bench, "A1"), (true, true, false));
        bench.call(&format!("MAM(B1, M, 0, {to}, {TRAPEZOID})"));
        bench.until("M", Flag::Pc);
        bench
    };
    #[rustfmt::skip]
    let cases = [
        // why,                     entry, master to, slave, ended
        ("to its end exactly",      0.0,   50.0,      10.0,  true),
        ("beyond its end",          0.0,   51.0,      10.0,  true),
        ("not as far",              0.0,   30.0,      8.0,   false),
        ("from the middle",         20.0,  40.0,      3.0,   true),
        ("back beyond its start",   20.0,  -25.0,     -7.0,  true),
        ("from its end, backwards", 50.0,  -10.0,     -1.0,  false),
        ("from its end, forwards",  50.0,  10.0,      0.0,   true),
    ];
    for (why, entry, to, slave, ended) in cases {
        let bench = run(entry, to);
        near(bench.position("A1"), slave, why);
        let bits = if ended { "EN DN PC" } else { "EN DN IP" };
        assert_eq!(bench.bits("C"), bits, "{why}");
        assert_eq!(position_cam(&bench, "A1"), (!ended, !ended, false), "{why}");
    }
    // The slave does not come back with the master.
    let mut bench = run(0.0, 60.0);
    let segments: Vec<i32> = bench
        .events
        .iter()
        .filter(|(tag, event)| tag == "C" && event.set | event.clear == 0)
        .map(|(_, event)| event.segment)
        .collect();
    assert_eq!(segments, [1]);
    bench.call(&format!("MAM(B1, M, 0, 10, {TRAPEZOID})"));
    bench.until("M", Flag::Pc);
    assert_eq!(bench.position("A1"), 10.0);
}

#[test]
fn continuous_repeats_both_ways() {
    let mut bench = bench();
    calculate(&mut bench, "P1", &[(5.0, 1.0, CUBIC), (25.0, 5.0, CUBIC)]);
    let cam = "MAPC(A1, B1, C, Same, P1, 1, 1, Continuous, Immediate, 0, 5, Command, Bidirectional)";
    assert_eq!(bench.call(cam), OK);
    for to in [113.0, -77.0, 40.0] {
        bench.call(&format!("MAM(B1, M, 0, {to}, {S_CURVE})"));
        while !bench.control("M").has(Flag::Pc) {
            bench.tick();
            let master = bench.position("B1");
            let turns = (master / 20.0).floor();
            near(
                bench.position("A1"),
                4.0 * turns + smooth(master - 20.0 * turns, 20.0, 4.0),
                "at {master}",
            );
            assert_eq!(position_cam(&bench, "A1"), (true, true, false));
        }
    }
    near(bench.position("A1"), 8.0, "two turns");
}

#[test]
fn locks_are_met_where_they_lie() {
    #[rustfmt::skip]
    let cases = [
        // schedule,      master there first, then to, slave, locked at the end
        ("Forward Only",  0.0,   30.0,  4.0,  true),
        ("Forward Only",  40.0,  10.0,  0.0,  false),
        ("Reverse Only",  40.0,  10.0, -4.0,  true),
        ("Reverse Only",  0.0,   30.0,  0.0,  false),
        ("Bidirectional", 0.0,   30.0,  4.0,  true),
        ("Bidirectional", 40.0,  10.0, -4.0,  true),
    ];
    for (schedule, first, to, slave, locked) in cases {
        for period in [0.25, 1.0, 4.0] {
            let mut bench = with_cams(period);
            calculate(&mut bench, "P1", &[(-100.0, 0.0, LINEAR), (100.0, 80.0, LINEAR)]);
            bench.call(&format!("MAM(B1, M, 0, {first}, {TRAPEZOID})"));
            bench.until("M", Flag::Pc);
            let schedule = schedule.replace(' ', "");
            let cam = format!("MAPC(A1, B1, C, Same, P1, 1, 1, Once, {schedule}, 20, 0, Command, Bidirectional)");
            assert_eq!(bench.call(&cam), OK);
            assert_eq!(position_cam(&bench, "A1"), (true, false, false), "{schedule}: it waits");
            bench.call(&format!("MAM(B1, M, 0, {to}, {TRAPEZOID})"));
            bench.until("M", Flag::Pc);
            near(bench.position("A1"), slave, &format!("{schedule} at {period} ms"));
            assert_eq!(position_cam(&bench, "A1"), (true, locked, false), "{schedule}");
        }
    }
    // On a rotary master a lock lies on every turn, and is a position of it.
    let mut bench = bench();
    calculate(&mut bench, "P1", &[(0.0, 0.0, LINEAR), (100.0, 50.0, LINEAR)]);
    let cam =
        |lock: &str| format!("MAPC(A1, TURN, C, Same, P1, 1, 1, Once, ForwardOnly, {lock}, 0, Command, Bidirectional)");
    assert_eq!(bench.call(&cam("360")), (13, 9));
    assert_eq!(bench.call(&format!("MAM(TURN, M, 1, 300, {TRAPEZOID})")), OK);
    bench.until("M", Flag::Pc);
    assert_eq!(bench.call(&cam("10")), OK);
    bench.call(&format!("MAM(TURN, M, 1, 90, {TRAPEZOID})"));
    bench.until("M", Flag::Pc);
    near(bench.position("A1"), 10.0, "20 degrees behind the lock");
    // The redefinition changes the displayed position, not the real one.
    bench.call("MRP(B1, R, 0, 1, 1000)");
    assert_eq!(
        bench.call("MAPC(C1, B1, D, Same, P1, 1, 1, Once, ForwardOnly, 1010, 0, Command, Bidirectional)"),
        OK
    );
    bench.tick();
    bench.call("MRP(B1, R, 0, 1, 0)");
    bench.call(&format!("MAM(B1, M, 1, 30, {TRAPEZOID})"));
    bench.until("M", Flag::Pc);
    near(bench.position("C1"), 10.0, "the lock is where it was");
}

#[test]
fn one_way_is_followed_until_the_master_is_back() {
    for (way, sign) in [("Forward Only", 1.0), ("Reverse Only", -1.0)] {
        let mut bench = bench();
        calculate(&mut bench, "P1", &[(-100.0, 0.0, LINEAR), (100.0, 100.0, LINEAR)]);
        let way = way.replace(' ', "");
        let cam = format!("MAPC(A1, B1, C, Same, P1, 1, 1, Once, Immediate, 0, 0, Command, {way})");
        assert_eq!(bench.call(&cam), OK);
        #[rustfmt::skip]
        let legs = [
            // master, slave, locked while it moves, in the end
            (40.0,     20.0,  true),
            (10.0,     20.0,  false),
            (30.0,     20.0,  false),
            (60.0,     30.0,  true),
        ];
        for (to, slave, locked) in legs {
            bench.call(&format!("MAM(B1, M, 0, {}, {TRAPEZOID})", sign * to));
            bench.until("M", Flag::Pc);
            near(bench.position("A1"), sign * slave, &format!("{way} at {to}"));
            assert_eq!(position_cam(&bench, "A1"), (true, locked, false), "{way} at {to}");
        }
    }
}

#[test]
fn a_pending_cam_takes_over_where_the_other_ends() {
    for period in [0.25, 1.0, 4.0] {
        for mode in ["Once", "Continuous", "Persistent"] {
            let mut bench = with_cams(period);
            calculate(&mut bench, "P1", &[(0.0, 0.0, LINEAR), (20.0, 10.0, LINEAR)]);
            calculate(&mut bench, "P2", &[(0.0, 0.0, LINEAR), (30.0, 45.0, LINEAR)]);
            let cam = |tag: &str, profile: &str, mode: &str, schedule: &str| {
                format!("MAPC(A1, B1, {tag}, Same, {profile}, 1, 1, {mode}, {schedule}, 0, 0, Command, Bidirectional)")
            };
            assert_eq!(bench.call(&cam("C", "P1", mode, "Immediate")), OK);
            // A pending cam replaces one that waits.
            assert_eq!(bench.call(&cam("Old", "P1", "Once", "Pending")), OK);
            assert_eq!(bench.call(&cam("D", "P2", "Once", "Pending")), OK);
            assert_eq!(
                (bench.bits("Old").as_str(), bench.bits("D").as_str()),
                ("EN DN", "EN DN IP")
            );
            assert_eq!(position_cam(&bench, "A1"), (true, true, true));
            assert_eq!((bench.read("P1[0].Status"), bench.read("P2[0].Status")), (3.0, 3.0));
            assert_eq!(bench.call("MCCP(Calc, Cam, 2, 0, 0, P2)"), (31, 0));
            bench.call(&format!("MAM(B1, M, 0, 40, {S_CURVE})"));
            while !bench.control("M").has(Flag::Pc) {
                bench.tick();
                let master = bench.position("B1");
                let slave = if master <= 20.0 {
                    0.5 * master
                } else {
                    10.0 + 1.5 * (master - 20.0)
                };
                near(bench.position("A1"), slave, &format!("{mode} at {period} ms"));
            }
            assert_eq!(
                (bench.bits("C").as_str(), bench.bits("D").as_str()),
                ("EN DN PC", "EN DN IP")
            );
            assert_eq!(position_cam(&bench, "A1"), (true, true, false));
            assert_eq!((bench.read("P1[0].Status"), bench.read("P2[0].Status")), (2.0, 3.0));
            bench.call(&format!("MAM(B1, M, 0, 60, {S_CURVE})"));
            bench.until("M", Flag::Pc);
            assert_eq!(bench.bits("D"), "EN DN PC");
            near(bench.position("A1"), 55.0, "both");
            assert_eq!(bench.read("P2[0].Status"), 2.0);
        }
    }
    // In reverse the next one is entered at its end. One that is loaded before the first waits for its end too.
    let mut bench = bench();
    calculate(&mut bench, "P1", &[(0.0, 0.0, LINEAR), (20.0, 10.0, LINEAR)]);
    calculate(&mut bench, "P2", &[(0.0, 0.0, LINEAR), (10.0, 15.0, LINEAR)]);
    let common = "0, 10, Command, Bidirectional";
    assert_eq!(
        bench.call(&format!("MAPC(A1, B1, D, Same, P2, 1, 1, Once, Pending, {common})")),
        OK
    );
    assert_eq!(position_cam(&bench, "A1"), (false, false, true));
    assert_eq!(
        bench.call(&format!("MAPC(A1, B1, C, Same, P1, 1, 1, Once, Immediate, {common})")),
        OK
    );
    bench.call(&format!("MAM(B1, M, 0, -15, {TRAPEZOID})"));
    bench.until("M", Flag::Pc);
    near(bench.position("A1"), -5.0 - 7.5, "back through both");
    assert_eq!(position_cam(&bench, "A1"), (true, true, false));
}

#[test]
fn time_cams() {
    for period in [0.25, 1.0, 4.0] {
        let mut bench = with_cams(period);
        calculate(&mut bench, "P1", &[(0.0, 0.0, CUBIC), (0.125, 5.0, CUBIC)]);
        calculate(&mut bench, "P2", &[(0.0, 0.0, LINEAR), (0.0625, 1.0, LINEAR)]);
        // Twice as far, in three times the time.
        assert_eq!(
            bench.call("MATC(A1, C, Same, P1, 2, 3, Once, Immediate, 0, None, TimeDrivenMode)"),
            OK
        );
        assert_eq!(bench.call("MATC(A1, D, Opposite, P2, 1, 1, Continuous, Pending)"), OK);
        assert_eq!(time_cam(&bench, "A1"), (true, true, true));
        let ticks = |seconds: f64| (seconds * 1000.0 / period).round() as u64;
        while bench.now() < ticks(0.5) {
            bench.tick();
            let t = bench.now() as f64 * period / 1000.0;
            let slave = if t <= 0.375 {
                smooth(t / 3.0, 0.125, 10.0)
            } else {
                10.0 - 16.0 * (t - 0.375)
            };
            near(bench.position("A1"), slave, &format!("{t} s at {period} ms"));
        }
        assert_eq!(
            (bench.bits("C").as_str(), bench.bits("D").as_str()),
            ("EN DN PC", "EN DN IP")
        );
        assert_eq!(time_cam(&bench, "A1"), (true, true, false));
        // The end of the last one is its end to the last bit.
        assert_eq!(bench.call("MAS(A1, S, TimeCam)"), OK);
        bench.until("S", Flag::Pc);
        assert_eq!(
            (bench.bits("D").as_str(), time_cam(&bench, "A1")),
            ("EN DN", (false, false, false))
        );
        let before = bench.position("A1");
        assert_eq!(bench.call("MATC(A1, C, Reverse, P2, 1, 1, Once, Immediate)"), OK);
        bench.until_rest();
        near(bench.position("A1"), before + 1.0, "the reverse of the opposite");
        assert_eq!(bench.bits("C"), "EN DN PC");
    }
}

/// Why, the earlier calls, the call, and its ERR and EXERR.
type Refusal = (&'static str, Vec<String>, String, (i16, i8));

#[test]
fn invalid_cams_are_refused() {
    let mapc = |slave: &str, master: &str, rest: &str| format!("MAPC({slave}, {master}, C, {rest})");
    let good = "Same, P1, 1, 1, Once, Immediate, 0, 0, Command, Bidirectional";
    let pending = "Same, P1, 1, 1, Once, Pending, 0, 0, Command, Bidirectional";
    let gear = "MAG(B1, A1, G, Same, 1, 1, 1, Command, Real, Disabled)";
    let first = mapc("A1", "B1", good).replace(", C,", ", First,");
    #[rustfmt::skip]
    let cases: Vec<Refusal> = vec![
        ("direction",            vec![], mapc("A1", "B1", "4, P1, 1, 1, 0, 0, 0, 0, 0, 0"), (13, 3)),
        ("slave scaling",        vec![], mapc("A1", "B1", "0, P1, 0, 1, 0, 0, 0, 0, 0, 0"), (13, 5)),
        ("master scaling",       vec![], mapc("A1", "B1", "0, P1, 1, -1, 0, 0, 0, 0, 0, 0"), (13, 6)),
        ("mode",                 vec![], mapc("A1", "B1", "0, P1, 1, 1, 3, 0, 0, 0, 0, 0"), (13, 7)),
        ("schedule",             vec![], mapc("A1", "B1", "0, P1, 1, 1, 0, 5, 0, 0, 0, 0"), (13, 8)),
        ("lock position",        vec![], mapc("A1", "TURN", "0, P1, 1, 1, 0, 2, -1, 0, 0, 0"), (13, 9)),
        ("entry",                vec![], mapc("A1", "B1", "0, P1, 1, 1, 0, 0, 0, 11, 0, 0"), (13, 10)),
        ("reference",            vec![], mapc("A1", "B1", "0, P1, 1, 1, 0, 0, 0, 0, 2, 0"), (13, 11)),
        ("master direction",     vec![], mapc("A1", "B1", "0, P1, 1, 1, 0, 0, 0, 0, 0, 3"), (13, 12)),
        ("its own master",       vec![], mapc("A1", "A1", good), (10, 0)),
        ("a ring",               vec![gear.into()], mapc("A1", "B1", good), (10, 0)),
        ("no profile",           vec![], mapc("A1", "B1", &good.replace("P1", "P2")), (32, 0)),
        ("a cam already",        vec![first.clone()], mapc("A1", "B1", good), (23, 0)),
        ("another master",       vec![first.clone()], mapc("A1", "C1", pending), (23, 0)),
        ("pending",              vec![first], mapc("A1", "B1", pending), OK),
        ("another than waits",   vec![mapc("A1", "B1", pending).replace(", C,", ", First,")], mapc("A1", "C1", good), (23, 0)),
        ("servo off",            vec!["MSF(P, S)".into()], mapc("P", "B1", good), (5, 0)),
        ("shutdown",             vec!["MASD(A1, S)".into()], mapc("A1", "B1", good), (7, 0)),
        ("a stop",               vec![format!("MAM(A1, M, 0, 500, {TRAPEZOID})"), "MAS(A1, S, All, Yes, 10, 0)".into()],
                                         mapc("A1", "B1", good), (78, 0)),
        ("a master without torque", vec!["MSF(P, S)".into()], mapc("A1", "P", good), OK),
        ("time scaling",         vec![], "MATC(A1, C, 0, P1, 1, 0, 0, 0)".into(), (13, 5)),
        ("persistent",           vec![], "MATC(A1, C, 0, P1, 1, 1, 2, 0)".into(), (13, 6)),
        ("time schedule",        vec![], "MATC(A1, C, 0, P1, 1, 1, 0, 2)".into(), (13, 7)),
        ("a lock in time",       vec![], "MATC(A1, C, 0, P1, 1, 1, 0, 0, 0, 1, 0)".into(), (95, 0)),
        ("no lock with a master", vec![], "MATC(A1, C, 0, P1, 1, 1, 0, 0, 0, 0, 1)".into(), (95, 0)),
        ("no link",              vec![], "MATC(A1, C, 0, P1, 1, 1, 0, 0, 0, 1, 1)".into(), (93, 0)),
        ("no time profile",      vec![], "MATC(A1, C, 0, P2, 1, 1, 0, 0)".into(), (32, 0)),
        ("two time cams",        vec!["MATC(A1, First, 0, P1, 1, 1, 1, 0)".into()], "MATC(A1, C, 0, P1, 1, 1, 0, 0)".into(), (23, 0)),
    ];
    for (why, before, call, expected) in cases {
        let mut bench = bench();
        calculate(&mut bench, "P1", &[(0.0, 0.0, LINEAR), (10.0, 5.0, LINEAR)]);
        for call in &before {
            assert_eq!(bench.call(call), OK, "{why}: {call}");
            bench.run(20);
        }
        assert_eq!(bench.call(&call), expected, "{why}: {call}");
        if expected != OK {
            assert_eq!(bench.bits("C"), "EN ER", "{why}");
        }
    }
}

#[test]
fn instructions_that_end_cams() {
    let end = |call: &str, bits: &str| {
        let mut bench = bench();
        calculate(&mut bench, "P1", &[(0.0, 0.0, LINEAR), (1000.0, 500.0, LINEAR)]);
        for (tag, schedule) in [("C", "Immediate"), ("D", "Pending")] {
            let cam = format!("MAPC(A1, B1, {tag}, Same, P1, 1, 1, Once, {schedule}, 0, 0, Command, Bidirectional)");
            assert_eq!(bench.call(&cam), OK);
        }
        for (tag, schedule) in [("T", "Immediate"), ("U", "Pending")] {
            assert_eq!(
                bench.call(&format!("MATC(A1, {tag}, Same, P1, 1, 100, Once, {schedule})")),
                OK
            );
        }
        bench.call(&format!("MAM(B1, M, 0, 900, {TRAPEZOID})"));
        bench.run(500);
        assert_eq!(bench.read("P1[0].Status"), 6.0);
        assert_eq!(bench.call(call), OK, "{call}");
        bench.run(1500);
        let shown: Vec<String> = ["C", "D", "T", "U"].iter().map(|tag| bench.bits(tag)).collect();
        assert_eq!(shown.join(", "), bits, "{call}");
        bench
    };
    let all = "EN DN, EN DN, EN DN, EN DN";
    let bench = end("MAS(A1, S, All, Yes, 100, 0)", all);
    assert_eq!(
        (position_cam(&bench, "A1"), time_cam(&bench, "A1")),
        ((false, false, false), (false, false, false))
    );
    let mut bench = end(
        "MAS(A1, S, PositionCam, Yes, 100, 0)",
        "EN DN, EN DN, EN DN IP, EN DN IP",
    );
    assert_eq!(bench.bits("S"), "EN DN PC");
    assert_eq!(
        (bench.read("P1[0].Status"), position_cam(&bench, "A1")),
        (4.0, (false, false, false))
    );
    let bench = end("MAS(A1, S, TimeCam, Yes, 100, 0)", "EN DN IP, EN DN IP, EN DN, EN DN");
    assert_eq!(time_cam(&bench, "A1"), (false, false, false));
    end("MASD(A1, S)", all);
    end("MGS(Motion, S, FastStop)", all);
    end(&format!("MAM(A1, S, 0, 0, {TRAPEZOID}, Enabled)"), all);
    end("MSF(P, S)", "EN DN IP, EN DN IP, EN DN IP, EN DN IP");
}

#[test]
fn a_servo_and_the_actual_position_of_one() {
    // A slave of a servo's actual position goes on without a jump when the servo goes off.
    let mut bench = bench();
    calculate(&mut bench, "P1", &[(-1000.0, 0.0, LINEAR), (1000.0, 1000.0, LINEAR)]);
    for (slave, reference) in [("A1", "Actual"), ("C1", "Command")] {
        let cam =
            format!("MAPC({slave}, P, C{slave}, Same, P1, 1, 1, Once, Immediate, 0, 0, {reference}, Bidirectional)");
        assert_eq!(bench.call(&cam), OK);
    }
    bench.call(&format!("MAM(P, M, 0, 90, {TRAPEZOID})"));
    let mut last = [0.0; 2];
    for tick in 0..3000 {
        bench.tick();
        if tick == 400 {
            bench.call("MSF(P, S)");
        }
        for (place, axis) in ["A1", "C1"].into_iter().enumerate() {
            let position = bench.position(axis);
            assert!(
                (position - last[place]).abs() < 0.08,
                "{axis} jumps at {tick}: {position}"
            );
            last[place] = position;
        }
    }
    near(last[0], 0.5 * bench.axis("P").actual[0], "the actual position");
}

#[test]
fn a_time_cam_is_a_function_of_the_way_of_a_master_that_is_linked() {
    // Lock direction and position, where the master goes, how far the cam has gone then, and whether it is locked.
    type Step = (f64, f64, bool);
    type Case<'a> = (&'a str, f64, &'a str, &'a [Step]);
    #[rustfmt::skip]
    let cases: &[Case<'_>] = &[
        ("forward at once",      0.0,  "0, 1", &[(5.0, 5.0, true), (2.0, 5.0, false), (4.0, 5.0, false), (8.0, 8.0, true)]),
        ("in reverse at once",   0.0,  "0, 2", &[(5.0, 0.0, false), (2.0, 3.0, true), (-1.0, 6.0, true), (0.0, 6.0, false)]),
        ("forward, a position",  0.0,  "4, 3", &[(3.0, 0.0, false), (10.0, 6.0, true), (9.0, 6.0, false), (14.0, 10.0, true)]),
        ("in reverse, a position", 9.0, "4, 4", &[(12.0, 0.0, false), (1.0, 3.0, true)]),
        ("standing on it",       4.0,  "4, 3", &[(6.0, 0.0, false), (3.0, 0.0, false), (6.0, 2.0, true)]),
    ];
    for (why, first, lock, steps) in cases {
        for period in [0.25, 4.0] {
            let mut bench = with_cams(period);
            calculate(&mut bench, "P1", &[(0.0, 0.0, CUBIC), (20.0, 8.0, CUBIC)]);
            assert_eq!(bench.call(&format!("MAM(B1, M, 0, {first}, {TRAPEZOID})")), OK);
            bench.until("M", Flag::Pc);
            assert_eq!(bench.call("MDAC(A1, B1, L, TimeCam, Command)"), OK);
            assert_eq!(
                bench.call(&format!(
                    "MATC(A1, C, Opposite, P1, 3, 0.5, Once, Immediate, {lock}, MasterDrivenMode)"
                )),
                OK
            );
            assert_eq!(
                (bench.bits("L").as_str(), bench.bits("C").as_str()),
                ("EN DN IP", "EN DN IP"),
                "{why}"
            );
            for (to, gone, locked) in *steps {
                assert_eq!(bench.call(&format!("MAM(B1, M, 0, {to}, {S_CURVE})")), OK);
                bench.until("M", Flag::Pc);
                // The profile is 10 units of the master long.
                near(
                    bench.position("A1"),
                    -3.0 * smooth(2.0 * gone, 20.0, 8.0),
                    &format!("{why} at {to}"),
                );
                let over = *gone >= 10.0;
                assert_eq!(
                    time_cam(&bench, "A1"),
                    (!over, *locked && !over, false),
                    "{why} at {to}"
                );
                assert_eq!(
                    bench.bits("C"),
                    if over { "EN DN PC" } else { "EN DN IP" },
                    "{why} at {to}"
                );
                assert_eq!(
                    bench.bits("L"),
                    if over { "EN DN IP" } else { "EN DN IP AC" },
                    "{why} at {to}"
                );
            }
        }
    }
}

#[test]
fn calls_while_a_master_driven_time_cam_runs() {
    let start = || {
        let mut bench = bench();
        calculate(&mut bench, "P1", &[(0.0, 0.0, LINEAR), (100.0, 50.0, LINEAR)]);
        assert_eq!(bench.call("MDAC(A1, B1, L, All, Command)"), OK);
        assert_eq!(bench.call("MATC(A1, C, Same, P1, 1, 1, Once, Immediate, 0, 1, 1)"), OK);
        bench
    };
    #[rustfmt::skip]
    let cases = [
        // why,                        call,                                                                  error
        ("pending behind it",          "MATC(A1, D, Same, P1, 1, 1, Once, Pending, 0, 1, 1)",                 OK),
        ("pending at a position",      "MATC(A1, D, Same, P1, 1, 1, Once, Pending, 5, 3, 1)",                 (95, 0)),
        ("pending in time",            "MATC(A1, D, Same, P1, 1, 1, Once, Pending)",                          (23, 0)),
        ("pending the other way",      "MATC(A1, D, Same, P1, 1, 1, Once, Pending, 0, 2, 1)",                 (98, 0)),
        ("a second one",               "MATC(A1, D, Same, P1, 1, 1, Once, Immediate, 0, 1, 1)",               (23, 0)),
        ("what is followed",           "MDAC(A1, B1, D, All, Actual)",                                        (105, 0)),
    ];
    for (why, call, expected) in cases {
        assert_eq!(start().call(call), expected, "{why}");
    }
    // The next one takes over where the master is at the end.
    let mut bench = start();
    assert_eq!(
        bench.call("MATC(A1, D, Opposite, P1, 1, 2, Once, Pending, 0, 1, 1)"),
        OK
    );
    bench.call(&format!("MAM(B1, M, 0, 150, {TRAPEZOID})"));
    bench.until("M", Flag::Pc);
    near(
        bench.position("A1"),
        50.0 - 12.5,
        "half a unit a unit, then a quarter back",
    );
    assert_eq!(
        (bench.bits("C").as_str(), bench.bits("D").as_str()),
        ("EN DN PC", "EN DN IP")
    );
    // A broken link stops it; a stop of it leaves the link.
    for (call, link) in [
        ("MASD(B1, S)", "EN DN"),
        ("MAS(A1, S, TimeCam, Yes, 100, 0)", "EN DN IP"),
        ("MAS(A1, S, All)", "EN DN"),
    ] {
        let mut bench = start();
        bench.call(&format!("MAM(B1, M, 0, 50, {TRAPEZOID})"));
        bench.run(200);
        assert_eq!(bench.bits("L"), "EN DN IP AC");
        assert_eq!(bench.call(call), OK, "{call}");
        bench.run(1000);
        assert_eq!(
            (bench.bits("C").as_str(), bench.bits("L").as_str()),
            ("EN DN", link),
            "{call}"
        );
        assert_eq!(time_cam(&bench, "A1"), (false, false, false), "{call}");
        assert_eq!(bench.axis("A1").command[1], 0.0, "{call}");
    }
}

#[test]
fn a_master_offset_shifts_the_master_position_of_the_cam() {
    for period in [0.25, 4.0] {
        let mut bench = with_cams(period);
        calculate(&mut bench, "P1", &[(0.0, 0.0, CUBIC), (100.0, 40.0, CUBIC)]);
        let cam = "MAPC(A1, B1, C, Same, P1, 1, 1, Once, Immediate, 0, 0, Command, Bidirectional)";
        let offset = |kind: u8, by: f64| format!("MAM(A1, O, {kind}, {by}, {TRAPEZOID})");
        assert_eq!(bench.call(&offset(5, 10.0)), (33, 0));
        assert_eq!(bench.call(cam), OK);
        // While the master stands, while it moves, and one after the other.
        let mut shift = 0.0;
        for (kind, by, to) in [
            (5, 20.0, None),
            (6, -5.0, Some(30.0)),
            (5, 7.5, Some(10.0)),
            (6, 2.5, None),
        ] {
            if let Some(to) = to {
                bench.call(&format!("MAM(B1, M, 0, {to}, {S_CURVE})"));
                bench.tick();
            }
            let from = shift;
            assert_eq!(bench.call(&offset(kind, by)), OK);
            shift = if kind == 5 { by } else { shift + by };
            let mut moved = false;
            while !bench.control("O").has(Flag::Pc) || (to.is_some() && !bench.control("M").has(Flag::Pc)) {
                bench.tick();
                let slave = bench.axis("A1");
                moved |= slave.motion_status & MASTER_OFFSET_MOVE_STATUS != 0;
                let seen = bench.position("B1") + slave.master_offset[0];
                near(
                    slave.command[0],
                    smooth(seen, 100.0, 40.0),
                    &format!("{period} ms at {seen}"),
                );
            }
            let slave = bench.axis("A1");
            assert!(moved && slave.motion_status & MASTER_OFFSET_MOVE_STATUS == 0);
            assert_eq!(slave.master_offset[..2], [shift, from]);
            assert_eq!(bench.bits("O"), "EN DN PC");
        }
        bench.call("MGSP(Motion, G)");
        assert_eq!(bench.axis("A1").master_offset[2], shift);
        // A stop of it alone, and the end of the cam.
        assert_eq!(bench.call(&offset(5, 60.0)), OK);
        bench.tick();
        assert_eq!(bench.call("MAS(A1, S, MasterOffsetMove, Yes, 1000, 0)"), OK);
        bench.until("S", Flag::Pc);
        assert_eq!(
            (bench.bits("O").as_str(), bench.bits("C").as_str()),
            ("EN DN", "EN DN IP")
        );
        let left = bench.axis("A1").master_offset[0];
        assert!(left > shift && left < 60.0, "{left}");
        assert_eq!(bench.call(&offset(5, 500.0)), OK);
        bench.until("C", Flag::Pc);
        bench.run(2);
        assert_eq!(
            (bench.bits("O").as_str(), bench.bits("C").as_str()),
            ("EN DN", "EN DN PC")
        );
        assert_eq!(bench.call(cam), OK);
        assert_eq!(bench.axis("A1").master_offset, [0.0; 3], "another cam begins without");
    }
}

#[test]
fn a_master_offset_by_the_way_of_a_master() {
    let mut bench = bench();
    calculate(&mut bench, "P1", &[(0.0, 0.0, LINEAR), (100.0, 50.0, LINEAR)]);
    assert_eq!(
        bench.call("MAPC(A1, B1, C, Same, P1, 1, 1, Once, Immediate, 0, 0, Command, Bidirectional)"),
        OK
    );
    let offset = "MAM(A1, O, 6, 20, 2, 4, 1, 4, 1, 4, 0, 100, 100, 6, 0, 0, 0, 1)";
    assert_eq!(bench.call(offset), (93, 0));
    assert_eq!(bench.call("MDAC(A1, C1, L, MasterOffsetMove, Command)"), OK);
    assert_eq!(bench.call(offset), OK);
    let locked = |bench: &Bench| bench.axis("A1").motion_status & MASTER_OFFSET_MOVE_LOCK_STATUS != 0;
    assert!(locked(&bench));
    // 2 units to come to 2 a unit, 2 back, 8 between: 12 units of C1.
    bench.call(&format!("MAM(C1, M, 0, 6, {TRAPEZOID})"));
    bench.until("M", Flag::Pc);
    near(bench.axis("A1").master_offset[0], 10.0, "half of it");
    assert_eq!(
        (bench.bits("O").as_str(), bench.bits("L").as_str()),
        ("EN DN IP AC TrackingMaster", "EN DN IP AC")
    );
    bench.call(&format!("MAM(C1, M, 0, 12.5, {TRAPEZOID})"));
    bench.until("M", Flag::Pc);
    near(bench.position("A1"), 10.0, "20 units of the master");
    assert_eq!((bench.bits("O").as_str(), locked(&bench)), ("EN DN PC", false));
}

#[test]
fn both_faceplates_of_mapc_are_read() {
    for (rest, way) in [
        ("Command, ForwardOnly", true),
        ("0, Command, ForwardOnly", true),
        ("Position, 1, 0", false),
    ] {
        let mut bench = bench();
        calculate(&mut bench, "P1", &[(-100.0, 0.0, LINEAR), (100.0, 100.0, LINEAR)]);
        let cam = format!("MAPC(A1, B1, C, Same, P1, 1, 1, Once, Immediate, (0 + 0), 0, {rest})");
        assert_eq!(bench.call(&cam), OK);
        bench.call(&format!("MAM(B1, M, 0, -20, {TRAPEZOID})"));
        bench.until("M", Flag::Pc);
        near(bench.position("A1"), if way { 0.0 } else { -10.0 }, rest);
    }
}

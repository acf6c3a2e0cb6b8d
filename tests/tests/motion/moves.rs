//! MAM, MAJ and MCD in every type, unit and merge, and rotary axes (spec/axis-and-data-types.md §3.3, §3.4, §3.6;
//! spec/coordinated-instructions.md §12.2, §13.6).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::motion_status;
use arcline_tests::bench::{Bench, OK};

/// Linear X, Y and Z (no deceleration), W (no deceleration jerk), servo D (off), rotary R and Q.
const MACHINE: &str = r#"
[motion_group]
name = "Motion"
coarse_update_period_ms = 1.0
[[axis]]
name = "X"
type = "virtual"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 5000.0
max_acceleration_jerk = 200000.0
max_deceleration_jerk = 100000.0
[[axis]]
name = "Y"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
[[axis]]
name = "Z"
type = "virtual"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 0.0
[[axis]]
name = "W"
type = "virtual"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
max_deceleration_jerk = 0.0
[[axis]]
name = "D"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
start = { servo_on = false }
[[axis]]
name = "R"
type = "virtual"
max_speed = 40000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
unwind = 360.0
start = { position = 10.0 }
[[axis]]
name = "Q"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
unwind = 360.0
start = { position = 350.0 }
drive = { velocity_feedforward = 0.5 }
[[coordinate_system]]
name = "XY"
type = "cartesian"
axes = ["X", "Y"]
max_speed = 500.0
max_acceleration = 5000.0
max_deceleration = 5000.0
actual_tolerance = 0.01
command_tolerance = 0.5
[[coordinate_system]]
name = "RX"
type = "cartesian"
axes = ["R", "X"]
max_speed = 500.0
max_acceleration = 5000.0
max_deceleration = 5000.0
actual_tolerance = 0.01
command_tolerance = 0.5
[[coordinate_system]]
name = "RQ"
type = "cartesian"
axes = ["R", "Q"]
max_speed = 500.0
max_acceleration = 5000.0
max_deceleration = 5000.0
actual_tolerance = 0.01
command_tolerance = 0.5
"#;

/// A trapezoid at 100 units/s with 1,000 units/s².
const RATES: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
/// The same, with a merge that ends the other motion of the axis.
const MERGED: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, Enabled";

fn bench() -> Bench {
    Bench::with(MACHINE)
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

/// Whether an axis shows a bit of its MotionStatus.
fn shows(bench: &Bench, axis: &str, bit: u32) -> bool {
    bench.axis(axis).motion_status & bit != 0
}

/// Runs to rest; returns how far an axis has gone meanwhile, with a sign, and its farthest distance from the start.
fn travel(bench: &mut Bench, axis: &str, tag: &str) -> (f64, f64) {
    let (mut gone, mut farthest, mut last) = (0.0, 0.0_f64, bench.position(axis));
    while !bench.control(tag).has(Flag::Pc) {
        bench.tick();
        let now = bench.position(axis);
        let step = now - last;
        // More than half a turn within a tick is the unwind.
        gone += if step.abs() > 180.0 {
            step - 360.0 * step.signum()
        } else {
            step
        };
        farthest = farthest.max(f64::abs(gone));
        last = now;
    }
    (gone, farthest)
}

#[test]
fn every_move_type_goes_its_way() {
    #[rustfmt::skip]
    let cases = [
        // axis, type,                 position, distance, shown at the end
        ("X",    "Absolute",           33.3,     33.3,     33.3),
        ("X",    "Absolute",           -33.3,    -33.3,    -33.3),
        ("X",    "Incremental",        -12.5,    -12.5,    -12.5),
        ("R",    "Absolute",           350.0,    340.0,    350.0),
        ("R",    "Absolute",           5.0,      -5.0,     5.0),
        ("R",    "Absolute",           -90.0,    260.0,    270.0),
        ("R",    "Absolute",           730.0,    720.0,    10.0),
        ("R",    "Incremental",        -20.0,    -20.0,    350.0),
        ("R",    "Incremental",        800.0,    800.0,    90.0),
        ("R",    "RotaryShortestPath", 350.0,    -20.0,    350.0),
        ("R",    "RotaryShortestPath", 190.0,    180.0,    190.0),
        ("R",    "RotaryShortestPath", 191.0,    -179.0,   191.0),
        ("R",    "RotaryPositive",     5.0,      355.0,    5.0),
        ("R",    "RotaryPositive",     15.0,     5.0,      15.0),
        ("R",    "RotaryNegative",     15.0,     -355.0,   15.0),
        ("R",    "RotaryNegative",     0.0,      -10.0,    0.0),
        ("Q",    "RotaryShortestPath", 10.0,     20.0,     10.0),
        ("Q",    "RotaryPositive",     350.0,    0.0,      350.0),
    ];
    for (axis, kind, position, distance, end) in cases {
        let mut bench = bench();
        let call = format!("MAM({axis}, M1, {kind}, {position}, {RATES})");
        assert_eq!(bench.call(&call), OK, "{call}");
        let (gone, farthest) = travel(&mut bench, axis, "M1");
        assert!(
            near(gone, distance) && near(farthest, distance.abs()),
            "{call}: {gone}, at most {farthest}"
        );
        assert!(near(bench.position(axis), end), "{call}: {}", bench.position(axis));
        bench.run(400);
        assert!(
            (bench.axis(axis).actual[0] - end).abs() < 1e-6,
            "{call}: the drive goes along"
        );
        assert_eq!(bench.bits("M1"), "EN DN PC", "{call}");
    }
}

#[test]
fn every_unit_makes_its_duration() {
    #[rustfmt::skip]
    let cases = [
        // why,                          distance, dynamics of MAM(X ...),                         milliseconds
        ("units",                        50.0,  "100, 0, 1000, 0, 500, 0, 0, 100, 100, 2",         500.0 + 50.0 + 100.0),
        ("% of maximum",                 50.0,  "10, 1, 10, 1, 10, 1, 0, 100, 100, 2",             500.0 + 50.0 + 100.0),
        ("S-curve in units/s³",          50.0,  "100, 0, 1000, 0, 1000, 0, 1, 20000, 20000, 0",    500.0 + 100.0 + 50.0),
        ("S-curve in % of maximum",      50.0,  "100, 0, 1000, 0, 1000, 0, 1, 10, 20, 1",          500.0 + 100.0 + 50.0),
        // A ramp of v/a + a/j = 0.2 s.
        ("S-curve in % of time",         50.0,  "100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2",        500.0 + 200.0),
        ("S-curve, 60 % of time",        50.0,  "100, 0, 1000, 0, 1000, 0, 1, 60, 60, 2",          500.0 + 142.857_142_857),
        ("seconds",                      50.0,  "2, 3, 0.5, 3, 0.25, 3, 0, 0.1, 0.1, 3",           2000.0),
        ("seconds, only ramps",          50.0,  "1, 3, 0.5, 3, 0.5, 3, 0, 0.1, 0.1, 3",            1000.0),
        ("seconds, S-curve",             50.0,  "2, 3, 0.5, 3, 0.25, 3, 1, 0.2, 0.1, 3",           2000.0),
        ("seconds, ramps all through",   -50.0, "2, 3, 0.5, 3, 0.5, 3, 1, 0.25, 0.25, 3",          2000.0),
        ("seconds, too short otherwise", 1e-3,  "3, 3, 0.5, 3, 0.25, 3, 1, 0.2, 0.1, 3",           3000.0),
    ];
    for (why, distance, dynamics, milliseconds) in cases {
        let mut bench = bench();
        assert_eq!(
            bench.call(&format!("MAM(X, M1, 1, {distance}, {dynamics})")),
            OK,
            "{why}"
        );
        let ticks = bench.until("M1", Flag::Pc) as f64;
        // PC shows at the first tick at or behind the end.
        assert!(
            (ticks - f64::ceil(milliseconds)).abs() <= 1.0,
            "{why}: {ticks} and not {milliseconds}"
        );
        assert_eq!(bench.axis("X").command, [distance, 0.0, 0.0], "{why}");
    }
    // The speed of a move in seconds follows from its distance: v = D / (T − (Ta + Td)/2).
    let mut bench = bench();
    bench.call("MAM(X, M1, 1, 50, 2, 3, 0.5, 3, 0.25, 3, 0, 0.1, 0.1, 3)");
    bench.run(1000);
    assert!(near(bench.axis("X").command[1], 50.0 / (2.0 - 0.375)));
}

#[test]
fn errors_in_the_order_of_verification() {
    #[rustfmt::skip]
    let cases = [
        // why,                             before,                      call,                                                       (ERR, EXERR)
        ("move type",                       "", "MAM(X, M1, 7, 10, 100, 0, 1000, 0, 1000, 0)",                                 (13, 2)),
        ("speed",                           "", "MAM(X, M1, 0, 10, -1, 0, 1000, 0, 1000, 0)",                                  (13, 4)),
        ("speed units",                     "", "MAM(X, M1, 0, 10, 100, 2, 1000, 0, 1000, 0)",                                 (13, 5)),
        ("accel rate",                      "", "MAM(X, M1, 0, 10, 100, 0, 0, 0, 1000, 0)",                                    (13, 6)),
        ("decel rate",                      "", "MAM(X, M1, 0, 10, 100, 0, 1000, 0, 0, 0)",                                    (13, 8)),
        ("jerk of an S-curve",              "", "MAM(X, M1, 0, 10, 100, 0, 1000, 0, 1000, 0, 1, 0, 100, 2)",               (13, 11)),
        ("jerk beyond 100 % of time",       "", "MAM(X, M1, 0, 10, 100, 0, 1000, 0, 1000, 0, 1, 100, 101, 2)",             (13, 12)),
        ("merge",                           "", "MAM(X, M1, 0, 10, 100, 0, 1000, 0, 1000, 0, 0, 1, 1, 0, 2)",              (13, 14)),
        ("beyond the turn",                 "", &format!("MAM(R, M1, 2, 360, {RATES})"),                                       (13, 3)),
        ("below the turn",                  "", &format!("MAM(R, M1, 3, -1, {RATES})"),                                        (13, 3)),
        ("the type before the position",    "", &format!("MAM(R, M1, -1, 400, {RATES})"),                                      (13, 2)),
        ("the position before the speed",   "", "MAM(R, M1, 4, 400, -1, 0, 1000, 0, 1000, 0)",                                 (13, 3)),
        ("a rotary type on a linear axis",  "", &format!("MAM(X, M1, 2, 10, {RATES})"),                                        (17, 0)),
        ("positive on a linear axis",       "", &format!("MAM(X, M1, 3, 400, {RATES})"),                                       (17, 0)),
        ("negative on a linear axis",       "", &format!("MAM(X, M1, 4, 10, {RATES})"),                                        (17, 0)),
        ("an absolute master offset",       "", &format!("MAM(X, M1, 5, 10, {RATES})"),                                        (33, 0)),
        ("an incremental master offset",    "", &format!("MAM(X, M1, 6, 10, {RATES})"),                                        (33, 0)),
        ("a speed of a master",             "", "MAM(X, M1, 0, 10, 100, 4, 1000, 0, 1000, 0)",                                 (94, 0)),
        ("a jerk of a master",              "", "MAM(X, M1, 0, 10, 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 6)",             (94, 0)),
        ("seconds with a rate",             "", "MAM(X, M1, 0, 10, 2, 3, 1000, 0, 0.5, 3, 0, 1, 1, 3)",                    (94, 0)),
        ("seconds with another jerk",       "", "MAM(X, M1, 0, 10, 2, 3, 0.5, 3, 0.5, 3, 0, 100, 100, 2)",                 (94, 0)),
        ("a rate in seconds",               "", "MAM(X, M1, 0, 10, 100, 0, 0.5, 3, 1000, 0, 0, 100, 100, 2)",              (94, 0)),
        ("master units with others",        "", "MAM(X, M1, 0, 10, 100, 7, 10, 4, 10, 4, 0, 100, 100, 4)",                 (94, 0)),
        ("phases longer than the move",     "", "MAM(X, M1, 0, 10, 1, 3, 0.75, 3, 0.5, 3, 0, 1, 1, 3)",                    (13, 4)),
        ("no time at all",                  "", "MAM(X, M1, 0, 10, 0, 3, 0.75, 3, 0.5, 3, 0, 1, 1, 3)",                    (13, 4)),
        ("an accel ramp beyond its phase",  "", "MAM(X, M1, 0, 10, 2, 3, 0.5, 3, 0.5, 3, 1, 0.3, 0.1, 3)",                 (13, 11)),
        ("a decel ramp beyond its phase",   "", "MAM(X, M1, 0, 10, 2, 3, 0.5, 3, 0.5, 3, 1, 0.1, 0.3, 3)",                 (13, 12)),
        ("seconds on a moving axis",        "JOG", "MAM(X, M1, 0, 10, 2, 3, 0.5, 3, 0.5, 3, 0, 1, 1, 3, 1)",               (100, 0)),
        ("master units on a moving axis",   "JOG", "MAM(X, M1, 0, 10, 2, 7, 0.5, 7, 0.5, 7, 0, 1, 1, 7, 0, 0, 0, 1)",    (100, 0)),
        ("merge to current with seconds",   "", "MAM(X, M1, 0, 10, 2, 3, 0.5, 3, 0.5, 3, 0, 1, 1, 3, 1, 1)",               (106, 0)),
        ("a lock without a master",         "", "MAM(X, M1, 0, 10, 100, 0, 1000, 0, 1000, 0, 0, 1, 1, 0, 0, 0, 0, 1)",    (95, 0)),
        ("master driven without a lock",    "", "MAM(X, M1, 0, 10, 100, 4, 1000, 4, 1000, 4, 0, 1, 1, 4)",                 (95, 0)),
        ("master driven without a link",    "", "MAM(X, M1, 0, 10, 2, 7, 0.5, 7, 0.5, 7, 0, 1, 1, 7, 0, 0, 0, 1)",        (93, 0)),
        ("event distances",                 "", "MAM(X, M1, 0, 10, 100, 0, 1000, 0, 1000, 0, 0, 1, 1, 0, 0, 0, 0, 0, [1])", (101, 0)),
        ("no servo",                        "", &format!("MAM(D, M1, 0, 10, {RATES})"),                                        (5, 0)),
        ("shutdown",                        "MASD(X, S1)", &format!("MAM(X, M1, 0, 10, {RATES})"),                             (7, 0)),
        ("no deceleration",                 "", &format!("MAM(Z, M1, 0, 10, {RATES})"),                                        (54, 0)),
        ("no deceleration jerk",            "", "MAM(W, M1, 0, 10, 100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2)",             (76, 0)),
        ("none is needed by a trapezoid",   "", &format!("MAM(W, M1, 0, 10, {RATES})"),                                        OK),
        ("a stop of everything",            "STOP", &format!("MAM(X, M1, 0, 10, {RATES})"),                                    (78, 0)),
        ("jog direction",                   "", "MAJ(X, M1, 2, 100, 0, 1000, 0, 1000, 0)",                                     (13, 2)),
        ("jog speed",                       "", "MAJ(X, M1, 0, -1, 0, 1000, 0, 1000, 0)",                                      (13, 3)),
        ("jog in seconds",                  "", "MAJ(X, M1, 0, 100, 3, 1000, 0, 1000, 0)",                                     (13, 4)),
        ("jog accel",                       "", "MAJ(X, M1, 0, 100, 0, 0, 0, 1000, 0)",                                        (13, 5)),
        ("jog decel in seconds",            "", "MAJ(X, M1, 0, 100, 0, 1000, 0, 1000, 3)",                                     (13, 8)),
        ("jog jerk",                        "", "MAJ(X, M1, 0, 100, 0, 1000, 0, 1000, 0, 1, 0, 0, 0)",                         (13, 10)),
        ("jog merge speed",                 "", "MAJ(X, M1, 0, 100, 0, 1000, 0, 1000, 0, 0, 1, 1, 0, 0, 2)",                  (13, 14)),
        ("jog in mixed units",              "", "MAJ(X, M1, 0, 100, 0, 1000, 4, 1000, 0)",                                     (94, 0)),
        ("jog with a lock",                 "", "MAJ(X, M1, 0, 100, 0, 1000, 0, 1000, 0, 0, 1, 1, 0, 0, 0, 0, 2)",            (95, 0)),
        ("jog without a link",              "", "MAJ(X, M1, 0, 100, 4, 1000, 4, 1000, 4, 0, 1, 1, 4, 0, 0, 0, 2)",            (93, 0)),
        ("jog without servo",               "", "MAJ(D, M1, 0, 100, 0, 1000, 0, 1000, 0)",                                     (5, 0)),
        ("jog without deceleration",        "", "MAJ(Z, M1, 0, 100, 0, 1000, 0, 1000, 0)",                                     (54, 0)),
        ("jog without deceleration jerk",   "", "MAJ(W, M1, 0, 100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2)",                    (76, 0)),
        ("jog while stopping",              "STOP", "MAJ(X, M1, 0, 100, 0, 1000, 0, 1000, 0)",                                 (78, 0)),
        ("change: motion type",             "JOG", "MCD(X, M1, 2, Yes, 5)",                                                    (13, 2)),
        ("change: flag",                    "JOG", "MCD(X, M1, 0, 2, 5)",                                                      (13, 3)),
        ("change: speed",                   "JOG", "MCD(X, M1, 0, 1, -5)",                                                     (13, 4)),
        ("change: accel",                   "JOG", "MCD(X, M1, 0, 0, 5, 1, 0)",                                                (13, 6)),
        ("change: decel",                   "JOG", "MCD(X, M1, 0, 0, 5, 0, 0, 1, 0)",                                          (13, 8)),
        ("change: accel jerk",              "JOG", "MCD(X, M1, 0, 0, 5, 0, 0, 0, 0, 1, 0)",                                    (13, 10)),
        ("change: decel jerk",              "JOG", "MCD(X, M1, 0, 0, 5, 0, 0, 0, 0, 0, 0, 1, 0)",                              (13, 12)),
        ("change: speed in seconds",        "JOG", "MCD(X, M1, 0, 1, 5, 0, 0, 0, 0, 0, 0, 0, 0, 3)",                           (13, 13)),
        ("change: jerk units",              "JOG", "MCD(X, M1, 0, 1, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3)",                  (13, 16)),
        ("change: speed of a master",       "JOG", "MCD(X, M1, 0, 1, 5, 0, 0, 0, 0, 0, 0, 0, 0, 4)",                           (105, 0)),
        ("change: mixed",                   "JOG", "MCD(X, M1, 0, 1, 5, 1, 5, 0, 0, 0, 0, 0, 0, 4, 0)",                        (94, 0)),
        ("change: rate of a master",        "JOG", "MCD(X, M1, 0, 0, 5, 1, 5, 0, 0, 0, 0, 0, 0, 0, 4)",                        (94, 0)),
        ("change: no move",                 "JOG", "MCD(X, M1, Move, Yes, 5)",                                                 (23, 0)),
        ("change: nothing",                 "", "MCD(X, M1, Jog, Yes, 5)",                                                     (23, 0)),
        ("change: no servo",                "", "MCD(D, M1, Jog, Yes, 5)",                                                     (5, 0)),
        ("change: shutdown",                "MASD(X, S1)", "MCD(X, M1, Jog, Yes, 5)",                                          (7, 0)),
        ("change: no deceleration",         "", "MCD(Z, M1, Jog, Yes, 5)",                                                     (54, 0)),
        ("change: stopping",                "STOP", "MCD(X, M1, Jog, Yes, 5)",                                                 (78, 0)),
        ("change: this jog stops",          "STOP JOG", "MCD(X, M1, Jog, Yes, 5)",                                             (78, 0)),
        ("change: the jog",                 "JOG", "MCD(X, M1, Jog, Yes, 5)",                                                  OK),
    ];
    for (why, before, call, expected) in cases {
        let mut bench = bench();
        match before {
            "" => {}
            "JOG" | "STOP" | "STOP JOG" => {
                assert_eq!(bench.call("MAJ(X, J1, 0, 100, 0, 1000, 0, 1000, 0)"), OK);
                bench.run(200);
                match before {
                    "STOP" => assert_eq!(bench.call("MAS(X, S1, All, No, 100, 0, No, 100, 2)"), OK),
                    "STOP JOG" => assert_eq!(bench.call("MAS(X, S1, Jog, No, 100, 0, No, 100, 2)"), OK),
                    _ => {}
                }
            }
            call => assert_eq!(bench.call(call), OK),
        }
        assert_eq!(bench.call(call), expected, "{why}: {call}");
    }
}

#[test]
fn bits_of_a_move_and_its_axis_at_their_ticks() {
    use motion_status::{ACCEL_STATUS, DECEL_STATUS, MOVE_STATUS};
    for (why, profile) in [("trapezoid", "0, 100, 100, 2"), ("S-curve", "1, 20000, 20000, 0")] {
        let mut bench = bench();
        // Ramps of 100 ms (S-curve: 150), 30 units in all at full speed.
        let ramp = if profile.starts_with('0') { 100 } else { 150 };
        let cruise = 300 - if profile.starts_with('0') { 100 } else { 150 };
        let call = format!("MAM(X, M1, 0, 30, 100, 0, 1000, 0, 1000, 0, {profile})");
        assert_eq!(bench.call(&call), OK, "{why}");
        assert_eq!(bench.bits("M1"), "EN DN IP", "{why}");
        for tick in 1..=2 * ramp + cruise {
            bench.tick();
            let (phase, status) = match tick {
                tick if tick < ramp => ("EN DN IP ACCEL", [true, true, false]),
                tick if tick < ramp + cruise => ("EN DN IP", [true, false, false]),
                tick if tick < 2 * ramp + cruise => ("EN DN IP DECEL", [true, false, true]),
                _ => ("EN DN PC", [false; 3]),
            };
            // Joints of segments lie on ticks but for rounding.
            let joint = [ramp, ramp + cruise, 2 * ramp + cruise].contains(&tick);
            if !joint {
                assert_eq!(bench.bits("M1"), phase, "{why} at {tick}");
                let shown = [MOVE_STATUS, ACCEL_STATUS, DECEL_STATUS].map(|bit| shows(&bench, "X", bit));
                assert_eq!(shown, status, "{why} at {tick}");
            }
        }
        bench.tick();
        assert_eq!(bench.bits("M1"), "EN DN PC", "{why}");
        assert!(!shows(&bench, "X", MOVE_STATUS), "{why}");
    }
}

#[test]
fn a_move_without_way_is_complete_at_once() {
    for call in [
        format!("MAM(X, M1, 0, 0, {RATES})"),
        format!("MAM(R, M1, 3, 10, {RATES})"),
        "MAM(X, M1, 1, 0, 2, 3, 0.5, 3, 0.5, 3, 0, 1, 1, 3)".to_owned(),
        "MAM(X, M1, 1, 0, 2, 3, 0.5, 3, 0.5, 3, 1, 0.1, 0.1, 3)".to_owned(),
        "MAM(X, M1, 1, 0, 0, 0, 1000, 0, 1000, 0)".to_owned(),
    ] {
        let mut bench = bench();
        assert_eq!(bench.call(&call), OK, "{call}");
        bench.tick();
        assert_eq!(bench.bits("M1"), "EN DN PC", "{call}");
        let events = bench.events.iter().filter(|(tag, _)| tag == "M1").count();
        assert_eq!(events, 1, "{call}");
    }
}

#[test]
fn a_new_move_takes_the_place_of_the_running_one() {
    // 0 to 4 at 10 units/s, interrupted at 1 by another + 4: 5, not 8.
    let slow = "10, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
    let mut bench = bench();
    bench.call(&format!("MAM(X, M1, 1, 4, {slow})"));
    bench.run(105);
    assert!(near(bench.position("X"), 1.0));
    assert_eq!(bench.call(&format!("MAM(X, M2, 1, 4, {slow})")), OK);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN", "EN DN IP")
    );
    assert!(near(bench.axis("X").command[1], 10.0), "without a stop");
    // 4 units at 10 units/s, and half of the ramp at the end.
    assert_eq!(bench.until("M2", Flag::Pc), 405);
    assert!(near(bench.position("X"), 5.0));

    // Absolute: to the new end, and back if that lies behind; a move that cannot stop before it overshoots.
    for (why, end, farthest) in [("back", -20.0, 35.0), ("too near", 32.0, 35.0), ("farther", 60.0, 60.0)] {
        let mut bench = Bench::with(MACHINE);
        bench.call(&format!("MAM(X, M1, 0, 50, {RATES})"));
        bench.run(350);
        assert!(near(bench.position("X"), 30.0));
        assert_eq!(bench.call(&format!("MAM(X, M2, 0, {end}, {RATES})")), OK, "{why}");
        let (_, reached) = travel(&mut bench, "X", "M2");
        assert!(
            end < 0.0 || (reached - (farthest - 30.0)).abs() < 0.01,
            "{why}: {reached}"
        );
        assert_eq!(bench.axis("X").command, [end, 0.0, 0.0], "{why}");
        assert_eq!(bench.bits("M1"), "EN DN", "{why}");
    }
}

#[test]
fn a_move_at_speed_0_waits_for_a_change() {
    let mut bench = bench();
    assert_eq!(bench.call("MAM(X, M1, 0, 10, 0, 0, 1000, 0, 1000, 0)"), OK);
    bench.run(500);
    assert_eq!((bench.bits("M1").as_str(), bench.position("X")), ("EN DN IP", 0.0));
    assert!(shows(&bench, "X", motion_status::MOVE_STATUS));
    assert_eq!(bench.call("MCD(X, C1, Move, Yes, 100)"), OK);
    assert_eq!(bench.bits("C1"), "EN DN");
    assert_eq!(bench.until("M1", Flag::Pc), 200);
    assert_eq!(bench.axis("X").command, [10.0, 0.0, 0.0]);
}

#[test]
fn merges_of_moves_and_jogs() {
    let jogging = || {
        let mut bench = bench();
        bench.call("MAJ(X, J1, 0, 40, 0, 1000, 0, 1000, 0)");
        bench.run(100);
        assert!(near(bench.axis("X").command[1], 40.0));
        bench
    };
    // Disabled: both add, and the jog goes on.
    let mut bench = jogging();
    let from = bench.position("X");
    assert_eq!(bench.call(&format!("MAM(X, M1, 1, 20, {RATES})")), OK);
    let jogged = 0.04 * bench.until("M1", Flag::Pc) as f64;
    assert!(near(bench.position("X") - from, 20.0 + jogged) && near(bench.axis("X").command[1], 40.0));
    assert_eq!(bench.bits("J1"), "EN DN IP");

    // Enabled: the jog ends, and the move begins at its speed; the end is the programmed one.
    let mut bench = jogging();
    let from = bench.position("X");
    assert_eq!(bench.call(&format!("MAM(X, M1, 1, 20, {MERGED})")), OK);
    assert_eq!(bench.bits("J1"), "EN DN");
    assert!(!shows(&bench, "X", motion_status::JOG_STATUS) && near(bench.axis("X").command[1], 40.0));
    bench.until("M1", Flag::Pc);
    assert!(near(bench.position("X") - from, 20.0) && bench.axis("X").command[1] == 0.0);

    // Merge Speed Current: at the speed that the axis has.
    let mut bench = jogging();
    assert_eq!(bench.call(&format!("MAM(X, M1, 1, 20, {MERGED}, Current)")), OK);
    bench.run(100);
    assert!(near(bench.axis("X").command[1], 40.0));
    bench.until("M1", Flag::Pc);

    // Merge Speed Current without a merge is not read.
    let mut bench = jogging();
    assert_eq!(
        bench.call(&format!("MAM(X, M1, 1, 50, {RATES}, Disabled, Current)")),
        OK
    );
    bench.run(200);
    assert!(near(bench.axis("X").command[1], 140.0));

    // A jog that merges takes the move over, at its speed or at the programmed one.
    for (speed, expected) in [("Programmed", 70.0), ("Current", 140.0)] {
        let mut bench = jogging();
        bench.call(&format!("MAM(X, M1, 1, 500, {RATES})"));
        bench.run(300);
        let jog = format!("MAJ(X, J2, 0, 70, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, Enabled, {speed})");
        assert_eq!(bench.call(&jog), OK);
        assert_eq!([bench.bits("M1"), bench.bits("J1")], ["EN DN", "EN DN"], "{speed}");
        assert!(!shows(&bench, "X", motion_status::MOVE_STATUS));
        bench.run(300);
        assert!(near(bench.axis("X").command[1], expected), "{speed}");
    }

    // Coordinated motion is not touched by a single-axis merge.
    let mut bench = jogging();
    bench.call("MCLM(XY, L1, 1, [100, 100], 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1)");
    bench.run(300);
    assert_eq!(bench.call(&format!("MAM(X, M1, 1, 10, {MERGED})")), OK);
    assert_eq!(
        (bench.bits("J1").as_str(), bench.bits("L1").as_str()),
        ("EN DN", "EN DN IP AC")
    );
    let present = bench.axis("X").command[1];
    assert!(near(present, 40.0 + 100.0 / f64::sqrt(2.0)), "{present}");
    bench.until("L1", Flag::Pc);
    assert!(near(bench.position("Y"), 100.0));
}

#[test]
fn jogs_change_speed_and_direction() {
    use motion_status::{ACCEL_STATUS, DECEL_STATUS, JOG_STATUS};
    // Accel 1,000 and Decel 500 units/s².
    let jog = |tag: &str, direction: &str, speed: f64| {
        format!("MAJ(X, {tag}, {direction}, {speed}, 0, 1000, 0, 500, 0, 0, 100, 100, 2)")
    };
    let mut bench = bench();
    assert_eq!(bench.call(&jog("J1", "Forward", 100.0)), OK);
    bench.run(50);
    assert_eq!(bench.bits("J1"), "EN DN IP ACCEL");
    assert!(shows(&bench, "X", ACCEL_STATUS) && shows(&bench, "X", JOG_STATUS));
    bench.run(60);
    assert_eq!(bench.bits("J1"), "EN DN IP");
    // Faster with Accel Rate, slower with Decel Rate.
    for (tag, speed, ticks, bits) in [("J2", 150.0, 50, "EN DN IP ACCEL"), ("J3", 50.0, 200, "EN DN IP DECEL")] {
        assert_eq!(bench.call(&jog(tag, "Forward", speed)), OK);
        bench.run(ticks - 1);
        assert_eq!(bench.bits(tag), bits);
        assert!(!near(bench.axis("X").command[1], speed));
        bench.run(2);
        assert_eq!(bench.bits(tag), "EN DN IP");
        assert_eq!(bench.axis("X").command[1], speed);
    }
    assert_eq!(bench.bits("J2"), "EN DN");
    // Through 0: first Decel Rate, 100 ms, then Accel Rate, 50 ms.
    assert_eq!(bench.call(&jog("J4", "Reverse", 50.0)), OK);
    bench.run(50);
    assert!(near(bench.axis("X").command[1], 25.0) && shows(&bench, "X", DECEL_STATUS));
    bench.run(75);
    assert!(near(bench.axis("X").command[1], -25.0) && shows(&bench, "X", ACCEL_STATUS));
    bench.run(30);
    assert_eq!(bench.axis("X").command[1], -50.0);
    // Speed 0 stays a jog, at rest, until it is stopped.
    assert_eq!(bench.call(&jog("J5", "Reverse", 0.0)), OK);
    bench.run(500);
    assert_eq!(
        (bench.bits("J5").as_str(), bench.axis("X").command[1]),
        ("EN DN IP", 0.0)
    );
    assert!(shows(&bench, "X", JOG_STATUS));
    // And its direction is the one in which MCD goes on.
    assert_eq!(bench.call("MCD(X, C1, Jog, Yes, 30)"), OK);
    bench.run(500);
    assert_eq!(bench.axis("X").command[1], -30.0);
    assert_eq!(bench.call("MAS(X, S1, Jog, No, 100, 0, No, 100, 2)"), OK);
    bench.until("S1", Flag::Pc);
    assert_eq!(bench.bits("J5"), "EN DN", "no PC");
    assert!(!shows(&bench, "X", JOG_STATUS));
}

#[test]
fn jerk_in_percent_of_time_of_jogs() {
    #[rustfmt::skip]
    let cases = [
        // start, speed,  %,     seconds of the change
        (0.0,     100.0,  100.0, 0.2),
        (0.0,     100.0,  50.0,  0.1 + 0.1 / 3.0),
        // From more than twice the speed the share is exact: v0 - v = 80 at 1,000 units/s².
        (100.0,   20.0,   100.0, 0.16),
        // From less it is larger: dv = 50 with the jerk for 50, then dv = 20 with that for 80.
        (100.0,   50.0,   100.0, 0.1),
        (100.0,   80.0,   100.0, 2.0 * f64::sqrt(20.0 / 12_500.0)),
        (100.0,   0.0,    100.0, 0.2),
    ];
    for (start, speed, percent, seconds) in cases {
        let mut bench = bench();
        let jog = |speed: f64| format!("MAJ(X, J1, 0, {speed}, 0, 1000, 0, 1000, 0, 1, {percent}, {percent}, 2)");
        if start > 0.0 {
            bench.call(&jog(start));
            bench.run(1000);
        }
        assert_eq!(bench.call(&jog(speed)), OK);
        let mut ticks = 0;
        while bench.axis("X").command[1] != speed || ticks == 0 {
            bench.tick();
            ticks += 1;
        }
        let expected = (seconds * 1000.0_f64).ceil();
        assert!(
            (f64::from(ticks) - expected).abs() <= 1.0,
            "{start} to {speed} at {percent} %: {ticks} ticks"
        );
    }
}

#[test]
fn a_change_of_a_move_keeps_its_end() {
    let start = |profile: &str| {
        let mut bench = bench();
        let call = format!("MAM(X, M1, 0, 100, 100, 0, 1000, 0, 1000, 0, {profile})");
        assert_eq!(bench.call(&call), OK);
        bench.run(500);
        bench
    };
    for profile in ["0, 100, 100, 2", "1, 100, 100, 2", "1, 20000, 20000, 0"] {
        // Slower, faster, in percent.
        for (call, speed) in [
            ("MCD(X, C1, Move, Yes, 40)", 40.0),
            ("MCD(X, C1, Move, Yes, 15, No, 0, No, 0, No, 0, No, 0, 1)", 150.0),
        ] {
            let mut bench = start(profile);
            assert_eq!(bench.call(call), OK);
            bench.run(200);
            assert!(near(bench.axis("X").command[1], speed), "{profile}: {call}");
            bench.until("M1", Flag::Pc);
            assert_eq!(bench.axis("X").command, [100.0, 0.0, 0.0], "{profile}: {call}");
        }
        // A pause and a resumption.
        let mut bench = start(profile);
        assert_eq!(bench.call("MCD(X, C1, Move, Yes, 0)"), OK);
        bench.run(1000);
        assert_eq!(
            (bench.bits("M1").as_str(), bench.axis("X").command[1]),
            ("EN DN IP", 0.0),
            "{profile}"
        );
        let paused = bench.position("X");
        bench.run(1000);
        assert_eq!(bench.position("X"), paused);
        assert_eq!(bench.call("MCD(X, C2, Move, Yes, 80)"), OK);
        bench.until("M1", Flag::Pc);
        assert_eq!(bench.axis("X").command, [100.0, 0.0, 0.0], "{profile}");
    }
    // A lower deceleration close to the end: over it and back, v²/2d - D = 100²/400 - 5.
    let mut bench = bench();
    bench.call(&format!("MAM(X, M1, 0, 100, {RATES})"));
    bench.run(1000);
    assert!(near(bench.position("X"), 95.0));
    let from = bench.position("X");
    assert_eq!(bench.call("MCD(X, C1, Move, No, 0, No, 0, Yes, 200)"), OK);
    let (gone, farthest) = travel(&mut bench, "X", "M1");
    assert!(near(from + gone, 100.0) && (farthest - 25.0).abs() < 0.01, "{farthest}");
    // A jerk in percent of time follows the new speed: a² / v = 10,000 instead of 5,000 units/s³.
    let mut bench = Bench::with(MACHINE);
    bench.call("MAM(X, M1, 0, 500, 200, 0, 1000, 0, 1000, 0, 1, 100, 100, 2)");
    bench.run(1000);
    assert_eq!(bench.call("MCD(X, C1, Move, Yes, 100)"), OK);
    bench.run(10);
    let acceleration = bench.axis("X").command[2];
    assert!(near(acceleration, -100.0), "{acceleration}");
}

#[test]
fn jogs_turn_for_ever_and_keep_their_digits() {
    let mut bench = bench();
    // 100 turns a second, 10 a ramp's worth: 100 ms tick by tick.
    assert_eq!(bench.call("MAJ(R, J1, Reverse, 36000, 0, 360000, 0, 360000, 0)"), OK);
    bench.run(100);
    for k in 1..=20_000_u32 {
        bench.tick();
        // 36 units a tick, from 10 - 1,800.
        let expected = (10.0 - 1_800.0 - 36.0 * f64::from(k)).rem_euclid(360.0);
        let shown = bench.position("R");
        let apart = (shown - expected).abs();
        assert!(
            apart.min(360.0 - apart) < 1e-7,
            "tick {k}: {shown}, expected {expected}"
        );
        assert!((0.0..360.0).contains(&shown));
    }
    assert_eq!(bench.call("MAS(R, S1, All, Yes, 360000, 0, No, 100, 2)"), OK);
    bench.until("S1", Flag::Pc);
    assert_eq!(bench.call(&format!("MAM(R, M1, 0, 123.456, {RATES})")), OK);
    bench.until("M1", Flag::Pc);
    assert_eq!(
        bench.position("R"),
        123.456,
        "to the last bit: nothing is left of the turns"
    );
    // A servo with a following error turns on without a step.
    assert_eq!(bench.call("MAJ(Q, J2, 0, 360, 0, 3600, 0, 3600, 0)"), OK);
    bench.run(1000);
    let error = bench.axis("Q").position_error;
    for _ in 0..40_000 {
        bench.tick();
        let axis = bench.axis("Q");
        assert!((axis.position_error - error).abs() < 1e-6, "{}", axis.position_error);
        assert!((axis.actual[1] - 360.0).abs() < 1e-6, "{}", axis.actual[1]);
    }
}

#[test]
fn coordinated_lines_turn_by_sign() {
    #[rustfmt::skip]
    let cases = [
        // from,  move type,     position, distance or EXERR of 13
        (350.0,   "Absolute",    "10",     Ok(20.0)),
        (10.0,    "Absolute",    "350",    Ok(340.0)),
        (10.0,    "Absolute",    "-350",   Ok(-20.0)),
        (10.0,    "Absolute",    "-360",   Ok(-10.0)),
        (10.0,    "Absolute",    "0",      Ok(350.0)),
        (10.0,    "Absolute",    "10",     Ok(0.0)),
        (10.0,    "Absolute",    "400",    Err((13, 3))),
        (10.0,    "Incremental", "800",    Ok(800.0)),
        (10.0,    "Incremental", "-20",    Ok(-20.0)),
    ];
    for (from, kind, position, expected) in cases {
        let mut bench = bench();
        bench.call(&format!("MAM(R, M0, 2, {from}, {RATES})"));
        bench.until_rest();
        let call = format!("MCLM(RX, L1, {kind}, [{position}, 50], 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1)");
        match expected {
            Ok(distance) => {
                assert_eq!(bench.call(&call), OK, "{call}");
                let (gone, farthest) = travel(&mut bench, "R", "L1");
                assert!(
                    near(gone, distance) && near(farthest, f64::abs(distance)),
                    "{call}: {gone}"
                );
                assert!(near(bench.position("X"), 50.0));
            }
            Err(error) => assert_eq!(bench.call(&call), error, "{call}"),
        }
    }
}

#[test]
fn coordinated_circles_pass_the_unwind() {
    let rates = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1";
    #[rustfmt::skip]
    let cases = [
        // why, R at the start, operands,                       distance of R or error, farthest of X
        ("centre, half circle over the unwind", 350.0, "0, [10, 0], 1, [0, 0], 0",      Ok(20.0),  10.0),
        ("via",                                 350.0, "0, [10, 0], 0, [0, 10], 0",     Ok(20.0),  10.0),
        ("radius",                              350.0, "0, [10, 0], 2, [10], 0",        Ok(20.0),  10.0),
        ("centre from the start",               350.0, "0, [10, 0], 3, [10, 0], 0",     Ok(20.0),  10.0),
        ("incremental",                         350.0, "1, [20, 0], 1, [10, 0], 0",     Ok(20.0),  10.0),
        ("backwards over the unwind",           10.0,  "0, [-350, 0], 1, [0, 0], 1",    Ok(-20.0), 10.0),
        ("a full circle around the unwind",     350.0, "0, [350, 0], 1, [0, 0], 2",     Ok(0.0),   10.0),
        ("beyond the unwind",                   350.0, "0, [400, 0], 2, [10], 0",       Err((13, 3)), 0.0),
        ("more than a turn",                    350.0, "1, [-361, 0], 2, [200], 0",     Err((13, 3)), 0.0),
    ];
    for (why, from, operands, expected, bulge) in cases {
        let mut bench = bench();
        bench.call(&format!("MAM(R, M0, 2, {from}, {RATES})"));
        bench.until_rest();
        let call = format!("MCCM(RX, C1, {operands}, {rates})");
        match expected {
            Ok(distance) => {
                assert_eq!(bench.call(&call), OK, "{why}");
                let (mut gone, mut last, mut most) = (0.0, bench.position("R"), 0.0_f64);
                while !bench.control("C1").has(Flag::Pc) {
                    bench.tick();
                    let step = bench.position("R") - last;
                    gone += if step.abs() > 180.0 {
                        step - 360.0 * step.signum()
                    } else {
                        step
                    };
                    last = bench.position("R");
                    most = most.max(bench.position("X").abs());
                }
                assert!(near(gone, distance), "{why}: {gone}");
                assert!((most - bulge).abs() < 0.1, "{why}: {most}");
            }
            Err(error) => assert_eq!(bench.call(&call), error, "{why}"),
        }
    }
}

/// The positions of some axes every 4 ms under a program of instructions at multiples of 4 ms.
fn trace(period: f64, program: &[(u32, &str)], axes: &[&str]) -> Vec<f64> {
    let config = MACHINE.replace(
        "coarse_update_period_ms = 1.0",
        &format!("coarse_update_period_ms = {period:?}"),
    );
    let mut bench = Bench::with(&config);
    let every = (4.0 / period) as u64;
    let mut positions = Vec::new();
    for step in 0..400 {
        for (_, call) in program.iter().filter(|(at, _)| *at == step * 4) {
            assert_eq!(bench.call(call), OK, "{call}");
        }
        positions.extend(axes.iter().map(|axis| bench.position(axis)));
        bench.run(every);
    }
    positions
}

#[test]
fn the_update_period_does_not_show() {
    let s_curve = "100, 0, 1000, 0, 700, 0, 1, 60, 80, 2";
    let moves = format!("MAM(X, M1, 0, 60, {s_curve})");
    let replaced = format!("MAM(X, M2, 1, -7, {s_curve})");
    let rotary = format!("MAM(R, M3, 4, 200, {s_curve})");
    #[rustfmt::skip]
    let program: [(u32, &str); 10] = [
        (0, &moves),
        (0, &rotary),
        (8, "MAJ(X, J1, Reverse, 33, 0, 900, 0, 500, 0, 1, 100, 100, 2)"),
        (0, "MAJ(Q, J2, Forward, 720, 0, 9000, 0, 5000, 0, 1, 100, 100, 2)"),
        (100, "MCD(X, C1, Move, Yes, 30, Yes, 400)"),
        (204, "MCD(X, C2, Jog, Yes, 80, No, 0, Yes, 90)"),
        (300, "MAM(Y, M4, 0, 12, 0.5, 3, 0.1, 3, 0.2, 3, 1, 0.05, 0.1, 3)"),
        (404, &replaced),
        (600, "MAJ(X, J3, Forward, 33, 0, 900, 0, 500, 0, 1, 100, 100, 2, Enabled)"),
        (1000, "MAS(Q, S1, Jog, Yes, 900, 0, No, 100, 2)"),
    ];
    let axes = ["X", "Y", "R", "Q"];
    let [fine, plain, coarse] = [0.25, 1.0, 4.0].map(|period| trace(period, &program, &axes));
    for other in [plain, coarse] {
        for (place, (a, b)) in fine.iter().zip(other).enumerate() {
            assert!(
                (a - b).abs() < 1e-9,
                "{} at {} ms: {a} and {b}",
                axes[place % 4],
                place / 4 * 4
            );
        }
    }
}

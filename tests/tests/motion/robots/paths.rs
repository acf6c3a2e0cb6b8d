//! MCPM: X, Y, Z and Rx, Ry, Rz along one path (spec/coordinated-instructions.md §23).

use arcline_geometry::{Point, nearest, rotation};
use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::motion_status::COORDINATED_MOTION_STATUS;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::random::{Random, is_long};
use arcline_tests::robots::{DELTA, RobotMachine, SIX_AXES};

/// X, Y, Z at 1000 units/s and 10000 units/s²; Rx, Ry, Rz at 90 degrees/s and 900 degrees/s².
pub(in super::super) const MACHINE: RobotMachine = RobotMachine {
    cart: "actual_tolerance = 0.01\nmax_orientation_speed = 90.0\nmax_orientation_acceleration = 900.0\n",
    ..SIX_AXES
};
const TAGS: &str = "[[tag]]\nname = \"P\"\ntype = \"PATH_DATA\"\n[[tag]]\nname = \"D\"\ntype = \"DYNAMICS_DATA\"\n\
                    [[tag]]\nname = \"Many\"\ntype = \"PATH_DATA[3]\"\n";
pub(super) const MOVE: &str = "MCPM(CART, M, P, 1, D)";
const TURNING: [&str; 3] = ["RX", "RY", "RZ"];
const MOVING: [&str; 3] = ["X", "Y", "Z"];

/// The machine with a path and dynamics: 100 units/s, 1000 units/s², 45 degrees/s, 450 degrees/s², trapezoidal.
pub(in super::super) fn bench_of(machine: RobotMachine) -> Bench {
    let mut bench = Bench::with(&format!("{}{TAGS}", machine.config()));
    for tag in ["P", "Many[0]", "Many[1]", "Many[2]"] {
        set(&mut bench, tag, &[("InterpolationType", 1.0), ("TerminationType", 1.0)]);
    }
    set(
        &mut bench,
        "D",
        &[
            ("UnitsMode", 1.0),
            ("AccelerationJerk", 100.0),
            ("DecelerationJerk", 100.0),
        ],
    );
    dynamics(&mut bench, [100.0, 1000.0, 1000.0], [45.0, 450.0, 450.0]);
    bench
}

fn bench() -> Bench {
    bench_of(MACHINE)
}

fn set(bench: &mut Bench, tag: &str, members: &[(&str, f64)]) {
    for (member, value) in members {
        bench.write(&format!("{tag}.{member}"), *value);
    }
}

pub(super) fn dynamics(bench: &mut Bench, linear: [f64; 3], orientation: [f64; 3]) {
    for (place, name) in ["Speed", "Acceleration", "Deceleration"].iter().enumerate() {
        bench.write(&format!("D.{name}"), linear[place]);
        bench.write(&format!("D.Orientation{name}"), orientation[place]);
    }
}

pub(in super::super) fn position(bench: &mut Bench, tag: &str, position: [f64; 6]) {
    for (place, value) in position.iter().enumerate() {
        bench.write(&format!("{tag}.Position[{place}]"), *value);
    }
}

fn of(bench: &Bench, axes: [&str; 3], quantity: usize) -> Point {
    Point::from(axes.map(|axis| bench.axis(axis).command[quantity]))
}

/// The command of each axis: X, Y, Z, Rx, Ry, Rz.
fn shown(bench: &Bench) -> [f64; 6] {
    let (p, a) = (of(bench, MOVING, 0), of(bench, TURNING, 0));
    [p.x, p.y, p.z, a.x, a.y, a.z]
}

/// The rates of the angles as a rate about an axis, degrees.
fn turning(bench: &Bench) -> f64 {
    let (angles, rate) = (of(bench, TURNING, 0), of(bench, TURNING, 1));
    let about = |axis: Point, base: Point| rotation(&base) * axis;
    let z = Point::z() * rate.z;
    let y = about(Point::y(), Point::new(0.0, 0.0, angles.z)) * rate.y;
    let x = about(Point::x(), Point::new(0.0, angles.y, angles.z)) * rate.x;
    (x + y + z).norm()
}

#[test]
fn path_moves_are_refused_in_the_order_of_verification() {
    type Prepare = fn(&mut Bench);
    #[rustfmt::skip]
    let cases: &[(&str, Prepare, &str, (i16, i8))] = &[
        // why,                               before,                                                     call,                         status
        ("a plain move",                      |_| {},                                                     MOVE,                         OK),
        ("the second of an array",            |_| {},                                                     "MCPM(CART, M, Many[1], 1, D)", OK),
        ("no orientation",                    |_| {},                                                     "MCPM(WORLD, M, P, 1, D)",    (13, 0)),
        ("a robot's joints",                  |_| {},                                                     "MCPM(ROBOT, M, P, 1, D)",    (13, 0)),
        ("Length before the path",            |b| b.write("P.MoveType", 2.0),                             "MCPM(CART, M, P, 2, D)",     (13, 3)),
        ("an interpolation there is not",     |b| b.write("P.InterpolationType", 2.0),                    MOVE,                         (13, 2)),
        ("point to point",                    |b| b.write("P.InterpolationType", 0.0),                    MOVE,                         (99, 0)),
        ("a move type there is not",          |b| b.write("P.MoveType", 2.0),                             MOVE,                         (13, 2)),
        ("a contour",                         |b| b.write("P.TerminationType", 4.0),                      MOVE,                         (13, 2)),
        ("no termination type",               |b| b.write("P.TerminationType", -1.0),                     MOVE,                         (13, 2)),
        ("a tolerance below 0",               |b| set(b, "P", &[("TerminationType", 6.0), ("CommandToleranceLinear", -1.0)]), MOVE,      (13, 2)),
        ("which is not read otherwise",       |b| b.write("P.CommandToleranceLinear", -1.0),              MOVE,                         OK),
        ("a configuration of the arm",        |b| b.write("P.RobotConfiguration", 2.0),                   MOVE,                         (13, 2)),
        ("turns of the base",                 |b| b.write("P.TurnsCounters[0]", 1.0),                     MOVE,                         (13, 2)),
        ("turns of two joints",               |b| set(b, "P", &[("TurnsCounters[1]", 1.0), ("TurnsCounters[2]", 1.0)]), MOVE,           (13, 2)),
        ("the path before the dynamics",      |b| { b.write("P.MoveType", 2.0); b.write("D.Profile", 2.0); }, MOVE,                     (13, 2)),
        ("units there are not",               |b| b.write("D.UnitsMode", 2.0),                            MOVE,                         (13, 4)),
        ("time units there are not",          |b| b.write("D.TimeUnits", 2.0),                            MOVE,                         (13, 4)),
        ("a profile there is not",            |b| b.write("D.Profile", 2.0),                              MOVE,                         (13, 4)),
        ("a speed below 0",                   |b| b.write("D.Speed", -1.0),                               MOVE,                         (13, 4)),
        ("no acceleration",                   |b| b.write("D.Acceleration", 0.0),                         MOVE,                         (13, 4)),
        ("no deceleration",                   |b| b.write("D.Deceleration", 0.0),                         MOVE,                         (13, 4)),
        ("no jerk of an S-curve",             |b| { b.write("D.Profile", 1.0); b.write("D.AccelerationJerk", 0.0); }, MOVE,             (13, 4)),
        ("too much jerk of an S-curve",       |b| { b.write("D.Profile", 1.0); b.write("D.DecelerationJerk", 100.5); }, MOVE,           (13, 4)),
        ("jerks of a trapezoid",              |b| b.write("D.AccelerationJerk", 0.0),                     MOVE,                         OK),
        ("an orientation speed below 0",      |b| b.write("D.OrientationSpeed", -1.0),                    MOVE,                         (13, 4)),
        ("no orientation acceleration",       |b| b.write("D.OrientationAcceleration", 0.0),              MOVE,                         (13, 4)),
        ("a lock direction there is not",     |_| {},                                                     "MCPM(CART, M, P, 1, D, 0, 5)", (13, 6)),
        ("a lock direction by time",          |_| {},                                                     "MCPM(CART, M, P, 1, D, 0, 1)", (95, 0)),
        ("no lock direction by a master",     |b| b.write("D.TimeUnits", 1.0),                            MOVE,                         (95, 0)),
        ("no master",                         |b| b.write("D.TimeUnits", 1.0),                            "MCPM(CART, M, P, 1, D, 0, 1)", (93, 0)),
        ("within the tolerance",              |b| b.write("P.TerminationType", 0.0),                      MOVE,                         OK),
    ];
    for (why, before, call, expected) in cases {
        let mut bench = bench();
        before(&mut bench);
        assert_eq!(bench.call(call), *expected, "{why}: {call}");
    }
    let mut loose = bench_of(RobotMachine { cart: "", ..MACHINE });
    loose.write("P.TerminationType", 0.0);
    assert_eq!(loose.call(MOVE), (51, 0), "without a tolerance");
    let mut precise = bench_of(RobotMachine {
        cart: "corner = \"precise\"\n",
        ..MACHINE
    });
    assert_eq!(precise.call(MOVE), (99, 0), "where moves are planned as contours");
    let mut off = bench();
    assert_eq!(off.call("MASD(RZ, S)"), OK);
    assert_eq!(off.call(MOVE), (7, 5), "the last axis is in shutdown");
}

#[test]
fn the_slower_part_determines_the_time() {
    #[rustfmt::skip]
    let cases = [
        // why,                         to,                                     seconds
        ("only a line",                 [50.0, 0.0, 0.0, 0.0, 0.0, 0.0],        0.5 + 0.1),
        ("only a turn",                 [0.0, 0.0, 0.0, 0.0, 0.0, 90.0],        2.0 + 0.1),
        ("the line is slower",          [400.0, 0.0, 0.0, 0.0, 0.0, 90.0],      4.0 + 0.1),
        ("the turn is slower",          [50.0, 0.0, 0.0, 0.0, 60.0, 0.0],       60.0 / 45.0 + 0.1),
        ("about a slanted axis",        [0.0, 3.0, 4.0, 180.0, 0.0, 0.0],       4.0 + 0.1),
        ("nothing",                     [0.0; 6],                               0.0),
    ];
    for (why, to, seconds) in cases {
        let mut bench = bench();
        position(&mut bench, "P", to);
        assert_eq!(bench.call(MOVE), OK, "{why}");
        let mut ticks = 0;
        let (mut last_line, mut last_turn) = (0, 0);
        while !bench.control("M").has(Flag::Pc) {
            bench.tick();
            ticks += 1;
            if of(&bench, MOVING, 1).norm() > 0.0 {
                last_line = ticks;
            }
            if of(&bench, TURNING, 1).norm() > 0.0 {
                last_turn = ticks;
            }
            assert!(
                of(&bench, MOVING, 1).norm() <= 100.0 + 1e-9 && turning(&bench) <= 45.0 + 1e-9,
                "{why}"
            );
        }
        let expected = f64::ceil(seconds * 1000.0 - 1e-6) as u64;
        assert_eq!(ticks.max(1), expected.max(1), "{why}");
        assert_eq!(shown(&bench), to, "{why}");
        let both = to[..3] != [0.0; 3] && to[3..] != [0.0; 3];
        assert!(!both || last_line == last_turn, "{why}: they end together");
    }
}

#[test]
fn percent_units_and_the_bits() {
    let mut bench = bench();
    set(&mut bench, "D", &[("UnitsMode", 0.0)]);
    dynamics(&mut bench, [50.0, 100.0, 100.0], [50.0, 50.0, 50.0]);
    position(&mut bench, "P", [0.0, 0.0, 0.0, 90.0, 0.0, 0.0]);
    assert_eq!(bench.call(MOVE), OK);
    assert!(bench.bits("M").contains("DN") && bench.bits("M").contains("IP") && bench.bits("M").contains("AC"));
    bench.run(50);
    assert!(bench.control("M").has(Flag::Accel));
    for axis in MOVING.into_iter().chain(TURNING) {
        assert_ne!(bench.axis(axis).motion_status & COORDINATED_MOTION_STATUS, 0, "{axis}");
    }
    bench.run(500);
    assert!(
        (bench.axis("RX").command[1] - 45.0).abs() < 1e-9,
        "half of 90 degrees/s"
    );
    assert!(!bench.control("M").has(Flag::Accel) && !bench.control("M").has(Flag::Decel));
    bench.until("M", Flag::Decel);
    bench.until("M", Flag::Pc);
    let shown = bench.control("M");
    assert!(!shown.has(Flag::Ip) && !shown.has(Flag::Ac) && !shown.has(Flag::CalculatedDataAvailable));
    for axis in TURNING {
        assert_eq!(bench.axis(axis).motion_status & COORDINATED_MOTION_STATUS, 0, "{axis}");
    }
}

#[test]
fn turns_counters_and_increments() {
    #[rustfmt::skip]
    let cases = [
        // why,                            first Rz,  increments, then,                                  J4, J6, Rz at the end, degrees gone
        ("a turn more",                    0.0,    false, [0.0, 0.0, 0.0, 0.0, 0.0, 45.0],       0.0,  1.0,  405.0,  405.0),
        ("a turn less",                    0.0,    false, [0.0, 0.0, 0.0, 0.0, 0.0, 45.0],       0.0,  -1.0, -315.0, 315.0),
        ("J4 turns the other way round",   0.0,    false, [0.0, 0.0, 0.0, 0.0, 0.0, 45.0],       1.0,  0.0,  -315.0, 315.0),
        ("within half a turn all the way", 170.0,  false, [0.0, 0.0, 0.0, 0.0, 0.0, -170.0],     0.0,  0.0,  -170.0, 340.0),
        ("over the edge with its turn",    170.0,  false, [0.0, 0.0, 0.0, 0.0, 0.0, -170.0],     0.0,  1.0,  190.0,  20.0),
        ("an increment",                   170.0,  true,  [0.0, 0.0, 0.0, 0.0, 0.0, 20.0],       0.0,  0.0,  190.0,  20.0),
        ("an increment and a turn",        170.0,  true,  [0.0, 0.0, 0.0, 0.0, 0.0, 20.0],       0.0,  1.0,  550.0,  380.0),
        ("a turn and nothing else",        30.0,   true,  [0.0; 6],                              0.0,  -1.0, -330.0, 360.0),
        ("angles beyond their range",      0.0,    false, [0.0, 0.0, 0.0, 0.0, 0.0, 370.0],      0.0,  0.0,  10.0,   10.0),
    ];
    for (why, first, incremental, then, fourth, sixth, at, gone) in cases {
        let mut bench = bench();
        position(&mut bench, "P", [0.0, 0.0, 0.0, 0.0, 0.0, first]);
        assert_eq!(bench.call(MOVE), OK, "{why}");
        bench.until_rest();
        bench.rung_false("M");
        position(&mut bench, "P", then);
        set(
            &mut bench,
            "P",
            &[
                ("MoveType", f64::from(u8::from(incremental))),
                ("TurnsCounters[1]", fourth),
                ("TurnsCounters[2]", sixth),
            ],
        );
        assert_eq!(bench.call(MOVE), OK, "{why}");
        let ticks = bench.until("M", Flag::Pc);
        assert!(
            (bench.position("RZ") - at).abs() < 1e-9,
            "{why}: {}",
            bench.position("RZ")
        );
        let expected = (gone / 45.0 + 0.1) * 1000.0;
        assert!(
            (ticks as f64 - expected).abs() <= 1.0,
            "{why}: {ticks} ticks are not {expected}"
        );
    }
}

#[test]
fn across_the_mirror_a_tool_tilts_on() {
    let mut bench = bench();
    position(&mut bench, "P", [0.0, 0.0, 0.0, 180.0, 80.0, 0.0]);
    assert_eq!(bench.call(MOVE), OK);
    bench.until_rest();
    bench.rung_false("M");
    position(&mut bench, "P", [0.0, 0.0, 0.0, 0.0, 80.0, 180.0]);
    assert_eq!(bench.call(MOVE), OK);
    let ticks = bench.until("M", Flag::Pc);
    assert!(
        (ticks as f64 - (20.0 / 45.0 + 0.1) * 1000.0).abs() <= 1.0,
        "20 degrees, not {ticks} ms"
    );
    assert_eq!(shown(&bench)[3..], [0.0, 80.0, 180.0]);
}

#[test]
fn it_shares_the_queue_with_lines() {
    let mut bench = bench();
    position(&mut bench, "P", [30.0, 0.0, 0.0, 0.0, 0.0, 40.0]);
    position(&mut bench, "Many[0]", [30.0, 60.0, 0.0, 0.0, 20.0, 40.0]);
    assert_eq!(bench.call(MOVE), OK);
    // A contour does not go over into a turn.
    let line = "MCLM(CART, L, 0, [30, 30, 0], 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 5)";
    assert_eq!(bench.call(line), OK);
    assert_eq!(bench.call("MCPM(CART, M2, Many[0], 1, D)"), OK);
    assert!(!bench.control("L").has(Flag::Ac));
    bench.until("M", Flag::Pc);
    assert!(bench.control("L").has(Flag::Ac));
    bench.until("L", Flag::Pc);
    // The next one begins within the same update.
    let kept = of(&bench, TURNING, 0) - Point::new(0.0, 0.0, 40.0);
    assert!(kept.norm() < 1e-3, "a line keeps the orientation: {kept}");
    bench.until("M2", Flag::Pc);
    assert_eq!(shown(&bench), [30.0, 60.0, 0.0, 0.0, 20.0, 40.0]);
    assert_eq!(
        bench.call("MCCM(CART, C, 0, [1, 2, 3], 0, [4, 5, 6], 0, 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2)"),
        (75, 0)
    );
}

#[test]
fn blends_begin_within_the_tolerance_and_turns_share_theirs() {
    let run = |kind: f64, tolerance: f64, first: [f64; 6], second: [f64; 6]| {
        let mut bench = bench();
        set(
            &mut bench,
            "P",
            &[("TerminationType", kind), ("CommandToleranceLinear", tolerance)],
        );
        position(&mut bench, "P", first);
        position(&mut bench, "Many[0]", second);
        assert_eq!(bench.call(MOVE), OK);
        assert_eq!(bench.call("MCPM(CART, M2, Many[0], 1, D)"), OK);
        let mut before = [of(&bench, MOVING, 1), of(&bench, TURNING, 1)];
        let mut ticks = 0;
        while !bench.control("M2").has(Flag::Pc) {
            bench.tick();
            ticks += 1;
            let now = [of(&bench, MOVING, 1), of(&bench, TURNING, 1)];
            assert!((now[0] - before[0]).norm() <= 2.0 + 1e-9, "a step of the speed");
            assert!((now[1] - before[1]).norm() <= 0.9 + 1e-6, "a step of the turn");
            before = now;
        }
        assert_eq!(shown(&bench), second);
        ticks
    };
    let (to, on) = ([100.0, 0.0, 0.0, 0.0, 0.0, 30.0], [100.0, 100.0, 0.0, 0.0, 20.0, 30.0]);
    let stopping = run(1.0, 0.0, to, on);
    assert_eq!(run(6.0, 0.0, to, on), stopping, "no tolerance");
    // Both brake for 0.1 s on the last 5 units; within these the second one begins.
    assert_eq!(run(6.0, 20.0, to, on), stopping - 100);
    assert!(run(6.0, 1.0, to, on) > stopping - 100 && run(6.0, 1.0, to, on) < stopping);
    let (to, on) = ([0.0, 0.0, 0.0, 0.0, 0.0, 40.0], [0.0, 0.0, 0.0, 0.0, 20.0, 40.0]);
    let stopping = run(1.0, 0.0, to, on);
    assert_eq!(
        run(6.0, 0.0, to, on),
        stopping - 100,
        "a turn has no tolerance: all of it"
    );
}

#[test]
fn both_parts_stop_pause_and_change_together() {
    let begun = || {
        let mut bench = bench();
        position(&mut bench, "P", [300.0, 0.0, 0.0, 0.0, 0.0, 90.0]);
        assert_eq!(bench.call(MOVE), OK);
        bench.run(1000);
        bench
    };
    let even = |bench: &Bench, why: &str| {
        let (x, angle) = (bench.position("X"), bench.position("RZ"));
        assert!((angle - 90.0 * x / 300.0).abs() < 1e-9, "{why}: {angle} at {x}");
        let (speed, rate) = (bench.axis("X").command[1], bench.axis("RZ").command[1]);
        assert!((rate - 90.0 * speed / 300.0).abs() < 1e-9, "{why}: {rate} at {speed}");
    };
    let mut bench = begun();
    assert_eq!(bench.call("MCS(CART, S, 2)"), OK);
    let mut before = bench.axis("RZ").command[1];
    while !bench.control("S").has(Flag::Pc) {
        bench.tick();
        even(&bench, "a stop");
        let now = bench.axis("RZ").command[1];
        assert!(now >= before - 0.9 - 1e-9, "it turns off faster than 900 degrees/s²");
        before = now;
    }
    assert!(!bench.control("M").has(Flag::Ip) && !bench.control("M").has(Flag::Pc));
    let stood = shown(&bench);
    bench.run(20);
    assert_eq!(shown(&bench), stood);
    // A start from the present position.
    assert_eq!(bench.call(MOVE), OK);
    bench.until("M", Flag::Pc);
    assert_eq!(shown(&bench), [300.0, 0.0, 0.0, 0.0, 0.0, 90.0]);

    let mut bench = begun();
    bench.set_override("CART", 0.0);
    bench.run(500);
    even(&bench, "a hold");
    assert_eq!((bench.axis("X").command[1], bench.axis("RZ").command[1]), (0.0, 0.0));
    assert!(bench.control("M").has(Flag::Ip));
    bench.set_override("CART", 0.5);
    bench.run(300);
    even(&bench, "half");
    assert!((bench.axis("X").command[1] - 50.0).abs() < 1e-9);

    let mut bench = begun();
    let change = |speed: f64| format!("MCCD(CART, C, 1, Yes, {speed}, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 2, 0)");
    assert_eq!(bench.call(&change(20.0)), OK);
    bench.run(300);
    even(&bench, "slower");
    assert!((bench.axis("X").command[1] - 20.0).abs() < 1e-9);
    bench.rung_false("C");
    assert_eq!(bench.call(&change(900.0)), OK);
    bench.run(200);
    even(&bench, "faster");
    assert!(
        (bench.axis("RZ").command[1] - 45.0).abs() < 1e-9,
        "as fast as the turn may be"
    );

    for call in ["MCSD(CART, S)", "MCS(CART, S, 0)"] {
        let mut bench = begun();
        assert_eq!(bench.call(call), OK);
        bench.run(400);
        assert_eq!(of(&bench, MOVING, 1) + of(&bench, TURNING, 1), Point::zeros(), "{call}");
        assert!(!bench.control("M").has(Flag::Ip), "{call}");
    }
}

#[test]
fn a_stop_of_a_rotation_alone_brakes_in_degrees() {
    let mut bench = bench();
    position(&mut bench, "P", [0.0, 0.0, 0.0, 0.0, 0.0, 90.0]);
    assert_eq!(bench.call(MOVE), OK);
    bench.run(1000);
    assert_eq!(bench.call("MCS(CART, S, 2)"), OK);
    assert_eq!(bench.until("S", Flag::Pc), 50, "45 degrees/s at 900 degrees/s²");
}

#[test]
fn a_master_drives_both_parts() {
    for (mode, linear, orientation, nominal) in [
        (1.0, [2.0, 0.5, 0.5], [1.0, 0.25, 0.25], 0.0),
        // 1000 units/s and 90 degrees/s at 50 master units/s.
        (
            0.0,
            [10.0, 12.5, 12.5],
            [55.555_555_555_555, 69.444_444_444_444, 69.444_444_444_444],
            50.0,
        ),
    ] {
        let mut bench = bench();
        set(&mut bench, "D", &[("UnitsMode", mode), ("TimeUnits", 1.0)]);
        dynamics(&mut bench, linear, orientation);
        position(&mut bench, "P", [100.0, 0.0, 0.0, 0.0, 0.0, 50.0]);
        assert_eq!(bench.call(&format!("MDCC(CART, U, L, 1, {nominal})")), OK);
        assert_eq!(bench.call("MCPM(CART, M, P, 1, D, 0, 1)"), OK);
        bench.run(20);
        assert_eq!(shown(&bench), [0.0; 6], "the master stands");
        assert_eq!(bench.call("MAJ(U, J, 0, 50, 0, 100000, 0, 100000, 0)"), OK);
        bench.run(500);
        let (x, angle) = (bench.position("X"), bench.position("RZ"));
        assert!(x > 10.0 && (angle - 0.5 * x).abs() < 1e-9, "{mode}: {angle} at {x}");
        assert!(
            (bench.axis("X").command[1] - 100.0).abs() < 1e-4,
            "{mode}: {}",
            bench.axis("X").command[1]
        );
        assert!((bench.axis("RZ").command[1] - 50.0).abs() < 1e-4, "{mode}");
        assert!(bench.control("M").has(Flag::TrackingMaster));
        bench.until("M", Flag::Pc);
        assert_eq!(shown(&bench), [100.0, 0.0, 0.0, 0.0, 0.0, 50.0]);
    }
}

/// The number of cases of a test: as `ARCLINE_PATH_CASES` says, or that of a long run, or of a plain one.
pub(super) fn path_cases(long: u64, plain: u64) -> u64 {
    std::env::var("ARCLINE_PATH_CASES").map_or(if is_long() { long } else { plain }, |text| {
        text.parse().expect("a number of cases")
    })
}

/// Both parts end exactly and together, within their limits, at every update period alike.
#[test]
fn any_two_path_moves() {
    for seed in 0..path_cases(6, 2) {
        let mut random = Random(seed);
        let points = [(); 2].map(|()| {
            let mut within = |bound: f64| f64::from(random.between(-bound, bound) as f32);
            let [x, y, z] = [within(40.0), within(40.0), within(40.0)];
            [x, y, z, within(170.0), within(80.0), within(170.0)]
        });
        let (blended, s_curve) = (random.below(2) == 1, random.below(2) == 1);
        let tolerance = random.between(0.0, 20.0);
        let why = format!("seed {seed}: {points:?} {blended} {s_curve} {tolerance}");
        let mut rows: Vec<Vec<[f64; 6]>> = Vec::new();
        for period in [0.25, 1.0, 4.0] {
            let mut bench = bench_of(RobotMachine { period, ..MACHINE });
            let termination = if blended { 6.0 } else { 1.0 };
            let members = [("TerminationType", termination), ("CommandToleranceLinear", tolerance)];
            set(&mut bench, "P", &members);
            set(&mut bench, "D", &[("Profile", f64::from(u8::from(s_curve)))]);
            position(&mut bench, "P", points[0]);
            position(&mut bench, "Many[0]", points[1]);
            assert_eq!(bench.call(MOVE), OK, "{why}");
            assert_eq!(bench.call("MCPM(CART, M2, Many[0], 1, D)"), OK, "{why}");
            let every = (4.0 / period) as u64;
            let mut row = Vec::new();
            let most = if blended { 2.0 } else { 1.0 };
            while !bench.control("M2").has(Flag::Pc) {
                bench.run(every);
                row.push(shown(&bench));
                assert!(of(&bench, MOVING, 1).norm() <= most * 100.0 + 1e-6, "{why}");
                let upright = bench.position("RY").abs() > 89.0;
                assert!(upright || turning(&bench) <= most * 45.0 + 1e-6, "{why}");
                assert!(row.len() < 20_000, "{why}: it does not end");
            }
            // Rx ends in the turn in which the move leads it.
            let mut end = shown(&bench);
            end[3] = nearest(end[3], points[1][3]);
            assert!((0..6).all(|k| (end[k] - points[1][k]).abs() < 1e-9), "{why}: {end:?}");
            rows.push(row);
        }
        for (place, fine) in rows[0].iter().enumerate() {
            for coarse in rows[1..].iter().filter_map(|row| row.get(place)) {
                assert!(apart(fine, coarse) < 1e-9, "{why}: {fine:?} is not {coarse:?}");
            }
        }
    }
}

/// The distance of two positions and orientations, units and parts of 1.
fn apart(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    let line = (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    let [a, b] = [a, b].map(|p| rotation(&Point::new(p[3], p[4], p[5])));
    line.max((a - b).abs().max())
}

/// Robots without orientation are moved as before.
#[test]
fn other_systems_have_no_path_moves() {
    let mut bench = Bench::with(&format!("{}{TAGS}", DELTA.config()));
    assert_eq!(bench.call(MOVE), (13, 0));
}

//! MCCD of the move that is under way (spec/coordinated-instructions.md §14): every unit, both jerks, jerks in percent of time,
//! and the derivation of §14.4 for rates that are lowered too late.

use arcline_instruction_set::{Flag, Object};
use arcline_tests::bench::{Bench, OK};

const PERIOD: f64 = 0.001;

/// The most that a motion along X did: speed, acceleration, deceleration, and the jerk while it sped up and while it slowed
/// down.
fn measured(bench: &mut Bench) -> [f64; 5] {
    let mut most = [0.0_f64; 5];
    let mut last = bench.axis("X").command[2];
    while !bench.control("M1").has(Flag::Pc) {
        bench.tick();
        let [_, speed, acceleration] = bench.axis("X").command;
        let jerk = ((acceleration - last) / PERIOD).abs();
        let sides = if acceleration.min(last) >= 0.0 { 3..4 } else { 4..5 };
        // In a tick that changes the sign of the acceleration, both jerks act.
        if acceleration * last >= 0.0 {
            for side in sides {
                most[side] = most[side].max(jerk);
            }
        }
        for (most, now) in most.iter_mut().zip([speed, acceleration, -acceleration]) {
            *most = most.max(now);
        }
        last = acceleration;
    }
    most
}

#[test]
fn every_value_in_every_unit() {
    // 100 units/s, 1000 units/s², 20,000 units/s³; XY has 500, 5000 and 100,000 at most.
    let base = [100.0, 1000.0, 1000.0, 2e4, 2e4];
    let with = |place: usize, value: f64| {
        let mut expected = base;
        expected[place] = value;
        expected
    };
    let both = |jerk: f64| [base[0], base[1], base[2], jerk, jerk];
    #[rustfmt::skip]
    let cases = [
        ("nothing",                       "No, 0, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 0", base),
        ("speed, units/s",                "Yes, 150, Unitspersec, No, 0, 0, No, 0, 0, No, 0, No, 0, 0", with(0, 150.0)),
        ("speed, % of maximum",           "Yes, 30, %ofMaximum, No, 0, 0, No, 0, 0, No, 0, No, 0, 0", with(0, 150.0)),
        ("accel, units/s2",               "No, 0, 0, Yes, 1300, Unitspersec2, No, 0, 0, No, 0, No, 0, 0", with(1, 1300.0)),
        ("accel, % of maximum",           "No, 0, 0, Yes, 24, %ofMaximum, No, 0, 0, No, 0, No, 0, 0", with(1, 1200.0)),
        ("decel, units/s2",               "No, 0, 0, No, 0, 0, Yes, 800, Unitspersec2, No, 0, No, 0, 0", with(2, 800.0)),
        ("decel, % of maximum",           "No, 0, 0, No, 0, 0, Yes, 16, %ofMaximum, No, 0, No, 0, 0", with(2, 800.0)),
        ("accel jerk, units/s3",          "No, 0, 0, No, 0, 0, No, 0, 0, Yes, 15000, No, 0, Unitspersec3", with(3, 15_000.0)),
        ("decel jerk, units/s3",          "No, 0, 0, No, 0, 0, No, 0, 0, No, 0, Yes, 40000, Unitspersec3", with(4, 40_000.0)),
        ("accel jerk, % of maximum",      "No, 0, 0, No, 0, 0, No, 0, 0, Yes, 30, No, 0, %ofMaximum", with(3, 30_000.0)),
        ("decel jerk, % of maximum",      "No, 0, 0, No, 0, 0, No, 0, 0, No, 0, Yes, 12, %ofMaximum", with(4, 12_000.0)),
        ("both jerks, % of time",         "No, 0, 0, No, 0, 0, No, 0, 0, Yes, 80, Yes, 80, %ofTime", both(15_000.0)),
        ("decel jerk, % of time",         "No, 0, 0, No, 0, 0, No, 0, 0, No, 0, Yes, 50, %ofTime", with(4, 30_000.0)),
        ("% of time of the new speed",    "Yes, 150, 0, No, 0, 0, No, 0, 0, Yes, 80, Yes, 80, %ofTime", [150.0, 1000.0, 1000.0, 1e4, 1e4]),
        ("all",                           "Yes, 150, 0, Yes, 1500, 0, Yes, 900, 0, Yes, 30000, Yes, 25000, 0", [150.0, 1500.0, 900.0, 3e4, 2.5e4]),
    ];
    for (why, change, expected) in cases {
        let mut bench = Bench::new();
        let call = "MCLM(XY, M1, 0, [400, 0], 100, 0, 1000, 0, 1000, 0, S-curve, 20000, 20000, Unitspersec3, 1)";
        assert_eq!(bench.call(call), OK);
        assert_eq!(
            bench.call(&format!("MCCD(XY, C1, CoordinatedMove, {change}, ActiveMotion)")),
            OK,
            "{why}"
        );
        for (place, (got, wanted)) in measured(&mut bench).iter().zip(expected).enumerate() {
            assert!(
                (got - wanted).abs() < 1e-6 * wanted,
                "{why}: {got} for value {place}, not {wanted}"
            );
        }
        assert_eq!(bench.axis("X").command, [400.0, 0.0, 0.0], "{why}");
    }
}

#[test]
fn a_jerk_in_percent_of_time_follows_whatever_is_changed() {
    // a²/v (200/p - 1): 60 % of 100 units/s at 1000 units/s² are 23,333 units/s³.
    let percent = |speed: f64, rate: f64| rate * rate / speed * (200.0 / 60.0 - 1.0);
    #[rustfmt::skip]
    let cases = [
        ("speed",      "Yes, 150, 0",             [150.0, 1000.0, 1000.0]),
        ("accel",      "No, 0, 0, Yes, 1600, 0",  [100.0, 1600.0, 1000.0]),
        ("decel",      "No, 0, 0, No, 0, 0, Yes, 700, 0", [100.0, 1000.0, 700.0]),
        ("all three",  "Yes, 120, 0, Yes, 900, 0, Yes, 1300, 0", [120.0, 900.0, 1300.0]),
    ];
    for (why, change, [speed, accel, decel]) in cases {
        let mut bench = Bench::new();
        let call = "MCLM(XY, M1, 0, [400, 0], 100, 0, 1000, 0, 1000, 0, S-curve, 60, 60, %ofTime, 1)";
        assert_eq!(bench.call(call), OK);
        assert_eq!(
            bench.call(&format!("MCCD(XY, C1, CoordinatedMove, {change})")),
            OK,
            "{why}"
        );
        let expected = [speed, accel, decel, percent(speed, accel), percent(speed, decel)];
        for (got, wanted) in measured(&mut bench).iter().zip(expected) {
            assert!((got - wanted).abs() < 1e-6 * wanted, "{why}: {got}, not {wanted}");
        }
    }
}

/// Runs to the end; the highest and the lowest velocity along X, and the furthest place.
fn extremes(bench: &mut Bench) -> [f64; 3] {
    let mut found = [f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
    while !bench.control("M1").has(Flag::Pc) {
        bench.tick();
        let [place, velocity, _] = bench.axis("X").command;
        found = [found[0].max(velocity), found[1].min(velocity), found[2].max(place)];
    }
    found
}

#[test]
fn an_acceleration_that_returns_too_slowly_takes_the_speed_beyond_the_programmed_one() {
    // v + A²/2j' > V: the speed passes V up to that, and a second ramp brings it back (spec/coordinated-instructions.md §14.4).
    #[rustfmt::skip]
    let cases = [
        ("a lower jerk",                      "50000, 50000, 0", "No, 0, 0, No, 0, 0, No, 0, 0, Yes, 10000, No, 0, 0", 10_000.0),
        ("a lower accel, jerk in % of time",  "100, 100, 2",     "No, 0, 0, Yes, 700, 0",                              2450.0),
    ];
    // At most 1.5 times the programmed speed, unless Reduced Extreme Velocity Overshoot is off (spec/coordinated-instructions.md §5.4).
    let all = cases
        .iter()
        .flat_map(|case| [(case, 7, 300.0), (case, 3, f64::INFINITY)]);
    for ((why, jerks, change, jerk), bits, bound) in all {
        let system = format!("name = \"XY\"\ndynamics_configuration_bits = {bits}");
        let mut bench = Bench::replacing("name = \"XY\"", &system);
        bench.execute(&format!(
            "MCLM(XY, M1, 0, [2000, 0], 200, 0, 2000, 0, 2000, 0, 1, {jerks}, 1)"
        ));
        bench.run(60);
        let [_, speed, acceleration] = bench.axis("X").command;
        assert_eq!(bench.call(&format!("MCCD(XY, C1, 1, {change})")), OK);
        let most = bound.min(speed + acceleration * acceleration / (2.0 * jerk));
        assert!(most > 220.0, "{why}: {most} is no overshoot");
        let mut cruise = 0;
        let mut top = 0.0_f64;
        while !bench.control("M1").has(Flag::Pc) {
            bench.tick();
            let speed = bench.axis("X").command[1];
            top = top.max(speed);
            cruise += u32::from(speed == 200.0);
        }
        assert!((top - most).abs() < 1e-2, "{why}: up to {top}, not {most}");
        assert!(cruise > 1000, "{why}: back at the programmed speed for {cruise} ms");
        assert_eq!(bench.position("X"), 2000.0, "{why}");
    }
}

/// Dynamics Configuration Bits that are set while the machine runs count from the next instruction on
/// (spec/axis-and-data-types.md §9.6): the fastest of a move whose jerk a change lowers.
#[test]
fn the_bound_of_the_overshoot_is_switched_while_the_machine_runs() {
    let fastest = |before: u32, at_the_change: Option<u32>, after: Option<u32>| {
        let mut bench = Bench::replacing(
            "name = \"XY\"",
            &format!("name = \"XY\"\ndynamics_configuration_bits = {before}"),
        );
        bench.execute("MCLM(XY, M1, 0, [2000, 0], 200, 0, 2000, 0, 2000, 0, 1, 50000, 50000, 0, 1)");
        bench.run(60);
        if let Some(bits) = at_the_change {
            bench.set_dynamics_bits(Object::CoordinateSystem, "XY", bits);
        }
        assert_eq!(
            bench.call("MCCD(XY, C1, 1, No, 0, 0, No, 0, 0, No, 0, 0, Yes, 5000, No, 0, 0)"),
            OK
        );
        if let Some(bits) = after {
            bench.set_dynamics_bits(Object::CoordinateSystem, "XY", bits);
        }
        let mut top = 0.0_f64;
        while !bench.control("M1").has(Flag::Pc) {
            bench.tick();
            top = top.max(bench.axis("X").command[1]);
        }
        assert_eq!(bench.position("X"), 2000.0);
        top
    };
    let (bounded, free) = (fastest(7, None, None), fastest(3, None, None));
    assert!((bounded - 300.0).abs() < 1e-2 && free > 301.0, "{bounded}, {free}");
    #[rustfmt::skip]
    let cases = [
        ("switched off before the change",  7, Some(3), None,    free),
        ("switched on before the change",   3, Some(7), None,    bounded),
        ("switched off after the change",   7, None,    Some(3), bounded),
        ("switched on after the change",    3, None,    Some(7), free),
    ];
    for (why, before, at, after, expected) in cases {
        assert_eq!(fastest(before, at, after), expected, "{why}");
    }
}

/// The same of an axis: MCD in a move, and MAS while an S-curve brakes, whose reversal bit 1 prevents.
#[test]
fn the_bits_of_an_axis_are_switched_while_the_machine_runs() {
    let fastest = |bits: Option<u32>| {
        let mut bench = Bench::new();
        bench.execute("MAM(X, M1, 0, 2000, 200, 0, 2000, 0, 2000, 0, 1, 50000, 50000, 0)");
        bench.run(60);
        if let Some(bits) = bits {
            bench.set_dynamics_bits(Object::Axis, "X", bits);
        }
        assert_eq!(
            bench.call("MCD(X, C1, 1, No, 0, No, 0, No, 0, Yes, 5000, No, 0, 0, 0, 0, 0)"),
            OK
        );
        let mut top = 0.0_f64;
        while !bench.control("M1").has(Flag::Pc) {
            bench.tick();
            top = top.max(bench.axis("X").command[1]);
        }
        top
    };
    let (bounded, free) = (fastest(None), fastest(Some(3)));
    assert!(bounded < 300.0 + 1e-2 && free > bounded + 1.0, "{bounded}, {free}");
    let lowest = |bits: Option<u32>| {
        let mut bench = Bench::new();
        bench.execute("MAM(X, M1, 0, 100, 200, 0, 2000, 0, 2000, 0, 1, 50000, 50000, 0)");
        // It brakes from 500 ms on, at 80 units/s and full deceleration now.
        bench.run(580);
        if let Some(bits) = bits {
            bench.set_dynamics_bits(Object::Axis, "X", bits);
        }
        assert_eq!(bench.call("MAS(X, S2, Move, Yes, 2000, 0, Yes, 9000, 0)"), OK);
        let mut least = 0.0_f64;
        while !bench.control("S2").has(Flag::Pc) {
            bench.tick();
            least = least.min(bench.axis("X").command[1]);
        }
        least
    };
    assert_eq!(lowest(None), 0.0, "no reversal");
    assert!(lowest(Some(5)) < -1.0, "a reversal: {}", lowest(Some(5)));
    // An object that does not exist, and a restart, which brings the configured bits back.
    let mut bench = Bench::new();
    bench.set_dynamics_bits(Object::MotionGroup, "Motion", 0);
    assert_eq!(bench.machine().axes[0].dynamics_bits.bits(), 7);
}

#[test]
fn a_deceleration_that_is_lowered_too_late_passes_the_end_and_comes_back() {
    struct Case {
        why: &'static str,
        rates: &'static str,
        until: f64,
        change: &'static str,
        /// The lowest velocity, of speed and deceleration at the change.
        lowest: fn(f64, f64) -> Option<f64>,
        /// The distance beyond the end, from the speed and the distance to go at the change.
        beyond: fn(f64, f64) -> Option<f64>,
    }
    let cases = [
        Case {
            why: "a trapezoid stops v²/2d' behind the change",
            rates: "0, 100, 100, 2",
            until: 92.0,
            change: "No, 0, 0, No, 0, 0, Yes, 500, 0",
            lowest: |_, _| None,
            beyond: |speed, to_go| Some(speed * speed / (2.0 * 500.0) - to_go),
        },
        Case {
            why: "an S-curve stops later too",
            rates: "1, 50000, 50000, 0",
            until: 92.0,
            change: "No, 0, 0, No, 0, 0, Yes, 500, 0",
            lowest: |_, _| None,
            beyond: |_, _| None,
        },
        Case {
            why: "v - b²/2j' < 0: rest is passed with what is left of b, and taken back with the accel jerk",
            rates: "1, 50000, 50000, 0",
            until: 99.0,
            change: "No, 0, 0, No, 0, 0, No, 0, 0, No, 0, Yes, 10000, 0",
            lowest: |speed, rate| Some(-(rate * rate - 2.0 * 10_000.0 * speed) / (2.0 * 50_000.0)),
            beyond: |_, _| None,
        },
    ];
    for case in cases {
        let why = case.why;
        let mut bench = Bench::new();
        bench.execute(&format!(
            "MCLM(XY, M1, 0, [100, 0], 200, 0, 2000, 0, 2000, 0, {}, 1)",
            case.rates
        ));
        while bench.position("X") < case.until {
            bench.tick();
        }
        let [place, speed, acceleration] = bench.axis("X").command;
        assert!(acceleration < 0.0, "{why}: it brakes");
        assert_eq!(bench.call(&format!("MCCD(XY, C1, 1, {})", case.change)), OK);
        let [_, lowest, furthest] = extremes(&mut bench);
        assert!(lowest < -0.5, "{why}: it comes back, {lowest}");
        if let Some(expected) = (case.lowest)(speed, -acceleration) {
            assert!((lowest - expected).abs() < 0.05, "{why}: {lowest}, not {expected}");
        } else {
            assert!(furthest > 100.5, "{why}: {furthest}");
        }
        if let Some(expected) = (case.beyond)(speed, 100.0 - place) {
            let beyond = furthest - 100.0;
            assert!((beyond - expected).abs() < 1e-2, "{why}: {beyond}, not {expected}");
        }
        assert_eq!(bench.axis("X").command, [100.0, 0.0, 0.0], "{why}");
        assert_eq!(bench.bits("M1"), "EN DN PC", "{why}");
    }
}

#[test]
fn a_change_anywhere_in_a_thousand_moves_reaches_every_one_of_them() {
    // Pieces of 0.1 mm along X; changes come while the ones before are still on their way through the queue.
    let mut bench = Bench::replacing("name = \"XY\"", "name = \"XY\"\nqueue_depth = 1000");
    let count = 1001;
    for place in 1..=count {
        let x = 0.1 * f64::from(place);
        let end = if place == count { 1 } else { 4 };
        let call = format!("MCLM(XY, M{place}, 0, [{x}, 0], 100, 0, 2000, 0, 2000, 0, 1, 60, 60, 2, {end})");
        assert_eq!(bench.call(&call), OK);
    }
    let change = |bench: &mut Bench, change: &str| {
        assert_eq!(
            bench.call(&format!("MCCD(XY, C1, 1, {change}, ActiveandPendingMotion)")),
            OK
        );
    };
    bench.run(200);
    change(&mut bench, "Yes, 50, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 0");
    bench.run(1);
    change(&mut bench, "No, 0, 0, No, 0, 0, Yes, 1000, 0, No, 0, No, 0, 0");
    bench.run(3);
    change(&mut bench, "Yes, 80, 0, Yes, 3000, 0, No, 0, 0, No, 0, No, 0, 0");
    bench.run(200);
    let mut speeds: Vec<f64> = Vec::new();
    let mut most = 0.0_f64;
    while !bench.control(&format!("M{count}")).has(Flag::Pc) {
        bench.tick();
        let [_, speed, acceleration] = bench.axis("X").command;
        speeds.push(speed);
        most = most.max(-acceleration);
    }
    // 80 units/s up to the last ramp, which takes 80 / 1000 s and 60 % of it as long again by jerks: 0.114 s.
    let cruise = &speeds[..speeds.len() - 116];
    assert!(
        cruise.iter().all(|speed| (speed - 80.0).abs() < 1e-6),
        "{:?}",
        &cruise[..20]
    );
    assert!((most - 1000.0).abs() < 1e-3, "{most}");
    assert_eq!(bench.axis("X").command, [0.1 * f64::from(count), 0.0, 0.0]);
}

#[test]
fn a_change_is_refused_for_a_pending_move_that_cannot_have_it() {
    // The pending one is driven by a master, the active one by time: one change cannot be both (spec/coordinated-instructions.md §14, 105).
    let mut bench = Bench::new();
    assert_eq!(bench.call("MDCC(XY, A, D1, Command, 0)"), OK);
    bench.execute("MCLM(XY, M1, 0, [100, 0], 100, 0, 2000, 0, 2000, 0, 1, 100, 100, 2, 1)");
    let driven = "MCLM(XY, M2, 0, [100, 50], 2, Unitspermasterunit, 1, Unitspermasterunit2, 1, Unitspermasterunit2, Trapezoidal, \
                  100, 100, %ofTimeMasterDriven, 1, Disabled, Programmed, 0, 0, ImmediateForwardOnly, 0, 0)";
    assert_eq!(bench.call(driven), OK);
    let change = |scope: &str| format!("MCCD(XY, C1, 1, Yes, 80, 0, No, 0, 0, No, 0, 0, No, 0, No, 0, 0, {scope})");
    assert_eq!(bench.call(&change("ActiveandPendingMotion")).0, 105);
    assert_eq!(bench.call(&change("ActiveMotion")), OK);
    // Without waiting moves, all dynamics can be changed.
    bench.until("M1", Flag::Pc);
    assert_eq!(bench.position("X"), 100.0);
}

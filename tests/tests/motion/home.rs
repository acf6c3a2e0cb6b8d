//! Homing and redefined positions (spec/axis-and-data-types.md §3.2, §3.7, §9.4, §11).

use arcline_instruction_set::predefined::{axis_event, motion_status};
use arcline_instruction_set::{Flag, Object, Quantity};
use arcline_tests::bench::{Bench, OK};

/// Speed, rates and profile of every move here: a trapezoid at 100 units/s.
const RATES: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
/// The same for a coordinated move, behind its end point.
const ALONG: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1";

/// A machine of the servo axes X and Y in the coordinate system XY, X with `keys` of its own.
fn machine(keys: &str) -> Bench {
    machine_at(1.0, keys)
}

fn machine_at(period: f64, keys: &str) -> Bench {
    let dynamics = "max_speed = 1000\nmax_acceleration = 1000\nmax_acceleration_jerk = 20000\n";
    let axis = |name: &str| format!("[[axis]]\nname = \"{name}\"\ntype = \"servo\"\n{dynamics}");
    Bench::with(&format!(
        "[motion_group]\ncoarse_update_period_ms = {period}\n{}{keys}\n{}[[coordinate_system]]\nname = \"XY\"\n\
         axes = [\"X\", \"Y\"]\n{dynamics}",
        axis("X"),
        axis("Y")
    ))
}

fn has(bench: &Bench, bit: u32) -> bool {
    bench.axis("X").motion_status & bit != 0
}

fn event(bench: &Bench) -> u32 {
    bench.axis("X").event
}

const ARMED: u32 = axis_event::HOME_EVENT_ARMED_STATUS;
const CAME: u32 = axis_event::HOME_EVENT_STATUS;
const HOMED: u32 = motion_status::AXIS_HOMED_STATUS;
const HOMING: u32 = motion_status::HOMING_STATUS;

/// Braking distance from 50 units/s at 1000 units/s².
const BRAKE: f64 = 1.25;

#[test]
fn every_sequence_ends_where_it_should() {
    let linear = "";
    let rotary = "unwind = 360\n";
    let far = "start = { position = -40, homed = false }\n";
    let beyond = "start = { position = 5, homed = false }\n";
    let turned = "start = { position = 200, homed = false }\n";
    let inside = "start = { position = 30, homed = false }\n";
    let switch = "switch = { min = 0, max = 60 }";
    let across = "switch = { min = 350, max = 40 }";
    let markers = "marker = { at = 3, every = 10 }";
    let once = "marker = {}";
    let (f, b, uf) = (
        "bidirectional-forward",
        "bidirectional-reverse",
        "unidirectional-forward",
    );
    let ur = "unidirectional-reverse";
    #[rustfmt::skip]
    let cases = [
        // axis, start,         sequence, direction, sensor,                    end, and machine position of it
        // Home Position 7, Home Offset 2: the axis ends 2 units from the event, at position 7.
        (linear, far,           "switch", f,         switch.to_owned(),         7.0, 2.0),
        (linear, beyond,        "switch", f,         switch.to_owned(),         7.0, 2.0),
        (linear, "start = { position = 80, homed = false }\n", "switch", b, switch.to_owned(), 7.0, 62.0),
        (linear, beyond,        "switch", b,         switch.to_owned(),         7.0, 62.0),
        (linear, far,           "switch", uf,        switch.to_owned(),         5.0 + BRAKE, BRAKE),
        (linear, "start = { position = 80, homed = false }\n", "switch", ur, switch.to_owned(), 5.0 - BRAKE, 60.0 - BRAKE),
        (linear, far,           "marker", f,         once.to_owned(),           7.0, 2.0),
        (linear, far,           "marker", uf,        once.to_owned(),           5.0 + BRAKE, BRAKE),
        (linear, beyond,        "marker", f,         markers.to_owned(),        7.0, 15.0),
        (linear, beyond,        "marker", b,         markers.to_owned(),        7.0, 5.0),
        (linear, far,           "switch-marker", f,  format!("{switch}, {markers}"), 7.0, -5.0),
        (linear, beyond,        "switch-marker", f,  format!("{switch}, {markers}"), 7.0, -5.0),
        (linear, beyond,        "switch-marker", b,  format!("{switch}, {markers}"), 7.0, 65.0),
        (linear, far,           "switch-marker", uf, format!("{switch}, {markers}"), 5.0 + BRAKE, 3.0 + BRAKE),
        (rotary, turned,        "switch", f,         across.to_owned(),         7.0, 352.0),
        (rotary, inside,        "switch", f,         across.to_owned(),         7.0, 352.0),
        (rotary, turned,        "switch", b,         across.to_owned(),         7.0, 42.0),
        (rotary, inside,        "switch", b,         across.to_owned(),         7.0, 42.0),
        // A rotary axis that does not turn back goes on to the Home Position.
        (rotary, turned,        "switch", uf,        across.to_owned(),         7.0, 352.0),
        (rotary, inside,        "switch", uf,        across.to_owned(),         7.0, 352.0),
        (rotary, turned,        "switch", ur,        across.to_owned(),         7.0, 42.0),
        (rotary, turned,        "marker", f,         once.to_owned(),           7.0, 2.0),
        (rotary, turned,        "marker", uf,        once.to_owned(),           7.0, 2.0),
        (rotary, turned,        "marker", ur,        once.to_owned(),           7.0, 2.0),
        (rotary, turned,        "switch-marker", f,  format!("{across}, {once}"), 7.0, 2.0),
        (rotary, turned,        "switch-marker", uf, format!("{across}, {once}"), 7.0, 2.0),
        (rotary, inside,        "switch-marker", uf, format!("{across}, {once}"), 7.0, 2.0),
    ];
    for (axis, start, sequence, direction, sensor, end, machine_end) in cases {
        let keys = format!(
            "{axis}{start}home = {{ sequence = \"{sequence}\", direction = \"{direction}\", position = 7, offset = 2, \
             speed = 50, return_speed = 20, {sensor} }}\n"
        );
        let mut bench = machine(&keys);
        let begin = bench.position("X");
        assert_eq!(bench.call("MAH(X, H1)"), OK, "{keys}");
        assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN IP", ARMED), "{keys}");
        // The real position of the axis: the sum of its movement, update by update, without redefinitions.
        let mut machine_position = begin;
        let mut last = bench.axis("X").actual[1];
        while !bench.control("H1").has(Flag::Pc) {
            assert!(bench.now() < 60_000, "not found: {keys}");
            assert!(has(&bench, HOMING) && !has(&bench, HOMED), "{keys}");
            bench.tick();
            let now = bench.axis("X").actual[1];
            machine_position += 0.5 * (last + now) * 0.001;
            last = now;
        }
        let axis = bench.axis("X");
        assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN DN PC", CAME), "{keys}");
        assert!(!has(&bench, HOMING) && has(&bench, HOMED), "{keys}");
        let exact = direction.starts_with("bi") || keys.contains("unwind");
        let apart = (axis.command[0] - end).abs();
        assert!(
            if exact { apart == 0.0 } else { apart < 1e-9 },
            "ends at {} instead of {end}: {keys}",
            axis.command[0]
        );
        let turn = if keys.contains("unwind") { 360.0 } else { f64::INFINITY };
        let mut apart = (machine_position - machine_end).abs();
        if turn.is_finite() {
            apart = (apart / turn - (apart / turn).round()).abs() * turn;
        }
        assert!(
            apart < 0.02,
            "is at {machine_position}, not {machine_end}, of the machine: {keys}"
        );
        assert_eq!(axis.command[1], 0.0, "{keys}");
        bench.run(5);
        assert_eq!(bench.axis("X").command[0], axis.command[0], "stays: {keys}");
    }
}

/// A machine whose X homes forward on a switch at 0, from -40.
fn on_switch() -> Bench {
    machine(
        "start = { position = -40 }\nhome = { sequence = \"switch\", speed = 50, return_speed = 20, switch = {} }\n",
    )
}

/// A machine whose X waits for a sensor that others move it to.
fn waiting(sequence: &str) -> Bench {
    machine(&format!(
        "start = {{ position = -10.5 }}\nhome = {{ mode = \"passive\", sequence = \"{sequence}\", position = 100, \
         switch = {{}}, marker = {{ at = 3, every = 10 }} }}\n"
    ))
}

#[test]
fn the_way_does_not_show_the_update_period() {
    // The command is a function of time from latch to latch, at every period. A drive with lag sees the command only at the ticks, also of a leg
    // that begins inside one; its result is the same up to a share of its movement in that tick.
    let follows = "velocity_feedforward = 1.0";
    let lags = "position_bandwidth_hz = 5, velocity_feedforward = 0.2";
    let run = |drive: &str, period: f64, sequence: &str, direction: &str| {
        let mut bench = machine_at(
            period,
            &format!(
                "start = {{ position = -40.3 }}\ndrive = {{ {drive} }}\n\
                 home = {{ sequence = \"{sequence}\", direction = \"{direction}\", position = 7, offset = 2, speed = 37, \
                 return_speed = 13, acceleration = 333, deceleration = 444, switch = {{}}, \
                 marker = {{ at = 0.7, every = 8 }} }}\n"
            ),
        );
        assert_eq!(bench.call("MAH(X, H1)"), OK);
        let every = (4.0 / period).round() as u64;
        let mut way = Vec::new();
        for _ in 0..2000 {
            let axis = bench.axis("X");
            way.push((axis.command[0], axis.actual[0]));
            bench.run(every);
        }
        assert_eq!(bench.bits("H1"), "EN DN PC", "{sequence} {direction}");
        way
    };
    for sequence in ["switch", "marker", "switch-marker"] {
        for direction in ["bidirectional-forward", "unidirectional-forward"] {
            for (drive, tolerance) in [(follows, 1e-9), (lags, 2e-3)] {
                let [fine, plain, coarse] = [0.25, 1.0, 4.0].map(|period| run(drive, period, sequence, direction));
                for other in [&plain, &coarse] {
                    for (at, (a, b)) in fine.iter().zip(other).enumerate() {
                        let mut apart = (a.0 - b.0).abs();
                        if drive == lags {
                            apart = apart.max((a.1 - b.1).abs());
                        }
                        assert!(
                            apart < tolerance,
                            "{drive}, {sequence} {direction}: {apart} apart at {} ms: {a:?} {b:?}",
                            4 * at
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn the_bits_of_homing_at_their_ticks() {
    let mut bench = on_switch();
    bench.call("MAH(X, H1)");
    assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN IP", ARMED));
    assert!(
        has(&bench, HOMING) && !has(&bench, HOMED),
        "a new MAH clears AxisHomedStatus"
    );
    // 40 / 50 + 50 / 1000 / 2 s to the switch; 50 / 1000 s to stand; 20 / 1000 s and 1.05 / 20 s back to its edge.
    let expected: f64 = 825.0 + 50.0 + 20.0 + (1.25 - 0.2) / 20.0 * 1000.0;
    while event(&bench) == ARMED {
        bench.tick();
    }
    assert_eq!(bench.now() as f64, expected.ceil(), "the event");
    assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN IP", CAME));
    // 20 / 1000 s to stand 0.2 behind the edge, and from there 2 sqrt(0.2 / 1000) s to it.
    let expected = expected + 20.0 + 2000.0 * (0.2f64 / 1000.0).sqrt();
    bench.until("H1", Flag::Pc);
    assert_eq!(bench.now() as f64, expected.ceil(), "the end");
    assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN DN PC", CAME));
    assert_eq!(bench.axis("X").command, [0.0; 3]);
    assert!(has(&bench, HOMED) && !has(&bench, HOMING));

    bench.rung_false("H1");
    assert_eq!(bench.bits("H1"), "DN PC");
    bench.tick();
    // The axis stands on the edge of the switch, which is found at once.
    bench.call("MAH(X, H1)");
    assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN IP", ARMED));
    bench.until("H1", Flag::Pc);
    assert_eq!(bench.position("X"), 0.0);
}

#[test]
fn immediate_homing_takes_the_position_and_moves_nothing() {
    let home = "home = { position = 12.3 }\n";
    for servo in [
        "start = { position = 0.1, servo_on = false }\n",
        "start = { position = 0.1 }\n",
    ] {
        let mut bench = machine(&format!("{servo}{home}"));
        assert_eq!(bench.call("MAH(X, H1)"), OK);
        assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN IP", 0));
        bench.tick();
        assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN DN PC", CAME));
        let axis = bench.axis("X");
        assert_eq!(
            (axis.command, axis.actual),
            ([12.3, 0.0, 0.0], [12.3, 0.0, 0.0]),
            "{servo}"
        );
        assert!(has(&bench, HOMED));
    }
    // A moving axis is stopped first, and so is the coordinated motion that it takes part in.
    let mut bench = machine(home);
    bench.call(&format!("MCLM(XY, M1, 0, [1000, 1000], {ALONG})"));
    bench.call(&format!("MAM(X, M2, 1, 500, {RATES})"));
    bench.run(500);
    assert_eq!(bench.call("MAH(X, H1)"), OK);
    assert_eq!(
        (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
        ("EN DN", "EN DN")
    );
    let speed = bench.axis("X").command[1];
    bench.until("H1", Flag::Pc);
    assert_eq!(bench.axis("X").command, [12.3, 0.0, 0.0]);
    assert!(
        (bench.now() as f64 - 500.0 - speed).abs() <= 1.0,
        "braked from {speed} at 1000 units/s²"
    );
    bench.until_rest();
    assert_eq!(bench.axis("Y").command[1], 0.0, "the other axis brakes");
}

#[test]
fn other_instructions_while_an_axis_is_homed() {
    #[rustfmt::skip]
    let cases = [
        // why,                        call,                                              active,  passive
        ("a move",                     format!("MAM(X, M1, 0, 50, {RATES})"),             (16, 0), OK),
        ("a redefined position",       "MRP(X, M1, 0, 0, 5)".to_owned(),                  (16, 0), (85, 0)),
        ("homing again",               "MAH(X, M1)".to_owned(),                           (16, 0), OK),
        ("homing with the same tag",   "MAH(X, H1)".to_owned(),                           (3, 0),  (3, 0)),
        ("a coordinated move",         format!("MCLM(XY, M1, 0, [50, 50], {ALONG})"),     (16, 0), OK),
        ("a move of another axis",     format!("MAM(Y, M1, 0, 50, {RATES})"),             OK,      OK),
        ("a stop of something else",   "MAS(X, M1, Move, No, 100, 0, No, 100, 2)".to_owned(), OK,  OK),
        ("a reset of faults",          "MAFR(X, M1)".to_owned(),                          OK,      OK),
    ];
    for (why, call, active, passive) in &cases {
        let mut bench = on_switch();
        bench.call("MAH(X, H1)");
        bench.run(100);
        assert_eq!(bench.call(call), *active, "{why}, active");
        let mut bench = waiting("switch");
        bench.call("MAH(X, H1)");
        bench.run(100);
        assert_eq!(bench.call(call), *passive, "{why}, passive");
    }
    // The axis index is that of the coordinate system.
    let mut bench = Bench::with(
        "[[axis]]\nname = \"Y\"\ntype = \"servo\"\nmax_speed = 9\nmax_acceleration = 9\n[[axis]]\nname = \"X\"\ntype = \
         \"servo\"\nmax_speed = 9\nmax_acceleration = 9\nhome = { sequence = \"marker\", speed = 5, marker = { at = 9 } }\n\
         [[coordinate_system]]\nname = \"XY\"\naxes = [\"Y\", \"X\"]\nmax_speed = 9\nmax_acceleration = 9\n",
    );
    bench.call("MAH(X, H1)");
    assert_eq!(bench.call(&format!("MCLM(XY, M1, 0, [50, 50], {ALONG})")), (16, 1));
}

#[test]
fn instructions_that_end_homing() {
    let cases = [
        "MAS(X, S1, Home, No, 100, 0, No, 100, 2)",
        "MAS(X, S1, All, No, 100, 0, No, 100, 2)",
        "MSF(X, S1)",
        "MASD(X, S1)",
    ];
    for call in cases {
        for (why, mut bench) in [("active", on_switch()), ("passive", waiting("switch"))] {
            bench.call("MAH(X, H1)");
            bench.run(100);
            assert_eq!(bench.call(call), OK, "{call}, {why}");
            assert_eq!(
                (bench.bits("H1").as_str(), event(&bench)),
                ("EN DN", 0),
                "{call}, {why}"
            );
            assert!(!has(&bench, HOMING) && !has(&bench, HOMED), "{call}, {why}");
            bench.run(2000);
            assert_eq!(bench.axis("X").command[1], 0.0, "{call}, {why}");
            let servo = !call.starts_with("MAS(");
            assert_eq!(
                bench.bits("S1"),
                if servo { "EN DN" } else { "EN DN PC" },
                "{call}, {why}"
            );
            if !servo {
                assert_eq!(bench.call("MAH(X, H2)"), OK, "{call}, {why}: again");
            }
        }
    }
    let mut bench = on_switch();
    bench.call("MAH(X, H1)");
    bench.run(100);
    let speed = bench.axis("X").command[1];
    bench.call("MAS(X, S1, Home, Yes, 100, 0, No, 100, 2)");
    assert_eq!(bench.bits("S1"), "EN DN IP");
    bench.until("S1", Flag::Pc);
    assert_eq!(
        (bench.now() as f64 - 100.0, bench.axis("X").command[1]),
        (speed * 10.0, 0.0)
    );
}

#[test]
fn a_torque_sequence_ends_at_the_mechanical_stop() {
    #[rustfmt::skip]
    let cases = [
        // sequence,        direction,                 end, machine position of it
        ("torque",          "bidirectional-forward",   7.0,  50.0),
        ("torque",          "bidirectional-reverse",   7.0,  -40.0),
        ("torque",          "unidirectional-forward",  17.0, 60.0),
        ("torque",          "unidirectional-reverse",  -3.0, -50.0),
        // From the stop to the next marker: 53, and -47.
        ("torque-marker",   "bidirectional-forward",   7.0,  43.0),
        ("torque-marker",   "bidirectional-reverse",   7.0,  -37.0),
    ];
    for (sequence, direction, end, machine) in cases {
        let offset = if direction.ends_with("reverse") { 10 } else { -10 };
        for period in [0.5, 4.0] {
            let mut bench = machine_at(
                period,
                &format!(
                    "travel = {{ min = -50, max = 60 }}\nstart = {{ position = 5, homed = false }}\n\
                     home = {{ sequence = \"{sequence}\", direction = \"{direction}\", speed = 50, return_speed = 20, \
                     position = 7, offset = {offset}, marker = {{ at = 3, every = 10 }} }}\n"
                ),
            );
            assert_eq!(bench.call("MAH(X, H1)"), OK);
            bench.until("H1", Flag::Pc);
            let shown = bench.axis("X");
            let found = (shown.actual[0], shown.actual[0] - shown.redefined);
            let near = |is: f64, expected: f64| (is - expected).abs() < 1e-6;
            assert!(
                near(found.0, end) && near(found.1, machine),
                "{sequence}, {direction} at {period} ms: {found:?}"
            );
            assert_eq!((event(&bench), has(&bench, HOMED)), (CAME, true));
            bench.run(100);
            assert_eq!(bench.axis("X").fault, 0);
        }
    }
}

#[test]
fn passive_homing_waits_for_others_to_come_by() {
    // The machine position of the event: the edge at 0, the markers at -7, 3, 13.
    for (sequence, event_at) in [("switch", 0.0), ("marker", -7.0), ("switch-marker", 3.0)] {
        let mut bench = waiting(sequence);
        assert_eq!(bench.call("MAH(X, H1)"), OK);
        bench.run(50);
        assert_eq!(
            (bench.bits("H1").as_str(), event(&bench)),
            ("EN IP", ARMED),
            "{sequence}"
        );
        bench.call(&format!("MCLM(XY, M1, 1, [40.1, 0], {ALONG})"));
        bench.until("H1", Flag::Pc);
        assert_eq!(
            (bench.bits("H1").as_str(), event(&bench)),
            ("EN DN PC", CAME),
            "{sequence}"
        );
        let speed = bench.axis("X").command[1];
        assert!(speed > 50.0, "{sequence}: the move goes on at {speed}");
        bench.until_rest();
        assert_eq!(bench.bits("M1"), "EN DN PC");
        let end = 100.0 + (29.6 - event_at);
        assert!(
            (bench.position("X") - end).abs() < 1e-9,
            "{sequence}: {} instead of {end}",
            bench.position("X")
        );
    }
    // Immediate, on a moving axis; and a newer one takes over.
    let mut bench = waiting("immediate");
    bench.call(&format!("MAM(X, M1, 1, 100, {RATES})"));
    bench.run(500);
    bench.call("MAH(X, H1)");
    bench.tick();
    assert_eq!((bench.bits("H1").as_str(), bench.position("X")), ("EN DN PC", 100.0));
    let mut bench = waiting("switch");
    bench.call("MAH(X, H1)");
    bench.run(10);
    bench.call("MAH(X, H2)");
    assert_eq!(
        (bench.bits("H1").as_str(), bench.bits("H2").as_str()),
        ("EN DN", "EN IP")
    );
    bench.call(&format!("MAM(X, M1, 1, 100, {RATES})"));
    bench.until_rest();
    assert_eq!(
        (bench.bits("H1").as_str(), bench.bits("H2").as_str()),
        ("EN DN", "EN DN PC")
    );
}

#[test]
fn homing_that_cannot_be() {
    let speed = "speed = 5";
    #[rustfmt::skip]
    let cases = [
        // why,                                 configuration of X,                                                        before,        error
        ("no switch",                           format!("home = {{ sequence = \"switch\", {speed} }}\n"),                 "",            (84, 0)),
        ("no marker",                           format!("home = {{ sequence = \"switch-marker\", {speed}, switch = {{}} }}\n"), "",      (84, 0)),
        ("no marker to wait for",               "home = { mode = \"passive\", sequence = \"marker\" }\n".into(),          "",            (84, 0)),
        ("no torque level",                     format!("home = {{ sequence = \"torque\", {speed} }}\n"),                 "",            (41, 0)),
        ("the switch has no edge this way",     format!("home = {{ sequence = \"switch\", {speed}, switch = {{ max = 3 }} }}\n"), "",    (41, 0)),
        ("servo off",                           format!("home = {{ sequence = \"marker\", {speed}, marker = {{}} }}\n"),  "MSF(X, B)",   (5, 0)),
        ("servo off, immediate",                String::new(),                                                             "MSF(X, B)",   OK),
        ("servo off, passive",                  "home = { mode = \"passive\", sequence = \"marker\", marker = {} }\n".into(), "MSF(X, B)", OK),
        ("shutdown",                            String::new(),                                                             "MASD(X, B)",  (7, 0)),
        ("no deceleration",                     format!("max_deceleration = 0\nhome = {{ sequence = \"marker\", {speed}, marker = {{}} }}\n"), "", (54, 0)),
        ("no deceleration, immediate",          "max_deceleration = 0\n".into(),                                           "",            OK),
        ("a position being redefined",          String::new(),                                                             "MRP(X, B, 0, 0, 5)", (85, 0)),
    ];
    for (why, keys, before, expected) in &cases {
        let mut bench = machine(keys);
        if !before.is_empty() {
            assert_eq!(bench.call(before), OK, "{why}");
            if !before.starts_with("MRP") {
                bench.run(5);
            }
        }
        assert_eq!(bench.call("MAH(X, H1)"), *expected, "{why}");
    }
    for quantity in [Quantity::HomePosition, Quantity::HomeOffset] {
        // Positions of the axis are at most 2^32 updates at Maximum Speed from 0, 4.3e9 units.
        for (far, expected) in [(4e9, OK), (-5e9, (41, 0)), (1e300, (41, 0))] {
            let mut bench = on_switch();
            bench.set_attribute(Object::Axis, "X", quantity, far);
            assert_eq!(bench.call("MAH(X, H1)"), expected, "{quantity:?} {far}");
        }
    }
    let mut bench = on_switch();
    bench.call(&format!("MAM(X, M1, 1, 500, {RATES})"));
    bench.run(200);
    bench.call("MAS(X, S1, All, No, 100, 0, No, 100, 2)");
    assert_eq!(bench.call("MAH(X, H1)"), (78, 0), "a stop of everything");
}

#[test]
fn a_switch_that_lies_behind_is_not_found() {
    let keys =
        "start = { position = 80 }\nhome = { sequence = \"switch\", speed = 50, switch = { min = 0, max = 60 } }\n";
    let mut bench = machine(keys);
    bench.call("MAH(X, H1)");
    bench.run(5000);
    assert_eq!((bench.bits("H1").as_str(), event(&bench)), ("EN IP", ARMED));
    assert_eq!(bench.axis("X").command[1], 50.0);
}

#[test]
fn positions_are_redefined_and_nothing_moves() {
    #[rustfmt::skip]
    let cases = [
        // why,                axis,              operands of MRP,  error,   position at rest from 0.1
        ("absolute, actual",   "",                "0, 0, 33.3",     OK,      33.3),
        ("absolute, command",  "",                "0, 1, -33.3",    OK,      -33.3),
        ("relative, actual",   "",                "1, 0, 0.2",      OK,      0.1 + 0.2),
        ("relative, command",  "",                "1, 1, -0.1",     OK,      0.0),
        ("within a turn",      "unwind = 360\n",  "0, 0, 359.9",    OK,      359.9),
        ("a turn and more",    "unwind = 360\n",  "0, 0, 360",      (13, 4), 0.1),
        ("below a turn",       "unwind = 360\n",  "0, 1, -0.1",     (13, 4), 0.1),
        ("back over the turn", "unwind = 360\n",  "1, 0, -0.1",     OK,      0.0),
        ("no such type",       "",                "2, 0, 5",        (13, 2), 0.1),
        ("no such select",     "",                "0, 2, 5",        (13, 3), 0.1),
    ];
    for (why, axis, operands, error, position) in cases {
        let mut bench = machine(&format!("{axis}start = {{ position = 0.1 }}\n"));
        assert_eq!(bench.call(&format!("MRP(X, R1, {operands})")), error, "{why}");
        assert_eq!(bench.bits("R1"), if error == OK { "EN" } else { "EN ER" }, "{why}");
        bench.tick();
        assert_eq!(bench.bits("R1"), if error == OK { "EN DN" } else { "EN ER" }, "{why}");
        let shown = bench.axis("X");
        assert_eq!(
            (shown.command, shown.actual),
            ([position, 0.0, 0.0], [position, 0.0, 0.0]),
            "{why}"
        );
        assert!(has(&bench, HOMED), "{why}: AxisHomedStatus stays");
    }
    let mut bench = machine("");
    bench.call("MRP(X, R1, 0, 0, 5)");
    assert_eq!(bench.call("MRP(X, R2, 0, 0, 6)"), (85, 0), "the first one is not done");
    bench.tick();
    assert_eq!(bench.call("MRP(X, R2, 0, 0, 6)"), OK);
    bench.tick();
    bench.call("MSF(X, B)");
    bench.run(3);
    assert_eq!(bench.call("MRP(X, R1, 0, 0, 7)"), OK, "the servo may be off");
    bench.call("MASD(X, B2)");
    bench.run(3);
    assert_eq!(bench.call("MRP(X, R3, 0, 0, 7)"), (7, 0));
}

#[test]
fn a_redefined_position_disturbs_no_motion() {
    let run = |redefine: &str| {
        let mut bench =
            machine("drive = { position_bandwidth_hz = 5, velocity_feedforward = 0, position_error_tolerance = 0 }\n");
        bench.call(&format!("MCLM(XY, M1, 0, [100, 50], {ALONG})"));
        bench.call(&format!("MAM(X, M2, 1, 30, {RATES})"));
        let mut seen = Vec::new();
        for tick in 0..1500 {
            if tick == 700 && !redefine.is_empty() {
                assert_eq!(bench.call(redefine), OK);
            }
            let axis = bench.axis("X");
            seen.push((
                axis.command[0],
                axis.actual[0],
                axis.command[1],
                axis.actual[1],
                axis.position_error,
            ));
            bench.tick();
        }
        bench.until_rest();
        assert_eq!(
            (bench.bits("M1").as_str(), bench.bits("M2").as_str()),
            ("EN DN PC", "EN DN PC")
        );
        (seen, bench.position("X"))
    };
    let (plain, end) = run("");
    assert_eq!(end, 130.0);
    for (redefine, index, to) in [
        ("MRP(X, R1, 0, 0, 500)", 1, Some(500.0)),
        ("MRP(X, R1, 0, 1, 500)", 0, Some(500.0)),
        ("MRP(X, R1, 1, 0, -7)", 0, None),
    ] {
        let (shifted, shifted_end) = run(redefine);
        let before = [plain[700].0, plain[700].1];
        let offset = to.map_or(-7.0, |to| to - before[index]);
        if let Some(to) = to {
            assert_eq!([shifted[700].0, shifted[700].1][index], to, "{redefine}");
        }
        for (tick, (a, b)) in plain.iter().zip(&shifted).enumerate() {
            let expected = if tick < 700 { 0.0 } else { offset };
            let apart = [
                b.0 - a.0 - expected,
                b.1 - a.1 - expected,
                b.2 - a.2,
                b.3 - a.3,
                b.4 - a.4,
            ];
            assert!(
                apart.iter().all(|apart| apart.abs() < 1e-9),
                "{redefine}: {apart:?} at {tick}"
            );
        }
        assert!(
            (shifted_end - end - offset).abs() < 1e-9,
            "{redefine}: the end is the same place"
        );
    }
}

#[test]
fn moves_queued_after_a_redefinition_have_the_new_positions() {
    let mut bench = machine("");
    bench.call(&format!("MCLM(XY, M1, 0, [100, 50], {ALONG})"));
    bench.run(400);
    bench.call("MRP(X, R1, 1, 0, 1000)");
    bench.call("MRP(Y, R2, 1, 0, -500)");
    let queued = "MCCM(XY, M2, 0, [1100, -350], 1, [1100, -400], 1, 100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2, 1)";
    assert_eq!(bench.call(queued), OK);
    bench.until("M1", Flag::Pc);
    let middle = ["X", "Y"].map(|axis| bench.position(axis));
    assert!(
        (middle[0] - 1100.0).hypot(middle[1] + 450.0) < 0.01,
        "the first one ends where it would have: {middle:?}"
    );
    bench.run(300);
    let now = ["X", "Y"].map(|axis| bench.position(axis));
    assert!(
        ((now[0] - 1100.0).hypot(now[1] + 400.0) - 50.0).abs() < 1e-9,
        "on the circle: {now:?}"
    );
    bench.until_rest();
    let end = ["X", "Y"].map(|axis| bench.position(axis));
    assert!((end[0] - 1100.0).hypot(end[1] + 350.0) < 1e-9, "{end:?}");
}

#[test]
fn a_slave_follows_a_master_that_is_homed_and_not_its_positions() {
    let mut bench = machine(
        "start = { position = -40 }\nhome = { sequence = \"switch\", position = 700, speed = 50, return_speed = 20, switch = {} }\n",
    );
    assert_eq!(bench.call("MAG(Y, X, G1, 0, 2, 1, 1, 1, 0, 1, 100, 0)"), OK);
    bench.run(5);
    assert_eq!(bench.call("MAH(X, H1)"), OK);
    bench.until("H1", Flag::Pc);
    bench.run(5);
    assert_eq!(bench.position("X"), 700.0);
    assert!(
        (bench.position("Y") - 80.0).abs() < 1e-9,
        "twice the 40 units to the switch: {}",
        bench.position("Y")
    );
    assert_eq!(bench.bits("G1"), "EN DN IP");
    // A slave that is homed leaves its master.
    bench.call("MRP(X, R1, 0, 0, 0)");
    bench.tick();
    assert_eq!(bench.call("MAH(Y, H2)"), OK);
    assert_eq!(bench.bits("G1"), "EN DN");
    bench.until("H2", Flag::Pc);
    assert_eq!(bench.position("Y"), 0.0);
}

#[test]
fn an_axis_of_a_transform_keeps_its_scale() {
    let mut bench = Bench::new();
    let none = "[0, 0, 0]";
    assert_eq!(bench.call(&format!("MCT(CS2, CS3, T, {none}, {none})")), OK);
    bench.run(5);
    for axis in ["X", "A"] {
        assert_eq!(bench.call(&format!("MRP({axis}, R1, 0, 0, 5)")), (63, 0), "{axis}");
        assert_eq!(bench.call(&format!("MAH({axis}, H1)")), (63, 0), "{axis}");
    }
}

#[test]
fn the_sensor_stays_where_it_is_when_positions_are_redefined() {
    let mut bench = on_switch();
    bench.call("MRP(X, R1, 0, 0, 1000)");
    bench.tick();
    for round in 0..3 {
        bench.call(&format!("MAH(X, H{round})"));
        bench.until(&format!("H{round}"), Flag::Pc);
        assert_eq!(bench.position("X"), 0.0);
        bench.call(&format!("MAM(X, M{round}, 0, -30, {RATES})"));
        bench.until_rest();
        bench.call(&format!("MRP(X, P{round}, 1, 0, {round}.7)"));
        bench.tick();
    }
}

#[test]
fn the_sensor_stands_where_it_is_after_a_restart() {
    let keys = "drive = { encoder_resolution = 10 }\nhome = { sequence = \"switch\", direction = \"unidirectional-forward\", \
                speed = 50, acceleration = 1000, deceleration = 1000, switch = { min = 5.0 } }\n";
    // The switch is at 5 as positions were at the start: after each redefinition somewhere else.
    for shifts in [vec![], vec![100.03], vec![100.03, -7.0]] {
        let total: f64 = shifts.iter().sum();
        let mut bench = machine(keys);
        for by in &shifts {
            assert_eq!(bench.call(&format!("MRP(X, P, Relative, Command, {by})")), OK);
            bench.run(5);
        }
        let mut bench = bench.restarted();
        assert_eq!(bench.axis("X").average_velocity, 0.0);
        bench.tick();
        assert_eq!(bench.axis("X").average_velocity, 0.0, "nothing has moved");
        assert!((bench.position("X") - total).abs() < 1e-9, "{shifts:?}");
        let actual = bench.axis("X").actual[0];
        assert!((actual - total).abs() < 1e-9, "a count is where it was: {actual}");
        assert_eq!(bench.call("MSO(X, O)"), OK);
        bench.run(3);
        assert_eq!(bench.call("MAH(X, H)"), OK);
        bench.until("H", Flag::Pc);
        // 50 units/s at 1,000 units/s² behind the switch, which has become 0.
        let stood = bench.position("X");
        assert!((stood - 1.25).abs() < 0.11, "{shifts:?}: {stood}");
        let travelled = bench.axis("X").redefined + 5.0;
        assert!(
            travelled.abs() < 0.11,
            "{shifts:?}: the machine position of the switch is 5: {travelled}"
        );
    }
}

#[test]
fn a_stop_of_everything_ends_homing_that_waits() {
    for stop in ["MGS(Motion, S1, 1)", "MAS(X, S1, All)"] {
        let mut bench = machine("home = { mode = \"passive\", sequence = \"marker\", marker = { at = 500 } }\n");
        assert_eq!(bench.call("MAH(X, H1)"), OK);
        bench.run(5);
        assert_eq!(bench.bits("H1"), "EN IP", "{stop}");
        assert_eq!(bench.call(stop), OK);
        bench.run(2);
        assert!(!bench.control("H1").has(Flag::Ip), "{stop}");
        assert_eq!(
            bench.axis("X").motion_status & motion_status::HOMING_STATUS,
            0,
            "{stop}"
        );
    }
}

#[test]
fn homing_attributes_count_from_the_next_homing() {
    let home = "home = { sequence = \"switch\", position = 7, offset = 2, speed = 50, return_speed = 20, switch = { min = 0, max = 60 } }\n";
    for (axis, start, position, shown) in [("", -53, 1000.0, 1000.0), ("unwind = 360\n", 307, -10.0, 350.0)] {
        let mut bench = machine(&format!(
            "{axis}start = {{ position = {start}, homed = false }}\n{home}"
        ));
        let set = |bench: &mut Bench, quantity, value| bench.set_attribute(Object::Axis, "X", quantity, value);
        let home_again = |bench: &mut Bench, meanwhile: Option<f64>| {
            let (mut fastest, mut moved) = (0.0_f64, 0.0);
            assert_eq!(bench.call("MAH(X, H1)"), OK);
            if let Some(position) = meanwhile {
                bench.run(10);
                set(bench, Quantity::HomePosition, position);
                set(bench, Quantity::HomeOffset, 5.0);
                set(bench, Quantity::HomeSpeed, 30.0);
                set(bench, Quantity::HomeReturnSpeed, 10.0);
            }
            while !bench.control("H1").has(Flag::Pc) {
                let [_, speed, _] = bench.axis("X").command;
                fastest = fastest.max(speed.abs());
                moved += speed * 1e-3;
                bench.tick();
            }
            (bench.position("X"), fastest, moved)
        };
        let (end, fastest, _) = home_again(&mut bench, Some(position));
        assert_eq!((end, fastest), (7.0, 50.0), "{axis}");
        // It stands 2 units behind the edge of the switch, and 5 afterwards.
        bench.execute(&format!("MAM(X, M1, 1, -60, {RATES})"));
        bench.until("M1", Flag::Pc);
        let (end, fastest, moved) = home_again(&mut bench, None);
        assert_eq!((end, fastest), (shown, 30.0), "{axis}");
        assert!((moved - 63.0).abs() < 0.1, "{axis}: {moved}");
    }
}

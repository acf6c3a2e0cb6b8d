//! MAOC and MDOC: the bits at each position of the axis, the arming and the end of an output cam, and refusals
//! (spec/axis-and-data-types.md §5).

mod ends;

use arcline_instruction_set::Flag;
use arcline_tests::bench::{Bench, OK};

/// The operands from Speed on: a trapezoid at 100 units/s.
const TRAPEZOID: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
/// The operands from Speed on: an S-curve at 100 units/s.
const S_CURVE: &str = "100, 0, 1000, 0, 1000, 0, 1, 100, 100, 2";

/// `X` without a drive, `TURN` rotary, `P` a servo that lags, each with 4 targets; `NONE` has no target.
fn machine(period_ms: f64) -> Bench {
    let mut text = format!("[motion_group]\nname = \"Motion\"\ncoarse_update_period_ms = {period_ms:?}\n");
    let axes = [
        ("X", "virtual", "output_cam_execution_targets = 4\n"),
        ("TURN", "virtual", "output_cam_execution_targets = 4\nunwind = 360.0\n"),
        (
            "P",
            "servo",
            "output_cam_execution_targets = 4\ndrive = { velocity_feedforward = 0.0 }\n",
        ),
        ("NONE", "virtual", ""),
    ];
    for (name, kind, more) in axes {
        text += &format!(
            "[[axis]]\nname = \"{name}\"\ntype = \"{kind}\"\nunits = \"mm\"\nmax_speed = 1000.0\n\
             max_acceleration = 5000.0\nmax_deceleration = 5000.0\n{more}"
        );
    }
    for (name, kind) in [
        ("Out", "DINT[2]"),
        ("In", "DINT"),
        ("Cam", "OUTPUT_CAM[6]"),
        ("Next", "OUTPUT_CAM"),
        ("Third", "OUTPUT_CAM"),
        ("Comp", "OUTPUT_COMPENSATION[4]"),
    ] {
        text += &format!("[[tag]]\nname = \"{name}\"\ntype = \"{kind}\"\n");
    }
    Bench::with(&text)
}

/// Writes an element: bit, latch type, unlatch type, left, right, duration, enable type, enable bit.
fn element(bench: &mut Bench, tag: &str, values: [f64; 8]) {
    let members = [
        "OutputBit",
        "LatchType",
        "UnlatchType",
        "Left",
        "Right",
        "Duration",
        "EnableType",
        "EnableBit",
    ];
    for (member, value) in members.into_iter().zip(values) {
        bench.write(&format!("{tag}.{member}"), value);
    }
}

/// Writes the compensation of a bit: offset, latch delay, unlatch delay, mode, cycle time, duty cycle.
fn compensate(bench: &mut Bench, bit: usize, values: [f64; 6]) {
    let members = ["Offset", "LatchDelay", "UnlatchDelay", "Mode", "CycleTime", "DutyCycle"];
    for (member, value) in members.into_iter().zip(values) {
        bench.write(&format!("Comp[{bit}].{member}"), value);
    }
}

/// A bit that is on from one position to another.
const fn window(bit: u8, left: f64, right: f64) -> [f64; 8] {
    [bit as f64, 1.0, 1.0, left, right, 0.0, 0.0, 0.0]
}

fn go(bench: &mut Bench, axis: &str, to: f64, dynamics: &str) {
    assert_eq!(bench.call(&format!("MAM({axis}, M, 0, {to}, {dynamics})")), OK);
    bench.until("M", Flag::Pc);
}

/// OutputCamStatus, PendingStatus, LockStatus and TransitionStatus.
fn status(bench: &Bench, axis: &str) -> [u32; 4] {
    bench.axis(axis).output_cams
}

/// A cam of the whole range: MAOC's operands from Output on, with the first 100 units.
const WHOLE: &str = "Out[0], In, Cam, 0, 100, None";

#[test]
fn bits_are_set_where_the_axis_is() {
    for (period, dynamics) in [(0.5, S_CURVE), (1.0, TRAPEZOID), (4.0, S_CURVE), (4.0, TRAPEZOID)] {
        let mut bench = machine(period);
        element(&mut bench, "Cam[0]", window(0, 10.0, 20.0));
        element(&mut bench, "Cam[1]", window(5, 15.0, 40.0));
        element(&mut bench, "Cam[2]", window(5, 35.0, 60.0));
        element(&mut bench, "Cam[3]", window(31, -50.0, 30.0));
        bench.write("Out[0]", f64::from(1 << 3));
        assert_eq!(
            bench.call(&format!("MAOC(X, 2, C, {WHOLE}, Persistent, Immediate, 0, 0, Command)")),
            OK
        );
        assert_eq!(status(&bench, "X"), [4, 0, 4, 0]);
        bench.tick();
        assert_eq!(bench.bits("C"), "EN DN IP");
        for to in [90.0, 12.5, 130.0, -20.0, 10.0, 20.0] {
            assert_eq!(bench.call(&format!("MAM(X, M, 0, {to}, {dynamics})")), OK);
            while !bench.control("M").has(Flag::Pc) {
                let at = bench.position("X");
                bench.tick();
                let inside = |left: f64, right: f64| (left..right).contains(&at);
                // Bit 3 belongs to no cam; bit 31 begins with the cam.
                let expected = u32::from(inside(10.0, 20.0))
                    | u32::from(inside(15.0, 60.0)) << 5
                    | 1 << 3
                    | u32::from(inside(0.0, 30.0)) << 31;
                assert_eq!(bench.read("Out[0]") as i32 as u32, expected, "{period} ms at {at}");
            }
        }
        let inside = (0.0..=100.0).contains(&bench.position("X"));
        assert_eq!(status(&bench, "X"), [4, 0, if inside { 4 } else { 0 }, 0]);
    }
}

/// Why, the values written to the tags, and the times at which the bits change.
type Edges = (&'static str, Box<dyn Fn(&mut Bench)>, Vec<(f64, i64)>);

#[test]
fn edges_lie_between_ticks_and_show_at_the_next() {
    // Duration counts from the edge at 10.05 units, 100.5 ms, at any update period.
    let duration = |bench: &mut Bench| {
        element(bench, "Cam[0]", [1.0, 1.0, 2.0, 10.05, 90.0, 0.0257, 0.0, 0.0]);
    };
    #[rustfmt::skip]
    let cases: Vec<Edges> = vec![
        ("a duration", Box::new(duration), vec![(100.5, 2), (126.2, 0)]),
        ("an offset", Box::new(|bench| {
            element(bench, "Cam[0]", window(0, 10.0, 20.0));
            compensate(bench, 0, [5.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }), vec![(150.0, 1), (250.0, 0)]),
        ("delays: 3 ms and 7.5 ms earlier", Box::new(|bench| {
            element(bench, "Cam[0]", window(0, 10.0, 20.0));
            compensate(bench, 0, [0.0, 0.003, 0.0075, 0.0, 0.0, 0.0]);
        }), vec![(97.0, 1), (192.5, 0)]),
        ("a compensated duration", Box::new(move |bench| {
            duration(bench);
            compensate(bench, 1, [0.0, 0.01, 0.005, 0.0, 0.0, 0.0]);
        }), vec![(90.5, 2), (121.2, 0)]),
        ("delays that leave nothing", Box::new(|bench| {
            element(bench, "Cam[0]", window(0, 10.0, 11.0));
            compensate(bench, 0, [0.0, 0.0, 0.02, 0.0, 0.0, 0.0]);
        }), vec![]),
        ("inverted", Box::new(|bench| {
            element(bench, "Cam[0]", window(2, 10.0, 20.0));
            compensate(bench, 2, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        }), vec![(0.0, 4), (100.0, 0), (200.0, 4)]),
        ("pulses of 40 of 100 ms", Box::new(|bench| {
            element(bench, "Cam[0]", window(0, 10.0, 35.0));
            compensate(bench, 0, [0.0, 0.0, 0.0, 2.0, 0.1, 40.0]);
        }), vec![(100.0, 1), (140.0, 0), (200.0, 1), (240.0, 0), (300.0, 1), (340.0, 0)]),
        ("one that sets and one that clears", Box::new(|bench| {
            element(bench, "Cam[0]", [0.0, 1.0, 0.0, 10.0, 12.0, 0.0, 0.0, 0.0]);
            element(bench, "Cam[1]", [0.0, 0.0, 1.0, 20.0, 60.0, 0.0, 0.0, 0.0]);
        }), vec![(100.0, 1), (600.0, 0)]),
        ("beyond the end of the cam", Box::new(|bench| {
            element(bench, "Cam[0]", window(0, 90.0, 200.0));
            element(bench, "Cam[1]", [1.0, 1.0, 2.0, 99.0, 100.0, 0.05, 0.0, 0.0]);
        }), vec![(900.0, 1), (990.0, 3), (1000.0, 2), (1040.0, 0)]),
    ];
    for (why, prepare, expected) in &cases {
        for period in [0.25, 1.0, 4.0] {
            let found = changes(period, prepare);
            let ticks: Vec<(f64, i64)> = expected
                .iter()
                .map(|(time, word)| {
                    // The axis has taken 50 ps to reach its speed.
                    let ticks = if *time == 0.0 {
                        0.0
                    } else {
                        (time / period + 1e-6).ceil()
                    };
                    (ticks * period, *word)
                })
                .collect();
            assert_eq!(found, ticks, "{why} at {period} ms");
        }
    }
}

/// When bits of a cam change on the way of an axis from 0 to 150, at 0.1 units/ms from the start: milliseconds and the word.
fn changes(period: f64, prepare: impl Fn(&mut Bench)) -> Vec<(f64, i64)> {
    let mut bench = machine(period);
    prepare(&mut bench);
    let call = "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, Comp, Once, Immediate, 0, 0, Command)";
    assert_eq!(bench.call(call), OK);
    assert_eq!(
        bench.call("MAM(X, M, 0, 300, 100, 0, 1e9, 0, 1e9, 0, 0, 100, 100, 2)"),
        OK
    );
    let mut word = 0;
    let mut list = Vec::new();
    while bench.position("X") < 150.0 {
        let time = bench.now() as f64 * period;
        bench.tick();
        let now = bench.read("Out[0]") as i64;
        if std::mem::replace(&mut word, now) != now {
            list.push((time, now));
        }
    }
    assert_eq!(bench.bits("C"), "EN DN PC");
    assert_eq!(status(&bench, "X"), [0; 4]);
    list
}

/// Why, latch type, unlatch type and enable type, and positions with the input and the bit there.
type Enabling<'a> = (&'a str, [f64; 3], &'a [(f64, u32, bool)]);

#[test]
fn an_enable_bit_counts_with_or_without_the_position() {
    const ENABLE: f64 = 2.0;
    const BOTH: f64 = 3.0;
    // Latch type, unlatch type, enable type; then positions and inputs in turn, and the bit behind each.
    #[rustfmt::skip]
    let cases: &[Enabling<'_>] = &[
        ("enabled alone", [ENABLE, 3.0, 0.0],
            &[(0.0, 0, false), (0.0, 4, true), (50.0, 4, true), (50.0, 3, false), (50.0, 7, true)]),
        ("by an inverted input", [ENABLE, 3.0, 1.0],
            &[(0.0, 0, true), (0.0, 4, false), (50.0, 0, true)]),
        ("in the range and enabled", [BOTH, 4.0, 0.0],
            &[(0.0, 4, false), (15.0, 4, true), (15.0, 0, false), (15.0, 4, true), (30.0, 4, false), (15.0, 0, false)]),
        ("enabled in the range", [BOTH, 1.0, 0.0],
            &[(15.0, 0, false), (15.0, 4, true), (15.0, 0, true), (30.0, 0, false)]),
        ("latched by position until it is not enabled", [1.0, 3.0, 0.0],
            &[(0.0, 4, false), (15.0, 4, true), (90.0, 4, true), (90.0, 0, false)]),
        ("latched for good", [BOTH, 0.0, 0.0],
            &[(15.0, 0, false), (15.0, 4, true), (90.0, 0, true)]),
    ];
    for (why, [latch, unlatch, enable], steps) in cases {
        let mut bench = machine(1.0);
        element(
            &mut bench,
            "Cam[0]",
            [0.0, *latch, *unlatch, 10.0, 20.0, 0.0, *enable, 2.0],
        );
        assert_eq!(
            bench.call(&format!("MAOC(X, 0, C, {WHOLE}, Persistent, Immediate, 0, 0, Command)")),
            OK
        );
        for (place, (position, input, on)) in steps.iter().enumerate() {
            bench.write("In", f64::from(*input));
            go(&mut bench, "X", *position, TRAPEZOID);
            bench.tick();
            assert_eq!(bench.read("Out[0]") != 0.0, *on, "{why}: step {place}");
        }
    }
    // Enabled by a bit of the output, its own or another one's: a tick later.
    let mut bench = machine(1.0);
    element(&mut bench, "Cam[0]", window(4, 10.0, 20.0));
    element(&mut bench, "Cam[1]", [0.0, ENABLE, 3.0, 0.0, 0.0, 0.0, 2.0, 4.0]);
    element(&mut bench, "Cam[2]", [1.0, ENABLE, 3.0, 0.0, 0.0, 0.0, 3.0, 9.0]);
    assert_eq!(
        bench.call(&format!("MAOC(X, 0, C, {WHOLE}, Persistent, Immediate, 0, 0, Command)")),
        OK
    );
    let after = |bench: &mut Bench, to: f64| {
        go(bench, "X", to, TRAPEZOID);
        bench.run(2);
        bench.read("Out[0]") as u32
    };
    assert_eq!(after(&mut bench, 5.0), 2);
    assert_eq!(after(&mut bench, 15.0), 0b1_0011);
    assert_eq!(after(&mut bench, 25.0), 2);
    // A client's write of bits that belong to no cam stays and shows.
    bench.write("Out[0]", f64::from(1 << 9 | 1 << 20));
    assert_eq!(after(&mut bench, 15.0), 1 << 20 | 1 << 9 | 0b1_0001);
}

/// A position, and the state there: the word, the status words, and the bits of the instruction.
type Place<'a> = (f64, u32, [u32; 4], &'a str);
/// Why, the operands from Execution Mode to Cam Arm Position, and the places on the way.
type Way<'a> = (&'a str, &'a str, &'a [Place<'a>]);

#[test]
fn modes_and_schedules() {
    // The word after each position, with a window of 10 to 20 of a cam from 0 to 100.
    #[rustfmt::skip]
    let cases: &[Way<'_>] = &[
        ("once", "Once, Immediate, 0, 0", &[
            (15.0, 1, [1, 0, 1, 0], "EN DN IP"), (100.0, 0, [1, 0, 1, 0], "EN DN IP"),
            (101.0, 0, [0; 4], "EN DN PC"), (15.0, 0, [0; 4], "EN DN PC")]),
        ("persistent", "Persistent, Immediate, 0, 0", &[
            (15.0, 1, [1, 0, 1, 0], "EN DN IP"), (130.0, 0, [1, 0, 0, 0], "EN DN IP"),
            (15.0, 1, [1, 0, 1, 0], "EN DN IP"), (-15.0, 0, [1, 0, 0, 0], "EN DN IP")]),
        ("continuous", "Continuous, Immediate, 0, 0", &[
            (15.0, 1, [1, 0, 1, 0], "EN DN IP"), (115.0, 1, [1, 0, 1, 0], "EN DN IP"),
            (125.0, 0, [1, 0, 1, 0], "EN DN IP"), (715.0, 1, [1, 0, 1, 0], "EN DN IP"),
            (-585.0, 1, [1, 0, 1, 0], "EN DN IP"), (-580.0, 0, [1, 0, 1, 0], "EN DN IP")]),
        ("entered in the middle", "Persistent, Immediate, 0, 12", &[
            (0.0, 1, [1, 0, 1, 0], "EN DN IP"), (8.0, 0, [1, 0, 1, 0], "EN DN IP")]),
        ("armed forwards", "Persistent, ForwardOnly, 30, 5", &[
            (29.0, 0, [1, 0, 0, 0], "EN DN IP"), (36.0, 1, [1, 0, 1, 0], "EN DN IP"),
            (45.0, 0, [1, 0, 1, 0], "EN DN IP"), (20.0, 0, [1, 0, 0, 0], "EN DN IP"),
            (37.0, 1, [1, 0, 1, 0], "EN DN IP")]),
        ("armed in reverse", "Persistent, ReverseOnly, 30, 15", &[
            (40.0, 0, [1, 0, 0, 0], "EN DN IP"), (29.0, 1, [1, 0, 1, 0], "EN DN IP")]),
        ("armed both ways", "Persistent, Bidirectional, 30, 15", &[
            (31.0, 1, [1, 0, 1, 0], "EN DN IP")]),
    ];
    for (why, operands, steps) in cases {
        for period in [0.25, 4.0] {
            let mut bench = machine(period);
            element(&mut bench, "Cam[0]", window(0, 10.0, 20.0));
            assert_eq!(
                bench.call(&format!("MAOC(X, 0, C, {WHOLE}, {operands}, Command)")),
                OK,
                "{why}"
            );
            for (to, word, shown, bits) in *steps {
                go(&mut bench, "X", *to, TRAPEZOID);
                bench.tick();
                let found = (bench.read("Out[0]") as u32, status(&bench, "X"), bench.bits("C"));
                assert_eq!(found, (*word, *shown, (*bits).to_owned()), "{why} at {to}");
            }
        }
    }
}

#[test]
fn a_pending_cam_takes_over_at_the_end() {
    for (to, delay, transition) in [(1.0, 0.0, false), (-1.0, 0.0, false), (1.0, 0.1, true)] {
        let mut bench = machine(1.0);
        element(&mut bench, "Cam[0]", window(0, 10.0, 20.0));
        element(&mut bench, "Next", window(1, 0.0, 5.0));
        compensate(&mut bench, 1, [0.0, delay, delay, 0.0, 0.0, 0.0]);
        let first = "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, None, Continuous, Immediate, 0, 50, Command)";
        assert_eq!(bench.call(first), OK);
        // Output, Input, Axis Arm Position and Position Reference of a pending one mean nothing.
        let next = "MAOC(X, 0, D, Out[1], None, Next, 0, 40, Comp, Once, Pending, 0, -7, Actual)";
        assert_eq!(bench.call(next), OK);
        assert_eq!(status(&bench, "X"), [1, 1, 1, 0]);
        assert_eq!(
            bench.call(&format!(
                "MAM(X, M, 1, {}, 100, 0, 1e9, 0, 1e9, 0, 0, 100, 100, 2)",
                to * 200.0
            )),
            OK
        );
        let mut seen = Vec::new();
        let mut transitions = 0;
        while !bench.control("M").has(Flag::Pc) {
            let at = bench.position("X");
            transitions += status(&bench, "X")[3];
            bench.tick();
            let word = bench.read("Out[0]") as u32;
            if word & 2 != 0 {
                seen.push(at);
            }
        }
        // The output from the end at 50, or the start at -50, with a lead of 10 units, 5 units long.
        let (from, until) = if to > 0.0 { (50.0, 55.0) } else { (-90.0, -85.0) };
        let lead = 100.0 * delay;
        assert!(
            (seen[0] + lead - if to > 0.0 { from } else { until }).abs() < 0.11,
            "{seen:?}"
        );
        assert!((seen.len() as f64 - 50.0).abs() <= 1.0, "{}", seen.len());
        assert_eq!(transitions > 0, transition);
        assert_eq!(
            (bench.bits("C").as_str(), bench.bits("D").as_str()),
            ("EN DN PC", "EN DN PC")
        );
        assert_eq!((status(&bench, "X"), bench.read("Out[1]")), ([0; 4], 0.0));
    }
    // Another pending one takes its place; without one that is armed it waits for one.
    let mut bench = machine(1.0);
    element(&mut bench, "Cam[0]", window(0, 10.0, 20.0));
    let pending = |tag: &str| format!("MAOC(X, 1, {tag}, {WHOLE}, Once, Pending, 0, 0, Command)");
    assert_eq!(bench.call(&pending("A")), OK);
    bench.tick();
    assert_eq!(bench.call(&pending("B")), OK);
    bench.tick();
    assert_eq!(
        (bench.bits("A"), bench.bits("B")),
        ("EN DN".to_owned(), "EN DN IP".to_owned())
    );
    assert_eq!(status(&bench, "X"), [0, 2, 0, 0]);
    let armed = format!("MAOC(X, 1, C, {WHOLE}, Once, Immediate, 0, 0, Command)");
    assert_eq!(bench.call(&armed), OK);
    go(&mut bench, "X", 115.0, TRAPEZOID);
    bench.tick();
    assert_eq!((status(&bench, "X"), bench.read("Out[0]")), ([2, 0, 2, 0], 1.0));
    // An armed cam takes the place of the other.
    assert_eq!(bench.call(&armed.replace(", C,", ", E,")), OK);
    bench.tick();
    assert_eq!(
        (bench.bits("B"), bench.bits("E")),
        ("EN DN".to_owned(), "EN DN IP".to_owned())
    );
}

#[test]
fn disarming_leaves_the_bits() {
    let mut bench = machine(1.0);
    element(&mut bench, "Cam[0]", window(0, -10.0, 20.0));
    let arm = |target: u8, schedule: &str| {
        format!(
            "MAOC(X, {target}, C{target}{schedule}, Out[0], In, Cam, -50, 100, None, Persistent, {schedule}, 0, 0, Command)"
        )
    };
    for target in [0, 3] {
        assert_eq!(bench.call(&arm(target, "Immediate")), OK);
    }
    assert_eq!(bench.call(&arm(3, "Pending")), OK);
    bench.tick();
    assert_eq!((status(&bench, "X"), bench.read("Out[0]")), ([9, 8, 9, 0], 1.0));
    assert_eq!(bench.call("MDOC(X, 3, D, Specific)"), OK);
    assert_eq!(bench.bits("D"), "EN DN");
    assert_eq!(status(&bench, "X"), [1, 0, 1, 0]);
    assert_eq!(
        ["C0Immediate", "C3Immediate", "C3Pending"].map(|tag| bench.bits(tag)),
        ["EN DN IP", "EN DN", "EN DN"]
    );
    assert_eq!(bench.call("MDOC(X, 99, D, All)"), OK);
    assert_eq!(
        (status(&bench, "X"), bench.bits("C0Immediate").as_str()),
        ([0; 4], "EN DN")
    );
    go(&mut bench, "X", 50.0, TRAPEZOID);
    bench.tick();
    assert_eq!(bench.read("Out[0]"), 1.0, "nobody changes it");
    // So does a shutdown.
    assert_eq!(bench.call(&arm(0, "Immediate")), OK);
    bench.tick();
    bench.call("MASD(X, S)");
    assert_eq!(
        (status(&bench, "X"), bench.bits("C0Immediate").as_str()),
        ([0; 4], "EN DN")
    );
}

#[test]
fn output_cams_follow_the_axis_across_unwinds_and_redefinitions() {
    // A turn after the other.
    let mut bench = machine(1.0);
    element(&mut bench, "Cam[0]", window(0, 350.0, 360.0));
    element(&mut bench, "Cam[1]", window(1, 0.0, 10.0));
    let cam = "MAOC(TURN, 0, C, Out[0], In, Cam, 0, 360, None, Continuous, ForwardOnly, 90, 90, Command)";
    assert_eq!(bench.call(cam), OK);
    assert_eq!(
        bench.call("MAJ(TURN, J, 0, 500, 0, 5000, 0, 5000, 0, 0, 100, 100, 2)"),
        OK
    );
    bench.run(200);
    for _ in 0..5000 {
        let at = bench.position("TURN");
        bench.tick();
        let expected = u32::from(at >= 350.0) | u32::from(at < 10.0) << 1;
        assert_eq!(bench.read("Out[0]") as u32, expected, "at {at}");
    }
    // Positions are redefined; the cam is where it was.
    let mut bench = machine(1.0);
    element(&mut bench, "Cam[0]", window(0, 10.0, 20.0));
    assert_eq!(
        bench.call(&format!("MAOC(X, 0, C, {WHOLE}, Persistent, Immediate, 0, 0, Command)")),
        OK
    );
    bench.call("MRP(X, R, 0, 1, 1000)");
    bench.tick();
    go(&mut bench, "X", 1015.0, TRAPEZOID);
    bench.tick();
    assert_eq!(bench.read("Out[0]"), 1.0);
    // The command is ahead of the servo.
    for (reference, place) in [("Command", 0), ("Actual", 1)] {
        let mut bench = machine(1.0);
        element(&mut bench, "Cam[0]", window(0, 10.0, 20.0));
        let cam = format!("MAOC(P, 0, C, Out[0], In, Cam, 0, 100, None, Persistent, Immediate, 0, 0, {reference})");
        assert_eq!(bench.call(&cam), OK);
        assert_eq!(bench.call(&format!("MAM(P, M, 0, 50, {TRAPEZOID})")), OK);
        while bench.read("Out[0]") == 0.0 {
            bench.tick();
        }
        let axis = bench.axis("P");
        let at = [axis.command[0], axis.actual[0]][place];
        assert!((9.8..10.3).contains(&at), "{reference}: {at}");
        assert!(axis.position_error > 0.2, "{reference}");
    }
}

#[test]
fn invalid_output_cams_are_refused() {
    type Case<'a> = (&'a str, &'a str, (i16, i8));
    #[rustfmt::skip]
    let cases: &[Case<'_>] = &[
        ("a target too many",   "MAOC(X, 4, C, Out[0], In, Cam, 0, 100, None, 0, 0, 0, 0, 0)",       (35, 0)),
        ("a target below 0",    "MAOC(X, -1, C, Out[0], In, Cam, 0, 100, None, 0, 0, 0, 0, 0)",      (35, 0)),
        ("no targets",          "MAOC(NONE, 0, C, Out[0], In, Cam, 0, 100, None, 0, 0, 0, 0, 0)",    (35, 0)),
        ("a range without length", "MAOC(X, 0, C, Out[0], In, Cam, 5, 5, None, 0, 0, 0, 5, 0)",      (13, 7)),
        ("mode",                "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, None, 3, 0, 0, 0, 0)",       (13, 9)),
        ("schedule",            "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, None, 0, 5, 0, 0, 0)",       (13, 10)),
        ("arm position",        "MAOC(TURN, 0, C, Out[0], In, Cam, 0, 100, None, 0, 2, 360, 0, 0)",  (13, 11)),
        ("arm position of none", "MAOC(TURN, 0, C, Out[0], In, Cam, 0, 100, None, 0, 0, 360, 0, 0)", OK),
        ("outside of the cam",  "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, None, 0, 0, 0, 101, 0)",     (13, 12)),
        ("reference",           "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, None, 0, 0, 0, 0, 2)",       (13, 13)),
        ("the first of two",    "MAOC(X, 9, C, Out[0], In, Cam, 9, 1, None, 7, 0, 0, 0, 2)",         (13, 7)),
        ("disarm type",         "MDOC(X, 0, C, 2)",                                                  (13, 3)),
        ("a target to disarm",  "MDOC(X, 4, C, 1)",                                                  (35, 0)),
    ];
    for (why, call, expected) in cases {
        assert_eq!(machine(1.0).call(call), *expected, "{why}");
    }
    let call = "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, Comp, 0, 0, 0, 0, 0)";
    for (tag, expected) in [
        ("Cam[4].LatchType", (36, 4)),
        ("Comp[2].Mode", (37, 2)),
        ("Cam[1].OutputBit", (36, 1)),
    ] {
        let mut bench = machine(1.0);
        bench.write(tag, 77.0);
        assert_eq!(bench.call(call), expected, "{tag}");
        assert_eq!(bench.control("C").segment, i32::from(expected.1), "{tag}");
        assert_eq!(status(&bench, "X"), [0; 4], "{tag}");
    }
    let mut bench = machine(1.0);
    bench.call("MASD(X, S)");
    bench.tick();
    assert_eq!(bench.call(call), (7, 0));
}

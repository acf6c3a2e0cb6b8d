//! Axes that are fed from tags, as masters and by themselves; MAW, MDW, MAR and MDR (spec/axis-and-data-types.md §5).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::axis_event::{
    REG_EVENT1_ARMED_STATUS, REG_EVENT1_STATUS, WATCH_EVENT_ARMED_STATUS, WATCH_EVENT_STATUS,
};
use arcline_instruction_set::predefined::axis_fault;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::{machine, without_command_limits};

/// The operands from Speed on: a trapezoid at 100 units/s.
const TRAPEZOID: &str = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";

/// The machine for gears, with an encoder `E` on the tag `Encoder` and a rotary one, `ER`, and inputs of `A1`.
fn with_encoders(period_ms: f64) -> Bench {
    let encoder = |name: &str, tag: &str, more: &str| {
        format!(
            "[[axis]]\nname = \"{name}\"\ntype = \"feedback\"\nmax_speed = 1000.0\nmax_acceleration = 5000.0\n\
             feed = {{ tag = \"{tag}\", interval_ms = 8.0, timeout_ms = 50.0 }}\n{more}"
        )
    };
    let tags = "[[tag]]\nname = \"Encoder\"\ntype = \"LREAL\"\n[[tag]]\nname = \"Turns\"\ntype = \"REAL[2]\"\n\
                [[tag]]\nname = \"Marks\"\ntype = \"DINT\"\n[[tag]]\nname = \"Mark\"\ntype = \"BOOL\"\n\
                [[tag]]\nname = \"Cam\"\ntype = \"CAM[2]\"\n[[tag]]\nname = \"Profile\"\ntype = \"CAM_PROFILE[2]\"\n";
    let own = without_command_limits(period_ms).replacen(
        "name = \"A1\"\n",
        "name = \"A1\"\nregistration = { input_1 = \"Mark\", input_2 = \"Marks.3\" }\n",
        1,
    );
    Bench::with(&format!(
        "{own}{}{}{tags}",
        encoder("E", "Encoder", ""),
        encoder("ER", "Turns[1]", "unwind = 360.0\n")
    ))
}

#[track_caller]
fn near(is: f64, expected: f64, why: &str) {
    assert!((is - expected).abs() < 1e-9, "{why}: {is} is not {expected}");
}

fn events(bench: &Bench, axis: &str) -> u32 {
    bench.axis(axis).event
}

#[test]
fn an_encoder_goes_in_straight_lines_from_position_to_position() {
    for period in [0.25, 1.0, 4.0] {
        let mut bench = with_encoders(period);
        let ticks = (8.0 / period) as u64;
        // The first position is where it is: nothing moves.
        bench.write("Encoder", 100.0);
        assert_eq!(bench.axis("E").actual, [100.0, 0.0, 0.0]);
        assert_eq!(bench.call("MAG(A1, E, G, Same, 0.5, 1, 1, Actual, Real, Disabled)"), OK);
        bench.cam("Cam", &[(0.0, 0.0, 0), (1000.0, 2000.0, 0)]);
        assert_eq!(bench.call("MCCP(Calc, Cam, 2, 0, 0, Profile)"), OK);
        assert_eq!(
            bench.call("MAPC(B1, E, C, Same, Profile, 1, 1, Once, Immediate, 0, 0, Command, Bidirectional)"),
            OK
        );
        bench.run(ticks);
        let mut before = 100.0;
        for position in [104.0, 112.0, 110.0, 110.0, 130.0] {
            bench.write("Encoder", position);
            for tick in 1..=ticks {
                bench.tick();
                let share = tick as f64 / ticks as f64;
                let expected = before + share * (position - before);
                let [is, velocity, _] = bench.axis("E").actual;
                near(is, expected, &format!("{period} ms"));
                near(velocity, (position - before) / 0.008, "velocity");
                near(bench.position("A1"), 0.5 * (is - 100.0), "a gear");
                near(bench.position("B1"), 2.0 * (is - 100.0), "a cam");
            }
            before = position;
        }
        bench.tick();
        assert_eq!(
            bench.axis("E").actual,
            [130.0, 0.0, 0.0],
            "nothing is written: it stands"
        );
        // A redefined position is that of the axis, not of the tag.
        assert_eq!(bench.call("MRP(E, R, 0, 0, 1000)"), OK);
        bench.write("Encoder", 134.0);
        bench.run(2 * ticks);
        near(bench.axis("E").actual[0], 1004.0, "redefined");
        near(bench.position("A1"), 17.0, "its slave does not see that");
    }
}

#[test]
fn a_rotary_encoder_goes_the_short_way() {
    let mut bench = with_encoders(1.0);
    bench.write("Turns[1]", 350.0);
    assert_eq!(bench.call("MAG(A1, ER, G, Same, 1, 1, 1, Actual, Real, Disabled)"), OK);
    for (written, shown, slave) in [
        (10.0, 10.0, 20.0),
        (355.0, 355.0, 5.0),
        (720.0, 0.0, 10.0),
        (800.0, 80.0, 90.0),
    ] {
        bench.write("Turns[1]", written);
        bench.run(10);
        near(bench.axis("ER").actual[0], shown, "what it shows");
        near(bench.position("A1"), slave, "its slave");
    }
    bench.write("Turns[0]", 5.0);
    bench.run(10);
    near(bench.axis("ER").actual[0], 80.0, "another element");
}

#[test]
fn old_positions_fault_and_missed_motion_is_not_made_up() {
    let mut bench = with_encoders(1.0);
    bench.run(200);
    assert_eq!(bench.axis("E").fault, 0, "nothing was ever written");
    bench.write("Encoder", 0.0);
    assert_eq!(bench.call("MAG(A1, E, G, Same, 1, 1, 1, Actual, Real, Disabled)"), OK);
    bench.run(50);
    bench.write("Encoder", 8.0);
    bench.run(50);
    assert_eq!(bench.axis("E").fault, 0, "just in time");
    bench.run(2);
    assert_eq!(bench.axis("E").fault, axis_fault::PHYSICAL_AXIS_FAULT);
    assert_eq!(bench.call("MAFR(E, F)"), OK);
    bench.run(2);
    assert_eq!(
        bench.axis("E").fault,
        axis_fault::PHYSICAL_AXIS_FAULT,
        "the cause is there"
    );
    bench.write("Encoder", f64::NAN);
    bench.run(2);
    assert_eq!(bench.call("MAFR(E, F)"), OK);
    bench.run(2);
    assert_eq!(
        bench.axis("E").fault,
        axis_fault::PHYSICAL_AXIS_FAULT,
        "that was no number"
    );
    bench.write("Encoder", 500.0);
    assert_eq!(bench.call("MAFR(E, F)"), OK);
    bench.run(10);
    assert_eq!((bench.axis("E").fault, bench.axis("E").actual[0]), (0, 500.0));
    near(bench.position("A1"), 8.0, "its slave stands");
    bench.write("Encoder", 503.0);
    bench.run(10);
    near(bench.position("A1"), 11.0, "and goes on");
}

#[test]
fn an_encoder_cannot_be_moved() {
    let mut bench = with_encoders(1.0);
    #[rustfmt::skip]
    let cases = [
        (format!("MAM(E, T, 0, 5, {TRAPEZOID})"), (8, 0)),
        (format!("MAJ(E, T, 0, {TRAPEZOID})"), (8, 0)),
        ("MAG(E, A1, T, Same, 1, 1, 1, Actual, Real, Disabled)".into(), (8, 0)),
        ("MAPC(E, A1, T, Same, Profile, 1, 1)".into(), (8, 0)),
        ("MATC(E, T, Same, Profile, 1, 1)".into(), (8, 0)),
        ("MSO(E, T)".into(), (8, 0)),
        ("MSF(E, T)".into(), (8, 0)),
        ("MRP(E, T, 0, 0, 5)".into(), OK),
        ("MASD(E, U)".into(), OK),
        ("MASR(E, V)".into(), OK),
        ("MAW(E, W, Forward, 5)".into(), OK),
    ];
    for (call, expected) in cases {
        assert_eq!(bench.call(&call), expected, "{call}");
        bench.run(3);
    }
    let text = format!(
        "{}[[axis]]\nname = \"E\"\ntype = \"feedback\"\nmax_speed = 1.0\nmax_acceleration = 1.0\nfeed = {{ tag = \"T\" }}\n",
        machine(1.0)
    );
    for (more, expected) in [
        ("", "axis[20].feed.tag"),
        ("[[tag]]\nname = \"T\"\ntype = \"BOOL\"\n", "axis[20].feed.tag"),
        (
            "[[tag]]\nname = \"T\"\ntype = \"DINT\"\n[[coordinate_system]]\nname = \"CE\"\ntype = \"cartesian\"\n\
             axes = [\"E\"]\nmax_speed = 1.0\nmax_acceleration = 1.0\n",
            "coordinate_system[11].axes[1]",
        ),
    ] {
        let error = arcline_config::load(&format!("{text}{more}"), "f.toml").expect_err(more);
        assert_eq!(error.key, expected, "{error}");
    }
}

/// A reversal at 1000 units/s² turns a third of a period before a tick, 0.0005 units beyond the positions of its ticks.
#[test]
fn a_watched_position_between_two_ticks_is_seen() {
    for (beyond, seen) in [(-1e-6, true), (1e-6, false)] {
        let mut bench = with_encoders(3.0);
        assert_eq!(bench.call(&format!("MAM(A1, M, 0, 100, {TRAPEZOID})")), OK);
        bench.run(60);
        assert_eq!(bench.axis("A1").actual[1], 100.0);
        assert_eq!(
            bench.call(&format!("MAM(A1, Back, 0, 0, {TRAPEZOID}, Enabled, Programmed)")),
            OK
        );
        bench.tick();
        let [position, velocity, acceleration] = bench.axis("A1").actual;
        assert_eq!(acceleration, -1000.0);
        let peak = position + velocity * velocity / 2000.0;
        assert_eq!(bench.call(&format!("MAW(A1, W, Forward, {})", peak + beyond)), OK);
        let mut highest: f64 = 0.0;
        while bench.axis("A1").actual[1] > -50.0 {
            bench.tick();
            highest = highest.max(bench.axis("A1").actual[0]);
        }
        assert!(highest < peak - 1e-5, "a tick at the peak: {highest}, {peak}");
        assert_eq!(bench.control("W").has(Flag::Pc), seen, "{beyond}");
    }
}

#[test]
fn watched_positions_are_seen_when_they_are_passed() {
    #[rustfmt::skip]
    let cases = [
        // why,                      trigger,   position, from, to,    seen
        ("forward",                  "Forward", 5.0,      0.0,  10.0,  true),
        ("up to it",                 "Forward", 10.0,     0.0,  10.0,  true),
        ("not as far",               "Forward", 11.0,     0.0,  10.0,  false),
        ("from it",                  "Forward", 0.0,      0.0,  10.0,  false),
        ("the other way",            "Reverse", 5.0,      0.0,  10.0,  false),
        ("reverse",                  "Reverse", 5.0,      10.0, 0.0,   true),
        ("the other way in reverse", "Forward", 5.0,      10.0, 0.0,   false),
    ];
    for (why, trigger, position, from, to, seen) in cases {
        let mut bench = with_encoders(1.0);
        bench.call(&format!("MAM(A1, M, 0, {from}, {TRAPEZOID})"));
        bench.until("M", Flag::Pc);
        assert_eq!(bench.call(&format!("MAW(A1, W, {trigger}, {position})")), OK, "{why}");
        assert_eq!(
            (bench.bits("W").as_str(), events(&bench, "A1")),
            ("EN IP", WATCH_EVENT_ARMED_STATUS)
        );
        bench.tick();
        assert_eq!(bench.bits("W"), "EN DN IP");
        assert_eq!(
            bench.call(&format!("MAW(A1, V, {trigger}, 1)")),
            (3, 0),
            "one at a time"
        );
        bench.call(&format!("MAM(A1, M, 0, {to}, {TRAPEZOID})"));
        bench.until("M", Flag::Pc);
        let (bits, word) = if seen {
            ("EN DN PC", WATCH_EVENT_STATUS)
        } else {
            ("EN DN IP", WATCH_EVENT_ARMED_STATUS)
        };
        assert_eq!((bench.bits("W").as_str(), events(&bench, "A1")), (bits, word), "{why}");
        assert_eq!(bench.axis("A1").watched, if seen { position } else { 0.0 }, "{why}");
        assert_eq!(bench.call("MDW(A1, D)"), OK);
        bench.tick();
        assert_eq!(
            (bench.bits("D").as_str(), bench.control("W").has(Flag::Ip)),
            ("EN DN", false),
            "{why}"
        );
        assert_eq!(events(&bench, "A1") & WATCH_EVENT_ARMED_STATUS, 0, "{why}");
    }
    let mut bench = with_encoders(1.0);
    assert_eq!(bench.call("MAW(TURN, W, Forward, 360)"), (13, 3));
    assert_eq!(bench.call("MAW(TURN, W, Forward, 0)"), OK);
    bench.call(&format!("MAM(TURN, M, 1, 361, {TRAPEZOID})"));
    bench.until("W", Flag::Pc);
    assert!(bench.position("TURN") < 2.0, "a whole turn");
    assert_eq!(bench.call("MAW(TURN, W, Forward, 90)"), OK);
    assert_eq!(bench.call("MASD(TURN, S)"), OK);
    bench.tick();
    assert_eq!(
        (bench.bits("W").as_str(), events(&bench, "TURN")),
        ("EN DN", 0),
        "a shutdown ends it"
    );
    assert_eq!(bench.call("MAW(TURN, V, Forward, 90)"), (7, 0));
}

#[test]
fn registration_latches_position_and_time_at_an_edge() {
    let mut bench = with_encoders(1.0);
    assert_eq!(bench.call("MAR(B1, R, 0, 0, 0, 0, 1)"), (75, 0), "no input");
    assert_eq!(bench.call("MDR(B1, D, 1)"), (75, 0));
    assert_eq!(bench.call("MAR(A1, R, PositiveEdge, Enabled, 5, 4, 1)"), (13, 4));
    assert_eq!(bench.call("MAR(A1, R, PositiveEdge, Disabled, 5, 4, 3)"), (13, 6));
    bench.call(&format!("MAJ(A1, J, 0, {TRAPEZOID})"));
    bench.run(200);
    bench.write("Mark", 1.0);
    bench.write("Mark", 0.0);
    assert_eq!(bench.axis("A1").registered, [[0.0; 3]; 2], "nobody waits");
    assert_eq!(bench.call("MAR(A1, R, PositiveEdge, Enabled, 30, 40, 1)"), OK);
    assert_eq!(bench.call("MAR(A1, S, NegativeEdge, Disabled, 0, 0, 2)"), OK);
    assert_eq!(bench.call("MAR(A1, T, NegativeEdge, Disabled, 0, 0, 1)"), (34, 0));
    assert_eq!(
        events(&bench, "A1") & (REG_EVENT1_ARMED_STATUS | REG_EVENT1_STATUS),
        REG_EVENT1_ARMED_STATUS
    );
    // Outside of the window, then inside of it; A1 is at 15 and goes 0.1 a tick.
    bench.write("Mark", 1.0);
    bench.write("Mark", 0.0);
    bench.run(200);
    assert_eq!(bench.bits("R"), "EN DN IP");
    let position = bench.position("A1");
    bench.write("Mark", 1.0);
    assert_eq!(bench.bits("R"), "EN DN PC");
    let shown = bench.axis("A1");
    assert_eq!(
        (shown.registered[0], shown.registered_at[0]),
        ([position, position, 0.0], [400_000, 400_000, 0])
    );
    assert_eq!(
        shown.event & (REG_EVENT1_ARMED_STATUS | REG_EVENT1_STATUS),
        REG_EVENT1_STATUS
    );
    bench.run(50);
    bench.write("Marks", 0xFF as f64);
    bench.write("Marks.3", 1.0);
    assert_eq!(bench.bits("S"), "EN DN IP", "the wrong edge, and none");
    bench.write("Marks.3", 0.0);
    assert_eq!(bench.bits("S"), "EN DN PC");
    assert_eq!(
        bench.axis("A1").registered[1],
        [bench.position("A1"), 0.0, bench.position("A1")]
    );
    assert_eq!(bench.call("MAR(A1, R, PositiveEdge, Disabled, 0, 0, 1)"), OK);
    assert_eq!(bench.call("MDR(A1, D, 1)"), OK);
    bench.tick();
    assert_eq!((bench.bits("R").as_str(), bench.bits("D").as_str()), ("EN DN", "EN DN"));
}

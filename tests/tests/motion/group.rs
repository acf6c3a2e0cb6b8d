//! MGS, MGSD, MGSR and MGSP on the group (spec/axis-and-data-types.md §4).

use arcline_instruction_set::Flag;
use arcline_instruction_set::predefined::{axis_status, motion_status};
use arcline_tests::bench::{Bench, OK};

/// CIPAxisState of an axis whose servo is off, is on, or that is shut down.
const STOPPED: i16 = 2;
const RUNNING: i16 = 4;
const SHUTDOWN: i16 = 10;

/// X and Y in a coordinated move, Z in a move of its own, all at 100 units/s or more.
fn moving(configuration: &[(&str, &str)]) -> Bench {
    let mut text = arcline_config::DEFAULT.to_owned();
    for (axis, mode) in configuration {
        let name = format!("name = \"{axis}\"\ntype = \"servo\"");
        assert!(text.contains(&name), "{axis}");
        text = text.replacen(&name, &format!("{name}\nprogrammed_stop_mode = \"{mode}\""), 1);
    }
    let mut bench = Bench::with(&text);
    let rates = "100, 0, 1000, 0, 1000, 0, 0, 100, 100, 2";
    assert_eq!(bench.call(&format!("MCLM(XY, L1, 0, [1000, 1000], {rates}, 1)")), OK);
    assert_eq!(bench.call(&format!("MCLM(XY, L2, 0, [2000, 1000], {rates}, 1)")), OK);
    assert_eq!(bench.call(&format!("MAM(Z, A1, 0, 1000, {rates})")), OK);
    bench.run(500);
    bench
}

fn states(bench: &Bench) -> [i16; 3] {
    ["X", "Y", "Z"].map(|axis| bench.axis(axis).cip_state)
}

#[test]
fn a_fast_stop_brakes_every_axis_and_empties_the_queue() {
    let mut bench = moving(&[]);
    let before = bench.position("Z");
    assert_eq!(bench.call("MGS(Motion, G1, FastStop)"), OK);
    assert_eq!(bench.bits("G1"), "EN DN IP");
    for tag in ["L1", "L2", "A1"] {
        assert_eq!(bench.bits(tag), "EN DN", "{tag}");
    }
    bench.tick();
    assert_ne!(bench.axis("Z").motion_status & motion_status::STOPPING_STATUS, 0);
    // 100 units/s at the Maximum Deceleration of 10,000: half a unit in 10 ms.
    assert_eq!(bench.until("G1", Flag::Pc), 9);
    assert!((bench.position("Z") - before - 0.5).abs() < 1e-9);
    assert_eq!(bench.bits("G1"), "EN DN PC");
    assert_eq!(states(&bench), [RUNNING; 3]);
    bench.until_rest();
}

#[test]
fn each_axis_stops_in_its_programmed_mode() {
    let mut bench = moving(&[("X", "fast_disable"), ("Y", "fast_shutdown"), ("Z", "hard_disable")]);
    assert_eq!(bench.call("MGS(Motion, G1, Programmed)"), OK);
    bench.tick();
    assert_eq!(states(&bench), [RUNNING, RUNNING, STOPPED]);
    assert!(bench.axis("Z").actual[1] > 90.0, "it coasts");
    bench.until("G1", Flag::Pc);
    assert_eq!(states(&bench), [STOPPED, SHUTDOWN, STOPPED]);
    assert_eq!(bench.axis("Z").actual[1], 0.0);
}

#[test]
fn a_fast_disable_switches_every_drive_off_when_it_stands_and_a_hard_shutdown_at_once() {
    let mut bench = moving(&[]);
    assert_eq!(bench.call("MGS(Motion, G1, FastDisable)"), OK);
    bench.until("G1", Flag::Pc);
    assert_eq!(states(&bench), [STOPPED; 3]);
    assert_eq!(bench.axis("A").cip_state, RUNNING, "a virtual axis has no drive");

    let mut bench = moving(&[("X", "hard_shutdown")]);
    bench.call("MGS(Motion, G1, Programmed)");
    assert_eq!(states(&bench), [SHUTDOWN, RUNNING, RUNNING]);
}

#[test]
fn a_second_stop_supersedes_the_first_and_a_stop_at_rest_is_complete_at_the_next_update() {
    let mut bench = moving(&[]);
    bench.call("MGS(Motion, G1, FastStop)");
    bench.run(3);
    assert_eq!(bench.call("MGS(Motion, G2, FastDisable)"), OK);
    assert_eq!(bench.bits("G1"), "EN DN");
    bench.until("G2", Flag::Pc);
    assert_eq!(states(&bench), [STOPPED; 3]);

    let mut bench = Bench::new();
    bench.call("MGS(Motion, G1, FastStop)");
    assert_eq!(bench.until("G1", Flag::Pc), 1);
}

#[test]
fn a_group_shutdown_ends_everything_at_once_and_its_reset_readies_every_axis() {
    let mut bench = moving(&[]);
    assert_eq!(bench.call("MGSD(Motion, G1)"), OK);
    assert_eq!(bench.bits("G1"), "EN");
    for tag in ["L1", "L2", "A1"] {
        assert_eq!(bench.bits(tag), "EN DN", "{tag}");
    }
    bench.tick();
    assert_eq!(bench.bits("G1"), "EN DN");
    assert_eq!(states(&bench), [SHUTDOWN; 3]);
    assert_eq!(
        bench.axis("A").status & axis_status::SHUTDOWN_STATUS,
        axis_status::SHUTDOWN_STATUS
    );
    assert_eq!(bench.call("MSO(X, M1)"), (7, 0));
    assert_eq!(bench.call("MGSR(Motion, G2)"), OK);
    bench.run(2);
    assert_eq!(bench.bits("G2"), "EN DN");
    assert_eq!(states(&bench), [STOPPED; 3]);
    assert_eq!(bench.call("MSO(X, M1)"), (22, 0), "it coasts");
    bench.run(3000);
    assert_eq!(bench.call("MSO(X, M1)"), OK);
}

#[test]
fn a_strobe_holds_the_positions_of_one_update() {
    let mut bench = moving(&[]);
    let positions = ["X", "Y", "Z"].map(|axis| [bench.axis(axis).command[0], bench.axis(axis).actual[0]]);
    assert_eq!(bench.call("MGSP(Motion, G1)"), OK);
    bench.run(20);
    assert_eq!(["X", "Y", "Z"].map(|axis| bench.axis(axis).strobed), positions);
    assert!(bench.position("X") > positions[0][0]);
}

#[test]
fn a_stop_mode_beyond_the_words_is_out_of_range() {
    let mut bench = Bench::new();
    for mode in ["-1", "3"] {
        assert_eq!(bench.call(&format!("MGS(Motion, G1, {mode})")), (13, 2), "{mode}");
    }
}

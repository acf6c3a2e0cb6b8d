//! Which instruction works in which state: the matrix of spec/axis-and-data-types.md §1.8, every cell of it.

use arcline_instruction_set::{FaultKind, Flag};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::CAM_TAGS;
use arcline_tests::robots::PATH_TAGS;

/// A trapezoid at 50 units/s, from Speed on.
const RATES: &str = "50, 0, 500, 0, 500, 0, 0, 100, 100, 2";

/// A name, and the function that makes a machine in this state.
type State = (&'static str, fn() -> Bench);

/// The states, in the order of the matrix's columns.
const STATES: [State; 7] = [
    ("servo off", servo_off),
    ("shutdown", shutdown),
    ("axis fault", axis_fault),
    ("active homing", active_homing),
    ("stop All running", stop_all_running),
    ("in a coordinated move", in_a_coordinated_move),
    ("moved by a transform", moved_by_a_transform),
];

/// A system that turns too, about axes of its own.
const TURNING: &str = "[[axis]]\nname = \"RX\"\ntype = \"virtual\"\nmax_speed = 1000.0\nmax_acceleration = 10000.0\n\
    [[axis]]\nname = \"RY\"\ntype = \"virtual\"\nmax_speed = 1000.0\nmax_acceleration = 10000.0\n\
    [[axis]]\nname = \"RZ\"\ntype = \"virtual\"\nmax_speed = 1000.0\nmax_acceleration = 10000.0\n\
    [[coordinate_system]]\nname = \"Turn\"\ndefinition = \"XYZRxRyRz\"\naxes = [\"X\", \"Y\", \"Z\", \"RX\", \"RY\", \"RZ\"]\n\
    max_speed = 500.0\nmax_acceleration = 5000.0\n";

/// X is homed by an active sequence, Y by a passive one.
fn machine() -> Bench {
    let home = |name: &str, mode: &str| {
        let axis = format!("name = \"{name}\"\ntype = \"servo\"");
        let home = format!(
            "{axis}\nhome = {{ mode = \"{mode}\", sequence = \"switch\", direction = \"bidirectional-forward\", \
             speed = 20.0, return_speed = 5.0, switch = {{ min = 1000.0, max = 1100.0 }} }}"
        );
        (axis, home)
    };
    let mut text = arcline_config::DEFAULT.to_owned();
    for (axis, with_home) in [home("X", "active"), home("S", "passive")] {
        assert!(text.contains(&axis));
        text = text.replacen(&axis, &with_home, 1);
    }
    text += CAM_TAGS;
    text += TURNING;
    text += PATH_TAGS;
    let mut bench = Bench::with(&text);
    assert_eq!(bench.call("MCCP(Calculated, Cam, 2, 0, 0, Profile)"), OK);
    bench
}

/// Makes a machine by these calls.
fn made(calls: &[&str], ticks: u64) -> Bench {
    let mut bench = machine();
    for (place, call) in calls.iter().enumerate() {
        assert_eq!(bench.call(&call.replace("{tag}", &format!("Set{place}"))), OK, "{call}");
    }
    bench.run(ticks);
    bench
}

fn servo_off() -> Bench {
    made(&["MSF(X, {tag})", "MSF(S, {tag})"], 5)
}

fn shutdown() -> Bench {
    made(&["MASD(X, {tag})", "MASD(S, {tag})"], 5)
}

fn axis_fault() -> Bench {
    let mut bench = machine();
    for axis in ["X", "S"] {
        bench.inject(axis, &[FaultKind::ALL[0]]);
    }
    bench.run(50);
    bench
}

fn active_homing() -> Bench {
    made(&["MAH(X, {tag})"], 50)
}

fn stop_all_running() -> Bench {
    let moves = ["X", "S"].map(|axis| format!("MAM({axis}, {{tag}}, 0, 1000, {RATES})"));
    let mut bench = made(&[&moves[0], &moves[1]], 500);
    for axis in ["X", "S"] {
        assert_eq!(
            bench.call(&format!("MAS({axis}, Stop{axis}, All, Yes, 100, 0, No, 0, 2)")),
            OK
        );
    }
    bench.run(10);
    bench
}

fn in_a_coordinated_move() -> Bench {
    let call = format!("MCLM(CS2, {{tag}}, 0, [100, 100, 100], {RATES}, 1)");
    made(&[&call], 500)
}

/// X is led back by the target of a transform, S is part of the source too.
fn moved_by_a_transform() -> Bench {
    let moves = ["A", "C"].map(|axis| format!("MAM({axis}, {{tag}}, 0, 100, {RATES})"));
    made(
        &["MCT(CS2, CS3, {tag}, [0, 0, 0], [0, 0, 0])", &moves[0], &moves[1]],
        500,
    )
}

/// A cell: ERR of the instruction; 0: it works.
type Row = (&'static str, [i16; 7]);

#[rustfmt::skip]
const MATRIX: &[Row] = &[
    // instruction                                          off sd  flt hom stp crd trf
    ("MSO(X, T)",                                         [  0,  7, 20, 22, 22, 22, 22]),
    ("MSF(X, T)",                                         [  0,  0,  0,  0,  0,  0,  0]),
    ("MASD(X, T)",                                        [  0,  0,  0,  0,  0,  0,  0]),
    ("MASR(X, T)",                                        [  0,  0,  0,  0,  0,  0,  0]),
    ("MAFR(X, T)",                                        [  0,  0,  0,  0,  0,  0,  0]),
    ("MAM(X, T, 1, 5, {rates})",                          [  5,  7, 20, 16, 78,  0,  0]),
    ("MAJ(X, T, 0, {rates})",                             [  5,  7, 20, 16, 78,  0,  0]),
    ("MAG(X, Z, T, 0, 1, 1, 1, 1, 0, 1)",                 [  5,  7, 20, 16, 78,  0,  0]),
    ("MAPC(X, Z, T, 0, Profile, 1, 1)",                   [  5,  7, 20, 16, 78,  0,  0]),
    ("MATC(X, T, 0, Profile, 1, 1)",                      [  5,  7, 20, 16, 78,  0,  0]),
    ("MAS(X, T, All, No, 0, 0, No, 0, 2)",                [  5,  7,  0,  0,  0,  0,  0]),
    ("MAH(X, T)",                                         [  5,  7, 20, 16, 78,  0, 63]),
    ("MAH(S, T)",                                         [  0,  7,  0,  0,  0,  0, 63]),
    ("MRP(X, T, 1, 0, 5)",                                [  0,  7,  0, 16,  0,  0, 63]),
    ("MCLM(CS1, T, 1, [5, 5, 5], {rates}, 1)",            [  5,  7, 20, 16, 78, 52,  0]),
    ("MCPM(Turn, T, Way, 1, Pace)",                       [  5,  7, 20, 16, 78, 52,  0]),
    ("MGS(Motion, T, 1)",                                 [  0,  0,  0,  0,  0,  0,  0]),
];

#[test]
fn every_instruction_has_the_error_of_the_matrix_in_every_state() {
    let mut wrong = Vec::new();
    for (call, expected) in MATRIX {
        let call = call.replace("{rates}", RATES);
        for ((state, make), expected) in STATES.iter().zip(expected) {
            let mut bench = make();
            let (err, exerr) = bench.call(&call);
            if err != *expected {
                wrong.push(format!(
                    "{call} while {state}: ERR {err} EXERR {exerr}, expected {expected}"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn accepted_stops_end_the_coordinated_move() {
    for (call, ends) in [
        ("MSF(X, T)", true),
        ("MASD(X, T)", true),
        ("MAFR(X, T)", false),
        ("MAS(X, T, All, No, 0, 0, No, 0, 2)", true),
        ("MAS(X, T, Move, No, 0, 0, No, 0, 2)", false),
        ("MGS(Motion, T, 1)", true),
    ] {
        let mut bench = in_a_coordinated_move();
        assert_eq!(bench.call(call), OK, "{call}");
        bench.run(2);
        assert_eq!(
            !bench.control("Set0").has(Flag::Ip),
            ends,
            "{call} in a coordinated move"
        );
        let mut bench = active_homing();
        assert_eq!(bench.call(call), OK, "{call}");
        bench.run(2);
        assert_eq!(!bench.control("Set0").has(Flag::Ip), ends, "{call} while homing");
    }
}

//! Every error code that an executed instruction can raise, raised: ERR with EXERR (spec/axis-and-data-types.md §1.7, §6,
//! §7, spec/coordinated-instructions.md §11).
//!
//! The table says how. That nothing is missing is checked against the lists of the specification, and against every error
//! that the sources of `crates/motion` construct; an error that cannot be raised is listed with its reason.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use arcline_instruction_set::{FaultKind, Flag, Mnemonic, MotionError, Timing};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::CAM_TAGS;

/// A trapezoid at 50 units/s, from Speed on.
const RATES: &str = "50, 0, 500, 0, 500, 0, 0, 100, 100, 2";
/// The same as an S-curve.
const CURVE: &str = "50, 0, 500, 0, 500, 0, 1, 100, 100, 2";

/// Axes and coordinate systems that the default machine does not have.
const MORE: &str = r#"
[[axis]]
name = "H"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
home = { sequence = "switch", speed = 20.0, switch = { min = 1000.0 } }

[[axis]]
name = "NoSwitch"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
home = { sequence = "switch", speed = 20.0 }

[[axis]]
name = "Torque"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
home = { sequence = "torque", speed = 20.0 }

[[axis]]
name = "NoDecel"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 0.0
home = { sequence = "marker", speed = 20.0, marker = {} }

[[axis]]
name = "NoJerk"
type = "virtual"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
max_deceleration_jerk = 0.0

[[tag]]
name = "Out"
type = "DINT"

[[tag]]
name = "Outs"
type = "OUTPUT_CAM"
value = { LatchType = 1, UnlatchType = 1, Right = 5.0 }

[[tag]]
name = "NoOuts"
type = "OUTPUT_CAM[2]"
value = [{}, { OutputBit = 32 }]

[[tag]]
name = "NoComp"
type = "OUTPUT_COMPENSATION"
value = { Mode = 4 }

[[axis]]
name = "R"
type = "virtual"
output_cam_execution_targets = 1
units = "deg"
unwind = 360.0
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0

[[axis]]
name = "L"
type = "virtual"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
travel = { min = -5.0, max = 10.0 }
start = { position = 11.0 }

[[axis]]
name = "E"
type = "feedback"
max_speed = 1000.0
max_acceleration = 10000.0
feed = { tag = "Encoder" }
registration = { input_1 = "Mark", input_2 = "Mark" }

[[tag]]
name = "Encoder"
type = "REAL"

[[tag]]
name = "Mark"
type = "BOOL"

[[tag]]
name = "NoType"
type = "CAM[2]"
value = [{ Master = 0.0 }, { Master = 5.0, SegmentType = 2 }]

[[tag]]
name = "NoOrder"
type = "CAM[2]"

[[tag]]
name = "Empty"
type = "CAM_PROFILE[2]"

[[tag]]
name = "Way"
type = "PATH_DATA"
value = { InterpolationType = 1, TerminationType = 1, Position = [5.0, 5.0, 5.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0] }

[[tag]]
name = "Settling"
type = "PATH_DATA"
value = { InterpolationType = 1 }

[[tag]]
name = "NoWay"
type = "PATH_DATA"
value = { InterpolationType = 1, TerminationType = 2 }

[[tag]]
name = "Point"
type = "PATH_DATA"
value = { TerminationType = 1 }

[[tag]]
name = "Pace"
type = "DYNAMICS_DATA"
value = { UnitsMode = 1, Speed = 50.0, Acceleration = 500.0, Deceleration = 500.0, OrientationSpeed = 50.0, OrientationAcceleration = 500.0, OrientationDeceleration = 500.0 }

[[tag]]
name = "Curve"
type = "DYNAMICS_DATA"
value = { UnitsMode = 1, Profile = 1, Speed = 50.0, AccelerationJerk = 50.0, DecelerationJerk = 50.0, Acceleration = 500.0, Deceleration = 500.0, OrientationSpeed = 50.0, OrientationAcceleration = 500.0, OrientationDeceleration = 500.0 }

[[tag]]
name = "Driven"
type = "DYNAMICS_DATA"
value = { UnitsMode = 1, TimeUnits = 1, Speed = 2.0, Acceleration = 500.0, Deceleration = 500.0, OrientationSpeed = 50.0, OrientationAcceleration = 500.0, OrientationDeceleration = 500.0 }

[[tag]]
name = "NoPace"
type = "DYNAMICS_DATA"

[[tag]]
name = "Frame"
type = "POSITION_DATA"

[[tag]]
name = "Tilted"
type = "POSITION_DATA"
value = { Ry = 91.0 }

[[tag]]
name = "Place"
type = "REAL[6]"

[[tag]]
name = "Bits"
type = "DINT"

[[tag]]
name = "Turns"
type = "INT[4]"
"#;

/// Coordinate systems: name, axes, keys in place of the usual ones.
const SYSTEMS: &[(&str, &str, &str)] = &[
    ("One", "\"A\"", ""),
    ("Flat", "\"A\", \"B\"", ""),
    ("Flat2", "\"Z\", \"S\"", ""),
    ("Homed", "\"A\", \"H\"", ""),
    ("AxisDecel", "\"A\", \"NoDecel\"", ""),
    ("AxisJerk", "\"A\", \"NoJerk\"", ""),
    ("Decel", "\"A\", \"B\"", "max_deceleration = 0.0"),
    (
        "Jerk",
        "\"A\", \"B\"",
        "max_deceleration = 5000.0\nmax_deceleration_jerk = 0.0",
    ),
    ("Tolerance", "\"A\", \"B\"", "actual_tolerance = 0.0"),
    ("Enforced", "\"A\", \"B\"", "axis_limits = \"enforce\""),
    ("Precise", "\"A\", \"B\"", "corner = \"precise\""),
    ("Round", "\"A\", \"R\"", ""),
    ("Limited", "\"A\", \"L\"", ""),
    ("SameAxis", "\"S\", \"B\", \"C\"", ""),
    ("Tool", "\"P1\", \"P2\", \"P3\"", ""),
    ("Arm", "\"Q1\", \"Q2\", \"Q3\"", ARM),
    ("Pose", "\"X\", \"Y\", \"Z\", \"P4\", \"P5\", \"P6\"", POSE),
    ("PoseHomed", "\"P1\", \"P2\", \"P3\", \"P4\", \"P5\", \"H\"", POSE),
    ("PoseDecel", "\"P1\", \"P2\", \"P3\", \"P4\", \"P5\", \"NoDecel\"", POSE),
    ("PoseJerk", "\"P1\", \"P2\", \"P3\", \"P4\", \"P5\", \"NoJerk\"", POSE),
    (
        "PoseLoose",
        "\"X\", \"Y\", \"Z\", \"P4\", \"P5\", \"P6\"",
        "actual_tolerance = 0.0\ndefinition = \"XYZRxRyRz\"",
    ),
    (
        "PosePrecise",
        "\"X\", \"Y\", \"Z\", \"P4\", \"P5\", \"P6\"",
        "corner = \"precise\"\ndefinition = \"XYZRxRyRz\"",
    ),
    ("Arm2", "\"Q4\", \"Q5\", \"Q6\"", ARM),
    ("NoLinks", "\"Q4\", \"Q5\", \"Q6\"", "type = \"articulated_dependent\""),
    (
        "NoRoom",
        "\"Q4\", \"Q5\", \"Q6\"",
        "type = \"delta\"\nlink_lengths = [100.0, 200.0]\nbase_offsets = [150.0, 0.0, 0.0]",
    ),
    (
        "Folded",
        "\"Q4\", \"Q5\", \"Q6\"",
        "type = \"scara_independent\"\nlink_lengths = [100.0, 100.0]\nzero_angles = [0.0, 180.0, 0.0]",
    ),
    ("Turn", TURN, ORIENTED),
    ("Turn2", "\"O2\", \"O1\", \"O3\", \"O4\", \"O5\", \"O6\"", ORIENTED),
    ("TurnR", "\"O1\", \"O2\", \"O3\", \"O4\", \"O5\", \"R\"", ORIENTED),
    ("TurnXYZ", "\"X\", \"Y\", \"Z\", \"O4\", \"O5\", \"O6\"", ORIENTED),
    ("TurnHome", "\"O1\", \"O2\", \"O3\", \"O4\", \"O5\", \"H\"", ORIENTED),
    ("TurnDecel", TURN, "definition = \"XYZRxRyRz\"\nmax_deceleration = 0.0"),
    (
        "TurnJerk",
        TURN,
        "definition = \"XYZRxRyRz\"\nmax_deceleration = 5000.0\nmax_deceleration_jerk = 0.0",
    ),
    ("Wrist", WRIST, SIX_AXES),
    ("Elbow", "\"W1\", \"W2\"", ""),
    (
        "WristStraight",
        WRIST,
        "type = \"articulated_independent\"\ndefinition = \"J1J2J3J4J5J6\"\nlink_lengths = [100.0, 100.0]\n\
         zero_angles = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0]",
    ),
    (
        "WristStretched",
        WRIST,
        "type = \"articulated_independent\"\ndefinition = \"J1J2J3J4J5J6\"\nlink_lengths = [100.0, 100.0]\n\
         zero_angles = [0.0, 0.0, 0.0, 0.0, 60.0, 0.0]",
    ),
    (
        "WristNoLinks",
        WRIST,
        "type = \"articulated_independent\"\ndefinition = \"J1J2J3J4J5J6\"",
    ),
    (
        "WristNoRoom",
        "\"W1\", \"W2\", \"W3\", \"W4\"",
        "type = \"delta\"\ndefinition = \"J1J2J3J6\"\nlink_lengths = [100.0, 200.0]\nbase_offsets = [150.0, 0.0, 0.0]",
    ),
];

/// Position and orientation.
const POSE: &str = "definition = \"XYZRxRyRz\"";
const TURN: &str = "\"O1\", \"O2\", \"O3\", \"O4\", \"O5\", \"O6\"";
const ORIENTED: &str = "definition = \"XYZRxRyRz\"";
const WRIST: &str = "\"W1\", \"W2\", \"W3\", \"W4\", \"W5\", \"W6\"";
/// At 0 the upper arm stands up, the forearm is level, and the hand is bent down.
const SIX_AXES: &str = "type = \"articulated_independent\"\ndefinition = \"J1J2J3J4J5J6\"\nlink_lengths = [100.0, 100.0]\n\
                        end_effector_offsets = [30.0, 0.0, 0.0]\nzero_angles = [0.0, -90.0, 90.0, 0.0, 60.0, 0.0]";

/// Two links of 100 on a turning base; at 0 it stands up and is bent forward.
const ARM: &str = "type = \"articulated_independent\"\nlink_lengths = [100.0, 100.0]\nzero_angles = [0.0, -90.0, 90.0]";

fn machine() -> String {
    let mut text = format!("{}\n{MORE}{CAM_TAGS}", arcline_config::DEFAULT);
    for letter in ["P", "Q", "O", "W"] {
        for place in 1..=6 {
            text.push_str(&format!(
                "\n[[axis]]\nname = \"{letter}{place}\"\ntype = \"virtual\"\nmax_speed = 100.0\nmax_acceleration = 10000.0\n"
            ));
        }
    }
    for (name, axes, keys) in SYSTEMS {
        let tolerance = if keys.contains("actual_tolerance") {
            ""
        } else {
            "actual_tolerance = 0.01\n"
        };
        let deceleration = if keys.contains("max_deceleration") {
            ""
        } else {
            "max_deceleration = 5000.0\n"
        };
        text.push_str(&format!(
            "\n[[coordinate_system]]\nname = \"{name}\"\naxes = [{axes}]\nmax_speed = 500.0\n\
             max_acceleration = 5000.0\ncommand_tolerance = 0.5\n{deceleration}{tolerance}{keys}\n"
        ));
    }
    text
}

/// The earlier steps, one a line: a call, `run TICKS`, or `fault AXIS`. Then a call and its ERR and EXERR.
type Row = (&'static str, &'static str, (i16, i8));

/// Speed, rates and jerks by a master.
const DRIVEN: &str = "2, 4, 1, 4, 1, 4, 0, 1, 1, 4";
const LINE: &str = "MCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)\nrun 20";
/// Linked to A, which stands, goes backwards at 50 units/s, or forwards at 1.
const STANDING: &str =
    "MDCC(CS1, A, B7, 1, 0)\nMDAC(X, A, B9, 0, 1)\nMCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)\nrun 200";
const BACKWARDS: &str =
    "MDCC(CS1, A, B7, 1, 0)\nMAJ(A, B6, 1, {rates})\nMCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)\nrun 200";
const SLOW: &str = "MDCC(CS1, A, B7, 1, 0)\nMAJ(A, B6, 0, 1, 0, 500, 0, 500, 0, 0, 1, 1, 0)\nMCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)\nrun 200";
const WAITING: &str = "MDCC(CS1, A, B7, 1, 0)\nMCLM(CS1, B1, 0, [9, 0, 0], {driven}, 1, 0, 0, 0, 5, 3)";
const ARC_STANDING: &str = "MDCC(XY, A, B7, 1, 0)\nMCLM(XY, B1, 0, [300, 0], {rates}, 1)\nrun 200";
const ARC_BACKWARDS: &str =
    "MDCC(XY, A, B7, 1, 0)\nMAJ(A, B6, 1, {rates})\nMCLM(XY, B1, 0, [300, 0], {rates}, 1)\nrun 200";
const ARC_SLOW: &str = "MDCC(XY, A, B7, 1, 0)\nMAJ(A, B6, 0, 1, 0, 500, 0, 500, 0, 0, 1, 1, 0)\nMCLM(XY, B1, 0, [300, 0], {rates}, 1)\nrun 200";
const ARC_WAITING: &str = "MDCC(XY, A, B7, 1, 0)\nMCLM(XY, B1, 0, [9, 0], {driven}, 1, 0, 0, 0, 5, 3)";
const MOVE: &str = "MDAC(X, A, B9, 0, 1)\nMAM(X, B1, 0, 300, {rates})\nrun 200";
const MOVE_BACKWARDS: &str = "MDAC(X, A, B9, 0, 1)\nMAJ(A, B6, 1, {rates})\nMAM(X, B1, 0, 300, {rates})\nrun 200";
const MOVE_SLOW: &str =
    "MDAC(X, A, B9, 0, 1)\nMAJ(A, B6, 0, 1, 0, 500, 0, 500, 0, 0, 1, 1, 0)\nMAM(X, B1, 0, 300, {rates})\nrun 200";
const MOVE_WAITING: &str = "MDAC(X, A, B9, 0, 1)\nMAM(X, B1, 0, 9, {driven}, 0, 0, 5, 3)";
const JOG_STANDING: &str = "MDAC(X, A, B9, 0, 1)\nMAJ(X, B1, 0, {rates})\nrun 200";
const JOG_BACKWARDS: &str = "MDAC(X, A, B9, 0, 1)\nMAJ(A, B6, 1, {rates})\nMAJ(X, B1, 0, {rates})\nrun 200";
const JOG_WAITING: &str = "MDAC(X, A, B9, 0, 1)\nMAJ(X, B1, 0, {driven}, 0, 0, 5, 3)";
const LINK: &str = "MCT(CS2, CS3, B1, [0, 0, 0], [0, 0, 0])\nrun 5";
const HOMING: &str = "MAH(H, B1)\nrun 5";
const REACH: &str = "MCT(Tool, Arm, B1, [0, 0, 0], [0, 0, 0])\nrun 5";
const TURNING: &str = "MCTO(Turn, Wrist, B1, Frame, Frame)\nrun 5";
const JOG: &str = "MAJ(X, B1, 0, {rates})\nrun 50";
const STOP_ALL: &str = "MAJ(X, B1, 0, {rates})\nrun 200\nMAS(X, B2, All, Yes, 100, 0, No, 0, 2)\nrun 2";
const FAULT: &str = "fault X\nrun 20";
const OFF: &str = "MSF(X, B1)\nrun 20";
const DOWN: &str = "MASD(X, B1)\nrun 20";
const CAM: &str = "MCCP(B9, Cam, 2, 0, 0, Profile)";
const CAMMING: &str = "MCCP(B9, Cam, 2, 0, 0, Profile)\nMAPC(X, Y, B1, 0, Profile, 1, 1, 0, 0, 0, 0, 1, 0)\nMATC(X, B2, 0, Profile, 1, 1)";

#[rustfmt::skip]
const TABLE: &[Row] = &[
    // MCLM: axes are counted within the coordinate system.
    ("MSF(Y, B1)\nrun 20",  "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1)",                             (5, 1)),
    ("MASD(Z, B1)\nrun 20", "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1)",                             (7, 2)),
    ("fault Y\nrun 20",     "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1)",                             (20, 1)),
    (HOMING,                "MCLM(Homed, T, 0, [5, 5], {rates}, 1)",                              (16, 1)),
    ("",                    "MCLM(CS1, T, 2, [5, 5, 5], {rates}, 1)",                             (13, 2)),
    ("",                    "MCLM(Round, T, 0, [5, 361], {rates}, 1)",                            (13, 3)),
    ("",                    "MCLM(CS1, T, 0, [5, 5, 5], 50, 0, 500, 4, 500, 0, 0, 100, 100, 2)",  (94, 0)),
    ("",                    "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1, 0, 0, 0, 0, 1)",              (95, 0)),
    ("",                    "MCLM(CS1, T, 0, [5, 5, 5], 50, 4, 500, 4, 500, 4, 0, 1, 1, 4, 1, 0, 0, 0, 0, 1)", (93, 0)),
    ("",                    "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1, 0, 0, 0, 0, 0, [1])",         (101, 0)),
    (STANDING,              "MCLM(CS1, T, 0, [5, 5, 5], {driven}, 1, 1, 0, 0, 0, 1)",             (97, 0)),
    (BACKWARDS,             "MCLM(CS1, T, 0, [5, 5, 5], {driven}, 1, 1, 0, 0, 0, 1)",             (98, 0)),
    (WAITING,               "MCLM(CS1, T, 0, [5, 5, 5], {driven}, 1, 0, 0, 0, 5, 3)",             (102, 0)),
    (SLOW,                  "MCLM(CS1, T, 0, [5, 5, 5], {driven}, 1, 1, 0, 0, 0, 1)",             (103, 0)),
    ("",                    "MCLM(Enforced, T, 0, [5, 5], {rates}, 3)",                           (99, 0)),
    ("",                    "MCLM(Decel, T, 0, [5, 5], {rates}, 1)",                              (54, -1)),
    ("",                    "MCLM(AxisDecel, T, 0, [5, 5], {rates}, 1)",                          (54, 1)),
    ("",                    "MCLM(Jerk, T, 0, [5, 5], {curve}, 1)",                               (76, -1)),
    ("",                    "MCLM(AxisJerk, T, 0, [5, 5], {curve}, 1)",                           (76, 1)),
    ("",                    "MCLM(Tolerance, T, 0, [5, 5], {rates}, 0)",                          (51, 0)),
    ("MCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)\nMCLM(CS1, B2, 0, [300, 5, 0], {rates}, 1)",
                            "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1)",                             (43, 0)),
    ("MCLM(Precise, B1, 0, [90, 0], {rates}, 1)\nMCLM(Precise, B2, 0, [90, 9], {rates}, 1)",
                            "MCLM(Precise, T, 0, [5, 5], {rates}, 1)",                            (43, 0)),
    ("MCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)\nrun 99\nMCS(CS1, B2, 2, Yes, 50, 0)\nrun 5",
                            "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1)",                             (78, 0)),
    ("MAJ(Y, B1, 0, {rates})\nrun 99\nMAS(Y, B2, All, Yes, 50, 0)\nrun 5",
                            "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1)",                             (78, 1)),
    ("MCLM(Flat2, B1, 0, [300, 0], {rates}, 1)\nrun 9", "MCLM(CS2, T, 0, [5, 5, 5], {rates}, 1)", (52, 2)),
    ("",                    "MCLM(Limited, T, 0, [5, 12], {rates}, 1)",                           (9, 0)),
    (REACH,                 "MCLM(Tool, T, 0, [190, 190, 0], {rates}, 1)",                        (67, 2)),
    (REACH,                 "MCLM(Tool, T, 0, [-100, 0, 100], {rates}, 1)",                       (68, 0)),
    ("MCT(Tool, Arm, B1, [0, 0, 0], [0, 0, 0])\nMCLM(Tool, B2, 0, [-50, 100, 100], {rates}, 1)\nrun 9000",
                            "MCLM(Tool, T, 0, [-50, -100, 100], {rates}, 1)",                     (72, 0)),
    // MCCM.
    ("",                    "MCCM(Turn, T, 0, [9, 0, 0], 1, [9, 0, 0], 2, {rates}, 1)",            (75, 0)),
    ("MSF(Y, B1)\nrun 20",  "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1)",                   (5, 1)),
    ("MASD(Y, B1)\nrun 20", "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1)",                   (7, 1)),
    (FAULT,                 "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1)",                   (20, 0)),
    (HOMING,                "MCCM(Homed, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1)",                (16, 1)),
    ("",                    "MCCM(One, T, 0, [0], 1, [9], 2, {rates}, 1)",                        (13, 0)),
    ("",                    "MCCM(XY, T, 0, [0, 0], 4, [9, 0], 2, {rates}, 1)",                   (13, 4)),
    ("",                    "MCCM(Round, T, 1, [0, 361], 1, [9, 0], 2, {rates}, 1)",              (13, 3)),
    ("",                    "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, 50, 0, 500, 4, 500, 0, 0, 100, 100, 2)", (94, 0)),
    ("",                    "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1, 0, 0, 0, 0, 1)",    (95, 0)),
    ("",                    "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, 50, 4, 500, 4, 500, 4, 0, 1, 1, 4, 1, 0, 0, 0, 0, 1)", (93, 0)),
    ("",                    "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1, 0, 0, 0, 0, 0, [1])", (101, 0)),
    (ARC_STANDING,          "MCCM(XY, T, 1, [0, 0], 3, [9, 0], 1, {driven}, 1, 1, 0, 0, 0, 1)",   (97, 0)),
    (ARC_BACKWARDS,         "MCCM(XY, T, 1, [0, 0], 3, [9, 0], 1, {driven}, 1, 1, 0, 0, 0, 1)",   (98, 0)),
    (ARC_WAITING,           "MCCM(XY, T, 1, [0, 0], 3, [9, 0], 1, {driven}, 1, 0, 0, 0, 5, 3)",   (102, 0)),
    (ARC_SLOW,              "MCCM(XY, T, 1, [0, 0], 3, [9, 0], 1, {driven}, 1, 1, 0, 0, 0, 1)",   (103, 0)),
    ("",                    "MCCM(Enforced, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 3)",             (99, 0)),
    ("",                    "MCCM(Decel, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1)",                (54, -1)),
    ("",                    "MCCM(AxisDecel, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1)",            (54, 1)),
    ("",                    "MCCM(Jerk, T, 0, [0, 0], 1, [9, 0], 2, {curve}, 1)",                 (76, -1)),
    ("",                    "MCCM(AxisJerk, T, 0, [0, 0], 1, [9, 0], 2, {curve}, 1)",             (76, 1)),
    ("",                    "MCCM(Tolerance, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 0)",            (51, 0)),
    ("",                    "MCCM(XY, T, 0, [3, 0], 0, [2, 0], 0, {rates}, 1)",                   (44, 0)),
    ("",                    "MCCM(XY, T, 0, [0, 0], 2, [1], 0, {rates}, 1)",                      (45, 0)),
    ("",                    "MCCM(XY, T, 0, [9, 9], 1, [2, 0], 0, {rates}, 1)",                   (46, 0)),
    ("",                    "MCCM(XY, T, 0, [9, 0], 2, [0.0005], 0, {rates}, 1)",                 (49, 0)),
    ("",                    "MCCM(CS1, T, 0, [9, 0, 0], 2, [9], 0, {rates}, 1)",                  (25, 0)),
    ("MCLM(XY, B1, 0, [300, 0], {rates}, 1)\nMCLM(XY, B2, 0, [300, 5], {rates}, 1)",
                            "MCCM(XY, T, 1, [0, 0], 3, [9, 0], 2, {rates}, 1)",                   (43, 0)),
    ("MCLM(XY, B1, 0, [300, 0], {rates}, 1)\nrun 99\nMCS(XY, B2, 2, Yes, 50, 0)\nrun 5",
                            "MCCM(XY, T, 1, [0, 0], 3, [9, 0], 2, {rates}, 1)",                   (78, 0)),
    (LINE,                  "MCCM(XY, T, 1, [0, 0], 3, [9, 0], 2, {rates}, 1)",                   (52, 0)),
    (REACH,                 "MCCM(Tool, T, 0, [190, 190, 0], 0, [150, 100, 50], 0, {rates}, 1)",  (67, 2)),
    (REACH,                 "MCCM(Tool, T, 0, [0, 100, 100], 0, [0, 0, 100], 0, {rates}, 1)",     (68, 0)),
    (REACH,                 "MCCM(Tool, T, 0, [0, -100, 100], 0, [-100, 0, 100], 0, {rates}, 1)", (72, 0)),
    ("",                    "MCCM(Limited, T, 0, [9, 20], 2, [90], 0, {rates}, 1)",               (9, 0)),
    // MCCD.
    ("MSF(Y, B1)\nrun 20",  "MCCD(CS1, T, 1, 1, 9, 0)",                                           (5, 1)),
    ("MASD(Z, B1)\nrun 20", "MCCD(CS1, T, 1, 1, 9, 0)",                                           (7, 2)),
    ("fault Y\nrun 20",     "MCCD(CS1, T, 1, 1, 9, 0)",                                           (20, 1)),
    (LINE,                  "MCCD(CS1, T, 0, 1, 9, 0)",                                           (13, 2)),
    ("",                    "MCCD(CS1, T, 1, 1, 9, 0)",                                           (23, 0)),
    ("MCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)\nrun 99\nMCS(CS1, B2, 2, Yes, 50, 0)\nrun 5",
                            "MCCD(CS1, T, 1, 1, 9, 0)",                                           (78, 0)),
    (LINE,                  "MCCD(CS1, T, 1, 1, 9, 0, 1, 500, 4)",                                (94, 0)),
    (LINE,                  "MCCD(CS1, T, 1, 1, 9, 4)",                                           (105, 0)),
    // MCS.
    ("MSF(Y, B1)\nrun 20",  "MCS(CS1, T, 0, 0, 0, 0)",                                            (5, 1)),
    ("MASD(Z, B1)\nrun 20", "MCS(CS1, T, 0, 0, 0, 0)",                                            (7, 2)),
    ("",                    "MCS(CS1, T, 1, 0, 0, 0)",                                            (13, 2)),
    ("",                    "MCS(CS1, T, 0, 1, 9, 4)",                                            (13, 5)),
    ("",                    "MCS(Decel, T, 0, 0, 0, 0)",                                          (54, -1)),
    ("",                    "MCS(AxisDecel, T, 0, 0, 0, 0)",                                      (54, 1)),
    // MCSR: the cause of the fault is still there.
    ("fault Y\nrun 20",     "MCSR(CS1, T)",                                                       (20, 1)),
    // MCT: axes are counted within their system.
    ("MSF(Y, B1)\nrun 20",  "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0])",                             (5, 1)),
    ("MASD(C, B1)\nrun 20", "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0])",                             (7, 2)),
    ("fault Y\nrun 20",     "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0])",                             (20, 1)),
    (HOMING,                "MCT(Homed, XY, T, [0, 0, 0], [0, 0, 0])",                            (16, 1)),
    ("",                    "MCT(Flat, Flat2, T, [0, 0, 0], [0, 0, 1])",                          (13, 4)),
    ("",                    "MCT(CS2, CS3, T, [0, 361, 0], [0, 0, 0])",                           (74, 1)),
    ("",                    "MCT(Decel, XY, T, [0, 0, 0], [0, 0, 0])",                            (54, -1)),
    ("",                    "MCT(AxisDecel, XY, T, [0, 0, 0], [0, 0, 0])",                        (54, 1)),
    ("",                    "MCT(XY, Jerk, T, [0, 0, 0], [0, 0, 0])",                             (76, -1)),
    ("",                    "MCT(XY, AxisJerk, T, [0, 0, 0], [0, 0, 0])",                         (76, 1)),
    ("MAM(C, B1, 0, 90, {rates})\nrun 9", "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0])",               (22, 2)),
    ("",                    "MCT(CS2, CS2, T, [0, 0, 0], [0, 0, 0])",                             (61, 2)),
    ("",                    "MCT(CS2, CS1, T, [0, 0, 0], [0, 0, 0])",                             (61, 7)),
    ("MCLM(SameAxis, B1, 0, [0, 9, 0], {rates}, 1)\nrun 9", "MCT(CS1, CS3, T, [0, 0, 0], [0, 0, 0])", (61, 8)),
    ("",                    "MCT(CS2, Flat, T, [0, 0, 0], [0, 0, 0])",                            (61, 17)),
    (LINK,                  "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0])",                             (62, 0)),
    ("",                    "MCT(CS2, CS3, T, [0, 0, 0], [0, 5, 0])",                             (67, 1)),
    ("",                    "MCT(Arm, Arm2, T, [0, 0, 0], [0, 0, 0])",                            (61, 5)),
    ("",                    "MCT(Tool, NoLinks, T, [0, 0, 0], [0, 0, 0])",                        (61, 9)),
    ("",                    "MCT(Tool, NoRoom, T, [0, 0, 0], [0, 0, 0])",                         (61, 10)),
    ("",                    "MCT(Tool, Folded, T, [0, 0, 0], [0, 0, 0])",                         (68, 0)),
    ("MAM(Q3, B1, 0, 90, {rates})\nMAM(Q2, B2, 0, -45, {rates})\nrun 3000", "MCT(Tool, Arm, T, [0, 0, 0], [0, 0, 0])",          (67, 2)),
    ("",                    "MCT(XY, Round, T, [0, 0, 0], [0, 0, 0])",                            (70, 1)),
    ("MCT(CS2, CS3, B1, [0, 0, 0], [0, 0, 0])\nMAM(S, B2, 0, 90, {rates})\nrun 99\nMCS(CS3, B3, 3, Yes, 50, 0)\nrun 2",
                            "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0])",                             (71, 0)),
    (LINK,                  "MCT(CS1, CS3, T, [0, 0, 0], [0, 0, 0])",                             (73, 0)),
    // MCPM, and operands that its systems do not have.
    ("",                    "MCCM(Pose, T, 0, [9, 0, 0], 1, [9, 0, 0], 2, {rates}, 1)",           (75, 0)),
    ("",                    "MCPM(CS1, T, Way, 1, Pace)",                                         (13, 0)),
    ("",                    "MCPM(Pose, T, NoWay, 1, Pace)",                                      (13, 2)),
    ("",                    "MCPM(Pose, T, Way, 2, Pace)",                                        (13, 3)),
    ("",                    "MCPM(Pose, T, Way, 1, NoPace)",                                      (13, 4)),
    ("",                    "MCPM(Pose, T, Way, 1, Pace, 0, 5)",                                  (13, 6)),
    ("",                    "MCPM(Pose, T, Way, 1, Pace, 0, 1)",                                  (95, 0)),
    ("",                    "MCPM(Pose, T, Way, 1, Driven, 0, 1)",                                (93, 0)),
    ("",                    "MCPM(Pose, T, Point, 1, Pace)",                                      (99, 0)),
    ("",                    "MCPM(PosePrecise, T, Way, 1, Pace)",                                 (99, 0)),
    (OFF,                   "MCPM(Pose, T, Way, 1, Pace)",                                        (5, 0)),
    ("MASD(P6, B1)\nrun 20", "MCPM(Pose, T, Way, 1, Pace)",                                       (7, 5)),
    ("fault Y\nrun 20",     "MCPM(Pose, T, Way, 1, Pace)",                                        (20, 1)),
    (HOMING,                "MCPM(PoseHomed, T, Way, 1, Pace)",                                   (16, 5)),
    ("",                    "MCPM(PoseDecel, T, Way, 1, Pace)",                                   (54, 5)),
    ("",                    "MCPM(PoseJerk, T, Way, 1, Curve)",                                   (76, 5)),
    ("",                    "MCPM(PoseLoose, T, Settling, 1, Pace)",                              (51, 0)),
    ("MCPM(Pose, B1, Way, 1, Pace)\nMCPM(Pose, B2, Way, 1, Pace)", "MCPM(Pose, T, Way, 1, Pace)", (43, 0)),
    (LINE,                  "MCPM(Pose, T, Way, 1, Pace)",                                        (52, 0)),
    ("MCPM(Pose, B1, Way, 1, Pace)\nrun 60\nMCS(Pose, B2, 2, Yes, 1, 1)\nrun 1", "MCPM(Pose, T, Way, 1, Pace)", (78, 0)),
    // MCTO.
    ("",                    "MCTO(Nobody, Wrist, T, Frame, Frame)",                               (13, 0)),
    ("MASD(Z, B1)\nrun 20", "MCTO(TurnXYZ, Wrist, T, Frame, Frame)",                              (7, 2)),
    ("MSF(Y, B1)\nrun 20",  "MCTO(TurnXYZ, Wrist, T, Frame, Frame)",                              (5, 1)),
    (FAULT,                 "MCTO(TurnXYZ, Wrist, T, Frame, Frame)",                              (20, 0)),
    (HOMING,                "MCTO(TurnHome, Wrist, T, Frame, Frame)",                             (16, 5)),
    ("",                    "MCTO(TurnDecel, Wrist, T, Frame, Frame)",                            (54, -1)),
    ("",                    "MCTO(TurnJerk, Wrist, T, Frame, Frame)",                             (76, -1)),
    ("MAM(W6, B1, 0, 90, {rates})\nrun 9", "MCTO(Turn, Wrist, T, Frame, Frame)",                  (22, 5)),
    ("",                    "MCTO(Turn, Turn, T, Frame, Frame)",                                  (61, 2)),
    ("",                    "MCTO(CS2, Wrist, T, Frame, Frame)",                                  (61, 5)),
    ("",                    "MCTO(Turn, Arm, T, Frame, Frame)",                                   (61, 6)),
    ("MCLM(Elbow, B1, 0, [9, 9], {rates}, 1)\nrun 9", "MCTO(Turn, Wrist, T, Frame, Frame)",       (61, 8)),
    ("",                    "MCTO(Turn, WristNoLinks, T, Frame, Frame)",                          (61, 9)),
    ("",                    "MCTO(Turn, WristNoRoom, T, Frame, Frame)",                           (61, 10)),
    (TURNING,               "MCTO(Turn, Wrist, T, Frame, Frame)",                                 (62, 0)),
    ("",                    "MCTO(Turn, WristStretched, T, Frame, Frame)",                        (67, 2)),
    ("",                    "MCTO(Turn, WristStraight, T, Frame, Frame)",                         (68, 0)),
    ("",                    "MCTO(TurnR, Wrist, T, Frame, Frame)",                                (70, 5)),
    ("MCTO(Turn, Wrist, B1, Frame, Frame)\nMAM(W6, B2, 0, 90, {rates})\nrun 99\nMCS(Wrist, B3, 3, Yes, 50, 0)\nrun 2",
                            "MCTO(Turn, Wrist, T, Frame, Frame)",                                 (71, 0)),
    (TURNING,               "MCTO(Turn2, Wrist, T, Frame, Frame)",                                (73, 0)),
    ("",                    "MCTO(Turn, Wrist, T, Frame, Tilted)",                                (74, 4)),
    // MCTPO.
    ("",                    "MCTPO(Turn, Wrist, T, Frame, Frame, 0, [0, 0, 0, 0, 0], Place, Bits, Turns)",          (13, 6)),
    ("",                    "MCTPO(Turn, Turn, T, Frame, Frame, 0, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",        (61, 2)),
    ("",                    "MCTPO(Turn, Wrist, T, Frame, Frame, 1, [300, 0, 0, 0, 90, 0], Place, Bits, Turns)",    (67, 2)),
    ("",                    "MCTPO(Turn, Wrist, T, Frame, Frame, 1, [0, 0, 150, 0, 0, 0], Place, Bits, Turns)",     (68, 0)),
    ("",                    "MCTPO(TurnR, Wrist, T, Frame, Frame, 0, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",      (70, 5)),
    ("",                    "MCTPO(Turn, Wrist, T, Tilted, Frame, 0, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",      (74, 1)),
    ("",                    "MCTPO(Turn, Wrist, T, Frame, Frame, 2, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",       (77, 0)),
    // MCTP.
    ("",                    "MCTP(CS2, CS3, T, [0, 0], [0, 0, 0], 1, [1, 2, 3], 0)",              (13, 3)),
    ("",                    "MCTP(CS2, CS2, T, [0, 0, 0], [0, 0, 0], 1, [1, 2, 3], 0)",           (61, 2)),
    ("",                    "MCTP(Tool, Arm, T, [0, 0, 0], [0, 0, 0], 1, [190, 190, 0], 0)",      (67, 2)),
    ("",                    "MCTP(Tool, Arm, T, [0, 0, 0], [0, 0, 0], 1, [0, 0, 100], 0)",        (68, 0)),
    ("",                    "MCTP(XY, Round, T, [0, 0, 0], [0, 0, 0], 1, [1, 2, 3], 0)",          (70, 1)),
    ("",                    "MCTP(CS2, CS3, T, [0, 361, 0], [0, 0, 0], 1, [1, 2, 3], 0)",         (74, 1)),
    ("",                    "MCTP(CS2, CS3, T, [0, 0, 0], [0, 0, 0], 2, [1, 2, 3], 0)",           (77, 0)),
    // MSO, MSF.
    (DOWN,                  "MSO(X, T)",                                                          (7, 0)),
    ("",                    "MSO(A, T)",                                                          (8, 0)),
    (FAULT,                 "MSO(X, T)",                                                          (20, 0)),
    (JOG,                   "MSO(X, T)",                                                          (22, 0)),
    ("MAJ(X, B1, 0, {rates})\nrun 200\nMSF(X, B2)\nrun 9", "MSO(X, T)",                           (22, 0)),
    ("",                    "MSF(A, T)",                                                          (8, 0)),
    // MAS.
    (OFF,                   "MAS(X, T, All, No, 0, 0)",                                           (5, 0)),
    (DOWN,                  "MAS(X, T, All, No, 0, 0)",                                           (7, 0)),
    ("",                    "MAS(X, T, 99, No, 0, 0)",                                            (13, 2)),
    ("",                    "MAS(X, T, All, Yes, 0, 0)",                                          (13, 4)),
    ("",                    "MAS(NoDecel, T, All, No, 0, 0)",                                     (54, 0)),
    // MAH.
    ("MSF(H, B1)\nrun 20",  "MAH(H, T)",                                                          (5, 0)),
    (DOWN,                  "MAH(X, T)",                                                          (7, 0)),
    (HOMING,                "MAH(H, T)",                                                          (16, 0)),
    (FAULT,                 "MAH(X, T)",                                                          (20, 0)),
    ("",                    "MAH(Torque, T)",                                                     (41, 0)),
    ("",                    "MAH(NoDecel, T)",                                                    (54, 0)),
    (LINK,                  "MAH(A, T)",                                                          (63, 0)),
    (STOP_ALL,              "MAH(X, T)",                                                          (78, 0)),
    ("",                    "MAH(NoSwitch, T)",                                                   (84, 0)),
    ("MRP(X, B1, 0, 0, 5)", "MAH(X, T)",                                                          (85, 0)),
    // MAJ.
    (OFF,                   "MAJ(X, T, 0, {rates})",                                              (5, 0)),
    (DOWN,                  "MAJ(X, T, 0, {rates})",                                              (7, 0)),
    ("",                    "MAJ(L, T, 0, {rates})",                                              (9, 0)),
    ("",                    "MAJ(X, T, 2, {rates})",                                              (13, 2)),
    (HOMING,                "MAJ(H, T, 0, {rates})",                                              (16, 0)),
    (FAULT,                 "MAJ(X, T, 0, {rates})",                                              (20, 0)),
    ("",                    "MAJ(NoDecel, T, 0, {rates})",                                        (54, 0)),
    ("",                    "MAJ(NoJerk, T, 0, {curve})",                                         (76, 0)),
    (STOP_ALL,              "MAJ(X, T, 0, {rates})",                                              (78, 0)),
    ("",                    "MAJ(X, T, 0, 50, 4, 500, 4, 500, 4, 0, 1, 1, 4, 0, 0, 0, 1)",        (93, 0)),
    ("",                    "MAJ(X, T, 0, 50, 0, 500, 4, 500, 0)",                                (94, 0)),
    (JOG_STANDING,          "MAJ(X, T, 0, {driven}, 0, 0, 0, 1)",                                 (97, 0)),
    (JOG_BACKWARDS,         "MAJ(X, T, 0, {driven}, 0, 0, 0, 1)",                                 (98, 0)),
    (JOG_WAITING,           "MAJ(X, T, 0, {driven}, 0, 0, 5, 3)",                                 (102, 0)),
    ("",                    "MAJ(X, T, 0, {rates}, 0, 0, 0, 1)",                                  (95, 0)),
    // MAM.
    (OFF,                   "MAM(X, T, 0, 9, {rates})",                                           (5, 0)),
    (DOWN,                  "MAM(X, T, 0, 9, {rates})",                                           (7, 0)),
    ("",                    "MAM(L, T, 0, 12, {rates})",                                          (9, 0)),
    ("",                    "MAM(X, T, 9, 9, {rates})",                                           (13, 2)),
    ("",                    "MAM(R, T, 2, 360, {rates})",                                         (13, 3)),
    ("",                    "MAM(X, T, 0, 9, 1, 3, 0.75, 3, 0.5, 3, 0, 1, 1, 3)",                 (13, 4)),
    (HOMING,                "MAM(H, T, 0, 9, {rates})",                                           (16, 0)),
    ("",                    "MAM(X, T, 2, 9, {rates})",                                           (17, 0)),
    (FAULT,                 "MAM(X, T, 0, 9, {rates})",                                           (20, 0)),
    ("",                    "MAM(X, T, 5, 9, {rates})",                                           (33, 0)),
    ("",                    "MAM(NoDecel, T, 0, 9, {rates})",                                     (54, 0)),
    ("",                    "MAM(NoJerk, T, 0, 9, {curve})",                                      (76, 0)),
    (STOP_ALL,              "MAM(X, T, 0, 9, {rates})",                                           (78, 0)),
    ("",                    "MAM(X, T, 0, 9, 50, 4, 500, 4, 500, 4, 0, 1, 1, 4, 0, 0, 0, 1)",     (93, 0)),
    ("",                    "MAM(X, T, 0, 9, 50, 0, 500, 4, 500, 0)",                             (94, 0)),
    ("",                    "MAM(X, T, 0, 9, {rates}, 0, 0, 0, 1)",                               (95, 0)),
    (MOVE,                  "MAM(X, T, 0, 9, {driven}, 0, 0, 0, 1)",                              (97, 0)),
    (MOVE_BACKWARDS,        "MAM(X, T, 0, 9, {driven}, 0, 0, 0, 1)",                              (98, 0)),
    ("",                    "MAM(X, T, 0, 9, {rates}, 0, 0, 0, 0, [1])",                          (101, 0)),
    (MOVE_WAITING,          "MAM(X, T, 0, 9, {driven}, 0, 0, 5, 3)",                              (102, 0)),
    (MOVE_SLOW,             "MAM(X, T, 0, 9, {driven}, 0, 0, 0, 1)",                              (103, 0)),
    (JOG,                   "MAM(X, T, 0, 9, 2, 3, 0.5, 3, 0.5, 3, 0, 1, 1, 3)",                  (100, 0)),
    ("",                    "MAM(X, T, 0, 9, 2, 3, 0.5, 3, 0.5, 3, 0, 1, 1, 3, 1, 1)",            (106, 0)),
    // MDCC, MDAC.
    ("",                    "MDCC(CS1, X, T, 1, 0)",                                              (10, 0)),
    ("",                    "MDCC(CS1, A, T, 2, 0)",                                              (13, 3)),
    ("",                    "MDCC(CS1, A, T, 1, -1)",                                             (13, 4)),
    ("MDCC(CS1, A, B2, 1, 0)\nMCLM(CS1, B1, 0, [300, 0, 0], {rates}, 1)", "MDCC(CS1, A, T, 0, 0)", (105, 0)),
    ("",                    "MDAC(X, X, T, 0, 1)",                                                (10, 0)),
    ("",                    "MDAC(X, A, T, 5, 1)",                                                (13, 3)),
    ("",                    "MDAC(X, A, T, 0, 2)",                                                (13, 4)),
    ("MDAC(X, A, B1, 1, 1)", "MDAC(X, A, T, 0, 1)",                                               (96, 0)),
    ("MDAC(X, A, B2, 0, 1)\nMAJ(X, B1, 0, {driven}, 0, 0, 0, 1)", "MDAC(X, A, T, 0, 0)",          (105, 0)),
    // MAG.
    (OFF,                   "MAG(X, Y, T, 0, 1, 1, 1, 1, 0, 1)",                                  (5, 0)),
    (DOWN,                  "MAG(X, Y, T, 0, 1, 1, 1, 1, 0, 1)",                                  (7, 0)),
    ("",                    "MAG(X, X, T, 0, 1, 1, 1, 1, 0, 1)",                                  (10, 0)),
    ("",                    "MAG(X, Y, T, 4, 1, 1, 1, 1, 0, 1)",                                  (13, 3)),
    ("",                    "MAG(X, Y, T, 0, 0, 1, 1, 1, 0, 1)",                                  (13, 4)),
    (HOMING,                "MAG(H, Y, T, 0, 1, 1, 1, 1, 0, 1)",                                  (16, 0)),
    (FAULT,                 "MAG(X, Y, T, 0, 1, 1, 1, 1, 0, 1)",                                  (20, 0)),
    ("",                    "MAG(X, Y, T, 2, 1, 1, 1, 1, 0, 1)",                                  (23, 0)),
    ("",                    "MAG(NoDecel, Y, T, 0, 1, 1, 1, 1, 0, 1)",                            (54, 0)),
    (STOP_ALL,              "MAG(X, Y, T, 0, 1, 1, 1, 1, 0, 1)",                                  (78, 0)),
    // An encoder.
    ("",                    "MAM(E, T, 0, 9, {rates})",                                           (8, 0)),
    ("",                    "MAJ(E, T, 0, {rates})",                                              (8, 0)),
    ("",                    "MAG(E, Y, T, 0, 1, 1, 1, 1, 0, 1)",                                  (8, 0)),
    ("",                    "MCD(E, T, Jog, Yes, 5)",                                             (8, 0)),
    ("",                    "MAPC(E, Y, T, 0, Empty, 1, 1)",                                      (8, 0)),
    ("",                    "MATC(E, T, 0, Empty, 1, 1)",                                         (8, 0)),
    // MAW, MAR, MDR.
    (DOWN,                  "MAW(X, T, 0, 5)",                                                    (7, 0)),
    ("",                    "MAW(X, T, 2, 5)",                                                    (13, 2)),
    ("",                    "MAW(R, T, 0, 360)",                                                  (13, 3)),
    ("MAW(X, B1, 0, 5)",    "MAW(X, T, 0, 5)",                                                    (3, 0)),
    ("MASD(E, B1)\nrun 20", "MAR(E, T, 0, 0, 0, 0, 1)",                                           (7, 0)),
    ("",                    "MAR(E, T, 0, 1, 5, 4, 1)",                                           (13, 4)),
    ("MAR(E, B1, 0, 0, 0, 0, 1)", "MAR(E, T, 0, 0, 0, 0, 1)",                                     (34, 0)),
    ("",                    "MAR(X, T, 0, 0, 0, 0, 1)",                                           (75, 0)),
    ("",                    "MDR(E, T, 0)",                                                       (13, 2)),
    ("",                    "MDR(X, T, 1)",                                                       (75, 0)),
    // MCCP, MCSV.
    ("",                    "MCCP(T, Cam, 3e9, 0, 0, Profile)",                                   (13, 2)),
    ("",                    "MCCP(T, Cam, 5, 0, 0, Profile)",                                     (26, 0)),
    ("",                    "MCCP(T, Cam, 3, 0, 0, Profile)",                                     (27, 0)),
    ("",                    "MCCP(T, NoType, 2, 0, 0, Profile)",                                  (28, 1)),
    ("",                    "MCCP(T, NoOrder, 2, 0, 0, Profile)",                                 (29, 1)),
    (CAMMING,               "MCCP(T, Cam, 2, 0, 0, Profile)",                                     (31, 0)),
    (CAM,                   "MCSV(T, Profile, 6)",                                                (13, 2)),
    ("",                    "MCSV(T, Empty, 0)",                                                  (32, 0)),
    // MAPC, MATC.
    (OFF,                   "MAPC(X, Y, T, 0, Empty, 1, 1)",                                      (5, 0)),
    (DOWN,                  "MAPC(X, Y, T, 0, Empty, 1, 1)",                                      (7, 0)),
    ("",                    "MAPC(X, X, T, 0, Empty, 1, 1)",                                      (10, 0)),
    ("",                    "MAPC(X, Y, T, 4, Empty, 1, 1)",                                      (13, 3)),
    ("",                    "MAPC(X, R, T, 0, Empty, 1, 1, 0, 2, 360)",                           (13, 9)),
    (CAM,                   "MAPC(X, Y, T, 0, Profile, 1, 1, 0, 0, 0, 6)",                        (13, 10)),
    (HOMING,                "MAPC(H, Y, T, 0, Empty, 1, 1)",                                      (16, 0)),
    (FAULT,                 "MAPC(X, Y, T, 0, Empty, 1, 1)",                                      (20, 0)),
    (CAMMING,               "MAPC(X, Y, T, 0, Profile, 1, 1)",                                    (23, 0)),
    ("",                    "MAPC(X, Y, T, 0, Empty, 1, 1)",                                      (32, 0)),
    ("",                    "MAPC(NoDecel, Y, T, 0, Empty, 1, 1)",                                (54, 0)),
    (STOP_ALL,              "MAPC(X, Y, T, 0, Empty, 1, 1)",                                      (78, 0)),
    (OFF,                   "MATC(X, T, 0, Empty, 1, 1)",                                         (5, 0)),
    (DOWN,                  "MATC(X, T, 0, Empty, 1, 1)",                                         (7, 0)),
    ("",                    "MATC(X, T, 0, Empty, 1, 0)",                                         (13, 5)),
    (HOMING,                "MATC(H, T, 0, Empty, 1, 1)",                                         (16, 0)),
    (FAULT,                 "MATC(X, T, 0, Empty, 1, 1)",                                         (20, 0)),
    (CAMMING,               "MATC(X, T, 0, Profile, 1, 1)",                                       (23, 0)),
    ("",                    "MATC(X, T, 0, Empty, 1, 1)",                                         (32, 0)),
    ("",                    "MATC(NoDecel, T, 0, Empty, 1, 1)",                                   (54, 0)),
    (STOP_ALL,              "MATC(X, T, 0, Empty, 1, 1)",                                         (78, 0)),
    ("MCCP(B9, Cam, 2, 0, 0, Profile)\nMATC(X, B1, 0, Profile, 9, 1)\nrun 20\nMAS(X, B2, TimeCam, Yes, 1, 0)\nrun 2",
                            "MATC(X, T, 0, Profile, 1, 1)",                                       (78, 0)),
    ("",                    "MATC(X, T, 0, Empty, 1, 1, 0, 0, 0, 1, 1)",                          (93, 0)),
    ("",                    "MATC(X, T, 0, Empty, 1, 1, 0, 0, 0, 1, 0)",                          (95, 0)),
    ("MCCP(B9, Cam, 2, 0, 0, Profile)\nMDAC(X, Y, B1, TimeCam, Command)\nMATC(X, B2, 0, Profile, 1, 1, 0, 0, 0, 1, 1)",
                            "MATC(X, T, 0, Profile, 1, 1, 0, 1, 0, 2, 1)",                        (98, 0)),
    // MCD.
    (OFF,                   "MCD(X, T, Jog, Yes, 5)",                                             (5, 0)),
    (DOWN,                  "MCD(X, T, Jog, Yes, 5)",                                             (7, 0)),
    (JOG,                   "MCD(X, T, 2, Yes, 5)",                                               (13, 2)),
    (HOMING,                "MCD(H, T, Jog, Yes, 5)",                                             (16, 0)),
    (FAULT,                 "MCD(X, T, Jog, Yes, 5)",                                             (20, 0)),
    ("",                    "MCD(X, T, Jog, Yes, 5)",                                             (23, 0)),
    ("",                    "MCD(NoDecel, T, Jog, Yes, 5)",                                       (54, 0)),
    (STOP_ALL,              "MCD(X, T, Jog, Yes, 5)",                                             (78, 0)),
    ("MAJ(X, B1, 0, {rates})\nrun 99\nMAS(X, B2, Jog, Yes, 50, 0)\nrun 2", "MCD(X, T, Jog, Yes, 5)", (78, 0)),
    (JOG,                   "MCD(X, T, Jog, Yes, 5, Yes, 5, 0, 0, 0, 0, 0, 0, 0, 4)",             (94, 0)),
    (JOG,                   "MCD(X, T, Jog, Yes, 5, 0, 0, 0, 0, 0, 0, 0, 0, 4)",                  (105, 0)),
    // MRP.
    (DOWN,                  "MRP(X, T, 0, 0, 5)",                                                 (7, 0)),
    ("",                    "MRP(X, T, 2, 0, 5)",                                                 (13, 2)),
    ("",                    "MRP(R, T, 0, 0, 360)",                                               (13, 4)),
    (HOMING,                "MRP(H, T, 0, 0, 5)",                                                 (16, 0)),
    (LINK,                  "MRP(A, T, 0, 0, 5)",                                                 (63, 0)),
    ("MRP(X, B1, 0, 0, 5)", "MRP(X, T, 0, 0, 5)",                                                 (85, 0)),
    // MAOC, MDOC.
    ("MASD(R, B1)",         "MAOC(R, 0, T, Out, 0, Outs, 0, 100)",                                (7, 0)),
    ("",                    "MAOC(R, 0, T, Out, 0, Outs, 5, 5)",                                  (13, 7)),
    ("",                    "MAOC(R, 1, T, Out, 0, Outs, 0, 100)",                                (35, 0)),
    ("",                    "MAOC(R, 0, T, Out, 0, NoOuts, 0, 100)",                              (36, 1)),
    ("",                    "MAOC(R, 0, T, Out, 0, Outs, 0, 100, NoComp)",                        (37, 0)),
    ("",                    "MDOC(R, 0, T, 2)",                                                   (13, 3)),
    ("",                    "MDOC(X, 0, T, Specific)",                                            (35, 0)),
    // The group.
    ("",                    "MGS(Motion, T, 3)",                                                  (13, 2)),
    (FAULT,                 "MGSR(Motion, T)",                                                    (81, 0)),
];

/// A call of every instruction that is executed; nothing keeps it from being done. Its tag is busy: 3.
#[rustfmt::skip]
const GOOD: &[&str] = &[
    "MCLM(CS1, T, 0, [5, 5, 5], {rates}, 1)", "MCCM(XY, T, 0, [0, 0], 1, [9, 0], 2, {rates}, 1)", "MCS(CS1, T, 0, 0, 0, 0)",
    "MDCC(CS1, A, T, 1, 0)", "MDAC(X, A, T, 0, 1)", "MCSD(CS1, T)", "MCSR(CS1, T)", "MCT(CS2, CS3, T, [0, 0, 0], [0, 0, 0])",
    "MCTP(CS2, CS3, T, [0, 0, 0], [0, 0, 0], 1, [1, 2, 3], 0)",
    "MCTO(Turn, Wrist, T, Frame, Frame)", "MCTPO(Turn, Wrist, T, Frame, Frame, 0, [0, 0, 0, 0, 0, 0], Place, Bits, Turns)",
    "MSO(X, T)", "MSF(X, T)", "MASD(X, T)", "MASR(X, T)", "MAFR(X, T)", "MAS(X, T, All, No, 0, 0)", "MAH(X, T)",
    "MAJ(X, T, 0, {rates})", "MAM(X, T, 0, 9, {rates})", "MAG(X, Y, T, 0, 1, 1, 1, 1, 0, 1)", "MRP(X, T, 0, 0, 5)",
    "MCPM(Pose, T, Way, 1, Pace)", "MGS(Motion, T, 1)", "MGSD(Motion, T)", "MGSR(Motion, T)", "MGSP(Motion, T)", "MCCP(T, Cam, 2, 0, 0, Profile)",
    "MAOC(R, 0, T, Out, 0, Outs, 0, 100)", "MDOC(R, 0, T, 0)", "MAW(X, T, 0, 5)", "MDW(X, T)", "MAR(E, T, 0, 0, 0, 0, 2)", "MDR(E, T, 1)",
];

/// A good call of each instruction that needs motion, with the call that begins the motion.
const GOOD_MOVING: &[(&str, &str)] = &[
    (LINE, "MCCD(CS1, T, 1, 1, 9, 0)"),
    (JOG, "MCD(X, T, Jog, Yes, 5)"),
    (CAM, "MCSV(T, Profile, 1)"),
    (CAM, "MAPC(X, Y, T, 0, Profile, 1, 1)"),
    (CAM, "MATC(X, T, 0, Profile, 1, 1)"),
];

/// The errors of an instruction by the specification: its own list if it has one, otherwise the checks of its order that
/// concern it. Coordinated instructions: spec/coordinated-instructions.md §11, §14 to §17, §19.6; others:
/// spec/axis-and-data-types.md §1.7, §2, §3, §4.
#[rustfmt::skip]
const LISTS: &[(&str, &[i16])] = &[
    ("MCLM", &[3, 24, 50, 19, 13, 94, 95, 93, 101, 11, 8, 38, 53, 7, 5, 20, 16, 14, 15, 54, 76, 51, 43, 78, 52, 97, 98, 102, 103,
               105, 9, 99, 67, 68, 72]),
    ("MCCM", &[3, 24, 50, 19, 13, 94, 95, 93, 101, 11, 8, 38, 53, 7, 5, 20, 16, 14, 15, 54, 76, 51, 25, 44, 45, 46, 49, 43, 78, 52, 97,
               98, 102, 103, 105, 9, 99, 67, 68, 72, 75]),
    ("MCCD", &[3, 24, 50, 19, 13, 94, 105, 11, 8, 38, 53, 7, 5, 20, 23, 78, 103]),
    ("MCS",  &[3, 24, 50, 19, 13, 11, 8, 38, 53, 7, 5, 54, 76]),
    ("MCSD", &[3, 11, 50, 12]),
    ("MCSR", &[3, 11, 50, 12, 20]),
    ("MCT",  &[3, 24, 50, 19, 13, 11, 7, 5, 20, 16, 22, 54, 76, 61, 62, 64, 66, 67, 68, 70, 71, 73, 74, 77, 99, 69, 72]),
    // A master driven move cannot merge: 97 and 103 are impossible.
    ("MCPM", &[3, 24, 50, 19, 13, 95, 93, 11, 8, 38, 53, 7, 5, 20, 16, 14, 15, 54, 76, 51, 43, 78, 52, 99]),
    ("MCTO", &[3, 24, 50, 19, 13, 11, 7, 5, 20, 16, 22, 54, 76, 61, 62, 64, 66, 67, 68, 70, 71, 73, 74, 77, 99, 69, 72]),
    ("MDCC", &[3, 24, 50, 19, 13, 11, 10, 105]),
    ("MDAC", &[3, 24, 19, 13, 11, 10, 96, 105]),
    ("MCTP", &[3, 13, 61, 67, 68, 70, 74, 77]),
    ("MCTPO", &[3, 13, 61, 67, 68, 70, 74, 77, 99]),
    ("MSO",  &[3, 24, 19, 7, 8, 11, 12, 20, 22, 53]),
    ("MSF",  &[3, 24, 19, 8, 11, 53]),
    ("MASD", &[3, 19, 11]),
    ("MASR", &[3, 19, 11]),
    ("MAFR", &[3, 19, 11]),
    ("MAS",  &[3, 5, 7, 8, 11, 13, 19, 20, 24, 38, 54, 76, 78]),
    ("MAH",  &[3, 5, 7, 8, 11, 12, 13, 16, 19, 20, 22, 24, 38, 39, 41, 54, 63, 78, 84, 85]),
    ("MAJ",  &[3, 24, 19, 13, 94, 95, 93, 11, 8, 38, 53, 21, 7, 5, 20, 16, 14, 15, 87, 54, 76, 78, 97, 98, 102, 105, 9]),
    ("MAM",  &[3, 24, 19, 13, 94, 100, 106, 95, 93, 101, 11, 8, 38, 53, 21, 7, 5, 20, 16, 14, 15, 87, 54, 76, 17, 33, 78, 97, 98, 102,
               103, 105, 9, 99]),
    ("MAG",  &[3, 24, 19, 13, 11, 8, 38, 53, 21, 7, 5, 20, 16, 14, 15, 87, 54, 10, 23, 78]),
    ("MCCP", &[3, 13, 26, 27, 28, 29, 30, 31]),
    ("MCSV", &[3, 13, 30, 32]),
    ("MAW",  &[3, 24, 19, 13, 11, 38, 53, 7]),
    ("MDW",  &[3, 24, 19, 11, 38, 53]),
    ("MAR",  &[3, 24, 19, 13, 11, 38, 53, 7, 34, 39, 75]),
    ("MDR",  &[3, 24, 19, 13, 11, 38, 53, 75]),
    ("MAPC", &[3, 24, 19, 13, 11, 8, 38, 53, 21, 7, 5, 20, 16, 14, 15, 87, 54, 10, 23, 30, 32, 78]),
    ("MATC", &[3, 24, 19, 13, 93, 95, 98, 11, 8, 38, 53, 21, 7, 5, 20, 16, 14, 15, 87, 54, 23, 30, 32, 78]),
    ("MAOC", &[3, 24, 19, 13, 11, 38, 53, 7, 35, 36, 37]),
    ("MDOC", &[3, 24, 19, 13, 11, 38, 53, 35]),
    ("MCD",  &[3, 24, 19, 13, 94, 105, 11, 8, 38, 53, 21, 7, 5, 20, 16, 54, 76, 23, 78, 103]),
    ("MRP",  &[3, 7, 8, 11, 12, 13, 16, 19, 24, 63, 85]),
    ("MGS",  &[3, 19, 21, 24, 13]),
    ("MGSD", &[3, 21, 24]),
    ("MGSR", &[3, 19, 21, 24, 81]),
    ("MGSP", &[3, 19, 21, 24]),
];

/// Codes that no instruction raises here, with the reason.
#[rustfmt::skip]
const NEVER: &[(i16, &str)] = &[
    (11,  "a configuration with an axis that does not exist, or without drive, is not valid"),
    (12,  "a simulated drive accepts every message"),
    (14,  "there is no tuning"),
    (15,  "there is no hookup test"),
    (19,  "the group is synchronized before the first instruction is executed"),
    (21,  "the group itself has no fault that could be"),
    (24,  "the controller is always in Run"),
    (30,  "a bench calculates at once; the tags' own tests see it"),
    (38,  "every axis type that there is can be moved"),
    (39,  "the newer codes 16, 63 and 85 tell which process it is"),
    (50,  "every coordinate system is in the one group, by the configuration"),
    (53,  "no axis can be inhibited"),
    (64,  "Cartesian systems have no ancillary axes"),
    (66,  "the arm keeps its solution: the way round to another one leads through a singularity, which 67 tells"),
    (79,  "a coordinate system without a contour has no contour's queue"),
    (87,  "there is no direct control"),
];

/// Codes that an instruction does not raise here although its list has them.
#[rustfmt::skip]
const NEVER_HERE: &[(&str, i16, &str)] = &[
    ("MCLM", 8,   "every axis type can be moved"),
    ("MCCM", 8,   "every axis type can be moved"),
    ("MCCD", 8,   "every axis type can be moved"),
    ("MCS",  8,   "every axis type can be moved"),
    ("MCPM", 8,   "every axis type can be moved"),
    ("MAS",  8,   "an encoder has no servo: 5 tells"),
    ("MAH",  8,   "every axis type can be homed"),
    ("MRP",  8,   "every axis type has a position"),
    ("MCLM", 105, "when it is to begin, not when it is executed: masters"),
    ("MCCM", 105, "when it is to begin, not when it is executed: masters"),
    ("MAJ",  105, "nothing waits on an axis: a move begins in its own mode"),
    ("MAM",  105, "nothing waits on an axis: a move begins in its own mode"),
    ("MAM",  99,  "all of it is executed"),
    ("MCCD", 103, "what is slowed down too much overshoots"),
    ("MCD",  103, "what is slowed down too much overshoots"),
    ("MCS",  76,  "no S-curve was started that this stop would need"),
    ("MAS",  76,  "no S-curve was started that this stop would need"),
    ("MCD",  76,  "no S-curve was started that could be changed"),
    ("MAS",  20,  "a stop works on a faulted axis, as the state matrix says"),
    ("MAS",  78,  "a stop of everything supersedes the one before it"),
    ("MAH",  13,  "it has no operand with a range"),
    ("MAH",  22,  "an immediate home of a moving axis brakes it"),
    ("MCT",  77,  "it has no direction"),
    ("MCT",  99,  "what can be configured can be linked"),
    ("MCTO", 77,  "it has no direction"),
    ("MCTO", 99,  "what can be configured can be linked"),
    ("MCTO", 72,  "joints with a wrist turn on; what a joint's soft travel forbids is refused to the move"),
    ("MCTPO", 99, "what can be configured can be calculated"),
];

fn filled(text: &str) -> String {
    text.replace("{rates}", RATES)
        .replace("{driven}", DRIVEN)
        .replace("{curve}", CURVE)
}

fn prepared(machine: &str, steps: &str) -> Bench {
    let mut bench = Bench::with(machine);
    for step in steps.lines() {
        if let Some(ticks) = step.strip_prefix("run ") {
            bench.run(ticks.parse().expect("ticks"));
        } else if let Some(axis) = step.strip_prefix("fault ") {
            bench.inject(axis, &[FaultKind::Drive]);
        } else {
            let step = filled(step);
            assert_eq!(bench.call(&step), OK, "{step}");
        }
    }
    bench
}

/// The earlier steps as in the table, and the error with which a transform `B1` has ended by itself.
const LATER: &[(&str, (i16, i8))] = &[
    // The first joint would have to turn too fast.
    (
        "MCT(Tool, Arm, B1, [0, 0, 0], [0, 0, 0])\nMCLM(Tool, B2, 0, [60, 10, 100], {rates}, 1)\nrun 3000\n\
         MCLM(Tool, B2, 0, [-60, 10, 100], {rates}, 1)\nrun 3000",
        (69, 0),
    ),
    // The tool would have to turn too fast.
    (
        "MCTO(Turn, Wrist, B1, Frame, Frame)\nMAM(O4, B2, 1, 60, 400, 0, 5000, 0, 5000, 0, 0, 100, 100, 2)\nrun 3000",
        (69, 3),
    ),
    // Round the base, beyond half a turn.
    (
        "MCT(Tool, Arm, B1, [0, 0, 0], [0, 0, 0])\nMCLM(Tool, B2, 0, [-80, 90, 100], {rates}, 1)\nrun 9000\n\
         MAJ(P2, B2, 1, {rates})\nrun 9000",
        (72, 0),
    ),
];

fn mnemonic(call: &str) -> &str {
    call.split('(').next().unwrap_or_default()
}

#[test]
fn every_code_that_can_be_raised_is_raised() {
    let machine = machine();
    let mut wrong = Vec::new();
    let mut raised: BTreeSet<(String, i16)> = BTreeSet::new();
    for (before, call, expected) in TABLE {
        let mut bench = prepared(&machine, before);
        let call = filled(call);
        let found = bench.call(&call);
        if found != *expected {
            wrong.push(format!("{call}: {found:?}, expected {expected:?}, after\n{before}"));
        }
        if !bench.bits("T").starts_with("EN ER") {
            wrong.push(format!("{call} shows {}", bench.bits("T")));
        }
        raised.insert((mnemonic(&call).to_owned(), found.0));
    }
    let moving = GOOD_MOVING.iter().copied();
    for (before, call) in GOOD.iter().map(|call| ("", *call)).chain(moving) {
        let call = filled(call);
        // A message that is under way keeps its tag.
        let busy = format!("{before}\nMASR(Z, T)");
        let found = prepared(&machine, busy.trim_start()).call(&call);
        if found != (3, 0) {
            wrong.push(format!("{call} on a busy tag: {found:?}"));
        }
        let found = prepared(&machine, before).call(&call);
        if found != OK {
            wrong.push(format!("{call}: {found:?}, expected to be done"));
        }
        raised.insert((mnemonic(&call).to_owned(), 3));
    }
    for (before, expected) in LATER {
        let shown = prepared(&machine, before).control("B1");
        if (shown.err, shown.exerr) != *expected || shown.has(Flag::Ip) {
            wrong.push(format!("{shown:?}, expected {expected:?}, after\n{before}"));
        }
        raised.insert((mnemonic(before).to_owned(), shown.err));
    }
    for (instruction, list) in LISTS {
        for code in *list {
            let is_raised = raised.contains(&((*instruction).to_owned(), *code));
            let never = NEVER.iter().any(|(never, _)| never == code)
                || NEVER_HERE
                    .iter()
                    .any(|(of, never, _)| (of, never) == (instruction, code));
            if is_raised == never {
                wrong.push(format!(
                    "{instruction} {code}: raised {is_raised}, said never to be raised {never}"
                ));
            }
        }
        for (_, code) in raised.iter().filter(|(of, _)| of == instruction) {
            if !list.contains(code) {
                wrong.push(format!("{instruction} raises {code}, which its list does not have"));
            }
        }
    }
    wrong.extend(constructed_in_sources(&raised));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The errors that `crates/motion` constructs and the table does not raise: in the file of an instruction, by this instruction;
/// in other files, by any.
fn constructed_in_sources(raised: &BTreeSet<(String, i16)>) -> Vec<String> {
    let mut wrong = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/motion/src");
    let mut files = 0;
    let mut folders = vec![root];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("the sources are there") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            files += 1;
            let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
            let own = stem.to_ascii_uppercase();
            let own = LISTS.iter().any(|(instruction, _)| *instruction == own).then_some(own);
            let text = fs::read_to_string(&path).expect("a source");
            for code in constructed(&text) {
                let found = raised
                    .iter()
                    .any(|(of, raised)| *raised == code && own.as_ref().is_none_or(|own| own == of));
                if !found && !NEVER.iter().any(|(never, _)| *never == code) {
                    wrong.push(format!("{stem}.rs constructs {code}, and no row raises it"));
                }
            }
        }
    }
    assert!(files > 40, "the sources of crates/motion");
    wrong
}

/// The codes of `MotionError::…` in a source.
fn constructed(text: &str) -> BTreeSet<i16> {
    let variant = |text: &str| {
        let end = text.find(|c: char| !c.is_alphanumeric()).unwrap_or(text.len());
        text[..end].to_owned()
    };
    let code = |name: &str| {
        (0..200).find(|err| {
            let error = MotionError::from_codes(*err, 0);
            error.is_some_and(|error| variant(&format!("{error:?}")) == name)
        })
    };
    text.match_indices("MotionError::")
        .filter_map(|(at, found)| code(&variant(&text[at + found.len()..])))
        .collect()
}

#[test]
fn every_executed_instruction_is_in_the_table() {
    for mnemonic in Mnemonic::ALL {
        let listed = LISTS.iter().any(|(name, _)| *name == mnemonic.name());
        let text =
            fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/motion/src/instructions/mod.rs"))
                .expect("the instructions");
        let arm = format!("Mnemonic::{mnemonic:?} => ");
        assert_eq!(text.contains(&arm), listed, "{mnemonic}");
    }
}

/// DN comes as the timing of the catalogue says, and IP with it (spec/axis-and-data-types.md §1.1).
#[test]
fn dn_comes_when_the_catalogue_says() {
    let machine = machine();
    // A servo that is on already, and a position that is home already, are done at once.
    let instead = [("MSO(X, T)", (OFF, "MSO(X, T)")), ("MAH(X, T)", ("", "MAH(H, T)"))];
    let instead = |call: &'static str| instead.iter().find(|(other, _)| *other == call).map(|(_, good)| *good);
    let good = GOOD.iter().map(|call| instead(call).unwrap_or(("", *call)));
    let mut seen = BTreeSet::new();
    for (steps, call) in good.chain(GOOD_MOVING.iter().copied()) {
        let timing = mnemonic(call).parse::<Mnemonic>().expect(call).instruction().timing;
        let mut bench = prepared(&machine, steps);
        let shown = bench.execute(&filled(call));
        bench.tick();
        let later = bench.control("T");
        let (at_once, in_process) = (shown.has(Flag::Dn), shown.has(Flag::Ip));
        let as_listed = match timing {
            Timing::Immediate => at_once,
            Timing::Message => !at_once && !in_process && later.has(Flag::Dn),
            // A stop of nothing is complete at once.
            Timing::Process => at_once && (in_process || shown.has(Flag::Pc)),
            Timing::MessageProcess => !at_once && in_process,
        };
        assert!(
            as_listed && !shown.has(Flag::Er),
            "{call}: {timing:?}, but {shown:?}, then {later:?}"
        );
        seen.insert(mnemonic(call));
    }
    assert_eq!(seen.len(), Mnemonic::ALL.len());
}

/// Every instruction takes its operands apart by a pattern without `..`, so that the compiler finds an operand that no code
/// reads.
#[test]
fn every_operand_is_read_by_its_instruction() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates");
    for mnemonic in Mnemonic::ALL
        .iter()
        .filter(|mnemonic| mnemonic.instruction().operands_behind_control().count() > 0)
    {
        let file = format!("motion/src/instructions/{}.rs", mnemonic.name().to_lowercase());
        let pattern = format!("let {mnemonic:?} {{");
        let taken_apart = [file.as_str(), "controller/src/image/cams.rs"].iter().any(|file| {
            let text = fs::read_to_string(folder.join(file)).expect("a source");
            let patterns = text.split(&pattern).skip(1);
            patterns
                .filter_map(|rest| rest.split('}').next())
                .any(|fields| !fields.contains(".."))
        });
        assert!(taken_apart, "{mnemonic}");
    }
}

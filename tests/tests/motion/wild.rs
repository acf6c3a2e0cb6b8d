//! Wild operands never move: every number of every instruction takes values that are none, that overflow, or that nothing can be
//! built with, alone and in pairs, from rest and in motion. With all accepted calls the axes stay finite, and no axis jumps.
//!
//! `ARCLINE_CASES` sets the number of random sequences of pairs (150 by default).

use arcline_instruction_set::{Kind, Mnemonic};
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::CAM_TAGS;
use arcline_tests::random::{Random, one_or_all};
use arcline_tests::robots::{PATH_TAGS, SIX_AXES};

/// A machine of the scan.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Of {
    /// The default machine, with a cam and output cams.
    Axes,
    /// A robot of six joints behind X, Y, Z, Rx, Ry, Rz.
    Robot,
}

/// Calls and, in front of them, values of the tags that they read, separated by semicolons. Numbers in braces are those of a good
/// program. In `<` and `>` stand speeds, rates, jerks and scalings, which a program may make as high as it likes; the axis then goes as
/// fast as that.
const CALLS: &[&str] = &[
    "MCLM(XY, W, {0}, [{9},{5}], <50>, 0, <500>, 0, <500>, 0, {1}, <90>, <90>, 2, {1}, 0, 0, {0}, {0}, 0)",
    "MCLM(XY, W, 1, [{9},{5}], <50>, 0, <500>, 0, <500>, 0, 1, <9000>, <9000>, 0, 5, 1, {1}, {0}, {0}, 0, [{3}], Answer1)",
    "MCLM(XY, W, 0, [{9},{5}], <50>, 1, <50>, 1, <50>, 1, 0, <50>, <50>, 1, 6, {0}, 0, {2}, 0, 0)",
    "MCLM(CS1, W, 0, [{9},{5},{1}], <50>, 0, <500>, 0, <500>, 0, 0, 100, 100, 2, 6, 2, 0, {2}, 0, 0)",
    "MCCM(XY, W, 0, [{10},{0}], 1, [{5},{0}], {1}, <50>, 0, <500>, 0, <500>, 0, 1, <90>, <90>, 2, 1, 0, 0, {0}, 0, 0)",
    "MCCM(XY, W, 1, [{10},{0}], 0, [{5},{5}], 2, <50>, 0, <500>, 0, <500>, 0, 0, 100, 100, 2, 1, 1, 0, {0}, 0, 0)",
    "MCCM(XY, W, 1, [{10},{0}], 2, [{6}], {3}, <50>, 0, <500>, 0, <500>, 0, 0, 100, 100, 2, 4, 0, 0, {0}, 0, 0)",
    "MCCM(CS1, W, 0, [{10},{0},{3}], 3, [{5},{0},{1}], 2, <50>, 0, <500>, 0, <500>, 0, 0, 100, 100, 2, 3, 0, 0, 0, 0, 0)",
    "MCCD(XY, W, 1, 1, <80>, 0, 1, <300>, 0, 1, <300>, 0, 1, <90>, 1, <90>, 2, {1})",
    "MCS(XY, W, {2}, 1, <300>, 0, 1, <90>, 2)",
    "MCS(XY, W, 0, 1, <300>, 0, 1, <9000>, 0)",
    "MAM(X, W, {0}, {12}, <50>, 0, <500>, 0, <500>, 0, {1}, <90>, <90>, 2, 0, 0, {0}, 0)",
    "MAM(X, W, 1, {12}, <50>, 0, <500>, 0, <500>, 0, 0, 100, 100, 2, 1, 1, {0}, 0, [{3}], Answer1)",
    "MAM(Z, W, 1, {12}, <2>, 3, <1>, 3, <1>, 3, 0, 100, 100, 2, 0, 0, 0, 0)",
    "MAJ(X, W, {0}, <50>, 0, <500>, 0, <500>, 0, 1, <90>, <90>, 2, 0, 0, {0}, 0)",
    "MCD(X, W, 0, 1, <80>, 1, <300>, 1, <300>, 1, <90>, 1, <90>, 0, 0, 0, 2)",
    "MAS(X, W, {0}, 1, <300>, 0, 1, <90>, 2)",
    "MRP(X, W, 0, {0}, {5})",
    "MRP(X, W, 1, {1}, {5})",
    "MAG(Y, X, W, 0, {0.5}, {1}, {2}, 1, {0}, {0}, <500>, 0)",
    "MAPC(Y, X, W, 0, Profile[0], <1>, <1>, {1}, {0}, {3}, {1}, 1, {0})",
    "MATC(Y, W, 0, Profile[0], <1>, <1>, {1}, {0}, {0}, 0, 0)",
    "MCT(CS1, CS3, W, [{10},{20},{30}], [{1},{2},{3}])",
    "MDCC(XY, A, W, 1, {10})",
    "MAW(X, W, 1, {20})",
    "MAR(X, W, 1, 1, {5}, {9}, {1})",
    "MCCP(W, Cam, {2}, {0}, {0}, Profile[0])",
    "MCSV(W, Profile[0], {2}, Answer1, Answer2, Answer3)",
    "MCTP(CS1, CS3, W, [{10},{20},{30}], [{1},{2},{3}], {0}, [{1},{2},{3}], Answer4)",
    "MDAC(Y, Z, L, {0}, {1}); MAM(Y, W, 1, {12}, <2>, 4, <1>, 4, <1>, 4, 0, 100, 100, 6, 0, 0, {1}, 1)",
    "MDAC(Y, Z, L, 0, 1); MAM(Y, W, 1, 12, <20>, 7, <2>, 7, <2>, 7, 0, <1>, <1>, 7, 0, 0, {1}, 1)",
    "MDAC(Y, Z, L, 0, 1); MAJ(Y, W, {0}, <2>, 4, <1>, 4, <1>, 4, 0, 100, 100, 6, 0, 0, {1}, 1)",
    "MDCC(XY, Z, L, 1, {20}); MCLM(XY, W, 1, [{9},{5}], <2>, 4, <1>, 4, <1>, 4, 0, 100, 100, 6, 0, 0, 0, 0, {1}, 1)",
    "MAOC(X, {0}, W, Out, 0, Mark, {0}, {50}, 0, {1}, {2}, {3}, {4}, {1})",
    "MAOC(X, 1, W, Out, In, Mark, 0, {50}, Comp, 2, 0, {0}, {0}, 1)",
    "Mark.OutputBit := {3}; Mark.LatchType := {1}; Mark.UnlatchType := {2}; Mark.Left := {5}; Mark.Right := {9}; Mark.Duration := {1}; \
     Mark.EnableType := {1}; Mark.EnableBit := {4}; MAOC(X, 2, W, Out, In, Mark, 0, 50, Comp, 2, 0, 0, 0, 1)",
    "Comp[1].Offset := {1}; Comp[1].LatchDelay := {0.01}; Comp[1].UnlatchDelay := {0.01}; Comp[1].Mode := {1}; Comp[1].CycleTime := {0.1}; \
     Comp[1].DutyCycle := {50}; Mark.OutputBit := 1; MAOC(X, 3, W, Out, In, Mark, 0, 50, Comp, 2, 0, 0, 0, 1)",
    "MDOC(X, {0}, W, {1})",
    "MDR(X, W, {1})",
    "MGS(Motion, W, {1})",
];

/// The same of the robot.
const ROBOT_CALLS: &[&str] = &[
    "Way.Position[0] := {9}; Way.Position[1] := {5}; Way.Position[2] := {1}; Way.Position[3] := {1}; Way.Position[4] := {2}; \
     Way.Position[5] := {10}; MCPM(CART, W, Way, 1, Pace)",
    "Way.InterpolationType := {1}; Way.RobotConfiguration := {0}; Way.TurnsCounters[1] := {0}; Way.MoveType := {1}; \
     Way.TerminationType := {3}; Way.CommandToleranceLinear := {0.5}; Way.Position[0] := 4; MCPM(CART, W, Way, {1}, Pace, {0}, {0})",
    "Pace.UnitsMode := {1}; Pace.TimeUnits := {0}; Pace.Profile := {1}; Pace.Speed := <50>; Pace.Acceleration := <500>; \
     Pace.Deceleration := <500>; Pace.AccelerationJerk := <90>; Pace.DecelerationJerk := <90>; Pace.OrientationSpeed := <45>; \
     Pace.OrientationAcceleration := <450>; Pace.OrientationDeceleration := <450>; MCPM(CART, W, Way, 1, Pace)",
    "Work.X := {10}; Work.Y := {1}; Work.Z := {-5}; Work.Rx := {1}; Work.Ry := {2}; Work.Rz := {3}; MCTO(CART, ROBOT, W, Work, Tool)",
    "Tool.ID := {3}; Tool.X := {1}; Tool.Y := {1}; Tool.Z := {40}; Tool.Rx := {1}; Tool.Ry := {2}; Tool.Rz := {15}; \
     MCTO(CART, ROBOT, W, NoFrame, Tool)",
    "MCTPO(CART, ROBOT, W, NoFrame, NoFrame, {0}, [{5},{70},{-80},{10},{-60},{20}], Place, Bits, Turns)",
    "Bits := {2}; Turns[0] := {1}; MCTPO(CART, ROBOT, W, NoFrame, NoFrame, {1}, [{250},{10},{200},{180},{0},{45}], Place, Bits, Turns)",
    "MCLM(CART, W, 0, [{9},{5},{1},{1},{2},{3}], <50>, 0, <500>, 0, <500>, 0, 0, 100, 100, 2, 3, 0, 0, {0}, {0}, 0)",
];

const AXES_TAGS: &str = r#"
[[tag]]
name = "Out"
type = "DINT"
[[tag]]
name = "In"
type = "DINT"
[[tag]]
name = "Mark"
type = "OUTPUT_CAM"
value = { OutputBit = 1, Left = 3.0, Right = 8.0 }
[[tag]]
name = "Comp"
type = "OUTPUT_COMPENSATION[32]"
"#;

/// Literals of Structured Text; the last three are infinity, its negative and no number.
const WILD: &[&str] = &[
    "0",
    "-1",
    "1E-300",
    "-1E-300",
    "1E-15",
    "0.000001",
    "1E9",
    "5E9",
    "-1E12",
    "1E15",
    "-1E16",
    "3.4028235E38",
    "1E140",
    "-1E155",
    "1E200",
    "1E308",
    "-1E308",
    INFINITE,
    NEGATIVE,
    NONE,
];
const INFINITE: &str = "(1E308*10.0)";
const NEGATIVE: &str = "(-1E308*10.0)";
const NONE: &str = "(1E308*10.0-1E308*10.0)";

/// The number that a literal means.
fn number(literal: &str) -> f64 {
    match literal {
        INFINITE => f64::INFINITY,
        NEGATIVE => f64::NEG_INFINITY,
        NONE => f64::NAN,
        literal => literal.parse().expect("a literal"),
    }
}

const BEGIN: [&str; 4] = [
    "MCLM(XY, Begin1, 0, [40, 30], 60, 0, 900, 0, 900, 0, 1, 100, 100, 2, 5)",
    "MAJ(Z, Begin2, 0, 20, 0, 200, 0, 200, 0, 0, 100, 100, 2)",
    "MAM(Y, Begin3, 1, 30, 20, 0, 200, 0, 200, 0, 1, 100, 100, 2)",
    "MAJ(A, Begin4, 0, 20, 0, 200, 0, 200, 0, 0, 100, 100, 2)",
];
const BEGIN_ROBOT: [&str; 3] = [
    "MCTO(CART, ROBOT, Begin1, NoFrame, NoFrame)",
    "MAJ(U, Begin2, 0, 20, 0, 200, 0, 200, 0, 0, 100, 100, 2)",
    "MCPM(CART, Begin3, Way, 1, Pace)",
];
/// The move programmed before at the end of the queue, and stopped.
const AFTER: [&str; 2] = [
    "MCLM(XY, After1, 1, [3, -2], 60, 0, 900, 0, 900, 0, 0, 100, 100, 2, 1)",
    "MAM(X, After2, 1, 3, 60, 0, 900, 0, 900, 0, 0, 100, 100, 2)",
];
const AFTER_ROBOT: [&str; 2] = [
    "MCLM(CART, After1, 1, [3, -2, 0, 0, 0, 0], 60, 0, 900, 0, 900, 0, 0, 100, 100, 2, 1)",
    "MAM(U, After2, 1, 3, 60, 0, 900, 0, 900, 0, 0, 100, 100, 2)",
];
const STOP: [&str; 2] = ["MCS(XY, Stop1, 0, 0, 100, 0, 0, 100, 2)", "MGS(Motion, Stop2, 1)"];
const STOP_ROBOT: [&str; 2] = ["MCS(CART, Stop1, 0, 0, 100, 0, 0, 100, 2)", "MGS(Motion, Stop2, 1)"];

/// Both machines with their calls.
const SCANS: [(Of, &[&str]); 2] = [(Of::Axes, CALLS), (Of::Robot, ROBOT_CALLS)];

/// A number of a call: its range in the text, and whether it may make an axis fast.
type NumberRange = (std::ops::Range<usize>, bool);

fn number_ranges(call: &str) -> Vec<NumberRange> {
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(open) = call[from..].find(['{', '<']).map(|at| from + at) {
        let fast = call.as_bytes()[open] == b'<';
        let close = open + call[open..].find(if fast { '>' } else { '}' }).expect("it is closed");
        found.push((open..close + 1, fast));
        from = close + 1;
    }
    found
}

/// The call with its own numbers but for those that are given.
fn with(call: &str, given: &[(usize, &str)]) -> String {
    let mut text = String::new();
    let mut from = 0;
    for (place, (range, _)) in number_ranges(call).into_iter().enumerate() {
        text += &call[from..range.start];
        let own = &call[range.start + 1..range.end - 1];
        text += given
            .iter()
            .find(|(other, _)| *other == place)
            .map_or(own, |(_, value)| value);
        from = range.end;
    }
    text + &call[from..]
}

struct Scan {
    bench: Bench,
    of: Of,
    /// A call was accepted that may move an axis at any speed.
    fast: bool,
    calls: Vec<String>,
}

impl Scan {
    fn new(of: Of, moving: bool) -> Self {
        let bench = match of {
            Of::Axes => {
                let cams = "name = \"X\"\noutput_cam_execution_targets = 4";
                let config = arcline_config::DEFAULT.replacen("name = \"X\"", cams, 1);
                let mut bench = Bench::with(&format!("{config}{CAM_TAGS}{AXES_TAGS}"));
                assert_eq!(bench.call("MCCP(Make, Cam, 2, 0, 0, Profile[0])"), OK);
                bench
            }
            Of::Robot => Bench::with(&format!("{}{PATH_TAGS}", SIX_AXES.config())),
        };
        let mut scan = Scan {
            bench,
            of,
            fast: false,
            calls: Vec::new(),
        };
        if moving {
            let begin = match of {
                Of::Axes => &BEGIN[..],
                Of::Robot => &BEGIN_ROBOT,
            };
            for call in begin {
                scan.calls.push((*call).to_owned());
                assert_eq!(scan.bench.call(call), OK, "{call}");
            }
            scan.run(60);
        }
        scan
    }

    fn call(&mut self, call: &str, given: &[(usize, &str)], ticks: u64) {
        let text = with(call, given);
        self.calls.push(text.clone());
        let mut accepted = true;
        for statement in text.split(';') {
            match statement.split_once(" := ") {
                Some((tag, value)) => self.bench.write(tag.trim(), number(value.trim())),
                None => accepted = self.bench.call(statement.trim()) == OK,
            }
        }
        let ranges = number_ranges(call);
        self.fast |= accepted && given.iter().any(|(index, _)| ranges[*index].1);
        // Faster than the axis can follow: the command limits act.
        self.bench.refusals_expected = self.fast;
        self.run(ticks);
    }

    fn run(&mut self, ticks: u64) {
        let period = self.bench.machine().period();
        for _ in 0..ticks {
            let before = self.bench.snapshot();
            self.bench.tick();
            let now = self.bench.snapshot();
            for (place, axis) in now.axes.iter().enumerate() {
                let shown = [axis.command, axis.actual].concat();
                let description = &self.bench.machine().axes[place];
                assert!(
                    shown.iter().all(|number| number.is_finite()),
                    "{} is at {shown:?} after\n{}",
                    description.name,
                    self.calls.join(";\n")
                );
                if self.fast || description.unwind.is_some() {
                    continue;
                }
                let last = &before.axes[place];
                let step = (axis.command[0] - axis.redefined - (last.command[0] - last.redefined)).abs();
                // Two motions may be superposed.
                assert!(
                    step <= 2.0 * description.max_speed * period,
                    "{} steps by {step} after\n{}",
                    description.name,
                    self.calls.join(";\n")
                );
            }
        }
    }

    fn finish(&mut self) {
        let (after, stop) = match self.of {
            Of::Axes => (AFTER, STOP),
            Of::Robot => (AFTER_ROBOT, STOP_ROBOT),
        };
        for call in after {
            self.call(call, &[], 20);
        }
        for call in stop {
            self.call(call, &[], 40);
        }
    }
}

#[test]
fn no_wild_number_alone_moves_an_axis() {
    for (of, calls) in SCANS {
        for call in calls {
            for place in 0..number_ranges(call).len() {
                for moving in one_or_all(&[false, true], place % 2).iter().copied() {
                    let mut scan = Scan::new(of, moving);
                    for value in WILD {
                        scan.call(call, &[(place, value)], 4);
                    }
                    scan.finish();
                }
            }
        }
    }
}

/// An instruction is in the scan, or no operand of it takes a number.
#[test]
fn every_instruction_that_takes_a_number_is_in_the_scan() {
    let scanned: Vec<&str> = SCANS
        .iter()
        .flat_map(|(_, calls)| calls.iter())
        .flat_map(|row| row.split(';'))
        .filter_map(|statement| statement.trim().split_once('(').map(|(name, _)| name))
        .collect();
    let mut missing = Vec::new();
    for mnemonic in Mnemonic::ALL {
        let takes_numbers = mnemonic
            .instruction()
            .operands
            .iter()
            .any(|operand| !matches!(operand.kind, Kind::Target(_) | Kind::MotionControl | Kind::Object(_)));
        if takes_numbers && !scanned.contains(&mnemonic.to_string().as_str()) {
            missing.push(mnemonic.to_string());
        }
    }
    assert_eq!(missing, Vec::<String>::new());
}

#[test]
fn no_wild_numbers_together_move_an_axis() {
    let cases = std::env::var("ARCLINE_CASES").ok().and_then(|cases| cases.parse().ok());
    for seed in 0..cases.unwrap_or(150) {
        let mut random = Random(seed);
        let (of, calls) = SCANS[usize::from(random.below(4) == 0)];
        let mut scan = Scan::new(of, random.below(2) == 0);
        for _ in 0..12 {
            let call = random.one_of(calls);
            let count = number_ranges(call).len() as u64;
            let given: Vec<(usize, &str)> = (0..2)
                .map(|_| (random.below(count) as usize, *random.one_of(WILD)))
                .collect();
            scan.call(call, &given, random.below(12));
        }
        scan.finish();
    }
}

/// The errors 13, each with its operand.
#[test]
fn operands_out_of_range_are_refused_with_their_index() {
    #[rustfmt::skip]
    let cases = [
        // why,                        call,                                                                    EXERR
        ("end of a line",              "MCLM(XY, W, 0, [1E140, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)",      3),
        ("increment of a line",        "MCLM(XY, W, 1, [5E9, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)",        3),
        ("end of an arc",              "MCCM(XY, W, 0, [1E140, 0], 1, [5, 0], 0, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)", 3),
        ("centre of a circle",         "MCCM(XY, W, 0, [10, 0], 1, [1E155, 0], 2, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)", 5),
        ("a full circle too wide",     "MCCM(XY, W, 0, [1E10, 0], 1, [5E9, 0], 2, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)", 3),
        ("the same with a near end",   "MCCM(XY, W, 0, [0, 10], 1, [5E12, 5], 2, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)", 5),
        ("speed too high",             "MCLM(XY, W, 0, [9, 0], 1E16, 0, 500, 0, 500, 0, 0, 100, 100, 2)",        4),
        ("speed too low",              "MCLM(XY, W, 0, [9, 0], 1E-16, 0, 500, 0, 500, 0, 0, 100, 100, 2)",       4),
        ("rate too low",               "MCLM(XY, W, 0, [9, 0], 50, 0, 1E-16, 0, 500, 0, 0, 100, 100, 2)",        6),
        ("position of a move",         "MAM(X, W, 0, 1E140, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)",             3),
        ("distance of a move",         "MAM(X, W, 1, 5E9, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)",               3),
        ("redefined position",         "MRP(X, W, 0, 0, 1E16)",                                                  4),
        ("offset",                     "MRP(X, W, 1, 0, 5E9)",                                                   4),
        ("rate of a stop",             "MCS(XY, W, 0, 1, 1E-300, 0, 0, 100, 2)",                                 4),
        ("translation of a transform", "MCT(CS1, CS3, W, [0, 0, 0], [1E12, 0, 0])",                              4),
    ];
    for (why, call, exerr) in cases {
        let mut bench = Bench::new();
        assert_eq!(bench.call(call), (13, exerr), "{why}: {call}");
        bench.run(5);
        assert!(bench.snapshot().axes.iter().all(|axis| axis.command[1] == 0.0), "{why}");
    }
    // The sum of two counts.
    let mut bench = Bench::new();
    for (offset, expected) in [("4E9", OK), ("4E9", (13, 4)), ("-8E9", OK), ("-1E9", (13, 4))] {
        assert_eq!(bench.call(&format!("MRP(X, W, 1, 0, {offset})")), expected, "{offset}");
        bench.run(3);
    }
    // A circle with a distant centre is one still.
    let arc = "MCCM(XY, W, 0, [10, 0], 1, [5, 1E12], 1, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)";
    assert_eq!(Bench::new().call(arc), OK);
}

//! Wild operands never move: every number of every instruction takes values that are none, that overflow, or that nothing can be
//! built with, alone and in pairs, from rest and in motion. Whatever is accepted, all axes stay finite, and no axis jumps.
//!
//! `ARCLINE_CASES` sets how many random sequences of pairs are run (150 unless told).

use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::CAM_TAGS;
use arcline_tests::random::Random;

/// Instructions with numbers in braces: what a good program has there. In `<` and `>` stand speeds, rates, jerks and scalings, which a
/// program may make as high as it likes; the axis then goes as fast as that.
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
];

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
    "(1E308*10.0)",
    "(-1E308*10.0)",
    "(1E308*10.0-1E308*10.0)",
];

const BEGIN: [&str; 4] = [
    "MCLM(XY, Begin1, 0, [40, 30], 60, 0, 900, 0, 900, 0, 1, 100, 100, 2, 5)",
    "MAJ(Z, Begin2, 0, 20, 0, 200, 0, 200, 0, 0, 100, 100, 2)",
    "MAM(Y, Begin3, 1, 30, 20, 0, 200, 0, 200, 0, 1, 100, 100, 2)",
    "MAJ(A, Begin4, 0, 20, 0, 200, 0, 200, 0, 0, 100, 100, 2)",
];
/// Programmed with what went before it at the end of the queue, and stopped.
const AFTER: [&str; 2] = [
    "MCLM(XY, After1, 1, [3, -2], 60, 0, 900, 0, 900, 0, 0, 100, 100, 2, 1)",
    "MAM(X, After2, 1, 3, 60, 0, 900, 0, 900, 0, 0, 100, 100, 2)",
];
const STOP: [&str; 2] = ["MCS(XY, Stop1, 0, 0, 100, 0, 0, 100, 2)", "MGS(Motion, Stop2, 1)"];

/// A number of a call: its place in the text, and whether it may make an axis fast.
type Slot = (std::ops::Range<usize>, bool);

fn slots(call: &str) -> Vec<Slot> {
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
    for (place, (range, _)) in slots(call).into_iter().enumerate() {
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
    /// Something that was accepted goes as fast as it likes.
    fast: bool,
    calls: Vec<String>,
}

impl Scan {
    fn new(moving: bool) -> Self {
        let mut bench = Bench::with(&format!("{}{CAM_TAGS}", arcline_config::DEFAULT));
        assert_eq!(bench.call("MCCP(Make, Cam, 2, 0, 0, Profile[0])"), OK);
        let mut scan = Scan {
            bench,
            fast: false,
            calls: Vec::new(),
        };
        if moving {
            for call in BEGIN {
                scan.calls.push(call.to_owned());
                assert_eq!(scan.bench.call(call), OK, "{call}");
            }
            scan.run(60);
        }
        scan
    }

    fn call(&mut self, call: &str, given: &[(usize, &str)], ticks: u64) {
        let text = with(call, given);
        self.calls.push(text.clone());
        let accepted = self.bench.call(&text) == OK;
        let slots = slots(call);
        self.fast |= accepted && given.iter().any(|(place, _)| slots[*place].1);
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
        for call in AFTER {
            self.call(call, &[], 20);
        }
        for call in STOP {
            self.call(call, &[], 40);
        }
    }
}

#[test]
fn no_wild_number_alone_moves_an_axis() {
    for call in CALLS {
        for place in 0..slots(call).len() {
            for moving in [false, true] {
                let mut scan = Scan::new(moving);
                for value in WILD {
                    scan.call(call, &[(place, value)], 4);
                }
                scan.finish();
            }
        }
    }
}

#[test]
fn no_wild_numbers_together_move_an_axis() {
    let cases = std::env::var("ARCLINE_CASES").ok().and_then(|cases| cases.parse().ok());
    for seed in 0..cases.unwrap_or(150) {
        let mut random = Random(seed);
        let mut scan = Scan::new(random.below(2) == 0);
        for _ in 0..12 {
            let call = random.one_of(CALLS);
            let count = slots(call).len() as u64;
            let given: Vec<(usize, &str)> = (0..2)
                .map(|_| (random.below(count) as usize, *random.one_of(WILD)))
                .collect();
            scan.call(call, &given, random.below(12));
        }
        scan.finish();
    }
}

/// What errs with 13, and with which operand.
#[test]
fn what_is_out_of_range_is_refused_with_its_operand() {
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

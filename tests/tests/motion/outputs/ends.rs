//! The bits of an output cam that is over, superseded or disarmed: edges that lag behind the axis, durations, and their treatment by
//! the next cam.

use arcline_instruction_set::Flag;
use arcline_tests::bench::OK;

use super::{TRAPEZOID, compensate, element, go, machine, status, window};

/// `Cam` from 0 to 100, once, from where the axis is at the start.
const ONCE: &str = "MAOC(X, 0, C, Out[0], In, Cam, 0, 100, Comp, Once, Immediate, 0, 0, Command)";
/// `Next` from 0 to 40 behind it.
const NEXT: &str = "MAOC(X, 0, D, Out[0], In, Next, 0, 40, Comp, Once, Pending, 0, 0, Command)";
/// A bit that is on for 100 ms from 50 units on.
const TIMED: [f64; 8] = [1.0, 1.0, 2.0, 50.0, 60.0, 0.1, 0.0, 0.0];

/// Offset, latch delay and unlatch delay.
const fn compensated(offset: f64, latch: f64, unlatch: f64) -> [f64; 6] {
    [offset, latch, unlatch, 0.0, 0.0, 0.0]
}

struct Case {
    why: &'static str,
    elements: &'static [(&'static str, [f64; 8])],
    /// The compensation by bits.
    compensation: &'static [(usize, [f64; 6])],
    /// The calls, each at a position of the axis.
    calls: &'static [(f64, &'static str)],
    /// Milliseconds at which `Out[0]` changes, and its value then.
    expected: &'static [(f64, i64)],
}

/// When the bits change on the way of the axis from 0 to 150, at 0.1 units/ms from the start.
fn changes(period: f64, case: &Case) -> Vec<(f64, i64)> {
    let mut bench = machine(period);
    for (tag, values) in case.elements {
        element(&mut bench, tag, *values);
    }
    for (bit, values) in case.compensation {
        compensate(&mut bench, *bit, *values);
    }
    let mut calls = case.calls.iter().peekable();
    let mut word = 0;
    let mut list = Vec::new();
    while bench.position("X") < 150.0 {
        while let Some((_, call)) = calls.next_if(|(place, _)| *place <= bench.position("X")) {
            assert_eq!(bench.call(call), OK, "{}: {call}", case.why);
        }
        if bench.now() == 0 {
            let go = "MAM(X, M, 0, 300, 100, 0, 1e9, 0, 1e9, 0, 0, 100, 100, 2)";
            assert_eq!(bench.call(go), OK);
        }
        let time = bench.now() as f64 * period;
        bench.tick();
        let now = bench.read("Out[0]") as i64;
        if std::mem::replace(&mut word, now) != now {
            list.push((time, now));
        }
    }
    list
}

const CASES: &[Case] = &[
    Case {
        why: "an offset over the end",
        elements: &[("Cam[0]", window(0, 90.0, 98.0))],
        compensation: &[(0, compensated(5.0, 0.0, 0.0))],
        calls: &[(0.0, ONCE)],
        expected: &[(950.0, 1), (1030.0, 0)],
    },
    Case {
        why: "a range that begins behind the end",
        elements: &[("Cam[0]", window(0, 98.0, 100.0))],
        compensation: &[(0, compensated(5.0, 0.0, 0.0))],
        calls: &[(0.0, ONCE)],
        expected: &[(1030.0, 1), (1050.0, 0)],
    },
    Case {
        why: "edges later by time",
        elements: &[("Cam[0]", window(0, 90.0, 98.0))],
        compensation: &[(0, compensated(0.0, -0.02, -0.05))],
        calls: &[(0.0, ONCE)],
        expected: &[(920.0, 1), (1030.0, 0)],
    },
    Case {
        why: "over the end and beside the next cam",
        elements: &[("Cam[0]", window(0, 90.0, 100.0)), ("Next", window(1, 0.0, 8.0))],
        compensation: &[(0, compensated(5.0, 0.0, 0.0))],
        calls: &[(0.0, ONCE), (0.0, NEXT)],
        expected: &[(950.0, 1), (1000.0, 3), (1050.0, 2), (1080.0, 0)],
    },
    Case {
        why: "a bit that is both cams'",
        elements: &[("Cam[0]", window(0, 90.0, 100.0)), ("Next", window(0, 0.0, 8.0))],
        compensation: &[(0, compensated(5.0, 0.0, 0.0))],
        calls: &[(0.0, ONCE), (0.0, NEXT)],
        expected: &[(950.0, 1), (1130.0, 0)],
    },
    Case {
        why: "up to the end, and the next cam does not know the bit",
        elements: &[("Cam[0]", window(0, 90.0, 100.0)), ("Next", window(1, 10.0, 15.0))],
        compensation: &[],
        calls: &[(0.0, ONCE), (0.0, NEXT)],
        expected: &[(900.0, 1), (1000.0, 0), (1100.0, 2), (1150.0, 0)],
    },
    Case {
        why: "an inverted one that the next cam does not know",
        elements: &[("Cam[0]", window(2, 10.0, 20.0)), ("Next", window(1, 10.0, 15.0))],
        compensation: &[(2, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0])],
        calls: &[(0.0, ONCE), (0.0, NEXT)],
        expected: &[(0.0, 4), (100.0, 0), (200.0, 4), (1100.0, 6), (1150.0, 4)],
    },
    Case {
        why: "a repeated cam begins at its start, and not with the end of a turn that never was",
        elements: &[("Cam[0]", window(0, 10.0, 20.0)), ("Next", window(1, 30.0, 38.0))],
        compensation: &[(1, compensated(10.0, 0.0, 0.0))],
        calls: &[
            (0.0, ONCE),
            (
                0.0,
                "MAOC(X, 0, D, Out[0], In, Next, 0, 40, Comp, Continuous, Pending, 0, 0, Command)",
            ),
        ],
        expected: &[(100.0, 1), (200.0, 0), (1400.0, 2), (1480.0, 0)],
    },
    Case {
        why: "the end of a turn that was, when a cam comes that waits",
        elements: &[("Cam[0]", window(0, 40.0, 50.0)), ("Next", window(1, 0.0, 5.0))],
        compensation: &[(0, compensated(5.0, 0.0, 0.0))],
        calls: &[
            (
                0.0,
                "MAOC(X, 0, C, Out[0], In, Cam, 0, 50, Comp, Continuous, Immediate, 0, 0, Command)",
            ),
            (52.0, NEXT),
        ],
        // The cam is armed as if it had been repeated before, too.
        expected: &[
            (0.0, 1),
            (50.0, 0),
            (450.0, 1),
            (550.0, 0),
            (950.0, 1),
            (1000.0, 3),
            (1050.0, 0),
        ],
    },
    Case {
        why: "a duration, executed again when the cam is over",
        elements: &[("Cam[0]", [0.0, 1.0, 2.0, 99.0, 100.0, 0.05, 0.0, 0.0])],
        compensation: &[],
        calls: &[
            (0.0, ONCE),
            (
                102.0,
                "MAOC(X, 0, D, Out[0], In, Cam, 0, 100, Comp, Once, Immediate, 0, 0, Command)",
            ),
        ],
        expected: &[(990.0, 1), (1040.0, 0)],
    },
    Case {
        why: "a lagging edge, executed again when the cam is over",
        elements: &[("Cam[0]", window(0, 90.0, 100.0))],
        compensation: &[(0, compensated(5.0, 0.0, 0.0))],
        calls: &[
            (0.0, ONCE),
            (
                102.0,
                "MAOC(X, 0, D, Out[0], In, Cam, 0, 100, Comp, Once, Immediate, 0, 0, Command)",
            ),
        ],
        expected: &[(950.0, 1), (1050.0, 0)],
    },
    Case {
        why: "superseded: durations run out, other bits that nobody knows stay",
        elements: &[
            ("Cam[0]", window(0, 40.0, 90.0)),
            ("Cam[1]", TIMED),
            ("Next", window(2, 10.0, 20.0)),
        ],
        compensation: &[],
        calls: &[
            (0.0, ONCE),
            (
                52.0,
                "MAOC(X, 0, D, Out[0], In, Next, 0, 100, Comp, Once, ForwardOnly, 55, 0, Command)",
            ),
        ],
        expected: &[(400.0, 1), (500.0, 3), (600.0, 1), (650.0, 5), (750.0, 1)],
    },
    Case {
        why: "superseded: a bit that the next cam knows begins with it",
        elements: &[("Cam[0]", window(0, 40.0, 90.0)), ("Next", window(0, 10.0, 20.0))],
        compensation: &[],
        calls: &[
            (0.0, ONCE),
            (
                54.5,
                "MAOC(X, 0, D, Out[0], In, Next, 0, 100, Comp, Once, ForwardOnly, 55, 0, Command)",
            ),
        ],
        expected: &[(400.0, 1), (550.0, 0), (650.0, 1), (750.0, 0)],
    },
    Case {
        why: "superseded with another output: as disarmed",
        elements: &[("Cam[0]", TIMED), ("Next", window(1, 10.0, 20.0))],
        compensation: &[],
        calls: &[
            (0.0, ONCE),
            (
                52.0,
                "MAOC(X, 0, D, Out[1], In, Next, 0, 100, Comp, Once, ForwardOnly, 55, 0, Command)",
            ),
        ],
        expected: &[(500.0, 2)],
    },
    Case {
        why: "disarmed: the bits stay",
        elements: &[("Cam[0]", window(0, 40.0, 90.0)), ("Cam[1]", TIMED)],
        compensation: &[],
        calls: &[(0.0, ONCE), (52.0, "MDOC(X, 0, D, Specific)")],
        expected: &[(400.0, 1), (500.0, 3)],
    },
    Case {
        why: "disarmed behind its end: the bits stay",
        elements: &[("Cam[0]", window(0, 90.0, 100.0))],
        compensation: &[(0, compensated(5.0, 0.0, 0.0))],
        calls: &[(0.0, ONCE), (102.0, "MDOC(X, 0, D, All)")],
        expected: &[(950.0, 1)],
    },
    Case {
        why: "a duration over two more cams",
        elements: &[
            ("Cam[0]", [0.0, 1.0, 2.0, 99.0, 100.0, 0.2, 0.0, 0.0]),
            ("Next", window(1, 0.0, 2.0)),
            ("Third", window(2, 5.0, 6.0)),
        ],
        compensation: &[],
        calls: &[
            (0.0, ONCE),
            (
                0.0,
                "MAOC(X, 0, D, Out[0], In, Next, 0, 5, Comp, Once, Pending, 0, 0, Command)",
            ),
            (
                101.0,
                "MAOC(X, 0, E, Out[0], In, Third, 0, 40, Comp, Once, Pending, 0, 0, Command)",
            ),
        ],
        expected: &[
            (990.0, 1),
            (1000.0, 3),
            (1020.0, 1),
            (1100.0, 5),
            (1110.0, 1),
            (1190.0, 0),
        ],
    },
];

#[test]
fn edges_come_where_they_lie_whatever_ends_their_cam() {
    for case in CASES {
        for period in [0.25, 1.0, 4.0] {
            let tick = |time: f64| {
                // The axis has taken 50 ps to reach its speed; a call before the first tick shows at once.
                let ticks = if time == 0.0 {
                    0.0
                } else {
                    (time / period + 1e-6).ceil()
                };
                ticks * period
            };
            let mut expected: Vec<(f64, i64)> = case.expected.iter().map(|(time, word)| (tick(*time), *word)).collect();
            // Of edges within one update, only the last one shows.
            expected.reverse();
            expected.dedup_by_key(|(time, _)| *time);
            expected.reverse();
            assert_eq!(changes(period, case), expected, "{} at {period} ms", case.why);
        }
    }
}

#[test]
fn a_lagging_bit_is_in_transition_and_ends_where_the_axis_comes_back() {
    let start = || {
        let mut bench = machine(1.0);
        element(&mut bench, "Cam[0]", window(0, 90.0, 100.0));
        element(&mut bench, "Next", window(1, 0.0, 5.0));
        compensate(&mut bench, 0, compensated(5.0, 0.0, 0.0));
        assert_eq!(bench.call(ONCE), OK);
        bench
    };
    // Position, the word, the status words.
    type Step = (f64, u32, [u32; 4]);
    const OVER: [u32; 4] = [0; 4];
    #[rustfmt::skip]
    let cases: [(&str, &[&str], &[Step]); 3] = [
        ("it stays on while the axis stands", &[],
            &[(92.0, 0, [1, 0, 1, 0]), (97.0, 1, [1, 0, 1, 0]), (102.0, 1, OVER), (104.0, 1, OVER), (106.0, 0, OVER)]),
        ("back over its end", &[],
            &[(102.0, 1, OVER), (101.0, 1, OVER), (99.0, 0, OVER), (102.0, 0, OVER), (120.0, 0, OVER)]),
        ("with another cam", &[NEXT],
            &[(97.0, 1, [1, 1, 1, 0]), (102.0, 3, [1, 0, 1, 1]), (104.0, 3, [1, 0, 1, 1]), (107.0, 0, [1, 0, 1, 0])]),
    ];
    for (why, calls, steps) in cases {
        let mut bench = start();
        for call in calls {
            assert_eq!(bench.call(call), OK, "{why}");
        }
        let mut is_over = false;
        for (to, word, shown) in steps {
            go(&mut bench, "X", *to, TRAPEZOID);
            is_over |= *to > 100.0;
            bench.tick();
            let found = (bench.read("Out[0]") as u32, status(&bench, "X"));
            assert_eq!(found, (*word, *shown), "{why} at {to}");
            // PC comes with the end of the cam, not with its last edge.
            assert_eq!(bench.control("C").has(Flag::Pc), is_over, "{why} at {to}");
        }
    }
}

//! Programs in, steps, Structured Text and errors out.

use arcline_gcode::{Corner, GcodeError, Motion, Options, Program, Speed};
use proptest::prelude::*;

fn parse(text: &str) -> Result<Program, GcodeError> {
    Program::parse(text, &Options::default())
}

/// `L x,y,z`, `A via end`, `D s`, with `@speed` where it is a feed, and the corner.
fn told(program: &Program) -> String {
    let point = |point: [f64; 3]| {
        point
            .map(|number| format!("{}", (number * 1e6).round() / 1e6 + 0.0))
            .join(",")
    };
    let speed = |speed| match speed {
        Speed::Rapid => String::new(),
        Speed::Feed(feed) => format!("@{}", (feed * 1e6).round() / 1e6),
    };
    let corner = |corner| match corner {
        Corner::Exact => "exact".to_owned(),
        Corner::Stop => "stop".to_owned(),
        Corner::Rounded => "rounded".to_owned(),
        Corner::Within(tolerance) => format!("within {}", (tolerance * 1e6).round() / 1e6),
    };
    let one = |motion: Motion| match motion {
        Motion::Line {
            end,
            speed: s,
            corner: c,
        } => format!("L {}{} {}", point(end), speed(s), corner(c)),
        Motion::Arc {
            via,
            end,
            speed: s,
            corner: c,
        } => format!("A {} {}{} {}", point(via), point(end), speed(s), corner(c)),
        Motion::Dwell { seconds } => format!("D {seconds}"),
    };
    let steps: Vec<String> = program.steps.iter().map(|step| one(step.motion)).collect();
    steps.join("; ")
}

#[test]
fn the_motions_of_programs() {
    #[rustfmt::skip]
    let cases = [
        // why,                      program,                                        steps
        ("a rapid",                  "G0 X10 Y5",                                    "L 10,5,0 stop"),
        ("a feed, per minute",       "G1 X10 F600",                                  "L 10,0,0@10 stop"),
        ("modes hold",               "F600 G1 X10\nY5",                              "L 10,0,0@10 exact; L 10,5,0@10 stop"),
        ("incremental",              "G91 G0 X10\nX10 Y1\nG90 X0",                   "L 10,0,0 exact; L 20,1,0 exact; L 0,1,0 stop"),
        ("inches",                   "G20 G1 X1 F60\nG21 X0 F60",                    "L 25.4,0,0@25.4 exact; L 0,0,0@1 stop"),
        ("an arc by its centre",     "G3 X10 Y10 J10 F60",                           "A 7.071068,2.928932,0 10,10,0@1 stop"),
        ("clockwise",                "G2 X10 Y10 I10 F60",                           "A 2.928932,7.071068,0 10,10,0@1 stop"),
        ("by its radius",            "G2 X10 Y10 R10 F60",                           "A 2.928932,7.071068,0 10,10,0@1 stop"),
        ("an absolute centre",       "G90.1 G3 X10 Y10 I0 J10 F60",                  "A 7.071068,2.928932,0 10,10,0@1 stop"),
        ("a full circle",            "G2 I5 F60",                                    "A 5,5,0 10,0,0@1 exact; A 5,-5,0 0,0,0@1 stop"),
        ("the ZX plane",             "G18 G3 X10 Z-10 K-10 F60",                     "A 7.071068,0,-2.928932 10,0,-10@1 stop"),
        ("the YZ plane",             "G19 G3 Y10 Z10 K10 F60",                       "A 0,7.071068,2.928932 0,10,10@1 stop"),
        ("path control",             "G64 G0 X1\nG64 P0.5\nX2\nG61\nX3\nG61.1 X4\nX5", "L 1,0,0 rounded; L 2,0,0 within 0.5; L 3,0,0 exact; L 4,0,0 stop; L 5,0,0 stop"),
        ("a tolerance in inches",    "G20 G64 P0.01 G0 X1\nX2",                      "L 25.4,0,0 within 0.254; L 50.8,0,0 stop"),
        ("no tolerance",             "G64 P0 G0 X1\nX2",                             "L 1,0,0 exact; L 2,0,0 stop"),
        ("a dwell stops",            "G64 G0 X1\nG4 P0.5\nX2\nX3",                   "L 1,0,0 stop; D 0.5; L 2,0,0 rounded; L 3,0,0 stop"),
        ("the end",                  "G0 X1\nM2\nG0 X2",                             "L 1,0,0 stop"),
        ("with the last motion",     "G0 X1 M30\nX2",                                "L 1,0,0 stop"),
        ("a frame",                  "%\nG0 X1\n%\nthis is not read",                "L 1,0,0 stop"),
        ("what is so anyway",        "G17 G21 G40 G49 G54 G80 G90 G94",              ""),
        ("no way",                   "G0 X0\nX1\nX1",                                "L 1,0,0 stop"),
        ("comments and numbers",     "N10 (go) G0 X1 ; there\n\nN20 X2",             "L 1,0,0 exact; L 2,0,0 stop"),
    ];
    for (why, program, expected) in cases {
        match parse(program) {
            Ok(parsed) => assert_eq!(told(&parsed), expected, "{why}: {program}"),
            Err(error) => panic!("{why}: {program}: {error}"),
        }
    }
}

#[test]
fn errors_are_reported_with_line_and_column() {
    #[rustfmt::skip]
    let cases = [
        ("an unknown word",       "G0 X1\nG5 X2",             "line 2, column 1: the word `G5` is not known"),
        ("a spindle",             "M3 S1000",                 "line 1, column 1: the word `M3` is not known"),
        ("its speed",             "G0 X1 S1000",              "line 1, column 7: the word `S1000` is not known"),
        ("another axis",          "G0 X1 A5",                 "line 1, column 7: the word `A5` is not known"),
        ("a letter twice",        "G0 X1 X2",                 "line 1, column 7: `X` stands twice on the line"),
        ("two motions",           "G0 G1 X2",                 "line 1, column 4: `G1` cannot stand on a line with `G0`"),
        ("two dwells",            "G4 G4 P1",                 "`G4` cannot stand on a line with `G4`"),
        ("P for two",             "G4 G64 P1",                "`G64` cannot stand on a line with `G4`"),
        ("P for nothing",         "G0 X1 P1",                 "line 1, column 7: `P` belongs to nothing on this line"),
        ("a dwell without time",  "G4",                       "the time of the dwell is missing"),
        ("time runs forward",     "G4 P-1",                   "`P` is -1, expected 0 or more"),
        ("a negative feed",       "F-1",                      "`F` is -1, expected 0 or more"),
        ("no feed",               "G1 X1",                    "line 1, column 4: the feed rate is missing"),
        ("no feed at all",        "G1 X1 F0",                 "the feed rate is missing"),
        ("no motion",             "X1",                       "line 1, column 1: how to get there is missing"),
        ("cancelled",             "G0 X1\nG80\nX2",           "line 3, column 1: how to get there is missing"),
        ("no centre",             "G2 X1 Y1 F60",             "the arc's centre is missing"),
        ("no arc",                "G2 F60",                   "line 1, column 1: the arc's end or centre is missing"),
        ("a centre of a line",    "G1 X1 I1 F60",             "`I` belongs to nothing on this line"),
        ("out of the plane",      "G2 X1 Y1 K1 F60",          "`K` belongs to nothing on this line"),
        ("centre and radius",     "G2 X1 Y1 I1 R1 F60",       "`I1` cannot stand on a line with `R1`"),
        ("half a centre",         "G90.1 G2 X1 Y1 I1 F60",    "half of the arc's centre is missing"),
        ("a helix",               "G2 X1 Y1 Z1 I1 F60",       "line 1, column 10: the arc leaves its plane along Z"),
        ("radii",                 "G2 X10 Y10 I5 F60",        "the radius is 5 at the start of the arc"),
    ];
    for (why, program, expected) in cases {
        match parse(program) {
            Ok(parsed) => panic!("{why}: {program}: {}", told(&parsed)),
            Err(error) => assert!(error.to_string().contains(expected), "{why}: {program}: {error}"),
        }
    }
}

#[test]
fn words_are_passed_over_when_it_is_said() {
    let options = |skip: &[&str]| Options {
        skip: skip.iter().map(|word| (*word).to_owned()).collect(),
        ..Options::default()
    };
    let text = "M3 S1000 G43\nG0 X1 M5";
    let program = Program::parse(text, &options(&["m3", "M5", "S", "G43"])).expect("a program");
    assert_eq!(told(&program), "L 1,0,0 stop");
    let error = Program::parse(text, &options(&["M3", "S", "G43"]))
        .expect_err("M5 is not named")
        .to_string();
    assert!(
        error.contains("line 2, column 7: the word `M5` is not known"),
        "{error}"
    );
    // A known word is never skipped.
    let program = Program::parse("G0 X1", &options(&["G0", "X"])).expect("a program");
    assert_eq!(told(&program), "L 1,0,0 stop");
}

#[test]
fn the_machine_has_its_own_axes_and_units() {
    let plane = Options {
        axes: 2,
        ..Options::default()
    };
    for (program, expected) in [
        ("G0 Z1", "line 1, column 4: the coordinate system has 2 axes and no Z"),
        ("G18 G2 X1 K1 F60", "has 2 axes and no Z"),
    ] {
        let error = Program::parse(program, &plane).expect_err(program).to_string();
        assert!(error.contains(expected), "{error}");
    }
    let text = Program::parse("G0 X1 Y2", &plane).map(|program| program.structured_text("XY", "M").text);
    assert!(
        text.as_ref()
            .is_ok_and(|text| text.starts_with("MCLM(XY, M, Absolute, [1, 2], 100, %ofMaximum")),
        "{text:?}"
    );
    let inches = Options {
        inches: true,
        start: [1.0, 0.0, 0.0],
        ..Options::default()
    };
    let program = Program::parse("G91 G1 X25.4 F60\nG20 X1", &inches).expect("a program");
    assert_eq!(
        told(&program),
        format!("L 2,0,0@{} exact; L 3,0,0@{} stop", 0.03937, 0.03937)
    );
}

#[test]
fn every_step_is_a_statement_that_can_be_read() {
    let text = "G21 G64 P0.1\nG0 X10 Y10\nG1 X20 F6000\nG3 X30 Y20 J10\nG61\nG2 I-5\nG4 P0.25\nG0 X0 Y0\nM2";
    let program = parse(text).expect("a program");
    let made = program.structured_text("CS1", "Ngc");
    assert_eq!(made.text.lines().count(), made.lines.len());
    assert_eq!(made.lines, [2, 3, 4, 6, 6, 7, 8]);
    let calls = arcline_structured_text::Program::parse(&made.text).expect("Structured Text");
    assert_eq!(calls.calls().count(), 6);
    for expected in [
        "MCLM(CS1, Ngc, Absolute, [20, 10, 0], 100, Unitspersec, ",
        "CommandToleranceProgrammed, Disabled, Programmed, 0.1);",
        "WAIT(NOT Ngc.IP); DELAY(0.25);",
        "NoSettle);",
    ] {
        assert!(made.text.contains(expected), "{expected} in\n{}", made.text);
    }
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,80}(\n\\PC{0,40}){0,3}") {
        let _ = parse(&text);
    }

    /// Every program that parses becomes Structured Text of finite numbers, each position within the reach of its words.
    #[test]
    fn programs_that_are_read_can_be_written(
        words in prop::collection::vec(
            (prop::sample::select("GXYZIJKRFPNM%(;\n".chars().collect::<Vec<_>>()), -100.0..100.0_f64),
            0..60,
        ),
        codes in prop::collection::vec(prop::sample::select(vec![0, 1, 2, 3, 4, 17, 18, 19, 20, 21, 61, 64, 90, 91]), 60),
    ) {
        let mut text = String::new();
        for ((letter, value), code) in words.iter().zip(&codes) {
            match letter {
                'G' => text.push_str(&format!("G{code} ")),
                'M' => text.push_str("M2 "),
                '%' | '(' | ';' | '\n' => text.push('\n'),
                'F' => text.push_str(&format!("F{} ", value.abs())),
                letter => text.push_str(&format!("{letter}{value:.3} ")),
            }
        }
        if let Ok(program) = parse(&text) {
            let made = program.structured_text("CS1", "M");
            prop_assert!(!made.text.contains("NaN") && !made.text.contains("inf"), "{text}\n{}", made.text);
            prop_assert!(arcline_structured_text::Program::parse(&made.text).is_ok(), "{text}\n{}", made.text);
            prop_assert_eq!(made.lines.len(), program.steps.len());
        }
    }
}

//! Programs in, errors and requests out.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use arcline_instruction_set::{Object, UnboundOperand, predefined};
use arcline_tag::{PathError, TagPath, TagType, Value};

use crate::{Answer, Interpreter, Names, OPERATIONS_PER_TICK, Program, Request, RuntimeProblem, STATEMENTS_PER_TICK};

/// The names of the embedded default configuration, and a few tags.
struct Machine;

impl Names for Machine {
    fn is_object(&self, object: Object, name: &str) -> bool {
        self.objects(object)
            .iter()
            .any(|known| known.eq_ignore_ascii_case(name))
    }

    fn locate(&self, path: &TagPath) -> Option<Result<(), PathError>> {
        let tag = path.tag()?;
        // X is an axis; of the others any part will do.
        if tag.eq_ignore_ascii_case("X") {
            let axis = TagType::scalar(predefined::axis_cip_drive());
            return Some(axis.locate(path.rest()).map(drop));
        }
        let known = self.tags();
        known
            .iter()
            .any(|known| tag.eq_ignore_ascii_case(known))
            .then_some(Ok(()))
    }

    fn objects(&self, object: Object) -> Vec<String> {
        let names: &[&str] = match object {
            Object::MotionGroup => &["Motion"],
            Object::Axis => &["X", "Y", "Z", "S", "A", "B", "C"],
            Object::CoordinateSystem => &["CS1", "CS2", "CS3", "XY"],
        };
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    fn tags(&self) -> Vec<String> {
        ["X", "Y", "S", "CS1", "Move1", "Recipe", "Count", "Flag"]
            .map(str::to_owned)
            .to_vec()
    }
}

/// Answers a program from a table of numbers and prints its requests, one line each.
fn trace(text: &str, tags: &[(&str, f64)], limit: usize) -> String {
    let mut program = Program::parse(text).unwrap_or_else(|error| panic!("{error}"));
    program.check(&Machine).unwrap_or_else(|error| panic!("{error}"));
    let mut tags: BTreeMap<String, f64> = tags
        .iter()
        .map(|(name, value)| (name.to_ascii_lowercase(), *value))
        .collect();
    let mut interpreter = Interpreter::new(program);
    let mut answer = Answer::Start;
    let mut out = String::new();
    for _ in 0..limit {
        let request = match interpreter.resume(answer) {
            Ok(request) => request,
            Err(error) => {
                let _ = writeln!(out, "error {error}");
                break;
            }
        };
        answer = match request {
            Request::Read(path) => {
                let number = tags.get(&path.to_string().to_ascii_lowercase()).copied();
                match number {
                    Some(number) => Answer::Value(Value::Lreal(number)),
                    None => Answer::Value(Value::Bool(false)),
                }
            }
            Request::ReadArray(path) => {
                let _ = writeln!(out, "read array {path}");
                Answer::Array(vec![1.0, 2.0, 3.0])
            }
            Request::Write(path, value) => {
                let _ = writeln!(out, "{path} := {value:?}");
                tags.insert(path.to_string().to_ascii_lowercase(), value.as_f64());
                Answer::Done
            }
            Request::GetAttribute(of) => {
                let _ = writeln!(out, "get {} of {}", of.attribute.name, of.name);
                Answer::Value(Value::Lreal(7.0))
            }
            Request::SetAttribute(of, value) => {
                let _ = writeln!(out, "set {} of {} to {value}", of.attribute.name, of.name);
                Answer::Done
            }
            Request::Call(call) => {
                let operands: Vec<String> = call.operands.iter().map(ToString::to_string).collect();
                let control = call.control.unwrap_or_default();
                let _ = writeln!(
                    out,
                    "{} {} {control}: {} @{}",
                    call.mnemonic,
                    call.target,
                    operands.join(" "),
                    call.line
                );
                Answer::Done
            }
            Request::NextTick => {
                let _ = writeln!(out, "tick");
                Answer::Done
            }
            Request::Delay(seconds) => {
                let _ = writeln!(out, "delay {seconds}");
                Answer::Done
            }
            Request::End => {
                let _ = writeln!(out, "end");
                break;
            }
        };
    }
    out
}

/// The value that an expression has.
fn value(expression: &str) -> String {
    let out = trace(&format!("Recipe := {expression};"), &[("Count", 7.0)], 100);
    out.lines().next().unwrap_or_default().replace("Recipe := ", "")
}

#[test]
fn expressions() {
    #[rustfmt::skip]
    let cases = [
        ("products bind tighter",            "1 + 2 * 3",               "Lreal(7.0)"),
        ("parentheses",                      "(1 + 2) * 3",             "Lreal(9.0)"),
        ("left to right",                    "10 - 3 - 2",              "Lreal(5.0)"),
        ("no integer division",              "7 / 2",                   "Lreal(3.5)"),
        ("the sign of the dividend",         "-7 MOD 3",                "Lreal(-1.0)"),
        ("division by zero",                 "1 / 0",                   "Lreal(inf)"),
        ("signs in a row",                   "- - 2 - -3",              "Lreal(5.0)"),
        ("a comparison",                     "1 + 1 = 2",               "Bool(true)"),
        ("comparisons before AND before OR", "1 > 2 AND FALSE OR TRUE", "Bool(true)"),
        ("XOR between AND and OR",           "TRUE OR TRUE XOR TRUE",   "Bool(true)"),
        ("NOT binds tightest",               "NOT FALSE AND FALSE",     "Bool(false)"),
        ("bits of integers",                 "6 AND 3",                 "Lreal(2.0)"),
        ("all bits",                         "NOT 0",                   "Lreal(-1.0)"),
        ("another spelling of AND",          "6 & 3",                   "Lreal(2.0)"),
        ("a tag",                            "Count * 2",               "Lreal(14.0)"),
        ("a truth value compared",           "TRUE = 1",                "Bool(true)"),
        ("a truth value is no number",       "TRUE + 1",                "error line 1: found a BOOL, expected a number"),
        ("no bits in a fraction",            "1.5 OR 1",                "error line 1: found 1.5, expected an integer for the bits of it"),
        ("case is ignored",                  "True aNd (count MOD 2 = 1)", "Bool(true)"),
    ];
    for (why, expression, expected) in cases {
        assert_eq!(value(expression), expected, "{why}: {expression}");
    }
}

#[test]
fn programs_ask_in_order() {
    #[rustfmt::skip]
    let cases = [
        ("a loop over a variable of the program", "FOR i := 1 TO 3 DO Recipe[i] := i * 10; END_FOR;",
         "Recipe[1] := Lreal(10.0)\nRecipe[2] := Lreal(20.0)\nRecipe[3] := Lreal(30.0)\nend\n"),
        ("downwards", "FOR i := 3 TO 1 BY -2 DO Count := i; END_FOR;",
         "Count := Lreal(3.0)\nCount := Lreal(1.0)\nend\n"),
        ("not at all", "FOR i := 3 TO 1 DO Count := i; END_FOR;", "end\n"),
        ("a tag as the variable", "FOR Count := 1 TO 1 DO END_FOR;",
         "Count := Lreal(1.0)\nCount := Lreal(2.0)\nend\n"),
        ("no step", "\nFOR i := 1 TO 3 BY 0 DO Count := i; END_FOR;",
         "error line 2: the step of FOR is 0, expected a number other than 0\n"),
        ("IF", "IF Count = 6 THEN Flag := 1; ELSIF Count = 7 THEN Flag := 2; ELSE Flag := 3; END_IF;",
         "Flag := Lreal(2.0)\nend\n"),
        ("ELSE", "IF FALSE THEN Flag := 1; ELSE Flag := 3; END_IF;", "Flag := Lreal(3.0)\nend\n"),
        ("WHILE", "n := 0; WHILE n < 2 DO n := n + 1; Count := n; END_WHILE;",
         "Count := Lreal(1.0)\nCount := Lreal(2.0)\nend\n"),
        ("REPEAT runs once at least", "REPEAT Count := 1; UNTIL TRUE END_REPEAT;", "Count := Lreal(1.0)\nend\n"),
        ("EXIT leaves the inner loop", "FOR i := 1 TO 2 DO WHILE TRUE DO EXIT; END_WHILE; Count := i; END_FOR;",
         "Count := Lreal(1.0)\nCount := Lreal(2.0)\nend\n"),
        ("DELAY", "DELAY(0.5 * 2);", "delay 1\nend\n"),
        ("time does not go back", "DELAY(-1);", "error line 1: DELAY is -1 s, expected 0 or more\n"),
        ("WAIT looks once a tick", "n := 0; WHILE n < 2 DO n := n + 1; END_WHILE; WAIT(Count = 8);",
         "tick\ntick\ntick\n"),
        ("a truth value is written as one", "Flag := Count > 6;", "Flag := Bool(true)\nend\n"),
        ("an index that is none", "Recipe[0 - 1] := 1;",
         "error line 1: the array index is -1, expected a whole number, 0 or more\n"),
        ("words, arrays, parts of arrays",
         "MCLM(CS1, M1, Absolute, [1, 2 * 3, -Count], Count, Units per sec, 2, %ofMaximum);\nMCLM(CS1, M1, 1, Recipe[4]);",
         "MCLM CS1 M1: 0 an array of 3 7 0 2 1 @1\nread array Recipe[4]\nMCLM CS1 M1: 1 an array of 3 @2\nend\n"),
        ("the control stands third", "MCT(CS2, CS3, T1c, [0, 0, 0], [0, 0, 0]);",
         "MCT CS2 T1c: \"CS3\" an array of 3 an array of 3 @1\nend\n"),
        ("a radius is a number", "MCCM(XY, M1, 0, [1, 2], 2, -60.0, 0);",
         "MCCM XY M1: 0 an array of 2 2 -60 0 @1\nend\n"),
        ("a variable with a word of other dialects", "case := 2; Count := case;", "Count := Lreal(2.0)\nend\n"),
        ("no control", "MSO(X);", "MSO X :  @1\nend\n"),
        ("an attribute is read and set", "GSV(Axis, X, MaximumSpeed, Recipe[1 + 1]);\nssv(coordinatesystem, CS1, dynamicsconfigurationbits, 8 - Count);",
         "get MaximumSpeed of X\nRecipe[2] := Lreal(7.0)\nset DynamicsConfigurationBits of CS1 to 1\nend\n"),
        ("an attribute in a variable", "GSV(Axis, X, DynamicsConfigurationBits, bits); Count := bits + 1;",
         "get DynamicsConfigurationBits of X\nCount := Lreal(8.0)\nend\n"),
        ("nothing", " ; ; // only this\n", "end\n"),
    ];
    for (why, text, expected) in cases {
        let limit = if why.starts_with("WAIT") { 6 } else { 100 };
        assert_eq!(trace(text, &[("Count", 7.0)], limit), expected, "{why}: {text}");
    }
}

#[test]
fn errors_have_a_place() {
    #[rustfmt::skip]
    let cases = [
        ("the call has no end", "MCLM(CS1, M1, 0, [1,2,3], 10\n", "line 2, column 1: found the end of the program, expected `,` or `)` behind the operand"),
        ("the array has no end", "MCLM(CS1, M1, 0, [1,2", "line 1, column 22: found the end of the program, expected `,` or `]`"),
        ("no semicolon", "a := 1\nb := 2;", "line 2, column 1: found `b`, expected `;` at the end of the statement"),
        ("no instruction", "MCML(CS1, M1);", "line 1, column 1: there is no instruction `MCML`, did you mean `MCLM`?"),
        ("no coordinate system", "MCLM(CS9, M1, 0);", "line 1, column 6: there is no coordinate system `CS9`, did you mean `CS3`?"),
        ("an axis is none", "MCLM(X, M1, 0);", "line 1, column 6: `X` is an axis, and this operand is a coordinate system"),
        ("no such word", "MCS(CS1, S1, Al);", "line 1, column 14: operand 2 (Stop Type) has no word `Al`, did you mean `All`?"),
        ("a percentage of nothing", "MCS(CS1, S1, All, Yes, 1, %ofNothing);", "line 1, column 27: operand 5 (Decel Units) has no word `%ofNothing`"),
        ("no such tag", "Count := Recip + 1;", "line 1, column 10: there is no tag `Recip`, did you mean `Recipe`?"),
        ("no such member", "MSO(X, M1); WAIT(M1.PX);", "line 1, column 18: MOTION_INSTRUCTION has no member \"PX\""),
        ("a slip in a member", "Count := X.ActualPositon;", "line 1, column 10: AXIS_CIP_DRIVE has no member \"ActualPositon\", did you mean \"ActualPosition\"?"),
        ("a slip in a control's member", "MSO(X, M1); WAIT(M1.Stat = 0);", "line 1, column 18: MOTION_INSTRUCTION has no member \"Stat\", did you mean \"STATE\"?"),
        ("a variable that nothing assigns", "Count := i;", "line 1, column 10: there is no tag `i`"),
        ("an object of another kind", "MSO(CS1, M1);", "line 1, column 5: `CS1` is a coordinate system, and this operand is an axis"),
        ("too many operands", "MSO(X, M1, 1);", "line 1, column 12: MSO has 2 operands, this is one too many"),
        ("a comment without end", "a := 1; (* b", "line 1, column 9: the comment that begins here has no end, expected `*)`"),
        ("a character of no meaning", "a := 1 $ 2;", "line 1, column 8: found the character '$', which has no meaning here"),
        ("columns count characters", "(* äöü² *) $", "line 1, column 12: found the character '$', which has no meaning here"),
        ("a keyword is no name", "IF := 1;", "line 1, column 4: found `:=`, expected a number, a tag or `(`"),
        ("IF has no end", "IF TRUE THEN a := 1;", "line 1, column 21: found the end of the program, expected a statement, ELSIF, ELSE or END_IF"),
        ("an end without beginning", "END_IF;", "line 1, column 1: found `END_IF`, expected a statement"),
        ("EXIT outside of a loop", "EXIT;", "line 1, column 1: found `EXIT`, expected it only within FOR, WHILE or REPEAT"),
        ("a number too large", "Count := 1e999;", "line 1, column 10: `1e999` is not a number that can be read"),
        ("a bit too far", "Count := Count.64;", "line 1, column 16: found `64`, expected a bit from 0 to 63"),
        ("a class without attributes", "GSV(Program, X, MaximumSpeed, Count);", "line 1, column 5: found `Program`, expected the class Axis or CoordinateSystem"),
        ("no axis with attributes", "GSV(Axis, CS1, MaximumSpeed, Count);", "line 1, column 11: `CS1` is a coordinate system, and this operand is an axis"),
        ("no attribute", "GSV(Axis, X, MaxSpeed, Count);", "line 1, column 14: GSV and SSV know no attribute `MaxSpeed` of an object of the class axis, did you mean `MaximumSpeed`?"),
        ("an attribute of the configuration", "SSV(Axis, X, MaximumSpeed, 5);", "line 1, column 14: SSV cannot set MaximumSpeed, only the configuration can; GSV reads it"),
        ("no destination", "GSV(Axis, X, MaximumSpeed, 5);", "line 1, column 28: found `5`, expected the tag or variable of the destination"),
        ("no source", "SSV(Axis, X, DynamicsConfigurationBits);", "line 1, column 39: found `)`, expected `,` and the source behind the attribute"),
        ("CASE of other dialects", "CASE Count OF 1: a := 2; END_CASE;", "line 1, column 1: this Structured Text has no CASE statement: use IF, ELSIF and ELSE"),
        ("RETURN of other dialects", "a := 1;\nRETURN;", "line 2, column 1: this Structured Text has no RETURN statement: a program ends"),
        ("a subroutine", "JSR(Other);", "line 1, column 1: this Structured Text has no JSR statement: a program is one text"),
        ("a declaration", "VAR x : DINT; END_VAR", "line 1, column 1: this Structured Text has no VAR statement: a name that a program assigns"),
        ("a function", "a := 1 + ABS(-3);", "line 1, column 10: this Structured Text has no function ABS: operators are"),
        ("a power", "a := 2 ** 3;", "line 1, column 9: this Structured Text has no operator **: multiply"),
        ("a point without digit", "a := .5;", "line 1, column 6: this Structured Text has no number that begins with its point: write 0.5 for .5"),
        ("a retentive assignment", "Count [:=] 2;", "line 1, column 8: this Structured Text has no assignment [:=]: use :="),
        ("a comment of C", "/* x */ a := 1;", "line 1, column 1: this Structured Text has no comment /* */: comments are // and (* *)"),
        ("an operand is missing", "MCLM(CS1, M1, , 1);", "line 1, column 15: found `,`, expected a number, a tag or `(`"),
    ];
    for (why, text, expected) in cases {
        let result = Program::parse(text).and_then(|mut program| program.check(&Machine));
        let error = result.expect_err(why).to_string();
        let first = error.lines().next().unwrap_or_default();
        assert!(
            first.starts_with(expected),
            "{why}: {text}\n   found {first}\nexpected {expected}"
        );
    }
}

#[test]
fn the_excerpt_points_at_the_place() {
    let error = Program::parse("MSO(X, M1);\nMCLM(CS1, M1, 0 1);").expect_err("no comma");
    let lines: Vec<String> = error.to_string().lines().map(str::to_owned).collect();
    assert_eq!(lines[1], "  MCLM(CS1, M1, 0 1);");
    assert_eq!(lines[2], "                  ^");
    assert_eq!((error.line, error.column), (2, 17));
}

#[test]
fn nesting_is_bounded() {
    let deep = format!("a := {}1{};", "(".repeat(100_000), ")".repeat(100_000));
    assert!(Program::parse(&deep).is_err());
    assert!(Program::parse(&"IF TRUE THEN ".repeat(100_000)).is_err());
    let signs = format!("a := {}1;", "-".repeat(100_001));
    assert!(Program::parse(&signs).is_ok());
    let fine = format!("a := {}1{};", "(".repeat(50), ")".repeat(50));
    assert!(Program::parse(&fine).is_ok());
}

#[test]
fn a_loop_without_wait_hangs_nothing() {
    let mut program = Program::parse("WHILE TRUE DO END_WHILE;").expect("a loop");
    program.check(&Machine).expect("no names");
    let mut interpreter = Interpreter::new(program);
    assert_eq!(interpreter.resume(Answer::Start), Ok(Request::NextTick));
    assert_eq!(interpreter.resume(Answer::Done), Ok(Request::NextTick));
    const { assert!(STATEMENTS_PER_TICK >= 10_000) };
}

/// A statement counts once however long its expression is; its operations are counted too.
#[test]
fn a_loop_of_long_expressions_goes_on_in_the_next_tick() {
    let sum = "1+".repeat(5000);
    let mut program = Program::parse(&format!("WHILE TRUE DO Count := {sum}1; END_WHILE;")).expect("a loop");
    program.check(&Machine).expect("known names");
    let mut interpreter = Interpreter::new(program);
    let mut answer = Answer::Start;
    for tick in 0..3 {
        let mut turns = 0;
        while let Request::Write(..) = interpreter.resume(answer).expect("it runs") {
            answer = Answer::Done;
            turns += 1;
            assert!(turns * 10_000 <= OPERATIONS_PER_TICK + 10_000, "tick {tick}");
        }
        assert!(turns * 10_000 > OPERATIONS_PER_TICK / 2, "tick {tick}");
        answer = Answer::Done;
    }
}

/// PC and IP of M1 are FALSE for good; A is FALSE and may change.
#[test]
fn a_wait_is_hopeless_when_settled_values_decide_it() {
    #[rustfmt::skip]
    let cases = [
        ("M1.PC",                      true),
        ("M1.IP OR M1.PC",             true),
        ("M1.PC = 1",                  true),
        ("NOT M1.PC AND M1.IP",        true),
        ("M1.PC AND A",                true),
        ("A AND M1.PC",                true),
        ("M1.PC OR A",                 false),
        ("A",                          false),
        ("NOT M1.PC AND A",            false),
        ("M1.PC AND A OR A",           false),
        ("M1.PC XOR A",                false),
        ("FALSE",                      false),
    ];
    for (condition, hopeless) in cases {
        let program = Program::parse(&format!("WAIT({condition});")).unwrap_or_else(|error| panic!("{error}"));
        let mut interpreter = Interpreter::new(program);
        let mut answer = Answer::Start;
        // Twice: the second evaluation comes behind a tick.
        for _ in 0..2 {
            loop {
                match interpreter.resume(answer).expect("it runs") {
                    Request::Read(path) if path.tag() == Some("M1") => answer = Answer::Settled(Value::Bool(false)),
                    Request::Read(_) => answer = Answer::Value(Value::Bool(false)),
                    Request::NextTick => break,
                    other => panic!("{condition}: {other:?}"),
                }
            }
            assert_eq!(interpreter.is_hopeless(), hopeless, "{condition}");
            answer = Answer::Done;
        }
    }
}

#[test]
fn a_full_queue_repeats_the_call() {
    let mut program = Program::parse("i := 5;\nMCLM(CS1, M1, 0, [i, 0, 0], 10);").expect("a move");
    program.check(&Machine).expect("known names");
    let mut interpreter = Interpreter::new(program);
    let first = interpreter.resume(Answer::Start).expect("the call");
    let Request::Call(call) = &first else {
        panic!("a call, not {first:?}")
    };
    assert_eq!(call.operands[1], UnboundOperand::Array(vec![5.0, 0.0, 0.0]));
    assert_eq!(interpreter.resume(Answer::QueueFull), Ok(Request::NextTick));
    assert_eq!(interpreter.resume(Answer::Done), Ok(first.clone()));
    assert_eq!(interpreter.resume(Answer::QueueFull), Ok(Request::NextTick));
    assert_eq!(interpreter.resume(Answer::Done), Ok(first));
    assert_eq!(interpreter.line(), 2);
    assert_eq!(interpreter.resume(Answer::Done), Ok(Request::End));
    assert_eq!(interpreter.resume(Answer::Done), Ok(Request::End));
}

#[test]
fn a_wrong_answer_is_the_drivers_fault() {
    let mut interpreter = Interpreter::new(Program::parse("DELAY(1);").expect("a delay"));
    let error = interpreter.resume(Answer::Done).expect_err("nothing was asked");
    assert_eq!(error.problem, RuntimeProblem::Answer { asked: "nothing yet" });
    assert_eq!(interpreter.resume(Answer::Start), Ok(Request::End));
}

#[test]
fn calls_are_listed() {
    let program = Program::parse("MSO(x, m1);\n  MCS (CS1, S1, All, No);mso(Y, M1);").expect("calls");
    let calls: Vec<_> = program.calls().collect();
    assert_eq!(calls.len(), 3);
    assert_eq!(
        (calls[1].target.as_str(), calls[1].control.as_deref()),
        ("CS1", Some("S1"))
    );
    assert_eq!((calls[1].line, calls[1].column), (2, 3));
    assert_eq!(program.control_tags().collect::<Vec<_>>(), ["m1", "S1"]);
}

#[test]
fn one_call() {
    #[rustfmt::skip]
    let cases = [
        ("as it is", "MSO(X, M1)", true), ("with its end", " MSO(X, M1); ", true),
        ("two", "MSO(X, M1); MSO(Y, M1);", false), ("none", "", false), ("no call", "a := 1;", false),
    ];
    for (why, text, fine) in cases {
        assert_eq!(Program::parse_call(text).is_ok(), fine, "{why}: {text}");
    }
}

/// The Structured Text lines of the reference pages, verbatim.
#[test]
fn the_seeds_lines() {
    struct Anything;
    impl Names for Anything {
        fn is_object(&self, _: Object, _: &str) -> bool {
            true
        }
        fn locate(&self, path: &TagPath) -> Option<Result<(), PathError>> {
            path.tag()?.to_ascii_lowercase().starts_with("my").then_some(Ok(()))
        }
    }
    let lines = [
        "MCCM(myMccmCoordinateSystem, myMccmMotionControl, myMccmMoveType, myMccmPosition[0], myMccmCircleType, myMccmRadius[0], myMccmDirection, myMccmSpeed, Unitspersec, myMccmAccelRate, Unitspersec2, myMccmDecelRate, Unitspersec2, Trapezoidal, 100.0, 100.0, %ofTime, myMccmTermType, CoordinatedMotion, Programmed, 0, 0, None, 0, 0);",
        "MCCD(myMccdCoordinateSystem, myMccdMotionControl, CoordinatedMove, Yes, MyMccdSpeed, Unitspersec, Yes, MyMsccdAccelRate, Unitspersec2, Yes, MyMccdDecelRate, Unitspersec2, Yes, 100.0, Yes, 100.0, %ofTime, ActiveMotion);",
        "MCS (myMcsCoordinateSystem, myMcsMotionControl, All, Yes, myMcsDecelRate, Unitspersec2, Yes, 100.0, % of Time);",
    ];
    let mut program = Program::parse(&lines.join("\n")).unwrap_or_else(|error| panic!("{error}"));
    program.check(&Anything).unwrap_or_else(|error| panic!("{error}"));
    let mut interpreter = Interpreter::new(program);
    let mut answer = Answer::Start;
    let mut operands = Vec::new();
    loop {
        answer = match interpreter.resume(answer).expect("a request") {
            Request::Read(_) => Answer::Value(Value::Real(2.0)),
            Request::ReadArray(_) => Answer::Array(vec![1.0, 2.0]),
            Request::Call(call) => {
                operands.push(call.operands);
                Answer::Done
            }
            Request::End => break,
            other => panic!("unexpected {other:?}"),
        };
    }
    assert_eq!(operands.iter().map(Vec::len).collect::<Vec<_>>(), [23, 16, 7]);
    assert_eq!(operands[0][1], UnboundOperand::Array(vec![1.0, 2.0]));
    let percent_of_time = UnboundOperand::Number(2.0);
    assert_eq!(
        (&operands[0][14], &operands[2][6]),
        (&percent_of_time, &percent_of_time)
    );
}

#[test]
fn superscripts_and_hyphens() {
    let out = trace(
        "MCLM(CS1, M1, 0, [0], 1, Unitspersec, 1, Unitspersec², 1, Units per sec2, S-curve, 1, 1, unitspersec³);",
        &[],
        10,
    );
    assert_eq!(out, "MCLM CS1 M1: 0 an array of 1 1 0 1 0 1 0 1 1 1 0 @1\nend\n");
}

mod hostile {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_text_is_a_program_or_an_error(text in "\\PC{0,80}") {
            let _ = Program::parse(&text).map(|mut program| program.check(&Machine));
            let _ = Program::parse_call(&text);
        }

        #[test]
        fn any_tokens_run_or_are_refused(tokens in proptest::collection::vec(prop::sample::select(TOKENS), 0..40)) {
            let text = tokens.join(" ");
            if let Ok(mut program) = Program::parse(&text) {
                let _ = program.check(&Machine).map_err(|error| error.to_string());
                let mut interpreter = Interpreter::new(program);
                let mut answer = Answer::Start;
                for _ in 0..50 {
                    let Ok(request) = interpreter.resume(answer) else { break };
                    answer = match request {
                        Request::Read(_) => Answer::Value(Value::Dint(1)),
                        Request::GetAttribute(_) => Answer::Value(Value::Lreal(1.0)),
                        Request::ReadArray(_) => Answer::Array(Vec::new()),
                        Request::End => break,
                        _ => Answer::Done,
                    };
                }
            }
        }
    }

    const TOKENS: &[&str] = &[
        "GSV(Axis, X, MaximumSpeed,",
        "SSV(Axis, X, DynamicsConfigurationBits,",
        "IF",
        "THEN",
        "ELSE",
        "ELSIF",
        "END_IF",
        "FOR",
        "TO",
        "BY",
        "DO",
        "END_FOR",
        "WHILE",
        "END_WHILE",
        "REPEAT",
        "UNTIL",
        "END_REPEAT",
        "EXIT",
        "WAIT",
        "DELAY",
        "(",
        ")",
        "[",
        "]",
        ",",
        ";",
        ";",
        ";",
        ":=",
        "+",
        "-",
        "*",
        "/",
        "=",
        "<",
        "AND",
        "NOT",
        "MOD",
        "1",
        "0",
        "2.5",
        "a",
        "b",
        "Recipe",
        ".",
        "MSO",
        "MCS",
        "CS1",
        "X",
        "M1",
        "All",
        "Yes",
        "%",
        "of",
        "Time",
        "TRUE",
        "a := 1 ;",
        "MSO ( X , M1 ) ;",
        "a",
    ];
}

/// A machine on which every instruction has ended at once, unless its axis is Z; each call is noted with its line.
#[derive(Default)]
struct Ended {
    calls: Vec<(usize, String)>,
    pauses: usize,
    room: usize,
    reported: Vec<usize>,
}

impl crate::Driver for Ended {
    type Error = &'static str;
    type Execution = ();

    const MOST_READS: usize = 1;

    async fn turn(&mut self, _line: usize) -> Result<(), &'static str> {
        Ok(())
    }
    async fn read(&mut self, _path: &TagPath, _calls: &crate::Calls<()>) -> Result<crate::Reading, &'static str> {
        Ok(crate::Reading::Settled(Value::Bool(false)))
    }
    async fn read_array(&mut self, _path: &TagPath) -> Result<Vec<f64>, &'static str> {
        Ok(vec![0.0])
    }
    async fn write(&mut self, _path: &TagPath, _value: Value) -> Result<(), &'static str> {
        Err("read only")
    }
    async fn attribute(&mut self, _of: &crate::ObjectAttribute) -> Result<f64, &'static str> {
        Ok(0.0)
    }
    async fn set_attribute(&mut self, _of: &crate::ObjectAttribute, _value: f64) -> Result<(), &'static str> {
        Ok(())
    }
    async fn has_room(&mut self, _call: &crate::EvaluatedCall) -> Result<bool, &'static str> {
        self.room += 1;
        Ok(self.room.is_multiple_of(2))
    }
    async fn call(&mut self, call: &crate::EvaluatedCall) -> Result<(), &'static str> {
        self.calls.push((call.line, call.target.clone()));
        if call.target == "Y" { Err("erred") } else { Ok(()) }
    }
    async fn pause(&mut self, pause: crate::Pause<'_>) -> Result<(), &'static str> {
        self.pauses += usize::from(matches!(pause, crate::Pause::Room(_)));
        Ok(())
    }
    async fn progress(&mut self, called: &crate::Called<()>) -> Result<crate::Progress<&'static str>, &'static str> {
        Ok(if called.target == "Z" {
            crate::Progress::Erred("erred later")
        } else {
            crate::Progress::Ended
        })
    }
    async fn stopped(
        &mut self,
        _called: &crate::Called<()>,
    ) -> Result<Option<crate::Stopped<&'static str>>, &'static str> {
        Ok(None)
    }
    async fn outcome(
        &mut self,
        _tag: &str,
        called: Option<&crate::Called<()>>,
    ) -> Result<crate::Outcome, &'static str> {
        Ok(crate::Outcome {
            call: called.map(|called| (called.mnemonic, called.line)),
            control: arcline_instruction_set::MotionControl::default(),
            ending: None,
        })
    }
    fn err(error: &&'static str) -> Option<i16> {
        error.starts_with("erred").then_some(9)
    }
    fn report(&mut self, called: &crate::Called<()>, _error: &&'static str) {
        self.reported.push(called.line);
    }
}

/// The lines of calls and errors behind the first piece count on; room, errors and hopeless waits are the loop's.
#[test]
fn the_loop_counts_lines_over_pieces_and_applies_its_policy() {
    use crate::{OnError, Policy, ProgramRun, immediately};
    let piece = |text: &str| Interpreter::new(Program::parse(text).expect(text));
    // why, piece, lines before it, keeps going, how it ends, lines of calls, lines that were reported
    #[rustfmt::skip]
    let cases = [
        ("a call",                       "\nMSO(X, M);",              0, false, "",                     vec![2],  vec![]),
        ("a call behind other pieces",   "\nMSO(X, M);",              9, false, "",                     vec![11], vec![]),
        ("an error",                     "MSO(X, M);\nMSO(Y, N);",    9, false, "line 11: erred",       vec![10, 11], vec![11]),
        ("the same, and it goes on",     "MSO(Y, N);\nMSO(X, M);",    9, true,  "",                     vec![10, 11], vec![10]),
        ("an error after its call",      "MSO(Z, N);\nDELAY(1);\nMSO(X, M);", 9, false, "line 10: erred later", vec![10], vec![10]),
        ("at the end, without a pause",  "MSO(Z, N);",                0, false, "line 1: erred later",  vec![1],  vec![1]),
        ("a refused write",              "\nT := 1;",                 9, false, "line 11: read only",   vec![],   vec![]),
        ("no number",                    "\nDELAY(TRUE);",            9, false, "line 11: found a BOOL, expected a number", vec![], vec![]),
        ("a wait in vain",               "MSO(X, M);\nWAIT(M.PC);",   9, false, "line 11: WAIT can no longer come true: M was never executed", vec![10], vec![]),
        ("a move that waits for room",   "MCLM(XY, M, 0, [1, 2], 3);", 0, false, "",                     vec![1],  vec![]),
    ];
    for (why, text, before, keeps_going, end, calls, reported) in cases {
        let on_error = if keeps_going { OnError::KeepGoing } else { OnError::Stop };
        let policy = Policy {
            on_error,
            ..Policy::default()
        };
        let mut driver = Ended::default();
        let mut run = ProgramRun::new(Interpreter::empty(), policy);
        let result = immediately(async {
            run.run(&mut driver).await?;
            run.load(piece(text), before);
            run.run(&mut driver).await?;
            run.finish(&mut driver).await
        });
        let told = result.map_or_else(|error| error.to_string(), |()| String::new());
        assert_eq!(told, end, "{why}");
        let lines: Vec<usize> = driver.calls.iter().map(|(line, _)| *line).collect();
        assert_eq!((lines, driver.reported), (calls, reported), "{why}");
        assert_eq!(driver.pauses, usize::from(text.starts_with("MCLM")), "{why}");
    }
}

//! A project on the virtual clock: its run, and its tags by name.

use arcline_controller::Controller;
use arcline_controller::machine::Machine;
use arcline_simulation::{Blind, NotWritten, Observer};
use arcline_tag::{TagPath, TagValue, Value, WriteValue};

use crate::{End, LoadError, RunLimits, SimulatedCell, UnknownParts};

const CELL: &str = include_str!("../../../tests/config/Cell.L5X");

fn load(text: &str, unknown_parts: UnknownParts) -> Result<SimulatedCell, LoadError> {
    let machine = arcline_l5x::machine(text, "Cell.L5X").expect("a machine");
    let source = arcline_l5x::logic(text, "Cell.L5X").expect("a program");
    SimulatedCell::load(&machine, source, unknown_parts)
}

fn begun(text: &str) -> SimulatedCell {
    let mut cell = load(text, UnknownParts::Refused).expect("it runs");
    cell.begin(&mut Blind).expect("a prescan without a fault");
    cell
}

/// The project of the tests with more tags and other rungs.
fn with(tags: &str, rungs: &[&str]) -> String {
    let rungs: String = (0..)
        .zip(rungs)
        .map(|(number, text)| format!("<Rung Number=\"{number}\" Type=\"N\"><Text><![CDATA[{text}]]></Text></Rung>"))
        .collect();
    let begin = CELL
        .find("<Rung Number=\"0\" Type=\"N\"><Text><![CDATA[XIC(Start)")
        .expect("the first rung");
    let end = begin + CELL[begin..].find("</RLLContent>").expect("an end");
    let text = format!("{}{rungs}{}", &CELL[..begin], &CELL[end..]);
    text.replacen("</Tags>", &format!("{tags}</Tags>"), 1)
}

fn path(text: &str) -> TagPath {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn value(cell: &mut SimulatedCell, text: &str) -> TagValue {
    cell.value(&path(text))
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn number(cell: &mut SimulatedCell, text: &str) -> f64 {
    value(cell, text)
        .as_f64()
        .unwrap_or_else(|| panic!("{text} is no number"))
}

fn ticks(cell: &mut SimulatedCell, ticks: u64) -> End {
    let limits = RunLimits {
        until: None,
        ticks,
        time: f64::INFINITY,
    };
    cell.run(limits, &mut Blind)
}

#[test]
fn a_project_runs_to_its_condition_as_often_as_it_is_run() {
    let run = || {
        let mut cell = begun(CELL);
        cell.write("Start", &WriteValue::Bool(true)).expect("a tag");
        let until = cell
            .condition("Done AND Program:Main.Settle.ACC >= 50")
            .expect("a condition");
        let limits = RunLimits {
            until: Some(&until),
            ticks: u64::MAX,
            time: 10.0,
        };
        assert_eq!(cell.run(limits, &mut Blind), End::Reached);
        (cell.time(), cell.tags_json(), number(&mut cell, "X.CommandPosition"))
    };
    let (time, json, position) = run();
    assert!(time > 0.2 && time < 2.0, "{time}");
    assert_eq!(position, 25.0);
    assert_eq!((time, json, position), run());
}

#[test]
fn a_run_that_passes_over_uneventful_ticks_is_the_same_run() {
    struct Count(u64, bool);
    impl Observer for Count {
        fn needs_every_tick(&self) -> bool {
            self.1
        }
        fn tick(&mut self, _: u64, _: &Machine, _: &mut Controller) -> bool {
            self.0 += 1;
            true
        }
    }
    let run = |needs_every_tick| {
        let mut cell = begun(CELL);
        cell.write("Start", &WriteValue::Bool(true)).expect("a tag");
        let mut seen = Count(0, needs_every_tick);
        let mut shown = Vec::new();
        // The present state at times of which some are between two scans, too.
        for time in [0.05, 0.0513, 0.32, 0.3217, 2.0] {
            let limits = RunLimits {
                until: None,
                ticks: u64::MAX,
                time,
            };
            assert_eq!(cell.run(limits, &mut seen), End::Time);
            let positions = ["X.CommandPosition", "X.AverageVelocity"].map(|tag| number(&mut cell, tag));
            shown.push((cell.time(), cell.tags_json(), positions));
        }
        (seen.0, shown)
    };
    let ((all, every), (few, some)) = (run(true), run(false));
    assert_eq!(every, some);
    assert!(few < all, "{few} of {all}");
}

#[test]
fn a_run_ends_at_its_limits() {
    let mut cell = begun(CELL);
    assert!(cell.is_open());
    assert_eq!((ticks(&mut cell, 0), cell.is_open()), (End::Time, true));
    assert_eq!(
        (ticks(&mut cell, 1), cell.tick(), cell.is_open()),
        (End::Time, 0, false)
    );
    assert_eq!((ticks(&mut cell, 2), cell.tick()), (End::Time, 2));
    let limits = RunLimits {
        until: None,
        ticks: u64::MAX,
        time: 0.1,
    };
    assert_eq!(cell.run(limits, &mut Blind), End::Time);
    assert_eq!(cell.time(), 0.1);
}

#[test]
fn tags_are_read_and_written_by_name() {
    let tags = "<Tag Name=\"Grid\" TagType=\"Base\" DataType=\"DINT\" Dimensions=\"2 3\"/>\
        <Tag Name=\"Flags\" TagType=\"Base\" DataType=\"BOOL\" Dimensions=\"40\"/>\
        <Tag Name=\"Word\" TagType=\"Base\" DataType=\"STRING\"/>";
    let mut cell = begun(&with(tags, &["MOV(7,Grid[1,2]);", "OTE(Flags[33]);"]));
    ticks(&mut cell, 1);
    #[rustfmt::skip]
    let numbers = [
        ("a tag",                               "Target",                 25.0),
        ("a member",                            "Batch.Speed",            80.0),
        ("an element of a member",              "Batch.Steps[2]",         6.0),
        ("an alias",                            "Middle",                 5.0),
        ("an alias, in another case",           "middle",                 5.0),
        ("a tag that clients do not see",       "Secret",                 0.0),
        ("a tag of a program",                  "Program:Main.Settle.PRE", 50.0),
        ("an element of a table",               "Grid[1,2]",              7.0),
        ("an element of an array of BOOLs",     "Flags[33]",              1.0),
        ("its neighbour",                       "Flags[34]",              0.0),
        ("a bit of a number",                   "Fixed.2",                1.0),
        ("a member of an axis",                 "X.CommandPosition",      0.0),
    ];
    for (why, text, expected) in numbers {
        assert!(cell.has(&path(text)), "{why}: {text}");
        assert_eq!(number(&mut cell, text), expected, "{why}: {text}");
    }
    let dint = |number| TagValue::Value(Value::Dint(number));
    let row = |numbers: [i32; 3]| TagValue::Array(numbers.map(dint).to_vec());
    assert_eq!(value(&mut cell, "Batch.Steps"), row([4, 5, 6]));
    let grid = TagValue::Array(vec![row([0, 0, 0]), row([0, 0, 7])]);
    assert_eq!(value(&mut cell, "Grid"), grid);
    let TagValue::Array(flags) = value(&mut cell, "Flags") else {
        panic!("Flags is an array")
    };
    let on = |bit: usize| TagValue::Value(Value::Bool(bit == 33));
    assert_eq!(flags, (0..40).map(on).collect::<Vec<_>>());

    #[rustfmt::skip]
    let writes = [
        ("a number",                     "Target",           "12.5",     "Target",         12.5),
        ("a constant",                   "Fixed",            "13",       "Fixed",          13.0),
        ("a tag that clients do not see", "Secret",          "4",        "Secret",         4.0),
        ("an alias",                     "Middle",           "50",       "Batch.Steps[1]", 50.0),
        ("the first elements",           "Batch.Steps",      "[1, 2]",   "Batch.Steps[1]", 2.0),
        ("a bit of an array of BOOLs",   "Flags[39]",        "true",     "Flags[39]",      1.0),
        ("a bit of a number",            "Fixed.0",          "0",        "Fixed",          12.0),
        ("a tag of a program",           "Program:Main.Settle.PRE", "7", "Program:main.settle.pre", 7.0),
    ];
    for (why, text, new, read, expected) in writes {
        let Ok(new) = new.parse();
        cell.write(text, &new).unwrap_or_else(|error| panic!("{why}: {error}"));
        assert_eq!(number(&mut cell, read), expected, "{why}");
    }
    let row = WriteValue::Array(vec![WriteValue::Integer(1), WriteValue::Integer(9)]);
    cell.write("Grid", &WriteValue::Array(vec![row])).expect("a table");
    assert_eq!(number(&mut cell, "Grid[0,1]"), 9.0);
    cell.write("Word", &WriteValue::Text("ready".to_owned()))
        .expect("a text");
    assert_eq!(value(&mut cell, "Word"), TagValue::Text("ready".to_owned()));
}

#[test]
fn values_that_do_not_fit_are_refused_with_the_tag() {
    let tags = "<Tag Name=\"Flags\" TagType=\"Base\" DataType=\"BOOL\" Dimensions=\"40\"/>\
        <Tag Name=\"Word\" TagType=\"Base\" DataType=\"STRING\"/>";
    let mut cell = begun(&with(tags, &["NOP();"]));
    #[rustfmt::skip]
    let cases = [
        ("no path",            "Batch..Speed",   "1",       "no path of a tag"),
        ("no tag",             "Targt",          "1",       "there is no tag \"Targt\""),
        ("no member",          "Batch.Sped",     "1",       "did you mean \"Speed\"?"),
        ("no element",         "Batch.Steps[3]", "1",       "index 3 is out of range"),
        ("no bit",             "Flags[40]",      "true",    "index 40 is out of range"),
        ("no whole number",    "Fixed",          "1.5",     "Fixed is a DINT and holds whole numbers only"),
        ("a number too large", "Fixed",          "1e12",    "Fixed is a DINT and cannot hold that value"),
        ("no truth",           "Flags[3]",       "2",       "Flags[3] is a BOOL"),
        ("a text for a number", "Target",        "'ab'",    "Target is a REAL and holds values of another kind"),
        ("one in an array",    "Batch.Steps",    "[1, 2.5]", "Batch.Steps[1] is a DINT"),
        ("a read-only tag of the machine", "X.ActualPosition", "1", "X.ActualPosition"),
    ];
    for (why, text, new, expected) in cases {
        let Ok(new) = new.parse();
        let error = cell.write(text, &new).expect_err(why);
        assert!(error.to_string().contains(expected), "{why}: {error}");
    }
    let long = WriteValue::Text("x".repeat(83));
    assert!(matches!(cell.write("Word", &long), Err(NotWritten::Value(_))));
}

#[test]
fn a_major_fault_stops_the_tasks_and_says_where() {
    let text = with(
        "<Tag Name=\"At\" TagType=\"Base\" DataType=\"DINT\"/>",
        &["MOV(0,Batch.Steps[At]);"],
    );
    let mut cell = begun(&text);
    assert_eq!(ticks(&mut cell, 10), End::Time);
    cell.write("At", &WriteValue::Integer(3)).expect("a tag");
    let End::Fault(fault) = ticks(&mut cell, 10) else {
        panic!("a subscript out of range is a major fault")
    };
    let words = "major fault 4/20 (subscript out of range) in Main/Go rung 0, MOV: At is 3";
    assert_eq!(fault.to_string(), words);
    let tick = cell.tick();
    assert_eq!(ticks(&mut cell, 10), End::Fault(fault.clone()));
    assert_eq!((cell.tick(), cell.faults().collect()), (tick, vec![fault]));
}

#[test]
fn parts_that_do_not_run_are_named_or_passed_over() {
    let text = with("", &["PID(Batch);", "NOP();"]);
    let Err(LoadError::Parts(parts)) = load(&text, UnknownParts::Refused) else {
        panic!("PID is not supported")
    };
    let words = "Main/Go rung 0: instruction PID is not supported; 1 parts of the project do not run";
    assert_eq!(
        (parts.summary(), parts.to_string()),
        (words.to_owned(), words.to_owned())
    );
    let cell = load(&text, UnknownParts::Allowed).expect("the rest runs");
    assert_eq!(cell.findings(), parts.findings);
}

#[test]
fn what_names_a_tag_that_is_not_there_is_named_or_passed_over_and_an_error_is_neither() {
    let text = with("", &["XIC(Loop.Auto)OTL(Done);", "MOV(7,Target);"]);
    let Err(LoadError::Parts(parts)) = load(&text, UnknownParts::Refused) else {
        panic!("there is no tag Loop")
    };
    assert_eq!(
        parts.to_string(),
        "Main/Go rung 0: XIC(Loop.Auto): Data Bit Loop.Auto: there is no tag Loop; 1 parts of the project do not run"
    );
    let mut cell = load(&text, UnknownParts::Allowed).expect("the rest runs");
    assert_eq!(cell.findings(), parts.findings);
    cell.begin(&mut Blind).expect("a prescan without a fault");
    ticks(&mut cell, 1);
    assert_eq!((number(&mut cell, "Target"), number(&mut cell, "Done")), (7.0, 0.0));
    let wrong = with("", &["XIC(Target)OTL(Done);"]);
    assert!(
        load(&wrong, UnknownParts::Allowed).is_err(),
        "a number is no BOOL, and no part of a project that is missing"
    );
}

#[test]
fn an_array_of_one_motion_control_tag_moves_an_axis() {
    let tags = "<Tag Name=\"Moves\" TagType=\"Base\" DataType=\"MOTION_INSTRUCTION\" Dimensions=\"1\"/>\
        <Tag Name=\"Power\" TagType=\"Base\" DataType=\"MOTION_INSTRUCTION\" Dimensions=\"1\"/>";
    let rungs = [
        "MSO(X,Power[0]);",
        "XIC(Power[0].DN)MAM(X,Moves[0],0,Target,50,Units per sec,100,% of Maximum,100,% of Maximum,Trapezoidal,100,100,% of Time,Disabled,0,0,None,0,0);",
    ];
    let mut cell = begun(&with(tags, &rungs));
    ticks(&mut cell, 5000);
    assert_eq!(
        (number(&mut cell, "X.ActualPosition"), number(&mut cell, "Moves[0].PC")),
        (25.0, 1.0)
    );
}

#[test]
fn an_ssv_without_effect_is_named_when_the_project_is_loaded() {
    let tags = "<Tag Name=\"Date\" TagType=\"Base\" DataType=\"DINT\" Dimensions=\"7\"/>\
        <Tag Name=\"CS\" TagType=\"Base\" DataType=\"COORDINATE_SYSTEM\"><Data Format=\"CoordinateSystem\">\
        <CoordinateSystemParameters MotionGroup=\"Motion1\" SystemType=\"Cartesian\" Dimension=\"1\" Axes=\"X\" MaximumSpeed=\"50.0\" \
        MaximumAcceleration=\"500.0\" MaximumDeceleration=\"500.0\"/></Data></Tag>";
    #[rustfmt::skip]
    let cases = [
        ("a tolerance",            "CoordinateSystem,CS,CommandPositionTolerance,Target", true),
        ("a maximum of a system",  "CoordinateSystem,CS,MaximumSpeed,Target",             true),
        ("a maximum of an axis",   "Axis,X,MaximumDeceleration,Target",                   false),
        ("a member of a tag",      "Axis,X,ActualPosition,Target",                        false),
        ("the speed of homing",    "Axis,X,HomeSpeed,Target",                             true),
        ("the mode of homing",     "Axis,X,HomeMode,Target",                              false),
        ("the clock",              "WallClockTime,,DateTime,Date[0]",                     false),
        ("the clock in one",       "WallClockTime,,CurrentValue,Date[0]",                 false),
        ("bits of an axis",        "Axis,X,DynamicsConfigurationBits,Fixed",              true),
        ("bits of a system",       "CoordinateSystem,CS,DynamicsConfigurationBits,Fixed", true),
    ];
    for (why, operands, has_effect) in cases {
        load(&with(tags, &[&format!("GSV({operands});")]), UnknownParts::Refused)
            .unwrap_or_else(|error| panic!("{why}: GSV: {error}"));
        let loaded = load(&with(tags, &[&format!("SSV({operands});")]), UnknownParts::Refused);
        if has_effect {
            loaded.unwrap_or_else(|error| panic!("{why}: {error}"));
            continue;
        }
        let Err(LoadError::Parts(parts)) = loaded else {
            panic!("{why}: it has no effect");
        };
        let named: Vec<&str> = operands.split(',').take(3).collect();
        let words = format!("Main/Go rung 0: instruction SSV {} is not supported", named.join(" "));
        assert_eq!(
            parts.findings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            [words],
            "{why}"
        );
    }
}

/// The project of the tests with a tag of a type and its data.
fn with_data(kind: &str, data: &str) -> String {
    let tag = format!("<Tag Name=\"V\" TagType=\"Base\" DataType=\"{kind}\">{data}</Tag>");
    let types = "<DataType Name=\"Part\" Family=\"NoFamily\" Class=\"User\"><Members>\
        <Member Name=\"ZZZZZZZZZZPart0\" DataType=\"SINT\" Dimension=\"0\" Hidden=\"true\"/>\
        <Member Name=\"On\" DataType=\"BIT\" Dimension=\"0\" Hidden=\"false\" Target=\"ZZZZZZZZZZPart0\" BitNumber=\"0\"/>\
        <Member Name=\"Up\" DataType=\"BIT\" Dimension=\"0\" Hidden=\"false\" Target=\"ZZZZZZZZZZPart0\" BitNumber=\"1\"/>\
        <Member Name=\"Count\" DataType=\"DINT\" Dimension=\"0\" Hidden=\"false\"/>\
        <Member Name=\"Delay\" DataType=\"TIMER\" Dimension=\"0\" Hidden=\"false\"/>\
        <Member Name=\"Row\" DataType=\"REAL\" Dimension=\"2\" Hidden=\"false\"/></Members></DataType>";
    with(&tag, &["NOP();"]).replacen("</DataTypes>", &format!("{types}</DataTypes>"), 1)
}

#[test]
fn values_of_every_format_are_first_values() {
    let l5k = |text: &str| format!("<Data Format=\"L5K\"><![CDATA[{text}]]></Data>");
    let part = l5k("[2,-7,[0,500,3],[1.50000000e+000,2.5]]");
    let decorated = |inside: &str| format!("<Data Format=\"Decorated\">{inside}</Data>");
    let element = |index: u8, length: u8, text: &str| {
        format!(
            "<Element Index=\"[{index}]\"><Structure DataType=\"STRING\"><DataValueMember Name=\"LEN\" DataType=\"DINT\" Value=\"{length}\"/>\
             <DataValueMember Name=\"DATA\" DataType=\"STRING\"><![CDATA[{text}]]></DataValueMember></Structure></Element>"
        )
    };
    #[rustfmt::skip]
    let cases = [
        ("a number",              "DINT",                        l5k("42"),                        vec![("V", 42.0)]),
        ("another radix",         "DINT",                        l5k("16#ff"),                     vec![("V", 255.0)]),
        ("characters",            "DINT",                        l5k("'$00$00$00A'"),              vec![("V", 65.0)]),
        ("a real",                "REAL",                        l5k("-1.50000000e+000"),          vec![("V", -1.5)]),
        ("a bit",                 "BOOL",                        l5k("2#1"),                       vec![("V", 1.0)]),
        ("a timer",               "TIMER",                       l5k("[-2147483648,500,7]"),       vec![("V.PRE", 500.0), ("V.ACC", 7.0), ("V.EN", 1.0)]),
        ("an array, with blanks", "INT\" Dimensions=\"3",        l5k("[ 1,\n 2 , 3 ]"),           vec![("V[0]", 1.0), ("V[2]", 3.0)]),
        ("two dimensions",        "INT\" Dimensions=\"2 2",      l5k("[1,2,3,4]"),                vec![("V[1,0]", 3.0)]),
        ("rows",                  "INT\" Dimensions=\"2 2",      l5k("[[1,2],[3,4]]"),            vec![("V[1,0]", 3.0)]),
        ("bits",                  "BOOL\" Dimensions=\"32",      l5k(&format!("[2#0,2#1{}]", ",2#0".repeat(30))), vec![("V[0]", 0.0), ("V[1]", 1.0)]),
        ("a structure",           "Part",                        part.clone(),                     vec![("V.On", 0.0), ("V.Up", 1.0), ("V.Count", -7.0), ("V.Delay.PRE", 500.0), ("V.Row[1]", 2.5)]),
        ("structures",            "TIMER\" Dimensions=\"2",      l5k("[[0,1,0],[0,2,0]]"),        vec![("V[0].PRE", 1.0), ("V[1].PRE", 2.0)]),
        ("a text",                "STRING",                      l5k("[3,'a$'c$00$00']"),         vec![("V.LEN", 3.0), ("V.DATA[1]", 39.0)]),
        ("the bytes of a number", "DINT",                        "<Data>2A 01 00 00 </Data>".to_owned(), vec![("V", 298.0)]),
        ("names go first",        "DINT",                        format!("<Data>2A 00 00 00</Data>{}<Data Format=\"Decorated\"><DataValue DataType=\"DINT\" Value=\"7\"/></Data>", l5k("5")), vec![("V", 7.0)]),
        ("texts, the first one",  "STRING\" Dimensions=\"3",     "<Data>01 00 00 00 </Data><Data Format=\"String\" Length=\"1\"><![CDATA['x']]></Data>".to_owned(), vec![("V[0].LEN", 1.0), ("V[0].DATA[0]", 120.0), ("V[1].LEN", 0.0)]),
        ("texts, their bytes",    "STRING\" Dimensions=\"2",     format!("<Data>{}</Data><Data Format=\"String\"><![CDATA['x']]></Data>", format!("01 00 00 00 79{}", " 00".repeat(83)).repeat(2).replace("0001", "00 01")), vec![("V[1].DATA[0]", 121.0)]),
        ("texts, in L5K",         "STRING\" Dimensions=\"2",     format!("{}<Data Format=\"String\"><![CDATA['x']]></Data>", l5k("[[1,'x'],[2,'yz']]")), vec![("V[1].LEN", 2.0)]),
        ("a date",                "LINT",                        "<Data Format=\"Decorated\"><DataValue DataType=\"LINT\" Radix=\"Date/Time\" Value=\"DT#2020-01-31-12:00:00.000_001Z\"/></Data>".to_owned(), vec![("V", 1_580_472_000_000_001.0)]),
        ("a date in a zone",      "LINT",                        l5k("LDT#2020-03-01-00:00:00.000_000_000(UTC-05:00)"), vec![("V", 1_583_038_800e9)]),
        ("texts, one is empty",   "STRING\" Dimensions=\"2",     decorated(&format!("<Array DataType=\"STRING\" Dimensions=\"2\">{}{}</Array>", element(0, 0, ""), element(1, 2, "'ok'"))), vec![("V[0].LEN", 0.0), ("V[1].LEN", 2.0)]),
        ("a short text",          "STRING_16",                   l5k("[2,'ok']"),                  vec![("V.LEN", 2.0), ("V.DATA[1]", 107.0)]),
        ("a connection",          "CONNECTION_STATUS",           l5k("[1]"),                       vec![("V.RunMode", 1.0), ("V.ConnectionFaulted", 0.0)]),
        ("the least number",      "LINT",                        decorated("<DataValue DataType=\"LINT\" Value=\"-9223372036854775808\"/>"), vec![("V", -9_223_372_036_854_775_808.0)]),
        ("the greatest number",   "ULINT",                       decorated("<DataValue DataType=\"ULINT\" Value=\"18446744073709551615\"/>"), vec![("V", 18_446_744_073_709_551_615.0)]),
        ("no value",              "DINT",                        l5k(" "),                         vec![("V", 0.0)]),
    ];
    for (why, kind, data, expected) in cases {
        let mut cell =
            load(&with_data(kind, &data), UnknownParts::Refused).unwrap_or_else(|error| panic!("{why}: {error}"));
        cell.begin(&mut Blind).expect("a prescan without a fault");
        for (tag, expected) in expected {
            assert_eq!(number(&mut cell, tag), expected, "{why}: {tag}");
        }
    }
}

#[test]
fn a_first_value_that_is_not_read_is_named() {
    let l5k = |text: &str| format!("<Data Format=\"L5K\"><![CDATA[{text}]]></Data>");
    #[rustfmt::skip]
    let cases = [
        ("no end",             "DINT\" Dimensions=\"2", l5k("[1,2"),     "\"[1,2\" is not understood"),
        ("a word",             "DINT",                  l5k("ab"),       "\"ab\" is not understood"),
        ("too few members",    "TIMER",                 l5k("[500,0]"),  "TIMER has 2 values, expected 3"),
        ("too many elements",  "DINT\" Dimensions=\"2", l5k("[1,2,3]"),  "it has 3 elements, expected 2"),
        ("an add-on instance", "Adder",                 l5k("[1,2]"),    "an instance of Adder without names of its members"),
        ("too few bytes",      "DINT",                  "<Data>01 00</Data>".to_owned(), "it has 2 bytes, expected 4"),
        ("no bytes",           "DINT",                  "<Data>0x1</Data>".to_owned(),   "\"0x1\" is not understood"),
        ("a list for a number", "DINT",                 l5k("[1,2]"),    "it has 2 elements, expected 1"),
    ];
    for (why, kind, data, reason) in cases {
        let text = with_data(kind, &data);
        let Err(LoadError::Parts(parts)) = load(&text, UnknownParts::Refused) else {
            panic!("{why}: it is not read");
        };
        let words = format!("tag V: its first value is not that of the file: {reason}");
        assert_eq!(
            parts.findings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            [words],
            "{why}"
        );
        load(&text, UnknownParts::Allowed).unwrap_or_else(|error| panic!("{why}: {error}"));
    }
}

#[test]
fn the_task_of_a_home_event_runs_with_each_homing() {
    let tags = "<Tag Name=\"Homed\" TagType=\"Base\" DataType=\"DINT\" Radix=\"Decimal\" ExternalAccess=\"Read/Write\"/>\
                <Tag Name=\"H\" TagType=\"Base\" DataType=\"MOTION_INSTRUCTION\" ExternalAccess=\"Read/Write\"/>";
    let text = with(tags, &["XIC(Start)MAH(X,H);", "JSR(Count,0);"]);
    let program = "<Program Name=\"Home\" MainRoutineName=\"R\"><Tags/><Routines><Routine Name=\"R\" Type=\"RLL\"><RLLContent>\
                   <Rung Number=\"0\" Type=\"N\"><Text><![CDATA[ADD(Homed,1,Homed);]]></Text></Rung></RLLContent></Routine></Routines></Program></Programs>";
    let task = "<Task Name=\"OnHome\" Type=\"EVENT\" Priority=\"3\" Watchdog=\"500\"><EventInfo EventTrigger=\"Axis Home\" EventTag=\"X\" \
                EnableTimeout=\"false\"/><ScheduledPrograms><ScheduledProgram Name=\"Home\"/></ScheduledPrograms></Task></Tasks>";
    let text = text.replacen("</Programs>", program, 1).replacen("</Tasks>", task, 1);
    let mut cell = begun(&text);
    for count in 1..=3 {
        cell.write("Start", &WriteValue::Bool(true)).expect("a tag");
        ticks(&mut cell, 10);
        assert_eq!(
            number(&mut cell, "Homed"),
            f64::from(count),
            "{:?}",
            cell.faults().collect::<Vec<_>>()
        );
        assert_eq!(value(&mut cell, "H.PC").as_bool(), Some(true));
        assert_eq!(value(&mut cell, "X.HomeEventStatus").as_bool(), Some(true));
        cell.write("Start", &WriteValue::Bool(false)).expect("a tag");
        ticks(&mut cell, 10);
    }
}

#[test]
fn an_ssv_of_homing_counts_from_the_next_mah() {
    let tags = "<Tag Name=\"Place\" TagType=\"Base\" DataType=\"REAL\" ExternalAccess=\"Read/Write\"/>\
                <Tag Name=\"H\" TagType=\"Base\" DataType=\"MOTION_INSTRUCTION\" ExternalAccess=\"Read/Write\"/>\
                <Tag Name=\"Feed\" TagType=\"Alias\" AliasFor=\"X\"/>";
    let rungs = [
        "SSV(Axis,Feed,HomePosition,Place);",
        "XIC(Start)MAH(X,H);",
        "GSV(AXIS,feed,HomePosition,Target);",
    ];
    let mut cell = begun(&with(tags, &rungs));
    for place in [12.5, -3.0] {
        cell.write("Place", &WriteValue::Number(place)).expect("a tag");
        ticks(&mut cell, 10);
        cell.write("Start", &WriteValue::Bool(true)).expect("a tag");
        ticks(&mut cell, 10);
        assert_eq!(
            (number(&mut cell, "Target"), number(&mut cell, "X.ActualPosition")),
            (place, place)
        );
        cell.write("Start", &WriteValue::Bool(false)).expect("a tag");
        ticks(&mut cell, 10);
    }
}

/// The project of the tests with programs behind its own, in the same task: their tags, rungs, and connections of their parameters.
fn with_programs(tags: &str, programs: &[(&str, &str, &[&str])], connections: &[(&str, &str)]) -> String {
    let mut text = with(tags, &["NOP();"]);
    for (name, tags, rungs) in programs {
        let rungs: String = (0..)
            .zip(*rungs)
            .map(|(number, text)| {
                format!("<Rung Number=\"{number}\" Type=\"N\"><Text><![CDATA[{text}]]></Text></Rung>")
            })
            .collect();
        let program = format!(
            "<Program Name=\"{name}\" MainRoutineName=\"R\"><Tags>{tags}</Tags><Routines><Routine Name=\"R\" Type=\"RLL\">\
             <RLLContent>{rungs}</RLLContent></Routine></Routines></Program>"
        );
        text = text.replacen("</Programs>", &format!("{program}</Programs>"), 1);
        let scheduled = format!("<ScheduledProgram Name=\"{name}\"/></ScheduledPrograms>");
        text = text.replacen("</ScheduledPrograms>", &scheduled, 1);
    }
    let connections: String = connections
        .iter()
        .map(|(one, other)| format!("<ParameterConnection EndPoint1=\"{one}\" EndPoint2=\"{other}\"/>"))
        .collect();
    let connections = format!("<ParameterConnections>{connections}</ParameterConnections></Controller>");
    text.replacen("</Controller>", &connections, 1)
}

fn parameter(name: &str, kind: &str, usage: &str) -> String {
    format!("<Tag Name=\"{name}\" TagType=\"Base\" DataType={kind} Usage=\"{usage}\" ExternalAccess=\"Read/Write\"/>")
}

#[test]
fn parameters_of_programs_are_copied_around_their_scans() {
    let tags = "<Tag Name=\"A\" TagType=\"Base\" DataType=\"DINT\"/><Tag Name=\"B\" TagType=\"Base\" DataType=\"DINT\"/>\
        <Tag Name=\"Io\" TagType=\"Base\" DataType=\"DINT\"/><Tag Name=\"Two\" TagType=\"Base\" DataType=\"DINT\" Dimensions=\"2\"/>";
    let first = [
        parameter("In", "\"DINT\"", "Input"),
        parameter("Bit", "\"BOOL\"", "Input"),
        parameter("Row", "\"DINT\" Dimensions=\"2\"", "Input"),
        parameter("Sum", "\"DINT\"", "Output"),
        parameter("Io", "\"DINT\"", "InOut"),
        parameter("Open", "\"DINT\"", "Public"),
    ];
    let second = [
        parameter("From", "\"DINT\"", "Input"),
        parameter("Way", "\"DINT\"", "InOut"),
    ];
    let text = with_programs(
        tags,
        &[
            (
                "P1",
                &first.concat(),
                &["ADD(In,Row[1],Sum)ADD(Io,1,Io);", "XIC(Bit)MOV(5,Open);"],
            ),
            ("P2", &second.concat(), &["ADD(From,100,B)ADD(Way,1,Way);"]),
        ],
        &[
            ("\\P1.In", "A"),
            ("Start", "\\P1.Bit"),
            ("\\P1.Row", "Two"),
            ("\\P2.From", "\\P1.Sum"),
            ("\\P1.Io", "Io"),
            ("\\P2.Way", "\\P1.Open"),
        ],
    );
    let mut cell = begun(&text);
    for (tag, value) in [("A", 7), ("Two[1]", 3), ("Io", 40), ("Start", 1)] {
        cell.write(tag, &WriteValue::Integer(value)).expect(tag);
    }
    ticks(&mut cell, 1);
    let expected = [
        ("Program:P1.Sum", 10.0),
        ("B", 110.0),
        ("Io", 41.0),
        ("Program:P1.Open", 6.0),
        ("Program:P1.Io", 41.0),
    ];
    for (tag, value) in expected {
        assert_eq!(number(&mut cell, tag), value, "{tag}");
    }
}

#[test]
fn connections_that_do_not_take_place_are_named() {
    let tags = [
        parameter("In", "\"DINT\"", "Input"),
        parameter("Io", "\"DINT\"", "InOut"),
        parameter("Open", "\"DINT\"", "Public"),
    ];
    let connections = [("\\P1.In", "Batch"), ("\\P1.In", "Gone"), ("\\P1.Open", "Target")];
    let text = with_programs("", &[("P1", &tags.concat(), &["NOP();"])], &connections);
    let Err(LoadError::Parts(parts)) = load(&text, UnknownParts::Refused) else {
        panic!("they do not take place");
    };
    let found: Vec<String> = parts.findings.iter().map(ToString::to_string).collect();
    assert_eq!(
        found,
        [
            "tag \\P1.Open: its connection with Target does not take place: neither is an Input, Output or InOut parameter",
            "P1: tag Io: is a parameter by reference (InOut) without a connection",
            "tag \\P1.In: its connection with Batch does not take place: their types differ",
            "tag \\P1.In: its connection with Gone does not take place: there is no tag Gone",
        ]
    );
    load(&text, UnknownParts::Allowed).expect("the rest runs");
}

/// Texts of a project, and those in their places.
type Replacements<'t> = &'t [(&'t str, &'t str)];

#[test]
fn safety_and_phases_are_named_and_passed_over() {
    let tags = "<Tag Name=\"N\" TagType=\"Base\" DataType=\"DINT\"/>";
    let own = "<Tag Name=\"M\" TagType=\"Base\" DataType=\"DINT\"/>";
    let programs: [(&str, &str, &[&str]); 2] =
        [("P1", own, &["ADD(N,1,N);", "PRNT(M);"]), ("P2", "", &["ADD(N,10,N);"])];
    let text = with_programs(tags, &programs, &[]);
    #[rustfmt::skip]
    let cases: [(&str, Replacements<'_>, &[&str]); 3] = [
        ("a phase", &[("<Program Name=\"P1\"", "<Program Type=\"EquipmentPhase\" Name=\"P1\"")],
            &["program P1: an equipment phase is not supported"]),
        ("a program of safety", &[("<Program Name=\"P1\"", "<Program Class=\"Safety\" Name=\"P1\"")],
            &["program P1: a program of safety is not supported"]),
        ("its task too", &[("<Program Name=\"P1\"", "<Program Class=\"Safety\" Name=\"P1\""), ("<Task ", "<Task Class=\"Safety\" ")],
            &["program P1: a program of safety is not supported", "task Fast: a task of safety is not supported"]),
    ];
    for (why, replaced, expected) in cases {
        let mut text = text.clone();
        for (from, to) in replaced {
            assert!(text.contains(from), "{why}: {from}");
            text = text.replacen(from, to, 1);
        }
        let Err(LoadError::Parts(parts)) = load(&text, UnknownParts::Refused) else {
            panic!("{why}: it is refused");
        };
        let found: Vec<String> = parts.findings.iter().map(ToString::to_string).collect();
        assert_eq!(found, expected, "{why}");
        let mut cell = load(&text, UnknownParts::Allowed).expect(why);
        cell.begin(&mut Blind).expect("a prescan without a fault");
        ticks(&mut cell, 1);
        let scans = if replaced.len() > 1 { 0.0 } else { 10.0 };
        assert_eq!(number(&mut cell, "N"), scans, "{why}");
        assert_eq!(number(&mut cell, "Program:P1.M"), 0.0, "{why}: its tags are there");
    }
}

#[test]
fn arrays_may_have_more_than_65535_elements() {
    let tags = "<Tag Name=\"Registers\" TagType=\"Base\" DataType=\"INT\" Dimensions=\"65536\"/>\
        <Tag Name=\"Far\" TagType=\"Base\" DataType=\"DINT\" Dimensions=\"100000\"/>";
    let rungs = [
        "MOV(7,Registers[65535])MOV(8,Far[99999]);",
        "COP(Far[99998],Far[70000],2);",
    ];
    let mut cell = begun(&with(tags, &rungs));
    ticks(&mut cell, 1);
    for (tag, expected) in [("Registers[65535]", 7.0), ("Far[70001]", 8.0)] {
        assert_eq!(number(&mut cell, tag), expected, "{tag}");
    }
    let large = "<Tag Name=\"Large\" TagType=\"Base\" DataType=\"DINT\" Dimensions=\"100000000\"/>";
    let Err(LoadError::Parts(parts)) = load(&with(large, &["NOP();"]), UnknownParts::Allowed) else {
        panic!("it has 400 MB");
    };
    assert_eq!(
        parts.findings[0].to_string(),
        "Large: the tags need more than 268435456 bytes"
    );
}

//! The listing of a project: the text of its rungs, power flow, values, uses.

use super::{project, script};
use crate::source::TagSource;
use crate::{Language, ListedElement, Listing, MonitoredValue, NoMachine, load};

fn alias(name: &str, of: &str) -> TagSource {
    TagSource {
        alias: Some(of.to_owned()),
        ..TagSource::new(name, "", [], None)
    }
}

#[test]
fn power_flow_is_that_of_the_last_scan() {
    #[rustfmt::skip]
    let cases = [
        // why,                             rung,                                        tags that are set,   power
        ("a series",                        "XIC(A)XIC(B)OTE(C);",                       &["A=1"][..],        "1100"),
        ("a branch behind its legs",        "[XIC(A) ,XIC(B) ]OTE(C);",                  &["B=1"],            "10111"),
        ("an empty leg is a wire",          "[XIC(A) , ]OTE(C);",                        &[],                 "1011"),
        ("a branch in a branch",            "[XIC(A)[XIC(B) ,XIO(B) ] ,AFI() ]OTE(C);",  &["A=1"],            "11011011"),
        ("a jump leaves the rest",          "XIC(A)JMP(End)OTE(C);",                     &["A=1"],            "1100"),
        ("without a jump it is scanned",    "XIC(A)JMP(End)OTE(C);",                     &[],                 "1000"),
        ("a compare",                       "GRT(N,2)ADD(N,1,N);",                       &["N=3"],            "111"),
        ("a subroutine has its own",        "XIC(A)JSR(Sub,0)OTE(C);",                   &["A=1"],            "1111"),
    ];
    for (why, rung, sets, power) in cases {
        let main = format!("{rung}\nOTE(D);\nLBL(End)NOP();");
        let source = project(
            "A BOOL, B BOOL, C BOOL, D BOOL, N DINT",
            &[("Main", &main), ("Sub", "XIC(B)OTE(D);")],
        );
        let loaded = load(&source, &mut NoMachine);
        assert!(loaded.findings.is_empty(), "{why}: {:?}", loaded.findings);
        let mut cell = loaded.cell;
        let listing = Listing::new(source.clone(), loaded.names, Vec::new());
        let routine = listing.routine("main", "MAIN").expect("there is one");
        let sub = listing.routine("Main", "Sub").expect("there is one");
        cell.trace([routine, sub]);
        cell.start(0, &mut NoMachine).expect("no fault");
        for text in sets {
            super::set(why, &mut cell, &source, text);
        }
        cell.tick(0, 10_000_000, &mut NoMachine).expect("no fault");
        let sampled = cell.sample(&listing.monitor(routine, 0, 3, None));
        assert_eq!(sampled[0].power, power, "{why}");
        // A rung that a jump passes over was not scanned.
        let is_passed = rung.contains("JMP") && power.starts_with("11");
        assert_eq!(sampled[1].power.is_empty(), is_passed, "{why}");
        let called = cell.sample(&listing.monitor(sub, 0, 1, None));
        assert_eq!(called[0].power.is_empty(), !rung.contains("JSR"), "{why}");
        // The monitors have ended.
        cell.trace([]);
        cell.tick(1, 10_000_000, &mut NoMachine).expect("no fault");
        assert_eq!(cell.sample(&listing.monitor(routine, 0, 1, None))[0].power, "", "{why}");
    }
}

#[test]
fn values_stand_in_the_order_of_the_operands() {
    let mut source = project(
        "A BOOL, N DINT 7, R REAL 1.5, T TIMER 100, S STRING abc, L LINT, Far DINT 99, V DINT[4] 1;2;3;4, I DINT 2",
        &[(
            "Main",
            "XIC(A)TON(T,?,?);\nADD(N,1.5,R);\nMOV(V[I],N);\nMOV(V[Far],N);\nCMP(N>3)NOP();\nCOP(S,S,1);\nXIC(Other)NOP();\nXIC(T.DN)NOP();",
        )],
    );
    source.tags.push(alias("Other", "V[0].0"));
    let loaded = load(&source, &mut NoMachine);
    assert!(loaded.findings.is_empty(), "{:?}", loaded.findings);
    let mut cell = loaded.cell;
    let listing = Listing::new(source, loaded.names, Vec::new());
    let rows = cell.sample(&listing.monitor(0, 0, 100, None));
    let whole = |value| MonitoredValue::Whole(value);
    let expected = [
        vec![
            MonitoredValue::Bool(false),
            MonitoredValue::Text(String::new()),
            whole(100),
            whole(0),
        ],
        vec![whole(7), MonitoredValue::Nothing, MonitoredValue::Real(1.5)],
        vec![whole(3), whole(7)],
        // A subscript out of range is no fault of the program.
        vec![MonitoredValue::Nothing, whole(7)],
        vec![whole(1)],
        vec![
            MonitoredValue::Text("abc".to_owned()),
            MonitoredValue::Text("abc".to_owned()),
            MonitoredValue::Nothing,
        ],
        vec![MonitoredValue::Bool(true)],
        vec![MonitoredValue::Bool(false)],
    ];
    assert_eq!(rows.len(), expected.len());
    for (number, (row, expected)) in rows.iter().zip(expected).enumerate() {
        assert_eq!(row.values, expected, "rung {number}");
    }
    assert_eq!(cell.faults().count(), 0);
}

#[test]
fn lines_of_text_name_their_tags() {
    let source = project(
        "N DINT 7, A BOOL, V DINT[4] 1;2;3;4",
        &[(
            "Main",
            "ST// N is no tag here\nIF A THEN\n  V[N MOD 4] := N; (* A\n A *) N := 1;\nEND_IF;",
        )],
    );
    let loaded = load(&source, &mut NoMachine);
    let mut cell = loaded.cell;
    let listing = Listing::new(source, loaded.names, Vec::new());
    assert_eq!(listing.routines()[0].language, Language::Text);
    let names: Vec<_> = listing.lines(0, 0, 9).into_iter().map(|line| line.names).collect();
    let expected: [&[&str]; 5] = [&[], &["A"], &["N", "V[(N MOD 4)]"], &["N"], &[]];
    assert_eq!(
        names,
        expected.map(|row| row.iter().map(ToString::to_string).collect::<Vec<_>>())
    );
    let rows = cell.sample(&listing.monitor(0, 2, 1, None));
    assert_eq!(rows[0].values, [MonitoredValue::Whole(7), MonitoredValue::Whole(4)]);
}

#[test]
fn a_listing_names_operands() {
    let source = project("A BOOL, N DINT", &[("Main", "[XIC(A) ,XIO(A) ]ADD(N,1,N);")]);
    let names = load(&source, &mut NoMachine).names;
    let rungs = Listing::new(source, names, Vec::new()).rungs(0, 0, 10);
    let [
        ListedElement::Branch { legs, condition: 3 },
        ListedElement::Instruction {
            name,
            title,
            operands,
            condition: 4,
        },
    ] = rungs[0].elements.as_slice()
    else {
        panic!("{:?}", rungs[0].elements)
    };
    assert_eq!(legs.len(), 2);
    assert_eq!((name.as_str(), title.as_str()), ("ADD", "Add"));
    let operands: Vec<_> = operands
        .iter()
        .map(|one| (one.name.as_str(), one.text.as_str()))
        .collect();
    assert_eq!(operands, [("Source A", "N"), ("Source B", "1"), ("Dest", "N")]);
}

#[test]
fn uses_are_found_through_aliases_scopes_and_wholes() {
    let mut source = project(
        "N DINT, Word DINT, V DINT[8], T TIMER, M DINT",
        &[
            (
                "Main",
                "XIC(Lamp)ADD(N,V[2],V[N]);\nTON(T,?,?)XIC(T.DN)OTE(Word.4);\nMOV(V[3],M);",
            ),
            ("Text", "STN := Word + 1;\nIF Lamp THEN M := V[N]; END_IF;"),
        ],
    );
    source.tags.push(alias("Lamp", "Word.3"));
    source.programs[0].tags = super::tags("M DINT");
    let names = load(&source, &mut NoMachine).names;
    let listing = Listing::new(source, names, Vec::new());
    let found = |tag: &str, program: Option<&str>| {
        let (name, uses) = listing.uses(tag, program, 100).expect("a tag");
        let uses = uses.iter().map(|one| {
            let writes = if one.is_written { "!" } else { "" };
            format!("{}:{} {}{writes}", one.routine, one.index, one.operand)
        });
        (name, uses.collect::<Vec<_>>().join(", "))
    };
    #[rustfmt::skip]
    let cases = [
        ("an alias",             "lamp",    None,         "Word.3", "0:0 Lamp, 1:0 Word, 1:1 Lamp"),
        ("a bit",                "Word.4",  None,         "Word.4", "0:1 Word.4!, 1:0 Word"),
        ("the whole",            "Word",    None,         "Word",   "0:0 Lamp, 0:1 Word.4!, 1:0 Word, 1:1 Lamp"),
        ("an element",           "V[2]",    None,         "V[2]",   "0:0 V[2], 0:0 V[N]!, 1:1 V[N]"),
        ("a tag in a subscript", "N",       None,         "N",      "0:0 N, 0:0 N, 1:0 N!, 1:1 N"),
        ("a member",             "T.DN",    None,         "T.DN",   "0:1 T!, 0:1 T.DN"),
        ("the controller's",     "M",       None,         "M",      ""),
        ("the program's",        "m",       Some("main"), "Program:Main.M", "0:2 M!, 1:1 M!"),
        ("with its program",     "Program:Main.M", None,  "Program:Main.M", "0:2 M!, 1:1 M!"),
        ("no such tag",          "Nowhere", None,         "Nowhere", ""),
    ];
    for (why, tag, program, name, uses) in cases {
        assert_eq!(found(tag, program), (name.to_owned(), uses.to_owned()), "{why}");
    }
    assert!(listing.uses("1+", None, 9).is_err());
    assert_eq!(listing.uses("Word", None, 2).expect("a tag").1.len(), 2);
}

#[test]
fn a_trace_changes_nothing() {
    let source = project(
        "A BOOL, N DINT, T TIMER 30, S BOOL",
        &[(
            "Main",
            "XIO(T.DN)TON(T,?,?);\nXIC(T.DN)[ONS(S)ADD(N,1,N) ,XIO(A) OTE(A) ];",
        )],
    );
    let plain = script("without a trace", &source, "20 x");
    let mut traced = super::started("with one", &source);
    traced.trace([0]);
    for tick in 0..20 {
        traced.tick(tick, 10_000_000, &mut NoMachine).expect("no fault");
    }
    assert_eq!(plain.memory()[..], traced.memory()[..]);
}

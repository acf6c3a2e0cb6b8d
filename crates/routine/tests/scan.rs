//! A scan allocates nothing, and the same project gives the same bytes each time.
//!
//! The global allocator ends the process when the guarded scan asks it for anything.

use arcline_routine::source::{
    Access, Content, Datum, InstructionSource, MemberSource, ParameterSource, ProgramSource, Project, RoutineSource,
    RungSource, TagSource, TaskSource, Trigger, Usage,
};
use arcline_routine::{Cell, NoMachine, load};
use assert_no_alloc::{AllocDisabler, assert_no_alloc};

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

fn ladder(name: &str, rungs: &[&str]) -> RoutineSource {
    let rungs = (0..).zip(rungs).map(|(number, text)| RungSource {
        number,
        kind: "N".to_owned(),
        text: (*text).to_owned(),
        comment: String::new(),
    });
    RoutineSource {
        name: name.to_owned(),
        content: Content::Ladder(rungs.collect()),
    }
}

fn text(name: &str, lines: &str) -> RoutineSource {
    RoutineSource {
        name: name.to_owned(),
        content: Content::Text((0..).zip(lines.lines()).map(|(k, line)| (k, line.to_owned())).collect()),
    }
}

/// A project with an instruction of every kind: bits, timers, counters, arithmetic, files, queues, texts, calls, loops, faults.
fn project() -> Project {
    let number = |text: &str| Datum::Number(text.to_owned());
    let preset = |kind: &str, member: &str, value: &str| {
        Some(Datum::Structure(
            kind.to_owned(),
            vec![(member.to_owned(), number(value))],
        ))
    };
    let parameter = |name: &str, data_type: &str, usage, is_required| ParameterSource {
        member: MemberSource {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            dimensions: Vec::new(),
            access: Access::ReadWrite,
        },
        usage,
        is_required,
        alias: None,
        value: None,
    };
    Project {
        tags: vec![
            TagSource::new("I", "BOOL", [], None),
            TagSource::new("O", "BOOL", [], None),
            TagSource::new("S", "BOOL", [], None),
            TagSource::new("N", "DINT", [], None),
            TagSource::new("R", "REAL", [], None),
            TagSource::new("A", "DINT", [16], None),
            TagSource::new("B", "DINT", [16], None),
            TagSource::new("T", "TIMER", [], preset("TIMER", "PRE", "35")),
            TagSource::new("C", "COUNTER", [], preset("COUNTER", "PRE", "3")),
            TagSource::new("F", "CONTROL", [], preset("CONTROL", "LEN", "8")),
            TagSource::new("Q", "CONTROL", [], preset("CONTROL", "LEN", "8")),
            TagSource::new("Text", "STRING", [], None),
            TagSource::new("Part", "STRING", [], Some(Datum::Text(b"abc".to_vec()))),
            TagSource::new("Count", "Counted", [], None),
            TagSource::new("Message", "MESSAGE", [], None),
            TagSource::new("Record", "DINT", [11], None),
        ],
        instructions: vec![InstructionSource {
            name: "Counted".to_owned(),
            parameters: vec![
                parameter("EnableIn", "BOOL", Usage::Input, false),
                parameter("EnableOut", "BOOL", Usage::Output, false),
                parameter("By", "DINT", Usage::Input, true),
                parameter("Sum", "DINT", Usage::InOut, true),
            ],
            locals: Vec::new(),
            routines: vec![ladder("Logic", &["ADD(Sum,By,Sum);"])],
            has_prescan: false,
            has_enable_in_false: false,
            is_encoded: false,
        }],
        programs: vec![ProgramSource {
            name: "Main".to_owned(),
            main: Some("Go".to_owned()),
            fault: Some("Clear".to_owned()),
            is_disabled: false,
            tags: Vec::new(),
            routines: vec![
                ladder(
                    "Go",
                    &[
                        "XIO(T.DN)TON(T,?,?);",
                        "XIC(T.DN)[CTU(C,?,?) ,OTE(O) ];",
                        "XIC(O)ONS(S)ADD(N,1,N);",
                        "CPT(R,SIN(N*0.1)+SQR(N));",
                        "FAL(F,?,?,ALL,B[F.POS],A[F.POS]+N);",
                        "XIO(O)FFL(N,A[0],Q,?,?);",
                        "COP(A[0],B[8],8);",
                        "CONCAT(Part,Part,Text);",
                        "DTOS(N,Text);",
                        "Counted(Count,2,A[1]);",
                        "XIC(O)MSG(Message);",
                        "GSV(WallClockTime,,DateTime,Record[0]);",
                        "JSR(Loop,0);",
                        "EQU(N,3)MOV(A[N_Far],N);",
                        "EQU(N,2)MOV(1,A[Far]);",
                    ],
                ),
                text(
                    "Loop",
                    "FOR N_Far := 0 TO 9 DO\nIF N_Far MOD 2 = 0 THEN A[N_Far] := A[N_Far] + 1; END_IF;\nEND_FOR;\nWHILE N > 100 DO\nN := N - 1;\nEND_WHILE;",
                ),
                ladder(
                    "Clear",
                    &[
                        "GSV(Program,THIS,MajorFaultRecord,Record[0]);",
                        "MOV(0,Record[2])SSV(Program,THIS,MajorFaultRecord,Record[0]);",
                    ],
                ),
            ],
        }],
        tasks: vec![TaskSource::new("T", Trigger::Periodic(10.0), &["Main"])],
        ..Project::default()
    }
}

fn started() -> Cell {
    let mut project = project();
    project.tags.push(TagSource::new("N_Far", "DINT", [], None));
    project
        .tags
        .push(TagSource::new("Far", "DINT", [], Some(Datum::Number("99".to_owned()))));
    let loaded = load(&project, &mut NoMachine);
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    assert!(findings.is_empty(), "{findings:?}");
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine).expect("no fault");
    cell
}

const TICKS: u64 = 500;

fn run(cell: &mut Cell) {
    for tick in 0..TICKS {
        cell.tick(tick, 2_000_000, &mut NoMachine)
            .expect("the fault routine clears every fault");
    }
}

#[test]
fn a_scan_allocates_nothing() {
    let mut cell = started();
    assert_no_alloc(|| run(&mut cell));
    assert!(cell.faults().count() > 0, "a fault was cleared on the way");
}

#[test]
fn a_scan_that_someone_looks_at_allocates_nothing() {
    let mut cell = started();
    cell.trace(0..8);
    assert_no_alloc(|| run(&mut cell));
}

#[test]
fn a_hundred_runs_give_the_same_bytes() {
    let mut first = started();
    run(&mut first);
    assert!(first.memory().iter().any(|byte| *byte != 0));
    for number in 1..100 {
        let mut cell = started();
        run(&mut cell);
        assert!(cell.memory()[..] == first.memory()[..], "run {number} differs");
    }
}

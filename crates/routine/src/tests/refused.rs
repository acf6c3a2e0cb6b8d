//! Each part that does not run has a finding with its position, and is counted (spec/programs.md §4, §10.8, §16).

use super::{NoMachine, expect, project, routine, script, set, started};
use crate::source::{Content, Project, RoutineSource, RungSource, TaskSource, Trigger};
use crate::{Finding, FindingKind, load};

fn told(findings: &[Finding]) -> Vec<String> {
    findings.iter().map(ToString::to_string).collect()
}

#[test]
fn routines_in_other_languages_are_named_and_calls_of_them_too() {
    let mut of = project(
        "N DINT",
        &[("Main", "JSR(Flow,0);\nJSR(Chart,0);\nJSR(Locked,0);\nADD(N,1,N);")],
    );
    for (name, language) in [("Flow", "FBD"), ("Chart", "SFC"), ("Locked", "encoded content")] {
        of.programs[0].routines.push(RoutineSource {
            name: name.to_owned(),
            content: Content::Other(language.to_owned()),
        });
    }
    let mut encoded = super::projects::add_on("Secret", Vec::new(), Vec::new());
    encoded.is_encoded = true;
    of.instructions.push(encoded);
    let loaded = load(&of, &mut NoMachine);
    assert_eq!(
        told(&loaded.findings),
        [
            "Secret: routine Secret: its content is encoded",
            "Main/Flow: routine Flow: FBD is not supported",
            "Main/Chart: routine Chart: SFC is not supported",
            "Main/Locked: routine Locked: encoded content is not supported",
        ]
    );
    assert!(loaded.findings.iter().all(|one| one.kind == FindingKind::Routine));
    // Passed over, the rest runs.
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine).expect("it starts");
    cell.tick(0, 10_000_000, &mut NoMachine).expect("no fault");
    expect("the last rung", &mut cell, &of, "N=1");
}

#[test]
fn rungs_with_pending_edits_are_named_and_those_in_force_run() {
    let mut of = project("A DINT, B DINT, C DINT, D DINT, E DINT", &[("Main", "NOP();")]);
    let rung = |number: u32, kind: &str, text: &str| RungSource {
        number,
        kind: kind.to_owned(),
        text: text.to_owned(),
        comment: String::new(),
    };
    of.programs[0].routines[0].content = Content::Ladder(vec![
        rung(0, "N", "ADD(A,1,A);"),
        rung(1, "I", "ADD(B,1,B);"),
        rung(2, "D", "ADD(C,1,C);"),
        rung(3, "R", "ADD(D,1,D);"),
        rung(4, "IR", "ADD(E,1,E);"),
    ]);
    let loaded = load(&of, &mut NoMachine);
    let in_force = "rung: has a pending edit; the rung in force runs";
    let pending = "rung: is a pending edit, which does not run";
    assert_eq!(
        told(&loaded.findings),
        [
            format!("Main/Main rung 1: {pending}"),
            format!("Main/Main rung 2: {in_force}"),
            format!("Main/Main rung 3: {in_force}"),
            format!("Main/Main rung 4: {pending}"),
        ]
    );
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine).expect("it starts");
    cell.tick(0, 10_000_000, &mut NoMachine).expect("no fault");
    for text in ["A=1", "B=0", "C=1", "D=1", "E=0"] {
        expect("one scan", &mut cell, &of, text);
    }
}

#[test]
fn system_values_that_are_passed_over_are_0_with_a_minor_fault() {
    let mut of = project(
        "N DINT 7, M DINT 7, V BOOL, Count INT",
        &[(
            "Main",
            "GSV(Redundancy,,ChassisRedundancyState,N);\nSSV(Controller,,ShareUnusedTimeSlice,M);\nXIC(S:MINOR)OTE(V);\nGSV(FaultLog,,MinorEvents,Count);",
        )],
    );
    let loaded = load(&of, &mut NoMachine);
    assert_eq!(
        told(&loaded.findings),
        [
            "Main/Main rung 0: instruction GSV Redundancy  ChassisRedundancyState is not supported",
            "Main/Main rung 1: instruction SSV Controller  ShareUnusedTimeSlice is not supported",
        ]
    );
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine).expect("it starts");
    cell.tick(0, 10_000_000, &mut NoMachine).expect("no major fault");
    for text in ["N=0", "M=7", "V=1", "Count=2"] {
        expect("one scan", &mut cell, &of, text);
    }
    // A module that the project does not have.
    of.modules = vec!["Rack".to_owned()];
    of.programs[0].routines = vec![routine(
        "Main",
        "GSV(Module,rack,EntryStatus,N);\nGSV(Module,Gone,EntryStatus,N);",
    )];
    let findings = load(&of, &mut NoMachine).findings;
    assert_eq!(
        told(&findings),
        ["Main/Main rung 1: instruction GSV Module Gone EntryStatus is not supported"]
    );
}

#[test]
fn a_destination_that_is_too_small_is_a_minor_fault() {
    let of = project(
        "S SINT -1, D DINT[2], V BOOL, Count INT, Zero INT, Go BOOL",
        &[(
            "Main",
            "GSV(Task,THIS,Rate,S);\nXIC(S:MINOR)OTE(V);\nGSV(WallClockTime,,LocalDateTime,D[0]);\nGSV(FaultLog,,MinorEvents,Count);\nXIC(Go)SSV(FaultLog,,MinorEvents,Zero);",
        )],
    );
    script(
        "4/7",
        &of,
        ":S=16;V=1;D[0]=2026;D[1]=1;Count=2\nGo:Count=4\nGo=0:Count=2",
    );
}

#[test]
fn major_faults_are_counted_and_shown_by_type() {
    let clear = "GSV(Program,THIS,MajorFaultRecord,R[0]);\nMOV(0,R[2]);\nSSV(Program,THIS,MajorFaultRecord,R[0]);";
    let mut of = project(
        "A DINT[2], I DINT 9, N DINT, R DINT[11], Count INT, Bits DINT",
        &[
            (
                "Main",
                "MOV(A[I],N);\nGSV(FaultLog,,MajorEvents,Count);\nGSV(FaultLog,,MajorFaultBits,Bits);",
            ),
            ("Fault", clear),
        ],
    );
    of.programs[0].fault = Some("Fault".to_owned());
    script("4/20", &of, ":Count=1;Bits=16\n:Count=2;Bits=16");
}

#[test]
fn a_program_makes_faults_of_its_own_by_a_call_of_its_fault_routine() {
    let clear = "ADD(Count,1,Count);\nGSV(Program,THIS,MajorFaultRecord,R[0]);\nMOV(R[2],Seen);\nXIC(Keep)RET();\nMOV(0,R[2]);\nSSV(Program,THIS,MajorFaultRecord,R[0]);";
    let tags = "Code DINT 995, Go BOOL, Keep BOOL, R DINT[11], Count DINT, Seen DINT, N DINT";
    let rungs = "XIC(Go)JSR(Fault,1,Code);\nADD(N,1,N);";
    let mut of = project(tags, &[("Main", rungs), ("Fault", clear)]);
    of.programs[0].fault = Some("Fault".to_owned());
    let high = |code: i32| (code << 16) + 4;
    let lines = format!(
        ":N=1;Count=0\nGo:N=2;Count=1;Seen={}\nCode=990:N=3;Count=2;Seen={}\nCode=5:N=4;Count=3",
        high(995),
        high(990)
    );
    script("cleared, and 5 is no such code", &of, &lines);
    let mut cell = started("not cleared", &of);
    ["Go", "Keep"]
        .iter()
        .for_each(|tag| set("not cleared", &mut cell, &of, tag));
    let fault = cell.tick(0, 10_000_000, &mut NoMachine).expect_err("it stays");
    assert_eq!(
        fault.to_string(),
        "major fault 4/995 (of the program) in Main/Main rung 0, JSR"
    );
}

#[test]
fn more_messages_than_can_be_under_way_err_at_once() {
    let of = project(
        "M MESSAGE[258], K DINT",
        &[("Main", "ST\nFOR K := 0 TO 257 DO MSG(M[K]); END_FOR;")],
    );
    script(
        "256 of them wait",
        &of,
        ":M[0].EN=1;M[0].EW=1;M[0].ER=0;M[255].ER=0;M[256].ER=1;M[256].ERR=2;M[256].EW=0;M[257].ER=1",
    );
}

#[test]
fn a_program_ends_a_message_by_to() {
    let of = project("M MESSAGE, Go BOOL, N DINT", &[("Main", "XIC(Go)MSG(M);")]);
    let lines = "Go:M.EN=1;M.EW=1;M.ER=0
        M.TO:M.ER=1;M.DN=0;M.EW=0;M.ERR=1;M.EXERR=16#0204
        Go=0:M.EN=0
        Go:M.EN=1;M.TO=0;M.ER=0
        5 x:M.ER=0";
    script("TO", &of, lines);
}

#[test]
fn modules_and_tags_of_other_controllers_are_named_and_block_nothing_but_their_use() {
    let outside = ("Local:1:I".to_owned(), "has no data: there is no such tag".to_owned());
    let mut of = project("N DINT", &[("Main", "ADD(N,1,N);")]);
    of.outside = vec![outside];
    let findings = load(&of, &mut NoMachine).findings;
    assert_eq!(told(&findings), ["module Local:1:I: has no data: there is no such tag"]);
    assert_eq!(findings[0].kind, FindingKind::Module);
    of.programs[0].routines = vec![routine("Main", "XIC(Local:1:I.Data.0)ADD(N,1,N);")];
    let findings = load(&of, &mut NoMachine).findings;
    assert_eq!(findings[1].kind, FindingKind::Absent);
    assert_eq!(
        findings[1].to_string(),
        "Main/Main rung 0: XIC(Local:1:I.Data.0): Data Bit Local:1:I.Data.0: there is no tag Local:1:I"
    );
}

#[test]
fn instructions_and_statements_that_name_what_is_not_there_are_passed_over() {
    let mut of = project(
        "N DINT, M DINT, A BOOL, B BOOL, C BOOL, T TIMER",
        &[
            (
                "Main",
                "XIC(Gone.In)OTE(A);\nXIO(Gone.In)OTE(A);\nOTE(Gone.Out)OTE(B);\n[XIC(T.Gone),XIO(A)]OTE(C);\nEQ(Gone,0)ADD(N,100,N);\nJSR(Nowhere,0)ADD(N,1,N);\nJSR(Text,0);\nMAM(Gone,M1,0,1,1)ADD(N,10,N);\nCOP(?,M,1)ADD(N,1000,N);\nONS(Gone.Once)ADD(N,10000,N);",
            ),
            (
                "Text",
                "ST\nM := M + 1;\nGone := 5;\nIF Gone = 0 THEN M := M + 100; ELSE M := M + 200; END_IF;\nIF M = 1 THEN M := Gone; M := M + 10; END_IF;",
            ),
        ],
    );
    of.programs[0].tags.clear();
    let loaded = load(&of, &mut NoMachine);
    assert_eq!(
        told(&loaded.findings),
        [
            "Main/Main rung 0: XIC(Gone.In): Data Bit Gone.In: there is no tag Gone",
            "Main/Main rung 1: XIO(Gone.In): Data Bit Gone.In: there is no tag Gone",
            "Main/Main rung 2: OTE(Gone.Out): Data Bit Gone.Out: there is no tag Gone",
            "Main/Main rung 3: XIC(T.Gone): Data Bit T.Gone: TIMER has no member Gone",
            "Main/Main rung 4: EQ(Gone,0): Gone: there is no tag Gone",
            "Main/Main rung 5: JSR(Nowhere,0): there is no routine Nowhere",
            "Main/Main rung 7: MAM(Gone,M1,0,1,1): Axis Gone: there is no tag Gone",
            "Main/Main rung 8: COP(?,M,1): Source ?: the operand is not given",
            "Main/Main rung 9: ONS(Gone.Once): Storage Bit Gone.Once: there is no tag Gone",
            "Main/Text line 2: statement: Gone := 5: there is no tag Gone",
            "Main/Text line 3: statement: (Gone=0): there is no tag Gone",
            "Main/Text line 4: statement: M := Gone: there is no tag Gone",
        ]
    );
    assert!(loaded.findings.iter().all(|one| one.kind == FindingKind::Absent));
    let mut cell = loaded.cell;
    cell.start(0, &mut NoMachine).expect("it starts");
    cell.tick(0, 10_000_000, &mut NoMachine).expect("no fault");
    for text in ["A=0", "B=1", "C=1", "N=1011", "M=11"] {
        expect("one scan", &mut cell, &of, text);
    }
}

#[test]
fn names_that_lead_nowhere_or_to_two_places_are_named() {
    let plain = || project("N DINT", &[("Main", "ADD(N,1,N);")]);
    let continuous = |name: &str| TaskSource::new(name, Trigger::Continuous, &["Main"]);
    type Change<'c> = &'c dyn Fn(&mut Project);
    #[rustfmt::skip]
    let cases: [(&str, Change<'_>, &str); 6] = [
        ("a task's program",  &|of| of.tasks[0].programs.push("Gone".to_owned()),        "task Task: there is no program Gone, which it runs"),
        ("a main routine",    &|of| of.programs[0].main = Some("Gone".to_owned()),       "program Main: there is no routine Gone, its main routine"),
        ("a fault routine",   &|of| of.programs[0].fault = Some("Gone".to_owned()),      "program Main: there is no routine Gone, its fault routine"),
        ("a fault handler",   &|of| of.fault_handler = Some("Gone".to_owned()),          "program Gone: there is no such program, which is to handle major faults"),
        ("continuous tasks",  &|of| of.tasks = vec![continuous("A"), continuous("B")],   "task B: it does not run, since A is continuous too"),
        ("a label twice",     &|of| of.programs[0].routines[0] = routine("Main", "LBL(Here)NOP();\nlbl(here)NOP();\nJMP(Here);"), "Main/Main rung 1: LBL: another rung has the label here too"),
    ];
    for (why, change, expected) in cases {
        let mut of = plain();
        change(&mut of);
        assert_eq!(told(&load(&of, &mut NoMachine).findings), [expected], "{why}");
    }
    // A program that no task runs may be a part of another project.
    let mut of = plain();
    of.programs[0].main = Some("Gone".to_owned());
    of.tasks.clear();
    assert!(load(&of, &mut NoMachine).findings.is_empty());
    // The second continuous task is passed over.
    let mut of = plain();
    of.tasks = vec![continuous("A"), continuous("B")];
    let mut cell = load(&of, &mut NoMachine).cell;
    cell.start(0, &mut NoMachine).expect("it starts");
    cell.tick(0, 10_000_000, &mut NoMachine).expect("no fault");
    expect("one of them ran", &mut cell, &of, "N=1");
}

//! Status bits, and the minor faults of arithmetic (spec/programs.md §7).

use super::projects::{add_on, member};
use super::{NoMachine, project, routine, script};
use crate::load;

#[test]
fn a_division_by_0_is_one_minor_fault() {
    #[rustfmt::skip]
    let cases = [
        ("DIV(A,Z,D);",         ":Count=1;D=7;V=1"),
        ("DIV(A,Z,R);",         ":Count=1;V=1"),
        ("DIV(R,Z,D);",         ":Count=1"),
        ("MOD(A,Z,D);",         ":Count=1;D=0;V=1"),
        ("MOD(A,Z,R);",         ":Count=1;R=0;V=1"),
        ("CPT(D,A / Z);",       ":Count=1;D=7"),
        ("CPT(R,A / Z);",       ":Count=1"),
        ("CPT(D,A / Z + 1);",   ":Count=1;D=8"),
        ("TOD(N,D);",           ":Count=1"),
        ("ADD(M,M,D);",         ":Count=1"),
        ("DIV(A,Z,D)ADD(M,M,D);", ":Count=2"),
        ("ADD(A,A,D);",         ":Count=0;V=0"),
        ("CMP(A / Z > 1);",     ":Count=1"),
    ];
    for (rung, lines) in cases {
        let rungs = format!("{rung}\nXIC(S:V)OTE(V);\nGSV(FaultLog,,MinorEvents,Count);");
        let of = project(
            "A DINT 7, Z DINT, D DINT, R REAL, N DINT -1, M DINT 2147483647, V BOOL, Count DINT",
            &[("Main", &rungs)],
        );
        script(rung, &of, lines);
    }
    let of = project(
        "A DINT 7, Z DINT, D DINT, Count DINT",
        &[(
            "Main",
            "ST\nD := A / Z;\nD := A MOD Z;\nGSV(FaultLog,,MinorEvents,Count);",
        )],
    );
    script("Structured Text", &of, ":Count=2;D=0");
}

#[test]
fn status_bits_are_written() {
    #[rustfmt::skip]
    let cases = [
        ("OTL(S:MINOR)XIC(S:MINOR)OTE(O);",           ":O=1"),
        ("DIV(A,Z,D)OTU(S:MINOR)XIC(S:MINOR)OTE(O);", ":O=0"),
        ("OTE(S:V)XIC(S:V)OTE(O);",                   ":O=1"),
        ("XIC(I)OTE(S:V);\nXIC(S:V)OTE(O);",          ":O=0\nI:O=1"),
        ("OTL(s:z)XIC(S:Z)OTE(O);",                   ":O=1"),
        ("OTL(S:N)XIC(S:N)OTE(O);",                   ":O=1"),
        ("OTL(S:C)XIC(S:C)OTE(O);",                   ":O=1"),
        ("MOV(0,D)OTU(S:Z)XIC(S:Z)OTE(O);",           ":O=0"),
    ];
    for (rungs, lines) in cases {
        let of = project("A DINT 7, Z DINT, D DINT, O BOOL, I BOOL", &[("Main", rungs)]);
        script(rungs, &of, lines);
    }
    #[rustfmt::skip]
    let refused = [
        ("OTE(S:FS)", "OTE(S:FS): S:FS is not written"),
        ("ONS(S:V)",  "ONS(S:V): a status bit is no storage"),
    ];
    for (rung, expected) in refused {
        let of = project("O BOOL", &[("Main", &format!("{rung};"))]);
        let told: Vec<String> = load(&of, &mut NoMachine)
            .findings
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(told, [format!("Main/Main rung 0: {expected}")]);
    }
}

/// Names of what runs: in an add-on instruction the program and task that call it. The controller's catalogue number has its count before it.
#[test]
fn names_of_the_program_that_calls_and_of_the_controller() {
    let mut of = project(
        "A Who, D SINT[8]",
        &[("Main", "Who(A);\nGSV(ControllerDevice,,DeviceName,D[0]);")],
    );
    let mut who = add_on(
        "Who",
        Vec::new(),
        vec![routine(
            "Logic",
            "GSV(Program,THIS,Name,P);\nGSV(Task,THIS,Name,T);\nGSV(Routine,THIS,Name,R);",
        )],
    );
    let local = |name: &str| (member(name, "STRING"), None);
    who.locals = vec![local("P"), local("T"), local("R")];
    of.instructions = vec![who];
    of.processor = "1756-L8".to_owned();
    script(
        "names",
        &of,
        ": A.P.LEN=4; A.P.DATA[0]=77; A.T.LEN=4; A.T.DATA[0]=84; A.R.LEN=5; A.R.DATA[4]=99; D[0]=7; D[1]=49; D[7]=56",
    );
}

#[test]
fn a_name_that_is_too_long_stays_in_its_text() {
    let rungs = "GSV(Program,THIS,Name,S[0]);\nGSV(FaultLog,,MinorEvents,Count);";
    let mut of = project("S STRING_16[2], Count INT", &[("Main", rungs)]);
    of.programs[0].name = "A_name_of_23_characters".to_owned();
    of.tasks[0].programs = vec!["A_name_of_23_characters".to_owned()];
    script("a name", &of, ": S[0].LEN=16; S[0].DATA[15]=97; S[1].LEN=0; Count=1");
}

#[test]
fn a_name_in_other_data_has_its_length_first() {
    let rungs =
        "GSV(Program,THIS,Name,N);\nMOV(S:MINOR,Cut);\nGSV(Program,THIS,Name,D[1]);\nGSV(FaultLog,,MinorEvents,Count);";
    let of = project("N DINT, Cut DINT, D DINT[4] -1;-1;-1;-1, Count INT", &[("Main", rungs)]);
    // "Main" from the least byte on.
    script(
        "a name",
        &of,
        ": N=4; Cut=1; D[0]=-1; D[1]=4; D[2]=1852399949; D[3]=-1; Count=1",
    );
}

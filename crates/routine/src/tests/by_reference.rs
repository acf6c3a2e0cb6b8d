//! Operands of add-on instructions by reference (spec/programs.md §13): arrays have the sizes of the operand.

use super::projects::{add_on, parameter};
use super::{NoMachine, expect, project, routine, script, started};
use crate::load;
use crate::source::{Access, MemberSource, ParameterSource, Project, Usage};

fn array(name: &str, data_type: &str, dimensions: &[u32]) -> ParameterSource {
    let mut by_reference = parameter(name, data_type, Usage::InOut, None);
    by_reference.member.dimensions = dimensions.to_vec();
    by_reference
}

/// `Do(instance, operand)` with the parameter P by reference and its logic; `Pass` hands its own P on to it.
fn with(tags: &str, call: &str, dimensions: &[u32], data_type: &str, logic: &str) -> Project {
    let mut of = project(
        &format!("{tags}, S Do, Q Pass, N DINT, M DINT, K DINT"),
        &[("Main", call)],
    );
    let parameters = || {
        vec![
            array("P", data_type, dimensions),
            parameter("K", "DINT", Usage::InOut, None),
            parameter("N", "DINT", Usage::InOut, None),
        ]
    };
    let mut first = add_on("Do", parameters(), vec![routine("Logic", logic)]);
    first.locals = vec![(local("I", "DINT"), None), (local("C", "CONTROL"), None)];
    let mut second = add_on("Pass", parameters(), vec![routine("Logic", "Do(Inner,P,K,N);")]);
    second.locals = vec![(local("Inner", "Do"), None)];
    of.instructions = vec![first, second];
    of
}

fn local(name: &str, data_type: &str) -> MemberSource {
    MemberSource {
        name: name.to_owned(),
        data_type: data_type.to_owned(),
        dimensions: Vec::new(),
        access: Access::ReadWrite,
    }
}

#[test]
fn an_array_by_reference_has_the_sizes_of_the_operand() {
    let sum = "ST\nSIZE(P,0,K);\nFOR I := 0 TO K - 1 DO N := N + P[I]; END_FOR;";
    let numbers = "A DINT[7] 1;2;3;4;5;6;7, After DINT";
    #[rustfmt::skip]
    let cases: [(&str, &[u32], &str, &str, &str); 10] = [
        ("SIZE and a loop",   &[1],    "DINT", sum, ":N=28;K=7"),
        ("COP from it",       &[1],    "DINT", "COP(P,N,1)MOV(2,K)COP(P[0],P[K],100);", ":N=1;A[2]=1;A[6]=5;After=0"),
        ("FLL",               &[1],    "DINT", "FLL(9,P[0],100);", ":A[0]=9;A[6]=9;After=0"),
        ("FLL from an index", &[1],    "DINT", "MOV(5,K)FLL(9,P[K],100);", ":A[4]=5;A[5]=9;A[6]=9;After=0"),
        ("FAL",               &[1],    "DINT", "MOV(7,C.LEN)FAL(C,?,?,ALL,P[C.POS],8);", ":A[0]=8;A[6]=8;After=0"),
        ("AVE",               &[1],    "REAL", "MOV(7,C.LEN)AVE(P[0],0,N,C,?,?);", ":N=4"),
        ("BSL",               &[1],    "DINT", "MOV(200,C.LEN)BSL(P[0],C,0,?);", ":A[0]=2;A[5]=12"),
        ("a matrix",          &[1, 1], "INT",  "ST\nP[1,2] := 12; I := 1; P[I,0] := 10; P[0,I] := 1;\nSIZE(P,0,N); SIZE(P,1,K);", ":M1[1,2]=12;M1[1,0]=10;M1[0,1]=1;N=2;K=3"),
        ("structures",        &[1],    "TIMER", "ST\nI := 2; P[I].PRE := 5; SIZE(P,0,N);", ":T[2].PRE=5;N=3"),
        ("bits",              &[32],   "BOOL", "ST\nI := 63; P[I] := 1; SIZE(P,0,N);", ":B[63]=1;N=64"),
    ];
    for (why, dimensions, data_type, logic, lines) in cases {
        let operand = match (dimensions.len(), data_type) {
            (2, _) => "M1",
            (_, "BOOL") => "B",
            (_, "TIMER") => "T",
            (_, "REAL") => "R",
            _ => "A",
        };
        let tags = format!("{numbers}, R REAL[7] 1;2;3;4;5;6;7, M1 INT[2;3], T TIMER[3], B BOOL[64]");
        // A constant subscript of a matrix is checked by the definition.
        let dimensions = if why == "a matrix" { &[2, 3] } else { dimensions };
        for call in ["Do(S", "Pass(Q"] {
            let call = format!("{call},{operand},K,N);");
            script(
                &format!("{why}, {call}"),
                &with(&tags, &call, dimensions, data_type, logic),
                lines,
            );
        }
    }
}

#[test]
fn the_strides_of_a_matrix_are_those_of_the_operand() {
    let logic = "ST\nP[1,0] := 10; I := 1; P[I,1] := 11; SIZE(P,0,K); SIZE(P,1,N); COP(P[1,0],P[0,0],100);";
    let tags = "M1 INT[3;5], After DINT";
    for call in ["Do(S,M1,K,N);", "Pass(Q,M1,K,N);"] {
        let lines = ":M1[1,0]=0;M1[0,0]=10;M1[0,1]=11;K=3;N=5;After=0";
        script(call, &with(tags, call, &[2, 2], "INT", logic), lines);
    }
}

#[test]
fn subscripts_behind_the_operand_are_faults() {
    let tags = "Before DINT, A DINT[3], After DINT";
    for (index, faults) in [(2, false), (3, true), (-1, true)] {
        for call in ["Do(S,A,K,N);", "Pass(Q,A,K,N);"] {
            let logic = format!("MOV({index},I)MOV(111,P[I]);");
            let of = with(tags, call, &[1], "DINT", &logic);
            let mut cell = started(call, &of);
            let ran = cell.tick(0, 10_000_000, &mut NoMachine);
            assert_eq!(
                ran.err().map(|fault| (fault.kind, fault.code)),
                faults.then_some((4, 20)),
                "{call} {index}"
            );
            ["Before=0", "After=0"]
                .iter()
                .for_each(|text| expect(call, &mut cell, &of, text));
        }
    }
}

#[test]
fn operands_of_another_size_are_refused() {
    #[rustfmt::skip]
    let cases: [(&str, &[u32], &str, &str); 11] = [
        ("A",    &[10],   "DINT", "has 3 elements, expected 10 or more"),
        ("D",    &[10],   "DINT", "is one DINT, expected an array"),
        ("A[0]", &[1],    "DINT", "is one DINT, expected an array"),
        ("A",    &[],     "DINT", "is an array, expected one DINT"),
        ("A[1]", &[],     "DINT", ""),
        ("M1",   &[2],    "DINT", "has 2 dimensions, expected 1"),
        ("M1",   &[2, 4], "DINT", "has 3 elements, expected 4 or more"),
        ("B",    &[64],   "BOOL", "has 32 elements, expected 64 or more"),
        ("B[0]", &[32],   "BOOL", "is a bit, expected BOOL"),
        ("D.3",  &[],     "DINT", "is a bit, expected DINT"),
        ("A",    &[3],    "INT",  "is DINT, expected INT"),
    ];
    for (operand, dimensions, data_type, expected) in cases {
        let call = format!("Do(S,{operand},K,N);");
        let of = with(
            "D DINT, A DINT[3], M1 DINT[2;3], B BOOL[32]",
            &call,
            dimensions,
            data_type,
            "NOP();",
        );
        let told: Vec<String> = load(&of, &mut NoMachine)
            .findings
            .iter()
            .map(ToString::to_string)
            .collect();
        let expected =
            (!expected.is_empty()).then(|| format!("Main/Main rung 0: Do(S,{operand},K,N): P {operand}: {expected}"));
        // The second instruction is not called, but its own call has to fit.
        assert_eq!(told, Vec::from_iter(expected), "{operand}");
    }
}

#[test]
fn literals_stand_for_operands_that_nothing_takes() {
    let of = |call: &str| {
        let mut of = project("S Do, A DINT, B BOOL, R REAL", &[("Main", call)]);
        let parameters = vec![
            parameter("Out", "DINT", Usage::Output, None),
            parameter("Flag", "BOOL", Usage::InOut, None),
            parameter("Sum", "DINT", Usage::InOut, None),
            parameter("Gain", "REAL", Usage::InOut, None),
        ];
        let logic = "XIO(Flag)MOV(3,Out);\nADD(Sum,1,Sum)ADD(Out,Sum,Out);\nMUL(Gain,Sum,Gain);\nOTL(Flag);";
        of.instructions
            .push(add_on("Do", parameters, vec![routine("Logic", logic)]));
        of
    };
    #[rustfmt::skip]
    let cases = [
        // Each call finds the literal, whatever the last one made of it.
        ("Do(S,0,0,5,0);",   ":S.Out=9;A=0\n:S.Out=9"),
        ("Do(S,A,B,0,1.5);", ":A=4;B=1;S.Out=4\n:S.Out=5"),
        ("Do(S,0,1,0,R);",   ":S.Out=1;A=0\n:S.Out=2"),
    ];
    for (call, lines) in cases {
        script(call, &of(call), lines);
    }
    #[rustfmt::skip]
    let refused = [
        ("Do(S,1,0,0,0)",   "Out 1: expected a tag that can be written"),
        ("Do(S,0,0,A+1,0)", "Sum A+1: expected a tag"),
    ];
    for (call, expected) in refused {
        let told = load(&of(&format!("{call};")), &mut NoMachine).findings;
        let told: Vec<String> = told.iter().map(ToString::to_string).collect();
        assert_eq!(told, [format!("Main/Main rung 0: {call}: {expected}")]);
    }
    for (operand, data_type, dimensions) in [("1", "TIMER", &[][..]), ("1", "DINT", &[1])] {
        let call = format!("Do(S,{operand},K,N)");
        let told = load(
            &with("", &format!("{call};"), dimensions, data_type, "NOP();"),
            &mut NoMachine,
        )
        .findings;
        assert_eq!(
            told[0].to_string(),
            format!("Main/Main rung 0: {call}: P 1: expected a tag")
        );
    }
    let logic = "ST\nSIZE(P,0,N); K := P[2].PRE; P[2].PRE := 5;";
    script(
        "0 for an array of structures",
        &with("", "Do(S,0,K,N);", &[3], "TIMER", logic),
        ":N=3;K=0",
    );
}

#[test]
fn modules_are_given_by_name() {
    let of = |call: &str| {
        let mut of = with("", call, &[], "MODULE", "GSV(Module,P,EntryStatus,N);");
        of.modules = vec!["Rack".to_owned()];
        of
    };
    script("a module", &of("Do(S,Rack,K,N);"), ":N=16384");
    script("through another instruction", &of("Pass(Q,rack,K,N);"), ":N=16384");
    let mut with_tag = of("Do(S,Ref,K,N);");
    with_tag.tags.extend(super::tags("Ref MODULE"));
    script("a tag of a partial export", &with_tag, ":N=16384");
    for operand in ["Gone", "N", "Rack.X"] {
        let told = load(&of(&format!("Do(S,{operand},K,N);")), &mut NoMachine).findings;
        let told: Vec<String> = told.iter().map(ToString::to_string).collect();
        assert_eq!(
            told,
            [format!(
                "Main/Main rung 0: Do(S,{operand},K,N): P {operand}: is no module"
            )]
        );
    }
}

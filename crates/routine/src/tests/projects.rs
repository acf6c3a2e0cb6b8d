//! Whole projects: add-on instructions, tasks, faults.

use super::{NoMachine, expect, project, routine, script, started, tags};
use crate::source::{
    Access, Datum, InstructionSource, MemberSource, ParameterSource, Project, TaskSource, Trigger, Usage,
};

pub(super) fn member(name: &str, data_type: &str) -> MemberSource {
    MemberSource {
        name: name.to_owned(),
        data_type: data_type.to_owned(),
        dimensions: Vec::new(),
        access: Access::ReadWrite,
    }
}

pub(super) fn parameter(name: &str, data_type: &str, usage: Usage, value: Option<&str>) -> ParameterSource {
    ParameterSource {
        member: member(name, data_type),
        usage,
        is_required: value.is_none(),
        alias: None,
        value: value.map(|text| Datum::Number(text.to_owned())),
    }
}

/// An add-on instruction with these parameters and routines.
pub(super) fn add_on(
    name: &str,
    parameters: Vec<ParameterSource>,
    routines: Vec<crate::source::RoutineSource>,
) -> InstructionSource {
    let own = [
        parameter("EnableIn", "BOOL", Usage::Input, Some("1")),
        parameter("EnableOut", "BOOL", Usage::Output, Some("0")),
    ];
    InstructionSource {
        name: name.to_owned(),
        parameters: own.into_iter().chain(parameters).collect(),
        locals: Vec::new(),
        routines,
        has_prescan: false,
        has_enable_in_false: false,
        is_encoded: false,
    }
}

/// `Scale(instance, In, Out, Sum)`: Out := In * Gain, Sum by reference; counts its calls.
fn scale() -> InstructionSource {
    InstructionSource {
        name: "Scale".to_owned(),
        parameters: vec![
            parameter("EnableIn", "BOOL", Usage::Input, Some("1")),
            parameter("EnableOut", "BOOL", Usage::Output, Some("0")),
            parameter("In", "DINT", Usage::Input, None),
            parameter("Gain", "DINT", Usage::Input, Some("3")),
            parameter("Out", "DINT", Usage::Output, None),
            parameter("Sum", "DINT", Usage::InOut, None),
        ],
        locals: vec![(member("Calls", "DINT"), Some(Datum::Number("100".to_owned())))],
        routines: vec![
            routine("Logic", "MUL(In,Gain,Out);\nADD(Sum,Out,Sum);\nADD(Calls,1,Calls);"),
            routine("EnableInFalse", "MOV(-1,Out);"),
            routine("Prescan", "MOV(7,Calls);"),
        ],
        has_prescan: true,
        has_enable_in_false: true,
        is_encoded: false,
    }
}

#[test]
fn add_on_instructions_copy_in_and_out() {
    let mut of = project(
        "I BOOL, S1 Scale, S2 Scale, A DINT 2, R DINT, T DINT[3], K DINT 1, O BOOL",
        &[("Main", "XIC(I)Scale(S1,A,R,T[K])OTE(O);\nScale(S2,A,S2.Out,T[0]);")],
    );
    of.instructions.push(scale());
    let lines = "pre:S1.Calls=7;S1.Gain=3
        :R=0;S1.Out=-1;S1.Calls=7;S1.EnableOut=0;O=0;T[0]=6
        I:R=6;S1.Out=6;S1.Calls=8;T[1]=6;O=1;S1.EnableIn=1
        K=2,S1.Gain=5:R=10;T[2]=10;T[1]=6;T[0]=18";
    script("an add-on instruction", &of, lines);
}

#[test]
fn add_on_instructions_nest() {
    let mut of = project("O Outer, A DINT 4, R DINT, T DINT", &[("Main", "Outer(O,A,R,T);")]);
    of.instructions.push(InstructionSource {
        name: "Outer".to_owned(),
        parameters: vec![
            parameter("EnableIn", "BOOL", Usage::Input, Some("1")),
            parameter("EnableOut", "BOOL", Usage::Output, Some("0")),
            parameter("X", "DINT", Usage::Input, None),
            parameter("Y", "DINT", Usage::Output, None),
            parameter("Total", "DINT", Usage::InOut, None),
        ],
        locals: vec![(member("Inner", "Scale"), None), (member("Tmr", "TIMER"), None)],
        routines: vec![routine("Logic", "Scale(Inner,X,Y,Total);\nTON(Tmr,?,?);")],
        has_prescan: false,
        has_enable_in_false: false,
        is_encoded: false,
    });
    of.instructions.push(scale());
    script(
        "nested",
        &of,
        ":R=12;T=12;O.Inner.Out=12;O.Inner.Calls=8\n:T=24;O.Tmr.DN=1",
    );
}

#[test]
fn tasks_run_by_rate_and_priority() {
    let mut of = project(
        "A DINT, B DINT, C DINT, Order DINT",
        &[("Main", "ADD(A,1,A);\nMOV(1,Order);")],
    );
    let mut second = of.programs[0].clone();
    second.name = "Second".to_owned();
    second.routines = vec![routine(
        "Main",
        "ADD(B,1,B);\nEQU(Order,1)MOV(2,Order);\nXIC(S:FS)EVENT(Third);",
    )];
    let mut third = of.programs[0].clone();
    third.name = "Third".to_owned();
    third.routines = vec![routine("Main", "ADD(C,1,C);")];
    of.programs.extend([second, third]);
    let task = |name: &str, trigger, priority: u32, program: &str| TaskSource {
        priority,
        ..TaskSource::new(name, trigger, &[program])
    };
    of.tasks = vec![
        task("Slow", Trigger::Periodic(20.0), 9, "Second"),
        task("Fast", Trigger::Periodic(5.0), 2, "Main"),
        task(
            "Third",
            Trigger::Event("EVENT Instruction Only".to_owned(), None),
            1,
            "Third",
        ),
    ];
    // A rate below the tick: the first tick has one release, every other two.
    script("tasks", &of, ":A=1;B=1;C=1;Order=2\n:A=3;B=1;Order=1\n:A=5;B=2;C=1");
}

#[test]
fn faults_name_their_place() {
    #[rustfmt::skip]
    let cases = [
        ("MOV(A[I],N);", "major fault 4/20 (subscript out of range) in Main/Main rung 0, MOV: I is 9"),
        ("XIC(N)TON(T,?,?);", "major fault 4/34 (negative PRE or ACC of a timer) in Main/Main rung 0, TON: PRE is -1"),
        ("XIC(W.[I])OTE(B);", ""),
        ("XIC(W.[J])OTE(B);", "major fault 4/83 (value out of range) in Main/Main rung 0, XIC: J is 32"),
        ("XIC(B)ONS(Bits[J]);", ""),
        ("AFI()ONS(Bits[K]);", "major fault 4/20 (subscript out of range) in Main/Main rung 0, ONS: K is 99"),
        ("FAL(C,?,?,ALL,N,1);", "major fault 4/21 (LEN or POS of a CONTROL out of range) in Main/Main rung 0, FAL: LEN is 0"),
        ("JSR(Sub,0);", "major fault 4/84 (too many calls within one another) in Main/Sub rung 0, JSR"),
        ("JSR(Two,1,5);", "major fault 4/31 (parameters of a subroutine do not fit) in Main/Main rung 0, JSR"),
        ("LBL(x)JMP(x);", "major fault 6/1 (watchdog) in Main/Main rung 0, JMP"),
    ];
    let tags =
        "A DINT[8], I DINT 9, J DINT 32, K DINT 99, N DINT, B BOOL, W DINT, Bits BOOL[64], T TIMER -1, C CONTROL";
    for (rung, expected) in cases {
        let rung = rung.replace("XIC(N)TON", "TON");
        let sub = "JSR(Sub,0);";
        let of = project(tags, &[("Main", &rung), ("Sub", sub), ("Two", "SBR(N,I);")]);
        let mut cell = started(&rung, &of);
        let ran = cell
            .tick(0, 10_000_000, &mut NoMachine)
            .map_err(|fault| fault.to_string());
        assert_eq!(ran.err().unwrap_or_default(), expected, "{rung}");
    }
}

#[test]
fn a_fault_routine_clears_and_the_scan_goes_on() {
    let fault_routine = "GSV(Program,THIS,MajorFaultRecord,R[0]);
        MOV(R[2],Seen);
        MOV(0,R[2]);
        SSV(Program,THIS,MajorFaultRecord,R[0]);";
    let mut of = project(
        "A DINT[8], I DINT 9, N DINT, M DINT, R DINT[11], Seen DINT",
        &[("Main", "MOV(A[I],N)MOV(5,M);\nADD(N,1,N);"), ("Fault", fault_routine)],
    );
    of.programs[0].fault = Some("Fault".to_owned());
    // Type 4 in the low, code 20 in the high word.
    let cell = script("cleared", &of, ":M=5;N=1;Seen=1310724;R[2]=0\n:N=2");
    assert_eq!(cell.faults().count(), 2, "each is listed");
    of.programs[0].routines[1] = routine("Fault", "NOP();");
    let mut cell = started("not cleared", &of);
    assert!(
        cell.tick(0, 10_000_000, &mut NoMachine).is_err(),
        "the fault is still there"
    );
    of.programs[0].fault = None;
    let mut handler = of.programs[0].clone();
    handler.name = "Handler".to_owned();
    handler.routines = vec![routine("Main", fault_routine)];
    of.programs.push(handler);
    of.fault_handler = Some("Handler".to_owned());
    let mut cell = started("the handler", &of);
    cell.tick(0, 10_000_000, &mut NoMachine).expect("the handler clears it");
    expect("the handler", &mut cell, &of, "N=1");
}

#[test]
fn programs_have_tags_of_their_own() {
    let mut of = project("X DINT 1, Y DINT", &[("Main", "MOV(X,Y);\nMOV(\\Other.X,Z);")]);
    of.programs[0].tags = tags("X DINT 5, Z DINT");
    let mut other = of.programs[0].clone();
    other.name = "Other".to_owned();
    other.tags = tags("X DINT 9");
    other.routines = vec![routine("Main", "NOP();")];
    of.programs.push(other);
    script(
        "scopes",
        &of,
        ":Y=5;X=1;Program:Main.Z=9;Program:Main.X=5\nProgram:Main.X=6:Y=6",
    );
}

#[test]
fn a_seed_moves_continuous_scans() {
    let mut of: Project = project("N DINT", &[("Main", "ADD(N,1,N);")]);
    of.tasks[0].trigger = Trigger::Continuous;
    let count = |seed: Option<u64>| {
        let mut cell = started("phase", &of);
        seed.into_iter().for_each(|seed| cell.set_phase(seed));
        for tick in 0..1000 {
            cell.tick(tick, 1_000_000, &mut NoMachine).expect("no fault");
        }
        let tag = cell
            .tags()
            .iter()
            .find(|tag| tag.name == "N")
            .map_or(0, |tag| tag.at as usize);
        cell.memory()[tag..tag + 4].to_vec()
    };
    assert_eq!(count(None), 1000_i32.to_le_bytes());
    assert_eq!(count(Some(1)), count(Some(1)));
    let scans = i32::from_le_bytes(count(Some(7)).try_into().expect("four bytes"));
    assert!((110..500).contains(&scans), "every second to ninth tick: {scans}");
}

//! Mistakes that were mended, a test each.

use super::projects::{add_on, parameter};
use super::{NoMachine, expect, project, routine, script, started};
use crate::load;
use crate::source::{Access, MemberSource, TypeSource, Usage};

#[test]
fn the_carry_is_kept_when_only_an_add_on_instruction_looks_at_it() {
    let mut of = project(
        "A DINT -1, B DINT, S Look, O BOOL",
        &[("Main", "ADD(A,1,B);\nLook(S,O);")],
    );
    let logic = routine("Logic", "XIC(S:C)OTE(Seen);");
    of.instructions.push(add_on(
        "Look",
        vec![parameter("Seen", "BOOL", Usage::Output, None)],
        vec![logic],
    ));
    script("S:C in an instance", &of, ":O=1\nA=1:O=0");
}

#[test]
fn a_bool_by_reference_is_its_bit() {
    let flag = || parameter("Flag", "BOOL", Usage::InOut, None);
    let of = |call: &str| {
        let mut of = project(
            "W DINT, Bits BOOL[40], K DINT 35, S Put, T Pass, B BOOL",
            &[("Main", call)],
        );
        of.instructions
            .push(add_on("Put", vec![flag()], vec![routine("Logic", "OTE(Flag);")]));
        of.instructions
            .push(add_on("Pass", vec![flag()], vec![routine("Logic", "Put(Inner,Flag);")]));
        of.instructions[1].locals.push((
            MemberSource {
                name: "Inner".to_owned(),
                data_type: "Put".to_owned(),
                dimensions: Vec::new(),
                access: Access::ReadWrite,
            },
            None,
        ));
        of
    };
    #[rustfmt::skip]
    let cases = [
        ("Put(S,B);",       ":B=1"),
        ("Put(S,W.3);",     ":W=8"),
        ("Put(S,Bits[K]);", ":Bits[35]=1;Bits[32]=0"),
        ("Pass(T,W.9);",    ":W=512"),
    ];
    for (call, lines) in cases {
        script(call, &of(call), lines);
    }
}

#[test]
fn first_values_in_ascii_are_numbers() {
    let of = project("N DINT 'AB', S SINT 'z'", &[("Main", "NOP();")]);
    script("radix ASCII", &of, ":N=16706;S=122");
}

#[test]
fn texts_are_set_from_outside() {
    let of = project("T STRING, N DINT", &[("Main", "MOV(T.LEN,N);")]);
    script("a text", &of, "T='abc':N=3;T.DATA[2]=99");
}

#[test]
fn members_that_are_left_out_are_named() {
    let mut of = project("N DINT", &[("Main", "NOP();")]);
    let member = |name: &str, data_type: &str, dimensions: Vec<u32>| MemberSource {
        name: name.to_owned(),
        data_type: data_type.to_owned(),
        dimensions,
        access: Access::ReadWrite,
    };
    of.types.push(TypeSource {
        name: "Odd".to_owned(),
        is_string: false,
        members: vec![member("A", "NOTHING", vec![]), member("B", "DINT", vec![70_000])],
    });
    let told: Vec<String> = load(&of, &mut NoMachine)
        .findings
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(
        told,
        [
            "type Odd: the type NOTHING of its member A is not known",
            "type Odd: its member B has 70000 elements, more than 65535"
        ]
    );
}

#[test]
fn a_fault_routine_runs_once_for_each_fault() {
    let mut of = project(
        "L DINT[4], I DINT 9, N DINT, Count DINT",
        &[
            ("Main", "JSR(A,0);"),
            ("A", "JSR(B,0);"),
            ("B", "MOV(L[I],N);"),
            ("Fault", "ADD(Count,1,Count);"),
        ],
    );
    of.programs[0].fault = Some("Fault".to_owned());
    let mut cell = started("not cleared", &of);
    let fault = cell.tick(0, 10_000_000, &mut NoMachine).expect_err("it stays");
    assert!(fault.to_string().contains("Main/B rung 0"), "{fault}");
    expect("two calls lead to it", &mut cell, &of, "Count=1");
}

#[test]
fn a_watchdog_that_is_cleared_again_and_again_ends_the_run() {
    let clear = "GSV(Program,THIS,MajorFaultRecord,R[0]);
        MOV(0,R[2]);
        SSV(Program,THIS,MajorFaultRecord,R[0]);
        ADD(Count,1,Count);";
    let loops = "ST\nWHILE 1 = 1 DO\nWHILE 1 = 1 DO\nN := N + 1;\nEND_WHILE;\nEND_WHILE;";
    let jumps = "LBL(x)ADD(N,1,N);\nJMP(x);";
    for main in [loops, jumps] {
        let mut of = project("N DINT, R DINT[11], Count DINT", &[("Main", main), ("Fault", clear)]);
        of.programs[0].fault = Some("Fault".to_owned());
        let mut cell = started(main, &of);
        let fault = cell
            .tick(0, 10_000_000, &mut NoMachine)
            .expect_err("it never ends by itself");
        assert_eq!((fault.kind, fault.code), (6, 1), "{main}");
        expect(main, &mut cell, &of, "Count=1");
    }
}

#[test]
fn positions_beyond_every_array_are_faults() {
    let of = project(
        "A DINT[4], D DINT, M DINT -1, I BOOL, C CONTROL 2147483647",
        &[("Main", "XIC(I)SQO(A[0],M,D,C,?,?);")],
    );
    let mut cell = started("SQO", &of);
    cell.tick(0, 10_000_000, &mut NoMachine).expect("a false rung");
    super::set("SQO", &mut cell, &of, "C.POS=1500000000");
    super::set("SQO", &mut cell, &of, "I");
    let fault = cell.tick(1, 10_000_000, &mut NoMachine).expect_err("beyond the array");
    assert_eq!((fault.kind, fault.code), (4, 20));
}

#[test]
fn blanks_before_brackets_and_reals_without_digits_behind_the_point() {
    let of = super::project(
        "N DINT, R REAL, S REAL, B BOOL 1",
        &[("Main", "  XIC ( B )  ADD ( N , 1 , N ) ;\nMOV(1.E-3,R)MOV(2.e+1,S);")],
    );
    super::script("read", &of, ":N=1;R>0.00099;R<0.00101;S=20");
}

#[test]
fn a_fault_record_has_the_time_of_its_fault() {
    let clear = "GSV(Program,THIS,MajorFaultRecord,R[0]);\nMOV(0,R[2]);\nSSV(Program,THIS,MajorFaultRecord,R[0]);";
    let mut of = super::project(
        "A DINT[2], I DINT 9, N DINT, R DINT[11]",
        &[("Main", "MOV(A[I],N);"), ("Fault", clear)],
    );
    of.programs[0].fault = Some("Fault".to_owned());
    super::script("4/20", &of, ":R[0]=0\n2 x:R[0]=20000;R[1]=0");
}

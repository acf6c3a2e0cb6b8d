//! Settled steps: a scan that passes over them gives the bytes, faults and instructions of motion of one that executes all.

use arcline_instruction_set::{ControlSlot, Flag};
use proptest::prelude::*;

use super::motion::Machine;
use super::projects::{add_on, member, parameter};
use super::{project, routine};
use crate::readers::Readers;
use crate::source::{InstructionSource, Project, Usage};
use crate::{Cell, load};

const TAGS: &str = "B BOOL[64], W BOOL[64], N DINT[8], M DINT[8], S SINT[8], R REAL[8], I DINT, J DINT, T TIMER 30, U TIMER 20, V TIMER 15, \
    C COUNTER 3, F DINT[12], G DINT[12], X1 STRING a, X2 STRING b, P Press, Q Press, D DINT, X AXIS_CIP_DRIVE, K MOTION_INSTRUCTION, \
    Record DINT[11], Files CONTROL 4, Search CONTROL 6, Queue CONTROL 5, Steps CONTROL 3, Bits CONTROL 30";

/// Rungs: `#` is a number below 8, `%` one below 64.
const RUNGS: [&str; 70] = [
    "XIC(B[%])XIO(B[%])OTE(W[%]);",
    "XIC(W[%])OTE(B[%]);",
    "[XIC(B[%]) ,XIO(W[%]) XIC(B[%]) ]OTL(W[%]);",
    "XIC(B[%])OTU(W[%]);",
    "XIC(B[%])ONS(W[%])ADD(N[#],1,N[#]);",
    "XIC(B[%])OSR(W[%],W[%]);",
    "XIO(B[%])OSF(W[%],W[%]);",
    "XIC(B[%])TON(T,?,?);",
    "XIC(T.DN)OTE(W[%]);",
    "XIC(B[%])TOF(U,?,?);",
    "XIC(B[%])RTO(V,?,?);",
    "XIC(V.TT)XIC(B[%])RES(V);",
    "XIC(B[%])TON(T,?,?)XIC(T.TT)OTE(W[%]);",
    "XIC(B[%])TON(T,?,?)GRT(T.ACC,9)OTE(W[%]);",
    "XIC(B[%])[TON(T,?,?) ,RTO(V,?,?) ]XIO(V.DN)OTE(W[%]);",
    "XIC(T.TT)MOV(N[#],T.PRE);",
    "XIC(B[%])OTU(T.DN);",
    "XIC(B[%])OTL(U.DN);",
    "XIC(B[%])XIC(B[%])OTU(V.DN);",
    "XIC(W[%])CTU(C,?,?);",
    "XIC(B[%])CTD(C,?,?);",
    "XIC(C.DN)RES(C);",
    "GRT(C.ACC,2)MOV(C.ACC,M[#]);",
    "EQU(N[#],M[#])OTE(W[%]);",
    "LES(T.ACC,15)XIC(B[%])MOV(N[#],M[#]);",
    "LIM(0,N[#],5)ADD(M[#],N[#],M[#]);",
    "MEQ(N[#],7,M[#])XIC(B[%])OTE(W[%]);",
    "CPT(R[#],R[#]*0.5+N[#]);",
    "XIC(B[%])CPT(N[#],N[#]*3-M[#]);",
    "XIC(B[%])DIV(N[#],M[#],N[#]);",
    "XIC(B[%])MUL(S[#],3,S[#]);",
    "MOV(N[#],S[#]);",
    "MVM(N[#],15,M[#]);",
    "BTD(N[#],0,M[#],4,4);",
    "XIC(B[%])MOV(N[I],M[J]);",
    "XIC(N[#].#)OTE(M[#].#);",
    "XIC(N[#].[I])OTE(W[J]);",
    "COP(F[#],G[#],3);",
    "XIC(B[%])COP(G[0],F[I],2);",
    "XIC(B[%])FLL(N[#],G[#],4);",
    "XIC(B[%])CLR(N[#]);",
    "CMP(N[#]+M[#]>3)OTE(W[%]);",
    "COP(N[0],G[#],2);",
    "GRT(G[#],3)OTE(W[%]);",
    "EQU(G[#],F[#])OTE(W[%]);",
    "GRT(F[#],N[#])OTE(W[%]);",
    "XIC(B[%])CONCAT(X1,X2,X1);",
    "EQU(X1,X2)OTE(W[%]);",
    "XIC(B[%])DTOS(N[#],X2);",
    "XIC(B[%])Press(P,N[#],M[#],D);",
    "Press(Q,M[#],R[#],N[#]);",
    "XIC(B[%])MAM(X,K,0,N[#],10,Unitspersec)OTE(W[%]);",
    "XIC(K.IP)XIO(K.EN)OTL(W[%]);",
    "XIC(B[%])MOV(#,I)MOV(#,J);",
    "XIC(B[%])XIC(W[%])XIC(B[%])MOV(9,I);",
    "XIC(B[%])FAL(Files,?,?,ALL,G[Files.POS],F[Files.POS]+N[#]);",
    "XIC(B[%])FAL(Files,?,?,2,F[Files.POS],M[#]);",
    "XIC(B[%])FSC(Search,?,?,ALL,G[Search.POS]>N[#]);",
    "XIC(B[%])AVE(F[0],0,R[#],Files,?,?);",
    "XIC(B[%])FFL(N[#],F[0],Queue,?,?);",
    "XIC(B[%])FFU(F[0],M[#],Queue,?,?);",
    "XIC(B[%])SQO(G[0],15,M[#],Steps,?,?);",
    "XIC(B[%])BSL(W[0],Bits,B[%],30);",
    "XIC(B[%])SRT(G[0],0,Files,?,?);",
    "XIC(B[%])GSV(Task,Task,Rate,D);",
    "XIC(B[%])[AFI() ,NOP() ]UPPER(X1,X2);",
    "XIC(B[%])JSR(Other,0);",
    "XIC(B[%])JSR(Words,0);",
    "XIC(B[%])MCR();",
    "XIC(B[%])JMP(Last);",
];

/// Those of them that call no routine and leave none.
const OTHER: usize = 63;

const STATEMENTS: [&str; 12] = [
    "N[#] := M[#] + 1;",
    "IF B[%] THEN W[%] := NOT W[%]; ELSIF N[#] > 3 THEN M[#] := 0; END_IF;",
    "W[%] := B[%] AND NOT W[%];",
    "CASE N[#] OF 0: M[#] := 1; 1..3: M[#] := 2; ELSE M[#] := N[#]; END_CASE;",
    "FOR D := 0 TO 3 DO F[D] := N[D]; END_FOR;",
    "WHILE J > # DO J := J - 1; END_WHILE;",
    "R[#] := R[#] / 2.0 + SIN(R[#]);",
    "Press(Q, N[#], M[#], D);",
    "IF B[%] THEN RETURN; END_IF;",
    "N[I] := N[J];",
    "IF XIC_(B[%]) THEN D := 1; END_IF;",
    "S[#] := N[#];",
];

/// `Press(instance, In, Out, Sum)`: a timer, an edge and sums.
fn press() -> InstructionSource {
    let mut press = add_on(
        "Press",
        vec![
            parameter("In", "DINT", Usage::Input, None),
            parameter("Out", "DINT", Usage::Output, None),
            parameter("Sum", "DINT", Usage::InOut, None),
        ],
        vec![
            routine(
                "Logic",
                "XIC(Wait.DN)ONS(Edge)ADD(Sum,In,Sum);\nGRT(In,2)TON(Wait,?,?);\nMOV(Wait.ACC,Out);\nEQU(Sum,In)OTE(Equal);",
            ),
            routine("EnableInFalse", "MOV(In,Out);"),
        ],
    );
    press.locals = vec![
        (member("Wait", "TIMER"), None),
        (member("Edge", "BOOL"), None),
        (member("Equal", "BOOL"), None),
    ];
    press.has_enable_in_false = true;
    press
}

#[test]
fn add_on_instructions_within_one_another_are_looked_at_once() {
    // Eight calls in each of fourteen: 8^14 ways to the last.
    let mut of = project("Top Level13, N DINT", &[("Main", "Level13(Top);")]);
    for level in 0..14 {
        let (calls, locals) = match level {
            0 => ("ADD(Count,1,Count);".to_owned(), vec![(member("Count", "DINT"), None)]),
            _ => {
                let below = format!("Level{}", level - 1);
                let calls: Vec<String> = (0..8).map(|_| format!("{below}(Inner);")).collect();
                (calls.join("\n"), vec![(member("Inner", &below), None)])
            }
        };
        let mut definition = add_on(&format!("Level{level}"), Vec::new(), vec![routine("Logic", &calls)]);
        definition.locals = locals;
        of.instructions.push(definition);
    }
    let loaded = load(&of, &mut Machine::default());
    assert!(loaded.findings.is_empty(), "{:?}", loaded.findings);
}

/// A template with numbers for its places.
fn filled(template: &str, numbers: &[u8]) -> String {
    let mut numbers = numbers.iter().cycle();
    let mut text = String::new();
    for c in template.chars() {
        match (c, numbers.next()) {
            ('#', Some(number)) => text += &(number % 8).to_string(),
            ('%', Some(number)) => text += &(number % 64).to_string(),
            _ => text.push(c),
        }
    }
    text
}

type Lines = Vec<(usize, Vec<u8>)>;

fn lines(templates: usize, most: usize) -> impl Strategy<Value = Lines> {
    let line = (0..templates, prop::collection::vec(any::<u8>(), 8));
    prop::collection::vec(line, 1..most)
}

fn texts(templates: &[&str], lines: &Lines) -> String {
    let all = lines
        .iter()
        .map(|(number, numbers)| filled(templates[*number], numbers));
    all.collect::<Vec<_>>().join("\n")
}

fn random_project(main: &Lines, other: &Lines, words: &Lines, extra: &str) -> Project {
    let statements = STATEMENTS.map(|text| text.replace("XIC_", ""));
    let statements = statements.each_ref().map(String::as_str);
    let main = format!("{}\nLBL(Last)XIC(B[0])OTE(B[1]);{extra}", texts(&RUNGS, main));
    let other = texts(&RUNGS[..OTHER], other);
    let mut of = project(
        TAGS,
        &[
            ("Main", &main),
            ("Other", &other),
            ("Words", &format!("ST{}", texts(&statements, words))),
        ],
    );
    of.instructions.push(press());
    if let [program] = &mut *of.programs {
        program.fault = Some("Mend".to_owned());
        program.routines.push(routine(
            "Mend",
            "MOV(0,I);\nSSV(Program,THIS,MajorFaultRecord,Record[0]);",
        ));
    }
    of
}

/// Executes every step in each scan.
fn without_rest(cell: &Cell) -> Cell {
    let mut cell = cell.clone();
    cell.memory_mut().set_readers(Readers::default());
    cell
}

/// What happens before a scan: a byte of the tags that clients write is changed, or none.
type Writes = Vec<Option<(u8, u8)>>;

fn same(of: &Project, first: [u8; 16], writes: &Writes, period: u64) -> Result<(), TestCaseError> {
    let mut machine = Machine::default();
    let loaded = load(of, &mut machine);
    prop_assert!(loaded.findings.is_empty(), "{:?}", loaded.findings);
    let mut cell = loaded.cell;
    for (at, byte) in first.iter().enumerate() {
        cell.memory_mut().put_bits(at, 0xFF, *byte);
    }
    cell.start(0, &mut machine).expect("a prescan without fault");
    let mut all = without_rest(&cell);
    let mut other = machine.clone();
    for (tick, write) in (1..).zip(writes) {
        if let Some((at, bits)) = write {
            let at = usize::from(*at) % WRITTEN;
            let value = cell.memory().get(at).copied().unwrap_or_default() ^ bits;
            [&mut cell, &mut all]
                .into_iter()
                .for_each(|one| one.memory_mut().put_bits(at, 0xFF, value));
        }
        if tick % 16 == 0 {
            [&mut cell, &mut all]
                .into_iter()
                .for_each(|one| one.change_control(ControlSlot(0), |control| control.clear(Flag::Ip)));
        }
        let ends = [
            cell.tick(tick, period, &mut machine),
            all.tick(tick, period, &mut other),
        ];
        prop_assert_eq!(&ends[0], &ends[1], "scan {}", tick);
        prop_assert_eq!(&machine.calls, &other.calls, "scan {}", tick);
        prop_assert_eq!(&machine.falses, &other.falses, "scan {}", tick);
        let difference = cell.memory().iter().zip(all.memory().iter()).position(|(a, b)| a != b);
        let tag = difference.and_then(|at| cell.tags().iter().rfind(|tag| tag.at as usize <= at));
        prop_assert!(
            difference.is_none(),
            "scan {}: byte {:?} of {:?}",
            tick,
            difference,
            tag.map(|tag| &tag.name)
        );
        prop_assert!(cell.faults().eq(all.faults()), "scan {}", tick);
        if ends[0].is_err() {
            break;
        }
    }
    Ok(())
}

/// Bytes that clients write: the tags B, W and N.
const WRITTEN: usize = 48;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases * 25 / 16))]

    #[test]
    fn a_scan_that_passes_over_settled_steps_gives_the_same_bytes(
        main in lines(RUNGS.len(), 30),
        other in lines(OTHER, 6),
        words in lines(STATEMENTS.len(), 6),
        writes in prop::collection::vec(prop::option::weighted(0.3, any::<(u8, u8)>()), 60..160),
        first in any::<[u8; 16]>(),
        period in prop::sample::select(vec![500_000_u64, 1_000_000, 10_000_000]),
    ) {
        same(&random_project(&main, &other, &words, ""), first, &writes, period)?;
    }

    #[test]
    fn so_do_projects_that_name_a_status_bit(
        main in lines(RUNGS.len(), 12),
        words in lines(STATEMENTS.len(), 4),
        first in any::<[u8; 16]>(),
        writes in prop::collection::vec(prop::option::weighted(0.3, any::<(u8, u8)>()), 60..100),
    ) {
        same(&random_project(&main, &Vec::from([(0, vec![1, 2, 3])]), &words, "\nXIC(S:Z)OTE(B[2]);\nXIC(S:V)OTE(B[3]);"), first, &writes, 1_000_000)?;
    }
}

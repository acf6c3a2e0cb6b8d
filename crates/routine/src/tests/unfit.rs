//! Operands that begin a word of BOOLs, and those that do not go together: the latter are refused when the project is loaded.

use super::{NoMachine, project, script};
use crate::load;
use crate::source::{Access, MemberSource, Project, TypeSource};

const TAGS: &str = "B BOOL[64], C BOOL[64], D DINT[4], N DINT, I DINT, L SINT, R REAL, P Part[2], Q Part, F BOOL, \
     T TIMER, U TIMER[3], W CONTROL 4, S STRING, H STRING_16, V STRING[3], X INT[8]";

fn with(rung: &str) -> Project {
    let mut of = project(
        TAGS,
        &[
            ("Main", rung),
            ("Sub", "SBR(N)RET(N);"),
            ("Whole", "SBR(T)RET(T);"),
            ("Text", "RET(H);"),
            ("None", "NOP();"),
        ],
    );
    let member = |name: &str, data_type: &str, dimensions: Vec<u32>| MemberSource {
        name: name.to_owned(),
        data_type: data_type.to_owned(),
        dimensions,
        access: Access::ReadWrite,
    };
    of.types.push(TypeSource {
        name: "Part".to_owned(),
        is_string: false,
        members: vec![
            member("Id", "DINT", vec![]),
            member("B", "BOOL", vec![64]),
            member("One", "BOOL", vec![]),
            member("Two", "BOOL", vec![]),
        ],
    });
    of
}

#[test]
fn an_element_of_an_array_of_bools_begins_a_word() {
    let bits = "OTL(B[5])OTL(B[33])";
    #[rustfmt::skip]
    let cases = [
        ("the whole array",      format!("{bits}COP(B,D[0],2);"),                       ":D[0]=32;D[1]=2"),
        ("its first element",    format!("{bits}COP(B[0],D[0],2);"),                    ":D[0]=32;D[1]=2"),
        ("its second word",      format!("{bits}COP(B[32],D[0],2);"),                   ":D[0]=2;D[1]=0"),
        ("CPS",                  format!("{bits}CPS(B[32],D[3],1);"),                   ":D[3]=2"),
        ("words as destination", "MOV(1,D[0])MOV(2,D[1])COP(D[0],B[32],2);".to_owned(), ":B[32]=1;B[33]=0;B[0]=0;C[1]=0"),
        ("one word",             "MOV(3,D[0])COP(D[0],B[0],1);".to_owned(),             ":B[0]=1;B[1]=1;B[32]=0"),
        ("a member",             "OTL(P[1].B[5])COP(P[1].B[0],D[0],1)COP(P[1].B[32],D[1],1);".to_owned(), ":D[0]=32;D[1]=0"),
        ("a member by index",    "MOV(1,I)OTL(P[1].B[37])COP(P[I].B[32],D[0],1);".to_owned(), ":D[0]=32"),
        ("FLL",                  "FLL(5,B[32],2);".to_owned(),                          ":B[32]=1;B[33]=0;B[34]=1;B[0]=0;C[0]=0"),
        ("FLL from words",       format!("{bits}FLL(B[32],D[1],2);"),                   ":D[0]=0;D[1]=2;D[2]=2;D[3]=0"),
        ("SIZE",                 "SIZE(B[0],0,N);".to_owned(),                          ":N=64"),
        ("BSL",                  "OTL(B[31])MOV(64,W.LEN)BSL(B[0],W,F,?);".to_owned(),  ":B[32]=1;B[31]=0"),
    ];
    for (why, rung, lines) in cases {
        script(why, &with(&rung), lines);
    }
}

#[test]
fn a_routine_returns_a_shorter_text() {
    script("a text", &with("MOV('ab',H)JSR(Text,0,S);"), ":S.LEN=2;S.DATA[1]=98");
}

#[test]
fn fills_have_the_type_of_their_source() {
    #[rustfmt::skip]
    let cases = [
        ("texts",              "MOV('ab',S)FLL(S,V[1],9);",          ":V[0].LEN=0;V[1].LEN=2;V[2].LEN=2;V[2].DATA[1]=98"),
        ("structures",         "MOV(7,T.PRE)FLL(T,U[0],3);",         ":U[0].PRE=7;U[2].PRE=7"),
        ("a number in a UDT",  "FLL(16#01020304,Q,1);",              ":Q.Id=16#01020304;Q.B[2]=1;Q.B[0]=0"),
        ("a SINT in a UDT",    "MOV(1,L)FLL(L,Q,1);",                ":Q.Id=16#01010101"),
        ("a REAL in a UDT",    "MOV(1.0,R)FLL(R,Q,1);",              ":Q.Id=16#3F800000"),
        ("another type",       "MOV(-2,X[0])FLL(X,D[0],2);",         ":D[0]=-2;D[1]=-2;D[2]=0"),
        ("an element",         "MOV(2.5,R)FLL(R,X[1],2);",           ":X[0]=0;X[1]=2;X[2]=2"),
    ];
    for (why, rung, lines) in cases {
        script(why, &with(rung), lines);
    }
}

#[test]
fn operands_that_do_not_go_together_are_refused() {
    #[rustfmt::skip]
    let cases = [
        ("COP(B[5],D[0],1)",         "Source B[5]: begins no word of 32 BOOLs"),
        ("COP(B[8],D[0],1)",         "Source B[8]: begins no word of 32 BOOLs"),
        ("COP(D[0],B[I],1)",         "Dest B[I]: is a BOOL by a subscript that is calculated, expected one that begins a word of 32 BOOLs"),
        ("COP(F,D[0],1)",            "Source is a BOOL"),
        ("COP(D[0],F,1)",            "Dest is a BOOL, expected data"),
        ("COP(D[0],N.3,1)",          "Dest is a BOOL, expected data"),
        ("COP(N,5,1)",               "Dest is a number, expected data"),
        ("FLL(F,D[0],1)",            "Source is a BOOL, Dest is DINT"),
        ("FLL('a',D[0],1)",          "Source is a text, Dest is DINT"),
        ("FLL(S,D[0],1)",            "Source is STRING, Dest is DINT"),
        ("FLL(T,W,1)",               "Source is TIMER, Dest is CONTROL"),
        ("SIZE(5,0,N)",              "Source is a number, expected data"),
        ("SIZE(F,0,N)",              "Source is a BOOL, expected data"),
        ("MOV(S,N)",                 "Source is a text, Dest is a number"),
        ("MOV(5,S)",                 "Source is a number, Dest is a text"),
        ("MOV(T,N)",                 "Source T: T is TIMER, expected a number"),
        ("SWPB(N,WORD,F)",           "Dest is a BOOL, expected a whole number"),
        ("BSL(N.2,W,F,?)",           "Array is a BOOL, expected data"),
        ("BSR(U[0],W,F,?)",          "Array is TIMER, expected numbers"),
        ("FFL(F,D[0],W,?,?)",        "Source is a BOOL, expected DINT"),
        ("FFL(B[0],D[0],W,?,?)",     "Source is a BOOL, expected DINT"),
        ("FFL(5,U[0],W,?,?)",        "Source is a number, expected TIMER"),
        ("FFL(T,D[0],W,?,?)",        "Source is TIMER, expected DINT"),
        ("LFU(D[0],F,W,?,?)",        "Dest is a BOOL, expected DINT"),
        ("FFU(D[0],5,W,?,?)",        "Dest is a number, expected DINT"),
        ("SQI(U[0],1,N,W,?,?)",      "Array is TIMER, expected numbers"),
        ("SQL(F,N,W,?,?)",           "Array is a BOOL, expected data"),
        ("AVE(U[0],0,R,W,?,?)",      "Array is TIMER, expected numbers"),
        ("JSR(Sub,1,T)",             "input 1: TIMER does not fit into a number"),
        ("JSR(Sub,1,D)",             "input 1: an array of DINT does not fit into a number"),
        ("JSR(Whole,1,N)",           "input 1: a number does not fit into TIMER"),
        ("JSR(Whole,1,W)",           "input 1: CONTROL does not fit into TIMER"),
        ("JSR(Sub,1,N,T)",           "return 1: a number does not fit into TIMER"),
        ("GSV(Task,THIS,Rate,Q.Two)", "Q.Two: is a bit, expected data"),
    ];
    for (rung, expected) in cases {
        let of = with(&format!("{rung};"));
        let told: Vec<String> = load(&of, &mut NoMachine)
            .findings
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(told, [format!("Main/Main rung 0: {rung}: {expected}")]);
    }
    #[rustfmt::skip]
    let statements = [
        ("T := 5;", "T := 5: a number does not fit into TIMER"),
        ("T := W;", "T := W: CONTROL does not fit into TIMER"),
        ("D := N;", ""),
        ("T := 'a';", "T := 'a': a text does not fit into TIMER"),
    ];
    for (line, expected) in statements {
        let of = with(&format!("ST\n{line}"));
        let told: Vec<String> = load(&of, &mut NoMachine)
            .findings
            .iter()
            .map(ToString::to_string)
            .collect();
        let expected = (!expected.is_empty()).then(|| format!("Main/Main line 1: statement: {expected}"));
        assert_eq!(told, Vec::from_iter(expected), "{line}");
    }
}

//! Parameters of add-on instructions that are aliases of local tags (spec/programs.md §13): parts of the instance like any other.

use super::projects::{add_on, parameter};
use super::{NoMachine, project, routine, script};
use crate::load;
use crate::source::{Access, MemberSource, ParameterSource, Project, Usage};

fn alias(name: &str, target: &str, usage: Usage, is_required: bool) -> ParameterSource {
    let mut alias = parameter(name, "", usage, None);
    (alias.alias, alias.is_required) = (Some(target.to_owned()), is_required);
    alias
}

fn with(parameters: Vec<ParameterSource>, main: &str, logic: &str) -> Project {
    let mut of = project(
        "S Do, T Do[2], U Outer, A DINT, B DINT, K DINT, R REAL",
        &[("Main", main)],
    );
    let local = |name: &str, data_type: &str, dimensions: &[u32]| {
        let member = MemberSource {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            dimensions: dimensions.to_vec(),
            access: Access::ReadWrite,
        };
        (member, None)
    };
    let mut first = add_on("Do", parameters, vec![routine("Logic", logic)]);
    first.locals = vec![
        local("Tm", "TIMER", &[]),
        local("W", "DINT", &[]),
        local("L", "DINT", &[4]),
        local("M", "INT", &[2, 3]),
        local("F", "BOOL", &[64]),
        local("C", "CONTROL", &[2]),
        local("One", "BOOL", &[]),
        local("Two", "BOOL", &[]),
    ];
    let mut second = add_on(
        "Outer",
        vec![alias("Deep", "Inner.Pre", Usage::Input, false)],
        Vec::new(),
    );
    second.locals = vec![local("Inner", "Do", &[])];
    of.instructions = vec![first, second];
    of
}

#[test]
fn aliases_are_members_of_the_instance() {
    let parameters = || {
        let one = |name, target| alias(name, target, Usage::Input, false);
        vec![
            // An alias of an alias, before its target.
            one("Again", "Pre"),
            one("Pre", "Tm.PRE"),
            one("Dn", "Tm.DN"),
            one("Bit", "W.9"),
            one("Third", "L[2]"),
            one("Cell", "M[1,2]"),
            one("Flag", "F[37]"),
            one("Len", "C[1].LEN"),
            one("Second", "Two"),
            one("Whole", "Tm"),
            one("List", "L"),
        ]
    };
    #[rustfmt::skip]
    let cases = [
        ("a member",            "MOV(20,S.Pre)MOV(S.Tm.PRE,A);",           ":A=20;S.Again=20"),
        ("its alias",           "MOV(20,S.Again)MOV(S.Pre,A);",            ":A=20;S.Tm.PRE=20"),
        ("a bit of a member",   "OTL(S.Tm.DN)XIC(S.Dn)MOV(1,A);",          ":A=1"),
        ("a bit of a number",   "OTL(S.Bit)MOV(S.W,A);",                   ":A=512"),
        ("an element",          "MOV(3,S.Third)MOV(S.L[2],A);",            ":A=3;S.L[1]=0"),
        ("of two dimensions",   "MOV(3,S.Cell)MOV(S.M[5],A);",             ":A=3"),
        ("an element of bits",  "OTL(S.Flag)XIC(S.F[37])MOV(1,A);",        ":A=1;S.F[36]=0"),
        ("of an element",       "MOV(3,S.Len)MOV(S.C[1].LEN,A);",          ":A=3"),
        ("a BOOL",              "OTL(S.Second)XIC(S.Two)XIO(S.One)MOV(1,A);", ":A=1"),
        ("a structure",         "MOV(5,S.Whole.PRE)MOV(S.Pre,A);",         ":A=5"),
        ("an array",            "MOV(1,K)MOV(7,S.List[K])MOV(S.L[1],A);",  ":A=7"),
        ("of an element of an array", "MOV(1,K)MOV(7,T[K].Pre)MOV(T[1].Tm.PRE,A);", ":A=7;T[0].Pre=0"),
        ("of an instance in an instance", "MOV(7,U.Deep)MOV(U.Inner.Tm.PRE,A);", ":A=7;U.Inner.Again=7"),
        ("in the logic",        "OTL(S.Bit)Do(S);",                         ":S.Pre=11;S.W=512"),
    ];
    for (why, main, lines) in cases {
        script(why, &with(parameters(), main, "XIC(Bit)MOV(11,Again);"), lines);
    }
}

#[test]
fn aliases_take_operands_of_calls() {
    let parameters = vec![
        alias("Pre", "Tm.PRE", Usage::Input, true),
        alias("On", "W.1", Usage::Input, true),
        alias("Dn", "Tm.DN", Usage::Output, true),
        alias("Acc", "Tm.ACC", Usage::Output, true),
    ];
    let of = with(parameters, "Do(S,20,K.2,A.4,B);", "XIC(On)TON(Tm,?,?);");
    script(
        "a timer",
        &of,
        "K=4:A=0;B=0\n:B=10\n:A=16;B=20;S.Dn=1;S.Tm.PRE=20;S.W=2",
    );
}

#[test]
fn aliases_are_in_the_template_and_take_no_room() {
    let plain = load(&with(Vec::new(), "NOP();", "NOP();"), &mut NoMachine);
    let parameters = vec![
        alias("Pre", "Tm.PRE", Usage::Input, false),
        alias("Bit", "W.9", Usage::Input, false),
        alias("Gone", "Nothing.X", Usage::Input, false),
    ];
    let with = load(&with(parameters, "NOP();", "NOP();"), &mut NoMachine);
    assert_eq!(with.cell.memory().len(), plain.cell.memory().len());
    let tag = &with.cell.tags()[0];
    let arcline_tag::DataType::Structure(template) = &tag.tag_type.data_type else {
        panic!("an instance is a structure");
    };
    let (timer, word) = (
        template.member("Tm").expect("a local tag"),
        template.member("W").expect("a local tag"),
    );
    let place = |name: &str| template.member(name).map(|one| (one.offset, one.bit, one.hidden));
    assert_eq!(place("Pre"), Some((timer.offset + 4, None, false)));
    assert_eq!(place("Bit"), Some((word.offset + 1, Some(1), false)));
    let told: Vec<String> = with.findings.iter().map(ToString::to_string).collect();
    let expected = "type Do: its parameter Gone is an alias of Nothing.X, which it does not have";
    assert_eq!(told, [expected]);
}

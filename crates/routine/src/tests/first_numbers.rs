//! Numbers in a text in place of `?` (spec/programs.md §3): first values, if the file has no data for the tag.

use super::projects::{add_on, member};
use super::{NoMachine, project, routine, script};
use crate::source::{Datum, Project};
use crate::{FindingKind, load};

fn told(of: &Project) -> Vec<String> {
    let loaded = load(of, &mut NoMachine);
    loaded.findings.iter().map(ToString::to_string).collect()
}

#[test]
fn a_number_is_the_first_value_of_a_tag_without_data() {
    let rungs = "TON(T,30,0);\nCTU(C[2],3,1);\nSQO(A[0],-1,D,K,4,2);\nTON(Held,500,0);\nTON(E[I],700,0);";
    let tags = "T TIMER, C COUNTER[4], A DINT[8], D DINT, K CONTROL, Held TIMER 500, E TIMER[2], I DINT";
    let of = project(tags, &[("Main", rungs)]);
    script(
        "numbers",
        &of,
        "pre : T.PRE=30; C[2].PRE=3; C[2].ACC=1; C[1].PRE=0; K.LEN=4; K.POS=2; Held.PRE=500; E[0].PRE=0
        T.PRE=50 : T.PRE=50
        : T.DN=0",
    );
}

#[test]
fn the_data_of_a_tag_counts_and_a_difference_is_told() {
    let of = project(
        "T TIMER 40, Two TIMER",
        &[("Main", "TON(T,30,7);\nTON(Two,5,0);\nTON(Two,6,0);")],
    );
    let expected = [
        "Main/Main rung 0: tag T.PRE: is 30 here and 40 in the data of its tag, which counts",
        "Main/Main rung 2: tag Two.PRE: is 6 here and 5 in another text; this one counts",
    ];
    assert_eq!(told(&of), expected);
    let mut loaded = load(&of, &mut NoMachine);
    assert!(loaded.findings.iter().all(|one| one.kind == FindingKind::FirstNumber));
    loaded.cell.start(0, &mut NoMachine).expect("it starts");
    super::expect("data", &mut loaded.cell, &of, "T.PRE=40 AND T.ACC=0 AND Two.PRE=6");
}

#[test]
fn what_is_no_number_is_refused() {
    for (text, reason) in [
        ("TON(T,N,0);", "Preset N: expected ? or a number that a DINT holds"),
        ("TON(T,?,1.5);", "Accum 1.5: expected ? or a number that a DINT holds"),
        (
            "TON(T,3000000000,0);",
            "Preset 3000000000: expected ? or a number that a DINT holds",
        ),
    ] {
        let of = project("T TIMER 10, N DINT", &[("Main", text)]);
        let written = text.trim_end_matches(';');
        assert_eq!(told(&of), [format!("Main/Main rung 0: {written}: {reason}")]);
    }
}

/// The local timers of all instances for which the file has no data, those within others and within arrays among them.
#[test]
fn instances_of_add_on_instructions_have_the_numbers_of_their_text() {
    let ten = Datum::Structure(
        "TIMER".to_owned(),
        vec![("PRE".to_owned(), Datum::Number("10".to_owned()))],
    );
    let mut inner = add_on(
        "Inner",
        Vec::new(),
        vec![routine("Logic", "TON(Tm,40,0);\nTON(Own,20,0);")],
    );
    inner.locals = vec![(member("Tm", "TIMER"), None), (member("Own", "TIMER"), Some(ten))];
    let mut outer = add_on("Outer", Vec::new(), vec![routine("Logic", "Inner(In);")]);
    outer.locals = vec![(member("In", "Inner"), None)];
    let mut of = project(
        "A Outer, B Inner[2]",
        &[("Main", "Outer(A);\nInner(B[0]);\nInner(B[1]);")],
    );
    of.instructions = vec![inner, outer];
    let expected = ["Inner/Logic rung 1: tag Own.PRE: is 20 here and 10 in the data of its tag, which counts"];
    assert_eq!(told(&of), expected);
    let mut loaded = load(&of, &mut NoMachine);
    loaded.cell.start(0, &mut NoMachine).expect("it starts");
    for text in [
        "A.In.Tm.PRE=40 AND A.In.Own.PRE=10",
        "B[0].Tm.PRE=40 AND B[0].Own.PRE=10",
        "B[1].Tm.PRE=40",
    ] {
        super::expect("instances", &mut loaded.cell, &of, text);
    }
}

//! Texts: printing gives a text back as it was read; no text panics.

use proptest::prelude::*;

use crate::rll::{Element, Instruction, Operand};
use crate::st::StatementKind;
use crate::{Expression, Rung, Text};

#[test]
fn rungs_print_as_they_were() {
    let rungs = [
        ";",
        "NOP();",
        "NOP NOP XIC(a)NOP;",
        "XIC(a)OTE(b);",
        "[XIC(a) OTE(b) ,XIC(c) OTE(d) ];",
        "XIC(Local:1:I.Data.0)[,XIO(b[3,i+1].c.[n]) ]MAM(X,M,0,100,50,Units per sec,% of Maximum);",
        "CONCAT('a,b)$'',s,d)CPT(d,(a[1]+b)*2);",
    ];
    for text in rungs {
        let rung = Rung::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let printed = rung.to_string();
        let plain = |text: &str| text.replace(' ', "");
        assert_eq!(plain(&printed), plain(text));
        assert_eq!(Rung::parse(&printed).expect("printed").to_string(), printed);
    }
}

#[test]
fn comments_around_the_operands_of_a_call_do_not_belong_to_them() {
    let text = "MAS(X, M /* control */, // what stops\n All, No // no change\n, (*rate*) 10.0 (*of*), % of Maximum // units\n);";
    let read = Text::parse(text).expect("a call");
    let StatementKind::Call(_, operands) = &read.statements[0].kind else {
        panic!("{:?}", read.statements);
    };
    let texts: Vec<&str> = operands.iter().map(|one| one.text.as_str()).collect();
    assert_eq!(texts, ["X", "M", "All", "No", "10.0", "% of Maximum"]);
}

#[test]
fn wrong_rungs_say_where() {
    #[rustfmt::skip]
    let cases = [
        ("XIC(a)", 6), ("XIC(a;", 6), ("[XIC(a);", 7), ("XIC(a)];", 6), ("XIC(a));", 6), ("XIC('a);", 4), ("1;", 0), ("; x", 2), ("XIC(a]);", 5),
    ];
    for (text, at) in cases {
        let error = Rung::parse(text).expect_err(text);
        assert_eq!(error.at(), at, "{text}: {error}");
    }
}

#[test]
fn long_and_deep_texts_are_refused() {
    let cases = [
        ("a chain", format!("CPT(d,{}1);", "1+".repeat(600))),
        ("brackets", format!("CPT(d,{}1{});", "(".repeat(80), ")".repeat(80))),
        ("signs", format!("CPT(d,{}1);", "-".repeat(5000))),
    ];
    for (why, text) in cases {
        let rung = Rung::parse(&text);
        let refused = match &rung {
            Ok(rung) => {
                let mut refused = false;
                rung.visit(&mut |one| refused |= one.operands().iter().any(|o| Expression::parse(&o.text).is_err()));
                refused
            }
            Err(_) => true,
        };
        assert!(refused, "{why}");
    }
    let nested = format!("{};", "IF a THEN ".repeat(500));
    assert!(Text::parse(&nested).is_err());
}

#[test]
fn expressions_keep_the_order_of_operators() {
    #[rustfmt::skip]
    let cases = [
        ("2+3*4", "(2+(3*4))"), ("2**3**2", "((2**3)**2)"), ("-2**2", "(-(2**2))"), ("a AND b = c", "(a AND (b=c))"),
        ("NOT a OR b XOR c", "((NOT a) OR (b XOR c))"), ("a - b - c", "((a-b)-c)"), ("2**-1", "(2**(-1))"), ("a MOD b * c", "((a MOD b)*c)"),
        ("a < b + 1", "(a<(b+1))"), ("SIN(x)/2", "(SIN(x)/2)"), ("\\P.t.x", "\\P.t.x"), ("16#FF_00", "65280"), ("1.5e3", "1500.0"), ("w.[i+1]", "w.[(i+1)]"),
    ];
    for (text, expected) in cases {
        let read = Expression::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(read.to_string(), expected, "{text}");
    }
}

fn name() -> impl Strategy<Value = String> {
    "[A-Za-z_][A-Za-z0-9_]{0,6}"
}

fn operand() -> impl Strategy<Value = Operand> {
    let text = prop_oneof![
        name(),
        Just("?".to_owned()),
        (name(), 0..9_u32).prop_map(|(name, place)| format!("{name}[{place},b+1].c")),
        (name(), name()).prop_map(|(a, b)| format!("({a}+{b})*2")),
        "[a-z ,()]{0,5}".prop_map(|text| format!("'{text}'")),
        Just("Units per sec2".to_owned()),
    ];
    text.prop_map(|text| Operand { text, at: 0 })
}

fn element() -> impl Strategy<Value = Element> {
    let instruction = (name(), proptest::option::of(proptest::collection::vec(operand(), 0..4)))
        .prop_map(|(name, operands)| Element::Instruction(Instruction { name, at: 0, operands }));
    instruction.prop_recursive(4, 24, 4, |inner| {
        proptest::collection::vec(proptest::collection::vec(inner, 0..3), 1..4).prop_map(Element::Branch)
    })
}

/// Places aside.
fn plain(rung: &Rung) -> String {
    let mut text = String::new();
    rung.visit(&mut |one| {
        text.push_str(&format!(
            "{} {:?};",
            one.name,
            one.operands().iter().map(|o| &o.text).collect::<Vec<_>>()
        ))
    });
    text
}

proptest! {
    #[test]
    fn any_rung_reads_as_it_prints(elements in proptest::collection::vec(element(), 0..6)) {
        // Two names in a row need brackets between them.
        let mut elements = elements;
        for element in &mut elements {
            bracket(element);
        }
        let rung = Rung { elements };
        let printed = rung.to_string();
        let read = Rung::parse(&printed).map_err(|error| TestCaseError::fail(format!("{printed}: {error}")))?;
        prop_assert_eq!(plain(&read), plain(&rung));
        prop_assert_eq!(read.to_string(), printed);
    }

    #[test]
    fn no_text_panics(text in "[\\x20-\\x7e\n\u{e4}]{0,80}") {
        let _ = Rung::parse(&text);
        let _ = Text::parse(&text);
        if let Ok(read) = Expression::parse(&text) {
            let printed = read.to_string();
            let again = Expression::parse(&printed).map_err(|error| TestCaseError::fail(format!("{printed}: {error}")))?;
            prop_assert_eq!(again.to_string(), printed);
        }
    }

    #[test]
    fn no_words_of_structured_text_panic(words in proptest::collection::vec(
        prop::sample::select(vec!["IF ", "THEN ", "END_IF", "CASE ", "OF ", "1..2", ":", ";", "a", ":=", "(", ")", "[", "]", "FOR ", "TO ",
            "DO ", "END_FOR", "REPEAT ", "UNTIL ", "END_REPEAT", "END_CASE", "ELSE ", "-", "NOT ", "'x'", ".", "5", "EXIT", "WHILE ", ","]), 0..40)) {
        let text = words.concat();
        if let Ok(read) = Text::parse(&text) {
            prop_assert_eq!(read.to_string(), text);
        }
    }
}

fn bracket(element: &mut Element) {
    match element {
        Element::Instruction(one) => {
            one.operands.get_or_insert_default();
        }
        Element::Branch(legs) => legs.iter_mut().flatten().for_each(bracket),
    }
}

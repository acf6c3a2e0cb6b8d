//! Calls that bind, calls that do not with the reason, and the operand that is out of range first.

use proptest::prelude::*;

use super::*;

fn address(tag: u32) -> TagAddress {
    TagAddress::new(tag, 0).expect("an address")
}

struct Machine;

impl Directory for Machine {
    fn object(&self, object: Object, name: &str) -> Option<u16> {
        match (object, name.to_ascii_lowercase().as_str()) {
            (Object::Axis, "master") => Some(3),
            (Object::CoordinateSystem, "cs2") => Some(1),
            _ => None,
        }
    }

    fn real_array(&self, name: &str) -> Option<WrittenArray> {
        let results = WrittenArray {
            tag: address(17),
            elements: 4,
        };
        name.eq_ignore_ascii_case("results").then_some(results)
    }
}

/// Reads operands as a test writes them: numbers, `[arrays]`, words; `_` is left out.
fn unbound(text: &str) -> Vec<UnboundOperand> {
    let mut operands = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let end = match rest.strip_prefix('[') {
            Some(inside) => 2 + inside.find(']').expect("closing bracket"),
            None => rest.find(',').unwrap_or(rest.len()),
        };
        let operand = rest[..end].trim();
        operands.push(match operand.parse::<f64>() {
            Ok(number) => UnboundOperand::Number(number),
            Err(_) if operand == "_" => UnboundOperand::Missing,
            Err(_) => match operand.strip_prefix('[') {
                Some(inside) => UnboundOperand::Array(
                    inside
                        .trim_end_matches(']')
                        .split(',')
                        .filter_map(|number| number.trim().parse().ok())
                        .collect(),
                ),
                None => UnboundOperand::Word(operand.to_owned()),
            },
        });
        rest = rest[end..].trim_start_matches(',').trim();
    }
    operands
}

/// Binds and verifies: `ok`, the operand out of range, or the message of the operand that cannot be bound.
fn outcome(name: &str, axes: usize, operands: &str) -> String {
    let mnemonic: Mnemonic = name.parse().expect("a mnemonic");
    match bind(mnemonic, Some(0), ControlSlot(0), &unbound(operands), &Machine) {
        Err(error) => error.to_string(),
        Ok(call) => match mnemonic.instruction().verify(&call, axes) {
            Ok(()) => "ok".to_owned(),
            Err(OperandIndex(operand)) => format!("13/{operand}"),
        },
    }
}

const MCLM: &str = "0, [9,0,0], 50, 0, 500, 0, 500, 0, 1, 100, 100, 2, 0, 0, 0, 0, 0, 0, 0, 0";
const MCCM: &str = "0, [9,0], 2, 5, 0, 50, 0, 500, 0, 500, 0, 1, 100, 100, 2, 0, 0, 0, 0, 0, 0, 0, 0";
const MCCD: &str = "1, 1, 50, 0, 1, 500, 0, 1, 500, 0, 1, 100, 1, 100, 2, 0";
const MCS: &str = "0, 1, 500, 0, 1, 100, 2";
const MAM: &str = "0, 9, 50, 0, 500, 0, 500, 0, 1, 100, 100, 2, 0, 0, 0, 0, 0, 0";
const MAJ: &str = "0, 50, 0, 500, 0, 500, 0, 1, 100, 100, 2, 0, 0, 0, 0";
const MAS: &str = "0, 1, 500, 0, 1, 100, 2";
const MCD: &str = "1, 1, 50, 1, 500, 1, 500, 1, 100, 1, 100, 0, 0, 0, 2";
const MAG: &str = "Master, 0, 1, 1, 1, 0, 0, 0, 100, 1";

/// `base` with the operands at some faceplate positions replaced.
fn with(name: &str, base: &str, changes: &[(usize, &str)]) -> String {
    let mnemonic: Mnemonic = name.parse().expect("a mnemonic");
    let places: Vec<_> = mnemonic.instruction().operands_behind_control().collect();
    let mut operands: Vec<String> = Vec::new();
    let mut depth = false;
    for part in base.split(',') {
        match operands.last_mut() {
            Some(last) if depth => *last = format!("{last},{part}"),
            _ => operands.push(part.trim().to_owned()),
        }
        depth = (depth || part.contains('[')) && !part.contains(']');
    }
    for (place, value) in changes {
        let k = places
            .iter()
            .position(|p| p == place)
            .expect("an operand behind the control");
        operands[k] = (*value).to_owned();
    }
    operands.join(", ")
}

#[test]
fn operands_out_of_range_are_found_in_faceplate_order() {
    type Case<'a> = (&'a str, usize, &'a str, &'a [(usize, &'a str)], &'a str);
    #[rustfmt::skip]
    let cases: &[Case<'_>] = &[
        // instruction, axes, base, changes, outcome
        ("MCLM", 3, MCLM, &[], "ok"),
        ("MCLM", 0, MCLM, &[], "13/0"),
        ("MCLM", 4, MCLM, &[], "13/0"),
        ("MCLM", 3, MCLM, &[(2, "2")], "13/2"),
        ("MCLM", 3, MCLM, &[(2, "-1")], "13/2"),
        ("MCLM", 3, MCLM, &[(2, "0.5")], "ok"),         // half to even: 0
        ("MCLM", 3, MCLM, &[(2, "1.5")], "13/2"),       // half to even: 2
        ("MCLM", 3, MCLM, &[(2, "nan")], "13/2"),
        ("MCLM", 3, MCLM, &[(2, "4294967296")], "13/2"), // does not wrap to 0
        ("MCLM", 3, MCLM, &[(3, "[9,0]")], "13/3"),
        ("MCLM", 2, MCLM, &[(3, "[9,0]")], "ok"),
        ("MCLM", 1, MCLM, &[(3, "9")], "ok"),
        ("MCLM", 3, MCLM, &[(3, "[9,nan,0]")], "13/3"),
        ("MCLM", 1, MCLM, &[(3, "[9,nan,0]")], "ok"),   // elements beyond the axes are not looked at
        ("MCLM", 3, MCLM, &[(4, "-1")], "13/4"),
        ("MCLM", 3, MCLM, &[(4, "0")], "ok"),
        ("MCLM", 3, MCLM, &[(4, "inf")], "13/4"),
        ("MCLM", 3, MCLM, &[(5, "2")], "13/5"),
        ("MCLM", 3, MCLM, &[(5, "3")], "13/5"),
        ("MCLM", 3, MCLM, &[(5, "Seconds")], "13/5"),
        ("MCLM", 3, MCLM, &[(5, "5")], "13/5"),
        ("MCLM", 3, MCLM, &[(5, "7")], "13/5"),
        ("MCLM", 3, MCLM, &[(5, "4")], "ok"),           // units that do not go together are 94, elsewhere
        ("MCLM", 3, MCLM, &[(6, "0")], "13/6"),
        ("MCLM", 3, MCLM, &[(7, "3")], "13/7"),
        ("MCLM", 3, MCLM, &[(8, "-5")], "13/8"),
        ("MCLM", 3, MCLM, &[(9, "6")], "13/9"),
        ("MCLM", 3, MCLM, &[(10, "2")], "13/10"),
        ("MCLM", 3, MCLM, &[(11, "0")], "13/11"),
        ("MCLM", 3, MCLM, &[(11, "101")], "13/11"),
        ("MCLM", 3, MCLM, &[(11, "101"), (13, "0")], "ok"),
        ("MCLM", 3, MCLM, &[(11, "101"), (13, "6")], "13/11"),
        ("MCLM", 3, MCLM, &[(11, "0"), (10, "0")], "ok"), // trapezoidal: any value
        ("MCLM", 3, MCLM, &[(11, "nan"), (10, "0")], "13/11"),
        ("MCLM", 3, MCLM, &[(12, "-1")], "13/12"),
        ("MCLM", 3, MCLM, &[(13, "3")], "13/13"),
        ("MCLM", 3, MCLM, &[(13, "5")], "13/13"),
        ("MCLM", 3, MCLM, &[(13, "7")], "13/13"),
        ("MCLM", 3, MCLM, &[(14, "7")], "13/14"),
        ("MCLM", 3, MCLM, &[(15, "3")], "13/15"),
        ("MCLM", 3, MCLM, &[(16, "2")], "13/16"),
        ("MCLM", 3, MCLM, &[(17, "-1"), (14, "6")], "13/17"),
        ("MCLM", 3, MCLM, &[(17, "-1"), (14, "2")], "ok"),
        ("MCLM", 3, MCLM, &[(18, "nan")], "13/18"),
        ("MCLM", 3, MCLM, &[(19, "5")], "13/19"),
        ("MCLM", 3, MCLM, &[(20, "[5,nan]")], "13/20"),
        ("MCLM", 3, MCLM, &[(20, "[5,1]"), (21, "Results")], "ok"),
        ("MCLM", 3, MCLM, &[(4, "-1"), (2, "9")], "13/2"), // the first one counts
        ("MCCM", 2, MCCM, &[], "ok"),
        ("MCCM", 1, MCCM, &[], "13/0"),
        ("MCCM", 2, MCCM, &[(2, "2")], "13/2"),
        ("MCCM", 2, MCCM, &[(3, "[9]")], "13/3"),
        ("MCCM", 2, MCCM, &[(4, "4")], "13/4"),
        ("MCCM", 2, MCCM, &[(4, "0")], "13/5"),         // one element is enough for a radius only
        ("MCCM", 2, MCCM, &[(4, "0"), (5, "[1,1]")], "ok"),
        ("MCCM", 2, MCCM, &[(5, "[5,nan]")], "ok"),
        ("MCCM", 2, MCCM, &[(6, "4")], "13/6"),
        ("MCCM", 2, MCCM, &[(7, "-1")], "13/7"),
        ("MCCM", 2, MCCM, &[(8, "2")], "13/8"),
        ("MCCM", 2, MCCM, &[(9, "0")], "13/9"),
        ("MCCM", 2, MCCM, &[(10, "5")], "13/10"),
        ("MCCM", 2, MCCM, &[(11, "0")], "13/11"),
        ("MCCM", 2, MCCM, &[(12, "7")], "13/12"),
        ("MCCM", 2, MCCM, &[(13, "-1")], "13/13"),
        ("MCCM", 2, MCCM, &[(14, "0")], "13/14"),
        ("MCCM", 2, MCCM, &[(15, "101")], "13/15"),
        ("MCCM", 2, MCCM, &[(16, "3")], "13/16"),
        ("MCCM", 2, MCCM, &[(17, "7")], "13/17"),
        ("MCCM", 2, MCCM, &[(18, "3")], "13/18"),
        ("MCCM", 2, MCCM, &[(19, "2")], "13/19"),
        ("MCCM", 2, MCCM, &[(20, "-1"), (17, "6")], "13/20"),
        ("MCCM", 2, MCCM, &[(22, "5")], "13/22"),
        ("MCCD", 3, MCCD, &[], "ok"),
        ("MCCD", 3, MCCD, &[(2, "0")], "13/2"),
        ("MCCD", 3, MCCD, &[(2, "CoordinatedMove"), (17, "ActiveMotion"), (16, "%ofTime")], "ok"),
        ("MCCD", 3, MCCD, &[(3, "2")], "13/3"),
        ("MCCD", 3, MCCD, &[(4, "-1")], "13/4"),
        ("MCCD", 3, MCCD, &[(4, "-1"), (3, "No")], "ok"),
        ("MCCD", 3, MCCD, &[(4, "nan"), (3, "No")], "ok"),
        ("MCCD", 3, MCCD, &[(5, "3")], "13/5"),
        ("MCCD", 3, MCCD, &[(6, "2")], "13/6"),
        ("MCCD", 3, MCCD, &[(7, "0")], "13/7"),
        ("MCCD", 3, MCCD, &[(7, "0"), (6, "0")], "ok"),
        ("MCCD", 3, MCCD, &[(8, "2")], "13/8"),
        ("MCCD", 3, MCCD, &[(9, "-1")], "13/9"),
        ("MCCD", 3, MCCD, &[(10, "0")], "13/10"),
        ("MCCD", 3, MCCD, &[(11, "7")], "13/11"),
        ("MCCD", 3, MCCD, &[(12, "2")], "13/12"),
        ("MCCD", 3, MCCD, &[(13, "101")], "13/13"),
        ("MCCD", 3, MCCD, &[(14, "2")], "13/14"),
        ("MCCD", 3, MCCD, &[(15, "0")], "13/15"),
        ("MCCD", 3, MCCD, &[(15, "0"), (14, "0")], "ok"),
        ("MCCD", 3, MCCD, &[(16, "5")], "13/16"),
        ("MCCD", 3, MCCD, &[(17, "2")], "13/17"),
        ("MCS", 3, MCS, &[], "ok"),
        ("MCS", 3, MCS, &[(2, "1")], "13/2"),
        ("MCS", 3, MCS, &[(2, "CoordinatedTransform"), (8, "% of Time")], "ok"),
        ("MCS", 3, MCS, &[(3, "2")], "13/3"),
        ("MCS", 3, MCS, &[(4, "0")], "13/4"),
        ("MCS", 3, MCS, &[(4, "0"), (3, "0")], "ok"),
        ("MCS", 3, MCS, &[(5, "4")], "13/5"),
        ("MCS", 3, MCS, &[(6, "2")], "13/6"),
        ("MCS", 3, MCS, &[(7, "0")], "13/7"),
        ("MCS", 3, MCS, &[(8, "6")], "13/8"),
        ("MAS", 1, MAS, &[(2, "11")], "13/2"),
        ("MAS", 1, MAS, &[(2, "DirectControl")], "ok"),
        ("MAS", 1, MAS, &[(4, "0")], "13/4"),
        ("MAS", 1, MAS, &[(8, "4")], "13/8"),
        ("MAM", 1, MAM, &[(2, "7")], "13/2"),
        ("MAM", 1, MAM, &[(3, "nan")], "13/3"),
        ("MAM", 1, MAM, &[(4, "-1")], "13/4"),
        ("MAM", 1, MAM, &[(5, "Seconds"), (13, "Seconds")], "ok"),
        ("MAM", 1, MAM, &[(6, "0")], "13/6"),
        ("MAM", 1, MAM, &[(8, "0")], "13/8"),
        ("MAM", 1, MAM, &[(13, "5")], "13/13"),
        ("MAM", 1, MAM, &[(17, "5")], "13/17"),
        ("MAJ", 1, MAJ, &[(2, "2")], "13/2"),
        ("MAJ", 1, MAJ, &[(3, "-1")], "13/3"),
        ("MAJ", 1, MAJ, &[(4, "3")], "13/4"),
        ("MAJ", 1, MAJ, &[(5, "0")], "13/5"),
        ("MAJ", 1, MAJ, &[(10, "101")], "13/10"),
        ("MAJ", 1, MAJ, &[(13, "2")], "13/13"),
        ("MAJ", 1, MAJ, &[(16, "5")], "13/16"),
        ("MCD", 1, MCD, &[(4, "-1")], "13/4"),
        ("MCD", 1, MCD, &[(6, "0")], "13/6"),
        ("MCD", 1, MCD, &[(12, "0")], "13/12"),
        ("MCD", 1, MCD, &[(12, "0"), (11, "no")], "ok"),
        ("MCD", 1, MCD, &[(13, "3")], "13/13"),
        ("MAG", 1, MAG, &[], "ok"),
        ("MAG", 1, MAG, &[(3, "4")], "13/3"),
        ("MAG", 1, MAG, &[(4, "10")], "13/4"),
        ("MAG", 1, MAG, &[(4, "10"), (8, "1")], "ok"),
        ("MAG", 1, MAG, &[(5, "0"), (8, "fraction_slave_master_counts")], "13/5"),
        ("MAG", 1, MAG, &[(10, "0")], "13/10"),
        ("MAG", 1, MAG, &[(10, "0"), (9, "disabled")], "ok"),
        ("MGS", 0, "3", &[], "13/2"),
        ("MRP", 1, "0, 2, 5", &[], "13/3"),
        ("MDAC", 1, "Master, 5, 0", &[], "13/3"),
        ("MDCC", 3, "Master, 2, 0", &[], "13/3"),
        ("MDCC", 3, "Master, 0, -1", &[], "13/4"),
        ("MCT", 3, "CS2, [0,0], [0,0,0]", &[], "13/3"),
        ("MCTP", 3, "CS2, [0,0,0], [0,0,0], 6, [0,0,0], Results", &[], "13/5"),
    ];
    for (name, axes, base, changes, expected) in cases {
        let operands = if changes.is_empty() {
            (*base).to_owned()
        } else {
            with(name, base, changes)
        };
        assert_eq!(
            outcome(name, *axes, &operands),
            *expected,
            "{name}({operands}) with {axes} axes"
        );
    }
}

#[test]
fn trailing_operands_can_be_left_out() {
    #[rustfmt::skip]
    let cases = [
        ("MCLM", 3, "0, [9,0,0], 50, 0, 500, 0, 500", "ok"),
        ("MCLM", 3, "0, [9,0,0], 50, _, 500, _, 500", "ok"),
        ("MCLM", 3, "", "13/3"),
        ("MCLM", 3, "0, [9,0,0], 50", "13/6"),
        ("MCLM", 3, "0, [9,0,0], 50, 0, 500, 0, 500, 0, S-curve", "13/11"),
        ("MCS", 3, "", "ok"),
        ("MCCD", 3, "", "13/2"),
        ("MSO", 1, "", "ok"),
        ("MAG", 1, "", "MAG: operand 1 (Master Axis) is missing"),
        ("MAPC", 1, "Master", "MAPC: operand 4 (Cam Profile) is missing"),
    ];
    for (name, axes, operands, expected) in cases {
        assert_eq!(outcome(name, axes, operands), expected, "{name}({operands})");
    }
}

#[test]
fn operands_that_cannot_be_bound_are_reported() {
    #[rustfmt::skip]
    let cases = [
        ("MCLM", "0, Everywhere", "MCLM: operand 3 (Position) is \"Everywhere\", expected an array of numbers"),
        ("MCLM", "0, [9,0], fast", "MCLM: operand 4 (Speed) is \"fast\", expected a number"),
        ("MCLM", "0, [9,0], [1,2]", "MCLM: operand 4 (Speed) is an array of 2, expected a number"),
        ("MCLM", "Sideways", "MCLM: operand 2 (Move Type) is \"Sideways\", expected one of Absolute (0), Incremental (1)"),
        ("MSO", "1", "MSO: 1 operands behind target and motion control, expected at most 0"),
        ("MAG", "Nobody", "MAG: operand 1 (Master Axis) is \"Nobody\", there is no such axis"),
        ("MAG", "1", "MAG: operand 1 (Master Axis) is 1, expected the name of a motion object"),
        ("MCTP", "CS2, [0], [0], 0, [0], Nowhere",
            "MCTP: operand 7 (Transform Position) is \"Nowhere\", there is no such REAL array tag"),
        ("MCTP", "CS2, [0], [0], 0, [0], 5",
            "MCTP: operand 7 (Transform Position) is 5, expected the name of a REAL array tag, or 0"),
        ("MCPM", "P1", "MCPM: operand 2 (Path) is \"P1\", there is no such tag of type PATH_DATA"),
    ];
    for (name, operands, expected) in cases {
        assert_eq!(outcome(name, 3, operands), expected, "{name}({operands})");
    }
    let events = unbound(&with("MCLM", MCLM, &[(20, "[1,2,3,4,5,6,7,8,9,10]")]));
    let error = bind(Mnemonic::Mclm, Some(0), ControlSlot(0), &events, &Machine).expect_err("too long");
    assert_eq!(error.operand(), Some(OperandIndex(20)));
}

#[test]
fn the_call_of_the_seed_binds() {
    let operands = "0, [10,0], 2, 5, 0, 10, Unitspersec, 5, Unitspersec2, 5, Unitspersec2, Trapezoidal, 100.0, \
                    100.0, %ofTime, 0, CoordinatedMotion, Programmed, 0, 0, None, 0, 0";
    let call = bind(Mnemonic::Mccm, Some(4), ControlSlot(9), &unbound(operands), &Machine).expect("binds");
    assert_eq!((call.target, call.control), (Some(4), ControlSlot(9)));
    assert_eq!((call.number(7), call.word(16), call.word(18)), (10.0, 2, 1));
    assert_eq!((call.array(3), call.array(5)), (&[10.0, 0.0][..], &[5.0][..]));
    assert_eq!((call.argument(23), call.argument(24)), (Argument::None, Argument::None));
    assert_eq!(call.instruction().verify(&call, 2), Ok(()));
}

#[test]
fn names_become_objects_and_tags() {
    let call = bind(
        Mnemonic::Mdcc,
        Some(0),
        ControlSlot(0),
        &unbound("MASTER, 1, 50"),
        &Machine,
    )
    .expect("binds");
    assert_eq!((call.object(1), call.word(3), call.number(4)), (Some(3), 1, 50.0));
    let operands = unbound(&with("MCLM", MCLM, &[(20, "[5,1]"), (21, "Results")]));
    let call = bind(Mnemonic::Mclm, Some(0), ControlSlot(0), &operands, &Machine).expect("binds");
    assert_eq!(
        (call.written(21), call.array(20)),
        (
            Some(WrittenArray {
                tag: address(17),
                elements: 4
            }),
            &[5.0, 1.0][..]
        )
    );
}

#[test]
fn an_event_distance_of_one_number_is_an_array_where_its_answer_has_a_place() {
    let (zero, one) = (UnboundOperand::Number(0.0), UnboundOperand::Array(vec![0.0]));
    let name = |text: &str| UnboundOperand::Name(text.to_owned());
    #[rustfmt::skip]
    let cases: &[(&str, UnboundOperand, UnboundOperand, &[f64])] = &[
        ("an array",               one,                name("Results"),  &[0.0]),
        ("as it arrives",          zero.clone(),       name("Results"),  &[0.0]),
        ("nothing to calculate",   zero.clone(),       name("None"),     &[]),
        ("no place",               zero,               UnboundOperand::Integer(0), &[]),
        ("the literal 0",          UnboundOperand::Integer(0),  name("Results"),  &[]),
        ("left out",               UnboundOperand::Missing,     name("Results"),  &[]),
        ("another number",         UnboundOperand::Number(5.0), name("Results"),  &[5.0]),
    ];
    for (why, distance, answer, expected) in cases {
        let mut operands = unbound(&with("MCLM", MCLM, &[(20, "_"), (21, "_")]));
        let places = operands.len();
        operands[places - 2] = distance.clone();
        operands[places - 1] = answer.clone();
        let call = bind(Mnemonic::Mclm, Some(0), ControlSlot(0), &operands, &Machine).expect("binds");
        assert_eq!(call.array(20), *expected, "{why}");
    }
}

fn any_operand() -> impl Strategy<Value = UnboundOperand> {
    prop_oneof![
        Just(UnboundOperand::Missing),
        any::<f64>().prop_map(UnboundOperand::Number),
        (-2i64..8).prop_map(UnboundOperand::Integer),
        any::<i64>().prop_map(UnboundOperand::Integer),
        prop::sample::select(vec!["Master", "CS2", "None", "Yes", "S-curve", "%ofTime", "Results"])
            .prop_map(|word| UnboundOperand::Word(word.to_owned())),
        ".{0,80}".prop_map(UnboundOperand::Name),
        proptest::collection::vec(any::<f64>(), 0..20).prop_map(UnboundOperand::Array),
    ]
}

proptest! {
    #[test]
    fn anything_binds_or_is_refused(
        index in 0usize..31,
        axes in 0usize..10,
        operands in proptest::collection::vec(any_operand(), 0..26),
    ) {
        let mnemonic = Mnemonic::ALL[index];
        match bind(mnemonic, None, ControlSlot(0), &operands, &Machine) {
            Err(error) => prop_assert!(error.to_string().len() < 2000),
            Ok(call) => {
                let instruction = mnemonic.instruction();
                if let Err(OperandIndex(operand)) = instruction.verify(&call, axes) {
                    prop_assert!(usize::from(operand) < instruction.operands.len());
                } else {
                    for (place, operand) in instruction.operands.iter().enumerate() {
                        if let Kind::Word(words) = operand.kind {
                            prop_assert!(words.contains(call.word(place)), "{} {}", mnemonic, operand.name);
                        }
                    }
                }
            }
        }
    }
}

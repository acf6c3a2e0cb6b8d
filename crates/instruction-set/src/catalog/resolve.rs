//! From the names of operands to their indices, while the compiler evaluates the tables: a name or a value that does not exist
//! is an error of the compiler.

use super::row::Draft;
use crate::enumerations::{JerkUnits, NoYes};
use crate::instruction::{ArrayRule, Condition, Kind, Operand, Range};

/// Operands of all rows, in which every name has become an index.
pub(super) const fn resolved<const N: usize>(parts: &[&[Draft]]) -> [Operand; N] {
    let mut operands = [parts[0][0].operand; N];
    let (mut part, mut row, mut index) = (0, 0, 0);
    while index < N {
        if row == parts[part].len() {
            part += 1;
            row = 0;
            continue;
        }
        operands[index] = resolve(&parts[part][row], parts);
        row += 1;
        index += 1;
    }
    operands
}

const fn resolve(draft: &Draft, parts: &[&[Draft]]) -> Operand {
    let mut operand = draft.operand;
    match &mut operand.condition {
        Condition::Always => {}
        Condition::Changed(flag) => *flag = index_of(draft.condition_on, NoYes::Yes as i32, parts),
        Condition::When { operand, value } => *operand = index_of(draft.condition_on, *value, parts),
    }
    match &mut operand.kind {
        Kind::Number(Range::Jerk { units }) => {
            *units = index_of(draft.range_on, JerkUnits::PercentOfTime as i32, parts);
        }
        Kind::Array(ArrayRule::PerAxisUnless { operand, value }) => {
            *operand = index_of(draft.range_on, *value, parts);
        }
        _ => {}
    }
    operand
}

/// The index of the operand of a name, which has a value.
const fn index_of(name: &str, value: i32, parts: &[&[Draft]]) -> u8 {
    let (mut part, mut row, mut index) = (0, 0, 0);
    while part < parts.len() {
        if row == parts[part].len() {
            part += 1;
            row = 0;
            continue;
        }
        let operand = &parts[part][row].operand;
        if equal(operand.name, name) {
            assert!(
                has_word(operand, value),
                "the operand that a row depends on has no such value"
            );
            return index;
        }
        row += 1;
        index += 1;
    }
    panic!("a row depends on an operand that the instruction does not have");
}

const fn has_word(operand: &Operand, value: i32) -> bool {
    let Kind::Word(words) = &operand.kind else {
        return false;
    };
    let mut word = 0;
    while word < words.words.len() {
        if words.words[word].value == value {
            return true;
        }
        word += 1;
    }
    false
}

const fn equal(one: &str, other: &str) -> bool {
    let (one, other) = (one.as_bytes(), other.as_bytes());
    let mut place = 0;
    while place < one.len() && place < other.len() && one[place] == other[place] {
        place += 1;
    }
    place == one.len() && place == other.len()
}

/// The number of operands in the rows.
pub(super) const fn total(parts: &[&[Draft]]) -> usize {
    let (mut part, mut total) = (0, 0);
    while part < parts.len() {
        total += parts[part].len();
        part += 1;
    }
    total
}

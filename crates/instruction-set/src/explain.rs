//! The explanation of an error: cause, remedy, and the operand, axis or detail that EXERR points at, from the table of errors and the
//! faceplates. Not here: a fault of an axis, which is not the error of an instruction ([`crate::FAULTS`]).

use crate::docs::{operand_type, operand_values};
use crate::error::text;
use crate::{Extended, Kind, Mnemonic, Object, describe};

/// An error in words.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Explanation {
    /// The error as all interfaces show it: `ERR 13 Parameter Out Of Range, operand 4 (Speed)`.
    pub headline: String,
    /// The usual cause, a sentence.
    pub cause: &'static str,
    /// The operand, axis or detail that EXERR points at, if it does: `Operand 4 of MCLM is Speed: number, 0 or more (in Speed Units).`
    pub concerns: Option<String>,
    /// The remedy, a sentence.
    pub remedy: &'static str,
}

/// Explains a pair of codes; `None` for an ERR that does not exist. With the instruction it also describes the operand
/// and its legal values.
///
/// ```
/// use arcline_instruction_set::{Mnemonic, explain};
///
/// let told = explain(13, 4, Some(Mnemonic::Mclm)).expect("13 exists");
/// assert_eq!(told.headline, "ERR 13 Parameter Out Of Range, operand 4 (Speed)");
/// assert!(told.concerns.is_some_and(|text| text.contains("0 or more")));
/// ```
pub fn explain(err: i16, exerr: i8, mnemonic: Option<Mnemonic>) -> Option<Explanation> {
    let row = text(err)?;
    let concerns = match row.extended {
        Extended::Unused => None,
        Extended::Operand => Some(operand(exerr, mnemonic)),
        Extended::Culprit if exerr == -1 => Some("It is about the coordinate system itself.".to_owned()),
        Extended::Axis | Extended::Culprit => Some(axis(exerr, mnemonic)),
        Extended::Detail => {
            let detail = row.details.iter().find(|(code, _)| *code == exerr);
            detail.map(|(_, meaning)| format!("EXERR {exerr}: {meaning}."))
        }
    };
    Some(Explanation {
        headline: describe(err, exerr, mnemonic),
        cause: row.cause,
        concerns,
        remedy: row.remedy,
    })
}

/// The operand at an index, and its legal values.
fn operand(place: i8, mnemonic: Option<Mnemonic>) -> String {
    let Some(mnemonic) = mnemonic else {
        return format!("Operand {place} is counted on the faceplate, the target of the instruction being 0.");
    };
    let instruction = mnemonic.instruction();
    let found = usize::try_from(place).ok();
    let Some(operand) = found.and_then(|place| instruction.operands.get(place)) else {
        let last = instruction.operands.len().saturating_sub(1);
        return format!("{mnemonic} has no operand {place}: they are 0 to {last}.");
    };
    let mut parts = vec![operand_type(&operand.kind)];
    parts.extend(Some(operand_values(instruction, operand)).filter(|values| !values.is_empty()));
    let note = match operand.note {
        "" => String::new(),
        note => format!(" ({note})"),
    };
    format!(
        "Operand {place} of {mnemonic} is {}: {}{note}.",
        operand.name,
        parts.join(", ")
    )
}

/// The axis of an index.
fn axis(index: i8, mnemonic: Option<Mnemonic>) -> String {
    let instruction = mnemonic.map(Mnemonic::instruction);
    match instruction {
        Some(instruction) if instruction.object == Object::Axis => {
            let references = |kind: &Kind| matches!(kind, Kind::Object(Object::Axis));
            if instruction.operands.iter().any(|operand| references(&operand.kind)) {
                let which = if index == 0 { "slave" } else { "master" };
                format!("It is about the {which} axis.")
            } else {
                "It is about the axis of the instruction.".to_owned()
            }
        }
        Some(instruction) if instruction.object == Object::MotionGroup => {
            format!("It is about axis {index} of the motion group, counted from 0.")
        }
        _ => format!("It is about axis {index} of the coordinate system, counted from 0."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ERRORS;

    #[test]
    fn exerr_is_explained() {
        #[rustfmt::skip]
        let cases = [
            // why,                    err, exerr, instruction,          explanation
            ("an operand",             13,  4, Some(Mnemonic::Mclm), Some("Operand 4 of MCLM is Speed: number, 0 or more (in Speed Units; 0: the move waits until MCCD or MCD gives it a speed).")),
            ("a word",                 13,  2, Some(Mnemonic::Mclm), Some("Operand 2 of MCLM is Move Type: word or number, 0 Absolute, 1 Incremental.")),
            ("no such operand",        13, 99, Some(Mnemonic::Mso),  Some("MSO has no operand 99: they are 0 to 1.")),
            ("no instruction",         13,  4, None,                 Some("Operand 4 is counted on the faceplate, the target of the instruction being 0.")),
            ("an axis of a system",     5,  1, Some(Mnemonic::Mclm), Some("It is about axis 1 of the coordinate system, counted from 0.")),
            ("the axis itself",         5,  0, Some(Mnemonic::Mam),  Some("It is about the axis of the instruction.")),
            ("the slave",               5,  0, Some(Mnemonic::Mag),  Some("It is about the slave axis.")),
            ("the master",              5,  1, Some(Mnemonic::Mag),  Some("It is about the master axis.")),
            ("the system",             54, -1, Some(Mnemonic::Mclm), Some("It is about the coordinate system itself.")),
            ("a list of its own",      61, 17, Some(Mnemonic::Mct),  Some("EXERR 17: the transform dimensions differ.")),
            ("not on the list",        61, 99, Some(Mnemonic::Mct),  None),
            ("nothing",                43,  0, Some(Mnemonic::Mclm), None),
        ];
        for (why, err, exerr, mnemonic, told) in cases {
            let explanation = explain(err, exerr, mnemonic).unwrap_or_else(|| panic!("{why}: {err} exists"));
            let concerns = explanation.concerns.unwrap_or_default();
            assert!(
                concerns.starts_with(told.unwrap_or_default()) && concerns.is_empty() == told.is_none(),
                "{why}: {concerns:?}, expected {told:?}"
            );
        }
        assert_eq!(explain(120, 0, None), None, "no such error");
    }

    #[test]
    fn every_error_of_every_instruction_is_told_in_sentences() {
        for row in ERRORS {
            for mnemonic in Mnemonic::ALL {
                for exerr in [-1, 0, 3, i8::MAX] {
                    let told = explain(row.err, exerr, Some(*mnemonic)).expect("every row can be explained");
                    let concerns = told.concerns.unwrap_or_else(|| "None.".to_owned());
                    assert!(
                        concerns.ends_with('.') && !concerns.contains(".."),
                        "{mnemonic} {concerns}"
                    );
                    assert!(
                        told.headline.starts_with(&format!("ERR {} ", row.err)),
                        "{}",
                        told.headline
                    );
                }
            }
        }
    }
}

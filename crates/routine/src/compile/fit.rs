//! Operands that do not go together: what the scan would have to pass over in silence is refused when the project is loaded.

use arcline_tag::{DataType, Elementary};

use super::Wrong;
use crate::code::{Area, Argument, Status, TextPart};
use crate::table::Op;
use crate::types::text_layout;

/// Whether the scan has an effect for these operands of an instruction.
pub(crate) fn check(op: Op, arguments: &[Argument]) -> Result<(), Wrong> {
    match (op, arguments) {
        (Op::Ote | Op::Otl | Op::Otu, [Argument::Status(Status::FirstScan)]) => Err("S:FS is not written".into()),
        (Op::Ote | Op::Otl | Op::Otu, _) => Ok(()),
        (_, all) if all.iter().any(|one| matches!(one, Argument::Status(_))) => {
            Err("a status bit is no storage".into())
        }
        (Op::Cop, [from, to, _]) => {
            area("Dest", to)?;
            match from {
                Argument::Bit(_) => Err(format!("Source is {}", described(from)).into()),
                _ => Ok(()),
            }
        }
        (Op::Fll, [from, to, _]) => fill(from, area("Dest", to)?),
        (Op::Size, [of, ..]) => area("Source", of).map(|_| ()),
        (Op::Mov, [from, to]) => match (from, to) {
            (Argument::Text(_), Argument::Text(TextPart::Tag { .. })) => Ok(()),
            (Argument::Text(_), _) | (_, Argument::Text(_)) => {
                Err(format!("Source is {}, Dest is {}", described(from), described(to)).into())
            }
            _ => Ok(()),
        },
        (Op::Swpb, [.., to]) => match to {
            Argument::Target(_) => Ok(()),
            _ => Err(format!("Dest is {}, expected a whole number", described(to)).into()),
        },
        (Op::Bsl | Op::Bsr | Op::Ave | Op::Std | Op::Srt | Op::Sqi | Op::Sqo | Op::Sql, [of, ..]) => {
            numbers(area("Array", of)?).map(|_| ())
        }
        (Op::Ffl | Op::Lfl, [value, of, ..]) => queue(area("Array", of)?, "Source", value, true),
        (Op::Ffu | Op::Lfu, [of, value, ..]) => queue(area("Array", of)?, "Dest", value, false),
        _ => Ok(()),
    }
}

/// Whether a value that a call gives has a place in a tag that takes it.
pub(crate) fn transfers(from: &Argument, to: &Argument) -> Result<(), Wrong> {
    let fits = match (from, to) {
        (Argument::Area(from), Argument::Area(to)) => are_alike(from, to) || is_shorter_text(from, to),
        (Argument::Area(_) | Argument::Text(_), _) | (_, Argument::Area(_) | Argument::Text(_)) => false,
        _ => true,
    };
    if fits {
        Ok(())
    } else {
        Err(format!("{} does not fit into {}", described(from), described(to)).into())
    }
}

fn fill(from: &Argument, to: &Area) -> Result<(), Wrong> {
    let fits = match from {
        Argument::Bit(_) | Argument::Text(_) => false,
        Argument::Area(from) => are_alike(from, to),
        _ => true,
    };
    if fits {
        Ok(())
    } else {
        Err(format!("Source is {}, Dest is {}", described(from), to.data_type.name()).into())
    }
}

/// An element of a queue is a number, or a structure of the type of its array.
fn queue(array: &Area, name: &str, value: &Argument, loads: bool) -> Result<(), Wrong> {
    let fits = match (value, &array.data_type) {
        (Argument::Area(one), _) if is_word_of_bits(one) => false,
        (Argument::Area(one), _) => are_alike(one, array),
        (Argument::Integer(_) | Argument::Real(_), DataType::Elementary(_)) => loads,
        _ => false,
    };
    if fits {
        Ok(())
    } else {
        Err(format!("{name} is {}, expected {}", described(value), array.data_type.name()).into())
    }
}

/// Both are numbers, or structures of one type.
fn are_alike(one: &Area, other: &Area) -> bool {
    match (&one.data_type, &other.data_type) {
        (DataType::Elementary(_), DataType::Elementary(_)) => true,
        (one, other) => one.name().eq_ignore_ascii_case(other.name()),
    }
}

/// Both are texts, and the one has room in the other.
fn is_shorter_text(one: &Area, other: &Area) -> bool {
    let capacity = |area: &Area| text_layout(&area.data_type).filter(|_| !area.is_whole);
    let layouts = capacity(one).zip(capacity(other));
    layouts.is_some_and(|((_, one), (_, other))| one <= other)
}

fn is_word_of_bits(area: &Area) -> bool {
    area.data_type == DataType::Elementary(Elementary::Dword) && !area.is_whole
}

fn area<'a>(name: &str, argument: &'a Argument) -> Result<&'a Area, Wrong> {
    match argument {
        Argument::Area(area) => Ok(area),
        other => Err(format!("{name} is {}, expected data", described(other)).into()),
    }
}

fn numbers(area: &Area) -> Result<&Area, Wrong> {
    match &area.data_type {
        DataType::Elementary(_) => Ok(area),
        DataType::Structure(template) => Err(format!("Array is {}, expected numbers", template.name).into()),
    }
}

fn described(argument: &Argument) -> String {
    match argument {
        Argument::Bit(_) => "a BOOL".to_owned(),
        Argument::Area(area) if is_word_of_bits(area) => "a BOOL".to_owned(),
        Argument::Area(area) if area.is_whole => format!("an array of {}", area.data_type.name()),
        Argument::Area(area) => area.data_type.name().to_owned(),
        Argument::Text(_) => "a text".to_owned(),
        _ => "a number".to_owned(),
    }
}

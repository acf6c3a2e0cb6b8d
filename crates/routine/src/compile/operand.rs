//! Operands by the kinds of the table.

use arcline_tag::{DataType, Elementary};

use super::call::unsigned;
use super::expression::{Sort, status_of};
use super::{Compiler, Wrong};
use crate::code::{Argument, Cellular, Ex, TextPart};
use crate::expression::{Expression, TagReference};
use crate::table::Kind;

impl Compiler<'_> {
    /// An operand of that kind.
    pub(crate) fn operand(&mut self, kind: Kind, text: &str) -> Result<Argument, Wrong> {
        match kind {
            Kind::Shown | Kind::Name => return Ok(Argument::Shown),
            Kind::Word(words) => return word(words, text),
            Kind::Mode => return self.mode(text),
            Kind::Routine => {
                let routine = self
                    .routine_id(text)
                    .ok_or_else(|| Wrong::absent("there is no such routine".to_owned()))?;
                return Ok(Argument::Routine(routine));
            }
            Kind::Label => {
                let label = self.label(text).ok_or("the routine has no such label (4/42)")?;
                return Ok(Argument::Label(label));
            }
            Kind::Task => {
                let place = self
                    .project
                    .tasks
                    .iter()
                    .position(|task| task.name.eq_ignore_ascii_case(text));
                let place = place
                    .and_then(|place| u32::try_from(place).ok())
                    .ok_or_else(|| Wrong::absent("there is no such task".to_owned()))?;
                return Ok(Argument::Task(place));
            }
            _ => {}
        }
        let expression = parse(text)?;
        match kind {
            Kind::Bit => match &expression {
                Expression::Reference(reference) => match status_of(reference) {
                    Some(status) => Ok(Argument::Integer(Ex::Status(status))),
                    None => self.bit(reference),
                },
                _ => Ok(Argument::Integer(self.whole(&expression)?)),
            },
            Kind::OutBit => match &expression {
                Expression::Reference(reference) => match status_of(reference) {
                    Some(status) => Ok(Argument::Status(status)),
                    None => self.bit(reference),
                },
                _ => Err("expected a BOOL".into()),
            },
            Kind::Number | Kind::Expression => self.value(&expression),
            Kind::Unsigned => Ok(Argument::Integer(unsigned(self.whole(&expression)?))),
            Kind::Compared => match self.text_part(&expression) {
                Some(part) => Ok(Argument::Text(part)),
                None => self.value(&expression),
            },
            Kind::Filling => self.filling(&expression),
            Kind::Target => self.target(&expression),
            Kind::MoveTarget => match self.text_part(&expression) {
                Some(part @ TextPart::Tag { .. }) => Ok(Argument::Text(part)),
                _ => self.target(&expression),
            },
            Kind::Data => self.data(&expression),
            Kind::Structure(names) => {
                let Argument::Area(area) = self.data(&expression)? else {
                    return Err("expected a tag".into());
                };
                let name = area.data_type.name();
                if names.iter().any(|known| known.eq_ignore_ascii_case(name)) && !area.is_whole {
                    Ok(Argument::Area(area))
                } else {
                    Err(format!("is {name}, expected {}", names.join(" or ")).into())
                }
            }
            Kind::Text => self
                .text_part(&expression)
                .map(Argument::Text)
                .ok_or("expected a text".into()),
            Kind::TextTarget => match self.text_part(&expression) {
                Some(part @ TextPart::Tag { .. }) => Ok(Argument::Text(part)),
                _ => Err("expected a tag of a type of texts".into()),
            },
            _ => Err("unexpected".into()),
        }
    }

    fn bit(&mut self, reference: &TagReference) -> Result<Argument, Wrong> {
        let found = self.resolve(reference)?;
        found
            .as_bit()
            .map(Argument::Bit)
            .ok_or_else(|| format!("{reference} is no BOOL and no bit").into())
    }

    /// A number, in the type it has.
    pub(crate) fn value(&mut self, expression: &Expression) -> Result<Argument, Wrong> {
        let (value, sort) = self.number(expression, Sort::Whole)?;
        Ok(if sort.is_real() {
            Argument::Real(value)
        } else {
            Argument::Integer(value)
        })
    }

    /// A number that is written.
    pub(crate) fn target(&mut self, expression: &Expression) -> Result<Argument, Wrong> {
        let Expression::Reference(reference) = expression else {
            return Err("expected a tag that can be written".into());
        };
        let found = self.resolve(reference)?;
        if let Some(bit) = found.as_bit() {
            return Ok(Argument::Bit(bit));
        }
        match found.data_type {
            DataType::Elementary(kind) if !found.is_array() => Ok(Argument::Target(Cellular {
                place: found.place(),
                kind,
            })),
            // The first element, as newer controllers do it.
            DataType::Elementary(kind) => Ok(Argument::Target(Cellular {
                place: found.place(),
                kind,
            })),
            DataType::Structure(ref template) => Err(format!("is {}, expected a number", template.name).into()),
        }
    }

    /// Data of any type.
    pub(crate) fn data(&mut self, expression: &Expression) -> Result<Argument, Wrong> {
        match expression {
            Expression::Reference(reference) => {
                let found = self.resolve(reference)?;
                match (found.as_bit(), found.bits) {
                    // An element of an array of BOOLs begins a word.
                    (Some(_), Some(_)) => Ok(Argument::Area(found.words()?)),
                    (Some(bit), None) => Ok(Argument::Bit(bit)),
                    (None, _) => Ok(Argument::Area(found.area())),
                }
            }
            Expression::Text(bytes) => Ok(Argument::Text(TextPart::Literal(bytes.clone().into()))),
            _ => self.value(expression),
        }
    }

    /// The source of FLL: a number, or data that fills element by element.
    fn filling(&mut self, expression: &Expression) -> Result<Argument, Wrong> {
        let data = self.data(expression)?;
        match &data {
            Argument::Area(area) if matches!(area.data_type, DataType::Elementary(_)) && !area.is_whole => Ok(self
                .value(expression)
                .ok()
                .filter(|_| area.data_type != Elementary::Dword.into())
                .unwrap_or(data)),
            _ => Ok(data),
        }
    }

    /// A value that a call gives: a number, a bit, or data of any type by its bytes.
    pub(crate) fn data_or_number(&mut self, text: &str) -> Result<Argument, Wrong> {
        let expression = parse(text)?;
        if let Expression::Reference(reference) = &expression
            && status_of(reference).is_none()
        {
            let found = self.resolve(reference)?;
            if matches!(found.data_type, DataType::Structure(_)) || found.is_array() {
                return Ok(Argument::Area(found.area()));
            }
        }
        self.value(&expression)
    }

    /// A tag that a call gives a value to.
    pub(crate) fn written(&mut self, text: &str) -> Result<Argument, Wrong> {
        let expression = parse(text)?;
        let Expression::Reference(reference) = &expression else {
            return Err(format!("{text}: expected a tag").into());
        };
        let found = self.resolve(reference).map_err(|reason| reason.of(text))?;
        if matches!(found.data_type, DataType::Structure(_)) || found.is_array() {
            return Ok(Argument::Area(found.area()));
        }
        self.target(&expression)
    }

    fn mode(&mut self, text: &str) -> Result<Argument, Wrong> {
        match text.to_ascii_uppercase().as_str() {
            "ALL" => Ok(Argument::Word(MODE_ALL)),
            "INC" | "INCREMENTAL" => Ok(Argument::Word(MODE_INCREMENTAL)),
            _ => Ok(Argument::Integer(self.whole(&parse(text)?)?)),
        }
    }
}

/// FAL and FSC: the whole file in one scan.
pub(crate) const MODE_ALL: i32 = 0;
/// FAL and FSC: one element for each edge.
pub(crate) const MODE_INCREMENTAL: i32 = -1;

fn word(words: &[&str], text: &str) -> Result<Argument, Wrong> {
    let clean: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let place = words.iter().position(|word| word.eq_ignore_ascii_case(&clean));
    let place = place.or_else(|| clean.parse().ok().filter(|number| *number < words.len()));
    place
        .map(|place| Argument::Word(place as i32))
        .ok_or_else(|| format!("expected {}", words.join(", ")).into())
}

pub(crate) fn parse(text: &str) -> Result<Expression, Wrong> {
    // Studio 5000 writes an operand that is not given yet as a question mark.
    if text == "?" {
        return Err(Wrong::absent("the operand is not given".to_owned()));
    }
    Expression::parse(text).map_err(|error| error.to_string().into())
}

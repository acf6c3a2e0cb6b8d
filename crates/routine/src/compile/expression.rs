//! Expressions with types: whole numbers with 64 bits, REAL, LREAL (spec/programs.md §6, §7).

use arcline_tag::{DataType, Elementary};

use super::{Compiler, Wrong};
use crate::code::{Cellular, Compare, Ex, Float, Function, Status, TextPart, Whole, Width};
use crate::expression::{Binary, Expression, TagReference, Unary};
use crate::types::text_layout;

/// The type that an expression is calculated in, by rank.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Sort {
    Bool,
    Whole,
    Single,
    Double,
}

impl Sort {
    pub(crate) fn of(kind: Elementary) -> Self {
        match kind {
            Elementary::Bool => Self::Bool,
            Elementary::Real => Self::Single,
            Elementary::Lreal => Self::Double,
            _ => Self::Whole,
        }
    }

    fn width(self) -> Width {
        if self == Self::Double {
            Width::Double
        } else {
            Width::Single
        }
    }

    pub(crate) fn is_real(self) -> bool {
        self >= Self::Single
    }
}

/// Converts a value from one type to another.
pub(crate) fn cast(value: Ex, from: Sort, to: Sort) -> Ex {
    match (from.is_real(), to.is_real()) {
        (false, true) => match value {
            Ex::Integer(number) => Ex::Real(number as f64),
            value => Ex::ToReal(Box::new(value), to.width()),
        },
        (true, false) => match value {
            Ex::Real(number) => Ex::Integer(number.round_ties_even() as i64),
            value => Ex::ToInteger(Box::new(value)),
        },
        _ => value,
    }
}

impl Compiler<'_> {
    /// A number or a truth value; arithmetic is done in `least` at least.
    pub(crate) fn number(&mut self, expression: &Expression, least: Sort) -> Result<(Ex, Sort), Wrong> {
        match expression {
            Expression::Integer(value) => Ok((Ex::Integer(*value), Sort::Whole)),
            Expression::Real(value) if least == Sort::Double => Ok((Ex::Real(*value), Sort::Double)),
            Expression::Real(value) => Ok((Ex::Real(f64::from(*value as f32)), Sort::Single)),
            Expression::Text(_) => Err("a text is no number".into()),
            Expression::Reference(reference) => self.load(reference),
            Expression::Unary(Unary::Negate, operand) => {
                let (value, from) = self.number(operand, least)?;
                let sort = from.max(least).max(Sort::Whole);
                let is_real = sort.is_real();
                Ok(match cast(value, from, sort) {
                    Ex::Integer(number) => (Ex::Integer(number.wrapping_neg()), sort),
                    Ex::Real(number) => (Ex::Real(-number), sort),
                    value if is_real => (Ex::NegateReal(Box::new(value)), sort),
                    value => (Ex::Negate(Box::new(value)), sort),
                })
            }
            Expression::Unary(Unary::Not, operand) => {
                let (value, sort) = self.number(operand, Sort::Whole)?;
                if sort == Sort::Bool {
                    return Ok((Ex::IsZero(Box::new(value)), Sort::Bool));
                }
                Ok((Ex::Invert(Box::new(cast(value, sort, Sort::Whole))), Sort::Whole))
            }
            Expression::Binary(operator, operands) => self.binary(*operator, &operands.0, &operands.1, least),
            Expression::Call(name, arguments) => self.function(name, arguments, least),
        }
    }

    fn binary(
        &mut self,
        operator: Binary,
        left: &Expression,
        right: &Expression,
        least: Sort,
    ) -> Result<(Ex, Sort), Wrong> {
        if let Some(compare) = comparison(operator) {
            if let Some(compared) = self.texts(compare, left, right)? {
                return Ok((compared, Sort::Bool));
            }
            let (a, from_a) = self.number(left, Sort::Whole)?;
            let (b, from_b) = self.number(right, Sort::Whole)?;
            return Ok((compared(compare, (a, from_a), (b, from_b)), Sort::Bool));
        }
        let logical = match operator {
            Binary::And => Some(Whole::And),
            Binary::Or => Some(Whole::Or),
            Binary::Xor => Some(Whole::Xor),
            _ => None,
        };
        if let Some(operation) = logical {
            let (a, from_a) = self.number(left, Sort::Whole)?;
            let (b, from_b) = self.number(right, Sort::Whole)?;
            let sort = from_a.max(from_b).min(Sort::Whole);
            let operands = Box::new((cast(a, from_a, Sort::Whole), cast(b, from_b, Sort::Whole)));
            return Ok((Ex::Whole(operation, operands), sort));
        }
        let (a, from_a) = self.number(left, least)?;
        let (b, from_b) = self.number(right, least)?;
        let sort = from_a.max(from_b).max(least).max(Sort::Whole);
        Ok((
            arithmetic(operator, cast(a, from_a, sort), cast(b, from_b, sort), sort),
            sort,
        ))
    }

    fn function(&mut self, name: &str, arguments: &[Expression], least: Sort) -> Result<(Ex, Sort), Wrong> {
        let [argument] = arguments else {
            return Err(format!("{name} takes one number").into());
        };
        let (value, sort) = self.number(argument, least)?;
        self.apply(name, (value, sort), least)
            .ok_or_else(|| Wrong::absent(format!("there is no function {name}")))
    }

    /// A function of a number.
    pub(crate) fn apply(&mut self, name: &str, (value, sort): (Ex, Sort), least: Sort) -> Option<(Ex, Sort)> {
        let function = function_of(name)?;
        let whole = |function| {
            Some((
                Ex::Function(
                    function,
                    Width::Single,
                    Box::new(cast(value.clone(), sort, Sort::Whole)),
                ),
                Sort::Whole,
            ))
        };
        match function {
            Function::ToBcd | Function::FromBcd => return whole(function),
            Function::Absolute if !sort.max(least).is_real() => return whole(Function::AbsoluteWhole),
            _ => {}
        }
        let real = sort.max(least).max(Sort::Single);
        Some((
            Ex::Function(function, real.width(), Box::new(cast(value, sort, real))),
            real,
        ))
    }

    /// The value of a tag, or a status bit.
    fn load(&mut self, reference: &TagReference) -> Result<(Ex, Sort), Wrong> {
        if let Some(status) = status_of(reference) {
            return Ok((Ex::Status(status), Sort::Bool));
        }
        let found = self.resolve(reference)?;
        if let Some(bit) = found.as_bit() {
            return Ok((Ex::Bit(Box::new(bit)), Sort::Bool));
        }
        if found.is_array() {
            return Err(format!("{reference} is an array, expected an element").into());
        }
        match found.data_type {
            DataType::Elementary(kind) => {
                let place = found.place();
                let value = match place.fixed() {
                    Some(at) if kind == Elementary::Dint => Ex::Dint(at),
                    _ => Ex::Load(Box::new(Cellular { place, kind })),
                };
                Ok((value, Sort::of(kind)))
            }
            DataType::Structure(template) => Err(format!("{reference} is {}, expected a number", template.name).into()),
        }
    }

    /// A comparison of texts; `None`: neither side is one.
    pub(crate) fn texts(
        &mut self,
        compare: Compare,
        left: &Expression,
        right: &Expression,
    ) -> Result<Option<Ex>, Wrong> {
        let (Some(a), Some(b)) = (self.text_part(left), self.text_part(right)) else {
            return Ok(None);
        };
        Ok(Some(Ex::CompareText(compare, Box::new((a, b)))))
    }

    /// A text: a literal, or a tag of a type of texts.
    pub(crate) fn text_part(&mut self, expression: &Expression) -> Option<TextPart> {
        match expression {
            Expression::Text(bytes) => Some(TextPart::Literal(bytes.clone().into())),
            Expression::Reference(reference) => {
                let found = self.resolve(reference).ok()?;
                let (data, capacity) = text_layout(&found.data_type).filter(|_| !found.is_array())?;
                Some(TextPart::Tag {
                    place: found.place(),
                    data,
                    capacity,
                })
            }
            _ => None,
        }
    }
}

/// The status bit that a name means.
pub(crate) fn status_of(reference: &TagReference) -> Option<Status> {
    Some(match reference.name.to_ascii_uppercase().as_str() {
        "S:FS" => Status::FirstScan,
        "S:V" => Status::Overflow,
        "S:Z" => Status::Zero,
        "S:N" => Status::Negative,
        "S:C" => Status::Carry,
        "S:MINOR" => Status::Minor,
        _ => return None,
    })
}

pub(crate) fn compared(compare: Compare, (a, from_a): (Ex, Sort), (b, from_b): (Ex, Sort)) -> Ex {
    let sort = from_a.max(from_b);
    let operands = Box::new((cast(a, from_a, sort), cast(b, from_b, sort)));
    if sort.is_real() {
        Ex::CompareReal(compare, operands)
    } else {
        Ex::Compare(compare, operands)
    }
}

pub(crate) fn comparison(operator: Binary) -> Option<Compare> {
    Some(match operator {
        Binary::Less => Compare::Less,
        Binary::LessEqual => Compare::LessEqual,
        Binary::Greater => Compare::Greater,
        Binary::GreaterEqual => Compare::GreaterEqual,
        Binary::Equal => Compare::Equal,
        Binary::NotEqual => Compare::NotEqual,
        _ => return None,
    })
}

/// An operation on two values of one type.
pub(crate) fn arithmetic(operator: Binary, a: Ex, b: Ex, sort: Sort) -> Ex {
    let operands = Box::new((a, b));
    if sort.is_real() {
        let operation = match operator {
            Binary::Add => Float::Add,
            Binary::Subtract => Float::Subtract,
            Binary::Multiply => Float::Multiply,
            Binary::Divide => Float::Divide,
            Binary::Modulo => Float::Modulo,
            _ => Float::Power,
        };
        return Ex::Float(operation, sort.width(), operands);
    }
    let operation = match operator {
        Binary::Add => Whole::Add,
        Binary::Subtract => Whole::Subtract,
        Binary::Multiply => Whole::Multiply,
        Binary::Divide => Whole::Divide,
        Binary::Modulo => Whole::Modulo,
        _ => Whole::Power,
    };
    Ex::Whole(operation, operands)
}

fn function_of(name: &str) -> Option<Function> {
    Some(match name.to_ascii_uppercase().as_str() {
        "ABS" => Function::Absolute,
        "SIN" => Function::Sine,
        "COS" => Function::Cosine,
        "TAN" => Function::Tangent,
        "ASN" | "ASIN" => Function::ArcSine,
        "ACS" | "ACOS" => Function::ArcCosine,
        "ATN" | "ATAN" => Function::ArcTangent,
        "LN" => Function::Ln,
        "LOG" => Function::Log,
        "DEG" => Function::Degrees,
        "RAD" => Function::Radians,
        "SQR" | "SQRT" => Function::Root,
        "TRN" | "TRUNC" => Function::Truncate,
        "TOD" => Function::ToBcd,
        "FRD" => Function::FromBcd,
        _ => return None,
    })
}

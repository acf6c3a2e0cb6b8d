//! Operands of motion services: a list of typed numbers and names (spec/contract.md §4).
//!
//! Not here: the binding of operands to an instruction, which is the server's. Surplus bytes are errors here, unlike in
//! the tag services.

use arcline_tag::{Elementary, Value};
use bytes::{BufMut, BytesMut};

use super::{SHORT_STRING, WireType};
use crate::cip::CipStatus;
use crate::wire::{Reader, counted};

/// Operands accepted in one motion service; more are [`TypedError::TooMuch`].
pub const MAX_OPERANDS: usize = 64;

/// One operand of a motion service (spec/contract.md §4).
#[derive(Clone, PartialEq, Debug)]
pub enum Typed {
    /// One or more numbers of one type: SINT, INT, DINT, LINT, REAL or LREAL.
    Numbers(Elementary, Vec<Value>),
    /// A name; may be empty.
    ShortString(String),
}

/// Operands that are not laid out as they must be.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum TypedError {
    /// 0x13: the data ends inside an operand, or an operand has no elements.
    #[error("operand {operand} needs {needed} bytes, {present} are there")]
    TooLittle {
        /// Counts from 0, the motion control tag.
        operand: usize,
        /// Bytes of the announced value.
        needed: usize,
        /// Bytes there.
        present: usize,
    },
    /// 0x15: more operands than any instruction has.
    #[error("more than {limit} operands")]
    TooMuch {
        /// Operands accepted.
        limit: usize,
    },
    /// 0x20: neither a number nor a name.
    #[error("operand {operand} has type 0x{code:04X}, expected SINT, INT, DINT, LINT, REAL, LREAL or one SHORT_STRING")]
    WrongType {
        /// Counts from 0, the motion control tag.
        operand: usize,
        /// The type code.
        code: u16,
    },
}

impl TypedError {
    /// The general status.
    pub const fn status(self) -> CipStatus {
        match self {
            Self::TooLittle { .. } => CipStatus::NOT_ENOUGH_DATA,
            Self::TooMuch { .. } => CipStatus::TOO_MUCH_DATA,
            Self::WrongType { .. } => CipStatus::INVALID_PARAMETER,
        }
    }
}

/// Reads operands to the end of `data`: `type code u16, element count u16, elements` each. Nothing is allocated that is
/// only announced.
///
/// # Errors
/// [`TypedError`].
pub fn decode_operands(data: &[u8]) -> Result<Vec<Typed>, TypedError> {
    let mut reader = Reader::new(data);
    let mut operands = Vec::new();
    while !reader.is_empty() {
        if operands.len() == MAX_OPERANDS {
            return Err(TypedError::TooMuch { limit: MAX_OPERANDS });
        }
        let operand = decode_operand(operands.len(), &mut reader)?;
        operands.push(operand);
    }
    Ok(operands)
}

fn decode_operand(operand: usize, reader: &mut Reader<'_>) -> Result<Typed, TypedError> {
    let present = reader.remaining();
    let little = |needed| TypedError::TooLittle {
        operand,
        needed,
        present,
    };
    let code = reader.u16().ok_or_else(|| little(4))?;
    let wrong = TypedError::WrongType { operand, code };
    let elementary = match WireType::Atomic(code).elementary() {
        _ if code == SHORT_STRING => None,
        Some(number) if is_operand_type(number) => Some(number),
        _ => return Err(wrong),
    };
    let count = usize::from(reader.u16().ok_or_else(|| little(4))?);
    if count == 0 {
        return Err(little(4 + elementary.map_or(1, Elementary::size)));
    }
    if let Some(elementary) = elementary {
        let size = elementary.size();
        let bytes = reader.take(count * size).ok_or_else(|| little(4 + count * size))?;
        let values: Option<Vec<Value>> = bytes.chunks(size).map(|chunk| Value::read(elementary, chunk)).collect();
        return values.map(|values| Typed::Numbers(elementary, values)).ok_or(wrong);
    }
    if count != 1 {
        return Err(wrong);
    }
    let length = usize::from(reader.u8().ok_or_else(|| little(5))?);
    let name = reader.take(length).ok_or_else(|| little(5 + length))?;
    let name = std::str::from_utf8(name).map_err(|_| wrong)?;
    Ok(Typed::ShortString(name.to_owned()))
}

const fn is_operand_type(elementary: Elementary) -> bool {
    use Elementary::{Dint, Int, Lint, Lreal, Real, Sint};
    matches!(elementary, Sint | Int | Dint | Lint | Real | Lreal)
}

/// Appends operands, the other direction of [`decode_operands`]. A name is cut at 255 bytes, a list at 65,535 numbers;
/// a number of another type than its list's is converted.
pub fn encode_operands(operands: &[Typed], out: &mut BytesMut) {
    for operand in operands {
        match operand {
            Typed::Numbers(elementary, values) => {
                let count = u16::try_from(values.len()).unwrap_or(u16::MAX);
                out.put_u16_le(elementary.code().into());
                out.put_u16_le(count);
                for value in values.iter().take(usize::from(count)) {
                    encode_value(*elementary, *value, out);
                }
            }
            Typed::ShortString(name) => {
                out.put_u16_le(SHORT_STRING);
                out.put_u16_le(1);
                let (length, name) = counted(name.as_bytes());
                out.put_u8(length);
                out.put_slice(name);
            }
        }
    }
}

fn encode_value(elementary: Elementary, value: Value, out: &mut BytesMut) {
    let value = value.convert(elementary);
    let mut bytes = [0_u8; 8];
    let size = elementary.size().min(bytes.len());
    // Eight bytes hold every elementary value.
    let _ = value.write(&mut bytes);
    out.put_slice(bytes.get(..size).unwrap_or_default());
}

//! A type as the tag services write it in front of values (spec/ethernet-ip.md §9).
//!
//! The codes on the wire only; the layout of a structure is in the template of its handle.

use arcline_tag::Elementary;
use bytes::{BufMut, BytesMut};

use crate::wire::Reader;

/// Type code of a SHORT_STRING: `length u8, bytes`.
pub const SHORT_STRING: u16 = 0x00DA;
/// Type code in front of a structure's handle.
pub const STRUCTURE: u16 = 0x02A0;

/// A type as the tag services write it: two bytes, or four for a structure.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum WireType {
    /// The code of an atomic type, see [`Elementary::code`]; other codes are kept as they came.
    Atomic(u16),
    /// `A0 02` and the structure's handle.
    Structure(u16),
}

impl WireType {
    /// The elementary type, if it is one.
    pub fn elementary(self) -> Option<Elementary> {
        match self {
            Self::Atomic(code) => Elementary::from_code(u8::try_from(code).ok()?),
            Self::Structure(_) => None,
        }
    }

    /// Bytes on the wire.
    pub const fn size(self) -> usize {
        match self {
            Self::Atomic(_) => 2,
            Self::Structure(_) => 4,
        }
    }

    /// Reads two or four bytes.
    pub fn decode(reader: &mut Reader<'_>) -> Option<Self> {
        match reader.u16()? {
            STRUCTURE => reader.u16().map(Self::Structure),
            code => Some(Self::Atomic(code)),
        }
    }

    /// Appends two or four bytes.
    pub fn encode(self, out: &mut BytesMut) {
        match self {
            Self::Atomic(code) => out.put_u16_le(code),
            Self::Structure(handle) => {
                out.put_u16_le(STRUCTURE);
                out.put_u16_le(handle);
            }
        }
    }
}

impl From<Elementary> for WireType {
    fn from(elementary: Elementary) -> Self {
        Self::Atomic(elementary.code().into())
    }
}

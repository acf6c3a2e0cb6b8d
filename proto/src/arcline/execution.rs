//! Motion Instruction, class 0x0303: one instance for every executed instruction (spec/contract.md §4).
//!
//! Not here: the meaning of the words in an [`Ending`], which `arcline_instruction_set::Ending` defines.

use bytes::{BufMut, Bytes, BytesMut};

use super::{put_name, read_name};
use crate::wire::Reader;

/// The class code.
pub const CLASS: u16 = 0x0303;

/// Attributes of an instance. The first seven are parts of its MOTION_INSTRUCTION.
pub mod attribute {
    /// FLAGS, DWORD.
    pub const FLAGS: u16 = 1;
    /// ERR, INT.
    pub const ERR: u16 = 2;
    /// STATUS, SINT.
    pub const STATUS: u16 = 3;
    /// STATE, SINT.
    pub const STATE: u16 = 4;
    /// SEGMENT, DINT.
    pub const SEGMENT: u16 = 5;
    /// EXERR, SINT.
    pub const EXERR: u16 = 6;
    /// The MOTION_INSTRUCTION structure, 16 bytes: also the reply of Get Attributes All.
    pub const CONTROL: u16 = 7;
    /// The cause of its end, an [`Ending`](super::Ending).
    pub const ENDING: u16 = 8;
}

/// Attribute 8: why an instruction ended that has ended without PC and without an error. `code USINT, name SHORT_STRING,
/// detail SHORT_STRING, machine time LREAL, UTC ULINT`.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Ending {
    /// 0 no ending of this kind, 1 another instruction, 2 faults of an axis, 3 a stop of the whole machine, 4 the end of a jog
    /// by the server.
    pub code: u8,
    /// The motion control tag of the other instruction, or the axis; at most 255 bytes.
    pub name: String,
    /// The mnemonic of the other instruction, the faults as words with blanks between them, or the reason of the end of a jog;
    /// at most 255 bytes.
    pub detail: String,
    /// Machine time, s.
    pub time: f64,
    /// µs since 1970-01-01 UTC.
    pub utc_micros: u64,
}

impl Ending {
    /// The value of the attribute.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(3 + self.name.len() + self.detail.len() + 16);
        out.put_u8(self.code);
        put_name(&mut out, &self.name);
        put_name(&mut out, &self.detail);
        out.put_f64_le(self.time);
        out.put_u64_le(self.utc_micros);
        out.freeze()
    }

    /// Reads the value; `None` when it is cut, or a text is no UTF-8.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        let code = reader.u8()?;
        let (name, detail) = (read_name(&mut reader)?, read_name(&mut reader)?);
        Some(Self {
            code,
            name,
            detail,
            time: f64::from_le_bytes(reader.array()?),
            utc_micros: reader.u64()?,
        })
    }
}

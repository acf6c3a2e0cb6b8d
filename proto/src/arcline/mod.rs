//! Arcline's own CIP classes: class ids, attribute ids, services and layouts, in both directions.
//!
//! Not here: the effects of services, and the names of instructions and faults, which are the instruction set's. All numbers are
//! little-endian; a name is a SHORT_STRING (length USINT, bytes).

pub mod execution;
pub mod machine;
pub mod motion;
pub mod trace;

use bytes::{BufMut, BytesMut};

use crate::cip::CipStatus;
use crate::wire::{Reader, counted};

/// Writes a name; of a longer one its first 255 bytes.
fn put_name(out: &mut BytesMut, name: &str) {
    let (length, name) = counted(name.as_bytes());
    out.put_u8(length);
    out.put_slice(name);
}

/// Reads a name; `None` when it is cut or no UTF-8.
fn read_name(reader: &mut Reader<'_>) -> Option<String> {
    let length = reader.u8()?;
    let name = reader.take(length.into())?;
    Some(std::str::from_utf8(name).ok()?.to_owned())
}

/// Reads the data of a request field by field: 0x13 when it ends too early, 0x15 when bytes are left behind it.
struct RequestReader<'a>(Reader<'a>);

impl<'a> RequestReader<'a> {
    fn new(data: &'a [u8]) -> Self {
        Self(Reader::new(data))
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], CipStatus> {
        self.0.array().ok_or(CipStatus::NOT_ENOUGH_DATA)
    }

    fn u8(&mut self) -> Result<u8, CipStatus> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, CipStatus> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, CipStatus> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, CipStatus> {
        self.array().map(u64::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64, CipStatus> {
        self.array().map(f64::from_le_bytes)
    }

    /// 0x20 for bytes that are no UTF-8.
    fn name(&mut self) -> Result<String, CipStatus> {
        let length = usize::from(self.u8()?);
        let name = self.0.take(length).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let name = std::str::from_utf8(name).map_err(|_| CipStatus::INVALID_PARAMETER)?;
        Ok(name.to_owned())
    }

    fn end(self) -> Result<(), CipStatus> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(CipStatus::TOO_MUCH_DATA)
        }
    }
}

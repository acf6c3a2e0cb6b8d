//! Messages of the Connection Manager, class 6: Unconnected Send, Forward Open, Large Forward Open, Forward Close, and
//! its counters (CIP Vol. 1, 3-5; spec/ethernet-ip.md §7).
//!
//! Codecs only; [`crate::session`] holds the connections. Intervals are in microseconds.

mod counters;
mod forward_close;
mod forward_open;
mod parameters;
mod unconnected_send;

use bytes::{BufMut, Bytes, BytesMut};
use std::time::Duration;

use crate::cip::{CipStatus, Reply};
use crate::epath::{Epath, PathError};
use crate::wire::Reader;

pub use counters::{Count, Counters};
pub use forward_close::ForwardClose;
pub use forward_open::{ForwardOpen, ForwardOpenReply, OpenError, TRANSPORT_CLASS_3};
pub use parameters::{ConnectionType, NetworkParameters};
pub use unconnected_send::{UnconnectedSend, route_refusal};

/// Names a connection: chosen by its originator.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct ConnectionKey {
    /// Connection serial number.
    pub serial: u16,
    /// Originator's vendor id.
    pub vendor: u16,
    /// Originator's serial number.
    pub originator: u32,
}

impl ConnectionKey {
    fn read(reader: &mut Reader<'_>) -> Option<Self> {
        Some(Self {
            serial: reader.u16()?,
            vendor: reader.u16()?,
            originator: reader.u32()?,
        })
    }

    fn write(self, out: &mut BytesMut) {
        out.put_u16_le(self.serial);
        out.put_u16_le(self.vendor);
        out.put_u32_le(self.originator);
    }
}

/// How long a request may take on its way: 2^(tick & 15) × ticks milliseconds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TickTime {
    /// Priority and tick exponent.
    pub tick: u8,
    /// Ticks.
    pub ticks: u8,
}

impl TickTime {
    /// 5.12 s.
    pub const DEFAULT: Self = Self { tick: 0x0A, ticks: 5 };

    /// The time meant.
    pub fn duration(self) -> Duration {
        Duration::from_millis(u64::from(self.ticks) << (self.tick & 0x0F))
    }

    fn read(reader: &mut Reader<'_>) -> Option<Self> {
        Some(Self {
            tick: reader.u8()?,
            ticks: reader.u8()?,
        })
    }

    fn write(self, out: &mut BytesMut) {
        out.put_slice(&[self.tick, self.ticks]);
    }
}

/// The refusal of a Forward Open or Close: the connection's name, then the remaining path size.
pub fn refusal(service: u8, key: ConnectionKey, status: CipStatus, remaining_words: u8) -> Reply {
    let mut out = BytesMut::with_capacity(10);
    key.write(&mut out);
    out.put_slice(&[remaining_words, 0]);
    Reply::with_status(service, status, out)
}

/// `size u8, reserved u8, path`.
fn encode_reserved_path(path: &Epath, out: &mut BytesMut) -> Result<(), PathError> {
    let (words, path) = path.to_sized_bytes()?;
    out.put_slice(&[words, 0]);
    out.put_slice(&path);
    Ok(())
}

/// `size u8`, with `reserved` another byte, `path`: the other direction.
fn read_path(reader: &mut Reader<'_>, data: &Bytes, reserved: bool) -> Result<Epath, CipStatus> {
    let words = reader.u8().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
    if reserved {
        reader.u8().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
    }
    Epath::read(words, reader, data).map_err(PathError::status)
}

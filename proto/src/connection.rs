//! Messages of the Connection Manager, class 6: Unconnected Send, Forward Open, Large Forward Open, Forward Close, and
//! its counters (CIP Vol. 1, 3-5; spec/ethernet-ip.md §7).
//!
//! Codecs only; who holds which connection is [`crate::session`]'s business. Intervals are in microseconds.

use bytes::{BufMut, Bytes, BytesMut};
use std::time::Duration;

use crate::cip::{CipStatus, Reply, service};
use crate::cpf::ConnectionId;
use crate::epath::{Epath, PathError};
use crate::wire::Reader;

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
}

/// Request data of Unconnected Send (0x52): a message and the way to its destination.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct UnconnectedSend {
    /// Time allowed.
    pub time: TickTime,
    /// The embedded message router request.
    pub message: Bytes,
    /// The way; empty is the device itself.
    pub route: Epath,
}

impl UnconnectedSend {
    /// Reads the data. A route that is missing is empty; surplus bytes are ignored.
    ///
    /// # Errors
    /// 0x13 when the message is cut, 0x26 or 0x04 for a bad route.
    pub fn decode(data: &Bytes) -> Result<Self, CipStatus> {
        let mut reader = Reader::new(data);
        let time = TickTime::read(&mut reader).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let length = usize::from(reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?);
        let message = data.slice_ref(reader.take(length).ok_or(CipStatus::NOT_ENOUGH_DATA)?);
        if length % 2 == 1 {
            let _pad = reader.u8();
        }
        let claimed = 2 * usize::from(reader.u8().unwrap_or_default());
        let _reserved = reader.u8();
        let present = reader.remaining();
        let route = reader
            .take(claimed)
            .ok_or_else(|| PathError::Size { claimed, present }.status())?;
        let route = Epath::decode(&data.slice_ref(route)).map_err(PathError::status)?;
        Ok(Self { time, message, route })
    }

    /// The data of the request.
    ///
    /// # Errors
    /// The route is too long, or the message longer than 65,535 bytes.
    pub fn to_bytes(&self) -> Result<Bytes, PathError> {
        let too_long = PathError::TooDeep {
            limit: usize::from(u16::MAX),
        };
        let length = u16::try_from(self.message.len()).map_err(|_| too_long)?;
        let mut out = BytesMut::new();
        out.put_slice(&[self.time.tick, self.time.ticks]);
        out.put_u16_le(length);
        out.put_slice(&self.message);
        out.put_bytes(0, usize::from(length % 2));
        encode_reserved_path(&self.route, &mut out)?;
        Ok(out.freeze())
    }
}

/// `size u8, reserved u8, path`.
fn encode_reserved_path(path: &Epath, out: &mut BytesMut) -> Result<(), PathError> {
    let mut sized = BytesMut::new();
    path.encode_sized(&mut sized)?;
    let (words, path) = sized
        .split_first()
        .map(|(words, path)| (*words, path))
        .unwrap_or_default();
    out.put_slice(&[words, 0]);
    out.put_slice(path);
    Ok(())
}

/// How packets of one direction are addressed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ConnectionType {
    /// No connection in this direction; both null: reconfigure.
    Null,
    /// To a group.
    Multicast,
    /// To one consumer.
    PointToPoint,
    /// The reserved code 3.
    Reserved,
}

/// Network connection parameters of one direction; the 16-bit and 32-bit forms differ in the size's width only.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NetworkParameters {
    /// Several owners may have the connection.
    pub redundant_owner: bool,
    /// Addressing.
    pub connection_type: ConnectionType,
    /// 0 low, 1 high, 2 scheduled, 3 urgent.
    pub priority: u8,
    /// Sizes up to `size` rather than exactly `size`.
    pub variable: bool,
    /// Bytes, including the 2-byte sequence count of class 1 and 3.
    pub size: u16,
}

impl NetworkParameters {
    /// Largest size of the 16-bit form.
    pub const MAX_SMALL: u16 = 0x01FF;

    /// Point-to-point, low priority, variable: what class 3 uses.
    pub const fn explicit(size: u16) -> Self {
        Self {
            redundant_owner: false,
            connection_type: ConnectionType::PointToPoint,
            priority: 0,
            variable: true,
            size,
        }
    }

    /// From the 16-bit form.
    pub const fn from_small(word: u16) -> Self {
        Self::from_flags((word >> 8) as u8, word & Self::MAX_SMALL)
    }

    /// From the 32-bit form.
    pub const fn from_large(word: u32) -> Self {
        Self::from_flags((word >> 24) as u8, (word & 0xFFFF) as u16)
    }

    /// To the 16-bit form; a larger size is cut to [`Self::MAX_SMALL`].
    pub const fn to_small(self) -> u16 {
        let size = if self.size > Self::MAX_SMALL {
            Self::MAX_SMALL
        } else {
            self.size
        };
        ((self.flags() as u16) << 8) | size
    }

    /// To the 32-bit form.
    pub const fn to_large(self) -> u32 {
        ((self.flags() as u32) << 24) | self.size as u32
    }

    const fn from_flags(flags: u8, size: u16) -> Self {
        let connection_type = match (flags >> 5) & 3 {
            0 => ConnectionType::Null,
            1 => ConnectionType::Multicast,
            2 => ConnectionType::PointToPoint,
            _ => ConnectionType::Reserved,
        };
        let (priority, variable) = ((flags >> 2) & 3, flags & 2 != 0);
        Self {
            redundant_owner: flags & 0x80 != 0,
            connection_type,
            priority,
            variable,
            size,
        }
    }

    const fn flags(self) -> u8 {
        let connection_type = match self.connection_type {
            ConnectionType::Null => 0,
            ConnectionType::Multicast => 1,
            ConnectionType::PointToPoint => 2,
            ConnectionType::Reserved => 3,
        };
        (self.redundant_owner as u8) << 7 | connection_type << 5 | (self.priority & 3) << 2 | (self.variable as u8) << 1
    }
}

/// Transport class and trigger byte of an explicit connection's server side: 0xA3.
pub const TRANSPORT_CLASS_3: u8 = 0xA3;

/// Request data of Forward Open (0x54) and Large Forward Open (0x5B).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ForwardOpen {
    /// Time allowed.
    pub time: TickTime,
    /// A proposal that the target need not follow, or 0.
    pub o_to_t_id: ConnectionId,
    /// Chosen by the originator when point-to-point.
    pub t_to_o_id: ConnectionId,
    /// Names the connection.
    pub key: ConnectionKey,
    /// Code 0-7: the timeout is 4 << code intervals.
    pub multiplier: u8,
    /// Requested interval, µs.
    pub o_to_t_rpi: u32,
    /// Originator to target.
    pub o_to_t: NetworkParameters,
    /// Requested interval, µs.
    pub t_to_o_rpi: u32,
    /// Target to originator.
    pub t_to_o: NetworkParameters,
    /// Bit 7 server, bits 6-4 trigger, bits 3-0 class.
    pub transport: u8,
    /// Ports, key, application path.
    pub path: Epath,
}

/// A Forward Open or Close that cannot be read.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{status}")]
pub struct OpenError {
    /// The connection it is about, as far as it was there.
    pub key: ConnectionKey,
    /// Why.
    pub status: CipStatus,
}

impl ForwardOpen {
    /// The class in the transport byte.
    pub const fn transport_class(&self) -> u8 {
        self.transport & 0x0F
    }

    /// Whether it reconfigures a connection instead of opening one.
    pub fn is_null(&self) -> bool {
        self.o_to_t.connection_type == ConnectionType::Null && self.t_to_o.connection_type == ConnectionType::Null
    }

    /// Reads the data of service 0x54, or of 0x5B if `large`. Surplus bytes are ignored.
    ///
    /// # Errors
    /// 0x13, or the path's status.
    pub fn decode(data: &Bytes, large: bool) -> Result<Self, OpenError> {
        let mut reader = Reader::new(data);
        let mut key = ConnectionKey::default();
        let this = Self::read(&mut reader, large, &mut key);
        let mut this = this.ok_or(OpenError {
            key,
            status: CipStatus::NOT_ENOUGH_DATA,
        })?;
        this.path = read_path(&mut reader, data, false).map_err(|status| OpenError { key, status })?;
        Ok(this)
    }

    /// All but the path.
    fn read(reader: &mut Reader<'_>, large: bool, known: &mut ConnectionKey) -> Option<Self> {
        let time = TickTime::read(reader)?;
        let o_to_t_id = ConnectionId(reader.u32()?);
        let t_to_o_id = ConnectionId(reader.u32()?);
        let key = ConnectionKey::read(reader)?;
        *known = key;
        let multiplier = reader.u8()?;
        reader.take(3)?;
        let parameters = |reader: &mut Reader<'_>| {
            if large {
                reader.u32().map(NetworkParameters::from_large)
            } else {
                reader.u16().map(NetworkParameters::from_small)
            }
        };
        let o_to_t_rpi = reader.u32()?;
        let o_to_t = parameters(reader)?;
        let t_to_o_rpi = reader.u32()?;
        let t_to_o = parameters(reader)?;
        let transport = reader.u8()?;
        let path = Epath::default();
        Some(Self {
            time,
            o_to_t_id,
            t_to_o_id,
            key,
            multiplier,
            o_to_t_rpi,
            o_to_t,
            t_to_o_rpi,
            t_to_o,
            transport,
            path,
        })
    }

    /// The data of service 0x54, or of 0x5B if `large`.
    ///
    /// # Errors
    /// The path is too long.
    pub fn to_bytes(&self, large: bool) -> Result<Bytes, PathError> {
        let mut out = BytesMut::with_capacity(64);
        out.put_slice(&[self.time.tick, self.time.ticks]);
        out.put_u32_le(self.o_to_t_id.0);
        out.put_u32_le(self.t_to_o_id.0);
        self.key.write(&mut out);
        out.put_slice(&[self.multiplier, 0, 0, 0]);
        for (rpi, parameters) in [(self.o_to_t_rpi, self.o_to_t), (self.t_to_o_rpi, self.t_to_o)] {
            out.put_u32_le(rpi);
            if large {
                out.put_u32_le(parameters.to_large());
            } else {
                out.put_u16_le(parameters.to_small());
            }
        }
        out.put_u8(self.transport);
        self.path.encode_sized(&mut out)?;
        Ok(out.freeze())
    }
}

fn read_path(reader: &mut Reader<'_>, data: &Bytes, reserved: bool) -> Result<Epath, CipStatus> {
    let claimed = 2 * usize::from(reader.u8().ok_or(CipStatus::NOT_ENOUGH_DATA)?);
    if reserved {
        reader.u8().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
    }
    let present = reader.remaining();
    let path = reader
        .take(claimed)
        .ok_or_else(|| PathError::Size { claimed, present }.status())?;
    Epath::decode(&data.slice_ref(path)).map_err(PathError::status)
}

/// Reply data of a Forward Open that succeeded.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ForwardOpenReply {
    /// Chosen by the target.
    pub o_to_t_id: ConnectionId,
    /// The originator's, when point-to-point.
    pub t_to_o_id: ConnectionId,
    /// Names the connection.
    pub key: ConnectionKey,
    /// Interval the target expects, µs.
    pub o_to_t_api: u32,
    /// Interval the target keeps, µs.
    pub t_to_o_api: u32,
    /// Whole words, at most 510 bytes.
    pub application: Bytes,
}

impl ForwardOpenReply {
    /// Reads the data; `None` if it is cut.
    pub fn decode(data: &Bytes) -> Option<Self> {
        let mut reader = Reader::new(data);
        let o_to_t_id = ConnectionId(reader.u32()?);
        let t_to_o_id = ConnectionId(reader.u32()?);
        let key = ConnectionKey::read(&mut reader)?;
        let (o_to_t_api, t_to_o_api) = (reader.u32()?, reader.u32()?);
        let words = usize::from(reader.u8()?);
        reader.u8()?;
        let application = data.slice_ref(reader.take(2 * words)?);
        Some(Self {
            o_to_t_id,
            t_to_o_id,
            key,
            o_to_t_api,
            t_to_o_api,
            application,
        })
    }

    /// The data of a reply.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(26);
        out.put_u32_le(self.o_to_t_id.0);
        out.put_u32_le(self.t_to_o_id.0);
        self.key.write(&mut out);
        out.put_u32_le(self.o_to_t_api);
        out.put_u32_le(self.t_to_o_api);
        let words = u8::try_from(self.application.len() / 2).unwrap_or(u8::MAX);
        out.put_slice(&[words, 0]);
        out.put_slice(self.application.get(..2 * usize::from(words)).unwrap_or_default());
        out.freeze()
    }
}

/// The refusal of a Forward Open or Close: the connection's name, then the remaining path size.
pub fn refusal(service: u8, key: ConnectionKey, status: CipStatus, remaining_words: u8) -> Reply {
    let mut out = BytesMut::with_capacity(10);
    key.write(&mut out);
    out.put_slice(&[remaining_words, 0]);
    Reply::with_status(service, status, out)
}

/// The refusal of an Unconnected Send that cannot be routed: 0x01, the code, and the remaining path size.
pub fn route_refusal(code: u16, remaining_words: u8) -> Reply {
    let data = Bytes::copy_from_slice(&[remaining_words]);
    Reply::with_status(service::UNCONNECTED_SEND, CipStatus::connection(code), data)
}

/// Request data of Forward Close (0x4E).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ForwardClose {
    /// Time allowed.
    pub time: TickTime,
    /// Which connection.
    pub key: ConnectionKey,
    /// The path it was opened with; a mismatch is ignored.
    pub path: Epath,
}

impl ForwardClose {
    /// Reads the data; a path that is cut or not understood is taken as empty, since it is ignored anyway.
    ///
    /// # Errors
    /// 0x13 when the connection's name is cut.
    pub fn decode(data: &Bytes) -> Result<Self, CipStatus> {
        let mut reader = Reader::new(data);
        let time = TickTime::read(&mut reader).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let key = ConnectionKey::read(&mut reader).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let path = read_path(&mut reader, data, true).unwrap_or_default();
        Ok(Self { time, key, path })
    }

    /// The data of the request.
    ///
    /// # Errors
    /// The path is too long.
    pub fn to_bytes(&self) -> Result<Bytes, PathError> {
        let mut out = BytesMut::with_capacity(24);
        out.put_slice(&[self.time.tick, self.time.ticks]);
        self.key.write(&mut out);
        encode_reserved_path(&self.path, &mut out)?;
        Ok(out.freeze())
    }

    /// The data of a reply that confirms it.
    pub fn reply(key: ConnectionKey) -> Reply {
        let mut out = BytesMut::with_capacity(10);
        key.write(&mut out);
        out.put_slice(&[0, 0]);
        Reply::success(service::FORWARD_CLOSE, out)
    }
}

/// What the Connection Manager counts; the number is the attribute.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
#[repr(u8)]
pub enum Count {
    /// Forward Opens received.
    OpenRequests = 1,
    /// Refused because they could not be read.
    OpenFormatRejects = 2,
    /// Refused because a limit was reached.
    OpenResourceRejects = 3,
    /// Refused for another reason.
    OpenOtherRejects = 4,
    /// Forward Closes received.
    CloseRequests = 5,
    /// Refused because they could not be read.
    CloseFormatRejects = 6,
    /// Refused for another reason.
    CloseOtherRejects = 7,
    /// Connections whose watchdog expired.
    ConnectionTimeouts = 8,
}

/// Attributes 1 to 8 of the Connection Manager, instance 1. They wrap.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counters([u16; 8]);

impl Counters {
    /// Counts one.
    pub fn add(&mut self, count: Count) {
        if let Some(counter) = self.0.get_mut(count as usize - 1) {
            *counter = counter.wrapping_add(1);
        }
    }

    /// How often.
    pub fn of(&self, count: Count) -> u16 {
        self.attribute(count as u16).unwrap_or_default()
    }

    /// The value of attribute 1 to 8.
    pub fn attribute(&self, id: u16) -> Option<u16> {
        self.0.get(usize::from(id).checked_sub(1)?).copied()
    }

    /// Get Attributes All: attributes 1 to 8.
    pub fn attributes_all(&self) -> Bytes {
        self.0.iter().flat_map(|counter| counter.to_le_bytes()).collect()
    }
}

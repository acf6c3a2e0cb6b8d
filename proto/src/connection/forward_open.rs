//! Forward Open and Large Forward Open, request and reply (CIP Vol. 1, 3-5; spec/ethernet-ip.md §7).
//!
//! Not here: the check of the requests. Intervals are in microseconds.

use bytes::{BufMut, Bytes, BytesMut};

use super::{ConnectionKey, ConnectionType, NetworkParameters, TickTime, read_path};
use crate::cip::CipStatus;
use crate::cpf::ConnectionId;
use crate::epath::{Epath, PathError};
use crate::wire::Reader;

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
    /// The reason.
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
        self.time.write(&mut out);
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

//! Unconnected Send: a message and the way to its destination (CIP Vol. 1, 3-5; spec/ethernet-ip.md §7).
//!
//! Not here: the check that the route leads to a device.

use bytes::{BufMut, Bytes, BytesMut};

use super::{TickTime, encode_reserved_path};
use crate::cip::{CipStatus, Reply, service};
use crate::epath::{Epath, PathError};
use crate::wire::Reader;

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
        let words = reader.u8().unwrap_or_default();
        let _reserved = reader.u8();
        let route = Epath::read(words, &mut reader, data).map_err(PathError::status)?;
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
        self.time.write(&mut out);
        out.put_u16_le(length);
        out.put_slice(&self.message);
        out.put_bytes(0, usize::from(length % 2));
        encode_reserved_path(&self.route, &mut out)?;
        Ok(out.freeze())
    }
}

/// The refusal of an Unconnected Send that cannot be routed: 0x01, the code, and the remaining path size.
pub fn route_refusal(code: u16, remaining_words: u8) -> Reply {
    let data = Bytes::copy_from_slice(&[remaining_words]);
    Reply::with_status(service::UNCONNECTED_SEND, CipStatus::connection(code), data)
}

//! Forward Close, request and reply (CIP Vol. 1, 3-5; spec/ethernet-ip.md §7).
//!
//! Not here: the connections.

use bytes::{BufMut, Bytes, BytesMut};

use super::{ConnectionKey, TickTime, encode_reserved_path, read_path};
use crate::cip::{CipStatus, Reply, service};
use crate::epath::{Epath, PathError};
use crate::wire::Reader;

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
        self.time.write(&mut out);
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

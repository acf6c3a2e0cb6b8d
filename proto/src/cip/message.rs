//! One message router request or reply (CIP Vol. 1, 2-4; spec/ethernet-ip.md §4).
//!
//! Not here: the effects of services. Path sizes on the wire are in 16-bit words.

use bytes::{BufMut, Bytes, BytesMut};

use super::service;
use crate::epath::{Epath, PathError};
use crate::status::CipStatus;
use crate::wire::Reader;

/// Bytes of a reply without additional status and data.
pub const REPLY_HEAD: usize = 4;

/// A message router request: `service u8, path size u8 (words), path, data`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Request {
    /// Service code, bit 7 clear.
    pub service: u8,
    /// The object or tag that it addresses.
    pub path: Epath,
    /// The service's data, perhaps with surplus bytes behind it.
    pub data: Bytes,
}

/// A request that cannot be read; answered with [`RequestError::reply`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("service 0x{service:02X}: {status}")]
pub struct RequestError {
    /// Service code, 0 if there was not even one.
    pub service: u8,
    /// The reason.
    pub status: CipStatus,
}

impl RequestError {
    /// The refusal.
    pub fn reply(self) -> Reply {
        Reply::error(self.service, self.status)
    }
}

impl Request {
    /// A request.
    pub fn new(service: u8, path: Epath, data: impl Into<Bytes>) -> Self {
        Self {
            service,
            path,
            data: data.into(),
        }
    }

    /// Reads a message.
    ///
    /// # Errors
    /// 0x13 for a message without path size, 0x26 for a path beyond the message, 0x04 for a path that is not understood,
    /// 0x08 for a service code with the reply bit.
    pub fn decode(message: &Bytes) -> Result<Self, RequestError> {
        Self::read(message, message)
    }

    /// Reads a message that is a part of `bytes`.
    pub(super) fn read(message: &[u8], bytes: &Bytes) -> Result<Self, RequestError> {
        let mut reader = Reader::new(message);
        let service = reader.u8().unwrap_or_default();
        let fail = |status| RequestError {
            service: service & !service::REPLY,
            status,
        };
        let words = reader.u8().ok_or_else(|| fail(CipStatus::NOT_ENOUGH_DATA))?;
        if service & service::REPLY != 0 {
            return Err(fail(CipStatus::SERVICE_NOT_SUPPORTED));
        }
        let path = Epath::read(words, &mut reader, bytes).map_err(|error| fail(error.status()))?;
        Ok(Self {
            service,
            path,
            data: bytes.slice_ref(reader.rest()),
        })
    }

    /// Appends the message.
    ///
    /// # Errors
    /// The path is too long; nothing is appended then.
    pub fn encode(&self, out: &mut BytesMut) -> Result<(), PathError> {
        let mut head = BytesMut::with_capacity(2 + self.data.len());
        head.put_u8(self.service);
        self.path.encode_sized(&mut head)?;
        out.put_slice(&head);
        out.put_slice(&self.data);
        Ok(())
    }

    /// The message's bytes.
    ///
    /// # Errors
    /// The path is too long.
    pub fn to_bytes(&self) -> Result<Bytes, PathError> {
        let mut out = BytesMut::new();
        self.encode(&mut out)?;
        Ok(out.freeze())
    }
}

/// A message router reply: `service|0x80 u8, 0, general status u8, additional size u8 (words), additional words, data`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Reply {
    /// Service code of the request, bit 7 clear.
    pub service: u8,
    /// General and additional status.
    pub status: CipStatus,
    /// The service's data.
    pub data: Bytes,
}

impl Reply {
    /// Success with data.
    pub fn success(service: u8, data: impl Into<Bytes>) -> Self {
        Self {
            service,
            status: CipStatus::SUCCESS,
            data: data.into(),
        }
    }

    /// Any status with data (0x06 has both).
    pub fn with_status(service: u8, status: CipStatus, data: impl Into<Bytes>) -> Self {
        Self {
            service,
            status,
            data: data.into(),
        }
    }

    /// A refusal without data.
    pub fn error(service: u8, status: CipStatus) -> Self {
        Self {
            service,
            status,
            data: Bytes::new(),
        }
    }

    /// Bytes on the wire.
    pub fn len(&self) -> usize {
        REPLY_HEAD + 2 * self.status.additional().len() + self.data.len()
    }

    /// Never: there is always a head.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Appends the message.
    pub fn encode(&self, out: &mut BytesMut) {
        let words = self.status.additional();
        out.reserve(self.len());
        out.put_u8(self.service | service::REPLY);
        out.put_u8(0);
        out.put_u8(self.status.general());
        out.put_u8(u8::try_from(words.len()).unwrap_or(u8::MAX));
        for word in words {
            out.put_u16_le(*word);
        }
        out.put_slice(&self.data);
    }

    /// The message's bytes.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(self.len());
        self.encode(&mut out);
        out.freeze()
    }

    /// Reads a message; `None` if it is cut or has no reply bit. Of the additional words the first
    /// [`CipStatus::MAX_ADDITIONAL`] are kept.
    pub fn decode(message: &Bytes) -> Option<Self> {
        let mut reader = Reader::new(message);
        let service = reader.u8().filter(|code| code & service::REPLY != 0)? & !service::REPLY;
        reader.u8()?;
        let mut status = CipStatus::new(reader.u8()?);
        let words = reader.u8()?;
        for _ in 0..words {
            status = status.with(reader.u16()?);
        }
        Some(Self {
            service,
            status,
            data: message.slice_ref(reader.rest()),
        })
    }
}

/// Whether `surplus` is one of the encoded routes that a stock client leaves behind an unconnected message: `0000` or
/// `01 00 01 00` (spec/ethernet-ip.md §4).
pub fn is_stray_route(surplus: &[u8]) -> bool {
    matches!(surplus, [0, 0] | [1, 0, 1, _])
}

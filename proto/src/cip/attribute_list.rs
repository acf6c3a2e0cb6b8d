//! Get and Set Attribute List: ids asked for, and values with a status each (CIP Vol. 1, appendix A; spec/ethernet-ip.md
//! §13).
//!
//! Not here: the attributes. Their widths are not on the wire, so the reader of a list must know them.

use bytes::{BufMut, Bytes, BytesMut};

use super::Reply;
use crate::status::CipStatus;
use crate::wire::Reader;

/// Attributes accepted in one attribute list.
pub const MAX_ATTRIBUTES: usize = 256;

/// Request data of Get Attribute List: `count u16, id u16 × count`. Surplus bytes are ignored.
///
/// # Errors
/// 0x13 when ids are missing, 0x03 for more than [`MAX_ATTRIBUTES`].
pub fn decode_attribute_ids(data: &[u8]) -> Result<Vec<u16>, CipStatus> {
    let mut reader = Reader::new(data);
    let count = usize::from(reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?);
    if reader.remaining() < 2 * count {
        return Err(CipStatus::NOT_ENOUGH_DATA);
    }
    if count > MAX_ATTRIBUTES {
        return Err(CipStatus::INVALID_PARAMETER_VALUE);
    }
    let mut ids = Vec::with_capacity(count);
    for _ in 0..count {
        ids.push(reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?);
    }
    Ok(ids)
}

/// The other direction of [`decode_attribute_ids`].
pub fn encode_attribute_ids(ids: &[u16]) -> Bytes {
    let mut out = BytesMut::with_capacity(2 + 2 * ids.len());
    out.put_u16_le(u16::try_from(ids.len()).unwrap_or(u16::MAX));
    for id in ids {
        out.put_u16_le(*id);
    }
    out.freeze()
}

/// Collects the reply of Get or Set Attribute List: `count u16, (id u16, status u16, value) × count`.
#[derive(Debug)]
pub struct AttributeListReply {
    service: u8,
    count: u16,
    failed: bool,
    body: BytesMut,
}

impl AttributeListReply {
    /// An empty list for `service` (0x03 or 0x04).
    pub fn new(service: u8) -> Self {
        Self {
            service,
            count: 0,
            failed: false,
            body: BytesMut::new(),
        }
    }

    /// Adds an attribute: its value (empty for Set), or why there is none.
    pub fn push(&mut self, id: u16, value: Result<&[u8], CipStatus>) {
        self.count = self.count.saturating_add(1);
        self.body.put_u16_le(id);
        match value {
            Ok(value) => {
                self.body.put_u16_le(0);
                self.body.put_slice(value);
            }
            Err(status) => {
                self.failed = true;
                self.body.put_u16_le(status.general().into());
            }
        }
    }

    /// The reply: 0x00, or 0x0A when an attribute failed, or 0x11 when it exceeds `budget` bytes.
    pub fn finish(self, budget: usize) -> Reply {
        let mut data = BytesMut::with_capacity(2 + self.body.len());
        data.put_u16_le(self.count);
        data.put_slice(&self.body);
        let status = if self.failed {
            CipStatus::ATTRIBUTE_LIST_ERROR
        } else {
            CipStatus::SUCCESS
        };
        let reply = Reply::with_status(self.service, status, data);
        if reply.len() > budget {
            Reply::error(self.service, CipStatus::REPLY_TOO_LARGE)
        } else {
            reply
        }
    }
}

/// Reads the values of a Get Attribute List reply, or of a Set Attribute List request: the widths are not on the wire,
/// so the reader must know them.
#[derive(Clone, Copy, Debug)]
pub struct AttributeListReader<'a> {
    reader: Reader<'a>,
    left: u16,
}

impl<'a> AttributeListReader<'a> {
    /// A reader in front of the first attribute.
    ///
    /// # Errors
    /// 0x13 when even the count is missing.
    pub fn new(data: &'a [u8]) -> Result<Self, CipStatus> {
        let mut reader = Reader::new(data);
        let left = reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        Ok(Self { reader, left })
    }

    /// Attributes not read yet, as claimed.
    pub const fn left(&self) -> u16 {
        self.left
    }

    /// Set request: the next id; its value follows by [`Self::value`]. `None` when the list is done or cut.
    pub fn next_id(&mut self) -> Option<u16> {
        self.left = self.left.checked_sub(1)?;
        self.reader.u16()
    }

    /// Get reply: the next id and its general status; a value follows only when that is 0.
    pub fn next_entry(&mut self) -> Option<(u16, u16)> {
        let id = self.next_id()?;
        Some((id, self.reader.u16()?))
    }

    /// `width` bytes of value.
    pub fn value(&mut self, width: usize) -> Option<&'a [u8]> {
        self.reader.take(width)
    }

    /// The bytes behind the list.
    pub const fn rest(&self) -> &'a [u8] {
        self.reader.rest()
    }
}

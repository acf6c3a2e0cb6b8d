//! The Template class: the attributes of a structure, and reading its definition (spec/ethernet-ip.md §11).
//!
//! Not here: the layout of the definition ([`Definition`](super::Definition)). Sizes are in bytes but for the definition's, which
//! the class counts in 32-bit words.

use bytes::{BufMut, Bytes, BytesMut};

use crate::cip::{AttributeListReader, AttributeListReply, CipStatus, REPLY_HEAD, Reply, service};
use crate::wire::Reader;

/// The attributes of a structure in the Template class (spec/ethernet-ip.md §11).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct TemplateAttributes {
    /// Attribute 1: the handle behind `A0 02`.
    pub handle: u16,
    /// Attribute 2: members.
    pub members: u16,
    /// Attribute 4: size of the definition, in 32-bit words.
    pub definition_words: u32,
    /// Attribute 5: bytes of a value.
    pub size: u32,
}

impl TemplateAttributes {
    /// The attributes that a client reads.
    pub const IDS: [u16; 4] = [4, 5, 2, 1];

    /// The value of an attribute. Attribute 3 exists and is 0, because a stock client needs it.
    ///
    /// # Errors
    /// 0x14 for an id there is not.
    pub fn attribute(self, id: u16) -> Result<Bytes, CipStatus> {
        Ok(match id {
            1 => Bytes::copy_from_slice(&self.handle.to_le_bytes()),
            2 => Bytes::copy_from_slice(&self.members.to_le_bytes()),
            3 => Bytes::from_static(&[0, 0]),
            4 => Bytes::copy_from_slice(&self.definition_words.to_le_bytes()),
            5 => Bytes::copy_from_slice(&self.size.to_le_bytes()),
            _ => return Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED),
        })
    }

    /// The reply of Get Attribute List for `ids`.
    pub fn reply(self, ids: &[u16], budget: usize) -> Reply {
        let mut list = AttributeListReply::new(service::GET_ATTRIBUTE_LIST);
        for id in ids {
            match self.attribute(*id) {
                Ok(value) => list.push(*id, Ok(&value)),
                Err(status) => list.push(*id, Err(status)),
            }
        }
        list.finish(budget)
    }

    /// Reads the reply data of Get Attribute List; `None` when it is cut, or an attribute failed or is unknown.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut list = AttributeListReader::new(data).ok()?;
        let mut this = Self::default();
        while list.left() > 0 {
            let (id, 0) = list.next_entry()? else {
                return None;
            };
            match id {
                1 => this.handle = Reader::new(list.value(2)?).u16()?,
                2 => this.members = Reader::new(list.value(2)?).u16()?,
                3 => drop(list.value(2)?),
                4 => this.definition_words = Reader::new(list.value(4)?).u32()?,
                5 => this.size = Reader::new(list.value(4)?).u32()?,
                _ => return None,
            }
        }
        Some(this)
    }
}

/// Request data of Read Template (0x4C on class 0x6C).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ReadTemplate {
    /// First byte.
    pub offset: u32,
    /// Bytes asked for.
    pub bytes: u16,
}

impl ReadTemplate {
    /// Reads `byte offset u32, bytes u16`.
    ///
    /// # Errors
    /// 0x13.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let mut reader = Reader::new(data);
        let offset = reader.u32().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let bytes = reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        Ok(Self { offset, bytes })
    }

    /// The data of the request.
    pub fn to_bytes(self) -> Bytes {
        let mut out = BytesMut::with_capacity(6);
        out.put_u32_le(self.offset);
        out.put_u16_le(self.bytes);
        out.freeze()
    }

    /// The reply from the zero-padded `definition`: 0x00 when the request or the definition ends, 0x06 only when `budget`
    /// (of the whole router reply) cut it.
    pub fn reply(self, definition: &[u8], budget: usize) -> Reply {
        let offset = usize::try_from(self.offset).unwrap_or(usize::MAX);
        let rest = definition.get(offset..).unwrap_or_default();
        let asked = rest.get(..usize::from(self.bytes)).unwrap_or(rest);
        let room = budget.saturating_sub(REPLY_HEAD);
        match asked.get(..room) {
            Some([]) if !asked.is_empty() => Reply::error(service::READ_TAG, CipStatus::REPLY_TOO_LARGE),
            Some(part) if part.len() < asked.len() => Reply::with_status(
                service::READ_TAG,
                CipStatus::PARTIAL_TRANSFER,
                Bytes::copy_from_slice(part),
            ),
            _ => Reply::success(service::READ_TAG, Bytes::copy_from_slice(asked)),
        }
    }
}

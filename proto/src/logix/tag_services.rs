//! Reading, writing and masking tags: services 0x4C, 0x4D, 0x4E, 0x52 and 0x53 (spec/ethernet-ip.md §9).
//!
//! Codecs, and the rule by which a read is cut into fragments; the caller finds the tag and its bytes. Offsets are in
//! bytes.

use bytes::{BufMut, Bytes, BytesMut};

use super::WireType;
use crate::cip::{CipStatus, REPLY_HEAD, Reply};
use crate::status::general_error;
use crate::wire::Reader;

/// Request data of Read Tag (0x4C, offset 0) and Read Tag Fragmented (0x52).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ReadTag {
    /// Elements asked for.
    pub elements: u16,
    /// Byte offset into them.
    pub offset: u32,
}

impl ReadTag {
    /// Reads the data of service 0x4C.
    ///
    /// # Errors
    /// 0x13.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let elements = Reader::new(data).u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        Ok(Self { elements, offset: 0 })
    }

    /// Reads the data of service 0x52.
    ///
    /// # Errors
    /// 0x13.
    pub fn decode_fragmented(data: &[u8]) -> Result<Self, CipStatus> {
        let mut reader = Reader::new(data);
        let elements = reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let offset = reader.u32().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        Ok(Self { elements, offset })
    }

    /// The data of service 0x4C (the offset is left out).
    pub fn to_bytes(self) -> Bytes {
        Bytes::copy_from_slice(&self.elements.to_le_bytes())
    }

    /// The data of service 0x52.
    pub fn to_bytes_fragmented(self) -> Bytes {
        let mut out = BytesMut::with_capacity(6);
        out.put_u16_le(self.elements);
        out.put_u32_le(self.offset);
        out.freeze()
    }

    /// The reply to a read: as much of `all` (the asked elements, whole) from the offset on as fits `budget` bytes (of
    /// the whole router reply). 0x06 when bytes remain. Fragments of atomic types end at an element's boundary,
    /// `element` is the size of one; for structures any multiple of 4 will do.
    ///
    /// 0xFF/0x2104 when the offset is beyond the data; 0x11 when not even one element fits.
    pub fn reply(self, service: u8, data_type: WireType, element: usize, all: &[u8], budget: usize) -> Reply {
        let offset = usize::try_from(self.offset).unwrap_or(usize::MAX);
        let Some(rest) = all.get(offset..).filter(|rest| !rest.is_empty() || all.is_empty()) else {
            return Reply::error(
                service,
                CipStatus::GENERAL_ERROR.with(general_error::OFFSET_BEYOND_DATA),
            );
        };
        let room = budget.saturating_sub(REPLY_HEAD + data_type.size());
        let mut out = BytesMut::with_capacity(data_type.size() + rest.len().min(room));
        data_type.encode(&mut out);
        if rest.len() <= room {
            out.put_slice(rest);
            return Reply::success(service, out);
        }
        let unit = match data_type {
            WireType::Atomic(_) => element.max(4),
            WireType::Structure(_) => 4,
        };
        match rest.get(..room - room % unit).filter(|part| !part.is_empty()) {
            Some(part) => {
                out.put_slice(part);
                Reply::with_status(service, CipStatus::PARTIAL_TRANSFER, out)
            }
            None => Reply::error(service, CipStatus::REPLY_TOO_LARGE),
        }
    }
}

/// Reply data of both reads.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ReadReply {
    /// Type of an element.
    pub data_type: WireType,
    /// The elements, or a fragment of them.
    pub data: Bytes,
}

impl ReadReply {
    /// Reads the data of a reply; `None` if the type is cut.
    pub fn decode(data: &Bytes) -> Option<Self> {
        let mut reader = Reader::new(data);
        let data_type = WireType::decode(&mut reader)?;
        Some(Self {
            data_type,
            data: data.slice_ref(reader.rest()),
        })
    }

    /// The data of a reply.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(self.data_type.size() + self.data.len());
        self.data_type.encode(&mut out);
        out.put_slice(&self.data);
        out.freeze()
    }
}

/// Request data of Write Tag (0x4D, offset 0) and Write Tag Fragmented (0x53).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct WriteTag {
    /// Type of an element.
    pub data_type: WireType,
    /// Elements meant.
    pub elements: u16,
    /// Byte offset into them.
    pub offset: u32,
    /// Values, perhaps with surplus bytes behind them: take `elements × size` and ignore the rest.
    pub data: Bytes,
}

impl WriteTag {
    /// Reads the data of service 0x4D.
    ///
    /// # Errors
    /// 0x13.
    pub fn decode(data: &Bytes) -> Result<Self, CipStatus> {
        Self::decode_with(data, |_| Some(0)).ok_or(CipStatus::NOT_ENOUGH_DATA)
    }

    /// Reads the data of service 0x53.
    ///
    /// # Errors
    /// 0x13.
    pub fn decode_fragmented(data: &Bytes) -> Result<Self, CipStatus> {
        Self::decode_with(data, |reader| reader.u32()).ok_or(CipStatus::NOT_ENOUGH_DATA)
    }

    fn decode_with(data: &Bytes, offset: impl FnOnce(&mut Reader<'_>) -> Option<u32>) -> Option<Self> {
        let mut reader = Reader::new(data);
        let data_type = WireType::decode(&mut reader)?;
        let elements = reader.u16()?;
        let offset = offset(&mut reader)?;
        Some(Self {
            data_type,
            elements,
            offset,
            data: data.slice_ref(reader.rest()),
        })
    }

    /// The data of service 0x4D (the offset is left out).
    pub fn to_bytes(&self) -> Bytes {
        self.encode(None)
    }

    /// The data of service 0x53.
    pub fn to_bytes_fragmented(&self) -> Bytes {
        self.encode(Some(self.offset))
    }

    fn encode(&self, offset: Option<u32>) -> Bytes {
        let mut out = BytesMut::with_capacity(10 + self.data.len());
        self.data_type.encode(&mut out);
        out.put_u16_le(self.elements);
        if let Some(offset) = offset {
            out.put_u32_le(offset);
        }
        out.put_slice(&self.data);
        out.freeze()
    }
}

/// Request data of Read-Modify-Write (0x4E): new = (old OR `or`) AND `and`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ReadModifyWrite {
    /// Bytes of the integer: 1, 2, 4 or 8.
    pub size: u8,
    /// Bits to set.
    pub or: u64,
    /// Bits to keep.
    pub and: u64,
}

impl ReadModifyWrite {
    /// Reads `mask size u16, OR mask, AND mask`; surplus bytes are ignored.
    ///
    /// # Errors
    /// 0x03 for another mask size, 0x13.
    pub fn decode(data: &[u8]) -> Result<Self, CipStatus> {
        let mut reader = Reader::new(data);
        let size = match reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)? {
            1 => 1_u8,
            2 => 2,
            4 => 4,
            8 => 8,
            _ => return Err(CipStatus::INVALID_PARAMETER_VALUE),
        };
        let mut mask = || {
            reader
                .take(usize::from(size))
                .map(little_endian)
                .ok_or(CipStatus::NOT_ENOUGH_DATA)
        };
        Ok(Self {
            size,
            or: mask()?,
            and: mask()?,
        })
    }

    /// The data of the request.
    pub fn to_bytes(self) -> Bytes {
        let mut out = BytesMut::with_capacity(18);
        out.put_u16_le(self.size.into());
        for mask in [self.or, self.and] {
            out.put_slice(mask.to_le_bytes().get(..usize::from(self.size)).unwrap_or_default());
        }
        out.freeze()
    }

    /// The masks that set or clear one bit of an integer of `size` bytes.
    pub fn bit(size: u8, bit: u8, set: bool) -> Self {
        let mask = 1_u64.checked_shl(bit.into()).unwrap_or_default();
        if set {
            Self {
                size,
                or: mask,
                and: u64::MAX,
            }
        } else {
            Self {
                size,
                or: 0,
                and: !mask,
            }
        }
    }

    /// Applies the masks to the integer's bytes.
    ///
    /// # Errors
    /// 0x03 when `integer` is not `size` bytes long.
    pub fn apply(self, integer: &mut [u8]) -> Result<(), CipStatus> {
        if integer.len() != usize::from(self.size) {
            return Err(CipStatus::INVALID_PARAMETER_VALUE);
        }
        let new = (little_endian(integer) | self.or) & self.and;
        for (to, from) in integer.iter_mut().zip(new.to_le_bytes()) {
            *to = from;
        }
        Ok(())
    }
}

fn little_endian(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, byte| (value << 8) | u64::from(*byte))
}

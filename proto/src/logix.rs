//! Tag services of a Logix-like controller and the data they carry (spec/ethernet-ip.md §9-§11; contract.md §4).
//!
//! Codecs only: which tag, its type and its value are the caller's. Requests ignore surplus bytes, because stock clients
//! send them (spec/ethernet-ip.md §4); operands of motion services ([`decode_operands`]) do not.

use arcline_tag::{Elementary, Value};
use bytes::{BufMut, Bytes, BytesMut};

use crate::cip::{AttributeListReader, AttributeListReply, CipStatus, REPLY_HEAD, Reply, service};
use crate::status::general_error;
use crate::wire::Reader;

/// Type code of a SHORT_STRING: `length u8, bytes`.
pub const SHORT_STRING: u16 = 0x00DA;
/// Type code in front of a structure's handle.
pub const STRUCTURE: u16 = 0x02A0;
/// Operands accepted in one motion service; more are [`TypedError::TooMuch`].
pub const MAX_OPERANDS: usize = 64;

/// A type as the tag services write it: two bytes, or four for a structure.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum WireType {
    /// The code of an atomic type, see [`Elementary::code`]; other codes are kept as they came.
    Atomic(u16),
    /// `A0 02` and the structure's handle.
    Structure(u16),
}

impl WireType {
    /// The elementary type, if it is one.
    pub fn elementary(self) -> Option<Elementary> {
        match self {
            Self::Atomic(code) => Elementary::from_code(u8::try_from(code).ok()?),
            Self::Structure(_) => None,
        }
    }

    /// Bytes on the wire.
    pub const fn size(self) -> usize {
        match self {
            Self::Atomic(_) => 2,
            Self::Structure(_) => 4,
        }
    }

    /// Reads two or four bytes.
    pub fn decode(reader: &mut Reader<'_>) -> Option<Self> {
        match reader.u16()? {
            STRUCTURE => reader.u16().map(Self::Structure),
            code => Some(Self::Atomic(code)),
        }
    }

    /// Appends two or four bytes.
    pub fn encode(self, out: &mut BytesMut) {
        match self {
            Self::Atomic(code) => out.put_u16_le(code),
            Self::Structure(handle) => {
                out.put_u16_le(STRUCTURE);
                out.put_u16_le(handle);
            }
        }
    }
}

impl From<Elementary> for WireType {
    fn from(elementary: Elementary) -> Self {
        Self::Atomic(elementary.code().into())
    }
}

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
    /// the whole router reply). 0x06 when something is left. Fragments of atomic types end at an element's boundary,
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
        let mut out = BytesMut::new();
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

/// What the Symbol class tells about a tag (spec/ethernet-ip.md §10).
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Symbol {
    /// Instance id, 1 or more, fixed while the server runs.
    pub instance: u32,
    /// Attribute 1.
    pub name: String,
    /// Attribute 2: structure, dimensions, template or atomic type.
    pub symbol_type: u16,
    /// Attribute 3.
    pub address: u32,
    /// Attribute 5.
    pub object_address: u32,
    /// Attribute 6; [`Symbol::BASE_TAG`] unless an alias.
    pub software_control: u32,
    /// Attribute 7: bytes of one element.
    pub element_size: u16,
    /// Attribute 8: zero when unused.
    pub dimensions: [u32; 3],
    /// Attribute 9: 1 is a safety tag.
    pub safety: u8,
    /// Attribute 10: 0 read/write, 2 read only, 3 none.
    pub access: u8,
    /// Attribute 11.
    pub usage: u8,
}

impl Symbol {
    /// Software control of a tag that is no alias.
    pub const BASE_TAG: u32 = 0x0400_0000;

    /// Appends the value of one attribute.
    ///
    /// # Errors
    /// 0x14 for an id there is not; nothing is appended then.
    pub fn encode_attribute(&self, id: u16, out: &mut BytesMut) -> Result<(), CipStatus> {
        match id {
            1 => {
                let length = u16::try_from(self.name.len()).unwrap_or(u16::MAX);
                out.put_u16_le(length);
                out.put_slice(self.name.as_bytes().get(..usize::from(length)).unwrap_or_default());
            }
            2 => out.put_u16_le(self.symbol_type),
            3 => out.put_u32_le(self.address),
            5 => out.put_u32_le(self.object_address),
            6 => out.put_u32_le(self.software_control),
            7 => out.put_u16_le(self.element_size),
            8 => self.dimensions.iter().for_each(|dimension| out.put_u32_le(*dimension)),
            9 => out.put_u8(self.safety),
            10 => out.put_u8(self.access),
            11 => out.put_u8(self.usage),
            _ => return Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED),
        }
        Ok(())
    }

    /// Reads one entry of a Get Instance Attribute List reply whose request named `attributes` in this order. Attributes
    /// that were not asked for stay at their default; `None` if the entry is cut or an attribute is unknown.
    pub fn decode_entry(reader: &mut Reader<'_>, attributes: &[u16]) -> Option<Self> {
        let mut this = Self {
            instance: reader.u32()?,
            ..Self::default()
        };
        for id in attributes {
            match id {
                1 => {
                    let length = usize::from(reader.u16()?);
                    this.name = String::from_utf8_lossy(reader.take(length)?).into_owned();
                }
                2 => this.symbol_type = reader.u16()?,
                3 => this.address = reader.u32()?,
                5 => this.object_address = reader.u32()?,
                6 => this.software_control = reader.u32()?,
                7 => this.element_size = reader.u16()?,
                8 => this.dimensions = [reader.u32()?, reader.u32()?, reader.u32()?],
                9 => this.safety = reader.u8()?,
                10 => this.access = reader.u8()?,
                11 => this.usage = reader.u8()?,
                _ => return None,
            }
        }
        Some(this)
    }

    /// Reads all entries of a Get Instance Attribute List reply.
    pub fn decode_list(data: &[u8], attributes: &[u16]) -> Option<Vec<Self>> {
        let mut reader = Reader::new(data);
        let mut symbols = Vec::new();
        while !reader.is_empty() {
            symbols.push(Self::decode_entry(&mut reader, attributes)?);
        }
        Some(symbols)
    }
}

/// The reply of Get Instance Attribute List (0x55): the symbols with an instance of `start` or more, in ascending order,
/// as many as fit `budget` bytes (of the whole router reply); 0x06 when more follow.
///
/// 0x14 for an attribute there is not: a guessed width would spoil the rest. 0x11 when not even one entry fits.
pub fn instance_list_reply<'a>(
    symbols: impl IntoIterator<Item = &'a Symbol>,
    start: u32,
    attributes: &[u16],
    budget: usize,
) -> Reply {
    const SERVICE: u8 = service::GET_INSTANCE_ATTRIBUTE_LIST;
    if attributes.iter().any(|id| !matches!(id, 1..=3 | 5..=11)) {
        return Reply::error(SERVICE, CipStatus::ATTRIBUTE_NOT_SUPPORTED);
    }
    let mut out = BytesMut::new();
    for symbol in symbols.into_iter().filter(|symbol| symbol.instance >= start) {
        let mut entry = BytesMut::with_capacity(64);
        entry.put_u32_le(symbol.instance);
        for id in attributes {
            if let Err(status) = symbol.encode_attribute(*id, &mut entry) {
                return Reply::error(SERVICE, status);
            }
        }
        if REPLY_HEAD + out.len() + entry.len() > budget {
            return if out.is_empty() {
                Reply::error(SERVICE, CipStatus::REPLY_TOO_LARGE)
            } else {
                Reply::with_status(SERVICE, CipStatus::PARTIAL_TRANSFER, out)
            };
        }
        out.put_slice(&entry);
    }
    Reply::success(SERVICE, out)
}

/// What the Template class tells about a structure (spec/ethernet-ip.md §11).
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
    /// What a client asks for.
    pub const IDS: [u16; 4] = [4, 5, 2, 1];

    /// The reply of Get Attribute List for `ids`. Attribute 3 exists and is 0, because a stock client needs it.
    pub fn reply(self, ids: &[u16], budget: usize) -> Reply {
        let mut list = AttributeListReply::new(service::GET_ATTRIBUTE_LIST);
        for id in ids {
            match id {
                1 => list.push(*id, Ok(&self.handle.to_le_bytes())),
                2 => list.push(*id, Ok(&self.members.to_le_bytes())),
                3 => list.push(*id, Ok(&[0, 0])),
                4 => list.push(*id, Ok(&self.definition_words.to_le_bytes())),
                5 => list.push(*id, Ok(&self.size.to_le_bytes())),
                _ => list.push(*id, Err(CipStatus::ATTRIBUTE_NOT_SUPPORTED)),
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

/// One operand of a motion service (contract.md §4).
#[derive(Clone, PartialEq, Debug)]
pub enum Typed {
    /// One or more numbers of one type: SINT, INT, DINT, LINT, REAL or LREAL.
    Numbers(Elementary, Vec<Value>),
    /// A name; may be empty.
    ShortString(String),
}

/// Operands that are not laid out as they must be.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum TypedError {
    /// 0x13: the data ends inside an operand, or an operand has no elements.
    #[error("operand {operand} needs {needed} bytes, {present} are there")]
    TooLittle {
        /// Counts from 0, the motion control tag.
        operand: usize,
        /// Bytes needed for what is announced.
        needed: usize,
        /// Bytes there.
        present: usize,
    },
    /// 0x15: more operands than any instruction has.
    #[error("more than {limit} operands")]
    TooMuch {
        /// Operands accepted.
        limit: usize,
    },
    /// 0x20: neither a number nor a name.
    #[error("operand {operand} has type 0x{code:04X}, expected SINT, INT, DINT, LINT, REAL, LREAL or one SHORT_STRING")]
    WrongType {
        /// Counts from 0, the motion control tag.
        operand: usize,
        /// The type code.
        code: u16,
    },
}

impl TypedError {
    /// The general status.
    pub const fn status(self) -> CipStatus {
        match self {
            Self::TooLittle { .. } => CipStatus::NOT_ENOUGH_DATA,
            Self::TooMuch { .. } => CipStatus::TOO_MUCH_DATA,
            Self::WrongType { .. } => CipStatus::INVALID_PARAMETER,
        }
    }
}

/// Reads operands to the end of `data`: `type code u16, element count u16, elements` each. Nothing is allocated that is
/// only announced.
///
/// # Errors
/// [`TypedError`].
pub fn decode_operands(data: &[u8]) -> Result<Vec<Typed>, TypedError> {
    let mut reader = Reader::new(data);
    let mut operands = Vec::new();
    while !reader.is_empty() {
        if operands.len() == MAX_OPERANDS {
            return Err(TypedError::TooMuch { limit: MAX_OPERANDS });
        }
        let operand = decode_operand(operands.len(), &mut reader)?;
        operands.push(operand);
    }
    Ok(operands)
}

fn decode_operand(operand: usize, reader: &mut Reader<'_>) -> Result<Typed, TypedError> {
    let present = reader.remaining();
    let little = |needed| TypedError::TooLittle {
        operand,
        needed,
        present,
    };
    let code = reader.u16().ok_or_else(|| little(4))?;
    let wrong = TypedError::WrongType { operand, code };
    let elementary = match WireType::Atomic(code).elementary() {
        _ if code == SHORT_STRING => None,
        Some(number) if is_operand_type(number) => Some(number),
        _ => return Err(wrong),
    };
    let count = usize::from(reader.u16().ok_or_else(|| little(4))?);
    if count == 0 {
        return Err(little(4 + elementary.map_or(1, Elementary::size)));
    }
    if let Some(elementary) = elementary {
        let size = elementary.size();
        let bytes = reader.take(count * size).ok_or_else(|| little(4 + count * size))?;
        let values: Option<Vec<Value>> = bytes.chunks(size).map(|chunk| Value::read(elementary, chunk)).collect();
        return values.map(|values| Typed::Numbers(elementary, values)).ok_or(wrong);
    }
    if count != 1 {
        return Err(wrong);
    }
    let length = usize::from(reader.u8().ok_or_else(|| little(5))?);
    let name = reader.take(length).ok_or_else(|| little(5 + length))?;
    let name = std::str::from_utf8(name).map_err(|_| wrong)?;
    Ok(Typed::ShortString(name.to_owned()))
}

const fn is_operand_type(elementary: Elementary) -> bool {
    use Elementary::{Dint, Int, Lint, Lreal, Real, Sint};
    matches!(elementary, Sint | Int | Dint | Lint | Real | Lreal)
}

/// Appends operands, the other direction of [`decode_operands`]. A name is cut at 255 bytes, a list at 65,535 numbers;
/// a number of another type than its list's is converted.
pub fn encode_operands(operands: &[Typed], out: &mut BytesMut) {
    for operand in operands {
        match operand {
            Typed::Numbers(elementary, values) => {
                let count = u16::try_from(values.len()).unwrap_or(u16::MAX);
                out.put_u16_le(elementary.code().into());
                out.put_u16_le(count);
                for value in values.iter().take(usize::from(count)) {
                    encode_value(*elementary, *value, out);
                }
            }
            Typed::ShortString(name) => {
                out.put_u16_le(SHORT_STRING);
                out.put_u16_le(1);
                let length = u8::try_from(name.len()).unwrap_or(u8::MAX);
                out.put_u8(length);
                out.put_slice(name.as_bytes().get(..usize::from(length)).unwrap_or_default());
            }
        }
    }
}

fn encode_value(elementary: Elementary, value: Value, out: &mut BytesMut) {
    let value = value.convert(elementary);
    let mut bytes = [0_u8; 8];
    let size = elementary.size().min(bytes.len());
    // Eight bytes hold every elementary value.
    let _ = value.write(&mut bytes);
    out.put_slice(bytes.get(..size).unwrap_or_default());
}

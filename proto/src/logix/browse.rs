//! The Symbol class: the attributes of a tag, and the list of all tags (spec/ethernet-ip.md §10).
//!
//! Not here: the table of tags. Lists are cut to a budget in bytes.

use bytes::{BufMut, BytesMut};

use crate::cip::{CipStatus, REPLY_HEAD, Reply, service};
use crate::wire::Reader;

/// The attributes of a tag in the Symbol class (spec/ethernet-ip.md §10).
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
    /// that the request does not name stay at their default; `None` if the entry is cut or an attribute is unknown.
    fn decode_entry(reader: &mut Reader<'_>, attributes: &[u16]) -> Option<Self> {
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

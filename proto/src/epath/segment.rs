//! One segment of a padded path, and its bytes (CIP Vol. 1, appendix C-1; spec/ethernet-ip.md §5).
//!
//! Not here: the meaning of a sequence of segments. Segments are a whole number of 16-bit words.

use std::ops::Deref;

use bytes::{BufMut, Bytes, BytesMut};

use super::PathError;
use crate::wire::{Reader, counted};

/// One segment of a path.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Segment {
    /// `20`, `21`, `22`: class.
    Class(u32),
    /// `24`, `25`, `26`: instance.
    Instance(u32),
    /// `28`, `29`, `2A`: member, or element of an array.
    Member(u32),
    /// `2C`, `2D`, `2E`: connection point.
    ConnectionPoint(u32),
    /// `30`, `31`, `32`: attribute.
    Attribute(u32),
    /// `34 04`: electronic key.
    Key(ElectronicKey),
    /// `91`: a name.
    Symbol(SymbolName),
    /// `0p`, `1p`: the way out of a port.
    Port(PortSegment),
    /// `4x`, `5x`: network segment: type byte and its data (one byte, or counted words for `5x`).
    Network {
        /// The type byte, 0x40-0x5F.
        kind: u8,
        /// One byte for 0x40-0x4F, an even number of bytes for 0x50-0x5F.
        data: Bytes,
    },
    /// `80`: simple data, an even number of bytes, at most 510.
    Data(Bytes),
}

/// A name of one to 255 bytes, where it stands in the message.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SymbolName(Bytes);

impl SymbolName {
    /// `None`: no text.
    fn decode(name: Bytes) -> Option<Self> {
        std::str::from_utf8(&name).is_ok().then(|| Self(name))
    }
}

impl Deref for SymbolName {
    type Target = str;

    fn deref(&self) -> &str {
        // Looked at when it was made.
        std::str::from_utf8(&self.0).unwrap_or_default()
    }
}

impl<T: Into<String>> From<T> for SymbolName {
    fn from(name: T) -> Self {
        Self(name.into().into())
    }
}

/// The device that an originator expects; a zero matches every value (CIP Vol. 1, C-1.4.2).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ElectronicKey {
    /// Vendor id.
    pub vendor: u16,
    /// Device type.
    pub device_type: u16,
    /// Product code.
    pub product_code: u16,
    /// Major revision in bits 0-6, bit 7: a compatible device will do.
    pub major: u8,
    /// Minor revision.
    pub minor: u8,
}

/// Port and link address of a route's hop.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PortSegment {
    /// 1 is the backplane, 2 usually Ethernet; never 0.
    pub port: u16,
    /// One byte (a slot) or a longer address (an IP address as text); 1 to 255 bytes.
    pub link: Bytes,
}

impl PortSegment {
    /// Slot `slot` of the backplane: `01 ss`.
    pub fn backplane(slot: u8) -> Self {
        Self {
            port: 1,
            link: Bytes::copy_from_slice(&[slot]),
        }
    }

    /// The slot, if this is the backplane.
    pub fn backplane_slot(&self) -> Option<u8> {
        match (self.port, self.link.as_ref()) {
            (1, [slot]) => Some(*slot),
            _ => None,
        }
    }
}

/// `Ok(None)`: truncated.
pub(super) fn decode_segment(kind: u8, reader: &mut Reader<'_>, bytes: &Bytes) -> Result<Option<Segment>, PathError> {
    let unknown = PathError::Unknown { kind };
    Ok(match kind {
        0x01..=0x0E => reader.take(1).map(|link| port(kind.into(), link, bytes)),
        0x0F => extended_port(reader).map(|(number, link)| port(number, link, bytes)),
        0x11..=0x1F => {
            let segment = long_port(kind, reader).map(|(number, link)| port(number, link, bytes));
            if matches!(&segment, Some(Segment::Port(p)) if p.link.is_empty()) {
                return Err(unknown);
            }
            segment
        }
        0x34 => match reader.u8() {
            Some(4) => electronic_key(reader).map(Segment::Key),
            Some(_) => return Err(unknown),
            None => None,
        },
        0x20..=0x33 => {
            let id = match kind & 0x03 {
                0 => reader.u8().map(u32::from),
                1 => reader.u8().and_then(|_pad| reader.u16()).map(u32::from),
                2 => reader.u8().and_then(|_pad| reader.u32()),
                _ => return Err(unknown),
            };
            id.map(|id| match kind & 0xFC {
                0x20 => Segment::Class(id),
                0x24 => Segment::Instance(id),
                0x28 => Segment::Member(id),
                0x2C => Segment::ConnectionPoint(id),
                _ => Segment::Attribute(id),
            })
        }
        0x40..=0x4F => reader.take(1).map(|data| Segment::Network {
            kind,
            data: bytes.slice_ref(data),
        }),
        0x50..=0x5F => words(reader).map(|data| Segment::Network {
            kind,
            data: bytes.slice_ref(data),
        }),
        0x80 => words(reader).map(|data| Segment::Data(bytes.slice_ref(data))),
        0x91 => match symbol(reader) {
            Some([]) => return Err(PathError::Symbol),
            Some(name) => {
                let name = SymbolName::decode(bytes.slice_ref(name)).ok_or(PathError::Symbol)?;
                Some(Segment::Symbol(name))
            }
            None => None,
        },
        _ => return Err(unknown),
    })
}

fn port(number: u16, link: &[u8], bytes: &Bytes) -> Segment {
    Segment::Port(PortSegment {
        port: number,
        link: bytes.slice_ref(link),
    })
}

fn extended_port<'a>(reader: &mut Reader<'a>) -> Option<(u16, &'a [u8])> {
    let number = reader.u16()?;
    Some((number, reader.take(1)?))
}

fn long_port<'a>(kind: u8, reader: &mut Reader<'a>) -> Option<(u16, &'a [u8])> {
    let length = usize::from(reader.u8()?);
    let number = if kind == 0x1F {
        reader.u16()?
    } else {
        u16::from(kind & 0x0F)
    };
    Some((number, padded(length, reader)?))
}

fn electronic_key(reader: &mut Reader<'_>) -> Option<ElectronicKey> {
    Some(ElectronicKey {
        vendor: reader.u16()?,
        device_type: reader.u16()?,
        product_code: reader.u16()?,
        major: reader.u8()?,
        minor: reader.u8()?,
    })
}

fn words<'a>(reader: &mut Reader<'a>) -> Option<&'a [u8]> {
    let count = usize::from(reader.u8()?);
    reader.take(2 * count)
}

fn symbol<'a>(reader: &mut Reader<'a>) -> Option<&'a [u8]> {
    let length = usize::from(reader.u8()?);
    padded(length, reader)
}

/// `length` bytes, and one more if that is odd.
fn padded<'a>(length: usize, reader: &mut Reader<'a>) -> Option<&'a [u8]> {
    let bytes = reader.take(length)?;
    reader.take(length % 2)?;
    Some(bytes)
}

pub(super) fn encode_segment(segment: &Segment, out: &mut BytesMut) {
    match segment {
        Segment::Class(id) => encode_logical(0x20, *id, out),
        Segment::Instance(id) => encode_logical(0x24, *id, out),
        Segment::Member(id) => encode_logical(0x28, *id, out),
        Segment::ConnectionPoint(id) => encode_logical(0x2C, *id, out),
        Segment::Attribute(id) => encode_logical(0x30, *id, out),
        Segment::Key(key) => {
            out.put_slice(&[0x34, 0x04]);
            out.put_u16_le(key.vendor);
            out.put_u16_le(key.device_type);
            out.put_u16_le(key.product_code);
            out.put_slice(&[key.major, key.minor]);
        }
        Segment::Symbol(name) => {
            let (length, name) = counted(name.as_bytes());
            out.put_slice(&[0x91, length]);
            out.put_slice(name);
            out.put_bytes(0, name.len() % 2);
        }
        Segment::Port(PortSegment { port, link }) => {
            // The low nibble 0 is no port: port 0 has the extended form too.
            let low = u8::try_from(*port).ok().filter(|port| (1..0x0F).contains(port));
            match (low, link.as_ref()) {
                (Some(port), [link]) => out.put_slice(&[port, *link]),
                (None, [link]) => {
                    out.put_u8(0x0F);
                    out.put_u16_le(*port);
                    out.put_u8(*link);
                }
                (low, link) => {
                    let (length, link) = counted(link);
                    out.put_slice(&[0x10 | low.unwrap_or(0x0F), length]);
                    if low.is_none() {
                        out.put_u16_le(*port);
                    }
                    out.put_slice(link);
                    out.put_bytes(0, link.len() % 2);
                }
            }
        }
        Segment::Network {
            kind: kind @ 0x50..,
            data,
        } => encode_words(*kind, data, out),
        Segment::Network { kind, data } => out.put_slice(&[*kind, data.first().copied().unwrap_or_default()]),
        Segment::Data(data) => encode_words(0x80, data, out),
    }
}

fn encode_logical(kind: u8, id: u32, out: &mut BytesMut) {
    if let Ok(id) = u8::try_from(id) {
        out.put_slice(&[kind, id]);
    } else if let Ok(id) = u16::try_from(id) {
        out.put_slice(&[kind | 1, 0]);
        out.put_u16_le(id);
    } else {
        out.put_slice(&[kind | 2, 0]);
        out.put_u32_le(id);
    }
}

fn encode_words(kind: u8, data: &[u8], out: &mut BytesMut) {
    let words = u8::try_from(data.len() / 2).unwrap_or(u8::MAX);
    out.put_slice(&[kind, words]);
    out.put_slice(data.get(..2 * usize::from(words)).unwrap_or_default());
}

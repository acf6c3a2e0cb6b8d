//! Padded EPATHs: the segments that say which object, attribute, tag or route a message is for
//! (CIP Vol. 1, appendix C-1; spec/ethernet-ip.md §5), and what a request's path means ([`Target`]).
//!
//! Not the packed encoding, which no request uses. A path's length is in words; it is bounded by [`MAX_WORDS`].

use arcline_tag::{PathSegment, TagPath};
use bytes::{BufMut, Bytes, BytesMut};

use crate::cip::CipStatus;
use crate::wire::Reader;

/// The longest path a length byte can announce.
pub const MAX_WORDS: usize = 255;
/// The deepest nesting of names that is followed.
pub const MAX_SYMBOLS: usize = 32;

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
    /// `91`: a name; one to 255 bytes of UTF-8.
    Symbol(String),
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

/// Which device an originator expects; zeros match anything (CIP Vol. 1, C-1.4.2).
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

/// A path that cannot be understood.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum PathError {
    /// The path says it is longer than the bytes that are there.
    #[error("path of {claimed} bytes, {present} are there")]
    Size {
        /// Bytes claimed.
        claimed: usize,
        /// Bytes there.
        present: usize,
    },
    /// A segment runs past the path.
    #[error("segment 0x{kind:02X} runs past the path")]
    Truncated {
        /// Segment type byte.
        kind: u8,
    },
    /// A segment type or format that is not known.
    #[error("segment type 0x{kind:02X} is not known")]
    Unknown {
        /// Segment type byte.
        kind: u8,
    },
    /// A name that is empty, no text, or not a tag name.
    #[error("a symbol segment does not hold a name")]
    Symbol,
    /// More names inside each other, or a longer path, than is followed.
    #[error("more than {limit} segments")]
    TooDeep {
        /// What is followed.
        limit: usize,
    },
    /// A class or attribute beyond 16 bits: there is none.
    #[error("class or attribute {value} is beyond 65535")]
    OutOfRange {
        /// The id asked for.
        value: u32,
    },
    /// Segments in an order that means nothing (two classes, an instance without class).
    #[error("segments in an order that means nothing")]
    Order,
}

impl PathError {
    /// The general status a request with such a path is refused with.
    pub fn status(self) -> CipStatus {
        match self {
            Self::Size { .. } => CipStatus::PATH_SIZE_INVALID,
            Self::OutOfRange { .. } => CipStatus::PATH_DESTINATION_UNKNOWN.with(0),
            _ => CipStatus::PATH_SEGMENT_ERROR.with(0),
        }
    }
}

/// A padded path.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Epath(pub Vec<Segment>);

impl Epath {
    /// Class and instance.
    pub fn object(class: u16, instance: u32) -> Self {
        Self(vec![Segment::Class(class.into()), Segment::Instance(instance)])
    }

    /// Class, instance and attribute.
    pub fn attribute(class: u16, instance: u32, attribute: u16) -> Self {
        let mut this = Self::object(class, instance);
        this.0.push(Segment::Attribute(attribute.into()));
        this
    }

    /// A name, not looked into.
    pub fn symbol(name: &str) -> Self {
        Self(vec![Segment::Symbol(name.to_owned())])
    }

    /// A tag's path: names as symbols, indices as members. A final bit is not on the wire (spec/ethernet-ip.md §5):
    /// clients read or write the whole integer; it comes back as the second value.
    pub fn from_tag(path: &TagPath) -> (Self, Option<u8>) {
        let mut bit = None;
        let mut segments = Vec::with_capacity(path.0.len());
        for segment in &path.0 {
            match segment {
                PathSegment::Symbol(name) => segments.push(Segment::Symbol(name.clone())),
                PathSegment::Element(index) => segments.push(Segment::Member(*index)),
                PathSegment::Bit(number) => bit = Some(*number),
            }
        }
        (Self(segments), bit)
    }

    /// Reads all of `bytes` as a path.
    ///
    /// # Errors
    /// Any [`PathError`] but `Order` and `OutOfRange`, which only [`Target`] can tell.
    pub fn decode(bytes: &Bytes) -> Result<Self, PathError> {
        if bytes.len() > 2 * MAX_WORDS {
            return Err(PathError::TooDeep { limit: MAX_WORDS });
        }
        let mut reader = Reader::new(bytes);
        let mut segments = Vec::new();
        while let Some(kind) = reader.u8() {
            let segment = decode_segment(kind, &mut reader, bytes)?;
            segments.push(segment.ok_or(PathError::Truncated { kind })?);
        }
        Ok(Self(segments))
    }

    /// Appends the path without a length. Every id takes the shortest form that holds it.
    pub fn encode(&self, out: &mut BytesMut) {
        for segment in &self.0 {
            encode_segment(segment, out);
        }
    }

    /// The path's bytes, without a length.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::new();
        self.encode(&mut out);
        out.freeze()
    }

    /// Appends `size u8` (words) and the path.
    ///
    /// # Errors
    /// [`PathError::TooDeep`] if it needs more than [`MAX_WORDS`]; nothing is appended then.
    pub fn encode_sized(&self, out: &mut BytesMut) -> Result<(), PathError> {
        let bytes = self.to_bytes();
        let words = u8::try_from(bytes.len() / 2).map_err(|_| PathError::TooDeep { limit: MAX_WORDS })?;
        out.put_u8(words);
        out.put_slice(&bytes);
        Ok(())
    }

    /// Whether the path is exactly class and instance, in any of the id forms.
    pub fn is_object(&self, class: u16, instance: u32) -> bool {
        matches!(self.0.as_slice(), [Segment::Class(c), Segment::Instance(i)] if *c == u32::from(class) && *i == instance)
    }

    /// Takes the leading port segments off: route and rest.
    pub fn split_route(&self) -> (&[Segment], &[Segment]) {
        let ports = self
            .0
            .iter()
            .take_while(|segment| matches!(segment, Segment::Port(_)))
            .count();
        self.0.split_at(ports)
    }
}

/// `Ok(None)`: truncated.
fn decode_segment(kind: u8, reader: &mut Reader<'_>, bytes: &Bytes) -> Result<Option<Segment>, PathError> {
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
                let name = std::str::from_utf8(name).map_err(|_| PathError::Symbol)?;
                Some(Segment::Symbol(name.to_owned()))
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
    let link = reader.take(length)?;
    if length % 2 == 1 {
        reader.u8()?;
    }
    Some((number, link))
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
    let name = reader.take(length)?;
    if length % 2 == 1 {
        reader.u8()?;
    }
    Some(name)
}

fn encode_segment(segment: &Segment, out: &mut BytesMut) {
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

/// As much as a length byte can count.
fn counted(bytes: &[u8]) -> (u8, &[u8]) {
    let length = u8::try_from(bytes.len()).unwrap_or(u8::MAX);
    (length, bytes.get(..usize::from(length)).unwrap_or(bytes))
}

/// What a request is for: a name, an object, or an object within the scope of a name.
///
/// `91 "A" 28 03 91 "B"` is `symbols` A, 3, B. `20 6B 25 iiii 28 03` is class 0x6B, that instance, `members` 3.
/// `91 "Program:P" 20 6B 24 00` is `symbols` Program:P and class 0x6B.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Target {
    /// Names and indices in front of any class.
    pub symbols: Vec<PathSegment>,
    /// Class.
    pub class: Option<u16>,
    /// Instance; 0 is the class itself.
    pub instance: Option<u32>,
    /// Attribute.
    pub attribute: Option<u16>,
    /// Connection points, in order.
    pub connection_points: Vec<u32>,
    /// Names and indices behind the instance.
    pub members: Vec<PathSegment>,
}

impl Target {
    /// Reads the meaning of a request path. A name such as `A.B[3]` in one symbol segment is split. Port segments, keys,
    /// network and data segments are skipped: they belong to routes and connections.
    ///
    /// # Errors
    /// `Order`, `OutOfRange`, `Symbol` and `TooDeep`; see [`PathError::status`].
    pub fn new(path: &Epath) -> Result<Self, PathError> {
        let mut this = Self::default();
        for segment in &path.0 {
            match segment {
                Segment::Class(id) if this.class.is_none() => this.class = Some(narrow(*id)?),
                Segment::Instance(id) if this.class.is_some() && this.instance.is_none() => this.instance = Some(*id),
                Segment::Attribute(id) if this.class.is_some() && this.attribute.is_none() => {
                    this.attribute = Some(narrow(*id)?);
                }
                Segment::Class(_) | Segment::Instance(_) | Segment::Attribute(_) => {
                    return Err(PathError::Order);
                }
                Segment::ConnectionPoint(id) => this.connection_points.push(*id),
                Segment::Member(index) => this.names().push(PathSegment::Element(*index)),
                Segment::Symbol(name) => {
                    let names = split_symbol(name)?;
                    this.names().extend(names);
                }
                Segment::Key(_) | Segment::Port(_) | Segment::Network { .. } | Segment::Data(_) => {}
            }
            let symbols = |names: &[PathSegment]| names.iter().filter(|n| matches!(n, PathSegment::Symbol(_))).count();
            if symbols(&this.symbols) + symbols(&this.members) > MAX_SYMBOLS {
                return Err(PathError::TooDeep { limit: MAX_SYMBOLS });
            }
        }
        if matches!(
            this.symbols.first(),
            Some(PathSegment::Element(_) | PathSegment::Bit(_))
        ) {
            return Err(PathError::Order);
        }
        Ok(this)
    }

    /// The tag meant by name alone; `None` if the path goes by class or is empty.
    pub fn tag_path(&self) -> Option<TagPath> {
        (self.class.is_none() && !self.symbols.is_empty()).then(|| TagPath(self.symbols.clone()))
    }

    /// The first name, if the path begins with one.
    pub fn first_symbol(&self) -> Option<&str> {
        match self.symbols.first() {
            Some(PathSegment::Symbol(name)) => Some(name),
            _ => None,
        }
    }

    fn names(&mut self) -> &mut Vec<PathSegment> {
        if self.class.is_some() {
            &mut self.members
        } else {
            &mut self.symbols
        }
    }
}

fn narrow(value: u32) -> Result<u16, PathError> {
    u16::try_from(value).map_err(|_| PathError::OutOfRange { value })
}

/// A plain name stays as it is; only one with dots or brackets is taken apart.
fn split_symbol(name: &str) -> Result<Vec<PathSegment>, PathError> {
    if name.contains(['.', '[']) {
        let path: TagPath = name.parse().map_err(|_| PathError::Symbol)?;
        Ok(path.0)
    } else {
        Ok(vec![PathSegment::Symbol(name.to_owned())])
    }
}

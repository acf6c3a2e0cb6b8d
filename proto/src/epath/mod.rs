//! Padded EPATHs: the segments that say which object, attribute, tag or route a message is for
//! (CIP Vol. 1, appendix C-1; spec/ethernet-ip.md §5), and the meaning of a request's path ([`Target`]).
//!
//! Not here: the packed encoding, which no request uses. A path's length is in words; it is bounded by [`MAX_WORDS`].

mod segment;
mod target;

use arcline_tag::{PathSegment, TagPath};
use bytes::{BufMut, Bytes, BytesMut};

use crate::status::CipStatus;
use crate::wire::Reader;

pub use segment::{ElectronicKey, PortSegment, Segment, SymbolName};
use segment::{decode_segment, encode_segment};
pub use target::{MAX_SYMBOLS, Target};

/// The longest path a length byte can announce.
pub const MAX_WORDS: usize = 255;

/// Segments of most paths: a name and an element, or class and instance.
const TYPICAL: usize = 2;

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
    /// More names inside each other, or a longer path, than the limit.
    #[error("more than {limit} segments")]
    TooDeep {
        /// The most segments of a path.
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
        Self(vec![Segment::Symbol(name.into())])
    }

    /// A tag's path: names as symbols, indices as members. A final bit is not on the wire (spec/ethernet-ip.md §5):
    /// clients read or write the whole integer; it comes back as the second value.
    pub fn from_tag(path: &TagPath) -> (Self, Option<u8>) {
        let mut bit = None;
        let mut segments = Vec::with_capacity(path.0.len());
        for segment in &path.0 {
            match segment {
                PathSegment::Symbol(name) => segments.push(Segment::Symbol(name.as_str().into())),
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
        Self::read_all(bytes, bytes)
    }

    /// Reads all of `path`, which is a part of `bytes`.
    fn read_all(path: &[u8], bytes: &Bytes) -> Result<Self, PathError> {
        let mut reader = Reader::new(path);
        let mut segments = Vec::with_capacity(TYPICAL);
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
        let (words, bytes) = self.to_sized_bytes()?;
        out.put_u8(words);
        out.put_slice(&bytes);
        Ok(())
    }

    /// Whether the path is exactly class and instance, in any of the id forms.
    pub fn is_object(&self, class: u16, instance: u32) -> bool {
        matches!(self.0.as_slice(), [Segment::Class(c), Segment::Instance(i)] if *c == u32::from(class) && *i == instance)
    }

    /// Reads a path of `words` 16-bit words off the front of `reader`, which is somewhere in `bytes`.
    ///
    /// # Errors
    /// As [`Self::decode`]; [`PathError::Size`] if fewer bytes are left.
    pub(crate) fn read(words: u8, reader: &mut Reader<'_>, bytes: &Bytes) -> Result<Self, PathError> {
        let claimed = 2 * usize::from(words);
        let present = reader.remaining();
        let path = reader.take(claimed).ok_or(PathError::Size { claimed, present })?;
        Self::read_all(path, bytes)
    }

    /// The path's length in words, and its bytes.
    ///
    /// # Errors
    /// As [`Self::encode_sized`].
    pub(crate) fn to_sized_bytes(&self) -> Result<(u8, Bytes), PathError> {
        let bytes = self.to_bytes();
        let words = u8::try_from(bytes.len() / 2).map_err(|_| PathError::TooDeep { limit: MAX_WORDS })?;
        Ok((words, bytes))
    }
}

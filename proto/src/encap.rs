//! The encapsulation layer: 24-byte header, commands, status, and the frames of the session services
//! (CIP Vol. 2, chapter 2; spec/ethernet-ip.md §2).
//!
//! Not here: the common packet format inside SendRRData and SendUnitData ([`crate::cpf`]) and the rules of a session
//! ([`crate::connection`]). All fields are little-endian except socket addresses.

use bytes::{Buf, BufMut, Bytes, BytesMut};
use std::fmt;

use crate::wire::Reader;

/// The largest `length` the field can claim in a legal frame.
pub const MAX_DATA: usize = 65_511;
/// The limit a server puts on a frame's data unless it is set otherwise (spec/ethernet-ip.md §18).
pub const DEFAULT_LIMIT: usize = 8 * 1024;
/// The only version of the encapsulation protocol there is.
pub const PROTOCOL_VERSION: u16 = 1;

/// The command of a frame (CIP Vol. 2, table 2-3.2).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Command(pub u16);

impl Command {
    /// No operation: never answered.
    pub const NOP: Self = Self(0x0000);
    /// The kinds of communication that the target supports.
    pub const LIST_SERVICES: Self = Self(0x0004);
    /// The identity of the target.
    pub const LIST_IDENTITY: Self = Self(0x0063);
    /// Non-CIP interfaces: there are none.
    pub const LIST_INTERFACES: Self = Self(0x0064);
    /// Opens the session.
    pub const REGISTER_SESSION: Self = Self(0x0065);
    /// Closes the session and the socket: never answered.
    pub const UNREGISTER_SESSION: Self = Self(0x0066);
    /// Unconnected message (UCMM).
    pub const SEND_RR_DATA: Self = Self(0x006F);
    /// Message on a class 3 connection.
    pub const SEND_UNIT_DATA: Self = Self(0x0070);
}

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match *self {
            Self::NOP => "NOP",
            Self::LIST_SERVICES => "ListServices",
            Self::LIST_IDENTITY => "ListIdentity",
            Self::LIST_INTERFACES => "ListInterfaces",
            Self::REGISTER_SESSION => "RegisterSession",
            Self::UNREGISTER_SESSION => "UnRegisterSession",
            Self::SEND_RR_DATA => "SendRRData",
            Self::SEND_UNIT_DATA => "SendUnitData",
            Self(code) => return write!(f, "command 0x{code:04X}"),
        };
        f.write_str(name)
    }
}

/// Status of an encapsulation reply (CIP Vol. 2, table 2-3.3).
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct EncapStatus(pub u32);

impl EncapStatus {
    /// Done.
    pub const SUCCESS: Self = Self(0x0000);
    /// Unknown command, or a second RegisterSession.
    pub const INVALID_COMMAND: Self = Self(0x0001);
    /// The target is out of memory.
    pub const NO_MEMORY: Self = Self(0x0002);
    /// The data of the command cannot be understood.
    pub const INCORRECT_DATA: Self = Self(0x0003);
    /// The session handle is not the one of this socket.
    pub const INVALID_SESSION: Self = Self(0x0064);
    /// The length does not fit the command.
    pub const INVALID_LENGTH: Self = Self(0x0065);
    /// RegisterSession asked for another protocol version.
    pub const UNSUPPORTED_VERSION: Self = Self(0x0069);
    /// This port does not offer the service (plain text where TLS is demanded).
    pub const NOT_ALLOWED_ON_PORT: Self = Self(0x006A);
}

impl fmt::Display for EncapStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match *self {
            Self::SUCCESS => "success",
            Self::INVALID_COMMAND => "invalid or unsupported command",
            Self::NO_MEMORY => "out of memory",
            Self::INCORRECT_DATA => "poorly formed or incorrect data",
            Self::INVALID_SESSION => "invalid session handle",
            Self::INVALID_LENGTH => "invalid length",
            Self::UNSUPPORTED_VERSION => "unsupported protocol version",
            Self::NOT_ALLOWED_ON_PORT => "service not allowed on this port",
            Self(code) => return write!(f, "encapsulation status 0x{code:04X}"),
        };
        write!(f, "encapsulation status 0x{:04X}: {text}", self.0)
    }
}

/// Names a session on its TCP connection; never zero once registered.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default)]
pub struct SessionHandle(pub u32);

/// Eight bytes a client sends with a request to recognise the reply by; echoed byte for byte.
pub type SenderContext = [u8; 8];

/// The 24 bytes in front of every frame (CIP Vol. 2, 2-3.1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Header {
    /// The request.
    pub command: Command,
    /// Bytes that follow the header.
    pub length: u16,
    /// Session, zero before there is one.
    pub session: SessionHandle,
    /// Zero in requests.
    pub status: EncapStatus,
    /// The client's mark.
    pub context: SenderContext,
    /// Must be zero.
    pub options: u32,
}

impl Header {
    /// Bytes of a header.
    pub const LEN: usize = 24;

    /// Reads the header's fields.
    pub fn from_bytes(bytes: &[u8; Self::LEN]) -> Self {
        let [c0, c1, l0, l1, h0, h1, h2, h3, s0, s1, s2, s3, rest @ ..] = *bytes;
        let [x0, x1, x2, x3, x4, x5, x6, x7, o0, o1, o2, o3] = rest;
        Self {
            command: Command(u16::from_le_bytes([c0, c1])),
            length: u16::from_le_bytes([l0, l1]),
            session: SessionHandle(u32::from_le_bytes([h0, h1, h2, h3])),
            status: EncapStatus(u32::from_le_bytes([s0, s1, s2, s3])),
            context: [x0, x1, x2, x3, x4, x5, x6, x7],
            options: u32::from_le_bytes([o0, o1, o2, o3]),
        }
    }

    /// Appends the header's 24 bytes.
    pub fn encode(&self, out: &mut BytesMut) {
        out.put_u16_le(self.command.0);
        out.put_u16_le(self.length);
        out.put_u32_le(self.session.0);
        out.put_u32_le(self.status.0);
        out.put_slice(&self.context);
        out.put_u32_le(self.options);
    }
}

/// A whole frame: header and data. `header.length` always equals `data.len()` when it came from this crate.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct EncapFrame {
    /// The 24 bytes in front.
    pub header: Header,
    /// The data behind the header.
    pub data: Bytes,
}

impl EncapFrame {
    /// A request frame.
    ///
    /// Data beyond [`MAX_DATA`] cannot be carried and is cut; no codec of this crate makes that much.
    pub fn request(command: Command, session: SessionHandle, context: SenderContext, data: Bytes) -> Self {
        let header = Header {
            command,
            length: 0,
            session,
            status: EncapStatus::SUCCESS,
            context,
            options: 0,
        };
        Self::with(header, data)
    }

    /// The reply to a frame with `header`: command, session and context are echoed.
    pub fn reply(header: &Header, data: Bytes) -> Self {
        Self::with(
            Header {
                status: EncapStatus::SUCCESS,
                options: 0,
                ..*header
            },
            data,
        )
    }

    /// The refusal of a frame with `header`: no data.
    pub fn error(header: &Header, status: EncapStatus) -> Self {
        Self::with(
            Header {
                status,
                options: 0,
                ..*header
            },
            Bytes::new(),
        )
    }

    fn with(header: Header, mut data: Bytes) -> Self {
        data.truncate(MAX_DATA);
        let length = u16::try_from(data.len()).unwrap_or(u16::MAX);
        Self {
            header: Header { length, ..header },
            data,
        }
    }

    /// Appends the frame to `out`.
    pub fn encode(&self, out: &mut BytesMut) {
        out.reserve(Header::LEN + self.data.len());
        self.header.encode(out);
        out.put_slice(&self.data);
    }

    /// The frame as bytes of its own.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(Header::LEN + self.data.len());
        self.encode(&mut out);
        out.freeze()
    }
}

/// A stream that cannot be read on.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum EncapFrameError {
    /// The peer announced more data than is accepted.
    #[error("{} announces {claimed} bytes, accepted are at most {limit}", header.command)]
    TooLong {
        /// The offending header, to answer it with 0x0065 before closing.
        header: Header,
        /// Bytes announced.
        claimed: usize,
        /// Bytes accepted.
        limit: usize,
    },
}

/// Cuts a byte stream into frames.
#[derive(Clone, Copy, Debug)]
pub struct FrameDecoder {
    limit: usize,
}

impl Default for FrameDecoder {
    fn default() -> Self {
        Self::new(DEFAULT_LIMIT)
    }
}

impl FrameDecoder {
    /// A decoder that accepts up to `limit` bytes behind a header (at most [`MAX_DATA`]).
    pub fn new(limit: usize) -> Self {
        Self {
            limit: limit.min(MAX_DATA),
        }
    }

    /// Bytes accepted behind a header.
    pub const fn limit(&self) -> usize {
        self.limit
    }

    /// Takes the next frame off the front of `buf` (CIP Vol. 2, 2-3.1).
    ///
    /// `Ok(None)` asks for more bytes and leaves `buf` as it was. No claimed length is ever allocated: the data is a
    /// slice of the bytes that have arrived.
    ///
    /// # Errors
    /// [`EncapFrameError::TooLong`]; after it the stream cannot be resumed.
    pub fn decode(&self, buf: &mut BytesMut) -> Result<Option<EncapFrame>, EncapFrameError> {
        let Some(header) = buf.first_chunk::<{ Header::LEN }>() else {
            return Ok(None);
        };
        let header = Header::from_bytes(header);
        let claimed = usize::from(header.length);
        if claimed > self.limit {
            return Err(EncapFrameError::TooLong {
                header,
                claimed,
                limit: self.limit,
            });
        }
        if buf.len() < Header::LEN + claimed {
            return Ok(None);
        }
        buf.advance(Header::LEN);
        Ok(Some(EncapFrame {
            header,
            data: buf.split_to(claimed).freeze(),
        }))
    }

    /// Reads a datagram that must hold exactly one frame, or more than it: surplus is ignored, a shortfall is `None`.
    pub fn decode_datagram(&self, datagram: &[u8]) -> Option<EncapFrame> {
        let mut reader = Reader::new(datagram);
        let header = Header::from_bytes(&reader.array::<{ Header::LEN }>()?);
        let claimed = usize::from(header.length);
        if claimed > self.limit {
            return None;
        }
        let data = Bytes::copy_from_slice(reader.take(claimed)?);
        Some(EncapFrame { header, data })
    }
}

/// Data of RegisterSession, both ways: `version u16, options u16` (CIP Vol. 2, 2-4.4).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct RegisterSession {
    /// Protocol version, 1.
    pub version: u16,
    /// Option flags, 0.
    pub options: u16,
}

impl RegisterSession {
    /// The only one that is in use: version 1, no options.
    pub const CURRENT: Self = Self {
        version: PROTOCOL_VERSION,
        options: 0,
    };

    /// Reads the four bytes; `None` unless they are exactly four.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        let this = Self {
            version: reader.u16()?,
            options: reader.u16()?,
        };
        reader.is_empty().then_some(this)
    }

    /// The four bytes.
    pub fn to_bytes(self) -> Bytes {
        let mut out = BytesMut::with_capacity(4);
        out.put_u16_le(self.version);
        out.put_u16_le(self.options);
        out.freeze()
    }
}

/// The one entry of a ListServices reply (CIP Vol. 2, 2-4.6).
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Service {
    /// Version of the encapsulation protocol.
    pub version: u16,
    /// Bit 5: CIP over TCP; bit 8: class 0 and 1 over UDP.
    pub capability: u16,
    /// Up to 16 characters.
    pub name: String,
}

impl Service {
    /// CIP over TCP.
    pub const TCP: u16 = 0x0020;
    /// Class 0 and 1 connections over UDP.
    pub const UDP_IO: u16 = 0x0100;

    /// "Communications" with the given capability bits.
    pub fn communications(capability: u16) -> Self {
        Self {
            version: PROTOCOL_VERSION,
            capability,
            name: "Communications".to_owned(),
        }
    }

    /// Appends the 20 bytes of the item's data.
    pub fn encode(&self, out: &mut BytesMut) {
        out.put_u16_le(self.version);
        out.put_u16_le(self.capability);
        let mut name = [0_u8; 16];
        for (to, from) in name.iter_mut().zip(self.name.bytes()) {
            *to = from;
        }
        out.put_slice(&name);
    }

    /// Reads the 20 bytes of the item's data; bytes that are no UTF-8 are replaced.
    pub fn decode(data: &[u8]) -> Option<Self> {
        let mut reader = Reader::new(data);
        let version = reader.u16()?;
        let capability = reader.u16()?;
        let name = reader.array::<16>()?;
        let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
        Some(Self {
            version,
            capability,
            name: String::from_utf8_lossy(name).into_owned(),
        })
    }
}

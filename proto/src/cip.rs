//! CIP messages: router request and reply (CIP Vol. 1, 2-4), the attribute list services, and the Multiple Service
//! Packet (spec/ethernet-ip.md §4, §9.1, §13). Status codes are in [`crate::status`].
//!
//! Not what a service does. Surplus bytes behind a request's data are the service's business, and most must ignore them.

use bytes::{BufMut, Bytes, BytesMut};

use crate::epath::{Epath, PathError};
pub use crate::status::CipStatus;
use crate::wire::Reader;

/// Class ids every device has, and those of a Logix controller (spec/ethernet-ip.md §13).
pub mod class {
    /// Identity.
    pub const IDENTITY: u16 = 0x01;
    /// Message Router.
    pub const MESSAGE_ROUTER: u16 = 0x02;
    /// Assembly.
    pub const ASSEMBLY: u16 = 0x04;
    /// Connection Manager.
    pub const CONNECTION_MANAGER: u16 = 0x06;
    /// Quality of service.
    pub const QOS: u16 = 0x48;
    /// Program name.
    pub const PROGRAM_NAME: u16 = 0x64;
    /// Program.
    pub const PROGRAM: u16 = 0x68;
    /// Symbol: the tags.
    pub const SYMBOL: u16 = 0x6B;
    /// Template: the structures.
    pub const TEMPLATE: u16 = 0x6C;
    /// Wall clock time.
    pub const WALL_CLOCK: u16 = 0x8B;
    /// Change counters of the tag table.
    pub const CHANGE_DETECTION: u16 = 0xAC;
    /// Port.
    pub const PORT: u16 = 0xF4;
    /// TCP/IP interface.
    pub const TCP_IP: u16 = 0xF5;
    /// Ethernet link.
    pub const ETHERNET_LINK: u16 = 0xF6;
}

/// Service codes (CIP Vol. 1, appendix A; the class-specific ones of spec/ethernet-ip.md §7, §9, §10).
pub mod service {
    /// Get Attributes All.
    pub const GET_ATTRIBUTES_ALL: u8 = 0x01;
    /// Set Attributes All.
    pub const SET_ATTRIBUTES_ALL: u8 = 0x02;
    /// Get Attribute List.
    pub const GET_ATTRIBUTE_LIST: u8 = 0x03;
    /// Set Attribute List.
    pub const SET_ATTRIBUTE_LIST: u8 = 0x04;
    /// Reset.
    pub const RESET: u8 = 0x05;
    /// Multiple Service Packet.
    pub const MULTIPLE_SERVICE_PACKET: u8 = 0x0A;
    /// Get Attribute Single.
    pub const GET_ATTRIBUTE_SINGLE: u8 = 0x0E;
    /// Set Attribute Single.
    pub const SET_ATTRIBUTE_SINGLE: u8 = 0x10;
    /// Read Tag; on class 0x6C: read a template's definition.
    pub const READ_TAG: u8 = 0x4C;
    /// Write Tag.
    pub const WRITE_TAG: u8 = 0x4D;
    /// Read-Modify-Write Tag; on class 6: Forward Close.
    pub const READ_MODIFY_WRITE_TAG: u8 = 0x4E;
    /// Read Tag Fragmented; on class 6: Unconnected Send.
    pub const READ_TAG_FRAGMENTED: u8 = 0x52;
    /// Write Tag Fragmented.
    pub const WRITE_TAG_FRAGMENTED: u8 = 0x53;
    /// Get Instance Attribute List.
    pub const GET_INSTANCE_ATTRIBUTE_LIST: u8 = 0x55;
    /// Forward Close, on class 6.
    pub const FORWARD_CLOSE: u8 = 0x4E;
    /// Unconnected Send, on class 6.
    pub const UNCONNECTED_SEND: u8 = 0x52;
    /// Forward Open, on class 6.
    pub const FORWARD_OPEN: u8 = 0x54;
    /// Large Forward Open, on class 6.
    pub const LARGE_FORWARD_OPEN: u8 = 0x5B;
    /// Set in the service code of a reply.
    pub const REPLY: u8 = 0x80;
}

/// Bytes of a reply without additional status and data.
pub const REPLY_HEAD: usize = 4;
/// Requests accepted in one Multiple Service Packet.
pub const MAX_SERVICES: usize = 256;
/// Attributes accepted in one attribute list.
pub const MAX_ATTRIBUTES: usize = 256;

/// A message router request: `service u8, path size u8 (words), path, data`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Request {
    /// Service code, bit 7 clear.
    pub service: u8,
    /// What it is for.
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
    /// Why.
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
        let claimed = 2 * usize::from(words);
        let present = reader.remaining();
        let path = reader
            .take(claimed)
            .ok_or_else(|| fail(PathError::Size { claimed, present }.status()))?;
        let path = Epath::decode(&message.slice_ref(path)).map_err(|error| fail(error.status()))?;
        Ok(Self {
            service,
            path,
            data: message.slice_ref(reader.rest()),
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

/// Reads the data of a Multiple Service Packet: `count u16, offset u16 × count, requests` (spec/ethernet-ip.md §9.1).
/// A request ends where the next one begins, the last one at the end of the data. An embedded Multiple Service Packet,
/// Unconnected Send, Forward Open or Forward Close comes out as an error with 0x08: nothing nests.
///
/// # Errors
/// 0x13 when offsets are missing, 0x03 when they do not ascend within the data or there are more than [`MAX_SERVICES`].
pub fn split_multiple(data: &Bytes) -> Result<Vec<Result<Request, RequestError>>, CipStatus> {
    let offsets = decode_offsets(data)?;
    let ends = offsets.iter().skip(1).copied().chain([data.len()]);
    let mut requests = Vec::with_capacity(offsets.len());
    for (start, end) in offsets.iter().zip(ends) {
        requests.push(Request::decode(&data.slice(*start..end)).and_then(refuse_nesting));
    }
    Ok(requests)
}

fn refuse_nesting(request: Request) -> Result<Request, RequestError> {
    use crate::epath::Segment;
    let connection_manager =
        matches!(request.path.0.first(), Some(Segment::Class(id)) if *id == u32::from(class::CONNECTION_MANAGER));
    let nests = match request.service {
        service::MULTIPLE_SERVICE_PACKET => true,
        service::FORWARD_CLOSE | service::UNCONNECTED_SEND | service::FORWARD_OPEN | service::LARGE_FORWARD_OPEN => {
            connection_manager
        }
        _ => false,
    };
    if nests {
        Err(RequestError {
            service: request.service,
            status: CipStatus::SERVICE_NOT_SUPPORTED,
        })
    } else {
        Ok(request)
    }
}

/// Offsets that ascend, lie behind the table and within the data.
fn decode_offsets(data: &[u8]) -> Result<Vec<usize>, CipStatus> {
    let mut reader = Reader::new(data);
    let count = usize::from(reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?);
    if count > MAX_SERVICES {
        return Err(CipStatus::INVALID_PARAMETER_VALUE);
    }
    let mut offsets = Vec::new();
    let mut least = 2 + 2 * count;
    for _ in 0..count {
        let offset = usize::from(reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?);
        if offset < least || offset > data.len() {
            return Err(CipStatus::INVALID_PARAMETER_VALUE);
        }
        least = offset;
        offsets.push(offset);
    }
    Ok(offsets)
}

/// The data of a Multiple Service Packet request.
///
/// # Errors
/// A path is too long.
///
/// # Panics
/// Never; more requests than offsets can reach give a packet the server refuses.
pub fn join_multiple(requests: &[Request]) -> Result<Bytes, PathError> {
    let mut bodies = Vec::with_capacity(requests.len());
    for request in requests {
        bodies.push(request.to_bytes()?);
    }
    Ok(join(&bodies))
}

fn join(bodies: &[Bytes]) -> Bytes {
    let mut out = BytesMut::new();
    let mut offset = 2 + 2 * bodies.len();
    out.put_u16_le(u16::try_from(bodies.len()).unwrap_or(u16::MAX));
    for body in bodies {
        out.put_u16_le(u16::try_from(offset).unwrap_or(u16::MAX));
        offset += body.len();
    }
    for body in bodies {
        out.put_slice(body);
    }
    out.freeze()
}

/// Collects the replies to the requests of one Multiple Service Packet, never beyond its budget.
#[derive(Debug)]
pub struct MultipleReplies {
    replies: Vec<Bytes>,
    expected: usize,
    room: usize,
    failed: bool,
}

impl MultipleReplies {
    /// Room for `count` replies in a router reply of at most `budget` bytes (head included).
    ///
    /// # Errors
    /// 0x11 if not even empty replies fit.
    pub fn new(count: usize, budget: usize) -> Result<Self, CipStatus> {
        let least = REPLY_HEAD + 2 + count * (2 + REPLY_HEAD);
        let room = budget.checked_sub(least).ok_or(CipStatus::REPLY_TOO_LARGE)?;
        Ok(Self {
            replies: Vec::new(),
            expected: count,
            room,
            failed: false,
        })
    }

    /// The longest next reply that fits, in bytes with its head.
    pub fn budget(&self) -> usize {
        self.room + REPLY_HEAD
    }

    /// Adds the next reply. One that does not fit is answered in place with 0x06 and no data, as controllers do. More
    /// replies than requests are ignored.
    pub fn push(&mut self, reply: &Reply) {
        if self.replies.len() == self.expected {
            return;
        }
        let bytes = if reply.len() <= self.budget() {
            reply.to_bytes()
        } else {
            Reply::error(reply.service, CipStatus::PARTIAL_TRANSFER).to_bytes()
        };
        self.failed |= bytes.get(2) != Some(&0);
        self.room = self.room.saturating_sub(bytes.len() - REPLY_HEAD);
        self.replies.push(bytes);
    }

    /// The reply to the packet: 0x00, or 0x1E when an embedded one failed. Requests nobody answered get 0x02.
    pub fn finish(mut self) -> Reply {
        while self.replies.len() < self.expected {
            self.push(&Reply::error(0, CipStatus::RESOURCE_UNAVAILABLE));
        }
        let status = if self.failed {
            CipStatus::EMBEDDED_SERVICE_ERROR
        } else {
            CipStatus::SUCCESS
        };
        Reply::with_status(service::MULTIPLE_SERVICE_PACKET, status, join(&self.replies))
    }
}

/// Reads the replies inside a Multiple Service Packet's reply data; `None` if one is cut.
pub fn split_multiple_replies(data: &Bytes) -> Option<Vec<Reply>> {
    let offsets = decode_offsets(data).ok()?;
    let ends = offsets.iter().skip(1).copied().chain([data.len()]);
    offsets
        .iter()
        .zip(ends)
        .map(|(start, end)| Reply::decode(&data.slice(*start..end)))
        .collect()
}

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
/// so who reads must know them.
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

    /// What is left behind the list.
    pub const fn rest(&self) -> &'a [u8] {
        self.reader.rest()
    }
}

/// Whether `surplus` is one of the encoded routes that a stock client leaves behind an unconnected message: `0000` or
/// `01 00 01 00` (spec/ethernet-ip.md §4).
pub fn is_stray_route(surplus: &[u8]) -> bool {
    matches!(surplus, [0, 0] | [1, 0, 1, _])
}

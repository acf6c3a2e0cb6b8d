//! The Multiple Service Packet: several requests in one, and their replies within one budget (spec/ethernet-ip.md §9.1).
//!
//! Not here: the order of execution, which is the caller's. Offsets and budgets are in bytes.

use bytes::{BufMut, Bytes, BytesMut};

use super::{REPLY_HEAD, Reply, Request, RequestError, class, service};
use crate::epath::PathError;
use crate::status::CipStatus;
use crate::wire::Reader;

/// Requests accepted in one Multiple Service Packet: as many as the largest connection has room for their replies, each with its
/// offset.
pub const MAX_SERVICES: usize = u16::MAX as usize / (2 + REPLY_HEAD);

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
        let message = data.get(*start..end).unwrap_or_default();
        requests.push(Request::read(message, data).and_then(refuse_nesting));
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
    /// Count, offsets and replies as they leave.
    out: BytesMut,
    pushed: usize,
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
        let table = 2 + 2 * count;
        let mut out = BytesMut::with_capacity(table + count * TYPICAL);
        out.put_u16_le(u16::try_from(count).unwrap_or(u16::MAX));
        out.put_bytes(0, table - 2);
        Ok(Self {
            out,
            pushed: 0,
            expected: count,
            room,
            failed: false,
        })
    }

    /// The longest next reply that fits, in bytes with its head.
    pub fn budget(&self) -> usize {
        self.room + REPLY_HEAD
    }

    /// Adds the next reply. One that does not fit, or says so itself (0x11), is answered in place with 0x06 and no data, as
    /// controllers do: libplctag then asks for it in another packet, and gives up the tag at 0x11. Only the first, which had
    /// all the room there is, keeps its 0x11. More replies than requests are ignored.
    pub fn push(&mut self, reply: &Reply) {
        if self.pushed == self.expected {
            return;
        }
        let refused = self.pushed > 0 && reply.status.is(CipStatus::REPLY_TOO_LARGE);
        if refused || reply.len() > self.budget() {
            return self.append(&Reply::error(reply.service, CipStatus::PARTIAL_TRANSFER));
        }
        self.append(reply);
    }

    fn append(&mut self, reply: &Reply) {
        let offset = u16::try_from(self.out.len()).unwrap_or(u16::MAX);
        let entry = 2 + 2 * self.pushed;
        if let Some(entry) = self.out.get_mut(entry..entry + 2) {
            entry.copy_from_slice(&offset.to_le_bytes());
        }
        reply.encode(&mut self.out);
        self.pushed += 1;
        self.failed |= !reply.status.is_success();
        self.room = self.room.saturating_sub(reply.len() - REPLY_HEAD);
    }

    /// The reply to the packet: 0x00, or 0x1E when an embedded one failed. Requests without an answer get 0x02.
    pub fn finish(mut self) -> Reply {
        while self.pushed < self.expected {
            self.push(&Reply::error(0, CipStatus::RESOURCE_UNAVAILABLE));
        }
        let status = if self.failed {
            CipStatus::EMBEDDED_SERVICE_ERROR
        } else {
            CipStatus::SUCCESS
        };
        Reply::with_status(service::MULTIPLE_SERVICE_PACKET, status, self.out)
    }
}

/// Bytes of a reply with a number.
const TYPICAL: usize = REPLY_HEAD + 2 + 4;

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

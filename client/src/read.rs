//! Reading tags: scalars, arrays, structures, strings, bits; in fragments where one reply does not hold them.

use bytes::{Bytes, BytesMut};

use arcline_instruction_set::locate;
use arcline_proto::cip::{CipStatus, Reply, Request, class, join_multiple, service, split_multiple_replies};
use arcline_proto::epath::Epath;
use arcline_proto::logix::{ReadReply, ReadTag, WireType};
use arcline_tag::{DataType, Elementary, Location, PathSegment, TagPath, TagType, Value};

use crate::{Client, ClientError, TagValue};

/// Most bytes of one tag that are read or written at once.
pub const MAX_BYTES: usize = 16 << 20;
/// Bytes that a request adds to a Multiple Service Packet beside its own, with the head and type of its reply.
const MULTIPLE_OVERHEAD: usize = 10;
/// Requests in one Multiple Service Packet.
const MAX_MULTIPLE: usize = 100;

/// The part of a tag that a path names, and its request.
#[derive(Clone, Debug)]
pub(crate) struct TagPart {
    /// The path as text.
    pub(crate) text: String,
    /// The wire path, without a final bit.
    pub(crate) path: Epath,
    pub(crate) data_type: DataType,
    /// Elements, when the path leads to an array.
    pub(crate) array: Option<u16>,
    /// Elements from here to the end of the array.
    pub(crate) available: u32,
    /// A bit of an integer.
    pub(crate) bit: Option<u8>,
}

impl TagPart {
    /// Finds the part of a tag that a path leads to.
    fn new(text: &str, path: &TagPath, tag_type: &TagType) -> Result<Self, ClientError> {
        let wrong = |error| ClientError::path(text, error);
        let Location {
            data_type, elements, ..
        } = locate(tag_type, path.scope().2).map_err(wrong)?;
        let (wire, bit) = Epath::from_tag(path);
        let array = if bit.is_none() && is_array(path, tag_type).map_err(wrong)? {
            let claimed = elements as usize;
            let limit = usize::from(u16::MAX);
            let count = u16::try_from(elements);
            Some(count.map_err(|_| ClientError::TooLarge {
                what: "the number of elements",
                claimed,
                limit,
            })?)
        } else {
            None
        };
        let size = data_type.size().saturating_mul(array.map_or(1, usize::from));
        if size > MAX_BYTES {
            return Err(ClientError::TooLarge {
                what: "the tag's size",
                claimed: size,
                limit: MAX_BYTES,
            });
        }
        Ok(Self {
            text: text.to_owned(),
            path: wire,
            data_type,
            array,
            available: elements,
            bit,
        })
    }

    /// The type code in front of its values.
    pub(crate) fn wire_type(&self) -> WireType {
        match &self.data_type {
            DataType::Elementary(elementary) => WireType::from(*elementary),
            DataType::Structure(template) => WireType::Structure(template.handle),
        }
    }

    fn elements(&self) -> u16 {
        self.array.unwrap_or(1)
    }

    fn size(&self) -> usize {
        self.data_type.size() * usize::from(self.elements())
    }

    fn request(&self) -> Request {
        let data = ReadTag {
            elements: self.elements(),
            offset: 0,
        }
        .to_bytes();
        Request::new(service::READ_TAG, self.path.clone(), data)
    }

    fn decode(&self, bytes: &[u8]) -> Result<TagValue, ClientError> {
        let reading = match self.array {
            Some(elements) => TagValue::decode_array(&self.data_type, usize::from(elements), bytes),
            None => TagValue::decode(&self.data_type, bytes),
        };
        let reading = reading.ok_or(TOO_SHORT)?;
        match (self.bit, reading.value()) {
            (Some(bit), Some(value)) => Ok(TagValue::Value(Value::Bool(has_bit(value, bit)))),
            _ => Ok(reading),
        }
    }
}

/// Whether a path ends at an array rather than at one element of it.
fn is_array(path: &TagPath, tag_type: &TagType) -> Result<bool, arcline_tag::PathError> {
    match path.scope().2.split_last() {
        Some((PathSegment::Symbol(name), front)) => {
            let parent = locate(tag_type, front)?;
            Ok(match &parent.data_type {
                DataType::Structure(template) => template.member(name).is_some_and(|member| member.dimension > 0),
                DataType::Elementary(_) => false,
            })
        }
        Some(_) => Ok(false),
        None => Ok(tag_type.rank() > 0),
    }
}

fn has_bit(value: Value, bit: u8) -> bool {
    let bits = match value {
        Value::Ulint(bits) | Value::Lword(bits) => bits,
        other => other.to_integer().unwrap_or_default().cast_unsigned(),
    };
    bits.checked_shr(bit.into()).unwrap_or_default() & 1 != 0
}

impl Client {
    /// Reads a tag, a member, an element (`A[3]`), a bit (`Word.5`), a whole array or a whole structure. A value that
    /// needs several replies may have changed between them.
    ///
    /// # Errors
    /// [`ClientError::UnknownTag`], [`ClientError::Path`], [`ClientError::Refused`], or an error of the connection.
    ///
    /// ```no_run
    /// # async fn example(client: arcline_client::Client) -> Result<(), arcline_client::ClientError> {
    /// let axis = client.read("X").await?;
    /// println!("{:?}", axis.member("ActualPosition").and_then(|position| position.as_f64()));
    /// println!("{:?}", client.read("Move1.Position").await?.numbers());
    /// # Ok(())
    /// # }
    /// ```
    pub async fn read(&self, path: &str) -> Result<TagValue, ClientError> {
        let part = self.locate(path).await?;
        let bytes = self.read_bytes(&part).await?;
        part.decode(&bytes)
    }

    /// Reads an array of numbers from an element on: `A[2]` to its end, `A` whole; a tag that is no array is an array of one.
    ///
    /// # Errors
    /// As [`Client::read`]; [`ClientError::Value`] when there are no numbers.
    pub async fn read_numbers(&self, path: &str) -> Result<Vec<f64>, ClientError> {
        let mut part = self.locate(path).await?;
        if part.array.is_none() && part.available > 1 && matches!(part.data_type, DataType::Elementary(_)) {
            part.array = Some(u16::try_from(part.available).unwrap_or(u16::MAX));
        }
        let bytes = self.read_bytes(&part).await?;
        let numbers = part.decode(&bytes)?.numbers();
        numbers.ok_or_else(|| ClientError::Value {
            path: path.to_owned(),
            expected: part.data_type.name().to_owned(),
            given: "an array of numbers".to_owned(),
        })
    }

    /// Reads several tags, as many as possible at the same instant: one message reads as many as fit into it.
    ///
    /// # Errors
    /// The errors of the connection; each tag has an answer of its own.
    ///
    /// ```no_run
    /// # async fn example(client: arcline_client::Client) -> Result<(), arcline_client::ClientError> {
    /// for reading in client.read_many(&["X.ActualPosition", "Y.ActualPosition"]).await? {
    ///     println!("{}", reading?);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    pub async fn read_many(&self, paths: &[&str]) -> Result<Vec<Result<TagValue, ClientError>>, ClientError> {
        let mut parts = Vec::with_capacity(paths.len());
        for path in paths {
            match self.locate(path).await {
                Err(error) if error.is_connection() => return Err(error),
                part => parts.push(part),
            }
        }
        let mut readings = Vec::with_capacity(parts.len());
        let mut rest = parts.into_iter().peekable();
        while rest.peek().is_some() {
            let mut room = self.budget().saturating_sub(16);
            let mut batch = Vec::new();
            while let Some(part) = rest.next_if(|part| {
                let needed = part.as_ref().map_or(0, |part| {
                    let request = part.request().to_bytes().map_or(usize::MAX, |bytes| bytes.len());
                    request.max(part.size()).saturating_add(MULTIPLE_OVERHEAD)
                });
                let fits = batch.is_empty() || needed <= room && batch.len() < MAX_MULTIPLE;
                room = room.saturating_sub(needed);
                fits
            }) {
                batch.push(part);
            }
            readings.extend(self.read_batch(batch).await?);
        }
        Ok(readings)
    }

    async fn read_batch(
        &self,
        batch: Vec<Result<TagPart, ClientError>>,
    ) -> Result<Vec<Result<TagValue, ClientError>>, ClientError> {
        let parts: Vec<&TagPart> = batch.iter().filter_map(|part| part.as_ref().ok()).collect();
        let mut replies = Vec::new();
        if let [_, _, ..] = parts.as_slice() {
            let requests: Vec<Request> = parts.iter().map(|part| part.request()).collect();
            let data = join_multiple(&requests).map_err(arcline_proto::client::ClientError::from)?;
            let path = Epath::object(class::MESSAGE_ROUTER, 1);
            let reply = self
                .request(Request::new(service::MULTIPLE_SERVICE_PACKET, path, data))
                .await?;
            if !reply.status.is_success() && !reply.status.is(CipStatus::EMBEDDED_SERVICE_ERROR) {
                return Err(ClientError::refused("reading several tags", reply.status));
            }
            let malformed = ClientError::Malformed {
                what: "replies of a Multiple Service Packet are missing",
            };
            replies = split_multiple_replies(&reply.data)
                .filter(|all| all.len() == parts.len())
                .ok_or(malformed)?;
        }
        let mut replies = replies.into_iter();
        let mut readings = Vec::with_capacity(batch.len());
        for part in batch {
            let reading = match (part, replies.as_slice().is_empty()) {
                (Err(error), _) => Err(error),
                (Ok(part), true) => self.read_part(&part, None).await,
                (Ok(part), false) => self.read_part(&part, replies.next()).await,
            };
            match reading {
                Err(error) if error.is_connection() => return Err(error),
                reading => readings.push(reading),
            }
        }
        Ok(readings)
    }

    async fn read_part(&self, part: &TagPart, first: Option<Reply>) -> Result<TagValue, ClientError> {
        let bytes = match first {
            Some(reply) if reply.status.is_success() => fragment(part, &reply, part.size())?,
            Some(reply) if !reply.status.is(CipStatus::PARTIAL_TRANSFER) => {
                return Err(ClientError::refused(&part.text, reply.status));
            }
            // The part did not fit: read it again, alone.
            _ => self.read_bytes(part).await?,
        };
        part.decode(&bytes)
    }

    /// The part of a tag that a path names, by the type of the tag.
    pub(crate) async fn locate(&self, path: &str) -> Result<TagPart, ClientError> {
        let parsed: TagPath = path.parse().map_err(|error| ClientError::path(path, error))?;
        let tag = self.tag(&parsed.full_name().unwrap_or_default()).await?;
        TagPart::new(path, &parsed, &tag.tag_type)
    }

    async fn read_bytes(&self, part: &TagPart) -> Result<Bytes, ClientError> {
        let size = part.size();
        let mut reply = self.request(part.request()).await?;
        let mut bytes = BytesMut::new();
        loop {
            let partial = reply.status.is(CipStatus::PARTIAL_TRANSFER);
            if !partial && !reply.status.is_success() {
                return Err(ClientError::refused(&part.text, reply.status));
            }
            let data = fragment(part, &reply, size - bytes.len())?;
            let nothing = data.is_empty();
            bytes.extend_from_slice(&data);
            if !partial {
                break;
            }
            if nothing || bytes.len() >= size {
                return Err(ClientError::Malformed {
                    what: "a fragmented read does not end",
                });
            }
            let offset = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
            let data = ReadTag {
                elements: part.elements(),
                offset,
            }
            .to_bytes_fragmented();
            let request = Request::new(service::READ_TAG_FRAGMENTED, part.path.clone(), data);
            reply = self.request(request).await?;
        }
        if bytes.len() < size {
            Err(TOO_SHORT)
        } else {
            Ok(bytes.freeze())
        }
    }
}

/// The data of a read reply, at most `room` bytes of it; its type must be the tag's.
fn fragment(part: &TagPart, reply: &Reply, room: usize) -> Result<Bytes, ClientError> {
    let reply = ReadReply::decode(&reply.data).ok_or(ClientError::Malformed {
        what: "a read reply is cut",
    })?;
    if !same_type(reply.data_type, part.wire_type()) {
        return Err(ClientError::Malformed {
            what: "a read reply has another type than the tag",
        });
    }
    Ok(reply.data.slice(..reply.data.len().min(room)))
}

/// Controllers answer a BOOL in a structure with 0xC1 and its bit position in the second byte.
fn same_type(answered: WireType, expected: WireType) -> bool {
    let bool_code = u16::from(Elementary::Bool.code());
    match (answered, expected) {
        (WireType::Atomic(code), WireType::Atomic(expected)) if expected == bool_code => code & 0xFF == bool_code,
        _ => answered == expected,
    }
}

const TOO_SHORT: ClientError = ClientError::Malformed {
    what: "a read reply has too few bytes",
};

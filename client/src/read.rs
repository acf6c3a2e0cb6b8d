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
/// What a request of a Multiple Service Packet costs besides its own bytes, with its reply's head and type.
const MULTIPLE_OVERHEAD: usize = 10;
/// Requests in one Multiple Service Packet.
const MAX_MULTIPLE: usize = 100;

/// Where a path leads, and how it is asked for.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// As it was given.
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

impl Place {
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
    /// [`ClientError::UnknownTag`], [`ClientError::Path`], [`ClientError::Refused`], or what the session meets.
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
        let place = self.place(path).await?;
        let bytes = self.read_bytes(&place).await?;
        place.decode(&bytes)
    }

    /// Reads an array of numbers from an element on: `A[2]` to its end, `A` whole; what is no array is an array of one.
    ///
    /// # Errors
    /// As [`Client::read`]; [`ClientError::Value`] when there are no numbers.
    pub async fn read_numbers(&self, path: &str) -> Result<Vec<f64>, ClientError> {
        let mut place = self.place(path).await?;
        if place.array.is_none() && place.available > 1 && matches!(place.data_type, DataType::Elementary(_)) {
            place.array = Some(u16::try_from(place.available).unwrap_or(u16::MAX));
        }
        let bytes = self.read_bytes(&place).await?;
        let numbers = place.decode(&bytes)?.numbers();
        numbers.ok_or_else(|| ClientError::Value {
            path: path.to_owned(),
            expected: place.data_type.name().to_owned(),
            given: "an array of numbers".to_owned(),
        })
    }

    /// Reads several tags, as many as possible at the same moment: those that fit one message are read in one.
    ///
    /// # Errors
    /// What the session meets; each tag has an answer of its own.
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
        let mut places = Vec::with_capacity(paths.len());
        for path in paths {
            match self.place(path).await {
                Err(error) if error.is_connection() => return Err(error),
                place => places.push(place),
            }
        }
        let mut readings = Vec::with_capacity(places.len());
        let mut rest = places.into_iter().peekable();
        while rest.peek().is_some() {
            let mut room = self.budget().saturating_sub(16);
            let mut batch = Vec::new();
            while let Some(place) = rest.next_if(|place| {
                let needed = place.as_ref().map_or(0, |place| {
                    let request = place.request().to_bytes().map_or(usize::MAX, |bytes| bytes.len());
                    request.max(place.size()).saturating_add(MULTIPLE_OVERHEAD)
                });
                let fits = batch.is_empty() || needed <= room && batch.len() < MAX_MULTIPLE;
                room = room.saturating_sub(needed);
                fits
            }) {
                batch.push(place);
            }
            readings.extend(self.read_batch(batch).await?);
        }
        Ok(readings)
    }

    async fn read_batch(
        &self,
        batch: Vec<Result<Place, ClientError>>,
    ) -> Result<Vec<Result<TagValue, ClientError>>, ClientError> {
        let places: Vec<&Place> = batch.iter().filter_map(|place| place.as_ref().ok()).collect();
        let mut replies = Vec::new();
        if let [_, _, ..] = places.as_slice() {
            let requests: Vec<Request> = places.iter().map(|place| place.request()).collect();
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
                .filter(|all| all.len() == places.len())
                .ok_or(malformed)?;
        }
        let mut replies = replies.into_iter();
        let mut readings = Vec::with_capacity(batch.len());
        for place in batch {
            let reading = match (place, replies.as_slice().is_empty()) {
                (Err(error), _) => Err(error),
                (Ok(place), true) => self.read_place(&place, None).await,
                (Ok(place), false) => self.read_place(&place, replies.next()).await,
            };
            match reading {
                Err(error) if error.is_connection() => return Err(error),
                reading => readings.push(reading),
            }
        }
        Ok(readings)
    }

    async fn read_place(&self, place: &Place, first: Option<Reply>) -> Result<TagValue, ClientError> {
        let bytes = match first {
            Some(reply) if reply.status.is_success() => fragment(place, &reply, place.size())?,
            Some(reply) if !reply.status.is(CipStatus::PARTIAL_TRANSFER) => {
                return Err(ClientError::refused(&place.text, reply.status));
            }
            // It did not fit: again, alone.
            _ => self.read_bytes(place).await?,
        };
        place.decode(&bytes)
    }

    /// Where a path leads, by the tag's type.
    pub(crate) async fn place(&self, path: &str) -> Result<Place, ClientError> {
        let parsed: TagPath = path.parse().map_err(|error| ClientError::path(path, error))?;
        let tag = self.tag(&parsed.full_name().unwrap_or_default()).await?;
        Place::new(path, &parsed, &tag.tag_type)
    }

    async fn read_bytes(&self, place: &Place) -> Result<Bytes, ClientError> {
        let size = place.size();
        let mut reply = self.request(place.request()).await?;
        let mut bytes = BytesMut::new();
        loop {
            let partial = reply.status.is(CipStatus::PARTIAL_TRANSFER);
            if !partial && !reply.status.is_success() {
                return Err(ClientError::refused(&place.text, reply.status));
            }
            let part = fragment(place, &reply, size - bytes.len())?;
            let nothing = part.is_empty();
            bytes.extend_from_slice(&part);
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
                elements: place.elements(),
                offset,
            }
            .to_bytes_fragmented();
            let request = Request::new(service::READ_TAG_FRAGMENTED, place.path.clone(), data);
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
fn fragment(place: &Place, reply: &Reply, room: usize) -> Result<Bytes, ClientError> {
    let reply = ReadReply::decode(&reply.data).ok_or(ClientError::Malformed {
        what: "a read reply is cut",
    })?;
    if !same_type(reply.data_type, place.wire_type()) {
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

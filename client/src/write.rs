//! Writing tags: the type of the tag decides the bytes on the wire; a value that does not fit is refused here.

use bytes::Bytes;

use arcline_proto::cip::service;
use arcline_proto::logix::{ReadModifyWrite, WriteTag};
use arcline_tag::{Elementary, Fraction, TagType};

use crate::read::TagPart;
use crate::{Client, ClientError, WriteValue};

/// Bytes of a write request beside path and data: head, type, count, offset.
const WRITE_HEAD: usize = 16;

impl Client {
    /// Writes a tag, a member, an element, a bit, a string, or the first elements of an array (from an element on, when
    /// the path names one). Integers take real numbers rounded half to even; a value out of the type's range is refused.
    ///
    /// # Errors
    /// [`ClientError::Value`] when the value does not fit, [`ClientError::Refused`] when the server does not take it
    /// (0x0F: the tag is read-only); otherwise as [`Client::read`].
    ///
    /// ```no_run
    /// # async fn example(client: arcline_client::Client) -> Result<(), arcline_client::ClientError> {
    /// client.write("Move1.Speed", 50.0).await?;
    /// client.write("Move1.Position", vec![100.0, 50.0, 0.0]).await?;
    /// client.write("Move1.CoordinateSystem", "CS1").await?;
    /// client.write("Move1.EnableIn", true).await?;
    /// # Ok(())
    /// # }
    /// ```
    pub async fn write(&self, path: &str, value: impl Into<WriteValue>) -> Result<(), ClientError> {
        let value = value.into();
        let part = self.locate(path).await?;
        if let Some(bit) = part.bit {
            return self.write_bit(&part, bit, &value).await;
        }
        let (elements, bytes) = encode(&part, &value)?;
        let size = part.data_type.size();
        let path_size = part.path.to_bytes().len();
        let room = self.budget().saturating_sub(WRITE_HEAD + path_size);
        let request = |offset, data| WriteTag {
            data_type: part.wire_type(),
            elements,
            offset,
            data,
        };
        if bytes.len() <= room {
            let data = request(0, bytes).to_bytes();
            self.ask(&part.text, service::WRITE_TAG, part.path.clone(), data)
                .await?;
            return Ok(());
        }
        // Elements stay whole; of a structure larger than a message any multiple of 4 will do.
        let unit = if size <= room { size } else { 4 };
        let step = room - room % unit.max(1);
        if step == 0 {
            return Err(ClientError::TooLarge {
                what: "the path",
                claimed: path_size,
                limit: self.budget(),
            });
        }
        for offset in (0..bytes.len()).step_by(step) {
            let end = bytes.len().min(offset + step);
            let data = request(u32::try_from(offset).unwrap_or(u32::MAX), bytes.slice(offset..end));
            let data = data.to_bytes_fragmented();
            self.ask(&part.text, service::WRITE_TAG_FRAGMENTED, part.path.clone(), data)
                .await?;
        }
        Ok(())
    }

    async fn write_bit(&self, part: &TagPart, bit: u8, value: &WriteValue) -> Result<(), ClientError> {
        let set = value.convert(Elementary::Bool, Fraction::Round);
        let set = set.map_err(|_| ClientError::value(&part.text, Elementary::Bool, value))?;
        let set = set.as_bool();
        let size = u8::try_from(part.data_type.size()).unwrap_or_default();
        let data = ReadModifyWrite::bit(size, bit, set).to_bytes();
        self.ask(&part.text, service::READ_MODIFY_WRITE_TAG, part.path.clone(), data)
            .await?;
        Ok(())
    }
}

/// Elements and their bytes.
fn encode(part: &TagPart, value: &WriteValue) -> Result<(u16, Bytes), ClientError> {
    let WriteValue::Array(values) = value else {
        if part.array.is_some_and(|elements| elements != 1) {
            return Err(does_not_fit(part, value));
        }
        let mut bytes = Vec::new();
        encode_one(part, value, &mut bytes)?;
        return Ok((1, bytes.into()));
    };
    let count = u16::try_from(values.len())
        .ok()
        .filter(|count| *count > 0 && u32::from(*count) <= part.available);
    let count = count.ok_or_else(|| does_not_fit(part, value))?;
    let mut bytes = Vec::new();
    for value in values {
        encode_one(part, value, &mut bytes)?;
    }
    Ok((count, bytes.into()))
}

fn encode_one(part: &TagPart, value: &WriteValue, bytes: &mut Vec<u8>) -> Result<(), ClientError> {
    let start = bytes.len();
    bytes.resize(start + part.data_type.size(), 0);
    let room = bytes.get_mut(start..).unwrap_or_default();
    let written = value.encode(&part.data_type, Fraction::Round, room);
    written.map_err(|_| does_not_fit(part, value))
}

fn does_not_fit(part: &TagPart, value: &WriteValue) -> ClientError {
    let tag_type = TagType {
        data_type: part.data_type.clone(),
        dimensions: [part.array.map_or(0, u32::from), 0, 0],
    };
    ClientError::Value {
        path: part.text.clone(),
        expected: tag_type.to_string(),
        given: value.to_string(),
    }
}

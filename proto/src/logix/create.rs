//! Request data of Create (0x08) on class 0x6B: a tag that is to be there. The service is this project's own use of a
//! common service; a controller's is not documented.

use bytes::{BufMut, Bytes, BytesMut};

use crate::status::CipStatus;
use crate::wire::Reader;

/// A tag to be created: `name length u16, name, type length u16, type, external access u8`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CreateSymbol {
    /// Its name, without a program.
    pub name: String,
    /// Its type as text, such as `DINT[2,3]`.
    pub data_type: String,
    /// External access: 0 read and write, 2 read only.
    pub access: u8,
}

/// Longest text that is accepted, bytes.
const MAX_TEXT: usize = 255;

impl CreateSymbol {
    /// The request data.
    pub fn to_bytes(&self) -> Bytes {
        let mut out = BytesMut::with_capacity(5 + self.name.len() + self.data_type.len());
        for text in [&self.name, &self.data_type] {
            let bytes = text.as_bytes().get(..text.len().min(MAX_TEXT)).unwrap_or_default();
            // At most MAX_TEXT.
            out.put_u16_le(bytes.len() as u16);
            out.put_slice(bytes);
        }
        out.put_u8(self.access);
        out.freeze()
    }

    /// Reads request data; bytes behind it are returned.
    ///
    /// # Errors
    /// 0x13 when it is cut, 0x20 for texts that are too long or no text.
    pub fn decode(data: &[u8]) -> Result<(Self, &[u8]), CipStatus> {
        let mut reader = Reader::new(data);
        let mut text = || {
            let length = usize::from(reader.u16().ok_or(CipStatus::NOT_ENOUGH_DATA)?);
            let bytes = reader.take(length).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
            let text = std::str::from_utf8(bytes).ok().filter(|text| text.len() <= MAX_TEXT);
            text.map(str::to_owned).ok_or(CipStatus::INVALID_PARAMETER)
        };
        let (name, data_type) = (text()?, text()?);
        let access = reader.u8().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let this = Self {
            name,
            data_type,
            access,
        };
        Ok((this, reader.rest()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_cut_nowhere() {
        let create = CreateSymbol {
            name: "Recipe".to_owned(),
            data_type: "REAL[16]".to_owned(),
            access: 2,
        };
        let bytes = create.to_bytes();
        assert_eq!(&bytes[..], b"\x06\0Recipe\x08\0REAL[16]\x02");
        for cut in 0..bytes.len() {
            assert_eq!(
                CreateSymbol::decode(&bytes[..cut]),
                Err(CipStatus::NOT_ENOUGH_DATA),
                "cut at {cut}"
            );
        }
        let longer = [&bytes[..], &[1, 0]].concat();
        assert_eq!(CreateSymbol::decode(&longer), Ok((create, &[1, 0][..])));
    }
}

//! Records as bytes, the only module that uses `bincode`. Numbers are little-endian, counts and integers of variable
//! length. The bytes do not describe themselves, so a changed type is a new [`FORMAT`](crate::FORMAT).

use bincode::config::{self, Configuration, Limit, LittleEndian, Varint};
use serde::{Deserialize, Serialize};

use crate::{Change, MAX_TOTAL, RetainedState};

/// One record of a file; a crash leaves all of it or none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Record {
    /// A whole state in place of the earlier one: the first record of a file, and one whenever there are other tags.
    State(RetainedState),
    /// Changes that belong together.
    Changes(Vec<Change>),
}

impl Record {
    /// The bytes of tags in it.
    pub fn tag_bytes(&self) -> usize {
        match self {
            Record::State(state) => state.tags.iter().map(|tag| tag.bytes.len()).sum(),
            Record::Changes(changes) => changes
                .iter()
                .map(|change| match change {
                    Change::Axis { .. } => 0,
                    Change::Tag { bytes, .. } => bytes.len(),
                })
                .sum(),
        }
    }

    /// Whether it changes nothing but axes.
    pub(crate) fn is_of_axes(&self) -> bool {
        match self {
            Record::State(_) => false,
            Record::Changes(changes) => changes.iter().all(|change| matches!(change, Change::Axis { .. })),
        }
    }
}

/// The bytes of [`Record::State`], from a state that is borrowed. The names of the variants do not matter, their order does.
#[derive(Serialize)]
pub(crate) enum Borrowed<'s> {
    State(&'s RetainedState),
}

/// Bytes of a tag.
pub(crate) type Bytes = Vec<u8>;

/// Longest record: tags and, generously, names, types and counts. Nothing claims more memory while it is read.
pub(crate) const MAX_RECORD: usize = 2 * MAX_TOTAL;

const CONFIG: Configuration<LittleEndian, Varint, Limit<MAX_RECORD>> = config::standard()
    .with_variable_int_encoding()
    .with_limit::<MAX_RECORD>();

/// Appends the bytes of a [`Record`], or of a [`Borrowed`] one.
pub(crate) fn encode(record: &impl Serialize, out: &mut Vec<u8>) {
    bincode::serde::encode_into_std_write(record, out, CONFIG).expect("plain data goes into a vector");
}

/// Reads a record; `None`: the bytes are not one record exactly.
pub(crate) fn decode(bytes: &[u8]) -> Option<Record> {
    let (record, length) = bincode::serde::borrow_decode_from_slice(bytes, CONFIG).ok()?;
    (length == bytes.len()).then_some(record)
}

/// Bytes as one piece; serde would take a vector of them one by one. Read, they are taken from the record, so their
/// claimed length is never allocated.
pub(crate) mod bytes {
    use serde::de::{Error, Visitor};
    use serde::{Deserializer, Serializer};

    struct Owned;

    impl Visitor<'_> for Owned {
        type Value = Vec<u8>;

        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("bytes")
        }

        fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Vec<u8>, E> {
            Ok(bytes.to_vec())
        }
    }

    pub(crate) fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(bytes)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
        deserializer.deserialize_bytes(Owned)
    }
}

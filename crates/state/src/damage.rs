//! The defects of a file.

/// The reason for which a file is not a usable retained state.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum Damage {
    /// The file does not begin like a retained state.
    #[error("it is not a retained state of Arcline")]
    NotAState,
    /// The file has another format.
    #[error("it has format {found}, and this version of Arcline reads format {expected}")]
    OtherFormat {
        /// Its format.
        found: u32,
        /// The format that is read.
        expected: u32,
    },
    /// The file ends before its first state is whole.
    #[error("it ends after {length} bytes, before its first state is whole")]
    TooShort {
        /// Its length, bytes.
        length: usize,
    },
    /// The file ends before the length that the disk had.
    #[error("it ends after {length} bytes, and the disk had {synchronised}")]
    Truncated {
        /// The end of its last whole record, bytes.
        length: usize,
        /// Bytes that were synchronised.
        synchronised: u64,
    },
    /// The file is longer than a retained state can be.
    #[error("it has more than {limit} bytes")]
    TooLong {
        /// The limit, bytes.
        limit: usize,
    },
    /// A checksum does not fit the bytes before it.
    #[error("its checksum at byte {offset} is wrong")]
    Checksum {
        /// The offset of the checksum.
        offset: usize,
    },
    /// A record is not one that can stand there.
    #[error("its record at byte {offset} cannot be read")]
    Record {
        /// The offset of the record.
        offset: usize,
    },
    /// A number in it is beyond its limit.
    #[error("it has {found} {what}, and there are at most {limit}")]
    Limit {
        /// The quantity of which there is too much.
        what: Limit,
        /// The number in the file.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// A position is not a number.
    #[error("the position of its axis {axis} is not a number")]
    NotANumber {
        /// LockedFile of the axis.
        axis: usize,
    },
    /// A change of an axis or a tag that its state does not have.
    #[error("it changes {what} number {index}, which it does not have")]
    NoSuchIndex {
        /// The kind of the changed object.
        what: Limit,
        /// The index that does not exist.
        index: u32,
    },
}

/// A quantity that has a limit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Limit {
    /// Axes.
    Axes,
    /// Tags.
    Tags,
    /// Bytes of a name or a type.
    Text,
    /// Bytes of one tag.
    TagBytes,
    /// Bytes of all tags.
    Total,
}

impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Limit::Axes => "axes",
            Limit::Tags => "tags",
            Limit::Text => "bytes in a name",
            Limit::TagBytes => "bytes in a tag",
            Limit::Total => "bytes in all tags",
        })
    }
}

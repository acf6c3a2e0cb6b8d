//! The errors of reading a tag, writing a tag, and using it as a motion control.

use arcline_tag::PathError;

/// The reason why a path has no value.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ReadError {
    /// No tag of that name.
    #[error("there is no tag {name:?}")]
    NoSuchTag {
        /// The name.
        name: String,
    },
    /// The tag has no such part.
    #[error(transparent)]
    Path(#[from] PathError),
    /// A structure in place of a number.
    #[error("{path} has the type {data_type}, expected a number")]
    NotAValue {
        /// The path.
        path: String,
        /// Its type.
        data_type: String,
    },
}

/// The reason for the refusal of a write. The write has changed nothing.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum WriteError {
    /// No tag of that id.
    #[error("there is no such tag")]
    NoSuchTag,
    /// Bytes beyond the end of the tag.
    #[error("{name} has {size} bytes, the write goes beyond them")]
    BeyondEnd {
        /// The tag.
        name: String,
        /// Its size in bytes.
        size: usize,
    },
    /// A part that only the controller writes.
    #[error("{name} is read-only there")]
    ReadOnly {
        /// The tag.
        name: String,
    },
    /// The controller has no room for another instruction.
    #[error("{name} cannot be executed now, too many instructions wait for the controller: try again")]
    NoRoom {
        /// The instruction tag.
        name: String,
    },
    /// A number outside of the range of the tag's type.
    #[error("{name} cannot be {value}, expected {low} to {high}")]
    OutOfRange {
        /// The tag.
        name: String,
        /// The number.
        value: f32,
        /// The lowest value of the type.
        low: f32,
        /// The highest value of the type.
        high: f32,
    },
    /// A number outside of the tag's own range.
    #[error("{name} cannot be {value}, expected {range}")]
    OutsideRange {
        /// The tag, and the element of an array.
        name: String,
        /// The number.
        value: f64,
        /// The range, as a phrase.
        range: String,
    },
    /// An attribute that only the configuration sets.
    #[error("{name} cannot be set while the machine runs, only by the configuration")]
    NotSettable {
        /// The attribute.
        name: &'static str,
    },
    /// A number outside of the attribute's range.
    #[error("{name} cannot be {value}, expected {range}")]
    NotInRange {
        /// The attribute.
        name: &'static str,
        /// The number.
        value: f64,
        /// Its range, as a phrase.
        range: &'static str,
    },
    /// A fault that does not exist for the axis.
    #[error("{name}[{axis}] cannot be {bits:#x}, expected bits of {possible:#x}")]
    NoSuchFault {
        /// The tag.
        name: String,
        /// Index of the axis.
        axis: usize,
        /// The bits to inject.
        bits: u32,
        /// The possible bits.
        possible: u32,
    },
    /// The path does not exist.
    #[error(transparent)]
    Read(#[from] ReadError),
}

/// The reason why a name is not a motion control tag.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ControlError {
    /// A tag of another type.
    #[error("{name} is not a MOTION_INSTRUCTION tag")]
    NotAMotionControl {
        /// The name.
        name: String,
    },
    /// The name is not a valid tag name.
    #[error("{name:?} cannot be the name of a tag, expected up to 40 letters, digits and underscores")]
    NotAName {
        /// The name, its beginning.
        name: String,
    },
    /// Every slot is in use.
    #[error(
        "there is no room for another motion control tag, {} are in use",
        crate::CONTROL_SLOTS
    )]
    NoRoom,
}

//! Why a tag cannot be read, written, or used as a motion control.

use arcline_tag::PathError;

/// Why a path gives no value.
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
    /// A structure where a number is needed.
    #[error("{path} is a {data_type}, expected a number")]
    NotAValue {
        /// The path.
        path: String,
        /// Its type.
        data_type: String,
    },
}

/// Why a write was refused. Nothing was written then.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum WriteError {
    /// No tag of that id.
    #[error("there is no such tag")]
    NoSuchTag,
    /// Bytes behind the tag's last.
    #[error("{name} has {size} bytes, the write goes beyond them")]
    BeyondEnd {
        /// The tag.
        name: String,
        /// Its size in bytes.
        size: usize,
    },
    /// Something that only the controller writes.
    #[error("{name} is read-only there")]
    ReadOnly {
        /// The tag.
        name: String,
    },
    /// More instructions wait for the controller than it can take.
    #[error("{name} cannot be executed now, too many instructions wait for the controller: try again")]
    NoRoom {
        /// The instruction tag.
        name: String,
    },
    /// A number that the tag cannot hold.
    #[error("{name} cannot be {value}, expected {low} to {high}")]
    OutOfRange {
        /// The tag.
        name: String,
        /// The number.
        value: f32,
        /// The least it can hold.
        low: f32,
        /// The most.
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
    /// A number that the attribute cannot have.
    #[error("{name} cannot be {value}, expected a whole number from 0 to {most}")]
    NotInRange {
        /// The attribute.
        name: &'static str,
        /// The number.
        value: f64,
        /// The most it can be.
        most: u32,
    },
    /// A fault that the axis cannot have.
    #[error("{name}[{axis}] cannot be {bits:#x}, expected bits of {possible:#x}")]
    NoSuchFault {
        /// The tag.
        name: String,
        /// Place of the axis.
        axis: usize,
        /// What was to be injected.
        bits: u32,
        /// What can be.
        possible: u32,
    },
    /// The path leads nowhere.
    #[error(transparent)]
    Read(#[from] ReadError),
}

/// Why a name is no motion control tag.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ControlError {
    /// A tag of another type.
    #[error("{name} is not a MOTION_INSTRUCTION tag")]
    NotAMotionControl {
        /// The name.
        name: String,
    },
    /// It cannot be the name of a tag.
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

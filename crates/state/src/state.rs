//! The retained data, and a change of them.

use serde::{Deserialize, Serialize};

use crate::codec::Bytes;
use crate::{Damage, Limit, Record};

/// All retained data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RetainedState {
    /// The axes, at most [`MAX_AXES`].
    pub axes: Vec<Axis>,
    /// The plain tags, at most [`MAX_TAGS`] of together [`MAX_TOTAL`] bytes.
    pub tags: Vec<Tag>,
}

/// An axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Axis {
    /// Its name, at most [`MAX_TEXT`] bytes.
    pub name: String,
    /// The meaning of its position: type and units. Another text is another axis.
    pub kind: String,
    /// The state of the axis.
    pub state: AxisState,
}

/// The state of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AxisState {
    /// Its position, position units; finite.
    pub position: f64,
    /// Whether the axis is homed.
    pub homed: bool,
    /// Whether the axis moves: the position is then that of a moment ago.
    pub moving: bool,
    /// Its faults since the last reset, a bit for each kind.
    pub faults: u32,
    /// The sum of the shifts of the position without motion since the machine was built, position units; finite.
    pub redefined: f64,
}

/// A tag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tag {
    /// Its name, at most [`MAX_TEXT`] bytes.
    pub name: String,
    /// Its type as a configuration spells it: `REAL[16]`. Another text is another tag.
    pub kind: String,
    /// Its bytes on the wire, at most [`MAX_TAG_BYTES`].
    #[serde(with = "crate::codec::bytes")]
    pub bytes: Bytes,
}

/// A change of a [`RetainedState`]. Indices count from 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Change {
    /// The state of an axis.
    Axis {
        /// Index of the axis in the state.
        axis: u32,
        /// Its new state.
        state: AxisState,
    },
    /// Bytes of a tag.
    Tag {
        /// Index of the tag in the state.
        tag: u32,
        /// Offset of the first byte.
        offset: u32,
        /// The new bytes.
        #[serde(with = "crate::codec::bytes")]
        bytes: Bytes,
    },
}

impl RetainedState {
    /// Takes over a record: all of it, or nothing of it.
    ///
    /// # Errors
    /// [`Damage::NoSuchIndex`] and [`Damage::NotANumber`] for a change; the errors of [`RetainedState::check`] for a state.
    pub fn apply(&mut self, record: &Record) -> Result<(), Damage> {
        match record {
            Record::State(state) => {
                state.check()?;
                self.clone_from(state);
            }
            Record::Changes(changes) => {
                changes.iter().try_for_each(|change| self.check_change(change))?;
                changes.iter().for_each(|change| self.make(change));
            }
        }
        Ok(())
    }

    fn check_change(&self, change: &Change) -> Result<(), Damage> {
        match change {
            Change::Axis { axis, state } => {
                let (what, index) = (Limit::Axes, *axis);
                if *axis as usize >= self.axes.len() {
                    return Err(Damage::NoSuchIndex { what, index });
                }
                finite(*axis as usize, state)
            }
            Change::Tag { tag, offset, bytes } => {
                let (what, index) = (Limit::Tags, *tag);
                let known = self.tags.get(*tag as usize);
                let room = known.and_then(|tag| tag.bytes.len().checked_sub(*offset as usize));
                match room {
                    Some(room) if bytes.len() <= room => Ok(()),
                    _ => Err(Damage::NoSuchIndex { what, index }),
                }
            }
        }
    }

    /// Makes a change that has been checked.
    fn make(&mut self, change: &Change) {
        match change {
            Change::Axis { axis, state } => {
                if let Some(axis) = self.axes.get_mut(*axis as usize) {
                    axis.state = *state;
                }
            }
            Change::Tag { tag, offset, bytes } => {
                let tag = self.tags.get_mut(*tag as usize);
                let part = tag.and_then(|tag| tag.bytes.get_mut(*offset as usize..)?.get_mut(..bytes.len()));
                if let Some(part) = part {
                    part.copy_from_slice(bytes);
                }
            }
        }
    }

    /// Holds a state against the limits.
    ///
    /// # Errors
    /// The first limit that it breaks, or a position that is not a number.
    pub fn check(&self) -> Result<(), Damage> {
        within(Limit::Axes, self.axes.len(), MAX_AXES)?;
        within(Limit::Tags, self.tags.len(), MAX_TAGS)?;
        for (index, axis) in self.axes.iter().enumerate() {
            within(Limit::Text, axis.name.len().max(axis.kind.len()), MAX_TEXT)?;
            finite(index, &axis.state)?;
        }
        let mut total = 0;
        for tag in &self.tags {
            within(Limit::Text, tag.name.len().max(tag.kind.len()), MAX_TEXT)?;
            within(Limit::TagBytes, tag.bytes.len(), MAX_TAG_BYTES)?;
            total += tag.bytes.len();
        }
        within(Limit::Total, total, MAX_TOTAL)
    }
}

pub(crate) fn within(what: Limit, found: usize, limit: usize) -> Result<(), Damage> {
    if found <= limit {
        Ok(())
    } else {
        Err(Damage::Limit { what, found, limit })
    }
}

fn finite(axis: usize, state: &AxisState) -> Result<(), Damage> {
    if state.position.is_finite() && state.redefined.is_finite() {
        Ok(())
    } else {
        Err(Damage::NotANumber { axis })
    }
}

/// Most axes.
pub const MAX_AXES: usize = 4096;
/// Most tags.
pub const MAX_TAGS: usize = 65_536;
/// Longest name or type, bytes.
pub const MAX_TEXT: usize = 255;
/// Largest tag, bytes.
pub const MAX_TAG_BYTES: usize = 8 * 1024 * 1024;
/// Largest sum of all tags, bytes.
pub const MAX_TOTAL: usize = 64 * 1024 * 1024;

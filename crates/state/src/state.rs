//! What is kept, and a change of it.

use serde::{Deserialize, Serialize};

use crate::codec::Bytes;
use crate::{Damage, Limit};

/// Everything that is kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
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
    /// What its position means: type and units. Another text is another axis.
    pub kind: String,
    /// How it stands.
    pub state: AxisState,
}

/// How an axis stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AxisState {
    /// Its position, position units; finite.
    pub position: f64,
    /// Whether it is homed.
    pub homed: bool,
    /// Whether something moves it: the position is where it was a moment ago.
    pub moving: bool,
    /// Its faults since the last reset, a bit for each kind.
    pub faults: u32,
    /// What positions were shifted by without motion since the machine was built, position units; finite.
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

/// A change of a [`State`]. Places count from 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Change {
    /// An axis stands otherwise.
    Axis {
        /// Place of the axis.
        axis: u32,
        /// How it stands now.
        state: AxisState,
    },
    /// Bytes of a tag are others.
    Tag {
        /// Place of the tag.
        tag: u32,
        /// Offset of the first byte.
        offset: u32,
        /// What stands there now.
        #[serde(with = "crate::codec::bytes")]
        bytes: Bytes,
    },
}

impl State {
    /// Makes a change.
    ///
    /// # Errors
    /// [`Damage::NoSuchPlace`] and [`Damage::NotANumber`]; then nothing has changed.
    pub fn apply(&mut self, change: &Change) -> Result<(), Damage> {
        match change {
            Change::Axis { axis, state } => {
                let place = Damage::NoSuchPlace {
                    what: Limit::Axes,
                    place: *axis,
                };
                let kept = self.axes.get_mut(*axis as usize).ok_or(place)?;
                finite(*axis as usize, state)?;
                kept.state = *state;
            }
            Change::Tag { tag, offset, bytes } => {
                let from = *offset as usize;
                let kept = self.tags.get_mut(*tag as usize);
                let kept = kept.and_then(|kept| kept.bytes.get_mut(from..from.checked_add(bytes.len())?));
                kept.ok_or(Damage::NoSuchPlace {
                    what: Limit::Tags,
                    place: *tag,
                })?
                .copy_from_slice(bytes);
            }
        }
        Ok(())
    }

    /// What makes `next` of this state; `None` when `next` has other axes or tags, or has them in another order.
    pub fn changes_to(&self, next: &State) -> Option<Vec<Change>> {
        let axes = self
            .axes
            .iter()
            .map(|axis| (&axis.name, &axis.kind))
            .eq(next.axes.iter().map(|axis| (&axis.name, &axis.kind)));
        let shape = |tag: &Tag| (tag.name.clone(), tag.kind.clone(), tag.bytes.len());
        if !axes || !self.tags.iter().map(shape).eq(next.tags.iter().map(shape)) {
            return None;
        }
        let axes = (0..).zip(self.axes.iter().zip(&next.axes));
        let axes = axes.filter(|(_, (was, is))| was.state != is.state);
        let tags = (0..).zip(self.tags.iter().zip(&next.tags));
        let tags = tags.filter(|(_, (was, is))| was.bytes != is.bytes);
        Some(
            axes.map(|(axis, (_, is))| Change::Axis { axis, state: is.state })
                .chain(tags.map(|(tag, (_, is))| Change::Tag {
                    tag,
                    offset: 0,
                    bytes: is.bytes.clone(),
                }))
                .collect(),
        )
    }

    /// Holds a state against the limits.
    ///
    /// # Errors
    /// The first limit that it breaks, or a position that is not a number.
    pub fn check(&self) -> Result<(), Damage> {
        within(Limit::Axes, self.axes.len(), MAX_AXES)?;
        within(Limit::Tags, self.tags.len(), MAX_TAGS)?;
        for (place, axis) in self.axes.iter().enumerate() {
            within(Limit::Text, axis.name.len().max(axis.kind.len()), MAX_TEXT)?;
            finite(place, &axis.state)?;
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

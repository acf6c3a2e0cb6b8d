//! What an instruction needs besides its operands, and has from tags: made beside the tick, by whoever has the tags.

use std::sync::Arc;

use arcline_cam::Profile;
use arcline_instruction_set::MotionError;

/// What goes into the tick with a call.
///
/// The memory behind it is only read there. Whoever sends it keeps an [`Arc`] of its own until that is the last one, so
/// that the tick never frees anything.
#[derive(Clone, Debug)]
pub enum Material {
    /// What the instruction does was worked out beside the tick: it is done once its operands are verified.
    Done,
    /// It errs, once its operands are verified.
    Refused {
        /// Why.
        error: MotionError,
        /// The element of a cam that is to blame: SEGMENT.
        element: u32,
    },
    /// A calculated cam profile.
    Cam(Arc<Profile>),
}

/// What was sent for an instruction that works on tags, and the element to blame when it errs.
pub(crate) struct Sent(pub(crate) Option<Material>);

impl Sent {
    /// The element of a cam that is to blame for an error: SEGMENT.
    pub(crate) fn element(&self) -> u32 {
        match self.0 {
            Some(Material::Refused { element, .. }) => element,
            _ => 0,
        }
    }

    /// Of an instruction that was worked out beside the tick.
    ///
    /// # Errors
    /// What it errs with; `FeatureNotSupported` where nobody has worked it out.
    pub(crate) fn verdict(&self) -> Result<(), MotionError> {
        match &self.0 {
            Some(Material::Done) => Ok(()),
            Some(Material::Refused { error, .. }) => Err(*error),
            _ => Err(MotionError::FeatureNotSupported),
        }
    }

    /// The profile of a cam.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn cam(&self) -> Result<Arc<Profile>, MotionError> {
        match &self.0 {
            Some(Material::Cam(profile)) => Ok(profile.clone()),
            _ => self.verdict().and(Err(MotionError::FeatureNotSupported)),
        }
    }
}

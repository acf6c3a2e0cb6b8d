//! Forced inputs of modules: values that the controller's program sees in place of those that clients write. They hold until they are
//! removed or the server ends, in Run and in Program mode, and over a reload of the program.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use arcline_controller::image::{Image, TagId};
use arcline_tag::{DataType, Elementary, TagPath, Value};

/// A forced input.
#[derive(Clone, PartialEq, Debug)]
pub struct Force {
    /// Its name as it was given.
    pub name: String,
    /// The tag.
    pub tag: TagId,
    /// The first byte of the value in the tag.
    pub offset: usize,
    /// The bits of each byte that are forced, and their values.
    pub bytes: Vec<(u8, u8)>,
    /// The value.
    pub value: Value,
}

/// The reason for which an input cannot be forced.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum ForceError {
    /// The name is not that of a tag.
    #[error("{name}: {reason}")]
    NoTag {
        /// The name.
        name: String,
        /// The error of the name.
        reason: String,
    },
    /// The tag is not an input of a module.
    #[error("{name} is not an input of a module, expected a tag such as Local:1:I.Data.0; other tags can be written")]
    NoInput {
        /// The name.
        name: String,
    },
    /// The tag is a structure or an array.
    #[error("{name} is {data_type}, expected a BOOL, a bit or a number")]
    NoValue {
        /// The name.
        name: String,
        /// The type.
        data_type: String,
    },
    /// There are too many already.
    #[error("{MAX_FORCES} inputs are forced already, remove one first")]
    Full,
    /// The input is not forced.
    #[error("{name} is not forced")]
    NotForced {
        /// The name.
        name: String,
    },
}

impl Force {
    /// A value for an input of a module.
    ///
    /// # Errors
    /// [`ForceError`]: there is no such input, or it has no value that could be forced.
    pub fn new(image: &Image, name: &str, value: Value) -> Result<Self, ForceError> {
        let wrong = |reason: String| ForceError::NoTag {
            name: name.to_owned(),
            reason,
        };
        let path: TagPath = name
            .parse()
            .map_err(|error: arcline_tag::PathError| wrong(error.to_string()))?;
        let (tag, place) = image.locate(&path).map_err(|error| wrong(error.to_string()))?;
        // An alias of an input is that input.
        if !image.tag(tag).is_some_and(|tag| is_input(&tag.name)) {
            return Err(ForceError::NoInput { name: name.to_owned() });
        }
        let (offset, bytes) = match (place.bit, &place.data_type) {
            (Some(bit), _) => {
                let mask = 1 << (bit % 8);
                let on = if value.as_bool() { mask } else { 0 };
                (place.offset + usize::from(bit / 8), vec![(mask, on)])
            }
            (None, DataType::Elementary(kind)) if place.elements <= 1 || path.to_string().ends_with(']') => {
                let mut data = [0; 8];
                let data = data.get_mut(..kind.size()).unwrap_or_default();
                value.convert(*kind).write(data);
                let mask = if *kind == Elementary::Bool { 1 } else { 0xFF };
                (place.offset, data.iter().map(|byte| (mask, *byte)).collect())
            }
            (None, other) => {
                return Err(ForceError::NoValue {
                    name: name.to_owned(),
                    data_type: other.name().to_owned(),
                });
            }
        };
        Ok(Force {
            name: name.to_owned(),
            tag,
            offset,
            bytes,
            value,
        })
    }
}

/// Whether a tag is the input of a module: `Local:1:I`, `Rack:I`.
fn is_input(name: &str) -> bool {
    name.rsplit_once(':').is_some_and(|(_, part)| {
        let (head, number) = part.split_at_checked(1).unwrap_or_default();
        head.eq_ignore_ascii_case("I") && number.bytes().all(|byte| byte.is_ascii_digit())
    })
}

/// All forced inputs.
#[derive(Debug, Default)]
pub(crate) struct Forces {
    all: Mutex<Vec<Force>>,
    changes: AtomicU64,
}

impl Forces {
    /// Forces an input, in place of its force before.
    ///
    /// # Errors
    /// [`ForceError::Full`].
    pub(super) fn set(&self, force: Force) -> Result<(), ForceError> {
        let mut all = self.lock();
        let count = all.len();
        match all.iter_mut().find(|one| one.name.eq_ignore_ascii_case(&force.name)) {
            Some(one) => *one = force,
            None if count >= MAX_FORCES => return Err(ForceError::Full),
            None => all.push(force),
        }
        self.changes.fetch_add(1, Ordering::AcqRel);
        Ok(())
    }

    /// Removes the force of an input, or all of them.
    ///
    /// # Errors
    /// [`ForceError::NotForced`].
    pub(super) fn remove(&self, name: Option<&str>) -> Result<(), ForceError> {
        let mut all = self.lock();
        let before = all.len();
        all.retain(|one| name.is_some_and(|name| !one.name.eq_ignore_ascii_case(name)));
        if let Some(name) = name.filter(|_| all.len() == before) {
            return Err(ForceError::NotForced { name: name.to_owned() });
        }
        self.changes.fetch_add(1, Ordering::AcqRel);
        Ok(())
    }

    /// Another number for other forces.
    pub(crate) fn changes(&self) -> u64 {
        self.changes.load(Ordering::Acquire)
    }

    /// All of them.
    pub(crate) fn all(&self) -> Vec<Force> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Force>> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Inputs that may be forced at a time.
const MAX_FORCES: usize = 64;

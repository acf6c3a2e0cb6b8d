//! Values for tags by name, before a run or at the present tick.

use arcline_controller::image::{Image, ReadError, WriteEffect, WriteError};
use arcline_tag::{Fraction, Location, Misfit, PathSegment, TagPath, WriteValue};

use crate::calls::Origin;
use crate::end::Refused;
use crate::simulation::Simulation;

/// The reason why a value was not written.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NotWritten {
    /// The name is not a path of a tag.
    #[error("{0:?} is no path of a tag: {1}")]
    Path(String, String),
    /// The tag or its member does not exist.
    #[error("{0}")]
    Read(ReadError),
    /// The tag cannot hold the value, or is read-only.
    #[error("{0}")]
    Value(String),
}

/// A value as a part of a tag holds it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Encoded {
    /// A bit, counted from the first byte of the part.
    Bit(u8, bool),
    /// Bytes from the first one of the part.
    Bytes(Vec<u8>),
}

/// Encodes a value other than an array for the part of a tag that `text` names.
///
/// # Errors
/// The part cannot hold the value.
pub fn encoded(text: &str, location: &Location, value: &WriteValue) -> Result<Encoded, NotWritten> {
    if let Some(bit) = location.bit {
        return match value {
            WriteValue::Bool(on) => Ok(Encoded::Bit(bit, *on)),
            WriteValue::Integer(number @ 0..=1) => Ok(Encoded::Bit(bit, *number == 1)),
            _ => Err(NotWritten::Value(format!("{text} is a BOOL: expected true or false"))),
        };
    }
    let mut bytes = vec![0; location.data_type.size()];
    match value.encode(&location.data_type, Fraction::Refuse, &mut bytes) {
        Ok(()) => Ok(Encoded::Bytes(bytes)),
        Err(error) => {
            let why = match error {
                Misfit::OutOfRange => "cannot hold that value",
                Misfit::Fraction => "holds whole numbers only",
                Misfit::Kind => "holds values of another kind",
            };
            Err(NotWritten::Value(format!(
                "{text} is a {} and {why}",
                location.data_type.name()
            )))
        }
    }
}

/// Parses a path, and hands a value to `write`; an array by its elements, each with its own path.
///
/// # Errors
/// The text is no path, or the first error of `write`: the elements behind it are not written.
pub fn by_element(
    text: &str,
    value: &WriteValue,
    write: &mut impl FnMut(&str, &TagPath, &WriteValue) -> Result<(), NotWritten>,
) -> Result<(), NotWritten> {
    let path: TagPath = text
        .parse()
        .map_err(|error: arcline_tag::PathError| NotWritten::Path(text.to_owned(), error.to_string()))?;
    each(text, &path, value, write)
}

fn each(
    text: &str,
    path: &TagPath,
    value: &WriteValue,
    write: &mut impl FnMut(&str, &TagPath, &WriteValue) -> Result<(), NotWritten>,
) -> Result<(), NotWritten> {
    let WriteValue::Array(elements) = value else {
        return write(text, path, value);
    };
    (0..).zip(elements).try_for_each(|(index, element)| {
        let mut of_element = path.clone();
        of_element.0.push(PathSegment::Element(index));
        each(&format!("{text}[{index}]"), &of_element, element, write)
    })
}

/// Writes a value to tags that belong to no machine, and executes nothing: the errors are those of [`Simulation::write_tag`] with the same tags, but for
/// those of an instruction that a write executes.
///
/// # Errors
/// The tag does not exist, or cannot hold the value.
pub fn try_write(image: &mut Image, text: &str, value: &WriteValue) -> Result<(), NotWritten> {
    by_element(text, value, &mut |text, path, value| {
        let written = write_part(image, text, path, value);
        written.map(drop).map_err(|error| match error {
            PartError::Write(error) => refused(text, error.into()),
            PartError::Misfit(error) => error,
        })
    })
}

/// The reason why a part of a tag was not written.
enum PartError {
    Write(WriteError),
    Misfit(NotWritten),
}

/// Writes a value other than an array.
fn write_part(
    image: &mut Image,
    text: &str,
    path: &TagPath,
    value: &WriteValue,
) -> Result<Option<WriteEffect>, PartError> {
    let located = image.locate(path);
    let (id, location) = located.map_err(|error| PartError::Write(error.into()))?;
    let written = match encoded(text, &location, value).map_err(PartError::Misfit)? {
        Encoded::Bit(bit, on) => image.write_bit(id, location.offset, bit, on),
        Encoded::Bytes(bytes) => image.write(id, location.offset, &bytes),
    };
    written.map_err(PartError::Write)
}

fn refused(text: &str, error: Refused) -> NotWritten {
    match error {
        Refused::Write(WriteError::Read(error)) => NotWritten::Read(error),
        error => NotWritten::Value(format!("{text}: {error}")),
    }
}

impl Simulation {
    /// Writes a value to the tag of a path; for an array, to its first elements. A write to `EnableIn` executes its instruction at
    /// the present tick.
    ///
    /// # Errors
    /// The tag does not exist, or cannot hold the value.
    pub fn write_tag(&mut self, text: &str, value: &WriteValue) -> Result<(), NotWritten> {
        by_element(text, value, &mut |text, path, value| self.write_one(text, path, value))
    }

    fn write_one(&mut self, text: &str, path: &TagPath, value: &WriteValue) -> Result<(), NotWritten> {
        let mut misfit = None;
        let written = self.write(Origin::default(), |image| {
            write_part(image, text, path, value).or_else(|error| match error {
                PartError::Write(error) => Err(error),
                PartError::Misfit(error) => {
                    misfit = Some(error);
                    Ok(None)
                }
            })
        });
        match (misfit, written) {
            (Some(misfit), _) => Err(misfit),
            (None, Ok(_)) => Ok(()),
            (None, Err(error)) => Err(refused(text, error)),
        }
    }

    /// Updates the motion control tag of a path to the present moment.
    pub fn show_control_of(&mut self, path: &TagPath) {
        let slot = path
            .tag()
            .and_then(|tag| self.image().known_control(tag).ok().flatten());
        if let Some(slot) = slot {
            self.show_control(slot);
        }
    }
}

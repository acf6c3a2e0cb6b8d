//! Values for tags by name, before a run or at the present tick.

use arcline_controller::image::{ReadError, WriteError};
use arcline_tag::{Fraction, Misfit, PathSegment, TagPath, WriteValue};

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

impl Simulation {
    /// Writes a value to the tag of a path; for an array, to its first elements. A write to `EnableIn` executes its instruction at
    /// the present tick.
    ///
    /// # Errors
    /// The tag does not exist, or cannot hold the value.
    pub fn write_tag(&mut self, text: &str, value: &WriteValue) -> Result<(), NotWritten> {
        let path: TagPath = text
            .parse()
            .map_err(|error: arcline_tag::PathError| NotWritten::Path(text.to_owned(), error.to_string()))?;
        self.write_at(text, &path, value)
    }

    fn write_at(&mut self, text: &str, path: &TagPath, value: &WriteValue) -> Result<(), NotWritten> {
        if let WriteValue::Array(elements) = value {
            for (index, element) in (0..).zip(elements) {
                let mut of_element = path.clone();
                of_element.0.push(PathSegment::Element(index));
                self.write_at(&format!("{text}[{index}]"), &of_element, element)?;
            }
            return Ok(());
        }
        let mut misfit = None;
        let written = self.write(Origin::default(), |image| {
            let (id, location) = image.locate(path)?;
            if let Some(bit) = location.bit {
                let on = match value {
                    WriteValue::Bool(on) => *on,
                    WriteValue::Integer(number @ 0..=1) => *number == 1,
                    _ => {
                        misfit = Some(format!("{text} is a BOOL: expected true or false"));
                        return Ok(None);
                    }
                };
                return image.write_bit(id, location.offset, bit, on);
            }
            let mut bytes = vec![0; location.data_type.size()];
            if let Err(error) = value.encode(&location.data_type, Fraction::Refuse, &mut bytes) {
                let why = match error {
                    Misfit::OutOfRange => "cannot hold that value",
                    Misfit::Fraction => "holds whole numbers only",
                    Misfit::Kind => "holds values of another kind",
                };
                misfit = Some(format!("{text} is a {} and {why}", location.data_type.name()));
                return Ok(None);
            }
            image.write(id, location.offset, &bytes)
        });
        if let Some(misfit) = misfit {
            return Err(NotWritten::Value(misfit));
        }
        match written {
            Ok(_) => Ok(()),
            Err(Refused::Write(WriteError::Read(error))) => Err(NotWritten::Read(error)),
            Err(error) => Err(NotWritten::Value(format!("{text}: {error}"))),
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

//! The names of a machine's tags, for the check of Structured Text.

use arcline_controller::image::{Image, ReadError};
use arcline_instruction_set::{Directory as _, Object};
use arcline_structured_text::Names;
use arcline_tag::{PathError, TagPath};

/// The names of an image, for the check of a program.
#[derive(Debug)]
pub struct ImageNames<'i>(pub &'i Image);

impl Names for ImageNames<'_> {
    fn is_object(&self, object: Object, name: &str) -> bool {
        self.0.object(object, name).is_some()
    }

    fn locate(&self, path: &TagPath) -> Option<Result<(), PathError>> {
        match self.0.locate(path) {
            Err(ReadError::NoSuchTag { .. }) => None,
            Err(ReadError::Path(error)) => Some(Err(error)),
            Ok(_) | Err(ReadError::NotAValue { .. }) => Some(Ok(())),
        }
    }

    fn objects(&self, object: Object) -> Vec<String> {
        let names = self.0.tags().iter().filter(|tag| self.is_object(object, &tag.name));
        names.map(|tag| tag.name.clone()).collect()
    }

    fn tags(&self) -> Vec<String> {
        self.0.tags().iter().map(|tag| tag.name.clone()).collect()
    }
}

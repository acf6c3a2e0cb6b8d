//! Reading: from a path to a location in a tag, and to the values there.

use arcline_tag::{DataType, Location, PathError, PathSegment, TagPath, Value, scope};

use super::{Image, ReadError, Tag, TagId, TagKind};

impl Image {
    /// The location of a path. The status bits of an instruction tag need no `MotionControl`: `Move1.PC` is `Move1.MotionControl.PC`.
    ///
    /// # Errors
    /// [`ReadError::NoSuchTag`], or the part of the path that does not exist.
    pub fn locate(&self, path: &TagPath) -> Result<(TagId, Location), ReadError> {
        self.resolve(&path.0)
    }

    /// As [`Image::locate`], from the segments of a path: the tag, and the location in its bytes.
    ///
    /// # Errors
    /// As [`Image::locate`].
    pub fn resolve<S: AsRef<str>>(&self, segments: &[PathSegment<S>]) -> Result<(TagId, Location), ReadError> {
        let (program, name, rest) = scope(segments);
        let name = name.ok_or(PathError::Empty)?;
        let tag = self
            .names
            .get(program, name)
            .and_then(|id| self.tag(id))
            .ok_or_else(|| ReadError::NoSuchTag { name: name.to_owned() })?;
        Ok(self.resolve_in(tag, rest)?)
    }

    /// The location of the segments behind a tag's name; of an alias, in its target.
    ///
    /// # Errors
    /// The member, index or bit that does not exist.
    pub fn resolve_in<S: AsRef<str>>(
        &self,
        tag: &Tag,
        rest: &[PathSegment<S>],
    ) -> Result<(TagId, Location), PathError> {
        if tag.kind.is_part_of_project() {
            return Err(PathError::Empty);
        }
        let mut location = arcline_instruction_set::locate(&tag.tag_type, rest)?;
        let TagKind::Alias(alias) = tag.kind else {
            return Ok((tag.id, location));
        };
        location.offset += alias.offset;
        location.bit = location.bit.or(alias.bit);
        Ok((alias.tag, location))
    }

    /// The value at a path; of an array, the element at the path or its first one.
    ///
    /// # Errors
    /// [`ReadError::NotAValue`] for a structure, else see [`Image::locate`].
    pub fn read(&self, path: &TagPath) -> Result<Value, ReadError> {
        let (id, location) = self.locate(path)?;
        value_at(self.bytes(id), &location).ok_or_else(|| not_a_value(path, &location))
    }

    /// The numbers from a path to the end of its array.
    ///
    /// # Errors
    /// As [`Image::read`].
    pub fn read_numbers(&self, path: &TagPath) -> Result<Vec<f64>, ReadError> {
        let (id, location) = self.locate(path)?;
        let DataType::Elementary(kind) = location.data_type else {
            return Err(not_a_value(path, &location));
        };
        if location.bit.is_some() {
            let value = value_at(self.bytes(id), &location).ok_or_else(|| not_a_value(path, &location))?;
            return Ok(vec![value.as_f64()]);
        }
        let bytes = self.bytes(id).get(location.offset..).unwrap_or_default();
        let elements = bytes.chunks_exact(kind.size()).take(location.elements as usize);
        Ok(elements
            .filter_map(|bytes| Value::read(kind, bytes))
            .map(Value::as_f64)
            .collect())
    }
}

fn value_at(bytes: &[u8], location: &Location) -> Option<Value> {
    let DataType::Elementary(kind) = location.data_type else {
        return None;
    };
    if let Some(bit) = location.bit {
        let byte = bytes.get(location.offset + usize::from(bit / 8))?;
        return Some(Value::Bool(byte & 1 << (bit % 8) != 0));
    }
    Value::read(kind, bytes.get(location.offset..)?)
}

pub(super) fn not_a_value(path: &TagPath, location: &Location) -> ReadError {
    ReadError::NotAValue {
        path: path.to_string(),
        data_type: location.data_type.name().to_owned(),
    }
}

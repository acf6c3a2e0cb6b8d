//! Values of tags by name. Tags of the project are read and written in its memory, also those that clients do not see; tags of the machine in the tag
//! memory. An array of BOOLs is one of truths here, as routines see it.

use arcline_controller::image::{ReadError, TagId};
use arcline_routine::Tag;
use arcline_simulation::{Encoded, NotWritten, by_element, encoded};
use arcline_tag::{DataType, Elementary, Location, PathError, PathSegment, TagPath, TagValue, WriteValue};

use crate::decode::{array, text_layout, truth, truths};
use crate::simulated::SimulatedCell;

/// The memory that has a tag.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Memory {
    /// That of the project: the first byte of the tag.
    Project(usize),
    /// The tag memory of the machine.
    Machine(TagId),
}

/// A part of a tag.
#[derive(Clone, Debug)]
struct Part {
    memory: Memory,
    location: Location,
    /// The size of each dimension of an array as a whole; zeros behind the last.
    dimensions: [u32; 3],
    /// The elements of an array of BOOLs.
    bits: Option<u32>,
}

impl SimulatedCell {
    /// Whether a path leads to a tag or a part of one.
    pub fn has(&self, path: &TagPath) -> bool {
        self.part(path).is_ok()
    }

    /// The value at a path, at the present tick.
    ///
    /// # Errors
    /// There is no such tag, or it has no such part.
    pub fn value(&mut self, path: &TagPath) -> Result<TagValue, ReadError> {
        let part = self.part(path)?;
        let bytes = match part.memory {
            Memory::Project(at) => self.cell.memory().get(at..),
            Memory::Machine(id) => {
                let simulation = self.plant.simulation_mut();
                simulation.show();
                simulation.show_control_of(path);
                Some(simulation.image().bytes(id))
            }
        };
        let bytes = bytes.and_then(|bytes| bytes.get(part.location.offset..));
        bytes
            .and_then(|bytes| part.value(bytes))
            .ok_or_else(|| ReadError::NotAValue {
                path: path.to_string(),
                data_type: part.location.data_type.name().to_owned(),
            })
    }

    /// Writes a value to the tag of a path; for an array, to its first elements. The project sees it in its next scan. A write to a tag of the machine,
    /// such as `EnableIn` of an instruction, acts in the next tick, which it begins.
    ///
    /// # Errors
    /// The tag does not exist, or cannot hold the value.
    pub fn write(&mut self, text: &str, value: &WriteValue) -> Result<(), NotWritten> {
        by_element(text, value, &mut |text, path, value| self.write_one(text, path, value))
    }

    fn write_one(&mut self, text: &str, path: &TagPath, value: &WriteValue) -> Result<(), NotWritten> {
        let part = self.part(path).map_err(NotWritten::Read)?;
        let at = match part.memory {
            Memory::Project(at) => at,
            Memory::Machine(_) => {
                self.open();
                self.plant.simulation_mut().write_tag(text, value)?;
                self.plant.show(self.cell.memory_mut());
                return Ok(());
            }
        };
        let new = match (text_layout(&part.location.data_type), value) {
            (Some((data, capacity)), WriteValue::Text(new)) if new.len() <= capacity => {
                let mut bytes = vec![0; part.location.data_type.size()];
                bytes
                    .iter_mut()
                    .zip((new.len() as u32).to_le_bytes())
                    .for_each(|(place, byte)| *place = byte);
                bytes
                    .iter_mut()
                    .skip(data)
                    .zip(new.bytes())
                    .for_each(|(place, byte)| *place = byte);
                Encoded::Bytes(bytes)
            }
            _ => encoded(text, &part.location, value)?,
        };
        let (memory, at) = (self.cell.memory_mut(), at + part.location.offset);
        match new {
            Encoded::Bit(bit, on) => {
                let mask = 1 << (bit % 8);
                memory.put_bits(at + usize::from(bit / 8), mask, if on { mask } else { 0 });
            }
            Encoded::Bytes(bytes) => memory.write(at, &bytes),
        }
        Ok(())
    }

    fn part(&self, path: &TagPath) -> Result<Part, ReadError> {
        if let [outer @ .., PathSegment::Element(index)] = path.0.as_slice()
            && let Ok(array) = self.plain_part(&TagPath(outer.to_vec()))
            && let Some(bits) = array.bits
        {
            if *index >= bits {
                let (index, size) = (*index, bits);
                return Err(PathError::IndexOutOfRange { index, size }.into());
            }
            return Ok(Part {
                location: Location {
                    offset: array.location.offset + *index as usize / 32 * 4,
                    elements: 1,
                    bit: Some((*index % 32) as u8),
                    ..array.location
                },
                dimensions: [0; 3],
                bits: None,
                ..array
            });
        }
        self.plain_part(path)
    }

    /// A part of a tag that is no element of an array of BOOLs.
    fn plain_part(&self, path: &TagPath) -> Result<Part, ReadError> {
        let (program, name, rest) = path.scope();
        let name = name.ok_or(PathError::Empty)?;
        let Some(tag) = self.tag(program, name) else {
            return self.other_part(path);
        };
        let objects = &self.plant.places().objects;
        let object = objects.iter().find(|(at, _)| *at == tag.at);
        let memory = object.map_or(Memory::Project(tag.at as usize), |(_, id)| Memory::Machine(*id));
        let locate = |rest: &[PathSegment]| arcline_instruction_set::locate(&tag.tag_type, rest);
        let location = locate(rest)?;
        let dimensions = match rest {
            [] => tag.tag_type.dimensions,
            _ => dimensions_at(&location, rest, |rest| locate(rest).is_ok()),
        };
        let bits = match rest {
            [] => tag.bits(),
            _ => bits_of_member(&location, dimensions),
        };
        Ok(Part {
            memory,
            location,
            dimensions,
            bits,
        })
    }

    /// A part of an alias, or of a tag that only the machine has.
    fn other_part(&self, path: &TagPath) -> Result<Part, ReadError> {
        let image = self.plant.simulation().image();
        let (id, location) = image.locate(path)?;
        let placed = self.plant.places().tag(id);
        let memory = placed.map_or(Memory::Machine(id), |placed| Memory::Project(placed.from));
        let dimensions = dimensions_at(&location, &path.0, |segments| image.resolve(segments).is_ok());
        let bits = placed.and_then(|_| bits_of_member(&location, dimensions));
        Ok(Part {
            memory,
            location,
            dimensions,
            bits,
        })
    }

    fn tag(&self, program: Option<&str>, name: &str) -> Option<&Tag> {
        let number = self
            .names
            .get(&(program.map(str::to_ascii_lowercase), name.to_ascii_lowercase()))?;
        self.cell.tags().get(*number)
    }
}

/// The dimensions of a member: an array has an element 0.
fn dimensions_at(location: &Location, rest: &[PathSegment], leads: impl Fn(&[PathSegment]) -> bool) -> [u32; 3] {
    if location.bit.is_some() || matches!(rest.last(), Some(PathSegment::Element(_))) {
        return [0; 3];
    }
    let mut first = rest.to_vec();
    first.push(PathSegment::Element(0));
    if leads(&first) {
        [location.elements, 0, 0]
    } else {
        [0; 3]
    }
}

fn bits_of_member(location: &Location, dimensions: [u32; 3]) -> Option<u32> {
    let is_array_of_words = dimensions[0] > 0 && location.data_type == DataType::Elementary(Elementary::Dword);
    is_array_of_words.then_some(32 * dimensions[0])
}

impl Part {
    fn value(&self, bytes: &[u8]) -> Option<TagValue> {
        if let Some(bit) = self.location.bit {
            return truth(bytes, usize::from(bit));
        }
        if let Some(bits) = self.bits {
            return truths(bytes, bits as usize);
        }
        array(&self.location.data_type, &self.dimensions, bytes)
    }
}

//! Names for instructions: objects and arrays among the tags, and the call of an instruction tag.

use arcline_instruction_set::{
    BindError, Call, Directory, Object, TagAddress, WrittenArray, bind, instruction_tag_operands,
    instruction_tag_target,
};
use arcline_tag::{DataType, Elementary};

use super::{Image, TagId, TagKind};
use crate::{InstructionWrite, WrittenValues};

impl Image {
    /// The instruction of an instruction tag, with its present target and operands. A target that does not exist gives a call without a target,
    /// which errs with 13, 0 as on every other interface.
    ///
    /// # Errors
    /// A name among the operands that is unknown. `None`: not an instruction tag.
    pub fn call_of(&self, id: TagId) -> Option<Result<Call, BindError>> {
        let tag = self.tag(id)?;
        let TagKind::Instruction(kind) = tag.kind else {
            return None;
        };
        let bytes = self.bytes(id);
        let target = instruction_tag_target(kind.mnemonic, bytes);
        let target = self.object(kind.mnemonic.instruction().object, &target);
        let operands = instruction_tag_operands(kind.mnemonic, &tag.name, bytes);
        Some(bind(kind.mnemonic, target, kind.control, &operands, self))
    }

    /// Takes over a write of an instruction to a tag. A tag that no longer exists is ignored; a restart does not retain the values.
    pub fn apply_instruction_write(&mut self, write: &InstructionWrite) {
        match write.values {
            WrittenValues::Numbers(numbers) => self.apply_numbers(write.tag, numbers.as_slice()),
            WrittenValues::Bits { mask, bits } => self.apply_bits(write.tag, mask, bits),
        }
    }

    fn apply_numbers(&mut self, tag: TagAddress, numbers: &[f64]) {
        let Some((id, offset, elements)) = self.written_array(tag) else {
            return;
        };
        let Some(bytes) = self.bytes_mut(id).and_then(|bytes| bytes.get_mut(offset..)) else {
            return;
        };
        let values = numbers.iter().take(elements);
        for (value, real) in values.zip(bytes.chunks_exact_mut(4)) {
            real.copy_from_slice(&(*value as f32).to_le_bytes());
        }
        self.note_part(id, offset, 4 * numbers.len().min(elements), 0xFF);
    }

    /// The location of a REAL array that an instruction writes; `tag` is the address from [`Directory::real_array`].
    /// Tag, byte offset and number of elements.
    pub fn written_array(&self, tag: TagAddress) -> Option<(TagId, usize, usize)> {
        let (id, offset) = tag_and_offset(tag);
        let tag = self.tag(id)?;
        let end = match &tag.tag_type.data_type {
            DataType::Structure(template) => {
                let member = template.members.iter().find(|member| {
                    let from = member.offset as usize;
                    (from..from + member.size()).contains(&offset) && member.dimension > 0
                })?;
                member.offset as usize + member.size()
            }
            DataType::Elementary(_) => tag.tag_type.size(),
        };
        Some((id, offset, end.checked_sub(offset)? / 4))
    }
}

/// The tag and the first byte of an address.
pub(super) fn tag_and_offset(address: TagAddress) -> (TagId, usize) {
    (TagId(address.tag()), address.offset())
}

impl Directory for Image {
    fn object(&self, object: Object, name: &str) -> Option<u16> {
        match (self.find(name)?.kind, object) {
            (TagKind::MotionGroup, Object::MotionGroup) => Some(0),
            (TagKind::Axis(axis), Object::Axis) => Some(axis.0),
            (TagKind::CoordinateSystem(system), Object::CoordinateSystem) => Some(system.0),
            _ => None,
        }
    }

    fn real_array(&self, name: &str) -> Option<WrittenArray> {
        let (id, location) = self.locate(&name.parse().ok()?).ok()?;
        let real = location.data_type == DataType::Elementary(Elementary::Real) && location.bit.is_none();
        let for_instructions = self.tag(id)?.kind != TagKind::FeedOverride;
        let writable = for_instructions && self.writable(id, location.offset, 4 * location.elements as usize);
        let tag = TagAddress::new(id.0, location.offset).filter(|_| real && writable)?;
        let (_, _, elements) = self.written_array(tag)?;
        Some(WrittenArray {
            tag,
            elements: elements.min(usize::from(u16::MAX)) as u16,
        })
    }

    fn structure(&self, type_name: &str, name: &str) -> Option<TagAddress> {
        let (id, location) = self.locate(&name.parse().ok()?).ok()?;
        // INT[4] stands for an array of four elements or more.
        let (type_name, least) = match type_name.strip_suffix(']').and_then(|array| array.split_once('[')) {
            Some((element, count)) => (element, count.parse().ok()?),
            None => (type_name, 1),
        };
        let named = location.data_type.name().eq_ignore_ascii_case(type_name) && location.bit.is_none();
        let named = named && location.elements >= least;
        let plain = self.tag(id)?.kind == TagKind::Plain;
        TagAddress::new(id.0, location.offset).filter(|_| named && plain)
    }
}

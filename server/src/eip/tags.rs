//! Tag services: read, write, both in fragments, and read-modify-write (spec/ethernet-ip.md §9).
//!
//! The bytes are the image's; here are types, elements and statuses. A refused write changes nothing. Surplus bytes
//! behind a request are ignored, since stock clients send them.

use std::borrow::Cow;

use arcline_controller::image::{Image, ReadError, TagId, TagKind};
use arcline_proto::cip::{CipStatus, Reply, Request};
use arcline_proto::epath::Target;
use arcline_proto::logix::{ReadModifyWrite, ReadTag, WireType, WriteTag};
use arcline_proto::status::general_error;
use arcline_state::planted::is_planted;
use arcline_tag::{DataType, Elementary, Location, clamp_strings};

use super::action::{TagRead, TagWrite};
use super::context::{Context, Memory};
use super::status::{path_status, refusal, unknown};
use crate::plant::{Command, Outcome, Refused, Transaction};

/// Reads a tag that a path names, by name or by its instance of class 0x6B.
pub(crate) fn read(cx: &Context<'_>, image: &Image, request: &Request, target: &Target<'_>, how: TagRead) -> Reply {
    let code = request.service;
    let decode = match how {
        TagRead::Whole => ReadTag::decode,
        TagRead::Fragment => ReadTag::decode_fragmented,
    };
    let done = TagPart::find(image, target).and_then(|part| Ok((part, decode(&request.data)?)));
    match done {
        Ok((part, read)) => part.read(code, image, read, cx.budget),
        Err(status) => Reply::error(code, status),
    }
}

/// Writes a tag that a path names, by name or by its instance of class 0x6B.
pub(crate) fn write(memory: Memory<'_, '_>, request: &Request, target: &Target<'_>, how: TagWrite) -> Reply {
    let done = TagPart::find(memory.image(), target).and_then(|part| match (how, memory) {
        (TagWrite::Whole, Memory::Write(transaction)) => {
            part.write(transaction, &WriteTag::decode(&request.data)?, Extent::Whole)
        }
        (TagWrite::Fragment, Memory::Write(transaction)) => {
            part.write(transaction, &WriteTag::decode_fragmented(&request.data)?, Extent::Part)
        }
        (TagWrite::Modify, Memory::Write(transaction)) => {
            part.modify(transaction, ReadModifyWrite::decode(&request.data)?)
        }
        (_, Memory::Read(_)) => Err(CipStatus::RESOURCE_UNAVAILABLE),
    });
    match done {
        Ok(()) => Reply::success(request.service, &[][..]),
        Err(status) => Reply::error(request.service, status),
    }
}

/// Whether a path is in a tag of an instruction that stops or switches off, or in the tag of STOP.
pub(crate) fn is_of_stop(image: &Image, target: &Target<'_>) -> bool {
    let tag = TagPart::find(image, target).ok().and_then(|part| image.tag(part.tag));
    match tag.map(|tag| tag.kind) {
        Some(TagKind::Instruction(kind)) => kind.mnemonic.is_stop(),
        Some(kind) => kind == TagKind::MotionInhibit,
        None => false,
    }
}

/// The program in whose scope an instance of class 0x6B is meant: `Program:Main` in front of the class.
pub(crate) fn scope(image: &Image, target: &Target<'_>) -> Result<Option<u16>, CipStatus> {
    let Some(name) = target.first_symbol() else {
        return Ok(None);
    };
    match image.find(name).map(|tag| tag.kind) {
        Some(TagKind::Program(index)) if target.symbols.len() == 1 => Ok(Some(index)),
        _ => Err(unknown()),
    }
}

/// The elements that a write must bring.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Extent {
    /// All of them.
    Whole,
    /// As many as the data of the write have.
    Part,
}

/// The part of a tag that a path names.
struct TagPart {
    tag: TagId,
    location: Location,
}

impl TagPart {
    fn find(image: &Image, target: &Target<'_>) -> Result<Self, CipStatus> {
        if target.class.is_none() && target.attribute.is_some() {
            return Err(CipStatus::PATH_SEGMENT_ERROR.with(0));
        }
        let (tag, location) = match target.instance {
            None => image.resolve(&target.symbols).map_err(|error| match error {
                ReadError::Path(error) => path_status(&error),
                _ => unknown(),
            })?,
            Some(instance) => {
                let tag = image.tag(TagId(instance)).ok_or_else(unknown)?;
                if scope(image, target)? != tag.program {
                    return Err(unknown());
                }
                image
                    .resolve_in(tag, &target.members)
                    .map_err(|error| path_status(&error))?
            }
        };
        Ok(Self { tag, location })
    }

    /// A bit travels as a BOOL.
    fn wire_type(&self) -> WireType {
        match (&self.location.data_type, self.location.bit) {
            (_, Some(_)) => Elementary::Bool.into(),
            (DataType::Elementary(kind), None) => (*kind).into(),
            (DataType::Structure(template), None) => WireType::Structure(template.handle),
        }
    }

    fn element_size(&self) -> usize {
        if self.location.bit.is_some() {
            1
        } else {
            self.location.element_size()
        }
    }

    fn check_elements(&self, elements: u16) -> Result<usize, CipStatus> {
        let available = if self.location.bit.is_some() {
            1
        } else {
            self.location.elements
        };
        if elements == 0 || u32::from(elements) > available {
            return Err(CipStatus::GENERAL_ERROR.with(general_error::ELEMENTS_BEYOND_TAG));
        }
        Ok(usize::from(elements) * self.element_size())
    }

    fn read(&self, code: u8, image: &Image, read: ReadTag, budget: usize) -> Reply {
        match self.bytes(image, read.elements) {
            Ok(all) => read.reply(code, self.wire_type(), self.element_size(), &all, budget),
            Err(status) => Reply::error(code, status),
        }
    }

    /// The elements as they travel.
    fn bytes<'i>(&self, image: &'i Image, elements: u16) -> Result<Cow<'i, [u8]>, CipStatus> {
        let size = self.check_elements(elements)?;
        let Location {
            offset, data_type, bit, ..
        } = &self.location;
        let bytes = image.bytes(self.tag);
        if let Some(bit) = bit {
            let byte = bytes.get(offset + usize::from(bit / 8)).ok_or_else(unknown)?;
            let value: &[u8] = if byte >> (bit % 8) & 1 == 0 { &[0] } else { &[1] };
            return Ok(value.into());
        }
        let bytes = bytes.get(*offset..offset + size).ok_or_else(unknown)?;
        let DataType::Structure(template) = data_type else {
            return Ok(bytes.into());
        };
        let mut bytes = bytes.to_vec();
        bytes
            .chunks_mut(template.size.max(1) as usize)
            .for_each(|element| clamp_strings(template, element));
        Ok(bytes.into())
    }

    fn write(&self, transaction: &mut Transaction<'_>, write: &WriteTag, extent: Extent) -> Result<(), CipStatus> {
        if write.data_type != self.wire_type() && !is_planted("type not checked") {
            return Err(CipStatus::GENERAL_ERROR.with(general_error::TYPE_MISMATCH));
        }
        let total = self.check_elements(write.elements)?;
        let start = usize::try_from(write.offset).unwrap_or(usize::MAX);
        if start >= total {
            return Err(CipStatus::GENERAL_ERROR.with(general_error::OFFSET_BEYOND_DATA));
        }
        let wanted = match extent {
            Extent::Whole => total,
            Extent::Part => write.data.len().clamp(1, total - start),
        };
        let data = write.data.get(..wanted).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
        let is_bool = write.data_type == Elementary::Bool.into();
        let (tag, offset) = (self.tag, self.location.offset);
        let values: Vec<u8>;
        let command = match (self.location.bit, data) {
            (Some(bit), [value, ..]) => {
                let on = *value != 0;
                Command::WriteBit { tag, offset, bit, on }
            }
            (_, data) => {
                let offset = offset + start;
                values = data.iter().map(|value| u8::from(*value != 0)).collect();
                let data = if is_bool { values.as_slice() } else { data };
                Command::WriteTag { tag, offset, data }
            }
        };
        done(transaction.apply(command))
    }

    fn modify(&self, transaction: &mut Transaction<'_>, masks: ReadModifyWrite) -> Result<(), CipStatus> {
        match self.location {
            Location {
                data_type: DataType::Elementary(kind),
                bit: None,
                ..
            } if kind.has_bits() => {}
            _ => return Err(CipStatus::GENERAL_ERROR.with(general_error::TYPE_MISMATCH)),
        }
        let mut integer = self.bytes(transaction.image(), 1)?.into_owned();
        masks.apply(&mut integer)?;
        done(transaction.apply(Command::WriteTag {
            tag: self.tag,
            offset: self.location.offset,
            data: &integer,
        }))
    }
}

/// The status of a write.
fn done(outcome: Result<Outcome, Refused>) -> Result<(), CipStatus> {
    outcome.map(drop).map_err(|refused| refusal(&refused))
}

//! Motion Instruction, class 0x0303 (spec/contract.md §4): one instance for each of the newest 4,096 executed
//! instructions, and for each older one that still runs or has ended since it was among them.
//!
//! | attribute | type | |
//! |---|---|---|
//! | 1 | DWORD | FLAGS |
//! | 2 | INT | ERR |
//! | 3 | SINT | STATUS |
//! | 4 | SINT | STATE |
//! | 5 | DINT | SEGMENT |
//! | 6 | SINT | EXERR |
//! | 7 | 16 bytes | the MOTION_INSTRUCTION structure; Get Attributes All returns it |
//! | 8 | structure | the cause that ended the instruction without PC and without an error |
//!
//! Attribute 8: USINT 0 no cause, 1 another instruction, 2 faults of an axis, 3 a stop of the whole machine, 4 the end of a jog by
//! the server; SHORT_STRING the other's motion control tag, or the axis; SHORT_STRING its mnemonic, or the faults as words with blanks
//! between them, or of a jog `released` (the button of the page), `silent` or `lost` (the client that began it); LREAL the time of the machine, s; ULINT the time, µs since 1970-01-01 UTC.

use std::time::UNIX_EPOCH;

use arcline_instruction_set::MotionControl;
use arcline_proto::arcline::execution::{self, attribute};
use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::object::{Extent, Object, ObjectContext};
use super::values::no_attribute;
use crate::plant::Plant;

#[derive(Debug)]
pub(super) struct MotionInstructions;

fn find(plant: &Plant, instance: u32) -> Result<MotionControl, CipStatus> {
    plant
        .instruction_instance(instance)
        .ok_or(CipStatus::OBJECT_DOES_NOT_EXIST)
}

fn ending(plant: &Plant, instance: u32) -> execution::Ending {
    let Some(ended) = plant.instruction_ending(instance) else {
        return execution::Ending::default();
    };
    let (code, name, detail) = ended.ending.to_parts();
    let since = ended.at.duration_since(UNIX_EPOCH).unwrap_or_default();
    execution::Ending {
        code,
        name: name.to_owned(),
        detail,
        time: ended.time,
        utc_micros: u64::try_from(since.as_micros()).unwrap_or(u64::MAX),
    }
}

impl Object for MotionInstructions {
    fn class(&self) -> u16 {
        execution::CLASS
    }

    fn name(&self) -> &'static str {
        "Motion Instruction"
    }

    fn is_late(&self) -> bool {
        true
    }

    fn extent(&self, cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        let plant = &cx.device().plant;
        Ok(Extent {
            highest: plant.newest_instance().unwrap_or(0),
            count: u32::try_from(plant.instances()).unwrap_or(u32::MAX),
            last_attribute: attribute::ENDING,
        })
    }

    /// 0x16, whether it was dropped or never was.
    fn check(&self, cx: &ObjectContext<'_, '_>, instance: u32) -> Result<(), CipStatus> {
        find(&cx.device().plant, instance).map(drop)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let plant = &cx.device().plant;
        let bytes = Bytes::copy_from_slice(&find(plant, instance)?.to_bytes());
        match id {
            attribute::FLAGS => Ok(bytes.slice(0..4)),
            attribute::ERR => Ok(bytes.slice(4..6)),
            attribute::STATUS => Ok(bytes.slice(6..7)),
            attribute::STATE => Ok(bytes.slice(7..8)),
            attribute::SEGMENT => Ok(bytes.slice(8..12)),
            attribute::EXERR => Ok(bytes.slice(12..13)),
            attribute::CONTROL => Ok(bytes),
            attribute::ENDING => Ok(ending(plant, instance).to_bytes()),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[attribute::CONTROL]
    }
}

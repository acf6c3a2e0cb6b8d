//! Motion Instruction, class 0x0303 (spec/contract.md §4): one instance for every instruction that was executed, the
//! newest 4,096 kept.
//!
//! | attribute | type | |
//! |---|---|---|
//! | 1 | DWORD | FLAGS |
//! | 2 | INT | ERR |
//! | 3 | SINT | STATUS |
//! | 4 | SINT | STATE |
//! | 5 | DINT | SEGMENT |
//! | 6 | SINT | EXERR |
//! | 7 | 16 bytes | the MOTION_INSTRUCTION structure; this is what Get Attributes All returns |
//! | 8 | structure | why the instruction ended that has ended without PC and without an error |
//!
//! Attribute 8: USINT 0 nothing to say, 1 another instruction, 2 faults of an axis, 3 a stop of the whole machine, 4 the end of a jog by
//! the server; SHORT_STRING the other's motion control tag, or the axis; SHORT_STRING its mnemonic, or the faults as words with blanks
//! between them, or of a jog `released` (the button of the page), `silent` or `lost` (the client that began it); LREAL the time of the machine, s; ULINT the time, µs since 1970-01-01 UTC.

use std::time::UNIX_EPOCH;

use arcline_instruction_set::MotionControl;
use arcline_proto::arcline::execution::{self, attribute};
use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, no_attribute};
use crate::plant::Plant;

pub(super) struct MotionInstructions<'a>(pub(super) &'a Plant);

impl MotionInstructions<'_> {
    fn find(&self, instance: u32) -> Result<MotionControl, CipStatus> {
        self.0
            .instruction_instance(instance)
            .ok_or(CipStatus::OBJECT_DOES_NOT_EXIST)
    }

    fn ending(&self, instance: u32) -> execution::Ending {
        let Some(ended) = self.0.instruction_ending(instance) else {
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
}

impl Class for MotionInstructions<'_> {
    fn extent(&self) -> Extent {
        let (oldest, newest) = (self.0.oldest_instance(), self.0.newest_instance());
        let count = oldest
            .zip(newest)
            .map_or(0, |(oldest, newest)| newest.wrapping_sub(oldest).wrapping_add(1));
        Extent {
            highest: newest.unwrap_or(0),
            count,
            last_attribute: attribute::ENDING,
        }
    }

    /// 0x16, whether it was dropped or never was.
    fn check(&self, instance: u32) -> Result<(), CipStatus> {
        self.find(instance).map(|_| ())
    }

    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let bytes = Bytes::copy_from_slice(&self.find(instance)?.to_bytes());
        match id {
            attribute::FLAGS => Ok(bytes.slice(0..4)),
            attribute::ERR => Ok(bytes.slice(4..6)),
            attribute::STATUS => Ok(bytes.slice(6..7)),
            attribute::STATE => Ok(bytes.slice(7..8)),
            attribute::SEGMENT => Ok(bytes.slice(8..12)),
            attribute::EXERR => Ok(bytes.slice(12..13)),
            attribute::CONTROL => Ok(bytes),
            attribute::ENDING => Ok(self.ending(instance).to_bytes()),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[attribute::CONTROL]
    }
}

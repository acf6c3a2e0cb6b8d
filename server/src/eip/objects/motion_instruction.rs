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
use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, no_attribute};
use crate::plant::Plant;

/// The class code.
pub(super) const CLASS: u16 = 0x0303;

pub(super) struct MotionInstructions<'a>(pub(super) &'a Plant);

impl MotionInstructions<'_> {
    fn find(&self, instance: u32) -> Result<MotionControl, CipStatus> {
        self.0
            .instruction_instance(instance)
            .ok_or(CipStatus::OBJECT_DOES_NOT_EXIST)
    }

    fn ending(&self, instance: u32) -> Bytes {
        let mut bytes = Vec::new();
        let ended = self.0.instruction_ending(instance);
        let (code, name, what) = ended
            .as_ref()
            .map_or((0, "", String::new()), |ended| ended.ending.to_parts());
        bytes.push(code);
        for text in [name, &what] {
            // Names have 40 characters at most, and the words of all faults fit too.
            let text = text.as_bytes();
            let text = text.get(..usize::from(u8::MAX)).unwrap_or(text);
            bytes.push(text.len() as u8);
            bytes.extend_from_slice(text);
        }
        let (time, at) = ended.map_or((0.0, UNIX_EPOCH), |ended| (ended.time, ended.at));
        bytes.extend_from_slice(&f64::to_le_bytes(time));
        let at = at.duration_since(UNIX_EPOCH).unwrap_or_default().as_micros();
        bytes.extend_from_slice(&u64::try_from(at).unwrap_or(u64::MAX).to_le_bytes());
        bytes.into()
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
            last_attribute: 8,
        }
    }

    /// 0x16, whether it was dropped or never was.
    fn check(&self, instance: u32) -> Result<(), CipStatus> {
        self.find(instance).map(|_| ())
    }

    fn attribute(&self, instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        let bytes = Bytes::copy_from_slice(&self.find(instance)?.to_bytes());
        match id {
            1 => Ok(bytes.slice(0..4)),
            2 => Ok(bytes.slice(4..6)),
            3 => Ok(bytes.slice(6..7)),
            4 => Ok(bytes.slice(7..8)),
            5 => Ok(bytes.slice(8..12)),
            6 => Ok(bytes.slice(12..13)),
            7 => Ok(bytes),
            8 => Ok(self.ending(instance)),
            _ => no_attribute(),
        }
    }

    fn all(&self) -> &'static [u16] {
        &[7]
    }
}

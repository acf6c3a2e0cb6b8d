//! Wall clock, class 0x8B (spec/ethernet-ip.md §13).
//!
//! Setting it moves what clients see, never the host's clock. Local time is UTC.

use arcline_proto::cip::CipStatus;
use bytes::Bytes;

use super::{Class, Extent, no_attribute, u8_value, u64_value};
use crate::eip::device::Device;

/// µs since 1970-01-01 UTC, u64, can be set.
const UTC: u16 = 0x06;
/// Daylight saving, u8, can be set.
const DAYLIGHT_SAVING: u16 = 0x0A;
/// Local µs since 1970-01-01, u64.
const LOCAL: u16 = 0x0B;

pub(super) struct WallClock<'a>(pub(super) &'a Device);

impl Class for WallClock<'_> {
    fn extent(&self) -> Extent {
        Extent::dense(1, LOCAL)
    }

    fn attribute(&self, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            UTC | LOCAL => u64_value(self.0.clock()),
            DAYLIGHT_SAVING => u8_value(self.0.daylight_saving().into()),
            _ => no_attribute(),
        }
    }

    fn settable(&self, _instance: u32, id: u16) -> Option<usize> {
        match id {
            UTC => Some(8),
            DAYLIGHT_SAVING => Some(1),
            _ => None,
        }
    }

    fn set(&self, _instance: u32, id: u16, value: &[u8]) -> Result<(), CipStatus> {
        match (id, value) {
            (DAYLIGHT_SAVING, [on]) => self.0.set_daylight_saving(*on != 0),
            (UTC, value) => {
                let micros = value.first_chunk::<8>().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
                self.0.set_clock(u64::from_le_bytes(*micros));
            }
            _ => return Err(CipStatus::ATTRIBUTE_NOT_SETTABLE),
        }
        Ok(())
    }
}

//! Wall clock, class 0x8B (spec/ethernet-ip.md §13; the dates are those of GSV and SSV).
//!
//! Setting it moves what clients see, never the host's clock. Local time is UTC.

use arcline_proto::cip::CipStatus;
use bytes::{BufMut, Bytes, BytesMut};

use super::{Class, Extent, no_attribute, u8_value, u64_value};
use crate::eip::calendar::DateTime;
use crate::eip::device::Device;

/// Local date and time, DINT[7]: year, month, day, hour, minute, second, µs; can be set.
const LOCAL_DATE: u16 = 0x05;
/// µs since 1970-01-01 UTC, u64, can be set.
const UTC: u16 = 0x06;
/// UTC date and time, as the local one.
const UTC_DATE: u16 = 0x07;
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
            UTC_DATE | LOCAL_DATE => Ok(encode(DateTime::from_micros(self.0.clock()))),
            DAYLIGHT_SAVING => u8_value(self.0.daylight_saving().into()),
            _ => no_attribute(),
        }
    }

    fn settable(&self, _instance: u32, id: u16) -> Option<usize> {
        match id {
            UTC => Some(8),
            UTC_DATE | LOCAL_DATE => Some(DATE_LENGTH),
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
            (UTC_DATE | LOCAL_DATE, value) => {
                let date = decode(value).ok_or(CipStatus::NOT_ENOUGH_DATA)?;
                let micros = date.to_micros().ok_or(CipStatus::INVALID_ATTRIBUTE_VALUE)?;
                self.0.set_clock(micros);
            }
            _ => return Err(CipStatus::ATTRIBUTE_NOT_SETTABLE),
        }
        Ok(())
    }
}

/// Bytes of a date: seven DINTs.
const DATE_LENGTH: usize = 7 * 4;

fn encode(date: DateTime) -> Bytes {
    let mut bytes = BytesMut::with_capacity(DATE_LENGTH);
    for field in [
        date.year,
        date.month,
        date.day,
        date.hour,
        date.minute,
        date.second,
        date.micros,
    ] {
        bytes.put_u32_le(u32::try_from(field).unwrap_or(u32::MAX));
    }
    bytes.freeze()
}

/// `None` when the bytes are too few. A negative number becomes one that no date has.
fn decode(bytes: &[u8]) -> Option<DateTime> {
    let (words, _) = bytes.as_chunks::<4>();
    let mut fields = words.iter().map(|word| u64::from(u32::from_le_bytes(*word)));
    Some(DateTime {
        year: fields.next()?,
        month: fields.next()?,
        day: fields.next()?,
        hour: fields.next()?,
        minute: fields.next()?,
        second: fields.next()?,
        micros: fields.next()?,
    })
}

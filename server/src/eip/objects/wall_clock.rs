//! Wall clock, class 0x8B (spec/ethernet-ip.md §13; the dates are those of GSV and SSV).
//!
//! A client that sets it moves the time that clients see, never the host's clock. Local time is UTC.

use arcline_proto::cip::{CipStatus, class};
use bytes::{BufMut, Bytes, BytesMut};
use time::{Date, Month, OffsetDateTime, PrimitiveDateTime};

use super::object::{Extent, Object, ObjectContext};
use super::values::{no_attribute, u8_value, u64_value};
use crate::plant::Right;

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

#[derive(Debug)]
pub(super) struct WallClock;

impl Object for WallClock {
    fn class(&self) -> u16 {
        class::WALL_CLOCK
    }

    fn name(&self) -> &'static str {
        "Wall Clock Time"
    }

    fn extent(&self, _cx: &ObjectContext<'_, '_>) -> Result<Extent, CipStatus> {
        Extent::dense(1, LOCAL)
    }

    fn attribute(&self, cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Result<Bytes, CipStatus> {
        match id {
            UTC | LOCAL => u64_value(cx.device().clock()),
            UTC_DATE | LOCAL_DATE => Ok(encode(cx.device().clock())),
            DAYLIGHT_SAVING => u8_value(cx.device().daylight_saving().into()),
            _ => no_attribute(),
        }
    }

    fn settable(&self, _cx: &ObjectContext<'_, '_>, _instance: u32, id: u16) -> Option<usize> {
        match id {
            UTC => Some(8),
            UTC_DATE | LOCAL_DATE => Some(DATE_LENGTH),
            DAYLIGHT_SAVING => Some(1),
            _ => None,
        }
    }

    fn right_to_set(&self) -> Right {
        Right::SetClock
    }

    fn set(&self, cx: &mut ObjectContext<'_, '_>, _instance: u32, id: u16, value: &[u8]) -> Result<(), CipStatus> {
        match (id, value) {
            (DAYLIGHT_SAVING, [on]) => cx.device().set_daylight_saving(*on != 0),
            (UTC, value) => {
                let micros = value.first_chunk::<8>().ok_or(CipStatus::NOT_ENOUGH_DATA)?;
                cx.device().set_clock(u64::from_le_bytes(*micros));
            }
            (UTC_DATE | LOCAL_DATE, value) => {
                cx.device().set_clock(decode(value)?);
            }
            _ => return Err(CipStatus::ATTRIBUTE_NOT_SETTABLE),
        }
        Ok(())
    }
}

/// Bytes of a date: seven DINTs.
const DATE_LENGTH: usize = 7 * 4;

/// The date at a number of µs since 1970, or the last possible date.
fn encode(micros: u64) -> Bytes {
    let moment = OffsetDateTime::from_unix_timestamp_nanos(i128::from(micros) * 1000);
    let moment = moment.unwrap_or(PrimitiveDateTime::MAX.assume_utc());
    let mut bytes = BytesMut::with_capacity(DATE_LENGTH);
    bytes.put_i32_le(moment.year());
    for field in [
        u8::from(moment.month()),
        moment.day(),
        moment.hour(),
        moment.minute(),
        moment.second(),
    ] {
        bytes.put_i32_le(field.into());
    }
    bytes.put_u32_le(moment.microsecond());
    bytes.freeze()
}

/// µs since 1970 of a date.
fn decode(bytes: &[u8]) -> Result<u64, CipStatus> {
    let (words, _) = bytes.as_chunks::<4>();
    let [year, month, day, hour, minute, second, micros] = *words else {
        return Err(CipStatus::NOT_ENOUGH_DATA);
    };
    let field = |word: [u8; 4]| u8::try_from(i32::from_le_bytes(word)).ok();
    let moment = || {
        let month = Month::try_from(field(month)?).ok()?;
        let date = Date::from_calendar_date(i32::from_le_bytes(year), month, field(day)?).ok()?;
        let micros = u32::from_le_bytes(micros);
        let moment = date
            .with_hms_micro(field(hour)?, field(minute)?, field(second)?, micros)
            .ok()?;
        u64::try_from(moment.assume_utc().unix_timestamp_nanos() / 1000).ok()
    };
    moment().ok_or(CipStatus::INVALID_ATTRIBUTE_VALUE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(fields: [i32; 7]) -> Vec<u8> {
        fields.iter().flat_map(|field| field.to_le_bytes()).collect()
    }

    #[test]
    fn dates_and_back() {
        // Seconds as `date -u +%s` prints them.
        for (why, seconds, [year, month, day, hour, minute, second]) in [
            ("the beginning", 0, [1970, 1, 1, 0, 0, 0]),
            ("a leap day of a century", 951_782_400, [2000, 2, 29, 0, 0, 0]),
            ("a common moment", 1_795_301_281, [2026, 11, 21, 22, 48, 1]),
            ("the end of 32 bits", 2_147_483_647, [2038, 1, 19, 3, 14, 7]),
            ("the last that can be set", 253_402_300_799, [9999, 12, 31, 23, 59, 59]),
        ] {
            let date = bytes([year, month, day, hour, minute, second, 123_456]);
            let micros = seconds * 1_000_000 + 123_456;
            assert_eq!(encode(micros)[..], date, "{why}");
            assert_eq!(decode(&date), Ok(micros), "{why}");
        }
        let last = bytes([9999, 12, 31, 23, 59, 59, 999_999]);
        assert_eq!(encode(u64::MAX)[..], last, "further than any date");
    }

    #[test]
    fn values_that_are_no_date_are_refused() {
        for (why, fields) in [
            ("before the beginning", [1969, 12, 31, 23, 59, 59, 0]),
            ("too far", [10_000, 1, 1, 0, 0, 0, 0]),
            ("month 0", [2026, 0, 1, 0, 0, 0, 0]),
            ("month 13", [2026, 13, 1, 0, 0, 0, 0]),
            ("day 0", [2026, 1, 0, 0, 0, 0, 0]),
            ("day 257", [2026, 1, 257, 0, 0, 0, 0]),
            ("the 30th of February", [2024, 2, 30, 0, 0, 0, 0]),
            ("hour 24", [2026, 1, 1, 24, 0, 0, 0]),
            ("minute 60", [2026, 1, 1, 0, 60, 0, 0]),
            ("second 60", [2026, 1, 1, 0, 0, 60, 0]),
            ("a whole second of µs", [2026, 1, 1, 0, 0, 0, 1_000_000]),
            ("less than nothing", [2026, 1, 1, 0, 0, 0, -1]),
        ] {
            assert_eq!(decode(&bytes(fields)), Err(CipStatus::INVALID_ATTRIBUTE_VALUE), "{why}");
        }
        assert_eq!(
            decode(&bytes([2026, 1, 1, 0, 0, 0, 0])[..27]),
            Err(CipStatus::NOT_ENOUGH_DATA)
        );
    }
}

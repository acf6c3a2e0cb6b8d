//! Dates of the Gregorian calendar for a count of µs since 1970-01-01, and back. No time zones, no leap seconds.

/// A moment as the wall clock's attributes lay it out, where each field is a DINT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DateTime {
    /// From 1970 on.
    pub(crate) year: u64,
    /// From 1.
    pub(crate) month: u64,
    /// From 1.
    pub(crate) day: u64,
    pub(crate) hour: u64,
    pub(crate) minute: u64,
    pub(crate) second: u64,
    pub(crate) micros: u64,
}

impl DateTime {
    /// The moment that many µs after the beginning of 1970.
    pub(crate) fn from_micros(micros: u64) -> Self {
        let (seconds, micros) = (micros / SECOND, micros % SECOND);
        let (mut day, of_day) = (seconds / DAY, seconds % DAY);
        // Four centuries have as many days wherever they begin; within them the estimate is a year off at most.
        let mut year = EPOCH + (day * 400 / 146_097).saturating_sub(1);
        while days_before(year + 1) <= day {
            year += 1;
        }
        day -= days_before(year);
        let mut month = 1;
        while day >= month_length(year, month) {
            day -= month_length(year, month);
            month += 1;
        }
        Self {
            year,
            month,
            day: day + 1,
            hour: of_day / 3600,
            minute: of_day / 60 % 60,
            second: of_day % 60,
            micros,
        }
    }

    /// µs since the beginning of 1970; `None` when there is no such date, or it is before 1970 or too far.
    pub(crate) fn to_micros(self) -> Option<u64> {
        let Self { year, month, day, .. } = self;
        let is_date = (EPOCH..=LAST).contains(&year) && (1..=12).contains(&month) && day >= 1;
        let is_time = self.hour < 24 && self.minute < 60 && self.second < 60 && self.micros < SECOND;
        if !(is_date && is_time && day <= month_length(year, month)) {
            return None;
        }
        let months: u64 = (1..month).map(|month| month_length(year, month)).sum();
        let days = days_before(year) + months + day - 1;
        let seconds = days * DAY + self.hour * 3600 + self.minute * 60 + self.second;
        Some(seconds * SECOND + self.micros)
    }
}

/// Days from the beginning of 1970 to the beginning of a year.
fn days_before(year: u64) -> u64 {
    let leap_days = |year: u64| year / 4 - year / 100 + year / 400;
    (year - EPOCH) * 365 + leap_days(year - 1) - leap_days(EPOCH - 1)
}

fn month_length(year: u64, month: u64) -> u64 {
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    match month {
        2 if is_leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// µs.
const SECOND: u64 = 1_000_000;
/// s.
const DAY: u64 = 86_400;
/// The year with which µs begin.
const EPOCH: u64 = 1970;
/// The last year that can be set; what is counted in µs goes much further.
const LAST: u64 = 9999;

#[cfg(test)]
mod tests {
    use super::*;

    /// Why, seconds since 1970 as `date -u +%s` tells them, and the date.
    const DATES: [(&str, u64, [u64; 6]); 9] = [
        ("the beginning", 0, [1970, 1, 1, 0, 0, 0]),
        ("the end of a year", 31_535_999, [1970, 12, 31, 23, 59, 59]),
        ("a leap day", 68_169_600, [1972, 2, 29, 0, 0, 0]),
        ("a leap day of a century", 951_782_400, [2000, 2, 29, 0, 0, 0]),
        ("the day after", 951_868_800, [2000, 3, 1, 0, 0, 0]),
        ("a common moment", 1_795_301_281, [2026, 11, 21, 22, 48, 1]),
        ("the end of 32 bits", 2_147_483_647, [2038, 1, 19, 3, 14, 7]),
        ("a century without leap day", 4_107_542_400, [2100, 3, 1, 0, 0, 0]),
        ("the last that can be set", 253_402_300_799, [9999, 12, 31, 23, 59, 59]),
    ];

    fn date([year, month, day, hour, minute, second]: [u64; 6], micros: u64) -> DateTime {
        DateTime {
            year,
            month,
            day,
            hour,
            minute,
            second,
            micros,
        }
    }

    #[test]
    fn dates_and_back() {
        for (why, seconds, fields) in DATES {
            let micros = seconds * SECOND + 123_456;
            let date = date(fields, 123_456);
            assert_eq!(DateTime::from_micros(micros), date, "{why}");
            assert_eq!(date.to_micros(), Some(micros), "{why}");
        }
    }

    #[test]
    fn every_day_follows_the_one_before() {
        let mut before = DateTime::from_micros(0);
        for day in 1..200_000 {
            let date = DateTime::from_micros(day * DAY * SECOND);
            let next = match (before.month, before.day) {
                (12, 31) => (before.year + 1, 1, 1),
                (month, last) if last == month_length(before.year, month) => (before.year, month + 1, 1),
                (month, day) => (before.year, month, day + 1),
            };
            assert_eq!((date.year, date.month, date.day), next);
            assert_eq!(date.to_micros(), Some(day * DAY * SECOND));
            before = date;
        }
    }

    #[test]
    fn the_farthest_moment_has_a_date() {
        assert_eq!(DateTime::from_micros(u64::MAX).year, 586_524);
    }

    #[test]
    fn what_is_no_date() {
        for (why, fields, micros) in [
            ("before the beginning", [1969, 12, 31, 23, 59, 59], 0),
            ("too far", [10_000, 1, 1, 0, 0, 0], 0),
            ("month 0", [2026, 0, 1, 0, 0, 0], 0),
            ("month 13", [2026, 13, 1, 0, 0, 0], 0),
            ("day 0", [2026, 1, 0, 0, 0, 0], 0),
            ("the 30th of February", [2024, 2, 30, 0, 0, 0], 0),
            ("a leap day of a common year", [2026, 2, 29, 0, 0, 0], 0),
            ("hour 24", [2026, 1, 1, 24, 0, 0], 0),
            ("minute 60", [2026, 1, 1, 0, 60, 0], 0),
            ("second 60", [2026, 1, 1, 0, 0, 60], 0),
            ("a whole second of µs", [2026, 1, 1, 0, 0, 0], 1_000_000),
        ] {
            assert_eq!(date(fields, micros).to_micros(), None, "{why}");
        }
    }
}

//! Measures how late datagrams leave, and derives the shortest interval that may be confirmed: the thread keeps up with every
//! interval that it confirms.
//!
//! A machine that grants no priority, or that is too busy, makes the thread of implicit I/O late. Then the shortest interval
//! that is confirmed doubles from one look to the next, until they are in time again.

use std::time::Duration;

/// Counts over a second.
#[derive(Debug)]
pub(super) struct Lateness {
    /// The shortest interval that may be confirmed, µs.
    floor: u32,
    sent: u32,
    late: u32,
    /// Datagrams that would be late for an interval of half the floor.
    nearly: u32,
    /// When this second is over.
    until: Duration,
}

impl Lateness {
    /// Before the first measurement, a connection may have the shortest interval.
    pub(super) fn new() -> Self {
        Self {
            floor: SHORTEST,
            sent: 0,
            late: 0,
            nearly: 0,
            until: SECOND,
        }
    }

    /// A datagram left so late. Real-time of a kind: bounded, without allocation.
    pub(super) fn sent(&mut self, late: Duration) {
        self.sent += 1;
        // More than a quarter of the interval.
        let late = late.as_micros() * 4;
        self.late += u32::from(late > u128::from(self.floor));
        self.nearly += u32::from(late > u128::from(self.floor / 2));
    }

    /// Gives the shortest interval that may be confirmed from now on, µs, when it is another one.
    pub(super) fn changed_floor(&mut self, now: Duration) -> Option<u32> {
        if now < self.until {
            return None;
        }
        let before = self.floor;
        // 1 of 100 may be late; a few say nothing.
        let too_many = |late: u32| late > FEW && late * 100 > self.sent;
        if too_many(self.late) {
            self.floor = (self.floor * 2).min(LONGEST);
        } else if !too_many(self.nearly) {
            self.floor = (self.floor / 2).max(SHORTEST);
        }
        (self.sent, self.late, self.nearly, self.until) = (0, 0, 0, now + SECOND);
        (self.floor != before).then_some(self.floor)
    }
}

/// The shortest interval, µs.
pub(super) const SHORTEST: u32 = 1000;
/// The shortest interval that is confirmed on the worst machine, µs.
const LONGEST: u32 = 32_000;
const SECOND: Duration = Duration::from_secs(1);
/// Late datagrams in a second that happen anywhere.
const FEW: u32 = 3;

#[cfg(test)]
mod tests {
    use super::*;

    /// Records a second of datagrams, a number of them late.
    fn second(lateness: &mut Lateness, number: u64, late: u32) -> Option<u32> {
        for index in 0..1000 {
            let micros = if index < late { 900 } else { 60 };
            lateness.sent(Duration::from_micros(micros));
        }
        lateness.changed_floor(Duration::from_secs(number))
    }

    #[test]
    fn a_write_that_is_not_on_the_disk_is_not_confirmed_until_it_is() {
        let mut lateness = Lateness::new();
        assert_eq!(lateness.changed_floor(Duration::from_millis(999)), None);
        assert_eq!(second(&mut lateness, 1, 10), None, "one of a hundred");
        assert_eq!(second(&mut lateness, 2, 11), Some(2000));
        assert_eq!(
            second(&mut lateness, 3, 100),
            Some(4000),
            "900 µs is too late for 2 ms too"
        );
        assert_eq!(second(&mut lateness, 4, 100), None, "for 4 ms it is not");
        assert_eq!(second(&mut lateness, 5, 0), Some(2000));
        assert_eq!(second(&mut lateness, 6, 0), Some(1000));
        for number in 7..30 {
            for _ in 0..100 {
                lateness.sent(Duration::from_secs(1));
            }
            lateness.changed_floor(Duration::from_secs(number));
        }
        assert_eq!(lateness.floor, LONGEST);
        // Without datagrams, none is late.
        assert_eq!(lateness.changed_floor(Duration::from_secs(30)), Some(LONGEST / 2));
    }
}

//! Time as an integer number of ticks and a fraction of one (spec/motion-core.md §12.3).

const NANOSECONDS: f64 = 1e9;

/// Seconds by which an instant may be off for rounding: what lies so little ahead of a tick is at it. A motion of a whole number
/// of ticks ends at the last of them.
pub const ROUNDING: f64 = 1e-10;

/// The present tick and what a tick is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clock {
    /// Coarse updates since the start; tick 0 is the first.
    pub tick: u64,
    /// Coarse update period, nanoseconds; more than 0.
    pub period_ns: u64,
}

impl Clock {
    /// Coarse update period in seconds.
    pub fn period(&self) -> f64 {
        self.period_ns as f64 / NANOSECONDS
    }

    /// Seconds from tick 0 to the present tick.
    pub fn seconds(&self) -> f64 {
        (self.tick * self.period_ns) as f64 / NANOSECONDS
    }

    /// The present tick as an instant.
    pub fn now(&self) -> Instant {
        Instant {
            tick: self.tick,
            offset: 0.0,
        }
    }
}

/// A point in time between two ticks: exact however long the controller has been running.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    tick: u64,
    /// Seconds after `tick`, at least 0 and less than a period.
    offset: f64,
}

impl Instant {
    /// Seconds from this instant to the clock's tick; negative when the instant lies ahead.
    pub fn elapsed(&self, clock: &Clock) -> f64 {
        let ticks = if clock.tick >= self.tick {
            ((clock.tick - self.tick) * clock.period_ns) as f64
        } else {
            -(((self.tick - clock.tick) * clock.period_ns) as f64)
        };
        ticks / NANOSECONDS - self.offset
    }

    /// The instant `seconds` (at least 0) after this one.
    pub fn after(&self, seconds: f64, clock: &Clock) -> Instant {
        let period = clock.period();
        let total = self.offset + seconds;
        let whole = (total / period).floor();
        Instant {
            tick: self.tick + whole as u64,
            offset: (total - whole * period).clamp(0.0, period),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_keep_their_fraction_however_far_they_lie() {
        let clock = |tick| Clock {
            tick,
            period_ns: 1_000_000,
        };
        let day = 86_400_000;
        for (why, from, seconds, read_at, elapsed) in [
            ("inside the first tick", 0, 0.0004, 1, 0.0006),
            ("ahead of the clock", 5, 0.0025, 5, -0.0025),
            ("a day later", day, 0.000_25, day + 1, 0.000_75),
            ("over several ticks", day, 0.0105, day + 11, 0.0005),
        ] {
            let instant = clock(from).now().after(seconds, &clock(from));
            let got = instant.elapsed(&clock(read_at));
            assert!((got - elapsed).abs() < 1e-15, "{why}: {got} is not {elapsed}");
        }
    }
}

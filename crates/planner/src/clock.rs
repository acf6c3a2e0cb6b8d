//! The variables that moves are functions of: time, as an integer number of ticks and a fraction of one (spec/motion-core.md §12.3), or
//! the displacement of a master (§10.4).
//!
//! A master's displacement has no ticks: its clock shows the displacement in master units. A plan over it has master units in place of
//! seconds. The rate of the displacement in time is its [`MasterRate`].

use arcline_profile::KinematicState;

use crate::Sample;

const NANOSECONDS: f64 = 1e9;

/// The present tick with the length of a tick, or the displacement of a master.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Coarse updates since the start; tick 0 is the first.
    pub tick: u64,
    /// Coarse update period, nanoseconds; more than 0. 0: the clock shows a master's displacement.
    pub period_ns: u64,
    /// The displacement of a master, master units; of a clock that shows time, seconds after the tick.
    displacement: f64,
}

impl Clock {
    /// Time: a tick, and the coarse update period in nanoseconds, more than 0.
    pub const fn at(tick: u64, period_ns: u64) -> Self {
        Clock {
            tick,
            period_ns,
            displacement: 0.0,
        }
    }

    /// A master's displacement, master units.
    pub const fn of_displacement(displacement: f64) -> Self {
        Clock {
            tick: 0,
            period_ns: 0,
            displacement,
        }
    }

    /// Coarse update period in seconds.
    pub fn period(&self) -> f64 {
        self.period_ns as f64 / NANOSECONDS
    }

    /// Seconds from tick 0 to the present tick.
    pub fn seconds(&self) -> f64 {
        (self.tick * self.period_ns) as f64 / NANOSECONDS
    }

    /// The clock an update later.
    #[must_use]
    pub fn next(&self) -> Clock {
        Clock {
            tick: self.tick + 1,
            ..*self
        }
    }

    /// The clock `seconds` later, also between two ticks; only for reading. Master units for a master's displacement.
    #[must_use]
    pub fn later(&self, seconds: f64) -> Clock {
        Clock {
            displacement: self.displacement + seconds,
            ..*self
        }
    }

    /// The reading of the clock as an instant.
    pub fn now(&self) -> Instant {
        Instant {
            tick: self.tick,
            offset: self.displacement,
        }
    }
}

/// A point in time between two ticks, exact at any run time of the controller. On a clock of a master's displacement: a displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    tick: u64,
    /// Seconds after `tick`, at least 0 and less than a period; or the displacement.
    offset: f64,
}

impl Instant {
    /// Seconds from this instant to the clock's tick; negative if the instant lies ahead. Master units for a master's displacement.
    pub fn elapsed(&self, clock: &Clock) -> f64 {
        // f64 does not hold the nanoseconds of centuries exactly.
        let nanoseconds = |ticks: u64| {
            let exact = ticks.checked_mul(clock.period_ns);
            exact.map_or(ticks as f64 * clock.period_ns as f64, |exact| exact as f64)
        };
        let ticks = if clock.tick >= self.tick {
            nanoseconds(clock.tick - self.tick)
        } else {
            -nanoseconds(self.tick - clock.tick)
        };
        ticks / NANOSECONDS + (clock.displacement - self.offset)
    }

    /// The instant `seconds` (at least 0), or master units, after this one.
    pub fn after(&self, seconds: f64, clock: &Clock) -> Instant {
        let total = self.offset + seconds;
        if clock.period_ns == 0 {
            return Instant { tick: 0, offset: total };
        }
        let period = clock.period();
        let whole = (total / period).floor();
        Instant {
            tick: self.tick.saturating_add(whole as u64),
            offset: (total - whole * period).clamp(0.0, period),
        }
    }
}

/// The rate of a master's displacement: it converts derivatives by the displacement to derivatives by time, and back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MasterRate {
    /// Master units/s, at least 0.
    pub speed: f64,
    /// Master units/s².
    pub acceleration: f64,
}

impl MasterRate {
    /// Converts a state over the displacement to one over time.
    pub fn in_time(&self, state: KinematicState) -> KinematicState {
        KinematicState {
            velocity: state.velocity * self.speed,
            acceleration: state.acceleration * self.speed * self.speed + state.velocity * self.acceleration,
            ..state
        }
    }

    /// Converts a state over time to one over the displacement; at rest if the displacement does not change.
    pub fn by_displacement(&self, state: KinematicState) -> KinematicState {
        if self.speed <= 0.0 {
            return KinematicState {
                position: state.position,
                ..KinematicState::default()
            };
        }
        let velocity = state.velocity / self.speed;
        KinematicState {
            velocity,
            acceleration: (state.acceleration - velocity * self.acceleration) / (self.speed * self.speed),
            ..state
        }
    }

    /// Converts a sample over the displacement to one over time. Its phase remains that of the move itself.
    pub fn sample(&self, sample: Sample) -> Sample {
        Sample {
            acceleration: sample.acceleration * (self.speed * self.speed) + sample.velocity * self.acceleration,
            velocity: sample.velocity * self.speed,
            along: self.in_time(sample.along),
            rotation_state: sample
                .rotation_state
                .map(|rotation_state| rotation_state.in_time(self.speed, self.acceleration)),
            ..sample
        }
    }
}

/// The variables of moves at one instant: time, and the displacement of a master.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeBase {
    /// Time.
    pub time: Clock,
    /// The master of the active move, if it has one.
    pub master: Option<MasterMotion>,
}

/// The master of a driven move, as the move reads it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MasterMotion {
    /// Its displacement since the lock, master units.
    pub displacement: f64,
    /// The rate of the displacement.
    pub rate: MasterRate,
}

impl TimeBase {
    /// Time without a master.
    pub fn of_time(time: Clock) -> Self {
        TimeBase { time, master: None }
    }

    /// The variable of the active move, as a clock.
    pub fn clock(&self) -> Clock {
        self.master
            .map_or(self.time, |master| Clock::of_displacement(master.displacement))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_keep_their_fraction_however_far_they_lie() {
        let clock = |tick| Clock::at(tick, 1_000_000);
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

    #[test]
    fn a_clock_of_displacement_has_no_ticks() {
        let instant_of_displacement = Clock::of_displacement(2.5)
            .now()
            .after(10.0, &Clock::of_displacement(2.5));
        assert_eq!(instant_of_displacement.elapsed(&Clock::of_displacement(14.0)), 1.5);
        assert_eq!(instant_of_displacement.elapsed(&Clock::of_displacement(12.0)), -0.5);
    }

    #[test]
    fn a_master_rate_converts_derivatives_by_displacement_to_derivatives_by_time_and_back() {
        let rate = MasterRate {
            speed: 50.0,
            acceleration: 30.0,
        };
        let state = KinematicState {
            position: 7.0,
            velocity: 2.0,
            acceleration: -0.5,
        };
        let timed = rate.in_time(state);
        // d²s/dt² = s'' (dm/dt)² + s' d²m/dt²
        assert_eq!((timed.velocity, timed.acceleration), (100.0, -1250.0 + 60.0));
        assert_eq!(rate.by_displacement(timed), state);
        let at_rest = MasterRate::default().by_displacement(timed);
        assert_eq!((at_rest.velocity, at_rest.acceleration), (0.0, 0.0));
    }
}

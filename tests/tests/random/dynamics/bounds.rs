//! The greatest further travel of a motion: the distance that a stop with the old dynamics, or with those of the stop, would need.
//!
//! Units and seconds.

use arcline_profile::{DynamicsBits, Jerk, KinematicState, Limits, Profile, jerk_from_percent_of_time};

/// Dynamics as programmed, the jerks in percent of time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Dynamics {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
    pub(crate) deceleration: f64,
    /// `None`: a trapezoid.
    pub(crate) jerk: Option<f64>,
}

impl Dynamics {
    pub(crate) fn limits(&self) -> Limits {
        let rate = |rate: f64, percent: f64| jerk_from_percent_of_time(self.speed, rate, percent);
        Limits {
            speed: self.speed,
            acceleration: self.acceleration,
            deceleration: self.deceleration,
            jerk: self.jerk.map(|percent| Jerk {
                acceleration: rate(self.acceleration, percent),
                deceleration: rate(self.deceleration, percent),
            }),
        }
    }

    /// Applies a change; a speed of 0 leaves the jerks as they were.
    pub(crate) fn changed(&mut self, speed: f64, acceleration: Option<f64>, deceleration: Option<f64>) {
        if speed > 0.0 {
            self.speed = speed;
        }
        self.acceleration = acceleration.unwrap_or(self.acceleration);
        self.deceleration = deceleration.unwrap_or(self.deceleration);
    }

    /// The distance to rest with it.
    pub(crate) fn distance_to_rest(&self, from: KinematicState) -> f64 {
        Profile::stop(from, &self.limits()).reach()
    }

    /// The distance of a stop with a rate and all of its time limited in jerk.
    pub(crate) fn distance_of_a_stop(&self, from: KinematicState, rate: f64, percent: f64) -> f64 {
        let jerk = jerk_from_percent_of_time(from.velocity.abs(), rate, percent);
        let limits = Limits {
            speed: from.velocity.abs(),
            acceleration: rate,
            deceleration: rate,
            jerk: self.jerk.map(|_| Jerk {
                acceleration: jerk,
                deceleration: jerk,
            }),
        };
        // The motion may have been on its way to a higher speed than programmed.
        let before = self.limits();
        let most = Profile::stop(from, &before).top_speed(0.0).max(from.velocity.abs());
        let before = Limits {
            speed: self.speed.max(most),
            ..before
        };
        Profile::stop_within(from, &limits, Some(&before), DynamicsBits::ALL).reach()
    }
}

/// A motion that comes to rest, or at least turns.
#[derive(Clone, Debug)]
pub(crate) struct Coasting {
    pub(crate) why: String,
    /// The tag of the move that pauses: where it ends, its successor begins.
    pub(crate) paused: Option<String>,
    /// Travelled since.
    pub(crate) gone: f64,
    pub(crate) most: f64,
}

/// A merge: how far it may lead beside the line from where it began to its end.
#[derive(Clone, Debug)]
pub(crate) struct Beside {
    pub(crate) tag: String,
    pub(crate) why: String,
    pub(crate) from: [f64; 2],
    pub(crate) to: [f64; 2],
    pub(crate) most: f64,
}

impl Beside {
    pub(crate) fn distance(&self, at: [f64; 2]) -> f64 {
        let line = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let off = [at[0] - self.from[0], at[1] - self.from[1]];
        let square = line[0] * line[0] + line[1] * line[1];
        let share = if square > 0.0 {
            ((off[0] * line[0] + off[1] * line[1]) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (off[0] - share * line[0]).hypot(off[1] - share * line[1])
    }
}

/// The greatest distance if `distance` is the bound: a path is sampled, and a call takes effect within a tick or two.
pub(crate) fn at_most(distance: f64, from: KinematicState) -> f64 {
    1.02 * distance + 0.1 + 2.0 * PERIOD * from.velocity
}

/// The coarse update period, seconds.
pub(crate) const PERIOD: f64 = 0.001;

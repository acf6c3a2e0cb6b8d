//! The instant between two updates at which axes came within a tolerance of their resting commands.
//!
//! Without active limits an error only decreases, and the instant is found by bisection. An axis at its torque limit oscillates, and
//! may enter and leave the tolerance within one period: it is followed in steps short enough for its speed and torque. Not here: the
//! tolerance, and its use. Units: position units, seconds.

use arcline_profile::KinematicState;
use arcline_profile::numeric::bisect;

use super::Drive;
use super::tolerance::GRAIN_SHARE;
use crate::Saturation;

/// Halvings of a span: to the last bit of a period.
const HALVINGS: usize = 60;
/// Steps along an oscillation within one period, and halvings of the last one.
const STEPS: usize = 32;

/// Drives at the beginning of a period in which their commands come to rest.
#[derive(Clone, Copy, Debug)]
pub struct Settling<const N: usize> {
    /// The drives before the period.
    pub drives: [Drive; N],
    /// The positions of their resting commands, units.
    pub ends: [f64; N],
    /// The largest norm of the errors, units.
    pub tolerance: f64,
    /// The period, seconds.
    pub period: f64,
    /// Seconds for which the commands have rested at the end of the period, at least.
    pub rest: f64,
}

/// The axes at an instant.
struct Seen {
    distance: f64,
    speed: f64,
    /// The growth rate of the speed; 0 without a torque limit, as the speed then only decreases.
    growth: f64,
    /// The effect of one count of every encoder on the distance.
    grain: f64,
}

impl<const N: usize> Settling<N> {
    /// Seconds before the end of the period at which the axes first were within the tolerance, with resting commands; `None` if they were not.
    /// Real-time: bounded.
    pub fn within(&self) -> Option<f64> {
        let available = self.rest.min(self.period);
        let drives = self.at(self.period);
        if !drives
            .iter()
            .all(|drive| drive.error_before(available).is_finite() && drive.decays())
        {
            return self.swings_within(available);
        }
        let distance = |before: f64| norm(drives.iter().map(|drive| drive.error_before(before)));
        if distance(0.0) > self.tolerance {
            return None;
        }
        if distance(available) <= self.tolerance {
            return Some(available);
        }
        let inside = |before: f64| distance(before) <= self.tolerance;
        Some(bisect(available, 0.0, HALVINGS, inside))
    }

    fn swings_within(&self, available: f64) -> Option<f64> {
        let mut at = self.period - available;
        let mut outside = at;
        for _ in 0..STEPS {
            let seen = self.seen(at);
            if seen.distance <= self.tolerance {
                return Some(self.period - self.entered(outside, at));
            }
            if at >= self.period {
                return None;
            }
            outside = at;
            let clear = seen.distance - self.tolerance - seen.grain;
            at = (at + seen.time_for(clear.max(0.25 * seen.grain))).min(self.period);
        }
        let seen = self.seen(self.period);
        (seen.distance <= self.tolerance).then(|| self.period - self.entered(outside, self.period))
    }

    /// The instant between two, in seconds from the beginning of the period, at which the axes came within the tolerance.
    fn entered(&self, outside: f64, inside: f64) -> f64 {
        bisect(outside, inside, STEPS, |at| self.seen(at).distance <= self.tolerance)
    }

    fn seen(&self, at: f64) -> Seen {
        let drives = self.at(at);
        Seen {
            distance: norm(drives.iter().map(Drive::error)),
            speed: norm(drives.iter().map(|drive| drive.axis().velocity)),
            growth: norm(drives.iter().map(Drive::torque_limit)),
            grain: norm(drives.iter().map(Drive::count)).max(GRAIN_SHARE * self.tolerance),
        }
    }

    /// The drives at an instant after the beginning of the period, with resting commands.
    fn at(&self, at: f64) -> [Drive; N] {
        let mut drives = self.drives;
        if at > 0.0 {
            for (drive, end) in drives.iter_mut().zip(self.ends) {
                drive.rest_for(self.rest - (self.period - at));
                drive.cycle(KinematicState::at_rest(end), at);
            }
        }
        drives
    }
}

impl Seen {
    /// A time in which the axes cannot move further than a distance.
    fn time_for(&self, distance: f64) -> f64 {
        let root = (self.speed * self.speed + 2.0 * self.growth * distance).sqrt();
        // Infinite at rest without acceleration.
        2.0 * distance / (self.speed + root)
    }
}

impl Drive {
    /// A following error only decreases while the command rests.
    fn decays(&self) -> bool {
        match self {
            Drive::Ideal(_) => true,
            Drive::Servo(servo) => servo.saturation() == Saturation::None,
        }
    }

    /// Acceleration at the torque limit, or 0 without one.
    fn torque_limit(&self) -> f64 {
        match self {
            Drive::Ideal(_) => 0.0,
            Drive::Servo(servo) => servo.torque_limit(),
        }
    }

    /// The length of one count, or 0 without an encoder.
    fn count(&self) -> f64 {
        match self {
            Drive::Ideal(_) => 0.0,
            Drive::Servo(servo) => servo.count(),
        }
    }
}

fn norm(parts: impl Iterator<Item = f64>) -> f64 {
    parts.map(|part| part * part).sum::<f64>().sqrt()
}

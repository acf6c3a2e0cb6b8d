//! When axes came near enough to where their commands stand, found between two updates.
//!
//! Without limits an error only shrinks, and the instant is found by halving. An axis whose torque is spent swings,
//! and may come near and leave again within one period: it is followed in steps that its speed and its torque do not
//! let it outrun. Not here: what is near enough, and for whom. Units: position units, seconds.

use arcline_profile::KinematicState;

use super::Drive;
use super::tolerance::GRAIN_SHARE;
use crate::Saturation;

/// Halvings of a span: to the last bit of a period.
const HALVINGS: u32 = 60;
/// Steps along a swing within one period, and halvings of the last of them.
const STEPS: u32 = 32;

/// Drives at the beginning of a period in which their commands come to rest.
#[derive(Clone, Copy, Debug)]
pub struct Settling<const N: usize> {
    /// The drives before the period.
    pub drives: [Drive; N],
    /// Where their commands stand, units.
    pub ends: [f64; N],
    /// How near the vector of the errors must be to 0, units.
    pub tolerance: f64,
    /// The period, seconds.
    pub period: f64,
    /// How long before the end of the period the commands have come to rest, or longer; seconds.
    pub rest: f64,
}

/// The axes at an instant.
struct Seen {
    distance: f64,
    speed: f64,
    /// How fast the speed can grow; 0 where nothing limits the torque, as speed then only shrinks.
    growth: f64,
    /// What one count of every encoder makes of the distance.
    grain: f64,
}

impl<const N: usize> Settling<N> {
    /// How long before the end of the period the axes first were within the tolerance, while the commands stood
    /// still; `None` if they were not. Real-time: bounded.
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
        let (mut inside, mut outside) = (0.0, available);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if distance(middle) <= self.tolerance {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        Some(inside)
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

    /// The instant between two, from the beginning of the period, at which the axes came within the tolerance.
    fn entered(&self, mut outside: f64, mut inside: f64) -> f64 {
        for _ in 0..STEPS {
            let middle = 0.5 * (inside + outside);
            if middle <= outside || middle >= inside {
                break;
            }
            if self.seen(middle).distance <= self.tolerance {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
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

    /// The drives so long after the beginning of the period, when the commands stand.
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
    /// A time in which the axes cannot go further than a distance.
    fn time_for(&self, distance: f64) -> f64 {
        let root = (self.speed * self.speed + 2.0 * self.growth * distance).sqrt();
        // Infinite at standstill where nothing accelerates.
        2.0 * distance / (self.speed + root)
    }
}

impl Drive {
    /// Whether a following error only shrinks while the command stands.
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

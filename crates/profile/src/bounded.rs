//! The removal of an acceleration that is present when the dynamics change, such that the speed stays within bounds
//! (spec/coordinated-instructions.md §5.4, the Dynamics Configuration Bits of spec/axis-and-data-types.md §9.2 and §10.4).
//!
//! A ramp removes a present acceleration with its own jerk. If that jerk is much lower than the one that built the acceleration up, the speed
//! overshoots by `a² / 2j`, or passes through rest and returns. An [`AccelerationRemovalPhase`] removes the acceleration with a higher jerk
//! first; the plan begins after it.
//!
//! Position units and seconds. Real-time safe, as the rest of the crate.

use crate::KinematicState;
use crate::builder::MAX_SEGMENTS;
use crate::limits::{Jerk, Limits, ProfileShape};
use crate::profile::{Profile, Segment};
use crate::tolerance::LIMIT_SHARE;

/// The Dynamics Configuration Bits of an axis or a coordinate system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DynamicsBits {
    /// Bit 0, Reduce S-Curve Stop Delay: a stop removes a present acceleration with the larger of both jerks.
    pub stop_delay: bool,
    /// Bit 1, Prevent S-Curve Velocity Reversals: a stop that begins while an S-curve brakes does not pass through rest.
    pub reversals: bool,
    /// Bit 2, Reduced Extreme Velocity Overshoot: a change removes a present acceleration in time.
    pub overshoot: bool,
}

impl DynamicsBits {
    /// All three, the default of axes and coordinate systems.
    pub const ALL: DynamicsBits = DynamicsBits {
        stop_delay: true,
        reversals: true,
        overshoot: true,
    };

    /// From the attribute, 0 to 7; higher bits are ignored.
    #[must_use]
    pub const fn from_bits(bits: u32) -> DynamicsBits {
        DynamicsBits {
            stop_delay: bits & 1 != 0,
            reversals: bits & 2 != 0,
            overshoot: bits & 4 != 0,
        }
    }

    /// The attribute, 0 to 7.
    #[must_use]
    pub const fn bits(self) -> u32 {
        self.stop_delay as u32 | (self.reversals as u32) << 1 | (self.overshoot as u32) << 2
    }
}

impl Default for DynamicsBits {
    fn default() -> Self {
        DynamicsBits::ALL
    }
}

/// Largest speed after a change of dynamics, as a multiple of the programmed speeds (spec/axis-and-data-types.md §10.4: the overshoot
/// stays below 50 %).
pub const MOST_OVERSHOOT: f64 = 1.5;

/// A phase before a plan: it removes the acceleration of a state with a constant jerk, then holds the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccelerationRemovalPhase {
    /// Its start state.
    pub from: KinematicState,
    /// Position units per second cubed, above 0. An acceleration whose removal takes no time ends at once.
    pub jerk: f64,
    /// Seconds for which the speed is held after the removal.
    pub hold: f64,
}

impl AccelerationRemovalPhase {
    /// The phase that keeps the speed of a plan from a state at or below `ceiling`; `None` if the jerks of the limits suffice. A
    /// motion that passes through rest counts with its speed on the other side.
    #[must_use]
    pub fn below(from: KinematicState, limits: &Limits, ceiling: f64) -> Option<AccelerationRemovalPhase> {
        let ProfileShape::SCurve(own) = limits.shape() else {
            return None;
        };
        let (speed, square) = (from.velocity.abs(), from.acceleration * from.acceleration);
        if square == 0.0 {
            return None;
        }
        let most = ceiling.max(speed) * (1.0 + LIMIT_SHARE);
        let jerk = if from.velocity * from.acceleration >= 0.0 {
            if speed + 0.5 * square * own.up.per_jerk <= most {
                return None;
            }
            square / (2.0 * (ceiling - speed).max(0.0))
        } else {
            let left = square - 2.0 * own.down.jerk * speed;
            if 0.5 * left * own.up.per_jerk <= most {
                return None;
            }
            square / (2.0 * (speed + ceiling.max(0.0)))
        };
        Some(AccelerationRemovalPhase {
            from,
            jerk: jerk.max(own.up.jerk.min(own.down.jerk)),
            hold: 0.0,
        })
    }

    /// The phase that removes a deceleration before the motion passes through rest; `None` if the jerk of the limits suffices.
    #[must_use]
    pub fn before_rest(from: KinematicState, limits: &Limits) -> Option<AccelerationRemovalPhase> {
        let ProfileShape::SCurve(own) = limits.shape() else {
            return None;
        };
        let critical = critical_jerk(&from)?;
        (critical > own.down.jerk).then_some(AccelerationRemovalPhase {
            from,
            jerk: critical,
            hold: 0.0,
        })
    }

    /// Its duration in seconds: the removal and the hold.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.removal_time() + self.hold
    }

    /// Its end state, at a constant speed.
    #[must_use]
    pub fn end(&self) -> KinematicState {
        let mut level = self.level();
        level.position += level.velocity * self.hold;
        level
    }

    /// The phase, followed by a plan from [`AccelerationRemovalPhase::end`].
    #[must_use]
    pub fn then(&self, plan: &Profile) -> Profile {
        let mut whole = Profile::rest(0.0);
        whole.start = self.from;
        let removal_time = self.removal_time();
        let mut time = 0.0;
        if removal_time > 0.0 {
            let jerk = -self.from.acceleration / removal_time;
            whole.append(time, Segment { state: self.from, jerk });
            time += removal_time;
        }
        if self.hold > 0.0 {
            let state = self.level();
            whole.append(time, Segment { state, jerk: 0.0 });
            time += self.hold;
        }
        for index in 0..plan.len {
            whole.append(time + plan.times[index], plan.segments[index]);
        }
        whole.duration = time + plan.duration;
        whole.end = plan.end;
        whole.arrives = plan.arrives;
        whole
    }

    fn removal_time(&self) -> f64 {
        let time = self.from.acceleration.abs() / self.jerk;
        if time.is_finite() { time } else { 0.0 }
    }

    fn level(&self) -> KinematicState {
        let KinematicState {
            position,
            velocity,
            acceleration,
        } = self.from;
        let time = self.removal_time();
        KinematicState {
            position: position + time * (velocity + time * acceleration / 3.0),
            velocity: velocity + 0.5 * time * acceleration,
            acceleration: 0.0,
        }
    }
}

impl Profile {
    /// A plan from a state, after the removal phase if there is one.
    #[must_use]
    pub fn after_removal(
        removal_phase: Option<AccelerationRemovalPhase>,
        from: KinematicState,
        plan: impl FnOnce(KinematicState) -> Profile,
    ) -> Profile {
        match removal_phase {
            Some(phase) => phase.then(&plan(phase.end())),
            None => plan(from),
        }
    }

    /// A stop within the bounds (spec/coordinated-instructions.md §5.4). With bits 0 and 1 its speed neither passes through rest nor
    /// exceeds 1.5 times that of `before`, the limits of the motion so far; if these are unknown, 1.5 times the present speed.
    #[must_use]
    pub fn stop_within(
        from: KinematicState,
        limits: &Limits,
        before: Option<&Limits>,
        dynamics_bits: DynamicsBits,
    ) -> Profile {
        let mut limits = *limits;
        if let Some(jerk) = &mut limits.jerk {
            if from.velocity * from.acceleration >= 0.0 {
                if dynamics_bits.stop_delay {
                    let speed = from.velocity.abs();
                    let own = before.and_then(|before| before.jerk);
                    let ceiling = MOST_OVERSHOOT * before.map_or(speed, |before| before.speed);
                    // A speed already above the ceiling may increase by half.
                    let room = if ceiling > speed {
                        ceiling - speed
                    } else {
                        (MOST_OVERSHOOT - 1.0) * speed
                    };
                    let least = 0.5 * from.acceleration * from.acceleration / room;
                    jerk.acceleration = jerk
                        .acceleration
                        .max(jerk.deceleration)
                        .max(own.map_or(0.0, |own| own.acceleration))
                        .max(if least.is_nan() { 0.0 } else { least });
                }
            } else if let (true, Some(critical)) = (dynamics_bits.reversals, critical_jerk(&from)) {
                jerk.deceleration = jerk.deceleration.max(critical);
            }
        }
        Profile::stop(from, &limits)
    }

    /// The highest magnitude of the velocity from `t` seconds after the start on.
    #[must_use]
    pub fn top_speed(&self, t: f64) -> f64 {
        let ahead = (0..self.len).filter(|&index| self.times[index] > t);
        ahead
            .map(|index| self.segments[index].state.velocity.abs())
            .fold(self.at(t).velocity.abs().max(self.end.velocity.abs()), f64::max)
    }

    /// The largest distance of the motion from its start, to either side.
    #[must_use]
    pub fn reach(&self) -> f64 {
        (0..self.len)
            .map(|index| self.segments[index].state.position)
            .chain([self.end.position])
            .map(|position| (position - self.start.position).abs())
            .fold(0.0, f64::max)
    }

    fn append(&mut self, time: f64, segment: Segment) {
        if self.len < MAX_SEGMENTS {
            self.times[self.len] = time;
            self.segments[self.len] = segment;
            self.len += 1;
        }
    }
}

impl Limits {
    /// Limits with which ramps are shorter in time and in distance by a factor.
    #[must_use]
    pub fn hastened(&self, factor: f64) -> Limits {
        let square = factor * factor;
        Limits {
            speed: self.speed,
            acceleration: self.acceleration * factor,
            deceleration: self.deceleration * factor,
            jerk: self.jerk.map(|jerk| Jerk {
                acceleration: jerk.acceleration * square,
                deceleration: jerk.deceleration * square,
            }),
        }
    }
}

/// The jerk that removes a deceleration exactly when the motion comes to rest.
fn critical_jerk(from: &KinematicState) -> Option<f64> {
    let brakes = from.velocity * from.acceleration < 0.0;
    let jerk = 0.5 * from.acceleration * from.acceleration / from.velocity.abs();
    brakes.then_some(jerk * (1.0 + LIMIT_SHARE))
}

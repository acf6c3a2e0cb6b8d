//! The pace of a trajectory's own time, and its ramps to another pace.
//!
//! A ramp begins at once if the limits leave room for it. Otherwise a gentler one, or one to a nearer pace, is chosen, and every tick
//! searches for a better one than the active one, until the ramp is the requested one. An active ramp has always been checked to its end
//! ([`Guard`]), so no limit is exceeded at any instant. Own seconds per second; its derivatives per second. Nothing allocates; a tick tries a
//! few ramps.

use arcline_contour::{AxesState, Trajectory};
use arcline_profile::{KinematicState, Limits, Profile};

use super::guard::{Extra, Guard};
use super::ramp::{CurveStop, Ramp, StopRequest};
use super::run::both;
use crate::tolerance::{LEAST_RAMP_SPEED_SHARE, REACHED_PACE_SHARE};
use crate::{Clock, Instant};

/// A requested pace, and the highest rates of its ramp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PaceRequest {
    pub(super) target: f64,
    /// First derivative of the pace.
    pub(super) rate: f64,
    /// Second derivative; `None`: the first may step.
    pub(super) jerk: Option<f64>,
    /// Vector rate and jerk of the ramps that suit the present state; `None`: there are no such ramps.
    pub(super) near: Option<(f64, Option<f64>)>,
    /// The stop along the curve, if the target is 0.
    pub(super) stop: Option<StopRequest>,
    /// The rates of a stop, which are permitted besides those of the moves.
    pub(super) extra: Extra,
}

/// The pace of a trajectory in execution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    ramp: Ramp,
    start: Instant,
    wanted: PaceRequest,
    /// Index of the active ramp; [`NONE`] if it does not end at the requested pace.
    under_way: usize,
    /// Index of the ramp to try next.
    next: usize,
}

impl Pace {
    /// A constant pace from the present tick on, at `own` of the trajectory's time.
    pub(super) fn constant(own: f64, pace: f64, clock: &Clock) -> Self {
        let state = KinematicState {
            position: own,
            velocity: pace,
            acceleration: 0.0,
        };
        Pace {
            ramp: Ramp::OwnTime(Profile::to_velocity(state, pace, &limits(1.0, None))),
            start: clock.now(),
            wanted: PaceRequest {
                target: pace,
                rate: 1.0,
                jerk: None,
                near: None,
                stop: None,
                extra: Extra::NONE,
            },
            under_way: 0,
            next: 0,
        }
    }

    /// Comes to rest from a state, without regard to the limits of a trajectory.
    pub(super) fn stopping(from: KinematicState, rate: f64, jerk: Option<f64>, clock: &Clock) -> Self {
        let from = KinematicState {
            acceleration: if jerk.is_some() { from.acceleration } else { 0.0 },
            ..from
        };
        Pace {
            ramp: Ramp::OwnTime(Profile::stop(from, &limits(rate, jerk))),
            start: clock.now(),
            wanted: PaceRequest {
                target: 0.0,
                rate,
                jerk,
                near: None,
                stop: None,
                extra: Extra::NONE,
            },
            under_way: 0,
            next: 0,
        }
    }

    /// Seconds from its beginning to the end of the present ramp.
    pub(super) fn duration(&self) -> f64 {
        self.ramp.duration()
    }

    /// Seconds from the present tick to an instant of the trajectory's own time, negative for a past one; `None`: the present ramp never
    /// reaches it.
    pub(super) fn until(&self, own: f64, trajectory: &Trajectory, clock: &Clock) -> Option<f64> {
        Some(self.ramp.time_at(own, trajectory)? - self.start.elapsed(clock))
    }

    /// The instant of a point in the trajectory's own time that lies at or before the present tick, but not before the beginning of the present
    /// ramp.
    pub(super) fn instant_of(&self, own: f64, trajectory: &Trajectory, clock: &Clock) -> Instant {
        let since = self.ramp.time_at(own, trajectory).unwrap_or(0.0);
        self.start.after(since.min(self.start.elapsed(clock)), clock)
    }

    /// The trajectory's own time, the pace and its derivative at the present tick.
    pub(super) fn at(&self, trajectory: &Trajectory, clock: &Clock) -> KinematicState {
        self.ramp.at(self.start.elapsed(clock), trajectory)
    }

    /// The requested pace.
    pub(super) fn target(&self) -> f64 {
        self.wanted.target
    }

    /// The pace has reached the requested one, and stays there.
    pub(super) fn is_settled(&self, clock: &Clock) -> bool {
        self.ramp.end_pace() == self.wanted.target && self.start.elapsed(clock) >= self.ramp.duration()
    }

    /// A ramp to the requested pace is active, or over.
    pub(super) fn is_under_way(&self) -> bool {
        self.under_way != NONE && self.ramp.end_pace() == self.wanted.target
    }

    /// Requests a pace, from the present tick on.
    pub(super) fn ask(&mut self, wanted: PaceRequest, trajectory: &Trajectory, clock: &Clock) {
        self.wanted = wanted;
        (self.under_way, self.next) = (NONE, 0);
        self.steer(trajectory, clock);
    }

    /// Searches for a better ramp than the active one, once a tick. Returns true if it has found one.
    pub(super) fn steer(&mut self, trajectory: &Trajectory, clock: &Clock) -> bool {
        if self.under_way == 0 || self.is_settled(clock) {
            return false;
        }
        let now = self.at(trajectory, clock);
        let over = self.start.elapsed(clock) >= self.ramp.duration();
        let gap = self.wanted.target - now.velocity;
        if over && gap.abs() <= REACHED_PACE_SHARE {
            self.take(0, Ramp::OwnTime(self.constant_from(now)), clock);
            return true;
        }
        if over {
            self.under_way = NONE;
        }
        let guard = Guard::new(trajectory, self.wanted.extra);
        let mut left = WORK;
        for _ in 0..TRIES {
            if self.next >= self.under_way.min(self.ramps()) {
                self.next = 0;
            }
            let ramp_index = self.next;
            let ramp = self.ramp(ramp_index, now, gap, trajectory);
            let whole = left == WORK;
            if let Some(ramp) = ramp.filter(|ramp| guard.allows(ramp, 0.0, &mut left)) {
                self.take(ramp_index, ramp, clock);
                return true;
            }
            if left == 0 && !whole {
                // The next tick has time to check it.
                break;
            }
            self.next += 1;
        }
        false
    }

    /// The active ramp keeps the limits of another trajectory, which continues the present one.
    pub(super) fn suits(&self, new: &Trajectory, old: &Trajectory, clock: &Clock) -> bool {
        let elapsed = self.start.elapsed(clock);
        let ramp = self.on(new, old, clock).ramp;
        elapsed >= ramp.duration() || Guard::new(new, self.wanted.extra).allows(&ramp, elapsed, &mut { WORK })
    }

    /// The same on another trajectory, which continues the present one.
    pub(super) fn on(&self, new: &Trajectory, old: &Trajectory, clock: &Clock) -> Self {
        let own = self.at(old, clock).position;
        Pace {
            ramp: self.ramp.on(new, old, own),
            ..*self
        }
    }

    fn take(&mut self, ramp_index: usize, ramp: Ramp, clock: &Clock) {
        self.ramp = ramp;
        self.start = clock.now();
        (self.under_way, self.next) = (ramp_index, 0);
    }

    fn constant_from(&self, now: KinematicState) -> Profile {
        let state = KinematicState {
            velocity: self.wanted.target,
            acceleration: 0.0,
            ..now
        };
        Profile::to_velocity(state, self.wanted.target, &limits(1.0, None))
    }

    /// The ramps, the best first: stops along the curve; ramps of the pace at the full rates; at rates that suit the present state; then shorter distances,
    /// and the same with gentler rates. `None`: there is no such ramp in the present state.
    fn ramp(&self, ramp_index: usize, now: KinematicState, gap: f64, trajectory: &Trajectory) -> Option<Ramp> {
        let Some(stop) = &self.wanted.stop else {
            return Some(Ramp::OwnTime(self.ramp_of_pace(ramp_index, now, gap, trajectory)));
        };
        match STOPS.get(ramp_index) {
            Some(&share) => CurveStop::new(&now, trajectory, stop, share).map(Ramp::Stop),
            None => Some(Ramp::OwnTime(self.ramp_of_pace(
                ramp_index - STOPS.len(),
                now,
                gap,
                trajectory,
            ))),
        }
    }

    fn ramp_of_pace(&self, ramp_index: usize, now: KinematicState, gap: f64, trajectory: &Trajectory) -> Profile {
        let number = match (ramp_index.checked_sub(1), self.wanted.near) {
            (Some(near), Some(most)) if near < NEAR.len() => {
                let (rate, jerk) = near_rates(most, NEAR[near], &trajectory.at(now.position), trajectory.peaks().speed);
                return Profile::to_velocity(now, self.wanted.target, &limits(rate, jerk));
            }
            (Some(_), Some(_)) => ramp_index - NEAR.len(),
            _ => ramp_index,
        };
        let (reach, gentler) = (number % REACHES.len(), number / REACHES.len());
        let target = self.wanted.target - gap * REACHES[reach];
        // Twice the time: half the rate, a quarter of the jerk.
        let time = f64::powi(2.0, gentler as i32);
        let jerk = self.wanted.jerk.map(|jerk| jerk / (time * time));
        Profile::to_velocity(now, target, &limits(self.wanted.rate / time, jerk))
    }

    fn ramps(&self) -> usize {
        let stops = self.wanted.stop.map_or(0, |_| STOPS.len());
        RAMPS + self.wanted.near.map_or(0, |_| NEAR.len()) + stops
    }
}

/// First and second derivative of the pace that take a share of a vector rate and of a jerk in a state of the trajectory: the speed takes
/// `q' r'` of the rate, and `3 q'' r r' + q' r''` of the jerk.
fn near_rates((rate, jerk): (f64, Option<f64>), share: f64, state: &AxesState, peak: f64) -> (f64, Option<f64>) {
    let speed = state.velocity.norm().max(LEAST_RAMP_SPEED_SHARE * peak);
    let first = jerk.map_or(f64::INFINITY, |jerk| jerk / (3.0 * state.acceleration.norm()));
    (share * first.min(rate / speed), jerk.map(|jerk| share * jerk / speed))
}

fn limits(rate: f64, jerk: Option<f64>) -> Limits {
    Limits {
        speed: 1.0,
        acceleration: rate,
        deceleration: rate,
        jerk: jerk.map(both),
    }
}

/// No ramp to the requested pace is active.
const NONE: usize = usize::MAX;
/// Shares of the distance to the requested pace that a ramp leaves.
const REACHES: [f64; 3] = [0.0, 0.1, 0.5];
/// Shares of the rates and the jerk of ramps that suit the present state. Not all: the guard counts in what may lie between its points.
const NEAR: [f64; 8] = [0.95, 0.75, 0.58, 0.45, 0.35, 0.26, 0.18, 0.12];
/// Shares of the rates and the jerk of stops along the curve.
const STOPS: [f64; 9] = [1.0, 0.99, 0.97, 0.94, 0.9, 0.84, 0.76, 0.66, 0.55];
/// Number of other ramps: the gentlest takes 2^13 times as long.
const RAMPS: usize = 14 * REACHES.len();
/// Most samples and examined stretches of ramps in a tick; a ramp that needs more is not allowed.
const WORK: usize = 4500;
/// Ramps to try in a tick.
const TRIES: usize = 3;

//! A ramp of the pace of a trajectory's own time: one of the pace itself, or a stop along the curve.
//!
//! A ramp of the pace lowers what the trajectory does; while the trajectory accelerates, the speed along the curve falls later than the pace. A stop along
//! the curve is the stop of a single move: its profile gives the length of the curve, and the pace follows from it. Position units, seconds; paces as
//! [`super::pace`]. Nothing allocates.

use arcline_contour::{AxesState, Trajectory};
use arcline_geometry::Point;
use arcline_profile::{DynamicsBits, KinematicState, Limits, Profile};

use super::guard::{Extra, Rate};
use crate::running::scaled_limits;
use crate::tolerance::LEAST_RAMP_SPEED_SHARE;

/// A ramp of the pace.
#[derive(Clone, Copy, Debug)]
pub(super) enum Ramp {
    /// Its position is the trajectory's own time.
    OwnTime(Profile),
    /// A stop along the curve.
    Stop(CurveStop),
}

/// A stop along the curve of a trajectory.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveStop {
    /// Its position is the length of the curve from the beginning of the stop.
    pub(super) along: Profile,
    /// Length of the trajectory's curve up to there.
    pub(super) from: f64,
}

/// The rates of a stop along the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StopRequest {
    pub(super) limits: Limits,
    /// Limits that are used instead where a stop is shorter with them.
    pub(super) other: Option<Limits>,
    /// The limits of the motion so far.
    pub(super) before: Limits,
    pub(super) dynamics_bits: DynamicsBits,
}

impl StopRequest {
    /// The rates that it needs besides those of the moves, up to an instant of the trajectory's own time.
    pub(super) fn extra(&self, until: Option<f64>) -> Extra {
        let all = [Some(self.limits), self.other, Some(self.before)];
        let most = |of: fn(&Limits) -> f64| all.iter().flatten().map(of).fold(0.0, f64::max);
        Extra {
            deceleration: most(|limits| limits.deceleration),
            jerk: most(|limits| limits.jerk.map_or(0.0, |jerk| jerk.acceleration.max(jerk.deceleration))),
            until: until.unwrap_or(f64::INFINITY),
        }
    }

    fn plan(&self, from: KinematicState, share: f64) -> Profile {
        let before = Limits {
            jerk: scaled_limits(&self.before, 1.0, share).jerk,
            ..self.before
        };
        let planned = |limits: &Limits| {
            let limits = scaled_limits(limits, 1.0, share);
            let acceleration = match (limits.jerk, before.jerk) {
                (Some(_), Some(_)) => from.acceleration,
                // A trapezoid accelerates without a jerk limit, and ends that in an instant.
                (Some(_), None) => from.acceleration.min(0.0),
                (None, _) => 0.0,
            };
            Profile::stop_within(
                KinematicState { acceleration, ..from },
                &limits,
                Some(&before),
                self.dynamics_bits,
            )
        };
        let own = planned(&self.limits);
        match self.other.as_ref().map(planned) {
            Some(other) if other.reach() < own.reach() => other,
            _ => own,
        }
    }
}

impl Ramp {
    /// Seconds from its beginning to its end.
    pub(super) fn duration(&self) -> f64 {
        match self {
            Ramp::OwnTime(profile) => profile.duration(),
            Ramp::Stop(stop) => stop.along.duration(),
        }
    }

    /// The pace at its end.
    pub(super) fn end_pace(&self) -> f64 {
        match self {
            Ramp::OwnTime(profile) => profile.end().velocity,
            Ramp::Stop(_) => 0.0,
        }
    }

    /// The trajectory's own time, the pace and its derivative, `t` seconds after its beginning.
    pub(super) fn at(&self, t: f64, trajectory: &Trajectory) -> KinematicState {
        match self {
            Ramp::OwnTime(profile) => profile.at(t),
            Ramp::Stop(stop) => stop.at(t, trajectory),
        }
    }

    /// The first time at which it reaches an instant of the trajectory's own time; `None`: never.
    pub(super) fn time_at(&self, own: f64, trajectory: &Trajectory) -> Option<f64> {
        match self {
            Ramp::OwnTime(profile) => profile.time_at_position(own),
            Ramp::Stop(stop) => stop.along.time_at_position(trajectory.arc_length(own) - stop.from),
        }
    }

    /// The same ramp on a trajectory that continues `old` and is the same up to the present instant of its own time.
    pub(super) fn on(self, new: &Trajectory, old: &Trajectory, own: f64) -> Ramp {
        match self {
            Ramp::OwnTime(_) => self,
            // Past knots may be missing.
            Ramp::Stop(stop) => Ramp::Stop(CurveStop {
                from: stop.from + (new.arc_length(own) - old.arc_length(own)),
                ..stop
            }),
        }
    }
}

impl CurveStop {
    /// From a state of the trajectory's own time and the pace, with a share of the rates of a request. `None`: the speed is so low that it does not
    /// determine the pace.
    pub(super) fn new(
        now: &KinematicState,
        trajectory: &Trajectory,
        request: &StopRequest,
        share: f64,
    ) -> Option<Self> {
        let Along { speed, change } = Along::of(&trajectory.at(now.position));
        if speed < least_speed(trajectory) {
            return None;
        }
        let acceleration = change * now.velocity * now.velocity + speed * now.acceleration;
        let state = KinematicState {
            position: 0.0,
            velocity: speed * now.velocity,
            acceleration,
        };
        Some(CurveStop {
            along: request.plan(state, share),
            from: trajectory.arc_length(now.position),
        })
    }

    fn at(&self, t: f64, trajectory: &Trajectory) -> KinematicState {
        let now = self.along.at(t);
        let own = trajectory.time_at_length(self.from + now.position);
        let along = Along::of(&trajectory.at(own));
        let [pace, first] = along.pace(now.velocity, now.acceleration);
        KinematicState {
            position: own,
            velocity: pace,
            acceleration: first,
        }
    }
}

/// The motion of a trajectory along its curve, by its own time.
pub(super) struct Along {
    pub(super) speed: f64,
    /// First derivative of the speed.
    pub(super) change: f64,
}

impl Along {
    pub(super) fn of(state: &AxesState) -> Self {
        let speed = state.velocity.norm();
        let change = if speed > 0.0 {
            state.velocity.dot(&state.acceleration) / speed
        } else {
            0.0
        };
        Along { speed, change }
    }

    /// The pace and its derivative for a speed and an acceleration along the curve.
    pub(super) fn pace(&self, speed: f64, acceleration: f64) -> [f64; 2] {
        if speed == 0.0 && acceleration == 0.0 || self.speed == 0.0 {
            return [0.0; 2];
        }
        let pace = speed / self.speed;
        [pace, (acceleration - self.change * pace * pace) / self.speed]
    }

    /// As [`Along::pace`], with the jerk along the curve, of a state with a jerk of its own.
    pub(super) fn rate(&self, state: &AxesState, own_jerk: &Point, [speed, acceleration, jerk]: [f64; 3]) -> Rate {
        let [pace, first] = self.pace(speed, acceleration);
        let turning = state.acceleration.norm_squared() + state.velocity.dot(own_jerk) - self.change * self.change;
        let own = turning / self.speed;
        let second = (jerk - own * pace * pace * pace - 3.0 * self.change * pace * first) / self.speed;
        Rate { pace, first, second }
    }
}

/// The least speed of a trajectory at which a stop along its curve determines the pace.
pub(super) fn least_speed(trajectory: &Trajectory) -> f64 {
    LEAST_RAMP_SPEED_SHARE * trajectory.peaks().speed
}

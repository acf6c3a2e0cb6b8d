//! What a profile aims at: the end of its path or of several joined ones, at the speed that the queue behind it
//! allows, and when the successor takes over.
//!
//! Bounded: a fixed number of pending moves is looked at (spec/motion-core.md §7).

use arcline_profile::{Jerk, Limits, Profile, State, exit_speed};

use crate::Clock;
use crate::junction::{Junction, joins, junction, junction_speed};
use crate::planner::{Move, Planner, Running};

/// Pending moves that a junction speed looks at. Behind them the path is taken to end at rest, which is always
/// possible, so the work of a tick is bounded.
const LOOK_AHEAD: usize = 32;
/// How far behind its end, as a share of a path, a stop on it may seem to be by rounding.
const STOP_ROUNDING: f64 = 1e-12;

impl<T: Copy> Planner<T> {
    /// What the profile of a move that is in state `from` aims at.
    pub(crate) fn plan(&self, running: &Running<T>, from: State) -> Plan {
        let mut target = running.motion.path.length();
        let mut joined = 0;
        if running.track.residual.is_some() {
            // Its compensation moves with the speed along the path, so the path ends at rest.
            return Plan {
                target,
                exit: 0.0,
                joined,
            };
        }
        let mut first = &running.motion;
        for second in self.pending.iter().take(LOOK_AHEAD) {
            if !joins(first, second, joined > 0 || running.blended) {
                break;
            }
            target += second.path.length();
            joined += 1;
            first = second;
        }
        let wanted = self.look_ahead(first, joined, running.blended);
        let exit = if wanted > 0.0 {
            wanted.min(exit_speed(from, target - from.position, &running.motion.limits))
        } else {
            self.unavoidable_exit(first, joined, running, from, target)
        };
        Plan { target, exit, joined }
    }

    /// The speed at the end of a path that is to be held, but too late for that: what braking leaves there. The
    /// moves behind it brake on, so that a hold stays on the path.
    fn unavoidable_exit(&self, last: &Move<T>, joined: usize, running: &Running<T>, from: State, target: f64) -> f64 {
        let Some(next) = self.pending.get(joined) else {
            return 0.0;
        };
        let passable = matches!(
            junction(last, next, joined > 0 || running.blended),
            Junction::Pass { .. } | Junction::Overtake { .. }
        );
        if !passable || running.motion.limits.speed > 0.0 {
            return 0.0;
        }
        let stop = Profile::stop(from, &running.motion.limits);
        if stop.end().position <= target + STOP_ROUNDING * target.abs() {
            return 0.0;
        }
        stop.time_at_position(target).map_or(0.0, |time| stop.at(time).velocity)
    }

    /// The speed that the junction behind a move allows, seen from the end of the queue. `place` is that of the
    /// pending move behind it.
    fn look_ahead(&self, from: &Move<T>, from_place: usize, blended: bool) -> f64 {
        let seen = self.pending.len().min(from_place + LOOK_AHEAD);
        let mut exit = 0.0;
        for place in (from_place..seen).rev() {
            let second = &self.pending[place];
            let first = if place == from_place {
                from
            } else {
                &self.pending[place - 1]
            };
            let joined = junction(first, second, blended || place > 0);
            exit = junction_speed(first, second, joined, exit, &self.corner_step);
        }
        exit
    }

    /// After the queue has grown: the active move may end faster than it was planned to, or be joined.
    pub(crate) fn raise_exit(&mut self, clock: &Clock) {
        let Some(mut running) = self.active else {
            return;
        };
        let from = running.track.state(clock);
        let plan = self.plan(&running, from);
        if plan.exit > running.exit || plan.joined > running.joined {
            let profile = Profile::to_position(from, plan.target, plan.exit, &plan.limits(running.limits()));
            running.follow(plan, profile, clock);
            self.active = Some(running);
        }
    }

    /// Finds when the successor takes over, if it does so before the programmed end.
    pub(crate) fn schedule(&mut self, clock: &Clock) {
        self.hand_over_at = None;
        let (Some(running), Some(next)) = (&self.active, self.pending.front()) else {
            return;
        };
        let track = &running.track;
        // A pause may end behind the active path where the profile runs over several.
        let paused = !track.profile.arrives();
        if paused && running.joined == 0 {
            return;
        }
        let now = track.start.elapsed(clock);
        let length = running.motion.path.length();
        let reaches = |distance: f64| {
            track
                .profile
                .time_at_position(track.offset + length - distance)
                .unwrap_or(0.0)
        };
        let mut at = match junction(&running.motion, next, running.blended) {
            _ if running.joined > 0 => {
                let end = track.offset + length;
                match track.profile.time_at_position(end) {
                    Some(at) => at,
                    None if paused => return,
                    None => track.profile.duration(),
                }
            }
            Junction::Rest | Junction::Pass { early: false, .. } => return,
            Junction::Pass { early: true, .. } => track.profile.brakes_from(),
            Junction::Overtake { tolerance } => reaches(tolerance),
            Junction::Blend { tolerance } => {
                let begins =
                    track
                        .profile
                        .brakes_from()
                        .max(if tolerance.is_finite() { reaches(tolerance) } else { 0.0 });
                let begins = begins.max(now);
                let braking = track.profile.duration() - begins;
                let rising = Profile::to_position(State::default(), next.path.length(), 0.0, &next.limits);
                begins + (braking - rising.accelerates_until()).max(0.0)
            }
        };
        if let Some(tail) = &self.tail {
            // Two moves overlap at most: a third waits.
            at = at.max(tail.duration(clock) + now - tail.start.elapsed(clock));
        }
        let at = at.max(now);
        if at < track.duration(clock) {
            self.hand_over_at = Some(at);
        }
    }
}

/// What a profile aims at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// Distance from the start of the active path.
    pub(crate) target: f64,
    /// Speed there.
    pub(crate) exit: f64,
    /// Pending moves on the way.
    pub(crate) joined: usize,
}

impl Plan {
    /// The limits for a profile that ends at the exit speed, which may be above that of a move that is held.
    pub(crate) fn limits(&self, limits: Limits) -> Limits {
        Limits {
            speed: limits.speed.max(self.exit),
            ..limits
        }
    }
}

impl<T> Running<T> {
    /// The limits that the profile along the path keeps.
    pub(crate) fn limits(&self) -> Limits {
        let limits = self.motion.limits;
        match &self.track.residual {
            Some(residual) if residual.pace < 1.0 => Limits {
                speed: limits.speed * residual.pace,
                acceleration: limits.acceleration * residual.pace,
                deceleration: limits.deceleration * residual.pace,
                jerk: limits.jerk.map(|jerk| Jerk {
                    acceleration: jerk.acceleration * residual.pace,
                    deceleration: jerk.deceleration * residual.pace,
                }),
            },
            _ => limits,
        }
    }

    pub(crate) fn follow(&mut self, plan: Plan, profile: Profile, clock: &Clock) {
        self.track.replan(profile, clock);
        self.exit = plan.exit;
        self.joined = plan.joined;
    }
}

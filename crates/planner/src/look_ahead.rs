//! The aim of a profile: the next junction that binds it, at the speed that the queue behind it allows, and when the
//! successor takes over.
//!
//! Whatever changes, and whenever: a profile ends with acceleration 0 at a place from which the rest of the queue can
//! be travelled, or where a stop has led it. A place within a run of equal rates that is met too fast or too slow is no
//! such place: it is led over. At the end of a run the speed may then be higher than programmed, but never such that
//! the path must be left. A corner that is met faster than the axes can follow it is a rest: the motion goes beyond it along
//! the end tangent, as beyond an end, and comes back. Bounded: a fixed number of bounds is looked at (spec/motion-core.md §7).

use arcline_profile::{Jerk, KinematicState, Limits, Passing, Profile, passing_speed};

use crate::junction::{Junction, JunctionDemand, junction};
use crate::planner::Planner;
use crate::queue::Bound;
use crate::running::{Running, scaled_limits};
use crate::tolerance::ROUNDING_SHARE;
use crate::{Clock, Instant};

/// Slower moves of a run that a profile may lead over.
const LED_OVER: usize = 6;

impl<T: Copy> Planner<T> {
    /// The aim of the profile of a move that is in state `from`.
    pub(crate) fn plan(&self, running: &Running<T>, from: KinematicState) -> Plan {
        let limits = self.limits(running);
        let length = running.motion.path.length();
        let mut cap = limits.speed;
        if running.trajectory.residual.is_some() {
            // Its compensation moves with the speed along the path, so the path ends at rest.
            return Plan {
                target: length,
                exit: 0.0,
                joined: 0,
                cap,
                corners: f64::INFINITY,
                ends: Ends::AsItMust,
            };
        }
        let queue = &self.queue;
        let towards = |bound: &Bound, exit: f64, cap: f64| {
            let target = bound.at - running.run_start;
            let joined = queue.moves_before(bound);
            let at_end = joined == 0 && (target - length).abs() <= ROUNDING_SHARE * length;
            Plan {
                target: if at_end { length } else { target },
                exit,
                joined,
                cap,
                corners: queue.corners(bound),
                ends: Ends::AsItMust,
            }
        };
        if cap > 0.0 {
            let mut seen = 0;
            for bound in queue.slower() {
                let distance = bound.at - running.run_start - from.position;
                let wanted = queue.speed(bound).min(cap);
                let ahead = distance >= 0.0;
                let Passing { speed, level } = passing_speed(from, distance, wanted, &Limits { speed: cap, ..limits });
                seen += 1;
                let slow = seen == LED_OVER && speed < wanted && from.velocity <= cap;
                if ahead && level && (speed == wanted || slow) {
                    return towards(bound, speed, cap);
                }
                if seen == LED_OVER {
                    break;
                }
                cap = cap.min(bound.demand.programmed() * queue.rate());
            }
        }
        let end = queue.run_end(running.run_start + length);
        let wanted = queue.speed(&end).min(cap);
        let distance = end.at - running.run_start - from.position;
        let beyond = distance < -ROUNDING_SHARE * (running.run_start + from.position).abs();
        if beyond && end.demand.corner().is_finite() {
            // It comes back to a corner, and turns there.
            return Plan {
                ends: Ends::Overshooting,
                ..towards(&end, 0.0, cap)
            };
        }
        if beyond {
            // Where the path goes on straight, the motion does: the next move is planned while the acceleration is taken away.
            return Plan {
                target: from.position,
                joined: queue.moves_before(&end) + 1,
                ends: Ends::TooFast,
                ..towards(&end, from.velocity.max(0.0), cap)
            };
        }
        let Passing { speed, level } = passing_speed(from, distance, wanted, &Limits { speed: cap, ..limits });
        let plan = towards(&end, speed, cap);
        if end.demand == JunctionDemand::Rest {
            let ends = if level && speed == 0.0 {
                Ends::AsItMust
            } else {
                Ends::Overshooting
            };
            return Plan {
                exit: 0.0,
                ends,
                ..plan
            };
        }
        let too_fast = speed > wanted && speed > queue.must(&end) * (1.0 + ROUNDING_SHARE);
        if level && !too_fast && !turns_back(&from, &limits) {
            return plan;
        }
        if too_fast && can_rest(from, distance, &limits) {
            return Plan { exit: 0.0, ..plan };
        }
        let plan = Plan {
            ends: Ends::TooFast,
            ..plan
        };
        let corner = end.demand.corner();
        if corner.is_finite() && self.profile(running, from, &plan).end().velocity > corner * (1.0 + ROUNDING_SHARE) {
            return Plan { exit: 0.0, ..plan };
        }
        plan
    }

    /// The limits that the profile along the path keeps.
    pub(crate) fn limits(&self, running: &Running<T>) -> Limits {
        scaled_limits(&running.keeps(), self.queue.rate(), running.trajectory.share())
    }

    /// A profile that does what a plan says.
    pub(crate) fn profile(&self, running: &Running<T>, from: KinematicState, plan: &Plan) -> Profile {
        // The exit speed may be above that of a move that is held.
        let limits = Limits {
            speed: plan.cap.max(plan.exit),
            ..self.limits(running)
        };
        Profile::to_position(from, plan.target, plan.exit, &limits)
    }

    /// After the queue has grown, or more of it has been looked at: the active move may go over into what lies behind
    /// it, or end faster than it was planned to.
    pub(crate) fn raise_exit(&mut self, clock: &Clock) {
        let Some(mut running) = self.active.filter(|running| !running.stopped) else {
            return;
        };
        let approaching = running.trajectory.is_approaching(clock);
        let from = if approaching {
            running.trajectory.profile.start()
        } else {
            running.trajectory.state(clock)
        };
        let (plan, profile) = self.planned(&running, from);
        // A corner that was not known may lie behind what was to be passed.
        let too_fast = plan.exit < running.exit && running.exit > plan.corners * (1.0 + ROUNDING_SHARE);
        if plan.exit > running.exit || plan.joined != running.joined || too_fast {
            if approaching {
                running.trajectory.profile = profile;
                running.aim(&plan);
            } else {
                running.follow(&plan, profile, clock.now());
            }
            self.active = Some(running);
        }
    }

    /// Finds when the successor takes over, if it does so before the programmed end; not before `since`.
    pub(crate) fn schedule(&mut self, since: Instant, clock: &Clock) {
        self.plans = self.plans.wrapping_add(1);
        self.hand_over_at = None;
        let (Some(running), Some(next)) = (&self.active, self.queue.front()) else {
            return;
        };
        let trajectory = &running.trajectory;
        let profile = &trajectory.profile;
        // A pause may end behind the active path where the profile runs over several.
        let paused = !profile.arrives();
        if paused && running.joined == 0 {
            return;
        }
        let elapsed = trajectory.start.elapsed(clock);
        let since = elapsed - since.elapsed(clock);
        let length = running.motion.path.length();
        let reaches = |distance: f64| profile.time_at_position(trajectory.offset + length - distance);
        let between = junction(&running.motion, next, running.blended);
        let at = match between {
            _ if running.joined > 0 => {
                let tolerance = match between {
                    Junction::Overtake { tolerance } => tolerance,
                    _ => 0.0,
                };
                match reaches(tolerance) {
                    Some(at) => at,
                    None if trajectory.offset + length - tolerance <= profile.start().position => 0.0,
                    None if paused => return,
                    None => profile.duration(),
                }
            }
            Junction::Rest | Junction::Pass { early: false, .. } => return,
            Junction::Pass { .. } | Junction::Overtake { .. } if trajectory.residual.is_some() => return,
            Junction::Pass { early: true, .. } => profile.brakes_from(),
            Junction::Overtake { tolerance } => reaches(tolerance).unwrap_or(0.0).min(profile.duration()),
            Junction::Blend { tolerance } => {
                let within = if tolerance.is_finite() {
                    reaches(tolerance).unwrap_or(0.0)
                } else {
                    0.0
                };
                let begins = profile.brakes_from().max(within).max(since);
                // To its rest, and to that of what ramps out beside it.
                let braking = trajectory.duration(clock) - begins;
                let limits = Limits {
                    speed: next.limits.speed * self.queue.rate(),
                    ..next.limits
                };
                let rising = Profile::to_position(KinematicState::default(), next.path.length(), 0.0, &limits);
                begins + (braking - rising.accelerates_until()).max(0.0)
            }
        };
        // Not while the end of the move before the active one is still being travelled.
        let begun = if profile.start().position < trajectory.offset {
            reaches(length).unwrap_or(0.0)
        } else {
            0.0
        };
        let mut at = at.max(since).max(begun);
        if running.joined > 0 {
            self.hand_over_at = Some(at);
            return;
        }
        if let Some(tail) = &self.tail {
            // Two moves overlap at most: a third waits.
            at = at.max(tail.duration(clock) + elapsed - tail.start.elapsed(clock));
        }
        if at < trajectory.duration(clock) || matches!(between, Junction::Overtake { .. }) {
            self.hand_over_at = Some(at);
        }
    }
}

/// The aim of a profile.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// Distance from the start of the active path.
    pub(crate) target: f64,
    /// Speed there.
    pub(crate) exit: f64,
    /// Pending moves on the way.
    pub(crate) joined: usize,
    /// The speed limit on the way.
    pub(crate) cap: f64,
    /// The speed there from which the corners behind it can be met.
    pub(crate) corners: f64,
    pub(crate) ends: Ends,
}

/// How a profile meets what lies ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ends {
    /// Such that the rest of the queue can be travelled.
    AsItMust,
    /// With more speed than the corner, or the way behind it, allows; or before the acceleration is 0; or turning back. Where the
    /// axes could not follow the corner, with a rest there.
    TooFast,
    /// Beyond the rest that it was to come to, and back.
    Overshooting,
}

/// Whether the motion can come to rest within a way, where it cannot come down to a lower speed: with a limited jerk, the last of a
/// deceleration to rest takes less way than the one to a speed above (a move that came into the queue since has such a speed at its
/// beginning).
fn can_rest(from: KinematicState, distance: f64, limits: &Limits) -> bool {
    let rest = Profile::stop(from, limits).end().position - from.position;
    (0.0..=distance * (1.0 + ROUNDING_SHARE)).contains(&rest)
}

/// Whether a deceleration can only be taken back when the motion has passed through rest.
pub(crate) fn turns_back(from: &KinematicState, limits: &Limits) -> bool {
    let relieved = |jerk: Jerk| 0.5 * from.acceleration * from.acceleration / jerk.deceleration;
    let least = (1.0 + ROUNDING_SHARE) * from.velocity;
    from.acceleration < 0.0 && limits.jerk.is_some_and(|jerk| least < relieved(jerk))
}

impl<T> Running<T> {
    pub(crate) fn follow(&mut self, plan: &Plan, profile: Profile, at: Instant) {
        self.trajectory.replan(profile, at);
        self.aim(plan);
    }

    pub(crate) fn aim(&mut self, plan: &Plan) {
        self.exit = plan.exit;
        self.joined = plan.joined;
    }
}

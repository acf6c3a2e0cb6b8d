//! The aim of a profile: the next junction that binds it, at the speed that the queue behind it permits, and the instant at which the
//! successor becomes active.
//!
//! At any change, a profile ends with acceleration 0 at a point from which the rest of the queue can be executed, or at the end of a stop. A
//! junction within a run of equal rates that is reached too fast or too slowly is not such a point: the profile continues across it. At the
//! end of a run the speed may then be higher than programmed, but never so high that the motion must leave the path. A corner that is
//! reached faster than the axes can follow it becomes a rest: the motion overshoots it along the end tangent, as at a programmed end, and
//! returns. Bounded: a fixed number of bounds is examined (spec/motion-core.md §7).

use arcline_profile::{Jerk, KinematicState, Limits, Passing, Profile, passing_speed};

use crate::junction::{Junction, JunctionDemand, junction};
use crate::planner::Planner;
use crate::queue::Bound;
use crate::running::{Running, scaled_limits};
use crate::tolerance::ROUNDING_SHARE;
use crate::{Clock, Instant};

/// Slower moves of a run that one profile may cross.
const MAX_CROSSED_MOVES: usize = 6;

impl<T: Copy> Planner<T> {
    /// The aim of the profile of a move in state `from`.
    pub(crate) fn plan(&self, running: &Running<T>, from: KinematicState) -> Plan {
        let limits = self.limits(running);
        let length = running.motion.path.length();
        let mut cap = limits.speed;
        if running.trajectory.residual.is_some() {
            // The compensation of a residual moves with the speed along the path, so the path ends at rest.
            return Plan {
                target: length,
                exit: 0.0,
                joined: 0,
                cap,
                corners: f64::INFINITY,
                end_quality: EndQuality::Feasible,
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
                end_quality: EndQuality::Feasible,
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
                let slow = seen == MAX_CROSSED_MOVES && speed < wanted && from.velocity <= cap;
                if ahead && level && (speed == wanted || slow) {
                    return towards(bound, speed, cap);
                }
                if seen == MAX_CROSSED_MOVES {
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
            // The motion returns to the corner and continues there.
            return Plan {
                end_quality: EndQuality::Overshooting,
                ..towards(&end, 0.0, cap)
            };
        }
        if beyond {
            // On a straight path the motion continues: the next move is planned while the acceleration ramps down.
            return Plan {
                target: from.position,
                joined: queue.moves_before(&end) + 1,
                end_quality: EndQuality::TooFast,
                ..towards(&end, from.velocity.max(0.0), cap)
            };
        }
        let Passing { speed, level } = passing_speed(from, distance, wanted, &Limits { speed: cap, ..limits });
        let plan = towards(&end, speed, cap);
        if end.demand == JunctionDemand::Rest {
            let end_quality = if level && speed == 0.0 {
                EndQuality::Feasible
            } else {
                EndQuality::Overshooting
            };
            return Plan {
                exit: 0.0,
                end_quality,
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
            end_quality: EndQuality::TooFast,
            ..plan
        };
        let corner = end.demand.corner();
        if corner.is_finite() && self.profile(running, from, &plan).end().velocity > corner * (1.0 + ROUNDING_SHARE) {
            return Plan { exit: 0.0, ..plan };
        }
        plan
    }

    /// The limits of the profile along the path.
    pub(crate) fn limits(&self, running: &Running<T>) -> Limits {
        scaled_limits(&running.profile_limits(), self.queue.rate(), running.trajectory.share())
    }

    /// The profile of a plan.
    pub(crate) fn profile(&self, running: &Running<T>, from: KinematicState, plan: &Plan) -> Profile {
        // The exit speed may exceed the speed of a held move.
        let limits = Limits {
            speed: plan.cap.max(plan.exit),
            ..self.limits(running)
        };
        Profile::to_position(from, plan.target, plan.exit, &limits)
    }

    /// Plans the active move again after the queue has grown, or after more of it was examined: the move may continue into the following ones,
    /// or end faster than planned.
    pub(crate) fn raise_exit(&mut self, clock: &Clock) {
        let Some(running) = self.active.as_ref().filter(|running| !running.stopped) else {
            return;
        };
        let approaching = running.trajectory.is_approaching(clock);
        let from = if approaching {
            running.trajectory.profile.start()
        } else {
            running.trajectory.state(clock)
        };
        let (plan, profile) = self.planned(running, from);
        // A corner unknown before may lie behind the planned junction.
        let too_fast = plan.exit < running.exit && running.exit > plan.corners * (1.0 + ROUNDING_SHARE);
        let better = plan.exit > running.exit || plan.joined != running.joined || too_fast;
        let Some(running) = self.active.as_mut().filter(|_| better) else {
            return;
        };
        if approaching {
            running.trajectory.profile = profile;
            running.aim(&plan);
        } else {
            running.follow(&plan, profile, clock.now());
        }
    }

    /// Determines the instant at which the successor becomes active, if that is before the programmed end; not before `since`.
    pub(crate) fn schedule(&mut self, since: Instant, clock: &Clock) {
        self.plans = self.plans.wrapping_add(1);
        self.hand_over_at = None;
        let (Some(running), Some(next)) = (&self.active, self.queue.front()) else {
            return;
        };
        let trajectory = &running.trajectory;
        let profile = &trajectory.profile;
        // A profile over several moves may pause behind the active path.
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
                // To the rest of the move, and of its residual.
                let braking = trajectory.duration(clock) - begins;
                let limits = Limits {
                    speed: next.limits.speed * self.queue.rate(),
                    ..next.limits
                };
                let rising = Profile::to_position(KinematicState::default(), next.path.length(), 0.0, &limits);
                begins + (braking - rising.accelerates_until()).max(0.0)
            }
        };
        // Not before the motion has left the end of the previous move.
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
            // At most two moves overlap: a third waits.
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
    /// Pending moves that the profile crosses.
    pub(crate) joined: usize,
    /// The speed limit on the profile.
    pub(crate) cap: f64,
    /// The speed at the target from which the corners behind it can be met.
    pub(crate) corners: f64,
    pub(crate) end_quality: EndQuality,
}

/// The quality of the end of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EndQuality {
    /// The rest of the queue can be executed from it.
    Feasible,
    /// With more speed than the corner, or the distance behind it, permits; or with an acceleration; or after a reversal. If the axes could not
    /// follow the corner, the motion rests there.
    TooFast,
    /// Beyond the planned rest, with a return to it.
    Overshooting,
}

/// The motion can come to rest within a distance. It may be able to even where it cannot come down to a lower speed: with a limited jerk, the
/// final part of a deceleration to rest is shorter than that to a speed above 0, such as that at the beginning of a move queued meanwhile.
fn can_rest(from: KinematicState, distance: f64, limits: &Limits) -> bool {
    let rest = Profile::stop(from, limits).end().position - from.position;
    (0.0..=distance * (1.0 + ROUNDING_SHARE)).contains(&rest)
}

/// A deceleration cannot ramp down before the motion has passed through rest.
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

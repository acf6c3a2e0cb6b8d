//! Changes of an active move: its limits, and the override of the programmed speeds.
//!
//! Bounded.

use arcline_profile::{KinematicState, Limits, MOST_OVERSHOOT, Profile, entry_speed, passing_speed, stop_distance};

use crate::Clock;
use crate::junction::same_rates;
use crate::look_ahead::{EndQuality, Plan, turns_back};
use crate::move_trajectory::Approach;
use crate::path_with_residual::PathWithResidual;
use crate::planner::Planner;
use crate::running::{AccelerationRemoval, Move, Running, scaled_limits};
use crate::tolerance::ROUNDING_SHARE;

impl<T: Copy> Planner<T> {
    /// Gives the active move new limits from the present tick on. Its profile is planned again from the present state, in two stages if the
    /// end cannot be met any more (spec/motion-core.md §5). Rates that do not suffice for a corner ahead hold only from that corner on
    /// (§5.3).
    pub fn change_limits(&mut self, limits: Limits, clock: &Clock) {
        let limits = self.allowed(&limits);
        let Some(running) = &mut self.active else {
            return;
        };
        let before = running.motion.limits;
        let ran = Ran::new(running, self.queue.rate(), clock);
        running.motion.limits = limits;
        let met = self.replan(&ran, clock);
        if met == Met::All || same_rates(&before, &limits) {
            return;
        }
        // The rates of the moves on which the motion brakes already are tried first, then the old ones; of equal results the last one counts.
        let following = self.queue.front().map_or(limits, |next| next.limits);
        let mut best = (met, limits);
        for rates in [following, before] {
            let met = self.replan_with(&rates, &ran, clock);
            if met >= best.0 {
                best = (met, rates);
            }
        }
        if best.1 != before {
            self.replan_with(&best.1, &ran, clock);
        }
    }

    /// Plans the active move again at its speed with other rates.
    fn replan_with(&mut self, rates: &Limits, ran: &Ran, clock: &Clock) -> Met {
        if let Some(running) = &mut self.active {
            let speed = running.motion.limits.speed;
            running.motion.limits = Limits { speed, ..*rates };
        }
        self.replan(ran, clock)
    }

    /// Changes all pending moves; `limits` are the future ones of the active move. [`Planner::change_limits`] then puts the change into effect.
    pub fn change_pending(&mut self, limits: &Limits, clock: &Clock, change: impl FnMut(&mut Move<T>)) {
        let distance = self.active.as_ref().map_or(0.0, |running| {
            let now = running.trajectory.state(clock);
            let top = now.velocity.max(limits.speed * self.queue.rate());
            // Over a master's displacement, the distance of an update is unknown.
            let distance = if clock.period_ns == 0 {
                f64::INFINITY
            } else {
                top * clock.period() * self.queue.ticks_of_a_change() as f64
            };
            stop_distance(top, limits) + distance - (running.motion.path.length() - now.position)
        });
        self.queue.change_all(distance, change);
    }

    /// Sets the override, a share (at least 0) of the programmed speeds of the active, the pending and all later moves, from the present
    /// tick on; 0 holds. Without effect on an active stop.
    pub fn set_rate(&mut self, rate: f64, clock: &Clock) {
        let most = self.most_rate();
        let ran = self
            .active
            .as_ref()
            .map(|running| Ran::new(running, self.queue.rate(), clock));
        self.queue.set_rate(rate.min(most));
        if let Some(ran) = ran {
            self.replan(&ran, clock);
        }
    }

    /// Plans the active move again from its present state. `ran`: its profile before the change.
    fn replan(&mut self, ran: &Ran, clock: &Clock) -> Met {
        let Some(mut running) = self.active.filter(|running| !running.stopped) else {
            return Met::All;
        };
        running.run_start = self.queue.relink(&running.motion, running.blended);
        if let Some(approach) = running
            .trajectory
            .approach
            .filter(|_| running.trajectory.is_approaching(clock))
            && !same_rates(&approach.limits, &running.motion.limits)
        {
            let start = self.approach_again(&mut running, approach, clock);
            return self.plan_from(running, start, clock);
        }
        let from = running.trajectory.state(clock);
        running.removal = self.removal_at_change(ran, running.motion.limits.speed, running.trajectory.share());
        running.in_force = running.motion.limits;
        running.has_other_limits = false;
        let paused = self.limits(&running).speed == 0.0;
        if paused && self.needs_more(&running, from, &ran.limits) {
            running.in_force = ran.limits;
            running.has_other_limits = true;
        }
        let removal_phase = running.removal.phase(from, &self.limits(&running));
        let level = removal_phase.map_or(from, |phase| phase.end());
        let plan = self.plan(&running, level);
        let profile = if plan.exit > 0.0 {
            let profile = self.profile(&running, level, &plan);
            removal_phase.map_or(profile, |phase| phase.then(&profile))
        } else if plan.cap == 0.0 {
            let limits = Limits {
                speed: 0.0,
                ..self.limits(&running)
            };
            Profile::after_removal(removal_phase, from, |from| {
                Profile::to_position_two_stage(from, plan.target, &limits)
            })
        } else {
            let limits = Limits {
                speed: plan.cap,
                ..self.limits(&running)
            };
            let planned = |from, limits: &Limits| Profile::to_position_two_stage(from, plan.target, limits);
            let beside = self.beside_again(&running, from, &limits, ran, planned, clock);
            beside.unwrap_or_else(|| Profile::after_removal(removal_phase, from, |from| planned(from, &limits)))
        };
        // A path that waits until a residual has ramped out continues to wait.
        let waits = running.trajectory.residual.is_some() && running.trajectory.start.elapsed(clock) < 0.0;
        let at = if waits { running.trajectory.start } else { clock.now() };
        running.follow(&plan, profile, at);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        Met::by(&plan)
    }

    /// The removal of an acceleration at a change of the programmed speed. The profile may overshoot that speed and the old one by half
    /// (spec/coordinated-instructions.md §5.4), and may reach the speed that the earlier profile would have reached. `share`: the profile's
    /// share of the limits.
    fn removal_at_change(&self, ran: &Ran, speed: f64, share: f64) -> AccelerationRemoval {
        if !self.dynamics_bits.overshoot {
            return AccelerationRemoval::NONE;
        }
        let programmed = ran.programmed.max(self.programmed_speed(speed));
        AccelerationRemoval {
            ceiling: (MOST_OVERSHOOT * programmed * share).max(ran.ahead),
            forward: ran.forward,
        }
    }

    /// With the limits of the move, a pause would need a longer distance than with the earlier ones, or would reverse where the earlier ones
    /// do not.
    fn needs_more(&self, running: &Running<T>, from: KinematicState, ran: &Limits) -> bool {
        if !self.dynamics_bits.overshoot {
            return false;
        }
        let limits = self.limits(running);
        let ran = scaled_limits(ran, 1.0, running.trajectory.share());
        let reach = |limits: &Limits| {
            Profile::after_removal(running.removal.phase(from, limits), from, |level| {
                Profile::stop(level, limits)
            })
            .reach()
        };
        reach(&limits) > reach(&ran) * (1.0 + ROUNDING_SHARE)
            || (turns_back(&from, &limits) && !turns_back(&from, &ran))
    }

    /// The programmed speed, raised by an override above 1. An override below 1 lowers the speed, and a motion that is still changing its
    /// speed to that keeps the time that its acceleration needs.
    pub(crate) fn programmed_speed(&self, speed: f64) -> f64 {
        raised(speed, self.queue.rate())
    }

    /// The profile of a path whose residual still ramps out; `None` without a residual.
    fn beside_again(
        &self,
        running: &Running<T>,
        from: KinematicState,
        limits: &Limits,
        ran: &Ran,
        plan: impl Fn(KinematicState, &Limits) -> Profile,
        clock: &Clock,
    ) -> Option<Profile> {
        let trajectory = &running.trajectory;
        let residual = trajectory.residual.as_ref().filter(|_| self.dynamics_bits.overshoot)?;
        let since = residual.start.elapsed(clock);
        let length = running.motion.path.length();
        if self.within.is_some() || since >= residual.duration() || length <= 0.0 {
            return None;
        }
        let present = trajectory.sample(clock).velocity.norm();
        let programmed = ran.programmed.max(self.programmed_speed(running.motion.limits.speed));
        let beside = PathWithResidual {
            path: &running.motion.path,
            parts: &residual.parts,
            since,
            bound: present.max(programmed),
        };
        let old = ran.limits.jerk.map_or(0.0, |jerk| jerk.acceleration);
        // A hold reduces the acceleration no faster than any other change.
        let below = running.removal.phase(from, limits).map_or(0.0, |phase| phase.jerk);
        let removal = limits.jerk.map_or(old, |jerk| jerk.acceleration.max(old)).max(below);
        let found = beside.profile(from, limits, removal, &plan);
        Some(found.unwrap_or_else(|| beside.waiting(from, limits, removal, &plan)))
    }

    /// Plans the approach to the start of the active path again, which has other rates. Returns the state at the start.
    fn approach_again(&self, running: &mut Running<T>, mut approach: Approach, clock: &Clock) -> KinematicState {
        let elapsed = approach.start.elapsed(clock);
        let mut from = approach.profile.at(elapsed);
        from.position -= approach.offset;
        let limits = Limits {
            speed: approach.limits.speed * self.queue.rate(),
            ..approach.limits
        };
        let length = approach.path.length();
        let ran = Ran::approaching(&approach, self.queue.rate(), elapsed);
        let removal = self.removal_at_change(&ran, running.motion.limits.speed, 1.0);
        let removal_phase = removal.phase(from, &limits);
        let level = removal_phase.map_or(from, |phase| phase.end());
        let wanted = self.entry(running).min(limits.speed);
        let exit = passing_speed(level, length - level.position, wanted, &limits).speed;
        let capped = Limits {
            speed: limits.speed.max(exit),
            ..limits
        };
        // If the approach cannot remove its acceleration before the start of the path, the profile of the path removes the rest.
        let early = level.position > length;
        let target = if early { level.position } else { length };
        approach.profile = Profile::after_removal(removal_phase, from, |level| {
            Profile::to_position(level, target, exit, &capped)
        });
        approach.offset = 0.0;
        approach.start = clock.now();
        let profile = &approach.profile;
        let distance = if early {
            profile.time_at_position(length).unwrap_or(0.0)
        } else if profile.arrives() {
            profile.duration()
        } else {
            NEVER_S
        };
        running.trajectory.start = clock.now().after(distance, clock);
        running.trajectory.approach = Some(approach);
        running.removal = if early { removal } else { AccelerationRemoval::NONE };
        // The approach overshoots the start, and returns to rest there.
        KinematicState {
            position: 0.0,
            ..if early { profile.at(distance) } else { profile.end() }
        }
    }

    /// The highest speed with which the active path can begin.
    fn entry(&self, running: &Running<T>) -> f64 {
        let limits = self.limits(running);
        let end = self.queue.run_end(running.run_start + running.motion.path.length());
        let bound = self.queue.slower().next().unwrap_or(&end);
        let distance = bound.at - running.run_start;
        limits
            .speed
            .min(entry_speed(distance, self.queue.speed(bound), &limits))
    }

    /// Plans the profile of the active path from its start, which lies ahead.
    fn plan_from(&mut self, mut running: Running<T>, from: KinematicState, clock: &Clock) -> Met {
        let (plan, profile) = self.planned(&running, from);
        running.trajectory.profile = profile;
        running.trajectory.offset = 0.0;
        running.in_force = running.motion.limits;
        running.has_other_limits = false;
        running.aim(&plan);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        Met::by(&plan)
    }
}

/// The demands of the queue that a plan meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Met {
    /// None: the motion leaves the path at a corner.
    Nothing,
    /// The corners.
    Corners,
    /// The corners, speeds and rests.
    All,
}

impl Met {
    fn by(plan: &Plan) -> Met {
        if plan.end_quality != EndQuality::TooFast {
            Met::All
        } else if plan.exit <= plan.corners * (1.0 + ROUNDING_SHARE) {
            Met::Corners
        } else {
            Met::Nothing
        }
    }
}

/// The motion of a move before a change of its limits.
struct Ran {
    /// The limits.
    limits: Limits,
    /// The programmed speed, raised by the override.
    programmed: f64,
    /// The highest speed that was planned.
    ahead: f64,
    /// The jerk that reduces a deceleration too high for the jerk of the move, if there is one.
    forward: Option<f64>,
}

impl Ran {
    fn new<T>(running: &Running<T>, rate: f64, clock: &Clock) -> Ran {
        let trajectory = &running.trajectory;
        let own = scaled_limits(&running.in_force, 1.0, trajectory.share());
        let programmed = raised(running.motion.limits.speed, rate);
        let ran = Ran::along(&trajectory.profile, trajectory.start.elapsed(clock), own, programmed);
        // The deceleration of a profile that began on an earlier move, with its rates, may also be too high.
        let earlier = running.has_other_limits || trajectory.offset != 0.0;
        Ran {
            limits: running.in_force,
            forward: ran.forward.or(taking(&own).filter(|_| earlier)),
            ..ran
        }
    }

    /// The motion of the predecessor to the start of the active path.
    fn approaching(approach: &Approach, rate: f64, elapsed: f64) -> Ran {
        let programmed = raised(approach.limits.speed, rate);
        let ran = Ran::along(&approach.profile, elapsed, approach.limits, programmed);
        Ran {
            forward: ran
                .forward
                .or(taking(&approach.limits).filter(|_| approach.has_other_limits)),
            ..ran
        }
    }

    fn along(profile: &Profile, elapsed: f64, limits: Limits, programmed: f64) -> Ran {
        let now = profile.at(elapsed);
        let braking = now.velocity > 0.0 && now.acceleration < 0.0;
        // The removal phase is active.
        let removes = |jerk: &f64| braking && taking(&limits).is_some_and(|own| *jerk > own * (1.0 + ROUNDING_SHARE));
        Ran {
            limits,
            programmed,
            ahead: profile.top_speed(elapsed),
            forward: Some(profile.jerk(elapsed)).filter(removes),
        }
    }
}

/// A speed, raised by an override above 1.
fn raised(speed: f64, rate: f64) -> f64 {
    speed * rate.max(1.0)
}

/// The jerk that reduces a deceleration.
fn taking(limits: &Limits) -> Option<f64> {
    limits.jerk.map(|jerk| jerk.deceleration)
}

/// Seconds to an instant that never comes.
const NEVER_S: f64 = 1e9;

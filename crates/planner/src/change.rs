//! Changes of a move that is under way: its limits, and the share of the programmed speeds.
//!
//! Bounded.

use arcline_profile::{KinematicState, Limits, MOST_OVERSHOOT, Profile, entry_speed, passing_speed, stop_distance};

use crate::Clock;
use crate::junction::same_rates;
use crate::look_ahead::{Ends, Plan, turns_back};
use crate::move_trajectory::Approach;
use crate::path_with_residual::PathWithResidual;
use crate::planner::Planner;
use crate::running::{AccelerationRemoval, Move, Running, scaled_limits};
use crate::tolerance::ROUNDING_SHARE;

impl<T: Copy> Planner<T> {
    /// Gives the active move new limits from the present tick on: the profile is planned again from the
    /// present state, in two stages when the end can no longer be met (spec/motion-core.md §5). Rates with which a
    /// corner that the motion is to pass could no longer be met hold from there on only (§5.3).
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
        // The old rates before those of the moves that the motion was already braking along, and these before the new ones.
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

    /// Changes all pending moves; `limits` are those that the active one is to have. [`Planner::change_limits`] then makes it take effect.
    pub fn change_pending(&mut self, limits: &Limits, clock: &Clock, change: impl FnMut(&mut Move<T>)) {
        let distance = self.active.map_or(0.0, |running| {
            let now = running.trajectory.state(clock);
            let top = now.velocity.max(limits.speed * self.queue.rate());
            // By a master's displacement: as much as may be.
            let distance = if clock.period_ns == 0 {
                f64::INFINITY
            } else {
                top * clock.period() * self.queue.ticks_of_a_change() as f64
            };
            stop_distance(top, limits) + distance - (running.motion.path.length() - now.position)
        });
        self.queue.change_all(distance, change);
    }

    /// Takes a share (at least 0) of the programmed speeds of the active move, the pending and all later ones, from the
    /// present tick on; 0 holds. Of no effect on a stop that is under way.
    pub fn set_rate(&mut self, rate: f64, clock: &Clock) {
        let most = self.most_rate();
        let ran = self.active.map(|running| Ran::new(&running, self.queue.rate(), clock));
        self.queue.set_rate(rate.min(most));
        if let Some(ran) = ran {
            self.replan(&ran, clock);
        }
    }

    /// Plans the active move again from its present state; so far it ran in another way.
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
        running.removal = self.relief_of(ran, running.motion.limits.speed, running.trajectory.share());
        running.in_force = running.motion.limits;
        running.kept = false;
        let paused = self.limits(&running).speed == 0.0;
        if paused && self.needs_more(&running, from, &ran.limits) {
            running.in_force = ran.limits;
            running.kept = true;
        }
        let lead = running.removal.lead(from, &self.limits(&running));
        let level = lead.map_or(from, |lead| lead.end());
        let plan = self.plan(&running, level);
        let profile = if plan.exit > 0.0 {
            let profile = self.profile(&running, level, &plan);
            lead.map_or(profile, |lead| lead.then(&profile))
        } else if plan.cap == 0.0 {
            let limits = Limits {
                speed: 0.0,
                ..self.limits(&running)
            };
            Profile::led(lead, from, |from| {
                Profile::to_position_two_stage(from, plan.target, &limits)
            })
        } else {
            let limits = Limits {
                speed: plan.cap,
                ..self.limits(&running)
            };
            let planned = |from, limits: &Limits| Profile::to_position_two_stage(from, plan.target, limits);
            let beside = self.beside_again(&running, from, &limits, ran, planned, clock);
            beside.unwrap_or_else(|| Profile::led(lead, from, |from| planned(from, &limits)))
        };
        // A path that waits for what ramps out goes on waiting.
        let waits = running.trajectory.residual.is_some() && running.trajectory.start.elapsed(clock) < 0.0;
        let at = if waits { running.trajectory.start } else { clock.now() };
        running.follow(&plan, profile, at);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        Met::by(&plan)
    }

    /// A change to a programmed speed may overshoot that and the old one by half (spec/coordinated-instructions.md §5.4), and go on to
    /// where the profile so far was to come. `share`: the share of the limits that the profile may use.
    fn relief_of(&self, ran: &Ran, speed: f64, share: f64) -> AccelerationRemoval {
        if !self.bounds.overshoot {
            return AccelerationRemoval::NONE;
        }
        let programmed = ran.programmed.max(self.programmed_speed(speed));
        AccelerationRemoval {
            ceiling: (MOST_OVERSHOOT * programmed * share).max(ran.ahead),
            forward: ran.forward,
        }
    }

    /// Whether a pause would need more way with the limits of the move than with those so far, or would turn back where these
    /// do not.
    fn needs_more(&self, running: &Running<T>, from: KinematicState, ran: &Limits) -> bool {
        if !self.bounds.overshoot {
            return false;
        }
        let limits = self.limits(running);
        let ran = scaled_limits(ran, 1.0, running.trajectory.share());
        let reach = |limits: &Limits| {
            Profile::led(running.removal.lead(from, limits), from, |level| {
                Profile::stop(level, limits)
            })
            .reach()
        };
        reach(&limits) > reach(&ran) * (1.0 + ROUNDING_SHARE)
            || (turns_back(&from, &limits) && !turns_back(&from, &ran))
    }

    /// A speed as it is programmed and an override raises it. An override below 1 lowers the speed, and a motion that still slows down
    /// to it, or speeds up, keeps the time that its acceleration needs.
    pub(crate) fn programmed_speed(&self, speed: f64) -> f64 {
        raised(speed, self.queue.rate())
    }

    /// The profile of a path beside what still ramps out; `None` where nothing does.
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
        let residual = trajectory.residual.as_ref().filter(|_| self.bounds.overshoot)?;
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
        // A hold is no faster than any other change.
        let below = running.removal.lead(from, limits).map_or(0.0, |lead| lead.jerk);
        let removal = limits.jerk.map_or(old, |jerk| jerk.acceleration.max(old)).max(below);
        let found = beside.profile(from, limits, removal, &plan);
        Some(found.unwrap_or_else(|| beside.waiting(from, limits, removal, &plan)))
    }

    /// The way to the start of the active path, which has other rates, is planned again. The state there.
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
        let removal = self.relief_of(&ran, running.motion.limits.speed, 1.0);
        let lead = removal.lead(from, &limits);
        let level = lead.map_or(from, |lead| lead.end());
        let wanted = self.entry(running).min(limits.speed);
        let exit = passing_speed(level, length - level.position, wanted, &limits).speed;
        let capped = Limits {
            speed: limits.speed.max(exit),
            ..limits
        };
        // Where the acceleration is not 0 by the start of the path, the profile of that takes the rest of it away.
        let early = level.position > length;
        let target = if early { level.position } else { length };
        approach.profile = Profile::led(lead, from, |level| Profile::to_position(level, target, exit, &capped));
        approach.offset = 0.0;
        approach.start = clock.now();
        let profile = &approach.profile;
        let distance = if early {
            profile.time_at_position(length).unwrap_or(0.0)
        } else if profile.arrives() {
            profile.duration()
        } else {
            NEVER
        };
        running.trajectory.start = clock.now().after(distance, clock);
        running.trajectory.approach = Some(approach);
        running.removal = if early { removal } else { AccelerationRemoval::NONE };
        // Beyond the place, it comes back to rest there.
        KinematicState {
            position: 0.0,
            ..if early { profile.at(distance) } else { profile.end() }
        }
    }

    /// The highest speed with which the active path can be begun.
    fn entry(&self, running: &Running<T>) -> f64 {
        let limits = self.limits(running);
        let end = self.queue.run_end(running.run_start + running.motion.path.length());
        let bound = self.queue.slower().next().unwrap_or(&end);
        let distance = bound.at - running.run_start;
        limits
            .speed
            .min(entry_speed(distance, self.queue.speed(bound), &limits))
    }

    /// The profile of the active path from its beginning, which lies ahead.
    fn plan_from(&mut self, mut running: Running<T>, from: KinematicState, clock: &Clock) -> Met {
        let (plan, profile) = self.planned(&running, from);
        running.trajectory.profile = profile;
        running.trajectory.offset = 0.0;
        running.in_force = running.motion.limits;
        running.kept = false;
        running.aim(&plan);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        Met::by(&plan)
    }
}

/// The demands behind the end of a plan that it meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Met {
    /// The path is left at a corner.
    Nothing,
    /// The corners.
    Corners,
    /// The speeds and rests too.
    All,
}

impl Met {
    fn by(plan: &Plan) -> Met {
        if plan.ends != Ends::TooFast {
            Met::All
        } else if plan.exit <= plan.corners * (1.0 + ROUNDING_SHARE) {
            Met::Corners
        } else {
            Met::Nothing
        }
    }
}

/// How a move ran until its limits changed.
struct Ran {
    /// Within these.
    limits: Limits,
    /// Its programmed speed, as the override raised it.
    programmed: f64,
    /// The highest speed that was to come.
    ahead: f64,
    /// Where a deceleration may be too much for the jerk of the move: the jerk that takes it away.
    forward: Option<f64>,
}

impl Ran {
    fn new<T>(running: &Running<T>, rate: f64, clock: &Clock) -> Ran {
        let trajectory = &running.trajectory;
        let own = scaled_limits(&running.in_force, 1.0, trajectory.share());
        let programmed = raised(running.motion.limits.speed, rate);
        let ran = Ran::along(&trajectory.profile, trajectory.start.elapsed(clock), own, programmed);
        // So may it be one that began on an earlier move, with the rates of that.
        let earlier = running.kept || trajectory.offset != 0.0;
        Ran {
            limits: running.in_force,
            forward: ran.forward.or(taking(&own).filter(|_| earlier)),
            ..ran
        }
    }

    /// How the predecessor ran to the start of the active path.
    fn approaching(approach: &Approach, rate: f64, elapsed: f64) -> Ran {
        let programmed = raised(approach.limits.speed, rate);
        let ran = Ran::along(&approach.profile, elapsed, approach.limits, programmed);
        Ran {
            forward: ran.forward.or(taking(&approach.limits).filter(|_| approach.kept)),
            ..ran
        }
    }

    fn along(profile: &Profile, elapsed: f64, limits: Limits, programmed: f64) -> Ran {
        let now = profile.at(elapsed);
        let braking = now.velocity > 0.0 && now.acceleration < 0.0;
        // A lead is under way.
        let led = |jerk: &f64| braking && taking(&limits).is_some_and(|own| *jerk > own * (1.0 + ROUNDING_SHARE));
        Ran {
            limits,
            programmed,
            ahead: profile.top_speed(elapsed),
            forward: Some(profile.jerk(elapsed)).filter(led),
        }
    }
}

/// A speed as an override raises it.
fn raised(speed: f64, rate: f64) -> f64 {
    speed * rate.max(1.0)
}

/// The jerk that takes a deceleration away.
fn taking(limits: &Limits) -> Option<f64> {
    limits.jerk.map(|jerk| jerk.deceleration)
}

/// Seconds to an instant that does not come.
const NEVER: f64 = 1e9;

//! What changes while a move is under way: its limits, and the share of the programmed speeds.
//!
//! Bounded. What pending moves are given stands in `sight`.

use arcline_profile::{KinematicState, Lead, Limits, MOST_OVERSHOOT, Profile, entry_speed, passing_speed};

use crate::Clock;
use crate::beside::Beside;
use crate::junction::same_rates;
use crate::look_ahead::Ends;
use crate::planner::{Planner, Relief, Running};
use crate::track::Approach;

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
        let ran = running.in_force;
        running.motion.limits = limits;
        if self.replan(&ran, clock) && !same_rates(&before, &limits) {
            // The old rates; those of the moves that the motion was already braking along; the new ones all the same.
            let following = self.queue.front().map_or(limits, |next| next.limits);
            for rates in [before, following, limits] {
                if let Some(running) = &mut self.active {
                    running.motion.limits = Limits {
                        speed: limits.speed,
                        ..rates
                    };
                }
                if !self.replan(&ran, clock) {
                    break;
                }
            }
        }
    }

    /// Takes a share (at least 0) of the programmed speeds of the active move, the pending and all later ones, from the
    /// present tick on; 0 holds. Of no effect on a stop that is under way.
    pub fn set_rate(&mut self, rate: f64, clock: &Clock) {
        let most = self.active.map_or(rate, |running| {
            let speed = running.motion.limits.speed;
            let wanted = Limits {
                speed: speed * rate,
                ..running.motion.limits
            };
            if speed > 0.0 {
                self.allowed(&wanted).speed / speed
            } else {
                rate
            }
        });
        self.queue.set_rate(rate.min(most));
        if let Some(running) = &self.active {
            let ran = running.in_force;
            self.replan(&ran, clock);
        }
    }

    /// Plans the active move again from its present state; so far it ran within other limits. Whether it comes to the next corner
    /// too fast.
    fn replan(&mut self, ran: &Limits, clock: &Clock) -> bool {
        let Some(mut running) = self.active.filter(|running| !running.stopped) else {
            return false;
        };
        running.place = self.queue.relink(&running.motion, running.blended);
        if let Some(approach) = running.track.approach.filter(|_| running.track.is_approaching(clock))
            && !same_rates(&approach.limits, &running.motion.limits)
        {
            let start = self.approach_again(&mut running, approach, clock);
            return self.plan_from(running, start, clock);
        }
        let from = running.track.state(clock);
        running.relief = self.relief_of(&running, ran, clock);
        running.in_force = running.motion.limits;
        running.kept = false;
        let lead = running.relief.lead(from, &self.limits(&running));
        let level = lead.map_or(from, |lead| lead.end());
        let plan = self.plan(&running, level);
        let profile = if plan.exit > 0.0 {
            let profile = self.profile(&running, level, &plan);
            lead.map_or(profile, |lead| lead.then(&profile))
        } else if plan.cap == 0.0 {
            self.pause(&mut running, from, plan.target, ran, clock)
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
        let waits = running.track.residual.is_some() && running.track.start.elapsed(clock) < 0.0;
        let at = if waits { running.track.start } else { clock.now() };
        running.follow(&plan, profile, at);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        plan.ends == Ends::TooFast
    }

    /// A change may overshoot the programmed speeds, old and new, by half (spec/coordinated-instructions.md §5.4), and go on to
    /// where the profile so far was to come.
    fn relief_of(&self, running: &Running<T>, ran: &Limits, clock: &Clock) -> Relief {
        if !self.bounds.overshoot {
            return Relief::NONE;
        }
        let track = &running.track;
        let programmed = ran.speed.max(running.motion.limits.speed) * self.queue.rate();
        let ahead = track.profile.top_speed(track.start.elapsed(clock));
        // A compensation moves along.
        let pace = track.residual.map_or(1.0, |residual| residual.pace);
        Relief {
            ceiling: (MOST_OVERSHOOT * programmed * pace).max(ahead),
            // A deceleration of the old limits may be too much for the new jerk, so may one that began on an earlier move, with
            // the rates of that.
            forward: running.kept || track.offset != 0.0,
        }
    }

    /// Comes to rest on the path, over no more way than with the limits so far, and no faster than any other change.
    fn pause(
        &self,
        running: &mut Running<T>,
        from: KinematicState,
        target: f64,
        ran: &Limits,
        clock: &Clock,
    ) -> Profile {
        let mut limits = self.limits(running);
        let relief = running.relief;
        // The jerk that would have taken the acceleration away always suffices.
        let present = running.track.jerk(clock).abs();
        let up = |limits: &Limits| limits.jerk.map_or(0.0, |jerk| jerk.acceleration);
        let most = present.max(up(&limits)).max(up(ran));
        let lead = |limits: &Limits| {
            relief.lead(from, limits).map(|lead| Lead {
                jerk: if from.acceleration * from.velocity < 0.0 {
                    lead.jerk
                } else {
                    lead.jerk.min(most)
                },
                ..lead
            })
        };
        if self.bounds.overshoot {
            let old = Limits {
                speed: limits.speed,
                ..*ran
            };
            let stop = |limits: &Limits| Profile::led(lead(limits), from, |level| Profile::stop(level, limits));
            if stop(&limits).reach() > stop(&old).reach() * (1.0 + NEARLY) {
                running.in_force = Limits {
                    speed: running.motion.limits.speed,
                    ..*ran
                };
                running.kept = true;
                limits = old;
            }
        }
        let standing = Limits { speed: 0.0, ..limits };
        Profile::led(lead(&limits), from, |level| {
            Profile::to_position_two_stage(level, target, &standing)
        })
    }

    /// The profile of a path beside what still ramps out; `None` where nothing does.
    fn beside_again(
        &self,
        running: &Running<T>,
        from: KinematicState,
        limits: &Limits,
        ran: &Limits,
        plan: impl Fn(KinematicState, &Limits) -> Profile,
        clock: &Clock,
    ) -> Option<Profile> {
        let track = &running.track;
        let residual = track.residual.as_ref().filter(|_| self.bounds.overshoot)?;
        let since = residual.start.elapsed(clock);
        let length = running.motion.path.length();
        if self.within.is_some() || since >= residual.duration() || length <= 0.0 {
            return None;
        }
        let present = track.sample(clock).velocity.norm();
        let programmed = ran.speed.max(running.motion.limits.speed) * self.queue.rate();
        let beside = Beside {
            path: &running.motion.path,
            parts: &residual.parts,
            since,
            bound: present.max(programmed),
        };
        let old = ran.jerk.map_or(0.0, |jerk| jerk.acceleration);
        // A hold is no faster than any other change.
        let below = running.relief.lead(from, limits).map_or(0.0, |lead| lead.jerk);
        let relief = limits.jerk.map_or(old, |jerk| jerk.acceleration.max(old)).max(below);
        let found = beside.profile(from, limits, relief, &plan);
        Some(found.unwrap_or_else(|| beside.waiting(from, limits, relief, &plan)))
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
        let wanted = self.entry(running).min(limits.speed);
        let exit = passing_speed(from, length - from.position, wanted, &limits).speed;
        let capped = Limits {
            speed: limits.speed.max(exit),
            ..limits
        };
        approach.profile = Profile::to_position(from, length, exit, &capped);
        approach.offset = 0.0;
        approach.start = clock.now();
        let arrives = approach.profile.arrives();
        let way = if arrives { approach.profile.duration() } else { NEVER };
        running.track.start = clock.now().after(way, clock);
        running.track.approach = Some(approach);
        // Beyond the place, it comes back to rest there.
        let velocity = approach.profile.end().velocity;
        KinematicState {
            position: 0.0,
            velocity,
            acceleration: 0.0,
        }
    }

    /// The highest speed with which the active path can be begun.
    fn entry(&self, running: &Running<T>) -> f64 {
        let limits = self.limits(running);
        let end = self.queue.run_end(running.place + running.motion.path.length());
        let bound = self.queue.slower().next().unwrap_or(&end);
        let way = bound.at - running.place;
        limits.speed.min(entry_speed(way, self.queue.speed(bound), &limits))
    }

    /// The profile of the active path from its beginning, which lies ahead.
    fn plan_from(&mut self, mut running: Running<T>, from: KinematicState, clock: &Clock) -> bool {
        let plan = self.plan(&running, from);
        running.track.profile = self.profile(&running, from, &plan);
        running.track.offset = 0.0;
        running.aim(&plan);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        plan.ends == Ends::TooFast
    }
}

/// Share of a way that is rounding.
const NEARLY: f64 = 1e-9;
/// Seconds to an instant that does not come.
const NEVER: f64 = 1e9;

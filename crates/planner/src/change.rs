//! What changes while a move is under way: its limits, and the share of the programmed speeds.
//!
//! Bounded. What pending moves are given stands in `sight`.

use arcline_profile::{Limits, Profile, State, entry_speed, passing_speed};

use crate::Clock;
use crate::junction::same_rates;
use crate::look_ahead::Ends;
use crate::planner::{Planner, Running};
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
        running.motion.limits = limits;
        if self.replan(clock) && !same_rates(&before, &limits) {
            // The old rates; those of the moves that the motion was already braking along; the new ones all the same.
            let following = self.queue.front().map_or(limits, |next| next.limits);
            for rates in [before, following, limits] {
                if let Some(running) = &mut self.active {
                    running.motion.limits = Limits {
                        speed: limits.speed,
                        ..rates
                    };
                }
                if !self.replan(clock) {
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
        self.replan(clock);
    }

    /// Plans the active move again from its present state. Whether it comes to the next corner too fast.
    fn replan(&mut self, clock: &Clock) -> bool {
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
        let plan = self.plan(&running, from);
        let profile = if plan.exit > 0.0 || plan.cap == 0.0 {
            self.profile(&running, from, &plan)
        } else {
            let limits = Limits {
                speed: plan.cap,
                ..self.limits(&running)
            };
            Profile::to_position_two_stage(from, plan.target, &limits)
        };
        // A path that waits for what ramps out goes on waiting.
        let waits = running.track.residual.is_some() && running.track.start.elapsed(clock) < 0.0;
        let at = if waits { running.track.start } else { clock.now() };
        running.follow(&plan, profile, at);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        plan.ends == Ends::TooFast
    }

    /// The way to the start of the active path, which has other rates, is planned again. The state there.
    fn approach_again(&self, running: &mut Running<T>, mut approach: Approach, clock: &Clock) -> State {
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
        State {
            position: 0.0,
            velocity: exit,
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
    fn plan_from(&mut self, mut running: Running<T>, from: State, clock: &Clock) -> bool {
        let plan = self.plan(&running, from);
        running.track.profile = self.profile(&running, from, &plan);
        running.track.offset = 0.0;
        running.aim(&plan);
        self.active = Some(running);
        self.schedule(clock.now(), clock);
        plan.ends == Ends::TooFast
    }
}

/// Seconds to an instant that does not come.
const NEVER: f64 = 1e9;

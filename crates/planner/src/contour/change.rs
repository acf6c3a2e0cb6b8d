//! Changes of a contour in execution: an override, new speeds or rates of its moves, a stop.
//!
//! Not here: the pace itself ([`super::pace`]). Nothing allocates.

use arcline_profile::Limits;

use super::guard::Extra;
use super::pace::PaceRequest;
use super::ramp::StopRequest;
use super::run::{PlanRequest, RunState, least};
use super::tuning::{LATE_LEFT_S, WAITING_PACE};
use super::{ContourQueue, requests};
use crate::tolerance::SAME_SHARE;
use crate::{Clock, MasterRate, Parameter};

impl<T: Copy> ContourQueue<T> {
    /// Sets the override: a share of the programmed speeds, 0 holds.
    pub fn set_rate(&mut self, rate: f64, clock: &Clock) {
        self.rate = rate;
        if matches!(self.asked, Some(PlanRequest::Anew { .. })) {
            self.asked = None;
        }
        self.change(clock);
    }

    /// Gives the active move new limits, from the present tick on.
    pub fn change_limits(&mut self, limits: Limits, clock: &Clock) {
        self.asked = None;
        if let Some(active) = self.moves.front_mut() {
            // A pause brakes no gentler than before the change that asked for it.
            if limits.speed > 0.0 {
                self.paused_from = None;
            } else if active.limits.speed > 0.0 {
                self.paused_from = Some(active.limits);
            }
            active.set_limits(limits);
        }
        self.change(clock);
    }

    /// Adapts to changed speeds or rates of moves, or a changed override: a trajectory in execution slows down to a pace within all of them, or
    /// returns to its own pace; then its rest is planned anew.
    pub fn change(&mut self, clock: &Clock) {
        self.change_pace(clock);
    }

    /// Continues the change of the pace if it was not possible at once, and slows down while an extension is late. Called first in every tick.
    pub fn steer(&mut self, clock: &Clock) {
        let waits = self.waits_for_extension(clock);
        if self.run.as_ref().is_some_and(|run| run.waits_for_extension != waits) {
            self.change_pace(clock);
            return;
        }
        if let Some(run) = &mut self.run
            && run.pace.steer(&run.trajectory, clock)
        {
            self.plans = self.plans.wrapping_add(1);
        }
    }

    /// The plan of an extension is late or was not found, and the end of the trajectory is near. A lower pace leaves more time for it, so that the motion
    /// does not come to rest. Only by time: over a master's displacement, the master leads the motion.
    fn waits_for_extension(&self, clock: &Clock) -> bool {
        let (Some(run), Some(active)) = (&self.run, self.moves.front()) else {
            return false;
        };
        let now = run.pace_at(clock).position;
        let near = LATE_LEFT_S[usize::from(self.is_s_curve())];
        let is_late = matches!(self.asked, Some(PlanRequest::Extension { .. })) && now >= run.due;
        let has_failed = run.slowed_retry.is_some() && self.moves.len() > self.planned();
        run.state == RunState::Travelling
            && active.parameter == Parameter::TIME
            && (is_late || has_failed)
            && run.trajectory.duration() - now <= near
    }

    /// Asks for a pace of at most 1 at which every move is within its speed and rates.
    pub(super) fn change_pace(&mut self, clock: &Clock) {
        let (rate, dynamics_bits) = (self.planned_rate(), self.dynamics_bits);
        let waits = self.waits_for_extension(clock);
        let Some(run) = self.run.as_mut().filter(|run| run.state == RunState::Travelling) else {
            return;
        };
        let left = run.trajectory.moves() - run.passed;
        let (mut target, mut stale) = (if waits { WAITING_PACE } else { 1.0 }, false);
        run.waits_for_extension = waits;
        for (move_index, motion) in self.moves.iter().take(left).enumerate() {
            let Some(planned) = run.trajectory.rates(run.passed + move_index) else {
                break;
            };
            let wanted = motion.limits;
            // It does not hold the moves before it: it brakes when it is the active one ([`ContourQueue::pass`]).
            if move_index > 0 && wanted.speed == 0.0 && self.moves[0].limits.speed > 0.0 {
                break;
            }
            let own = wanted.jerk.map(least);
            let own_speed = requests::planned_speed(motion, rate);
            stale |= (own_speed / planned.speed - 1.0).abs() > SAME_SHARE;
            target = share_of(target, self.rate * wanted.speed / planned.speed);
            let shares = [
                (wanted.acceleration / planned.acceleration).sqrt(),
                (wanted.deceleration / planned.deceleration).sqrt(),
                own.zip(planned.jerk)
                    .map_or(1.0, |(own, planned)| libm::cbrt(own / planned)),
            ];
            for share in shares {
                stale |= (share - 1.0).abs() > SAME_SHARE;
                target = share_of(target, share);
            }
        }
        run.stale = stale;
        run.changed = clock.now();
        let stands = self.moves.front().is_some_and(|first| first.limits.speed == 0.0);
        run.stood |= stands && run.is_at_its_beginning(clock);
        if !stands && run.waits(clock) {
            return;
        }
        let speed = run.trajectory.peaks().speed.max(f64::MIN_POSITIVE);
        let stop = self.moves.front().map(|active| StopRequest {
            limits: active.limits,
            other: self.paused_from.filter(|_| dynamics_bits.overshoot),
            before: run.limits(),
            dynamics_bits,
        });
        let stop = stop.filter(|_| target == 0.0);
        let rates = run.trajectory.least_rates();
        let (rate, jerk) = (rates.acceleration.min(rates.deceleration), rates.jerk);
        let wanted = PaceRequest {
            target,
            rate: rate / speed,
            jerk: jerk.map(|jerk| jerk / speed),
            near: Some((rate, jerk)),
            stop,
            extra: stop.map_or(Extra::NONE, |stop| stop.extra(run.trajectory.move_end(run.passed))),
        };
        run.pace.ask(wanted, &run.trajectory, clock);
        self.plans = self.plans.wrapping_add(1);
    }

    /// As [`ContourQueue::stop`] for a master driven contour: `clock` shows the master displacement as time, and `rate` the rate of that. From now
    /// on the queue's clock is `time`. The master may have been faster than its nominal speed, so only the limits of the stop are kept.
    pub fn stop_in_time(&mut self, limits: &Limits, rate: &MasterRate, clock: &Clock, time: &Clock) {
        self.asked = None;
        let Some(run) = &mut self.run else {
            return;
        };
        run.pace = run.stopping(limits, Some(rate), clock, time);
        run.state = RunState::Stopping;
    }

    /// Brakes on the path from the present tick on, as fast as the limits of the axes permit. The caller ends the moves.
    pub fn stop(&mut self, limits: &Limits, clock: &Clock) {
        self.asked = None;
        let dynamics_bits = self.dynamics_bits;
        let Some(run) = &mut self.run else {
            return;
        };
        let before = run.limits();
        let stop = StopRequest {
            // The stop has the profile of the active move.
            limits: Limits {
                jerk: before.jerk.and(limits.jerk),
                ..*limits
            },
            other: None,
            before,
            dynamics_bits,
        };
        let speed = run.speed_of_a_stop(run.pace_at(clock).position, limits);
        let jerk = limits.jerk.map(|jerk| jerk.deceleration);
        let wanted = PaceRequest {
            target: 0.0,
            rate: limits.deceleration / speed,
            jerk: jerk.map(|jerk| jerk / speed),
            near: None,
            stop: Some(stop),
            extra: stop.extra(None),
        };
        run.state = RunState::Stopping;
        run.pace.ask(wanted, &run.trajectory, clock);
    }
}

/// The lesser of two shares; a share that is 1 within rounding does not count.
fn share_of(target: f64, share: f64) -> f64 {
    if share < 1.0 - SAME_SHARE {
        target.min(share)
    } else {
        target
    }
}

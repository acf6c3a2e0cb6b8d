//! The change of the active move to the oldest pending one: from rest, with a blend, at a speed, or on a continued profile.

use arcline_profile::{AccelerationRemovalPhase, KinematicState, Limits, Profile};

use crate::junction::{Junction, junction};
use crate::look_ahead::{EndQuality, turns_back};
use crate::move_trajectory::{Approach, MoveTrajectory};
use crate::planner::{Planner, RunStart};
use crate::running::{AccelerationRemoval, Move, Running};
use crate::tolerance::DISTANCE_SHARE;
use crate::{Clock, Instant};

impl<T: Copy> Planner<T> {
    /// Makes the oldest pending move active at an instant: from rest, with a blend, or at the speed of the junction.
    pub fn hand_over(&mut self, at: Instant, clock: &Clock) -> Option<&mut T> {
        let last = self.active.take();
        let early = self.hand_over_at.take().is_some();
        let run_ends = self.queue.run_ends_here();
        let next = self.queue.pop()?;
        let Some(last) = last else {
            self.start(next, at, clock);
            return self.active_data();
        };
        // An ended residual or blend affects no later move. At a change of the clock, all have ended, and do not refer to the new clock.
        let other = last.motion.parameter != next.parameter;
        if other || self.tail.is_some_and(|tail| tail.is_over_at(&at, clock)) {
            self.tail = None;
        }
        if other || self.ramping_out.is_some_and(|out| out.is_over_at(&at, clock)) {
            self.ramping_out = None;
        }
        let between = junction(&last.motion, &next, last.blended);
        if last.joined > 0 {
            let pauses = last.has_other_limits && next.limits.speed * self.queue.rate() == 0.0;
            let trajectory = last.trajectory.onto(&next, between);
            if run_ends {
                self.plan_on(next, trajectory, last.removal, at, clock);
            } else if last.motion.limits.speed != next.limits.speed && !pauses {
                self.plan_on(next, trajectory, last.removal_of_the_next(), at, clock);
            } else {
                self.go_on(&last, next, trajectory, at, clock);
            }
            return self.active_data();
        }
        let end = last.trajectory.profile.end();
        match between {
            Junction::Blend { .. } if early => {
                self.tail = Some(last.trajectory);
                self.tail_turns = last.turn_limits();
                let start = RunStart {
                    blended: true,
                    ..RunStart::new(KinematicState::default(), at)
                };
                self.run(next, start, clock);
            }
            Junction::Overtake { .. } if early && self.overtake(&last, next, at, clock) => {}
            Junction::Pass { .. } | Junction::Overtake { .. } if early => {
                let start = last.trajectory.start.after(last.trajectory.profile.duration(), clock);
                let approach = Approach {
                    path: last.motion.path,
                    profile: last.trajectory.profile,
                    start: last.trajectory.start,
                    offset: last.trajectory.offset,
                    limits: last.profile_limits(),
                    has_other_limits: last.has_other_limits || last.trajectory.offset != 0.0,
                };
                let blended = matches!(between, Junction::Overtake { .. });
                let start = RunStart {
                    blended,
                    ..RunStart::new(passing(end), start)
                };
                self.run(next, start, clock);
                if let Some(running) = &mut self.active {
                    running.trajectory.approach = Some(approach);
                    running.begun = at;
                }
            }
            _ => {
                let from = if last.exit > 0.0 {
                    passing(end)
                } else {
                    KinematicState::default()
                };
                self.run(next, RunStart::new(from, at), clock);
            }
        }
        self.active_data()
    }

    /// Begins a move within its tolerance before its path, with its own rates, unless these are too low for the junctions ahead.
    fn overtake(&mut self, last: &Running<T>, next: Move<T>, at: Instant, clock: &Clock) -> bool {
        let mut from = last
            .trajectory
            .profile
            .at(last.trajectory.start.elapsed(clock) - at.elapsed(clock));
        from.position -= last.trajectory.offset + last.motion.path.length();
        let trajectory = MoveTrajectory {
            path: next.path,
            rotation: next.rotation,
            run_up: (from.position < 0.0).then_some(last.motion.path),
            approach: None,
            profile: Profile::rest(0.0),
            start: at,
            offset: 0.0,
            residual: None,
        };
        let running = Running {
            blended: true,
            run_start: self.queue.relink(&next, true),
            ..Running::new(next, trajectory)
        };
        let fastest = last.motion.limits.speed.max(next.limits.speed) * self.queue.rate();
        let slow =
            !self.dynamics_bits.overshoot || AccelerationRemovalPhase::below(from, &next.limits, fastest).is_none();
        let safe =
            slow && self.plan(&running, from).end_quality == EndQuality::Feasible && !turns_back(&from, &next.limits);
        if safe {
            self.begin(running, from, clock);
        }
        safe
    }

    /// Makes the next of several joined moves active, and plans its profile from the present state: the move has another speed, or the run of
    /// equal rates ends before it with an acceleration that is not 0.
    fn plan_on(
        &mut self,
        next: Move<T>,
        mut trajectory: MoveTrajectory,
        removal: AccelerationRemoval,
        at: Instant,
        clock: &Clock,
    ) {
        let mut from = trajectory
            .profile
            .at(trajectory.start.elapsed(clock) - at.elapsed(clock));
        from.position -= trajectory.offset;
        if from.position.abs() <= DISTANCE_SHARE * trajectory.offset {
            from.position = 0.0;
        }
        trajectory.replan(trajectory.profile, at);
        let running = Running {
            blended: trajectory.run_up.is_some(),
            removal,
            ..Running::new(next, trajectory)
        };
        self.begin(running, from, clock);
    }

    /// Makes the next of several joined moves active on the same profile. A pause on older limits keeps them: the rates of the new move may
    /// not brake in time.
    fn go_on(&mut self, last: &Running<T>, next: Move<T>, trajectory: MoveTrajectory, at: Instant, clock: &Clock) {
        let has_other_limits = last.has_other_limits && next.limits.speed * self.queue.rate() == 0.0;
        let in_force = Limits {
            speed: next.limits.speed,
            ..if has_other_limits { last.in_force } else { next.limits }
        };
        let blended = trajectory.run_up.is_some();
        self.active = Some(Running {
            begun: at,
            exit: last.exit,
            joined: last.joined - 1,
            blended,
            run_start: self.queue.relink(&next, blended),
            in_force,
            has_other_limits,
            removal: last.removal,
            ..Running::new(next, trajectory)
        });
        self.schedule(at, clock);
    }
}

impl MoveTrajectory {
    /// Continues a profile on the path of the next of several joined moves.
    fn onto<T>(&self, next: &Move<T>, between: Junction) -> MoveTrajectory {
        MoveTrajectory {
            path: next.path,
            rotation: next.rotation,
            run_up: matches!(between, Junction::Overtake { .. }).then_some(self.path),
            approach: None,
            offset: self.offset + self.path.length(),
            ..*self
        }
    }
}

/// The state at which a profile passes a junction, on the path behind it.
fn passing(end: KinematicState) -> KinematicState {
    KinematicState { position: 0.0, ..end }
}

//! A generator of an axis: its instruction, its program and its present position.
//!
//! Real-time: nothing allocates. Units: position units in the generator's own frame ([`super::sum`]), seconds; a profile over a
//! master's displacement has master units in place of seconds.

use arcline_planner::profile::{Limits, MOST_OVERSHOOT, Phase, Profile, ProfileSegment};
use arcline_planner::{Clock, Instant, SAME_INSTANT_S};
use arcline_profile::KinematicState;

use super::generator_kind::Displacements;
use crate::dynamics::Dynamics;
use crate::events::MoveEvents;
use crate::execution::Execution;
use crate::masters::cam::Cam;
use crate::masters::follower::MasterFollower;
use crate::masters::gear::Gear;

/// The source of a generator's position.
#[derive(Clone, Debug)]
pub(crate) enum Equation {
    /// The tick sets it from outside of the axis: by a coordinate system, a master axis or a transform.
    Followed,
    /// A profile.
    Planned { profile: Profile, start: Instant },
    /// A gear, as a function of its master.
    Geared(Gear),
    /// A cam, as a function of its master.
    Cammed(Cam),
}

/// The programmed motion of an instruction, for later changes of its dynamics.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProgrammedMotion {
    pub(crate) dynamics: Dynamics,
    pub(crate) goal: Goal,
}

/// The goal of a programmed generator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Goal {
    /// A position of its frame: MAM.
    Position(f64),
    /// A velocity with a sign, which is the direction at a speed of 0, too, without an end: MAJ.
    Velocity(f64),
}

/// A generator under way.
#[derive(Clone, Debug)]
pub(crate) struct Generator {
    pub(crate) equation: Equation,
    /// Its present motion, in its frame.
    pub(crate) now: KinematicState,
    /// The instruction that reports its end.
    pub(crate) execution: Option<Execution>,
    /// `None` if no instruction can change the motion: of stops, and of generators that are computed outside of the axis.
    pub(crate) program: Option<ProgrammedMotion>,
    /// It only brakes, and ends when it stands.
    pub(crate) stopping: bool,
    /// The limits at which it brakes; `None`: it does not brake, or its coordinate system brakes it.
    pub(crate) brake: Option<Limits>,
    /// Its profile is an S-curve, so its stop is one, too.
    pub(crate) s_curve: bool,
    /// ACCEL and DECEL of its instruction, as last written.
    pub(crate) shown_phase: Phase,
    /// The master displacement that its profile is a function of; `None`: time.
    pub(crate) follower: Option<MasterFollower>,
    /// TrackingMaster of its instruction, as last written.
    pub(crate) shown_tracking: bool,
    /// Event Distance and Calculated Data of its instruction.
    pub(crate) events: Option<MoveEvents>,
    /// SEGMENT of its instruction, as last written.
    pub(crate) shown_segment: usize,
    /// Its profile has reached its end.
    pub(crate) over: bool,
    /// The limits of its profile, in time or master displacement as the profile, if they are known. Its speed may exceed theirs by half.
    pub(crate) in_force: Option<Limits>,
    /// The highest programmed jerk before it was stopped, units/s³.
    pub(super) jerk: f64,
    /// It brakes motion that a cancelled transform left, perhaps besides other motion.
    pub(crate) after_transform: bool,
    /// It also brakes coordinated motion that was ended.
    pub(crate) coordinated: bool,
    /// A stop of the whole axis brakes it on its path; no other motion can begin meanwhile.
    pub(crate) ending: bool,
    /// The position at which it began, in its frame.
    pub(super) origin: f64,
    /// Its displacement at the last tick.
    pub(super) last_displacement: f64,
    /// Displacements by all generators of the axis at its beginning.
    pub(super) others: Displacements,
    /// The offset by which the position was redefined since its beginning.
    pub(super) shift: f64,
}

impl Generator {
    /// A generator that is computed outside of the axis, at rest.
    pub(crate) fn followed(s_curve: bool) -> Self {
        Generator {
            equation: Equation::Followed,
            now: KinematicState::default(),
            execution: None,
            program: None,
            stopping: false,
            brake: None,
            s_curve,
            shown_phase: Phase::Steady,
            follower: None,
            shown_tracking: false,
            events: None,
            shown_segment: 0,
            over: false,
            in_force: None,
            jerk: 0.0,
            after_transform: false,
            coordinated: false,
            ending: false,
            origin: 0.0,
            last_displacement: 0.0,
            others: Displacements::default(),
            shift: 0.0,
        }
    }

    /// A generator along a profile that begins at an instant.
    pub(crate) fn planned(profile: Profile, start: Instant) -> Self {
        let mut generator = Generator::followed(false);
        generator.now = profile.start();
        generator.equation = Equation::Planned { profile, start };
        generator
    }

    /// Records the limits of its profile.
    pub(crate) fn set_limits_in_force(&mut self, limits: &Limits) {
        let top = match &self.equation {
            Equation::Planned { profile, .. } => profile.top_speed(0.0),
            _ => 0.0,
        };
        self.in_force = Some(Limits {
            speed: limits.speed.max(top / MOST_OVERSHOOT),
            ..*limits
        });
    }

    /// Its highest programmed jerk, units/s³; 0 if the jerk is unlimited, or per master unit.
    pub(crate) fn highest_jerk(&self) -> f64 {
        let program = self.program.filter(|_| self.follower.is_none());
        let jerk = program.and_then(|program| program.dynamics.limits().jerk);
        jerk.map_or(self.jerk, |jerk| {
            self.jerk.max(jerk.acceleration).max(jerk.deceleration)
        })
    }

    /// Continues along another profile from this instant; the frame stays.
    pub(crate) fn follow(&mut self, profile: Profile, start: Instant) {
        self.equation = Equation::Planned { profile, start };
        self.over = false;
    }

    /// Its profile is a function of time.
    pub(crate) fn is_planned(&self) -> bool {
        matches!(self.equation, Equation::Planned { .. }) && self.follower.is_none()
    }

    /// The variable of its profile at the present tick: time, or a master's displacement.
    pub(crate) fn clock(&self, time: &Clock) -> Clock {
        self.follower.map_or(*time, |follower| follower.clock())
    }

    /// Its motion by the variable of its profile.
    pub(crate) fn planned_state(&self, time: &Clock) -> KinematicState {
        match (&self.equation, &self.follower) {
            (Equation::Planned { profile, start }, Some(_)) => profile.at(start.elapsed(&self.clock(time))),
            _ => self.now,
        }
    }

    /// The phase of the speed at the present tick; steady while the profile waits for a lock.
    pub(crate) fn phase(&self, time: &Clock) -> Phase {
        match &self.equation {
            Equation::Planned { profile, start } if self.follower.is_none_or(|follower| follower.has_begun()) => {
                profile.phase(start.elapsed(&self.clock(time)))
            }
            _ => Phase::Steady,
        }
    }

    /// A master driven generator has reached its programmed speed.
    pub(crate) fn is_tracking(&self, time: &Clock) -> bool {
        self.follower.is_some_and(|follower| follower.has_begun())
            && !self.over
            && self.phase(time) == Phase::Steady
            && self.planned_state(time).velocity != 0.0
    }

    /// Shifts a jog at constant speed back by the whole turns of a rotary axis that it has passed, once they are many: its position then never
    /// loses digits. Returns the shift of the position: 0 for all other generators.
    pub(super) fn fold(&mut self, unwind: f64, clock: &Clock) -> f64 {
        let (Equation::Planned { profile, start }, Some(program), None) =
            (&self.equation, &self.program, &self.follower)
        else {
            return 0.0;
        };
        let Goal::Velocity(velocity) = program.goal else {
            return 0.0;
        };
        let turns = (self.displacement() / unwind).trunc();
        if turns.abs() < FOLDED_TURNS || start.elapsed(clock) < profile.duration() {
            return 0.0;
        }
        let offset = -turns * unwind;
        self.now.position += offset;
        let profile = Profile::to_velocity(self.now, velocity, &program.dynamics.limits());
        self.follow(profile, clock.now());
        offset
    }

    /// The offset between its frame and the position of the axis that it alone moves.
    pub(crate) fn shift(&self) -> f64 {
        self.shift
    }

    pub(super) fn displacement(&self) -> f64 {
        self.now.position - self.origin
    }

    /// Its profile leads to an end: it is no jog, or it stops.
    fn ends(&self) -> bool {
        let goal = self.program.map(|program| program.goal);
        self.stopping || !matches!(goal, Some(Goal::Velocity(_)))
    }

    /// The segment of its profile at the present tick, and the seconds from the start until which it alone determines the motion and nothing is
    /// to be reported.
    pub(crate) fn segment(&self, profile: &Profile, start: &Instant, clock: &Clock) -> Option<(ProfileSegment, f64)> {
        let is_plain = self.follower.is_none() && self.events.as_ref().is_none_or(|events| events.due.is_none());
        let elapsed = start.elapsed(clock);
        if !is_plain || self.shown_phase != profile.phase(elapsed) {
            return None;
        }
        let segment = profile.segment(elapsed)?;
        let end = if self.ends() { profile.duration() } else { f64::INFINITY };
        Some((segment, end.min(segment.until()) - SAME_INSTANT_S))
    }

    pub(super) fn advance(&mut self, time: &Clock) {
        let clock = self.clock(time);
        if let Equation::Planned { profile, start } = &self.equation {
            let elapsed = start.elapsed(&clock);
            let state = profile.at(elapsed);
            let at_end = profile.arrives() && elapsed >= profile.duration() - SAME_INSTANT_S;
            self.over = self.ends() && at_end;
            self.now = if self.over {
                KinematicState::at_rest(profile.end().position)
            } else {
                self.follower.map_or(state, |follower| follower.rate().in_time(state))
            };
        }
    }
}

/// Turns after which a jog is shifted back.
const FOLDED_TURNS: f64 = 16.0;

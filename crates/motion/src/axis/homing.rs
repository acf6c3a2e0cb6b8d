//! Homing of one axis: the order of its legs and events (spec/axis-and-data-types.md §11).
//!
//! An active sequence is the axis's [`GeneratorKind::Home`] generator. A leg begins at the exact instant of the event or at the exact end
//! of the previous leg, also inside an update. The event is a latch of the drive: its position is exact, and its instant lies inside the
//! update that the feedback ends. As the set-point of that update has gone out by then, the drive sees the next leg one update later, but
//! from its exact beginning on. A passive sequence waits for its event without moving the axis.
//!
//! Not here: one update ([`update`]), instructions and their bits. Units: position units, seconds. Nothing allocates.

mod update;

use arcline_drive::{ArmLatch, HOME_LATCH, Latch, Trigger};
use arcline_planner::profile::{Limits, Profile};
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;
use arcline_profile::numeric::modulo;

use super::Axis;
use super::generator::Generator;
use super::generator_kind::GeneratorKind;
use super::state::AxisState;
use crate::execution::Execution;
use crate::machine::{HomeMode, HomeSequence};

/// A MAH under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homing {
    pub(crate) execution: Execution,
    /// It prevents other instructions from moving the axis.
    pub(crate) active: bool,
    /// It moves the axis, and ends with its generator.
    driven: bool,
    step: HomingStep,
    /// Machine position of the home point, once known.
    event: Option<f64>,
}

/// The step of a sequence.
#[derive(Clone, Copy, Debug, PartialEq)]
enum HomingStep {
    /// The earlier motion of the axis brakes; an Immediate sequence waits for the next update.
    Clearing,
    /// The axis moves until a latch closes.
    Seeking {
        sought: Sought,
        direction: f64,
        latch: ArmLatch,
    },
    /// The axis brakes on the switch, to return to its edge.
    Turning,
    /// The axis brakes behind the home point.
    Braking,
    /// The axis moves to the Home Position.
    Returning,
    /// Other instructions move the axis until a latch closes.
    Waiting { latch: ArmLatch },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sought {
    /// The switch becomes active.
    Switch,
    /// The switch becomes inactive.
    Release,
    Marker,
    /// The mechanical stop: the torque rises to its level there.
    Stop,
}

impl Axis {
    /// Begins a sequence at the present tick. All other generators of an axis that is homed actively have ended; `from` is its motion until
    /// then, which brakes within `stop`.
    pub(crate) fn begin_homing(&mut self, execution: Execution, from: KinematicState, stop: &Limits, clock: &Clock) {
        self.home = self.next_home;
        let active = self.home.mode == HomeMode::Active;
        let driven = active && self.state == AxisState::Running;
        self.homed = false;
        self.home_event = false;
        let sequence = self.home.sequence;
        let waits = !active && sequence != HomeSequence::Immediate;
        let mut homing = Homing {
            execution,
            active,
            driven,
            step: HomingStep::Clearing,
            event: None,
        };
        if waits {
            let before_marker = sequence == HomeSequence::SwitchMarker;
            let latch = if sequence == HomeSequence::Marker || (before_marker && self.stands_on_switch()) {
                self.link.arm(Trigger::Marker, false)
            } else {
                self.link.arm(Trigger::SwitchOn, before_marker)
            };
            homing.step = HomingStep::Waiting { latch };
        }
        self.homing = Some(homing);
        if driven {
            let started_at = [from.position, self.actual.position];
            let from = KinematicState {
                position: from.position,
                velocity: from.velocity,
                acceleration: if stop.jerk.is_some() { from.acceleration } else { 0.0 },
            };
            self.leg(Profile::stop(from, stop), clock.now());
            self.started_at = started_at;
        }
    }

    /// The MAH under way, unless it moved the axis and was stopped.
    #[inline]
    pub(crate) fn homing(&self) -> Option<&Homing> {
        let homing = self.homing.as_ref()?;
        let alive = !homing.driven || self.sum.get(GeneratorKind::Home).is_some_and(|home| !home.stopping);
        alive.then_some(homing)
    }

    /// Removes a MAH that does not move the axis.
    pub(crate) fn take_passive_homing(&mut self) -> Option<Execution> {
        let passive = self.homing.filter(|homing| !homing.driven)?;
        self.homing = None;
        Some(passive.execution)
    }

    /// Homing prevents other instructions from moving the axis.
    pub(crate) fn is_homed_actively(&self) -> bool {
        self.homing().is_some_and(|homing| homing.active)
    }

    /// Homing calculates the command of the axis.
    #[inline]
    pub(crate) fn is_driven_home(&self) -> bool {
        self.homing().is_some_and(|homing| homing.driven)
    }

    /// The sequence still waits for its home event.
    pub(crate) fn awaits_home_event(&self) -> bool {
        let has_event = self.home.sequence != HomeSequence::Immediate;
        has_event && self.homing().is_some_and(|homing| homing.event.is_none())
    }

    /// A MAH is under way, or has just reached its home point.
    pub(crate) fn is_homing(&self) -> bool {
        self.homing.is_some() || self.home_reached
    }

    /// Returns true if the update that ends now found the home point.
    pub(crate) fn home_was_found(&mut self, clock: &Clock) -> bool {
        if !self.is_homing() {
            return false;
        }
        self.take_home_latch(clock);
        if std::mem::take(&mut self.home_reached) {
            return true;
        }
        if self.is_driven_home() {
            return false;
        }
        if self.homing().is_none() {
            // An instruction stopped the MAH.
            self.homing = None;
        }
        self.watch_home()
    }

    /// The latch that the sequence waits for.
    pub(crate) fn home_latch(&self) -> Option<ArmLatch> {
        match self.homing()?.step {
            HomingStep::Seeking { latch, .. } | HomingStep::Waiting { latch } => Some(latch),
            HomingStep::Clearing | HomingStep::Turning | HomingStep::Braking | HomingStep::Returning => None,
        }
    }

    /// Performs one update of a passive sequence, with the feedback of this tick. Returns true if the home point was found.
    fn watch_home(&mut self) -> bool {
        let Some(homing) = &self.homing else {
            return false;
        };
        if !matches!(homing.step, HomingStep::Waiting { .. }) {
            self.take_home_position();
            return true;
        }
        let Some(latch) = self.closed_home_latch() else {
            return false;
        };
        self.home_event = true;
        self.align(latch.position);
        true
    }

    /// The latch that the sequence waits for, if the last exchange reports that it has closed.
    fn closed_home_latch(&self) -> Option<Latch> {
        let armed = self.home_latch()?;
        self.link.feedback.latches[HOME_LATCH].filter(|latch| latch.number == armed.number)
    }

    /// The home switch is active at the present position of the axis.
    fn stands_on_switch(&self) -> bool {
        self.link.feedback.inputs.home
    }

    /// Handles the end of a leg. Returns true if it ends the sequence.
    fn leg_is_over(&mut self, instant: Instant) -> bool {
        let Some(homing) = self.homing else {
            return true;
        };
        let direction = self.home.direction;
        match homing.step {
            HomingStep::Clearing if self.home.sequence == HomeSequence::Immediate => {
                self.end(GeneratorKind::Home);
                self.take_home_position();
                true
            }
            HomingStep::Clearing => {
                let has_switch = self.home.sequence != HomeSequence::Marker;
                if self.home.sequence.is_of_torque() {
                    self.seek(Sought::Stop, direction.sign(), self.home.speed, instant);
                } else if !has_switch {
                    self.seek(Sought::Marker, direction.sign(), self.home.speed, instant);
                } else if direction.is_bidirectional() && self.stands_on_switch() {
                    self.seek(Sought::Release, -direction.sign(), self.home.return_speed, instant);
                } else {
                    self.seek(Sought::Switch, direction.sign(), self.home.speed, instant);
                }
                false
            }
            HomingStep::Turning => {
                self.seek(Sought::Release, -direction.sign(), self.home.return_speed, instant);
                false
            }
            HomingStep::Braking => {
                if let Some(home_point) = homing.event {
                    self.align(home_point);
                }
                if direction.is_bidirectional() {
                    if let Some(turn) = self.unwind {
                        let turns = ((self.command.position - self.home.position) / turn).round();
                        self.redefine(-turns * turn);
                    }
                    self.go_home(instant);
                }
                !direction.is_bidirectional()
            }
            HomingStep::Seeking { .. } | HomingStep::Returning | HomingStep::Waiting { .. } => true,
        }
    }

    /// Handles the event that the axis seeks, at a machine position.
    fn sought_is_reached(&mut self, position: f64, instant: Instant) {
        let Some(HomingStep::Seeking { sought, direction, .. }) = self.homing.map(|homing| homing.step) else {
            return;
        };
        let returns = self.home.direction.is_bidirectional();
        if sought == Sought::Stop && self.home.sequence == HomeSequence::TorqueMarker {
            self.seek(Sought::Marker, -direction, self.home.return_speed, instant);
        } else if sought == Sought::Switch && returns {
            self.brake_as(HomingStep::Turning, instant);
        } else {
            self.home_event = true;
            if let Some(homing) = &mut self.homing {
                homing.event = Some(position);
            }
            match self.unwind {
                Some(turn) if !returns => self.go_on_home(position, turn, direction, instant),
                _ => self.brake_as(HomingStep::Braking, instant),
            }
        }
    }

    /// Begins a motion at a speed until a latch closes.
    fn seek(&mut self, sought: Sought, direction: f64, speed: f64, instant: Instant) {
        let trigger = match sought {
            Sought::Switch => Trigger::SwitchOn,
            Sought::Release => Trigger::SwitchOff,
            Sought::Marker => Trigger::Marker,
            Sought::Stop => Trigger::Stop,
        };
        // The axis does not reverse at this edge of the switch; it seeks the marker next.
        let turns = sought == Sought::Switch && self.home.direction.is_bidirectional();
        let of_switch = matches!(sought, Sought::Switch | Sought::Release);
        let then_marker = self.home.sequence == HomeSequence::SwitchMarker && of_switch && !turns;
        let latch = self.link.arm(trigger, then_marker);
        self.enter(HomingStep::Seeking {
            sought,
            direction,
            latch,
        });
        let limits = self.home_limits(speed);
        self.leg(
            Profile::to_velocity(self.present(), direction * speed, &limits),
            instant,
        );
    }

    fn brake_as(&mut self, step: HomingStep, instant: Instant) {
        let limits = self.home_limits(self.home.speed);
        self.leg(Profile::stop(self.present(), &limits), instant);
        self.enter(step);
    }

    /// Continues in the same direction, to the first Home Position at which the axis can stop.
    fn go_on_home(&mut self, home_point: f64, turn: f64, direction: f64, instant: Instant) {
        self.align(home_point);
        let KinematicState { position, velocity, .. } = self.command;
        let stop = velocity * velocity / (2.0 * self.home.deceleration);
        let least = modulo(direction * (self.home.position - position), turn);
        let distance = least + turn * ((stop - least) / turn).ceil().max(0.0);
        let turns = ((position + direction * distance - self.home.position) / turn).round();
        self.redefine(-turns * turn);
        self.go_home(instant);
    }

    fn go_home(&mut self, instant: Instant) {
        let limits = self.home_limits(self.home.return_speed);
        let profile = Profile::to_position(self.present(), self.home.position, 0.0, &limits);
        self.leg(profile, instant);
        self.enter(HomingStep::Returning);
    }

    /// Redefines the positions such that the home point lies at a machine position.
    fn align(&mut self, home_point: f64) {
        let shown = home_point + self.redefined;
        self.redefine((self.home.position - self.home.offset) - shown);
    }

    /// Sets the command to the Home Position, and shifts the actual position accordingly: the home event of an immediate sequence.
    fn take_home_position(&mut self) {
        self.home_event = true;
        self.redefine_command(self.home.position);
    }

    fn home_limits(&self, speed: f64) -> Limits {
        Limits {
            speed,
            acceleration: self.home.acceleration,
            deceleration: self.home.deceleration,
            jerk: None,
        }
    }

    fn present(&self) -> KinematicState {
        KinematicState {
            position: self.command.position,
            velocity: self.command.velocity,
            acceleration: 0.0,
        }
    }

    fn enter(&mut self, step: HomingStep) {
        if let Some(homing) = &mut self.homing {
            homing.step = step;
        }
    }

    /// Begins a leg at the command position.
    fn leg(&mut self, profile: Profile, start: Instant) {
        let mut generator = Generator::planned(profile, start);
        generator.execution = self.homing.map(|homing| homing.execution);
        self.sum.begin(GeneratorKind::Home, generator);
        self.command = self.sum.command();
    }
}

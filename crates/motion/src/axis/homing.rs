//! Homing of one axis: which leg comes after which event (spec/axis-and-data-types.md §11).
//!
//! An active sequence is the axis's [`Slot::Home`] generator. Its legs begin at the exact instants at which the event
//! came or the leg before ended, inside an update if need be: the way does not show the update period. The event is
//! that of the actual position; its place is known exactly, and the instant is found by bisection of what the drive
//! does within the update. Waiting for the event of a passive sequence moves nothing; it sees positions once an update,
//! so one that comes and goes within an update is not seen.
//!
//! Not here: one update ([`update`]), instructions and their bits. Units: position units, seconds. Nothing allocates.

mod update;

use arcline_planner::profile::{Limits, Profile};
use arcline_planner::{Clock, Instant};
use arcline_profile::KinematicState;

use super::generator::Generator;
use super::sensor::{ahead, modulo};
use super::sum::Slot;
use super::{Axis, AxisState};
use crate::control::Execution;
use crate::machine::{HomeMode, HomeSequence};

/// A MAH under way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homing {
    pub(crate) execution: Execution,
    /// It keeps other instructions from moving the axis.
    pub(crate) active: bool,
    /// It moves the axis: over when its generator is.
    driven: bool,
    stage: Stage,
    /// Machine position of the home point, once it is known.
    event: Option<f64>,
}

/// How far a sequence is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// What moved the axis before brakes; or, for Immediate, the next update is waited for.
    Clearing,
    /// It moves until it is at a machine position.
    Seeking { sought: Sought, place: f64, direction: f64 },
    /// It brakes on the switch, to come back to its edge.
    Turning,
    /// It brakes behind the home point.
    Braking,
    /// It moves to the Home Position.
    Returning,
    /// Others move it; where it was in the update before.
    Waiting { sought: Sought, last: f64 },
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
    /// Begins a sequence at the present tick. All other generators of an axis that is homed actively have ended;
    /// `from` is what it did until then, and braking is within `stop`.
    pub(crate) fn begin_homing(&mut self, execution: Execution, from: KinematicState, stop: &Limits, clock: &Clock) {
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
            stage: Stage::Clearing,
            event: None,
        };
        if waits {
            let sought = if sequence == HomeSequence::Marker || self.stands_on_switch_before_marker() {
                Sought::Marker
            } else {
                Sought::Switch
            };
            let last = self.machine_position();
            homing.stage = Stage::Waiting { sought, last };
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

    /// The MAH under way. One that moved the axis and was stopped is none.
    pub(crate) fn homing(&self) -> Option<&Homing> {
        let homing = self.homing.as_ref()?;
        let alive = !homing.driven || self.sum.get(Slot::Home).is_some_and(|home| !home.stopping);
        alive.then_some(homing)
    }

    /// Takes away a MAH that does not move the axis.
    pub(crate) fn take_passive_homing(&mut self) -> Option<Execution> {
        let passive = self.homing.filter(|homing| !homing.driven)?;
        self.homing = None;
        Some(passive.execution)
    }

    /// Whether homing keeps other instructions from moving the axis.
    pub(crate) fn is_homed_actively(&self) -> bool {
        self.homing().is_some_and(|homing| homing.active)
    }

    /// Whether homing gives the command of the axis.
    pub(crate) fn is_driven_home(&self) -> bool {
        self.homing().is_some_and(|homing| homing.driven)
    }

    /// Whether the home event is waited for.
    pub(crate) fn awaits_home_event(&self) -> bool {
        let has_event = self.home.sequence != HomeSequence::Immediate;
        has_event && self.homing().is_some_and(|homing| homing.event.is_none())
    }

    /// Whether the home point was found in the update that ends now.
    pub(crate) fn home_was_found(&mut self) -> bool {
        if std::mem::take(&mut self.home_reached) {
            return true;
        }
        if self.is_driven_home() {
            return false;
        }
        if self.homing().is_none() {
            // It was stopped.
            self.homing = None;
        }
        self.watch_home()
    }

    /// The actual position without any redefinition.
    pub(crate) fn machine_position(&self) -> f64 {
        self.actual.position - self.redefined
    }

    /// One update in which others move the axis, if anything: to be called with the positions of this tick. Whether the
    /// home point was found.
    pub(crate) fn watch_home(&mut self) -> bool {
        let now = self.machine_position();
        loop {
            let Some(homing) = &mut self.homing else {
                return false;
            };
            let Stage::Waiting { sought, last } = homing.stage else {
                self.take_home_position();
                return true;
            };
            if now == last {
                return false;
            }
            let direction = (now - last).signum();
            let place = self.place_of(sought, last, direction);
            let passed = place.filter(|place| direction * (now - place) >= 0.0);
            let Some(homing) = &mut self.homing else {
                return false;
            };
            match passed {
                None => {
                    homing.stage = Stage::Waiting { sought, last: now };
                    return false;
                }
                Some(place) if sought == Sought::Switch && self.home.sequence == HomeSequence::SwitchMarker => {
                    homing.stage = Stage::Waiting {
                        sought: Sought::Marker,
                        last: place,
                    };
                }
                Some(place) => {
                    self.home_event = true;
                    self.align(place);
                    return true;
                }
            }
        }
    }

    /// Where the axis finds what it seeks, as a machine position; `None`: not in that direction.
    fn place_of(&self, sought: Sought, machine: f64, direction: f64) -> Option<f64> {
        match sought {
            Sought::Switch => ahead(machine, self.home.switch?.edge(direction), direction, self.unwind),
            Sought::Release => ahead(machine, self.home.switch?.edge(-direction), direction, self.unwind),
            Sought::Marker => self.home.marker?.ahead(machine, direction),
            Sought::Stop => self.home.stop(direction),
        }
    }

    /// Whether the home switch is active where the axis is.
    pub(crate) fn stands_on_switch(&self) -> bool {
        let active = |switch: crate::machine::HomeSwitch| switch.is_active(self.machine_position(), self.unwind);
        self.home.switch.is_some_and(active)
    }

    fn stands_on_switch_before_marker(&self) -> bool {
        self.home.sequence == HomeSequence::SwitchMarker && self.stands_on_switch()
    }

    /// The leg is at its end. Whether the sequence is.
    fn leg_is_over(&mut self, instant: Instant) -> bool {
        let Some(homing) = self.homing else {
            return true;
        };
        let way = self.home.direction;
        match homing.stage {
            Stage::Clearing if self.home.sequence == HomeSequence::Immediate => {
                self.end(Slot::Home);
                self.take_home_position();
                true
            }
            Stage::Clearing => {
                let has_switch = self.home.sequence != HomeSequence::Marker;
                if self.home.sequence.is_of_torque() {
                    self.seek(Sought::Stop, way.sign(), self.home.speed, instant);
                } else if !has_switch {
                    self.seek(Sought::Marker, way.sign(), self.home.speed, instant);
                } else if way.is_bidirectional() && self.stands_on_switch() {
                    self.seek(Sought::Release, -way.sign(), self.home.return_speed, instant);
                } else {
                    self.seek(Sought::Switch, way.sign(), self.home.speed, instant);
                }
                false
            }
            Stage::Turning => {
                self.seek(Sought::Release, -way.sign(), self.home.return_speed, instant);
                false
            }
            Stage::Braking => {
                if let Some(place) = homing.event {
                    self.align(place);
                }
                if way.is_bidirectional() {
                    if let Some(turn) = self.unwind {
                        let turns = ((self.command.position - self.home.position) / turn).round();
                        self.redefine(-turns * turn);
                    }
                    self.go_home(instant);
                }
                !way.is_bidirectional()
            }
            Stage::Seeking { .. } | Stage::Returning | Stage::Waiting { .. } => true,
        }
    }

    /// The axis is at the place that it seeks.
    fn place_is_reached(&mut self, instant: Instant) {
        let Some(homing) = self.homing else {
            return;
        };
        let Stage::Seeking {
            sought,
            place,
            direction,
        } = homing.stage
        else {
            return;
        };
        let way = self.home.direction;
        let returns = way.is_bidirectional();
        if sought == Sought::Stop && self.home.sequence == HomeSequence::TorqueMarker {
            self.seek(Sought::Marker, -direction, self.home.return_speed, instant);
        } else if sought == Sought::Switch && returns {
            self.brake_as(Stage::Turning, instant);
        } else if sought != Sought::Marker && self.home.sequence == HomeSequence::SwitchMarker {
            self.seek_from(Sought::Marker, place, direction);
        } else {
            self.home_event = true;
            if let Some(homing) = &mut self.homing {
                homing.event = Some(place);
            }
            match self.unwind {
                Some(turn) if !returns => self.go_on_home(place, turn, direction, instant),
                _ => self.brake_as(Stage::Braking, instant),
            }
        }
    }

    /// Moves at a speed until it is where `sought` is.
    fn seek(&mut self, sought: Sought, direction: f64, speed: f64, instant: Instant) {
        self.seek_from(sought, self.machine_position(), direction);
        let limits = self.home_limits(speed);
        self.leg(
            Profile::to_velocity(self.present(), direction * speed, &limits),
            instant,
        );
    }

    /// From now on it seeks something; the leg goes on. What is not there is never reached.
    fn seek_from(&mut self, sought: Sought, machine: f64, direction: f64) {
        let place = self.place_of(sought, machine, direction);
        self.enter(Stage::Seeking {
            sought,
            place: place.unwrap_or(direction * f64::INFINITY),
            direction,
        });
    }

    fn brake_as(&mut self, stage: Stage, instant: Instant) {
        let limits = self.home_limits(self.home.speed);
        self.leg(Profile::stop(self.present(), &limits), instant);
        self.enter(stage);
    }

    /// Goes on in the same direction, to the first Home Position at which it can stand.
    fn go_on_home(&mut self, place: f64, turn: f64, direction: f64, instant: Instant) {
        self.align(place);
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
        self.enter(Stage::Returning);
    }

    /// Positions become what they are with the home point at a machine position.
    fn align(&mut self, place: f64) {
        let shown = place + self.redefined;
        self.redefine((self.home.position - self.home.offset) - shown);
    }

    /// The command becomes the Home Position, and the actual position with it.
    fn take_home_position(&mut self) {
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

    fn enter(&mut self, stage: Stage) {
        if let Some(homing) = &mut self.homing {
            homing.stage = stage;
        }
    }

    /// Begins a leg where the axis is commanded to be.
    fn leg(&mut self, profile: Profile, start: Instant) {
        let mut generator = Generator::planned(profile, start);
        generator.execution = self.homing.map(|homing| homing.execution);
        self.sum.begin(Slot::Home, generator);
        self.command = self.sum.command();
    }
}

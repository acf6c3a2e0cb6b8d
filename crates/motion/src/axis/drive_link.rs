//! The exchange of an axis with its drive: set-point out, feedback in (spec/axis-and-data-types.md §12).
//!
//! The drive knows machine positions; what an axis's positions were redefined by is added here. Not here: the exchange of all axes
//! (`crate::motion`), homing. Units: position units, seconds. Nothing allocates.

use arcline_drive::{
    ArmLatch, DriveState, Feedback, Following, HOME_LATCH, LATCHES, REGISTRATION_LATCHES, SetPoint, Trigger,
};
use arcline_instruction_set::{FaultKind, FaultSet};
use arcline_planner::Clock;
use arcline_profile::KinematicState;

use super::Axis;
use super::faults::Observed;
use super::probes::Registration;
use super::state::AxisState;

/// Exchanges in a row that an axis does without; one more is a fault.
const TOLERATED_LOSSES: u32 = 2;

/// An axis's side of the seam to its drive.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DriveLink {
    /// The feedback of the last exchange.
    pub(crate) feedback: Feedback,
    /// How far the axis was behind its set-point at the last exchange.
    lag: KinematicState,
    /// The axis was at its set-point, to the last bit.
    at_set_point: bool,
    /// The drive has been on since it was asked to be.
    was_on: bool,
    /// Exchanges in a row that were lost.
    lost: u32,
    /// How long before the tick the command came to rest, where a coordinated move waits for the axis.
    pub(crate) stood: f64,
    /// The number of the latch that was armed last.
    armed: u32,
}

impl DriveLink {
    /// A latch that no other one is taken for.
    pub(crate) fn arm(&mut self, trigger: Trigger, then_marker: bool) -> ArmLatch {
        self.armed = self.armed.wrapping_add(1);
        ArmLatch {
            number: self.armed,
            trigger,
            then_marker,
        }
    }
}

impl Axis {
    /// Whether a drive moves it: not a virtual axis, nor one whose position is written to a tag.
    pub(crate) fn has_drive(&self) -> bool {
        !self.is_virtual && self.feeding.is_none()
    }

    /// The set-point of the present tick.
    pub(crate) fn write_set_point(&self, out: &mut SetPoint) {
        // Few axes have a latch armed, and every axis comes here in every tick.
        if self.arms_latches() || out.latches.iter().any(Option::is_some) {
            out.latches[HOME_LATCH] = self.home_latch();
            for (latch, registration) in REGISTRATION_LATCHES.into_iter().zip(&self.registrations) {
                out.latches[latch] = registration.latch();
            }
        }
        out.enable = self.has_drive() && self.has_torque();
        out.position = self.command.position - self.redefined;
        out.velocity = self.command.velocity;
        out.acceleration = self.command.acceleration;
        out.stood = self.link.stood;
    }

    fn arms_latches(&self) -> bool {
        self.homing.is_some() || self.registrations.iter().any(Registration::is_armed)
    }

    /// Takes the feedback of the exchange at which `sent` went out; `None`: it was lost. Without torque, the command is where the axis
    /// is.
    pub(crate) fn take_feedback(&mut self, feedback: Option<&Feedback>, sent: &SetPoint, clock: &Clock) {
        if let Some(now) = self.fed(clock) {
            self.sum.set_position(now.position);
            self.command = now;
            self.set_actual(now);
        } else if self.is_virtual {
            if self.has_torque() {
                self.set_actual(self.command);
            } else {
                self.rest_at_actual();
            }
        } else {
            match feedback.filter(|feedback| feedback.state != DriveState::Lost) {
                Some(feedback) => {
                    self.link.lost = 0;
                    self.link.feedback = *feedback;
                    self.link.at_set_point = feedback.motion.position == sent.position;
                    self.set_actual(KinematicState {
                        position: self.in_axis_coordinates(feedback.motion.position),
                        ..feedback.motion
                    });
                }
                None => {
                    self.set_actual(self.expected(clock));
                    self.link.lost = self.link.lost.saturating_add(1);
                    self.link.feedback.latches = [None; LATCHES];
                }
            }
            self.take_drive_state();
            // The first set-point that a drive follows is where the axis is.
            if !self.has_torque() || self.state == AxisState::Starting {
                self.rest_at_actual();
            }
        }
        self.link.stood = 0.0;
        self.average.take(self.actual.position - self.redefined);
    }

    /// Whether the next exchange would leave the axis as it is: it brings the same feedback, or the axis has no drive.
    pub(crate) fn is_unchanged_by(&self, feedback: Option<&Feedback>) -> bool {
        !self.has_drive() || feedback.is_some_and(|feedback| *feedback == self.link.feedback)
    }

    /// Whether the same feedback once more would change nothing.
    pub(super) fn is_link_steady(&self) -> bool {
        let link = &self.link;
        link.lost == 0 && link.stood == 0.0 && link.feedback.latches.iter().all(Option::is_none) && !self.has_gone_off()
    }

    fn set_actual(&mut self, actual: KinematicState) {
        self.link.lag = self.command - actual;
        self.actual = actual;
    }

    /// The command is where the axis is.
    fn rest_at_actual(&mut self) {
        self.stand_at(self.actual.position);
        self.link.lag = self.command - self.actual;
    }

    /// The drive answers what it was asked for.
    fn take_drive_state(&mut self) {
        let on = self.link.feedback.state == DriveState::Enabled;
        match self.state {
            AxisState::Starting if on => self.state = AxisState::Running,
            AxisState::Stopping if !on => self.state = AxisState::Stopped,
            _ => {}
        }
        self.link.was_on = self.has_torque() && (on || self.link.was_on);
    }

    /// The actual position, with what positions were redefined by.
    pub(super) fn update_actual(&mut self) {
        self.actual.position = self.in_axis_coordinates(self.link.feedback.motion.position);
    }

    /// A machine position of the last feedback as a position of the axis: exactly its command where it is at its set-point.
    fn in_axis_coordinates(&self, position: f64) -> f64 {
        if self.link.at_set_point && self.has_torque() {
            self.command.position
        } else {
            position + self.redefined
        }
    }

    /// The machine position of a latch as a position of the axis: exactly the actual position where it closed at the exchange.
    pub(crate) fn latched_at(&self, position: f64) -> f64 {
        if position == self.link.feedback.motion.position {
            self.actual.position
        } else {
            position + self.redefined
        }
    }

    /// Where the axis is at the present tick, before its feedback comes: as far behind the command as at the last exchange;
    /// without torque, as fast as then.
    pub(crate) fn expected(&self, clock: &Clock) -> KinematicState {
        if let Some(now) = self.fed(clock) {
            now
        } else if self.has_torque() {
            self.command - self.link.lag
        } else {
            self.actual + self.actual.velocity * clock.period()
        }
    }

    /// Whether the axis is where its command is at every instant, and not only when the feedback says so.
    pub(crate) fn follows_exactly(&self) -> bool {
        let link = &self.link;
        let drive = link.feedback.following == Following::Exact && link.feedback.state == DriveState::Enabled;
        self.is_virtual || (drive && link.lost == 0)
    }

    /// Command minus actual position at the last exchange, as motion knows it.
    pub(crate) fn behind(&self) -> f64 {
        self.link.lag.position
    }

    /// The last exchange was lost.
    pub(crate) fn is_lost(&self) -> bool {
        self.link.lost > 0
    }

    /// The drive has gone off by itself.
    pub(crate) fn has_gone_off(&self) -> bool {
        self.has_drive() && self.link.was_on && self.link.feedback.state != DriveState::Enabled
    }

    /// Following error as the drive tells it; 0 without a drive.
    pub(crate) fn position_error(&self) -> f64 {
        self.link.feedback.error
    }

    /// Whether a watch position, a registration or an output cam waits for what the feedback says.
    pub(crate) fn awaits_events(&self) -> bool {
        self.watch.is_armed() || self.registrations.iter().any(Registration::is_armed) || !self.outputs.is_empty()
    }

    /// The quantities that faults look at.
    pub(crate) fn observed(&self) -> Observed {
        let loop_closed = self.has_torque() && self.has_drive();
        let mut drive = FaultSet::default();
        if self.has_drive() {
            drive = self.link.feedback.faults;
            if self.has_gone_off() && drive.is_empty() {
                drive = drive.with(FaultKind::Drive);
            }
            if self.link.lost > TOLERATED_LOSSES {
                drive = drive.with(FaultKind::DriveCommunication);
            }
        }
        Observed {
            position: self.actual.position,
            homed: self.homed,
            velocity: self.command.velocity,
            error: loop_closed.then_some(self.link.feedback.error),
            lost: false,
            drive,
        }
    }
}

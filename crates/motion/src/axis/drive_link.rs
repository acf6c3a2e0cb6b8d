//! The exchange of an axis with its drive: set-point out, feedback in (spec/axis-and-data-types.md §12).
//!
//! The drive knows machine positions; this module adds the offsets by which the positions of an axis were redefined. Not here: the
//! exchange of all axes (`crate::motion`), homing. Units: position units, seconds. Nothing allocates.

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

/// Consecutive lost exchanges that an axis tolerates; one more is a fault.
const TOLERATED_LOSSES: u32 = 2;

/// An axis's side of the seam to its drive.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DriveLink {
    /// The feedback of the last exchange.
    pub(crate) feedback: Feedback,
    /// Set-point minus actual motion at the last exchange.
    lag: KinematicState,
    /// At the last exchange the axis was exactly at its set-point, to the last bit.
    at_set_point: bool,
    /// The drive has been enabled since the controller asked for it.
    was_on: bool,
    /// Consecutive lost exchanges.
    lost: u32,
    /// Seconds before the tick at which the command came to rest, where a coordinated move waits for the axis.
    pub(crate) stood: f64,
    /// The number of the latch that was armed last.
    armed: u32,
}

impl DriveLink {
    /// A latch with a new number: no earlier latch can be mistaken for it.
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
    /// A drive moves the axis: it is neither virtual nor fed by a tag.
    pub(crate) fn has_drive(&self) -> bool {
        !self.is_virtual && self.feeding.is_none()
    }

    /// The set-point of the present tick.
    pub(crate) fn write_set_point(&self, out: &mut SetPoint) {
        // Few axes have an armed latch, and every axis passes here in every tick.
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

    /// Takes the feedback of the exchange at which `sent` went out; `None` if the exchange was lost. Without torque, the command position
    /// follows the actual position.
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
                Some(feedback) => self.set_feedback(feedback, sent),
                None => {
                    self.set_actual(self.expected(clock));
                    self.link.lost = self.link.lost.saturating_add(1);
                    self.link.feedback.latches = [None; LATCHES];
                }
            }
            self.take_drive_state();
            // The first set-point that a drive follows is its own actual position.
            if !self.has_torque() || self.state == AxisState::Starting {
                self.rest_at_actual();
            }
        }
        self.link.stood = 0.0;
        self.average.take(self.actual.position - self.redefined);
    }

    /// The actual position while the axis follows a command; `None`: its feedback shows more than motion, or its position is a fault.
    pub(crate) fn plain_position(&self, feedback: &Feedback, sent: &SetPoint, command: f64) -> Option<f64> {
        if self.is_virtual {
            return self.plain_exact_position(command);
        }
        let position = if feedback.motion.position == sent.position {
            command
        } else {
            feedback.motion.position + self.redefined
        };
        let is_plain = feedback.state == DriveState::Enabled
            && feedback.faults.is_empty()
            && feedback.latches.iter().all(Option::is_none)
            && self.faults.allow(position, feedback.error);
        is_plain.then_some(position)
    }

    /// As [`Axis::plain_position`], of an axis that is exactly at its command.
    pub(crate) fn plain_exact_position(&self, command: f64) -> Option<f64> {
        self.faults.allow(command, 0.0).then_some(command)
    }

    /// Takes the feedback of an exchange, and the position of the axis by it.
    pub(crate) fn set_feedback(&mut self, feedback: &Feedback, sent: &SetPoint) {
        if self.is_virtual {
            self.set_actual(self.command);
            return;
        }
        self.link.lost = 0;
        self.link.feedback = *feedback;
        self.link.at_set_point = feedback.motion.position == sent.position;
        self.set_actual(KinematicState {
            position: self.in_axis_coordinates(feedback.motion.position),
            ..feedback.motion
        });
    }

    /// The next exchange would leave the axis unchanged: it brings the same feedback, or the axis has no drive.
    pub(crate) fn is_unchanged_by(&self, feedback: Option<&Feedback>) -> bool {
        !self.has_drive() || feedback.is_some_and(|feedback| *feedback == self.link.feedback)
    }

    /// Another exchange with the same feedback would change nothing.
    pub(super) fn is_link_steady(&self) -> bool {
        let link = &self.link;
        link.lost == 0 && link.stood == 0.0 && link.feedback.latches.iter().all(Option::is_none) && !self.has_gone_off()
    }

    fn set_actual(&mut self, actual: KinematicState) {
        self.link.lag = self.command - actual;
        self.actual = actual;
    }

    /// Sets the command to the actual position, at rest.
    fn rest_at_actual(&mut self) {
        self.stand_at(self.actual.position);
        self.link.lag = self.command - self.actual;
    }

    /// Follows the state of the drive: it reports that it has been enabled or disabled as requested.
    fn take_drive_state(&mut self) {
        let on = self.link.feedback.state == DriveState::Enabled;
        match self.state {
            AxisState::Starting if on => self.state = AxisState::Running,
            AxisState::Stopping if !on => self.state = AxisState::Stopped,
            _ => {}
        }
        self.link.was_on = self.has_torque() && (on || self.link.was_on);
    }

    /// Calculates the actual position from the feedback and the offsets of redefined positions.
    pub(super) fn update_actual(&mut self) {
        self.actual.position = self.in_axis_coordinates(self.link.feedback.motion.position);
    }

    /// Converts a machine position of the last feedback to a position of the axis: exactly its command if the axis is at its set-point.
    fn in_axis_coordinates(&self, position: f64) -> f64 {
        if self.link.at_set_point && self.has_torque() {
            self.command.position
        } else {
            position + self.redefined
        }
    }

    /// Converts the machine position of a latch to a position of the axis: exactly the actual position if the latch closed at the
    /// exchange.
    pub(crate) fn latched_at(&self, position: f64) -> f64 {
        if position == self.link.feedback.motion.position {
            self.actual.position
        } else {
            position + self.redefined
        }
    }

    /// The expected actual motion at the present tick, before its feedback arrives: the command less the lag of the last exchange; without
    /// torque, the last motion continued at its speed.
    pub(crate) fn expected(&self, clock: &Clock) -> KinematicState {
        if let Some(now) = self.fed(clock) {
            now
        } else if self.has_torque() {
            self.command - self.link.lag
        } else {
            self.actual + self.actual.velocity * clock.period()
        }
    }

    /// The actual position equals the command at every instant, not only at the exchanges.
    pub(crate) fn follows_exactly(&self) -> bool {
        let link = &self.link;
        let drive = link.feedback.following == Following::Exact && link.feedback.state == DriveState::Enabled;
        self.is_virtual || (drive && link.lost == 0)
    }

    /// Command minus actual position at the last exchange, as the motion core calculates it.
    pub(crate) fn behind(&self) -> f64 {
        self.link.lag.position
    }

    /// The last exchange was lost.
    pub(crate) fn is_lost(&self) -> bool {
        self.link.lost > 0
    }

    /// The drive has disabled itself.
    pub(crate) fn has_gone_off(&self) -> bool {
        self.has_drive() && self.link.was_on && self.link.feedback.state != DriveState::Enabled
    }

    /// Following error as the drive reports it; 0 without a drive.
    pub(crate) fn position_error(&self) -> f64 {
        self.link.feedback.error
    }

    /// A watch position, a registration or an output cam waits for an event of the feedback.
    pub(crate) fn awaits_events(&self) -> bool {
        self.watch.is_armed() || self.registrations.iter().any(Registration::is_armed) || !self.outputs.is_empty()
    }

    /// The quantities that the fault checks observe.
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

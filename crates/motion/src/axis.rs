//! One axis: its state, its drive, and where its command comes from.

use arcline_drive::{Drive, Motion as Point};
use arcline_planner::{Clock, Instant};
use arcline_profile::{Jerk, Limits, Profile, State};

use crate::machine::{Axis as Description, AxisKind};

/// The axis state machine (spec/axis-and-data-types.md §12), as far as instructions see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AxisState {
    /// Ready, servo off.
    Stopped,
    /// MSO is under way.
    Starting,
    /// Servo on: the drive follows the command.
    Running,
    /// MSF is under way.
    Stopping,
    /// Shut down until a shutdown reset.
    Shutdown,
}

/// Where the command comes from.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "a box would allocate in the tick")]
pub(crate) enum Source {
    /// Nothing moves it.
    Held,
    /// A coordinate system does.
    System,
    /// It brakes by itself, out of a motion that was ended.
    Braking { profile: Profile, start: Instant },
}

/// An axis at the present tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) state: AxisState,
    pub(crate) drive: Drive,
    pub(crate) command: Point,
    pub(crate) source: Source,
    pub(crate) homed: bool,
    /// Command and actual position when the last motion began.
    pub(crate) started_at: [f64; 2],
    pub(crate) dynamics: AxisDynamics,
    pub(crate) unwind: Option<f64>,
    pub(crate) is_virtual: bool,
}

/// The maxima of an axis: units/s, units/s², units/s³.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisDynamics {
    pub(crate) speed: f64,
    pub(crate) deceleration: f64,
    pub(crate) deceleration_jerk: f64,
}

impl Axis {
    pub(crate) fn new(description: &Description) -> Self {
        let position = description.start.position;
        let (drive, state) = match &description.kind {
            AxisKind::Virtual => (Drive::ideal(position), AxisState::Running),
            AxisKind::Servo(drive) => (
                Drive::servo(position, &drive.settings()),
                if description.start.servo_on {
                    AxisState::Running
                } else {
                    AxisState::Stopped
                },
            ),
        };
        Axis {
            state,
            drive,
            command: standing(position),
            source: Source::Held,
            homed: description.start.homed,
            started_at: [position; 2],
            dynamics: AxisDynamics {
                speed: description.max_speed,
                deceleration: description.max_deceleration,
                deceleration_jerk: description.max_deceleration_jerk,
            },
            unwind: description.unwind,
            is_virtual: description.is_virtual(),
        }
    }

    /// Whether the command moves, or a motion that can move it holds the axis.
    pub(crate) fn in_motion(&self) -> bool {
        !matches!(self.source, Source::Held)
    }

    /// The axis becomes part of a coordinated move.
    pub(crate) fn join(&mut self) {
        self.source = Source::System;
        self.started_at = [self.command.position, self.drive.actual().position];
    }

    /// The motion that held the axis is over; it stands where it is.
    pub(crate) fn release(&mut self) {
        self.source = Source::Held;
        self.command = standing(self.command.position);
    }

    /// Brakes from the present command at the axis's own Maximum Deceleration.
    pub(crate) fn brake(&mut self, s_curve: bool, now: Instant) {
        let from = State {
            position: self.command.position,
            velocity: self.command.velocity,
            acceleration: if s_curve { self.command.acceleration } else { 0.0 },
        };
        let AxisDynamics {
            speed,
            deceleration,
            deceleration_jerk,
        } = self.dynamics;
        let limits = Limits {
            speed,
            acceleration: deceleration,
            deceleration,
            jerk: s_curve.then_some(Jerk {
                acceleration: deceleration_jerk,
                deceleration: deceleration_jerk,
            }),
        };
        self.source = Source::Braking {
            profile: Profile::stop(from, &limits),
            start: now,
        };
    }

    /// The command at the present tick, unless a coordinate system gives it.
    pub(crate) fn advance(&mut self, clock: &Clock) {
        if let Source::Braking { profile, start } = &self.source {
            let elapsed = start.elapsed(clock);
            let State {
                position,
                velocity,
                acceleration,
            } = profile.at(elapsed);
            let over = elapsed >= profile.duration();
            self.command = Point {
                position,
                velocity,
                acceleration,
            };
            if over {
                self.release();
            }
        }
    }

    /// The drive follows the command over the period that ends now; without torque, the command follows it.
    pub(crate) fn follow(&mut self, period: f64) {
        match self.state {
            AxisState::Running | AxisState::Starting => self.drive.cycle(self.command, period),
            AxisState::Stopped | AxisState::Stopping | AxisState::Shutdown => {
                let now = self.drive.coast(period);
                self.command = standing(now.position);
            }
        }
    }

    /// Opens the loop: whatever moved the axis is over.
    pub(crate) fn disable(&mut self, state: AxisState) {
        self.state = state;
        if self.is_virtual {
            self.drive.halt();
        }
        self.release();
    }

    /// Closes the loop where the axis stands.
    pub(crate) fn enable(&mut self) {
        self.drive.halt();
        self.command = standing(self.drive.actual().position);
        self.state = AxisState::Starting;
    }

    /// A position as the axis shows it: rotary ones within one turn.
    pub(crate) fn shown(&self, position: f64) -> f64 {
        match self.unwind {
            Some(unwind) => {
                let turn = position - unwind * (position / unwind).floor();
                if turn >= unwind { 0.0 } else { turn }
            }
            None => position,
        }
    }
}

fn standing(position: f64) -> Point {
    Point {
        position,
        velocity: 0.0,
        acceleration: 0.0,
    }
}

//! The simulated machine: every axis follows its set-point, and its latches close at exact positions.
//!
//! A latch closes when the position of the axis by its encoder passes the trigger; the instant is found by bisection of the drive's motion within
//! the update. The mechanical stop holds an axis while its latch is armed.

use arcline_instruction_set::{AxisId, FaultSet};
use arcline_profile::KinematicState;
use arcline_profile::numeric::bisect;

use super::tolerance::SHORTEST_S;
use super::{Drive, Sensor, Settings, Settling};
use crate::{
    ArmLatch, DriveInput, DriveState, Drives, ExchangeLost, Feedback, Following, HOME_LATCH, LATCHES, Latch,
    REGISTRATION_LATCHES, SetPoint, Settled, Trigger, WrittenInput,
};

/// Halvings of the instant of a latch: to the last bit of an update.
const HALVINGS: usize = 60;
/// Axes of one coordinate system whose settling is examined together.
const MOST_AXES: usize = 3;

/// Simulated drives of a machine.
#[derive(Debug)]
pub struct SimulatedDrives {
    /// `None`: an axis without a drive.
    axes: Vec<Option<SimulatedAxis>>,
    period: f64,
}

/// A drive with its axis and the sensors of that.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedAxis {
    drive: Drive,
    /// The drive at the beginning of the last update.
    before: Drive,
    sensor: Sensor,
    set_point: SetPoint,
    /// The last closed latch.
    closed: Option<u32>,
    /// The last update changed nothing, so another one with the same set-point changes nothing either.
    rests: bool,
    /// The marker behind a trigger that has come: the number of the latch, the position of the marker, and the direction.
    marker: Option<(u32, f64, f64)>,
    /// The home input is written to be active; and its newest change, which closes a latch in the next update.
    home: bool,
    home_edge: Option<Trigger>,
    /// The enable input is written to be inactive.
    is_disabled: bool,
}

impl SimulatedAxis {
    /// An axis at rest at a machine position, disabled.
    pub fn new(position: f64, settings: &Settings, sensor: Sensor) -> Self {
        let drive = Drive::servo(position, settings);
        SimulatedAxis {
            drive,
            before: drive,
            sensor,
            set_point: SetPoint::default(),
            closed: None,
            rests: false,
            marker: None,
            home: false,
            home_edge: None,
            is_disabled: false,
        }
    }

    /// Executes one update. If nothing changes, the feedback of the last exchange stays.
    pub(super) fn follow(&mut self, set_point: &SetPoint, period: f64, feedback: &mut Feedback) {
        let off;
        let set_point = if self.is_disabled {
            off = SetPoint {
                enable: false,
                ..*set_point
            };
            &off
        } else {
            set_point
        };
        let stands = *set_point == self.set_point;
        if stands && self.rests {
            return;
        }
        if set_point.enable && !self.set_point.enable {
            self.drive.halt();
        }
        self.set_point = *set_point;
        self.before = self.drive;
        if set_point.enable {
            self.drive.rest_for(set_point.stood);
            self.drive.cycle(set_point.motion(), period);
        } else {
            self.drive.coast(period);
        }
        self.rests = stands && set_point.latches[HOME_LATCH].is_none() && self.drive == self.before;
        let mut latches = [None; LATCHES];
        let edge = self.home_edge.take();
        latches[HOME_LATCH] = set_point.latches[HOME_LATCH].and_then(|armed| self.latch(&armed, edge, period));
        let motion = self.drive.actual();
        // Member by member: an assignment of the whole would copy it once more in every update. A simulated drive has no faults of its own.
        feedback.state = if set_point.enable {
            DriveState::Enabled
        } else {
            DriveState::Off
        };
        feedback.following = if self.drive.is_exact() {
            Following::Exact
        } else {
            Following::Measured
        };
        feedback.motion = motion;
        feedback.error = self.drive.error();
        feedback.saturation = self.drive.saturation();
        feedback.faults = FaultSet::default();
        feedback.inputs.home = self.home || self.sensor.is_active(motion.position);
        feedback.latches = latches;
    }

    /// The axis is exactly at its set-points, and nothing is pending that another update would show.
    fn follows_exactly(&self) -> bool {
        self.set_point.enable
            && !self.is_disabled
            && self.home_edge.is_none()
            && self.set_point.latches.iter().all(Option::is_none)
            && self.drive.is_exact()
            && self.drive.error() == 0.0
    }

    /// Takes a write of the home input. A change closes a latch at the present position of the axis.
    fn write_home(&mut self, on: bool, feedback: &mut Feedback) {
        if self.home != on {
            self.home_edge = Some(if on { Trigger::SwitchOn } else { Trigger::SwitchOff });
            self.rests = false;
        }
        self.home = on;
        feedback.inputs.home = on || self.sensor.is_active(self.drive.actual().position);
    }

    /// The axis with an ideal drive, at its present position.
    pub(super) fn ideal(&self) -> Self {
        SimulatedAxis {
            drive: Drive::Ideal(self.drive.actual()),
            set_point: SetPoint {
                enable: true,
                ..self.set_point
            },
            rests: false,
            ..*self
        }
    }

    /// The motion of the axis by its encoder.
    pub(super) fn actual(&self) -> KinematicState {
        self.drive.actual()
    }

    /// Executes one update of an ideal axis that a model moves; its latches are those of the set-point.
    pub(super) fn be_moved(&mut self, motion: KinematicState, sent: &SetPoint, period: f64, feedback: &mut Feedback) {
        let there = SetPoint {
            enable: true,
            position: motion.position,
            velocity: motion.velocity,
            acceleration: motion.acceleration,
            stood: 0.0,
            latches: sent.latches,
        };
        self.follow(&there, period, feedback);
        // A mechanical stop may have held the simulated axis; the model alone determines the motion.
        self.drive = Drive::Ideal(motion);
        feedback.motion = motion;
    }

    /// Checks whether a latch has closed in the update, by a written `edge` at its beginning or by the motion. A mechanical stop then holds the
    /// axis.
    fn latch(&mut self, armed: &ArmLatch, edge: Option<Trigger>, period: f64) -> Option<Latch> {
        if self.closed == Some(armed.number) {
            return None;
        }
        let [from, to] = [self.before.actual().position, self.drive.actual().position];
        let direction = if to == from { 0.0 } else { (to - from).signum() };
        let pending = self.marker.filter(|(number, ..)| *number == armed.number);
        let (position, direction) = match pending {
            Some((_, marker, direction)) => (marker, direction),
            None if direction == 0.0 && (armed.then_marker || edge != Some(armed.trigger)) => return None,
            None => {
                let position = if edge == Some(armed.trigger) {
                    from
                } else {
                    self.sensor.ahead(armed.trigger, from, direction)?
                };
                if direction * (to - position) < 0.0 {
                    return None;
                }
                if armed.then_marker {
                    // The axis moves on; an axis that reverses meets the marker in the direction in which it met the trigger.
                    let marker = self.sensor.ahead(Trigger::Marker, position, direction);
                    let marker = marker.unwrap_or(direction * f64::INFINITY);
                    self.marker = Some((armed.number, marker, direction));
                    (marker, direction)
                } else {
                    (position, direction)
                }
            }
        };
        let passed = |at: f64| direction * (at - position) >= 0.0;
        if !passed(to) {
            return None;
        }
        let instant = self.instant(passed, period);
        self.closed = Some(armed.number);
        if armed.trigger == Trigger::Stop {
            self.drive = self.within(instant, period);
            self.drive.halt();
        }
        Some(Latch {
            number: armed.number,
            before_end_s: period - instant,
            position,
        })
    }

    /// The first instant of the update at which the axis has passed a position.
    fn instant(&self, passed: impl Fn(f64) -> bool, period: f64) -> f64 {
        let position = |at: f64| match at {
            short if short < SHORTEST_S => {
                let KinematicState { position, velocity, .. } = self.before.actual();
                position + short * velocity
            }
            _ => self.within(at, period).actual().position,
        };
        if passed(position(0.0)) {
            return 0.0;
        }
        bisect(0.0, period, HALVINGS, |at| passed(position(at)))
    }

    /// The drive at an instant after the beginning of the update.
    fn within(&self, at: f64, period: f64) -> Drive {
        let mut drive = self.before;
        if !self.set_point.enable {
            drive.coast(at);
        } else if at >= SHORTEST_S {
            drive.cycle(self.before.command_within(self.set_point.motion(), period, at), at);
        }
        drive
    }
}

impl SimulatedDrives {
    /// A machine with these axes, at an update period in seconds. The only allocation.
    pub fn new(axes: Vec<Option<SimulatedAxis>>, period: f64) -> Self {
        SimulatedDrives { axes, period }
    }

    pub(super) fn axes(&self) -> &[Option<SimulatedAxis>] {
        &self.axes
    }

    pub(super) fn axes_mut(&mut self) -> &mut [Option<SimulatedAxis>] {
        &mut self.axes
    }

    pub(super) fn period(&self) -> f64 {
        self.period
    }
}

impl Drives for SimulatedDrives {
    fn exchange(&mut self, set_points: &[SetPoint], feedback: &mut [Feedback]) -> Result<(), ExchangeLost> {
        let values = set_points.iter().zip(feedback);
        for (axis, (set_point, feedback)) in self.axes.iter_mut().zip(values) {
            if let Some(axis) = axis {
                axis.follow(set_point, self.period, feedback);
            }
        }
        Ok(())
    }

    fn rest_but(&self, axes: &[AxisId]) -> bool {
        let mut all = (0..).map(AxisId).zip(&self.axes);
        all.all(|(id, axis)| axis.as_ref().is_none_or(|axis| axis.rests) || axes.contains(&id))
    }

    fn exchange_of(&mut self, axes: &[AxisId], set_points: &[SetPoint], feedback: &mut [Feedback]) {
        for id in axes.iter().map(|id| id.index()) {
            if let (Some(Some(axis)), Some(set_point), Some(feedback)) =
                (self.axes.get_mut(id), set_points.get(id), feedback.get_mut(id))
            {
                axis.follow(set_point, self.period, feedback);
            }
        }
    }

    fn follow_exactly(&self, axes: &[AxisId]) -> bool {
        axes.iter().all(|id| match self.axes.get(id.index()) {
            Some(Some(axis)) => axis.follows_exactly(),
            _ => true,
        })
    }

    /// Closes the latch at the tick, at the present position of the axis.
    fn write_input(&mut self, input: &WrittenInput, feedback: &mut Feedback) {
        let axis = self.axes.get_mut(input.axis.index()).and_then(Option::as_mut);
        let number = match (input.input, axis) {
            (DriveInput::Registration(number), _) => number,
            (DriveInput::Home, Some(axis)) => return axis.write_home(input.on, feedback),
            (DriveInput::Enable, Some(axis)) => {
                axis.is_disabled = !input.on;
                axis.rests = false;
                return;
            }
            (_, None) => return,
        };
        let Some(level) = feedback.inputs.registration.get_mut(number) else {
            return;
        };
        *level = input.on;
        let trigger = if input.on {
            Trigger::RegistrationOn
        } else {
            Trigger::RegistrationOff
        };
        let armed = input.armed.filter(|armed| armed.trigger == trigger);
        feedback.latches[REGISTRATION_LATCHES[number]] = armed.map(|armed| Latch {
            number: armed.number,
            before_end_s: 0.0,
            position: feedback.motion.position,
        });
    }

    fn settled(&self, axes: &[AxisId], tolerance: f64, stood: f64) -> Settled {
        let mut settling = Settling {
            drives: [Drive::ideal(0.0); MOST_AXES],
            ends: [0.0; MOST_AXES],
            tolerance,
            period: self.period,
            rest: stood,
        };
        for (index, axis) in axes.iter().enumerate().take(MOST_AXES) {
            if let Some(Some(axis)) = self.axes.get(usize::from(*axis)) {
                settling.drives[index] = axis.before;
                settling.ends[index] = axis.set_point.position;
            }
        }
        match settling.within() {
            Some(before_end_s) => Settled::Within { before_end_s },
            None => Settled::No,
        }
    }
}

//! The data exchanged with the drives in a tick, and the trait that drives implement.

use std::fmt;

use arcline_instruction_set::{AxisId, FaultSet};
use arcline_profile::KinematicState;

/// Latches of an axis: of homing, and of both registration inputs.
pub const LATCHES: usize = 3;
/// The latch of homing.
pub const HOME_LATCH: usize = 0;
/// The latches of the registration inputs.
pub const REGISTRATION_LATCHES: [usize; 2] = [1, 2];

/// The drives of a machine, in the order of its axes. The entries of an axis without a drive are ignored.
pub trait Drives: fmt::Debug + Send {
    /// Sends the set-points of the present tick to all drives, and takes their feedback. The tick calls it once: it must not block or allocate.
    /// `feedback` holds the feedback of the last exchange.
    ///
    /// The feedback may be of the present tick, as that of a model in the same process, or some ticks old, as that of a fieldbus.
    ///
    /// # Errors
    /// [`ExchangeLost`] if no feedback came: the contents of `feedback` are then invalid.
    fn exchange(&mut self, set_points: &[SetPoint], feedback: &mut [Feedback]) -> Result<(), ExchangeLost>;

    /// The drives of all axes but these rest: their feedback stays as it is until their set-points or a written input change. Drives that cannot
    /// know it, as real ones, answer false.
    fn rest_but(&self, axes: &[AxisId]) -> bool {
        let _ = axes;
        false
    }

    /// As [`Drives::exchange`], after [`Drives::rest_but`] was true: only the drives of these axes need to be asked, and they always answer.
    fn exchange_of(&mut self, axes: &[AxisId], set_points: &[SetPoint], feedback: &mut [Feedback]) {
        let _ = axes;
        let _ = self.exchange(set_points, feedback);
    }

    /// The drives of these axes are exactly at their set-points at every instant, and their feedback shows nothing but this motion as long as
    /// no latch is armed and no input written. Exchanges with them can then be left out, but for the last two before their feedback is used.
    fn follow_exactly(&self, axes: &[AxisId]) -> bool {
        let _ = axes;
        false
    }

    /// Takes a change, after the last exchange of the present tick, of an input that clients or a program write and that is not wired
    /// to a drive. The drive handles it as a wired input: `feedback` is that of the axis, and gets the input and the latch of a
    /// registration input; the latch of homing comes with the next exchange.
    ///
    /// Drives with all their inputs at their own terminals ignore it.
    fn write_input(&mut self, input: &WrittenInput, feedback: &mut Feedback) {
        let _ = (input, feedback);
    }

    /// The instant, during the update that the last exchange ended, at which axes with resting set-points came within a tolerance of them, by the
    /// norm of their following errors. `stood`: seconds for which the set-points have rested at the end of the update.
    ///
    /// Drives that know only their feedback answer [`Settled::Unknown`].
    fn settled(&self, axes: &[AxisId], tolerance: f64, stood: f64) -> Settled {
        let _ = (axes, tolerance, stood);
        Settled::Unknown
    }
}

/// The feedback did not come in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExchangeLost;

/// An answer of [`Drives::settled`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Settled {
    /// The axes came within the tolerance.
    Within {
        /// Seconds before the end of the update.
        before_end_s: f64,
    },
    /// The axes did not.
    No,
    /// The feedback shows only their positions at its own time.
    Unknown,
}

/// The output to the drive of one axis at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPoint {
    /// The drive must hold the axis and follow the set-points.
    pub enable: bool,
    /// Machine position, without the offset of redefined positions, position units.
    pub position: f64,
    /// Position units per second.
    pub velocity: f64,
    /// Position units per second².
    pub acceleration: f64,
    /// Seconds before the tick at which the set-point came to rest, if it rests and did so within the last update; otherwise 0.
    pub stood: f64,
    /// Latches to close.
    pub latches: [Option<ArmLatch>; LATCHES],
}

impl SetPoint {
    /// Its position, velocity and acceleration.
    pub fn motion(&self) -> KinematicState {
        KinematicState {
            position: self.position,
            velocity: self.velocity,
            acceleration: self.acceleration,
        }
    }

    /// Sets its position, velocity and acceleration.
    pub fn set_motion(&mut self, motion: KinematicState) {
        self.position = motion.position;
        self.velocity = motion.velocity;
        self.acceleration = motion.acceleration;
    }
}

/// A latch that is armed. It closes once for each number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArmLatch {
    /// The number of the arming: a closed latch has the same number.
    pub number: u32,
    /// The trigger that closes it.
    pub trigger: Trigger,
    /// The first marker behind the trigger closes it instead.
    pub then_marker: bool,
}

/// The trigger of a latch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trigger {
    /// The home switch becomes active.
    SwitchOn,
    /// The home switch becomes inactive.
    SwitchOff,
    /// A marker of the encoder passes.
    Marker,
    /// The torque has risen to its level: a mechanical stop holds the axis.
    Stop,
    /// The registration input of the latch becomes active.
    RegistrationOn,
    /// The registration input of the latch becomes inactive.
    RegistrationOff,
}

/// A latch that has closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latch {
    /// The number with which it was armed.
    pub number: u32,
    /// Seconds before the tick of the exchange at which it closed, 0 or more.
    pub before_end_s: f64,
    /// Machine position of the axis at that instant, exact, position units.
    pub position: f64,
}

/// A written input of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrittenInput {
    /// The axis.
    pub axis: AxisId,
    /// The input.
    pub input: DriveInput,
    /// The input is active now.
    pub on: bool,
    /// The armed latch of a registration input.
    pub armed: Option<ArmLatch>,
}

/// A digital input of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveInput {
    /// A registration input: 0 or 1.
    Registration(usize),
    /// The home switch: active if this input or a switch that the drive itself reads is.
    Home,
    /// The drive holds the axis only while this input is active. A drive whose input was never written ignores it.
    Enable,
}

/// The input from the drive of one axis at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// The state of the drive.
    pub state: DriveState,
    /// The precision with which the axis follows.
    pub following: Following,
    /// Machine motion of the axis by its encoder; the acceleration is the mean over the last update.
    pub motion: KinematicState,
    /// Set-point minus actual position by the drive's own measurement, position units.
    pub error: f64,
    /// The limit that prevents the drive from following.
    pub saturation: Saturation,
    /// Faults that the drive reports while their causes are present.
    pub faults: FaultSet,
    /// Digital inputs.
    pub inputs: DriveInputs,
    /// Latches that have closed since the last exchange.
    pub latches: [Option<Latch>; LATCHES],
}

/// The state of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveState {
    /// It has no torque.
    #[default]
    Off,
    /// It holds the axis and follows the set-points.
    Enabled,
    /// A fault has disabled it.
    Faulted,
    /// It does not answer: the rest of its feedback is invalid.
    Lost,
}

/// The precision with which an axis follows its set-points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Following {
    /// Only the feedback shows it.
    #[default]
    Measured,
    /// The axis follows without an error at any instant.
    Exact,
}

/// The limit that prevents a drive from following its loop, at the present tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Saturation {
    /// None.
    #[default]
    None,
    /// It runs at its speed limit.
    Speed,
    /// It accelerates at its full torque.
    Torque,
}

/// Digital inputs of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct DriveInputs {
    /// The home switch is active.
    pub home: bool,
    /// The registration inputs are active.
    pub registration: [bool; REGISTRATION_LATCHES.len()],
}

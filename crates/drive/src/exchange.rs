//! The values that go over the seam in a tick, and the trait of what stands behind it.

use std::fmt;

use arcline_instruction_set::{AxisId, FaultSet};
use arcline_profile::KinematicState;

/// Latches of an axis: of homing, and of both registration inputs.
pub const LATCHES: usize = 3;
/// The latch of homing.
pub const HOME_LATCH: usize = 0;
/// The latches of the registration inputs.
pub const REGISTRATION_LATCHES: [usize; 2] = [1, 2];

/// The drives of a machine, in the order of its axes. An axis without a drive has a place that means nothing.
pub trait Drives: fmt::Debug + Send {
    /// Gives the set-points of the present tick to all drives, and takes their feedback. Called once in a tick, from the tick: it
    /// must not block or allocate. `feedback` holds what the last exchange has left there.
    ///
    /// The feedback may be of the present tick, as that of the simulated machine, or some ticks old, as that of a fieldbus.
    ///
    /// # Errors
    /// [`ExchangeLost`] when no feedback came: `feedback` then means nothing.
    fn exchange(&mut self, set_points: &[SetPoint], feedback: &mut [Feedback]) -> Result<(), ExchangeLost>;

    /// An input that clients or a program's wires write, and that is not wired to a drive, has changed at the present tick, behind the
    /// last exchange. The drive takes it as if it was wired to it: `feedback` is that of the axis, and gets the input and the latch of a
    /// registration input; that of homing comes with the next exchange.
    ///
    /// Drives that have all their inputs at their own terminals ignore it.
    fn write_input(&mut self, input: &WrittenInput, feedback: &mut Feedback) {
        let _ = (input, feedback);
    }

    /// When axes whose set-points stand came within a tolerance of them: by the norm of their following errors, during the update
    /// that the last exchange ended. `stood`: for how long the set-points have stood at its end, seconds.
    ///
    /// Drives that know only what their feedback says answer [`Settled::Unknown`].
    fn settled(&self, axes: &[AxisId], tolerance: f64, stood: f64) -> Settled {
        let _ = (axes, tolerance, stood);
        Settled::Unknown
    }
}

/// No feedback came in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExchangeLost;

/// An answer of [`Drives::settled`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Settled {
    /// The axes came within the tolerance.
    Within {
        /// How long before the end of the update, seconds.
        before_end_s: f64,
    },
    /// They did not.
    No,
    /// The feedback tells no more than where they are at its time.
    Unknown,
}

/// What goes out to the drive of one axis at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPoint {
    /// The drive is to hold the axis and to follow.
    pub enable: bool,
    /// Where the axis is to be, of the machine: without what positions were redefined by. Position units.
    pub position: f64,
    /// Position units per second.
    pub velocity: f64,
    /// Position units per second².
    pub acceleration: f64,
    /// How long before the tick the set-point came to rest, where that lies within the last update and it is at rest; seconds.
    pub stood: f64,
    /// Latches that are to close.
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
}

/// A latch that is armed. It closes once for each number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArmLatch {
    /// Which arming this is: a latch that closes has the same number.
    pub number: u32,
    /// What closes it.
    pub trigger: Trigger,
    /// The first marker behind the trigger closes it instead.
    pub then_marker: bool,
}

/// What closes a latch.
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
    /// How long before the tick of the exchange it closed, seconds, 0 or more.
    pub before_end_s: f64,
    /// Where the axis was, of the machine: exact. Position units.
    pub position: f64,
}

/// An input of a drive that is written instead of wired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrittenInput {
    /// The axis.
    pub axis: AxisId,
    /// Which of its inputs.
    pub input: DriveInput,
    /// The input is active now.
    pub on: bool,
    /// The latch of a registration input, as it is armed now.
    pub armed: Option<ArmLatch>,
}

/// A digital input of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveInput {
    /// A registration input: 0 or 1.
    Registration(usize),
    /// The home switch, beside that of the simulated machine: active is one of them.
    Home,
    /// The drive holds the axis only while this input is active. A drive whose input is never written does not need it.
    Enable,
}

/// What comes in from the drive of one axis at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// What the drive does.
    pub state: DriveState,
    /// How the axis follows.
    pub following: Following,
    /// Where the axis is, of the machine, as its encoder sees it; the acceleration is the mean over the last update.
    pub motion: KinematicState,
    /// Set-point minus actual position, as the drive knows it, position units.
    pub error: f64,
    /// What keeps the drive from following.
    pub saturation: Saturation,
    /// Faults that the drive reports, as long as their causes are there.
    pub faults: FaultSet,
    /// Digital inputs.
    pub inputs: Inputs,
    /// Latches that have closed since the last exchange.
    pub latches: [Option<Latch>; LATCHES],
}

/// What a drive does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveState {
    /// It has no torque.
    #[default]
    Off,
    /// It holds the axis and follows the set-points.
    Enabled,
    /// A fault has switched it off.
    Faulted,
    /// It does not answer: the rest of its feedback means nothing.
    Lost,
}

/// How an axis follows its set-points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Following {
    /// The feedback says how.
    #[default]
    Measured,
    /// Without an error at any instant: a simulated drive can.
    Exact,
}

/// What keeps a drive from doing what its loop asks for, at the present tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Saturation {
    /// Nothing.
    #[default]
    None,
    /// It runs at its speed limit.
    Speed,
    /// It accelerates with all its torque.
    Torque,
}

/// Digital inputs of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Inputs {
    /// The home switch is active.
    pub home: bool,
    /// The registration inputs are active.
    pub registration: [bool; REGISTRATION_LATCHES.len()],
}

//! The configuration of one axis. Units: position units (u), seconds.

use arcline_instruction_set::{ExceptionAction, FAULTS, FaultKind, FaultSet};

use arcline_planner::profile::DynamicsBits;

use super::home::Home;
use super::inputs::AxisInputs;
use super::limits::default_jerk;

/// One axis (spec/axis-and-data-types.md §9.1 to §9.4).
#[derive(Clone, PartialEq, Debug)]
pub struct Axis {
    /// Name, the axis's tag.
    pub name: String,
    /// Its type.
    pub kind: AxisKind,
    /// Label of its position units, such as `mm`.
    pub units: String,
    /// 100 % of speed, above 0, u/s.
    pub max_speed: f64,
    /// 100 % of acceleration, above 0, u/s².
    pub max_acceleration: f64,
    /// 100 % of deceleration, u/s². 0 is possible: instructions that need it err with 54.
    pub max_deceleration: f64,
    /// 100 % of acceleration jerk, above 0, u/s³.
    pub max_acceleration_jerk: f64,
    /// 100 % of deceleration jerk, u/s³. 0 is possible: S-curves then err with 76.
    pub max_deceleration_jerk: f64,
    /// Dynamics Configuration Bits at start-up.
    pub dynamics_bits: DynamicsBits,
    /// Soft travel limits; `None`: unchecked. Never together with `unwind`.
    pub travel: Option<Travel>,
    /// Length of one turn of a rotary axis, above 0; `None`: a linear axis.
    pub unwind: Option<f64>,
    /// State at start-up.
    pub start: StartState,
    /// Its homing.
    pub home: Home,
    /// The deceleration of the axis by a group stop in mode Programmed.
    pub programmed_stop_mode: ProgrammedStopMode,
    /// The action of each fault.
    pub exception_actions: ExceptionActions,
    /// Time over which AverageVelocity is taken, above 0, at most 1 s.
    pub average_velocity_timebase: f64,
    /// The limits of its set-points.
    pub command_limits: CommandLimits,
    /// The following error that is a fault; without effect on an axis without a drive.
    pub position_error: PositionErrorLimit,
    /// Execution targets of output cams (MAOC), 0 to [`MAX_OUTPUT_TARGETS`](super::MAX_OUTPUT_TARGETS).
    pub output_cam_targets: usize,
    /// Its inputs from tags that clients write.
    pub inputs: AxisInputs,
}

/// The largest step from one set-point to the next, as multiples of the axis's maxima (spec/axis-and-data-types.md §12).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CommandLimits {
    /// The controller checks the limits. A set-point that is not a number is always refused.
    pub enabled: bool,
    /// Highest speed, times Maximum Speed.
    pub speed: f64,
    /// Highest change of velocity, times the higher one of Maximum Acceleration and Maximum Deceleration.
    pub acceleration: f64,
}

impl CommandLimits {
    /// The default limits for a type of axis: checked if the axis has a drive.
    pub fn of_kind(kind: &AxisKind) -> Self {
        CommandLimits {
            enabled: matches!(kind, AxisKind::Servo),
            ..CommandLimits::default()
        }
    }
}

impl Default for CommandLimits {
    /// Four times Maximum Speed, a hundred times the maximum acceleration.
    fn default() -> Self {
        CommandLimits {
            enabled: true,
            speed: 4.0,
            acceleration: 100.0,
        }
    }
}

/// The action of every kind of fault (spec/axis-and-data-types.md §9.3).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ExceptionActions([ExceptionAction; FaultKind::COUNT]);

impl ExceptionActions {
    /// The action of one kind. Real-time.
    pub fn of(&self, kind: FaultKind) -> ExceptionAction {
        self.0[kind as usize]
    }

    /// The same actions with another one for one kind.
    #[must_use]
    pub fn with(mut self, kind: FaultKind, action: ExceptionAction) -> Self {
        self.0[kind as usize] = action;
        self
    }
}

impl Default for ExceptionActions {
    /// The default actions of the catalogue.
    fn default() -> Self {
        ExceptionActions(FAULTS.each_ref().map(|fault| fault.default))
    }
}

/// Programmed Stop Mode of an axis (spec/axis-and-data-types.md §4).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum ProgrammedStopMode {
    /// Decelerate at Maximum Deceleration; the servo stays on.
    #[default]
    FastStop,
    /// Decelerate, then servo off.
    FastDisable,
    /// Servo off now; the axis coasts.
    HardDisable,
    /// Decelerate, then shutdown.
    FastShutdown,
    /// Shutdown now.
    HardShutdown,
}

impl ProgrammedStopMode {
    /// Every mode with its word in the configuration, in the order of the attribute's values from 0.
    pub const ALL: [(&'static str, ProgrammedStopMode); 5] = [
        ("fast_stop", ProgrammedStopMode::FastStop),
        ("fast_disable", ProgrammedStopMode::FastDisable),
        ("hard_disable", ProgrammedStopMode::HardDisable),
        ("fast_shutdown", ProgrammedStopMode::FastShutdown),
        ("hard_shutdown", ProgrammedStopMode::HardShutdown),
    ];
}

impl Axis {
    /// A linear axis with these maxima, in units/s and units/s², and the defaults of a configuration otherwise.
    pub fn new(name: &str, kind: AxisKind, max_speed: f64, max_acceleration: f64) -> Self {
        let jerk = default_jerk(max_speed, max_acceleration);
        Axis {
            name: name.to_owned(),
            kind,
            units: "Position Units".to_owned(),
            max_speed,
            max_acceleration,
            max_deceleration: max_acceleration,
            max_acceleration_jerk: jerk,
            max_deceleration_jerk: jerk,
            dynamics_bits: DynamicsBits::ALL,
            travel: None,
            unwind: None,
            start: StartState::default(),
            home: Home::immediate(max_acceleration, max_acceleration),
            programmed_stop_mode: ProgrammedStopMode::default(),
            exception_actions: ExceptionActions::default(),
            average_velocity_timebase: 0.25,
            command_limits: CommandLimits::of_kind(&kind),
            position_error: PositionErrorLimit::default(),
            output_cam_targets: 0,
            inputs: AxisInputs::default(),
        }
    }

    /// The axis is rotary: its position repeats after one unwind.
    pub fn is_rotary(&self) -> bool {
        self.unwind.is_some()
    }

    /// The greatest distance of the axis from 0: 2³² coarse updates of this period (s) at Maximum Speed
    pub(crate) fn range(&self, period: f64) -> f64 {
        const UPDATES: f64 = 4_294_967_296.0;
        UPDATES * self.max_speed * period
    }

    /// The axis is an AXIS_VIRTUAL.
    pub fn is_virtual(&self) -> bool {
        matches!(self.kind, AxisKind::Virtual)
    }
}

/// Type of an axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum AxisKind {
    /// A drive moves it; the axis is an AXIS_CIP_DRIVE.
    Servo,
    /// The axis has no drive: its actual position is its command position; the axis is an AXIS_VIRTUAL.
    Virtual,
    /// An encoder: no instruction moves it, and clients write its position to a tag; the axis is an AXIS_CIP_DRIVE.
    Feedback,
}

/// The limit of the following error of an axis; an error beyond it is a fault (spec/axis-and-data-types.md §9.3).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PositionErrorLimit {
    /// Position Error Tolerance, u; 0 switches the check off.
    pub tolerance: f64,
    /// Position Error Tolerance Time: the time for which the error must exceed the tolerance, s, 0 or more.
    pub time: f64,
}

impl PositionErrorLimit {
    /// The following error is unchecked.
    pub const OFF: PositionErrorLimit = PositionErrorLimit {
        tolerance: 0.0,
        time: 0.0,
    };
}

impl Default for PositionErrorLimit {
    /// 5 position units at once.
    fn default() -> Self {
        PositionErrorLimit {
            tolerance: 5.0,
            time: 0.0,
        }
    }
}

/// Soft travel limits on the actual position, u, `min < max`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Travel {
    /// Soft Travel Limit Negative.
    pub min: f64,
    /// Soft Travel Limit Positive.
    pub max: f64,
}

/// The state of an axis at start-up.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct StartState {
    /// Actual and command position, u; of a rotary axis within one turn.
    pub position: f64,
    /// The drive is enabled. Without effect on a virtual axis, which is always on.
    pub servo_on: bool,
    /// The axis counts as homed.
    pub homed: bool,
    /// Faults that have not been reset.
    pub faults: FaultSet,
    /// Sum of the shifts of the position by homing and MRP: the axis's position minus the position of its drive, u.
    pub redefined: f64,
}

impl Default for StartState {
    fn default() -> Self {
        Self {
            position: 0.0,
            servo_on: true,
            homed: true,
            faults: FaultSet::default(),
            redefined: 0.0,
        }
    }
}

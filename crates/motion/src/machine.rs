//! The machine: which axes and coordinate systems there are, and what they can do.
//!
//! It is what `arcline-config` makes of a configuration and what the controller is built from. It holds
//! nothing that changes while the machine runs: positions and states are the controller's.
//!
//! Units: positions in the axis's own units (u), speeds u/s, rates u/s², jerks u/s³, times in
//! nanoseconds or seconds as named. Places (`u16`) count from 0 in configuration order.

mod home;
mod inputs;

pub use home::{Home, HomeDirection, HomeMarker, HomeMode, HomeSequence, HomeSwitch};
pub use inputs::{Feed, Inputs};

pub use arcline_kinematics::{Geometry, Parameters, Wrist};
pub use arcline_planner::precise::Deviation;
pub use arcline_planner::profile::Bounds as DynamicsBits;

use arcline_instruction_set::{AxisId, ExceptionAction, FAULTS, FaultKind, FaultSet, SystemId};

/// Largest number of axes of one machine.
pub const MAX_AXES: usize = 256;

/// Largest number of coordinate systems of one machine.
pub const MAX_SYSTEMS: usize = 64;

/// Largest number of transforms of one machine.
pub const MAX_TRANSFORMS: usize = 64;

/// Largest number of axes of one coordinate system that moves interpolate as a vector: X, Y, Z.
pub const MAX_PRIMARY_AXES: usize = 3;

/// Largest number of execution targets of output cams of one axis: a bit of OutputCamStatus each.
pub const MAX_OUTPUT_TARGETS: usize = 32;

/// Largest number of axes of one coordinate system: X, Y, Z, Rx, Ry, Rz, or the joints J1 to J6.
pub const MAX_SYSTEM_AXES: usize = 6;

/// Deepest queue of pending moves behind the active one.
pub const MAX_QUEUE_DEPTH: usize = 1000;

/// Everything there is to control.
///
/// Whoever makes one keeps these promises, on which the controller relies: names are unique without
/// regard to case among group, axes, systems and transforms; every place (`CoordinateSystem::axes`,
/// `Transform::source`) exists; numbers are finite and within what their fields say.
#[derive(Clone, PartialEq, Debug)]
pub struct Machine {
    /// Coarse update period: the length of one tick, 250,000 to 32,000,000 ns.
    pub period_ns: u64,
    /// Name of the motion group.
    pub group: String,
    /// The axes, at most [`MAX_AXES`].
    pub axes: Vec<Axis>,
    /// The coordinate systems, at most [`MAX_SYSTEMS`].
    pub systems: Vec<CoordinateSystem>,
    /// The transforms that MCT may turn on, at most [`MAX_TRANSFORMS`].
    pub transforms: Vec<Transform>,
}

impl Machine {
    /// Coarse update period in seconds.
    pub fn period(&self) -> f64 {
        // Exact: the period is far below 2^53 ns.
        self.period_ns as f64 / 1e9
    }

    /// Place of the axis of that name, case ignored.
    pub fn axis(&self, name: &str) -> Option<AxisId> {
        place(self.axes.iter().map(|axis| axis.name.as_str()), name).map(AxisId)
    }

    /// Place of the coordinate system of that name, case ignored.
    pub fn system(&self, name: &str) -> Option<SystemId> {
        place(self.systems.iter().map(|system| system.name.as_str()), name).map(SystemId)
    }

    /// Place of the transform of that name, case ignored.
    pub fn transform(&self, name: &str) -> Option<u16> {
        place(self.transforms.iter().map(|transform| transform.name.as_str()), name)
    }

    /// Whether the motion group has that name, case ignored.
    pub fn is_group(&self, name: &str) -> bool {
        self.group.eq_ignore_ascii_case(name)
    }
}

/// One axis (spec/axis-and-data-types.md §9.1 to §9.4).
#[derive(Clone, PartialEq, Debug)]
pub struct Axis {
    /// Name, the axis's tag.
    pub name: String,
    /// What stands behind it.
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
    pub start: Start,
    /// How it is homed.
    pub home: Home,
    /// What a group stop in mode Programmed does with the axis.
    pub programmed_stop_mode: ProgrammedStopMode,
    /// What each fault does.
    pub exception_actions: ExceptionActions,
    /// Time over which AverageVelocity is taken, above 0, at most 1 s.
    pub average_velocity_timebase: f64,
    /// What its set-points may ask of it.
    pub command_limits: CommandLimits,
    /// Execution targets of output cams (MAOC), 0 to [`MAX_OUTPUT_TARGETS`].
    pub output_cam_targets: usize,
    /// What it has from tags that clients write.
    pub inputs: Inputs,
}

/// What a set-point may ask of an axis beyond the last one, as multiples of the axis's maxima (spec/axis-and-data-types.md §12).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CommandLimits {
    /// Whether they are looked at. A set-point that is no number never goes out.
    pub enabled: bool,
    /// Highest speed, times Maximum Speed.
    pub speed: f64,
    /// Highest change of velocity, times the higher one of Maximum Acceleration and Maximum Deceleration.
    pub acceleration: f64,
}

impl CommandLimits {
    /// Those of an axis that is not configured otherwise: looked at where it has a drive.
    pub fn of_kind(kind: &AxisKind) -> Self {
        CommandLimits {
            enabled: matches!(kind, AxisKind::Servo(_)),
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

    /// With another action for one kind.
    #[must_use]
    pub fn with(mut self, kind: FaultKind, action: ExceptionAction) -> Self {
        self.0[kind as usize] = action;
        self
    }
}

impl Default for ExceptionActions {
    /// As the catalogue says.
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
    /// Whether its position rolls over.
    pub fn is_rotary(&self) -> bool {
        self.unwind.is_some()
    }

    /// How far from 0 the axis can be: 2³² coarse updates of this period (s) at Maximum Speed
    /// (spec/coordinated-instructions.md §4.6, "The range of positions").
    pub(crate) fn range(&self, period: f64) -> f64 {
        const UPDATES: f64 = 4_294_967_296.0;
        UPDATES * self.max_speed * period
    }

    /// Whether it has no drive.
    pub fn is_virtual(&self) -> bool {
        matches!(self.kind, AxisKind::Virtual)
    }
}

/// What stands behind an axis.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum AxisKind {
    /// A simulated servo drive; the axis is an AXIS_CIP_DRIVE.
    Servo(Drive),
    /// Nothing: actual is command; the axis is an AXIS_VIRTUAL.
    Virtual,
    /// An encoder: it cannot be moved, its position is written to a tag; the axis is an AXIS_CIP_DRIVE.
    Feedback,
}

/// A simulated servo drive.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Drive {
    /// Bandwidth of the position loop, above 0, Hz.
    pub position_bandwidth_hz: f64,
    /// Share of the command velocity that is fed forward: 0 lags by velocity / bandwidth, 1 does not. 0 to 1.
    pub velocity_feedforward: f64,
    /// Position error above which the drive faults, u; 0 switches the check off (spec/axis-and-data-types.md §9.3).
    pub position_error_tolerance: f64,
    /// How long the position error must stay above its tolerance, s, 0 or more (spec/axis-and-data-types.md §9.3).
    pub position_error_tolerance_time: f64,
    /// Highest speed of the motor, above 0, u/s; `None`: as fast as the loop asks for.
    pub speed_limit: Option<f64>,
    /// Acceleration of the axis under the highest torque of the motor, above 0, u/s²; `None`: as the loop asks for.
    pub torque_limit: Option<f64>,
    /// Encoder counts per unit, above 0: what the actual position is rounded to; `None`: it is not.
    pub encoder_resolution: Option<f64>,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            position_bandwidth_hz: 40.0,
            velocity_feedforward: 1.0,
            position_error_tolerance: 5.0,
            position_error_tolerance_time: 0.0,
            speed_limit: None,
            torque_limit: None,
            encoder_resolution: None,
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

/// How an axis stands at start-up.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Start {
    /// Actual and command position, u; of a rotary axis within one turn.
    pub position: f64,
    /// Whether the drive is enabled. Means nothing for a virtual axis, which is always on.
    pub servo_on: bool,
    /// Whether the axis counts as homed.
    pub homed: bool,
    /// Faults that have not been reset.
    pub faults: FaultSet,
    /// What positions were shifted by since the machine was built: home sensor and encoder stand where they are.
    pub redefined: f64,
}

impl Default for Start {
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

/// One coordinate system (spec/axis-and-data-types.md §9.6). The maxima are of the vector.
#[derive(Clone, PartialEq, Debug)]
pub struct CoordinateSystem {
    /// Name, the coordinate system's tag.
    pub name: String,
    /// Places of its axes in [`Machine::axes`], in order, each once: 1 to [`MAX_PRIMARY_AXES`], or as many as `orientation`
    /// or a wrist in `robot` says. See [`CoordinateSystem::linear`].
    pub axes: Vec<AxisId>,
    /// 100 % of speed, above 0, u/s.
    pub max_speed: f64,
    /// 100 % of acceleration, above 0, u/s².
    pub max_acceleration: f64,
    /// 100 % of deceleration, u/s². 0 is possible: moves then err with 54, -1.
    pub max_deceleration: f64,
    /// 100 % of acceleration jerk, above 0, u/s³.
    pub max_acceleration_jerk: f64,
    /// 100 % of deceleration jerk, u/s³. 0 is possible: S-curves then err with 76, -1.
    pub max_deceleration_jerk: f64,
    /// Dynamics Configuration Bits at start-up.
    pub dynamics_bits: DynamicsBits,
    /// Actual Position Tolerance, u, 0 or more; 0 makes termination type 0 err with 51.
    pub actual_tolerance: f64,
    /// Command Position Tolerance, u, 0 or more.
    pub command_tolerance: f64,
    /// Pending moves behind the active one, 1 to [`MAX_QUEUE_DEPTH`].
    pub queue_depth: usize,
    /// How termination types 2, 3 and 6 shape a corner.
    pub corner: Corner,
    /// Where planned contours may deviate from the programmed path inside the tolerance.
    pub deviation: Deviation,
    /// Whether the axes' own limits lower the path speed.
    pub axis_limits: AxisLimits,
    /// Whether the joints of robots that a transform leads lower the path speed.
    pub joint_limits: AxisLimits,
    /// The robot whose joints its axes are; `None`: it is Cartesian.
    pub robot: Option<Robot>,
    /// Its axes are X, Y, Z, Rx, Ry, Rz, the last three in degrees: Coordinate Definition XYZRxRyRz. Never of a robot.
    pub orientation: Option<Orientation>,
}

impl CoordinateSystem {
    /// The axes that coordinated moves interpolate as a vector: at most [`MAX_PRIMARY_AXES`], the first ones. Real-time.
    pub fn linear(&self) -> &[AxisId] {
        &self.axes[..self.axes.len().min(MAX_PRIMARY_AXES)]
    }

    /// The axes behind them: Rx, Ry, Rz, or the joints J4 to J6; mostly none. Real-time.
    pub fn oriented(&self) -> &[AxisId] {
        &self.axes[self.axes.len().min(MAX_PRIMARY_AXES)..]
    }
}

/// Maxima of the turn of a Cartesian coordinate system with orientation (spec/axis-and-data-types.md §9.6), each above 0.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Orientation {
    /// 100 % of Orientation Speed, degrees/s.
    pub max_speed: f64,
    /// 100 % of Orientation Acceleration, degrees/s².
    pub max_acceleration: f64,
    /// 100 % of Orientation Deceleration, degrees/s².
    pub max_deceleration: f64,
}

impl Orientation {
    /// Its Coordinate Definition.
    pub const DEFINITION: &'static str = "XYZRxRyRz";
}

/// A robot as it was described: MCT refuses one that cannot be (ERR 61).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Robot {
    /// How it is built; it has as many joints as the coordinate system has axes.
    pub build: Build,
    /// What it is built with.
    pub parameters: Parameters,
}

/// How a robot is built.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Build {
    /// An arm, which MCT links.
    Arm(Geometry),
    /// An arm with a wrist, which MCTO links.
    Wrist(Wrist),
}

impl Build {
    /// Joints.
    pub fn joints(self) -> usize {
        match self {
            Build::Arm(geometry) => geometry.joints(),
            Build::Wrist(wrist) => wrist.joints(),
        }
    }
}

/// How termination types 2, 3 and 6 shape a corner.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Corner {
    /// The two moves are superposed, as Logix does it.
    #[default]
    Logix,
    /// Rounded within the tolerance at the highest speed that the limits allow.
    Precise,
}

/// What becomes of an axis's own limits in a coordinated move.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum AxisLimits {
    /// Nothing, as in Logix: only the vector's limits count.
    #[default]
    Ignore,
    /// The path speed is lowered so that no axis exceeds its speed, acceleration or jerk.
    Enforce,
}

/// A link between two coordinate systems for MCT.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Transform {
    /// Name of the link.
    pub name: String,
    /// Place of the source system in [`Machine::systems`].
    pub source: SystemId,
    /// Place of the target system in [`Machine::systems`], another one.
    pub target: SystemId,
}

/// The jerk maximum that stands for "100 % of time" at full speed and full rate: `rate² / speed`
/// (spec/axis-and-data-types.md §9.2), u/s³; what an absent jerk maximum is.
pub fn default_jerk(speed: f64, rate: f64) -> f64 {
    if speed > 0.0 { rate * rate / speed } else { 0.0 }
}

fn place<'a>(mut names: impl Iterator<Item = &'a str>, name: &str) -> Option<u16> {
    names
        .position(|other| other.eq_ignore_ascii_case(name))
        .and_then(|place| u16::try_from(place).ok())
}

/// The first three of what each axis of a coordinate system has: those of its primary axes, or of an arm's joints.
pub(crate) fn three<T: Copy>(of: &[T; MAX_SYSTEM_AXES]) -> [T; MAX_PRIMARY_AXES] {
    [of[0], of[1], of[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_ignore_case() {
        let machine = Machine {
            period_ns: 1_000_000,
            group: "Motion".into(),
            axes: vec![],
            systems: vec![],
            transforms: vec![Transform {
                name: "T1".into(),
                source: SystemId(0),
                target: SystemId(1),
            }],
        };
        assert_eq!(machine.transform("t1"), Some(0));
        assert_eq!(machine.transform("t2"), None);
        assert!(machine.is_group("MOTION"));
        assert_eq!(machine.period(), 0.001);
    }

    #[test]
    fn absent_jerk_is_full_time() {
        // The value seen in exported projects (spec/axis-and-data-types.md §9.2).
        assert!((default_jerk(92.083336, 894.4814) - 8688.8).abs() < 0.1);
        assert_eq!(default_jerk(0.0, 1.0), 0.0);
    }
}

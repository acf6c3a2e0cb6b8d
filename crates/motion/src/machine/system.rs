//! The configuration of one coordinate system. Units: position units (u), seconds.

use arcline_instruction_set::AxisId;

use arcline_contour::Deviation;
use arcline_kinematics::{Geometry, Parameters, Wrist};
use arcline_planner::profile::DynamicsBits;

use super::limits::{MAX_PRIMARY_AXES, default_jerk};

/// One coordinate system (spec/axis-and-data-types.md §9.6). The maxima apply along the path.
#[derive(Clone, PartialEq, Debug)]
pub struct CoordinateSystem {
    /// Name, the coordinate system's tag.
    pub name: String,
    /// Its axes in order, each once: 1 to [`MAX_PRIMARY_AXES`], or the number that `orientation` or a wrist in `robot` requires. See
    /// [`CoordinateSystem::linear`].
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
    /// Pending moves behind the active one, 1 to [`MAX_QUEUE_DEPTH`](super::MAX_QUEUE_DEPTH).
    pub queue_depth: usize,
    /// The shape of corners with termination types 2, 3 and 6.
    pub corner: Corner,
    /// The permitted side of the deviation of planned contours from the programmed path within the tolerance.
    pub deviation: Deviation,
    /// The axes' own limits lower the path speed, or do not.
    pub axis_limits: LimitPolicy,
    /// The limits of the joints of robots that a transform moves lower the path speed, or do not.
    pub joint_limits: LimitPolicy,
    /// The robot whose joints are the axes of the system; `None`: it is Cartesian.
    pub robot: Option<Robot>,
    /// Its axes are X, Y, Z, Rx, Ry, Rz, the last three in degrees: Coordinate Definition XYZRxRyRz. Never of a robot.
    pub orientation: Option<Orientation>,
}

impl CoordinateSystem {
    /// Its moves are planned as contours, outside the tick.
    pub fn plans_contours(&self) -> bool {
        self.corner == Corner::Precise || self.axis_limits == LimitPolicy::Enforce
    }

    /// A Cartesian coordinate system with these maxima along the path, in units/s and units/s², and the defaults of a configuration
    /// otherwise.
    pub fn new(name: &str, axes: &[AxisId], max_speed: f64, max_acceleration: f64) -> Self {
        let jerk = default_jerk(max_speed, max_acceleration);
        CoordinateSystem {
            name: name.to_owned(),
            axes: axes.to_vec(),
            max_speed,
            max_acceleration,
            max_deceleration: max_acceleration,
            max_acceleration_jerk: jerk,
            max_deceleration_jerk: jerk,
            dynamics_bits: DynamicsBits::ALL,
            actual_tolerance: 0.0,
            command_tolerance: 0.0,
            queue_depth: 1,
            corner: Corner::default(),
            deviation: Deviation::default(),
            axis_limits: LimitPolicy::default(),
            joint_limits: LimitPolicy::default(),
            robot: None,
            orientation: None,
        }
    }

    /// The axes that coordinated moves interpolate as a vector: at most [`MAX_PRIMARY_AXES`], the first ones. Real-time.
    pub fn linear(&self) -> &[AxisId] {
        &self.axes[..self.axes.len().min(MAX_PRIMARY_AXES)]
    }

    /// The other axes: Rx, Ry, Rz, or the joints J4 to J6; often none. Real-time.
    pub fn oriented(&self) -> &[AxisId] {
        &self.axes[self.axes.len().min(MAX_PRIMARY_AXES)..]
    }
}

/// Maxima of the rotation of a Cartesian coordinate system with orientation (spec/axis-and-data-types.md §9.6), each above 0.
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

/// A robot as configured: MCT refuses invalid parameters (ERR 61).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Robot {
    /// Its kinematic structure; it has as many joints as the coordinate system has axes.
    pub structure: KinematicStructure,
    /// Its lengths and offsets.
    pub parameters: Parameters,
}

/// The kinematic structure of a robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum KinematicStructure {
    /// An arm, which MCT links.
    Arm(Geometry),
    /// An arm with a wrist, which MCTO links.
    Wrist(Wrist),
}

impl KinematicStructure {
    /// The number of joints.
    pub fn joints(self) -> usize {
        match self {
            KinematicStructure::Arm(geometry) => geometry.joints(),
            KinematicStructure::Wrist(wrist) => wrist.joints(),
        }
    }
}

/// The shape of corners with termination types 2, 3 and 6.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Corner {
    /// The two moves are superposed, as Logix does it.
    #[default]
    Logix,
    /// Rounded within the tolerance at the highest speed that the limits allow.
    Precise,
}

/// The treatment of the own limits of axes and joints by coordinated moves.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum LimitPolicy {
    /// They have no effect, as in Logix: only the limits along the path apply.
    #[default]
    Ignore,
    /// The path speed is lowered so that no axis or joint exceeds its speed, acceleration or jerk.
    Enforce,
}

//! The state of an axis and of a coordinate system at one tick, for publication.

use arcline_instruction_set::FaultSet;
use arcline_planner::ContourRests;

use crate::machine::MAX_SYSTEM_AXES;

/// One axis: the words of its tag (spec/axis-and-data-types.md §8.4) and its motion variables.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisSnapshot {
    /// AxisFault.
    pub fault: u32,
    /// AxisStatus.
    pub status: u32,
    /// AxisEvent.
    pub event: u32,
    /// MotionStatus.
    pub motion_status: u32,
    /// MotionFaultStatus and MotionAlarmStatus.
    pub motion_faults: [u32; 2],
    /// CIPAxisFaults and CIPAxisAlarms.
    pub cip_faults: [u64; 2],
    /// Faults since the last reset, as in the words above.
    pub faults: FaultSet,
    /// Commands beyond the axis's command limits that did not go out since the start of the machine.
    pub refused_commands: u32,
    /// The offset by which positions were shifted without motion since the start of the machine.
    pub redefined: f64,
    /// CIPAxisState.
    pub cip_state: i16,
    /// CIPAxisStatus.
    pub cip_status: u32,
    /// CIPAxisIOStatus.
    pub cip_io: u32,
    /// CommandPosition, CommandVelocity, CommandAcceleration.
    pub command: [f64; 3],
    /// ActualPosition, ActualVelocity, ActualAcceleration.
    pub actual: [f64; 3],
    /// AverageVelocity.
    pub average_velocity: f64,
    /// PositionError.
    pub position_error: f64,
    /// StartCommandPosition, StartActualPosition.
    pub started_at: [f64; 2],
    /// StrobeCommandPosition, StrobeActualPosition.
    pub strobed: [f64; 2],
    /// MasterOffset, StartMasterOffset, StrobeMasterOffset.
    pub master_offset: [f64; 3],
    /// OutputCamStatus, OutputCamPendingStatus, OutputCamLockStatus and OutputCamTransitionStatus.
    pub output_cams: [u32; 4],
    /// Bits that the output cams have set, of all targets together.
    pub outputs: u32,
    /// WatchPosition.
    pub watched: f64,
    /// Positions of each registration input: at the last event, the last positive edge, and the last negative edge.
    pub registered: [[f64; 3]; 2],
    /// The times of the same events, µs since the first tick.
    pub registered_at: [[i32; 3]; 2],
}

/// One coordinate system: the words of its tag (spec/axis-and-data-types.md §8.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SystemSnapshot {
    /// CoordinateSystemStatus.
    pub status: u32,
    /// CoordinateMotionStatus.
    pub motion_status: u32,
    /// AxisFault.
    pub fault: u32,
    /// PhysicalAxesFaulted.
    pub axes_faulted: u32,
    /// AxesShutdownStatus.
    pub axes_shutdown: u32,
    /// AxesServoOnStatus.
    pub axes_servo_on: u32,
    /// ActualPosition of each axis.
    pub actual: [f64; MAX_SYSTEM_AXES],
    /// ActiveToolFrameID and ActiveWorkFrameID.
    pub frames: [i32; 2],
    /// TurnsCounters.
    pub turns: [i16; 4],
    /// RobotConfiguration.
    pub configuration: i32,
    /// The position of a robot's tool by the actual positions of its joints, in the frame of its base, position units: the tool centre
    /// with the tool frame of an active MCTO, otherwise the end of the arm. NaN if the joints are in no possible position.
    pub tool: Option<[f64; 3]>,
    /// Vector speed of all coordinated motion of X, Y and Z, units/s: of both moves of a blend, of a residual that ramps out beside a merged
    /// move, and of axes that brake separately in a stop. Jogs and moves of single axes do not count. While a move only rotates the tool:
    /// degrees/s.
    pub path_speed: f64,
    /// Distance covered on the active move, units: along its path or, in a planned contour, along the planned curve.
    pub path_position: f64,
    /// Length of that path or curve, units; 0 without an active move.
    pub path_length: f64,
    /// Seconds until the end of the active move, or until its successor becomes active, as planned now; `None` if the time is unknown:
    /// no move is active, it is held or stopped, or it is master driven.
    pub time_left: Option<f64>,
    /// Share of the programmed speeds, 0 to 2.
    pub feed_override: f64,
    /// The number of further moves that its queue has room for.
    pub queue_room: u32,
    /// Rests of planned contours between moves that should follow without a rest, since the start.
    pub contour_rests: ContourRests,
}

impl Default for SystemSnapshot {
    /// At rest at 0, with an override of 1.
    fn default() -> Self {
        SystemSnapshot {
            status: 0,
            motion_status: 0,
            fault: 0,
            axes_faulted: 0,
            axes_shutdown: 0,
            axes_servo_on: 0,
            actual: [0.0; MAX_SYSTEM_AXES],
            frames: [0; 2],
            turns: [0; 4],
            configuration: 0,
            tool: None,
            path_speed: 0.0,
            path_position: 0.0,
            path_length: 0.0,
            time_left: None,
            feed_override: 1.0,
            queue_room: 0,
            contour_rests: ContourRests::default(),
        }
    }
}

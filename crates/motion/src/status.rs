//! Status words, from the state at a tick.

use arcline_drive::Saturation;
use arcline_instruction_set::predefined::{
    axis_status, cip_axis_status, coordinate_motion_status as motion, coordinate_system_status as status, motion_status,
};
use arcline_planner::profile::Phase;

use crate::axis::{Axis, AxisState, Source};
use crate::snapshot::{AxisSnapshot, SystemSnapshot};
use crate::system::{Activity, System};

/// A following error below this, units, shows as position lock (Position Lock Tolerance's default).
const POSITION_LOCK_TOLERANCE: f64 = 0.01;
/// An actual speed below this, units/s, shows as standstill.
const STANDSTILL: f64 = 1e-3;

/// One axis as its tag shows it.
pub(crate) fn axis(axis: &Axis) -> AxisSnapshot {
    let actual = axis.drive.actual();
    let saturation = axis.drive.saturation();
    let command = axis.command;
    AxisSnapshot {
        fault: 0,
        status: axis_word(axis),
        motion_status: motion_word(axis),
        cip_state: match axis.state {
            AxisState::Stopped => 2,
            AxisState::Starting => 3,
            AxisState::Running => 4,
            AxisState::Stopping => 6,
            AxisState::Shutdown => 10,
        },
        cip_status: [
            (
                axis.state == AxisState::Running,
                cip_axis_status::POWER_STRUCTURE_ENABLED_STATUS,
            ),
            (
                axis.state == AxisState::Running,
                cip_axis_status::TRACKING_COMMAND_STATUS,
            ),
            (
                axis.drive.error().abs() <= POSITION_LOCK_TOLERANCE,
                cip_axis_status::POSITION_LOCK_STATUS,
            ),
            (
                actual.velocity.abs() <= STANDSTILL,
                cip_axis_status::VELOCITY_STANDSTILL_STATUS,
            ),
            (saturation == Saturation::Speed, cip_axis_status::VELOCITY_LIMIT_STATUS),
            (saturation == Saturation::Torque, cip_axis_status::TORQUE_LIMIT_STATUS),
            (axis.state == AxisState::Shutdown, cip_axis_status::CIP_SHUTDOWN_STATUS),
        ]
        .into_iter()
        .fold(0, with),
        command: [axis.shown(command.position), command.velocity, command.acceleration],
        actual: [axis.shown(actual.position), actual.velocity, actual.acceleration],
        position_error: axis.drive.error(),
        started_at: axis.started_at.map(|position| axis.shown(position)),
    }
}

fn axis_word(axis: &Axis) -> u32 {
    let on = axis.state == AxisState::Running;
    [
        (on, axis_status::SERVO_ACTION_STATUS),
        (on, axis_status::DRIVE_ENABLE_STATUS),
        (axis.state == AxisState::Shutdown, axis_status::SHUTDOWN_STATUS),
        (true, axis_status::AXIS_UPDATE_STATUS),
    ]
    .into_iter()
    .fold(0, with)
}

fn motion_word(axis: &Axis) -> u32 {
    let rising = axis.command.velocity * axis.command.acceleration;
    let from_rest = axis.command.velocity == 0.0 && axis.command.acceleration != 0.0;
    let braking = matches!(axis.source, Source::Braking { .. });
    [
        (rising > 0.0 || from_rest, motion_status::ACCEL_STATUS),
        (rising < 0.0, motion_status::DECEL_STATUS),
        (braking, motion_status::STOPPING_STATUS),
        (axis.homed, motion_status::AXIS_HOMED_STATUS),
        (
            matches!(axis.source, Source::System),
            motion_status::COORDINATED_MOTION_STATUS,
        ),
        (
            axis.command.velocity.abs() > axis.dynamics.speed,
            motion_status::MAXIMUM_SPEED_EXCEEDED,
        ),
    ]
    .into_iter()
    .fold(0, with)
}

/// One coordinate system as its tag shows it.
pub(crate) fn system(system: &System, axes: &[Axis]) -> SystemSnapshot {
    let mut shown = SystemSnapshot {
        path_speed: system.along[0],
        path_position: system.along[1],
        path_length: system.along[2],
        feed_override: system.feed_override,
        ..SystemSnapshot::default()
    };
    for (place, axis) in system.description.axes.iter().enumerate() {
        let Some(axis) = axes.get(usize::from(*axis)) else {
            continue;
        };
        shown.axes_shutdown |= u32::from(axis.state == AxisState::Shutdown) << place;
        shown.axes_servo_on |= u32::from(axis.state == AxisState::Running) << place;
        if let Some(actual) = shown.actual.get_mut(place) {
            *actual = axis.shown(axis.drive.actual().position);
        }
    }
    let moving = system.activity == Activity::Moving;
    let on_path = moving && !system.in_transition;
    let pending = system.has_pending();
    shown.status = [
        (system.shutdown, status::SHUTDOWN_STATUS),
        (shown.axes_shutdown == 0, status::READY_STATUS),
        (system.is_busy(), status::MOTION_STATUS),
    ]
    .into_iter()
    .fold(0, with);
    shown.motion_status = [
        (
            on_path && system.shown_phase == Phase::Accelerating,
            motion::ACCEL_STATUS,
        ),
        (
            system.stop.is_some() || (on_path && system.shown_phase == Phase::Decelerating),
            motion::DECEL_STATUS,
        ),
        (system.in_actual_tolerance, motion::ACTUAL_POS_TOLERANCE_STATUS),
        (system.in_command_tolerance, motion::COMMAND_POS_TOLERANCE_STATUS),
        (system.stop.is_some(), motion::STOPPING_STATUS),
        (moving, motion::MOVE_STATUS),
        (moving && system.in_transition, motion::MOVE_TRANSITION_STATUS),
        (pending, motion::MOVE_PENDING_STATUS),
        (pending && system.is_full(), motion::MOVE_PENDING_QUEUE_FULL_STATUS),
    ]
    .into_iter()
    .fold(0, with);
    shown
}

fn with(word: u32, (set, bit): (bool, u32)) -> u32 {
    if set { word | bit } else { word }
}

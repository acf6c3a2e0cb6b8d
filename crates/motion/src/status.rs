//! Status words, from the state at a tick.

use arcline_drive::Saturation;
use arcline_instruction_set::FaultWord;
use arcline_instruction_set::predefined::{
    axis_event, axis_fault, axis_status, cip_axis_io_status, cip_axis_status, coordinate_motion_status as motion,
    coordinate_system_status as status, motion_status,
};
use arcline_planner::Clock;
use arcline_planner::profile::Phase;

use crate::axes::Axes;
use crate::axis::Axis;
use crate::axis::generator_kind::GeneratorKind;
use crate::axis::state::AxisState;
use crate::masters::cam::Cam;
use crate::snapshot::{AxisSnapshot, SystemSnapshot};
use crate::system::{Activity, System};
use crate::tolerance::{POSITION_LOCK_UNITS, STANDSTILL_UNITS_PER_S};
use crate::transforms::shown::Role;

/// The state of one axis in the members of its tag.
pub(crate) fn axis(axis: &Axis, clock: &Clock) -> AxisSnapshot {
    let actual = axis.actual;
    let [first, second] = &axis.registrations;
    let (saturation, inputs) = (axis.link.feedback.saturation, axis.link.feedback.inputs);
    let command = axis.command;
    let offset = &axis.cams(GeneratorKind::PositionCam).offset;
    AxisSnapshot {
        fault: axis.faults.axis_fault(axis.is_virtual),
        motion_faults: [
            axis.faults.word(FaultWord::Motion) as u32,
            axis.faults.alarms(FaultWord::Motion) as u32,
        ],
        cip_faults: [axis.faults.word(FaultWord::Cip), axis.faults.alarms(FaultWord::Cip)],
        faults: axis.faults.latched(),
        refused_commands: axis.faults.refusals(),
        redefined: axis.redefined,
        status: axis_word(axis),
        event: [
            (axis.awaits_home_event(), axis_event::HOME_EVENT_ARMED_STATUS),
            (axis.home_event, axis_event::HOME_EVENT_STATUS),
            (axis.watch.is_armed(), axis_event::WATCH_EVENT_ARMED_STATUS),
            (axis.watch.seen, axis_event::WATCH_EVENT_STATUS),
            (first.is_armed(), axis_event::REG_EVENT1_ARMED_STATUS),
            (first.seen, axis_event::REG_EVENT1_STATUS),
            (second.is_armed(), axis_event::REG_EVENT2_ARMED_STATUS),
            (second.seen, axis_event::REG_EVENT2_STATUS),
        ]
        .into_iter()
        .fold(0, with),
        motion_status: motion_word(axis, clock),
        cip_state: match axis.state {
            AxisState::Stopped => 2,
            AxisState::Starting => 3,
            AxisState::Running => 4,
            AxisState::Stopping => 6,
            AxisState::Aborting => 7,
            AxisState::Faulted => 8,
            AxisState::Shutdown => 10,
        },
        cip_status: [
            (axis.faults.alarms(FaultWord::Cip) != 0, cip_axis_status::ALARM_STATUS),
            (
                matches!(axis.state, AxisState::Running | AxisState::Aborting),
                cip_axis_status::POWER_STRUCTURE_ENABLED_STATUS,
            ),
            (
                axis.state == AxisState::Running,
                cip_axis_status::TRACKING_COMMAND_STATUS,
            ),
            (
                axis.position_error().abs() <= POSITION_LOCK_UNITS,
                cip_axis_status::POSITION_LOCK_STATUS,
            ),
            (
                actual.velocity.abs() <= STANDSTILL_UNITS_PER_S,
                cip_axis_status::VELOCITY_STANDSTILL_STATUS,
            ),
            (saturation == Saturation::Speed, cip_axis_status::VELOCITY_LIMIT_STATUS),
            (saturation == Saturation::Torque, cip_axis_status::TORQUE_LIMIT_STATUS),
            (axis.state == AxisState::Shutdown, cip_axis_status::CIP_SHUTDOWN_STATUS),
        ]
        .into_iter()
        .fold(0, with),
        cip_io: [
            (inputs.home, cip_axis_io_status::HOME_INPUT_STATUS),
            (inputs.registration[0], cip_axis_io_status::REGISTRATION1_INPUT_STATUS),
            (inputs.registration[1], cip_axis_io_status::REGISTRATION2_INPUT_STATUS),
        ]
        .into_iter()
        .fold(0, with),
        command: [axis.shown(command.position), command.velocity, command.acceleration],
        actual: [axis.shown(actual.position), actual.velocity, actual.acceleration],
        average_velocity: axis.average.velocity(),
        position_error: axis.position_error(),
        started_at: axis.started_at.map(|position| axis.shown(position)),
        strobed: axis.strobed,
        master_offset: [axis.master_offset().position, offset.start, offset.strobed],
        output_cams: axis.outputs.status(),
        outputs: axis.outputs.bits(),
        watched: axis.watch.position,
        registered: [first.positions, second.positions],
        registered_at: [first.times, second.times],
    }
}

fn axis_word(axis: &Axis) -> u32 {
    let on = axis.state == AxisState::Running;
    [
        (on, axis_status::SERVO_ACTION_STATUS),
        (
            on || axis.state == AxisState::Aborting,
            axis_status::DRIVE_ENABLE_STATUS,
        ),
        (axis.state == AxisState::Shutdown, axis_status::SHUTDOWN_STATUS),
        (true, axis_status::AXIS_UPDATE_STATUS),
    ]
    .into_iter()
    .fold(0, with)
}

fn motion_word(axis: &Axis, clock: &Clock) -> u32 {
    let phase = phase(axis);
    let runs = |kind| axis.sum.get(kind).is_some_and(|generator| !generator.stopping);
    let locked = |kind| {
        let generator = axis.sum.get(kind);
        generator.is_some_and(|generator| generator.follower.is_some_and(|follower| follower.follows()))
    };
    let pends = |kind| axis.cams(kind).pending.is_some();
    let cam_locked = |kind| axis.cam(kind).is_some_and(Cam::follows);
    let braking = axis
        .sum
        .active()
        .any(|(_, generator)| generator.stopping || generator.ending);
    [
        (phase == Phase::Accelerating, motion_status::ACCEL_STATUS),
        (phase == Phase::Decelerating, motion_status::DECEL_STATUS),
        (braking, motion_status::STOPPING_STATUS),
        (axis.homed, motion_status::AXIS_HOMED_STATUS),
        (runs(GeneratorKind::Move), motion_status::MOVE_STATUS),
        (runs(GeneratorKind::Jog), motion_status::JOG_STATUS),
        (runs(GeneratorKind::Gear), motion_status::GEARING_STATUS),
        (axis.homing().is_some(), motion_status::HOMING_STATUS),
        (
            axis.gear().is_some_and(|gear| gear.is_locked(clock)),
            motion_status::GEARING_LOCK_STATUS,
        ),
        (locked(GeneratorKind::Move), motion_status::MOVE_LOCK_STATUS),
        (locked(GeneratorKind::Jog), motion_status::JOG_LOCK_STATUS),
        (
            runs(GeneratorKind::MasterOffset),
            motion_status::MASTER_OFFSET_MOVE_STATUS,
        ),
        (
            locked(GeneratorKind::MasterOffset),
            motion_status::MASTER_OFFSET_MOVE_LOCK_STATUS,
        ),
        (runs(GeneratorKind::PositionCam), motion_status::POSITION_CAM_STATUS),
        (runs(GeneratorKind::TimeCam), motion_status::TIME_CAM_STATUS),
        (
            pends(GeneratorKind::PositionCam),
            motion_status::POSITION_CAM_PENDING_STATUS,
        ),
        (pends(GeneratorKind::TimeCam), motion_status::TIME_CAM_PENDING_STATUS),
        (
            cam_locked(GeneratorKind::PositionCam),
            motion_status::POSITION_CAM_LOCK_STATUS,
        ),
        (cam_locked(GeneratorKind::TimeCam), motion_status::TIME_CAM_LOCK_STATUS),
        (axis.is_transformed(), motion_status::TRANSFORM_STATE_STATUS),
        (
            axis.transforms.controlled,
            motion_status::CONTROLLED_BY_TRANSFORM_STATUS,
        ),
        (axis.has_coordinated_motion(), motion_status::COORDINATED_MOTION_STATUS),
        (
            axis.command.velocity.abs() > axis.dynamics.speed,
            motion_status::MAXIMUM_SPEED_EXCEEDED,
        ),
    ]
    .into_iter()
    .fold(0, with)
}

/// The phase of the speed of an axis: by its profile if it has one, otherwise by its command.
fn phase(axis: &Axis) -> Phase {
    let mut active = axis.sum.active();
    if let (Some((_, only)), None) = (active.next(), active.next())
        && only.is_planned()
    {
        return only.shown_phase;
    }
    axis.command.phase()
}

/// Vector speed of coordinated motion, units/s, including the axes that brake separately.
fn path_speed(system: &System, axes: &Axes) -> f64 {
    let Some(stop) = system.stop.filter(|_| !system.is_busy()) else {
        return system.shown.speed;
    };
    let braking = system
        .description
        .linear()
        .iter()
        .filter(|axis| stop.braking.contains(**axis));
    let squares = braking.filter_map(|axis| axes.get(*axis)).map(|axis| {
        let parts = [GeneratorKind::System, GeneratorKind::Stop]
            .map(|kind| axis.sum.get(kind).map_or(0.0, |part| part.now.velocity));
        (parts[0] + parts[1]).powi(2)
    });
    squares.sum::<f64>().sqrt()
}

/// The state of one coordinate system in the members of its tag.
pub(crate) fn system(system: &System, axes: &Axes, role: Role) -> SystemSnapshot {
    let mut shown = SystemSnapshot {
        path_speed: path_speed(system, axes),
        path_position: system.shown.distance,
        path_length: system.shown.length,
        feed_override: system.travel.rate(),
        queue_room: u32::try_from(system.room()).unwrap_or(u32::MAX),
        contour_rests: system.travel.contour_rests(),
        frames: role.robot.frames,
        turns: {
            let [j1, j4, j6] = role.robot.solution.1;
            [j1, j4, j6, 0]
        },
        configuration: role.robot.solution.0.bits(),
        ..SystemSnapshot::default()
    };
    for (member, axis) in system.description.axes.iter().enumerate() {
        let Some(axis) = axes.get(*axis) else {
            continue;
        };
        let faulted = axis.faults.axis_fault(axis.is_virtual) != 0;
        shown.axes_faulted |= u32::from(faulted) << member;
        shown.axes_shutdown |= u32::from(axis.state == AxisState::Shutdown) << member;
        shown.axes_servo_on |= u32::from(axis.state == AxisState::Running) << member;
        if let Some(actual) = shown.actual.get_mut(member) {
            *actual = axis.shown(axis.actual.position);
        }
    }
    if shown.axes_faulted != 0 {
        shown.fault = axis_fault::PHYSICAL_AXIS_FAULT;
    }
    shown.tool = system.tool(&shown.actual, &role.robot.tool);
    let moving = system.activity == Activity::Moving;
    let brakes = system.brakes(axes);
    let on_path = moving && !system.shown.in_transition;
    let pending = system.travel.waiting().next().is_some();
    shown.status = [
        (system.shutdown, status::SHUTDOWN_STATUS),
        (shown.axes_shutdown | shown.axes_faulted == 0, status::READY_STATUS),
        (system.is_busy() || brakes, status::MOTION_STATUS),
    ]
    .into_iter()
    .fold(0, with);
    shown.motion_status = [
        (
            on_path && system.shown.trend == Phase::Accelerating,
            motion::ACCEL_STATUS,
        ),
        (
            system.stop.is_some() || brakes || (on_path && system.shown.trend == Phase::Decelerating),
            motion::DECEL_STATUS,
        ),
        (system.shown.in_actual_tolerance, motion::ACTUAL_POS_TOLERANCE_STATUS),
        (system.shown.in_command_tolerance, motion::COMMAND_POS_TOLERANCE_STATUS),
        (system.stop.is_some(), motion::STOPPING_STATUS),
        (moving && system.shown.has_moved, motion::MOVE_STATUS),
        (moving && system.shown.in_transition, motion::MOVE_TRANSITION_STATUS),
        (pending, motion::MOVE_PENDING_STATUS),
        (
            pending && system.travel.is_full(),
            motion::MOVE_PENDING_QUEUE_FULL_STATUS,
        ),
        (role.robot.tool_change, motion::TOOL_CHANGE_ALLOWED_STATUS),
        (role.source, motion::TRANSFORM_SOURCE_STATUS),
        (role.target, motion::TRANSFORM_TARGET_STATUS),
        (
            moving && system.follower.is_some_and(|follower| follower.follows()),
            motion::COORDINATE_SYSTEM_LOCK_STATUS,
        ),
    ]
    .into_iter()
    .fold(0, with);
    shown
}

fn with(word: u32, (set, bit): (bool, u32)) -> u32 {
    if set { word | bit } else { word }
}

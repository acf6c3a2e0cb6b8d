//! An `[[axis]]` table.

use arcline_controller::machine::{
    Axis, AxisKind, CommandLimits, ExceptionActions, PositionErrorLimit, Sensor, Settings, SimulatedDrive, StartState,
    Travel,
};
use arcline_instruction_set::{FAULTS, FaultKind, FaultSet};

use super::dynamics::Dynamics;
use super::home::{home, marker, switch};
use super::inputs::inputs;
use super::names::Taken;
use crate::section::Section;
use crate::words;

/// The axis, and the drive of a servo.
pub(super) fn axis(section: &Section<'_>, names: &mut Taken) -> (Axis, Option<SimulatedDrive>) {
    let name = names.take_name(section, "name");
    let kind = section.one_of("type", words::AXIS_KINDS);
    let (servo, feedback) = (kind == AxisKind::Servo, kind == AxisKind::Feedback);
    let dynamics = Dynamics::read(section);
    let unwind = section.number("unwind");
    let travel = travel(section);
    if travel.is_some() && unwind.is_some() {
        section.conflict("travel", "unwind", "a rotary axis has no soft limits");
    }
    let mut home = home(section, &dynamics, unwind, servo);
    if section.has("drive") && !servo {
        section.conflict("drive", "type = \"virtual\"", "only a servo has a drive");
    }
    let drive = servo.then(|| SimulatedDrive {
        settings: settings(section),
        sensor: sensor(section, travel, unwind),
    });
    home.inputs = drive.map(|drive| drive.home_inputs()).unwrap_or_default();
    let axis = Axis {
        name,
        kind,
        units: section.text_or_default("units"),
        max_speed: dynamics.speed,
        max_acceleration: dynamics.acceleration,
        max_deceleration: dynamics.deceleration,
        max_acceleration_jerk: dynamics.acceleration_jerk,
        max_deceleration_jerk: dynamics.deceleration_jerk,
        dynamics_bits: dynamics.bits,
        travel,
        unwind,
        start: start(section, unwind),
        home,
        programmed_stop_mode: section.one_of("programmed_stop_mode", words::STOP_MODES),
        exception_actions: exception_actions(section, servo || feedback),
        average_velocity_timebase: section.required("average_velocity_timebase"),
        command_limits: command_limits(section, CommandLimits::of_kind(&kind)),
        position_error: if servo {
            position_error(section)
        } else {
            PositionErrorLimit::OFF
        },
        output_cam_targets: section.whole("output_cam_execution_targets"),
        inputs: inputs(section, feedback),
    };
    (axis, drive)
}

fn travel(axis: &Section<'_>) -> Option<Travel> {
    let (section, present) = axis.table("travel");
    let (min, max) = (section.number("min")?, section.number("max")?);
    if min >= max {
        section.refuse_value("max", "a number above `min`");
    }
    present.then_some(Travel { min, max })
}

fn settings(axis: &Section<'_>) -> Settings {
    let (section, _) = axis.table("drive");
    Settings {
        bandwidth: section.required("position_bandwidth_hz"),
        feedforward: section.required("velocity_feedforward"),
        speed_limit: section.number("speed_limit").unwrap_or(f64::INFINITY),
        torque_limit: section.number("torque_limit").unwrap_or(f64::INFINITY),
        encoder_resolution: section.number("encoder_resolution"),
    }
}

fn position_error(axis: &Section<'_>) -> PositionErrorLimit {
    let (section, _) = axis.table("drive");
    PositionErrorLimit {
        tolerance: section.required("position_error_tolerance"),
        time: section.required("position_error_tolerance_time"),
    }
}

/// The travel limits are where the mechanical stops are.
fn sensor(axis: &Section<'_>, travel: Option<Travel>, turn: Option<f64>) -> Sensor {
    let (home, _) = axis.table("home");
    Sensor {
        switch: switch(&home, turn),
        marker: marker(&home, turn),
        stops: travel.map(|Travel { min, max }| [min, max]),
        turn,
    }
}

/// A key for each kind of fault of the catalogue.
fn exception_actions(axis: &Section<'_>, servo: bool) -> ExceptionActions {
    let (section, _) = axis.table("exception_actions");
    let possible = FaultSet::possible(servo);
    let mut actions = ExceptionActions::default();
    for fault in &FAULTS {
        let action = section.one_of(fault.word, words::ACTIONS);
        if section.has(fault.word) && !possible.contains(fault.kind) {
            section.conflict(fault.word, "type = \"virtual\"", "only a servo has faults of a drive");
        } else if fault.kind == FaultKind::CommandLimit && !action.stops() {
            let reason = "the axis has stopped: \"stop_planner\", \"stop_drive\" or \"shutdown\"";
            section.conflict(fault.word, "a command that did not go out", reason);
        }
        actions = actions.with(fault.kind, action);
    }
    actions
}

fn command_limits(axis: &Section<'_>, default: CommandLimits) -> CommandLimits {
    let (section, _) = axis.table("command_limits");
    CommandLimits {
        enabled: section.boolean("enabled").unwrap_or(default.enabled),
        speed: section.required("speed"),
        acceleration: section.required("acceleration"),
    }
}

fn start(axis: &Section<'_>, unwind: Option<f64>) -> StartState {
    let (section, _) = axis.table("start");
    let position = section.required("position");
    if unwind.is_some_and(|turn| !(0.0..turn).contains(&position)) {
        section.refuse_value("position", "a number from 0 to below `unwind`");
    }
    StartState {
        position,
        servo_on: section.flag("servo_on"),
        homed: section.flag("homed"),
        ..StartState::default()
    }
}

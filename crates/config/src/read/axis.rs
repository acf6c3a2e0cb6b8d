//! An `[[axis]]` table.

use arcline_controller::machine::{
    Axis, AxisKind, CommandLimits, Drive, ExceptionActions, MAX_OUTPUT_TARGETS, ProgrammedStopMode, Start, Travel,
};
use arcline_instruction_set::{ExceptionAction, FAULTS, FaultKind, FaultSet};

use super::NOT_NEGATIVE_LENGTH;
use super::dynamics::{Dynamics, POSITIVE_RATE, POSITIVE_SPEED};
use super::home::home;
use super::inputs::inputs;
use super::names::{Taken, required_name};
use crate::error::{ConfigError, Problem};
use crate::section::{NumberRule, Section};

pub(super) fn axis(section: &Section<'_>, names: &mut Taken) -> Result<Axis, ConfigError> {
    let name = required_name(section, "name", names)?;
    let (servo, feedback) = match section.word("type", &["servo", "virtual", "feedback"], AXIS_TYPE)? {
        Some(place) => (place == 0, place == 2),
        None => return Err(section.missing("type", AXIS_TYPE)),
    };
    let units = match section.string("units", UNITS)? {
        Some(units) if units.value.len() <= MAX_UNITS && !units.value.chars().any(char::is_control) => units.value,
        Some(units) => return Err(section.refuse(&units, UNITS, None)),
        None => "Position Units".to_owned(),
    };
    let dynamics = Dynamics::read(section)?;
    let unwind = section.number("unwind", &POSITIVE_LENGTH)?;
    let travel = travel(section)?;
    if travel.is_some() && unwind.is_some() {
        let problem = Problem::Conflict {
            other: "unwind",
            reason: "a rotary axis has no soft limits",
        };
        return Err(section.refuse_key("travel", problem));
    }
    let mut home = home(section, &dynamics, unwind, servo)?;
    home.stops = travel.filter(|_| servo).map(|Travel { min, max }| [min, max]);
    let drive = drive(section)?;
    let kind = match (servo, drive) {
        (true, drive) => AxisKind::Servo(drive.unwrap_or_default()),
        (false, None) if feedback => AxisKind::Feedback,
        (false, None) => AxisKind::Virtual,
        (false, Some(_)) => {
            let problem = Problem::Conflict {
                other: "type = \"virtual\"",
                reason: "only a servo has a drive",
            };
            return Err(section.refuse_key("drive", problem));
        }
    };
    let command_limits = command_limits(section, CommandLimits::of_kind(&kind))?;
    Ok(Axis {
        name,
        kind,
        units,
        max_speed: dynamics.speed,
        max_acceleration: dynamics.acceleration,
        max_deceleration: dynamics.deceleration,
        max_acceleration_jerk: dynamics.acceleration_jerk,
        max_deceleration_jerk: dynamics.deceleration_jerk,
        dynamics_bits: dynamics.bits,
        travel,
        unwind,
        start: start(section, unwind)?,
        home,
        programmed_stop_mode: stop_mode(section)?,
        exception_actions: exception_actions(section, servo || feedback)?,
        average_velocity_timebase: section
            .number("average_velocity_timebase", &TIMEBASE)?
            .unwrap_or(AVERAGE_VELOCITY_TIMEBASE),
        command_limits,
        output_cam_targets: section
            .integer(OUTPUT_CAMS, 0..=MAX_OUTPUT_TARGETS, TARGETS)?
            .unwrap_or_default(),
        inputs: inputs(section, feedback)?,
    })
}

fn travel(axis: &Section<'_>) -> Result<Option<Travel>, ConfigError> {
    let (section, present) = axis.table("travel", TRAVEL, "{ min = NUMBER, max = NUMBER }")?;
    if !present {
        return Ok(None);
    }
    let min = section.required_number("min", &ANY)?;
    let max = section.required_number("max", &ANY)?;
    if min >= max {
        let problem = Problem::Value {
            found: section.found("max"),
            expected: "a number above `min`",
            suggestion: None,
        };
        return Err(section.refuse_key("max", problem));
    }
    Ok(Some(Travel { min, max }))
}

fn drive(axis: &Section<'_>) -> Result<Option<Drive>, ConfigError> {
    let (section, present) = axis.table("drive", DRIVE, "a table such as { position_bandwidth_hz = 40.0 }")?;
    let default = Drive::default();
    let bandwidth = section.number("position_bandwidth_hz", &BANDWIDTH)?;
    let feedforward = section.number("velocity_feedforward", &SHARE)?;
    let tolerance = section.number("position_error_tolerance", &NOT_NEGATIVE_LENGTH)?;
    let tolerance_time = section.number("position_error_tolerance_time", &NOT_NEGATIVE_TIME)?;
    let speed_limit = section.number("speed_limit", &POSITIVE_SPEED)?;
    let torque_limit = section.number("torque_limit", &POSITIVE_RATE)?;
    let encoder_resolution = section.number("encoder_resolution", &RESOLUTION)?;
    Ok(present.then(|| Drive {
        position_bandwidth_hz: bandwidth.unwrap_or(default.position_bandwidth_hz),
        velocity_feedforward: feedforward.unwrap_or(default.velocity_feedforward),
        position_error_tolerance: tolerance.unwrap_or(default.position_error_tolerance),
        position_error_tolerance_time: tolerance_time.unwrap_or(default.position_error_tolerance_time),
        speed_limit,
        torque_limit,
        encoder_resolution,
    }))
}

fn stop_mode(axis: &Section<'_>) -> Result<ProgrammedStopMode, ConfigError> {
    let words = ProgrammedStopMode::ALL.map(|(word, _)| word);
    let place = axis.word("programmed_stop_mode", &words, STOP_MODE)?;
    Ok(place.map_or_else(ProgrammedStopMode::default, |place| ProgrammedStopMode::ALL[place].1))
}

/// A key for each kind of fault of the catalogue.
fn exception_actions(axis: &Section<'_>, servo: bool) -> Result<ExceptionActions, ConfigError> {
    let (section, _) = axis.table("exception_actions", &EXCEPTION_ACTIONS, EXCEPTIONS)?;
    let words = ExceptionAction::ALL.map(|(word, _)| word);
    let possible = FaultSet::possible(servo);
    let mut actions = ExceptionActions::default();
    for fault in &FAULTS {
        let Some(place) = section.word(fault.word, &words, ACTION)? else {
            continue;
        };
        if !possible.contains(fault.kind) {
            let problem = Problem::Conflict {
                other: "type = \"virtual\"",
                reason: "only a servo has faults of a drive",
            };
            return Err(section.refuse_key(fault.word, problem));
        }
        let action = ExceptionAction::ALL[place].1;
        if fault.kind == FaultKind::CommandLimit && !action.stops() {
            let problem = Problem::Conflict {
                other: "a command that did not go out",
                reason: "the axis has stopped: \"stop_planner\", \"stop_drive\" or \"shutdown\"",
            };
            return Err(section.refuse_key(fault.word, problem));
        }
        actions = actions.with(fault.kind, action);
    }
    Ok(actions)
}

fn command_limits(axis: &Section<'_>, default: CommandLimits) -> Result<CommandLimits, ConfigError> {
    let (section, _) = axis.table(
        "command_limits",
        COMMAND_LIMITS,
        "a table such as { speed = 4.0, acceleration = 100.0 }",
    )?;
    Ok(CommandLimits {
        enabled: section.boolean("enabled")?.unwrap_or(default.enabled),
        speed: section.number("speed", &FACTOR)?.unwrap_or(default.speed),
        acceleration: section.number("acceleration", &FACTOR)?.unwrap_or(default.acceleration),
    })
}

fn start(axis: &Section<'_>, unwind: Option<f64>) -> Result<Start, ConfigError> {
    let (section, _) = axis.table("start", START, "a table such as { position = 0.0, servo_on = true }")?;
    let default = Start::default();
    let position = section.number("position", &ANY)?.unwrap_or(default.position);
    if unwind.is_some_and(|turn| !(0.0..turn).contains(&position)) {
        let problem = Problem::Value {
            found: section.found("position"),
            expected: "a number from 0 to below `unwind`",
            suggestion: None,
        };
        return Err(section.refuse_key("position", problem));
    }
    Ok(Start {
        position,
        servo_on: section.boolean("servo_on")?.unwrap_or(default.servo_on),
        homed: section.boolean("homed")?.unwrap_or(default.homed),
        ..default
    })
}

const OUTPUT_CAMS: &str = "output_cam_execution_targets";
const TARGETS: &str = "a whole number from 0 to 32";
/// Longest label, bytes.
const MAX_UNITS: usize = 40;

pub(super) const AXIS: &[&str] = &[
    "name",
    "type",
    "units",
    "max_speed",
    "max_acceleration",
    "max_deceleration",
    "max_acceleration_jerk",
    "max_deceleration_jerk",
    "dynamics_configuration_bits",
    "travel",
    "unwind",
    "start",
    "drive",
    "home",
    "programmed_stop_mode",
    "exception_actions",
    "average_velocity_timebase",
    "command_limits",
    OUTPUT_CAMS,
    "feed",
    "registration",
];
pub(super) const COMMAND_LIMITS: &[&str] = &["enabled", "speed", "acceleration"];
pub(super) const START: &[&str] = &["position", "servo_on", "homed"];
pub(super) const TRAVEL: &[&str] = &["min", "max"];
pub(super) const DRIVE: &[&str] = &[
    "position_bandwidth_hz",
    "velocity_feedforward",
    "position_error_tolerance",
    "position_error_tolerance_time",
    "speed_limit",
    "torque_limit",
    "encoder_resolution",
];
pub(super) static EXCEPTION_ACTIONS: [&str; FaultKind::COUNT] = {
    let mut words = [""; FaultKind::COUNT];
    let mut place = 0;
    while place < words.len() {
        words[place] = FAULTS[place].word;
        place += 1;
    }
    words
};
const UNITS: &str = "a label of up to 40 bytes such as \"mm\"";
const STOP_MODE: &str = "\"fast_stop\", \"fast_disable\", \"hard_disable\", \"fast_shutdown\" or \"hard_shutdown\"";
const EXCEPTIONS: &str = "a table such as { position_error = \"stop_drive\" }";
const ACTION: &str = "\"ignore\", \"alarm\", \"fault_status_only\", \"stop_planner\", \"stop_drive\" or \"shutdown\"";
const AXIS_TYPE: &str = "\"servo\", \"virtual\" or \"feedback\"";

pub(super) const POSITIVE_LENGTH: NumberRule = NumberRule {
    expected: "a number above 0 (position units)",
    holds: |x| x > 0.0,
};
const BANDWIDTH: NumberRule = NumberRule {
    expected: "a number above 0, at most 10000 (Hz)",
    holds: |x| x > 0.0 && x <= 10_000.0,
};
/// Average Velocity Timebase of an axis that is not configured otherwise, s (spec/axis-and-data-types.md §9.1).
const AVERAGE_VELOCITY_TIMEBASE: f64 = 0.25;
const TIMEBASE: NumberRule = NumberRule {
    expected: "a number above 0, at most 1 (seconds)",
    holds: |x| x > 0.0 && x <= 1.0,
};
const FACTOR: NumberRule = NumberRule {
    expected: "a number from 1 to 1e6 (times the axis's maximum)",
    holds: |x| (1.0..=1e6).contains(&x),
};
const SHARE: NumberRule = NumberRule {
    expected: "a number from 0 to 1",
    holds: |x| (0.0..=1.0).contains(&x),
};
const NOT_NEGATIVE_TIME: NumberRule = NumberRule {
    expected: "a number, 0 or more (s)",
    holds: |x| x >= 0.0,
};
const RESOLUTION: NumberRule = NumberRule {
    expected: "a number above 0 (counts per position unit)",
    holds: |x| x > 0.0,
};
pub(super) const ANY: NumberRule = NumberRule {
    expected: "a finite number (position units)",
    holds: |_| true,
};

//! `[[coordinate_system]]` and `[[transform]]` tables: what stands on axes and systems that are there already.

use arcline_controller::machine::{
    AxisLimits, CoordinateSystem, Corner, Deviation, MAX_QUEUE_DEPTH, Machine, Transform,
};

use super::NOT_NEGATIVE_LENGTH;
use super::dynamics::Dynamics;
use super::names::{Taken, required_name, unknown_name};
use super::robot::Kind;
use crate::error::ConfigError;
use crate::section::Section;

pub(super) fn coordinate_system(
    section: &Section<'_>,
    machine: &Machine,
    names: &mut Taken,
) -> Result<CoordinateSystem, ConfigError> {
    let name = required_name(section, "name", names)?;
    let kind = Kind::read(section)?;
    let (count, expected) = kind.axes();
    let mut axes = Vec::new();
    for axis in section.strings("axes", expected, count)? {
        let Some(place) = machine.axis(&axis.value) else {
            let known = machine.axes.iter().map(|axis| axis.name.as_str());
            return Err(unknown_name(section, &axis, "axis", known));
        };
        let behind = machine.axes.get(usize::from(place)).map(|axis| axis.kind);
        if behind == Some(arcline_controller::machine::AxisKind::Feedback) {
            return Err(section.refuse(&axis, "an axis that can be moved", None));
        }
        if axes.contains(&place) {
            return Err(section.refuse(&axis, "each axis once", None));
        }
        axes.push(place);
    }
    let robot = kind.robot(section, axes.len())?;
    let own = axes.iter().filter_map(|place| machine.axes.get(usize::from(*place)));
    let orientation = kind.orientation(section, own)?;
    let dynamics = Dynamics::read(section)?;
    let corner = match section.word("corner", &["logix", "precise"], "\"logix\" or \"precise\"")? {
        Some(1) => Corner::Precise,
        _ => Corner::Logix,
    };
    let deviation = match section.word("deviation", &["corners", "anywhere"], "\"corners\" or \"anywhere\"")? {
        Some(1) => Deviation::Anywhere,
        _ => Deviation::Corners,
    };
    let axis_limits = match section.word("axis_limits", &["ignore", "enforce"], "\"ignore\" or \"enforce\"")? {
        Some(1) => AxisLimits::Enforce,
        _ => AxisLimits::Ignore,
    };
    let joint_limits = match section.word("joint_limits", &["ignore", "enforce"], "\"ignore\" or \"enforce\"")? {
        Some(1) => AxisLimits::Enforce,
        _ => AxisLimits::Ignore,
    };
    Ok(CoordinateSystem {
        name,
        axes,
        max_speed: dynamics.speed,
        max_acceleration: dynamics.acceleration,
        max_deceleration: dynamics.deceleration,
        max_acceleration_jerk: dynamics.acceleration_jerk,
        max_deceleration_jerk: dynamics.deceleration_jerk,
        dynamics_bits: dynamics.bits,
        actual_tolerance: section.number("actual_tolerance", &NOT_NEGATIVE_LENGTH)?.unwrap_or(0.0),
        command_tolerance: section
            .number("command_tolerance", &NOT_NEGATIVE_LENGTH)?
            .unwrap_or(0.0),
        queue_depth: section
            .integer("queue_depth", 1..=MAX_QUEUE_DEPTH, QUEUE_DEPTH)?
            .unwrap_or(1),
        corner,
        deviation,
        axis_limits,
        joint_limits,
        robot,
        orientation,
    })
}

pub(super) fn transform(section: &Section<'_>, machine: &Machine, names: &mut Taken) -> Result<Transform, ConfigError> {
    let name = required_name(section, "name", names)?;
    let system = |key| {
        let given = section
            .string(key, SYSTEM_NAME)?
            .ok_or_else(|| section.missing(key, SYSTEM_NAME))?;
        match machine.system(&given.value) {
            Some(place) => Ok((place, given)),
            None => {
                let known = machine.systems.iter().map(|system| system.name.as_str());
                Err(unknown_name(section, &given, "coordinate system", known))
            }
        }
    };
    let (source, _) = system("source")?;
    let (target, given) = system("target")?;
    if source == target {
        return Err(section.refuse(&given, "another coordinate system than `source`", None));
    }
    Ok(Transform { name, source, target })
}

pub(super) const COORDINATE_SYSTEM: &[&str] = &[
    "name",
    "type",
    "definition",
    "axes",
    "max_speed",
    "max_acceleration",
    "max_deceleration",
    "max_acceleration_jerk",
    "max_deceleration_jerk",
    "dynamics_configuration_bits",
    "max_orientation_speed",
    "max_orientation_acceleration",
    "max_orientation_deceleration",
    "actual_tolerance",
    "command_tolerance",
    "queue_depth",
    "corner",
    "deviation",
    "axis_limits",
    "joint_limits",
    "link_lengths",
    "base_offsets",
    "end_effector_offsets",
    "zero_angles",
];
pub(super) const TRANSFORM: &[&str] = &["name", "source", "target"];

const QUEUE_DEPTH: &str = "a whole number from 1 to 1000";
const SYSTEM_NAME: &str = "the name of a coordinate system";

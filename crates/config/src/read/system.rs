//! `[[coordinate_system]]` and `[[transform]]` tables: what stands on axes and systems that are there already.

use arcline_controller::machine::{
    AxisLimits, CoordinateSystem, Corner, Geometry, MAX_PRIMARY_AXES, MAX_QUEUE_DEPTH, Machine, Parameters, Robot,
    Transform,
};

use super::NOT_NEGATIVE_LENGTH;
use super::dynamics::Dynamics;
use super::names::{Taken, required_name, unknown_name};
use crate::error::{ConfigError, Problem};
use crate::section::Section;

pub(super) fn coordinate_system(
    section: &Section<'_>,
    machine: &Machine,
    names: &mut Taken,
) -> Result<CoordinateSystem, ConfigError> {
    let name = required_name(section, "name", names)?;
    let build = section.word("type", BUILDS, BUILD)?.unwrap_or(0);
    let mut axes = Vec::new();
    for axis in section.strings("axes", PRIMARY_AXES, 1..=MAX_PRIMARY_AXES)? {
        let Some(place) = machine.axis(&axis.value) else {
            let known = machine.axes.iter().map(|axis| axis.name.as_str());
            return Err(unknown_name(section, &axis, "axis", known));
        };
        let kind = machine.axes.get(usize::from(place)).map(|axis| axis.kind);
        if kind == Some(arcline_controller::machine::AxisKind::Feedback) {
            return Err(section.refuse(&axis, "an axis that can be moved", None));
        }
        if axes.contains(&place) {
            return Err(section.refuse(&axis, "each axis once", None));
        }
        axes.push(place);
    }
    let robot = robot(section, build, axes.len())?;
    let dynamics = Dynamics::read(section)?;
    let corner = match section.word("corner", &["logix", "precise"], "\"logix\" or \"precise\"")? {
        Some(1) => Corner::Precise,
        _ => Corner::Logix,
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
        actual_tolerance: section.number("actual_tolerance", &NOT_NEGATIVE_LENGTH)?.unwrap_or(0.0),
        command_tolerance: section
            .number("command_tolerance", &NOT_NEGATIVE_LENGTH)?
            .unwrap_or(0.0),
        queue_depth: section
            .integer("queue_depth", 1..=MAX_QUEUE_DEPTH, QUEUE_DEPTH)?
            .unwrap_or(1),
        corner,
        axis_limits,
        joint_limits,
        robot,
    })
}

/// The robot of a type, with the parameters that it has.
fn robot(section: &Section<'_>, build: usize, axes: usize) -> Result<Option<Robot>, ConfigError> {
    let mut parameters = Parameters::default();
    let [mut lengths, mut angles] = [[0.0; 3]; 2];
    section.numbers("link_lengths", "two numbers", &mut lengths[..2])?;
    section.numbers("base_offsets", THREE_NUMBERS, &mut parameters.base_offsets)?;
    section.numbers(
        "end_effector_offsets",
        THREE_NUMBERS,
        &mut parameters.end_effector_offsets,
    )?;
    section.numbers("zero_angles", THREE_NUMBERS, &mut angles)?;
    parameters.link_lengths = [lengths[0], lengths[1]];
    parameters.zero_angles[..3].copy_from_slice(&angles);
    let plane = axes == 2;
    let geometry = match BUILDS.get(build).copied() {
        Some("articulated_independent") if plane => Geometry::ArticulatedIndependent2,
        Some("articulated_independent") => Geometry::ArticulatedIndependent3,
        Some("articulated_dependent") if plane => Geometry::ArticulatedDependent2,
        Some("articulated_dependent") => Geometry::ArticulatedDependent3,
        Some("scara_independent") => Geometry::ScaraIndependent,
        Some("scara_delta") => Geometry::ScaraDelta,
        Some("delta") if plane => Geometry::Delta2,
        Some("delta") => Geometry::Delta3,
        _ => {
            if let Some(key) = PARAMETERS.iter().find(|key| section.value(key).is_some()) {
                return Err(section.refuse_key(
                    key,
                    Problem::Value {
                        found: section.found(key),
                        expected: "no such key: the coordinate system is Cartesian",
                        suggestion: None,
                    },
                ));
            }
            return Ok(None);
        }
    };
    if geometry.joints() != axes {
        return Err(section.refuse_key(
            "axes",
            Problem::Value {
                found: section.found("axes"),
                expected: "as many axes as the geometry has joints",
                suggestion: None,
            },
        ));
    }
    Ok(Some(Robot { geometry, parameters }))
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
    "axes",
    "max_speed",
    "max_acceleration",
    "max_deceleration",
    "max_acceleration_jerk",
    "max_deceleration_jerk",
    "actual_tolerance",
    "command_tolerance",
    "queue_depth",
    "corner",
    "axis_limits",
    "joint_limits",
    "link_lengths",
    "base_offsets",
    "end_effector_offsets",
    "zero_angles",
];
/// Keys that only robots have.
const PARAMETERS: &[&str] = &["link_lengths", "base_offsets", "end_effector_offsets", "zero_angles"];
/// Words of `type`; how many axes there are tells the rest.
pub(crate) const BUILDS: &[&str] = &[
    "cartesian",
    "articulated_independent",
    "articulated_dependent",
    "scara_independent",
    "scara_delta",
    "delta",
];
pub(super) const TRANSFORM: &[&str] = &["name", "source", "target"];

const BUILD: &str = "\"cartesian\", \"articulated_independent\", \"articulated_dependent\", \"scara_independent\", \"scara_delta\" or \"delta\"";
const THREE_NUMBERS: &str = "a list of three numbers";
const PRIMARY_AXES: &str = "a list of 1 to 3 names of axes";
const QUEUE_DEPTH: &str = "a whole number from 1 to 1000";
const SYSTEM_NAME: &str = "the name of a coordinate system";

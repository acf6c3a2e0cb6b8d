//! `[[coordinate_system]]` and `[[transform]]` tables, which build on axes and systems that exist already.

use arcline_controller::machine::{AxisKind, CoordinateSystem, Machine, Transform};

use arcline_instruction_set::AxisId;

use super::dynamics::Dynamics;
use super::names::{Taken, unknown_name};
use super::robot::Kind;
use crate::section::Section;
use crate::words;

pub(super) fn coordinate_system(section: &Section<'_>, machine: &Machine, names: &mut Taken) -> CoordinateSystem {
    let name = names.take_name(section, "name");
    let kind = Kind::read(section);
    let axes = axes(section, machine, &kind);
    let robot = kind.robot(section);
    let own = axes.iter().filter_map(|place| machine.axes.get(usize::from(*place)));
    let orientation = kind.orientation(section, own);
    let dynamics = Dynamics::read(section);
    CoordinateSystem {
        name,
        max_speed: dynamics.speed,
        max_acceleration: dynamics.acceleration,
        max_deceleration: dynamics.deceleration,
        max_acceleration_jerk: dynamics.acceleration_jerk,
        max_deceleration_jerk: dynamics.deceleration_jerk,
        dynamics_bits: dynamics.bits,
        actual_tolerance: section.required("actual_tolerance"),
        command_tolerance: section.required("command_tolerance"),
        queue_depth: section.whole("queue_depth"),
        corner: section.one_of("corner", words::CORNERS),
        deviation: section.one_of("deviation", words::DEVIATIONS),
        axis_limits: section.one_of("axis_limits", words::LIMITS),
        joint_limits: section.one_of("joint_limits", words::LIMITS),
        axes,
        robot,
        orientation,
    }
}

/// The axes by their indices: as many as the geometry takes, each once, all of them axes that can be moved.
fn axes(section: &Section<'_>, machine: &Machine, kind: &Kind) -> Vec<AxisId> {
    let (count, expected) = kind.axes();
    if section.has("axes") && !count.contains(&section.count("axes")) {
        section.refuse_value("axes", expected);
        return Vec::new();
    }
    let mut axes = Vec::new();
    for axis in section.texts("axes") {
        let Some(place) = machine.axis(&axis.value) else {
            let known = machine.axes.iter().map(|axis| axis.name.as_str());
            unknown_name(section, &axis, "axis", known);
            continue;
        };
        let behind = machine.axes.get(usize::from(place)).map(|axis| axis.kind);
        if behind == Some(AxisKind::Feedback) {
            section.refuse_as(&axis, "an axis that can be moved", None);
        }
        if axes.contains(&place) {
            section.refuse_as(&axis, "each axis once", None);
        }
        axes.push(place);
    }
    axes
}

pub(super) fn transform(section: &Section<'_>, machine: &Machine, names: &mut Taken) -> Transform {
    let name = names.take_name(section, "name");
    let system = |key| {
        let given = section.text(key)?;
        let index = machine.system(&given.value);
        if index.is_none() {
            let known = machine.systems.iter().map(|system| system.name.as_str());
            unknown_name(section, &given, "coordinate system", known);
        }
        index
    };
    let (source, target) = (system("source"), system("target"));
    if let (Some(source), Some(target), Some(given)) = (source, target, section.text("target"))
        && source == target
    {
        section.refuse_as(&given, "another coordinate system than `source`", None);
    }
    Transform {
        name,
        source: source.unwrap_or_default(),
        target: target.unwrap_or_default(),
    }
}

//! `/api/machine`: what is configured, in the units of the configuration (spec/contract.md §2).

use arcline_controller::machine::{Axis, CoordinateSystem, Corner};
use serde_json::{Value, json};

use crate::plant::Plant;

/// The machine as JSON.
pub(super) fn description(plant: &Plant) -> Value {
    let machine = plant.machine();
    let names = |system: &CoordinateSystem| -> Vec<&str> {
        let axes = system
            .axes
            .iter()
            .filter_map(|axis| machine.axes.get(usize::from(*axis)));
        axes.map(|axis| axis.name.as_str()).collect()
    };
    let axes: Vec<Value> = machine.axes.iter().map(axis).collect();
    let systems = machine.systems.iter().map(|system| {
        json!({
            "name": system.name,
            "axes": names(system),
            "robot": system.robot.is_some(),
            "max_speed": system.max_speed,
            "max_acceleration": system.max_acceleration,
            "max_deceleration": system.max_deceleration,
            "max_acceleration_jerk": system.max_acceleration_jerk,
            "max_deceleration_jerk": system.max_deceleration_jerk,
            "actual_tolerance": system.actual_tolerance,
            "command_tolerance": system.command_tolerance,
            "queue_depth": system.queue_depth,
            "corner": match system.corner {
                Corner::Logix => "logix",
                Corner::Precise => "precise",
            },
        })
    });
    json!({
        "name": plant.server().name,
        "version": env!("CARGO_PKG_VERSION"),
        "period_s": machine.period(),
        "group": machine.group,
        "axes": axes,
        "coordinate_systems": systems.collect::<Vec<_>>(),
    })
}

fn axis(axis: &Axis) -> Value {
    json!({
        "name": axis.name,
        "type": if axis.is_virtual() { "virtual" } else { "servo" },
        "units": axis.units,
        "rotary": axis.is_rotary(),
        "unwind": axis.unwind,
        "travel": axis.travel.map(|travel| json!({"min": travel.min, "max": travel.max})),
        "max_speed": axis.max_speed,
        "max_acceleration": axis.max_acceleration,
        "max_deceleration": axis.max_deceleration,
        "max_acceleration_jerk": axis.max_acceleration_jerk,
        "max_deceleration_jerk": axis.max_deceleration_jerk,
    })
}

//! `/api/machine`: the configured axes and coordinate systems, in the units of the configuration (spec/contract.md §2).

use arcline_controller::machine::{Axis, CoordinateSystem, Corner};
use serde::Serialize;

use crate::plant::Plant;

/// The machine as configured.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Machine {
    /// Name of the server.
    name: String,
    /// Version of the server.
    version: &'static str,
    /// Coarse update period, s.
    period_s: f64,
    /// Name of the motion group.
    group: String,
    /// The notice beside the log-in; null without one.
    login_notice: Option<String>,
    /// Every axis.
    axes: Vec<AxisConfiguration>,
    /// Every coordinate system.
    coordinate_systems: Vec<SystemConfiguration>,
}

/// An axis as configured. Rates are in its position units per s, s² and s³.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct AxisConfiguration {
    /// Name.
    name: String,
    /// Kind of drive.
    #[serde(rename = "type")]
    kind: AxisType,
    /// Position units.
    units: String,
    /// Whether the axis is rotary.
    rotary: bool,
    /// Unwind, position units.
    unwind: Option<f64>,
    /// Soft travel limits.
    travel: Option<TravelLimits>,
    /// Maximum Speed.
    max_speed: f64,
    /// Maximum Acceleration.
    max_acceleration: f64,
    /// Maximum Deceleration.
    max_deceleration: f64,
    /// Maximum Acceleration Jerk.
    max_acceleration_jerk: f64,
    /// Maximum Deceleration Jerk.
    max_deceleration_jerk: f64,
}

/// Kind of an axis's drive.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum AxisType {
    /// No drive.
    Virtual,
    /// A servo drive.
    Servo,
}

/// Soft travel limits, position units.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct TravelLimits {
    /// Negative limit.
    min: f64,
    /// Positive limit.
    max: f64,
}

/// A coordinate system as configured. Rates are in position units per s, s² and s³.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct SystemConfiguration {
    /// Name.
    name: String,
    /// Names of its axes.
    axes: Vec<String>,
    /// Whether the coordinate system is a robot: frames of samples have the position of its tool.
    robot: bool,
    /// Maximum Speed.
    max_speed: f64,
    /// Maximum Acceleration.
    max_acceleration: f64,
    /// Maximum Deceleration.
    max_deceleration: f64,
    /// Maximum Acceleration Jerk.
    max_acceleration_jerk: f64,
    /// Maximum Deceleration Jerk.
    max_deceleration_jerk: f64,
    /// Actual tolerance, position units.
    actual_tolerance: f64,
    /// Command tolerance, position units.
    command_tolerance: f64,
    /// Number of moves for which its queue has room.
    queue_depth: usize,
    /// Planning of corners.
    corner: CornerPlanning,
}

/// Planning of corners.
#[derive(Serialize, Debug)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum CornerPlanning {
    /// Blends as Logix makes them.
    Logix,
    /// One contour within the tolerance.
    Precise,
}

/// The machine of a plant.
pub(super) fn description(plant: &Plant) -> Machine {
    let machine = plant.machine();
    let names = |system: &CoordinateSystem| {
        let axes = system.axes.iter();
        let axes = axes.filter_map(|axis| machine.axes.get(usize::from(*axis)));
        axes.map(|axis| axis.name.clone()).collect()
    };
    let systems = machine.systems.iter().map(|system| SystemConfiguration {
        name: system.name.clone(),
        axes: names(system),
        robot: system.robot.is_some(),
        max_speed: system.max_speed,
        max_acceleration: system.max_acceleration,
        max_deceleration: system.max_deceleration,
        max_acceleration_jerk: system.max_acceleration_jerk,
        max_deceleration_jerk: system.max_deceleration_jerk,
        actual_tolerance: system.actual_tolerance,
        command_tolerance: system.command_tolerance,
        queue_depth: system.queue_depth,
        corner: match system.corner {
            Corner::Logix => CornerPlanning::Logix,
            Corner::Precise => CornerPlanning::Precise,
        },
    });
    Machine {
        name: plant.server().name.clone(),
        version: env!("CARGO_PKG_VERSION"),
        period_s: machine.period(),
        group: machine.group.clone(),
        login_notice: plant.server().security.login_notice.clone(),
        axes: machine.axes.iter().map(axis).collect(),
        coordinate_systems: systems.collect(),
    }
}

fn axis(axis: &Axis) -> AxisConfiguration {
    AxisConfiguration {
        name: axis.name.clone(),
        kind: if axis.is_virtual() {
            AxisType::Virtual
        } else {
            AxisType::Servo
        },
        units: axis.units.clone(),
        rotary: axis.is_rotary(),
        unwind: axis.unwind,
        travel: axis.travel.map(|travel| TravelLimits {
            min: travel.min,
            max: travel.max,
        }),
        max_speed: axis.max_speed,
        max_acceleration: axis.max_acceleration,
        max_deceleration: axis.max_deceleration,
        max_acceleration_jerk: axis.max_acceleration_jerk,
        max_deceleration_jerk: axis.max_deceleration_jerk,
    }
}

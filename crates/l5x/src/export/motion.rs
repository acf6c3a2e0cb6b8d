//! The motion group, axes and coordinate systems as tags. Keys without an attribute go to the overlay.

use arcline_controller::machine::{
    Axis, CoordinateSystem, Home, HomeDirection, HomeMode, HomeSequence, Machine, ProgrammedStopMode, Robot,
    SimulatedDrive,
};
use arcline_instruction_set::{FAULTS, FaultSet, FaultWord};

use super::xml::Xml;
use crate::import::motion::{ACTIONS, ORIENTATION, ROBOT, SYSTEM_TYPES, UNDEFINED};
use crate::text::write_real;

pub(super) fn motion(xml: &mut Xml, machine: &Machine) {
    let micros = machine.period_ns.div_ceil(1000).to_string();
    parameters(
        xml,
        &machine.group,
        "MOTION_GROUP",
        "MotionGroup",
        "MotionGroupParameters",
        &[("CoarseUpdatePeriod", micros)],
    );
    for (axis, drive) in machine.axes.iter().zip(&machine.drives) {
        let word = if axis.is_virtual() {
            "AXIS_VIRTUAL"
        } else {
            "AXIS_CIP_DRIVE"
        };
        parameters(
            xml,
            &axis.name,
            word,
            "Axis",
            "AxisParameters",
            &attributes(axis, drive.as_ref(), &machine.group),
        );
    }
    for one in &machine.systems {
        let (element, list) = ("CoordinateSystemParameters", system(one, machine));
        parameters(xml, &one.name, "COORDINATE_SYSTEM", "CoordinateSystem", element, &list);
    }
}

type Attribute = (&'static str, String);

fn parameters(xml: &mut Xml, name: &str, word: &str, format: &str, element: &str, attributes: &[Attribute]) {
    let head = [
        ("Name", name),
        ("TagType", "Base"),
        ("DataType", word),
        ("ExternalAccess", "Read/Write"),
    ];
    xml.open("Tag", &head);
    xml.open("Data", &[("Format", format)]);
    let attributes: Vec<(&str, &str)> = attributes.iter().map(|(key, value)| (*key, value.as_str())).collect();
    xml.empty(element, &attributes);
    xml.close("Data");
    xml.close("Tag");
}

fn attributes(axis: &Axis, servo: Option<&SimulatedDrive>, group: &str) -> Vec<Attribute> {
    let mut list = vec![("MotionGroup", group.to_owned())];
    if servo.is_some() {
        list.push(("AxisConfiguration", "Position Loop".to_owned()));
    }
    // Logix's own first values of the two types (spec/axis-and-data-types.md §9.1).
    let constant = if servo.is_some() { 1_000_000.0 } else { 8000.0 };
    let counts = (axis.unwind.unwrap_or(1.0) * constant)
        .round()
        .clamp(1.0, f64::from(i32::MAX));
    list.push(("ConversionConstant", write_real(constant)));
    list.push(("PositionUnits", axis.units.clone()));
    list.push(("AverageVelocityTimebase", write_real(axis.average_velocity_timebase)));
    list.push(("OutputCamExecutionTargets", axis.output_cam_targets.to_string()));
    let (key, words) = match servo {
        Some(_) => ("TravelMode", ["Unlimited", "Cyclic"]),
        None => ("RotaryAxis", ["Linear", "Rotary"]),
    };
    list.push((key, words[usize::from(axis.is_rotary())].to_owned()));
    list.push(("PositionUnwind", format!("{counts:.0}")));
    home(&axis.home, servo.is_some(), &mut list);
    list.push(("MaximumSpeed", write_real(axis.max_speed)));
    list.push(("MaximumAcceleration", write_real(axis.max_acceleration)));
    list.push(("MaximumDeceleration", write_real(axis.max_deceleration)));
    list.push(("MaximumAccelerationJerk", write_real(axis.max_acceleration_jerk)));
    list.push(("MaximumDecelerationJerk", write_real(axis.max_deceleration_jerk)));
    list.push(("DynamicsConfigurationBits", axis.dynamics_bits.bits().to_string()));
    let stop = match axis.programmed_stop_mode {
        ProgrammedStopMode::FastStop => "Fast Stop",
        ProgrammedStopMode::FastDisable => "Fast Disable",
        ProgrammedStopMode::HardDisable => "Hard Disable",
        ProgrammedStopMode::FastShutdown => "Fast Shutdown",
        ProgrammedStopMode::HardShutdown => "Hard Shutdown",
    };
    list.push(("ProgrammedStopMode", stop.to_owned()));
    if let Some(SimulatedDrive { settings, .. }) = servo {
        list.push(("PositionLoopBandwidth", write_real(settings.bandwidth)));
        list.push(("VelocityFeedforwardGain", write_real(settings.feedforward * 100.0)));
        list.push(("PositionErrorTolerance", write_real(axis.position_error.tolerance)));
        list.push(("PositionErrorToleranceTime", write_real(axis.position_error.time)));
        list.push(("SoftTravelLimitChecking", axis.travel.is_some().to_string()));
        if let Some(travel) = axis.travel {
            list.push(("SoftTravelLimitPositive", write_real(travel.max)));
            list.push(("SoftTravelLimitNegative", write_real(travel.min)));
        }
        list.push(("MotionExceptionAction", actions(axis, FaultWord::Motion, 32)));
        list.push(("CIPAxisExceptionAction", actions(axis, FaultWord::Cip, 64)));
    }
    list
}

/// A word a bit; a bit that no fault of Arcline has is unsupported.
fn actions(axis: &Axis, word: FaultWord, bits: usize) -> String {
    let possible = FaultSet::possible(true);
    let words = (0..bits).map(|bit| {
        let here = FAULTS
            .iter()
            .find(|fault| fault.shows == word && usize::from(fault.bit) == bit);
        let action = here
            .filter(|fault| possible.contains(fault.kind))
            .map(|fault| axis.exception_actions.of(fault.kind));
        ACTIONS
            .iter()
            .find(|(_, other)| *other == action)
            .map_or("Unsupported", |(word, _)| word)
    });
    words.collect::<Vec<_>>().join(" ")
}

fn home(home: &Home, servo: bool, list: &mut Vec<Attribute>) {
    let mode = match home.mode {
        HomeMode::Passive => "Passive",
        HomeMode::Active => "Active",
    };
    let direction = match home.direction {
        HomeDirection::UnidirectionalForward => "Uni-directional Forward",
        HomeDirection::BidirectionalForward => "Bi-directional Forward",
        HomeDirection::UnidirectionalReverse => "Uni-directional Reverse",
        HomeDirection::BidirectionalReverse => "Bi-directional Reverse",
    };
    let sequence = match home.sequence {
        HomeSequence::Immediate => "Immediate",
        HomeSequence::Switch => "Switch",
        HomeSequence::Marker => "Marker",
        HomeSequence::SwitchMarker => "Switch-Marker",
        HomeSequence::Torque => "Torque Level",
        HomeSequence::TorqueMarker => "Torque Level-Marker",
    };
    list.push(("HomeMode", mode.to_owned()));
    list.push(("HomeDirection", direction.to_owned()));
    list.push(("HomeSequence", sequence.to_owned()));
    list.push(("HomePosition", write_real(home.position)));
    list.push(("HomeOffset", write_real(home.offset)));
    if servo {
        list.push(("HomeSpeed", write_real(home.speed)));
        list.push(("HomeReturnSpeed", write_real(home.return_speed)));
    }
}

fn system(system: &CoordinateSystem, machine: &Machine) -> Vec<Attribute> {
    let axes = system
        .axes
        .iter()
        .filter_map(|place| machine.axes.get(usize::from(*place)));
    let names: Vec<&str> = axes.map(|axis| axis.name.as_str()).collect();
    let key = arcline_config::type_of_system(system.robot.as_ref());
    let word = SYSTEM_TYPES
        .iter()
        .find(|build| build.key == key)
        .map(|build| build.word);
    let definition = arcline_config::definition_of(system);
    let mut list = vec![
        ("MotionGroup", machine.group.clone()),
        ("SystemType", word.unwrap_or("Cartesian").to_owned()),
        ("CoordinateDefinition", definition.unwrap_or(UNDEFINED).to_owned()),
        ("Dimension", names.len().to_string()),
        ("Axes", names.join(" ")),
        ("MaximumPendingMoves", system.queue_depth.to_string()),
        ("CoordinationMode", vec!["Primary"; names.len()].join(" ")),
        ("MaximumSpeed", write_real(system.max_speed)),
        ("MaximumAcceleration", write_real(system.max_acceleration)),
        ("MaximumDeceleration", write_real(system.max_deceleration)),
        ("ActualPositionTolerance", write_real(system.actual_tolerance)),
        ("CommandPositionTolerance", write_real(system.command_tolerance)),
        ("TransformDimension", names.len().to_string()),
        ("MaximumAccelerationJerk", write_real(system.max_acceleration_jerk)),
        ("MaximumDecelerationJerk", write_real(system.max_deceleration_jerk)),
        ("DynamicsConfigurationBits", system.dynamics_bits.bits().to_string()),
    ];
    if let Some(maxima) = &system.orientation {
        let numbers = [maxima.max_speed, maxima.max_acceleration, maxima.max_deceleration];
        let named = ORIENTATION.iter().map(|(attribute, _)| *attribute);
        list.extend(named.zip(numbers.map(write_real)));
    }
    if let Some(Robot { parameters, .. }) = &system.robot {
        for (key, attributes) in ROBOT {
            let numbers: &[f64] = match *key {
                "link_lengths" => &parameters.link_lengths,
                "base_offsets" => &parameters.base_offsets,
                "end_effector_offsets" => &parameters.end_effector_offsets,
                _ => &parameters.zero_angles,
            };
            let numbers = numbers.iter().copied().map(write_real);
            list.extend(attributes.iter().copied().zip(numbers));
        }
    }
    list
}

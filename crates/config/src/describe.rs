//! The objects that a project would create, as text (`arcline-server check`).

use std::fmt::Write as _;

use arcline_controller::machine::{
    Axis, AxisKind, CoordinateSystem, Corner, Home, HomeMode, HomeSequence, LimitPolicy, Machine,
};
use arcline_instruction_set::SystemId;

use crate::{Project, ServerConfig};

/// The objects that the project would create, one a line, ending with a newline.
pub fn describe(project: &Project) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut text, project);
    text
}

fn write(out: &mut String, project: &Project) -> std::fmt::Result {
    let Project {
        server,
        machine,
        instruction_tags,
        types: _,
        tags,
        ..
    } = project;
    write_server(out, server)?;
    writeln!(
        out,
        "motion group {}, coarse update period {} ms",
        machine.group,
        machine.period_ns as f64 / 1e6
    )?;
    for axis in &machine.axes {
        write_axis(out, axis)?;
    }
    for system in &machine.systems {
        write_system(out, system, machine)?;
    }
    let system_name = |place: SystemId| {
        machine
            .systems
            .get(usize::from(place))
            .map_or("?", |system| system.name.as_str())
    };
    for transform in &machine.transforms {
        writeln!(
            out,
            "transform {}: {} to {}",
            transform.name,
            system_name(transform.source),
            system_name(transform.target)
        )?;
    }
    for tag in instruction_tags {
        writeln!(out, "instruction tag {}: {} on {}", tag.name, tag.mnemonic, tag.target)?;
    }
    for tag in tags {
        writeln!(out, "tag {}: {}", tag.name, tag.tag_type)?;
    }
    writeln!(
        out,
        "{}, {}, {}, {}, {}",
        counted(machine.axes.len(), ["axis", "axes"]),
        counted(machine.systems.len(), ["coordinate system", "coordinate systems"]),
        counted(machine.transforms.len(), ["transform", "transforms"]),
        counted(instruction_tags.len(), ["instruction tag", "instruction tags"]),
        counted(tags.len(), ["plain tag", "plain tags"]),
    )
}

fn write_server(out: &mut String, server: &ServerConfig) -> std::fmt::Result {
    writeln!(out, "server {:?}", server.name)?;
    writeln!(out, "  EtherNet/IP on {}", server.listen)?;
    for also in &server.listen_also {
        writeln!(out, "  EtherNet/IP on {also}")?;
    }
    match server.io.address(server.listen) {
        Some(io) => writeln!(out, "  I/O on {io}, lost outputs: {}", server.io_loss.word())?,
        None => writeln!(out, "  I/O off")?,
    }
    match server.hmi {
        Some(hmi) => writeln!(out, "  HMI on {hmi}")?,
        None => writeln!(out, "  HMI off")?,
    }
    Ok(())
}

fn write_axis(out: &mut String, axis: &Axis) -> std::fmt::Result {
    let kind = match axis.kind {
        AxisKind::Servo => "servo",
        AxisKind::Virtual => "virtual",
        AxisKind::Feedback => "feedback",
    };
    let unit = &axis.units;
    write!(
        out,
        "axis {}: {kind}, up to {} {unit}/s, {} {unit}/s²",
        axis.name, axis.max_speed, axis.max_acceleration
    )?;
    if let Some(travel) = axis.travel {
        write!(out, ", travel {} to {} {unit}", travel.min, travel.max)?;
    }
    if let Some(unwind) = axis.unwind {
        write!(out, ", rotary, {unwind} {unit} a turn")?;
    }
    write!(out, ", starts at {} {unit}", axis.start.position)?;
    if matches!(axis.kind, AxisKind::Servo) {
        write!(out, ", servo {}", if axis.start.servo_on { "on" } else { "off" })?;
    }
    write!(out, "{}", if axis.start.homed { ", homed" } else { ", not homed" })?;
    writeln!(out, "{}", homing(&axis.home))
}

fn write_system(out: &mut String, system: &CoordinateSystem, machine: &Machine) -> std::fmt::Result {
    let axes: Vec<&str> = system
        .axes
        .iter()
        .filter_map(|place| machine.axes.get(usize::from(*place)))
        .map(|axis| axis.name.as_str())
        .collect();
    write!(
        out,
        "coordinate system {}: {}, up to {} units/s, {} units/s², {} pending",
        system.name,
        axes.join(" "),
        system.max_speed,
        system.max_acceleration,
        system.queue_depth,
    )?;
    if system.corner == Corner::Precise {
        write!(out, ", precise corners")?;
    }
    if system.axis_limits == LimitPolicy::Enforce {
        write!(out, ", axis limits enforced")?;
    }
    writeln!(out)
}

/// `1 axis`, `7 axes`.
fn counted(count: usize, [one, more]: [&str; 2]) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}

/// The homing of an axis, as far as it is not the usual one.
fn homing(home: &Home) -> &'static str {
    match (home.mode, home.sequence) {
        (_, HomeSequence::Immediate) => "",
        (HomeMode::Active, HomeSequence::Switch) => ", homes on a switch",
        (HomeMode::Active, HomeSequence::Marker) => ", homes on a marker",
        (HomeMode::Active, HomeSequence::SwitchMarker) => ", homes on a marker behind a switch",
        (HomeMode::Passive, HomeSequence::Switch) => ", homes on a switch when moved there",
        (HomeMode::Passive, HomeSequence::Marker) => ", homes on a marker when moved there",
        (HomeMode::Passive, HomeSequence::SwitchMarker) => ", homes on a marker behind a switch when moved there",
        (_, HomeSequence::Torque | HomeSequence::TorqueMarker) => ", homes by torque, which is not simulated",
    }
}

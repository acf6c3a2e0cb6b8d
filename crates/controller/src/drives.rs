//! The simulated drives of a machine, from its description.
//!
//! A fieldbus or a plant model is another implementation of [`arcline_drive::Drives`], given to
//! [`Controller::with_drives`](crate::Controller::with_drives).

use arcline_drive::simulated::{Sensor, Settings, SimulatedAxis, SimulatedDrives};
use arcline_motion::machine::{Axis, AxisKind, Machine};

/// Simulated drives of every servo axis. Allocates.
pub fn simulated(machine: &Machine) -> SimulatedDrives {
    let axes = machine.axes.iter().map(axis).collect();
    SimulatedDrives::new(axes, machine.period())
}

fn axis(axis: &Axis) -> Option<SimulatedAxis> {
    let AxisKind::Servo(drive) = &axis.kind else {
        return None;
    };
    let settings = Settings {
        bandwidth: drive.position_bandwidth_hz,
        feedforward: drive.velocity_feedforward,
        speed_limit: drive.speed_limit.unwrap_or(f64::INFINITY),
        torque_limit: drive.torque_limit.unwrap_or(f64::INFINITY),
        encoder_resolution: drive.encoder_resolution,
    };
    let sensor = Sensor {
        switch: axis.home.switch.map(|switch| [switch.min, switch.max]),
        marker: axis.home.marker.map(|marker| (marker.at, marker.every)),
        stops: axis.home.stops,
        turn: axis.unwind,
    };
    Some(SimulatedAxis::new(
        axis.start.position - axis.start.redefined,
        &settings,
        sensor,
    ))
}

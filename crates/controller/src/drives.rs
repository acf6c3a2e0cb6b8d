//! The simulated drives of a machine, from its configuration.
//!
//! A fieldbus or a plant model is another implementation of [`arcline_drive::Drives`], given to
//! [`Controller::with_drives`](crate::Controller::with_drives).

use arcline_drive::simulated::{SimulatedAxis, SimulatedDrives};

use crate::machine::Machine;

/// Simulated drives of every servo axis. Allocates.
pub fn simulated(machine: &Machine) -> SimulatedDrives {
    let axes = machine.axes.iter().zip(&machine.drives).map(|(axis, drive)| {
        let position = axis.start.position - axis.start.redefined;
        let drive = drive.as_ref()?;
        Some(SimulatedAxis::new(position, &drive.settings, drive.sensor))
    });
    SimulatedDrives::new(axes.collect(), machine.period())
}

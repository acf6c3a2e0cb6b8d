//! Snapshots as the bytes of the predefined types: the member for each number, found by name at compile time.

use arcline_instruction_set::AxisId;
use arcline_instruction_set::predefined::{self, axis_fault};
use arcline_motion::{AxisSet, AxisSnapshot, SystemSnapshot};

use super::Health;
use super::shared::{Memory, Unshared};
use crate::Snapshot;
use crate::machine::Machine;

/// A quantity of an axis, by its index in the snapshot.
#[derive(Clone, Copy, Debug)]
enum AxisField {
    Fault,
    Status,
    Event,
    MotionStatus,
    MotionFaults,
    MotionAlarms,
    CipFaults,
    CipAlarms,
    CipState,
    CipStatus,
    Real(fn(&AxisSnapshot) -> f64),
    Dint(fn(&AxisSnapshot) -> i32),
}

/// The states that the bytes of the tags have, and the fault of the group with each. A copy of an image has none: it is only read.
#[derive(Clone, Debug, Default)]
pub(super) struct Encoded {
    axes: Unshared<(AxisSnapshot, u32)>,
    systems: Unshared<(SystemSnapshot, u32)>,
}

/// Notes a state at an index; false: it was the last one there.
fn differs<T: PartialEq>(last: &mut Vec<T>, index: usize, now: T) -> bool {
    match last.get_mut(index) {
        Some(last) if *last == now => return false,
        Some(last) => *last = now,
        None => last.push(now),
    }
    true
}

/// Writes all changing values. The order of tags is the group, the axes, the coordinate systems.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    is_virtual: Vec<bool>,
}

/// The offset of a member of a predefined type; a name that the type does not have is a compiler error.
macro_rules! offset {
    ($template:ident $name:literal) => {
        const { predefined::$template::offset($name) }
    };
}

impl Encoder {
    pub(super) fn new(machine: &Machine) -> Self {
        Encoder {
            is_virtual: machine.axes.iter().map(|axis| axis.is_virtual()).collect(),
        }
    }

    /// Writes the states that have changed; of the axes only these, if they are given. `overlapping`: the motion task was still in execution when its
    /// next period began.
    pub(super) fn snapshot(
        &self,
        snapshot: &Snapshot,
        changed: Option<&AxisSet>,
        overlapping: bool,
        encoded: &mut Encoded,
        memory: &mut Memory,
    ) {
        let group_fault = if overlapping { axis_fault::GROUP_FAULT } else { 0 };
        let mut faults = 0;
        let axes = snapshot.axes.iter().zip(&self.is_virtual);
        for ((index, id), (axis, is_virtual)) in (0..).zip(AxisId::first(snapshot.axes.len())).zip(axes) {
            faults |= axis.fault;
            let known = encoded.axes.get(index).filter(|(_, fault)| *fault == group_fault);
            let may_differ = known.is_none() || changed.is_none_or(|changed| changed.contains(id));
            if !may_differ || !differs(&mut encoded.axes, index, (*axis, group_fault)) {
                continue;
            }
            let fields = if *is_virtual { VIRTUAL_FIELDS } else { CIP_FIELDS };
            if let Some(bytes) = memory.get_mut(FIRST_AXIS + index) {
                encode_axis(fields, axis, group_fault, bytes);
            }
        }
        for (index, system) in snapshot.systems.iter().enumerate() {
            let row = FIRST_AXIS + self.is_virtual.len() + index;
            if differs(&mut encoded.systems, index, (*system, group_fault))
                && let Some(bytes) = memory.get_mut(row)
            {
                encode_system(system, group_fault, bytes);
            }
        }
        if let Some(group) = memory.get_mut(GROUP_TAG) {
            put(group, offset!(motion_group "GroupStatus"), GROUP_RUNNING.to_le_bytes());
            // The group has no bit for motion faults of axes, so they count as physical faults.
            if faults & axis_fault::MOTION_FAULT != 0 {
                faults |= axis_fault::PHYSICAL_AXIS_FAULT;
            }
            put(
                group,
                offset!(motion_group "AxisFault"),
                (faults & GROUP_AXIS_FAULTS).to_le_bytes(),
            );
        }
    }

    pub(super) fn health(&self, health: &Health, memory: &mut Memory) {
        let Some(group) = memory.get_mut(GROUP_TAG) else { return };
        let (scan, io) = (&health.compute, &health.lateness);
        let times = [
            (offset!(motion_group "TaskMaxScanTime"), scan.max),
            (offset!(motion_group "TaskLastScanTime"), scan.last),
            (offset!(motion_group "TaskAverageScanTime"), scan.average),
            (offset!(motion_group "TaskLastIOTime"), io.last),
            (offset!(motion_group "TaskMaxIOTime"), io.max),
            (offset!(motion_group "TaskAverageIOTime"), io.average),
        ];
        for (offset, time) in times {
            put(group, offset, (time.round() as i32).to_le_bytes());
        }
        put(
            group,
            offset!(motion_group "GroupFault"),
            u32::from(health.overlapping).to_le_bytes(),
        );
    }

    /// Attributes of the drives, which do not change.
    pub(super) fn constants(&self, machine: &Machine, memory: &mut Memory) {
        for (row, (axis, drive)) in (FIRST_AXIS..).zip(machine.axes.iter().zip(&machine.drives)) {
            let Some(bytes) = memory.get_mut(row) else { continue };
            let interpolation_time = if axis.is_virtual() {
                offset!(axis_virtual "InterpolationTime")
            } else {
                offset!(axis_cip_drive "InterpolationTime")
            };
            put(bytes, interpolation_time, 0i32.to_le_bytes());
            if let Some(drive) = drive {
                let bandwidth = drive.settings.bandwidth as f32;
                let percent = (drive.settings.feedforward * 100.0) as f32;
                put(
                    bytes,
                    offset!(axis_cip_drive "PositionLoopBandwidth"),
                    bandwidth.to_le_bytes(),
                );
                put(
                    bytes,
                    offset!(axis_cip_drive "VelocityFeedforwardGain"),
                    percent.to_le_bytes(),
                );
            }
        }
    }
}

/// The members that both types of axes have, and those of AXIS_CIP_DRIVE alone. A name that a type does not have is a compiler error.
macro_rules! axis_fields {
    (both { $($name:literal $field:expr;)* } cip { $($cip:literal $cip_field:expr;)* }) => {
        const CIP_FIELDS: &[(usize, AxisField)] = &[
            $((offset!(axis_cip_drive $name), $field),)*
            $((offset!(axis_cip_drive $cip), $cip_field),)*
        ];
        const VIRTUAL_FIELDS: &[(usize, AxisField)] = &[$((offset!(axis_virtual $name), $field),)*];
    };
}

use AxisField::{
    CipAlarms, CipFaults, CipState, CipStatus, Dint, Event, Fault, MotionAlarms, MotionFaults, MotionStatus, Real,
    Status,
};

axis_fields! {
    both {
        "AxisFault" Fault;
        "AxisStatus" Status;
        "AxisEvent" Event;
        "MotionStatus" MotionStatus;
        "CommandPosition" Real(|axis| axis.command[0]);
        "CommandVelocity" Real(|axis| axis.command[1]);
        "CommandAcceleration" Real(|axis| axis.command[2]);
        "ActualPosition" Real(|axis| axis.actual[0]);
        "ActualVelocity" Real(|axis| axis.actual[1]);
        "AverageVelocity" Real(|axis| axis.average_velocity);
        "ActualAcceleration" Real(|axis| axis.actual[2]);
        "StartCommandPosition" Real(|axis| axis.started_at[0]);
        "StartActualPosition" Real(|axis| axis.started_at[1]);
        "StrobeCommandPosition" Real(|axis| axis.strobed[0]);
        "StrobeActualPosition" Real(|axis| axis.strobed[1]);
        "WatchPosition" Real(|axis| axis.watched);
        "Registration1Position" Real(|axis| axis.registered[0][0]);
        "Registration2Position" Real(|axis| axis.registered[1][0]);
        "Registration1Time" Dint(|axis| axis.registered_at[0][0]);
        "Registration2Time" Dint(|axis| axis.registered_at[1][0]);
        "MasterOffset" Real(|axis| axis.master_offset[0]);
        "StartMasterOffset" Real(|axis| axis.master_offset[1]);
        "StrobeMasterOffset" Real(|axis| axis.master_offset[2]);
        "OutputCamStatus" Dint(|axis| axis.output_cams[0] as i32);
        "OutputCamPendingStatus" Dint(|axis| axis.output_cams[1] as i32);
        "OutputCamLockStatus" Dint(|axis| axis.output_cams[2] as i32);
        "OutputCamTransitionStatus" Dint(|axis| axis.output_cams[3] as i32);
        "InterpolatedActualPosition" Real(|axis| axis.actual[0]);
        "InterpolatedCommandPosition" Real(|axis| axis.command[0]);
    }
    cip {
        "MotionFaultStatus" MotionFaults;
        "MotionAlarmStatus" MotionAlarms;
        "CIPAxisFaults" CipFaults;
        "CIPAxisAlarms" CipAlarms;
        "CIPAxisState" CipState;
        "CIPAxisStatus" CipStatus;
        "VelocityFeedback" Real(|axis| axis.actual[1]);
        "VelocityError" Real(|axis| axis.command[1] - axis.actual[1]);
        "PositionError" Real(|axis| axis.position_error);
        "Registration1PositiveEdgePosition" Real(|axis| axis.registered[0][1]);
        "Registration1NegativeEdgePosition" Real(|axis| axis.registered[0][2]);
        "Registration2PositiveEdgePosition" Real(|axis| axis.registered[1][1]);
        "Registration2NegativeEdgePosition" Real(|axis| axis.registered[1][2]);
        "Registration1PositiveEdgeTime" Dint(|axis| axis.registered_at[0][1]);
        "Registration1NegativeEdgeTime" Dint(|axis| axis.registered_at[0][2]);
        "Registration2PositiveEdgeTime" Dint(|axis| axis.registered_at[1][1]);
        "Registration2NegativeEdgeTime" Dint(|axis| axis.registered_at[1][2]);
        "CIPAxisIOStatus" Dint(|axis| axis.cip_io as i32);
    }
}

fn encode_axis(fields: &[(usize, AxisField)], axis: &AxisSnapshot, group_fault: u32, bytes: &mut [u8]) {
    for (offset, field) in fields {
        match field {
            AxisField::Fault => put(bytes, *offset, (axis.fault | group_fault).to_le_bytes()),
            AxisField::Status => put(bytes, *offset, axis.status.to_le_bytes()),
            AxisField::Event => put(bytes, *offset, axis.event.to_le_bytes()),
            AxisField::MotionStatus => put(bytes, *offset, axis.motion_status.to_le_bytes()),
            AxisField::MotionFaults => put(bytes, *offset, axis.motion_faults[0].to_le_bytes()),
            AxisField::MotionAlarms => put(bytes, *offset, axis.motion_faults[1].to_le_bytes()),
            AxisField::CipFaults => put(bytes, *offset, axis.cip_faults[0].to_le_bytes()),
            AxisField::CipAlarms => put(bytes, *offset, axis.cip_faults[1].to_le_bytes()),
            AxisField::CipState => put(bytes, *offset, axis.cip_state.to_le_bytes()),
            AxisField::CipStatus => put(bytes, *offset, axis.cip_status.to_le_bytes()),
            AxisField::Dint(of) => put(bytes, *offset, of(axis).to_le_bytes()),
            AxisField::Real(of) => put(bytes, *offset, real(of(axis))),
        }
    }
}

fn encode_system(system: &SystemSnapshot, group_fault: u32, bytes: &mut [u8]) {
    put(
        bytes,
        offset!(coordinate_system "CoordinateSystemStatus"),
        system.status.to_le_bytes(),
    );
    put(
        bytes,
        offset!(coordinate_system "CoordinateMotionStatus"),
        system.motion_status.to_le_bytes(),
    );
    put(
        bytes,
        offset!(coordinate_system "AxisFault"),
        (system.fault | group_fault).to_le_bytes(),
    );
    put(
        bytes,
        offset!(coordinate_system "PhysicalAxesFaulted"),
        system.axes_faulted.to_le_bytes(),
    );
    put(
        bytes,
        offset!(coordinate_system "AxesShutdownStatus"),
        system.axes_shutdown.to_le_bytes(),
    );
    put(
        bytes,
        offset!(coordinate_system "AxesServoOnStatus"),
        system.axes_servo_on.to_le_bytes(),
    );
    for (row, actual) in system.actual.iter().enumerate() {
        put(
            bytes,
            offset!(coordinate_system "ActualPosition") + 4 * row,
            real(*actual),
        );
    }
    let frames = [
        offset!(coordinate_system "ActiveToolFrameID"),
        offset!(coordinate_system "ActiveWorkFrameID"),
    ];
    for (offset, id) in frames.into_iter().zip(system.frames) {
        put(bytes, offset, id.to_le_bytes());
    }
    for (row, turns) in system.turns.iter().enumerate() {
        put(
            bytes,
            offset!(coordinate_system "TurnsCounters") + 2 * row,
            turns.to_le_bytes(),
        );
    }
    put(
        bytes,
        offset!(coordinate_system "RobotConfiguration"),
        system.configuration.to_le_bytes(),
    );
}

/// A REAL. States that differ in the sign of a zero alone are equal, so a zero has none.
fn real(value: f64) -> [u8; 4] {
    (value as f32 + 0.0).to_le_bytes()
}

fn put<const N: usize>(bytes: &mut [u8], offset: usize, value: [u8; N]) {
    if let Some(row) = bytes.get_mut(offset..offset + N) {
        row.copy_from_slice(&value);
    }
}

/// Index of the group's tag; axes follow it, coordinate systems follow them.
const GROUP_TAG: usize = 0;
/// Index of the first axis's tag.
const FIRST_AXIS: usize = 1;
/// GroupStatus of a running group: GroupSynced and the timer event (spec/axis-and-data-types.md §8.8).
const GROUP_RUNNING: u32 = 6;
/// The bits of an axis's AxisFault that the group collects.
const GROUP_AXIS_FAULTS: u32 = 7;

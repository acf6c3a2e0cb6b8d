//! Snapshots as the bytes of the predefined types: which number goes to which member, found once by name.

use arcline_instruction_set::predefined::{self, axis_fault};
use arcline_motion::{AxisSnapshot, SystemSnapshot};
use arcline_tag::Template;

use super::Health;
use super::shared::Memory;
use crate::Snapshot;
use crate::machine::Machine;

/// Number of an axis that is shown.
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

/// Where the numbers of one axis type stand.
#[derive(Clone, Debug)]
struct AxisLayout {
    fields: Vec<(usize, AxisField)>,
    interpolation_time: Option<usize>,
}

/// Places of everything that changes. The order of tags is the group, the axes, the coordinate systems.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    cip: AxisLayout,
    virtual_: AxisLayout,
    is_virtual: Vec<bool>,
    system: SystemLayout,
    group: GroupLayout,
}

#[derive(Clone, Debug)]
struct SystemLayout {
    status: usize,
    motion_status: usize,
    fault: usize,
    faulted: usize,
    shutdown: usize,
    servo_on: usize,
    actual: usize,
    frames: [usize; 2],
    turns: usize,
    configuration: usize,
}

#[derive(Clone, Debug)]
struct GroupLayout {
    status: usize,
    fault: usize,
    axis_fault: usize,
    /// Max, last and average scan time; last, max and average I/O time.
    task: [usize; 6],
}

impl Encoder {
    pub(super) fn new(machine: &Machine) -> Self {
        let system = predefined::coordinate_system();
        let group = predefined::motion_group();
        Encoder {
            cip: AxisLayout::new(&predefined::axis_cip_drive()),
            virtual_: AxisLayout::new(&predefined::axis_virtual()),
            is_virtual: machine.axes.iter().map(|axis| axis.is_virtual()).collect(),
            system: SystemLayout {
                status: at(&system, "CoordinateSystemStatus"),
                motion_status: at(&system, "CoordinateMotionStatus"),
                fault: at(&system, "AxisFault"),
                faulted: at(&system, "PhysicalAxesFaulted"),
                shutdown: at(&system, "AxesShutdownStatus"),
                servo_on: at(&system, "AxesServoOnStatus"),
                actual: at(&system, "ActualPosition"),
                frames: ["ActiveToolFrameID", "ActiveWorkFrameID"].map(|name| at(&system, name)),
                turns: at(&system, "TurnsCounters"),
                configuration: at(&system, "RobotConfiguration"),
            },
            group: GroupLayout {
                status: at(&group, "GroupStatus"),
                fault: at(&group, "GroupFault"),
                axis_fault: at(&group, "AxisFault"),
                task: [
                    "TaskMaxScanTime",
                    "TaskLastScanTime",
                    "TaskAverageScanTime",
                    "TaskLastIOTime",
                    "TaskMaxIOTime",
                    "TaskAverageIOTime",
                ]
                .map(|name| at(&group, name)),
            },
        }
    }

    /// `overlapping`: the motion task was still running when its next period began.
    pub(super) fn snapshot(&self, snapshot: &Snapshot, overlapping: bool, memory: &mut Memory) {
        let group_fault = if overlapping { axis_fault::GROUP_FAULT } else { 0 };
        let mut faults = 0;
        let axes = snapshot.axes.iter().zip(&self.is_virtual);
        for (row, (axis, is_virtual)) in (FIRST_AXIS..).zip(axes) {
            faults |= axis.fault;
            let layout = if *is_virtual { &self.virtual_ } else { &self.cip };
            if let Some(bytes) = memory.get_mut(row) {
                layout.encode(axis, group_fault, bytes);
            }
        }
        for (row, system) in (FIRST_AXIS + self.is_virtual.len()..).zip(&snapshot.systems) {
            if let Some(bytes) = memory.get_mut(row) {
                self.system.encode(system, group_fault, bytes);
            }
        }
        if let Some(group) = memory.get_mut(GROUP_TAG) {
            put(group, self.group.status, GROUP_RUNNING.to_le_bytes());
            // The group has no bit for motion faults of axes: they show as physical ones.
            if faults & axis_fault::MOTION_FAULT != 0 {
                faults |= axis_fault::PHYSICAL_AXIS_FAULT;
            }
            put(group, self.group.axis_fault, (faults & GROUP_AXIS_FAULTS).to_le_bytes());
        }
    }

    pub(super) fn health(&self, health: &Health, memory: &mut Memory) {
        let Some(group) = memory.get_mut(GROUP_TAG) else { return };
        let (scan, io) = (&health.compute, &health.lateness);
        let times = [scan.max, scan.last, scan.average, io.last, io.max, io.average];
        for (offset, time) in self.group.task.into_iter().zip(times) {
            put(group, offset, (time.round() as i32).to_le_bytes());
        }
        put(group, self.group.fault, u32::from(health.overlapping).to_le_bytes());
    }

    /// Attributes of the drives, which do not change.
    pub(super) fn constants(&self, machine: &Machine, memory: &mut Memory) {
        let template = predefined::axis_cip_drive();
        let bandwidth = template
            .member("PositionLoopBandwidth")
            .map(|member| member.offset as usize);
        let feedforward = template
            .member("VelocityFeedforwardGain")
            .map(|member| member.offset as usize);
        for (row, (axis, drive)) in (FIRST_AXIS..).zip(machine.axes.iter().zip(&machine.drives)) {
            let Some(bytes) = memory.get_mut(row) else { continue };
            let layout = if axis.is_virtual() { &self.virtual_ } else { &self.cip };
            if let Some(offset) = layout.interpolation_time {
                put(bytes, offset, 0i32.to_le_bytes());
            }
            if let Some(drive) = drive {
                let percent = drive.settings.feedforward * 100.0;
                for (offset, value) in [(bandwidth, drive.settings.bandwidth), (feedforward, percent)] {
                    if let Some(offset) = offset {
                        put(bytes, offset, (value as f32).to_le_bytes());
                    }
                }
            }
        }
    }
}

impl AxisLayout {
    fn new(template: &Template) -> Self {
        use AxisField::{
            CipAlarms, CipFaults, CipState, CipStatus, Dint, Event, Fault, MotionAlarms, MotionFaults, MotionStatus,
            Real, Status,
        };
        let fields: [(&str, AxisField); 47] = [
            ("AxisFault", Fault),
            ("AxisStatus", Status),
            ("AxisEvent", Event),
            ("MotionStatus", MotionStatus),
            ("MotionFaultStatus", MotionFaults),
            ("MotionAlarmStatus", MotionAlarms),
            ("CIPAxisFaults", CipFaults),
            ("CIPAxisAlarms", CipAlarms),
            ("CIPAxisState", CipState),
            ("CIPAxisStatus", CipStatus),
            ("CommandPosition", Real(|axis| axis.command[0])),
            ("CommandVelocity", Real(|axis| axis.command[1])),
            ("CommandAcceleration", Real(|axis| axis.command[2])),
            ("ActualPosition", Real(|axis| axis.actual[0])),
            ("ActualVelocity", Real(|axis| axis.actual[1])),
            ("AverageVelocity", Real(|axis| axis.average_velocity)),
            ("ActualAcceleration", Real(|axis| axis.actual[2])),
            ("VelocityFeedback", Real(|axis| axis.actual[1])),
            ("VelocityError", Real(|axis| axis.command[1] - axis.actual[1])),
            ("PositionError", Real(|axis| axis.position_error)),
            ("StartCommandPosition", Real(|axis| axis.started_at[0])),
            ("StartActualPosition", Real(|axis| axis.started_at[1])),
            ("StrobeCommandPosition", Real(|axis| axis.strobed[0])),
            ("StrobeActualPosition", Real(|axis| axis.strobed[1])),
            ("WatchPosition", Real(|axis| axis.watched)),
            ("Registration1Position", Real(|axis| axis.registered[0][0])),
            ("Registration1PositiveEdgePosition", Real(|axis| axis.registered[0][1])),
            ("Registration1NegativeEdgePosition", Real(|axis| axis.registered[0][2])),
            ("Registration2Position", Real(|axis| axis.registered[1][0])),
            ("Registration2PositiveEdgePosition", Real(|axis| axis.registered[1][1])),
            ("Registration2NegativeEdgePosition", Real(|axis| axis.registered[1][2])),
            ("Registration1Time", Dint(|axis| axis.registered_at[0][0])),
            ("Registration1PositiveEdgeTime", Dint(|axis| axis.registered_at[0][1])),
            ("Registration1NegativeEdgeTime", Dint(|axis| axis.registered_at[0][2])),
            ("Registration2Time", Dint(|axis| axis.registered_at[1][0])),
            ("Registration2PositiveEdgeTime", Dint(|axis| axis.registered_at[1][1])),
            ("Registration2NegativeEdgeTime", Dint(|axis| axis.registered_at[1][2])),
            ("CIPAxisIOStatus", Dint(|axis| axis.cip_io as i32)),
            ("MasterOffset", Real(|axis| axis.master_offset[0])),
            ("StartMasterOffset", Real(|axis| axis.master_offset[1])),
            ("StrobeMasterOffset", Real(|axis| axis.master_offset[2])),
            ("OutputCamStatus", Dint(|axis| axis.output_cams[0] as i32)),
            ("OutputCamPendingStatus", Dint(|axis| axis.output_cams[1] as i32)),
            ("OutputCamLockStatus", Dint(|axis| axis.output_cams[2] as i32)),
            ("OutputCamTransitionStatus", Dint(|axis| axis.output_cams[3] as i32)),
            ("InterpolatedActualPosition", Real(|axis| axis.actual[0])),
            ("InterpolatedCommandPosition", Real(|axis| axis.command[0])),
        ];
        let places = fields
            .into_iter()
            .filter_map(|(name, field)| template.member(name).map(|member| (member.offset as usize, field)));
        AxisLayout {
            fields: places.collect(),
            interpolation_time: template
                .member("InterpolationTime")
                .map(|member| member.offset as usize),
        }
    }

    fn encode(&self, axis: &AxisSnapshot, group_fault: u32, bytes: &mut [u8]) {
        for (offset, field) in &self.fields {
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
                AxisField::Real(of) => put(bytes, *offset, (of(axis) as f32).to_le_bytes()),
            }
        }
    }
}

impl SystemLayout {
    fn encode(&self, system: &SystemSnapshot, group_fault: u32, bytes: &mut [u8]) {
        put(bytes, self.status, system.status.to_le_bytes());
        put(bytes, self.motion_status, system.motion_status.to_le_bytes());
        put(bytes, self.fault, (system.fault | group_fault).to_le_bytes());
        put(bytes, self.faulted, system.axes_faulted.to_le_bytes());
        put(bytes, self.shutdown, system.axes_shutdown.to_le_bytes());
        put(bytes, self.servo_on, system.axes_servo_on.to_le_bytes());
        for (row, actual) in system.actual.iter().enumerate() {
            put(bytes, self.actual + 4 * row, (*actual as f32).to_le_bytes());
        }
        for (offset, id) in self.frames.into_iter().zip(system.frames) {
            put(bytes, offset, id.to_le_bytes());
        }
        for (row, turns) in system.turns.iter().enumerate() {
            put(bytes, self.turns + 2 * row, turns.to_le_bytes());
        }
        put(bytes, self.configuration, system.configuration.to_le_bytes());
    }
}

/// The offset of a member of a predefined type.
fn at(template: &Template, name: &str) -> usize {
    template.member(name).expect("a member of a predefined type").offset as usize
}

fn put<const N: usize>(bytes: &mut [u8], offset: usize, value: [u8; N]) {
    if let Some(row) = bytes.get_mut(offset..offset + N) {
        row.copy_from_slice(&value);
    }
}

/// The place of the group's tag; axes are behind it, coordinate systems behind them.
const GROUP_TAG: usize = 0;
/// The place of the first axis's tag.
const FIRST_AXIS: usize = 1;
/// GroupStatus of a running group: GroupSynced and the timer event (spec/axis-and-data-types.md §8.8).
const GROUP_RUNNING: u32 = 6;
/// The bits of an axis's AxisFault that the group collects.
const GROUP_AXIS_FAULTS: u32 = 7;

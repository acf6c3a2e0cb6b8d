//! Instructions of a coordinate system.

use super::bits::*;
use super::groups::{DynamicsOperands, EventOperands, LockOperands, StopOperands};
use super::resolve::{resolved, total};
use super::row::*;
use crate::enumerations::*;
use crate::instruction::{ArrayRule, Axes, Instruction, Object, Range, Timing};
use crate::operands::{OperandReader, OperandValue, Operands};
use crate::{AxisId, Mnemonic, RealArray, SystemId, TagAddress, WrittenArray};

const POSITION_NOTE: &str = "position units: end point or increments";
const TOLERANCE_NOTE: &str = "position units; used by termination type 6";
const PROGRAMMED_TOLERANCE: i32 = TerminationType::CommandToleranceProgrammed as i32;
const KNOWN_NOTE: &str = "the known position";
const RESULT_NOTE: &str = "receives the other position";
const POSE_NOTE: &str = "forward: written, inverse: read";

const fn orientation() -> Row<RealArray> {
    array(ArrayRule::AtLeast(3), "degrees")
}

const fn translation() -> Row<RealArray> {
    array(ArrayRule::AtLeast(3), "position units")
}

const fn frame() -> Row<Option<TagAddress>> {
    structure_or_none("POSITION_DATA", "0: no offset")
}

instructions! {
    MCLM = Mclm on CoordinateSystem, Process, PATH_BITS_CALCULATED, Axes { least: 1, most: 3 },
    "Moves a coordinate system of 1 to 3 axes along a straight line.": [
        coordinate_system = system(), motion_control = control(),
        move_type: MoveType = word(),
        position: RealArray = array(ArrayRule::PerAxis, POSITION_NOTE),
        dynamics as DynamicsOperands = DynamicsOperands::rows(&SPEED_UNITS, &RATE_UNITS, &JERK_UNITS),
        termination_type: TerminationType = word(),
        merge: Merge = word(),
        merge_speed: MergeSpeed = word(),
        command_tolerance: f64 = number(Range::NotNegative, TOLERANCE_NOTE).when("Termination Type", PROGRAMMED_TOLERANCE),
        lock as LockOperands = LockOperands::rows(),
        events as EventOperands = EventOperands::rows(),
    ];

    MCCM = Mccm on CoordinateSystem, Process, PATH_BITS_CALCULATED, Axes { least: 2, most: 3 },
    "Moves a coordinate system of 2 or 3 axes along an arc or a full circle.": [
        coordinate_system = system(), motion_control = control(),
        move_type: MoveType = word(),
        position: RealArray = array(ArrayRule::PerAxis, POSITION_NOTE),
        circle_type: CircleType = word(),
        via_center_radius: RealArray = per_axis_unless(
            "Circle Type", CircleType::Radius as i32, "position units, as Circle Type says").named("Via/Center/Radius"),
        direction: CircleDirection = word(),
        dynamics as DynamicsOperands = DynamicsOperands::rows(&SPEED_UNITS, &RATE_UNITS, &JERK_UNITS),
        termination_type: TerminationType = word(),
        merge: Merge = word(),
        merge_speed: MergeSpeed = word(),
        command_tolerance: f64 = number(Range::NotNegative, TOLERANCE_NOTE).when("Termination Type", PROGRAMMED_TOLERANCE),
        lock as LockOperands = LockOperands::rows(),
        events as EventOperands = EventOperands::rows(),
    ];

    MCCD = Mccd on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Changes speed, rates or jerks of the active coordinated move, and of the pending one.": [
        coordinate_system = system(), motion_control = control(),
        motion_type: MccdMotionType = word().first(1.0),
        change_speed: NoYes = change(),
        speed: f64 = speed().changed_by("Change Speed"),
        speed_units: SpeedUnits = speed_units(&SPEED_UNITS),
        change_accel: NoYes = change(),
        accel_rate: f64 = accel_rate().changed_by("Change Accel"),
        accel_units: RateUnits = rate_units(&RATE_UNITS),
        change_decel: NoYes = change(),
        decel_rate: f64 = decel_rate().changed_by("Change Decel"),
        decel_units: RateUnits = rate_units(&RATE_UNITS),
        change_accel_jerk: NoYes = change(),
        accel_jerk: f64 = jerk().changed_by("Change Accel Jerk"),
        change_decel_jerk: NoYes = change(),
        decel_jerk: f64 = jerk().changed_by("Change Decel Jerk"),
        jerk_units: JerkUnits = jerk_units(&JERK_UNITS),
        scope: Scope = word(),
    ];

    MCS = Mcs on CoordinateSystem, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Stops the motion of a coordinate system, or its transforms.": [
        coordinate_system = system(), motion_control = control(),
        stop_type: McsStopType = word(),
        rates as StopOperands = StopOperands::rows(),
    ];

    MCSD = Mcsd on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Puts all axes of a coordinate system into shutdown.": [coordinate_system = system(), motion_control = control()];

    MCSR = Mcsr on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Takes all axes of a coordinate system out of shutdown.": [coordinate_system = system(), motion_control = control()];

    MDCC = Mdcc on CoordinateSystem, Immediate, EN_DN_ER_IP_AC, Axes::ANY,
    "Links a coordinate system to a master axis for master driven moves.": [
        slave_system = system(),
        master_axis: Option<AxisId> = other_axis("no axis of the slave system"),
        motion_control = control(),
        master_reference: Reference = word(),
        nominal_master_velocity: f64 = number(
            Range::NotNegative, "master units/s; for speeds in % when master driven"),
    ];

    MCT = Mct on CoordinateSystem, Process, EN_DN_ER_IP, Axes::ANY,
    "Starts a transform between two coordinate systems.": [
        source_system = system(),
        target_system: Option<SystemId> = other_system(),
        motion_control = control(),
        orientation: RealArray = orientation(),
        translation: RealArray = translation(),
    ];

    MCTP = Mctp on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates a position in one coordinate system from one in another, without motion.": [
        source_system = system(),
        target_system: Option<SystemId> = other_system(),
        motion_control = control(),
        orientation: RealArray = orientation(),
        translation: RealArray = translation(),
        transform_direction: TransformDirection = word(),
        reference_position: RealArray = array(ArrayRule::AtLeast(3), KNOWN_NOTE),
        transform_position: Option<WrittenArray> = written(9, RESULT_NOTE),
    ];

    MCPM = Mcpm on CoordinateSystem, Process, PATH_BITS, Axes::ANY,
    "Moves position and orientation of a coordinate system along a path.": [
        coordinate_system = system(), motion_control = control(),
        path: Option<TagAddress> = structure("PATH_DATA", ""),
        length: i32 = count(Range::Between(1.0, 1.0), "number of path elements, always 1").first(1.0),
        dynamics: Option<TagAddress> = structure("DYNAMICS_DATA", ""),
        lock as LockOperands = LockOperands::rows(),
    ];

    MCTO = Mcto on CoordinateSystem, Process, EN_DN_ER_IP, Axes::ANY,
    "Starts a transform with orientation between a Cartesian and a robot system.": [
        cartesian_system = system(),
        robot_system: Option<SystemId> = other_system(),
        motion_control = control(),
        work_frame: Option<TagAddress> = frame(),
        tool_frame: Option<TagAddress> = frame(),
    ];

    MCTPO = Mctpo on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates a point with orientation from joint positions or the reverse, without motion.": [
        cartesian_system = system(),
        robot_system: Option<SystemId> = other_system(),
        motion_control = control(),
        work_frame: Option<TagAddress> = frame(),
        tool_frame: Option<TagAddress> = frame(),
        transform_direction: TransformDirection = word(),
        reference_position: RealArray = array(ArrayRule::AtLeast(6), KNOWN_NOTE),
        transform_position: Option<WrittenArray> = written(9, RESULT_NOTE),
        robot_configuration: Option<TagAddress> = structure("DINT", POSE_NOTE),
        turns_counter: Option<TagAddress> = structure("INT[4]", POSE_NOTE),
    ];
}

//! Instructions of an axis.

use super::bits::*;
use super::groups::{DynamicsOperands, EventOperands, LockOperands, StopOperands};
use super::resolve::{resolved, total};
use super::row::*;
use crate::enumerations::*;
use crate::instruction::{Axes, Instruction, Object, Range, Timing};
use crate::operands::{OperandReader, OperandValue, Operands};
use crate::{AxisId, Mnemonic, TagAddress};

const CAM_PROFILE_NOTE: &str = "a calculated profile";
const TARGET_NOTE: &str = "0 to below the axis's output_cam_execution_targets (35)";
const INPUT_NOTE: &str = "registration input of the axis";
const COUNTS: Range = Range::Between(1.0, 32767.0);
const INPUTS: Range = Range::Between(1.0, 2.0);
const FRACTION: i32 = RatioFormat::Fraction as i32;
const WINDOW: i32 = Windowed::Enabled as i32;

instructions! {
    MSO = Mso on Axis, Message, EN_DN_ER, Axes::ANY,
    "Energises the drive and closes the servo loop at the present position.": [axis = axis(), motion_control = control()];

    MSF = Msf on Axis, Message, EN_DN_ER, Axes::ANY,
    "Opens the servo loop and de-energises the drive.": [axis = axis(), motion_control = control()];

    MASD = Masd on Axis, Message, EN_DN_ER, Axes::ANY,
    "Puts the axis into shutdown; all its motion ends at once.": [axis = axis(), motion_control = control()];

    MASR = Masr on Axis, Message, EN_DN_ER, Axes::ANY,
    "Clears all faults of the axis and takes it out of shutdown; the servo stays off.": [
        axis = axis(), motion_control = control(),
    ];

    MAFR = Mafr on Axis, Message, EN_DN_ER, Axes::ANY,
    "Clears the faults of the axis.": [axis = axis(), motion_control = control()];

    MAS = Mas on Axis, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Stops one kind of motion of the axis, or all of it.": [
        axis = axis(), motion_control = control(),
        stop_type: MasStopType = word(),
        rates as StopOperands = StopOperands::rows(),
    ];

    MAH = Mah on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Homes the axis by its configured sequence.": [axis = axis(), motion_control = control()];

    MAJ = Maj on Axis, Process, JOG_BITS, Axes::ANY,
    "Moves the axis at a constant speed until something ends it.": [
        axis = axis(), motion_control = control(),
        direction: JogDirection = word(),
        dynamics as DynamicsOperands = DynamicsOperands::rows(&SPEED_UNITS, &RATE_UNITS, &JERK_UNITS),
        merge: AxisMerge = word(),
        merge_speed: MergeSpeed = word(),
        lock as LockOperands = LockOperands::rows(),
    ];

    MAM = Mam on Axis, Process, PATH_BITS_CALCULATED, Axes::ANY,
    "Moves the axis to a position or by a distance.": [
        axis = axis(), motion_control = control(),
        move_type: MamMoveType = word(),
        position: f64 = number(
            Range::Any, "position units: end position or distance; of a master offset in units of the master"),
        dynamics as DynamicsOperands = DynamicsOperands::rows(&MAM_SPEED_UNITS, &MAM_RATE_UNITS, &MAM_JERK_UNITS),
        merge: AxisMerge = word(),
        merge_speed: MergeSpeed = word(),
        lock as LockOperands = LockOperands::rows(),
        events as EventOperands = EventOperands::rows(),
    ];

    MAG = Mag on Axis, Process, EN_DN_ER_IP, Axes::ANY,
    "Gears the slave axis to a master axis.": [
        slave_axis = axis(),
        master_axis: Option<AxisId> = other_axis(""),
        motion_control = control(),
        direction: GearDirection = word(),
        ratio: f64 = number(Range::Between(0.00001, 9.99999), "slave units per master unit; format Real")
            .when("Ratio Format", RatioFormat::Real as i32).first(1.0),
        slave_counts: i32 = count(COUNTS, "format Fraction").when("Ratio Format", FRACTION).first(1.0),
        master_counts: i32 = count(COUNTS, "format Fraction").when("Ratio Format", FRACTION).first(1.0),
        master_reference: Reference = word(),
        ratio_format: RatioFormat = word(),
        clutch: Clutch = word(),
        accel_rate: f64 = rate("in Accel Units; used with the clutch").when("Clutch", Clutch::Enabled as i32),
        accel_units: RateUnits = rate_units(&STOP_RATE_UNITS),
    ];

    MCD = Mcd on Axis, Immediate, EN_DN_ER, Axes::ANY,
    "Changes speed, rates or jerks of the running move or jog of the axis.": [
        axis = axis(), motion_control = control(),
        motion_type: McdMotionType = word(),
        change_speed: NoYes = change(),
        speed: f64 = speed().changed_by("Change Speed"),
        change_accel: NoYes = change(),
        accel_rate: f64 = accel_rate().changed_by("Change Accel"),
        change_decel: NoYes = change(),
        decel_rate: f64 = decel_rate().changed_by("Change Decel"),
        change_accel_jerk: NoYes = change(),
        accel_jerk: f64 = jerk().changed_by("Change Accel Jerk"),
        change_decel_jerk: NoYes = change(),
        decel_jerk: f64 = jerk().changed_by("Change Decel Jerk"),
        speed_units: SpeedUnits = speed_units(&SPEED_UNITS),
        accel_units: RateUnits = rate_units(&RATE_UNITS),
        decel_units: RateUnits = rate_units(&RATE_UNITS),
        jerk_units: JerkUnits = jerk_units(&JERK_UNITS),
    ];

    MRP = Mrp on Axis, Message, EN_DN_ER, Axes::ANY,
    "Changes the actual or command position of the axis without moving it.": [
        axis = axis(), motion_control = control(),
        redefine_type: RedefineType = word().named("Type"),
        position_select: Reference = word_of(&POSITION_SELECT),
        position: f64 = number(Range::Any, "position units: new position or offset"),
    ];

    MDAC = Mdac on Axis, Immediate, EN_DN_ER_IP_AC, Axes::ANY,
    "Links the slave axis to a master axis for master driven motion.": [
        slave_axis = axis(),
        master_axis: Option<AxisId> = other_axis(""),
        motion_control = control(),
        motion_type: MdacMotionType = word(),
        master_reference: Reference = word(),
    ];

    MAPC = Mapc on Axis, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Moves the slave axis by a cam profile over the position of a master axis.": [
        slave_axis = axis(),
        master_axis: Option<AxisId> = other_axis(""),
        motion_control = control(),
        direction: GearDirection = word(),
        cam_profile: Option<TagAddress> = structure("CAM_PROFILE", CAM_PROFILE_NOTE),
        slave_scaling: f64 = number(Range::Positive, "").first(1.0),
        master_scaling: f64 = number(Range::Positive, "").first(1.0),
        execution_mode: ExecutionMode = word(),
        execution_schedule: ExecutionSchedule = word(),
        master_lock_position: f64 = number(Range::Any, "master units"),
        cam_lock_position: f64 = number(Range::Any, "units of the profile's master"),
        master_reference: Reference = word().behind_ignored("Cam Type"),
        master_direction: MasterDirection = word(),
    ];

    MATC = Matc on Axis, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Moves the axis by a cam profile over time, or over the distance of a master that MDAC links.": [
        axis = axis(), motion_control = control(),
        direction: GearDirection = word(),
        cam_profile: Option<TagAddress> = structure("CAM_PROFILE", CAM_PROFILE_NOTE),
        distance_scaling: f64 = number(Range::Positive, "").first(1.0),
        time_scaling: f64 = number(Range::Positive, "").first(1.0),
        execution_mode: ExecutionMode = word_of(&TIME_CAM_EXECUTION_MODE),
        execution_schedule: ExecutionSchedule = word_of(&TIME_CAM_EXECUTION_SCHEDULE),
        lock as LockOperands = LockOperands::rows(),
        instruction_mode: InstructionMode = word(),
    ];

    MAW = Maw on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Watches for the actual position of the axis to pass a position.": [
        axis = axis(), motion_control = control(),
        trigger_condition: WatchTrigger = word(),
        position: f64 = number(Range::Any, "position units"),
    ];

    MDW = Mdw on Axis, Message, EN_DN_ER, Axes::ANY,
    "Ends the watch of the axis's position.": [axis = axis(), motion_control = control()];

    MAR = Mar on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Latches the actual position of the axis at an edge of a registration input.": [
        axis = axis(), motion_control = control(),
        trigger_condition: RegistrationTrigger = word(),
        windowed_registration: Windowed = word(),
        min_position: f64 = number(Range::Any, "position units; beginning of the window").when("Windowed Registration", WINDOW),
        max_position: f64 = number(Range::Any, "position units; end of the window").when("Windowed Registration", WINDOW),
        input_number: i32 = count(INPUTS, INPUT_NOTE).first(1.0),
    ];

    MDR = Mdr on Axis, Message, EN_DN_ER, Axes::ANY,
    "Ends the wait for a registration input.": [
        axis = axis(), motion_control = control(),
        input_number: i32 = count(INPUTS, INPUT_NOTE).first(1.0),
    ];

    MAOC = Maoc on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Sets and clears bits of a DINT by the position of the axis.": [
        axis = axis(),
        execution_target: i32 = count(Range::Any, TARGET_NOTE),
        motion_control = control(),
        output: Option<TagAddress> = structure("DINT", "its bits are set and cleared"),
        input: Option<TagAddress> = structure_or_none("DINT", "its bits enable"),
        output_cam: Option<TagAddress> = structure("OUTPUT_CAM", "an array, all of which is used"),
        cam_start_position: f64 = number(Range::Any, "position units"),
        cam_end_position: f64 = number(Range::Any, "position units, above Cam Start Position"),
        output_compensation: Option<TagAddress> = structure_or_none(
            "OUTPUT_COMPENSATION", "an array, an element for each output bit"),
        execution_mode: ExecutionMode = word(),
        execution_schedule: ExecutionSchedule = word(),
        axis_arm_position: f64 = number(Range::Any, "position units"),
        cam_arm_position: f64 = number(Range::Any, "position units, within the cam"),
        position_reference: Reference = word_of(&POSITION_REFERENCE),
    ];

    MDOC = Mdoc on Axis, Immediate, EN_DN_ER, Axes::ANY,
    "Ends output cams of the axis.": [
        axis = axis(),
        execution_target: i32 = count(Range::Any, TARGET_NOTE),
        motion_control = control(),
        disarm_type: DisarmType = word(),
    ];
}

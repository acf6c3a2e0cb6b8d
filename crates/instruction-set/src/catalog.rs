//! The faceplates: the only place where the operands of an instruction are listed.
//!
//! Operands stand in faceplate order; the place of one, counted from 0, is also the EXERR of "Parameter Out
//! Of Range" (13). Sources: spec/coordinated-instructions.md §12–§25, spec/axis-and-data-types.md §2–§4.

use crate::enumerations::*;
use crate::instruction::{ArrayRule, Axes, Condition, Instruction, Kind, Object, Operand, Range, Timing};
use crate::{Flag, Mnemonic, Words};

/// Class 0x0300 in the order of the service codes.
pub const MOTION_GROUP: &[Mnemonic] = &[
    Mnemonic::Mgs,
    Mnemonic::Mgsd,
    Mnemonic::Mgsr,
    Mnemonic::Mgsp,
    Mnemonic::Mccp,
    Mnemonic::Mcsv,
];

/// Class 0x0301 in the order of the service codes.
pub const AXIS: &[Mnemonic] = &[
    Mnemonic::Mso,
    Mnemonic::Msf,
    Mnemonic::Masd,
    Mnemonic::Masr,
    Mnemonic::Mafr,
    Mnemonic::Mas,
    Mnemonic::Mah,
    Mnemonic::Maj,
    Mnemonic::Mam,
    Mnemonic::Mag,
    Mnemonic::Mcd,
    Mnemonic::Mrp,
    Mnemonic::Mdac,
    Mnemonic::Mapc,
    Mnemonic::Matc,
    Mnemonic::Maw,
    Mnemonic::Mdw,
    Mnemonic::Mar,
    Mnemonic::Mdr,
    Mnemonic::Maoc,
    Mnemonic::Mdoc,
];

/// Class 0x0302 in the order of the service codes.
pub const COORDINATE_SYSTEM: &[Mnemonic] = &[
    Mnemonic::Mclm,
    Mnemonic::Mccm,
    Mnemonic::Mccd,
    Mnemonic::Mcs,
    Mnemonic::Mcsd,
    Mnemonic::Mcsr,
    Mnemonic::Mdcc,
    Mnemonic::Mct,
    Mnemonic::Mctp,
    Mnemonic::Mcpm,
    Mnemonic::Mcto,
    Mnemonic::Mctpo,
];

const EN_DN_ER: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er];
const EN_DN_ER_IP: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er, Flag::Ip];
const EN_DN_ER_IP_AC: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er, Flag::Ip, Flag::Ac];
const EN_DN_ER_IP_PC: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er, Flag::Ip, Flag::Pc];
const JOG_BITS: &[Flag] = &[
    Flag::En,
    Flag::Dn,
    Flag::Er,
    Flag::Ip,
    Flag::Ac,
    Flag::Accel,
    Flag::Decel,
    Flag::TrackingMaster,
];
const PATH_BITS: &[Flag] = &[
    Flag::En,
    Flag::Dn,
    Flag::Er,
    Flag::Ip,
    Flag::Ac,
    Flag::Pc,
    Flag::Accel,
    Flag::Decel,
    Flag::TrackingMaster,
];

const FULL_SCALE: f32 = 100.0;
const PERCENT_OF_MAXIMUM: f32 = 1.0;
const PERCENT_OF_TIME: f32 = 2.0;
const S_CURVE: f32 = 1.0;

const fn operand(name: &'static str, kind: Kind, note: &'static str) -> Operand {
    Operand {
        name,
        kind,
        condition: Condition::Always,
        initial: 0.0,
        note,
    }
}

const fn target(name: &'static str, object: Object) -> Operand {
    operand(name, Kind::Target(object), "")
}

const fn motion_control() -> Operand {
    operand(
        "Motion Control",
        Kind::MotionControl,
        "a MOTION_INSTRUCTION tag of its own",
    )
}

const fn reference(name: &'static str, object: Object, note: &'static str) -> Operand {
    operand(name, Kind::Reference(object), note)
}

const fn word(name: &'static str, words: &'static Words) -> Operand {
    operand(name, Kind::Word(words), "")
}

const fn number(name: &'static str, range: Range, note: &'static str) -> Operand {
    operand(name, Kind::Number(range), note)
}

impl Operand {
    /// First value in an instruction tag.
    const fn first(self, initial: f32) -> Operand {
        Operand { initial, ..self }
    }

    /// Range looked at only when the operand at `flag` is Yes.
    const fn changed_by(self, flag: u8) -> Operand {
        Operand {
            condition: Condition::Changed(flag),
            ..self
        }
    }

    /// Range looked at only when the operand at `operand` has this value.
    const fn when(self, operand: u8, value: i32) -> Operand {
        Operand {
            condition: Condition::When { operand, value },
            ..self
        }
    }
}

const fn speed() -> Operand {
    number(
        "Speed",
        Range::NotNegative,
        "in Speed Units; 0: the move waits until MCCD or MCD gives it a speed",
    )
    .first(FULL_SCALE)
}

const fn rate(name: &'static str, note: &'static str) -> Operand {
    number(name, Range::Positive, note).first(FULL_SCALE)
}

const fn units(name: &'static str, words: &'static Words) -> Operand {
    word(name, words).first(PERCENT_OF_MAXIMUM)
}

const fn jerk(name: &'static str, units: u8) -> Operand {
    number(name, Range::Jerk { units }, "in Jerk Units; used by an S-curve only").first(FULL_SCALE)
}

const fn jerk_units(words: &'static Words) -> Operand {
    word("Jerk Units", words).first(PERCENT_OF_TIME)
}

const fn profile() -> Operand {
    word("Profile", &PROFILE).first(S_CURVE)
}

const ACCEL_NOTE: &str = "in Accel Units";
const DECEL_NOTE: &str = "in Decel Units";
const LOCK_NOTE: &str = "master units; used when master driven";
const EVENT_NOTE: &str = "distances before the end of the move, position units";
const CALCULATED_NOTE: &str = "receives seconds (master driven: master units) from the start to each event distance";
const CALCULATED_ELEMENTS: u16 = 4;

const fn lock_position() -> Operand {
    number("Lock Position", Range::Any, LOCK_NOTE)
}

const fn event_distance() -> Operand {
    operand("Event Distance", Kind::ArrayOrNone, EVENT_NOTE)
}

const fn calculated_data() -> Operand {
    operand(
        "Calculated Data",
        Kind::WrittenArray(CALCULATED_ELEMENTS),
        CALCULATED_NOTE,
    )
}

const fn axis() -> Operand {
    target("Axis", Object::Axis)
}

const fn system() -> Operand {
    target("Coordinate System", Object::CoordinateSystem)
}

macro_rules! instructions {
    ($($constant:ident = $mnemonic:ident on $object:ident, $timing:ident, $bits:expr, $axes:expr, $summary:literal:
       [$($operand:expr),* $(,)?];)*) => {
        $(
            #[doc = $summary]
            pub static $constant: Instruction = Instruction {
                mnemonic: Mnemonic::$mnemonic,
                title: Mnemonic::$mnemonic.title(),
                summary: $summary,
                object: Object::$object,
                timing: Timing::$timing,
                bits: $bits,
                axes: $axes,
                operands: &[$($operand),*],
            };
        )*
    };
}

instructions! {
    MGS = Mgs on MotionGroup, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Stops all motion of all axes of the group.": [
        target("Group", Object::MotionGroup), motion_control(), word("Stop Mode", &STOP_MODE),
    ];

    MGSD = Mgsd on MotionGroup, Message, EN_DN_ER, Axes::ANY,
    "Puts every axis of the group into shutdown.": [target("Group", Object::MotionGroup), motion_control()];

    MGSR = Mgsr on MotionGroup, Message, EN_DN_ER, Axes::ANY,
    "Clears the faults and takes every axis of the group out of shutdown.": [
        target("Group", Object::MotionGroup), motion_control(),
    ];

    MGSP = Mgsp on MotionGroup, Immediate, EN_DN_ER, Axes::ANY,
    "Copies the positions of all axes into their Strobe members at one coarse update.": [
        target("Group", Object::MotionGroup), motion_control(),
    ];

    MCCP = Mccp on MotionGroup, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates a cam profile from the points of a cam.": [
        motion_control(),
        operand("Cam", Kind::Structure("CAM"), "the points, an array"),
        operand("Length", Kind::Integer(Range::Any), "points to use, 2 or more (26)").first(2.0),
        number("Start Slope", Range::Any, "of a cubic first segment, slave units per master unit"),
        number("End Slope", Range::Any, "of a cubic last segment, slave units per master unit"),
        operand("Cam Profile", Kind::Structure("CAM_PROFILE"), "receives the profile, an array of Length elements or more"),
    ];

    MCSV = Mcsv on MotionGroup, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates where a cam profile leads a slave, without motion.": [
        motion_control(),
        operand("Cam Profile", Kind::Structure("CAM_PROFILE"), "a calculated profile"),
        number("Master Value", Range::Any, "within the profile"),
        operand("Slave Value", Kind::WrittenArray(1), "receives the slave's position"),
        operand("Slope Value", Kind::WrittenArray(1), "receives the first derivative by the master"),
        operand("Slope Derivative", Kind::WrittenArray(1), "receives the second derivative by the master"),
    ];

    MSO = Mso on Axis, Message, EN_DN_ER, Axes::ANY,
    "Energises the drive and closes the servo loop at the present position.": [axis(), motion_control()];

    MSF = Msf on Axis, Message, EN_DN_ER, Axes::ANY,
    "Opens the servo loop and de-energises the drive.": [axis(), motion_control()];

    MASD = Masd on Axis, Message, EN_DN_ER, Axes::ANY,
    "Puts the axis into shutdown; all its motion ends at once.": [axis(), motion_control()];

    MASR = Masr on Axis, Message, EN_DN_ER, Axes::ANY,
    "Clears all faults of the axis and takes it out of shutdown; the servo stays off.": [axis(), motion_control()];

    MAFR = Mafr on Axis, Message, EN_DN_ER, Axes::ANY,
    "Clears the faults of the axis.": [axis(), motion_control()];

    MAS = Mas on Axis, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Stops one kind of motion of the axis, or all of it.": [
        axis(), motion_control(),
        word("Stop Type", &MAS_STOP_TYPE),
        word("Change Decel", &NO_YES),
        rate("Decel Rate", DECEL_NOTE).changed_by(3),
        units("Decel Units", &STOP_RATE_UNITS),
        word("Change Decel Jerk", &NO_YES),
        jerk("Decel Jerk", 8).changed_by(6),
        jerk_units(&STOP_JERK_UNITS),
    ];

    MAH = Mah on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Homes the axis by its configured sequence.": [axis(), motion_control()];

    MAJ = Maj on Axis, Process, JOG_BITS, Axes::ANY,
    "Moves the axis at a constant speed until something ends it.": [
        axis(), motion_control(),
        word("Direction", &JOG_DIRECTION),
        speed(), units("Speed Units", &SPEED_UNITS),
        rate("Accel Rate", ACCEL_NOTE), units("Accel Units", &RATE_UNITS),
        rate("Decel Rate", DECEL_NOTE), units("Decel Units", &RATE_UNITS),
        profile(), jerk("Accel Jerk", 12).when(9, 1), jerk("Decel Jerk", 12).when(9, 1), jerk_units(&JERK_UNITS),
        word("Merge", &AXIS_MERGE), word("Merge Speed", &MERGE_SPEED),
        lock_position(), word("Lock Direction", &LOCK_DIRECTION),
    ];

    MAM = Mam on Axis, Process, PATH_BITS_CALCULATED, Axes::ANY,
    "Moves the axis to a position or by a distance.": [
        axis(), motion_control(),
        word("Move Type", &MAM_MOVE_TYPE),
        number("Position", Range::Any, "position units: end position or distance; of a master offset in units of the master"),
        speed(), units("Speed Units", &MAM_SPEED_UNITS),
        rate("Accel Rate", ACCEL_NOTE), units("Accel Units", &MAM_RATE_UNITS),
        rate("Decel Rate", DECEL_NOTE), units("Decel Units", &MAM_RATE_UNITS),
        profile(), jerk("Accel Jerk", 13).when(10, 1), jerk("Decel Jerk", 13).when(10, 1),
        jerk_units(&MAM_JERK_UNITS),
        word("Merge", &AXIS_MERGE), word("Merge Speed", &MERGE_SPEED),
        lock_position(), word("Lock Direction", &LOCK_DIRECTION),
        event_distance(), calculated_data(),
    ];

    MAG = Mag on Axis, Process, EN_DN_ER_IP, Axes::ANY,
    "Gears the slave axis to a master axis.": [
        target("Slave Axis", Object::Axis),
        reference("Master Axis", Object::Axis, ""),
        motion_control(),
        word("Direction", &GEAR_DIRECTION),
        number("Ratio", Range::Between(0.00001, 9.99999), "slave units per master unit; format Real").when(8, 0).first(1.0),
        operand("Slave Counts", Kind::Integer(Range::Between(1.0, 32767.0)), "format Fraction").when(8, 1).first(1.0),
        operand("Master Counts", Kind::Integer(Range::Between(1.0, 32767.0)), "format Fraction").when(8, 1).first(1.0),
        word("Master Reference", &MASTER_REFERENCE),
        word("Ratio Format", &RATIO_FORMAT),
        word("Clutch", &CLUTCH),
        rate("Accel Rate", "in Accel Units; used with the clutch").when(9, 0),
        units("Accel Units", &STOP_RATE_UNITS),
    ];

    MCD = Mcd on Axis, Immediate, EN_DN_ER, Axes::ANY,
    "Changes speed, rates or jerks of the running move or jog of the axis.": [
        axis(), motion_control(),
        word("Motion Type", &MCD_MOTION_TYPE),
        word("Change Speed", &NO_YES), speed().changed_by(3),
        word("Change Accel", &NO_YES), rate("Accel Rate", ACCEL_NOTE).changed_by(5),
        word("Change Decel", &NO_YES), rate("Decel Rate", DECEL_NOTE).changed_by(7),
        word("Change Accel Jerk", &NO_YES), jerk("Accel Jerk", 16).changed_by(9),
        word("Change Decel Jerk", &NO_YES), jerk("Decel Jerk", 16).changed_by(11),
        units("Speed Units", &SPEED_UNITS),
        units("Accel Units", &RATE_UNITS),
        units("Decel Units", &RATE_UNITS),
        jerk_units(&JERK_UNITS),
    ];

    MRP = Mrp on Axis, Message, EN_DN_ER, Axes::ANY,
    "Changes the actual or command position of the axis without moving it.": [
        axis(), motion_control(),
        word("Type", &REDEFINE_TYPE),
        word("Position Select", &POSITION_SELECT),
        number("Position", Range::Any, "position units: new position or offset"),
    ];

    MDAC = Mdac on Axis, Immediate, EN_DN_ER_IP_AC, Axes::ANY,
    "Links the slave axis to a master axis for master driven motion.": [
        target("Slave Axis", Object::Axis),
        reference("Master Axis", Object::Axis, ""),
        motion_control(),
        word("Motion Type", &MDAC_MOTION_TYPE),
        word("Master Reference", &MASTER_REFERENCE),
    ];

    MAPC = Mapc on Axis, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Moves the slave axis by a cam profile over the position of a master axis.": [
        target("Slave Axis", Object::Axis),
        reference("Master Axis", Object::Axis, ""),
        motion_control(),
        word("Direction", &GEAR_DIRECTION),
        operand("Cam Profile", Kind::Structure("CAM_PROFILE"), "a calculated profile"),
        number("Slave Scaling", Range::Positive, "").first(1.0),
        number("Master Scaling", Range::Positive, "").first(1.0),
        word("Execution Mode", &EXECUTION_MODE),
        word("Execution Schedule", &EXECUTION_SCHEDULE),
        number("Master Lock Position", Range::Any, "master units"),
        number("Cam Lock Position", Range::Any, "units of the profile's master"),
        word("Master Reference", &MASTER_REFERENCE),
        word("Master Direction", &MASTER_DIRECTION),
    ];

    MATC = Matc on Axis, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Moves the axis by a cam profile over time, or over the way of a master that MDAC links.": [
        axis(), motion_control(),
        word("Direction", &GEAR_DIRECTION),
        operand("Cam Profile", Kind::Structure("CAM_PROFILE"), "a calculated profile"),
        number("Distance Scaling", Range::Positive, "").first(1.0),
        number("Time Scaling", Range::Positive, "").first(1.0),
        word("Execution Mode", &TIME_CAM_EXECUTION_MODE),
        word("Execution Schedule", &TIME_CAM_EXECUTION_SCHEDULE),
        lock_position(), word("Lock Direction", &LOCK_DIRECTION),
        word("Instruction Mode", &INSTRUCTION_MODE),
    ];

    MAW = Maw on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Watches for the actual position of the axis to pass a position.": [
        axis(), motion_control(),
        word("Trigger Condition", &WATCH_TRIGGER),
        number("Position", Range::Any, "position units"),
    ];

    MDW = Mdw on Axis, Message, EN_DN_ER, Axes::ANY,
    "Ends the watch of the axis's position.": [axis(), motion_control()];

    MAR = Mar on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Latches the actual position of the axis at an edge of a registration input.": [
        axis(), motion_control(),
        word("Trigger Condition", &REGISTRATION_TRIGGER),
        word("Windowed Registration", &WINDOWED),
        number("Min Position", Range::Any, "position units; beginning of the window").when(3, 1),
        number("Max Position", Range::Any, "position units; end of the window").when(3, 1),
        operand("Input Number", Kind::Integer(Range::Between(1.0, 2.0)), "registration input of the axis").first(1.0),
    ];

    MDR = Mdr on Axis, Message, EN_DN_ER, Axes::ANY,
    "Ends the wait for a registration input.": [
        axis(), motion_control(),
        operand("Input Number", Kind::Integer(Range::Between(1.0, 2.0)), "registration input of the axis").first(1.0),
    ];

    MAOC = Maoc on Axis, MessageProcess, EN_DN_ER_IP_PC, Axes::ANY,
    "Sets and clears bits of a DINT by the position of the axis.": [
        axis(),
        operand("Execution Target", Kind::Integer(Range::Any), "0 to below the axis's output_cam_execution_targets (35)"),
        motion_control(),
        operand("Output", Kind::Structure("DINT"), "its bits are set and cleared"),
        operand("Input", Kind::StructureOrNone("DINT"), "its bits enable"),
        operand("Output Cam", Kind::Structure("OUTPUT_CAM"), "an array, all of which is used"),
        number("Cam Start Position", Range::Any, "position units"),
        number("Cam End Position", Range::Any, "position units, above Cam Start Position"),
        operand("Output Compensation", Kind::StructureOrNone("OUTPUT_COMPENSATION"), "an array, an element for each output bit"),
        word("Execution Mode", &EXECUTION_MODE),
        word("Execution Schedule", &EXECUTION_SCHEDULE),
        number("Axis Arm Position", Range::Any, "position units"),
        number("Cam Arm Position", Range::Any, "position units, within the cam"),
        word("Position Reference", &POSITION_REFERENCE),
    ];

    MDOC = Mdoc on Axis, Immediate, EN_DN_ER, Axes::ANY,
    "Ends output cams of the axis.": [
        axis(),
        operand("Execution Target", Kind::Integer(Range::Any), "0 to below the axis's output_cam_execution_targets (35)"),
        motion_control(),
        word("Disarm Type", &DISARM_TYPE),
    ];

    MCLM = Mclm on CoordinateSystem, Process, PATH_BITS_CALCULATED, Axes { least: 1, most: 3 },
    "Moves a coordinate system of 1 to 3 axes along a straight line.": [
        system(), motion_control(),
        word("Move Type", &MOVE_TYPE),
        operand("Position", Kind::Array(ArrayRule::PerAxis), "position units: end point or increments"),
        speed(), units("Speed Units", &SPEED_UNITS),
        rate("Accel Rate", ACCEL_NOTE), units("Accel Units", &RATE_UNITS),
        rate("Decel Rate", DECEL_NOTE), units("Decel Units", &RATE_UNITS),
        profile(), jerk("Accel Jerk", 13).when(10, 1), jerk("Decel Jerk", 13).when(10, 1), jerk_units(&JERK_UNITS),
        word("Termination Type", &TERMINATION_TYPE),
        word("Merge", &MERGE), word("Merge Speed", &MERGE_SPEED),
        number("Command Tolerance", Range::NotNegative, "position units; used by termination type 6").when(14, 6),
        lock_position(), word("Lock Direction", &LOCK_DIRECTION),
        event_distance(), calculated_data(),
    ];

    MCCM = Mccm on CoordinateSystem, Process, PATH_BITS_CALCULATED, Axes { least: 2, most: 3 },
    "Moves a coordinate system of 2 or 3 axes along an arc or a full circle.": [
        system(), motion_control(),
        word("Move Type", &MOVE_TYPE),
        operand("Position", Kind::Array(ArrayRule::PerAxis), "position units: end point or increments"),
        word("Circle Type", &CIRCLE_TYPE),
        operand("Via/Center/Radius", Kind::Array(ArrayRule::PerAxisUnless { operand: 4, value: 2 }),
            "position units, as Circle Type says"),
        word("Direction", &DIRECTION),
        speed(), units("Speed Units", &SPEED_UNITS),
        rate("Accel Rate", ACCEL_NOTE), units("Accel Units", &RATE_UNITS),
        rate("Decel Rate", DECEL_NOTE), units("Decel Units", &RATE_UNITS),
        profile(), jerk("Accel Jerk", 16).when(13, 1), jerk("Decel Jerk", 16).when(13, 1), jerk_units(&JERK_UNITS),
        word("Termination Type", &TERMINATION_TYPE),
        word("Merge", &MERGE), word("Merge Speed", &MERGE_SPEED),
        number("Command Tolerance", Range::NotNegative, "position units; used by termination type 6").when(17, 6),
        lock_position(), word("Lock Direction", &LOCK_DIRECTION),
        event_distance(), calculated_data(),
    ];

    MCCD = Mccd on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Changes speed, rates or jerks of the active coordinated move, and of the pending one.": [
        system(), motion_control(),
        word("Motion Type", &MCCD_MOTION_TYPE).first(1.0),
        word("Change Speed", &NO_YES), speed().changed_by(3), units("Speed Units", &SPEED_UNITS),
        word("Change Accel", &NO_YES), rate("Accel Rate", ACCEL_NOTE).changed_by(6), units("Accel Units", &RATE_UNITS),
        word("Change Decel", &NO_YES), rate("Decel Rate", DECEL_NOTE).changed_by(9), units("Decel Units", &RATE_UNITS),
        word("Change Accel Jerk", &NO_YES), jerk("Accel Jerk", 16).changed_by(12),
        word("Change Decel Jerk", &NO_YES), jerk("Decel Jerk", 16).changed_by(14),
        jerk_units(&JERK_UNITS),
        word("Scope", &SCOPE),
    ];

    MCS = Mcs on CoordinateSystem, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Stops the motion of a coordinate system, or its transforms.": [
        system(), motion_control(),
        word("Stop Type", &MCS_STOP_TYPE),
        word("Change Decel", &NO_YES),
        rate("Decel Rate", DECEL_NOTE).changed_by(3),
        units("Decel Units", &STOP_RATE_UNITS),
        word("Change Decel Jerk", &NO_YES),
        jerk("Decel Jerk", 8).changed_by(6),
        jerk_units(&STOP_JERK_UNITS),
    ];

    MCSD = Mcsd on CoordinateSystem, Message, EN_DN_ER, Axes::ANY,
    "Puts all axes of a coordinate system into shutdown.": [system(), motion_control()];

    MCSR = Mcsr on CoordinateSystem, Message, EN_DN_ER, Axes::ANY,
    "Takes all axes of a coordinate system out of shutdown.": [system(), motion_control()];

    MDCC = Mdcc on CoordinateSystem, Immediate, EN_DN_ER_IP_AC, Axes::ANY,
    "Links a coordinate system to a master axis for master driven moves.": [
        target("Slave System", Object::CoordinateSystem),
        reference("Master Axis", Object::Axis, "no axis of the slave system"),
        motion_control(),
        word("Master Reference", &MASTER_REFERENCE),
        number("Nominal Master Velocity", Range::NotNegative, "master units/s; for speeds in % when master driven"),
    ];

    MCT = Mct on CoordinateSystem, Process, EN_DN_ER_IP, Axes::ANY,
    "Starts a transform between two coordinate systems.": [
        target("Source System", Object::CoordinateSystem),
        reference("Target System", Object::CoordinateSystem, ""),
        motion_control(),
        operand("Orientation", Kind::Array(ArrayRule::AtLeast(3)), "degrees"),
        operand("Translation", Kind::Array(ArrayRule::AtLeast(3)), "position units"),
    ];

    MCTP = Mctp on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates a position in one coordinate system from one in another, without motion.": [
        target("Source System", Object::CoordinateSystem),
        reference("Target System", Object::CoordinateSystem, ""),
        motion_control(),
        operand("Orientation", Kind::Array(ArrayRule::AtLeast(3)), "degrees"),
        operand("Translation", Kind::Array(ArrayRule::AtLeast(3)), "position units"),
        word("Transform Direction", &TRANSFORM_DIRECTION),
        operand("Reference Position", Kind::Array(ArrayRule::AtLeast(3)), "the known position"),
        operand("Transform Position", Kind::WrittenArray(9), "receives the other position"),
    ];

    MCPM = Mcpm on CoordinateSystem, Process, PATH_BITS, Axes::ANY,
    "Moves position and orientation of a coordinate system along a path.": [
        system(), motion_control(),
        operand("Path", Kind::Structure("PATH_DATA"), ""),
        operand("Length", Kind::Integer(Range::Between(1.0, 1.0)), "number of path elements, always 1").first(1.0),
        operand("Dynamics", Kind::Structure("DYNAMICS_DATA"), ""),
        lock_position(), word("Lock Direction", &LOCK_DIRECTION),
    ];

    MCTO = Mcto on CoordinateSystem, Process, EN_DN_ER_IP, Axes::ANY,
    "Starts a transform with orientation between a Cartesian and a robot system.": [
        target("Cartesian System", Object::CoordinateSystem),
        reference("Robot System", Object::CoordinateSystem, ""),
        motion_control(),
        operand("Work Frame", Kind::Structure("POSITION_DATA"), ""),
        operand("Tool Frame", Kind::Structure("POSITION_DATA"), ""),
    ];

    MCTPO = Mctpo on CoordinateSystem, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates a point with orientation from joint positions or the reverse, without motion.": [
        target("Cartesian System", Object::CoordinateSystem),
        reference("Robot System", Object::CoordinateSystem, ""),
        motion_control(),
        operand("Work Frame", Kind::Structure("POSITION_DATA"), ""),
        operand("Tool Frame", Kind::Structure("POSITION_DATA"), ""),
        word("Transform Direction", &TRANSFORM_DIRECTION),
        operand("Reference Position", Kind::Array(ArrayRule::AtLeast(6)), "the known position"),
        operand("Transform Position", Kind::WrittenArray(9), "receives the other position"),
        operand("Robot Configuration", Kind::Structure("DINT"), "forward: written, inverse: read"),
        operand("Turns Counter", Kind::Structure("INT[4]"), "forward: written, inverse: read"),
    ];
}

const PATH_BITS_CALCULATED: &[Flag] = &[
    Flag::En,
    Flag::Dn,
    Flag::Er,
    Flag::Ip,
    Flag::Ac,
    Flag::Pc,
    Flag::Accel,
    Flag::Decel,
    Flag::TrackingMaster,
    Flag::CalculatedDataAvailable,
];

#[cfg(test)]
mod tests {
    use crate::{Condition, Kind, MAX_OPERANDS, Mnemonic, Object, Range, by_service, services};

    #[test]
    fn services_are_those_of_the_contract() {
        #[rustfmt::skip]
        let cases = [
            (0x0302, 0x32, "MCLM"), (0x0302, 0x33, "MCCM"), (0x0302, 0x34, "MCCD"), (0x0302, 0x35, "MCS"),
            (0x0302, 0x3D, "MCTPO"), (0x0301, 0x32, "MSO"), (0x0301, 0x33, "MSF"), (0x0301, 0x40, "MATC"),
            (0x0300, 0x35, "MGSP"), (0x0300, 0x37, "MCSV"), (0x0301, 0x41, "MAW"), (0x0301, 0x46, "MDOC"),
        ];
        for (class, service, name) in cases {
            let mnemonic: Mnemonic = name.parse().expect(name);
            assert_eq!(by_service(class, service), Some(mnemonic), "{name}");
            assert_eq!(mnemonic.instruction().service(), (class, service), "{name}");
        }
        for (class, service) in [
            (0x0302, 0x31),
            (0x0302, 0x3E),
            (0x0303, 0x32),
            (0x0301, 0x47),
            (0x0300, 0x38),
        ] {
            assert_eq!(by_service(class, service), None, "{class:#06x} {service:#04x}");
        }
    }

    #[test]
    fn the_catalogue_is_whole() {
        let all: usize = [Object::MotionGroup, Object::Axis, Object::CoordinateSystem]
            .into_iter()
            .map(|object| services(object).len())
            .sum();
        assert_eq!(all, Mnemonic::ALL.len());
        for mnemonic in Mnemonic::ALL {
            let instruction = mnemonic.instruction();
            assert_eq!(instruction.mnemonic, *mnemonic);
            assert!(instruction.operands.len() <= MAX_OPERANDS, "{mnemonic}");
            let kinds = instruction.operands.iter().map(|operand| &operand.kind);
            let target = |kind: &Kind| matches!(kind, Kind::Target(object) if *object == instruction.object);
            let is_first = target(&instruction.operands[0].kind);
            assert_eq!(is_first, instruction.has_target(), "{mnemonic}");
            let calculates = matches!(mnemonic, Mnemonic::Mccp | Mnemonic::Mcsv);
            assert_eq!(is_first, !calculates, "{mnemonic}");
            assert_eq!(
                kinds.filter(|kind| matches!(kind, Kind::MotionControl)).count(),
                1,
                "{mnemonic}"
            );
            for (k, operand) in instruction.operands.iter().enumerate() {
                assert_eq!(
                    instruction.operand(operand.name),
                    Some(k),
                    "{mnemonic} {}",
                    operand.name
                );
                assert_eq!(
                    instruction.operand(&operand.member()),
                    Some(k),
                    "{mnemonic} {}",
                    operand.name
                );
                let other = match (operand.condition, &operand.kind) {
                    (Condition::Changed(flag), _) => Some(("Change", flag)),
                    (Condition::When { operand, .. }, _) => Some(("", operand)),
                    _ => None,
                };
                if let Some((start, place)) = other {
                    let name = instruction.operands[usize::from(place)].name;
                    assert!(
                        name.starts_with(start),
                        "{mnemonic} {}: condition on {name}",
                        operand.name
                    );
                }
                if let Kind::Number(Range::Jerk { units }) = operand.kind {
                    assert_eq!(
                        instruction.operands[usize::from(units)].name,
                        "Jerk Units",
                        "{mnemonic}"
                    );
                }
            }
        }
    }

    #[test]
    fn operands_stand_at_the_positions_of_the_specification() {
        #[rustfmt::skip]
        let cases: &[(&str, &[(usize, &str)])] = &[
            ("MCLM", &[(2, "MoveType"), (3, "Position"), (4, "Speed"), (5, "SpeedUnits"), (6, "AccelRate"),
                (8, "DecelRate"), (10, "Profile"), (11, "AccelJerk"), (12, "DecelJerk"), (13, "JerkUnits"),
                (14, "TerminationType"), (15, "Merge"), (16, "MergeSpeed"), (17, "CommandTolerance"),
                (18, "LockPosition"), (19, "LockDirection"), (20, "EventDistance"), (21, "CalculatedData")]),
            ("MCCM", &[(4, "CircleType"), (5, "ViaCenterRadius"), (6, "Direction"), (7, "Speed"), (9, "AccelRate"),
                (11, "DecelRate"), (13, "Profile"), (14, "AccelJerk"), (16, "JerkUnits"), (17, "TerminationType"),
                (20, "CommandTolerance"), (22, "LockDirection"), (24, "CalculatedData")]),
            ("MCCD", &[(2, "MotionType"), (4, "Speed"), (7, "AccelRate"), (10, "DecelRate"), (13, "AccelJerk"),
                (15, "DecelJerk"), (16, "JerkUnits"), (17, "Scope")]),
            ("MCS", &[(2, "StopType"), (3, "ChangeDecel"), (4, "DecelRate"), (7, "DecelJerk"), (8, "JerkUnits")]),
            ("MAM", &[(4, "Speed"), (6, "AccelRate"), (8, "DecelRate"), (17, "LockDirection"), (19, "CalculatedData")]),
            ("MAJ", &[(2, "Direction"), (3, "Speed"), (12, "JerkUnits"), (16, "LockDirection")]),
            ("MAG", &[(1, "MasterAxis"), (2, "MotionControl"), (3, "Direction"), (9, "Clutch"), (11, "AccelUnits")]),
            ("MCD", &[(4, "Speed"), (12, "DecelJerk"), (13, "SpeedUnits"), (16, "JerkUnits")]),
            ("MAPC", &[(4, "CamProfile"), (12, "MasterDirection")]),
            ("MATC", &[(3, "CamProfile"), (10, "InstructionMode")]),
            ("MDCC", &[(1, "MasterAxis"), (3, "MasterReference"), (4, "NominalMasterVelocity")]),
            ("MCTPO", &[(5, "TransformDirection"), (9, "TurnsCounter")]),
        ];
        for (name, operands) in cases {
            let instruction = name.parse::<Mnemonic>().expect(name).instruction();
            for (place, member) in *operands {
                assert_eq!(instruction.operands[*place].member(), *member, "{name} {place}");
            }
        }
    }
}

//! Motion errors: ERR, EXERR, and their meaning, in one table (spec/axis-and-data-types.md §6, §7).

use std::fmt;

use crate::Mnemonic;

/// Faceplate position of an operand, from 0.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct OperandIndex(pub u8);

/// Index of an axis: within the coordinate system for coordinated instructions; 0 for single-axis ones; 0 the
/// slave and 1 the master for those with two axes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct AxisIndex(pub u8);

/// The object of an error that can concern the coordinate system itself.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Culprit {
    /// The coordinate system: EXERR −1.
    CoordinateSystem,
    /// One of its axes.
    Axis(AxisIndex),
}

/// An extended code with a list of its own.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Detail(pub i8);

/// The use of EXERR by an error.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Extended {
    /// Always 0.
    Unused,
    /// Position of the operand.
    Operand,
    /// Index of the axis.
    Axis,
    /// Index of the axis, or −1: the coordinate system.
    Culprit,
    /// A list of its own.
    Detail,
}

impl Extended {
    /// In words, for reference pages.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Unused => "0",
            Self::Operand => "operand, from 0",
            Self::Axis => "axis, from 0",
            Self::Culprit => "axis, from 0; -1 the coordinate system",
            Self::Detail => "own list",
        }
    }
}

/// A row of the error table.
#[derive(Debug)]
pub struct ErrorText {
    /// ERR.
    pub err: i16,
    /// Name.
    pub name: &'static str,
    /// The use of EXERR.
    pub extended: Extended,
    /// The usual cause.
    pub cause: &'static str,
    /// The remedy.
    pub remedy: &'static str,
    /// The meaning of the values of EXERR, for an error with a list of its own ([`Extended::Detail`]); others are a count.
    pub details: &'static [(i8, &'static str)],
}

/// Payloads of [`MotionError`] to and from EXERR.
trait Payload {
    fn to_exerr(self) -> i8;
    fn from_exerr(exerr: i8) -> Self;
}

impl Payload for OperandIndex {
    fn to_exerr(self) -> i8 {
        self.0 as i8 // at most 25
    }
    fn from_exerr(exerr: i8) -> Self {
        Self(exerr as u8)
    }
}

impl Payload for AxisIndex {
    fn to_exerr(self) -> i8 {
        self.0 as i8 // at most 8
    }
    fn from_exerr(exerr: i8) -> Self {
        Self(exerr as u8)
    }
}

impl Payload for Culprit {
    fn to_exerr(self) -> i8 {
        match self {
            Self::CoordinateSystem => -1,
            Self::Axis(axis) => axis.to_exerr(),
        }
    }
    fn from_exerr(exerr: i8) -> Self {
        if exerr == -1 {
            Self::CoordinateSystem
        } else {
            Self::Axis(AxisIndex::from_exerr(exerr))
        }
    }
}

impl Payload for Detail {
    fn to_exerr(self) -> i8 {
        self.0
    }
    fn from_exerr(exerr: i8) -> Self {
        Self(exerr)
    }
}

macro_rules! motion_errors {
    (@extended) => { Extended::Unused };
    (@extended OperandIndex) => { Extended::Operand };
    (@extended AxisIndex) => { Extended::Axis };
    (@extended Culprit) => { Extended::Culprit };
    (@extended Detail) => { Extended::Detail };
    (@details) => { &[] };
    (@details $details:ident) => { $details };
    ($($err:literal $variant:ident $(($payload:ident $($details:ident)?))? $name:literal $cause:literal $remedy:literal;)*) => {
        /// The error of an instruction that was refused or failed. The variant is ERR, the payload is EXERR.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        #[non_exhaustive]
        pub enum MotionError {
            $(#[doc = concat!("ERR ", $err, ": ", $name, ". ", $cause)] $variant $(($payload))?,)*
        }

        /// Every error code, ascending.
        pub static ERRORS: &[ErrorText] = &[$(ErrorText {
            err: $err,
            name: $name,
            extended: motion_errors!(@extended $($payload)?),
            cause: $cause,
            remedy: $remedy,
            details: motion_errors!(@details $($($details)?)?),
        }),*];

        impl MotionError {
            /// ERR.
            pub fn err(self) -> i16 {
                match self { $(Self::$variant { .. } => $err),* }
            }

            /// EXERR, 0 if the error has none.
            pub fn exerr(self) -> i8 {
                $(if let Some(exerr) = motion_errors!(@exerr self $variant $($payload)?) { return exerr; })*
                0
            }

            /// The error of a pair of codes; `None` for a code that does not exist.
            pub fn from_codes(err: i16, exerr: i8) -> Option<Self> {
                let _ = exerr;
                match err {
                    $($err => Some(Self::$variant $((<$payload as Payload>::from_exerr(exerr)))?),)*
                    _ => None,
                }
            }
        }
    };
    (@exerr $value:ident $variant:ident) => { None::<i8> };
    (@exerr $value:ident $variant:ident $payload:ident) => {
        match $value {
            Self::$variant(payload) => Some(Payload::to_exerr(payload)),
            _ => None,
        }
    };
}

/// EXERR of error 12 (spec/axis-and-data-types.md §7.4).
const SERVO_MESSAGE: &[(i8, &str)] = &[
    (2, "no response, or no memory in the module"),
    (3, "an invalid value"),
    (12, "the axis is in shutdown"),
    (15, "the enable input is off, or the process was terminated on request"),
    (
        16,
        "the drive is in the wrong state: homing, MRP and registration 2 exclude each other",
    ),
];

/// EXERR of error 61 (spec/coordinated-instructions.md §19.6).
const CONNECTION: &[(i8, &str)] = &[
    (1, "one of the systems is in no motion group, or in another"),
    (
        2,
        "source and target are the same system, or of the same type where they must differ",
    ),
    (3, "the transform dimension of the source is not allowed"),
    (4, "the transform dimension of the target is not allowed"),
    (
        5,
        "the type or the axes of the source are not allowed, or neither system is Cartesian",
    ),
    (6, "the type or the axes of the target are not allowed"),
    (7, "an axis belongs to both systems"),
    (8, "another coordinated motion uses axes of the target"),
    (9, "link lengths are 0, negative or equal where they must differ"),
    (10, "the offsets leave no workspace"),
    (17, "the transform dimensions differ"),
];

/// EXERR of errors 151 to 156.
const JOINT_LIMIT: &[(i8, &str)] = &[(1, "beyond the positive limit"), (2, "beyond the negative limit")];

#[rustfmt::skip]
motion_errors! {
    3 ExecutionCollision "Execution Collision" "The same kind of request is still under way." "Wait for DN or ER before the next rung transition.";
    4 ServoOnState "Servo On State Error" "It needs an open servo loop, and the loop is closed." "Execute MSF first.";
    5 ServoOffState(AxisIndex) "Servo Off State Error" "It needs a closed servo loop, and the loop is open." "Execute MSO on the axis and wait for DN.";
    6 DriveOnState "Drive On State Error" "The drive is still enabled by another means." "Switch the drive off first.";
    7 ShutdownState(AxisIndex) "Shutdown State Error" "The axis or coordinate system is in shutdown." "Execute MASR, MCSR or MGSR, then MSO.";
    8 WrongAxisType(AxisIndex) "Wrong Axis Type" "This kind of axis cannot do it." "Use an axis of a type that the instruction accepts.";
    9 OvertravelCondition "Overtravel Condition" "The motion would go further into an overtravel." "Move the axis back into its travel.";
    10 MasterAxisConflict "Master Axis Conflict" "Master and slave are the same axis, or the link would close a loop." "Choose another master axis.";
    11 AxisNotConfigured(Culprit) "Axis Not Configured" "The axis does not exist, has no drive, or is in no group; -1: the coordinate system could not set it up." "Check the name of the target and the configuration.";
    12 ServoMessageFailure(Detail SERVO_MESSAGE) "Servo Message Failure" "The drive refused a message." "Look at the state of the drive.";
    13 ParameterOutOfRange(OperandIndex) "Parameter Out Of Range" "The operand is out of its range." "Correct the operand whose number is EXERR (counted from 0).";
    14 TuneProcess "Tune Process Error" "Tuning runs or failed." "Wait for the end of tuning.";
    15 TestProcess "Test Process Error" "The hookup test runs or failed." "Wait for the end of the test.";
    16 HomeInProcess(AxisIndex) "Home In Process Error" "Homing runs." "Wait for the end of homing, or stop it.";
    17 AxisModeNotRotary "Axis Mode Not Rotary" "A rotary move type on a linear axis." "Use an absolute or incremental move, or configure an unwind.";
    18 AxisTypeUnused "Axis Type Unused" "The axis is configured as unused." "Configure the axis.";
    19 GroupNotSynchronized "Group Not Synchronized" "The motion group has not synchronized yet, or there is none." "Wait for GroupSynced.";
    20 AxisInFaultedState(AxisIndex) "Axis In Faulted State" "The axis has a fault." "Clear the fault with MAFR or MASR.";
    21 GroupInFaultedState "Group In Faulted State" "The group has a fault." "Clear the fault with MGSR.";
    22 AxisInMotion(AxisIndex) "Axis In Motion" "The axis must stand still." "Stop the axis first.";
    23 IllegalDynamicChange "Illegal Dynamic Change" "The running motion cannot be changed this way, or there is none." "Execute it while such a motion is active.";
    24 IllegalControllerMode "Illegal Controller Mode" "Motion is not allowed in this controller mode." "Put the controller into Run.";
    25 IllegalInstruction "Illegal Instruction" "Not allowed here, such as a Radius circle in three dimensions." "Use a Circle Type or geometry that is allowed.";
    26 IllegalCamLength "Illegal Cam Length" "The length is below 2 or above the cam array." "Correct the length.";
    27 IllegalCamProfileLength "Illegal Cam Profile Length" "The profile array is too short." "Use a longer profile array.";
    28 IllegalCamType(Detail) "Illegal Cam Type" "A segment type is neither 0 nor 1; EXERR is the element." "Correct the element.";
    29 IllegalCamOrder(Detail) "Illegal Cam Order" "The master values do not rise; EXERR is the element." "Correct the element.";
    30 CamProfileBeingCalculated "Cam Profile Being Calculated" "Another MCCP works on the profile." "Wait for it.";
    31 CamProfileBeingUsed "Cam Profile Being Used" "A cam runs on the profile." "Use another profile or stop the cam.";
    32 CamProfileNotCalculated "Cam Profile Not Calculated" "The profile has not been calculated." "Execute MCCP first.";
    33 PositionCamNotEnabled "Position Cam Not Enabled" "A master offset move without a running position cam." "Start MAPC first.";
    34 RegistrationInProgress "Registration In Progress" "A registration is armed." "Disarm it.";
    35 IllegalExecutionTarget "Illegal Execution Target" "The output cam target is outside the configured number." "Correct the target.";
    36 IllegalOutputCam(Detail) "Illegal Output Cam" "A bad output cam element; EXERR is the element." "Correct the element.";
    37 IllegalOutputCompensation(Detail) "Illegal Output Compensation" "A bad compensation element; EXERR is the element." "Correct the element.";
    38 IllegalAxisDataType(AxisIndex) "Illegal Axis Data Type" "The instruction does not support this axis type." "Use an axis of another type.";
    39 ProcessConflict "Process Conflict" "Home, tune, test, redefine and registration 2 exclude each other." "Wait for the other process.";
    40 DriveLocallyDisabled "Drive Locally Disabled" "The drive was disabled on its own input." "Enable the drive.";
    41 IllegalHomingConfig "Illegal Homing Config" "An impossible combination of homing parameters." "Correct the homing parameters.";
    42 ShutdownStatusTimeout "Shutdown Status Timeout" "The drive did not confirm the shutdown in time." "Reset and try again.";
    43 CoordinateSystemQueueFull "Coordinate System Queue Full" "One move is active and the pending places are taken." "Wait until MovePendingQueueFullStatus is 0.";
    44 CircularCollinearity "Circular Collinearity Error" "Start, end and via point (or centre, in three dimensions) lie on a line." "Choose another via point or centre.";
    45 CircularStartEnd "Circular Start End Error" "The end point is the start point and it is not a full circle that allows it." "Choose another end point or a full circle.";
    46 CircularR1R2Mismatch "Circular R1 R2 Mismatch" "Start and end radius differ by more than 15 %." "Correct the centre or the end point.";
    47 CircularInfiniteSolution "Circular Infinite Solution" "The operands describe infinitely many circles." "Choose another centre or end point.";
    48 CircularNoSolutions "Circular No Solutions" "No circle fits the operands." "Correct the operands.";
    49 CircularSmallR "Circular Small R Error" "The radius is below 0.001 or too short to span start and end." "Use a larger radius.";
    50 CoordinateSystemNotInGroup "Coordinate System Not In Group" "It is in no motion group, or its axes are in another." "Assign it to the group of its axes.";
    51 InvalidActualTolerance "Invalid Actual Tolerance" "Termination type 0 with an Actual Position Tolerance of 0." "Set the tolerance, or use another termination type.";
    52 CoordinatedMotionInProcess(AxisIndex) "Coordinated Motion In Process" "Another coordinated motion holds the axes." "Wait for it, stop it, or merge.";
    53 AxisIsInhibited(AxisIndex) "Axis Is Inhibited" "The axis is inhibited." "Release STOP (`arcline release`), or uninhibit the axis.";
    54 ZeroMaxDecel(Culprit) "Zero Max Decel" "The Maximum Deceleration is 0." "Set the Maximum Deceleration.";
    61 ConnectionConflict(Detail CONNECTION) "Connection Conflict" "The transform cannot be set up." "Correct the two coordinate systems.";
    62 TransformInProgress "Transform In Progress" "The coordinate system is already part of a transform." "Stop that transform first.";
    63 AxisInTransformMotion(AxisIndex) "Axis In Transform Motion" "The axis belongs to an active transform." "Stop the transform first.";
    64 AncillaryNotSupported "Ancillary Not Supported" "Ancillary axes are not allowed here." "Use a coordinate system without them.";
    65 AxisPositionOverflow(AxisIndex) "Axis Position Overflow" "The axis position left the representable range." "Redefine the position.";
    66 ArmSolutionChange "Motion error 66" "The arm would fold back or change its arm solution." "Keep the solution in which the transform was set up.";
    67 InvalidTransformPosition(Detail) "Invalid Transform Position" "The target is outside the reach or the joint limits; EXERR is the joint." "Choose a position within reach.";
    68 TransformAtOrigin "Transform At Origin" "The target is at the singular origin." "Stay away from the origin.";
    69 MaxJointVelocityExceeded(AxisIndex) "Max Joint Velocity Exceeded" "Near a singularity a joint would move too fast." "Move slower or stay away from the singularity.";
    70 AxesInTransformMustBeLinear(AxisIndex) "Axes In Transform Must Be Linear" "A rotary axis in a transform." "Configure the axis as linear.";
    71 TransformIsCanceling "Transform Is Canceling" "A cancelled transform has not stopped yet." "Wait until it has stopped.";
    72 MaxJointAngleExceeded(AxisIndex) "Max Joint Angle Exceeded" "A joint is outside its range." "Choose a position within the joint's range.";
    73 CoordinateSystemChaining "Coord System Chaining Error" "This chain or loop of transforms is not allowed." "Use each target once, without loops.";
    74 InvalidOrientationAngle(Detail) "Invalid Orientation Angle" "An orientation operand is out of range." "Keep angles within 360 degrees.";
    75 InstructionNotSupported "Instruction Not Supported" "This controller or axis type does not offer it." "Use another instruction.";
    76 ZeroMaxDecelJerk(Culprit) "Zero Max Decel Jerk" "The Maximum Deceleration Jerk is 0 and the stop needs it." "Set the Maximum Deceleration Jerk.";
    77 TransformDirectionNotSupported "Transform Direction Not Supported" "The geometry does not have this transform direction." "Use another direction.";
    78 NotAllowedWhileStopping(AxisIndex) "Not Allowed While Stopping" "A stop is in process." "Wait until the stop has ended.";
    79 InvalidPlannerState "Invalid Planner State" "An internal state of the planner." "Clear the faults and try again.";
    80 IncorrectOutputConnection "Incorrect Output Connection" "The output cam or drive connection is not valid." "Check the connection.";
    81 PartialGroupShutdownReset "Partial Group Shutdown Reset" "Not every axis could leave shutdown." "Look at the faults of the axes and try again.";
    82 CipAxisInIncorrectState "CIP Axis In Incorrect State" "The state of the drive forbids it." "Bring the drive to Stopped or Running.";
    83 IllegalControlMode "Illegal Control Mode Or Method" "Not for this control mode." "Use position control.";
    84 DriveDigitalInputNotAssigned "Drive Digital Input Not Assigned" "The home or registration input is not configured." "Assign the input.";
    85 RedefinePositionInProcess "Redefine Position In Process" "MRP or homing already runs." "Wait for it.";
    86 OptionalAttributeNotSupported(Detail) "Optional Attribute Not Supported" "The drive lacks the function; EXERR is the attribute." "Do without the function.";
    87 NotAllowedInDirectMotion "Not Allowed While In Direct Motion" "Direct control is active." "Stop it first.";
    88 NotAllowedWhilePlannerActive "Not Allowed While Planner Active" "The planner moves the axis." "Stop the axis first.";
    93 MdscNotActivated "MDSC Not Activated" "Master driven units without an active MDAC or MDCC." "Execute MDAC or MDCC first.";
    94 MdscUnitsConflict "MDSC Units Conflict" "Time driven and master driven units are mixed." "Use units of one mode.";
    95 MdscLockDirectionConflict "MDSC Lock Direction Conflict" "None when master driven, or not None when time driven." "Correct Lock Direction.";
    96 MdscMdacAllConflict "MDSC MDAC All Conflict" "MDAC All and a specific MDAC on the same slave." "Use one of them.";
    97 MdscIdleMasterAndSlaveMoving "MDSC Idle Master And Slave Moving" "A switch to master driven while the master stands and the slave moves." "Start the master or stop the slave.";
    98 MdscDirectionMismatch "MDSC Lock Direction Master Direction Mismatch" "The active move would be replaced by one with another master direction." "Use the same direction.";
    99 FeatureNotSupported "Feature Not Supported" "This combination of parameters is not offered." "Use another combination.";
    100 AxisNotAtRest(AxisIndex) "Axis Not At Rest" "Moves in seconds or master units start at rest." "Wait until the axis stands.";
    101 MdscCalculatedDataSize "MDSC Calculated Data Size Error" "Calculated Data and Event Distance do not fit in size." "Use arrays of the same size.";
    102 MdscLockWhileMoving "MDSC Lock While Moving" "A second position-lock move while the first waits or runs." "Wait for the first.";
    103 MdscInvalidSlaveSpeedReduction "MDSC Invalid Slave Speed Reduction" "The speed change needs a slowdown that the master does not give." "Use a speed that is not lower.";
    104 SlaveSpeedTooHigh "Motion error 104" "The slave speed is above what is permitted." "Lower the speed or the master's.";
    105 MdscInvalidModeOrMasterChange "MDSC Invalid Mode Or Master Change" "The mode or the master would change under motion." "Stop first.";
    106 MergeToCurrentUsingSeconds "Merge To Current Using Seconds Illegal" "Merge Speed Current with units of seconds." "Use Programmed or other units.";
    107 Internal "Motion error 107" "An internal error; there is nothing to correct." "Report it and restart.";
    108 MultiplexedAxes(AxisIndex) "Multiplexed Axes" "The axes are on different update schedules." "Put them on one schedule.";
    147 InvalidOrientationScaling(Detail) "Invalid Orientation Scaling" "The orientation scaling is not valid." "Correct it.";
    148 InvalidWorkFrame(Detail) "Invalid Work Frame" "The work frame is not valid." "Correct the frame.";
    149 InvalidToolFrame(Detail) "Invalid Tool Frame" "The tool frame is not valid." "Correct the frame.";
    150 InvalidArmConfiguration(Detail) "Invalid Arm Configuration" "The wrist or arm configuration is not valid." "Correct it.";
    151 J1BeyondLimit(Detail JOINT_LIMIT) "Joint J1 Beyond Limit" "Joint J1 is beyond its limit." "Choose a position within the limit.";
    152 J2BeyondLimit(Detail JOINT_LIMIT) "Joint J2 Beyond Limit" "Joint J2 is beyond its limit." "Choose a position within the limit.";
    153 J3BeyondLimit(Detail JOINT_LIMIT) "Joint J3 Beyond Limit" "Joint J3 is beyond its limit." "Choose a position within the limit.";
    154 J4BeyondLimit(Detail JOINT_LIMIT) "Joint J4 Beyond Limit" "Joint J4 is beyond its limit." "Choose a position within the limit.";
    155 J5BeyondLimit(Detail JOINT_LIMIT) "Joint J5 Beyond Limit" "Joint J5 is beyond its limit." "Choose a position within the limit.";
    156 J6BeyondLimit(Detail JOINT_LIMIT) "Joint J6 Beyond Limit" "Joint J6 is beyond its limit." "Choose a position within the limit.";
    157 InvalidTurnsCounter(Detail) "Invalid Turns Counter" "A turns counter is not valid." "Correct it.";
    158 GeometryNotSupported(Detail) "Geometry Not Supported" "The geometry is not offered." "Use another geometry.";
    159 InvalidPathData(Detail) "Invalid Path Data" "A member of PATH_DATA is not valid; EXERR is its place." "Correct the member.";
    160 InvalidDynamicsData(Detail) "Invalid Dynamics Data" "A member of DYNAMICS_DATA is not valid; EXERR is its place." "Correct the member.";
}

impl MotionError {
    /// The row of the table.
    pub fn text(self) -> &'static ErrorText {
        text(self.err()).expect("every variant has a row")
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.text().name
    }

    /// The usual cause.
    pub fn cause(self) -> &'static str {
        self.text().cause
    }

    /// The remedy.
    pub fn remedy(self) -> &'static str {
        self.text().remedy
    }
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&describe(self.err(), self.exerr(), None))
    }
}

impl std::error::Error for MotionError {}

/// The row of an error code.
pub(crate) fn text(err: i16) -> Option<&'static ErrorText> {
    ERRORS
        .binary_search_by_key(&err, |row| row.err)
        .ok()
        .map(|place| &ERRORS[place])
}

/// An error for people: `ERR 13 Parameter Out Of Range, operand 7 (Speed)`. The names of operands come from the
/// instruction.
pub fn describe(err: i16, exerr: i8, mnemonic: Option<Mnemonic>) -> String {
    if err == 0 {
        return "no error".to_owned();
    }
    let Some(row) = text(err) else {
        let extended = if exerr == 0 {
            String::new()
        } else {
            format!(", EXERR {exerr}")
        };
        return format!("ERR {err} Motion error {err}{extended}");
    };
    let extended = match row.extended {
        Extended::Unused if exerr == 0 => String::new(),
        Extended::Operand => {
            let operands = mnemonic.map_or(&[][..], |mnemonic| mnemonic.instruction().operands);
            let operand = usize::try_from(exerr).ok().and_then(|place| operands.get(place));
            match operand {
                Some(operand) => format!(", operand {exerr} ({})", operand.name),
                None => format!(", operand {exerr}"),
            }
        }
        Extended::Axis => format!(", axis {exerr}"),
        Extended::Culprit if exerr == -1 => ", coordinate system".to_owned(),
        Extended::Culprit => format!(", axis {exerr}"),
        Extended::Detail | Extended::Unused => format!(", EXERR {exerr}"),
    };
    format!("ERR {err} {}{extended}", row.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_ascend_and_read_back() {
        assert!(ERRORS.is_sorted_by(|a, b| a.err < b.err));
        for row in ERRORS {
            let error = MotionError::from_codes(row.err, 2).unwrap_or_else(|| panic!("{}", row.err));
            assert_eq!(error.err(), row.err, "{}", row.name);
            assert_eq!(
                error.exerr(),
                if row.extended == Extended::Unused { 0 } else { 2 },
                "{}",
                row.name
            );
            assert_eq!(error.name(), row.name);
            assert!(row.cause.ends_with('.') && row.remedy.ends_with('.'), "{}", row.name);
            assert!(row.details.is_sorted_by(|a, b| a.0 < b.0), "{}", row.name);
        }
        for err in [-1, 0, 1, 2, 55, 60, 89, 92, 109, 146, 161, i16::MAX] {
            assert_eq!(MotionError::from_codes(err, 0), None, "{err}");
        }
    }

    #[test]
    fn errors_are_told_in_words() {
        #[rustfmt::skip]
        let cases = [
            (13, 7, Some(Mnemonic::Mccm), "ERR 13 Parameter Out Of Range, operand 7 (Speed)"),
            (13, 4, Some(Mnemonic::Mclm), "ERR 13 Parameter Out Of Range, operand 4 (Speed)"),
            (13, 4, None,                 "ERR 13 Parameter Out Of Range, operand 4"),
            (13, 99, Some(Mnemonic::Mclm), "ERR 13 Parameter Out Of Range, operand 99"),
            (13, -1, Some(Mnemonic::Mclm), "ERR 13 Parameter Out Of Range, operand -1"),
            (5, 1, Some(Mnemonic::Mclm),  "ERR 5 Servo Off State Error, axis 1"),
            (54, -1, None,                "ERR 54 Zero Max Decel, coordinate system"),
            (54, 2, None,                 "ERR 54 Zero Max Decel, axis 2"),
            (43, 0, None,                 "ERR 43 Coordinate System Queue Full"),
            (61, 17, None,                "ERR 61 Connection Conflict, EXERR 17"),
            (120, 0, None,                "ERR 120 Motion error 120"),
            (0, 0, None,                  "no error"),
        ];
        for (err, exerr, mnemonic, expected) in cases {
            assert_eq!(describe(err, exerr, mnemonic), expected);
        }
    }

    #[test]
    fn payloads_carry_their_codes() {
        #[rustfmt::skip]
        let cases = [
            (MotionError::ParameterOutOfRange(OperandIndex(7)), 13, 7),
            (MotionError::ZeroMaxDecel(Culprit::CoordinateSystem), 54, -1),
            (MotionError::ZeroMaxDecel(Culprit::Axis(AxisIndex(2))), 54, 2),
            (MotionError::ServoOffState(AxisIndex(1)), 5, 1),
            (MotionError::GroupNotSynchronized, 19, 0),
            (MotionError::ConnectionConflict(Detail(17)), 61, 17),
        ];
        for (error, err, exerr) in cases {
            assert_eq!((error.err(), error.exerr()), (err, exerr), "{error}");
            assert_eq!(MotionError::from_codes(err, exerr), Some(error));
        }
    }
}

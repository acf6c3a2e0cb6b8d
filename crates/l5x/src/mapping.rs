//! The correspondence of L5X and Arcline: the one table of elements and attributes by which the importer judges a file and that
//! docs/L5X.md shows. The report calls all others not understood.

/// The meaning of an attribute or child element of L5X in Arcline.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Meaning {
    /// The attribute becomes this key of a configuration, or a part of it.
    Key(&'static str),
    /// The attribute has no information to lose; the words give the reason.
    Form(&'static str),
    /// A configuration has nothing like it: reported, unless it has this value (empty: always).
    Without(&'static str),
    /// A list whose entries a configuration has nothing like, such as routines: each is reported.
    Each,
}

/// A line of the table.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Row {
    /// `@Attribute`, or the name of a child element.
    pub what: &'static str,
    /// Its meaning in Arcline.
    pub meaning: Meaning,
}

/// The rows of an element; none: nothing in it is known.
pub fn rows(element: &str) -> &'static [Row] {
    ELEMENTS
        .iter()
        .find(|(name, _)| *name == element)
        .map_or(&[], |(_, rows)| rows)
}

/// The table as Markdown, as docs/L5X.md has it.
pub fn markdown() -> String {
    let mut text = String::new();
    for (element, rows) in ELEMENTS {
        text.push_str(&format!("\n### `{element}`\n\n| L5X | Arcline |\n|---|---|\n"));
        let mut without = Vec::new();
        let mut form: Vec<(&str, Vec<String>)> = Vec::new();
        for row in *rows {
            match row.meaning {
                Meaning::Key(key) => text.push_str(&format!("| `{}` | `{key}` |\n", row.what)),
                Meaning::Form(why) => match form.iter_mut().find(|(other, _)| *other == why) {
                    Some((_, names)) => names.push(format!("`{}`", row.what)),
                    None => form.push((why, vec![format!("`{}`", row.what)])),
                },
                Meaning::Without("") => without.push(format!("`{}`", row.what)),
                Meaning::Without(neutral) => without.push(format!("`{}` (unless `{neutral}`)", row.what)),
                Meaning::Each => without.push(format!("each in `{}`", row.what)),
            }
        }
        for (why, names) in form {
            text.push_str(&format!("| {} | no value of its own: {why} |\n", names.join(", ")));
        }
        if !without.is_empty() {
            text.push_str(&format!(
                "| {} | reported: no counterpart in a configuration |\n",
                without.join(", ")
            ));
        }
    }
    text
}

/// Every element that is looked into.
#[rustfmt::skip]
pub const ELEMENTS: &[(&str, &[Row])] = &[
    ("RSLogix5000Content", RSLOGIX5000_CONTENT),
    ("Controller", CONTROLLER),
    ("CustomProperties", CUSTOM_PROPERTIES),
    ("Provider", PROVIDER),
    ("DataTypes", DATA_TYPES),
    ("DataType", DATA_TYPE),
    ("Members", MEMBERS),
    ("Member", MEMBER),
    ("Tags", TAGS),
    ("Tag", TAG),
    ("Data", DATA),
    ("DataValue", DATA_VALUE),
    ("DataValueMember", DATA_VALUE_MEMBER),
    ("Array", ARRAY),
    ("ArrayMember", ARRAY_MEMBER),
    ("Element", ELEMENT),
    ("Structure", STRUCTURE),
    ("StructureMember", STRUCTURE_MEMBER),
    ("Programs", PROGRAMS),
    ("Program", PROGRAM),
    ("MotionGroupParameters", MOTION_GROUP_PARAMETERS),
    ("AxisParameters", AXIS_PARAMETERS),
    ("CoordinateSystemParameters", COORDINATE_SYSTEM_PARAMETERS),
];

#[rustfmt::skip]
const RSLOGIX5000_CONTENT: &[Row] = &[
    Row { what: "@SchemaRevision", meaning: Meaning::Form("about the file") },
    Row { what: "@SoftwareRevision", meaning: Meaning::Form("about the file") },
    Row { what: "@TargetName", meaning: Meaning::Form("about the file") },
    Row { what: "@TargetType", meaning: Meaning::Form("about the file") },
    Row { what: "@TargetSubType", meaning: Meaning::Form("about the file") },
    Row { what: "@TargetClass", meaning: Meaning::Form("about the file") },
    Row { what: "@TargetRevision", meaning: Meaning::Form("about the file") },
    Row { what: "@TargetLastEdited", meaning: Meaning::Form("about the file") },
    Row { what: "@TargetCount", meaning: Meaning::Form("about the file") },
    Row { what: "@ContainsContext", meaning: Meaning::Form("about the file") },
    Row { what: "@Owner", meaning: Meaning::Form("about the file") },
    Row { what: "@ExportDate", meaning: Meaning::Form("about the file") },
    Row { what: "@ExportOptions", meaning: Meaning::Form("about the file") },
    Row { what: "@CurrentLanguage", meaning: Meaning::Form("about the file") },
    Row { what: "@DataTypeGUID", meaning: Meaning::Form("about the file") },
    Row { what: "Controller", meaning: Meaning::Form("holds all the rest") },
];

#[rustfmt::skip]
const CONTROLLER: &[Row] = &[
    Row { what: "@Name", meaning: Meaning::Key("server.name") },
    Row { what: "@Use", meaning: Meaning::Form("about the file") },
    Row { what: "@ProcessorType", meaning: Meaning::Form("the kind of controller") },
    Row { what: "@MajorRev", meaning: Meaning::Form("the kind of controller") },
    Row { what: "@MinorRev", meaning: Meaning::Form("the kind of controller") },
    Row { what: "@ProjectCreationDate", meaning: Meaning::Form("about the file") },
    Row { what: "@LastModifiedDate", meaning: Meaning::Form("about the file") },
    Row { what: "@TimeSlice", meaning: Meaning::Without("") },
    Row { what: "@ShareUnusedTimeSlice", meaning: Meaning::Without("") },
    Row { what: "@PowerLossProgram", meaning: Meaning::Without("") },
    Row { what: "@MajorFaultProgram", meaning: Meaning::Without("") },
    Row { what: "@CommPath", meaning: Meaning::Without("") },
    Row { what: "@CommDriver", meaning: Meaning::Without("") },
    Row { what: "@SFCExecutionControl", meaning: Meaning::Without("") },
    Row { what: "@SFCRestartPosition", meaning: Meaning::Without("") },
    Row { what: "@SFCLastScan", meaning: Meaning::Without("") },
    Row { what: "@ProjectSN", meaning: Meaning::Without("") },
    Row { what: "@MatchProjectToController", meaning: Meaning::Without("") },
    Row { what: "@CanUseRPIFromProducer", meaning: Meaning::Without("") },
    Row { what: "@InhibitAutomaticFirmwareUpdate", meaning: Meaning::Without("") },
    Row { what: "@PassThroughConfiguration", meaning: Meaning::Without("") },
    Row { what: "@DownloadProjectDocumentationAndExtendedProperties", meaning: Meaning::Without("") },
    Row { what: "@DownloadProjectCustomProperties", meaning: Meaning::Without("") },
    Row { what: "@ReportMinorOverflow", meaning: Meaning::Without("") },
    Row { what: "@AutoDiagsEnabled", meaning: Meaning::Without("") },
    Row { what: "@WebServerEnabled", meaning: Meaning::Without("") },
    Row { what: "@EtherNetIPMode", meaning: Meaning::Without("") },
    Row { what: "@DataExchangeId", meaning: Meaning::Form("about the file") },
    Row { what: "@KeepTestEditsOnSwitchOver", meaning: Meaning::Without("") },
    Row { what: "DataTypes", meaning: Meaning::Form("holds DataType") },
    Row { what: "Tags", meaning: Meaning::Form("holds Tag") },
    Row { what: "Programs", meaning: Meaning::Form("holds Program") },
    Row { what: "CustomProperties", meaning: Meaning::Form("holds Provider") },
    Row { what: "Modules", meaning: Meaning::Each },
    Row { what: "AddOnInstructionDefinitions", meaning: Meaning::Each },
    Row { what: "Tasks", meaning: Meaning::Each },
    Row { what: "Trends", meaning: Meaning::Each },
    Row { what: "QuickWatchLists", meaning: Meaning::Each },
    Row { what: "ParameterConnections", meaning: Meaning::Each },
    Row { what: "DataLogs", meaning: Meaning::Each },
    Row { what: "AlarmDefinitions", meaning: Meaning::Each },
    Row { what: "InternetProtocol", meaning: Meaning::Each },
    Row { what: "EthernetPorts", meaning: Meaning::Each },
    Row { what: "CommPorts", meaning: Meaning::Each },
    Row { what: "Description", meaning: Meaning::Without("") },
    Row { what: "RedundancyInfo", meaning: Meaning::Without("") },
    Row { what: "Security", meaning: Meaning::Without("") },
    Row { what: "SafetyInfo", meaning: Meaning::Without("") },
    Row { what: "CST", meaning: Meaning::Without("") },
    Row { what: "WallClockTime", meaning: Meaning::Without("") },
    Row { what: "TimeSynchronize", meaning: Meaning::Without("") },
    Row { what: "OpcUaInfo", meaning: Meaning::Without("") },
    Row { what: "EthernetNetwork", meaning: Meaning::Without("") },
    Row { what: "NonVolatileMemory", meaning: Meaning::Without("") },
    Row { what: "Logo", meaning: Meaning::Without("") },
];

#[rustfmt::skip]
const CUSTOM_PROPERTIES: &[Row] = &[
    Row { what: "Provider", meaning: Meaning::Form("Arcline's own keys, which have no counterpart in L5X") },
];

#[rustfmt::skip]
const PROVIDER: &[Row] = &[
    Row { what: "@ID", meaning: Meaning::Form("Arcline reads its own") },
    Row { what: "@Ext", meaning: Meaning::Form("TOML") },
];

#[rustfmt::skip]
const DATA_TYPES: &[Row] = &[
    Row { what: "@Use", meaning: Meaning::Form("about the file") },
    Row { what: "DataType", meaning: Meaning::Key("data_type") },
];

#[rustfmt::skip]
const DATA_TYPE: &[Row] = &[
    Row { what: "@Use", meaning: Meaning::Form("about the file") },
    Row { what: "@Name", meaning: Meaning::Key("data_type.name") },
    Row { what: "@Family", meaning: Meaning::Form("StringFamily is reported with its type") },
    Row { what: "@Class", meaning: Meaning::Form("all are User") },
    Row { what: "Description", meaning: Meaning::Without("") },
    Row { what: "Members", meaning: Meaning::Form("holds Member") },
    Row { what: "Dependencies", meaning: Meaning::Form("follow from the members") },
    Row { what: "EngineeringUnit", meaning: Meaning::Without("") },
    Row { what: "CustomProperties", meaning: Meaning::Without("") },
];

#[rustfmt::skip]
const MEMBERS: &[Row] = &[
    Row { what: "Member", meaning: Meaning::Key("data_type.members") },
];

#[rustfmt::skip]
const MEMBER: &[Row] = &[
    Row { what: "@Name", meaning: Meaning::Key("data_type.members.name") },
    Row { what: "@DataType", meaning: Meaning::Key("data_type.members.type") },
    Row { what: "@Dimension", meaning: Meaning::Key("data_type.members.type") },
    Row { what: "@Radix", meaning: Meaning::Form("how a value is shown") },
    Row { what: "@Hidden", meaning: Meaning::Form("a host of BOOLs: Arcline makes its own") },
    Row { what: "@Target", meaning: Meaning::Form("a BOOL's host: Arcline makes its own") },
    Row { what: "@BitNumber", meaning: Meaning::Form("BOOLs are packed in their order") },
    Row { what: "@ExternalAccess", meaning: Meaning::Without("Read/Write") },
    Row { what: "Description", meaning: Meaning::Without("") },
];

#[rustfmt::skip]
const TAGS: &[Row] = &[
    Row { what: "@Use", meaning: Meaning::Form("about the file") },
    Row { what: "Tag", meaning: Meaning::Key("tag, axis, coordinate_system, motion_group") },
];

#[rustfmt::skip]
const TAG: &[Row] = &[
    Row { what: "@Use", meaning: Meaning::Form("about the file") },
    Row { what: "@Name", meaning: Meaning::Key("tag.name") },
    Row { what: "@TagType", meaning: Meaning::Form("Alias: see AliasFor") },
    Row { what: "@DataType", meaning: Meaning::Key("tag.type") },
    Row { what: "@Dimensions", meaning: Meaning::Key("tag.type") },
    Row { what: "@Radix", meaning: Meaning::Form("how a value is shown") },
    Row { what: "@AliasFor", meaning: Meaning::Key("tag.alias") },
    Row { what: "@ExternalAccess", meaning: Meaning::Key("tag.access") },
    Row { what: "@Constant", meaning: Meaning::Key("tag.access") },
    Row { what: "@OpcUaAccess", meaning: Meaning::Without("None") },
    Row { what: "@Class", meaning: Meaning::Without("Standard") },
    Row { what: "@Usage", meaning: Meaning::Without("Normal") },
    Row { what: "@IO", meaning: Meaning::Without("false") },
    Row { what: "@PermissionSet", meaning: Meaning::Without("") },
    Row { what: "@Verified", meaning: Meaning::Without("false") },
    Row { what: "Data", meaning: Meaning::Key("tag.value") },
    Row { what: "Description", meaning: Meaning::Without("") },
    Row { what: "Comments", meaning: Meaning::Without("") },
    Row { what: "EngineeringUnits", meaning: Meaning::Without("") },
    Row { what: "Mins", meaning: Meaning::Without("") },
    Row { what: "Maxes", meaning: Meaning::Without("") },
    Row { what: "State0s", meaning: Meaning::Without("") },
    Row { what: "State1s", meaning: Meaning::Without("") },
    Row { what: "ForceData", meaning: Meaning::Without("") },
    Row { what: "ProduceInfo", meaning: Meaning::Without("") },
    Row { what: "ConsumeInfo", meaning: Meaning::Without("") },
    Row { what: "AlarmConditions", meaning: Meaning::Without("") },
    Row { what: "CustomProperties", meaning: Meaning::Without("") },
    Row { what: "DefaultData", meaning: Meaning::Without("") },
];

#[rustfmt::skip]
const DATA: &[Row] = &[
    Row { what: "@Format", meaning: Meaning::Form("Decorated and String are read; L5K and bytes only where they stand alone") },
    Row { what: "@Length", meaning: Meaning::Form("follows from the text") },
    Row { what: "@ForceDecorated", meaning: Meaning::Form("about the file") },
    Row { what: "DataValue", meaning: Meaning::Form("a value") },
    Row { what: "Array", meaning: Meaning::Form("a value") },
    Row { what: "Structure", meaning: Meaning::Form("a value") },
    Row { what: "AxisParameters", meaning: Meaning::Key("axis") },
    Row { what: "CoordinateSystemParameters", meaning: Meaning::Key("coordinate_system") },
    Row { what: "MotionGroupParameters", meaning: Meaning::Key("motion_group") },
];

#[rustfmt::skip]
const DATA_VALUE: &[Row] = &[
    Row { what: "@DataType", meaning: Meaning::Form("that of the definition") },
    Row { what: "@Radix", meaning: Meaning::Form("how a value is shown") },
    Row { what: "@Value", meaning: Meaning::Key("tag.value") },
];

#[rustfmt::skip]
const DATA_VALUE_MEMBER: &[Row] = &[
    Row { what: "@DataType", meaning: Meaning::Form("that of the definition") },
    Row { what: "@Radix", meaning: Meaning::Form("how a value is shown") },
    Row { what: "@Name", meaning: Meaning::Form("the member") },
    Row { what: "@Value", meaning: Meaning::Key("tag.value") },
];

#[rustfmt::skip]
const ARRAY: &[Row] = &[
    Row { what: "@DataType", meaning: Meaning::Form("that of the definition") },
    Row { what: "@Radix", meaning: Meaning::Form("how a value is shown") },
    Row { what: "@Dimensions", meaning: Meaning::Form("those of the tag") },
    Row { what: "Element", meaning: Meaning::Key("tag.value") },
];

#[rustfmt::skip]
const ARRAY_MEMBER: &[Row] = &[
    Row { what: "@DataType", meaning: Meaning::Form("that of the definition") },
    Row { what: "@Radix", meaning: Meaning::Form("how a value is shown") },
    Row { what: "@Dimensions", meaning: Meaning::Form("those of the tag") },
    Row { what: "Element", meaning: Meaning::Key("tag.value") },
    Row { what: "@Name", meaning: Meaning::Form("the member") },
];

#[rustfmt::skip]
const ELEMENT: &[Row] = &[
    Row { what: "@Index", meaning: Meaning::Form("follows from the place") },
    Row { what: "@Value", meaning: Meaning::Key("tag.value") },
    Row { what: "Structure", meaning: Meaning::Form("a value") },
];

#[rustfmt::skip]
const STRUCTURE: &[Row] = &[
    Row { what: "@DataType", meaning: Meaning::Form("that of the definition") },
    Row { what: "DataValueMember", meaning: Meaning::Key("tag.value") },
    Row { what: "ArrayMember", meaning: Meaning::Key("tag.value") },
    Row { what: "StructureMember", meaning: Meaning::Key("tag.value") },
];

#[rustfmt::skip]
const STRUCTURE_MEMBER: &[Row] = &[
    Row { what: "@DataType", meaning: Meaning::Form("that of the definition") },
    Row { what: "DataValueMember", meaning: Meaning::Key("tag.value") },
    Row { what: "ArrayMember", meaning: Meaning::Key("tag.value") },
    Row { what: "StructureMember", meaning: Meaning::Key("tag.value") },
    Row { what: "@Name", meaning: Meaning::Form("the member") },
];

#[rustfmt::skip]
const PROGRAMS: &[Row] = &[
    Row { what: "@Use", meaning: Meaning::Form("about the file") },
    Row { what: "Program", meaning: Meaning::Key("tag.program") },
];

#[rustfmt::skip]
const PROGRAM: &[Row] = &[
    Row { what: "@Use", meaning: Meaning::Form("about the file") },
    Row { what: "@Name", meaning: Meaning::Key("tag.program") },
    Row { what: "Tags", meaning: Meaning::Form("holds Tag") },
    Row { what: "Routines", meaning: Meaning::Each },
    Row { what: "ChildPrograms", meaning: Meaning::Each },
    Row { what: "@MainRoutineName", meaning: Meaning::Without("") },
    Row { what: "@FaultRoutineName", meaning: Meaning::Without("") },
    Row { what: "@PreStateRoutineName", meaning: Meaning::Without("") },
    Row { what: "@CompleteStateIfNotImpl", meaning: Meaning::Without("") },
    Row { what: "@InitialStepIndex", meaning: Meaning::Without("") },
    Row { what: "@LossOfCommCmd", meaning: Meaning::Without("") },
    Row { what: "@ExternalRequestAction", meaning: Meaning::Without("") },
    Row { what: "@AutoValueAssignStepToPhase", meaning: Meaning::Without("") },
    Row { what: "@AutoValueAssignPhaseToStepOnComplete", meaning: Meaning::Without("") },
    Row { what: "@AutoValueAssignPhaseToStepOnStopped", meaning: Meaning::Without("") },
    Row { what: "@AutoValueAssignPhaseToStepOnAborted", meaning: Meaning::Without("") },
    Row { what: "@UnitID", meaning: Meaning::Without("") },
    Row { what: "@Type", meaning: Meaning::Without("Normal") },
    Row { what: "@Class", meaning: Meaning::Without("Standard") },
    Row { what: "@TestEdits", meaning: Meaning::Without("false") },
    Row { what: "@Disabled", meaning: Meaning::Without("false") },
    Row { what: "@SynchronizeRedundancyDataAfterExecution", meaning: Meaning::Without("false") },
    Row { what: "@UseAsFolder", meaning: Meaning::Without("false") },
    Row { what: "@InitialState", meaning: Meaning::Without("Idle") },
    Row { what: "@RetainSequenceIDOnReset", meaning: Meaning::Without("false") },
    Row { what: "@GenerateSequenceEvents", meaning: Meaning::Without("false") },
    Row { what: "@ValuesToUseOnStart", meaning: Meaning::Without("") },
    Row { what: "@ValuesToUseOnReset", meaning: Meaning::Without("") },
    Row { what: "Description", meaning: Meaning::Without("") },
    Row { what: "CustomProperties", meaning: Meaning::Without("") },
];

#[rustfmt::skip]
const MOTION_GROUP_PARAMETERS: &[Row] = &[
    Row { what: "@CoarseUpdatePeriod", meaning: Meaning::Key("motion_group.coarse_update_period_ms") },
    Row { what: "@GroupType", meaning: Meaning::Form("one kind") },
    Row { what: "@PhaseShift", meaning: Meaning::Without("0") },
    Row { what: "@GeneralFaultType", meaning: Meaning::Without("Non Major Fault") },
    Row { what: "@AutoTagUpdate", meaning: Meaning::Without("Enabled") },
    Row { what: "@Alternate1UpdateMultiplier", meaning: Meaning::Without("1") },
    Row { what: "@Alternate2UpdateMultiplier", meaning: Meaning::Without("1") },
];

#[rustfmt::skip]
const AXIS_PARAMETERS: &[Row] = &[
    Row { what: "@MaximumSpeed", meaning: Meaning::Key("axis.max_speed") },
    Row { what: "@MaximumAcceleration", meaning: Meaning::Key("axis.max_acceleration") },
    Row { what: "@MaximumDeceleration", meaning: Meaning::Key("axis.max_deceleration") },
    Row { what: "@MaximumAccelerationJerk", meaning: Meaning::Key("axis.max_acceleration_jerk") },
    Row { what: "@MaximumDecelerationJerk", meaning: Meaning::Key("axis.max_deceleration_jerk") },
    Row { what: "@DynamicsConfigurationBits", meaning: Meaning::Key("axis.dynamics_configuration_bits") },
    Row { what: "@PositionUnits", meaning: Meaning::Key("axis.units") },
    Row { what: "@AverageVelocityTimebase", meaning: Meaning::Key("axis.average_velocity_timebase") },
    Row { what: "@RotaryAxis", meaning: Meaning::Key("axis.unwind") },
    Row { what: "@TravelMode", meaning: Meaning::Key("axis.unwind") },
    Row { what: "@PositionUnwind", meaning: Meaning::Key("axis.unwind") },
    Row { what: "@ConversionConstant", meaning: Meaning::Key("axis.unwind") },
    Row { what: "@ProgrammedStopMode", meaning: Meaning::Key("axis.programmed_stop_mode") },
    Row { what: "@SoftTravelLimitChecking", meaning: Meaning::Key("axis.travel") },
    Row { what: "@SoftTravelLimitPositive", meaning: Meaning::Key("axis.travel.max") },
    Row { what: "@SoftTravelLimitNegative", meaning: Meaning::Key("axis.travel.min") },
    Row { what: "@HomeMode", meaning: Meaning::Key("axis.home.mode") },
    Row { what: "@HomeDirection", meaning: Meaning::Key("axis.home.direction") },
    Row { what: "@HomeSequence", meaning: Meaning::Key("axis.home.sequence") },
    Row { what: "@HomePosition", meaning: Meaning::Key("axis.home.position") },
    Row { what: "@HomeOffset", meaning: Meaning::Key("axis.home.offset") },
    Row { what: "@HomeSpeed", meaning: Meaning::Key("axis.home.speed") },
    Row { what: "@HomeReturnSpeed", meaning: Meaning::Key("axis.home.return_speed") },
    Row { what: "@HomeAcceleration", meaning: Meaning::Key("axis.home.acceleration") },
    Row { what: "@HomeDeceleration", meaning: Meaning::Key("axis.home.deceleration") },
    Row { what: "@PositionLoopBandwidth", meaning: Meaning::Key("axis.drive.position_bandwidth_hz") },
    Row { what: "@VelocityFeedforwardGain", meaning: Meaning::Key("axis.drive.velocity_feedforward") },
    Row { what: "@PositionErrorTolerance", meaning: Meaning::Key("axis.drive.position_error_tolerance") },
    Row { what: "@PositionErrorToleranceTime", meaning: Meaning::Key("axis.drive.position_error_tolerance_time") },
    Row { what: "@MotionExceptionAction", meaning: Meaning::Key("axis.exception_actions") },
    Row { what: "@CIPAxisExceptionAction", meaning: Meaning::Key("axis.exception_actions") },
    Row { what: "@MotionGroup", meaning: Meaning::Form("there is one group") },
    Row { what: "@AxisID", meaning: Meaning::Form("an identity of the project") },
    Row { what: "@AxisConfiguration", meaning: Meaning::Form("a servo closes the position loop; others are reported") },
    Row { what: "@ApplicationCatalogNumberInstance", meaning: Meaning::Form("about the file") },
    Row { what: "@ApplicationCatalogNumberVersion", meaning: Meaning::Form("about the file") },
    Row { what: "@OutputCamExecutionTargets", meaning: Meaning::Key("axis.output_cam_execution_targets") },
    Row { what: "@HomeConfigurationBits", meaning: Meaning::Without("16#0000_0000") },
    Row { what: "@MasterInputConfigurationBits", meaning: Meaning::Without("1") },
    Row { what: "@MasterPositionFilterBandwidth", meaning: Meaning::Without("0.1") },
    Row { what: "@InterpolatedPositionConfiguration", meaning: Meaning::Without("16#0000_0002") },
    Row { what: "@AxisUpdateSchedule", meaning: Meaning::Without("Base") },
    Row { what: "@MotionModule", meaning: Meaning::Without("<NA>") },
    Row { what: "@MotionPolarity", meaning: Meaning::Without("Normal") },
    Row { what: "@PositionLockTolerance", meaning: Meaning::Without("0.01") },
    Row { what: "@TravelRange", meaning: Meaning::Without("1000.0") },
    Row { what: "@MotionResolution", meaning: Meaning::Without("1000000") },
    Row { what: "@PositionScalingNumerator", meaning: Meaning::Without("1.0") },
    Row { what: "@PositionScalingDenominator", meaning: Meaning::Without("1.0") },
    Row { what: "@PositionUnwindNumerator", meaning: Meaning::Without("1.0") },
    Row { what: "@PositionUnwindDenominator", meaning: Meaning::Without("1.0") },
    Row { what: "@AccelerationFeedforwardGain", meaning: Meaning::Without("0.0") },
    Row { what: "@VelocityOffset", meaning: Meaning::Without("0.0") },
    Row { what: "@TorqueOffset", meaning: Meaning::Without("0.0") },
    Row { what: "@BacklashReversalOffset", meaning: Meaning::Without("0.0") },
    Row { what: "@CIPAxisExceptionActionRA", meaning: Meaning::Without("Unsupported") },
    Row { what: "@CIPAxisExceptionActionMfg", meaning: Meaning::Without("Unsupported") },
    Row { what: "@StoppingAction", meaning: Meaning::Without("Current Decel Disable") },
    Row { what: "@FeedbackConfiguration", meaning: Meaning::Without("") },
    Row { what: "@MotorDataSource", meaning: Meaning::Without("") },
    Row { what: "@MotorCatalogNumber", meaning: Meaning::Without("") },
    Row { what: "@Feedback1Type", meaning: Meaning::Without("") },
    Row { what: "@Feedback2Type", meaning: Meaning::Without("") },
    Row { what: "@MotorType", meaning: Meaning::Without("") },
    Row { what: "@MotionScalingConfiguration", meaning: Meaning::Without("") },
    Row { what: "@TuningTravelLimit", meaning: Meaning::Without("") },
    Row { what: "@TuningSpeed", meaning: Meaning::Without("") },
    Row { what: "@TuningTorque", meaning: Meaning::Without("") },
    Row { what: "@DampingFactor", meaning: Meaning::Without("") },
    Row { what: "@DriveModelTimeConstant", meaning: Meaning::Without("") },
    Row { what: "@PositionServoBandwidth", meaning: Meaning::Without("") },
    Row { what: "@VelocityServoBandwidth", meaning: Meaning::Without("") },
    Row { what: "@VelocityStandstillWindow", meaning: Meaning::Without("") },
    Row { what: "@TorqueLimitPositive", meaning: Meaning::Without("") },
    Row { what: "@TorqueLimitNegative", meaning: Meaning::Without("") },
    Row { what: "@StoppingTorque", meaning: Meaning::Without("") },
    Row { what: "@LoadInertiaRatio", meaning: Meaning::Without("") },
    Row { what: "@RegistrationInputs", meaning: Meaning::Without("") },
    Row { what: "@PositionIntegratorBandwidth", meaning: Meaning::Without("") },
    Row { what: "@PositionIntegratorControl", meaning: Meaning::Without("") },
    Row { what: "@PositionIntegratorHold", meaning: Meaning::Without("") },
    Row { what: "@VelocityIntegratorControl", meaning: Meaning::Without("") },
    Row { what: "@SystemInertia", meaning: Meaning::Without("") },
    Row { what: "@InverterCapacity", meaning: Meaning::Without("") },
    Row { what: "@ConverterCapacity", meaning: Meaning::Without("") },
    Row { what: "@MotorUnit", meaning: Meaning::Without("") },
    Row { what: "@Feedback1Unit", meaning: Meaning::Without("") },
    Row { what: "@Feedback2Unit", meaning: Meaning::Without("") },
    Row { what: "@ScalingSource", meaning: Meaning::Without("") },
    Row { what: "@LoadType", meaning: Meaning::Without("") },
    Row { what: "@ActuatorType", meaning: Meaning::Without("") },
    Row { what: "@MotorTestResistance", meaning: Meaning::Without("") },
    Row { what: "@MotorTestInductance", meaning: Meaning::Without("") },
    Row { what: "@TuneFriction", meaning: Meaning::Without("") },
    Row { what: "@TuneLoadOffset", meaning: Meaning::Without("") },
    Row { what: "@TuningSelect", meaning: Meaning::Without("") },
    Row { what: "@TuningDirection", meaning: Meaning::Without("") },
    Row { what: "@ApplicationType", meaning: Meaning::Without("") },
    Row { what: "@LoopResponse", meaning: Meaning::Without("") },
    Row { what: "@VelocityLoopBandwidth", meaning: Meaning::Without("") },
    Row { what: "@VelocityIntegratorBandwidth", meaning: Meaning::Without("") },
    Row { what: "@LoadRatio", meaning: Meaning::Without("") },
    Row { what: "@TuneInertiaMass", meaning: Meaning::Without("") },
    Row { what: "@GainTuningConfigurationBits", meaning: Meaning::Without("") },
    Row { what: "@SystemBandwidth", meaning: Meaning::Without("") },
    Row { what: "@TransmissionRatioInput", meaning: Meaning::Without("") },
    Row { what: "@TransmissionRatioOutput", meaning: Meaning::Without("") },
    Row { what: "@ActuatorLead", meaning: Meaning::Without("") },
    Row { what: "@ActuatorLeadUnit", meaning: Meaning::Without("") },
    Row { what: "@ActuatorDiameter", meaning: Meaning::Without("") },
    Row { what: "@ActuatorDiameterUnit", meaning: Meaning::Without("") },
    Row { what: "@SystemAccelerationBase", meaning: Meaning::Without("") },
    Row { what: "@DriveModelTimeConstantBase", meaning: Meaning::Without("") },
    Row { what: "@DriveRatedPeakCurrent", meaning: Meaning::Without("") },
    Row { what: "@HookupTestDistance", meaning: Meaning::Without("") },
    Row { what: "@HookupTestFeedbackChannel", meaning: Meaning::Without("") },
    Row { what: "@HookupTestSpeed", meaning: Meaning::Without("") },
    Row { what: "@LoadCoupling", meaning: Meaning::Without("") },
    Row { what: "@SystemDamping", meaning: Meaning::Without("") },
    Row { what: "@BusOvervoltageOperationalLimit", meaning: Meaning::Without("") },
    Row { what: "@CurrentLoopBandwidthScalingFactor", meaning: Meaning::Without("") },
    Row { what: "@CurrentLoopBandwidth", meaning: Meaning::Without("") },
    Row { what: "@DriveRatedVoltage", meaning: Meaning::Without("") },
    Row { what: "@MaxOutputFrequency", meaning: Meaning::Without("") },
    Row { what: "@MotorTestDataValid", meaning: Meaning::Without("") },
    Row { what: "@TestModeConfiguration", meaning: Meaning::Without("") },
    Row { what: "@TestModeEnable", meaning: Meaning::Without("") },
    Row { what: "@VelocityErrorTolerance", meaning: Meaning::Without("") },
    Row { what: "@VelocityErrorToleranceTime", meaning: Meaning::Without("") },
    Row { what: "@VelocityLimitPositive", meaning: Meaning::Without("") },
    Row { what: "@VelocityLimitNegative", meaning: Meaning::Without("") },
    Row { what: "@VelocityThreshold", meaning: Meaning::Without("") },
    Row { what: "@VelocityLockTolerance", meaning: Meaning::Without("") },
    Row { what: "@AccelerationLimit", meaning: Meaning::Without("") },
    Row { what: "@DecelerationLimit", meaning: Meaning::Without("") },
    Row { what: "@OvertorqueLimit", meaning: Meaning::Without("") },
    Row { what: "@UndertorqueLimit", meaning: Meaning::Without("") },
];

#[rustfmt::skip]
const COORDINATE_SYSTEM_PARAMETERS: &[Row] = &[
    Row { what: "@MaximumSpeed", meaning: Meaning::Key("coordinate_system.max_speed") },
    Row { what: "@MaximumAcceleration", meaning: Meaning::Key("coordinate_system.max_acceleration") },
    Row { what: "@MaximumDeceleration", meaning: Meaning::Key("coordinate_system.max_deceleration") },
    Row { what: "@MaximumAccelerationJerk", meaning: Meaning::Key("coordinate_system.max_acceleration_jerk") },
    Row { what: "@MaximumDecelerationJerk", meaning: Meaning::Key("coordinate_system.max_deceleration_jerk") },
    Row { what: "@DynamicsConfigurationBits", meaning: Meaning::Key("coordinate_system.dynamics_configuration_bits") },
    Row { what: "@SystemType", meaning: Meaning::Key("coordinate_system.type") },
    Row { what: "@Axes", meaning: Meaning::Key("coordinate_system.axes") },
    Row { what: "@ActualPositionTolerance", meaning: Meaning::Key("coordinate_system.actual_tolerance") },
    Row { what: "@CommandPositionTolerance", meaning: Meaning::Key("coordinate_system.command_tolerance") },
    Row { what: "@MaximumPendingMoves", meaning: Meaning::Key("coordinate_system.queue_depth") },
    Row { what: "@MotionGroup", meaning: Meaning::Form("there is one group") },
    Row { what: "@MotionGroupInstance", meaning: Meaning::Form("there is one group") },
    Row { what: "@Dimension", meaning: Meaning::Form("follows from the axes") },
    Row { what: "@ApplicationCatalogNumberInstance", meaning: Meaning::Form("about the file") },
    Row { what: "@ApplicationCatalogNumberVersion", meaning: Meaning::Form("about the file") },
    Row { what: "@CoordinateDefinition", meaning: Meaning::Key("coordinate_system.definition") },
    Row { what: "@CoordinationMode", meaning: Meaning::Without("Primary") },
    Row { what: "@CoordinationUnits", meaning: Meaning::Without("Coordination Units") },
    Row { what: "@ConversionRatioNumerator", meaning: Meaning::Without("1.0") },
    Row { what: "@ConversionRatioDenominator", meaning: Meaning::Without("1") },
    Row { what: "@CoordinateSystemAutoTagUpdate", meaning: Meaning::Without("Enabled") },
    Row { what: "@TransformDimension", meaning: Meaning::Form("follows from the axes; another one is reported") },
    Row { what: "@MasterInputConfigurationBits", meaning: Meaning::Without("1") },
    Row { what: "@MasterPositionFilterBandwidth", meaning: Meaning::Without("0.1") },
    Row { what: "@SwingArmCouplingRatioNumerator", meaning: Meaning::Without("1") },
    Row { what: "@SwingArmCouplingRatioDenominator", meaning: Meaning::Without("1") },
    Row { what: "@SwingArmCouplingDirection", meaning: Meaning::Without("<none>") },
    Row { what: "@RobotJointsDirectionSenseBits", meaning: Meaning::Without("0") },
    Row { what: "@JointRatioNumerator", meaning: Meaning::Without("1.0") },
    Row { what: "@JointRatioDenominator", meaning: Meaning::Without("1") },
    Row { what: "@BallScrewLead", meaning: Meaning::Without("0.0") },
    Row { what: "@LinkLength1", meaning: Meaning::Key("coordinate_system.link_lengths") },
    Row { what: "@LinkLength2", meaning: Meaning::Key("coordinate_system.link_lengths") },
    Row { what: "@LinkLength3", meaning: Meaning::Without("0.0") },
    Row { what: "@ZeroAngleOffset1", meaning: Meaning::Key("coordinate_system.zero_angles") },
    Row { what: "@ZeroAngleOffset2", meaning: Meaning::Key("coordinate_system.zero_angles") },
    Row { what: "@ZeroAngleOffset3", meaning: Meaning::Key("coordinate_system.zero_angles") },
    Row { what: "@ZeroAngleOffset4", meaning: Meaning::Key("coordinate_system.zero_angles") },
    Row { what: "@ZeroAngleOffset5", meaning: Meaning::Key("coordinate_system.zero_angles") },
    Row { what: "@ZeroAngleOffset6", meaning: Meaning::Key("coordinate_system.zero_angles") },
    Row { what: "@BaseOffset1", meaning: Meaning::Key("coordinate_system.base_offsets") },
    Row { what: "@BaseOffset2", meaning: Meaning::Key("coordinate_system.base_offsets") },
    Row { what: "@BaseOffset3", meaning: Meaning::Key("coordinate_system.base_offsets") },
    Row { what: "@EndEffectorOffset1", meaning: Meaning::Key("coordinate_system.end_effector_offsets") },
    Row { what: "@EndEffectorOffset2", meaning: Meaning::Key("coordinate_system.end_effector_offsets") },
    Row { what: "@EndEffectorOffset3", meaning: Meaning::Key("coordinate_system.end_effector_offsets") },
    Row { what: "@SwingArmA3", meaning: Meaning::Without("0.0") },
    Row { what: "@SwingArmD3", meaning: Meaning::Without("0.0") },
    Row { what: "@SwingArmA4", meaning: Meaning::Without("0.0") },
    Row { what: "@SwingArmD4", meaning: Meaning::Without("0.0") },
    Row { what: "@SwingArmD5", meaning: Meaning::Without("0.0") },
    Row { what: "@MaximumOrientationSpeed", meaning: Meaning::Key("coordinate_system.max_orientation_speed") },
    Row { what: "@MaximumOrientationAcceleration", meaning: Meaning::Key("coordinate_system.max_orientation_acceleration") },
    Row { what: "@MaximumOrientationDeceleration", meaning: Meaning::Key("coordinate_system.max_orientation_deceleration") },
];

//! Bits and byte offsets of the predefined types. A test compares them with the layouts.

/// Bits of AxisStatus.
pub mod axis_status {
    /// `ServoActionStatus`, bit 0.
    pub const SERVO_ACTION_STATUS: u32 = 1 << 0;
    /// `DriveEnableStatus`, bit 1.
    pub const DRIVE_ENABLE_STATUS: u32 = 1 << 1;
    /// `ShutdownStatus`, bit 2.
    pub const SHUTDOWN_STATUS: u32 = 1 << 2;
    /// `ConfigUpdateInProcess`, bit 3.
    pub const CONFIG_UPDATE_IN_PROCESS: u32 = 1 << 3;
    /// `InhibitStatus`, bit 4.
    pub const INHIBIT_STATUS: u32 = 1 << 4;
    /// `DirectControlStatus`, bit 5.
    pub const DIRECT_CONTROL_STATUS: u32 = 1 << 5;
    /// `AxisUpdateStatus`, bit 6.
    pub const AXIS_UPDATE_STATUS: u32 = 1 << 6;
}

/// Bits of MotionStatus of an axis.
pub mod motion_status {
    /// `AccelStatus`, bit 0.
    pub const ACCEL_STATUS: u32 = 1 << 0;
    /// `DecelStatus`, bit 1.
    pub const DECEL_STATUS: u32 = 1 << 1;
    /// `MoveStatus`, bit 2.
    pub const MOVE_STATUS: u32 = 1 << 2;
    /// `JogStatus`, bit 3.
    pub const JOG_STATUS: u32 = 1 << 3;
    /// `GearingStatus`, bit 4.
    pub const GEARING_STATUS: u32 = 1 << 4;
    /// `HomingStatus`, bit 5.
    pub const HOMING_STATUS: u32 = 1 << 5;
    /// `StoppingStatus`, bit 6.
    pub const STOPPING_STATUS: u32 = 1 << 6;
    /// `AxisHomedStatus`, bit 7.
    pub const AXIS_HOMED_STATUS: u32 = 1 << 7;
    /// `PositionCamStatus`, bit 8.
    pub const POSITION_CAM_STATUS: u32 = 1 << 8;
    /// `TimeCamStatus`, bit 9.
    pub const TIME_CAM_STATUS: u32 = 1 << 9;
    /// `PositionCamPendingStatus`, bit 10.
    pub const POSITION_CAM_PENDING_STATUS: u32 = 1 << 10;
    /// `TimeCamPendingStatus`, bit 11.
    pub const TIME_CAM_PENDING_STATUS: u32 = 1 << 11;
    /// `GearingLockStatus`, bit 12.
    pub const GEARING_LOCK_STATUS: u32 = 1 << 12;
    /// `PositionCamLockStatus`, bit 13.
    pub const POSITION_CAM_LOCK_STATUS: u32 = 1 << 13;
    /// `TimeCamLockStatus`, bit 14.
    pub const TIME_CAM_LOCK_STATUS: u32 = 1 << 14;
    /// `MasterOffsetMoveStatus`, bit 15.
    pub const MASTER_OFFSET_MOVE_STATUS: u32 = 1 << 15;
    /// `CoordinatedMotionStatus`, bit 16.
    pub const COORDINATED_MOTION_STATUS: u32 = 1 << 16;
    /// `TransformStateStatus`, bit 17.
    pub const TRANSFORM_STATE_STATUS: u32 = 1 << 17;
    /// `ControlledByTransformStatus`, bit 18.
    pub const CONTROLLED_BY_TRANSFORM_STATUS: u32 = 1 << 18;
    /// `DirectVelocityControlStatus`, bit 19.
    pub const DIRECT_VELOCITY_CONTROL_STATUS: u32 = 1 << 19;
    /// `DirectTorqueControlStatus`, bit 20.
    pub const DIRECT_TORQUE_CONTROL_STATUS: u32 = 1 << 20;
    /// `MoveLockStatus`, bit 22.
    pub const MOVE_LOCK_STATUS: u32 = 1 << 22;
    /// `JogLockStatus`, bit 24.
    pub const JOG_LOCK_STATUS: u32 = 1 << 24;
    /// `MasterOffsetMoveLockStatus`, bit 26.
    pub const MASTER_OFFSET_MOVE_LOCK_STATUS: u32 = 1 << 26;
    /// `MaximumSpeedExceeded`, bit 27.
    pub const MAXIMUM_SPEED_EXCEEDED: u32 = 1 << 27;
}

/// Bits of AxisFault, also of coordinate systems and the group (0 to 3).
pub mod axis_fault {
    /// `PhysicalAxisFault`, bit 0.
    pub const PHYSICAL_AXIS_FAULT: u32 = 1 << 0;
    /// `ModuleFault`, bit 1.
    pub const MODULE_FAULT: u32 = 1 << 1;
    /// `ConfigFault`, bit 2.
    pub const CONFIG_FAULT: u32 = 1 << 2;
    /// `GroupFault`, bit 3.
    pub const GROUP_FAULT: u32 = 1 << 3;
    /// `MotionFault`, bit 4.
    pub const MOTION_FAULT: u32 = 1 << 4;
    /// `GuardFault`, bit 5.
    pub const GUARD_FAULT: u32 = 1 << 5;
    /// `InitializationFault`, bit 6.
    pub const INITIALIZATION_FAULT: u32 = 1 << 6;
    /// `APRFault`, bit 7.
    pub const APR_FAULT: u32 = 1 << 7;
    /// `SafetyFault`, bit 8.
    pub const SAFETY_FAULT: u32 = 1 << 8;
}

/// Bits of AxisEvent.
pub mod axis_event {
    /// `WatchEventArmedStatus`, bit 0.
    pub const WATCH_EVENT_ARMED_STATUS: u32 = 1 << 0;
    /// `WatchEventStatus`, bit 1.
    pub const WATCH_EVENT_STATUS: u32 = 1 << 1;
    /// `RegEvent1ArmedStatus`, bit 2.
    pub const REG_EVENT1_ARMED_STATUS: u32 = 1 << 2;
    /// `RegEvent1Status`, bit 3.
    pub const REG_EVENT1_STATUS: u32 = 1 << 3;
    /// `RegEvent2ArmedStatus`, bit 4.
    pub const REG_EVENT2_ARMED_STATUS: u32 = 1 << 4;
    /// `RegEvent2Status`, bit 5.
    pub const REG_EVENT2_STATUS: u32 = 1 << 5;
    /// `HomeEventArmedStatus`, bit 6.
    pub const HOME_EVENT_ARMED_STATUS: u32 = 1 << 6;
    /// `HomeEventStatus`, bit 7.
    pub const HOME_EVENT_STATUS: u32 = 1 << 7;
}

/// Bits of MotionFaultStatus.
pub mod motion_fault_status {
    /// `SoftTravelLimitPositiveFault`, bit 1.
    pub const SOFT_TRAVEL_LIMIT_POSITIVE_FAULT: u32 = 1 << 1;
    /// `SoftTravelLimitNegativeFault`, bit 2.
    pub const SOFT_TRAVEL_LIMIT_NEGATIVE_FAULT: u32 = 1 << 2;
}

/// Bits of MotionAlarmStatus.
pub mod motion_alarm_status {
    /// `SoftTravelLimitPositiveAlarm`, bit 1.
    pub const SOFT_TRAVEL_LIMIT_POSITIVE_ALARM: u32 = 1 << 1;
    /// `SoftTravelLimitNegativeAlarm`, bit 2.
    pub const SOFT_TRAVEL_LIMIT_NEGATIVE_ALARM: u32 = 1 << 2;
}

/// Bits of CIPAxisIOStatus.
pub mod cip_axis_io_status {
    /// `HomeInputStatus`, bit 1.
    pub const HOME_INPUT_STATUS: u32 = 1 << 1;
    /// `Registration1InputStatus`, bit 2.
    pub const REGISTRATION1_INPUT_STATUS: u32 = 1 << 2;
    /// `Registration2InputStatus`, bit 3.
    pub const REGISTRATION2_INPUT_STATUS: u32 = 1 << 3;
}

/// Bits of CIPAxisStatus.
pub mod cip_axis_status {
    /// `LocalControlStatus`, bit 0.
    pub const LOCAL_CONTROL_STATUS: u32 = 1 << 0;
    /// `AlarmStatus`, bit 1.
    pub const ALARM_STATUS: u32 = 1 << 1;
    /// `DCBusUpStatus`, bit 2.
    pub const DC_BUS_UP_STATUS: u32 = 1 << 2;
    /// `PowerStructureEnabledStatus`, bit 3.
    pub const POWER_STRUCTURE_ENABLED_STATUS: u32 = 1 << 3;
    /// `MotorFluxUpStatus`, bit 4.
    pub const MOTOR_FLUX_UP_STATUS: u32 = 1 << 4;
    /// `TrackingCommandStatus`, bit 5.
    pub const TRACKING_COMMAND_STATUS: u32 = 1 << 5;
    /// `PositionLockStatus`, bit 6.
    pub const POSITION_LOCK_STATUS: u32 = 1 << 6;
    /// `VelocityLockStatus`, bit 7.
    pub const VELOCITY_LOCK_STATUS: u32 = 1 << 7;
    /// `VelocityStandstillStatus`, bit 8.
    pub const VELOCITY_STANDSTILL_STATUS: u32 = 1 << 8;
    /// `VelocityThresholdStatus`, bit 9.
    pub const VELOCITY_THRESHOLD_STATUS: u32 = 1 << 9;
    /// `VelocityLimitStatus`, bit 10.
    pub const VELOCITY_LIMIT_STATUS: u32 = 1 << 10;
    /// `AccelerationLimitStatus`, bit 11.
    pub const ACCELERATION_LIMIT_STATUS: u32 = 1 << 11;
    /// `DecelerationLimitStatus`, bit 12.
    pub const DECELERATION_LIMIT_STATUS: u32 = 1 << 12;
    /// `TorqueThresholdStatus`, bit 13.
    pub const TORQUE_THRESHOLD_STATUS: u32 = 1 << 13;
    /// `TorqueLimitStatus`, bit 14.
    pub const TORQUE_LIMIT_STATUS: u32 = 1 << 14;
    /// `CurrentLimitStatus`, bit 15.
    pub const CURRENT_LIMIT_STATUS: u32 = 1 << 15;
    /// `ThermalLimitStatus`, bit 16.
    pub const THERMAL_LIMIT_STATUS: u32 = 1 << 16;
    /// `FeedbackIntegrityStatus`, bit 17.
    pub const FEEDBACK_INTEGRITY_STATUS: u32 = 1 << 17;
    /// `CIPShutdownStatus`, bit 18.
    pub const CIP_SHUTDOWN_STATUS: u32 = 1 << 18;
    /// `InProcessStatus`, bit 19.
    pub const IN_PROCESS_STATUS: u32 = 1 << 19;
    /// `DCBusUnload`, bit 20.
    pub const DC_BUS_UNLOAD: u32 = 1 << 20;
    /// `ACPowerLossStatus`, bit 21.
    pub const AC_POWER_LOSS_STATUS: u32 = 1 << 21;
    /// `PositionControlModeStatus`, bit 22.
    pub const POSITION_CONTROL_MODE_STATUS: u32 = 1 << 22;
    /// `VelocityControlModeStatus`, bit 23.
    pub const VELOCITY_CONTROL_MODE_STATUS: u32 = 1 << 23;
    /// `TorqueControlModeStatus`, bit 24.
    pub const TORQUE_CONTROL_MODE_STATUS: u32 = 1 << 24;
}

/// Bits of CoordinateSystemStatus.
pub mod coordinate_system_status {
    /// `ShutdownStatus`, bit 0.
    pub const SHUTDOWN_STATUS: u32 = 1 << 0;
    /// `ReadyStatus`, bit 1.
    pub const READY_STATUS: u32 = 1 << 1;
    /// `MotionStatus`, bit 2.
    pub const MOTION_STATUS: u32 = 1 << 2;
    /// `AxisInhibitStatus`, bit 3.
    pub const AXIS_INHIBIT_STATUS: u32 = 1 << 3;
}

/// Bits of CoordinateMotionStatus.
pub mod coordinate_motion_status {
    /// `AccelStatus`, bit 0.
    pub const ACCEL_STATUS: u32 = 1 << 0;
    /// `DecelStatus`, bit 1.
    pub const DECEL_STATUS: u32 = 1 << 1;
    /// `ActualPosToleranceStatus`, bit 2.
    pub const ACTUAL_POS_TOLERANCE_STATUS: u32 = 1 << 2;
    /// `CommandPosToleranceStatus`, bit 3.
    pub const COMMAND_POS_TOLERANCE_STATUS: u32 = 1 << 3;
    /// `StoppingStatus`, bit 4.
    pub const STOPPING_STATUS: u32 = 1 << 4;
    /// `MoveStatus`, bit 6.
    pub const MOVE_STATUS: u32 = 1 << 6;
    /// `MoveTransitionStatus`, bit 7.
    pub const MOVE_TRANSITION_STATUS: u32 = 1 << 7;
    /// `MovePendingStatus`, bit 8.
    pub const MOVE_PENDING_STATUS: u32 = 1 << 8;
    /// `MovePendingQueueFullStatus`, bit 9.
    pub const MOVE_PENDING_QUEUE_FULL_STATUS: u32 = 1 << 9;
    /// `ToolChangeAllowedStatus`, bit 12.
    pub const TOOL_CHANGE_ALLOWED_STATUS: u32 = 1 << 12;
    /// `TransformSourceStatus`, bit 13.
    pub const TRANSFORM_SOURCE_STATUS: u32 = 1 << 13;
    /// `TransformTargetStatus`, bit 14.
    pub const TRANSFORM_TARGET_STATUS: u32 = 1 << 14;
    /// `CoordinateSystemLockStatus`, bit 15.
    pub const COORDINATE_SYSTEM_LOCK_STATUS: u32 = 1 << 15;
}

/// Bits of GroupStatus.
pub mod group_status {
    /// `InhibStatus`, bit 0.
    pub const INHIB_STATUS: u32 = 1 << 0;
    /// `GroupSynced`, bit 1.
    pub const GROUP_SYNCED: u32 = 1 << 1;
    /// `AxisInhibitStatus`, bit 3.
    pub const AXIS_INHIBIT_STATUS: u32 = 1 << 3;
}

/// Bits of GroupFault.
pub mod group_fault {
    /// `GroupOverlapFault`, bit 0.
    pub const GROUP_OVERLAP_FAULT: u32 = 1 << 0;
    /// `CSTLossFault`, bit 1.
    pub const CST_LOSS_FAULT: u32 = 1 << 1;
    /// `GroupTaskLoadingFault`, bit 2.
    pub const GROUP_TASK_LOADING_FAULT: u32 = 1 << 2;
    /// `ClockSyncFault`, bit 3.
    pub const CLOCK_SYNC_FAULT: u32 = 1 << 3;
}

/// Bits of State of REAL_TIME.
pub mod real_time_state {
    /// `Fifo`, bit 0.
    pub const FIFO: u32 = 1 << 0;
    /// `MemoryLocked`, bit 1.
    pub const MEMORY_LOCKED: u32 = 1 << 1;
    /// `Pinned`, bit 2.
    pub const PINNED: u32 = 1 << 2;
}

/// Byte offsets of the live members of AXIS_CIP_DRIVE.
pub mod axis_cip_drive_offset {
    /// `AxisFault` (DINT).
    pub const AXIS_FAULT: usize = 12;
    /// `AxisStatus` (DINT).
    pub const AXIS_STATUS: usize = 16;
    /// `MotionStatus` (DINT).
    pub const MOTION_STATUS: usize = 20;
    /// `MotionAlarmStatus` (DINT).
    pub const MOTION_ALARM_STATUS: usize = 76;
    /// `MotionFaultStatus` (DINT).
    pub const MOTION_FAULT_STATUS: usize = 80;
    /// `AxisEvent` (DINT).
    pub const AXIS_EVENT: usize = 84;
    /// `ActualPosition` (REAL).
    pub const ACTUAL_POSITION: usize = 104;
    /// `StrobeActualPosition` (REAL).
    pub const STROBE_ACTUAL_POSITION: usize = 108;
    /// `StartActualPosition` (REAL).
    pub const START_ACTUAL_POSITION: usize = 112;
    /// `AverageVelocity` (REAL).
    pub const AVERAGE_VELOCITY: usize = 116;
    /// `ActualVelocity` (REAL).
    pub const ACTUAL_VELOCITY: usize = 120;
    /// `ActualAcceleration` (REAL).
    pub const ACTUAL_ACCELERATION: usize = 124;
    /// `WatchPosition` (REAL).
    pub const WATCH_POSITION: usize = 128;
    /// `MasterOffset` (REAL).
    pub const MASTER_OFFSET: usize = 192;
    /// `StrobeMasterOffset` (REAL).
    pub const STROBE_MASTER_OFFSET: usize = 196;
    /// `StartMasterOffset` (REAL).
    pub const START_MASTER_OFFSET: usize = 200;
    /// `CommandPosition` (REAL).
    pub const COMMAND_POSITION: usize = 204;
    /// `StrobeCommandPosition` (REAL).
    pub const STROBE_COMMAND_POSITION: usize = 208;
    /// `StartCommandPosition` (REAL).
    pub const START_COMMAND_POSITION: usize = 212;
    /// `CommandVelocity` (REAL).
    pub const COMMAND_VELOCITY: usize = 220;
    /// `CommandAcceleration` (REAL).
    pub const COMMAND_ACCELERATION: usize = 224;
    /// `PositionError` (REAL).
    pub const POSITION_ERROR: usize = 280;
    /// `VelocityFeedback` (REAL).
    pub const VELOCITY_FEEDBACK: usize = 312;
    /// `VelocityError` (REAL).
    pub const VELOCITY_ERROR: usize = 316;
    /// `VelocityFeedforwardGain` (REAL).
    pub const VELOCITY_FEEDFORWARD_GAIN: usize = 756;
    /// `PositionLoopBandwidth` (REAL).
    pub const POSITION_LOOP_BANDWIDTH: usize = 764;
    /// `CIPAxisState` (INT).
    pub const CIP_AXIS_STATE: usize = 840;
    /// `CIPAxisStatus` (DINT).
    pub const CIP_AXIS_STATUS: usize = 844;
    /// `CIPAxisFaults` (LINT).
    pub const CIP_AXIS_FAULTS: usize = 880;
}

/// Byte offsets of the members of AXIS_VIRTUAL.
pub mod axis_virtual_offset {
    /// `AxisFault` (DINT).
    pub const AXIS_FAULT: usize = 12;
    /// `AxisStatus` (DINT).
    pub const AXIS_STATUS: usize = 16;
    /// `MotionStatus` (DINT).
    pub const MOTION_STATUS: usize = 20;
    /// `AxisEvent` (DINT).
    pub const AXIS_EVENT: usize = 24;
    /// `OutputCamStatus` (DINT).
    pub const OUTPUT_CAM_STATUS: usize = 28;
    /// `OutputCamPendingStatus` (DINT).
    pub const OUTPUT_CAM_PENDING_STATUS: usize = 32;
    /// `OutputCamLockStatus` (DINT).
    pub const OUTPUT_CAM_LOCK_STATUS: usize = 36;
    /// `OutputCamTransitionStatus` (DINT).
    pub const OUTPUT_CAM_TRANSITION_STATUS: usize = 40;
    /// `ActualPosition` (REAL).
    pub const ACTUAL_POSITION: usize = 44;
    /// `StrobeActualPosition` (REAL).
    pub const STROBE_ACTUAL_POSITION: usize = 48;
    /// `StartActualPosition` (REAL).
    pub const START_ACTUAL_POSITION: usize = 52;
    /// `AverageVelocity` (REAL).
    pub const AVERAGE_VELOCITY: usize = 56;
    /// `ActualVelocity` (REAL).
    pub const ACTUAL_VELOCITY: usize = 60;
    /// `ActualAcceleration` (REAL).
    pub const ACTUAL_ACCELERATION: usize = 64;
    /// `WatchPosition` (REAL).
    pub const WATCH_POSITION: usize = 68;
    /// `Registration1Position` (REAL).
    pub const REGISTRATION1_POSITION: usize = 72;
    /// `Registration2Position` (REAL).
    pub const REGISTRATION2_POSITION: usize = 76;
    /// `Registration1Time` (DINT).
    pub const REGISTRATION1_TIME: usize = 80;
    /// `Registration2Time` (DINT).
    pub const REGISTRATION2_TIME: usize = 84;
    /// `InterpolationTime` (DINT).
    pub const INTERPOLATION_TIME: usize = 88;
    /// `InterpolatedActualPosition` (REAL).
    pub const INTERPOLATED_ACTUAL_POSITION: usize = 92;
    /// `InterpolatedCommandPosition` (REAL).
    pub const INTERPOLATED_COMMAND_POSITION: usize = 96;
    /// `MasterOffset` (REAL).
    pub const MASTER_OFFSET: usize = 100;
    /// `StrobeMasterOffset` (REAL).
    pub const STROBE_MASTER_OFFSET: usize = 104;
    /// `StartMasterOffset` (REAL).
    pub const START_MASTER_OFFSET: usize = 108;
    /// `CommandPosition` (REAL).
    pub const COMMAND_POSITION: usize = 112;
    /// `StrobeCommandPosition` (REAL).
    pub const STROBE_COMMAND_POSITION: usize = 116;
    /// `StartCommandPosition` (REAL).
    pub const START_COMMAND_POSITION: usize = 120;
    /// `CommandVelocity` (REAL).
    pub const COMMAND_VELOCITY: usize = 124;
    /// `CommandAcceleration` (REAL).
    pub const COMMAND_ACCELERATION: usize = 128;
}

/// Byte offsets of the members of COORDINATE_SYSTEM.
pub mod coordinate_system_offset {
    /// `CoordinateSystemStatus` (DINT).
    pub const COORDINATE_SYSTEM_STATUS: usize = 12;
    /// `CoordinateMotionStatus` (DINT).
    pub const COORDINATE_MOTION_STATUS: usize = 16;
    /// `AxisFault` (DINT).
    pub const AXIS_FAULT: usize = 20;
    /// `PhysicalAxesFaulted` (DINT).
    pub const PHYSICAL_AXES_FAULTED: usize = 24;
    /// `ModulesFaulted` (DINT).
    pub const MODULES_FAULTED: usize = 28;
    /// `AxesConfigurationFaulted` (DINT).
    pub const AXES_CONFIGURATION_FAULTED: usize = 32;
    /// `AxesShutdownStatus` (DINT).
    pub const AXES_SHUTDOWN_STATUS: usize = 36;
    /// `AxesServoOnStatus` (DINT).
    pub const AXES_SERVO_ON_STATUS: usize = 40;
    /// `AxesInhibitedStatus` (DINT).
    pub const AXES_INHIBITED_STATUS: usize = 44;
    /// `ActualPosition` (`REAL[8]`).
    pub const ACTUAL_POSITION: usize = 52;
    /// `ActiveToolFrameID` (DINT).
    pub const ACTIVE_TOOL_FRAME_ID: usize = 84;
    /// `ActiveWorkFrameID` (DINT).
    pub const ACTIVE_WORK_FRAME_ID: usize = 88;
    /// `TurnsCounters` (`INT[4]`).
    pub const TURNS_COUNTERS: usize = 92;
    /// `RobotConfiguration` (DINT).
    pub const ROBOT_CONFIGURATION: usize = 100;
}

/// Byte offsets of the members of MOTION_GROUP.
pub mod motion_group_offset {
    /// `GroupStatus` (DINT).
    pub const GROUP_STATUS: usize = 40;
    /// `GroupFault` (DINT).
    pub const GROUP_FAULT: usize = 52;
    /// `GroupAlarm` (DINT).
    pub const GROUP_ALARM: usize = 56;
    /// `AxisFault` (DINT).
    pub const AXIS_FAULT: usize = 60;
    /// `TaskMaxScanTime` (DINT).
    pub const TASK_MAX_SCAN_TIME: usize = 64;
    /// `TaskLastScanTime` (DINT).
    pub const TASK_LAST_SCAN_TIME: usize = 68;
    /// `TaskLastIOTime` (DINT).
    pub const TASK_LAST_IO_TIME: usize = 72;
    /// `TaskMaxIOTime` (DINT).
    pub const TASK_MAX_IO_TIME: usize = 76;
    /// `TaskAverageScanTime` (DINT).
    pub const TASK_AVERAGE_SCAN_TIME: usize = 80;
    /// `TaskAverageIOTime` (DINT).
    pub const TASK_AVERAGE_IO_TIME: usize = 84;
}

/// Byte offsets of the members of MOTION_INSTRUCTION.
pub mod motion_instruction_offset {
    /// `FLAGS` (DINT).
    pub const FLAGS: usize = 0;
    /// `ERR` (INT).
    pub const ERR: usize = 4;
    /// `STATUS` (SINT).
    pub const STATUS: usize = 6;
    /// `STATE` (SINT).
    pub const STATE: usize = 7;
    /// `SEGMENT` (DINT).
    pub const SEGMENT: usize = 8;
    /// `EXERR` (SINT).
    pub const EXERR: usize = 12;
}

/// Byte offsets of the members of REAL_TIME.
pub mod real_time_offset {
    /// `Ticks` (LINT).
    pub const TICKS: usize = 0;
    /// `Overruns` (DINT).
    pub const OVERRUNS: usize = 8;
    /// `LatenessLast` (REAL).
    pub const LATENESS_LAST: usize = 12;
    /// `LatenessMean` (REAL).
    pub const LATENESS_MEAN: usize = 16;
    /// `LatenessP99` (REAL).
    pub const LATENESS_P99: usize = 20;
    /// `LatenessMax` (REAL).
    pub const LATENESS_MAX: usize = 24;
    /// `ComputeLast` (REAL).
    pub const COMPUTE_LAST: usize = 28;
    /// `ComputeMean` (REAL).
    pub const COMPUTE_MEAN: usize = 32;
    /// `ComputeP99` (REAL).
    pub const COMPUTE_P99: usize = 36;
    /// `ComputeMax` (REAL).
    pub const COMPUTE_MAX: usize = 40;
    /// `LatenessHistogram` (`DINT[24]`).
    pub const LATENESS_HISTOGRAM: usize = 44;
    /// `ComputeHistogram` (`DINT[24]`).
    pub const COMPUTE_HISTOGRAM: usize = 140;
    /// `State` (DINT).
    pub const STATE: usize = 236;
    /// `UpdatePeriod` (REAL, ms): the coarse update period.
    pub const UPDATE_PERIOD: usize = 240;
}

/// Byte offsets of the members of PATH_DATA.
pub mod path_data_offset {
    /// `InterpolationType` (DINT).
    pub const INTERPOLATION_TYPE: usize = 4;
    /// `Position` (`REAL[9]`).
    pub const POSITION: usize = 8;
    /// `RobotConfiguration` (DINT).
    pub const ROBOT_CONFIGURATION: usize = 44;
    /// `TurnsCounters` (`INT[4]`).
    pub const TURNS_COUNTERS: usize = 48;
    /// `MoveType` (DINT).
    pub const MOVE_TYPE: usize = 56;
    /// `TerminationType` (DINT).
    pub const TERMINATION_TYPE: usize = 60;
    /// `CommandToleranceLinear` (REAL).
    pub const COMMAND_TOLERANCE_LINEAR: usize = 64;
}

/// Byte offsets of the members of DYNAMICS_DATA.
pub mod dynamics_data_offset {
    /// `UnitsMode` (DINT).
    pub const UNITS_MODE: usize = 0;
    /// `TimeUnits` (DINT).
    pub const TIME_UNITS: usize = 4;
    /// `Profile` (DINT).
    pub const PROFILE: usize = 8;
    /// `Speed` (REAL).
    pub const SPEED: usize = 12;
    /// `Acceleration` (REAL).
    pub const ACCELERATION: usize = 16;
    /// `Deceleration` (REAL).
    pub const DECELERATION: usize = 20;
    /// `AccelerationJerk` (REAL).
    pub const ACCELERATION_JERK: usize = 24;
    /// `DecelerationJerk` (REAL).
    pub const DECELERATION_JERK: usize = 28;
    /// `OrientationSpeed` (REAL).
    pub const ORIENTATION_SPEED: usize = 32;
    /// `OrientationAcceleration` (REAL).
    pub const ORIENTATION_ACCELERATION: usize = 36;
    /// `OrientationDeceleration` (REAL).
    pub const ORIENTATION_DECELERATION: usize = 40;
}

/// Bit of CIPAxisFaults: the following error left its tolerance.
pub const EXCESSIVE_POSITION_ERROR_FAULT: u64 = 1 << 54;

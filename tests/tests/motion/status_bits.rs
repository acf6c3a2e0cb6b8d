//! Every bit of the predefined types that Arcline sets, seen set and cleared at its tick, as a client reads it from the
//! bytes of the tags (spec/axis-and-data-types.md §1.2, §8); the others with the reason why they stay 0.
//!
//! A scenario is a machine at rest and calls at given ticks. A row names a bit and the ticks at which it
//! changes: the first is that of the first snapshot that shows the change.

use std::collections::BTreeSet;

use arcline_controller::image::{Health, Image};
use arcline_instruction_set::{FAULTS, FaultKind, FaultWord, Flag, predefined};
use arcline_tag::TagPath;
use arcline_tests::bench::{Bench, OK};
use arcline_tests::follow::CAM_TAGS;
use arcline_tests::robots::PATH_TAGS;

const MORE: &str = r#"
[[axis]]
name = "H"
type = "servo"
max_speed = 1000.0
max_acceleration = 1000.0
max_deceleration = 1000.0
start = { homed = false }
home = { sequence = "switch", direction = "unidirectional-forward", speed = 50.0, switch = { min = 5.0 } }

[[axis]]
name = "Weak"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
drive = { speed_limit = 40.0, torque_limit = 1000.0, position_error_tolerance = 50.0 }

[[axis]]
name = "Far"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
travel = { min = -1.0, max = 1.0 }

[[axis]]
name = "Near"
type = "servo"
max_speed = 1000.0
max_acceleration = 10000.0
max_deceleration = 10000.0
travel = { min = -1.0, max = 1.0 }
exception_actions = { soft_travel_positive = "alarm", soft_travel_negative = "alarm", drive = "alarm" }

[[tag]]
name = "Out"
type = "DINT"

[[tag]]
name = "Outs"
type = "OUTPUT_CAM"
value = { OutputBit = 1, LatchType = 1, UnlatchType = 1, Left = 1.0, Right = 2.0 }

[[tag]]
name = "Comp"
type = "OUTPUT_COMPENSATION[2]"
value = [{}, { LatchDelay = 0.01 }]

[[tag]]
name = "Mark1"
type = "BOOL"

[[tag]]
name = "Mark2"
type = "BOOL"
"#;

/// A name, the last tick, and the steps at their ticks: a call, `fault AXIS BITS`, `write TAG VALUE`, `false TAG` of a rung, `late` and
/// `in time` of the motion task.
type Scenario = (&'static str, u64, &'static str);

#[rustfmt::skip]
const SCENARIOS: &[Scenario] = &[
    // Ramps of 100 ms to 50 units/s; 99.6 ms along.
    ("move", 330, "10 MAM(X, M, 0, 9.98, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n320 false M"),
    ("jog and stop", 300, "10 MAJ(X, M, 0, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n160 MAS(X, Stop, Jog, Yes, 500, 0)"),
    ("too fast", 400, "10 MAJ(X, M, 0, 1500, 0, 10000, 0, 10000, 0, 0, 100, 100, 2)\n200 MAS(X, Stop, All, Yes, 10000, 0)"),
    // The master runs at 50 units/s, which 10 ms of clutch reach.
    ("gear", 310, "0 MAJ(Y, J, 0, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n150 MAG(X, Y, M, 0, 1, 1, 1, Command, Real, Enabled, 5000, 0)\n200 MAS(X, Stop, Gear, Yes, 500, 0)"),
    // The master is at 2.5 units and 50 units/s after 100 ms, at its lock after 63.6, at 6.01 after 170.2, at 11.01 after 270.2.
    ("position cam", 330, "0 MCCP(P, Cam, 2, 0, 0, Profile)\n10 MAPC(X, Y, M, 0, Profile, 1, 1, Once, ForwardOnly, 1.01, 0, Command, 0)\n20 MAPC(X, Y, N, 0, Profile, 1, 1, Once, Pending, 0, 0, Command, 0)\n30 MAM(Y, J, 0, 20, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)"),
    // 51.5 ms and 51 ms more.
    ("time cam", 130, "0 MCCP(P, Cam, 2, 0, 0, Profile)\n10 MATC(X, M, 0, Profile, 1, 0.0103, Once, Immediate)\n20 MATC(X, N, 0, Profile, 1, 0.0102, Once, Pending)"),
    // The same positions as those of the position cam; the pending one's bit leads by 10 ms, 0.5 units.
    ("output cam", 330, "10 MAOC(X, 1, M, Out, 0, Outs, 0, 5, 0, Once, ForwardOnly, 1.01, 0, Command)\n20 MAOC(X, 1, N, Out, 0, Outs, 0, 5, Comp, Once, Pending, 0, 0, Command)\n30 MAM(X, J, 0, 20, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)"),
    // 2 units at 500 units/s²: 126.5 ms; by the way of a master at 51 units/s and 0.4: 4.472 units, 87.7 ms.
    ("master offset", 330, "0 MCCP(P, Cam, 2, 0, 0, Profile)\n10 MAPC(X, Y, M, 0, Profile, 1, 1, Persistent, Immediate, 0, 0, Command, 0)\n20 MAM(X, O, 5, 2, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)"),
    ("driven offset", 330, "0 MCCP(P, Cam, 2, 0, 0, Profile)\n10 MAPC(X, Y, M, 0, Profile, 1, 1, Persistent, Immediate, 0, 0, Command, 0)\n12 MAJ(Z, J, 0, 51, 0, 5100, 0, 5100, 0, 0, 100, 100, 2)\n20 MDAC(X, Z, L, MasterOffsetMove, Command)\n100 MAM(X, O, 5, 2, 2, 4, 0.4, 4, 0.4, 4, 0, 100, 100, 6, 0, 0, 0, 1)"),
    // 5.02 units after 150.4 ms.
    ("watch", 230, "10 MAW(X, M, Forward, 5.02)\n20 MAM(X, N, 0, 20, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n200 MAW(X, O, Forward, 90)\n220 MDW(X, D)"),
    ("registration", 90, "10 MAR(X, M, 0, 0, 0, 0, 1)\n20 MAR(X, N, 1, 0, 0, 0, 2)\n30 write Mark1 1\n40 write Mark2 1\n50 write Mark2 0\n60 MAR(X, O, 0, 0, 0, 0, 1)\n70 MAR(X, O, 1, 0, 0, 0, 2)"),
    // 125 ms to the switch at 5 units, then 50 ms of braking.
    ("home", 300, "10 MAH(H, M)"),
    ("virtual home", 60, "10 MAH(A, M)"),
    ("servo", 60, "10 MSF(X, M)\n30 MSO(X, N)"),
    ("shutdown", 60, "10 MASD(X, M)\n30 MASR(X, N)\n40 MSO(X, O)"),
    ("virtual shutdown", 60, "10 MASD(A, M)\n30 MASR(A, N)"),
    ("system shutdown", 60, "10 MCSD(CS1, M)\n30 MCSR(CS1, N)"),
    ("line", 330, "10 MCLM(CS1, M, 0, [9.98, 0, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 0)\n320 MCLM(CS1, N, 0, [11, 0, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 0)"),
    ("two lines", 630, "10 MCLM(CS1, M, 0, [9.98, 0, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 1)\n20 MCLM(CS1, N, 0, [9.98, 9.98, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 1)"),
    // The second begins 0.5 units before the end of the first: after 255 ms.
    ("blend", 630, "10 MCLM(CS1, M, 0, [9.98, 0, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 2)\n20 MCLM(CS1, N, 0, [9.98, 9.98, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 2)"),
    ("deep queue", 330, "10 MCLM(Deep, M, 0, [9.98, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 1)\n20 MCLM(Deep, N, 0, [9.98, 9.98], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 1)\n30 MCLM(Deep, O, 0, [0, 9.98], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 1)"),
    // The master runs at 51 units/s; 5 master units of ramp, 5 at 2 units per master unit, 5 of ramp.
    ("driven line", 500, "0 MAJ(A, J, 0, 51, 0, 5100, 0, 5100, 0, 0, 100, 100, 2)\n20 MDCC(CS1, A, L, Command, 0)\n100 MCLM(CS1, M, 0, [20, 0, 0], 2, 4, 0.4, 4, 0.4, 4, 0, 100, 100, 6, 1, 0, 0, 0, 0, 1, [0], Data)"),
    ("driven move", 500, "0 MAJ(Y, J, 0, 51, 0, 5100, 0, 5100, 0, 0, 100, 100, 2)\n20 MDAC(X, Y, L, Move, Command)\n100 MAM(X, M, 0, 20, 2, 4, 0.4, 4, 0.4, 4, 0, 100, 100, 6, 0, 0, 0, 1, [0, 1, 2, 3], Data)"),
    ("driven jog", 500, "0 MAJ(Y, J, 0, 51, 0, 5100, 0, 5100, 0, 0, 100, 100, 2)\n20 MDAC(X, Y, L, Jog, Command)\n100 MAJ(X, M, 0, 2, 4, 0.4, 4, 0.4, 4, 0, 100, 100, 6, 0, 0, 0, 1)\n300 MAS(X, Stop, Jog, Yes, 1000, 0)"),
    ("stopped line", 330, "10 MCLM(CS1, M, 0, [9.98, 0, 0], 50, 0, 500, 0, 500, 0, 0, 100, 100, 2, 1)\n160 MCS(CS1, Stop, 2, Yes, 500, 0)"),
    // As the line; it turns on its way.
    ("path", 330, "10 MCPM(Turn, M, Way, 1, Pace)\n320 false M"),
    ("two paths", 630, "10 MCPM(Turn, M, Way, 1, Pace)\n20 MCPM(Turn, N, Way, 1, Pace)"),
    // 10 percent of 5000 units/s².
    ("stopped path", 330, "10 MCPM(Turn, M, Way, 1, Pace)\n160 MCS(Turn, Stop, 2, Yes, 10, 1)"),
    ("transform", 300, "10 MCT(CS2, CS3, M, [0, 0, 0], [0, 0, 0])\n20 MAM(A, N, 0, 1, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n200 MCS(CS2, Stop, 3, No, 0, 0)"),
    ("tool", 400, "10 MCTO(Turn, Wrist, M, Frame, Frame)\n20 MAM(O6, N, 1, 1, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n300 MCS(Turn, Stop, 3, No, 0, 0)"),
    ("transform forwards", 300, "10 MCT(CS2, CS3, M, [0, 0, 0], [0, 0, 0])\n20 MAM(X, N, 0, 1, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n200 MCS(CS3, Stop, 3, No, 0, 0)"),
    ("fault", 60, "10 fault X 8\n20 fault X 0\n30 MAFR(X, M)\n40 MSO(X, N)"),
    ("virtual fault", 60, "10 fault A 1\n20 fault A 0\n30 MAFR(A, M)"),
    // A distance of 1 unit at 500 units/s²: √0.004 s.
    ("out of travel", 300, "10 MAM(Far, M, 0, 5, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n200 MAFR(Far, N)"),
    ("out of travel backwards", 300, "10 MAM(Far, M, 0, -5, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n200 MAFR(Far, N)"),
    ("alarm", 400, "10 MAM(Near, M, 0, 2.1, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n200 MAM(Near, N, 0, 0, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)"),
    ("alarm backwards", 400, "10 MAM(Near, M, 0, -2.1, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n200 MAM(Near, N, 0, 0, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)"),
    ("drive alarm", 60, "10 fault Near 8\n30 fault Near 0"),
    ("weak drive", 600, "10 MAM(Weak, M, 0, 10, 50, 0, 10000, 0, 10000, 0, 0, 100, 100, 2)"),
    ("error", 60, "10 MAM(X, M, 2, 10, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n20 false M"),
    ("late", 60, "10 late\n30 in time"),
    // The next edge clears the bits of the last execution.
    ("move again", 340, "10 MAM(X, M, 0, 9.98, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n320 false M\n330 MAM(X, M, 0, 20, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)"),
    ("reset again", 60, "10 MAFR(X, M)\n20 false M\n30 MAFR(X, M)"),
    ("error again", 60, "10 MAM(X, M, 2, 10, 50, 0, 500, 0, 500, 0, 0, 100, 100, 2)\n20 false M\n30 MAFR(X, M)"),
    ("home again", 300, "10 MAH(H, M)\n250 MAH(H, N)"),
];

/// Scenarios that a virtual axis goes through just so.
const VIRTUAL_TOO: [&str; 14] = [
    "output cam",
    "master offset",
    "driven offset",
    "move",
    "jog and stop",
    "too fast",
    "gear",
    "line",
    "driven move",
    "driven jog",
    "position cam",
    "time cam",
    "watch",
    "registration",
];

/// A scenario, a bit (`TAG.MEMBER`, or `TAG.MEMBER.BIT` of a word without names), its value at tick 0, and the ticks at
/// which it changes.
type Row = (&'static str, &'static str, bool, &'static [u64]);

#[rustfmt::skip]
const ROWS: &[Row] = &[
    // AXIS_CIP_DRIVE, AXIS_VIRTUAL: MotionStatus.
    ("move",             "X.MoveStatus",                    false, &[10, 310]),
    ("move",             "X.AccelStatus",                   false, &[10, 110]),
    ("move",             "X.DecelStatus",                   false, &[210, 310]),
    ("jog and stop",     "X.JogStatus",                     false, &[10, 160]),
    ("jog and stop",     "X.StoppingStatus",                false, &[160, 260]),
    ("too fast",         "X.MaximumSpeedExceeded",          false, &[111, 250]),
    ("driven move",      "X.MoveLockStatus",                false, &[100, 395]),
    ("driven jog",       "X.JogLockStatus",                 false, &[100, 300]),
    ("gear",             "X.GearingStatus",                 false, &[150, 200]),
    ("gear",             "X.GearingLockStatus",             false, &[160, 200]),
    ("position cam",     "X.PositionCamStatus",             false, &[10, 301]),
    ("position cam",     "X.PositionCamLockStatus",         false, &[94, 301]),
    ("position cam",     "X.PositionCamPendingStatus",      false, &[20, 201]),
    ("position cam",     "M.PC",                            false, &[201]),
    ("time cam",         "X.TimeCamStatus",                 false, &[10, 113]),
    ("time cam",         "X.TimeCamLockStatus",             false, &[10, 113]),
    ("time cam",         "X.TimeCamPendingStatus",          false, &[20, 62]),
    ("time cam",         "N.IP",                            false, &[20, 113]),
    ("master offset",    "X.MasterOffsetMoveStatus",        false, &[20, 147]),
    ("driven offset",    "X.MasterOffsetMoveLockStatus",    false, &[100, 188]),
    ("output cam",       "X.OutputCamStatus.1",             false, &[10, 301]),
    ("output cam",       "X.OutputCamPendingStatus.1",      false, &[20, 201]),
    ("output cam",       "X.OutputCamLockStatus.1",         false, &[94, 301]),
    ("output cam",       "X.OutputCamTransitionStatus.1",   false, &[191, 201]),
    ("output cam",       "X.OutputCamStatus.0",             false, &[]),
    ("output cam",       "M.PC",                            false, &[201]),
    ("output cam",       "N.IP",                            false, &[20, 301]),
    ("home",             "H.HomingStatus",                  false, &[10, 185]),
    ("home",             "H.AxisHomedStatus",               false, &[185]),
    ("virtual home",     "A.HomingStatus",                  false, &[10, 11]),
    ("virtual home",     "A.AxisHomedStatus",               true,  &[10, 11]),
    ("line",             "X.CoordinatedMotionStatus",       false, &[10, 310, 320]),
    ("transform",        "X.TransformStateStatus",          false, &[10, 200]),
    ("transform",        "X.ControlledByTransformStatus",   false, &[20, 110]),
    ("transform",        "A.TransformStateStatus",          false, &[10, 200]),
    ("transform",        "A.ControlledByTransformStatus",   false, &[]),
    ("transform forwards", "A.ControlledByTransformStatus", false, &[20, 110]),
    ("transform forwards", "X.ControlledByTransformStatus", false, &[]),
    ("path",             "O1.CoordinatedMotionStatus",      false, &[10, 310]),
    ("path",             "O6.CoordinatedMotionStatus",      false, &[10, 310]),
    // AxisEvent.
    ("watch",            "X.WatchEventArmedStatus",         false, &[10, 171, 200, 220]),
    ("watch",            "X.WatchEventStatus",              false, &[171, 200]),
    ("watch",            "M.DN",                            false, &[11]),
    ("watch",            "M.IP",                            false, &[10, 171]),
    ("watch",            "M.PC",                            false, &[171]),
    ("watch",            "O.IP",                            false, &[200, 220]),
    ("registration",     "X.RegEvent1ArmedStatus",          false, &[10, 30, 60]),
    ("registration",     "X.RegEvent1Status",               false, &[30, 60]),
    ("registration",     "X.RegEvent2ArmedStatus",          false, &[20, 50, 70]),
    ("registration",     "X.RegEvent2Status",               false, &[50, 70]),
    ("home",             "H.HomeEventArmedStatus",          false, &[10, 135]),
    ("home",             "H.HomeEventStatus",               false, &[135]),
    // AxisStatus, CIPAxisStatus.
    ("home",             "H.HomeInputStatus",               false, &[135]),
    ("registration",     "X.Registration1InputStatus",      false, &[30]),
    ("registration",     "X.Registration2InputStatus",      false, &[40, 50]),
    ("servo",            "X.ServoActionStatus",             true,  &[10, 31]),
    ("servo",            "X.DriveEnableStatus",             true,  &[10, 31]),
    ("servo",            "X.PowerStructureEnabledStatus",   true,  &[10, 31]),
    ("servo",            "X.TrackingCommandStatus",         true,  &[10, 31]),
    ("shutdown",         "X.ShutdownStatus",                false, &[10, 30]),
    ("shutdown",         "X.CIPShutdownStatus",             false, &[10, 30]),
    ("shutdown",         "X.ServoActionStatus",             true,  &[10, 41]),
    ("virtual shutdown", "A.ServoActionStatus",             true,  &[10, 30]),
    ("virtual shutdown", "A.DriveEnableStatus",             true,  &[10, 30]),
    ("virtual shutdown", "A.ShutdownStatus",                false, &[10, 30]),
    ("move",             "X.VelocityStandstillStatus",      true,  &[11, 310]),
    // 4 ms at 10 times the torque there is: the limit of the torque, then that of the speed, and the way back.
    ("weak drive",       "Weak.TorqueLimitStatus",          false, &[11, 51, 277, 478]),
    ("weak drive",       "Weak.VelocityLimitStatus",        false, &[51, 277]),
    ("weak drive",       "Weak.PositionLockStatus",         true,  &[12, 280, 281, 352, 353, 409, 410, 449, 450, 473]),
    ("drive alarm",      "Near.AlarmStatus",                false, &[11, 31]),
    // AxisFault, and its effect in the bits of motion.
    ("fault",            "X.PhysicalAxisFault",             false, &[11, 30]),
    ("fault",            "X.ServoActionStatus",             true,  &[11, 41]),
    ("virtual fault",    "A.PhysicalAxisFault",             false, &[11, 30]),
    ("out of travel",    "Far.MotionFault",                 false, &[74, 200]),
    ("out of travel",    "Far.SoftTravelLimitPositiveFault", false, &[74, 200]),
    ("out of travel",    "Far.StoppingStatus",              false, &[74, 78]),
    ("out of travel backwards", "Far.SoftTravelLimitNegativeFault", false, &[74, 200]),
    ("alarm",            "Near.SoftTravelLimitPositiveAlarm", false, &[74, 267]),
    ("alarm backwards",  "Near.SoftTravelLimitNegativeAlarm", false, &[74, 267]),
    ("late",             "X.GroupFault",                    false, &[10, 30]),
    ("late",             "A.GroupFault",                    false, &[10, 30]),
    // COORDINATE_SYSTEM: CoordinateMotionStatus.
    ("line",             "CS1.MoveStatus",                  false, &[10, 310, 320]),
    ("line",             "CS1.AccelStatus",                 false, &[10, 110, 320]),
    ("line",             "CS1.DecelStatus",                 false, &[210, 310]),
    ("line",             "CS1.ActualPosToleranceStatus",    false, &[310, 320]),
    ("line",             "CS1.CommandPosToleranceStatus",   false, &[265, 320]),
    ("two lines",        "CS1.MovePendingStatus",           false, &[20, 310]),
    ("two lines",        "CS1.MovePendingQueueFullStatus",  false, &[20, 310]),
    ("deep queue",       "Deep.MovePendingStatus",          false, &[20]),
    ("deep queue",       "Deep.MovePendingQueueFullStatus", false, &[30, 310]),
    ("two lines",        "CS1.MoveTransitionStatus",        false, &[]),
    ("blend",            "CS1.MoveTransitionStatus",        false, &[265, 310]),
    ("driven line",      "CS1.CoordinateSystemLockStatus",  false, &[100, 395]),
    ("driven line",      "CS1.AccelStatus",                 false, &[100, 199]),
    ("stopped line",     "CS1.StoppingStatus",              false, &[160, 260]),
    ("stopped line",     "CS1.DecelStatus",                 false, &[160, 260]),
    ("stopped line",     "CS1.MoveStatus",                  false, &[10, 160]),
    ("path",             "Turn.MoveStatus",                 false, &[10, 310]),
    ("path",             "Turn.AccelStatus",                false, &[10, 110]),
    ("path",             "Turn.DecelStatus",                false, &[210, 310]),
    ("two paths",        "Turn.MovePendingStatus",          false, &[20, 310]),
    ("two paths",        "Turn.MoveStatus",                 false, &[10, 610]),
    ("stopped path",     "Turn.StoppingStatus",             false, &[160, 260]),
    ("stopped path",     "Turn.MoveStatus",                 false, &[10, 160]),
    ("transform",        "CS2.TransformSourceStatus",       false, &[10, 200]),
    // √0.008 s.
    ("tool",             "Turn.ToolChangeAllowedStatus",    false, &[10, 20, 110, 300]),
    ("transform",        "CS3.TransformTargetStatus",       false, &[10, 200]),
    // CoordinateSystemStatus, AxisFault, and the words of its axes.
    ("line",             "CS1.MotionStatus",                false, &[10, 310, 320]),
    ("stopped line",     "CS1.MotionStatus",                false, &[10, 260]),
    ("path",             "Turn.MotionStatus",               false, &[10, 310]),
    ("stopped path",     "Turn.MotionStatus",               false, &[10, 260]),
    ("shutdown",         "CS1.ReadyStatus",                 true,  &[10, 30]),
    ("shutdown",         "CS1.ShutdownStatus",              false, &[]),
    ("system shutdown",  "CS1.ShutdownStatus",              false, &[10, 30]),
    ("system shutdown",  "CS2.ShutdownStatus",              false, &[]),
    ("fault",            "CS1.ReadyStatus",                 true,  &[11, 30]),
    ("fault",            "CS1.PhysicalAxisFault",           false, &[11, 30]),
    ("late",             "CS1.GroupFault",                  false, &[10, 30]),
    ("fault",            "CS1.PhysicalAxesFaulted.0",       false, &[11, 30]),
    ("fault",            "CS1.PhysicalAxesFaulted.1",       false, &[]),
    ("shutdown",         "CS1.AxesShutdownStatus.0",        false, &[10, 30]),
    ("shutdown",         "CS1.AxesShutdownStatus.1",        false, &[]),
    ("system shutdown",  "CS1.AxesShutdownStatus.2",        false, &[10, 30]),
    ("servo",            "CS1.AxesServoOnStatus.0",         true,  &[10, 31]),
    ("servo",            "CS1.AxesServoOnStatus.1",         true,  &[]),
    ("servo",            "CS1.AxesServoOnStatus.3",         false, &[]),
    // MOTION_GROUP.
    ("fault",            "Motion.PhysicalAxisFault",        false, &[11, 30]),
    ("out of travel",    "Motion.PhysicalAxisFault",        false, &[74, 200]),
    ("late",             "Motion.GroupOverlapFault",        false, &[10, 30]),
    // MOTION_INSTRUCTION.
    ("move",             "M.EN",                            false, &[10, 320]),
    ("move",             "M.DN",                            false, &[10]),
    ("move",             "M.IP",                            false, &[10, 310]),
    ("move",             "M.PC",                            false, &[310]),
    ("move",             "M.ACCEL",                         false, &[10, 110]),
    ("move",             "M.DECEL",                         false, &[210, 310]),
    ("move",             "M.AC",                            false, &[]),
    ("servo",            "M.EN",                            false, &[10]),
    ("servo",            "M.DN",                            false, &[11]),
    ("servo",            "N.DN",                            false, &[31]),
    ("home",             "M.IP",                            false, &[10, 185]),
    ("home",             "M.DN",                            false, &[185]),
    ("two lines",        "M.AC",                            false, &[10, 310]),
    ("two lines",        "N.IP",                            false, &[20, 610]),
    ("two lines",        "N.AC",                            false, &[310, 610]),
    ("two lines",        "N.ACCEL",                         false, &[310, 410]),
    ("blend",            "M.PC",                            false, &[265]),
    ("blend",            "N.AC",                            false, &[265, 565]),
    ("driven line",      "M.AC",                            false, &[100, 395]),
    ("driven line",      "M.TrackingMaster",                false, &[199, 297]),
    ("driven line",      "M.CalculatedDataAvailable",       false, &[100]),
    ("driven line",      "L.IP",                            false, &[20]),
    ("driven line",      "L.AC",                            false, &[100, 395]),
    ("driven move",      "M.TrackingMaster",                false, &[199, 297]),
    ("driven move",      "M.CalculatedDataAvailable",       false, &[100]),
    ("driven jog",       "M.TrackingMaster",                false, &[199, 300]),
    ("driven jog",       "M.AC",                            false, &[100, 300]),
    ("stopped line",     "M.IP",                            false, &[10, 160]),
    ("stopped line",     "M.PC",                            false, &[]),
    ("stopped line",     "Stop.IP",                         false, &[160, 260]),
    ("stopped line",     "Stop.PC",                         false, &[260]),
    ("path",             "M.EN",                            false, &[10, 320]),
    ("path",             "M.DN",                            false, &[10]),
    ("path",             "M.IP",                            false, &[10, 310]),
    ("path",             "M.AC",                            false, &[10, 310]),
    ("path",             "M.PC",                            false, &[310]),
    ("path",             "M.ACCEL",                         false, &[10, 110]),
    ("path",             "M.DECEL",                         false, &[210, 310]),
    ("two paths",        "M.AC",                            false, &[10, 310]),
    ("two paths",        "N.IP",                            false, &[20, 610]),
    ("two paths",        "N.AC",                            false, &[310, 610]),
    ("stopped path",     "M.IP",                            false, &[10, 160]),
    ("stopped path",     "M.PC",                            false, &[]),
    ("stopped path",     "Stop.IP",                         false, &[160, 260]),
    ("stopped path",     "Stop.PC",                         false, &[260]),
    ("error",            "M.ER",                            false, &[10]),
    ("error",            "M.EN",                            false, &[10, 20]),
    ("error",            "M.DN",                            false, &[]),
    ("move again",       "M.PC",                            false, &[310, 330]),
    ("reset again",      "M.DN",                            false, &[11, 30, 31]),
    ("error again",      "M.ER",                            false, &[10, 30]),
    ("home again",       "H.HomeEventStatus",               false, &[135, 250]),
];

/// Bits that are always 1.
const ALWAYS: &[(&str, &str)] = &[
    ("AxisUpdateStatus", "positions and status are refreshed at every tick"),
    ("GroupSynced", "the group is synchronized before the first tick"),
];

/// Bits that are always 0, by name.
#[rustfmt::skip]
const NEVER: &[(&str, &str)] = &[
    ("ModuleFault", "a simulated drive is no module that could be lost"),
    ("ConfigFault", "a configuration that is not valid does not start"),
    ("GuardFault", "no guard"), ("InitializationFault", "nothing to initialise"), ("APRFault", "positions are kept by --state"),
    ("SafetyFault", "no safety functions"),
    ("ConfigUpdateInProcess", "attributes do not change while it runs"), ("InhibitStatus", "no axis can be inhibited"),
    ("DirectControlStatus", "no MDS"), ("DirectVelocityControlStatus", "no MDS"), ("DirectTorqueControlStatus", "no MDS"),
    ("AxisInhibitStatus", "no axis can be inhibited"), ("InhibStatus", "the group cannot be inhibited"),
    ("CSTLossFault", "one clock"), ("GroupTaskLoadingFault", "an overlap shows as such"), ("ClockSyncFault", "one clock"),
    ("ClockSyncAlarm", "one clock"),
    ("LocalControlStatus", "no local control"), ("DCBusUpStatus", "no bus is simulated"), ("MotorFluxUpStatus", "no flux is simulated"),
    ("VelocityLockStatus", "no velocity loop of its own"), ("VelocityThresholdStatus", "no threshold"),
    ("AccelerationLimitStatus", "the torque is the limit"), ("DecelerationLimitStatus", "the torque is the limit"),
    ("TorqueThresholdStatus", "no threshold"), ("CurrentLimitStatus", "the torque is the limit"),
    ("ThermalLimitStatus", "no heat is simulated"), ("FeedbackIntegrityStatus", "no feedback device"), ("InProcessStatus", "no procedures"),
    ("EnableInputStatus", "nothing inhibits a start"), ("PositiveOvertravelInputStatus", "no such switch"),
    ("NegativeOvertravelInputStatus", "no such switch"), ("Feedback1ThermostatStatus", "no heat is simulated"),
    ("ResistiveBrakeOutputStatus", "no brake"), ("MechanicalBrakeOutputStatus", "no brake"),
    ("MotorThermostatInputStatus", "no heat is simulated"),
    ("DCBusUnload", "no bus is simulated"), ("ACPowerLossStatus", "no power is simulated"),
    ("PositionControlModeStatus", "Axis Configuration tells it"), ("VelocityControlModeStatus", "always position control"),
    ("TorqueControlModeStatus", "always position control"),
];

/// Words of AXIS_CIP_DRIVE in which every bit is 0, with the reason; of the two last those that no [`FAULTS`] shows.
#[rustfmt::skip]
const NEVER_WORDS: &[(&str, &str)] = &[
    ("ModuleFaults", "no modules"), ("ModuleAlarmStatus", "no modules"), ("GuardStatus", "no guard"), ("GuardFaults", "no guard"),
    ("CIPAxisStatus2", "no power is simulated"), ("CIPAxisStatusRA", "no tuning"),
    ("CIPAxisIOStatusRA", "no digital inputs"), ("CIPAxisFaults2", "no power is simulated"),
    ("CIPAxisFaultsRA", "none of one manufacturer"), ("CIPAxisAlarms2", "no power is simulated"),
    ("CIPAxisAlarmsRA", "none of one manufacturer"), ("AxisSafetyAlarms", "no safety"), ("AxisSafetyAlarmsRA", "no safety"),
    ("CIPInitializationFaults", "nothing to initialise"), ("CIPInitializationFaultsRA", "nothing to initialise"),
    ("CIPStartInhibits", "nothing inhibits a start"), ("CIPStartInhibitsRA", "nothing inhibits a start"),
    ("AxisSafetyStatus", "no safety"), ("AxisSafetyStatusRA", "no safety"), ("AxisSafetyFaults", "no safety"),
    ("AxisSafetyFaultsRA", "no safety"), ("CIPAPRFaults", "positions are kept by --state"),
    ("CIPAPRFaultsRA", "positions are kept by --state"),
    ("CIPAxisFaults", "no such fault is simulated"), ("CIPAxisAlarms", "no such fault is simulated"),
];

/// The axes and coordinate systems that scenarios move.
const TAGS: [&str; 11] = [
    "X", "A", "H", "Weak", "Far", "Near", "CS1", "CS2", "CS3", "Deep", "Motion",
];

fn machine(keys: &str) -> String {
    let deep = "[[coordinate_system]]\nname = \"Deep\"\ntype = \"cartesian\"\naxes = [\"X\", \"Y\"]\nmax_speed = 500.0\n\
                max_acceleration = 5000.0\nmax_deceleration = 5000.0\nqueue_depth = 2\n";
    let text = format!(
        "{}\n{MORE}{CAM_TAGS}{PATH_TAGS}\n{deep}{}",
        arcline_config::DEFAULT,
        wrist()
    );
    let axis = "name = \"X\"\ntype = ";
    assert!(text.contains(axis));
    let inputs = "output_cam_execution_targets = 2\nregistration = { input_1 = \"Mark1\", input_2 = \"Mark2\" }\n";
    let without_drive = "name = \"A\"\ntype = ";
    assert!(text.contains(without_drive));
    text.replacen(axis, &format!("{keys}{inputs}{axis}"), 1).replacen(
        without_drive,
        &format!("{inputs}{without_drive}"),
        1,
    )
}

/// A robot with a wrist, and a system with orientation that can lead it.
fn wrist() -> String {
    let mut text = "[[tag]]\nname = \"Frame\"\ntype = \"POSITION_DATA\"\n".to_owned();
    let mut system = |name: &str, letter: char, keys: &str| {
        let names: Vec<String> = (1..=6).map(|place| format!("{letter}{place}")).collect();
        for name in &names {
            text += &format!(
                "[[axis]]\nname = \"{name}\"\ntype = \"virtual\"\nmax_speed = 1000.0\nmax_acceleration = 10000.0\n"
            );
        }
        text += &format!(
            "[[coordinate_system]]\nname = \"{name}\"\n{keys}\naxes = {names:?}\nmax_speed = 500.0\nmax_acceleration = 5000.0\n"
        );
    };
    system("Turn", 'O', "definition = \"XYZRxRyRz\"");
    system(
        "Wrist",
        'W',
        "type = \"articulated_independent\"\ndefinition = \"J1J2J3J4J5J6\"\nlink_lengths = [100.0, 100.0]\n\
         end_effector_offsets = [30.0, 0.0, 0.0]\nzero_angles = [0.0, -90.0, 90.0, 0.0, 60.0, 0.0]",
    );
    text
}

fn template(tag: &str) -> std::sync::Arc<arcline_tag::Template> {
    match tag {
        "A" | "O1" | "O6" => predefined::axis_virtual(),
        "Motion" => predefined::motion_group(),
        "CS1" | "CS2" | "CS3" | "Deep" | "Turn" => predefined::coordinate_system(),
        "X" | "H" | "Weak" | "Far" | "Near" => predefined::axis_cip_drive(),
        _ => predefined::motion_instruction(),
    }
}

/// The word that a bit is in.
fn host(template: &arcline_tag::Template, bit: &arcline_tag::Member) -> String {
    let words = template.members.iter().filter(|member| member.bit.is_none());
    let mut holding = words.filter(|word| (word.offset..word.offset + word.size() as u32).contains(&bit.offset));
    holding.next().expect("a bit is in a word").name.clone()
}

/// The values of the wanted bits at every tick; `look` sees all tags after each step.
fn traces(config: &str, last: u64, steps: &str, bits: &[String], mut look: impl FnMut(&Image)) -> Vec<Vec<bool>> {
    let mut bench = Bench::with(config);
    let mut image = Image::new(bench.machine(), &[], &[]);
    let mut steps = steps
        .lines()
        .map(|step| step.split_once(' ').expect("a tick and a step"))
        .peekable();
    let places: Vec<Place> = bits.iter().map(|bit| Place::of(bit, &image)).collect();
    let mut traces = vec![Vec::new(); bits.len()];
    let mut health = Health::default();
    for tick in 0..=last {
        let mut happens = tick == last;
        while let Some((_, step)) = steps.next_if(|(due, _)| *due == tick.to_string()) {
            happens = true;
            match (step, step.split_once(' ')) {
                ("late", _) => health.overlapping = true,
                ("in time", _) => health.overlapping = false,
                (_, Some(("fault", fault))) => {
                    let (axis, bits) = fault.split_once(' ').expect("an axis and its bits");
                    let bits: u32 = bits.parse().expect("bits");
                    let kinds = FAULTS.iter().map(|fault| fault.kind);
                    let kinds: Vec<FaultKind> = kinds.filter(|kind| bits & (1 << *kind as u32) != 0).collect();
                    bench.inject(axis, &kinds);
                }
                (_, Some(("write", write))) => {
                    let (tag, value) = write.split_once(' ').expect("a tag and a value");
                    bench.write(tag, value.parse().expect("a number"));
                }
                (_, Some(("false", tag))) => bench.rung_false(tag),
                _ => {
                    let found = bench.call(step);
                    assert!(found == OK || step.starts_with("MAM(X, M, 2"), "{step}: {found:?}");
                }
            }
        }
        bench.tick_seen(|bench| {
            image.apply_health(&health);
            image.apply_snapshot(&bench.snapshot());
            for (place, trace) in places.iter().zip(&mut traces) {
                trace.push(place.value(bench, &image));
            }
        });
        if happens {
            look(&image);
        }
    }
    assert!(steps.next().is_none(), "steps behind the last tick");
    traces
}

/// The place of a bit: in a control tag of the bench, or in the tags of the machine.
enum Place {
    Control(String, Flag),
    Tag(TagPath),
}

impl Place {
    fn of(bit: &str, image: &Image) -> Self {
        let (tag, member) = bit.split_once('.').expect("a member");
        if image.find(tag).is_some() {
            return Self::Tag(bit.parse().expect("a path"));
        }
        let flag = Flag::ALL.iter().find(|flag| flag.name() == member).expect("a flag");
        Self::Control(tag.to_owned(), *flag)
    }

    fn value(&self, bench: &Bench, image: &Image) -> bool {
        let path = match self {
            Self::Control(tag, flag) => return bench.control(tag).has(*flag),
            Self::Tag(path) => path,
        };
        match image.read(path).expect("a bit").to_string().as_str() {
            "1" | "true" => true,
            "0" | "false" => false,
            other => panic!("{path} is {other}"),
        }
    }
}

fn changes(trace: &[bool]) -> Vec<u64> {
    let ticks = trace.windows(2).zip(1..);
    ticks
        .filter(|(pair, _)| pair[0] != pair[1])
        .map(|(_, tick)| tick)
        .collect()
}

/// A row's bit with the template that it is seen in.
fn seen(bit: &str) -> (String, String) {
    let (tag, member) = bit.split_once('.').expect("a member");
    (template(tag).name.clone(), member.to_owned())
}

#[test]
fn every_bit_is_set_and_cleared_at_its_tick() {
    let config = machine("");
    let mut wrong = Vec::new();
    let mut covered = BTreeSet::new();
    let constants = Constants::new();
    for (name, last, steps) in SCENARIOS {
        let rows: Vec<&Row> = ROWS.iter().filter(|(scenario, ..)| scenario == name).collect();
        assert!(!rows.is_empty(), "{name} shows nothing");
        let as_virtual = |text: &str| {
            let names = [
                ("(X,", "(A,"),
                ("(Y,", "(B,"),
                (", Y,", ", B,"),
                ("(CS1,", "(CS3,"),
                ("X.", "A."),
                ("CS1.", "CS3."),
            ];
            names
                .iter()
                .fold(text.to_owned(), |text, (from, to)| text.replace(from, to))
        };
        let mut variants = vec![false];
        if VIRTUAL_TOO.contains(name) {
            variants.push(true);
        }
        for is_virtual in variants {
            let named = |text: &str| if is_virtual { as_virtual(text) } else { text.to_owned() };
            let rows = rows.iter().map(|row| (named(row.1), row.2, row.3));
            let known = |bit: &str| {
                let (tag, member) = bit.split_once('.').expect("a member");
                let word = member.split('.').next().unwrap_or_default();
                template(tag).member(word).is_some()
            };
            let rows: Vec<_> = rows.filter(|(bit, ..)| !is_virtual || known(bit)).collect();
            let bits: Vec<String> = rows.iter().map(|(bit, ..)| bit.clone()).collect();
            let look = |image: &Image| wrong.extend(constants.wrong(image).map(|bit| format!("{name}: {bit}")));
            let found = traces(&config, *last, &named(steps), &bits, look);
            for ((bit, first, expected), trace) in rows.iter().zip(found) {
                let changes = changes(&trace);
                if trace[0] != *first || changes != *expected {
                    wrong.push(format!(
                        "{name}: {bit} is {} and changes at {changes:?}, expected {first}, {expected:?}",
                        trace[0]
                    ));
                }
                if !changes.is_empty() {
                    covered.insert(seen(bit));
                }
            }
        }
    }
    for name in TAGS.into_iter().chain(["M"]) {
        let template = template(name);
        for bit in template.members.iter().filter(|member| member.bit.is_some()) {
            let word = host(&template, bit);
            let constant = is_constant(&bit.name, &word);
            // The axis without a home sensor has no event.
            let constant = constant || (name == "A" && bit.name.starts_with("HomeEvent"));
            if covered.contains(&(template.name.clone(), bit.name.clone())) == constant {
                wrong.push(format!(
                    "{}.{}: constant {constant}, and a row or none",
                    template.name, bit.name
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether a bit never changes in these scenarios. The bits of faults and their alarms have a test of their own.
fn is_constant(bit: &str, word: &str) -> bool {
    NEVER.iter().chain(ALWAYS).any(|(name, _)| *name == bit) || NEVER_WORDS.iter().any(|(name, _)| *name == word)
}

/// The fault that a bit of CIPAxisFaults or CIPAxisAlarms shows: another test sees to these.
fn shown_fault(word: &str, bit: &arcline_tag::Member, offset: u32) -> Option<FaultKind> {
    let place = 8 * (bit.offset - offset) + u32::from(bit.bit?);
    let shows =
        |fault: &&arcline_instruction_set::Fault| fault.shows == FaultWord::Cip && u32::from(fault.bit) == place;
    ["CIPAxisFaults", "CIPAxisAlarms"]
        .contains(&word)
        .then(|| FAULTS.iter().find(shows).map(|fault| fault.kind))
        .flatten()
}

/// The bits and words of every tag that never change in these scenarios.
struct Constants(Vec<(&'static str, Vec<Constant>)>);

/// Some bits of a byte that have one value throughout.
struct Constant {
    name: String,
    byte: usize,
    mask: u8,
    is_set: bool,
}

impl Constants {
    fn new() -> Self {
        Self(TAGS.map(|tag| (tag, Self::of(&template(tag)))).into())
    }

    fn of(template: &arcline_tag::Template) -> Vec<Constant> {
        let bits = template.members.iter().filter(|member| member.bit.is_some());
        let bits = bits.filter_map(|bit| {
            let word = host(template, bit);
            let offset = template.member(&word).map_or(0, |word| word.offset);
            let never = NEVER.iter().any(|(name, _)| *name == bit.name)
                || NEVER_WORDS.iter().any(|(name, _)| *name == word) && shown_fault(&word, bit, offset).is_none();
            let always = ALWAYS.iter().any(|(name, _)| *name == bit.name);
            (never || always).then(|| Constant {
                name: bit.name.clone(),
                byte: bit.offset as usize,
                mask: 1 << bit.bit.unwrap_or(0),
                is_set: always,
            })
        });
        let words = ["ModulesFaulted", "AxesConfigurationFaulted", "AxesInhibitedStatus"];
        let words = words.into_iter().filter_map(|word| template.member(word));
        let bytes = words.flat_map(|word| (0..4).map(move |byte| (word.name.clone(), word.offset as usize + byte)));
        let zero = bytes.map(|(name, byte)| Constant {
            name,
            byte,
            mask: 0xFF,
            is_set: false,
        });
        bits.chain(zero).collect()
    }

    /// Those that do not have their value.
    fn wrong(&self, image: &Image) -> impl Iterator<Item = String> {
        self.0.iter().flat_map(|(tag, constants)| {
            let bytes = image.bytes(image.find(tag).expect("a tag").id);
            let wrong = constants
                .iter()
                .filter(|constant| (bytes[constant.byte] & constant.mask != 0) != constant.is_set);
            wrong.map(move |constant| format!("{tag}.{} is {}", constant.name, !constant.is_set))
        })
    }
}

#[test]
fn every_fault_and_alarm_shows_its_bit_and_no_other() {
    let template = predefined::axis_cip_drive();
    // Logix has no member for the fault of the command limits.
    for fault in FAULTS.iter().filter(|fault| fault.kind != FaultKind::CommandLimit) {
        let words = match fault.shows {
            FaultWord::Motion => ["MotionFaultStatus", "MotionAlarmStatus"],
            FaultWord::Cip => ["CIPAxisFaults", "CIPAxisAlarms"],
        };
        for (action, word, cleared) in [("fault_status_only", words[0], 30), ("alarm", words[1], 21)] {
            let config = machine(&format!("exception_actions = {{ {} = \"{action}\" }}\n", fault.word));
            let offset = template.member(word).expect("a word").offset + u32::from(fault.bit) / 8;
            let bits: Vec<String> = template
                .members
                .iter()
                .filter(|member| member.bit.is_some() && words.contains(&host(&template, member).as_str()))
                .map(|member| format!("X.{}", member.name))
                .collect();
            let own = template
                .members
                .iter()
                .find(|member| member.offset == offset && member.bit == Some(fault.bit % 8))
                .expect("its bit has a name");
            let steps = format!("10 fault X {}\n20 fault X 0\n30 MAFR(X, M)", 1 << fault.kind as u32);
            let found = traces(&config, 40, &steps, &bits, |_| ());
            for (bit, trace) in bits.iter().zip(found) {
                let expected = if *bit == format!("X.{}", own.name) {
                    vec![11, cleared]
                } else {
                    vec![]
                };
                assert_eq!(changes(&trace), expected, "{} {action}: {bit}", fault.word);
            }
        }
    }
}

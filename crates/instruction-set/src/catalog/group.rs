//! Instructions of the motion group, and those that only calculate with cams.

use super::bits::*;
use super::resolve::{resolved, total};
use super::row::*;
use crate::enumerations::StopMode;
use crate::instruction::{Axes, Instruction, Object, Range, Timing};
use crate::operands::{OperandReader, OperandValue, Operands};
use crate::{Mnemonic, TagAddress, WrittenArray};

instructions! {
    MGS = Mgs on MotionGroup, Process, EN_DN_ER_IP_PC, Axes::ANY,
    "Stops all motion of all axes of the group.": [
        group = group(), motion_control = control(),
        stop_mode: StopMode = word(),
    ];

    MGSD = Mgsd on MotionGroup, Message, EN_DN_ER, Axes::ANY,
    "Puts every axis of the group into shutdown.": [group = group(), motion_control = control()];

    MGSR = Mgsr on MotionGroup, Message, EN_DN_ER, Axes::ANY,
    "Clears the faults and takes every axis of the group out of shutdown.": [group = group(), motion_control = control()];

    MGSP = Mgsp on MotionGroup, Immediate, EN_DN_ER, Axes::ANY,
    "Copies the positions of all axes into their Strobe members at one coarse update.": [
        group = group(), motion_control = control(),
    ];

    MCCP = Mccp on MotionGroup, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates a cam profile from the points of a cam.": [
        motion_control = control(),
        cam: Option<TagAddress> = structure("CAM", "the points, an array"),
        length: i32 = count(Range::Any, "points to use, 2 or more (26)").first(2.0),
        start_slope: f64 = number(Range::Any, "of a cubic first segment, slave units per master unit"),
        end_slope: f64 = number(Range::Any, "of a cubic last segment, slave units per master unit"),
        cam_profile: Option<TagAddress> = structure("CAM_PROFILE", "receives the profile, an array of Length elements or more"),
    ];

    MCSV = Mcsv on MotionGroup, Immediate, EN_DN_ER, Axes::ANY,
    "Calculates the position and slope of a slave at a position of its master from a cam profile, without motion.": [
        motion_control = control(),
        cam_profile: Option<TagAddress> = structure("CAM_PROFILE", "a calculated profile"),
        master_value: f64 = number(Range::Any, "within the profile"),
        slave_value: Option<WrittenArray> = written(1, "receives the slave's position"),
        slope_value: Option<WrittenArray> = written(1, "receives the first derivative by the master"),
        slope_derivative: Option<WrittenArray> = written(1, "receives the second derivative by the master"),
    ];
}

//! The predefined types: the structure of motion tags that clients see
//! (spec/axis-and-data-types.md §8, Appendix A).
//!
//! The layouts are data, one line a member: offset, type, name (in parentheses: not shown), then
//! `bit:name` for the BOOLs that overlay it.
//! Template instances are fixed, so handles and ids are the same in every run. User types, such as those of
//! instruction tags, have instances 0x100 to 0xEFF; these have others.

use std::sync::{Arc, LazyLock};

use arcline_tag::{Elementary, Template, TemplateBuilder, string_template};

mod constants;
pub use constants::*;

macro_rules! predefined {
    ($($(#[$doc:meta])* $function:ident $name:literal $instance:literal $size:literal;)*) => {
        $($(#[$doc])* pub fn $function() -> Arc<Template> {
            static TEMPLATE: LazyLock<Arc<Template>> = LazyLock::new(|| {
                parse($name, $instance, $size, include_str!(concat!("../layouts/", stringify!($function), ".txt")))
            });
            TEMPLATE.clone()
        }

        #[doc = concat!("The layout of ", $name, ".")]
        pub mod $function {
            /// The offset of a word of the layout; a compiler error where it is used as a constant and there is none of that name.
            ///
            /// # Panics
            /// When the layout has no such word.
            pub const fn offset(name: &str) -> usize {
                super::offset_in(include_str!(concat!("../layouts/", stringify!($function), ".txt")), name)
            }
        })*

        /// Every predefined type, STRING included.
        pub fn all() -> Vec<Arc<Template>> {
            vec![string_template(), $($function()),*]
        }
    };
}

predefined! {
    /// MOTION_INSTRUCTION: status of one execution, 16 bytes; as bytes see [`crate::MotionControl`].
    motion_instruction "MOTION_INSTRUCTION" 0xF01 16;
    /// COORDINATE_SYSTEM, 104 bytes.
    coordinate_system "COORDINATE_SYSTEM" 0xF02 104;
    /// AXIS_CIP_DRIVE, 1040 bytes: a servo axis.
    axis_cip_drive "AXIS_CIP_DRIVE" 0xF03 1040;
    /// AXIS_VIRTUAL, 132 bytes: an axis without drive.
    axis_virtual "AXIS_VIRTUAL" 0xF04 132;
    /// MOTION_GROUP, 88 bytes.
    motion_group "MOTION_GROUP" 0xF05 88;
    /// CAM, 12 bytes: a point of a cam, for MCCP.
    cam "CAM" 0xF07 12;
    /// CAM_PROFILE, 56 bytes: a segment of a calculated cam, of which clients are shown the Status; see
    /// [`cam_profile_status`].
    cam_profile "CAM_PROFILE" 0xF08 56;
    /// OUTPUT_CAM, 32 bytes: an element of an output cam, for MAOC.
    output_cam "OUTPUT_CAM" 0xF09 32;
    /// OUTPUT_COMPENSATION, 24 bytes: of an output bit, for MAOC.
    output_compensation "OUTPUT_COMPENSATION" 0xF0A 24;
    /// POSITION_DATA, 28 bytes: a frame of a work or a tool, for MCTO and MCTPO (spec/coordinated-instructions.md §22.8).
    position_data "POSITION_DATA" 0xF0B 28;
    /// PATH_DATA, 68 bytes: where a path leads, for MCPM (spec/coordinated-instructions.md §23.1).
    path_data "PATH_DATA" 0xF0C 68;
    /// DYNAMICS_DATA, 44 bytes: how fast it leads there, for MCPM (spec/coordinated-instructions.md §23.2).
    dynamics_data "DYNAMICS_DATA" 0xF0D 44;
    /// TIMER, 12 bytes: the data of a program's timer, for clients that read one. Nothing counts in it.
    timer "TIMER" 0xF83 12;
    /// COUNTER, 12 bytes: as TIMER.
    counter "COUNTER" 0xF82 12;
    /// CONTROL, 12 bytes: place in an array that an instruction of a program works on; as TIMER.
    control "CONTROL" 0xF81 12;
    /// REAL_TIME, 248 bytes, a type of our own: the health of the real-time thread.
    ///
    /// Lateness is how long after its time a tick began, Compute how long it took; both in µs. Bucket 0 of a
    /// histogram counts values below 0.25 µs, bucket k ≥ 1 those from 2^(k−1) to below 2^k quarter-µs, and the
    /// last bucket, 23, also everything above (from 1.05 s). See [`histogram_bucket`].
    real_time "REAL_TIME" 0xF06 248;
    /// CONTOUR_RESTS, 8 bytes, a type of our own: how often the planned contours of a coordinate system have come to rest between moves that
    /// go on. Starved: its queue was empty, since the program sent its next move too late. Unplanned: the plan of the moves that waited was
    /// not ready in time. Both since the start of the server.
    contour_rests "CONTOUR_RESTS" 0xF0E 8;
}

/// The predefined types that plain tags can have, besides STRING.
pub fn for_tags() -> Vec<Arc<Template>> {
    vec![
        cam(),
        cam_profile(),
        output_cam(),
        output_compensation(),
        position_data(),
        path_data(),
        dynamics_data(),
        timer(),
        counter(),
        control(),
    ]
}

/// The predefined type of that name that plain tags can have, case ignored.
pub fn of_tags(name: &str) -> Option<Arc<Template>> {
    for_tags()
        .into_iter()
        .find(|template| template.name.eq_ignore_ascii_case(name))
}

/// Values of CAM_PROFILE.Status (spec/axis-and-data-types.md §3.9).
pub mod cam_profile_status {
    /// There is no profile.
    pub const NOT_CALCULATED: i32 = 0;
    /// MCCP calculates the profile.
    pub const BEING_CALCULATED: i32 = 1;
    /// The profile can be used; each instruction that uses it adds 1.
    pub const CALCULATED: i32 = 2;
}

/// Buckets of the histograms of REAL_TIME.
pub const HISTOGRAM_BUCKETS: usize = 24;

/// The bucket of REAL_TIME's histograms that counts a time. Real-time.
pub const fn histogram_bucket(nanoseconds: u64) -> usize {
    let quarters = nanoseconds / 250;
    let bucket = (u64::BITS - quarters.leading_zeros()) as usize;
    if bucket < HISTOGRAM_BUCKETS {
        bucket
    } else {
        HISTOGRAM_BUCKETS - 1
    }
}

/// The end of a bucket of REAL_TIME's histograms, s; `None`: the last one has none.
pub fn histogram_edge(bucket: usize) -> Option<f64> {
    (bucket + 1 < HISTOGRAM_BUCKETS).then(|| 250e-9 * 2_f64.powi(bucket as i32))
}

/// The type instances from here on are those of a real controller, whose handles are the same numbers.
const CONTROLLERS_OWN: u16 = 0xF80;

/// The offset of a word of a layout, found while this is compiled.
const fn offset_in(layout: &str, name: &str) -> usize {
    let (layout, name) = (layout.as_bytes(), name.as_bytes());
    let mut at = 0;
    while at < layout.len() {
        let mut offset = 0;
        while layout[at].is_ascii_digit() {
            offset = 10 * offset + (layout[at] - b'0') as usize;
            at += 1;
        }
        // The name begins behind the type.
        at += 1;
        while layout[at] != b' ' {
            at += 1;
        }
        at += 1;
        if layout[at] == b'(' {
            at += 1;
        }
        let mut same = 0;
        while same < name.len() && at + same < layout.len() && layout[at + same] == name[same] {
            same += 1;
        }
        let ends = at + same >= layout.len() || matches!(layout[at + same], b' ' | b')' | b'\n');
        if same == name.len() && ends {
            return offset;
        }
        while at < layout.len() && layout[at] != b'\n' {
            at += 1;
        }
        at += 1;
    }
    panic!("no word of this name in the layout")
}

fn parse(name: &str, instance: u16, size: u32, layout: &str) -> Arc<Template> {
    let mut builder = TemplateBuilder::new(name, instance).size(size);
    if instance >= CONTROLLERS_OWN {
        builder = builder.handle(instance);
    }
    layout
        .lines()
        .try_fold(builder, member)
        .expect("the layouts are part of the program")
        .build()
}

fn member(builder: TemplateBuilder, line: &str) -> Option<TemplateBuilder> {
    let mut words = line.split(' ');
    let offset: u32 = words.next()?.parse().ok()?;
    let (kind, dimension) = match words.next()? {
        array if array.ends_with(']') => {
            let (kind, dimension) = array.trim_end_matches(']').split_once('[')?;
            (kind, dimension.parse().ok()?)
        }
        scalar => (scalar, 0),
    };
    let word = words.next()?;
    let name = word.trim_start_matches('(').trim_end_matches(')');
    let mut builder = builder.member_at(name, Elementary::from_name(kind)?, dimension, offset);
    if name != word {
        builder = builder.hide();
    }
    for bit in words {
        let (bit, name) = bit.split_once(':')?;
        builder = builder.bit_at(name, offset, bit.parse().ok()?);
    }
    Some(builder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Flag;

    #[test]
    fn templates_are_those_of_a_controller() {
        #[rustfmt::skip]
        let cases = [
            // type,                members, size, member,              offset, bit
            (motion_instruction(),  19,  16,   "EN",                     3,   Some(7)),
            (motion_instruction(),  19,  16,   "ACCEL",                  0,   Some(1)),
            (motion_instruction(),  19,  16,   "EXERR",                  12,  None),
            (coordinate_system(),   39,  104,  "ActualPosition",         52,  None),
            (coordinate_system(),   39,  104,  "MovePendingStatus",      17,  Some(0)),
            (coordinate_system(),   39,  104,  "CoordinateSystemLockStatus", 17, Some(7)),
            (coordinate_system(),   39,  104,  "TurnsCounters",          92,  None),
            (motion_group(),        33,  88,   "GroupStatus",            40,  None),
            (motion_group(),        33,  88,   "GroupSynced",            40,  Some(1)),
            (axis_cip_drive(),      833, 1040, "CommandPosition",        204, None),
            (axis_cip_drive(),      833, 1040, "ExcessivePositionErrorFLFault", 886, Some(6)),
            (axis_cip_drive(),      833, 1040, "CIPShutdownStatus",      846, Some(2)),
            (axis_virtual(),        75,  132,  "CommandAcceleration",    128, None),
            (position_data(),       7,   28,   "Rz",                     24,  None),
            (path_data(),           8,   68,   "TurnsCounters",          48,  None),
            (timer(),               6,   12,   "DN",                     3,   Some(5)),
            (counter(),             8,   12,   "ACC",                    8,   None),
            (control(),             11,  12,   "FD",                     3,   Some(0)),
            (dynamics_data(),       11,  44,   "OrientationDeceleration", 40, None),
            (real_time(),           17,  248,  "Pinned",                 236, Some(2)),
        ];
        for (template, members, size, name, offset, bit) in cases {
            assert_eq!(
                (template.members.len(), template.size),
                (members, size),
                "{}",
                template.name
            );
            let member = template
                .member(name)
                .or_else(|| template.member(&name.replace("FL", "")));
            let member = member.unwrap_or_else(|| panic!("{} {name}", template.name));
            assert_eq!((member.offset, member.bit), (offset, bit), "{} {name}", template.name);
        }
    }

    #[test]
    fn handles_of_program_types_are_those_that_clients_know() {
        // Handles from gologix (lgxtypes), and handles that pycomm3 reads from controllers.
        for (template, handle) in [(timer(), 0x0F83), (counter(), 0x0F82), (control(), 0x0F81)] {
            assert_eq!(
                (template.handle, template.instance),
                (handle, handle),
                "{}",
                template.name
            );
            let host = template.member("Control").expect("the word that holds its bits");
            assert!(host.hidden, "Studio does not show it");
        }
    }

    #[test]
    fn words_fill_the_types_without_gap_or_overlap() {
        for template in all().into_iter().filter(|template| template.name != "ASCIISTRING82") {
            let (mut end, mut alignment) = (0, 1);
            for member in template.members.iter().filter(|member| member.bit.is_none()) {
                assert_eq!(member.offset as usize, end, "{} {}", template.name, member.name);
                end += member.size();
                alignment = alignment.max(member.data_type.size());
            }
            // In an array, each structure begins at the alignment of its largest member.
            assert_eq!(
                end.next_multiple_of(alignment),
                template.size as usize,
                "{}",
                template.name
            );
            assert!(!template.is_user_type());
            for member in template.members.iter().filter(|member| member.bit.is_some()) {
                assert!(member.offset < template.size, "{} {}", template.name, member.name);
            }
        }
    }

    #[test]
    fn instances_are_unique() {
        let mut instances: Vec<_> = all().iter().map(|template| template.instance).collect();
        instances.sort_unstable();
        instances.dedup();
        assert_eq!(instances.len(), all().len());
    }

    #[test]
    fn constants_agree_with_the_layouts() {
        #[rustfmt::skip]
        let offsets = [
            (axis_cip_drive(),     "CIPAxisFaults",          axis_cip_drive_offset::CIP_AXIS_FAULTS),
            (axis_cip_drive(),     "CommandVelocity",        axis_cip_drive_offset::COMMAND_VELOCITY),
            (axis_virtual(),       "CommandPosition",        axis_virtual_offset::COMMAND_POSITION),
            (coordinate_system(),  "AxesServoOnStatus",      coordinate_system_offset::AXES_SERVO_ON_STATUS),
            (motion_group(),       "TaskAverageScanTime",    motion_group_offset::TASK_AVERAGE_SCAN_TIME),
            (real_time(),          "ComputeHistogram",       real_time_offset::COMPUTE_HISTOGRAM),
            (real_time(),          "UpdatePeriod",           real_time_offset::UPDATE_PERIOD),
            (path_data(), "InterpolationType", path_data_offset::INTERPOLATION_TYPE),
            (path_data(), "Position", path_data_offset::POSITION),
            (path_data(), "RobotConfiguration", path_data_offset::ROBOT_CONFIGURATION),
            (path_data(), "TurnsCounters", path_data_offset::TURNS_COUNTERS),
            (path_data(), "MoveType", path_data_offset::MOVE_TYPE),
            (path_data(), "TerminationType", path_data_offset::TERMINATION_TYPE),
            (path_data(), "CommandToleranceLinear", path_data_offset::COMMAND_TOLERANCE_LINEAR),
            (dynamics_data(), "UnitsMode", dynamics_data_offset::UNITS_MODE),
            (dynamics_data(), "TimeUnits", dynamics_data_offset::TIME_UNITS),
            (dynamics_data(), "Profile", dynamics_data_offset::PROFILE),
            (dynamics_data(), "Speed", dynamics_data_offset::SPEED),
            (dynamics_data(), "Acceleration", dynamics_data_offset::ACCELERATION),
            (dynamics_data(), "Deceleration", dynamics_data_offset::DECELERATION),
            (dynamics_data(), "AccelerationJerk", dynamics_data_offset::ACCELERATION_JERK),
            (dynamics_data(), "DecelerationJerk", dynamics_data_offset::DECELERATION_JERK),
            (dynamics_data(), "OrientationSpeed", dynamics_data_offset::ORIENTATION_SPEED),
            (dynamics_data(), "OrientationAcceleration", dynamics_data_offset::ORIENTATION_ACCELERATION),
            (dynamics_data(), "OrientationDeceleration", dynamics_data_offset::ORIENTATION_DECELERATION),
        ];
        for (template, name, offset) in offsets {
            assert_eq!(template.member(name).expect(name).offset as usize, offset, "{name}");
        }
        #[rustfmt::skip]
        let bits = [
            (axis_cip_drive(),    "AxisUpdateStatus",      16, axis_status::AXIS_UPDATE_STATUS),
            (axis_cip_drive(),    "CoordinatedMotionStatus", 20, motion_status::COORDINATED_MOTION_STATUS),
            (axis_cip_drive(),    "HomeInputStatus",      868, cip_axis_io_status::HOME_INPUT_STATUS),
            (axis_cip_drive(),    "Registration2InputStatus", 868, cip_axis_io_status::REGISTRATION2_INPUT_STATUS),
            (axis_virtual(),      "MaximumSpeedExceeded",  20, motion_status::MAXIMUM_SPEED_EXCEEDED),
            (coordinate_system(), "MovePendingStatus",     16, coordinate_motion_status::MOVE_PENDING_STATUS),
            (coordinate_system(), "ReadyStatus",           12, coordinate_system_status::READY_STATUS),
            (motion_group(),      "GroupSynced",           40, group_status::GROUP_SYNCED),
        ];
        for (template, name, word, mask) in bits {
            let member = template.member(name).expect(name);
            let bit = 8 * (member.offset - word) + u32::from(member.bit.expect(name));
            assert_eq!(1 << bit, mask, "{name}");
        }
        for flag in Flag::ALL {
            let template = motion_instruction();
            let name = flag.name();
            let member = template.member(name).expect(name);
            assert_eq!(8 * member.offset as u8 + member.bit.expect(name), flag.bit(), "{flag}");
        }
    }

    #[test]
    fn offsets_are_those_of_the_templates() {
        type Offset = fn(&str) -> usize;
        #[rustfmt::skip]
        let templates: [(_, Offset); 4] = [
            (axis_cip_drive(), axis_cip_drive::offset), (axis_virtual(), axis_virtual::offset),
            (coordinate_system(), coordinate_system::offset), (motion_group(), motion_group::offset),
        ];
        for (template, offset) in templates {
            for member in template.members.iter().filter(|member| member.bit.is_none()) {
                assert_eq!(
                    offset(&member.name),
                    member.offset as usize,
                    "{} {}",
                    template.name,
                    member.name
                );
            }
        }
        for missing in ["AxisFaul", "AxisFaults", "", "ServoActionStatus"] {
            let found = std::panic::catch_unwind(|| axis_virtual::offset(missing));
            assert!(found.is_err(), "{missing} is no word of AXIS_VIRTUAL");
        }
    }

    #[test]
    fn histogram_buckets_double() {
        #[rustfmt::skip]
        let cases = [(0, 0), (249, 0), (250, 1), (499, 1), (500, 2), (999, 2), (1000, 3), (1_000_000, 12),
            (1_048_576_000, 23), (u64::MAX, 23)];
        for (nanoseconds, bucket) in cases {
            assert_eq!(histogram_bucket(nanoseconds), bucket, "{nanoseconds} ns");
        }
    }
}

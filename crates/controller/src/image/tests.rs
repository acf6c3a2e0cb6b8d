//! The tag memory: names, paths, writers, edges, and the effects of events and snapshots.

use arcline_instruction_set::predefined::axis_fault;
use arcline_instruction_set::{
    Argument, AxisId, Directory, FaultKind, Flag, Mnemonic, MotionControl, MotionError, UnboundOperand, bind,
};
use arcline_motion::{CallData, Cause, ContourRests};
use arcline_tag::{Elementary, TagPath, Value};

use super::*;
use crate::machine::{Axis, AxisKind, CoordinateSystem, MotionGroup};
use crate::{AxisSnapshot, CONTROL_SLOTS, Ticket};

pub(super) fn machine() -> Machine {
    let axis = |name: &str, kind| Axis {
        max_acceleration_jerk: 200_000.0,
        max_deceleration_jerk: 200_000.0,
        ..Axis::new(name, kind, 1000.0, 10_000.0)
    };
    let system = CoordinateSystem {
        max_acceleration_jerk: 100_000.0,
        max_deceleration_jerk: 100_000.0,
        actual_tolerance: 0.01,
        command_tolerance: 0.5,
        ..CoordinateSystem::new("CS1", &[AxisId(0), AxisId(1)], 500.0, 5000.0)
    };
    let axes = vec![axis("X", AxisKind::Servo), axis("V", AxisKind::Virtual)];
    Machine::new(MotionGroup::new(axes, vec![system]))
}

fn image() -> Image {
    let instruction = InstructionTag {
        name: "Move1".to_owned(),
        mnemonic: Mnemonic::Mclm,
        target: "CS1".to_owned(),
    };
    let plain = [
        ("Recipe", TagType::array(Elementary::Real, 16)),
        ("Count", TagType::scalar(Elementary::Int)),
        ("Label", TagType::scalar(arcline_tag::string_template())),
    ];
    let plain = plain.map(|(name, tag_type)| PlainTag::new(name, tag_type));
    Image::new(&machine(), &[instruction], &plain)
}

fn path(text: &str) -> TagPath {
    text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn number(image: &Image, text: &str) -> f64 {
    image
        .read(&path(text))
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .as_f64()
}

#[test]
fn every_tag_has_a_permanent_id_a_type_and_bytes() {
    let image = image();
    #[rustfmt::skip]
    let cases = [
        ("Motion", 1, "MOTION_GROUP", 88), ("X", 2, "AXIS_CIP_DRIVE", 1040), ("V", 3, "AXIS_VIRTUAL", 132),
        ("CS1", 4, "COORDINATE_SYSTEM", 104), ("Move1", 5, "MCLM", 368), ("Recipe", 6, "REAL", 64),
        ("Count", 7, "INT", 2), ("Label", 8, "STRING", 88), ("RealTime", 9, "REAL_TIME", 248),
        ("FeedOverride", 10, "REAL", 4), ("FaultInject", 11, "DINT", 8), ("MotionInhibit", 12, "BOOL", 1),
        ("ContourRests", 13, "CONTOUR_RESTS", 8),
    ];
    for (name, id, data_type, size) in cases {
        let tag = image.find(&name.to_uppercase()).unwrap_or_else(|| panic!("{name}"));
        assert_eq!((tag.id.0, tag.tag_type.data_type.name()), (id, data_type), "{name}");
        if name != "Move1" {
            assert_eq!(image.bytes(tag.id).len(), size, "{name}");
        }
        assert_eq!(image.tag(tag.id).map(|tag| tag.name.as_str()), Some(name));
        if let DataType::Structure(template) = &tag.tag_type.data_type {
            assert!(image.template(template.instance).is_some(), "{name}");
        }
    }
    assert_eq!(image.tags().len(), cases.len());
    assert!(
        image.templates().any(|template| template.name == "ASCIISTRING82"),
        "the type of a member"
    );
    assert!(image.tag(TagId(0)).is_none() && image.bytes(TagId(99)).is_empty());
}

#[test]
fn clients_write_inputs_and_not_status() {
    let mut image = image();
    #[rustfmt::skip]
    let cases = [
        ("Recipe[3]", true), ("Count", true), ("Count.5", true), ("Label.LEN", true),
        ("Move1.Speed", true), ("Move1.Position[8]", true), ("Move1.CoordinateSystem.LEN", true), ("Move1.EnableIn", true),
        ("Move1.EnableOut", false), ("Move1.MotionControl.FLAGS", false), ("Move1.MotionControl.DN", false),
        ("Move1.DN", false), ("Motion.GroupStatus", false), ("X.CommandPosition", false), ("X.InterpolationTime", true),
        ("V.InterpolationTime", true), ("V.AxisFault", false), ("CS1.MotionStatus", false), ("RealTime.Ticks", false),
        ("ContourRests[0].Starved", false),
    ];
    for (text, writable) in cases {
        let before = image.clone().bytes;
        let result = image.write_value(&path(text), Value::Lreal(1.0));
        assert_eq!(result.is_ok(), writable, "{text}: {result:?}");
        if writable {
            assert_eq!(number(&image, text), 1.0, "{text}");
        } else {
            assert_eq!(image.bytes, before, "{text}: a refused write changes nothing");
        }
    }
    let count = image.find("Count").expect("a tag").id;
    assert!(matches!(
        image.write(count, 1, &[0, 0]),
        Err(WriteError::BeyondEnd { size: 2, .. })
    ));
    let whole = image.find("Move1").expect("a tag").id;
    let bytes = image.bytes(whole).to_vec();
    assert!(image.write(whole, 0, &bytes).is_err(), "it holds MotionControl");
}

#[test]
fn enable_in_has_edges_and_enable_out_follows() {
    let mut image = image();
    let id = image.find("Move1").expect("a tag").id;
    #[rustfmt::skip]
    let cases = [
        (false, None), (true, Some(WriteEffect::Rising(id))), (true, None), (false, Some(WriteEffect::Falling(id))), (false, None),
    ];
    for (on, edge) in cases {
        assert_eq!(
            image.write_value(&path("Move1.EnableIn"), Value::Bool(on)),
            Ok(edge),
            "{on}"
        );
        assert_eq!(number(&image, "Move1.EnableOut"), f64::from(u8::from(on)), "{on}");
    }
}

#[test]
fn an_instruction_tag_calls_with_its_members() {
    let mut image = image();
    for (text, value) in [("Move1.Position[1]", 12.5), ("Move1.Speed", 40.0)] {
        image.write_value(&path(text), Value::Lreal(value)).expect("writable");
    }
    let id = image.find("Move1").expect("a tag").id;
    let call = image.call_of(id).expect("an instruction tag").expect("it binds");
    assert_eq!((call.mnemonic, call.target), (Mnemonic::Mclm, Some(0)));
    let speed = Mnemonic::Mclm.instruction().operand("Speed").expect("an operand");
    assert_eq!(call.number(speed), 40.0);
    assert!(
        call.arguments
            .iter()
            .any(|argument| matches!(argument, Argument::Array(array) if array.as_slice()[1] == 12.5))
    );

    image
        .write_value(&path("Move1.CoordinateSystem.LEN"), Value::Dint(2))
        .expect("writable");
    let call = image.call_of(id).expect("an instruction tag").expect("it binds");
    assert_eq!(call.target, None, "there is no CS");
    assert!(image.call_of(TagId(1)).is_none());
}

#[test]
fn motion_controls_are_found_or_made() {
    let mut image = image();
    let known = image.control_slot("move1").expect("its member");
    assert_eq!(image.control_slot("Move1.motioncontrol"), Ok(known));
    let made = image.control_slot("M1").expect("a new tag");
    assert_ne!(made, known);
    assert_eq!(image.control_slot("m1"), Ok(made));
    assert_eq!(
        (
            image.control_name(known),
            image.control_name(made),
            image.control_name(UNNAMED)
        ),
        ("Move1", "M1", "")
    );
    assert_eq!(image.tags().last().map(|tag| tag.name.as_str()), Some("M1"));
    #[rustfmt::skip]
    let wrong = ["X", "CS1", "Count", "Move1.Speed", "", "1M", "M 1", "M1.PC", "Nothing.PC", "a_name_that_is_longer_than_forty_letters_"];
    let tags = image.tags().len();
    for name in wrong {
        assert!(image.control_slot(name).is_err(), "{name:?}");
    }
    assert_eq!(image.tags().len(), tags);
}

/// The number of motion control tags that instructions add is limited, but a new name is refused only if every other tag has an instruction in
/// process.
#[test]
fn an_idle_motion_control_tag_makes_room() {
    let mut image = image();
    let configured = PlainTag::new("Configured", TagType::scalar(predefined::motion_instruction()));
    let tags = |tags| ConfiguredTags {
        data_types: &[],
        instructions: &[],
        tags,
    };
    let declared = [configured];
    image.reload(tags(&[]), tags(&declared)).expect("a free name");
    assert!(image.known_control("configured").is_ok_and(|slot| slot.is_some()));
    let set = |image: &mut Image, name: &str, flags: &[Flag]| {
        let slot = image.control_slot(name).expect("a slot");
        let mut control = MotionControl::default();
        flags.iter().for_each(|flag| control.set(*flag));
        image.set_control(slot, control);
    };
    set(&mut image, "Moving", &[Flag::En, Flag::Dn, Flag::Ip]);
    set(&mut image, "Sent", &[Flag::En]);
    set(&mut image, "Used", &[Flag::Dn, Flag::Pc]);
    set(&mut image, "Refused", &[Flag::En, Flag::Er]);
    let mut made = 4;
    while image.find("Used").is_some() && image.find("Refused").is_some() {
        // An instruction names it again and again.
        image.control_slot("Used").expect("its slot");
        image.control_slot(&format!("N{made}")).expect("a slot");
        made += 1;
        assert!(made < 2 * CONTROL_SLOTS, "no tag makes room");
    }
    assert!(made > CONTROL_SLOTS - 20, "{made}: only when no slot is free");
    // The tag that no instruction has named for the longest time is removed; that of the configuration stays.
    assert!(image.find("Configured").is_some());
    assert!(image.find("Refused").is_none());
    for name in ["Moving", "Sent", "Used", "N4"] {
        assert!(image.find(name).is_some(), "{name}");
    }
    // The next one to be replaced is N4; its slot now belongs to the new tag, without a status yet.
    let slot = image.known_control("N4").expect("a motion control tag");
    assert_eq!(image.control_slot("Another").ok(), slot);
    assert!(image.find("N4").is_none());
    assert_eq!(image.control(slot.expect("its slot")), MotionControl::default());
    let all: Vec<String> = image.tags().iter().map(|tag| tag.name.clone()).collect();
    for name in all {
        if image.known_control(&name).is_ok_and(|slot| slot.is_some()) {
            set(&mut image, &name, &[Flag::Ip]);
        }
    }
    assert_eq!(image.control_slot("OneMore"), Err(ControlError::NoRoom));
    assert!(image.control_slot("Moving").is_ok(), "what is there stays");
}

#[test]
fn events_show_in_the_tag_that_owns_them() {
    let mut image = image();
    let control = image.control_slot("Move1").expect("its member");
    let event = |owner, set: &[Flag], clear: &[Flag], err| Event {
        tick: 1,
        ticket: Ticket(1),
        control,
        owner,
        mnemonic: Mnemonic::Mclm,
        set: set.iter().fold(0, |word, flag| word | flag.mask()),
        clear: clear.iter().fold(0, |word, flag| word | flag.mask()),
        err,
        exerr: -1,
        segment: 0,
        cause: Cause::Itself,
    };
    image.apply_event(&event(true, &[Flag::En, Flag::Dn, Flag::Ip], &[], 0));
    image.apply_event(&event(false, &[Flag::Pc], &[Flag::Ip], 0));
    assert_eq!(
        [number(&image, "Move1.IP"), number(&image, "Move1.MotionControl.PC")],
        [1.0, 0.0]
    );
    image.apply_event(&event(true, &[Flag::Er], &[Flag::Ip], 54));
    #[rustfmt::skip]
    let cases = [("EN", 1.0), ("DN", 1.0), ("IP", 0.0), ("ER", 1.0), ("ERR", 54.0), ("EXERR", -1.0)];
    for (member, expected) in cases {
        assert_eq!(
            number(&image, &format!("Move1.MotionControl.{member}")),
            expected,
            "{member}"
        );
    }
}

#[test]
fn snapshots_show_in_every_type() {
    let mut image = image();
    let mut snapshot = Snapshot::new(&machine());
    snapshot.tick = 7;
    let shown = AxisSnapshot {
        status: 67,
        motion_status: 0x81,
        fault: 2,
        cip_state: 4,
        command: [1.5, -2.0, 3.0],
        actual: [1.25, -2.5, 0.0],
        position_error: 0.25,
        ..AxisSnapshot::default()
    };
    snapshot.axes.fill(shown);
    snapshot.systems[0].status = 6;
    snapshot.systems[0].motion_status = 0x40;
    snapshot.systems[0].actual = [1.25, 2.25, 0.0, 0.0, 0.0, 0.0];
    snapshot.systems[0].contour_rests = ContourRests {
        starved: 3,
        unplanned: 2,
    };
    image.apply_snapshot(&snapshot);
    image.apply_health(&Health {
        ticks: 42,
        overruns: 1,
        overlapping: true,
        fifo: true,
        ..Health::default()
    });
    #[rustfmt::skip]
    let cases = [
        ("X.CommandPosition", 1.5), ("V.CommandPosition", 1.5), ("X.ActualVelocity", -2.5), ("V.ActualVelocity", -2.5),
        ("X.AxisStatus", 67.0), ("X.ServoActionStatus", 1.0), ("V.AxisHomedStatus", 1.0), ("X.AccelStatus", 1.0),
        ("X.PositionError", 0.25), ("X.VelocityError", 0.5), ("X.CIPAxisState", 4.0), ("X.PositionLoopBandwidth", 40.0),
        ("X.VelocityFeedforwardGain", 100.0), ("CS1.MotionStatus", 1.0), ("CS1.MoveStatus", 1.0),
        ("CS1.ActualPosition[1]", 2.25), ("Motion.GroupSynced", 1.0), ("Motion.ModuleFault", 1.0),
        ("Motion.GroupOverlapFault", 1.0), ("RealTime.Ticks", 42.0), ("RealTime.Overruns", 1.0), ("RealTime.Fifo", 1.0),
        ("RealTime.Pinned", 0.0), ("RealTime.UpdatePeriod", 1.0),
        ("ContourRests[0].Starved", 3.0), ("ContourRests[0].Unplanned", 2.0),
    ];
    for (text, expected) in cases {
        assert_eq!(number(&image, text), expected, "{text}");
    }
    assert_eq!(image.snapshot_tick(), 7);
    assert_eq!(
        image.read_numbers(&path("CS1.ActualPosition[1]")),
        Ok(vec![2.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    );
    assert_eq!(image.read_numbers(&path("X.ServoActionStatus")), Ok(vec![1.0]));
}

#[test]
fn reads_that_lead_nowhere_say_why() {
    let image = image();
    #[rustfmt::skip]
    let cases = [
        ("Nothing", "there is no tag \"Nothing\""),
        ("X", "X has the type AXIS_CIP_DRIVE, expected a number"),
        ("X.Nothing", "AXIS_CIP_DRIVE has no member \"Nothing\""),
        ("Move1.Nothing", "MCLM has no member \"Nothing\""),
        ("Recipe[16]", "index 16 is out of range, the array has 16 elements"),
    ];
    for (text, message) in cases {
        assert_eq!(image.read(&path(text)).expect_err(text).to_string(), message, "{text}");
    }
}

#[test]
fn arrays_that_are_written_are_found_again() {
    let image = image();
    #[rustfmt::skip]
    let cases = [
        ("Recipe", Some(("Recipe", 0, 16))), ("recipe[4]", Some(("Recipe", 16, 12))), ("Count", None), ("X.ActualPosition", None),
        ("CS1.ActualPosition", None), ("Nothing", None), ("1", None),
    ];
    for (text, expected) in cases {
        let found = image.real_array(text).and_then(|array| image.written_array(array.tag));
        let expected = expected.map(|(name, offset, elements)| (image.find(name).expect(name).id, offset, elements));
        assert_eq!(found, expected, "{text}");
    }
    let tag = image
        .real_array("Move1.CalculatedData")
        .and_then(|array| image.written_array(array.tag));
    assert_eq!(tag.map(|(_, _, elements)| elements), Some(4));
}

#[test]
fn only_faults_that_an_axis_can_have_are_injected() {
    let mut image = image();
    let soft = 0b11 | 1 << FaultKind::CommandLimit as u32;
    let none = f64::from(1_u32 << FaultKind::COUNT);
    #[rustfmt::skip]
    let cases = [
        // why,                      path,               value,   taken, injected
        ("a servo",                  "FaultInject[0]",   16.0,    true,  [16, 0]),
        ("one more, as a bit",       "FaultInject[0].2", 1.0,     true,  [20, 0]),
        ("a bit away",               "FaultInject[0].4", 0.0,     true,  [4, 0]),
        ("a fault that there isn't", "FaultInject[0]",   none,    false, [4, 0]),
        ("as a bit",                 "FaultInject[0].31", 1.0,    false, [4, 0]),
        ("below zero",               "FaultInject[0]",   -1.0,    false, [4, 0]),
        ("a virtual axis",           "FaultInject[1]",   3.0,     true,  [4, 3]),
        ("a drive it has not",       "FaultInject[1]",   4.0,     false, [4, 3]),
        ("nothing",                  "FaultInject[0]",   0.0,     true,  [0, 3]),
    ];
    for (why, place, value, taken, injected) in cases {
        let result = image.write_value(&path(place), Value::Lreal(value));
        match result {
            Ok(edge) => assert_eq!((edge, taken), (Some(WriteEffect::FaultInject), true), "{why}"),
            Err(error) => assert!(
                !taken && matches!(error, WriteError::NoSuchFault { .. }),
                "{why}: {error}"
            ),
        }
        let shown: Vec<u32> = image.injected_faults().map(FaultSet::bits).collect();
        assert_eq!(shown, injected, "{why}");
    }
    assert_eq!(image.possible_faults(AxisId(1)).map(FaultSet::bits), Some(soft));
    assert_eq!(image.inject_faults(AxisId(1), 1), Ok(Some(WriteEffect::FaultInject)));
    assert!(image.inject_faults(AxisId(2), 1).is_err(), "no such axis");
}

#[test]
fn faults_show_in_the_axis_the_system_and_the_group() {
    let mut image = image();
    let mut snapshot = Snapshot::new(&machine());
    snapshot.axes[0].fault = axis_fault::MOTION_FAULT;
    snapshot.axes[0].motion_faults = [1 << 1, 1 << 2];
    snapshot.axes[0].cip_faults = [1 << 54, 1 << 62];
    snapshot.axes[0].average_velocity = 2.5;
    snapshot.systems[0].fault = axis_fault::PHYSICAL_AXIS_FAULT;
    snapshot.systems[0].axes_faulted = 1;
    image.apply_snapshot(&snapshot);
    #[rustfmt::skip]
    let cases = [
        ("X.MotionFault", 1.0), ("X.SoftTravelLimitPositiveFault", 1.0), ("X.SoftTravelLimitNegativeFault", 0.0),
        ("X.SoftTravelLimitNegativeAlarm", 1.0), ("X.ExcessivePositionErrorFault", 1.0),
        ("X.ControllerInitiatedAlarm", 1.0), ("X.AverageVelocity", 2.5), ("X.GroupFault", 0.0),
        ("CS1.PhysicalAxisFault", 1.0), ("CS1.PhysicalAxesFaulted", 1.0), ("CS1.ModulesFaulted", 0.0),
        ("Motion.PhysicalAxisFault", 1.0), ("V.PhysicalAxisFault", 0.0),
    ];
    for (member, value) in cases {
        assert_eq!(number(&image, member), value, "{member}");
    }
    // A tick that overran is a fault of the group, which axes and coordinate systems show too.
    let health = Health {
        overlapping: true,
        ..Health::default()
    };
    image.apply_health(&health);
    image.apply_snapshot(&snapshot);
    for member in [
        "Motion.GroupOverlapFault",
        "X.GroupFault",
        "V.GroupFault",
        "CS1.GroupFault",
    ] {
        assert_eq!(number(&image, member), 1.0, "{member}");
    }
}

#[test]
fn an_override_is_written_in_percent_and_within_its_range() {
    let mut image = image();
    assert_eq!(image.feed_overrides().collect::<Vec<_>>(), [100.0]);
    #[rustfmt::skip]
    let cases = [
        // why,          value,         taken, shown,  before a hold
        ("half",         50.0,          true,  50.0,   50.0),
        ("a hold",       0.0,           true,  0.0,    50.0),
        ("below",        -0.5,          false, 0.0,    50.0),
        ("above",        200.5,         false, 0.0,    50.0),
        ("no number",    f64::NAN,      false, 0.0,    50.0),
        ("infinite",     f64::INFINITY, false, 0.0,    50.0),
        ("the most",     200.0,         true,  200.0,  200.0),
    ];
    for (why, value, taken, shown, before) in cases {
        let result = image.write_value(&path("FeedOverride[0]"), Value::Lreal(value));
        match result {
            Ok(edge) => assert_eq!((edge, taken), (Some(WriteEffect::FeedOverride), true), "{why}"),
            Err(error) => assert!(
                !taken && matches!(error, WriteError::OutOfRange { .. }),
                "{why}: {error}"
            ),
        }
        assert_eq!(image.feed_overrides().collect::<Vec<_>>(), [shown], "{why}");
        assert_eq!(image.feed_override_before_hold(SystemId(0)), Some(before), "{why}");
    }
    assert_eq!(
        image.set_feed_override(SystemId(0), 25.0),
        Ok(Some(WriteEffect::FeedOverride))
    );
    assert!(
        image.set_feed_override(SystemId(1), 25.0).is_err(),
        "no such coordinate system"
    );
    assert_eq!(number(&image, "FeedOverride"), 25.0);
    assert!(
        image.real_array("FeedOverride").is_none(),
        "not for instructions to write"
    );
}

#[test]
fn programs_have_scopes_and_aliases_stand_for_parts() {
    let alias = |name: &str, of: &str, tag_type| PlainTag {
        alias: Some(path(of)),
        ..PlainTag::new(name, tag_type)
    };
    let plain = [
        PlainTag::new("Word", TagType::array(Elementary::Dint, 4)),
        PlainTag {
            program: Some("Main".to_owned()),
            access: Access::ReadOnly,
            first: vec![7, 0],
            ..PlainTag::new("Word", TagType::scalar(Elementary::Int))
        },
        alias("Second", "Word[1]", TagType::scalar(Elementary::Dint)),
        alias("Ready", "Word[2].9", TagType::scalar(Elementary::Bool)),
        alias("Seven", "Program:Main.Word", TagType::scalar(Elementary::Int)),
    ];
    let mut image = Image::new(&machine(), &[], &plain);
    assert_eq!(image.programs(), ["Main"]);
    for (text, value) in [("Word[1]", 11.0), ("SECOND", 12.0), ("Ready", 1.0)] {
        let edge = image.write_value(&path(text), Value::Dint(value as i32));
        assert_eq!(edge, Ok(None), "{text}");
    }
    #[rustfmt::skip]
    let cases = [
        ("Word[1]", 12.0), ("Second.2", 1.0), ("Word[2]", 512.0), ("Ready", 1.0), ("program:MAIN.word", 7.0),
        ("Seven", 7.0),
    ];
    for (text, expected) in cases {
        assert_eq!(number(&image, text), expected, "{text}");
    }
    for text in ["Program:Main.Word", "Seven"] {
        assert!(
            matches!(
                image.write_value(&path(text), Value::Int(1)),
                Err(WriteError::ReadOnly { .. })
            ),
            "{text}"
        );
    }
    for text in ["Program:Main", "Program:Main.Second", "Program:Other.Word", "Main.Word"] {
        assert!(image.read(&path(text)).is_err(), "{text}");
    }
}

#[test]
fn clients_do_not_write_read_only_members() {
    let inner = arcline_tag::TemplateBuilder::new("Inner", 0x120)
        .member("Free", Elementary::Bool)
        .member("Kept", Elementary::Bool)
        .read_only()
        .member("Set", Elementary::Dint)
        .build();
    let outer = arcline_tag::TemplateBuilder::new("Outer", 0x121)
        .member("Before", Elementary::Dint)
        .array("Rows", inner, 3)
        .build();
    let tags = [PlainTag::new("T", TagType::array(outer, 2))];
    let mut image = Image::new(&machine(), &[], &tags);
    #[rustfmt::skip]
    let cases = [
        ("T[1].Before", true), ("T[1].Rows[2].Free", true), ("T[1].Rows[2].Set", true), ("T[1].Rows[2].Kept", false), ("T[0].Rows[0].Kept", false),
        ("T[0].Rows[0].Set", true),
    ];
    for (text, is_writable) in cases {
        let written = image.write_value(&path(text), Value::Dint(1));
        assert_eq!(written.is_ok(), is_writable, "{text}");
        assert_eq!(number(&image, text), f64::from(u8::from(is_writable)), "{text}");
    }
    let id = image.find("T").expect("a tag").id;
    // Words of 28 bytes: `Before`, and three rows of the bits and `Set`.
    #[rustfmt::skip]
    let cases = [(0, 4, true), (8, 4, true), (4, 1, false), (0, 8, false), (28, 4, true), (24, 8, true), (24, 12, false), (8, 20, false), (0, 56, false)];
    for (offset, len, is_writable) in cases {
        assert_eq!(
            image.writable(id, offset, len),
            is_writable,
            "{len} bytes from {offset}"
        );
    }
}

#[test]
fn only_written_parts_of_plain_tags_are_remembered() {
    let mut image = image();
    let one = Value::Real(1.0);
    image.write_value(&path("Count"), one).expect("writable");
    assert_eq!(image.take_written(), [], "nobody wants to know yet");
    image.remember_written();
    for (written, value) in [
        ("Recipe[3]", 2.5),
        ("Count.9", 1.0),
        ("Move1.Speed", 5.0),
        ("Count", 7.0),
    ] {
        image.write_value(&path(written), Value::Real(value)).expect("writable");
    }
    assert!(image.write_value(&path("Recipe[99]"), one).is_err(), "refused");
    let [recipe, count, axis] = ["Recipe", "Count", "X"].map(|name| image.find(name).expect("it is there").id);
    let expected = [(recipe, 12, 4), (count, 0, 2)];
    let expected = expected.map(|(id, offset, length)| WrittenPart { id, offset, length });
    assert_eq!(image.take_written(), expected);
    image.restore(count, &[8, 0]);
    image.restore(count, &[9, 0, 0]);
    let before = image.bytes(axis).to_vec();
    image.restore(axis, &vec![1; before.len()]);
    assert_eq!((image.bytes(count), image.bytes(axis)), (&[8, 0][..], &before[..]));
    assert_eq!(image.take_written(), [], "what is restored is not written");
}

/// What waits for the retained state is never more than the tags, however often they are written.
#[test]
fn written_parts_that_overlap_or_touch_wait_as_one() {
    let big = PlainTag::new("Big", TagType::array(Elementary::Sint, 1 << 20));
    let mut image = Image::new(&machine(), &[], &[big]);
    image.remember_written();
    let id = image.find("Big").expect("it is there").id;
    for from in [7, 9, 8, 20, 7, 21, 6] {
        let written = image.write_value(&path(&format!("Big[{from}]")), Value::Sint(1));
        written.expect("writable");
    }
    let part = |offset, length| WrittenPart { id, offset, length };
    assert_eq!(image.take_written(), [part(20, 2), part(6, 4)]);
    for from in 0..5000 {
        let written = image.write_value(&path(&format!("Big[{}]", 200 * from)), Value::Sint(1));
        written.expect("writable");
    }
    let parts = image.take_written();
    assert!(parts.len() <= 1024, "{}", parts.len());
    let is_in = |at: usize| {
        parts
            .iter()
            .any(|part| (part.offset..part.offset + part.length).contains(&at))
    };
    assert!((0..5000).all(|from| is_in(200 * from)));
}

#[test]
fn a_profile_is_being_calculated_until_it_is_settled() {
    let tag = |name: &str, template, elements| PlainTag::new(name, TagType::array(template, elements));
    let tags = [
        tag("Cam", predefined::cam(), 2),
        tag("Curve", predefined::cam_profile(), 3),
    ];
    let mut image = Image::new(&machine(), &[], &tags);
    let wrote = image.write_value(&path("Cam[1].Master"), Value::Real(5.0));
    assert_eq!(wrote, Ok(None));
    let name = |name: &str| UnboundOperand::Name(name.to_owned());
    let operands = [
        name("Cam"),
        UnboundOperand::Integer(2),
        UnboundOperand::Integer(0),
        UnboundOperand::Integer(0),
        name("Curve"),
    ];
    let call = bind(Mnemonic::Mccp, None, UNNAMED, &operands, &image).expect("it binds");
    let status = |image: &Image| number(image, "Curve[0].Status");

    let (data, staged) = image.prepare(&call);
    assert!(matches!(data, Some(CallData::Done)));
    assert_eq!(status(&image), 1.0);
    let (again, nothing) = image.prepare(&call);
    let refused = MotionError::CamProfileBeingCalculated;
    assert!(matches!(again, Some(CallData::Refused { error, .. }) if error == refused) && nothing.is_none());
    image.settle(
        staged.expect("a profile"),
        &MotionControl::refused(MotionError::ExecutionCollision),
    );
    assert_eq!(status(&image), 0.0, "not done: nothing was there before");

    let (_, staged) = image.prepare(&call);
    let mut done = MotionControl::default();
    done.set(Flag::Dn);
    image.settle(staged.expect("a profile"), &done);
    assert_eq!(
        (
            status(&image),
            number(&image, "Curve[1].Status"),
            number(&image, "Curve[2].Status")
        ),
        (2.0, 2.0, 0.0)
    );
    let (_, staged) = image.prepare(&call);
    image.settle(
        staged.expect("a profile"),
        &MotionControl::refused(MotionError::ExecutionCollision),
    );
    assert_eq!(status(&image), 2.0, "not done: what was there is there still");

    // Two cams use the profile; when their owners free it, it is unused.
    let operands = [
        name("V"),
        UnboundOperand::Integer(0),
        name("Curve"),
        UnboundOperand::Integer(1),
        UnboundOperand::Integer(1),
    ];
    let call = bind(Mnemonic::Mapc, Some(0), UNNAMED, &operands, &image).expect("it binds");
    let cams = [image.prepare(&call).0, image.prepare(&call).0];
    // A copy for readers does not count as a use.
    let published = image.clone();
    image.show_uses();
    assert_eq!(status(&image), 4.0);
    drop(cams);
    image.show_uses();
    assert_eq!(status(&image), 2.0);
    drop(published);
}

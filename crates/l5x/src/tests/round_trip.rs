//! An export imports as the same project.

use std::fmt::Write as _;

use proptest::prelude::*;

use crate::{export, import};

fn check(config: &str) -> Result<(), TestCaseError> {
    let project = arcline_config::load(config, "test").expect("a configuration that holds");
    let again = arcline_config::format(&arcline_config::table(&project));
    let again = arcline_config::load(&again, "written").expect("what is written can be read");
    prop_assert_eq!(&project, &again);
    let l5x = export(&project);
    match import(&l5x, "exported.L5X") {
        Ok(import) => {
            prop_assert_eq!(&import.project, &project, "{}", l5x);
            prop_assert!(import.report.is_empty(), "{}", import.report);
        }
        Err(error) => prop_assert!(false, "{error}\n{l5x}"),
    }
    Ok(())
}

#[test]
fn the_default_configuration() {
    check(arcline_config::DEFAULT).expect("the same project");
}

#[test]
fn an_export_lists_the_keys_that_l5x_cannot_hold() {
    let config = r#"
        [server]
        name = "<A & 'B' \"C\">"
        listen = "[::1]:0"
        hmi = "off"
        io = "off"
        io_loss = "finish"
        [motion_group]
        name = "Group"
        coarse_update_period_ms = 0.2501
        [[axis]]
        name = "X"
        type = "servo"
        units = "µm & \"<>\""
        max_speed = 0.1
        max_acceleration = 1e-7
        max_deceleration = 0
        max_deceleration_jerk = 0
        start = { position = 3.5, servo_on = false, homed = false }
        travel = { min = -1.5, max = 1e300 }
        drive = { position_bandwidth_hz = 33.3, velocity_feedforward = 0.07, speed_limit = 5.0, encoder_resolution = 7.0 }
        home = { sequence = "switch-marker", direction = "unidirectional-reverse", speed = 3.0, switch = { max = 2.0 }, marker = { at = 1.0, every = 2.0 } }
        exception_actions = { position_error = "ignore", soft_travel_positive = "shutdown", overcurrent = "alarm" }
        [[axis]]
        name = "V"
        type = "virtual"
        max_speed = 10.0
        dynamics_configuration_bits = 0
        max_acceleration = 10.0
        unwind = 6.283185307179586
        home = { sequence = "marker", speed = 2.0, return_speed = 1.0 }
        exception_actions = { soft_travel_negative = "fault_status_only" }
        average_velocity_timebase = 1.0
        programmed_stop_mode = "hard_shutdown"
        [[axis]]
        name = "W"
        type = "virtual"
        max_speed = 10.0
        max_acceleration = 10.0
        travel = { min = 0, max = 1 }
        [[coordinate_system]]
        name = "CS1"
        axes = ["X", "V"]
        max_speed = 10.0
        max_acceleration = 10.0
        queue_depth = 1000
        corner = "precise"
        deviation = "anywhere"
        axis_limits = "enforce"
        actual_tolerance = 0.01
        [[coordinate_system]]
        name = "CS2"
        axes = ["V"]
        max_speed = 10.0
        dynamics_configuration_bits = 5
        max_acceleration = 10.0
        [[coordinate_system]]
        name = "Robot"
        type = "scara_delta"
        axes = ["X", "V", "W"]
        max_speed = 10.0
        max_acceleration = 10.0
        link_lengths = [120.5, 260.25]
        base_offsets = [60.0, 0.0, 0.1]
        end_effector_offsets = [20.0, 0.0, -30.0]
        zero_angles = [-10.0, 5.0, 0.0]
        joint_limits = "enforce"
        [[coordinate_system]]
        name = "Wrist"
        type = "delta"
        definition = "J1J2J6"
        axes = ["X", "V", "W"]
        max_speed = 10.0
        max_acceleration = 10.0
        link_lengths = [120.5, 260.25]
        zero_angles = [-10.0, 5.0, 7.0]
        [[transform]]
        name = "T"
        source = "CS1"
        target = "CS2"
        [[instruction]]
        tag = "Go"
        type = "MCLM"
        target = "CS1"
        [[data_type]]
        name = "Bits"
        members = [{ name = "A", type = "BOOL" }, { name = "B", type = "BOOL" }, { name = "N", type = "SINT" },
            { name = "C", type = "BOOL" }, { name = "Many", type = "BOOL[64]" }]
        [[data_type]]
        name = "Unused"
        members = [{ name = "Text", type = "STRING[2]" }, { name = "Inner", type = "Bits[2]" }]
        [[tag]]
        name = "Z"
        type = "Unused[2]"
        value = [{ Text = ["", "$'\n\u0001é"], Inner = [{ A = true, N = -1 }, { Many = [true, false, true] }] }, { }]
        [[tag]]
        name = "P1"
        program = "Main"
        type = "DINT[2,3]"
        value = [[1, 2, 3], [-4, 5, 2147483647]]
        [[tag]]
        name = "Y"
        type = "LREAL[2]"
        access = "read_only"
        value = [1e300, -0.0]
        [[tag]]
        name = "Infinite"
        type = "REAL[3]"
        value = [inf, -inf, 0.1]
        [[tag]]
        name = "A1"
        program = "MAIN"
        alias = "P1[1,2]"
        [[tag]]
        name = "A2"
        alias = "Z[0].Inner[1].Many[1]"
        [[data_type]]
        name = "Step"
        members = [{ name = "Dwell", type = "TIMER" }, { name = "Place", type = "POSITION_DATA" }]
        [[tag]]
        name = "Step"
        type = "Step"
        value = { Dwell = { PRE = 5, TT = true }, Place = { Rz = 90.0 } }
        [[tag]]
        name = "Parts"
        type = "COUNTER[2]"
        value = [{ PRE = 7, CU = true, UN = true }, { ACC = -7 }]
        [[tag]]
        name = "Find"
        type = "CONTROL"
        value = { LEN = 10, FD = true, EN = true }
        [[tag]]
        name = "Wide"
        type = "ULINT[2]"
        value = [0, 9223372036854775807]
        [[tag]]
        name = "Points"
        type = "CAM[2]"
        value = [{ Master = 0.0, Slave = 1.0, SegmentType = 1 }, { Master = 2.0 }]
        [[tag]]
        name = "Edges"
        type = "OUTPUT_CAM[2]"
        [[tag]]
        name = "A3"
        program = "Other"
        alias = "Y[0]"
    "#;
    check(config).expect("the same project");
}

/// A unique name, and a value for a type.
fn scalar_value(kind: usize) -> BoxedStrategy<String> {
    match kind {
        0 => any::<bool>().prop_map(|on| on.to_string()).boxed(),
        1 => any::<i8>().prop_map(|n| n.to_string()).boxed(),
        2 => any::<i16>().prop_map(|n| n.to_string()).boxed(),
        3 => any::<i32>().prop_map(|n| n.to_string()).boxed(),
        4 => any::<i64>().prop_map(|n| n.to_string()).boxed(),
        5 => any::<u8>().prop_map(|n| n.to_string()).boxed(),
        6 => any::<u16>().prop_map(|n| n.to_string()).boxed(),
        7 => any::<u32>().prop_map(|n| n.to_string()).boxed(),
        8 => any::<f32>()
            .prop_filter("finite", |x| x.is_finite())
            .prop_map(|x| format!("{x:?}"))
            .boxed(),
        9 => any::<f64>()
            .prop_filter("finite", |x| x.is_finite())
            .prop_map(|x| format!("{x:?}"))
            .boxed(),
        10 => (0..=i64::MAX).prop_map(|n| n.to_string()).boxed(),
        _ => "[ -~äß]{0,20}"
            .prop_map(|text| toml::Value::String(text).to_string())
            .boxed(),
    }
}

const WORDS: [&str; 12] = [
    "BOOL", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "REAL", "LREAL", "ULINT", "STRING",
];

fn tag(place: usize) -> impl Strategy<Value = String> {
    let shape = (0..WORDS.len(), 0..4usize, any::<bool>(), prop::option::of(0..3u8));
    shape.prop_flat_map(move |(kind, length, read_only, program)| {
        let values = prop::collection::vec(scalar_value(kind), length.max(1));
        values.prop_map(move |values| {
            let (word, value) = match length {
                0 => (WORDS[kind].to_owned(), values.concat()),
                length => (format!("{}[{length}]", WORDS[kind]), format!("[{}]", values.join(", "))),
            };
            let mut text = format!("[[tag]]\nname = \"Tag{place}\"\ntype = \"{word}\"\nvalue = {value}\n");
            if let Some(program) = program {
                let _ = writeln!(text, "program = \"Program{program}\"");
            }
            if read_only {
                text.push_str("access = \"read_only\"\n");
            }
            text
        })
    })
}

fn axis(place: usize) -> impl Strategy<Value = String> {
    let positive = || (1e-6..1e6f64).prop_map(|x| format!("{x:?}"));
    let shape = (
        any::<bool>(),
        positive(),
        positive(),
        prop::option::of(positive()),
        prop::option::of(positive()),
        0..4u8,
    );
    shape.prop_map(move |(servo, speed, rate, jerk, turn, home)| {
        let kind = if servo { "servo" } else { "virtual" };
        let mut text = format!(
            "[[axis]]\nname = \"Axis{place}\"\ntype = \"{kind}\"\nmax_speed = {speed}\nmax_acceleration = {rate}\n"
        );
        for (key, number) in [("max_acceleration_jerk", jerk), ("unwind", turn)] {
            if let Some(number) = number {
                let _ = writeln!(text, "{key} = {number}");
            }
        }
        text.push_str(match home {
            0 => "",
            1 => "home = { sequence = \"marker\", speed = 4.0, offset = -1.5 }\n",
            2 => "home = { mode = \"passive\", sequence = \"switch\" }\nstart = { homed = false }\n",
            _ => "programmed_stop_mode = \"fast_disable\"\n",
        });
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.div_ceil(4)))]

    #[test]
    fn random_projects(
        axes in (0..6usize).prop_flat_map(|count| (0..count).map(axis).collect::<Vec<_>>()),
        tags in (0..8usize).prop_flat_map(|count| (0..count).map(tag).collect::<Vec<_>>()),
    ) {
        let mut config = axes.concat();
        for (place, _) in axes.iter().enumerate().step_by(2) {
            let _ = writeln!(
                config,
                "[[coordinate_system]]\nname = \"CS{place}\"\naxes = [\"Axis{place}\"]\nmax_speed = 1.0\n\
                 max_acceleration = {}.5\nqueue_depth = {}", place + 1, place + 1
            );
        }
        config.push_str(&tags.concat());
        check(&config)?;
    }

    /// No text makes the importer panic, and every accepted file can be exported again.
    #[test]
    fn damaged_files(at in 0..4000usize, with in "[<>/=\"'&#a-zA-Z0-9\\[\\], ]{0,8}", cut in 0..20usize) {
        let project = arcline_config::load(arcline_config::DEFAULT, "").expect("the default holds");
        let mut text = export(&project);
        let at = at % text.len();
        text.replace_range(at..(at + cut).min(text.len()), &with);
        if let Ok(import) = import(&text, "damaged.L5X") {
            let _ = export(&import.project);
        }
    }
}

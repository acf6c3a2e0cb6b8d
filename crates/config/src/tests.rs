//! Texts in, projects and errors out.

use arcline_controller::image::{Image, Writers};
use arcline_controller::machine::{
    AxisKind, Corner, Deviation, Geometry, Home, HomeDirection, HomeInputs, HomeMode, HomeSequence, HomeSwitch,
    KinematicStructure, LimitPolicy, Orientation, PositionErrorLimit, Sensor, Settings, SimulatedDrive, StartState,
    Travel, Wrist,
};
use arcline_instruction_set::{AxisId, ExceptionAction, FAULTS, Mnemonic, SystemId};

use arcline_tag::Value;

use crate::keys::{COORDINATE_SYSTEM, Default, EXCEPTION_ACTIONS, Keys, Kind};
mod keys;

use crate::{AllowList, DEFAULT, PlainAccess, describe, format as format_table, load, table};

#[test]
fn the_default_is_that_of_the_contract() {
    let project = load(DEFAULT, "default.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(project.server.name, "Arcline demo");
    assert_eq!(project.server.listen.to_string(), "127.0.0.1:44818");
    assert_eq!(
        project.server.hmi.map(|hmi| hmi.to_string()).as_deref(),
        Some("127.0.0.1:8080")
    );

    let machine = &project.machine;
    assert_eq!((machine.group.as_str(), machine.period_ns), ("Motion", 1_000_000));
    let axes: Vec<_> = machine.axes.iter().map(|axis| axis.name.as_str()).collect();
    assert_eq!(axes, ["X", "Y", "Z", "S", "A", "B", "C"]);
    for (place, axis) in machine.axes.iter().enumerate() {
        let expected = if place < 4 {
            (
                AxisKind::Servo,
                PositionErrorLimit::default(),
                Some(SimulatedDrive::default()),
            )
        } else {
            (AxisKind::Virtual, PositionErrorLimit::OFF, None)
        };
        let found = (axis.kind, axis.position_error, machine.drives[place]);
        assert_eq!(found, expected, "{}", axis.name);
        assert_eq!(axis.units, "mm");
        assert_eq!(
            (axis.max_speed, axis.max_acceleration, axis.max_deceleration),
            (1000.0, 10000.0, 10000.0)
        );
        assert_eq!(
            (axis.max_acceleration_jerk, axis.max_deceleration_jerk),
            (200_000.0, 200_000.0)
        );
        assert_eq!((axis.travel, axis.unwind), (None, None));
        assert_eq!(axis.home, Home::immediate(10000.0, 10000.0));
        assert_eq!(
            axis.start,
            StartState {
                position: 0.0,
                servo_on: true,
                homed: true,
                ..StartState::default()
            }
        );
    }
    let systems: Vec<_> = machine
        .systems
        .iter()
        .map(|system| (system.name.as_str(), system.axes.as_slice()))
        .collect();
    let expected: [(&str, &[AxisId]); 4] = [
        ("CS1", &[0, 1, 2].map(AxisId)),
        ("CS2", &[0, 1, 3].map(AxisId)),
        ("CS3", &[4, 5, 6].map(AxisId)),
        ("XY", &[0, 1].map(AxisId)),
    ];
    assert_eq!(systems, expected);
    for system in &machine.systems {
        assert_eq!(
            (system.max_speed, system.max_acceleration, system.max_deceleration),
            (500.0, 5000.0, 5000.0)
        );
        assert_eq!(
            (system.max_acceleration_jerk, system.max_deceleration_jerk),
            (100_000.0, 100_000.0)
        );
        assert_eq!(
            (system.actual_tolerance, system.command_tolerance, system.queue_depth),
            (0.01, 0.5, 1)
        );
        assert_eq!(
            (system.corner, system.axis_limits),
            (Corner::Logix, LimitPolicy::Ignore)
        );
        assert_eq!(system.deviation, Deviation::Corners);
    }
    let transforms: Vec<_> = machine
        .transforms
        .iter()
        .map(|t| (t.name.as_str(), t.source, t.target))
        .collect();
    assert_eq!(transforms, [("T1", SystemId(1), SystemId(2))]);
    let tags: Vec<_> = project
        .instruction_tags
        .iter()
        .map(|tag| (tag.name.as_str(), tag.mnemonic, tag.target.as_str()))
        .collect();
    let expected = [
        ("Move1", Mnemonic::Mclm, "CS1"),
        ("Move2", Mnemonic::Mclm, "CS1"),
        ("Move3", Mnemonic::Mclm, "CS1"),
        ("Arc1", Mnemonic::Mccm, "XY"),
        ("Arc2", Mnemonic::Mccm, "XY"),
        ("Change1", Mnemonic::Mccd, "CS1"),
        ("Stop1", Mnemonic::Mcs, "CS1"),
    ];
    assert_eq!(tags, expected);
    assert!(project.tags.is_empty());
}

const AXIS: &str = "[[axis]]\nname = \"X\"\ntype = \"servo\"\nmax_speed = 10\nmax_acceleration = 100\n";
const TURN: &str = "[[axis]]\nname = \"R\"\ntype = \"virtual\"\nmax_speed = 10\nmax_acceleration = 100\nunwind = 360\n";
const TURNTABLE: &str =
    "[[axis]]\nname = \"X\"\ntype = \"servo\"\nmax_speed = 10\nmax_acceleration = 100\nunwind = 360\n";
const SYSTEM: &str = "[[coordinate_system]]\nname = \"CS\"\naxes = [\"x\"]\nmax_speed = 5\nmax_acceleration = 50\n";

#[test]
fn everything_has_its_default() {
    let text = format!("{AXIS}{SYSTEM}");
    let project = load(&text, "m.toml").unwrap_or_else(|error| panic!("{error}"));
    let axis = &project.machine.axes[0];
    assert_eq!(axis.units, "Position Units");
    assert_eq!(axis.max_deceleration, 100.0);
    // rate² / speed
    assert_eq!(
        (axis.max_acceleration_jerk, axis.max_deceleration_jerk),
        (1000.0, 1000.0)
    );
    assert_eq!(axis.kind, AxisKind::Servo);
    assert_eq!(project.machine.drives[0], Some(SimulatedDrive::default()));
    let system = &project.machine.systems[0];
    assert_eq!((system.axes.as_slice(), system.queue_depth), (&[AxisId(0)][..], 1));
    assert_eq!((system.actual_tolerance, system.command_tolerance), (0.0, 0.0));
    assert_eq!(
        (project.machine.period_ns, project.machine.group.as_str()),
        (1_000_000, "Motion")
    );
    assert_eq!(project.server, crate::ServerConfig::default());
    assert!(load("", "empty.toml").is_ok(), "an empty file is an empty machine");
}

#[test]
fn everything_can_be_said() {
    let text = format!(
        "[server]\nlisten = \"0.0.0.0:0\"\nhmi = \"off\"\n[motion_group]\nname = \"G\"\n\
         coarse_update_period_ms = 0.25\n{AXIS}max_deceleration = 0\nmax_deceleration_jerk = 0.0\n\
         travel = {{ min = -5, max = 15.5 }}\nstart = {{ position = 1.5, servo_on = false, homed = false }}\n\
         drive = {{ position_bandwidth_hz = 10, velocity_feedforward = 0.5, position_error_tolerance = 0,\
         position_error_tolerance_time = 0.02, speed_limit = 12, torque_limit = 150, encoder_resolution = 1000 }}\n{TURN}\
         start.position = 359.5\n{SYSTEM}queue_depth = 1000\ncorner = \"Precise\"\ndeviation = \"anywhere\"\naxis_limits = \"enforce\"\n\
         [[coordinate_system]]\nname = \"CS2\"\ntype = \"cartesian\"\naxes = [\"R\"]\nmax_speed = 1\n\
         max_acceleration = 1\n[[transform]]\nname = \"T\"\nsource = \"CS\"\ntarget = \"cs2\"\n\
         [[instruction]]\ntag = \"On\"\ntype = \"mso\"\ntarget = \"x\"\n[[instruction]]\ntag = \"Halt\"\ntype = \"MGS\"\n\
         [[tag]]\nname = \"Recipe\"\ntype = \"REAL[16]\"\n[[tag]]\nname = \"Texts\"\ntype = \"string [ 4 ]\"\n\
         [[tag]]\nname = \"Count\"\ntype = \"DINT\"\n[[tag]]\nname = \"Bits\"\ntype = \"BOOL[40]\"\n"
    );
    let project = load(&text, "m.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(project.server.hmi, None);
    assert_eq!(project.machine.period_ns, 250_000);
    let axis = &project.machine.axes[0];
    assert_eq!((axis.max_deceleration, axis.max_deceleration_jerk), (0.0, 0.0));
    assert_eq!(axis.travel, Some(Travel { min: -5.0, max: 15.5 }));
    assert_eq!(
        axis.start,
        StartState {
            position: 1.5,
            servo_on: false,
            homed: false,
            ..StartState::default()
        }
    );
    let settings = Settings {
        bandwidth: 10.0,
        feedforward: 0.5,
        speed_limit: 12.0,
        torque_limit: 150.0,
        encoder_resolution: Some(1000.0),
    };
    let drive = project.machine.drives[0].expect("a servo has a drive");
    assert_eq!(drive.settings, settings);
    assert_eq!(drive.sensor.stops, Some([-5.0, 15.5]));
    let position_error = PositionErrorLimit {
        tolerance: 0.0,
        time: 0.02,
    };
    assert_eq!(axis.position_error, position_error);
    assert_eq!(
        (project.machine.axes[1].unwind, project.machine.axes[1].start.position),
        (Some(360.0), 359.5)
    );
    let system = &project.machine.systems[0];
    assert_eq!(
        (system.queue_depth, system.corner, system.deviation, system.axis_limits),
        (1000, Corner::Precise, Deviation::Anywhere, LimitPolicy::Enforce)
    );
    assert_eq!(
        (
            project.machine.transforms[0].source,
            project.machine.transforms[0].target
        ),
        (SystemId(0), SystemId(1))
    );
    assert_eq!(project.instruction_tags[0].target, "X");
    assert_eq!(project.instruction_tags[1].target, "G");
    assert_eq!(project.tags[0].tag_type.size(), 64);
    assert_eq!(project.tags[1].tag_type.size(), 4 * 88);
    // 40 bits need two DWORDs.
    assert_eq!(project.tags[3].tag_type.size(), 8);

    let described = describe(&project);
    for part in [
        "axis X: servo",
        "travel -5 to 15.5",
        "servo off, not homed",
        "rotary, 360",
        "transform T: CS to CS2",
        "instruction tag On: MSO on X",
        "tag Recipe: REAL[16]",
        "HMI off",
        "precise corners",
        "tag Count: DINT\n",
    ] {
        assert!(described.contains(part), "{part} in\n{described}");
    }
}

#[test]
fn homing_can_be_said() {
    let full = Home {
        mode: HomeMode::Passive,
        sequence: HomeSequence::SwitchMarker,
        direction: HomeDirection::UnidirectionalReverse,
        position: 5.0,
        offset: -2.0,
        speed: 8.0,
        return_speed: 3.0,
        acceleration: 60.0,
        deceleration: 70.0,
        inputs: HomeInputs::default(),
    };
    let standing = Home::immediate(100.0, 100.0);
    let moving = Home {
        sequence: HomeSequence::Switch,
        speed: 8.0,
        return_speed: 8.0,
        ..Home::immediate(100.0, 100.0)
    };
    let switch = |min, max| Sensor {
        switch: Some([min, max]),
        ..Sensor::default()
    };
    let marker = |every| Sensor {
        marker: Some((0.0, every)),
        ..Sensor::default()
    };
    let both = Sensor {
        switch: Some([-1.0, 1.5]),
        marker: Some((0.25, Some(2.0))),
        ..Sensor::default()
    };
    let infinity = f64::INFINITY;
    let (forward, reverse, two) = (HomeSwitch::Forward, HomeSwitch::Reverse, HomeSwitch::Both);
    #[rustfmt::skip]
    let cases = [
        // why,                    of the axis,       keys of home,  homing,   sensor,  the edges of its switch
        ("nothing",                AXIS,              "",            standing, Sensor::default(), None),
        ("everything",             AXIS,
            "mode = \"passive\", sequence = \"Switch-Marker\", direction = \"unidirectional-reverse\", position = 5, \
             offset = -2, speed = 8, return_speed = 3, acceleration = 60, deceleration = 70, \
             switch = { min = -1, max = 1.5 }, marker = { at = 0.25, every = 2 }", full, both, Some(two)),
        ("no input",               AXIS,              "sequence = \"switch\", speed = 8", moving, Sensor::default(), None),
        ("the usual switch",       AXIS,              "sequence = \"switch\", speed = 8, switch = {}", moving, switch(0.0, infinity), Some(forward)),
        ("a switch up to",         AXIS,              "sequence = \"switch\", speed = 8, switch = { max = 3 }", moving, switch(-infinity, 3.0), Some(reverse)),
        ("the only marker",        AXIS,              "marker = {}", standing, marker(None), None),
        ("a marker a turn",        TURNTABLE,         "marker = {}", standing, marker(Some(360.0)), None),
        ("a switch across 0",      TURNTABLE,         "switch = { min = 350, max = 10 }", standing, switch(350.0, 10.0), Some(two)),
    ];
    for (why, axis, keys, homing, sensor, switch) in cases {
        let text = format!("{axis}home = {{ {keys} }}\n");
        let project = load(&text, "m.toml").unwrap_or_else(|error| panic!("{why}: {error}"));
        let (axis, drive) = (&project.machine.axes[0], project.machine.drives[0]);
        let sensor = Sensor {
            turn: axis.unwind,
            ..sensor
        };
        assert_eq!(drive.map(|drive| drive.sensor), Some(sensor), "{why}");
        let inputs = HomeInputs {
            switch,
            marker: sensor.marker.is_some(),
            stops: false,
        };
        assert_eq!(axis.home, Home { inputs, ..homing }, "{why}");
    }
    let text = format!("{AXIS}home = {{ sequence = \"marker\", speed = 1, marker = {{}} }}\n");
    let project = load(&text, "m.toml").unwrap_or_else(|error| panic!("{error}"));
    assert!(
        describe(&project).contains(", homes on a marker\n"),
        "{}",
        describe(&project)
    );
}

#[test]
fn errors_name_place_key_and_expectation() {
    let two = format!("{AXIS}{TURN}");
    let base = format!("{two}{SYSTEM}");
    let lines = base.lines().count();
    #[rustfmt::skip]
    let cases: Vec<(&str, String, String)> = vec![
        ("not TOML", "[server".into(), "m.toml:1:8: not valid TOML".into()),
        ("twice the same key", "[server]\nname = \"a\"\nname = \"b\"".into(), "m.toml:3:1: not valid TOML".into()),
        ("an unknown section", "[[axes]]\nname = \"X\"".into(), "m.toml:1:3: axes: unknown key (did you mean `axis`?)".into()),
        ("an unknown key", format!("{AXIS}max_sped = 5\n"), "m.toml:6:1: axis[1].max_sped: unknown key (did you mean `max_speed`?)".into()),
        ("an unknown key within", format!("{AXIS}start = {{ hommed = true }}\n"), "m.toml:6:11: axis[1].start.hommed: unknown key (did you mean `homed`?)".into()),
        ("the wrong type", "[server]\nname = 5".into(), "m.toml:2:8: server.name: found 5, expected 1 to 32 printable ASCII characters".into()),
        ("a table that is none", "server = 5".into(), "m.toml:1:10: server: found 5, expected a table, [server]".into()),
        ("a list that is none", "axis = 5".into(), "m.toml:1:8: axis: found 5, expected tables, [[axis]]".into()),
        ("a single table", "[axis]\nname = \"X\"".into(), "m.toml:1:1: axis: found".into()),
        ("no address", "[server]\nlisten = \"localhost\"".into(), "m.toml:2:10: server.listen: found \"localhost\", expected an address and port".into()),
        ("no address either", "[server]\nhmi = \"no\"".into(), "m.toml:2:7: server.hmi: found \"no\", expected an address and port".into()),
        ("a period too short", "[motion_group]\ncoarse_update_period_ms = 0.2".into(), "m.toml:2:27: motion_group.coarse_update_period_ms: found 0.2, expected a number from 0.25 to 32 (ms)".into()),
        ("a period too long", "[motion_group]\ncoarse_update_period_ms = 33".into(), "m.toml:2:27: motion_group.coarse_update_period_ms: found 33, expected".into()),
        ("not a number", "[motion_group]\ncoarse_update_period_ms = nan".into(), "m.toml:2:27: motion_group.coarse_update_period_ms: found nan, expected".into()),
        ("no name", "[[axis]]\ntype = \"servo\"".into(), "m.toml:1:1: axis[1].name: missing, expected a name".into()),
        ("a name that is none", AXIS.replace("\"X\"", "\"1X\""), "m.toml:2:8: axis[1].name: found \"1X\", expected a name: 1 to 40 letters".into()),
        ("a name too long", AXIS.replace("\"X\"", &format!("\"{}\"", "X".repeat(41))), "m.toml:2:8: axis[1].name: found \"XXX".into()),
        ("the same name", format!("{AXIS}{}", AXIS.replace("\"X\"", "\"x\"")), "m.toml:7:8: axis[2].name: the name `x` is taken by line 2".into()),
        ("the name of another thing", format!("{AXIS}[[tag]]\nname = \"x\"\ntype = \"INT\""), "m.toml:7:8: tag[1].name: the name `x` is taken by line 2".into()),
        ("no type", "[[axis]]\nname = \"X\"".into(), "m.toml:1:1: axis[1].type: missing, expected \"servo\", \"virtual\" or \"feedback\"".into()),
        ("another type", AXIS.replace("servo", "serov"), "m.toml:3:8: axis[1].type: found \"serov\" (did you mean `servo`?), expected \"servo\", \"virtual\" or \"feedback\"".into()),
        ("no speed", "[[axis]]\nname = \"X\"\ntype = \"servo\"".into(), "m.toml:1:1: axis[1].max_speed: missing, expected a number above 0 (units/s)".into()),
        ("a speed that is none", AXIS.replace("= 10\n", "= \"fast\"\n"), "m.toml:4:13: axis[1].max_speed: found \"fast\", expected a number above 0 (units/s)".into()),
        ("speed zero", AXIS.replace("= 10\n", "= 0\n"), "m.toml:4:13: axis[1].max_speed: found 0, expected a number above 0".into()),
        ("a deceleration below zero", format!("{AXIS}max_deceleration = -1"), "m.toml:6:20: axis[1].max_deceleration: found -1, expected a number, 0 or more (units/s²)".into()),
        ("travel the wrong way round", format!("{AXIS}travel = {{ min = 5, max = 5 }}"), "m.toml:6:27: axis[1].travel.max: found 5, expected a number above `min`".into()),
        ("half a travel", format!("{AXIS}travel = {{ min = 5 }}"), "m.toml:6:10: axis[1].travel.max: missing".into()),
        ("a rotary axis has no travel", format!("{AXIS}unwind = 360\ntravel = {{ min = 1, max = 5 }}"), "m.toml:7:10: axis[1].travel: cannot stand together with `unwind`".into()),
        ("a start beyond the turn", format!("{TURN}start = {{ position = 360 }}"), "m.toml:7:22: axis[1].start.position: found 360, expected a number from 0 to below `unwind`".into()),
        ("a virtual axis has no drive", format!("{TURN}drive = {{ position_bandwidth_hz = 40 }}"), "m.toml:7:9: axis[1].drive: cannot stand together with `type = \"virtual\"`".into()),
        ("an error for less than no time", format!("{AXIS}drive = {{ position_error_tolerance_time = -1 }}"), "m.toml:6:43: axis[1].drive.position_error_tolerance_time: found -1, expected a number, 0 or more (s)".into()),
        ("a motor that cannot turn", format!("{AXIS}drive = {{ speed_limit = 0 }}"), "m.toml:6:25: axis[1].drive.speed_limit: found 0, expected a number above 0 (units/s)".into()),
        ("a motor without torque", format!("{AXIS}drive = {{ torque_limit = 0 }}"), "m.toml:6:26: axis[1].drive.torque_limit: found 0, expected a number above 0 (units/s²)".into()),
        ("an encoder without counts", format!("{AXIS}drive = {{ encoder_resolution = 0 }}"), "m.toml:6:32: axis[1].drive.encoder_resolution: found 0, expected a number above 0 (counts per position unit)".into()),
        ("a flag that is none", format!("{AXIS}start = {{ homed = 1 }}"), "m.toml:6:19: axis[1].start.homed: found 1, expected true or false".into()),
        ("homing without a speed", format!("{AXIS}home = {{ sequence = \"switch\" }}"), "m.toml:6:8: axis[1].home.speed: missing, expected a number above 0 (units/s)".into()),
        ("a sequence that is none", format!("{AXIS}home = {{ sequence = \"swich\" }}"), "m.toml:6:21: axis[1].home.sequence: found \"swich\" (did you mean `switch`?), expected \"immediate\"".into()),
        ("a direction that is none", format!("{AXIS}home = {{ direction = \"forward\" }}"), "m.toml:6:22: axis[1].home.direction: found \"forward\"".into()),
        ("a mode that is none", format!("{AXIS}home = {{ mode = 1 }}"), "m.toml:6:17: axis[1].home.mode: found 1, expected \"active\" or \"passive\"".into()),
        ("a home position beyond the turn", format!("{TURN}home = {{ position = 360 }}"), "m.toml:7:21: axis[1].home.position: found 360, expected a number from 0 to below `unwind`".into()),
        ("a switch the wrong way round", format!("{AXIS}home = {{ switch = {{ min = 5, max = 4 }} }}"), "m.toml:6:36: axis[1].home.switch.max: found 4, expected a number above `min`".into()),
        ("half a switch of a turntable", format!("{TURNTABLE}home = {{ switch = {{ min = 5 }} }}"), "m.toml:7:19: axis[1].home.switch.max: missing, expected a finite number".into()),
        ("a switch beyond the turn", format!("{TURNTABLE}home = {{ switch = {{ min = 5, max = 400 }} }}"), "m.toml:7:36: axis[1].home.switch.max: found 400, expected a number from 0 to below `unwind`".into()),
        ("a switch of no width", format!("{TURNTABLE}home = {{ switch = {{ min = 5, max = 5 }} }}"), "m.toml:7:36: axis[1].home.switch.max: found 5, expected another number than `min`".into()),
        ("markers on top of each other", format!("{AXIS}home = {{ marker = {{ every = 0 }} }}"), "m.toml:6:29: axis[1].home.marker.every: found 0, expected a number above 0".into()),
        ("a sensor of a virtual axis", format!("{TURN}home = {{ marker = {{}} }}"), "m.toml:7:19: axis[1].home.marker: cannot stand together with `type = \"virtual\"`".into()),
        ("no such axis", SYSTEM.replace("\"x\"", "\"y\""), "m.toml:3:9: coordinate_system[1].axes[1]: there is no axis `y`".into()),
        ("an axis twice", format!("{AXIS}{}", SYSTEM.replace("[\"x\"]", "[\"x\", \"X\"]")), "m.toml:8:14: coordinate_system[1].axes[2]: found \"X\", expected each axis once".into()),
        ("no axes", format!("{AXIS}{}", SYSTEM.replace("[\"x\"]", "[]")), "m.toml:8:8: coordinate_system[1].axes: found [], expected a list of 1 to 3 names of axes".into()),
        ("four axes", format!("{AXIS}{}", SYSTEM.replace("[\"x\"]", "[\"x\", \"y\", \"z\", \"u\"]")), "m.toml:8:8: coordinate_system[1].axes: found".into()),
        ("another geometry", format!("{AXIS}{SYSTEM}type = \"hexapod\""), "m.toml:11:8: coordinate_system[1].type: found \"hexapod\", expected \"cartesian\", \"articulated_independent\"".into()),
        ("a robot without its joints", format!("{AXIS}{SYSTEM}type = \"delta\""), "m.toml:8:8: coordinate_system[1].axes: found [\"x\"], expected as many axes as the geometry has joints".into()),
        ("links of no robot", format!("{AXIS}{SYSTEM}link_lengths = [1, 2]"), "m.toml:11:16: coordinate_system[1].link_lengths: found [1, 2], expected no such key".into()),
        ("one link", format!("{AXIS}{SYSTEM}link_lengths = [1]"), "m.toml:11:16: coordinate_system[1].link_lengths: found [1], expected two numbers".into()),
        ("a definition that the type has not", format!("{AXIS}{SYSTEM}definition = \"J1J2J6\""), "m.toml:11:14: coordinate_system[1].definition: found \"J1J2J6\", expected a definition that the type has".into()),
        ("no such definition", format!("{AXIS}{SYSTEM}definition = \"XYZRxRyRx\""), "m.toml:11:14: coordinate_system[1].definition: found \"XYZRxRyRx\" (did you mean `XYZRxRyRz`?), expected \"XYZRxRyRz\", \"J1J2J6\"".into()),
        ("an orientation without its axes", format!("{AXIS}{SYSTEM}definition = \"xyzrxryrz\""), "m.toml:8:8: coordinate_system[1].axes: found [\"x\"], expected a list of 6 names of axes".into()),
        ("a turn of what does not turn", format!("{AXIS}{SYSTEM}max_orientation_speed = 1"), "m.toml:11:25: coordinate_system[1].max_orientation_speed: found 1, expected no such key: the coordinate system has no Rx, Ry, Rz".into()),
        ("too deep a queue", format!("{AXIS}{SYSTEM}queue_depth = 1001"), "m.toml:11:15: coordinate_system[1].queue_depth: found 1001, expected a whole number from 1 to 1000".into()),
        ("no such deviation", format!("{AXIS}{SYSTEM}deviation = \"all\""), "m.toml:11:13: coordinate_system[1].deviation: found \"all\", expected \"corners\" or \"anywhere\"".into()),
        ("no such corner", format!("{AXIS}{SYSTEM}corner = \"round\""), "m.toml:11:10: coordinate_system[1].corner: found \"round\", expected \"logix\" or \"precise\"".into()),
        ("no such system", format!("{base}[[transform]]\nname = \"T\"\nsource = \"CS\"\ntarget = \"CSS\""), format!("m.toml:{}:10: transform[1].target: there is no coordinate system `CSS` (did you mean `CS`?)", lines + 4)),
        ("onto itself", format!("{base}[[transform]]\nname = \"T\"\nsource = \"CS\"\ntarget = \"cs\""), format!("m.toml:{}:10: transform[1].target: found \"cs\", expected another coordinate system", lines + 4)),
        ("no such instruction", format!("{base}[[instruction]]\ntag = \"M\"\ntype = \"MCML\"\ntarget = \"CS\""), format!("m.toml:{}:8: instruction[1].type: found \"MCML\" (did you mean `MCLM`?)", lines + 3)),
        ("an axis for a system", format!("{base}[[instruction]]\ntag = \"M\"\ntype = \"MCLM\"\ntarget = \"X\""), format!("m.toml:{}:10: instruction[1].target: there is no coordinate system `X`", lines + 4)),
        ("no target", format!("{base}[[instruction]]\ntag = \"M\"\ntype = \"MCLM\""), format!("m.toml:{}:1: instruction[1].target: missing", lines + 1)),
        ("no such type", "[[tag]]\nname = \"a\"\ntype = \"REEL[5]\"".into(), "m.toml:3:8: tag[1].type: found \"REEL[5]\" (did you mean `REAL`?), expected BOOL".into()),
        ("an array of nothing", "[[tag]]\nname = \"a\"\ntype = \"REAL[0]\"".into(), "m.toml:3:8: tag[1].type: found \"REAL[0]\", expected BOOL".into()),
        ("a huge array", "[[tag]]\nname = \"a\"\ntype = \"REAL[99999999999]\"".into(), "m.toml:3:8: tag[1].type: found".into()),
        ("columns count characters", "server = { näme = 1 }".into(), "m.toml:1:12: server.n".into()),
    ];
    for (why, text, expected) in cases {
        let error = match load(&text, "m.toml") {
            Ok(_) => panic!("{why}: loads\n{text}"),
            Err(error) => error.to_string(),
        };
        let expected = expected.as_str();
        if why == "columns count characters" {
            // A bare key is ASCII: the TOML parser says so, at whatever place it stops.
            assert!(error.starts_with("m.toml:1:"), "{why}: {error}");
            continue;
        }
        assert!(
            error.starts_with(expected),
            "{why}:\n{text}\n   found {error}\nexpected {expected}"
        );
    }
}

#[test]
fn counts_are_bounded() {
    let axis = |n: usize| AXIS.replace("\"X\"", &format!("\"X{n}\""));
    let text: String = (0..257).map(axis).collect();
    let error = load(&text, "m.toml").expect_err("too many").to_string();
    assert!(
        error.contains("axis: found 257 of them, expected at most 256"),
        "{error}"
    );
    let text: String = (0..256).map(axis).collect();
    assert!(load(&text, "m.toml").is_ok());
}

/// A configuration with nothing but these tables.
fn tags(text: &str) -> Result<Vec<crate::PlainTag>, String> {
    load(text, "t.toml")
        .map(|project| project.tags)
        .map_err(|error| error.to_string())
}

#[test]
fn tags_have_structures_dimensions_scopes_and_first_values() {
    let tags = tags(
        r#"
        [[data_type]]
        name = "Point"
        members = [{ name = "At", type = "REAL[2]" }, { name = "Valid", type = "BOOL" }, { name = "Id", type = "SINT" }]
        [[data_type]]
        name = "Path"
        members = [{ name = "Name", type = "STRING" }, { name = "Points", type = "point[2]" }]
        [[tag]]
        name = "Grid"
        type = "INT[2,3]"
        value = [[1, 2, 3], [4, 5, -6]]
        [[tag]]
        name = "Route"
        type = "Path"
        value = { Name = "ab", Points = [{ At = [1, 2.5], Valid = true }, { Id = -1 }] }
        [[tag]]
        name = "Bits"
        type = "BOOL[40]"
        value = [true, false, true]
        [[tag]]
        name = "Route"
        program = "Main"
        type = "LINT"
        access = "read_only"
        value = -9223372036854775808
        [[tag]]
        name = "Last"
        alias = "Route.Points[1].Id"
    "#,
    )
    .expect("valid");
    let [grid, route, bits, inner, last] = tags.as_slice() else {
        panic!("{tags:?}")
    };
    assert_eq!((grid.tag_type.dimensions, grid.tag_type.size()), ([2, 3, 0], 12));
    assert_eq!(grid.first, [1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 250, 255]);
    // Name 88 bytes; a point: 8 of REALs, the host of Valid, Id, 2 of padding.
    assert_eq!(
        (route.tag_type.size(), route.first[..6].to_vec()),
        (88 + 2 * 12, b"\x02\0\0\0ab".to_vec())
    );
    assert_eq!(route.first[88..98], [0, 0, 128, 63, 0, 0, 32, 64, 1, 0]);
    assert_eq!(route.first[100 + 9], 255);
    assert_eq!((bits.tag_type.symbol_type(), bits.first[0]), (0x20D3, 0b101));
    assert_eq!((inner.program.as_deref(), inner.first[7]), (Some("Main"), 0x80));
    assert_eq!((last.tag_type.symbol_type(), last.tag_type.size()), (0x00C2, 1));
}

#[test]
fn a_tag_has_rules_for_its_writers() {
    let text = |rows: &str| format!("[[tag]]\nname = \"T\"\n{rows}\n");
    let project = load(
        &text("type = \"DINT[2]\"\nmin = -10\nmax = 20\nwrite_role = \"engineer\""),
        "t.toml",
    );
    let rule = project.unwrap_or_else(|error| panic!("{error}")).tags[0].rule;
    assert_eq!(rule.writers, Writers::Engineers);
    assert_eq!(rule.range.map(|range| (range.least, range.most)), Some((-10.0, 20.0)));
    #[rustfmt::skip]
    let cases = [
        ("no number",            "type = \"STRING\"\nmin = 1",                               "min"),
        ("a pattern of bits",    "type = \"BOOL\"\nmax = 1",                                 "max"),
        ("not whole",            "type = \"INT\"\nmax = 1.5",                                "max"),
        ("beyond the type",      "type = \"SINT\"\nmax = 200",                               "max"),
        ("the wrong way round",  "type = \"INT\"\nmin = 5\nmax = 4\nvalue = 5",             "max"),
        ("a first value beyond", "type = \"REAL[2]\"\nmax = 2.0\nvalue = [1, 3]",           "value"),
        ("zeros beyond",         "type = \"REAL\"\nmin = 2.0",                               "min"),
        ("no such role",         "type = \"INT\"\nwrite_role = \"viewer\"",                 "write_role"),
        ("nobody writes it",     "type = \"INT\"\naccess = \"read_only\"\nmin = 0",         "min"),
        ("a control tag",        "type = \"MOTION_INSTRUCTION\"\nwrite_role = \"engineer\"", "write_role"),
    ];
    for (why, rows, key) in cases {
        let error = load(&text(rows), "t.toml").expect_err(why).to_string();
        assert!(
            error.contains(&format!("tag[T].{key}")) || error.contains(key),
            "{why}: {error}"
        );
    }
    let alias = format!(
        "{}[[tag]]\nname = \"U\"\nalias = \"T\"\nmax = 1\n",
        text("type = \"INT\"")
    );
    assert!(load(&alias, "t.toml").is_err(), "an alias has none of its own");
}

#[test]
fn motion_control_tags_can_be_declared() {
    let text = "[[tag]]\nname = \"M1\"\ntype = \"motion_instruction\"\n[[tag]]\nname = \"Done\"\nalias = \"M1.DN\"\n";
    let project = load(text, "m.toml").unwrap_or_else(|error| panic!("{error}"));
    assert!(project.tags[0].is_control() && !project.tags[1].is_control());
    assert!(describe(&project).contains("tag M1: MOTION_INSTRUCTION\n"));
    let image = Image::new(&project.machine, &project.instruction_tags, &project.tags);
    assert!(image.known_control("m1").is_ok_and(|slot| slot.is_some()));
    for path in ["M1.PC", "M1.ERR", "Done"] {
        let read = image.read(&path.parse().expect("a path"));
        assert_eq!(read.map(Value::as_f64), Ok(0.0), "{path}");
    }
    let written = crate::format(&crate::table(&project));
    assert_eq!(load(&written, "m.toml").map(|again| again.tags), Ok(project.tags));
}

#[test]
fn tags_that_cannot_be_say_why() {
    let point = "[[data_type]]\nname = \"P\"\nmembers = [{ name = \"X\", type = \"REAL\" }]\n";
    #[rustfmt::skip]
    let cases = [
        ("[[tag]]\nname = \"A\"\ntype = \"DINT[1,2,3,4]\"", "three dimensions"),
        ("[[tag]]\nname = \"A\"\ntype = \"BOOL[2,2]\"", "three dimensions"),
        ("[[tag]]\nname = \"A\"\ntype = \"LREAL[65535,65535]\"", "2 MiB"),
        ("[[tag]]\nname = \"A\"\ntype = \"Q\"", "[[data_type]]"),
        ("[[tag]]\nname = \"A\"\ntype = \"MOTION_INSTRUCTION\"\nprogram = \"Main\"", "in the controller's scope"),
        ("[[tag]]\nname = \"A\"\ntype = \"MOTION_INSTRUCTION\"\nvalue = { ERR = 1 }", "only instructions write"),
        ("[[tag]]\nname = \"A\"\ntype = \"MOTION_INSTRUCTION[2]\"", "MOTION_INSTRUCTION, which has no arrays"),
        ("[[tag]]\nname = \"A\"\ntype = \"SINT\"\nvalue = 128", "a number that the type holds"),
        ("[[tag]]\nname = \"A\"\ntype = \"DINT\"\nvalue = 1.5", "a number that the type holds"),
        ("[[tag]]\nname = \"A\"\ntype = \"DINT[2]\"\nvalue = [1]", "a value for every element"),
        ("[[tag]]\nname = \"A\"\ntype = \"P\"\nvalue = { Y = 1 }", "a table of the structure's members"),
        ("[[tag]]\nname = \"A\"\nalias = \"B\"", "B"),
        ("[[tag]]\nname = \"B\"\ntype = \"P\"\n[[tag]]\nname = \"A\"\nalias = \"B.Y\"", "the path of a tag above"),
        ("[[tag]]\nname = \"A\"\ntype = \"P\"\n[[tag]]\nname = \"a\"\ntype = \"P\"", "a"),
        ("[[tag]]\nname = \"A\"\ntype = \"P\"\nprogram = \"1x\"", "a name"),
        ("[[data_type]]\nname = \"p\"\nmembers = [{ name = \"X\", type = \"REAL\" }]", "a name that no other type has"),
        ("[[data_type]]\nname = \"AXIS_VIRTUAL\"\nmembers = [{ name = \"X\", type = \"REAL\" }]", "a name that no other type has"),
        ("[[data_type]]\nname = \"Q\"\nmembers = []", "a list of tables"),
        ("[[data_type]]\nname = \"Q\"\nmembers = [{ name = \"X\", type = \"Q\" }]", "[[data_type]] above"),
        ("[[data_type]]\nname = \"Q\"\nmembers = [{ name = \"X\", type = \"REAL\" }, { name = \"x\", type = \"REAL\" }]", "no other member"),
    ];
    for (text, expected) in cases {
        let message = tags(&format!("{point}{text}")).expect_err(text);
        assert!(
            message.contains(expected) && message.contains("t.toml:"),
            "{text}: {message}"
        );
    }
}

#[test]
fn wires_are_read_and_written_and_give_an_axis_its_home_switch() {
    let wire =
        |from: &str, to: &str, more: &str| format!("[[controller.wire]]\nfrom = \"{from}\"\nto = \"{to}\"\n{more}\n");
    let text = format!(
        "{}\n[controller]\nprogram = \"Cell.L5X\"\n{}{}",
        crate::DEFAULT,
        wire("Local:2:O.Data.3", "x.Home_Switch", "delay_ms = 20"),
        wire("Y.home_switch", "Local:1:I.Data.0", "")
    );
    let project = crate::load(&text, "wired.toml").expect("it is valid");
    let wires: Vec<_> = project
        .server
        .controller
        .wires
        .iter()
        .map(|wire| (wire.from.as_str(), wire.to.as_str(), wire.delay_ms))
        .collect();
    let expected = [
        ("Local:2:O.Data.3", "x.Home_Switch", 20),
        ("Y.home_switch", "Local:1:I.Data.0", 0),
    ];
    assert_eq!(wires, expected);
    let switches: Vec<_> = project
        .machine
        .axes
        .iter()
        .map(|axis| axis.home.inputs.switch.is_some())
        .collect();
    assert_eq!(switches[..2], [true, false], "X has one, Y only shows its own");
    assert_eq!(
        crate::load(&crate::format(&crate::table(&project)), "again.toml").expect("it is valid"),
        project
    );
    for (text, expected) in [
        (wire("", "B", ""), "controller.wire[1].from"),
        (wire("A", "B C", ""), "controller.wire[1].to"),
        (wire("A", "B", "delay_ms = -1"), "controller.wire[1].delay_ms"),
        ("[[controller.wire]]\nfrom = \"A\"".to_owned(), "to"),
    ] {
        let error = crate::load(&format!("{}\n{text}", crate::DEFAULT), "t.toml").expect_err(expected);
        assert!(error.to_string().contains(expected), "{expected}: {error}");
    }
}

#[test]
fn the_documentation_lists_the_keys() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/CONFIGURATION.md");
    let found = std::fs::read_to_string(file).expect("the page is there");
    let expected = crate::page(&found).expect("a table under each heading");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(file, &expected).expect("the page can be written");
        return;
    }
    for (found, expected) in found.lines().zip(expected.lines()) {
        assert_eq!(found, expected, "old: UPDATE_EXPECT=1 cargo test -p arcline-config");
    }
    assert_eq!(found, expected);
}

#[test]
fn the_table_of_keys_agrees_with_the_catalogue() {
    let faults: Vec<&str> = FAULTS.iter().map(|fault| fault.word).collect();
    assert_eq!(EXCEPTION_ACTIONS.names(), faults);
    for (fault, key) in FAULTS.iter().zip(EXCEPTION_ACTIONS.keys) {
        let action = ExceptionAction::ALL.iter().find(|(_, action)| *action == fault.default);
        assert_eq!(
            key.default,
            action.map_or(Default::Required, |(word, _)| Default::Text(word)),
            "{}",
            fault.word
        );
    }
    let words = |keys: &Keys, key: &str| match keys.key(key).map(|key| &key.kind) {
        Some(Kind::Word(words)) => words.to_vec(),
        other => panic!("{key}: {other:?}"),
    };
    assert_eq!(
        words(&EXCEPTION_ACTIONS, faults[0]),
        ExceptionAction::ALL.map(|(word, _)| word)
    );
    for build in words(&COORDINATE_SYSTEM, "type") {
        for (definition, _) in crate::definitions(build) {
            assert!(
                words(&COORDINATE_SYSTEM, "definition").contains(&definition),
                "{definition}"
            );
        }
    }
}

#[test]
fn all_errors_are_found_at_once() {
    let text = "[server]\nmax_clients = 0\nlistn = \"a\"\n\
        [[axis]]\nname = \"X\"\ntype = \"virtual\"\nmax_speed = -1\nunwind = 360\ntravel = { min = 1, max = 0 }\n\
        drive = {}\nstart = { position = 400, servo_on = 1 }\n\
        [[axis]]\nname = \"x\"\ntype = \"serv\"\nmax_speed = 1\nmax_acceleration = 1\n\
        [[coordinate_system]]\nname = \"CS\"\naxes = [\"X\", \"Y\"]\nmax_speed = 1\ncorner = \"round\"\n\
        [[transform]]\nname = \"T\"\nsource = \"CS\"\ntarget = \"CS3\"\n\
        [[instruction]]\ntag = \"M\"\ntype = \"MCLM\"\ntarget = \"X\"\n\
        [[data_type]]\nname = \"P\"\nmembers = [{ name = \"A\", type = \"REEL\" }, { name = \"B\" }]\n\
        [[tag]]\nname = \"R\"\ntype = \"SINT\"\nvalue = 1000\n";
    let errors = crate::load_all(text, "m.toml").expect_err("much is wrong");
    let found: Vec<String> = errors
        .iter()
        .map(|error| format!("{} {}", error.line, error.key))
        .collect();
    #[rustfmt::skip]
    let expected = [
        "2 server.max_clients", "3 server.listn", "4 axis[1].max_acceleration", "7 axis[1].max_speed", "9 axis[1].travel",
        "9 axis[1].travel.max", "10 axis[1].drive", "11 axis[1].start.position", "11 axis[1].start.servo_on", "13 axis[2].name",
        "14 axis[2].type", "17 coordinate_system[1].max_acceleration", "19 coordinate_system[1].axes[2]",
        "21 coordinate_system[1].corner", "25 transform[1].target", "29 instruction[1].target", "32 data_type[1].members[1].type",
        "32 data_type[1].members[2].type", "36 tag[1].value",
    ];
    assert_eq!(found, expected, "{errors:#?}");
    let errors = crate::load_all("[server\nname = \n[x]\ny = 1 2", "m.toml").expect_err("no TOML");
    assert!(
        errors.len() == 2 && errors.iter().all(|error| error.to_string().contains("not valid TOML")),
        "{errors:#?}"
    );
}

mod by_schema {
    use serde_json::Value;

    use super::*;

    fn schema() -> Value {
        serde_json::from_str(&crate::schema()).expect("JSON")
    }

    fn json(text: &str) -> Value {
        let table: toml::Table = text.parse().expect("TOML");
        serde_json::to_value(table).expect("JSON")
    }

    /// The reason for which a value is not valid, by the keywords that the schema uses; any other keyword is a panic.
    fn wrong(schema: &Value, value: &Value) -> Option<String> {
        let number = |limit: &Value, holds: fn(&f64, &f64) -> bool| {
            value
                .as_f64()
                .is_none_or(|value| holds(&value, &limit.as_f64().expect("a number")))
        };
        let count = |limit: &Value, holds: fn(&u64, &u64) -> bool| {
            let count = value.as_array().map(|items| items.len() as u64);
            count.is_none_or(|count| holds(&count, &limit.as_u64().expect("a count")))
        };
        for (keyword, rule) in schema.as_object().expect("a schema") {
            let holds = match keyword.as_str() {
                "$schema" | "title" | "description" | "default" => true,
                "type" => match rule.as_str() {
                    Some("object") => value.is_object(),
                    Some("array") => value.is_array(),
                    Some("string") => value.is_string(),
                    Some("boolean") => value.is_boolean(),
                    Some("number") => value.is_number(),
                    Some("integer") => value.as_f64().is_some_and(|number| number.fract() == 0.0),
                    other => panic!("the type {other:?}"),
                },
                "enum" => rule.as_array().expect("a list").contains(value),
                "const" => rule == value,
                "anyOf" => rule
                    .as_array()
                    .expect("a list")
                    .iter()
                    .any(|schema| wrong(schema, value).is_none()),
                "pattern" => {
                    let pattern = regex::Regex::new(rule.as_str().expect("a text")).expect("a pattern");
                    value.as_str().is_none_or(|text| pattern.is_match(text))
                }
                "minimum" => number(rule, f64::ge),
                "maximum" => number(rule, f64::le),
                "exclusiveMinimum" => number(rule, f64::gt),
                "minItems" => count(rule, u64::ge),
                "maxItems" => count(rule, u64::le),
                "required" => rule
                    .as_array()
                    .expect("a list")
                    .iter()
                    .all(|key| value.get(key.as_str().expect("a key")).is_some()),
                "items" => {
                    if let Some(why) = value
                        .as_array()
                        .into_iter()
                        .flatten()
                        .find_map(|item| wrong(rule, item))
                    {
                        return Some(why);
                    }
                    true
                }
                "properties" => {
                    let rules = rule.as_object().expect("rules");
                    for (key, rule) in rules {
                        if let Some(why) = value.get(key).and_then(|value| wrong(rule, value)) {
                            return Some(format!("{key}: {why}"));
                        }
                    }
                    true
                }
                "additionalProperties" => {
                    assert_eq!(rule, &Value::Bool(false));
                    let known = schema["properties"].as_object().expect("rules");
                    value
                        .as_object()
                        .is_none_or(|keys| keys.keys().all(|key| known.contains_key(key)))
                }
                other => panic!("the keyword {other}"),
            };
            if !holds {
                return Some(format!("{value} against {keyword} {rule}"));
            }
        }
        None
    }

    #[test]
    fn shipped_and_written_configurations_are_valid() {
        let schema = schema();
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
        let mut texts = vec![("default".to_owned(), DEFAULT.to_owned())];
        for folder in ["tests/config", "docs/images"] {
            for entry in std::fs::read_dir(format!("{root}/{folder}")).expect("the folder is there") {
                let path = entry.expect("an entry").path();
                if path.extension().is_some_and(|extension| extension == "toml") {
                    let text = std::fs::read_to_string(&path).expect("it can be read");
                    texts.push((path.display().to_string(), text));
                }
            }
        }
        assert!(texts.len() > 5, "{}", texts.len());
        for (file, text) in texts {
            let project = load(&text, &file).unwrap_or_else(|error| panic!("{error}"));
            for text in [text, crate::format(&crate::table(&project))] {
                assert_eq!(wrong(&schema, &json(&text)), None, "{file}:\n{text}");
            }
        }
    }

    #[test]
    fn the_reader_refuses_every_file_that_the_schema_refuses() {
        let schema = schema();
        #[rustfmt::skip]
        let cases = [
            ("all is well",            format!("{AXIS}{SYSTEM}"),                                     true),
            ("an unknown key",         format!("{AXIS}max_sped = 1"),                                 false),
            ("an unknown key within",  format!("{AXIS}start = {{ hommed = true }}"),                  false),
            ("a missing key",          "[[axis]]\nname = \"X\"".to_owned(),                           false),
            ("a word that is none",    AXIS.replace("servo", "serov"),                                false),
            ("a number of text",       AXIS.replace("= 10\n", "= \"fast\"\n"),                       false),
            ("above 0",                AXIS.replace("= 10\n", "= 0\n"),                               false),
            ("a fraction",             format!("{AXIS}output_cam_execution_targets = 1.5"),           false),
            ("too much",               format!("{AXIS}output_cam_execution_targets = 33"),            false),
            ("neither 0 nor 100",      "[server]\njog_silence_ms = 50".to_owned(),                    false),
            ("0 is never",             "[server]\njog_silence_ms = 0".to_owned(),                     true),
            ("a name that is none",    AXIS.replace("\"X\"", "\"1X\""),                               false),
            ("no axes",                format!("{AXIS}{}", SYSTEM.replace("[\"x\"]", "[]")),          false),
            ("several addresses",      "[server]\nlisten = [\"127.0.0.1:0\", \"[::1]:0\"]".to_owned(), true),
            ("any value of a tag",     "[[tag]]\nname = \"A\"\ntype = \"INT[2]\"\nvalue = [1, 2]".to_owned(), true),
        ];
        for (why, text, valid) in cases {
            assert_eq!(wrong(&schema, &json(&text)).is_none(), valid, "{why}\n{text}");
            assert_eq!(load(&text, "m.toml").is_ok(), valid, "{why}\n{text}");
        }
    }
}

mod hostile {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_text_is_a_project_or_an_error(text in "\\PC{0,60}(\n\\PC{0,60}){0,4}") {
            let _ = load(&text, "m.toml").map_err(|error| error.to_string());
        }

        #[test]
        fn the_default_with_a_slip(at in 0..DEFAULT.len(), slip in "\\PC{0,3}", cut in 0usize..4) {
            let text: String = DEFAULT.chars().take(at).chain(slip.chars()).chain(DEFAULT.chars().skip(at + cut)).collect();
            match load(&text, "m.toml") {
                Ok(project) => prop_assert!(!describe(&project).is_empty()),
                Err(error) => prop_assert!(error.line >= 1 && error.column >= 1),
            }
        }
    }
}

#[test]
fn robots_are_read_and_written() {
    let axes: String = ["J1", "J2", "J3"]
        .iter()
        .map(|name| {
            format!("[[axis]]\nname = \"{name}\"\ntype = \"virtual\"\nmax_speed = 10.0\nmax_acceleration = 100.0\n")
        })
        .collect();
    #[rustfmt::skip]
    let cases = [
        ("articulated_independent", 2, Geometry::ArticulatedIndependent2), ("articulated_independent", 3, Geometry::ArticulatedIndependent3),
        ("articulated_dependent", 2, Geometry::ArticulatedDependent2), ("articulated_dependent", 3, Geometry::ArticulatedDependent3),
        ("scara_independent", 3, Geometry::ScaraIndependent), ("scara_delta", 3, Geometry::ScaraDelta),
        ("delta", 2, Geometry::Delta2), ("delta", 3, Geometry::Delta3),
    ];
    for (word, count, geometry) in cases {
        let names = &["J1", "J2", "J3"][..count];
        let text = format!(
            "{axes}[[coordinate_system]]\nname = \"R\"\ntype = \"{word}\"\naxes = {names:?}\nmax_speed = 1.0\nmax_acceleration = 1.0\n\
             joint_limits = \"enforce\"\nlink_lengths = [10, 20.5]\nbase_offsets = [1, 2, 3]\nend_effector_offsets = [4, 5, -6]\n\
             zero_angles = [0, 90, -45.5]\n"
        );
        let project = load(&text, "m.toml").expect(word);
        let robot = project.machine.systems[0].robot.expect(word);
        assert_eq!(robot.structure, KinematicStructure::Arm(geometry));
        assert_eq!(robot.parameters.link_lengths, [10.0, 20.5]);
        assert_eq!(robot.parameters.base_offsets, [1.0, 2.0, 3.0]);
        assert_eq!(robot.parameters.end_effector_offsets, [4.0, 5.0, -6.0]);
        assert_eq!(robot.parameters.zero_angles, [0.0, 90.0, -45.5, 0.0, 0.0, 0.0]);
        let written = crate::format(&crate::table(&project));
        let again = load(&written, "m.toml").expect("what is written can be read");
        assert_eq!(again.machine.systems, project.machine.systems, "{word}");
    }
}

#[test]
fn systems_with_orientation_are_read_and_written() {
    let names = ["A", "B", "C", "D", "E", "F"];
    let axes: String = names
        .iter()
        .zip(1..)
        .map(|(name, k)| {
            format!("[[axis]]\nname = \"{name}\"\ntype = \"virtual\"\nmax_speed = {k}0.0\nmax_acceleration = {k}00.0\nmax_deceleration = {k}50.0\n")
        })
        .collect();
    #[rustfmt::skip]
    let cases = [
        ("cartesian",               "XYZRxRyRz",    6, None,                                ""),
        ("cartesian",               "xyzrxryrz",    6, None,                                "max_orientation_speed = 7\n"),
        ("delta",                   "J1J2J6",       3, Some(Wrist::DeltaJ1J2J6),            "zero_angles = [1, 2, 3]\n"),
        ("delta",                   "J1J2J3J6",     4, Some(Wrist::DeltaJ1J2J3J6),          "zero_angles = [1, 2, 3, 4]\n"),
        ("delta",                   "J1J2J3J4J5",   5, Some(Wrist::DeltaJ1J2J3J4J5),        "zero_angles = [1, 2, 3, 4, 5]\n"),
        ("scara_independent",       "J1J2J3J6",     4, Some(Wrist::ScaraJ1J2J3J6),          ""),
        ("articulated_independent", "J1J2J3J4J5J6", 6, Some(Wrist::ArticulatedJ1J2J3J4J5J6), "zero_angles = [1, 2, 3, 4, 5, 6]\n"),
    ];
    for (build, definition, count, wrist, keys) in cases {
        let names = &names[..count];
        let text = format!(
            "{axes}[[coordinate_system]]\nname = \"R\"\ntype = \"{build}\"\ndefinition = \"{definition}\"\naxes = {names:?}\n\
             max_speed = 1.0\nmax_acceleration = 1.0\n{keys}"
        );
        let project = load(&text, "m.toml").unwrap_or_else(|error| panic!("{error}"));
        let system = &project.machine.systems[0];
        assert_eq!(system.axes.len(), count, "{definition}");
        assert_eq!(system.linear().len() + system.oriented().len(), count, "{definition}");
        assert_eq!(
            system.robot.map(|robot| robot.structure),
            wrist.map(KinematicStructure::Wrist),
            "{definition}"
        );
        let orientation = wrist.is_none().then_some(Orientation {
            max_speed: if keys.is_empty() { 40.0 } else { 7.0 },
            max_acceleration: 400.0,
            max_deceleration: 450.0,
        });
        assert_eq!(system.orientation, orientation, "{definition}");
        if keys.starts_with("zero") {
            let angles = system.robot.expect(definition).parameters.zero_angles;
            assert_eq!(angles[count - 1], count as f64, "{definition}");
        }
        let written = crate::format(&crate::table(&project));
        let again = load(&written, "m.toml").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(again.machine.systems, project.machine.systems, "{definition}");
    }
}

#[test]
fn security_is_read_and_written() {
    let text = r#"
[security]
tls = "0.0.0.0:2221"
revoked = "crl.pem"
plain = "discovery"
io_over_tls = "plain"
default_role = "operator"
check_expiration = false
remote_plain = "operator"
hmi_tls = "0.0.0.0:8443"
hmi_names = ["cell-4", "cell-4.plant.example"]
login_notice = "Only trained staff.\nAll is recorded."
users = "users.toml"
idle_s = 600
session_s = 3600
plain_allow = ["10.1.2.0/24", "10.9.9.9"]
hmi_allow = ["fd00::/8"]
max_requests_per_s_viewer = 50
[[security.certificates]]
cn = "line3-hmi"
issuer = "CN=Plant CA"
role = "engineer"
[[security.certificates]]
sha256 = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff"
role = "administrator"
"#;
    let project = load(&format!("{text}{DEFAULT}"), "t.toml").expect("it is valid");
    let security = &project.server.security;
    assert_eq!(security.certificates.len(), 2);
    assert_eq!(
        (security.plain, security.refuses_io_over_tls),
        (PlainAccess::Discovery, false)
    );
    assert_eq!(security.hmi_tls, "0.0.0.0:8443".parse().ok());
    assert_eq!(security.hmi_names, ["cell-4", "cell-4.plant.example"]);
    assert_eq!(
        (security.users.as_deref(), security.idle, security.session),
        (Some("users.toml"), 600, 3600)
    );
    let written = format_table(&table(&project));
    assert_eq!(
        load(&written, "written").expect("it is valid").server,
        project.server,
        "{written}"
    );
    let bad = "cn = \"a\"\nrole = \"viewer\"";
    let twice = "cn = \"a\"\nissuer = \"b\"\nsha256 = \"SHA\"\nrole = \"viewer\"".replace("SHA", &"0".repeat(64));
    #[rustfmt::skip]
    let cases = [
        ("plain = \"off\"".to_owned(),                                        "plain"),
        ("loopback = \"administrator\"".to_owned(),                           "loopback"),
        ("password = \"x\"".to_owned(),                                       "password"),
        ("idle_s = 59".to_owned(),                                            "idle_s"),
        ("tls_allow = [\"10.1.2.0/33\"]".to_owned(),                            "tls_allow[1]"),
        ("hmi_allow = []".to_owned(),                                         "hmi_allow"),
        (format!("hmi_allow = [{}]", "\"10.0.0.1\", ".repeat(65)),           "hmi_allow"),
        ("hmi_tls = \"8443\"".to_owned(),                                     "hmi_tls"),
        (format!("hmi_names = [{}]", "\"a\", ".repeat(33)),                  "hmi_names"),
        (format!("[[security.certificates]]\n{bad}"),                          "issuer"),
        (format!("[[security.certificates]]\n{twice}"),                        "sha256"),
        ("[[security.certificates]]\nsha256 = \"12\"\nrole = \"viewer\"".to_owned(), "sha256"),
    ];
    for (text, key) in cases {
        let error = load(&format!("[security]\n{text}\n{DEFAULT}"), "t.toml")
            .expect_err(key)
            .to_string();
        assert!(error.contains(key), "{text}: {error}");
    }
}

#[test]
fn an_allow_list_has_networks_of_both_families() {
    let list = |networks: &[&str]| {
        let networks = networks.iter().map(|text| AllowList::network(text).expect("a network"));
        AllowList(networks.collect())
    };
    #[rustfmt::skip]
    let cases = [
        ("without a list",             &[][..],                   "192.0.2.1",        true),
        ("in the network",             &["10.1.2.0/24"],          "10.1.2.255",       true),
        ("beside it",                  &["10.1.2.0/24"],          "10.1.3.0",         false),
        ("a host of the network",      &["10.1.2.7/24"],          "10.1.2.8",         true),
        ("one address",                &["10.1.2.7"],             "10.1.2.7",         true),
        ("its neighbour",              &["10.1.2.7"],             "10.1.2.8",         false),
        ("IPv4 inside of IPv6",        &["10.1.2.0/24"],          "::ffff:10.1.2.3",  true),
        ("an address inside of IPv6",  &["::ffff:10.1.2.3"],      "10.1.2.3",         true),
        ("IPv6",                       &["fd00::/8"],             "fd12::1",          true),
        ("another IPv6",               &["fd00::/8"],             "2001:db8::1",      false),
        ("one of two",                 &["fd00::/8", "10.0.0.1"], "10.0.0.1",         true),
        ("this computer",              &["10.1.2.0/24"],          "127.0.0.1",        true),
        ("this computer by IPv6",      &["10.1.2.0/24"],          "::1",              true),
    ];
    for (why, networks, address, expected) in cases {
        let address = address.parse().expect("an address");
        assert_eq!(list(networks).allows(address), expected, "{why}");
    }
    for text in ["10.1.2.0/33", "10.1.2/24", "host", "", "fd00::/129"] {
        assert_eq!(AllowList::network(text), None, "{text}");
    }
}

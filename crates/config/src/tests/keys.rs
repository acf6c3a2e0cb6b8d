//! The table of keys against reading and writing: every key is in one of the configurations below, is written back as it was read, and has
//! the default that the table says.

use std::collections::BTreeSet;

use toml::{Table, Value};

use crate::keys::{Default, Key, Keys, Kind, ROOT};
use crate::words;
use crate::{Project, load, table};

/// A servo, a feedback axis, coordinate systems, tags, the network: each key with a value that is not its default.
const FULL: &str = r#"
[server]
name = "Cell 4"
listen = ["127.0.0.1:0", "[::1]:44818"]
hmi = "127.0.0.1:8081"
io = "127.0.0.1:2223"
io_loss = "hold"
connection_loss = "finish"
max_clients = 11
max_clients_per_address = 12
max_connections = 13
max_connections_per_address = 14
inactivity_timeout_s = 15
jog_silence_ms = 160

[security]
tls = "127.0.0.1:2221"
certificate = "a.pem"
key = "a.key"
clients = "b.pem"
revoked = "c.pem"
check_expiration = false
plain = "discovery"
io_over_tls = "plain"
default_role = "operator"
certificates = [
    { cn = "hmi", issuer = "CN=Plant", role = "engineer" },
    { sha256 = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff", role = "administrator" },
]
loopback = "operator"
remote_plain = "engineer"
hmi_tls = "127.0.0.1:8443"
hmi_names = ["cell-4"]
login_notice = "Staff only."
users = "users.toml"
idle_s = 61
session_s = 301
plain_allow = ["10.1.2.0/24"]
tls_allow = ["10.1.3.0/24"]
hmi_allow = ["fd00::/8"]
max_requests_per_s_viewer = 1
max_requests_per_s_operator = 2
max_requests_per_s_engineer = 3

[controller]
program = "cell.L5X"
mode = "program"
allow_missing = true
messages = [
    { service = 1, class = 2, instance = 3, attribute = 4, answer = "01 2A", delay_ms = 5, err = 6, exerr = 7 },
]
wire = [{ from = "Local:2:O.Data.3", to = "X.enable", delay_ms = 8 }]

[motion_group]
name = "G"
coarse_update_period_ms = 2.0

[[axis]]
name = "X"
type = "servo"
units = "mm"
max_speed = 10.0
max_acceleration = 100.0
max_deceleration = 90.0
max_acceleration_jerk = 80.0
max_deceleration_jerk = 70.0
dynamics_configuration_bits = 5
travel = { min = -5.0, max = 6.0 }
start = { position = 1.0, servo_on = false, homed = false }
programmed_stop_mode = "hard_disable"
average_velocity_timebase = 0.5
output_cam_execution_targets = 3

[axis.drive]
position_bandwidth_hz = 30.0
velocity_feedforward = 0.5
position_error_tolerance = 4.0
position_error_tolerance_time = 0.1
speed_limit = 11.0
torque_limit = 110.0
encoder_resolution = 1000.0

[axis.home]
mode = "passive"
sequence = "switch-marker"
direction = "unidirectional-reverse"
position = 1.0
offset = 2.0
speed = 3.0
return_speed = 4.0
acceleration = 5.0
deceleration = 6.0
switch = { min = -1.0, max = 7.0 }
marker = { at = 0.5, every = 2.0 }

[axis.exception_actions]
soft_travel_positive = "ignore"
soft_travel_negative = "alarm"
position_error = "shutdown"
drive = "shutdown"
overcurrent = "shutdown"
overspeed = "shutdown"
overtravel_positive = "shutdown"
overtravel_negative = "shutdown"
feedback_loss = "shutdown"
command_limit = "stop_drive"
drive_communication = "shutdown"

[axis.command_limits]
enabled = false
speed = 2.0
acceleration = 3.0

[axis.registration]
input_1 = "Marks.3"
input_2 = "Marks.4"

[[axis]]
name = "F"
type = "feedback"
max_speed = 10.0
max_acceleration = 100.0
unwind = 360.0
feed = { tag = "Encoder", interval_ms = 20.0, timeout_ms = 30.0 }

[[axis]]
name = "A"
type = "virtual"
max_speed = 10.0
max_acceleration = 100.0

[[axis]]
name = "B"
type = "virtual"
max_speed = 10.0
max_acceleration = 100.0

[[axis]]
name = "C"
type = "virtual"
max_speed = 10.0
max_acceleration = 100.0

[[axis]]
name = "D"
type = "virtual"
max_speed = 10.0
max_acceleration = 100.0

[[axis]]
name = "E"
type = "virtual"
max_speed = 10.0
max_acceleration = 100.0

[[coordinate_system]]
name = "Robot"
type = "delta"
definition = "J1J2J3J6"
axes = ["A", "B", "C", "D"]
max_speed = 5.0
max_acceleration = 50.0
max_deceleration = 40.0
max_acceleration_jerk = 30.0
max_deceleration_jerk = 20.0
dynamics_configuration_bits = 3
actual_tolerance = 0.1
command_tolerance = 0.2
queue_depth = 9
corner = "precise"
deviation = "anywhere"
axis_limits = "enforce"
joint_limits = "enforce"
link_lengths = [1.0, 2.0]
base_offsets = [1.0, 2.0, 3.0]
end_effector_offsets = [4.0, 5.0, 6.0]
zero_angles = [1.0, 2.0, 3.0, 4.0]

[[coordinate_system]]
name = "Tool"
type = "cartesian"
definition = "XYZRxRyRz"
axes = ["X", "A", "B", "C", "D", "E"]
max_speed = 5.0
max_acceleration = 50.0
max_orientation_speed = 6.0
max_orientation_acceleration = 7.0
max_orientation_deceleration = 8.0

[[transform]]
name = "T"
source = "Tool"
target = "Robot"

[[data_type]]
name = "Point"
members = [{ name = "At", type = "REAL[6]" }]

[[tag]]
name = "Marks"
type = "DINT"
access = "read_only"

[[tag]]
name = "Encoder"
type = "REAL"
write_role = "engineer"
min = -1.0
max = 2.0
value = 1.5

[[tag]]
name = "Local"
type = "Point"
program = "Main"

[[tag]]
name = "Other"
alias = "Marks.5"

[[instruction]]
tag = "Move"
type = "MCLM"
target = "Tool"
"#;

/// A key of a configuration: its place, such as `axis[0].drive.speed_limit`.
struct Place {
    path: String,
    steps: Vec<Step>,
    key: &'static Key,
}

#[derive(Clone)]
enum Step {
    Table(&'static str),
    Item(&'static str, usize),
}

/// All keys of a table and of those within.
fn places(keys: &'static Keys, table: &Table, steps: &[Step], path: &str, found: &mut Vec<Place>) {
    for key in keys.keys {
        let Some(value) = table.get(key.name) else { continue };
        let path = format!("{path}{}", key.name);
        found.push(Place {
            path: path.clone(),
            steps: steps.to_vec(),
            key,
        });
        match (&key.kind, value) {
            (Kind::Table(keys), Value::Table(within)) => {
                let steps = [steps, &[Step::Table(key.name)]].concat();
                places(keys, within, &steps, &format!("{path}."), found);
            }
            (Kind::Tables(keys, _), Value::Array(items)) => {
                for (index, within) in items.iter().filter_map(Value::as_table).enumerate() {
                    let steps = [steps, &[Step::Item(key.name, index)]].concat();
                    places(keys, within, &steps, &format!("{path}[{index}]."), found);
                }
            }
            _ => {}
        }
    }
}

fn full() -> (Table, Vec<Place>) {
    let full: Table = FULL.parse().expect("TOML");
    let mut found = Vec::new();
    places(&ROOT, &full, &[], "", &mut found);
    (full, found)
}

impl Place {
    /// The table that has the key.
    fn within<'t>(&self, mut table: &'t mut Table) -> &'t mut Table {
        for step in &self.steps {
            let next = match step {
                Step::Table(name) => table.get_mut(*name),
                Step::Item(name, index) => table.get_mut(*name).and_then(|items| items.get_mut(*index)),
            };
            table = next.and_then(Value::as_table_mut).expect(&self.path);
        }
        table
    }

    fn of(&self, table: &Table) -> Option<Value> {
        self.within(&mut table.clone()).get(self.key.name).cloned()
    }

    fn is_table(&self) -> bool {
        matches!(self.key.kind, Kind::Table(_) | Kind::Tables(..))
    }

    /// The value of a key that the file leaves out, as the file would have it.
    fn default(&self) -> Option<Value> {
        Some(match self.key.default {
            Default::Number(number) => Value::Float(number),
            Default::Integer(number) => Value::Integer(i64::try_from(number).expect("small")),
            Default::Boolean(flag) => Value::Boolean(flag),
            Default::Text(text) => Value::String(text.to_owned()),
            Default::Required | Default::Prose(_) => return None,
        })
    }
}

fn loaded(table: &Table, why: &str) -> Project {
    load(&crate::format(table), "m.toml").unwrap_or_else(|error| panic!("{why}: {error}"))
}

#[test]
fn every_key_is_written_as_it_was_read() {
    let (full, places) = full();
    let seen: BTreeSet<*const Key> = places.iter().map(|place| &raw const *place.key).collect();
    let mut all = vec![&ROOT];
    while let Some(keys) = all.pop() {
        for key in keys.keys {
            assert!(
                seen.contains(&(&raw const *key)),
                "{} {} is in no configuration of this test",
                keys.heading,
                key.name
            );
            if let Kind::Table(within) | Kind::Tables(within, _) = key.kind {
                all.push(within);
            }
        }
    }
    let project = loaded(&full, "all keys");
    let written = table(&project);
    for place in places.iter().filter(|place| !place.is_table()) {
        assert_eq!(place.of(&written), place.of(&full), "{}", place.path);
    }
    assert_eq!(loaded(&written, "what is written"), project);
}

#[test]
fn every_word_of_a_key_is_written_as_it_was_read() {
    let (full, places) = full();
    for place in &places {
        let Kind::Word(words) = place.key.kind else { continue };
        let mut some = 0;
        for word in words {
            let mut other = full.clone();
            place
                .within(&mut other)
                .insert(place.key.name.to_owned(), Value::String((*word).to_owned()));
            // Some words contradict the other keys.
            let Ok(project) = load(&crate::format(&other), "m.toml") else {
                continue;
            };
            some += 1;
            let written = place.of(&table(&project)).or_else(|| place.default());
            assert_eq!(written, place.of(&other), "{}", place.path);
        }
        assert!(some > 0, "{}", place.path);
    }
}

/// A key that is left out has its default, wherever it is; the test sees it, since the configuration has another value.
#[test]
fn a_key_that_is_left_out_has_the_default_of_the_table() {
    let (full, places) = full();
    let mut count = 0;
    for place in &places {
        let Some(default) = place.default() else { continue };
        let is_given = place.of(&full).filter(|given| *given == default).is_none();
        // The `type` of the second coordinate system.
        assert!(is_given || place.key.name == "type", "{}: the default", place.path);
        let (mut without, mut with) = (full.clone(), full.clone());
        place.within(&mut without).remove(place.key.name);
        place
            .within(&mut with)
            .insert(place.key.name.to_owned(), default.clone());
        // The line of an error is another one.
        let [without, with] = [without, with]
            .map(|table| load(&crate::format(&table), "m.toml").map_err(|error| (error.key, error.problem)));
        assert_eq!(without, with, "{} = {default}", place.path);
        count += usize::from(without.is_ok());
    }
    assert!(count > 50, "{count} keys have a default");
}

#[test]
fn a_file_without_tables_has_the_defaults_of_the_table() {
    let project = load("", "m.toml").expect("an empty machine");
    assert_eq!(project.server, crate::ServerConfig::default());
    assert_eq!(project.server.security, crate::Security::default());
    let written = table(&project);
    for name in ["server", "motion_group"] {
        let written = written[name].as_table().expect(name);
        let Some(Kind::Table(keys)) = ROOT.key(name).map(|key| &key.kind) else {
            panic!("{name}")
        };
        for key in keys.keys {
            let place = Place {
                path: key.name.to_owned(),
                steps: Vec::new(),
                key,
            };
            // `listen` is written as a list.
            let found = written.get(key.name).map(|found| match found {
                Value::Array(items) if items.len() == 1 => items[0].clone(),
                other => other.clone(),
            });
            if let Some(default) = place.default() {
                assert_eq!(found, Some(default), "{name}.{}", key.name);
            }
        }
    }
}

#[test]
fn a_controller_without_a_program_is_written() {
    let text = "[controller]\nallow_missing = true\nmessages = [{ service = 1, class = 2 }]\n";
    let project = load(text, "m.toml").expect("valid");
    assert_eq!(loaded(&table(&project), "written").server, project.server);
}

/// The words that reading and writing know are those of the table.
#[test]
fn the_words_of_the_keys_are_those_that_are_read() {
    fn of<T>(words: words::Words<T>) -> Vec<&'static str> {
        words.iter().map(|(word, _)| *word).collect()
    }
    #[rustfmt::skip]
    let rows: &[(&Keys, &str, Vec<&str>)] = &[
        (&crate::keys::SERVER,            "io_loss",              of(words::IO_LOSS)),
        (&crate::keys::SERVER,            "connection_loss",      of(words::CONNECTION_LOSS)),
        (&crate::keys::SECURITY,          "plain",                of(words::PLAIN)),
        (&crate::keys::SECURITY,          "io_over_tls",          of(words::IO_OVER_TLS)),
        (&crate::keys::CERTIFICATE,       "role",                 of(words::ROLES)),
        (&crate::keys::CONTROLLER,        "mode",                 of(words::CONTROLLER_MODES)),
        (&crate::keys::AXIS,              "type",                 of(words::AXIS_KINDS)),
        (&crate::keys::AXIS,              "programmed_stop_mode", of(words::STOP_MODES)),
        (&crate::keys::EXCEPTION_ACTIONS, "drive",                of(words::ACTIONS)),
        (&crate::keys::HOME,              "mode",                 of(words::HOME_MODES)),
        (&crate::keys::HOME,              "sequence",             of(words::HOME_SEQUENCES)),
        (&crate::keys::HOME,              "direction",            of(words::HOME_DIRECTIONS)),
        (&crate::keys::COORDINATE_SYSTEM, "corner",               of(words::CORNERS)),
        (&crate::keys::COORDINATE_SYSTEM, "deviation",            of(words::DEVIATIONS)),
        (&crate::keys::COORDINATE_SYSTEM, "axis_limits",          of(words::LIMITS)),
        (&crate::keys::COORDINATE_SYSTEM, "joint_limits",         of(words::LIMITS)),
        (&crate::keys::TAG,               "access",               of(words::ACCESS)),
        (&crate::keys::TAG,               "write_role",           of(words::WRITERS)),
    ];
    let sorted = |words: &[&'static str]| words.iter().copied().collect::<BTreeSet<_>>();
    for (keys, name, read) in rows {
        let Some(Kind::Word(known)) = keys.key(name).map(|key| &key.kind) else {
            panic!("{name}")
        };
        assert_eq!(sorted(known), sorted(read), "{name}");
    }
    for name in ["default_role", "loopback", "remote_plain"] {
        let Some(Kind::Word(known)) = crate::keys::SECURITY.key(name).map(|key| &key.kind) else {
            panic!("{name}")
        };
        let read = of(words::ROLES);
        assert!(known.iter().all(|word| read.contains(word)), "{name}");
    }
}

//! From a [`Project`] back to the tables of its configuration, and tables as text. [`load`](crate::load) reads the tables that
//! [`table`] writes as the same project. Comments and the order of keys are lost.

use std::net::SocketAddr;

use arcline_controller::image::Writers;
use arcline_controller::machine::{
    Axis, AxisInputs, CoordinateSystem, DynamicsBits, FeedTag, Geometry, Home, KinematicStructure, Machine,
    Orientation, Robot, Sensor, SimulatedDrive, Travel,
};
use arcline_instruction_set::{FAULTS, FaultSet, SystemId};
use arcline_tag::{DataType, Elementary, Member, Template, shortest, string_text};
use toml::{Table, Value};

use crate::keys::{Keys, Kind, ROOT};
use crate::read::WRISTS;
use crate::words::{self, word_of};
use crate::{AllowList, ControllerConfig, IoListen, MessageAnswer, PlainTag, Project, Security};

/// The tables of a project with its keys, most of those at their default too.
pub fn table(project: &Project) -> Table {
    let Project {
        server,
        machine,
        instruction_tags,
        types,
        tags,
    } = project;
    let mut root = Table::new();
    let hmi = server.hmi.map_or_else(|| "off".to_owned(), |hmi| hmi.to_string());
    let io = match server.io {
        IoListen::BesideListen => None,
        IoListen::At(address) => Some(address.to_string()),
        IoListen::Off => Some("off".to_owned()),
    };
    let listen = [&server.listen].into_iter().chain(&server.listen_also);
    let listen = Value::Array(listen.map(|address| text(&address.to_string())).collect());
    let number = |most: usize| Some(Value::Integer(i64::try_from(most).unwrap_or(i64::MAX)));
    let server = [
        ("name", Some(text(&server.name))),
        ("listen", Some(listen)),
        ("hmi", Some(text(&hmi))),
        ("io", io.map(|io| text(&io))),
        ("io_loss", Some(text(server.io_loss.word()))),
        ("connection_loss", Some(text(server.connection_loss.word()))),
        ("max_clients", number(server.max_clients)),
        ("max_clients_per_address", number(server.max_clients_per_address)),
        ("max_connections", number(server.max_connections)),
        (
            "max_connections_per_address",
            number(server.max_connections_per_address),
        ),
        ("inactivity_timeout_s", number(server.inactivity_timeout.into())),
        ("jog_silence_ms", number(server.jog_silence.into())),
    ];
    let server = server.into_iter().filter_map(|(key, value)| Some((key, value?)));
    root.insert("server".into(), keys(server));
    if project.server.security.is_given {
        root.insert("security".into(), keys(security(&project.server.security)));
    }
    let controller = &project.server.controller;
    if *controller != ControllerConfig::default() {
        let mut all = vec![
            (
                "mode",
                text(word_of(words::CONTROLLER_MODES, &controller.begins_stopped)),
            ),
            ("allow_missing", Value::Boolean(controller.allow_missing)),
        ];
        all.extend(controller.program.as_deref().map(|file| ("program", text(file))));
        if !controller.messages.is_empty() {
            let rows = controller.messages.iter().map(message);
            all.push(("messages", Value::Array(rows.collect())));
        }
        if !controller.wires.is_empty() {
            let rows = controller.wires.iter().map(|wire| {
                keys([
                    ("from", text(&wire.from)),
                    ("to", text(&wire.to)),
                    ("delay_ms", Value::Integer(wire.delay_ms.into())),
                ])
            });
            all.push(("wire", Value::Array(rows.collect())));
        }
        root.insert("controller".into(), keys(all));
    }
    let group = [
        ("name", text(&machine.group)),
        ("coarse_update_period_ms", Value::Float(machine.period_ns as f64 / 1e6)),
    ];
    root.insert("motion_group".into(), keys(group));
    list(&mut root, "axis", machine.axes.iter().zip(&machine.drives).map(axis));
    list(
        &mut root,
        "coordinate_system",
        machine.systems.iter().map(|one| system(one, machine)),
    );
    let system_name = |place: SystemId| {
        let system = machine.systems.get(usize::from(place));
        text(system.map_or("", |system| &system.name))
    };
    let transforms = machine.transforms.iter().map(|transform| {
        keys([
            ("name", text(&transform.name)),
            ("source", system_name(transform.source)),
            ("target", system_name(transform.target)),
        ])
    });
    list(&mut root, "transform", transforms);
    let instructions = instruction_tags.iter().map(|tag| {
        keys([
            ("tag", text(&tag.name)),
            ("type", text(&tag.mnemonic.to_string())),
            ("target", text(&tag.target)),
        ])
    });
    list(&mut root, "instruction", instructions);
    list(&mut root, "data_type", types.iter().map(|template| data_type(template)));
    list(&mut root, "tag", tags.iter().map(tag));
    root
}

fn security(security: &Security) -> Vec<(&'static str, Value)> {
    let [viewer, operator, engineer, _] = security.max_requests.map(|rate| Value::Integer(rate.into()));
    let off_or = |address: Option<SocketAddr>| address.map_or_else(|| "off".to_owned(), |one| one.to_string());
    let mut all = vec![
        ("tls", text(&off_or(security.tls))),
        ("certificate", text(&security.certificate)),
        ("key", text(&security.key)),
        ("clients", text(&security.clients)),
    ];
    all.extend(security.revoked.as_deref().map(|file| ("revoked", text(file))));
    all.extend([
        ("check_expiration", Value::Boolean(security.check_expiration)),
        ("plain", text(security.plain.word())),
        (
            "io_over_tls",
            text(word_of(words::IO_OVER_TLS, &security.refuses_io_over_tls)),
        ),
        ("default_role", text(security.default_role.word())),
    ]);
    if !security.certificates.is_empty() {
        let rows = security.certificates.iter().map(|row| {
            let name = |key: &'static str, value: &Option<String>| value.as_deref().map(|value| (key, text(value)));
            let names = [
                name("cn", &row.cn),
                name("issuer", &row.issuer),
                name("sha256", &row.sha256),
                Some(("role", text(row.role.word()))),
            ];
            keys(names.into_iter().flatten())
        });
        all.push(("certificates", Value::Array(rows.collect())));
    }
    all.extend([
        ("loopback", text(security.loopback.word())),
        ("remote_plain", text(security.remote_plain.word())),
        ("hmi_tls", text(&off_or(security.hmi_tls))),
    ]);
    if !security.hmi_names.is_empty() {
        let names = security.hmi_names.iter().map(|name| text(name));
        all.push(("hmi_names", Value::Array(names.collect())));
    }
    all.extend(
        security
            .login_notice
            .as_deref()
            .map(|notice| ("login_notice", text(notice))),
    );
    all.extend(security.users.as_deref().map(|file| ("users", text(file))));
    let lists = [
        ("plain_allow", &security.plain_allow),
        ("tls_allow", &security.tls_allow),
        ("hmi_allow", &security.hmi_allow),
    ];
    all.extend([
        ("idle_s", Value::Integer(security.idle.into())),
        ("session_s", Value::Integer(security.session.into())),
    ]);
    for (key, AllowList(networks)) in lists {
        if !networks.is_empty() {
            let networks = networks.iter().map(|network| text(&network.to_string()));
            all.push((key, Value::Array(networks.collect())));
        }
    }
    all.extend([
        ("max_requests_per_s_viewer", viewer),
        ("max_requests_per_s_operator", operator),
        ("max_requests_per_s_engineer", engineer),
    ]);
    all
}

/// The tables as the text of a configuration: the sections and the keys of each in the order of docs/CONFIGURATION.md;
/// keys that it does not have come last.
pub fn format(table: &Table) -> String {
    let mut out = String::new();
    for key in ROOT.keys {
        match (&key.kind, table.get(key.name)) {
            (Kind::Table(keys), Some(Value::Table(section))) => {
                write_section(&mut out, &format!("[{}]", key.name), keys, section);
            }
            (Kind::Tables(keys, _), Some(Value::Array(sections))) => {
                for section in sections.iter().filter_map(Value::as_table) {
                    write_section(&mut out, &format!("[[{}]]", key.name), keys, section);
                }
            }
            _ => {}
        }
    }
    out
}

fn write_section(out: &mut String, heading: &str, keys: &Keys, section: &Table) {
    let break_before = if out.is_empty() { "" } else { "\n" };
    out.push_str(&format!("{break_before}{heading}\n"));
    let of_order = keys.keys.iter().filter_map(|key| section.get_key_value(key.name));
    let others = section.iter().filter(|(key, _)| keys.key(key).is_none());
    for (key, value) in of_order.chain(others) {
        out.push_str(&format!("{} = {value}\n", key_text(key)));
    }
}

/// A key, in quotes where it needs them.
fn key_text(key: &str) -> String {
    let line = Table::from_iter([(key.to_owned(), Value::Integer(0))]).to_string();
    line.trim_end().trim_end_matches(" = 0").to_owned()
}

fn axis((axis, drive): (&Axis, &Option<SimulatedDrive>)) -> Value {
    let mut table = dynamics([
        axis.max_speed,
        axis.max_acceleration,
        axis.max_deceleration,
        axis.max_acceleration_jerk,
        axis.max_deceleration_jerk,
    ]);
    table.extend(bits(axis.dynamics_bits));
    let travel = |travel: Travel| keys([("min", Value::Float(travel.min)), ("max", Value::Float(travel.max))]);
    let start = [
        ("position", Value::Float(axis.start.position)),
        ("servo_on", Value::Boolean(axis.start.servo_on)),
        ("homed", Value::Boolean(axis.start.homed)),
    ];
    let limits = [
        ("enabled", Value::Boolean(axis.command_limits.enabled)),
        ("speed", Value::Float(axis.command_limits.speed)),
        ("acceleration", Value::Float(axis.command_limits.acceleration)),
    ];
    let sensor = drive.map(|drive| drive.sensor).unwrap_or_default();
    let members = [
        ("name", Some(text(&axis.name))),
        ("type", Some(text(word_of(words::AXIS_KINDS, &axis.kind)))),
        ("units", Some(text(&axis.units))),
        ("travel", axis.travel.map(travel)),
        ("unwind", axis.unwind.map(Value::Float)),
        ("start", Some(keys(start))),
        ("drive", drive.as_ref().map(|drive| servo_drive(axis, drive))),
        ("feed", axis.inputs.feed.as_ref().map(feed)),
        ("registration", registration(&axis.inputs)),
        ("home", Some(home(&axis.home, sensor))),
        (
            "programmed_stop_mode",
            Some(text(word_of(words::STOP_MODES, &axis.programmed_stop_mode))),
        ),
        ("exception_actions", Some(exception_actions(axis))),
        (
            "average_velocity_timebase",
            Some(Value::Float(axis.average_velocity_timebase)),
        ),
        ("command_limits", Some(keys(limits))),
        (
            "output_cam_execution_targets",
            Some(Value::Integer(axis.output_cam_targets as i64)),
        ),
    ];
    table.extend(
        members
            .into_iter()
            .filter_map(|(key, value)| Some((key.to_owned(), value?))),
    );
    Value::Table(table)
}

fn servo_drive(axis: &Axis, drive: &SimulatedDrive) -> Value {
    let settings = &drive.settings;
    let limit = |limit: f64| limit.is_finite().then_some(limit);
    let numbers = [
        ("position_bandwidth_hz", Some(settings.bandwidth)),
        ("velocity_feedforward", Some(settings.feedforward)),
        ("position_error_tolerance", Some(axis.position_error.tolerance)),
        ("position_error_tolerance_time", Some(axis.position_error.time)),
        ("speed_limit", limit(settings.speed_limit)),
        ("torque_limit", limit(settings.torque_limit)),
        ("encoder_resolution", settings.encoder_resolution),
    ];
    keys(
        numbers
            .into_iter()
            .filter_map(|(key, number)| Some((key, Value::Float(number?)))),
    )
}

fn feed(feed: &FeedTag) -> Value {
    keys([
        ("tag", text(&feed.tag)),
        ("interval_ms", Value::Float(feed.interval * 1000.0)),
        ("timeout_ms", Value::Float(feed.timeout * 1000.0)),
    ])
}

fn registration(inputs: &AxisInputs) -> Option<Value> {
    let inputs = ["input_1", "input_2"].into_iter().zip(&inputs.registration);
    let inputs = inputs.filter_map(|(key, path)| Some((key.to_owned(), text(path.as_deref()?))));
    let inputs: Table = inputs.collect();
    (!inputs.is_empty()).then_some(Value::Table(inputs))
}

/// The reaction to each fault that the axis can have.
fn exception_actions(axis: &Axis) -> Value {
    let possible = FaultSet::possible(!axis.is_virtual());
    let faults = FAULTS.iter().filter(|fault| possible.contains(fault.kind));
    let actions = faults.map(|fault| {
        let action = axis.exception_actions.of(fault.kind);
        (fault.word, text(word_of(words::ACTIONS, &action)))
    });
    keys(actions)
}

fn home(home: &Home, sensor: Sensor) -> Value {
    let mut table = Table::new();
    let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
    put("mode", text(word_of(words::HOME_MODES, &home.mode)));
    put("sequence", text(word_of(words::HOME_SEQUENCES, &home.sequence)));
    put("direction", text(word_of(words::HOME_DIRECTIONS, &home.direction)));
    put("position", Value::Float(home.position));
    put("offset", Value::Float(home.offset));
    // 0 stands for a speed that is not given, which no key can say.
    for (key, speed) in [("speed", home.speed), ("return_speed", home.return_speed)] {
        if speed > 0.0 {
            put(key, Value::Float(speed));
        }
    }
    put("acceleration", Value::Float(home.acceleration));
    // A deceleration of 0 is the axis's own.
    if home.deceleration > 0.0 {
        put("deceleration", Value::Float(home.deceleration));
    }
    if let Some([min, max]) = sensor.switch {
        let ends = [("min", min), ("max", max)];
        let ends = ends.into_iter().filter(|(_, end)| end.is_finite());
        put("switch", keys(ends.map(|(key, end)| (key, Value::Float(end)))));
    }
    if let Some((at, every)) = sensor.marker {
        let places = [("at", Some(at)), ("every", every)];
        let places = places
            .into_iter()
            .filter_map(|(key, place)| Some((key, Value::Float(place?))));
        put("marker", keys(places));
    }
    Value::Table(table)
}

fn system(system: &CoordinateSystem, machine: &Machine) -> Value {
    let mut table = dynamics([
        system.max_speed,
        system.max_acceleration,
        system.max_deceleration,
        system.max_acceleration_jerk,
        system.max_deceleration_jerk,
    ]);
    table.extend(bits(system.dynamics_bits));
    let axes = system
        .axes
        .iter()
        .filter_map(|place| machine.axes.get(usize::from(*place)));
    let limits = |limits| text(word_of(words::LIMITS, &limits));
    if let Some(Robot { parameters, structure }) = &system.robot {
        let numbers = |numbers: &[f64]| Value::Array(numbers.iter().copied().map(Value::Float).collect());
        for (key, value) in [
            ("link_lengths", numbers(&parameters.link_lengths)),
            ("base_offsets", numbers(&parameters.base_offsets)),
            ("end_effector_offsets", numbers(&parameters.end_effector_offsets)),
            (
                "zero_angles",
                numbers(&parameters.zero_angles[..structure.joints().max(3)]),
            ),
        ] {
            table.insert(key.to_owned(), value);
        }
    }
    if let Some(orientation) = &system.orientation {
        for (key, number) in [
            ("max_orientation_speed", orientation.max_speed),
            ("max_orientation_acceleration", orientation.max_acceleration),
            ("max_orientation_deceleration", orientation.max_deceleration),
        ] {
            table.insert(key.to_owned(), Value::Float(number));
        }
    }
    if let Some(definition) = definition_of(system) {
        table.insert("definition".to_owned(), text(definition));
    }
    for (key, value) in [
        ("name", text(&system.name)),
        ("type", text(type_of_system(system.robot.as_ref()))),
        ("axes", Value::Array(axes.map(|axis| text(&axis.name)).collect())),
        ("actual_tolerance", Value::Float(system.actual_tolerance)),
        ("command_tolerance", Value::Float(system.command_tolerance)),
        ("queue_depth", Value::Integer(system.queue_depth as i64)),
        ("corner", text(word_of(words::CORNERS, &system.corner))),
        ("deviation", text(word_of(words::DEVIATIONS, &system.deviation))),
        ("axis_limits", limits(system.axis_limits)),
        ("joint_limits", limits(system.joint_limits)),
    ] {
        table.insert(key.to_owned(), value);
    }
    Value::Table(table)
}

/// The word of `definition`, where there is one.
pub fn definition_of(system: &CoordinateSystem) -> Option<&'static str> {
    match system.robot.map(|robot| robot.structure) {
        Some(KinematicStructure::Wrist(wrist)) => Some(wrist.definition()),
        Some(KinematicStructure::Arm(_)) => None,
        None => system.orientation.map(|_| Orientation::DEFINITION),
    }
}

/// The word of `type` of a coordinate system with this robot; `None`: it is Cartesian.
pub fn type_of_system(robot: Option<&Robot>) -> &'static str {
    match robot.map(|robot| robot.structure) {
        None => "cartesian",
        Some(KinematicStructure::Arm(geometry)) => match geometry {
            Geometry::ArticulatedIndependent2 | Geometry::ArticulatedIndependent3 => "articulated_independent",
            Geometry::ArticulatedDependent2 | Geometry::ArticulatedDependent3 => "articulated_dependent",
            Geometry::ScaraIndependent => "scara_independent",
            Geometry::ScaraDelta => "scara_delta",
            Geometry::Delta2 | Geometry::Delta3 => "delta",
        },
        Some(KinematicStructure::Wrist(wrist)) => {
            let named = WRISTS.iter().find(|(_, other)| *other == wrist);
            named.map_or("cartesian", |(word, _)| word)
        }
    }
}

fn data_type(template: &Template) -> Value {
    let visible = template.members.iter().filter(|member| !is_host(template, member));
    let members = visible.map(|member| keys([("name", text(&member.name)), ("type", text(&member_type(member)))]));
    keys([
        ("name", text(&template.name)),
        ("members", Value::Array(members.collect())),
    ])
}

/// Whether a member only holds BOOLs.
fn is_host(template: &Template, member: &Member) -> bool {
    let holds = |other: &Member| other.bit.is_some() && other.offset == member.offset;
    member.bit.is_none() && member.hidden && template.members.iter().any(holds)
}

fn member_type(member: &Member) -> String {
    match (&member.data_type, member.dimension) {
        (DataType::Elementary(Elementary::Dword), count) => format!("BOOL[{}]", 32 * u32::from(count)),
        (data_type, 0) => data_type.name().to_owned(),
        (data_type, count) => format!("{}[{count}]", data_type.name()),
    }
}

fn tag(tag: &PlainTag) -> Value {
    let mut table = Table::new();
    let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
    put("name", text(&tag.name));
    if let Some(program) = &tag.program {
        put("program", text(program));
    }
    put("access", text(word_of(words::ACCESS, &tag.access)));
    // Tags that no client writes, and aliases, have no rules of their own.
    if tag.rule.writers != Writers::Operators {
        put("write_role", text(word_of(words::WRITERS, &tag.rule.writers)));
    }
    let range = tag.rule.range.map(|range| [("min", range.least), ("max", range.most)]);
    for (key, bound) in range.into_iter().flatten().filter(|(_, bound)| bound.is_finite()) {
        put(key, Value::Float(bound));
    }
    match &tag.alias {
        Some(path) => {
            put("alias", text(&path.to_string()));
        }
        None => {
            let [count, ..] = tag.tag_type.dimensions;
            let tag_type = match tag.tag_type.data_type {
                DataType::Elementary(Elementary::Dword) => format!("BOOL[{}]", 32 * count),
                _ => tag.tag_type.to_string(),
            };
            put("type", text(&tag_type));
            if tag.first.iter().any(|byte| *byte != 0) {
                let rank = tag.tag_type.rank();
                put(
                    "value",
                    elements(&tag.tag_type.data_type, &tag.tag_type.dimensions[..rank], &tag.first),
                );
            }
        }
    }
    Value::Table(table)
}

fn elements(data_type: &DataType, dimensions: &[u32], bytes: &[u8]) -> Value {
    let [count, inner @ ..] = dimensions else {
        return one(data_type, bytes);
    };
    let count = *count as usize;
    if inner.is_empty() && matches!(data_type, DataType::Elementary(Elementary::Dword)) {
        let bit = |place: usize| bytes.get(place / 8).is_some_and(|byte| byte >> (place % 8) & 1 == 1);
        return Value::Array((0..32 * count).map(|place| Value::Boolean(bit(place))).collect());
    }
    let size = (bytes.len() / count.max(1)).max(1);
    let items = bytes
        .chunks(size)
        .take(count)
        .map(|bytes| elements(data_type, inner, bytes));
    Value::Array(items.collect())
}

fn one(data_type: &DataType, bytes: &[u8]) -> Value {
    match data_type {
        DataType::Elementary(Elementary::Bool) => Value::Boolean(bytes.first().is_some_and(|byte| *byte != 0)),
        DataType::Elementary(kind) => {
            let value = arcline_tag::Value::read(*kind, bytes);
            if let Some(arcline_tag::Value::Real(number)) = value {
                // The shortest text of the 32 bits, which reads back to them.
                return Value::Float(shortest(number));
            }
            match value
                .and_then(arcline_tag::Value::to_integer)
                .filter(|_| !kind.is_real())
            {
                Some(whole) => Value::Integer(whole),
                None => Value::Float(value.map_or(0.0, arcline_tag::Value::as_f64)),
            }
        }
        DataType::Structure(template) if template.is_string() => text(&string_text(bytes)),
        DataType::Structure(template) => {
            let visible = template.members.iter().filter(|member| !member.hidden);
            let values = visible.filter_map(|member| {
                let from = member.offset as usize;
                let value = match member.bit {
                    Some(bit) => Value::Boolean(bytes.get(from)? >> bit & 1 == 1),
                    None => {
                        let bytes = bytes.get(from..from + member.size())?;
                        let dimension = [u32::from(member.dimension)];
                        let dimensions = if member.dimension == 0 { &[][..] } else { &dimension };
                        elements(&member.data_type, dimensions, bytes)
                    }
                };
                Some((member.name.as_str(), value))
            });
            keys(values)
        }
    }
}

fn dynamics(maxima: [f64; 5]) -> Table {
    let keys = [
        "max_speed",
        "max_acceleration",
        "max_deceleration",
        "max_acceleration_jerk",
        "max_deceleration_jerk",
    ];
    let pairs = keys.into_iter().zip(maxima);
    pairs
        .map(|(key, number)| (key.to_owned(), Value::Float(number)))
        .collect()
}

/// The Dynamics Configuration Bits, where they are others than all.
fn bits(bits: DynamicsBits) -> Option<(String, Value)> {
    let key = "dynamics_configuration_bits".to_owned();
    (bits != DynamicsBits::ALL).then(|| (key, Value::Integer(bits.bits().into())))
}

fn list(root: &mut Table, key: &str, items: impl Iterator<Item = Value>) {
    let items: Vec<Value> = items.collect();
    if !items.is_empty() {
        root.insert(key.to_owned(), Value::Array(items));
    }
}

fn keys<'k>(pairs: impl IntoIterator<Item = (&'k str, Value)>) -> Value {
    Value::Table(pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
}

fn text(text: &str) -> Value {
    Value::String(text.to_owned())
}

fn message(row: &MessageAnswer) -> Value {
    let number = |value: u32| Value::Integer(value.into());
    let answer: Vec<String> = row.answer.iter().map(|byte| format!("{byte:02X}")).collect();
    let (err, exerr) = row.error;
    let all = [
        Some(("service", number(row.service.into()))),
        Some(("class", number(row.class.into()))),
        row.instance.map(|instance| ("instance", number(instance))),
        row.attribute.map(|attribute| ("attribute", number(attribute.into()))),
        (!answer.is_empty()).then(|| ("answer", text(&answer.join(" ")))),
        Some(("delay_ms", number(row.delay_ms))),
        Some(("err", number(err.into()))),
        Some(("exerr", number(exerr))),
    ];
    keys(all.into_iter().flatten())
}

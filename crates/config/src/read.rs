//! From the tables of the file to a [`Project`] that keeps what [`Machine`] promises. The only place
//! that lists the keys of the configuration (spec/contract.md §2).

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddr};

use arcline_instruction_set::{Mnemonic, Object};
use arcline_motion::machine::{
    Axis, AxisKind, AxisLimits, CoordinateSystem, Corner, Drive, MAX_AXES, MAX_PRIMARY_AXES, MAX_QUEUE_DEPTH,
    MAX_SYSTEMS, MAX_TRANSFORMS, Machine, Start, Transform, Travel, default_jerk,
};
use arcline_tag::{DataType, Elementary, TagType, string_template};
use toml::de::DeTable;

use crate::error::{ConfigError, Problem, nearest};
use crate::section::{NumberRule, Placed, Section, Source};
use crate::{InstructionTag, PlainTag, Project, ServerConfig};

/// Reads a whole file.
pub(crate) fn project(text: &str, file: &str) -> Result<Project, ConfigError> {
    let source = Source { file, text };
    if text.len() > MAX_TEXT {
        return Err(source.error(
            0,
            "",
            Problem::TooLarge {
                size: text.len(),
                limit: MAX_TEXT,
            },
        ));
    }
    let table = DeTable::parse(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        let message = error.message().lines().collect::<Vec<_>>().join(", ");
        source.error(offset, "", Problem::Syntax { message })
    })?;
    let root = Section::root(source, table.get_ref(), SECTIONS)?;
    let server = server(&root)?;
    let mut names = Taken::default();
    let machine = machine(&root, &mut names)?;
    let instruction_tags = instruction_tags(&root, &machine, &mut names)?;
    let tags = plain_tags(&root, &mut names)?;
    Ok(Project {
        server,
        machine,
        instruction_tags,
        tags,
    })
}

fn server(root: &Section<'_>) -> Result<ServerConfig, ConfigError> {
    let (section, _) = root.table("server", SERVER, "a table, [server]")?;
    let mut config = ServerConfig::default();
    if let Some(name) = section.string("name", PRODUCT_NAME)? {
        let printable = name.value.chars().all(|c| c == ' ' || c.is_ascii_graphic());
        if name.value.trim().is_empty() || name.value.len() > MAX_PRODUCT_NAME || !printable {
            return Err(section.refuse(&name, PRODUCT_NAME, None));
        }
        config.name = name.value;
    }
    if let Some(listen) = section.string("listen", LISTEN)? {
        config.listen = listen
            .value
            .parse()
            .map_err(|_| section.refuse(&listen, LISTEN, None))?;
    }
    if let Some(hmi) = section.string("hmi", HMI)? {
        config.hmi = if hmi.value.eq_ignore_ascii_case("off") {
            None
        } else {
            Some(hmi.value.parse().map_err(|_| section.refuse(&hmi, HMI, None))?)
        };
    }
    Ok(config)
}

fn machine(root: &Section<'_>, names: &mut Taken) -> Result<Machine, ConfigError> {
    let (group, _) = root.table("motion_group", MOTION_GROUP, "a table, [motion_group]")?;
    let group_name = match group.string("name", NAME)? {
        Some(name) => names.take(&group, name)?,
        None => names.take(
            &group,
            Placed {
                value: "Motion".into(),
                offset: 0,
                key: String::new(),
            },
        )?,
    };
    let period_ms = group.number("coarse_update_period_ms", &PERIOD)?.unwrap_or(1.0);
    // Within 250,000 and 32,000,000 by the rule: exact in both types.
    let period_ns = (period_ms * 1e6).round() as u64;

    let mut machine = Machine {
        period_ns,
        group: group_name,
        axes: Vec::new(),
        systems: Vec::new(),
        transforms: Vec::new(),
    };
    for section in root.tables("axis", AXIS, "tables, [[axis]]", MAX_AXES)? {
        machine.axes.push(axis(&section, names)?);
    }
    let systems = root.tables(
        "coordinate_system",
        COORDINATE_SYSTEM,
        "tables, [[coordinate_system]]",
        MAX_SYSTEMS,
    )?;
    for section in systems {
        let system = coordinate_system(&section, &machine, names)?;
        machine.systems.push(system);
    }
    for section in root.tables("transform", TRANSFORM, "tables, [[transform]]", MAX_TRANSFORMS)? {
        let transform = transform(&section, &machine, names)?;
        machine.transforms.push(transform);
    }
    Ok(machine)
}

fn axis(section: &Section<'_>, names: &mut Taken) -> Result<Axis, ConfigError> {
    let name = required_name(section, "name", names)?;
    let servo = match section.word("type", &["servo", "virtual"], AXIS_TYPE)? {
        Some(place) => place == 0,
        None => return Err(section.missing("type", AXIS_TYPE)),
    };
    let units = match section.string("units", UNITS)? {
        Some(units) if units.value.len() <= MAX_UNITS && !units.value.chars().any(char::is_control) => units.value,
        Some(units) => return Err(section.refuse(&units, UNITS, None)),
        None => "Position Units".to_owned(),
    };
    let dynamics = Dynamics::read(section)?;
    let unwind = section.number("unwind", &POSITIVE_LENGTH)?;
    let travel = travel(section)?;
    if travel.is_some() && unwind.is_some() {
        let problem = Problem::Conflict {
            other: "unwind",
            reason: "a rotary axis has no soft limits",
        };
        return Err(section.refuse_key("travel", problem));
    }
    let drive = drive(section)?;
    let kind = match (servo, drive) {
        (true, drive) => AxisKind::Servo(drive.unwrap_or_default()),
        (false, None) => AxisKind::Virtual,
        (false, Some(_)) => {
            let problem = Problem::Conflict {
                other: "type = \"virtual\"",
                reason: "only a servo has a drive",
            };
            return Err(section.refuse_key("drive", problem));
        }
    };
    Ok(Axis {
        name,
        kind,
        units,
        max_speed: dynamics.speed,
        max_acceleration: dynamics.acceleration,
        max_deceleration: dynamics.deceleration,
        max_acceleration_jerk: dynamics.acceleration_jerk,
        max_deceleration_jerk: dynamics.deceleration_jerk,
        travel,
        unwind,
        start: start(section, unwind)?,
    })
}

fn travel(axis: &Section<'_>) -> Result<Option<Travel>, ConfigError> {
    let (section, present) = axis.table("travel", &["min", "max"], "{ min = NUMBER, max = NUMBER }")?;
    if !present {
        return Ok(None);
    }
    let min = section.required_number("min", &ANY)?;
    let max = section.required_number("max", &ANY)?;
    if min >= max {
        let problem = Problem::Value {
            found: section.found("max"),
            expected: "a number above `min`",
            suggestion: None,
        };
        return Err(section.refuse_key("max", problem));
    }
    Ok(Some(Travel { min, max }))
}

fn drive(axis: &Section<'_>) -> Result<Option<Drive>, ConfigError> {
    let (section, present) = axis.table("drive", DRIVE, "a table such as { position_bandwidth_hz = 40.0 }")?;
    let default = Drive::default();
    let bandwidth = section.number("position_bandwidth_hz", &BANDWIDTH)?;
    let feedforward = section.number("velocity_feedforward", &SHARE)?;
    let tolerance = section.number("position_error_tolerance", &NOT_NEGATIVE_LENGTH)?;
    Ok(present.then(|| Drive {
        position_bandwidth_hz: bandwidth.unwrap_or(default.position_bandwidth_hz),
        velocity_feedforward: feedforward.unwrap_or(default.velocity_feedforward),
        position_error_tolerance: tolerance.unwrap_or(default.position_error_tolerance),
    }))
}

fn start(axis: &Section<'_>, unwind: Option<f64>) -> Result<Start, ConfigError> {
    let (section, _) = axis.table("start", START, "a table such as { position = 0.0, servo_on = true }")?;
    let default = Start::default();
    let position = section.number("position", &ANY)?.unwrap_or(default.position);
    if unwind.is_some_and(|turn| !(0.0..turn).contains(&position)) {
        let problem = Problem::Value {
            found: section.found("position"),
            expected: "a number from 0 to below `unwind`",
            suggestion: None,
        };
        return Err(section.refuse_key("position", problem));
    }
    Ok(Start {
        position,
        servo_on: section.boolean("servo_on")?.unwrap_or(default.servo_on),
        homed: section.boolean("homed")?.unwrap_or(default.homed),
    })
}

fn coordinate_system(
    section: &Section<'_>,
    machine: &Machine,
    names: &mut Taken,
) -> Result<CoordinateSystem, ConfigError> {
    let name = required_name(section, "name", names)?;
    section.word("type", &["cartesian"], "\"cartesian\"")?;
    let mut axes = Vec::new();
    for axis in section.strings("axes", PRIMARY_AXES, 1..=MAX_PRIMARY_AXES)? {
        let Some(place) = machine.axis(&axis.value) else {
            let known = machine.axes.iter().map(|axis| axis.name.as_str());
            return Err(unknown_name(section, &axis, "axis", known));
        };
        if axes.contains(&place) {
            return Err(section.refuse(&axis, "each axis once", None));
        }
        axes.push(place);
    }
    let dynamics = Dynamics::read(section)?;
    let corner = match section.word("corner", &["logix", "precise"], "\"logix\" or \"precise\"")? {
        Some(1) => Corner::Precise,
        _ => Corner::Logix,
    };
    let axis_limits = match section.word("axis_limits", &["ignore", "enforce"], "\"ignore\" or \"enforce\"")? {
        Some(1) => AxisLimits::Enforce,
        _ => AxisLimits::Ignore,
    };
    Ok(CoordinateSystem {
        name,
        axes,
        max_speed: dynamics.speed,
        max_acceleration: dynamics.acceleration,
        max_deceleration: dynamics.deceleration,
        max_acceleration_jerk: dynamics.acceleration_jerk,
        max_deceleration_jerk: dynamics.deceleration_jerk,
        actual_tolerance: section.number("actual_tolerance", &NOT_NEGATIVE_LENGTH)?.unwrap_or(0.0),
        command_tolerance: section
            .number("command_tolerance", &NOT_NEGATIVE_LENGTH)?
            .unwrap_or(0.0),
        queue_depth: section
            .integer("queue_depth", 1..=MAX_QUEUE_DEPTH, QUEUE_DEPTH)?
            .unwrap_or(1),
        corner,
        axis_limits,
    })
}

fn transform(section: &Section<'_>, machine: &Machine, names: &mut Taken) -> Result<Transform, ConfigError> {
    let name = required_name(section, "name", names)?;
    let system = |key| {
        let given = section
            .string(key, SYSTEM_NAME)?
            .ok_or_else(|| section.missing(key, SYSTEM_NAME))?;
        match machine.system(&given.value) {
            Some(place) => Ok((place, given)),
            None => {
                let known = machine.systems.iter().map(|system| system.name.as_str());
                Err(unknown_name(section, &given, "coordinate system", known))
            }
        }
    };
    let (source, _) = system("source")?;
    let (target, given) = system("target")?;
    if source == target {
        return Err(section.refuse(&given, "another coordinate system than `source`", None));
    }
    Ok(Transform { name, source, target })
}

fn instruction_tags(
    root: &Section<'_>,
    machine: &Machine,
    names: &mut Taken,
) -> Result<Vec<InstructionTag>, ConfigError> {
    let mut tags = Vec::new();
    for section in root.tables(
        "instruction",
        INSTRUCTION,
        "tables, [[instruction]]",
        MAX_INSTRUCTION_TAGS,
    )? {
        let tag = required_name(&section, "tag", names)?;
        let word = section
            .string("type", MNEMONIC)?
            .ok_or_else(|| section.missing("type", MNEMONIC))?;
        let Ok(mnemonic) = word.value.parse::<Mnemonic>() else {
            let known: Vec<String> = Mnemonic::ALL.iter().map(ToString::to_string).collect();
            let suggestion = nearest(&word.value, known.iter().map(String::as_str));
            return Err(section.refuse(&word, MNEMONIC, suggestion));
        };
        let target = match (mnemonic.instruction().object, section.string("target", TARGET)?) {
            (Object::MotionGroup, None) => machine.group.clone(),
            (_, None) => return Err(section.missing("target", TARGET)),
            (object, Some(given)) => target(&section, machine, object, &given)?,
        };
        tags.push(InstructionTag { tag, mnemonic, target });
    }
    Ok(tags)
}

/// The object's name as its own table spells it.
fn target(
    section: &Section<'_>,
    machine: &Machine,
    object: Object,
    given: &Placed<String>,
) -> Result<String, ConfigError> {
    let (what, known): (_, Vec<&str>) = match object {
        Object::MotionGroup => ("motion group", vec![machine.group.as_str()]),
        Object::Axis => ("axis", machine.axes.iter().map(|axis| axis.name.as_str()).collect()),
        Object::CoordinateSystem => (
            "coordinate system",
            machine.systems.iter().map(|system| system.name.as_str()).collect(),
        ),
    };
    match known.iter().find(|name| name.eq_ignore_ascii_case(&given.value)) {
        Some(name) => Ok((*name).to_owned()),
        None => Err(unknown_name(section, given, what, known.iter().copied())),
    }
}

fn plain_tags(root: &Section<'_>, names: &mut Taken) -> Result<Vec<PlainTag>, ConfigError> {
    let mut tags = Vec::new();
    for section in root.tables("tag", TAG, "tables, [[tag]]", MAX_TAGS)? {
        let name = required_name(&section, "name", names)?;
        let word = section
            .string("type", TAG_TYPE)?
            .ok_or_else(|| section.missing("type", TAG_TYPE))?;
        let Some(tag_type) = tag_type(&word.value) else {
            let element = word.value.split('[').next().unwrap_or_default().trim();
            let suggestion =
                nearest(element, TYPE_NAMES.iter().copied()).filter(|name| !name.eq_ignore_ascii_case(element));
            return Err(section.refuse(&word, TAG_TYPE, suggestion));
        };
        tags.push(PlainTag { name, tag_type });
    }
    Ok(tags)
}

/// `REAL`, `REAL[16]`, `STRING[4]`.
fn tag_type(text: &str) -> Option<TagType> {
    let (element, dimension) = match text.trim().split_once('[') {
        None => (text.trim(), 0),
        Some((element, rest)) => {
            let count: u32 = rest.strip_suffix(']')?.trim().parse().ok()?;
            if !(1..=MAX_ELEMENTS).contains(&count) {
                return None;
            }
            (element.trim(), count)
        }
    };
    let name = TYPE_NAMES.iter().find(|name| name.eq_ignore_ascii_case(element))?;
    if *name == "BOOL" && dimension > 0 {
        return Some(TagType::bool_array(dimension));
    }
    let data_type = match Elementary::from_name(name) {
        Some(elementary) => DataType::Elementary(elementary),
        None => DataType::Structure(string_template()),
    };
    Some(TagType {
        data_type,
        dimensions: [dimension, 0, 0],
    })
}

/// The five maxima that an axis and a coordinate system have alike.
struct Dynamics {
    speed: f64,
    acceleration: f64,
    deceleration: f64,
    acceleration_jerk: f64,
    deceleration_jerk: f64,
}

impl Dynamics {
    fn read(section: &Section<'_>) -> Result<Self, ConfigError> {
        let speed = section.required_number("max_speed", &POSITIVE_SPEED)?;
        let acceleration = section.required_number("max_acceleration", &POSITIVE_RATE)?;
        let deceleration = section
            .number("max_deceleration", &NOT_NEGATIVE_RATE)?
            .unwrap_or(acceleration);
        let acceleration_jerk = section.number("max_acceleration_jerk", &POSITIVE_JERK)?;
        let deceleration_jerk = section.number("max_deceleration_jerk", &NOT_NEGATIVE_JERK)?;
        Ok(Self {
            speed,
            acceleration,
            deceleration,
            acceleration_jerk: acceleration_jerk.unwrap_or_else(|| default_jerk(speed, acceleration)),
            deceleration_jerk: deceleration_jerk.unwrap_or_else(|| default_jerk(speed, deceleration)),
        })
    }
}

/// The names in use, in lower case, with the line of each.
#[derive(Default)]
struct Taken(BTreeMap<String, usize>);

impl Taken {
    fn take(&mut self, section: &Section<'_>, name: Placed<String>) -> Result<String, ConfigError> {
        if !is_name(&name.value) {
            return Err(section.refuse(&name, NAME, None));
        }
        let line = section.source.line(name.offset);
        match self.0.insert(name.value.to_ascii_lowercase(), line) {
            None => Ok(name.value),
            Some(line) => {
                let problem = Problem::Duplicate { name: name.value, line };
                Err(section.source.error(name.offset, name.key, problem))
            }
        }
    }
}

/// Whether a tag can have that name: 1 to 40 letters, digits and underscores, no digit first.
fn is_name(text: &str) -> bool {
    text.len() <= MAX_NAME
        && text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn required_name(section: &Section<'_>, key: &'static str, names: &mut Taken) -> Result<String, ConfigError> {
    let name = section.string(key, NAME)?.ok_or_else(|| section.missing(key, NAME))?;
    names.take(section, name)
}

fn unknown_name<'n>(
    section: &Section<'_>,
    given: &Placed<String>,
    what: &'static str,
    known: impl IntoIterator<Item = &'n str>,
) -> ConfigError {
    let suggestion = nearest(&given.value, known);
    let name = given.value.chars().take(60).collect();
    let problem = Problem::UnknownName { what, name, suggestion };
    section.source.error(given.offset, given.key.clone(), problem)
}

/// EtherNet/IP's own port.
pub(crate) const DEFAULT_LISTEN: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 44_818);
/// The pages' port.
pub(crate) const DEFAULT_HMI: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

/// 4 MiB hold every axis, system and tag there can be many times over.
const MAX_TEXT: usize = 4 << 20;
/// The Identity object's Product Name is a SHORT_STRING of up to 32 characters.
const MAX_PRODUCT_NAME: usize = 32;
const MAX_NAME: usize = 40;
const MAX_UNITS: usize = 40;
const MAX_INSTRUCTION_TAGS: usize = 1024;
const MAX_TAGS: usize = 4096;
/// Elements of one array.
const MAX_ELEMENTS: u32 = 65_535;

const SECTIONS: &[&str] = &[
    "server",
    "motion_group",
    "axis",
    "coordinate_system",
    "transform",
    "instruction",
    "tag",
];
const SERVER: &[&str] = &["name", "listen", "hmi"];
const MOTION_GROUP: &[&str] = &["name", "coarse_update_period_ms"];
const AXIS: &[&str] = &[
    "name",
    "type",
    "units",
    "max_speed",
    "max_acceleration",
    "max_deceleration",
    "max_acceleration_jerk",
    "max_deceleration_jerk",
    "travel",
    "unwind",
    "start",
    "drive",
];
const START: &[&str] = &["position", "servo_on", "homed"];
const DRIVE: &[&str] = &[
    "position_bandwidth_hz",
    "velocity_feedforward",
    "position_error_tolerance",
];
const COORDINATE_SYSTEM: &[&str] = &[
    "name",
    "type",
    "axes",
    "max_speed",
    "max_acceleration",
    "max_deceleration",
    "max_acceleration_jerk",
    "max_deceleration_jerk",
    "actual_tolerance",
    "command_tolerance",
    "queue_depth",
    "corner",
    "axis_limits",
];
const TRANSFORM: &[&str] = &["name", "source", "target"];
const INSTRUCTION: &[&str] = &["tag", "type", "target"];
const TAG: &[&str] = &["name", "type"];
const TYPE_NAMES: &[&str] = &[
    "BOOL", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "REAL", "LREAL", "STRING",
];

const NAME: &str = "a name: 1 to 40 letters, digits and underscores, no digit first";
const PRODUCT_NAME: &str = "1 to 32 printable ASCII characters";
const LISTEN: &str = "an address and port such as \"127.0.0.1:44818\"";
const HMI: &str = "an address and port such as \"127.0.0.1:8080\", or \"off\"";
const UNITS: &str = "a label of up to 40 bytes such as \"mm\"";
const AXIS_TYPE: &str = "\"servo\" or \"virtual\"";
const PRIMARY_AXES: &str = "a list of 1 to 3 names of axes";
const QUEUE_DEPTH: &str = "a whole number from 1 to 1000";
const SYSTEM_NAME: &str = "the name of a coordinate system";
const MNEMONIC: &str = "the mnemonic of a motion instruction such as \"MCLM\"";
const TARGET: &str = "the name of the coordinate system, axis or group that the instruction acts on";
const TAG_TYPE: &str = "BOOL, SINT, INT, DINT, LINT, USINT, UINT, UDINT, REAL, LREAL or STRING, \
     or an array of 1 to 65535 of them such as REAL[16]";

const PERIOD: NumberRule = NumberRule {
    expected: "a number from 0.25 to 32 (ms)",
    holds: |x| (0.25..=32.0).contains(&x),
};
const POSITIVE_SPEED: NumberRule = NumberRule {
    expected: "a number above 0 (units/s)",
    holds: |x| x > 0.0,
};
const POSITIVE_RATE: NumberRule = NumberRule {
    expected: "a number above 0 (units/s²)",
    holds: |x| x > 0.0,
};
const NOT_NEGATIVE_RATE: NumberRule = NumberRule {
    expected: "a number, 0 or more (units/s²)",
    holds: |x| x >= 0.0,
};
const POSITIVE_JERK: NumberRule = NumberRule {
    expected: "a number above 0 (units/s³)",
    holds: |x| x > 0.0,
};
const NOT_NEGATIVE_JERK: NumberRule = NumberRule {
    expected: "a number, 0 or more (units/s³)",
    holds: |x| x >= 0.0,
};
const POSITIVE_LENGTH: NumberRule = NumberRule {
    expected: "a number above 0 (position units)",
    holds: |x| x > 0.0,
};
const NOT_NEGATIVE_LENGTH: NumberRule = NumberRule {
    expected: "a number, 0 or more (position units)",
    holds: |x| x >= 0.0,
};
const BANDWIDTH: NumberRule = NumberRule {
    expected: "a number above 0, at most 10000 (Hz)",
    holds: |x| x > 0.0 && x <= 10_000.0,
};
const SHARE: NumberRule = NumberRule {
    expected: "a number from 0 to 1",
    holds: |x| (0.0..=1.0).contains(&x),
};
const ANY: NumberRule = NumberRule {
    expected: "a finite number (position units)",
    holds: |_| true,
};

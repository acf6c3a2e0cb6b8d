//! From the tables of the file to a [`Project`] that keeps what [`Machine`] promises. This file and its folder are
//! the only place that lists the keys of the configuration (spec/contract.md §2); a table's keys stand where the
//! table is read.

mod axis;
mod dynamics;
mod home;
mod inputs;
mod names;
mod robot;
mod server;
mod system;
mod tags;
mod types;
mod value;

use arcline_controller::machine::{MAX_AXES, MAX_SYSTEMS, MAX_TRANSFORMS, Machine};
use toml::de::DeTable;

use self::axis::{AXIS, axis};
use self::inputs::check_inputs;
use self::names::{NAME, Taken};
pub(crate) use self::robot::WRISTS;
pub use self::robot::definitions;
use self::server::server;
use self::system::{COORDINATE_SYSTEM, TRANSFORM, coordinate_system, transform};
use self::tags::{instruction_tags, plain_tags};
use self::types::Types;
use crate::Project;
use crate::error::{ConfigError, Problem};
use crate::section::{NumberRule, Placed, Section, Source};

pub use self::names::is_name;
pub(crate) use self::server::{DEFAULT_HMI, DEFAULT_LISTEN};
pub use self::types::{ELEMENTARY, MAX_ELEMENTS, MAX_MEMBERS, MAX_SIZE, MAX_TYPES, tag_type};

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
    let types = Types::read(&root)?;
    let tags = plain_tags(&root, &types, &mut names)?;
    check_inputs(&root, &machine, &instruction_tags, &tags)?;
    Ok(Project {
        server,
        machine,
        instruction_tags,
        types: types.in_order(),
        tags,
    })
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

/// 4 MiB hold every axis, system and tag there can be many times over.
const MAX_TEXT: usize = 4 << 20;

const SECTIONS: &[&str] = &[
    "server",
    "motion_group",
    "axis",
    "coordinate_system",
    "transform",
    "instruction",
    "data_type",
    "tag",
];
/// Every key that is read, by the heading of its table in docs/CONFIGURATION.md.
pub(crate) const KEYS: &[(&str, &[&str])] = &[
    ("## `[server]`", server::SERVER),
    ("## `[motion_group]`", MOTION_GROUP),
    ("## `[[axis]]`", AXIS),
    ("### `start = { … }`", axis::START),
    ("### `drive = { … }`", axis::DRIVE),
    ("### `exception_actions = { … }`", &axis::EXCEPTION_ACTIONS),
    ("### `travel = { … }`", axis::TRAVEL),
    ("### `home = { … }`", home::HOME),
    ("### `switch = { … }`", home::SWITCH),
    ("### `marker = { … }`", home::MARKER),
    ("## `[[coordinate_system]]`", COORDINATE_SYSTEM),
    ("## `[[transform]]`", TRANSFORM),
    ("## `[[instruction]]`", tags::INSTRUCTION),
    ("## `[[data_type]]`", types::DATA_TYPE),
    ("### `members = [{ … }]`", types::MEMBER),
    ("## `[[tag]]`", tags::TAG),
];

const MOTION_GROUP: &[&str] = &["name", "coarse_update_period_ms"];

const PERIOD: NumberRule = NumberRule {
    expected: "a number from 0.25 to 32 (ms)",
    holds: |x| (0.25..=32.0).contains(&x),
};
const NOT_NEGATIVE_LENGTH: NumberRule = NumberRule {
    expected: "a number, 0 or more (position units)",
    holds: |x| x >= 0.0,
};

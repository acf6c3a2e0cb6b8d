//! From the tables of the file to a [`Project`] that keeps the promises of [`Machine`] (spec/contract.md §2). The table `keys` has the values
//! that each key may have; this module has the rules between keys, and makes the objects. It reports a wrong key and goes on with the default,
//! so that it finds all errors of a file at once.

mod axis;
mod dynamics;
mod home;
mod inputs;
mod names;
mod robot;
mod security;
mod server;
mod system;
mod tags;
mod types;
mod value;

pub(crate) use server::hex_bytes;
use std::cell::RefCell;

use arcline_controller::machine::{HomeSwitch, Machine, MotionGroup};
use toml::de::DeTable;

use self::axis::axis;
use self::inputs::check_inputs;
use self::names::Taken;
pub(crate) use self::robot::WRISTS;
pub use self::robot::definitions;
use self::security::security;
use self::server::server;
use self::system::{coordinate_system, transform};
use self::tags::{instruction_tags, plain_tags};
use self::types::Types;
use crate::error::{ConfigError, Problem};
use crate::keys::ROOT;
use crate::section::{Placed, Section, Source};
use crate::{ControllerConfig, Project, ServerConfig, WireConfig};

pub use self::names::is_name;
pub use self::types::{ELEMENTARY, MAX_ELEMENTS, MAX_MEMBERS, MAX_SIZE, MAX_TYPES, tag_type};
pub(crate) use self::types::{member_types, tag_types};

/// Reads a whole file.
///
/// # Errors
/// All that is wrong, in the order of the file.
pub(crate) fn project(text: &str, file: &str) -> Result<Project, Vec<ConfigError>> {
    let errors = RefCell::new(Vec::new());
    let line_ends: Vec<usize> = text.match_indices('\n').map(|(offset, _)| offset).collect();
    let source = Source {
        file,
        text,
        line_ends: &line_ends,
        errors: &errors,
    };
    let project = parse(source);
    let mut errors = errors.into_inner();
    // Stable: at one place the first reason comes first.
    errors.sort_by_key(|error| (error.line, error.column));
    match project {
        Some(project) if errors.is_empty() => Ok(project),
        _ => Err(errors),
    }
}

/// The server of a file without keys: each has the default of the table of keys.
pub(crate) fn default_server() -> ServerConfig {
    let errors = RefCell::new(Vec::new());
    let source = Source {
        file: "",
        text: "",
        line_ends: &[],
        errors: &errors,
    };
    server(&Section::root(source, &DeTable::default(), &ROOT))
}

fn parse(source: Source<'_>) -> Option<Project> {
    if source.text.len() > MAX_TEXT {
        let problem = Problem::TooLarge {
            size: source.text.len(),
            limit: MAX_TEXT,
        };
        source.report(0, "", problem);
        return None;
    }
    let (table, errors) = DeTable::parse_recoverable(source.text);
    for error in &errors {
        let offset = error.span().map_or(0, |span| span.start);
        let message = error.message().lines().collect::<Vec<_>>().join(", ");
        source.report(offset, "", Problem::Syntax { message });
    }
    if !errors.is_empty() {
        return None;
    }
    let root = Section::root(source, table.get_ref(), &ROOT);
    root.check();
    let server = server(&root);
    let mut names = Taken::default();
    let mut machine = machine(&root, &mut names);
    wire_home_switches(&mut machine, &server.controller);
    let instruction_tags = instruction_tags(&root, &machine, &mut names);
    let types = Types::read(&root);
    let tags = plain_tags(&root, &types, &mut names);
    // Only a machine that is whole has tags to look for.
    if source.errors.borrow().is_empty() {
        check_inputs(&root, &machine, &instruction_tags, &tags);
    }
    Some(Project {
        server,
        machine,
        instruction_tags,
        types: types.in_order(),
        tags,
    })
}

/// An axis whose home switch a wire gives can be homed to it, in either direction.
fn wire_home_switches(machine: &mut Machine, controller: &ControllerConfig) {
    for name in controller.wires.iter().filter_map(WireConfig::home_switch) {
        let Machine { motion, drives } = machine;
        for (axis, drive) in motion.axes.iter_mut().zip(drives) {
            if axis.name.eq_ignore_ascii_case(name) && drive.is_some() {
                axis.home.inputs.switch = Some(HomeSwitch::Both);
            }
        }
    }
}

fn machine(root: &Section<'_>, names: &mut Taken) -> Machine {
    let (group, _) = root.table("motion_group");
    let group_name = group.text("name").unwrap_or_else(|| Placed {
        value: group.text_or_default("name"),
        offset: 0,
        key: String::new(),
    });
    let group_name = names.take(&group, group_name);
    let period_ms = group.required("coarse_update_period_ms");
    // Within 250,000 and 32,000,000 by the rule: exact in both types.
    let period_ns = (period_ms * 1e6).round() as u64;
    let mut machine = Machine::new(MotionGroup {
        period_ns,
        group: group_name,
        axes: Vec::new(),
        systems: Vec::new(),
        transforms: Vec::new(),
    });
    for section in root.tables("axis") {
        let (axis, drive) = axis(&section, names);
        machine.axes.push(axis);
        machine.drives.push(drive);
    }
    for section in root.tables("coordinate_system") {
        let system = coordinate_system(&section, &machine, names);
        machine.systems.push(system);
    }
    for section in root.tables("transform") {
        let transform = transform(&section, &machine, names);
        machine.transforms.push(transform);
    }
    machine
}

/// 4 MiB hold every axis, system and tag there can be many times over.
const MAX_TEXT: usize = 4 << 20;

//! The motion group, axes and coordinate systems (spec/axis-and-data-types.md §9).

mod axis;
mod drive;
mod dynamics;
mod home;
mod system;

use arcline_config::is_name;
use roxmltree::Node;
use toml::{Table, Value};

use super::Importer;
use super::tags::Scope;
use crate::document::{child, children};
use crate::{L5xError, Reason};

pub(crate) use drive::ACTIONS;
pub(crate) use system::{ORIENTATION, ROBOT, SYSTEM_TYPES, UNDEFINED};

/// Whether a tag is of a motion type; this module reads such a tag, not the one of plain tags.
pub(super) fn is_motion(tag: Node<'_, '_>) -> bool {
    let word = tag.attribute("DataType").unwrap_or_default();
    word.starts_with("AXIS_") || ["COORDINATE_SYSTEM", "MOTION_GROUP"].contains(&word)
}

impl<'a, 't> Importer<'a, 't> {
    pub(super) fn motion(&mut self, scopes: &[Scope<'a, 't>]) -> Result<(), L5xError> {
        let mut tags = Vec::new();
        for (program, list) in scopes {
            let bases = children(*list, "Tag").filter(|tag| tag.attribute("TagType") != Some("Alias"));
            for tag in bases.filter(|tag| is_motion(*tag)) {
                let name = self.source.required(tag, "Name", "the tag's name")?;
                self.source.check(tag);
                if program.is_some() || !is_name(name) {
                    self.source.report(tag, Reason::NoCounterpart);
                } else {
                    tags.push((tag, name, tag.attribute("DataType").unwrap_or_default()));
                }
            }
        }
        for (tag, name, word) in &tags {
            if *word == "MOTION_GROUP" {
                self.group(*tag, name)?;
            }
        }
        let mut axes = Vec::new();
        for (tag, name, word) in &tags {
            let virtual_axis = match *word {
                "AXIS_VIRTUAL" => true,
                "AXIS_CIP_DRIVE" => false,
                "AXIS_SERVO" | "AXIS_SERVO_DRIVE" | "AXIS_GENERIC" | "AXIS_GENERIC_DRIVE" => {
                    self.source.report(
                        *tag,
                        Reason::Changed("an axis of an older drive becomes an AXIS_CIP_DRIVE"),
                    );
                    false
                }
                "MOTION_GROUP" | "COORDINATE_SYSTEM" => continue,
                _ => {
                    self.source.report(*tag, Reason::NoCounterpart);
                    continue;
                }
            };
            if self.axis(*tag, name, virtual_axis)? {
                axes.push(*name);
            }
        }
        for (tag, name, word) in &tags {
            if *word == "COORDINATE_SYSTEM" {
                self.system(*tag, name, &axes)?;
            }
        }
        Ok(())
    }

    /// The attributes of a motion tag: the only element in its `Data` of that format.
    fn parameters(&mut self, tag: Node<'a, 't>, format: &str, element: &'static str) -> Option<Node<'a, 't>> {
        self.access_of_motion(tag);
        for data in children(tag, "Data") {
            self.source.check(data);
            if data.attribute("Format") == Some(format)
                && let Some(parameters) = child(data, element)
            {
                self.source.check(parameters);
                return Some(parameters);
            }
        }
        self.source
            .report(tag, Reason::Changed("without its parameters, so at the defaults"));
        None
    }

    fn access_of_motion(&mut self, tag: Node<'a, 't>) {
        if !matches!(tag.attribute("ExternalAccess"), None | Some("Read/Write")) {
            self.source
                .report_attribute(tag, "ExternalAccess", Reason::NoCounterpart);
        }
    }

    fn group(&mut self, tag: Node<'a, 't>, name: &str) -> Result<(), L5xError> {
        if self.config.contains_key("motion_group") {
            self.source.report(tag, Reason::NoCounterpart);
            return Ok(());
        }
        let mut group = Table::from_iter([("name".to_owned(), Value::String(name.to_owned()))]);
        if let Some(parameters) = self.parameters(tag, "MotionGroup", "MotionGroupParameters")
            && let Some(period) = self.source.number(parameters, "CoarseUpdatePeriod")?
        {
            if !(250.0..=32_000.0).contains(&period) {
                return Err(self.source.wrong(parameters, "CoarseUpdatePeriod", "250 to 32000 µs"));
            }
            group.insert("coarse_update_period_ms".into(), Value::Float(period / 1000.0));
        }
        self.config.insert("motion_group".into(), Value::Table(group));
        Ok(())
    }
}

fn put(table: &mut Table, key: &str, value: Value) {
    table.insert(key.to_owned(), value);
}

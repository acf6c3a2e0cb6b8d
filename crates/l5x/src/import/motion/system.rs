//! A coordinate system: its axes, the robot that it is, tolerances and queue.

use std::ops::RangeInclusive;

use arcline_controller::machine::{MAX_PRIMARY_AXES, MAX_QUEUE_DEPTH, MAX_SYSTEMS};
use roxmltree::Node;
use toml::{Table, Value};

use super::super::Importer;
use super::put;
use crate::{L5xError, Reason};

impl<'a, 't> Importer<'a, 't> {
    pub(super) fn system(&mut self, tag: Node<'a, 't>, name: &str, axes: &[&str]) -> Result<(), L5xError> {
        let Some(node) = self.parameters(tag, "CoordinateSystem", "CoordinateSystemParameters") else {
            return Ok(());
        };
        let names: Vec<&str> = node.attribute("Axes").unwrap_or_default().split_whitespace().collect();
        let known = |name: &&str| axes.iter().any(|axis| axis.eq_ignore_ascii_case(name));
        let each_once = names
            .iter()
            .enumerate()
            .all(|(place, name)| names.iter().take(place).all(|other| !other.eq_ignore_ascii_case(name)));
        let word = node.attribute("SystemType").unwrap_or(CARTESIAN);
        let build = SYSTEM_TYPES.iter().find(|build| build.word == word);
        let definition = node.attribute("CoordinateDefinition").filter(|word| *word != UNDEFINED);
        let defined = definition.map(|word| {
            let known = build.map(|build| arcline_config::definitions(build.key));
            known.into_iter().flatten().find(|(other, _)| *other == word)
        });
        let fits = |build: &SystemType| match defined {
            Some(defined) => defined.is_some_and(|(_, axes)| axes == names.len()),
            None => build.axes.contains(&names.len()),
        };
        let unlike = if build.is_none() {
            Some("SystemType")
        } else if defined == Some(None) {
            Some("CoordinateDefinition")
        } else if !build.is_some_and(fits) || !names.iter().all(known) || !each_once {
            Some("Axes")
        } else {
            None
        };
        if unlike.is_some() || self.count("coordinate_system") >= MAX_SYSTEMS {
            if let Some(attribute) = unlike {
                self.source.report_attribute(node, attribute, Reason::NoCounterpart);
            }
            self.source.report(tag, Reason::NoCounterpart);
            return Ok(());
        }
        let mut system = Table::new();
        put(&mut system, "name", Value::String(name.to_owned()));
        let robot = build.filter(|build| build.word != CARTESIAN);
        system.extend(robot.map(|build| ("type".to_owned(), Value::String(build.key.to_owned()))));
        system.extend(definition.map(|word| ("definition".to_owned(), Value::String(word.to_owned()))));
        self.robot(node, robot.map(|_| names.len()), &mut system)?;
        self.orientation(node, definition.filter(|_| robot.is_none()), &mut system)?;
        let words = "transforms take all axes";
        if let Some(dimension) = self.source.number(node, "TransformDimension")?
            && dimension != 0.0
            && dimension != names.len() as f64
        {
            self.source
                .report_attribute(node, "TransformDimension", Reason::Changed(words));
        }
        let names = names.into_iter().map(|name| Value::String(name.to_owned()));
        put(&mut system, "axes", Value::Array(names.collect()));
        self.dynamics(node, "coordinate_system", name, &mut system)?;
        self.tolerances(node, &mut system)?;
        self.queue(node, &mut system)?;
        self.push("coordinate_system", tag, system);
        Ok(())
    }

    /// The maxima of turns, which only a definition with orientations has.
    fn orientation(
        &mut self,
        node: Node<'a, 't>,
        definition: Option<&str>,
        system: &mut Table,
    ) -> Result<(), L5xError> {
        for (attribute, key) in ORIENTATION {
            let number = self.source.number(node, attribute)?.filter(|number| *number != 0.0);
            match number {
                Some(number) if number < 0.0 => return Err(self.source.wrong(node, attribute, "a number, 0 or more")),
                Some(_) if definition.is_none() => {
                    self.source.report_attribute(node, attribute, Reason::NoCounterpart);
                }
                number => system.extend(number.map(|number| (key.to_owned(), Value::Float(number)))),
            }
        }
        Ok(())
    }

    fn tolerances(&mut self, node: Node<'a, 't>, system: &mut Table) -> Result<(), L5xError> {
        for (attribute, key) in [
            ("ActualPositionTolerance", "actual_tolerance"),
            ("CommandPositionTolerance", "command_tolerance"),
        ] {
            match self.source.number(node, attribute)? {
                Some(number) if number < 0.0 => return Err(self.source.wrong(node, attribute, "a number, 0 or more")),
                number => system.extend(number.map(|number| (key.to_owned(), Value::Float(number)))),
            }
        }
        Ok(())
    }

    fn queue(&mut self, node: Node<'a, 't>, system: &mut Table) -> Result<(), L5xError> {
        if let Some(word) = node.attribute("MaximumPendingMoves") {
            match word.parse() {
                // An export of a version without a queue.
                Ok(0) => {}
                Ok(depth @ 1..=MAX_QUEUE_DEPTH) => put(system, "queue_depth", Value::Integer(depth as i64)),
                _ => {
                    return Err(self
                        .source
                        .wrong(node, "MaximumPendingMoves", "a whole number from 1 to 1000"));
                }
            }
        }
        Ok(())
    }

    /// The dimensions of a robot. A Cartesian system has none: attributes with dimensions are reported.
    fn robot(&mut self, node: Node<'a, 't>, joints: Option<usize>, system: &mut Table) -> Result<(), L5xError> {
        for (key, attributes) in ROBOT {
            let mut numbers = Vec::new();
            let has = match joints {
                Some(joints) if *key == ZERO_ANGLES => joints.max(3),
                Some(_) => attributes.len(),
                None => 0,
            };
            for (place, attribute) in attributes.iter().enumerate() {
                let number = self.source.number(node, attribute)?.unwrap_or(0.0);
                if place < has {
                    numbers.push(Value::Float(number));
                } else if number != 0.0 {
                    self.source.report_attribute(node, attribute, Reason::NoCounterpart);
                }
            }
            if joints.is_some() {
                put(system, key, Value::Array(numbers));
            }
        }
        Ok(())
    }
}

/// A kind of coordinate system, and how many axes it can have.
pub(crate) struct SystemType {
    /// SystemType.
    pub(crate) word: &'static str,
    /// `type` of a configuration.
    pub(crate) key: &'static str,
    axes: RangeInclusive<usize>,
}

const CARTESIAN: &str = "Cartesian";

/// The kinds of coordinate systems.
#[rustfmt::skip]
pub(crate) const SYSTEM_TYPES: &[SystemType] = &[
    SystemType { word: CARTESIAN, key: "cartesian", axes: 1..=MAX_PRIMARY_AXES },
    SystemType { word: "Articulated Independent", key: "articulated_independent", axes: 2..=3 },
    SystemType { word: "Articulated Dependent", key: "articulated_dependent", axes: 2..=3 },
    SystemType { word: "SCARA Independent", key: "scara_independent", axes: 3..=3 },
    SystemType { word: "SCARA Delta", key: "scara_delta", axes: 3..=3 },
    SystemType { word: "Delta", key: "delta", axes: 2..=3 },
];

/// The dimensions of a robot: the key of a configuration and the attributes of its entries.
pub(crate) const ROBOT: &[(&str, &[&str])] = &[
    ("link_lengths", &["LinkLength1", "LinkLength2"]),
    ("base_offsets", &["BaseOffset1", "BaseOffset2", "BaseOffset3"]),
    (
        "end_effector_offsets",
        &["EndEffectorOffset1", "EndEffectorOffset2", "EndEffectorOffset3"],
    ),
    (
        ZERO_ANGLES,
        &[
            "ZeroAngleOffset1",
            "ZeroAngleOffset2",
            "ZeroAngleOffset3",
            "ZeroAngleOffset4",
            "ZeroAngleOffset5",
            "ZeroAngleOffset6",
        ],
    ),
];
/// The key with an entry a joint.
const ZERO_ANGLES: &str = "zero_angles";

/// The maxima of a turn: attribute and key. 0 stands for the least of Rx, Ry and Rz.
pub(crate) const ORIENTATION: [(&str, &str); 3] = [
    ("MaximumOrientationSpeed", "max_orientation_speed"),
    ("MaximumOrientationAcceleration", "max_orientation_acceleration"),
    ("MaximumOrientationDeceleration", "max_orientation_deceleration"),
];

/// CoordinateDefinition of a coordinate system that has none.
pub(crate) const UNDEFINED: &str = "<none>";

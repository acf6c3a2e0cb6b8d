//! The motion group, axes and coordinate systems (spec/axis-and-data-types.md §9).

use std::ops::RangeInclusive;

use arcline_config::is_name;
use arcline_controller::machine::{
    MAX_AXES, MAX_OUTPUT_TARGETS, MAX_PRIMARY_AXES, MAX_QUEUE_DEPTH, MAX_SYSTEMS, ProgrammedStopMode,
};
use arcline_instruction_set::{DYNAMICS_CONFIGURATION_BITS, ExceptionAction, FAULTS, FaultSet, FaultWord};
use roxmltree::Node;
use toml::{Table, Value};

use super::Importer;
use super::tags::Scope;
use crate::document::{child, children};
use crate::{L5xError, Reason};

/// Whether a tag is of a motion type, which are read here and not among the plain tags.
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

    /// Adds an axis; `false`: it is none that moves.
    fn axis(&mut self, tag: Node<'a, 't>, name: &str, virtual_axis: bool) -> Result<bool, L5xError> {
        if self.count("axis") >= MAX_AXES {
            self.source.report(tag, Reason::NoCounterpart);
            return Ok(false);
        }
        let mut axis = Table::new();
        put(&mut axis, "name", Value::String(name.to_owned()));
        put(
            &mut axis,
            "type",
            Value::String(if virtual_axis { "virtual" } else { "servo" }.into()),
        );
        let Some(node) = self.parameters(tag, "Axis", "AxisParameters") else {
            put(&mut axis, "max_speed", Value::Float(FALLBACK_SPEED));
            put(&mut axis, "max_acceleration", Value::Float(FALLBACK_RATE));
            self.push("axis", tag, axis);
            return Ok(true);
        };
        match node.attribute("AxisConfiguration") {
            None | Some("Position Loop") => {}
            Some("Velocity Loop" | "Torque Loop" | "Frequency Control") => {
                let words = "every servo closes the position loop";
                self.source
                    .report_attribute(node, "AxisConfiguration", Reason::Changed(words));
            }
            Some(_) => {
                // A converter or an encoder: nothing that moves.
                self.source
                    .report_attribute(node, "AxisConfiguration", Reason::NoCounterpart);
                self.source.report(tag, Reason::NoCounterpart);
                return Ok(false);
            }
        }
        if let Some(units) = node.attribute("PositionUnits") {
            let fits: String = units.chars().filter(|c| !c.is_control()).collect();
            if fits.len() <= MAX_UNITS {
                put(&mut axis, "units", Value::String(fits));
            } else {
                self.source
                    .report_attribute(node, "PositionUnits", Reason::NoCounterpart);
            }
        }
        let speed = self.dynamics(node, "axis", name, &mut axis)?;
        if let Some(time) = self.source.number(node, "AverageVelocityTimebase")? {
            if time > 0.0 && time <= 1.0 {
                put(&mut axis, "average_velocity_timebase", Value::Float(time));
            } else {
                let words = "an average velocity timebase that is not above 0 and at most 1 s becomes 0.25 s";
                self.source
                    .report_attribute(node, "AverageVelocityTimebase", Reason::Changed(words));
            }
        }
        if let Some(targets) = self.source.number(node, "OutputCamExecutionTargets")? {
            if (0.0..=MAX_OUTPUT_TARGETS as f64).contains(&targets) && targets.fract() == 0.0 {
                if targets > 0.0 {
                    put(
                        &mut axis,
                        "output_cam_execution_targets",
                        Value::Integer(targets as i64),
                    );
                }
            } else {
                self.source
                    .report_attribute(node, "OutputCamExecutionTargets", Reason::NoCounterpart);
            }
        }
        let turn = self.turn(node, name)?;
        if let Some(turn) = turn {
            put(&mut axis, "unwind", Value::Float(turn));
        }
        self.travel(node, turn, &mut axis)?;
        if let Some(word) = node.attribute("ProgrammedStopMode") {
            let key = word.to_ascii_lowercase().replace(' ', "_");
            if !ProgrammedStopMode::ALL.iter().any(|(known, _)| *known == key) {
                let expected = "Fast Stop, Fast Disable, Hard Disable, Fast Shutdown or Hard Shutdown";
                return Err(self.source.wrong(node, "ProgrammedStopMode", expected));
            }
            put(&mut axis, "programmed_stop_mode", Value::String(key));
        }
        self.home(node, name, turn, speed, &mut axis)?;
        if !virtual_axis {
            self.drive(node, name, &mut axis)?;
        }
        self.exceptions(node, virtual_axis, &mut axis)?;
        self.push("axis", tag, axis);
        Ok(true)
    }

    /// The five maxima, and the speed that holds. 0 as a speed, acceleration or its jerk is no limit that can be moved with.
    fn dynamics(
        &mut self,
        node: Node<'a, 't>,
        section: &'static str,
        name: &str,
        table: &mut Table,
    ) -> Result<f64, L5xError> {
        let mut holds = FALLBACK_SPEED;
        for (attribute, key, fallback) in DYNAMICS {
            let number = self.source.number(node, attribute)?;
            if number.is_some_and(|number| number < 0.0) {
                return Err(self.source.wrong(node, attribute, "a number, 0 or more"));
            }
            let may_be_zero = matches!(key, "max_deceleration" | "max_deceleration_jerk");
            let number = number.filter(|number| may_be_zero || *number > 0.0);
            if number.is_none() && !may_be_zero && !self.overlaid(section, name, &[key]) {
                let reason = Reason::Changed(match fallback {
                    Some(FALLBACK_SPEED) => "0 or not given: becomes 100 units/s",
                    Some(_) => "0 or not given: becomes 1000 units/s²",
                    None => "0 or not given: becomes acceleration² / speed",
                });
                self.source.report_attribute(node, attribute, reason);
            }
            let number = number.or(fallback);
            if key == "max_speed" {
                holds = number.unwrap_or(holds);
            }
            table.extend(number.map(|number| (key.to_owned(), Value::Float(number))));
        }
        self.dynamics_bits(node, table)?;
        Ok(holds)
    }

    /// The Dynamics Configuration Bits, in decimal or as `16#0000_0007`; all three are the default of a configuration too.
    fn dynamics_bits(&mut self, node: Node<'a, 't>, table: &mut Table) -> Result<(), L5xError> {
        let attribute = "DynamicsConfigurationBits";
        let Some(word) = node.attribute(attribute).map(str::trim) else {
            return Ok(());
        };
        let bits = match word.strip_prefix("16#") {
            Some(digits) => u32::from_str_radix(&digits.replace('_', ""), 16),
            None => word.parse(),
        };
        let Ok(bits) = bits else {
            return Err(self
                .source
                .wrong(node, attribute, "a whole number such as 7 or 16#0000_0007"));
        };
        let known = bits & DYNAMICS_CONFIGURATION_BITS;
        if known != bits {
            let words = "of Dynamics Configuration Bits only bits 0 to 2 have a meaning";
            self.source.report_attribute(node, attribute, Reason::Changed(words));
        }
        if known != DYNAMICS_CONFIGURATION_BITS {
            put(table, "dynamics_configuration_bits", Value::Integer(known.into()));
        }
        Ok(())
    }

    /// The length of a turn, of a rotary axis.
    fn turn(&mut self, node: Node<'a, 't>, name: &str) -> Result<Option<f64>, L5xError> {
        let rotary = match (node.attribute("TravelMode"), node.attribute("RotaryAxis")) {
            (Some("Cyclic"), _) | (None, Some("Rotary")) => true,
            (Some("Unlimited" | "Limited"), _) | (None, Some("Linear") | None) => false,
            (Some(_), _) => return Err(self.source.wrong(node, "TravelMode", "Unlimited, Limited or Cyclic")),
            (None, Some(_)) => return Err(self.source.wrong(node, "RotaryAxis", "Linear or Rotary")),
        };
        if !rotary {
            return Ok(None);
        }
        let counts = self.source.number(node, "PositionUnwind")?;
        let constant = self.source.number(node, "ConversionConstant")?;
        let turn = counts.unwrap_or(0.0) / constant.unwrap_or(0.0);
        if turn > 0.0 && turn.is_finite() {
            return Ok(Some(turn));
        }
        if !self.overlaid("axis", name, &["unwind"]) {
            return Err(self.source.wrong(
                node,
                "PositionUnwind",
                "counts of a turn, above 0, beside a ConversionConstant above 0",
            ));
        }
        Ok(None)
    }

    fn travel(&mut self, node: Node<'a, 't>, turn: Option<f64>, axis: &mut Table) -> Result<(), L5xError> {
        let checked = match node.attribute("SoftTravelLimitChecking") {
            Some("true" | "1" | "Yes" | "Enabled") => true,
            None | Some("false" | "0" | "No" | "Disabled") => false,
            Some(_) => return Err(self.source.wrong(node, "SoftTravelLimitChecking", "true or false")),
        };
        let min = self.source.number(node, "SoftTravelLimitNegative")?.unwrap_or(0.0);
        let max = self.source.number(node, "SoftTravelLimitPositive")?.unwrap_or(0.0);
        if !checked {
            return Ok(());
        }
        if turn.is_some() || min >= max {
            let words = "soft limits of a rotary axis, or a negative one not below the positive one, are not checked";
            self.source
                .report_attribute(node, "SoftTravelLimitChecking", Reason::Changed(words));
            return Ok(());
        }
        let travel = [
            ("min".to_owned(), Value::Float(min)),
            ("max".to_owned(), Value::Float(max)),
        ];
        put(axis, "travel", Value::Table(Table::from_iter(travel)));
        Ok(())
    }

    fn home(
        &mut self,
        node: Node<'a, 't>,
        name: &str,
        turn: Option<f64>,
        max_speed: f64,
        axis: &mut Table,
    ) -> Result<(), L5xError> {
        let mut home = Table::new();
        for (attribute, key, words, expected) in HOME_WORDS {
            let Some(word) = node.attribute(*attribute) else {
                continue;
            };
            if *attribute == "HomeMode" && word == "Absolute" {
                self.source.report_attribute(node, attribute, Reason::NoCounterpart);
                continue;
            }
            let Some((_, ours)) = words.iter().find(|(theirs, _)| *theirs == word) else {
                return Err(self.source.wrong(node, attribute, expected));
            };
            put(&mut home, key, Value::String((*ours).to_owned()));
        }
        if let Some(position) = self.source.number(node, "HomePosition")? {
            if turn.is_none_or(|turn| (0.0..turn).contains(&position)) {
                put(&mut home, "position", Value::Float(position));
            } else if !self.overlaid("axis", name, &["home", "position"]) {
                let words = "a home position outside the turn becomes 0";
                self.source
                    .report_attribute(node, "HomePosition", Reason::Changed(words));
            }
        }
        if let Some(offset) = self.source.number(node, "HomeOffset")? {
            put(&mut home, "offset", Value::Float(offset));
        }
        for (attribute, key) in [
            ("HomeSpeed", "speed"),
            ("HomeReturnSpeed", "return_speed"),
            ("HomeAcceleration", "acceleration"),
            ("HomeDeceleration", "deceleration"),
        ] {
            // 0 is the value before it is set.
            let number = self.source.number(node, attribute)?.filter(|number| *number > 0.0);
            home.extend(number.map(|number| (key.to_owned(), Value::Float(number))));
        }
        let moves = home.get("mode").and_then(Value::as_str) != Some("passive")
            && !matches!(home.get("sequence").and_then(Value::as_str), None | Some("immediate"));
        if moves && !home.contains_key("speed") {
            if !self.overlaid("axis", name, &["home", "speed"]) {
                let words = "0 or not given: becomes a tenth of the maximum speed";
                self.source.report_attribute(node, "HomeSpeed", Reason::Changed(words));
            }
            put(&mut home, "speed", Value::Float(max_speed / 10.0));
        }
        put(axis, "home", Value::Table(home));
        Ok(())
    }

    fn drive(&mut self, node: Node<'a, 't>, name: &str, axis: &mut Table) -> Result<(), L5xError> {
        let mut drive = Table::new();
        for (attribute, key, factor, range, words) in DRIVE {
            let Some(number) = self.source.number(node, attribute)? else {
                continue;
            };
            let number = number / factor;
            if number >= range.0 && number <= range.1 {
                put(&mut drive, key, Value::Float(number));
            } else if !self.overlaid("axis", name, &["drive", key]) {
                self.source.report_attribute(node, attribute, Reason::Changed(words));
            }
        }
        put(axis, "drive", Value::Table(drive));
        Ok(())
    }

    /// The actions of the faults that Arcline has; the other bits of the two lists are of causes that it has not.
    fn exceptions(&mut self, node: Node<'a, 't>, virtual_axis: bool, axis: &mut Table) -> Result<(), L5xError> {
        let possible = FaultSet::possible(!virtual_axis);
        let mut actions = Table::new();
        for (attribute, shows) in [
            ("MotionExceptionAction", FaultWord::Motion),
            ("CIPAxisExceptionAction", FaultWord::Cip),
        ] {
            let words: Vec<&str> = node
                .attribute(attribute)
                .unwrap_or_default()
                .split_whitespace()
                .collect();
            let mut lost = false;
            for (bit, word) in words.iter().enumerate() {
                let action = ACTIONS.iter().find(|(theirs, _)| theirs == word);
                let expected =
                    "Ignore, Alarm, FaultStatusOnly, StopPlanner, StopDrive, Disable, Shutdown and Unsupported";
                let Some((_, action)) = action else {
                    return Err(self.source.wrong(node, attribute, expected));
                };
                let Some(action) = action else { continue };
                let fault = FAULTS
                    .iter()
                    .find(|fault| fault.shows == shows && usize::from(fault.bit) == bit);
                match (fault, ExceptionAction::ALL.iter().find(|(_, other)| other == action)) {
                    (Some(fault), Some((word, _))) if possible.contains(fault.kind) => {
                        put(&mut actions, fault.word, Value::String((*word).to_owned()));
                    }
                    _ => lost = true,
                }
            }
            if lost {
                self.source.report_attribute(
                    node,
                    attribute,
                    Reason::Changed("actions of faults that Arcline has not fall away"),
                );
            }
        }
        put(axis, "exception_actions", Value::Table(actions));
        Ok(())
    }

    fn system(&mut self, tag: Node<'a, 't>, name: &str, axes: &[&str]) -> Result<(), L5xError> {
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
        for (attribute, key) in ORIENTATION {
            let number = self.source.number(node, attribute)?.filter(|number| *number != 0.0);
            match number {
                Some(number) if number < 0.0 => return Err(self.source.wrong(node, attribute, "a number, 0 or more")),
                Some(_) if robot.is_some() || definition.is_none() => {
                    self.source.report_attribute(node, attribute, Reason::NoCounterpart);
                }
                number => system.extend(number.map(|number| (key.to_owned(), Value::Float(number)))),
            }
        }
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
        for (attribute, key) in [
            ("ActualPositionTolerance", "actual_tolerance"),
            ("CommandPositionTolerance", "command_tolerance"),
        ] {
            match self.source.number(node, attribute)? {
                Some(number) if number < 0.0 => return Err(self.source.wrong(node, attribute, "a number, 0 or more")),
                number => system.extend(number.map(|number| (key.to_owned(), Value::Float(number)))),
            }
        }
        if let Some(word) = node.attribute("MaximumPendingMoves") {
            match word.parse() {
                Ok(depth @ 1..=MAX_QUEUE_DEPTH) => put(&mut system, "queue_depth", Value::Integer(depth as i64)),
                _ => {
                    return Err(self
                        .source
                        .wrong(node, "MaximumPendingMoves", "a whole number from 1 to 1000"));
                }
            }
        }
        self.push("coordinate_system", tag, system);
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

fn put(table: &mut Table, key: &str, value: Value) {
    table.insert(key.to_owned(), value);
}

/// Position units per second of an axis that has no Maximum Speed.
const FALLBACK_SPEED: f64 = 100.0;
/// Position units per second² of an axis that has no Maximum Acceleration.
const FALLBACK_RATE: f64 = 1000.0;
/// Longest label of units, bytes, as in a configuration.
const MAX_UNITS: usize = 40;

/// Attribute, key, and the replacement of 0.
const DYNAMICS: [(&str, &str, Option<f64>); 5] = [
    ("MaximumSpeed", "max_speed", Some(FALLBACK_SPEED)),
    ("MaximumAcceleration", "max_acceleration", Some(FALLBACK_RATE)),
    ("MaximumDeceleration", "max_deceleration", None),
    ("MaximumAccelerationJerk", "max_acceleration_jerk", None),
    ("MaximumDecelerationJerk", "max_deceleration_jerk", None),
];

/// Attribute, key, its words in L5X and in Arcline, and the expected values.
type Words = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str)],
    &'static str,
);

/// The words of homing.
const HOME_WORDS: &[Words] = &[
    (
        "HomeMode",
        "mode",
        &[("Passive", "passive"), ("Active", "active")],
        "Passive, Active or Absolute",
    ),
    (
        "HomeDirection",
        "direction",
        &[
            ("Uni-directional Forward", "unidirectional-forward"),
            ("Bi-directional Forward", "bidirectional-forward"),
            ("Uni-directional Reverse", "unidirectional-reverse"),
            ("Bi-directional Reverse", "bidirectional-reverse"),
        ],
        "Uni-directional or Bi-directional, then Forward or Reverse",
    ),
    (
        "HomeSequence",
        "sequence",
        &[
            ("Immediate", "immediate"),
            ("Switch", "switch"),
            ("Marker", "marker"),
            ("Switch-Marker", "switch-marker"),
            ("Torque Level", "torque"),
            ("Torque Level-Marker", "torque-marker"),
        ],
        "Immediate, Switch, Marker, Switch-Marker, Torque Level or Torque Level-Marker",
    ),
];

/// Attribute, key, the factor of the attribute, the range of the key, and the reaction outside of it.
type OfDrive = (&'static str, &'static str, f64, (f64, f64), &'static str);

/// The attributes of a servo's loop.
const DRIVE: [OfDrive; 4] = [
    (
        "PositionLoopBandwidth",
        "position_bandwidth_hz",
        1.0,
        (f64::MIN_POSITIVE, 10_000.0),
        "a position loop bandwidth that is not above 0 and at most 10000 Hz becomes 40 Hz",
    ),
    (
        "VelocityFeedforwardGain",
        "velocity_feedforward",
        100.0,
        (0.0, 1.0),
        "a velocity feedforward that is not 0 to 100 % becomes 100 %",
    ),
    (
        "PositionErrorTolerance",
        "position_error_tolerance",
        1.0,
        (0.0, f64::MAX),
        "a position error tolerance below 0 becomes 5",
    ),
    (
        "PositionErrorToleranceTime",
        "position_error_tolerance_time",
        1.0,
        (0.0, f64::MAX),
        "a position error tolerance time below 0 becomes 0",
    ),
];

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

/// The words of actions; `Disable` is the older one of `StopDrive`. An export writes the first word of an action.
pub(crate) const ACTIONS: [(&str, Option<ExceptionAction>); 8] = [
    ("Ignore", Some(ExceptionAction::Ignore)),
    ("Alarm", Some(ExceptionAction::Alarm)),
    ("FaultStatusOnly", Some(ExceptionAction::FaultStatusOnly)),
    ("StopPlanner", Some(ExceptionAction::StopPlanner)),
    ("Disable", Some(ExceptionAction::StopDrive)),
    ("StopDrive", Some(ExceptionAction::StopDrive)),
    ("Shutdown", Some(ExceptionAction::Shutdown)),
    ("Unsupported", None),
];

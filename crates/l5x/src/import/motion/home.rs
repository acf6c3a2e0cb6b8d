//! The homing of an axis.

use roxmltree::Node;
use toml::{Table, Value};

use super::super::Importer;
use super::put;
use crate::{L5xError, Reason};

impl<'a, 't> Importer<'a, 't> {
    pub(super) fn home(
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
}

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

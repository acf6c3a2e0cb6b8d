//! The loop of a servo, and the reactions of its axis to faults.

use arcline_instruction_set::{ExceptionAction, FAULTS, FaultSet, FaultWord};
use roxmltree::Node;
use toml::{Table, Value};

use super::super::Importer;
use super::put;
use crate::{L5xError, Reason};

impl<'a, 't> Importer<'a, 't> {
    pub(super) fn drive(&mut self, node: Node<'a, 't>, name: &str, axis: &mut Table) -> Result<(), L5xError> {
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
    pub(super) fn exceptions(
        &mut self,
        node: Node<'a, 't>,
        virtual_axis: bool,
        axis: &mut Table,
    ) -> Result<(), L5xError> {
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
}

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

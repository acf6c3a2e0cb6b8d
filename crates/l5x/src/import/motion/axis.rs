//! An axis: its kind, units, turn, travel and stops.

use arcline_controller::machine::{MAX_AXES, MAX_OUTPUT_TARGETS, ProgrammedStopMode};
use roxmltree::Node;
use toml::{Table, Value};

use super::super::Importer;
use super::dynamics::{FALLBACK_RATE, FALLBACK_SPEED};
use super::put;
use crate::{L5xError, Reason};

impl<'a, 't> Importer<'a, 't> {
    /// Adds an axis; `false`: it is none that moves.
    pub(super) fn axis(&mut self, tag: Node<'a, 't>, name: &str, virtual_axis: bool) -> Result<bool, L5xError> {
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
        if !self.moves(node) {
            self.source.report(tag, Reason::NoCounterpart);
            return Ok(false);
        }
        self.units(node, &mut axis);
        let speed = self.dynamics(node, "axis", name, &mut axis)?;
        self.timebase(node, &mut axis)?;
        self.targets(node, &mut axis)?;
        let turn = self.turn(node, name)?;
        if let Some(turn) = turn {
            put(&mut axis, "unwind", Value::Float(turn));
        }
        self.travel(node, turn, &mut axis)?;
        self.stop_mode(node, &mut axis)?;
        self.home(node, name, turn, speed, &mut axis)?;
        if !virtual_axis {
            self.drive(node, name, &mut axis)?;
        }
        self.exceptions(node, virtual_axis, &mut axis)?;
        self.push("axis", tag, axis);
        Ok(true)
    }

    /// Whether the axis drives a motor; a converter or an encoder does not.
    fn moves(&mut self, node: Node<'a, 't>) -> bool {
        let reason = match node.attribute("AxisConfiguration") {
            None | Some("Position Loop") => return true,
            Some("Velocity Loop" | "Torque Loop" | "Frequency Control") => {
                Reason::Changed("every servo closes the position loop")
            }
            Some(_) => Reason::NoCounterpart,
        };
        let moves = reason != Reason::NoCounterpart;
        self.source.report_attribute(node, "AxisConfiguration", reason);
        moves
    }

    fn units(&mut self, node: Node<'a, 't>, axis: &mut Table) {
        let Some(units) = node.attribute("PositionUnits") else {
            return;
        };
        let fits: String = units.chars().filter(|c| !c.is_control()).collect();
        if fits.len() <= MAX_UNITS {
            put(axis, "units", Value::String(fits));
        } else {
            self.source
                .report_attribute(node, "PositionUnits", Reason::NoCounterpart);
        }
    }

    fn timebase(&mut self, node: Node<'a, 't>, axis: &mut Table) -> Result<(), L5xError> {
        if let Some(time) = self.source.number(node, "AverageVelocityTimebase")? {
            if time > 0.0 && time <= 1.0 {
                put(axis, "average_velocity_timebase", Value::Float(time));
            } else {
                let words = "an average velocity timebase that is not above 0 and at most 1 s becomes 0.25 s";
                self.source
                    .report_attribute(node, "AverageVelocityTimebase", Reason::Changed(words));
            }
        }
        Ok(())
    }

    fn targets(&mut self, node: Node<'a, 't>, axis: &mut Table) -> Result<(), L5xError> {
        if let Some(targets) = self.source.number(node, "OutputCamExecutionTargets")? {
            if (0.0..=MAX_OUTPUT_TARGETS as f64).contains(&targets) && targets.fract() == 0.0 {
                if targets > 0.0 {
                    put(axis, "output_cam_execution_targets", Value::Integer(targets as i64));
                }
            } else {
                self.source
                    .report_attribute(node, "OutputCamExecutionTargets", Reason::NoCounterpart);
            }
        }
        Ok(())
    }

    fn stop_mode(&mut self, node: Node<'a, 't>, axis: &mut Table) -> Result<(), L5xError> {
        if let Some(word) = node.attribute("ProgrammedStopMode") {
            let key = word.to_ascii_lowercase().replace(' ', "_");
            if !ProgrammedStopMode::ALL.iter().any(|(known, _)| *known == key) {
                let expected = "Fast Stop, Fast Disable, Hard Disable, Fast Shutdown or Hard Shutdown";
                return Err(self.source.wrong(node, "ProgrammedStopMode", expected));
            }
            put(axis, "programmed_stop_mode", Value::String(key));
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
}

/// Longest label of units, bytes, as in a configuration.
const MAX_UNITS: usize = 40;

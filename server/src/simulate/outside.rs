//! `simulate --step`: a plant in another process, tick by tick. The set-points of all axes with a drive go out as a line of JSON on standard output, their
//! feedback comes in as one on standard input ([PLANTS.md](../../../docs/PLANTS.md)).

use std::fmt;
use std::io::{BufRead, Write};
use std::sync::{Arc, Mutex, PoisonError};

use arcline_controller::drive::SetPoint;
use arcline_controller::drive::simulated::{MechanicalModel, ModelFailed, ModelledAxis};
use arcline_controller::machine::Machine;
use arcline_instruction_set::AxisId;
use serde::{Deserialize, Serialize};

/// A line longer than this, bytes, is none of a plant.
const LONGEST: u64 = 1 << 20;

/// The reason for which the plant cannot go on, for the end of the run.
#[derive(Clone, Debug, Default)]
pub(super) struct Reason(Arc<Mutex<Option<String>>>);

impl Reason {
    pub(super) fn is_given(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    pub(super) fn take(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// The two pipes.
pub(super) struct Outside {
    input: Box<dyn BufRead + Send>,
    output: Box<dyn Write + Send>,
    axes: Vec<AxisId>,
    names: Vec<String>,
    period_s: f64,
    tick: u64,
    line: Vec<u8>,
    reason: Reason,
}

impl fmt::Debug for Outside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Outside")
            .field("tick", &self.tick)
            .finish_non_exhaustive()
    }
}

/// The first line.
#[derive(Serialize)]
struct Head<'a> {
    arcline: &'static str,
    step: u32,
    period_s: f64,
    axes: &'a [String],
}

/// A tick, in the order of the axes of the first line.
#[derive(Serialize)]
struct Sent {
    tick: u64,
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    enable: Vec<bool>,
}

/// The answer of a plant. A key that is left out, or null for an axis, leaves the axis to its simulated drive. The line of the set-points is an answer too.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Answer {
    tick: Option<u64>,
    #[serde(default)]
    position: Vec<Option<f64>>,
    #[serde(default)]
    velocity: Vec<Option<f64>>,
    #[serde(default)]
    acceleration: Vec<Option<f64>>,
    #[serde(default)]
    fault: Vec<Option<bool>>,
    #[serde(default)]
    enable: Vec<bool>,
}

impl Outside {
    /// A plant behind two pipes that moves the axes with a drive.
    pub(super) fn new(machine: &Machine, input: Box<dyn BufRead + Send>, output: Box<dyn Write + Send>) -> Self {
        let driven = (0..).zip(&machine.axes).filter(|(_, axis)| !axis.is_virtual());
        let (axes, names) = driven.map(|(index, axis)| (AxisId(index), axis.name.clone())).unzip();
        Outside {
            input,
            output,
            axes,
            names,
            period_s: machine.period(),
            tick: 0,
            line: Vec::new(),
            reason: Reason::default(),
        }
    }

    pub(super) fn axes(&self) -> Vec<AxisId> {
        self.axes.clone()
    }

    pub(super) fn reason(&self) -> Reason {
        self.reason.clone()
    }

    fn send(&mut self, set_points: &[SetPoint]) -> std::io::Result<()> {
        if self.tick == 0 {
            let head = Head {
                arcline: env!("CARGO_PKG_VERSION"),
                step: 1,
                period_s: self.period_s,
                axes: &self.names,
            };
            write(&mut self.output, &head)?;
        }
        let points = || self.axes.iter().map(|axis| &set_points[usize::from(*axis)]);
        let sent = Sent {
            tick: self.tick,
            position: points().map(|point| point.position).collect(),
            velocity: points().map(|point| point.velocity).collect(),
            acceleration: points().map(|point| point.acceleration).collect(),
            enable: points().map(|point| point.enable).collect(),
        };
        write(&mut self.output, &sent)?;
        self.output.flush()
    }

    fn receive(&mut self) -> Result<Answer, String> {
        self.line.clear();
        let mut limited = std::io::Read::take(&mut self.input, LONGEST);
        let read = limited.read_until(b'\n', &mut self.line);
        let read = read.map_err(|error| format!("cannot be read: {error}"))?;
        if read == 0 {
            return Err("has ended, expected the feedback of the tick".to_owned());
        }
        if self.line.last() != Some(&b'\n') {
            return Err(if read as u64 == LONGEST {
                format!("a line is longer than {LONGEST} bytes")
            } else {
                "has ended within a line".to_owned()
            });
        }
        serde_json::from_slice(&self.line).map_err(|error| format!("is no feedback: {error}"))
    }

    fn exchange(&mut self, set_points: &[SetPoint], axes: &mut [ModelledAxis]) -> Result<(), String> {
        self.send(set_points)
            .map_err(|error| format!("standard output: tick {}: cannot be written: {error}", self.tick))?;
        let tick = self.tick;
        let wrong = |why: String| format!("standard input: tick {tick}: {why}");
        let answer = self.receive().map_err(wrong)?;
        if answer.tick.is_some_and(|answered| answered != tick) {
            return Err(wrong(format!(
                "is an answer to tick {}",
                answer.tick.unwrap_or_default()
            )));
        }
        let lengths = [
            ("position", answer.position.len()),
            ("velocity", answer.velocity.len()),
            ("acceleration", answer.acceleration.len()),
            ("fault", answer.fault.len()),
            ("enable", answer.enable.len()),
        ];
        let count = self.axes.len();
        if let Some((key, length)) = lengths.into_iter().find(|(_, length)| *length != 0 && *length != count) {
            return Err(wrong(format!(
                "{key} has {length} values, expected {count}, one of each axis"
            )));
        }
        for (column, axis) in self.axes.iter().enumerate() {
            let of = |values: &[Option<f64>]| values.get(column).copied().flatten();
            let Some(answered) = axes.get_mut(usize::from(*axis)) else {
                continue;
            };
            *answered = ModelledAxis {
                position: of(&answer.position).unwrap_or(answered.position),
                velocity: of(&answer.velocity),
                acceleration: of(&answer.acceleration),
                fault: answer.fault.get(column).copied().flatten().unwrap_or_default(),
            };
        }
        Ok(())
    }
}

/// Writes one line.
fn write(output: &mut impl Write, line: &impl Serialize) -> std::io::Result<()> {
    serde_json::to_writer(&mut *output, line)?;
    output.write_all(b"\n")
}

impl MechanicalModel for Outside {
    fn tick(&mut self, set_points: &[SetPoint], axes: &mut [ModelledAxis]) -> Result<(), ModelFailed> {
        let exchanged = self.exchange(set_points, axes);
        self.tick += 1;
        exchanged.map_err(|why| {
            *self.reason.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(why);
            ModelFailed
        })
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// The answers of a plant with these lines at tick 0 of a machine of two servos and a virtual axis.
    fn answers(lines: &str) -> Result<Vec<ModelledAxis>, String> {
        let axis = |name: &str, kind: &str| {
            format!("[[axis]]\nname = \"{name}\"\ntype = \"{kind}\"\nmax_speed = 100\nmax_acceleration = 1000\n")
        };
        let config = [axis("X", "servo"), axis("V", "virtual"), axis("Y", "servo")].concat();
        let project = arcline_config::load(&config, "test").expect("a valid configuration");
        let mut outside = Outside::new(
            &project.machine,
            Box::new(Cursor::new(lines.to_owned())),
            Box::new(Vec::new()),
        );
        let mut axes = vec![
            ModelledAxis {
                position: 7.0,
                ..ModelledAxis::default()
            };
            3
        ];
        let ticked = outside.tick(&[SetPoint::default(); 3], &mut axes);
        match outside.reason().take() {
            None => ticked.map(|()| axes).map_err(|_| "a reason is missing".to_owned()),
            Some(reason) => Err(reason),
        }
    }

    #[test]
    fn feedback_is_read_by_axis() {
        let read = answers("{\"tick\":0,\"position\":[1.25,null],\"velocity\":[null,2],\"fault\":[false,true]}\n");
        let [x, v, y] = read.expect("a good line").try_into().expect("three axes");
        assert_eq!((x.position, x.velocity, x.fault), (1.25, None, false));
        assert_eq!(
            (y.position, y.velocity, y.fault),
            (7.0, Some(2.0), true),
            "null leaves the simulated position"
        );
        assert_eq!(
            v,
            ModelledAxis {
                position: 7.0,
                ..ModelledAxis::default()
            },
            "no drive"
        );
        assert_eq!(answers("{}\n").map(|axes| axes[0].position), Ok(7.0));
        // The shortest decimal of every number is read back to the bit.
        for value in [0.1, 1.0 / 3.0, 123_456.789_012_345_67, 5e-324, f64::MAX] {
            let line = format!("{{\"position\":[{},0]}}\n", serde_json::json!(value));
            assert_eq!(
                answers(&line).map(|axes| axes[0].position.to_bits()),
                Ok(value.to_bits()),
                "{line}"
            );
        }
    }

    #[test]
    fn errors_of_the_input_name_their_cause() {
        #[rustfmt::skip]
        let cases = [
            ("",                                     "has ended, expected the feedback"),
            ("{}",                                   "has ended within a line"),
            ("rubbish\n",                            "is no feedback: expected value at line 1 column 1"),
            ("[1,2]\n",                              "is no feedback"),
            ("{\"position\":[1]}\n",                 "position has 1 values, expected 2, one of each axis"),
            ("{\"fault\":[false,false,true]}\n",     "fault has 3 values, expected 2"),
            ("{\"positions\":[1,2]}\n",              "unknown field `positions`, expected one of `tick`, `position`"),
            ("{\"position\":[1,\"2\"]}\n",           "invalid type: string \"2\", expected f64"),
            ("{\"position\":[1,1e999]}\n",           "number out of range"),
            ("{\"tick\":3}\n",                       "is an answer to tick 3"),
        ];
        for (lines, expected) in cases {
            let error = answers(lines).expect_err(lines);
            assert!(
                error.starts_with("standard input: tick 0: ") && error.contains(expected),
                "{lines}: {error}"
            );
        }
    }
}

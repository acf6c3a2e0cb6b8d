//! The data that a viewer watches while a project runs: the power flow of rungs in their last scan, and the values of their operands.
//!
//! A routine without a monitor costs a scan nothing. A monitor is compiled beside the scan ([`Listing::monitor`](crate::Listing::monitor)) and
//! sampled between two scans.

use arcline_tag::DataType;

use crate::cell::Cell;
use crate::code::{Argument, Body, Cellular, Code, Ex, Node, Place, TextPart};
use crate::compile::Compiler;
use crate::compile::status_of;
use crate::expression::{Expression, TagReference};
use crate::no_machine::NoMachine;
use crate::run::{Number, Run, Scan, Trace};

/// Operands of rungs or lines of a routine.
#[derive(Clone, Debug)]
pub struct Monitor {
    pub(crate) routine: u32,
    /// The index of the first rung or line.
    pub(crate) from: usize,
    /// The operands by rung or line; `None`: an operand without value.
    pub(crate) rows: Vec<Vec<Option<MonitoredOperand>>>,
    /// The instance of the add-on instruction.
    pub(crate) instance: Option<Place>,
    pub(crate) code: Code,
}

/// An operand whose value is shown.
#[derive(Clone, Debug)]
pub(crate) enum MonitoredOperand {
    Value(Argument),
    /// The status bits of a structure: byte, mask and name.
    Bits(Place, Box<[(u32, u8, String)]>),
}

/// A rung or line of a monitor.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct MonitorSample {
    /// A `0` or `1` each: the rung condition, then the condition behind each element in the order of
    /// [`ListedElement`](crate::ListedElement)'s conditions. Empty: the rung was not scanned in the program's last scan, or is a line of text.
    pub power: String,
    /// The values of the operands.
    pub values: Vec<MonitoredValue>,
}

/// A value as it is shown.
#[derive(Clone, PartialEq, Debug)]
pub enum MonitoredValue {
    /// There is none, or a subscript is out of range.
    Nothing,
    /// A BOOL or bit.
    Bool(bool),
    /// A whole number.
    Whole(i64),
    /// A number with a point.
    Real(f64),
    /// A text, or the names of the status bits that are set.
    Text(String),
}

impl Monitor {
    /// The number of its routine.
    pub fn routine(&self) -> u32 {
        self.routine
    }

    /// The index of its first rung or line.
    pub fn from(&self) -> usize {
        self.from
    }
}

impl Cell {
    /// Records the power flow of these routines from the next scan on, and of no others.
    pub fn trace(&mut self, routines: impl IntoIterator<Item = u32>) {
        let (code, state) = self.parts_mut();
        let mut traces: Vec<Trace> = Vec::new();
        for routine in routines {
            if traces.iter().any(|trace| trace.routine == routine) {
                continue;
            }
            if let Some(known) = state.traces.iter().position(|trace| trace.routine == routine) {
                traces.push(state.traces.swap_remove(known));
                continue;
            }
            let Some(of) = code.routines.get(routine as usize) else {
                continue;
            };
            let Body::Ladder(rungs) = &of.body else { continue };
            let mut starts = vec![0];
            let mut bits = 0;
            for rung in rungs {
                bits += 2 + conditions(&rung.nodes);
                starts.push(bits);
            }
            traces.push(Trace {
                routine,
                program: of.of_program,
                starts: starts.into(),
                bits: vec![0; bits.div_ceil(8) as usize].into(),
            });
        }
        state.traces = traces;
    }

    /// Samples the watched operands, between two scans.
    pub fn sample(&mut self, monitor: &Monitor) -> Vec<MonitorSample> {
        let mut samples: Vec<MonitorSample> = Vec::with_capacity(monitor.rows.len());
        for row in 0..monitor.rows.len() {
            samples.push(MonitorSample {
                power: self.power(monitor.routine, monitor.from + row),
                values: Vec::new(),
            });
        }
        let (_, state) = self.parts_mut();
        let overflow = state.begin_sample();
        let mut scan = Scan {
            code: &monitor.code,
            s: state,
            host: &mut NoMachine,
            caller: None,
        };
        if let Some(instance) = &monitor.instance
            && let Ok(at) = scan.address(instance)
        {
            scan.enter_instance(at);
        }
        for (row, sample) in monitor.rows.iter().zip(&mut samples) {
            sample.values = row
                .iter()
                .map(|one| one.as_ref().map_or(MonitoredValue::Nothing, |one| scan.shown(one)))
                .collect();
        }
        state.end_sample(overflow);
        samples
    }

    /// The conditions of a rung in the last scan.
    fn power(&mut self, routine: u32, rung: usize) -> String {
        let (_, state) = self.parts_mut();
        let Some(trace) = state.traces.iter().find(|trace| trace.routine == routine) else {
            return String::new();
        };
        let (Some(from), Some(end)) = (trace.starts.get(rung), trace.starts.get(rung + 1)) else {
            return String::new();
        };
        let bit = |place: u32| {
            let byte = trace.bits.get(place as usize / 8).copied().unwrap_or_default();
            byte >> (place % 8) & 1 != 0
        };
        if !bit(*from) {
            return String::new();
        }
        (from + 1..*end)
            .map(|place| if bit(place) { '1' } else { '0' })
            .collect()
    }
}

/// Conditions that the elements of a rung or leg have.
fn conditions(nodes: &[Node]) -> u32 {
    let each = nodes.iter().map(|node| match node {
        Node::Branch(legs) => 1 + legs.iter().map(|leg| conditions(leg)).sum::<u32>(),
        _ => 1,
    });
    each.sum()
}

impl Scan<'_> {
    fn shown(&mut self, operand: &MonitoredOperand) -> MonitoredValue {
        let shown = match operand {
            MonitoredOperand::Value(Argument::Bit(bit)) => self.bit(bit).map(MonitoredValue::Bool),
            MonitoredOperand::Value(Argument::Target(cell)) => {
                self.address(&cell.place).map(|at| match self.read(at, cell.kind) {
                    Number::Whole(value) => MonitoredValue::Whole(value),
                    Number::Real(value) => MonitoredValue::Real(value),
                })
            }
            MonitoredOperand::Value(Argument::Text(part)) => self.shown_text(part),
            MonitoredOperand::Value(value) => self.argument(value).map(|value| match value {
                Number::Whole(value) => MonitoredValue::Whole(value),
                Number::Real(value) => MonitoredValue::Real(value),
            }),
            MonitoredOperand::Bits(place, bits) => self.address(place).map(|at| {
                let set = bits.iter().filter(|(offset, mask, _)| self.has(at + offset, *mask));
                let names: Vec<&str> = set.map(|(.., name)| name.as_str()).collect();
                MonitoredValue::Text(names.join(" "))
            }),
        };
        // A subscript out of range is no fault of the program here.
        let _ = self.take_fault();
        shown.unwrap_or(MonitoredValue::Nothing)
    }

    fn shown_text(&mut self, part: &TextPart) -> Run<MonitoredValue> {
        let (from, end) = self.text_range(part)?;
        let bytes = self.text_slice(part, from, end);
        let text: String = bytes.iter().take(MAX_SHOWN).map(|byte| char::from(*byte)).collect();
        Ok(MonitoredValue::Text(text))
    }
}

impl Compiler<'_> {
    /// The displayed value of an operand; `None`: the operand is a literal, or a word that is not a tag.
    pub(crate) fn monitored(&mut self, expression: &Expression) -> Option<MonitoredOperand> {
        match expression {
            Expression::Integer(_) | Expression::Real(_) | Expression::Text(_) => None,
            Expression::Reference(reference) => match status_of(reference) {
                Some(status) => Some(MonitoredOperand::Value(Argument::Integer(Ex::Status(status)))),
                None => self.monitored_tag(reference),
            },
            expression => self.value(expression).ok().map(MonitoredOperand::Value),
        }
    }

    fn monitored_tag(&mut self, reference: &TagReference) -> Option<MonitoredOperand> {
        let found = self.resolve(reference).ok()?;
        if let Some(bit) = found.as_bit() {
            return Some(MonitoredOperand::Value(Argument::Bit(bit)));
        }
        if found.is_array() {
            return None;
        }
        let expression = Expression::Reference(reference.clone());
        match &found.data_type {
            DataType::Elementary(kind) => Some(MonitoredOperand::Value(Argument::Target(Cellular {
                place: found.place(),
                kind: *kind,
            }))),
            DataType::Structure(template) => {
                if let Some(part) = self.text_part(&expression) {
                    return Some(MonitoredOperand::Value(Argument::Text(part)));
                }
                if !WITH_BITS.contains(&template.name.as_str()) {
                    return None;
                }
                let members = template.members.iter().filter(|member| !member.hidden);
                let bits = members.filter_map(|member| Some((member.offset, 1 << member.bit?, member.name.clone())));
                Some(MonitoredOperand::Bits(found.place(), bits.collect()))
            }
        }
    }

    /// The place of an instance of an add-on instruction.
    pub(crate) fn instance(&mut self, reference: &TagReference, add_on: &str) -> Option<Place> {
        let found = self.resolve(reference).ok()?;
        (found.data_type.name().eq_ignore_ascii_case(add_on) && !found.is_array()).then(|| found.place())
    }
}

/// Structures of which the status bits that are set are shown.
const WITH_BITS: [&str; 5] = ["TIMER", "COUNTER", "CONTROL", "MOTION_INSTRUCTION", "MESSAGE"];
/// Longest text that is shown, bytes.
const MAX_SHOWN: usize = 82;

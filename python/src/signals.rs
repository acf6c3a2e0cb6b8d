//! Signals of a machine as numbers, tick by tick.

use arcline_controller::Controller;
use arcline_controller::machine::Machine;
use arcline_simulation::Simulation;
use arcline_tag::TagPath;
use pyo3::prelude::*;

use crate::errors::unread;
use crate::values;

/// A signal.
#[derive(Clone, Debug)]
pub(crate) enum Signal {
    /// One of the four of an axis that a trace has, as 64-bit numbers.
    Axis { axis: usize, column: usize },
    /// A tag, as its type holds it.
    Tag(TagPath),
}

/// The signals of an axis that are not rounded to the REALs of its tag, in the order of [`Controller::trace`].
const COLUMNS: [&str; 4] = [
    "CommandPosition",
    "CommandVelocity",
    "CommandAcceleration",
    "ActualPosition",
];

impl Signal {
    /// The signal of a name.
    pub(crate) fn new(py: Python<'_>, simulation: &Simulation, name: &str) -> PyResult<Self> {
        let path = values::path(py, name)?;
        if let Some(signal) = Self::of_axis(simulation.machine(), name) {
            return Ok(signal);
        }
        let image = simulation.image();
        image.read(&path).map_err(|error| unread(py, image, name, &error))?;
        Ok(Signal::Tag(path))
    }

    fn of_axis(machine: &Machine, name: &str) -> Option<Self> {
        let (axis, column) = name.split_once('.')?;
        let axis = machine
            .axes
            .iter()
            .position(|known| known.name.eq_ignore_ascii_case(axis))?;
        let column = COLUMNS.iter().position(|known| known.eq_ignore_ascii_case(column))?;
        Some(Signal::Axis { axis, column })
    }

    /// Whether the tags must be brought up to the moment to read it.
    pub(crate) fn is_tag(&self) -> bool {
        matches!(self, Signal::Tag(_))
    }
}

/// The values of signals at the present moment, into a row of as many numbers.
pub(crate) fn sample(simulation: &mut Simulation, signals: &[Signal], row: &mut [f64]) {
    if signals.iter().any(Signal::is_tag) {
        simulation.show();
        for signal in signals {
            if let Signal::Tag(path) = signal {
                show_control(simulation, path);
            }
        }
    }
    Columns::new(signals).read(simulation.controller(), row);
    for (signal, place) in signals.iter().zip(row) {
        if let Signal::Tag(path) = signal {
            *place = simulation.image().read(path).map_or(f64::NAN, |value| value.as_f64());
        }
    }
}

/// Brings the motion control tag of a path up to the moment.
pub(crate) fn show_control(simulation: &mut Simulation, path: &TagPath) {
    let slot = path
        .tag()
        .and_then(|tag| simulation.image().known_control(tag).ok().flatten());
    if let Some(slot) = slot {
        simulation.show_control(slot);
    }
}

/// Those of some signals that are axes', in the order of the axes.
pub(crate) struct Columns(Vec<(usize, usize, usize)>);

impl Columns {
    pub(crate) fn new(signals: &[Signal]) -> Self {
        let of_axis = |(place, signal): (usize, &Signal)| match signal {
            Signal::Axis { axis, column } => Some((*axis, *column, place)),
            Signal::Tag(_) => None,
        };
        let mut columns: Vec<_> = signals.iter().enumerate().filter_map(of_axis).collect();
        columns.sort_unstable();
        Columns(columns)
    }

    /// Reads them into their places of a row.
    pub(crate) fn read(&self, controller: &Controller, row: &mut [f64]) {
        let mut columns = self.0.iter().peekable();
        for (index, values) in controller.trace().enumerate() {
            while let Some((_, column, place)) = columns.next_if(|(axis, ..)| *axis == index) {
                row[*place] = values[*column];
            }
            if columns.peek().is_none() {
                return;
            }
        }
    }
}

//! Signals of a machine as numbers, tick by tick.

use arcline_controller::Controller;
use arcline_controller::image::ReadError;
use arcline_controller::machine::Machine;
use arcline_tag::TagPath;

use crate::simulation::Simulation;

/// The signals of an axis in full precision, not rounded to the REALs of its tag, in the order of [`Controller::trace`].
pub const AXIS_SIGNALS: [&str; 4] = [
    "CommandPosition",
    "CommandVelocity",
    "CommandAcceleration",
    "ActualPosition",
];

/// A signal.
#[derive(Clone, Debug)]
pub enum Signal {
    /// One of the four signals of an axis in a trace ([`AXIS_SIGNALS`]), as 64-bit numbers.
    Axis {
        /// The axis, in configuration order.
        axis: usize,
        /// Its index in [`AXIS_SIGNALS`].
        column: usize,
    },
    /// A tag, with the precision of its type.
    Tag(TagPath),
}

/// The reason why a name is not a signal.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NoSignal {
    /// The name is not a path of a tag.
    #[error("{0:?} is no path of a tag: {1}")]
    Path(String, String),
    /// The tag cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
}

impl Signal {
    /// The signal of a name.
    ///
    /// # Errors
    /// The name is neither a signal of an axis nor a tag.
    pub fn new(simulation: &Simulation, name: &str) -> Result<Self, NoSignal> {
        let path: TagPath = name
            .parse()
            .map_err(|error: arcline_tag::PathError| NoSignal::Path(name.to_owned(), error.to_string()))?;
        if let Some(signal) = Self::of_axis(simulation.machine(), name) {
            return Ok(signal);
        }
        simulation.image().read(&path)?;
        Ok(Signal::Tag(path))
    }

    /// One of the four signals of an axis.
    pub fn of_axis(machine: &Machine, name: &str) -> Option<Self> {
        let (axis, column) = name.split_once('.')?;
        let axis = machine
            .axes
            .iter()
            .position(|known| known.name.eq_ignore_ascii_case(axis))?;
        let column = AXIS_SIGNALS
            .iter()
            .position(|known| known.eq_ignore_ascii_case(column))?;
        Some(Signal::Axis { axis, column })
    }

    /// The tags must be updated before the signal is read.
    pub fn is_tag(&self) -> bool {
        matches!(self, Signal::Tag(_))
    }
}

/// Samples the signals at the present moment into a row with as many numbers.
pub fn sample(simulation: &mut Simulation, signals: &[Signal], row: &mut [f64]) {
    if signals.iter().any(Signal::is_tag) {
        simulation.show();
        for signal in signals {
            if let Signal::Tag(path) = signal {
                simulation.show_control_of(path);
            }
        }
    }
    Columns::new(signals).read(simulation.controller(), row);
    for (signal, value) in signals.iter().zip(row) {
        if let Signal::Tag(path) = signal {
            *value = simulation.image().read(path).map_or(f64::NAN, |number| number.as_f64());
        }
    }
}

/// The signals of axes among some signals, in the order of the axes.
#[derive(Clone, Debug)]
pub struct Columns(Vec<(usize, usize, usize)>);

impl Columns {
    /// The columns of these signals.
    pub fn new(signals: &[Signal]) -> Self {
        let of_axis = |(row_index, signal): (usize, &Signal)| match signal {
            Signal::Axis { axis, column } => Some((*axis, *column, row_index)),
            Signal::Tag(_) => None,
        };
        let mut columns: Vec<_> = signals.iter().enumerate().filter_map(of_axis).collect();
        columns.sort_unstable();
        Columns(columns)
    }

    /// Reads them into their columns of a row.
    pub fn read(&self, controller: &Controller, row: &mut [f64]) {
        let mut columns = self.0.iter().peekable();
        for (index, values) in controller.trace().enumerate() {
            while let Some((_, column, row_index)) = columns.next_if(|(axis, ..)| *axis == index) {
                row[*row_index] = values[*column];
            }
            if columns.peek().is_none() {
                return;
            }
        }
    }
}

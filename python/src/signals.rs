//! Signals of a machine by name, with the errors of Python.

pub(crate) use arcline_simulation::{Columns, Signal, sample};
use arcline_simulation::{NoSignal, Simulation};
use pyo3::prelude::*;

use crate::errors::{raise, unread};

/// The signal of a name.
pub(crate) fn signal(py: Python<'_>, simulation: &Simulation, name: &str) -> PyResult<Signal> {
    Signal::new(simulation, name).map_err(|error| match error {
        NoSignal::Path(..) => raise(py, "TagError", (error.to_string(),)),
        NoSignal::Read(error) => unread(py, simulation.image(), name, &error),
    })
}

//! `simulate`: a program from its beginning to its end, as `arcline-server simulate` runs it.

use std::fs::File;
use std::sync::Arc;

use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Controller, Event};
use arcline_simulation::{Observer, Options, Record, Runner};
use arcline_structured_text::Interpreter;
use numpy::PyArray2;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::errors;
use crate::inner::{parsed, policy, simulation};
use crate::plant::{Plant, Shared};
use crate::signals::{Columns, Signal, signal};
use crate::values;

/// The records of a run.
struct RunRecords<'s> {
    trace: Option<Record>,
    events: Option<Record>,
    signals: &'s [Signal],
    columns: Columns,
    rows: Vec<f64>,
    tick: u64,
    /// Real time is over: a signal of Python has come.
    interrupted: Option<PyErr>,
    plant: Option<Shared>,
}

impl Observer for RunRecords<'_> {
    fn begin(&mut self, machine: &Machine) {
        if let Some(trace) = &mut self.trace {
            trace.header(machine);
        }
    }

    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        if let Some(events) = &mut self.events {
            events.event(event, time, image.control_name(event.control));
        }
    }

    fn tick(&mut self, tick: u64, machine: &Machine, controller: &mut Controller) -> bool {
        self.tick = tick;
        if let Some(trace) = &mut self.trace {
            let time = (tick as f64 * machine.period_ns as f64) / 1e9;
            trace.row(tick, time, controller.trace());
        }
        if !self.signals.is_empty() {
            let from = self.rows.len();
            self.rows.resize(from + self.signals.len(), 0.0);
            self.columns.read(controller, &mut self.rows[from..]);
        }
        if tick.is_multiple_of(4096) {
            self.interrupted = Python::attach(|py| py.check_signals().err());
        }
        self.interrupted.is_none() && !self.plant.as_ref().is_some_and(Shared::has_failed)
    }
}

/// Runs a program to its end: `(error, seconds, ticks, positions, trace)`.
#[pyfunction]
#[pyo3(name = "_simulate", signature = (text, config, set, signals, until, wait, keep_going, trace_csv, events_jsonl, plant, plant_axes))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    text: &str,
    config: Option<&str>,
    set: Vec<(String, Bound<'py, PyAny>)>,
    signals: Vec<String>,
    until: f64,
    wait: bool,
    keep_going: bool,
    trace_csv: Option<&str>,
    events_jsonl: Option<&str>,
    plant: Option<Bound<'py, PyAny>>,
    plant_axes: Option<Vec<String>>,
) -> PyResult<Bound<'py, PyTuple>> {
    let (_, project) = errors::project(py, config)?;
    let machine = Arc::new(project.machine.clone());
    let plant = plant
        .map(|call| Plant::new(py, call, plant_axes, &machine))
        .transpose()?;
    let shared = plant.as_ref().map(Plant::shared);
    let mut simulation = simulation(&project, plant);
    for (path, value) in set {
        values::write(py, &mut simulation, &path, &values::given(&value)?)?;
    }
    let program = parsed(py, simulation.image(), text)?;
    let signals = signals
        .iter()
        .map(|name| signal(py, &simulation, name))
        .collect::<PyResult<Vec<_>>>()?;
    if signals.iter().any(Signal::is_tag) {
        return Err(errors::raise(
            py,
            "ArclineError",
            (
                "simulate traces CommandPosition, CommandVelocity, CommandAcceleration and ActualPosition of axes; Machine.trace traces tags",
            ),
        ));
    }
    let create = |path: Option<&str>| -> PyResult<Option<Record>> {
        let Some(path) = path else { return Ok(None) };
        let file = File::create(path)
            .map_err(|error| PyOSError::new_err((error.raw_os_error(), error.to_string(), path.to_owned())))?;
        Ok(Some(Record::new(Box::new(file))))
    };
    let mut records = RunRecords {
        trace: create(trace_csv)?,
        events: create(events_jsonl)?,
        signals: &signals,
        columns: Columns::new(&signals),
        rows: Vec::new(),
        tick: 0,
        interrupted: None,
        plant: shared,
    };
    let options = Options {
        until,
        policy: policy(wait, keep_going),
    };
    let mut runner = Runner::of(simulation);
    let end = py.detach(|| runner.run(Interpreter::new(program), options, &mut records));
    let failed = records.plant.as_ref().and_then(Shared::take_error);
    if let Some(error) = records.interrupted.take().or(failed) {
        return Err(error);
    }
    for record in [records.trace.take(), records.events.take()].into_iter().flatten() {
        record.finish()?;
    }
    let positions = PyDict::new(py);
    let simulation = runner.simulation();
    for (axis, values) in machine.axes.iter().zip(simulation.controller().trace()) {
        positions.set_item(&axis.name, values[0])?;
    }
    let width = signals.len();
    let rows = records.rows.len() / width.max(1);
    let trace = PyArray2::zeros(py, [rows, width], false);
    {
        use numpy::PyArrayMethods as _;
        let mut array = trace.try_readwrite()?;
        if let Ok(slice) = array.as_slice_mut() {
            slice.copy_from_slice(&records.rows);
        }
    }
    let error = errors::ended(py, &end).map(|error| error.into_value(py));
    (error, simulation.time(), records.tick, positions, trace).into_pyobject(py)
}

//! `simulate`: a program from its beginning to its end, or a project until its condition holds, as `arcline-server simulate` runs them.

use std::fs::File;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use arcline_cell::{End, RunLimits};
use arcline_controller::image::Image;
use arcline_controller::machine::Machine;
use arcline_controller::{Controller, Event};
use arcline_simulation::{Observer, Options, Record, Runner, Simulation};
use arcline_structured_text::Interpreter;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::cell::{self, Given, major_fault, no_condition, on_deep_stack};
use crate::errors;
use crate::inner::{parsed, policy, simulation};
use crate::interrupt::Pace;
use crate::plant::{Plant, Shared};
use crate::signals::{Columns, Signal, signal};
use crate::values;

/// Ticks before the first check for signals of Python.
const FIRST_SLICE: u64 = 64;

/// The records of a run.
struct RunRecords<'s> {
    trace: Option<Record>,
    events: Option<Record>,
    signals: &'s [Signal],
    columns: Columns,
    rows: Vec<f64>,
    tick: u64,
    pace: Pace,
    /// Ticks to the next check for signals of Python, 1 or more.
    left: u64,
    /// Real time is over: a signal of Python has come.
    interrupted: Option<PyErr>,
    /// The same, of a run on another thread.
    over: &'s AtomicBool,
    plant: Option<Shared>,
}

impl<'s> RunRecords<'s> {
    fn create(
        signals: &'s [Signal],
        trace_csv: Option<&str>,
        events_jsonl: Option<&str>,
        over: &'s AtomicBool,
        plant: Option<Shared>,
    ) -> PyResult<Self> {
        let create = |path: Option<&str>| -> PyResult<Option<Record>> {
            let Some(path) = path else { return Ok(None) };
            let file = File::create(path).map_err(|error| cannot_write(path, &error))?;
            Ok(Some(Record::new(Box::new(file))))
        };
        Ok(RunRecords {
            trace: create(trace_csv)?,
            events: create(events_jsonl)?,
            signals,
            columns: Columns::new(signals),
            rows: Vec::new(),
            tick: 0,
            pace: Pace::new(FIRST_SLICE),
            left: FIRST_SLICE,
            interrupted: None,
            over,
            plant,
        })
    }

    /// Ends the files, and makes the result of the run: `(error, seconds, ticks, positions, trace)`.
    fn result<'py>(
        mut self,
        py: Python<'py>,
        error: Option<PyErr>,
        simulation: &Simulation,
    ) -> PyResult<Bound<'py, PyTuple>> {
        for record in [self.trace.take(), self.events.take()].into_iter().flatten() {
            record.finish()?;
        }
        let positions = PyDict::new(py);
        let axes = simulation.machine().axes.iter();
        for (axis, values) in axes.zip(simulation.controller().trace()) {
            positions.set_item(&axis.name, values[0])?;
        }
        let width = self.signals.len();
        let rows = self.rows.len() / width.max(1);
        let trace = PyArray1::from_vec(py, self.rows).reshape([rows, width])?;
        let error = error.map(|error| error.into_value(py));
        (error, simulation.time(), self.tick, positions, trace).into_pyobject(py)
    }
}

fn cannot_write(path: &str, error: &std::io::Error) -> PyErr {
    PyOSError::new_err((error.raw_os_error(), error.to_string(), path.to_owned()))
}

/// Refuses tags, which a whole run does not record.
fn of_axes(py: Python<'_>, signals: &[Signal]) -> PyResult<()> {
    if signals.iter().any(Signal::is_tag) {
        return Err(errors::raise(
            py,
            "ArclineError",
            (
                "simulate traces CommandPosition, CommandVelocity, CommandAcceleration and ActualPosition of axes; \
                 Machine.trace and Cell.trace trace tags",
            ),
        ));
    }
    Ok(())
}

impl Observer for RunRecords<'_> {
    fn needs_every_tick(&self) -> bool {
        self.trace.is_some() || !self.signals.is_empty()
    }

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
        let passed = tick.saturating_sub(self.tick).max(1);
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
        self.left = self.left.saturating_sub(passed);
        if self.left == 0 {
            self.interrupted = Python::attach(|py| py.check_signals().err());
            self.pace.next();
            self.left = self.pace.ticks();
        }
        self.interrupted.is_none()
            && !self.over.load(Ordering::Relaxed)
            && !self.plant.as_ref().is_some_and(Shared::has_failed)
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
    of_axes(py, &signals)?;
    let over = AtomicBool::new(false);
    let mut records = RunRecords::create(&signals, trace_csv, events_jsonl, &over, shared)?;
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
    let simulation = runner.simulation();
    records.result(py, errors::ended(py, &end), &simulation)
}

/// Runs a project until an expression is true, or for a time: as [`simulate`].
#[pyfunction]
#[pyo3(
    name = "_simulate_project",
    signature = (project, config, set, signals, until, longest, scan_phase, allow_missing, trace_csv, events_jsonl, tags_json)
)]
#[allow(clippy::too_many_arguments)]
pub(crate) fn simulate_project<'py>(
    py: Python<'py>,
    project: &str,
    config: Option<&str>,
    set: Vec<(String, Bound<'py, PyAny>)>,
    signals: Vec<String>,
    until: Option<&str>,
    longest: f64,
    scan_phase: Option<u64>,
    allow_missing: bool,
    trace_csv: Option<&str>,
    events_jsonl: Option<&str>,
    tags_json: Option<&str>,
) -> PyResult<Bound<'py, PyTuple>> {
    let given = Given::read(py, project, config, scan_phase, allow_missing)?;
    let mut cell = given.load(py)?;
    let signals = signals
        .iter()
        .map(|name| signal(py, cell.simulation(), name))
        .collect::<PyResult<Vec<_>>>()?;
    of_axes(py, &signals)?;
    let over = AtomicBool::new(false);
    // A cell goes to another thread, but is not shared with one.
    let moved = &mut cell;
    let condition = on_deep_stack(py, &over, move || until.map(|text| moved.condition(text)).transpose())?;
    let condition = condition.map_err(|reason| no_condition(py, &cell, until.unwrap_or_default(), &reason))?;
    let mut records = RunRecords::create(&signals, trace_csv, events_jsonl, &over, None)?;
    let end = match on_deep_stack(py, &over, || cell.begin(&mut records))? {
        Err(fault) => End::Fault(fault),
        Ok(()) => {
            for (path, value) in set {
                cell::write(py, &mut cell, &path, &values::given(&value)?)?;
            }
            let limits = RunLimits {
                until: condition.as_ref(),
                ticks: u64::MAX,
                time: longest,
            };
            on_deep_stack(py, &over, || cell.run(limits, &mut records))?
        }
    };
    if let Some(path) = tags_json {
        let text = cell.tags_json() + "\n";
        std::fs::write(path, text).map_err(|error| cannot_write(path, &error))?;
    }
    let error = match (&end, until) {
        (End::Fault(fault), _) => Some(major_fault(py, fault)),
        (End::Time, Some(until)) => {
            let text = format!("{until} did not become true in {longest} s of simulated time");
            Some(errors::raise(py, "TimeoutError", (text,)))
        }
        _ => None,
    };
    records.result(py, error, cell.simulation())
}

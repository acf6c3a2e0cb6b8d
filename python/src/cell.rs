//! `Cell`: the program of a controller project beside its machine, stepped from Python.
//!
//! Projects load and scan on a thread with a deep stack, while the interpreter is released. Calls that let time pass share the cell with other threads
//! of Python as those of a machine do.

use std::collections::BTreeMap;
use std::sync::MutexGuard;
use std::sync::atomic::{AtomicBool, Ordering};

use arcline_cell::{Condition, End, LoadError, RunLimits, SimulatedCell, UnknownParts};
use arcline_config::Project;
use arcline_controller::Controller;
use arcline_controller::machine::Machine as MachineConfig;
use arcline_instruction_set::AxisId;
use arcline_routine::{Fault, Line};
use arcline_simulation::{Blind, Observer};
use arcline_tag::{TagPath, WriteValue};
use numpy::{PyArray2, PyArrayMethods, PyReadwriteArray2};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::errors::{self, raise};
use crate::fair::Fair;
use crate::interrupt::watched;
use crate::machine::{cause, ticks_of};
use crate::signals::{Columns, Signal};
use crate::{trace, values};

/// Ticks of a cell between two chances for other threads.
const SLICE: u64 = 64;

/// The program of a controller project on its machine. Deterministic: the same calls in the same order give the same state.
#[pyclass(frozen, subclass, module = "arcline._arcline", mapping)]
pub(crate) struct Cell {
    inner: Fair<Inner>,
    given: Given,
}

/// The texts and choices of which a cell is made.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    /// The project.
    text: String,
    /// Its file, for messages.
    name: String,
    /// The text of a configuration; `None`: the machine is that of the project.
    config: Option<String>,
    scan_phase: Option<u64>,
    allow_missing: bool,
}

struct Inner {
    cell: SimulatedCell,
    conditions: BTreeMap<String, Condition>,
    /// The calls since the beginning.
    journal: Vec<Entry>,
}

/// A call on a cell, with the data to repeat it.
#[derive(Clone, Debug)]
enum Entry {
    /// Ticks that were scanned.
    Ticks(u64),
    Write(String, WriteValue),
    Fault(u16, u32),
}

/// Ticks to run, and the signals that are sampled at the end of each.
struct Plan<'p> {
    ticks: u64,
    until: Option<&'p str>,
    signals: &'p [Signal],
    rows: &'p mut [f64],
}

/// Samples signals of axes and counts the ticks of a run.
struct Sampler<'s> {
    columns: &'s Columns,
    rows: std::slice::ChunksExactMut<'s, f64>,
    ticks: u64,
    over: &'s AtomicBool,
}

impl Observer for Sampler<'_> {
    fn tick(&mut self, _: u64, _: &MachineConfig, controller: &mut Controller) -> bool {
        self.ticks += 1;
        if let Some(row) = self.rows.next() {
            self.columns.read(controller, row);
        }
        !self.over.load(Ordering::Relaxed)
    }
}

impl Given {
    /// Reads the project, of which `project` is the text or the file.
    pub(crate) fn read(
        py: Python<'_>,
        project: &str,
        config: Option<&str>,
        scan_phase: Option<u64>,
        allow_missing: bool,
    ) -> PyResult<Self> {
        let is_text = project.contains('\n') || project.trim_start_matches('\u{FEFF}').starts_with('<');
        let (text, name) = if is_text {
            (project.to_owned(), "project".to_owned())
        } else {
            let bytes = std::fs::read(project)
                .map_err(|error| PyOSError::new_err((error.raw_os_error(), error.to_string(), project.to_owned())))?;
            let text = String::from_utf8(bytes).map_err(|error| {
                let before = error.as_bytes().iter().take(error.utf8_error().valid_up_to());
                let line = before.filter(|byte| **byte == b'\n').count() + 1;
                not_loaded(py, &format!("{project}:{line}: not UTF-8, expected XML in UTF-8"), &[])
            })?;
            (text, project.to_owned())
        };
        let config = config.map(|config| errors::project(py, Some(config)).map(|(text, _)| text));
        Ok(Given {
            text,
            name,
            config: config.transpose()?,
            scan_phase,
            allow_missing,
        })
    }

    /// Loads the project on its machine, before tick 0.
    pub(crate) fn load(&self, py: Python<'_>) -> PyResult<SimulatedCell> {
        let over = AtomicBool::new(false);
        let loaded = on_deep_stack(py, &over, || self.loaded())?;
        let mut cell = loaded.map_err(|error| match error {
            NotLoaded::Project(text, findings) => not_loaded(py, &text, &findings),
            NotLoaded::Config(text) => raise(py, "ConfigError", (text,)),
        })?;
        if let Some(seed) = self.scan_phase {
            cell.set_phase(seed);
        }
        Ok(cell)
    }

    fn loaded(&self) -> Result<SimulatedCell, NotLoaded> {
        let name = self.name.as_str();
        let wrong = |error: arcline_l5x::L5xError| NotLoaded::Project(error.to_string(), Vec::new());
        let machine: Project = match &self.config {
            None => arcline_l5x::machine(&self.text, name).map_err(wrong)?,
            Some(text) => arcline_config::load(text, "config").map_err(|error| NotLoaded::Config(error.to_string()))?,
        };
        let source = arcline_l5x::logic(&self.text, name).map_err(wrong)?;
        let unknown_parts = if self.allow_missing {
            UnknownParts::Allowed
        } else {
            UnknownParts::Refused
        };
        SimulatedCell::load(&machine, source, unknown_parts).map_err(|error| {
            let findings = match &error {
                LoadError::Parts(parts) => parts.blocking().map(ToString::to_string).collect(),
                LoadError::Tag(_) => Vec::new(),
            };
            NotLoaded::Project(format!("{name}: {error}"), findings)
        })
    }
}

/// The reason for which a project was not loaded, in words.
enum NotLoaded {
    /// With the parts that do not run.
    Project(String, Vec<String>),
    Config(String),
}

fn not_loaded(py: Python<'_>, text: &str, findings: &[String]) -> PyErr {
    raise(py, "ProjectError", (text, findings.to_vec()))
}

/// The exception of a major fault.
pub(crate) fn major_fault(py: Python<'_>, fault: &Fault) -> PyErr {
    let (rung, line) = match fault.place {
        Line::Rung(number) => (Some(number), None),
        Line::Text(number) => (None, Some(number)),
    };
    let arguments = (
        fault.kind,
        fault.code,
        fault.program.as_str(),
        fault.routine.as_str(),
        rung,
        line,
        fault.instruction.as_str(),
        fault.to_string(),
    );
    raise(py, "MajorFault", arguments)
}

/// Works on a thread with a deep stack: [`watched`].
pub(crate) fn on_deep_stack<R: Send>(
    py: Python<'_>,
    over: &AtomicBool,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    let thread = std::thread::Builder::new()
        .name("scan".to_owned())
        .stack_size(arcline_routine::STACK);
    watched(py, thread, over, work)
}

impl Inner {
    fn note(&mut self, entry: Entry) {
        match (self.journal.last_mut(), &entry) {
            (_, Entry::Ticks(0)) => {}
            (Some(Entry::Ticks(before)), Entry::Ticks(more)) => *before += more,
            _ => self.journal.push(entry),
        }
    }

    /// Runs ticks, and returns how many passed.
    fn run(&mut self, ticks: u64, until: Option<&str>, observer: &mut Sampler<'_>) -> End {
        let limits = RunLimits {
            until: until.and_then(|text| self.conditions.get(text)),
            ticks,
            time: f64::INFINITY,
        };
        let before = observer.ticks;
        let end = self.cell.run(limits, observer);
        self.note(Entry::Ticks(observer.ticks - before));
        end
    }

    /// A row of signals among which are tags.
    fn sample(&mut self, signals: &[Signal], row: &mut [f64]) {
        for (signal, value) in signals.iter().zip(row) {
            if let Signal::Tag(path) = signal {
                let read = self.cell.value(path).ok().and_then(|value| value.as_f64());
                *value = read.unwrap_or(f64::NAN);
            }
        }
    }
}

/// Carries out a plan, slice by slice.
fn work(inner: &Fair<Inner>, plan: Plan<'_>, over: &AtomicBool) -> End {
    let columns = Columns::new(plan.signals);
    let width = plan.signals.len().max(1);
    let has_tags = plan.signals.iter().any(Signal::is_tag);
    let (mut left, mut rows) = (plan.ticks, plan.rows);
    while left > 0 {
        let count = if has_tags { 1 } else { left.min(SLICE) };
        let (part, rest) = rows.split_at_mut((count as usize * width).min(rows.len()));
        rows = rest;
        let (end, passed) = inner.free(|inner| {
            let mut sampler = Sampler {
                columns: &columns,
                rows: part.chunks_exact_mut(width),
                ticks: 0,
                over,
            };
            let end = inner.run(count, plan.until, &mut sampler);
            let passed = sampler.ticks;
            if has_tags {
                inner.sample(plan.signals, part);
            }
            (end, passed)
        });
        left -= passed.min(left);
        if end != End::Time {
            return end;
        }
    }
    End::Time
}

impl Cell {
    fn lock(&self, py: Python<'_>) -> MutexGuard<'_, Inner> {
        self.inner.lock(py)
    }

    /// Carries out a plan; whether its condition came true.
    fn pass(&self, py: Python<'_>, plan: Plan<'_>) -> PyResult<bool> {
        let over = AtomicBool::new(false);
        match on_deep_stack(py, &over, || work(&self.inner, plan, &over))? {
            End::Reached => Ok(true),
            End::Time | End::Left => Ok(false),
            End::Fault(fault) => Err(major_fault(py, &fault)),
        }
    }

    fn pass_ticks(&self, py: Python<'_>, ticks: u64, until: Option<&str>) -> PyResult<bool> {
        let plan = Plan {
            ticks,
            until,
            signals: &[],
            rows: &mut [],
        };
        self.pass(py, plan)
    }

    /// The ticks that pass in `seconds`, and those to scan: a tick that is open is scanned too.
    fn scans(&self, py: Python<'_>, seconds: f64) -> PyResult<(u64, u64)> {
        let inner = self.lock(py);
        let ticks = ticks_of(inner.cell.machine(), seconds)?;
        Ok((ticks, ticks + u64::from(inner.cell.is_open())))
    }
}

/// The error of an expression that cannot be read.
pub(crate) fn no_condition(py: Python<'_>, cell: &SimulatedCell, text: &str, reason: &str) -> PyErr {
    match text.parse::<TagPath>() {
        Ok(path) if !cell.has(&path) => no_tag(py, cell, &path, reason),
        _ => errors::program(py, &format!("{text}: {reason}"), 1),
    }
}

/// A tag that is not there, with the nearest name that is.
fn no_tag(py: Python<'_>, cell: &SimulatedCell, path: &TagPath, why: &str) -> PyErr {
    let image = cell.simulation().image();
    let of_machine = image.tags().iter().map(|tag| image.full_name(tag));
    let name = path.full_name().unwrap_or_default();
    errors::no_name(py, cell.tags().chain(of_machine), &name, why)
}

/// The exception for a tag of a cell that cannot be read.
fn unread(py: Python<'_>, cell: &SimulatedCell, text: &str, error: &arcline_controller::image::ReadError) -> PyErr {
    use arcline_controller::image::ReadError::NoSuchTag;
    match (error, text.parse()) {
        (NoSuchTag { .. }, Ok(path)) => no_tag(py, cell, &path, &error.to_string()),
        _ => raise(py, "TagError", (format!("{text}: {error}"),)),
    }
}

/// Writes a value to a tag of a cell.
pub(crate) fn write(py: Python<'_>, cell: &mut SimulatedCell, text: &str, value: &WriteValue) -> PyResult<()> {
    use arcline_simulation::NotWritten;
    cell.write(text, value).map_err(|error| match error {
        NotWritten::Path(..) => raise(py, "TagError", (error.to_string(),)),
        NotWritten::Read(error) => unread(py, cell, text, &error),
        NotWritten::Value(why) => raise(py, "TagValueError", (why,)),
    })
}

#[pymethods]
impl Cell {
    #[new]
    #[pyo3(signature = (project, config=None, *, scan_phase=None, allow_missing=false))]
    fn new(
        py: Python<'_>,
        project: &str,
        config: Option<&str>,
        scan_phase: Option<u64>,
        allow_missing: bool,
    ) -> PyResult<Self> {
        let given = Given::read(py, project, config, scan_phase, allow_missing)?;
        let mut cell = given.load(py)?;
        let over = AtomicBool::new(false);
        let began = on_deep_stack(py, &over, || cell.begin(&mut Blind))?;
        began.map_err(|fault| major_fault(py, &fault))?;
        Ok(Cell {
            inner: Fair::new(Inner {
                cell,
                conditions: BTreeMap::new(),
                journal: Vec::new(),
            }),
            given,
        })
    }

    /// The present tick: the last one that was scanned; 0 before the first.
    #[getter]
    fn tick(&self, py: Python<'_>) -> u64 {
        self.lock(py).cell.tick()
    }

    /// Seconds at the present tick.
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.lock(py).cell.time()
    }

    /// Seconds of a tick.
    #[getter]
    fn period(&self, py: Python<'_>) -> f64 {
        self.lock(py).cell.machine().period()
    }

    /// The names of the axes.
    #[getter]
    fn axes(&self, py: Python<'_>) -> Vec<String> {
        let inner = self.lock(py);
        inner.cell.machine().axes.iter().map(|axis| axis.name.clone()).collect()
    }

    /// Whether the machine is at rest: no axis moves, and no execution is still to end.
    #[getter]
    fn at_rest(&self, py: Python<'_>) -> bool {
        self.lock(py).cell.simulation().controller().at_rest()
    }

    /// The parts of the project that do not run and are passed over, in words.
    #[getter]
    fn findings(&self, py: Python<'_>) -> Vec<String> {
        self.lock(py).cell.findings().iter().map(ToString::to_string).collect()
    }

    /// The major faults so far, those that a fault routine has cleared among them.
    #[getter]
    fn faults<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let faults: Vec<Fault> = self.lock(py).cell.faults().collect();
        PyList::new(py, faults.iter().map(|fault| major_fault(py, fault).into_value(py)))
    }

    /// The names of all tags of the project, with their programs.
    fn tags(&self, py: Python<'_>) -> Vec<String> {
        self.lock(py).cell.tags().collect()
    }

    /// All tags of the project as JSON: the text that `arcline-server simulate --tags` writes.
    fn tags_json(&self, py: Python<'_>) -> String {
        self.lock(py).cell.tags_json()
    }

    fn __getitem__(&self, py: Python<'_>, path: &str) -> PyResult<Py<PyAny>> {
        let parsed = values::path(py, path)?;
        let mut inner = self.lock(py);
        match inner.cell.value(&parsed) {
            Ok(value) => values::object(py, &value),
            Err(error) => Err(unread(py, &inner.cell, path, &error)),
        }
    }

    fn __setitem__(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = values::given(value)?;
        let mut inner = self.lock(py);
        write(py, &mut inner.cell, path, &value)?;
        inner.note(Entry::Write(path.to_owned(), value));
        Ok(())
    }

    fn __contains__(&self, py: Python<'_>, path: &str) -> bool {
        let inner = self.lock(py);
        path.parse().is_ok_and(|path| inner.cell.has(&path))
    }

    /// Scans `ticks` ticks.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        self.pass_ticks(py, ticks, None).map(drop)
    }

    /// Lets `seconds` pass.
    fn run(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        match self.scans(py, seconds)? {
            (0, _) => Ok(()),
            (_, scans) => self.pass_ticks(py, scans, None).map(drop),
        }
    }

    /// Samples signals at the end of each of `steps` ticks into `out`, or a new array of `(steps, len(signals))`.
    #[pyo3(signature = (signals, steps, out=None))]
    fn trace<'py>(
        &self,
        py: Python<'py>,
        signals: Vec<String>,
        steps: usize,
        out: Option<Bound<'py, PyArray2<f64>>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let signals = {
            let mut inner = self.lock(py);
            let signals = signals.iter().map(|name| signal(py, &mut inner.cell, name));
            signals.collect::<PyResult<Vec<_>>>()?
        };
        let array = trace::array(py, steps, signals.len(), out)?;
        let mut rows: PyReadwriteArray2<'_, f64> = array.try_readwrite()?;
        let plan = Plan {
            ticks: steps as u64,
            until: None,
            signals: &signals,
            rows: trace::contiguous(&mut rows)?,
        };
        self.pass(py, plan)?;
        drop(rows);
        Ok(array)
    }

    /// Injects a cause of a fault on an axis from the next tick on; `None` removes all causes.
    fn fault(&self, py: Python<'_>, axis: &str, kind: Option<&str>) -> PyResult<()> {
        let mut inner = self.lock(py);
        let (axis, bits) = cause(py, inner.cell.machine(), axis, kind)?;
        inner.cell.inject(axis, bits);
        inner.note(Entry::Fault(axis.0, bits));
        Ok(())
    }

    /// Lets time pass until an expression is true at the end of a tick, for `seconds` at most; whether it came true. A tick that has ended is looked at
    /// first.
    fn _until(&self, py: Python<'_>, expression: &str, seconds: f64) -> PyResult<bool> {
        let (_, scans) = self.scans(py, seconds)?;
        let over = AtomicBool::new(false);
        let holds = on_deep_stack(py, &over, || {
            self.inner.free(|inner| {
                if !inner.conditions.contains_key(expression) {
                    let condition = inner.cell.condition(expression)?;
                    inner.conditions.insert(expression.to_owned(), condition);
                }
                let Inner { cell, conditions, .. } = inner;
                let condition = conditions.get(expression);
                Ok::<_, String>(!cell.is_open() && condition.is_some_and(|condition| cell.holds(condition)))
            })
        })?;
        match holds {
            Err(reason) => Err(no_condition(py, &self.lock(py).cell, expression, &reason)),
            Ok(true) => Ok(true),
            Ok(false) => self.pass_ticks(py, scans, Some(expression)),
        }
    }

    /// The data to make the same cell again: the project, its name, the configuration, the phase, what may be missing, and all calls.
    fn _journal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let inner = self.lock(py);
        let list = PyList::empty(py);
        for entry in &inner.journal {
            match entry {
                Entry::Ticks(ticks) => list.append(("step", ticks))?,
                Entry::Write(path, value) => list.append(("write", path, values::python(py, value)?))?,
                Entry::Fault(axis, bits) => list.append(("fault", axis, bits))?,
            }
        }
        let Given {
            text,
            config,
            scan_phase,
            allow_missing,
            ..
        } = &self.given;
        (text.as_str(), config.as_deref(), *scan_phase, *allow_missing, list).into_pyobject(py)
    }

    /// Repeats the calls of a journal.
    fn _replay(&self, py: Python<'_>, journal: Vec<Bound<'_, PyTuple>>) -> PyResult<()> {
        for entry in journal {
            let kind: String = entry.get_item(0)?.extract()?;
            match kind.as_str() {
                "step" => self.step(py, entry.get_item(1)?.extract()?)?,
                "write" => self.__setitem__(py, &entry.get_item(1)?.extract::<String>()?, &entry.get_item(2)?)?,
                _ => {
                    let (_, axis, bits): (String, u16, u32) = entry.extract()?;
                    let mut inner = self.lock(py);
                    inner.cell.inject(AxisId(axis), bits);
                    inner.note(Entry::Fault(axis, bits));
                }
            }
        }
        Ok(())
    }
}

/// The signal of a name: one of an axis in full precision, or a tag that is a number.
fn signal(py: Python<'_>, cell: &mut SimulatedCell, name: &str) -> PyResult<Signal> {
    if let Some(signal) = Signal::of_axis(cell.machine(), name) {
        return Ok(signal);
    }
    let path = values::path(py, name)?;
    match cell.value(&path) {
        Ok(value) if value.as_f64().is_some() => Ok(Signal::Tag(path)),
        Ok(value) => {
            let text = format!("{name} is a {}, expected a number", value.type_name());
            Err(raise(py, "TagError", (text,)))
        }
        Err(error) => Err(unread(py, cell, name, &error)),
    }
}

//! `Machine`: a machine with its tags and programs, stepped from Python.
//!
//! Calls that let time pass release the interpreter first and lock the machine then, so that other threads of Python run meanwhile; nothing
//! of Python is called under the lock.

use std::collections::BTreeMap;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use arcline_config::Project;
use arcline_controller::image::Image;
use arcline_controller::machine::Machine as Configured;
use arcline_controller::{Controller, Event};
use arcline_instruction_set::{AxisId, FAULTS, FaultSet, Flag};
use arcline_simulation::{ImageNames, Limits, Observer, Origin, ProgramId, Runner, Simulation};
use arcline_structured_text::{Interpreter, OnError, Policy, Program, QueueFull};
use numpy::{PyArray2, PyArrayMethods, PyReadwriteArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::errors::{self, raise};
use crate::signals::{Columns, Signal, sample};
use crate::values;

/// Ticks between two looks at the wall clock.
const SLICE: u64 = 1024;
/// Wall time between two looks at the signals of Python, such as Ctrl-C.
const LOOK: Duration = Duration::from_millis(10);
/// Events that wait to be taken, at most; older ones are dropped.
const EVENTS: usize = 100_000;

/// A machine on a virtual clock, with its tags and programs. Deterministic: the same calls in the same order give the same state.
#[pyclass(frozen, subclass, module = "arcline._arcline", mapping)]
pub(crate) struct Machine {
    inner: Mutex<Inner>,
    config: String,
    seed: u64,
}

struct Inner {
    runner: Runner,
    /// The programs by their number, in the order in which they were started.
    programs: Vec<ProgramId>,
    events: Events,
    /// Faults that are to be injected, by tick: axis and causes, or none to take them away.
    faults: BTreeMap<u64, Vec<(AxisId, u32)>>,
    /// What was done since the beginning; `None`: it is not kept.
    journal: Option<Vec<Entry>>,
}

/// What a caller did to a machine: what is needed to do it again.
#[derive(Clone, Debug)]
enum Entry {
    Step(u64),
    Write(String, arcline_tag::WriteValue),
    Program(String, bool, bool),
    Remove(usize),
    Fault(u64, u16, u32),
}

/// Collects events.
#[derive(Default)]
struct Events {
    waiting: VecDeque<(f64, Event, String)>,
    is_on: bool,
}

impl Observer for Events {
    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        if !self.is_on || event.set | event.clear == 0 {
            return;
        }
        if self.waiting.len() == EVENTS {
            self.waiting.pop_front();
        }
        self.waiting
            .push_back((time, *event, image.control_name(event.control).to_owned()));
    }
}

/// Samples signals at the end of ticks.
struct Rows<'r> {
    events: &'r mut Events,
    columns: &'r Columns,
    rows: std::slice::ChunksExactMut<'r, f64>,
}

impl Observer for Rows<'_> {
    fn event(&mut self, event: &Event, time: f64, image: &Image) {
        self.events.event(event, time, image);
    }

    fn tick(&mut self, _: u64, _: &Configured, controller: &mut Controller) -> bool {
        if let Some(row) = self.rows.next() {
            self.columns.read(controller, row);
        }
        true
    }
}

impl Inner {
    fn new(project: &Project, journal: bool) -> Self {
        let runner = Runner::of(Simulation::of_project(project));
        runner.simulation().begin();
        Inner {
            runner,
            programs: Vec::new(),
            events: Events::default(),
            faults: BTreeMap::new(),
            journal: journal.then(Vec::new),
        }
    }

    fn tick(&self) -> u64 {
        self.runner.simulation().tick()
    }

    fn note(&mut self, entry: Entry) {
        let Some(journal) = &mut self.journal else { return };
        match (journal.last_mut(), &entry) {
            (Some(Entry::Step(before)), Entry::Step(more)) => *before += more,
            _ => journal.push(entry),
        }
    }

    /// Lets ticks pass, and injects the faults that are due.
    fn step(&mut self, ticks: u64) {
        self.note(Entry::Step(ticks));
        let end = self.tick().saturating_add(ticks);
        while self.inject_due() < end {
            let now = self.tick();
            let next = self.faults.keys().next().copied().unwrap_or(end).min(end);
            let limits = Limits {
                ticks: next.saturating_sub(now),
                until: f64::INFINITY,
            };
            self.runner.step(limits, &mut self.events);
        }
    }

    /// The same with a row of signals at the end of each tick.
    fn trace(&mut self, ticks: u64, signals: &[Signal], rows: &mut [f64]) {
        let width = signals.len().max(1);
        if signals.iter().any(Signal::is_tag) {
            for row in rows.chunks_exact_mut(width) {
                sample(&mut self.runner.simulation(), signals, row);
                self.step(1);
            }
            return;
        }
        self.note(Entry::Step(ticks));
        let end = self.tick().saturating_add(ticks);
        let columns = Columns::new(signals);
        let mut rows = rows;
        while self.inject_due() < end {
            let now = self.tick();
            let next = self.faults.keys().next().copied().unwrap_or(end).min(end);
            let count = next.saturating_sub(now);
            let (part, rest) = std::mem::take(&mut rows).split_at_mut(count as usize * width);
            rows = rest;
            let mut observer = Rows {
                events: &mut self.events,
                columns: &columns,
                rows: part.chunks_exact_mut(width),
            };
            let limits = Limits {
                ticks: count,
                until: f64::INFINITY,
            };
            self.runner.step(limits, &mut observer);
        }
    }

    /// Injects the faults whose time has come. The present tick.
    fn inject_due(&mut self) -> u64 {
        let now = self.tick();
        while let Some(entry) = self.faults.first_entry().filter(|entry| *entry.key() <= now) {
            let mut simulation = self.runner.simulation();
            for (axis, bits) in entry.remove() {
                // The axis and the causes were checked.
                let _ = simulation.write(Origin::default(), |image| image.inject_faults(axis, bits));
            }
        }
        now
    }

    fn start(&mut self, py: Python<'_>, text: &str, wait: bool, keep_going: bool) -> PyResult<usize> {
        let program = parsed(py, self.runner.simulation().image(), text)?;
        let id = self.runner.start(Interpreter::new(program), policy(wait, keep_going));
        self.programs.push(id);
        self.note(Entry::Program(text.to_owned(), wait, keep_going));
        Ok(self.programs.len() - 1)
    }
}

/// A program whose names are those of a machine.
pub(crate) fn parsed(py: Python<'_>, image: &Image, text: &str) -> PyResult<Program> {
    let checked = Program::parse(text).and_then(|mut program| program.check(&ImageNames(image)).map(|()| program));
    checked.map_err(|error| errors::program(py, &error.to_string(), error.line))
}

/// How a program runs.
pub(crate) fn policy(wait: bool, keep_going: bool) -> Policy {
    Policy {
        queue_full: if wait { QueueFull::Wait } else { QueueFull::Error },
        on_error: if keep_going { OnError::KeepGoing } else { OnError::Stop },
    }
}

/// Whole ticks of so many seconds.
fn ticks_of(machine: &Configured, seconds: f64) -> PyResult<u64> {
    if !(0.0..1e9).contains(&seconds) {
        return Err(PyValueError::new_err(format!("{seconds} s: expected 0 to 1e9 seconds")));
    }
    Ok((seconds * 1e9 / machine.period_ns as f64).round() as u64)
}

impl Machine {
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Works on the machine with the interpreter released.
    fn detached<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Inner) -> R + Send) -> R {
        py.detach(|| work(&mut self.lock()))
    }

    /// Lets ticks pass, and looks at signals of Python now and then.
    fn pass(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut left = ticks;
        let mut looked = Instant::now();
        while left > 0 {
            let slice = left.min(SLICE);
            self.detached(py, |inner| inner.step(slice));
            left -= slice;
            if left > 0 && looked.elapsed() >= LOOK {
                py.check_signals()?;
                looked = Instant::now();
            }
        }
        Ok(())
    }

    fn configured(&self) -> std::sync::Arc<Configured> {
        self.lock().runner.simulation().machine().clone()
    }
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (config=None, *, seed=0, set=None, journal=true))]
    fn new(
        py: Python<'_>,
        config: Option<&str>,
        seed: u64,
        set: Option<Vec<(String, Bound<'_, PyAny>)>>,
        journal: bool,
    ) -> PyResult<Self> {
        let (config, project) = errors::project(py, config)?;
        let machine = Machine {
            inner: Mutex::new(Inner::new(&project, journal)),
            config,
            seed,
        };
        for (path, value) in set.unwrap_or_default() {
            machine.__setitem__(py, &path, &value)?;
        }
        Ok(machine)
    }

    /// The seed that was given; the machine itself is deterministic.
    #[getter]
    fn seed(&self) -> u64 {
        self.seed
    }

    /// The text of the configuration.
    #[getter]
    fn config(&self) -> &str {
        &self.config
    }

    /// The present tick.
    #[getter]
    fn tick(&self) -> u64 {
        self.lock().tick()
    }

    /// Seconds at the present tick.
    #[getter]
    fn time(&self) -> f64 {
        self.lock().runner.simulation().time()
    }

    /// Seconds of a tick.
    #[getter]
    fn period(&self) -> f64 {
        self.configured().period()
    }

    /// The names of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        self.configured().axes.iter().map(|axis| axis.name.clone()).collect()
    }

    /// The names of all tags.
    fn tags(&self) -> Vec<String> {
        let inner = self.lock();
        let simulation = inner.runner.simulation();
        simulation
            .image()
            .tags()
            .iter()
            .map(|tag| simulation.image().full_name(tag))
            .collect()
    }

    /// Whether nothing moves, and nothing is under way that would end.
    #[getter]
    fn at_rest(&self) -> bool {
        self.lock().runner.simulation().controller().at_rest()
    }

    fn __getitem__(&self, py: Python<'_>, path: &str) -> PyResult<Py<PyAny>> {
        let inner = self.lock();
        let mut simulation = inner.runner.simulation();
        values::read(py, &mut simulation, path)
    }

    fn __setitem__(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = values::given(value)?;
        let mut inner = self.lock();
        values::write(py, &mut inner.runner.simulation(), path, &value)?;
        inner.note(Entry::Write(path.to_owned(), value));
        Ok(())
    }

    fn __contains__(&self, path: &str) -> bool {
        let inner = self.lock();
        let simulation = inner.runner.simulation();
        path.parse().is_ok_and(|path| simulation.image().locate(&path).is_ok())
    }

    /// Lets `ticks` ticks pass.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        self.pass(py, ticks)
    }

    /// Lets `seconds` pass.
    fn run(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        self.pass(py, ticks_of(&self.configured(), seconds)?)
    }

    /// Samples signals for `steps` ticks into `out`, or a new array of `(steps, len(signals))`.
    #[pyo3(signature = (signals, steps, out=None))]
    fn trace<'py>(
        &self,
        py: Python<'py>,
        signals: Vec<String>,
        steps: usize,
        out: Option<Bound<'py, PyArray2<f64>>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let signals = {
            let inner = self.lock();
            let simulation = inner.runner.simulation();
            signals
                .iter()
                .map(|name| Signal::new(py, &simulation, name))
                .collect::<PyResult<Vec<_>>>()?
        };
        let array = out.unwrap_or_else(|| PyArray2::zeros(py, [steps, signals.len()], false));
        let mut rows: PyReadwriteArray2<'py, f64> = array.try_readwrite()?;
        let shape = rows.as_array().dim();
        if shape != (steps, signals.len()) {
            let (rows, columns) = shape;
            return Err(PyValueError::new_err(format!(
                "out is {rows} by {columns}, expected {steps} by {}",
                signals.len()
            )));
        }
        let width = signals.len();
        let mut left = rows
            .as_slice_mut()
            .map_err(|_| PyValueError::new_err("out is not contiguous in C order"))?;
        let mut steps_left = steps;
        while steps_left > 0 {
            let slice = steps_left.min(SLICE as usize * 8);
            let (part, rest) = left.split_at_mut(slice * width);
            self.detached(py, |inner| inner.trace(slice as u64, &signals, part));
            (left, steps_left) = (rest, steps_left - slice);
            py.check_signals()?;
        }
        drop(rows);
        Ok(array)
    }

    /// Puts a cause of a fault on an axis, now or `at` so many seconds; `None` takes all causes away.
    #[pyo3(signature = (axis, kind, at=None))]
    fn fault(&self, py: Python<'_>, axis: &str, kind: Option<&str>, at: Option<f64>) -> PyResult<()> {
        let machine = self.configured();
        let known = || {
            machine
                .axes
                .iter()
                .map(|axis| axis.name.as_str())
                .collect::<Vec<_>>()
                .join(", ")
        };
        let index = machine
            .axes
            .iter()
            .position(|known| known.name.eq_ignore_ascii_case(axis));
        let index = index.ok_or_else(|| {
            raise(
                py,
                "TagError",
                (format!("there is no axis {axis:?}, only {}", known()),),
            )
        })?;
        let bits = match kind {
            None => 0,
            Some(word) => {
                let spaced = word.replace('_', " ");
                let fault = FAULTS
                    .iter()
                    .find(|fault| fault.word.replace('_', " ").eq_ignore_ascii_case(&spaced));
                let Some(fault) = fault else {
                    let words: Vec<&str> = FAULTS.iter().map(|fault| fault.word).collect();
                    return Err(PyValueError::new_err(format!(
                        "{word:?} is no fault, expected one of {}",
                        words.join(", ")
                    )));
                };
                FaultSet::default().with(fault.kind).bits()
            }
        };
        let possible = FaultSet::possible(!machine.axes[index].is_virtual()).bits();
        if bits & !possible != 0 {
            return Err(PyValueError::new_err(format!(
                "{axis} is a virtual axis and cannot have that fault"
            )));
        }
        let mut inner = self.lock();
        let tick = match at {
            None => inner.tick(),
            Some(at) => ticks_of(&machine, at)?,
        };
        if tick < inner.tick() {
            return Err(PyValueError::new_err("that time has passed"));
        }
        inner
            .faults
            .entry(tick)
            .or_default()
            .push((AxisId::from_index(index), bits));
        inner.note(Entry::Fault(tick, index as u16, bits));
        inner.inject_due();
        Ok(())
    }

    /// The events since the last call, as tuples; collected from the first call on.
    fn _events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let waiting = {
            let mut inner = self.lock();
            std::mem::take(&mut inner.events.waiting)
        };
        let list = PyList::empty(py);
        for (time, event, tag) in waiting {
            let flags = |word| Flag::in_word(word).map(Flag::name).collect::<Vec<_>>();
            let row = (
                time,
                event.tick,
                tag,
                event.mnemonic.name(),
                flags(event.set),
                flags(event.clear),
                event.err,
                event.exerr,
            );
            list.append(row)?;
        }
        Ok(list)
    }

    /// Collects events from now on.
    fn _collect_events(&self) {
        self.lock().events.is_on = true;
    }

    /// Starts a program; its number.
    fn _start(&self, py: Python<'_>, text: &str, wait: bool, keep_going: bool) -> PyResult<usize> {
        self.lock().start(py, text, wait, keep_going)
    }

    /// Whether a program still runs.
    fn _runs(&self, program: usize) -> bool {
        let inner = self.lock();
        inner.programs.get(program).is_some_and(|id| inner.runner.runs(*id))
    }

    /// The exception of a program that failed, so far.
    fn _error<'py>(&self, py: Python<'py>, program: usize) -> Option<Bound<'py, PyAny>> {
        let end = {
            let inner = self.lock();
            let id = *inner.programs.get(program)?;
            inner.runner.end_of(id)?.err()?
        };
        Some(errors::ended(py, &end)?.into_value(py).into_bound(py).into_any())
    }

    /// Ends a program where it is.
    fn _remove(&self, program: usize) {
        let mut inner = self.lock();
        if let Some(id) = inner.programs.get(program).copied() {
            inner.runner.remove(id);
            inner.note(Entry::Remove(program));
        }
    }

    /// What makes the same machine again: the configuration, the seed, and all that was done.
    fn _journal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let inner = self.lock();
        let Some(journal) = &inner.journal else {
            return Err(raise(
                py,
                "ArclineError",
                ("a machine with journal=False cannot be saved or pickled",),
            ));
        };
        let list = PyList::empty(py);
        for entry in journal {
            match entry {
                Entry::Step(ticks) => list.append(("step", ticks))?,
                Entry::Write(path, value) => list.append(("write", path, values::python(py, value)?))?,
                Entry::Program(text, wait, keep_going) => list.append(("program", text, wait, keep_going))?,
                Entry::Remove(program) => list.append(("remove", program))?,
                Entry::Fault(tick, axis, bits) => list.append(("fault", tick, axis, bits))?,
            }
        }
        (self.config.as_str(), self.seed, list).into_pyobject(py)
    }

    /// Does again what a journal says.
    fn _replay(&self, py: Python<'_>, journal: Vec<Bound<'_, PyTuple>>) -> PyResult<()> {
        for entry in journal {
            let kind: String = entry.get_item(0)?.extract()?;
            match kind.as_str() {
                "step" => self.pass(py, entry.get_item(1)?.extract()?)?,
                "write" => self.__setitem__(py, &entry.get_item(1)?.extract::<String>()?, &entry.get_item(2)?)?,
                "program" => {
                    let (_, text, wait, keep_going): (String, String, bool, bool) = entry.extract()?;
                    self.lock().start(py, &text, wait, keep_going)?;
                }
                "remove" => self._remove(entry.get_item(1)?.extract()?),
                _ => {
                    let (_, tick, axis, bits): (String, u64, u16, u32) = entry.extract()?;
                    let mut inner = self.lock();
                    inner.faults.entry(tick).or_default().push((AxisId(axis), bits));
                    inner.note(Entry::Fault(tick, axis, bits));
                    inner.inject_due();
                }
            }
        }
        Ok(())
    }

    /// Becomes the machine of a configuration at its beginning.
    fn _restart(&self, py: Python<'_>, config: &str) -> PyResult<()> {
        if config != self.config {
            return Err(raise(
                py,
                "ArclineError",
                ("the state is of a machine with another configuration",),
            ));
        }
        let (_, project) = errors::project(py, Some(config))?;
        let mut inner = self.lock();
        let is_on = inner.events.is_on;
        *inner = Inner::new(&project, true);
        inner.events.is_on = is_on;
        Ok(())
    }
}

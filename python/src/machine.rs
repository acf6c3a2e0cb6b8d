//! `Machine`: a machine with its tags and programs, stepped from Python.
//!
//! Calls that let time pass release the interpreter first and lock the machine then, so that other threads of Python run meanwhile. All others wait for
//! the lock with the interpreter released, and get it after the slice of ticks that passes.

use std::sync::{Arc, MutexGuard};

use arcline_controller::machine::Machine as MachineConfig;
use arcline_instruction_set::{AxisId, FAULTS, FaultSet, Flag};
use numpy::{PyArray2, PyArrayMethods, PyReadwriteArray2};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::errors::{self, raise};
use crate::fair::Fair;
use crate::inner::{Entry, Inner};
use crate::interrupt::Pace;
use crate::plant::{Plant, Shared};
use crate::signals::signal;
use crate::{trace, values};

/// Ticks before the first check for signals of Python.
const FIRST_SLICE: u64 = 64;

/// A machine on a virtual clock, with its tags and programs. Deterministic: the same calls in the same order give the same state.
#[pyclass(frozen, subclass, module = "arcline._arcline", mapping)]
pub(crate) struct Machine {
    inner: Fair<Inner>,
    /// The state that it shares with its plant.
    plant: Option<Shared>,
    config: String,
    seed: u64,
}

/// The whole ticks in a number of seconds.
pub(crate) fn ticks_of(machine: &MachineConfig, seconds: f64) -> PyResult<u64> {
    if !(0.0..1e9).contains(&seconds) {
        return Err(PyValueError::new_err(format!("{seconds} s: expected 0 to 1e9 seconds")));
    }
    Ok((seconds * 1e9 / machine.period_ns as f64).round() as u64)
}

/// The axis of a name, and the cause of a fault that it can have as bits; `None`: no bits.
pub(crate) fn cause(
    py: Python<'_>,
    machine: &MachineConfig,
    axis: &str,
    kind: Option<&str>,
) -> PyResult<(AxisId, u32)> {
    let index = machine
        .axes
        .iter()
        .position(|known| known.name.eq_ignore_ascii_case(axis));
    let index = index.ok_or_else(|| {
        let known: Vec<&str> = machine.axes.iter().map(|axis| axis.name.as_str()).collect();
        let text = format!("there is no axis {axis:?}, only {}", known.join(", "));
        raise(py, "TagError", (text,))
    })?;
    let Some(word) = kind else {
        return Ok((AxisId::from_index(index), 0));
    };
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
    let bits = FaultSet::default().with(fault.kind).bits();
    if bits & !FaultSet::possible(!machine.axes[index].is_virtual()).bits() != 0 {
        return Err(PyValueError::new_err(format!(
            "{axis} is a virtual axis and cannot have that fault"
        )));
    }
    Ok((AxisId::from_index(index), bits))
}

impl Machine {
    fn lock(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Inner>> {
        self.look_inside()?;
        Ok(self.inner.lock(py))
    }

    /// Refuses a plant that uses the machine which waits for its answer.
    fn look_inside(&self) -> PyResult<()> {
        if self.plant.as_ref().is_some_and(Shared::is_inside) {
            return Err(PyRuntimeError::new_err(
                "a plant cannot use its own machine: the machine waits for its feedback",
            ));
        }
        Ok(())
    }

    /// Raises the exception of the plant.
    fn plant_error(&self) -> PyResult<()> {
        self.plant.as_ref().and_then(Shared::take_error).map_or(Ok(()), Err)
    }

    /// Lets ticks pass slice by slice, and checks for signals of Python between them.
    fn pass(&self, py: Python<'_>, ticks: u64, mut work: impl FnMut(&mut Inner, u64) + Send) -> PyResult<()> {
        self.look_inside()?;
        let mut left = ticks;
        let mut pace = Pace::new(FIRST_SLICE);
        while left > 0 {
            let slice = left.min(pace.ticks());
            self.inner.detached(py, |inner| work(inner, slice));
            self.plant_error()?;
            left -= slice;
            if left > 0 {
                py.check_signals()?;
                pace.next();
            }
        }
        Ok(())
    }

    fn configured(&self, py: Python<'_>) -> PyResult<Arc<MachineConfig>> {
        Ok(self.lock(py)?.runner.simulation().machine().clone())
    }
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (config=None, *, seed=0, set=None, journal=true, plant=None, plant_axes=None))]
    fn new(
        py: Python<'_>,
        config: Option<&str>,
        seed: u64,
        set: Option<Vec<(String, Bound<'_, PyAny>)>>,
        journal: bool,
        plant: Option<Bound<'_, PyAny>>,
        plant_axes: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let (config, project) = errors::project(py, config)?;
        let plant = plant
            .map(|call| Plant::new(py, call, plant_axes, &project.machine))
            .transpose()?;
        let shared = plant.as_ref().map(Plant::shared);
        let machine = Machine {
            inner: Fair::new(Inner::new(&project, journal, plant)),
            plant: shared,
            config,
            seed,
        };
        machine.plant_error()?;
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
    fn tick(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(self.lock(py)?.tick())
    }

    /// Seconds at the present tick.
    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.lock(py)?.runner.simulation().time())
    }

    /// Seconds of a tick.
    #[getter]
    fn period(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.configured(py)?.period())
    }

    /// The names of the axes.
    #[getter]
    fn axes(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.configured(py)?.axes.iter().map(|axis| axis.name.clone()).collect())
    }

    /// The names of all tags.
    fn tags(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let inner = self.lock(py)?;
        let simulation = inner.runner.simulation();
        let image = simulation.image();
        Ok(image.tags().iter().map(|tag| image.full_name(tag)).collect())
    }

    /// Whether the machine is at rest: no axis moves, and no execution is still to end.
    #[getter]
    fn at_rest(&self, py: Python<'_>) -> PyResult<bool> {
        Ok(self.lock(py)?.runner.simulation().controller().at_rest())
    }

    fn __getitem__(&self, py: Python<'_>, path: &str) -> PyResult<Py<PyAny>> {
        let inner = self.lock(py)?;
        let mut simulation = inner.runner.simulation();
        values::read(py, &mut simulation, path)
    }

    fn __setitem__(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let value = values::given(value)?;
        let mut inner = self.lock(py)?;
        values::write(py, &mut inner.runner.simulation(), path, &value)?;
        inner.note(Entry::Write(path.to_owned(), value));
        Ok(())
    }

    fn __contains__(&self, py: Python<'_>, path: &str) -> PyResult<bool> {
        let inner = self.lock(py)?;
        let simulation = inner.runner.simulation();
        Ok(path.parse().is_ok_and(|path| simulation.image().locate(&path).is_ok()))
    }

    /// Lets `ticks` ticks pass.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        self.pass(py, ticks, Inner::step)
    }

    /// Lets `seconds` pass.
    fn run(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        let configured = self.configured(py)?;
        self.pass(py, ticks_of(&configured, seconds)?, Inner::step)
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
            let inner = self.lock(py)?;
            let simulation = inner.runner.simulation();
            signals
                .iter()
                .map(|name| signal(py, &simulation, name))
                .collect::<PyResult<Vec<_>>>()?
        };
        let array = trace::array(py, steps, signals.len(), out)?;
        let mut rows: PyReadwriteArray2<'py, f64> = array.try_readwrite()?;
        let width = signals.len();
        let mut left = trace::contiguous(&mut rows)?;
        self.pass(py, steps as u64, |inner, slice| {
            let (part, rest) = std::mem::take(&mut left).split_at_mut(slice as usize * width);
            left = rest;
            inner.trace(slice, &signals, part);
        })?;
        drop(rows);
        Ok(array)
    }

    /// Injects a cause of a fault on an axis, now or at the time `at`, seconds; `None` removes all causes.
    #[pyo3(signature = (axis, kind, at=None))]
    fn fault(&self, py: Python<'_>, axis: &str, kind: Option<&str>, at: Option<f64>) -> PyResult<()> {
        let machine = self.configured(py)?;
        let (axis, bits) = cause(py, &machine, axis, kind)?;
        let mut inner = self.lock(py)?;
        let tick = match at {
            None => inner.tick(),
            Some(at) => ticks_of(&machine, at)?,
        };
        if tick < inner.tick() {
            return Err(PyValueError::new_err("that time has passed"));
        }
        inner.faults.entry(tick).or_default().push((axis, bits));
        inner.note(Entry::Fault(tick, axis.0, bits));
        inner.inject_due();
        Ok(())
    }

    /// The events since the last call, as tuples; collected from the first call on.
    fn _events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let waiting = {
            let mut inner = self.lock(py)?;
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
    fn _collect_events(&self, py: Python<'_>) -> PyResult<()> {
        self.lock(py)?.events.is_on = true;
        Ok(())
    }

    /// Starts a program; its number.
    fn _start(&self, py: Python<'_>, text: &str, wait: bool, keep_going: bool) -> PyResult<usize> {
        self.lock(py)?.start(py, text, wait, keep_going)
    }

    /// Whether a program still runs.
    fn _runs(&self, py: Python<'_>, program: usize) -> PyResult<bool> {
        let inner = self.lock(py)?;
        Ok(inner.programs.get(program).is_some_and(|id| inner.runner.runs(*id)))
    }

    /// The exception of a program that failed, so far.
    fn _error<'py>(&self, py: Python<'py>, program: usize) -> PyResult<Option<Bound<'py, PyAny>>> {
        let error = {
            let inner = self.lock(py)?;
            let id = inner.programs.get(program);
            id.and_then(|id| errors::of_program(py, &inner.runner, *id))
        };
        Ok(error.map(|error| error.into_value(py).into_bound(py).into_any()))
    }

    /// Ends a program at its present statement.
    fn _remove(&self, py: Python<'_>, program: usize) -> PyResult<()> {
        let mut inner = self.lock(py)?;
        if let Some(id) = inner.programs.get(program).copied() {
            inner.runner.remove(id);
            inner.note(Entry::Remove(program));
        }
        Ok(())
    }

    /// The data to make the same machine again: the configuration, the seed, and all calls.
    fn _journal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let inner = self.lock(py)?;
        let Some(journal) = &inner.journal else {
            return Err(raise(
                py,
                "ArclineError",
                (if self.plant.is_some() {
                    "a machine with a plant cannot be saved or pickled: the state of the plant is not known"
                } else {
                    "a machine with journal=False cannot be saved or pickled"
                },),
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

    /// Repeats the calls of a journal.
    fn _replay(&self, py: Python<'_>, journal: Vec<Bound<'_, PyTuple>>) -> PyResult<()> {
        for entry in journal {
            let kind: String = entry.get_item(0)?.extract()?;
            match kind.as_str() {
                "step" => self.step(py, entry.get_item(1)?.extract()?)?,
                "write" => self.__setitem__(py, &entry.get_item(1)?.extract::<String>()?, &entry.get_item(2)?)?,
                "program" => {
                    let (_, text, wait, keep_going): (String, String, bool, bool) = entry.extract()?;
                    self.lock(py)?.start(py, &text, wait, keep_going)?;
                }
                "remove" => self._remove(py, entry.get_item(1)?.extract()?)?,
                _ => {
                    let (_, tick, axis, bits): (String, u64, u16, u32) = entry.extract()?;
                    let mut inner = self.lock(py)?;
                    inner.faults.entry(tick).or_default().push((AxisId(axis), bits));
                    inner.note(Entry::Fault(tick, axis, bits));
                    inner.inject_due();
                }
            }
        }
        Ok(())
    }

    /// Becomes the machine of a configuration at its beginning, and repeats the calls of a journal. The events of that time are not collected.
    fn _restore(&self, py: Python<'_>, config: &str, journal: Vec<Bound<'_, PyTuple>>) -> PyResult<()> {
        if self.plant.is_some() {
            return Err(raise(
                py,
                "ArclineError",
                ("a machine with a plant cannot be restored",),
            ));
        }
        if config != self.config {
            return Err(raise(
                py,
                "ArclineError",
                ("the state is of a machine with another configuration",),
            ));
        }
        let (_, project) = errors::project(py, Some(config))?;
        let is_on = {
            let mut inner = self.lock(py)?;
            let before = std::mem::replace(&mut *inner, Inner::new(&project, true, None));
            before.events.is_on
        };
        let replayed = self._replay(py, journal);
        self.lock(py)?.events.is_on = is_on;
        replayed
    }
}

//! `Batch`: many machines of one configuration, stepped together on several threads.

use std::num::NonZeroUsize;
use std::sync::{Mutex, MutexGuard, PoisonError};

use arcline_config::Project;
use arcline_simulation::{Blind, RunLimits, Runner, Simulation};
use arcline_structured_text::Interpreter;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadwriteArray1};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use crate::inner::{parsed, policy};
use crate::signals::{self, Signal, sample};
use crate::{errors, values};

/// Ticks between two checks for signals of Python.
const SLICE: u64 = 4096;

/// A truth for each machine.
type Mask<'py> = PyReadonlyArray1<'py, bool>;

/// `n` machines of one configuration, stepped together.
#[pyclass(frozen, module = "arcline._arcline")]
pub(crate) struct Batch {
    inner: Mutex<Inner>,
    count: usize,
    threads: usize,
}

struct Inner {
    project: Project,
    runners: Vec<Runner>,
    /// Signals with their arrays, which steps refresh.
    bound: Vec<(Signal, Py<PyArray1<f64>>)>,
}

fn fresh(project: &Project) -> Runner {
    let runner = Runner::of(Simulation::of_project(project));
    runner.simulation().begin();
    runner
}

impl Batch {
    /// Waits with the interpreter released: who holds the lock may need it.
    fn lock(&self, py: Python<'_>) -> MutexGuard<'_, Inner> {
        self.inner.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }

    /// The machines whose element of the mask is true; without a mask all.
    fn masked<'r>(&self, runners: &'r mut [Runner], mask: Option<&Mask<'_>>) -> PyResult<Vec<&'r mut Runner>> {
        let mask = mask.map(PyReadonlyArray1::as_array);
        if mask.as_ref().is_some_and(|mask| mask.len() != self.count) {
            return Err(PyValueError::new_err(format!(
                "the mask must have {} elements",
                self.count
            )));
        }
        let wanted = |index: usize| mask.as_ref().is_none_or(|mask| mask[index]);
        let runners = runners.iter_mut().enumerate();
        Ok(runners
            .filter_map(|(index, runner)| wanted(index).then_some(runner))
            .collect())
    }

    /// Steps all machines, then samples the bound signals of each into its element of their arrays.
    fn pass(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut inner = self.lock(py);
        let Inner { runners, bound, .. } = &mut *inner;
        let signals: Vec<Signal> = bound.iter().map(|(signal, _)| signal.clone()).collect();
        let mut arrays = Vec::with_capacity(bound.len());
        for (_, array) in bound.iter() {
            let array: PyReadwriteArray1<'_, f64> = array.bind(py).try_readwrite()?;
            arrays.push(array);
        }
        let mut columns = Vec::with_capacity(arrays.len());
        for array in &mut arrays {
            columns.push(
                array
                    .as_slice_mut()
                    .map_err(|_| PyValueError::new_err("a bound array is not contiguous"))?,
            );
        }
        let size = self.count.div_ceil(self.threads);
        py.detach(|| {
            std::thread::scope(|scope| {
                let mut columns: Vec<_> = columns.into_iter().map(|column| column.chunks_mut(size)).collect();
                let mut chunks = runners.chunks_mut(size).peekable();
                while let Some(chunk) = chunks.next() {
                    let columns: Vec<_> = columns.iter_mut().filter_map(Iterator::next).collect();
                    let signals = &signals;
                    let work = move || work(chunk, columns, signals, ticks);
                    // The last part is this thread's.
                    if chunks.peek().is_some() {
                        scope.spawn(work);
                    } else {
                        work();
                    }
                }
            });
        });
        Ok(())
    }
}

/// Steps some machines.
fn work(runners: &mut [Runner], mut columns: Vec<&mut [f64]>, signals: &[Signal], ticks: u64) {
    let mut row = vec![0.0; signals.len()];
    for (index, runner) in runners.iter_mut().enumerate() {
        let limits = RunLimits {
            ticks,
            until: f64::INFINITY,
        };
        runner.step(limits, &mut Blind);
        if !signals.is_empty() {
            sample(&mut runner.simulation(), signals, &mut row);
            for (column, value) in columns.iter_mut().zip(&row) {
                column[index] = *value;
            }
        }
    }
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (config=None, *, n, threads=0))]
    fn new(py: Python<'_>, config: Option<&str>, n: usize, threads: usize) -> PyResult<Self> {
        if n == 0 {
            return Err(PyValueError::new_err("n is 0, expected 1 or more machines"));
        }
        let (_, project) = errors::project(py, config)?;
        let all = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        Ok(Batch {
            count: n,
            threads: if threads == 0 { all } else { threads }.min(n),
            inner: Mutex::new(Inner {
                runners: (0..n).map(|_| fresh(&project)).collect(),
                project,
                bound: Vec::new(),
            }),
        })
    }

    fn __len__(&self) -> usize {
        self.count
    }

    /// Threads that step.
    #[getter]
    fn threads(&self) -> usize {
        self.threads
    }

    /// An array of a signal of all machines, which every step refreshes.
    fn bind<'py>(&self, py: Python<'py>, signal: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut inner = self.lock(py);
        let array = PyArray1::zeros(py, self.count, false);
        let parsed = signals::signal(py, &inner.runners[0].simulation(), signal)?;
        {
            let mut values = array.try_readwrite()?;
            if let Ok(values) = values.as_slice_mut() {
                for (runner, value) in inner.runners.iter().zip(values) {
                    sample(
                        &mut runner.simulation(),
                        std::slice::from_ref(&parsed),
                        std::slice::from_mut(value),
                    );
                }
            }
        }
        inner.bound.push((parsed, array.clone().unbind()));
        Ok(array)
    }

    /// Writes a value, or one of each machine, to a tag of all machines.
    fn write(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let inner = self.lock(py);
        if let Ok(each) = value.extract::<PyReadonlyArray1<'_, f64>>() {
            let each = each.as_array();
            if each.len() != self.count {
                return Err(PyValueError::new_err(format!(
                    "{} values for {} machines",
                    each.len(),
                    self.count
                )));
            }
            for (runner, value) in inner.runners.iter().zip(each) {
                values::write(
                    py,
                    &mut runner.simulation(),
                    path,
                    &arcline_tag::WriteValue::Number(*value),
                )?;
            }
            return Ok(());
        }
        let value = values::given(value)?;
        for runner in &inner.runners {
            values::write(py, &mut runner.simulation(), path, &value)?;
        }
        Ok(())
    }

    /// The value of a tag of one machine.
    fn read(&self, py: Python<'_>, index: usize, path: &str) -> PyResult<Py<PyAny>> {
        let inner = self.lock(py);
        let runner = inner.runners.get(index);
        let runner =
            runner.ok_or_else(|| PyIndexError::new_err(format!("{index}: there are {} machines", self.count)))?;
        values::read(py, &mut runner.simulation(), path)
    }

    /// Starts a program on every machine, or on those whose element of `mask` is true.
    #[pyo3(signature = (text, *, keep_going=false, mask=None))]
    fn program(&self, py: Python<'_>, text: &str, keep_going: bool, mask: Option<Mask<'_>>) -> PyResult<()> {
        let mut inner = self.lock(py);
        let program = parsed(py, inner.runners[0].simulation().image(), text)?;
        for runner in self.masked(&mut inner.runners, mask.as_ref())? {
            runner.start(Interpreter::new(program.clone()), policy(true, keep_going));
        }
        Ok(())
    }

    /// Lets `ticks` ticks pass on every machine; with 0 ticks the bound arrays are refreshed and no more.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut left = ticks;
        loop {
            let slice = left.min(SLICE);
            self.pass(py, slice)?;
            left -= slice;
            py.check_signals()?;
            if left == 0 {
                return Ok(());
            }
        }
    }

    /// Brings machines back to their beginning: those whose element of `mask` is true, or all.
    #[pyo3(signature = (mask=None))]
    fn reset(&self, py: Python<'_>, mask: Option<Mask<'_>>) -> PyResult<()> {
        let mut inner = self.lock(py);
        let Inner { project, runners, .. } = &mut *inner;
        for runner in self.masked(runners, mask.as_ref())? {
            *runner = fresh(project);
        }
        Ok(())
    }
}

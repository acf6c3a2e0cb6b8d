//! `Batch`: many machines of one configuration, stepped together on several threads.

use std::borrow::Cow;
use std::num::NonZeroUsize;
use std::sync::{Mutex, MutexGuard, PoisonError};

use arcline_config::Project;
use arcline_controller::image::Image;
use arcline_simulation::{Blind, ProgramId, RunLimits, Runner, Simulation};
use arcline_structured_text::Interpreter;
use arcline_tag::WriteValue;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadwriteArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyList;

use crate::inner::{parsed, policy};
use crate::interrupt::Pace;
use crate::signals::{self, Signal, sample};
use crate::{errors, values};

/// Ticks of one machine before the first check for signals of Python, shared out among all.
const FIRST_SLICE: u64 = 4096;

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
    members: Vec<Member>,
    /// Signals with their arrays, which steps refresh.
    bound: Vec<(Signal, Py<PyArray1<f64>>)>,
    /// Tags of no machine, in which writes are tried.
    tried: Image,
}

/// A machine, and the programs that were started on it since its beginning.
struct Member {
    runner: Runner,
    programs: Vec<ProgramId>,
}

impl Member {
    /// A machine at its beginning, unless a signal of Python has come: many machines take long.
    fn new(py: Python<'_>, project: &Project) -> PyResult<Self> {
        py.check_signals()?;
        let runner = py.detach(|| {
            let runner = Runner::of(Simulation::of_project(project));
            runner.simulation().begin();
            runner
        });
        Ok(Member {
            runner,
            programs: Vec::new(),
        })
    }
}

/// The values of a write: one for all machines, or one for each.
enum Given<'py> {
    All(WriteValue),
    Numbers(PyReadonlyArray1<'py, f64>),
    Each(Vec<WriteValue>),
}

impl<'py> Given<'py> {
    /// An array of NumPy has a value, or a row, for each machine; all else is for all.
    fn of(value: &Bound<'py, PyAny>, machines: usize) -> PyResult<Self> {
        let shape = value.cast::<PyUntypedArray>().map_or(&[][..], |array| array.shape());
        let Some(count) = shape.first() else {
            return Ok(Given::All(values::given(value)?));
        };
        if *count != machines {
            return Err(PyValueError::new_err(format!("{count} values for {machines} machines")));
        }
        if let Ok(numbers) = value.extract() {
            return Ok(Given::Numbers(numbers));
        }
        let elements = value.call_method0("tolist")?;
        let elements = elements.try_iter()?.map(|element| values::given(&element?));
        Ok(Given::Each(elements.collect::<PyResult<_>>()?))
    }

    /// Whether it has a number for each machine, which a whole array cannot hold.
    fn is_column(&self) -> bool {
        match self {
            Given::All(_) => false,
            Given::Numbers(_) => true,
            Given::Each(values) => !matches!(values.first(), Some(WriteValue::Array(_))),
        }
    }

    /// The value for a machine.
    fn at(&self, index: usize) -> Cow<'_, WriteValue> {
        match self {
            Given::All(value) => Cow::Borrowed(value),
            Given::Numbers(numbers) => Cow::Owned(WriteValue::Number(numbers.as_array()[index])),
            Given::Each(values) => Cow::Borrowed(&values[index]),
        }
    }
}

impl Batch {
    /// Waits with the interpreter released: who holds the lock may need it.
    fn lock(&self, py: Python<'_>) -> MutexGuard<'_, Inner> {
        self.inner.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }

    /// The numbers of the machines whose element of the mask is true; without a mask of all.
    fn masked(&self, mask: Option<&Mask<'_>>) -> PyResult<Vec<usize>> {
        let mask = mask.map(PyReadonlyArray1::as_array);
        if mask.as_ref().is_some_and(|mask| mask.len() != self.count) {
            return Err(PyValueError::new_err(format!(
                "the mask must have {} elements",
                self.count
            )));
        }
        let wanted = |index: usize| mask.as_ref().is_none_or(|mask| mask[index]);
        Ok((0..self.count).filter(|index| wanted(*index)).collect())
    }

    /// Steps all machines, then samples the bound signals of each into its element of their arrays.
    fn pass(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut inner = self.lock(py);
        let Inner { members, bound, .. } = &mut *inner;
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
        // Several pieces for each thread, so that one with less to do takes more of them.
        let size = self.count.div_ceil(self.threads * PIECES_PER_THREAD);
        let mut columns: Vec<_> = columns.into_iter().map(|column| column.chunks_mut(size)).collect();
        let pieces = members.chunks_mut(size).map(|chunk| {
            let columns: Vec<_> = columns.iter_mut().filter_map(Iterator::next).collect();
            (chunk, columns)
        });
        let pieces = Mutex::new(pieces.collect::<Vec<_>>());
        py.detach(|| {
            let work = || {
                loop {
                    let piece = pieces.lock().expect("no panic while it is locked").pop();
                    let Some((chunk, columns)) = piece else { return };
                    step(chunk, columns, &signals, ticks);
                }
            };
            std::thread::scope(|scope| {
                for _ in 1..self.threads {
                    scope.spawn(work);
                }
                work();
            });
        });
        Ok(())
    }
}

/// Pieces of a batch for each thread.
const PIECES_PER_THREAD: usize = 8;

/// Steps some machines.
fn step(members: &mut [Member], mut columns: Vec<&mut [f64]>, signals: &[Signal], ticks: u64) {
    let mut row = vec![0.0; signals.len()];
    for (index, Member { runner, .. }) in members.iter_mut().enumerate() {
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
                tried: project.image(),
                members: (0..n).map(|_| Member::new(py, &project)).collect::<PyResult<_>>()?,
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
        let parsed = signals::signal(py, &inner.members[0].runner.simulation(), signal)?;
        {
            let mut values = array.try_readwrite()?;
            if let Ok(values) = values.as_slice_mut() {
                for (member, value) in inner.members.iter().zip(values) {
                    sample(
                        &mut member.runner.simulation(),
                        std::slice::from_ref(&parsed),
                        std::slice::from_mut(value),
                    );
                }
            }
        }
        inner.bound.push((parsed, array.clone().unbind()));
        Ok(array)
    }

    /// Writes a tag of every machine, or of those whose element of `mask` is true. An array of NumPy has a value for each machine, or for an array tag a
    /// row; any other value is for all. If a machine cannot take its value, none is written.
    #[pyo3(signature = (path, value, mask=None))]
    fn write(&self, py: Python<'_>, path: &str, value: &Bound<'_, PyAny>, mask: Option<Mask<'_>>) -> PyResult<()> {
        let given = Given::of(value, self.count)?;
        let machines = self.masked(mask.as_ref())?;
        let mut inner = self.lock(py);
        let names_array = path.parse().is_ok_and(|path| values::is_array(&inner.tried, &path));
        if names_array && given.is_column() {
            let text = format!("{path} is an array: expected a row for each machine");
            return Err(errors::raise(py, "TagValueError", (text,)));
        }
        // A value for all is tried once.
        let different = if matches!(given, Given::All(_)) {
            1
        } else {
            machines.len()
        };
        for index in machines.iter().take(different) {
            values::try_write(py, &mut inner.tried, path, &given.at(*index))?;
        }
        for index in machines {
            values::write(
                py,
                &mut inner.members[index].runner.simulation(),
                path,
                &given.at(index),
            )?;
        }
        Ok(())
    }

    /// The value of a tag of one machine.
    fn read(&self, py: Python<'_>, index: usize, path: &str) -> PyResult<Py<PyAny>> {
        let inner = self.lock(py);
        let member = inner.members.get(index);
        let member =
            member.ok_or_else(|| PyIndexError::new_err(format!("{index}: there are {} machines", self.count)))?;
        values::read(py, &mut member.runner.simulation(), path)
    }

    /// Starts a program on every machine, or on those whose element of `mask` is true.
    #[pyo3(signature = (text, *, keep_going=false, mask=None))]
    fn program(&self, py: Python<'_>, text: &str, keep_going: bool, mask: Option<Mask<'_>>) -> PyResult<()> {
        let mut inner = self.lock(py);
        let program = parsed(py, inner.members[0].runner.simulation().image(), text)?;
        for index in self.masked(mask.as_ref())? {
            let Member { runner, programs } = &mut inner.members[index];
            programs.push(runner.start(Interpreter::new(program.clone()), policy(true, keep_going)));
        }
        Ok(())
    }

    /// The exception of each machine: that of the first of its programs since its beginning that failed, as `Program.error` has it; None: none did.
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let inner = self.lock(py);
        let errors = inner.members.iter().map(|Member { runner, programs }| {
            let error = programs.iter().find_map(|id| errors::of_program(py, runner, *id));
            error.map(|error| error.into_value(py))
        });
        PyList::new(py, errors.collect::<Vec<_>>())
    }

    /// For each machine, whether all its programs have ended. Motion that they began may go on.
    #[getter]
    fn done<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let inner = self.lock(py);
        let done = inner.members.iter().map(|Member { runner, programs }| {
            let mut running = programs.iter().filter(|id| runner.runs(**id));
            running.next().is_none()
        });
        PyArray1::from_vec(py, done.collect())
    }

    /// Lets `ticks` ticks pass on every machine; with 0 ticks the bound arrays are refreshed and no more.
    #[pyo3(signature = (ticks=1))]
    fn step(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut left = ticks;
        let mut pace = Pace::new(FIRST_SLICE / self.count as u64);
        loop {
            let slice = left.min(pace.ticks());
            self.pass(py, slice)?;
            left -= slice;
            py.check_signals()?;
            if left == 0 {
                return Ok(());
            }
            pace.next();
        }
    }

    /// Brings machines back to their beginning: those whose element of `mask` is true, or all.
    #[pyo3(signature = (mask=None))]
    fn reset(&self, py: Python<'_>, mask: Option<Mask<'_>>) -> PyResult<()> {
        let mut inner = self.lock(py);
        let Inner { project, members, .. } = &mut *inner;
        for index in self.masked(mask.as_ref())? {
            members[index] = Member::new(py, project)?;
        }
        Ok(())
    }
}

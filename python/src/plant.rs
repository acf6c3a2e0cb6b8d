//! A plant in Python behind the drives: a callable that gets the set-points of axes and gives their feedback, once in a tick.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::ThreadId;

use arcline_controller::drive::SetPoint;
use arcline_controller::drive::simulated::{MechanicalModel, ModelFailed, ModelledAxis};
use arcline_controller::machine::Machine as MachineConfig;
use arcline_instruction_set::AxisId;
use numpy::{PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyException, PyTypeError, PyValueError};
use pyo3::prelude::*;

use crate::errors::raise;

/// Rows of the array of set-points: position, velocity, acceleration, enable, time.
const SENT: usize = 5;
/// Rows of the array of feedback: position, velocity, acceleration, fault.
const ANSWERED: usize = 4;

/// The state that a machine and its plant share.
#[derive(Clone, Default)]
pub(crate) struct Shared(Arc<Mutex<State>>);

#[derive(Default)]
struct State {
    /// The exception of the plant, until it is raised.
    error: Option<PyErr>,
    /// The thread in which the plant is at work.
    inside: Option<ThreadId>,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the exception of the plant, which is raised once.
    pub(crate) fn take_error(&self) -> Option<PyErr> {
        self.state().error.take()
    }

    /// Whether the plant has failed with an exception that is not raised yet.
    pub(crate) fn has_failed(&self) -> bool {
        self.state().error.is_some()
    }

    /// Whether the call comes from the plant itself.
    pub(crate) fn is_inside(&self) -> bool {
        self.state().inside == Some(std::thread::current().id())
    }
}

/// A callable with the arrays that it gets.
pub(crate) struct Plant {
    call: Py<PyAny>,
    set_points: Py<PyAny>,
    feedback: Py<PyAny>,
    sent: Py<PyArray2<f64>>,
    answered: Py<PyArray2<f64>>,
    axes: Vec<AxisId>,
    names: Vec<String>,
    ticks: u64,
    period_ns: u64,
    /// The feedback of the last tick, in the order of the axes; empty before the first.
    last: Vec<ModelledAxis>,
    shared: Shared,
}

impl fmt::Debug for Plant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Plant")
            .field("axes", &self.names)
            .finish_non_exhaustive()
    }
}

impl Plant {
    /// The plant of a machine that moves the axes of these names; `None`: all that have a drive.
    pub(crate) fn new(
        py: Python<'_>,
        call: Bound<'_, PyAny>,
        names: Option<Vec<String>>,
        machine: &MachineConfig,
    ) -> PyResult<Self> {
        if !call.is_callable() {
            return Err(PyTypeError::new_err(format!(
                "plant is a {}, expected a callable of (set_points, feedback)",
                call.get_type()
            )));
        }
        let driven = || (0..).zip(&machine.axes).filter(|(_, axis)| !axis.is_virtual());
        let axes = match &names {
            None => driven().map(|(index, _)| AxisId(index)).collect(),
            Some(names) => names
                .iter()
                .map(|name| axis(py, name, driven()))
                .collect::<PyResult<Vec<_>>>()?,
        };
        let names: Vec<String> = axes
            .iter()
            .map(|axis| machine.axes[usize::from(*axis)].name.clone())
            .collect();
        let sent = PyArray2::zeros(py, [SENT, axes.len()], false);
        let answered = PyArray2::zeros(py, [ANSWERED, axes.len()], false);
        let module = py.import("arcline.plant")?;
        let set_points = module
            .getattr("SetPoints")?
            .call1((names.clone(), machine.period(), &sent))?;
        let feedback = module.getattr("Feedback")?.call1((names.clone(), &answered))?;
        Ok(Plant {
            call: call.unbind(),
            set_points: set_points.unbind(),
            feedback: feedback.unbind(),
            sent: sent.unbind(),
            answered: answered.unbind(),
            axes,
            names,
            ticks: 0,
            period_ns: machine.period_ns,
            last: Vec::new(),
            shared: Shared::default(),
        })
    }

    pub(crate) fn axes(&self) -> Vec<AxisId> {
        self.axes.clone()
    }

    pub(crate) fn shared(&self) -> Shared {
        self.shared.clone()
    }

    fn call(&self, py: Python<'_>, set_points: &[SetPoint], answers: &mut [ModelledAxis]) -> PyResult<()> {
        let width = self.axes.len();
        let gone = || PyValueError::new_err("the arrays of a plant must stay contiguous");
        {
            let (mut sent, mut answered) = (
                self.sent.bind(py).try_readwrite()?,
                self.answered.bind(py).try_readwrite()?,
            );
            let sent = sent.as_slice_mut().map_err(|_| gone())?;
            let answered = answered.as_slice_mut().map_err(|_| gone())?;
            let time = (self.ticks as f64 * self.period_ns as f64) / 1e9;
            for (column, axis) in self.axes.iter().enumerate() {
                let index = usize::from(*axis);
                let point = &set_points[index];
                let enable = f64::from(u8::from(point.enable));
                let values = [point.position, point.velocity, point.acceleration, enable, time];
                for (row, value) in values.into_iter().enumerate() {
                    sent[row * width + column] = value;
                }
                let values = [answers[index].position, f64::NAN, f64::NAN, 0.0];
                for (row, value) in values.into_iter().enumerate() {
                    answered[row * width + column] = value;
                }
            }
        }
        self.call.call1(py, (&self.set_points, &self.feedback))?;
        let answered = self.answered.bind(py).try_readonly()?;
        let answered = answered.as_slice().map_err(|_| gone())?;
        for (column, axis) in self.axes.iter().enumerate() {
            let [position, velocity, acceleration, fault] = [0, 1, 2, 3].map(|row| answered[row * width + column]);
            for (value, what) in [
                (position, "position"),
                (velocity, "velocity"),
                (acceleration, "acceleration"),
            ] {
                if value.is_infinite() || (what == "position" && value.is_nan()) {
                    let name = &self.names[column];
                    return Err(PyValueError::new_err(format!(
                        "the plant says that the {what} of {name} is {value}"
                    )));
                }
            }
            answers[usize::from(*axis)] = ModelledAxis {
                position,
                velocity: Some(velocity).filter(|value| !value.is_nan()),
                acceleration: Some(acceleration).filter(|value| !value.is_nan()),
                fault: fault != 0.0,
            };
        }
        Ok(())
    }
}

impl MechanicalModel for Plant {
    fn tick(&mut self, set_points: &[SetPoint], axes: &mut [ModelledAxis]) -> Result<(), ModelFailed> {
        self.shared.state().inside = Some(std::thread::current().id());
        let called = Python::attach(|py| {
            let called = self.call(py, set_points, axes);
            called.map_err(|error| (error.is_instance_of::<PyException>(py), error))
        });
        self.ticks += 1;
        let mut state = self.shared.state();
        state.inside = None;
        match called {
            Ok(()) => {
                self.last.clear();
                self.last.extend(self.axes.iter().map(|axis| axes[usize::from(*axis)]));
            }
            Err((is_failure, error)) => {
                state.error = Some(error);
                if is_failure {
                    return Err(ModelFailed);
                }
                // Ctrl-C, say, which came while the plant was at work: its axes stay where they were.
                for (axis, last) in self.axes.iter().zip(&self.last) {
                    axes[usize::from(*axis)] = *last;
                }
            }
        }
        Ok(())
    }
}

fn axis<'m>(
    py: Python<'_>,
    name: &str,
    mut driven: impl Iterator<Item = (u16, &'m arcline_controller::machine::Axis)> + Clone,
) -> PyResult<AxisId> {
    let known: Vec<&str> = driven.clone().map(|(_, axis)| axis.name.as_str()).collect();
    let found = driven.find(|(_, axis)| axis.name.eq_ignore_ascii_case(name));
    found.map(|(index, _)| AxisId(index)).ok_or_else(|| {
        let known = known.join(", ");
        raise(
            py,
            "TagError",
            (format!("there is no axis {name:?} with a drive, only {known}"),),
        )
    })
}

//! `Fair`: a lock that a thread which takes it again and again shares with waiting threads.

use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use pyo3::sync::MutexExt;

/// A value behind a lock. A waiting thread holds the turn, so that a thread that lets time pass slice by slice, and takes the lock again at once,
/// waits behind it.
pub(crate) struct Fair<T> {
    turn: Mutex<()>,
    value: Mutex<T>,
}

impl<T: Send> Fair<T> {
    pub(crate) fn new(value: T) -> Self {
        Fair {
            turn: Mutex::new(()),
            value: Mutex::new(value),
        }
    }

    /// Waits with the interpreter released: who holds the lock may need it.
    pub(crate) fn lock(&self, py: Python<'_>) -> MutexGuard<'_, T> {
        let _turn = self.turn.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
        self.value.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }

    /// Works on the value with the interpreter released.
    pub(crate) fn detached<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut T) -> R + Send) -> R {
        py.detach(|| self.free(work))
    }

    /// Works on the value, on a thread that does not have the interpreter.
    pub(crate) fn free<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        let mut value = self.value.lock().unwrap_or_else(PoisonError::into_inner);
        drop(turn);
        work(&mut value)
    }
}

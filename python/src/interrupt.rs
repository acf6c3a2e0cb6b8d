//! Ctrl-C while time passes: [`Pace`] says how many ticks pass between two checks for signals of Python, [`watched`] checks for them while another
//! thread works.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Wall time between two checks for signals of Python.
const LOOK: Duration = Duration::from_millis(10);
/// How much longer than the last slice the next one is at most.
const GROWTH: f64 = 8.0;

/// The length of slices of ticks, each of which takes about [`LOOK`].
pub(crate) struct Pace {
    ticks: u64,
    began: Instant,
}

impl Pace {
    /// The first slice is of `ticks`; it begins now.
    pub(crate) fn new(ticks: u64) -> Self {
        Pace {
            ticks: ticks.max(1),
            began: Instant::now(),
        }
    }

    /// Ticks of the present slice.
    pub(crate) fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The slice has passed, and the next one begins.
    pub(crate) fn next(&mut self) {
        let now = Instant::now();
        let took = (now - self.began).as_secs_f64();
        self.began = now;
        let factor = (LOOK.as_secs_f64() / took.max(f64::MIN_POSITIVE)).min(GROWTH);
        self.ticks = ((self.ticks as f64 * factor) as u64).max(1);
    }
}

/// Works on a new thread, with the interpreter released. Ctrl-C sets `over`, for work that looks at it, and is raised when the work has ended.
pub(crate) fn watched<R: Send>(
    py: Python<'_>,
    thread: thread::Builder,
    over: &AtomicBool,
    work: impl FnOnce() -> R + Send,
) -> PyResult<R> {
    let ended = py.detach(|| {
        thread::scope(|scope| {
            let (done, ended) = mpsc::channel::<()>();
            let thread = thread.spawn_scoped(scope, move || {
                // Dropped at the end of the work, which ends the wait.
                let _done = done;
                work()
            })?;
            let mut interrupted = Ok(());
            while let Err(mpsc::RecvTimeoutError::Timeout) = ended.recv_timeout(LOOK) {
                if interrupted.is_ok() {
                    interrupted = Python::attach(|py| py.check_signals());
                    over.store(interrupted.is_err(), Ordering::Relaxed);
                }
            }
            Ok::<_, std::io::Error>((thread.join(), interrupted))
        })
    });
    let (result, interrupted) = ended?;
    interrupted?;
    result.map_err(|_| PyRuntimeError::new_err("the work ended unexpectedly"))
}

//! `simulate_many`: a batch of cases, as `arcline-server simulate --cases` runs them.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use arcline_cases::{Batch, BatchError, Defaults};
use arcline_tag::WriteValue;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;

use crate::inner::policy;
use crate::interrupt::watched;
use crate::values;

/// Runs the cases of a text, one a line; their results, one a line.
#[pyfunction]
#[pyo3(name = "_simulate_many", signature = (cases, program, config, set, seed, until, wait, keep_going, first, threads, trace, signals))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn simulate_many(
    py: Python<'_>,
    cases: &str,
    program: Option<String>,
    config: Option<String>,
    set: Vec<(String, Bound<'_, PyAny>)>,
    seed: u64,
    until: f64,
    wait: bool,
    keep_going: bool,
    first: u64,
    threads: usize,
    trace: Option<String>,
    signals: Vec<String>,
) -> PyResult<String> {
    let set: PyResult<Vec<(String, WriteValue)>> = set
        .into_iter()
        .map(|(name, value)| Ok((name, values::given(&value)?)))
        .collect();
    let over = Arc::new(AtomicBool::new(false));
    let batch = Batch {
        defaults: Arc::new(Defaults {
            program,
            config,
            set: set?,
            seed,
            until,
            policy: policy(wait, keep_going),
            trace,
            signals,
            every: 1,
        }),
        first,
        from: first,
        to: None,
        jobs: threads,
        over: over.clone(),
        behind: None,
    };
    let mut output = Vec::new();
    let thread = std::thread::Builder::new().name("cases".to_owned());
    let ran = watched(py, thread, &over, || {
        batch.run(cases.as_bytes(), &mut output, &mut |_| true)
    })?;
    ran.map_err(|error| match error {
        BatchError::Read(_) | BatchError::Write(_) => PyOSError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    })?;
    String::from_utf8(output).map_err(|error| PyValueError::new_err(error.to_string()))
}

//! Arrays of NumPy for traces: a row for each tick, a column for each signal.

use numpy::{PyArray2, PyReadwriteArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The array of the caller, which must have this shape, or a new one.
pub(crate) fn array<'py>(
    py: Python<'py>,
    steps: usize,
    signals: usize,
    out: Option<Bound<'py, PyArray2<f64>>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let array = match out {
        Some(out) => out,
        // NumPy raises MemoryError for an array that is too large; `PyArray2::zeros` panics.
        None => {
            let zeros = py.import("numpy")?.getattr("zeros")?;
            zeros.call1(((steps, signals),))?.cast_into::<PyArray2<f64>>()?
        }
    };
    match *array.shape() {
        [rows, columns] if (rows, columns) != (steps, signals) => Err(PyValueError::new_err(format!(
            "out is {rows} by {columns}, expected {steps} by {signals}"
        ))),
        _ => Ok(array),
    }
}

/// Its rows as one slice.
pub(crate) fn contiguous<'r>(rows: &'r mut PyReadwriteArray2<'_, f64>) -> PyResult<&'r mut [f64]> {
    rows.as_slice_mut()
        .map_err(|_| PyValueError::new_err("out is not contiguous in C order"))
}

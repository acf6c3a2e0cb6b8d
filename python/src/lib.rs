//! The native half of the Python module `arcline`: machines on the virtual clock ([`machine`]), many at a time ([`batch`]), projects of
//! controllers ([`cell`]), whole programs ([`simulate`]) and many of them ([`cases`]). Python owns every array; Rust writes into it while the
//! interpreter is released.

mod batch;
mod cases;
mod cell;
mod errors;
mod fair;
mod inner;
mod interrupt;
mod machine;
mod plant;
mod signals;
mod simulate;
mod trace;
mod values;

use pyo3::prelude::*;

/// The native half of `arcline`.
#[pymodule]
fn _arcline(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("DEFAULT_CONFIG", arcline_config::DEFAULT)?;
    module.add_class::<machine::Machine>()?;
    module.add_class::<batch::Batch>()?;
    module.add_class::<cell::Cell>()?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate_project, module)?)?;
    module.add_function(wrap_pyfunction!(cases::simulate_many, module)?)?;
    Ok(())
}

//! Errors as Python exceptions: the classes are those of `arcline.errors`.

use arcline_config::Project;
use arcline_controller::image::{Image, ReadError};
use arcline_simulation::{End, Erred, ProgramId, Refused, Runner};
use arcline_structured_text::RunError;
use pyo3::call::PyCallArgs;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

/// An exception of `arcline.errors` with these arguments.
pub(crate) fn raise<'py>(py: Python<'py>, class: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let made = || -> PyResult<Bound<'py, PyAny>> { py.import("arcline.errors")?.getattr(class)?.call1(arguments) };
    match made() {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// The exception of an instruction that erred.
pub(crate) fn erred(py: Python<'_>, erred: &Erred) -> PyErr {
    let Erred {
        err,
        exerr,
        mnemonic,
        line,
        tag,
        ..
    } = erred;
    raise(
        py,
        "MotionError",
        (*err, *exerr, erred.text(), mnemonic.name(), *line, tag.as_str()),
    )
}

/// The exception of a program of a runner that failed, so far.
pub(crate) fn of_program(py: Python<'_>, runner: &Runner, program: ProgramId) -> Option<PyErr> {
    runner.end_of(program)?.err().and_then(|end| ended(py, &end))
}

/// The exception of a program that did not come to its end.
pub(crate) fn ended(py: Python<'_>, end: &End) -> Option<PyErr> {
    Some(match end {
        End::Finished | End::Left => return None,
        End::Erred(error) => erred(py, error),
        End::Wrong(wrong) => program(py, &wrong.to_string(), line_of(wrong)),
        End::TooLong(seconds) => raise(
            py,
            "TimeoutError",
            (format!("not at its end after {seconds} s of simulated time"),),
        ),
    })
}

fn line_of(wrong: &RunError<Refused>) -> usize {
    match wrong {
        RunError::Runtime(error) => error.line,
        RunError::Hopeless(error) => error.line,
        RunError::Driver { line, .. } => *line,
    }
}

/// The exception of a program that cannot be read, or cannot go on.
pub(crate) fn program(py: Python<'_>, text: &str, line: usize) -> PyErr {
    raise(py, "ProgramError", (text, line))
}

/// A tag that is not there, with the nearest name that is.
pub(crate) fn no_tag(py: Python<'_>, image: &Image, path: &str, why: &str) -> PyErr {
    let name = path.split(['.', '[']).next().unwrap_or_default();
    no_name(py, image.tags().iter().map(|tag| tag.name.clone()), name, why)
}

/// A name that is not there, with the nearest one of those that are.
pub(crate) fn no_name(py: Python<'_>, names: impl Iterator<Item = String>, name: &str, why: &str) -> PyErr {
    let wanted = name.to_ascii_lowercase();
    let near = names
        .map(|name| (strsim::damerau_levenshtein(&wanted, &name.to_ascii_lowercase()), name))
        .filter(|(distance, _)| (1..=2.max(wanted.len() / 3)).contains(distance))
        .min();
    let hint = near.map_or_else(String::new, |(_, near)| format!("; did you mean {near:?}?"));
    raise(py, "TagError", (format!("{why}{hint}"),))
}

/// The exception for a tag that cannot be read.
pub(crate) fn unread(py: Python<'_>, image: &Image, path: &str, error: &ReadError) -> PyErr {
    match error {
        ReadError::NoSuchTag { .. } => no_tag(py, image, path, &error.to_string()),
        _ => raise(py, "TagError", (format!("{path}: {error}"),)),
    }
}

/// A configuration, from its text, or from a file; `None`: the embedded one. Its text too.
pub(crate) fn project(py: Python<'_>, config: Option<&str>) -> PyResult<(String, Project)> {
    let (text, name) = match config {
        None => (arcline_config::DEFAULT.to_owned(), "the embedded configuration"),
        Some(text) if text.contains('\n') => (text.to_owned(), "config"),
        Some(file) => match std::fs::read_to_string(file) {
            Ok(text) => (text, file),
            Err(error) => {
                return Err(PyOSError::new_err((
                    error.raw_os_error(),
                    error.to_string(),
                    file.to_owned(),
                )));
            }
        },
    };
    match arcline_config::load(&text, name) {
        Ok(project) => Ok((text, project)),
        Err(error) => Err(raise(py, "ConfigError", (error.to_string(),))),
    }
}

//! Values of tags as Python objects, and the other direction.

use arcline_controller::image::Image;
use arcline_simulation::{NotWritten, Simulation};
use arcline_tag::{TagPath, TagValue, Value, WriteValue};
use pyo3::exceptions::PyTypeError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};

use crate::errors::{no_tag, raise, unread};

/// A path of a tag.
pub(crate) fn path(py: Python<'_>, text: &str) -> PyResult<TagPath> {
    let parsed: Result<TagPath, _> = text.parse();
    parsed.map_err(|error| raise(py, "TagError", (format!("{text:?} is no path of a tag: {error}"),)))
}

/// The value at a path, at the present tick.
pub(crate) fn read(py: Python<'_>, simulation: &mut Simulation, text: &str) -> PyResult<Py<PyAny>> {
    let path = path(py, text)?;
    simulation.show();
    simulation.show_control_of(&path);
    let image = simulation.image();
    let (id, place) = image.locate(&path).map_err(|error| unread(py, image, text, &error))?;
    let is_array = is_array(image, &path);
    let bytes = image.bytes(id).get(place.offset..).unwrap_or_default();
    let value = match place.bit {
        Some(bit) => {
            let byte = bytes.get(usize::from(bit / 8)).copied().unwrap_or_default();
            Some(TagValue::Value(Value::Bool(byte >> (bit % 8) & 1 == 1)))
        }
        None if is_array => TagValue::decode_array(&place.data_type, place.elements as usize, bytes),
        None => TagValue::decode(&place.data_type, bytes),
    };
    match value {
        Some(value) => object(py, &value),
        None => Err(no_tag(py, image, text, &format!("{text} has no value"))),
    }
}

/// Whether a path names an array as a whole.
pub(crate) fn is_array(image: &Image, path: &TagPath) -> bool {
    let mut first = path.clone();
    first.0.push(arcline_tag::PathSegment::Element(0));
    image.locate(&first).is_ok_and(|(_, place)| place.bit.is_none())
}

/// A value as an object.
pub(crate) fn object(py: Python<'_>, value: &TagValue) -> PyResult<Py<PyAny>> {
    Ok(match value {
        TagValue::Value(Value::Bool(on)) => PyBool::new(py, *on).to_owned().into_any().unbind(),
        TagValue::Value(Value::Real(number)) => PyFloat::new(py, f64::from(*number)).into_any().unbind(),
        TagValue::Value(Value::Lreal(number)) => PyFloat::new(py, *number).into_any().unbind(),
        TagValue::Value(Value::Lint(number)) => number.into_pyobject(py)?.into_any().unbind(),
        TagValue::Value(Value::Ulint(number) | Value::Lword(number)) => number.into_pyobject(py)?.into_any().unbind(),
        TagValue::Value(number) => (number.as_f64() as i64).into_pyobject(py)?.into_any().unbind(),
        TagValue::Text(text) => PyString::new(py, text).into_any().unbind(),
        TagValue::Array(elements) => {
            let list = PyList::empty(py);
            for element in elements {
                list.append(object(py, element)?)?;
            }
            list.into_any().unbind()
        }
        TagValue::Structure(structure) => {
            let members = PyDict::new(py);
            for (name, member) in &structure.members {
                members.set_item(name, object(py, member)?)?;
            }
            members.into_any().unbind()
        }
    })
}

/// The value of Python to write to a tag.
pub(crate) fn given(value: &Bound<'_, PyAny>) -> PyResult<WriteValue> {
    if let Ok(on) = value.cast::<PyBool>() {
        return Ok(WriteValue::Bool(on.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(WriteValue::Integer(value.extract::<i128>()?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(WriteValue::Text(text.to_str()?.to_owned()));
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(WriteValue::Number(number.value()));
    }
    // A truth value of NumPy.
    if let Ok(on) = value.extract::<bool>() {
        return Ok(WriteValue::Bool(on));
    }
    // An integer of NumPy, say, which a 64-bit float would round.
    if let Ok(number) = value.call_method0(intern!(value.py(), "__index__")) {
        return Ok(WriteValue::Integer(number.extract::<i128>()?));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(WriteValue::Number(number));
    }
    let elements = value.try_iter().map_err(|_| {
        PyTypeError::new_err(format!(
            "expected a number, a truth value, a text or a sequence, not {}",
            value.get_type()
        ))
    })?;
    let elements = elements.map(|element| given(&element?)).collect::<PyResult<_>>()?;
    Ok(WriteValue::Array(elements))
}

/// The other direction of [`given`].
pub(crate) fn python(py: Python<'_>, value: &WriteValue) -> PyResult<Py<PyAny>> {
    Ok(match value {
        WriteValue::Bool(on) => PyBool::new(py, *on).to_owned().into_any().unbind(),
        WriteValue::Integer(number) => number.into_pyobject(py)?.into_any().unbind(),
        WriteValue::Number(number) => PyFloat::new(py, *number).into_any().unbind(),
        WriteValue::Text(text) => PyString::new(py, text).into_any().unbind(),
        WriteValue::Array(elements) => {
            let list = PyList::empty(py);
            for element in elements {
                list.append(python(py, element)?)?;
            }
            list.into_any().unbind()
        }
    })
}

/// Writes a value at a path; a write of `EnableIn` executes its instruction at the present tick.
pub(crate) fn write(py: Python<'_>, simulation: &mut Simulation, text: &str, value: &WriteValue) -> PyResult<()> {
    let written = simulation.write_tag(text, value);
    written.map_err(|error| not_written(py, simulation.image(), text, error))
}

/// Writes a value at a path of an image of tags that no machine has: whether a machine with the same tags can take it.
pub(crate) fn try_write(py: Python<'_>, image: &mut Image, text: &str, value: &WriteValue) -> PyResult<()> {
    let tried = arcline_simulation::try_write(image, text, value);
    tried.map_err(|error| not_written(py, image, text, error))
}

fn not_written(py: Python<'_>, image: &Image, text: &str, error: NotWritten) -> PyErr {
    match error {
        NotWritten::Path(..) => raise(py, "TagError", (error.to_string(),)),
        NotWritten::Read(error) => unread(py, image, text, &error),
        NotWritten::Value(why) => raise(py, "TagValueError", (why,)),
    }
}

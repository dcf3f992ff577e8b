//! Values by name, between Python and the engine.

use crate::arrays;
use crate::diagnostics::failure;
use illuminator::formula::{Parameter, ParameterId};
use illuminator::lang::ast::Constant;
use illuminator::lang::types::Type;
use illuminator::texture;
use illuminator::workspace::assignment::{AssignmentTarget, WrittenValue};
use illuminator::workspace::{NamedAssignment, OwnerId, ParameterTable};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyBytes, PyString};

/// A value by name. The value is a number, a truth, three numbers, or a text as `--set` takes it.
pub(crate) fn assignment(name: &str, value: &Bound<'_, PyAny>) -> PyResult<NamedAssignment> {
    let text = if let Ok(text) = value.cast::<PyString>() {
        text.to_string()
    } else if let Ok(truth) = value.cast::<PyBool>() {
        u8::from(truth.is_true()).to_string()
    } else if value.is_instance_of::<PyBytes>() || value.is_instance_of::<PyByteArray>() {
        return Err(failure(format!("`{name}` cannot be bytes; a value is a number, three numbers, or a text")));
    } else if let Ok(number) = value.extract::<f64>() {
        // Large and small numbers with an exponent.
        if number != 0.0 && !(1e-5..1e15).contains(&number.abs()) { format!("{number:e}") } else { number.to_string() }
    } else if let Ok([x, y, z]) = value.extract::<[f64; 3]>() {
        format!("<{x}, {y}, {z}>")
    } else {
        let message = format!("`{name}` cannot be {}; a value is a number, three numbers, or a text", value.repr()?);
        return Err(failure(message));
    };
    if name.contains('=') {
        return Err(failure(format!("`{name}` has a `=`; give the name alone, and the value beside it")));
    }
    format!("{name}={text}").parse().map_err(failure)
}

/// The owner and the parameter of this name, for instance `ball.kd`.
pub(crate) fn find(table: &ParameterTable, name: &str) -> PyResult<(OwnerId, ParameterId)> {
    let (owner, parameter) = match name.split_once('.') {
        Some((owner, parameter)) => (Some(owner.trim()), parameter.trim()),
        None => (None, name.trim()),
    };
    let found_owner = match owner {
        None => Some(OwnerId::Global),
        Some(owner) => table.owners().named(owner),
    };
    let id = table.parameter_named(parameter);
    if let (Some(owner), Some(id)) = (found_owner, id)
        && table.parameter(id).owner == owner.kind()
    {
        return Ok((owner, id));
    }
    // The same messages as for setting a value.
    let target = match owner {
        None => AssignmentTarget::Scene,
        Some("*") => return Err(failure(format!("`{name}` is a value of several bodies or lights; name one of them"))),
        Some(owner) => AssignmentTarget::Named(owner.to_owned()),
    };
    let value = WrittenValue::Constant(Constant::Scalar(0.0));
    let probe = NamedAssignment { target, parameter: parameter.to_owned(), value };
    match probe.resolve(table) {
        Err(error) => Err(failure(error)),
        Ok(_) => Err(failure(format!("there is no value `{name}`"))),
    }
}

/// A value that a slider is moved to, as three numbers.
pub(crate) fn numbers(parameter: &Parameter, value: &Bound<'_, PyAny>) -> PyResult<[f32; 3]> {
    let name = &parameter.name;
    let given = match parameter.ty {
        Type::Vector => value.extract::<[f32; 3]>(),
        Type::Scalar | Type::Truth => value.extract().map(|number: f32| [number; 3]),
        Type::Texture => return Err(failure(format!("`{name}` is a texture, which no slider moves; use `set`"))),
    };
    let wanted = if parameter.ty == Type::Vector { "three numbers" } else { "a number" };
    match given {
        Ok(numbers) if numbers.iter().all(|number| number.is_finite()) => Ok(numbers),
        Ok(_) => Err(failure(format!("`{name}` is moved to {wanted}, which must be finite"))),
        // What the value itself raises stays as it is.
        Err(error) if !error.is_instance_of::<PyTypeError>(value.py()) => Err(error),
        Err(_) => Err(failure(format!("`{name}` is moved to {wanted}"))),
    }
}

/// A parameter's value in Python: a number, a truth for a switch, the name of a choice, an array of three, or the path
/// of an image.
pub(crate) fn named_value(py: Python<'_>, parameter: &Parameter, numbers: &[f32]) -> PyResult<Py<PyAny>> {
    let first = numbers.first().copied().unwrap_or_default();
    if parameter.ty == Type::Texture {
        return Ok(match texture::path_of(first) {
            Some(path) => path.into_pyobject(py)?.into_any().unbind(),
            None => py.None(),
        });
    }
    // The cast saturates.
    if let Some(choice) = parameter.choices.get(first as usize) {
        return Ok(choice.into_pyobject(py)?.into_any().unbind());
    }
    if parameter.switch {
        return Ok(PyBool::new(py, first != 0.0).to_owned().into_any().unbind());
    }
    arrays::value(py, numbers)
}

//! A formula evaluated at many points at once, without a scene.

use crate::arrays;
use crate::diagnostics::failure;
use crate::work::interruptible;
use illuminator::evaluate::at_point::{term_values, variable_at_point};
use illuminator::formula::{Formula, ParameterId, Term, TermId};
use illuminator::lang::ast::Constant;
use illuminator::lang::types::Type;
use illuminator::lang::variables::Variable;
use illuminator::workspace::assignment::parse_value;
use illuminator::workspace::textures;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use rayon::prelude::*;
use std::path::Path;
use std::sync::atomic::Ordering;

/// What a name in a call stands for.
#[derive(Clone, Copy, PartialEq)]
enum Named {
    Variable(Variable),
    Parameter(ParameterId),
}

/// Numbers that were given for a name: those of all points, `components` for each. They are a copy, because other
/// threads of Python may write into the array.
struct GivenNumbers {
    named: Named,
    components: usize,
    numbers: Vec<f32>,
}

/// The value of a formula, or of one of its macros, see [`Formula`](crate::formula::Formula).
pub(crate) fn evaluate<'py>(
    py: Python<'py>,
    formula: &Formula,
    of: Option<&str>,
    given: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let root = root(formula, of)?;
    let numpy = py.import("numpy")?;
    let mut arrays = Vec::new();
    for (name, value) in given.into_iter().flat_map(|given| given.iter()) {
        let (named, components) = lookup(formula, &name.extract::<String>()?)?;
        if value.is_none() {
            return Err(failure(format!("`{name}` is None; leave it out for its default")));
        }
        let value = numbers_of_text(formula, named, value)?;
        let keywords = PyDict::new(py);
        keywords.set_item("dtype", "float32")?;
        let array = numpy.call_method("asarray", (value,), Some(&keywords))?;
        let shape: Vec<usize> = array.getattr("shape")?.extract()?;
        let points = match (components, shape.split_last()) {
            (1, _) => shape.clone(),
            (_, Some((3, points))) => points.to_vec(),
            _ => return Err(failure(format!("`{name}` is a vector; its last axis must be 3, and its shape is {shape:?}"))),
        };
        arrays.push((named, components, array, points));
    }
    let shapes = arrays.iter().map(|(.., points)| PyTuple::new(py, points)).collect::<PyResult<Vec<_>>>()?;
    let shape: Vec<usize> = numpy.call_method1("broadcast_shapes", PyTuple::new(py, shapes)?)?.extract()?;
    let count = shape.iter().product::<usize>();
    let mut inputs = Vec::new();
    for (named, components, array, _) in arrays {
        let mut whole = shape.clone();
        whole.extend((components > 1).then_some(components));
        let array = numpy.call_method1("broadcast_to", (array, PyTuple::new(py, whole)?))?;
        let flat = numpy.call_method1("require", (array, "float32", "CA"))?.call_method1("reshape", (-1,))?;
        let numbers = flat.cast_into::<PyArray1<f32>>().map_err(PyErr::from)?.readonly().as_slice().map_err(failure)?.to_vec();
        inputs.push(GivenNumbers { named, components, numbers });
    }
    let components = formula.ty(root).slots();
    let result = values(py, formula, root, &inputs, count)?;
    let mut whole = shape;
    whole.extend((components > 1).then_some(components));
    arrays::rows(py, result, 1)?.call_method1("reshape", (PyTuple::new(py, whole)?,))
}

/// The term of a macro, or that of the result.
fn root(formula: &Formula, of: Option<&str>) -> PyResult<TermId> {
    let Some(of) = of else { return Ok(formula.result) };
    let found = formula.macros.iter().rev().find(|(name, _)| name == of).map(|(_, root)| *root);
    found.ok_or_else(|| {
        let names: Vec<&str> = formula.macros.iter().map(|(name, _)| name.as_str()).collect();
        failure(match names.is_empty() {
            true => "the formula has no macros".to_owned(),
            false => format!("the formula has no macro `{of}`; its macros are {}", names.join(", ")),
        })
    })
}

/// What a name stands for, and how many numbers each value has.
fn lookup(formula: &Formula, name: &str) -> PyResult<(Named, usize)> {
    if let Some(variable) = Variable::named(name) {
        return Ok((Named::Variable(variable), variable.ty().slots()));
    }
    let id = formula.parameter_named(name).ok_or_else(|| {
        let own = formula.parameters.iter().filter(|parameter| parameter.predefined.is_none());
        let own = own.map(|parameter| parameter.name.as_str()).collect::<Vec<_>>().join(", ");
        failure(format!("`{name}` is no variable, and no parameter of the formula; its own parameters are {own}"))
    })?;
    Ok((Named::Parameter(id), formula.parameter(id).ty.slots()))
}

/// A value with the name of a choice, the path of an image or a colour replaced by its numbers.
fn numbers_of_text<'py>(formula: &Formula, named: Named, value: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let (Named::Parameter(id), Ok(text)) = (named, value.extract::<String>()) else { return Ok(value) };
    let parameter = formula.parameter(id);
    let py = value.py();
    if parameter.ty == Type::Texture {
        let number = textures::load(Path::new(&text)).map_err(|error| failure(error.message()))?;
        return Ok(number.into_pyobject(py)?.into_any());
    }
    if parameter.ty == Type::Vector {
        return match parse_value(&text) {
            Some(Constant::Vector(numbers)) => Ok(numbers.into_pyobject(py)?.into_any()),
            Some(Constant::Scalar(_)) | None => {
                Err(failure(format!("`{}` is \"{text}\"; give three numbers, or a colour `#rrggbb`", parameter.name)))
            }
        };
    }
    let number = parameter.choices.iter().position(|choice| *choice == text).ok_or_else(|| {
        let choices = parameter.choices.join(", ");
        let name = &parameter.name;
        failure(match choices.is_empty() {
            true => format!("`{name}` is a number, not a text"),
            false => format!("`{name}` has no choice \"{text}\"; its choices are {choices}"),
        })
    })?;
    Ok(number.into_pyobject(py)?.into_any())
}

/// The value of a term at all points, one number or three for each.
fn values(py: Python<'_>, formula: &Formula, root: TermId, inputs: &[GivenNumbers], count: usize) -> PyResult<Vec<f32>> {
    let given = |named: Named, point: usize| {
        let GivenNumbers { components, numbers, .. } = inputs.iter().find(|input| input.named == named)?;
        let own = &numbers[point * components..][..*components];
        Some([0, 1, 2].map(|component: usize| own[component.min(components - 1)]))
    };
    let used = formula.terms_of(root);
    let variables: Vec<Variable> = used
        .iter()
        .filter_map(|term| match formula.term(*term) {
            Term::Variable(variable) => Some(*variable),
            Term::Number(_) | Term::Parameter(_) | Term::Material(_) | Term::Apply(..) | Term::ByComponents(..) => None,
        })
        .collect();
    let of_variable = |variable: Variable, point: usize| {
        let value = variable_at_point(variable, &|other| {
            let value = glam::Vec3::from(given(Named::Variable(other), point)?).as_dvec3();
            // Directions need not be of unit length.
            Some(if other.is_direction() { value.try_normalize().unwrap_or(value) } else { value })
        });
        value.map(|value| value.as_vec3().to_array())
    };
    if count > 0
        && let Some(missing) = variables.iter().find(|variable| of_variable(**variable, 0).is_none())
    {
        let wanted =
            if *missing == Variable::ToLight || *missing == Variable::ToViewer { "" } else { ", which follows from L and V" };
        return Err(failure(format!("the formula reads `{}`{wanted}; give directions `L=` and `V=`", missing.name())));
    }
    let slots = formula.ty(root).slots();
    let mut result = vec![0.0; count * slots];
    interruptible(py, |task| {
        result.par_chunks_mut(slots).enumerate().for_each(|(point, result)| {
            if task.cancelled.load(Ordering::Relaxed) {
                return;
            }
            let values = term_values(formula, &|variable| of_variable(variable, point).unwrap_or([f32::NAN; 3]), &|id| {
                given(Named::Parameter(id), point).unwrap_or_else(|| default_of(formula, id))
            });
            result.copy_from_slice(&values[root.0 as usize][..slots]);
        });
    })?;
    Ok(result)
}

/// The default of a parameter. That of a scalar stands three times.
fn default_of(formula: &Formula, id: ParameterId) -> [f32; 3] {
    let parameter = formula.parameter(id);
    match parameter.ty {
        Type::Vector => parameter.default,
        Type::Scalar | Type::Truth | Type::Texture => [parameter.default[0]; 3],
    }
}

//! The arguments of a session in Python, and what is wrong with them.

use crate::diagnostics::failure;
use crate::session::names::assignment;
use crate::session::open::{self, Given};
use crate::texts::location;
use illuminator::lang::ast::Constant;
use illuminator::trace::{MAX_DEPTH, MAX_PASSES, MAX_SIDE};
use illuminator::workspace::assignment::parse_value;
use illuminator::workspace::{FileKind, NamedAssignment};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::collections::HashMap;

/// The arguments as they are given.
pub(super) struct SessionArguments<'py> {
    pub(super) session: Option<Bound<'py, PyAny>>,
    pub(super) formula: Option<Bound<'py, PyAny>>,
    pub(super) scene: Option<Bound<'py, PyAny>>,
    pub(super) size: Option<Bound<'py, PyAny>>,
    pub(super) samples: Option<Bound<'py, PyAny>>,
    pub(super) depth: Option<Bound<'py, PyAny>>,
    pub(super) shadows: Option<Bound<'py, PyAny>>,
    pub(super) ior: Option<Bound<'py, PyAny>>,
    pub(super) background: Option<Bound<'py, PyAny>>,
    pub(super) set: Option<Bound<'py, PyAny>>,
    pub(super) materials: Option<Bound<'py, PyAny>>,
    pub(super) threads: Option<Bound<'py, PyAny>>,
    pub(super) memory: Option<Bound<'py, PyAny>>,
}

/// An argument that has a wrong value.
fn wrong(name: &str, value: &Bound<'_, PyAny>, wanted: &str) -> PyErr {
    let shown = value.repr().map_or_else(|_| "something else".to_owned(), |text| text.to_string());
    failure(format!("`{name}` is {shown}; give {wanted}"))
}

/// The value of an argument, if it is given.
fn read<'py, T>(
    name: &str,
    value: &Option<Bound<'py, PyAny>>,
    wanted: &str,
    read: impl FnOnce(&Bound<'py, PyAny>) -> Option<T>,
) -> PyResult<Option<T>> {
    value.as_ref().map(|value| read(value).ok_or_else(|| wrong(name, value, wanted))).transpose()
}

/// A whole number, also as a float.
fn whole(value: &Bound<'_, PyAny>) -> Option<u64> {
    if let Ok(number) = value.extract::<u64>() {
        return Some(number);
    }
    let number = value.extract::<f64>().ok()?;
    // The cast saturates.
    (number >= 0.0 && number.fract() == 0.0).then_some(number as u64)
}

/// A whole number within a range.
fn within(value: &Bound<'_, PyAny>, most: u32) -> Option<u32> {
    let number = u32::try_from(whole(value)?).ok()?;
    (1..=most).contains(&number).then_some(number)
}

/// A colour: three numbers, or `#rrggbb`.
fn colour(value: &Bound<'_, PyAny>) -> Option<[f32; 3]> {
    match value.cast::<PyString>() {
        Ok(text) => match parse_value(&text.to_string())? {
            Constant::Vector(components) => Some(components),
            Constant::Scalar(_) => None,
        },
        Err(_) => value.extract().ok(),
    }
}

fn values(dictionary: &Bound<'_, PyAny>) -> PyResult<Vec<NamedAssignment>> {
    let given =
        dictionary.cast::<PyDict>().map_err(|_| wrong("set", dictionary, "names with values, as in {\"ball.kd\": 0.3}"))?;
    given.iter().map(|(name, value)| assignment(&name.extract::<String>()?, &value)).collect()
}

impl SessionArguments<'_> {
    /// What they mean.
    pub(super) fn given(&self) -> PyResult<Given> {
        let session = self.session.as_ref().map(|session| location(session, FileKind::Session)).transpose()?;
        let side = format!("width and height in pixels, each 1 to {MAX_SIDE}");
        let size = read("size", &self.size, &side, |value| {
            let sides: [Bound<'_, PyAny>; 2] = value.extract().ok()?;
            Some([within(&sides[0], MAX_SIDE)?, within(&sides[1], MAX_SIDE)?])
        })?;
        let count = |name: &str, value, most: u32| {
            read(name, value, &format!("a whole number from 1 to {most}"), |value| within(value, most))
        };
        let materials = read("materials", &self.materials, "bodies with materials, as in {\"ball\": \"gold\"}", |value| {
            value.extract::<HashMap<String, String>>().ok()
        })?;
        let materials = materials.unwrap_or_default();
        let materials = materials.iter().map(|(body, name)| format!("{body}={name}").parse().map_err(failure));
        Ok(Given {
            session,
            formula: self.formula.as_ref().map(open::formula).transpose()?,
            scene: self.scene.as_ref().map(open::scene).transpose()?,
            size,
            samples: count("samples", &self.samples, MAX_PASSES)?,
            depth: count("depth", &self.depth, MAX_DEPTH)?,
            shadows: read("shadows", &self.shadows, "True or False", |value| value.is_truthy().ok())?,
            ior: read("ior", &self.ior, "a number greater than 0", |value| {
                value.extract::<f64>().ok().filter(|index| (1e-30..=1e30).contains(index))
            })?,
            background: read("background", &self.background, "three numbers, or a colour `#rrggbb`", colour)?,
            set: self.set.as_ref().map_or(Ok(Vec::new()), values)?,
            materials: materials.collect::<PyResult<_>>()?,
            threads: read("threads", &self.threads, "a whole number", whole)?.map(|threads| threads as usize),
            memory: read("memory", &self.memory, "a number of bytes", |value| whole(value).filter(|bytes| *bytes > 0))?,
        })
    }
}

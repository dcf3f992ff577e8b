//! Formulas: their text, their parameters, their value at a point, and their export.

use crate::arrays;
use crate::at_point;
use crate::diagnostics::failure;
use crate::texts;
use illuminator::export::{ExportTarget, export};
use illuminator::formula::{Formula as EngineFormula, Parameter as EngineParameter, Term};
use illuminator::lang::source::Source;
use illuminator::lang::types::Type;
use illuminator::workspace::textures::parse_formula;
use illuminator::workspace::{FileKind, Location};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// A parameter of a formula.
#[pyclass(module = "illuminator", frozen, get_all)]
pub(crate) struct Parameter {
    name: String,
    /// `"global"`, `"body"` or `"light"`.
    owner: &'static str,
    /// `"scalar"`, `"vector"` or `"texture"`.
    r#type: &'static str,
    /// The bounds of the value, or of each component.
    range: Option<(f32, f32)>,
    /// A number, or an array of three.
    default: Py<PyAny>,
    /// The names of its values 0, 1, ….
    choices: Vec<String>,
    /// Whether it is 0 or 1.
    switch: bool,
    /// Whether the author wants a slider for it.
    slider: bool,
    /// Whether every formula has it.
    predefined: bool,
    /// What the author says about it.
    doc: Option<String>,
}

#[pymethods]
impl Parameter {
    fn __repr__(&self) -> String {
        let range = self.range.map(|(low, high)| format!(" in {low}..{high}")).unwrap_or_default();
        format!("<{} parameter {}: {}{range}>", self.owner, self.name, self.r#type)
    }
}

impl Parameter {
    fn new(py: Python<'_>, parameter: &EngineParameter) -> PyResult<Self> {
        Ok(Self {
            name: parameter.name.clone(),
            owner: parameter.owner.adjective(),
            r#type: match parameter.ty {
                Type::Scalar | Type::Truth => "scalar",
                Type::Vector => "vector",
                Type::Texture => "texture",
            },
            range: parameter.range.map(|[low, high]| (low, high)),
            default: match (&parameter.image, parameter.ty) {
                (Some((image, _)), _) => image.into_pyobject(py)?.into_any().unbind(),
                (None, Type::Texture) => py.None(),
                (None, Type::Scalar | Type::Truth | Type::Vector) => {
                    arrays::value(py, &parameter.default[..parameter.ty.slots()])?
                }
            },
            choices: parameter.choices.clone(),
            switch: parameter.switch,
            slider: parameter.slider,
            predefined: parameter.predefined.is_some(),
            doc: parameter.doc.clone(),
        })
    }
}

/// An illumination model.
#[pyclass(module = "illuminator", frozen)]
#[derive(Clone)]
pub(crate) struct Formula {
    pub(crate) location: Location,
    pub(crate) source: Source,
    pub(crate) formula: EngineFormula,
}

#[pymethods]
impl Formula {
    /// Reads a formula: a path, or `preset:NAME`.
    #[new]
    #[pyo3(signature = (location))]
    fn new(location: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::read(location.py(), texts::location(location, FileKind::Formula)?, None)
    }

    /// Parses a text. `name` is what messages call it, and paths in the text start from its folder.
    #[staticmethod]
    #[pyo3(signature = (text, name=PathBuf::from("formula")))]
    fn parse(py: Python<'_>, text: String, name: PathBuf) -> PyResult<Self> {
        Self::read(py, Location::new(name), Some(text))
    }

    /// Where it comes from: a path, `preset:NAME`, or the name of the text.
    #[getter]
    fn name(&self) -> String {
        self.location.to_string()
    }

    /// Its text.
    #[getter]
    fn text(&self) -> &str {
        self.source.text()
    }

    /// Its parameters: the predefined ones first, then in the order of the text.
    #[getter]
    fn parameters(&self, py: Python<'_>) -> PyResult<Vec<Parameter>> {
        self.formula.parameters.iter().map(|parameter| Parameter::new(py, parameter)).collect()
    }

    /// The names of the variables that it reads, such as N and L.
    #[getter]
    fn variables(&self) -> Vec<&'static str> {
        let mut names: Vec<&str> = Vec::new();
        for term in &self.formula.terms {
            if let Term::Variable(variable) = term
                && !names.contains(&variable.name())
            {
                names.push(variable.name());
            }
        }
        names
    }

    /// The names of its macros, in the order of the text.
    #[getter]
    fn macros(&self) -> Vec<&str> {
        self.formula.macros.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// The value of the formula, or of the macro `of`, at points without a scene. Variables and parameters are given by
    /// name: numbers, or arrays that broadcast; those of vectors have a last axis of 3. N is <0, 0, 1> unless given,
    /// and `R`, `H`, `alpha` and others follow from N, L and V. Parameters have their defaults unless given. Returns an
    /// array of the broadcast shape, with a last axis of 3 for a vector.
    #[pyo3(signature = (of=None, **given))]
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        of: Option<&str>,
        given: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        at_point::evaluate(py, &self.formula, of, given)
    }

    /// The formula in another language: `"c"`, `"glsl"`, `"hlsl"`, `"wgsl"` and others, as the command `export` writes
    /// it. `name` is that of the function.
    #[pyo3(signature = (to, *, name=None))]
    fn export(&self, to: &str, name: Option<&str>) -> PyResult<String> {
        let target = ExportTarget::named(to).ok_or_else(|| {
            let names = ExportTarget::all().map(|target| format!("\"{}\"", target.name())).collect::<Vec<_>>().join(", ");
            failure(format!("there is no language \"{to}\"; the languages are {names}"))
        })?;
        let own = match &self.location {
            Location::Preset(name) => name.clone(),
            Location::File(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        };
        export(&self.formula, name.unwrap_or(&own), self.source.name(), target).map_err(failure)
    }

    fn __repr__(&self) -> String {
        format!("<Formula {}>", self.location)
    }

    /// Formulas can be pickled, to go to other processes.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (&str, String))> {
        Ok((py.get_type::<Self>().getattr("parse")?, (self.source.text(), self.name())))
    }
}

impl Formula {
    /// A formula, or the one at a location.
    pub(crate) fn of(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        match given.cast::<Self>() {
            Ok(formula) => Ok(formula.get().clone()),
            Err(_) => Self::read(given.py(), texts::location(given, FileKind::Formula)?, None),
        }
    }

    fn read(py: Python<'_>, location: Location, text: Option<String>) -> PyResult<Self> {
        let (source, formula) = texts::read(py, &location, FileKind::Formula, text, |source| parse_formula(source, &location))?;
        Ok(Self { location, source, formula })
    }
}

//! Errors and warnings of texts, with their places, as exceptions and warnings of Python.

use illuminator::engine::EngineError;
use illuminator::formula::Formula;
use illuminator::lang::diagnostic::{Diagnostic as EngineDiagnostic, Diagnostics, Severity};
use illuminator::lang::source::Source;
use illuminator::scene::Scene;
use illuminator::workspace::project::{Listener, OpenProjectError};
use illuminator::workspace::{FileKind, Library, Session, kind_of};
use pyo3::exceptions::{PyException, PyUserWarning};
use pyo3::prelude::*;
use std::ffi::CString;

pyo3::create_exception!(illuminator, IlluminatorError, PyException, "What cannot be done, with the reason.");
pyo3::create_exception!(
    illuminator,
    TextError,
    IlluminatorError,
    "Errors in a formula, a scene, a session or a library of materials. `diagnostics` lists them with their places; `file`,
`line` and `column` are those of the first."
);
pyo3::create_exception!(
    illuminator,
    IlluminatorWarning,
    PyUserWarning,
    "Something that is accepted and probably not meant: a value outside its range, for instance."
);

/// A marked place in a text. Lines and columns are counted from 1, columns in characters; the end is behind the last
/// character.
#[pyclass(module = "illuminator", frozen, get_all)]
#[derive(Clone)]
pub(crate) struct Place {
    line: usize,
    column: usize,
    end_line: usize,
    end_column: usize,
    text: String,
}

#[pymethods]
impl Place {
    #[new]
    fn new(line: usize, column: usize, end_line: usize, end_column: usize, text: String) -> Self {
        Self { line, column, end_line, end_column, text }
    }

    fn __getnewargs__(&self) -> (usize, usize, usize, usize, &str) {
        (self.line, self.column, self.end_line, self.end_column, &self.text)
    }

    fn __repr__(&self) -> String {
        let Self { line, column, end_line, end_column, text } = self;
        format!("Place({line}:{column}-{end_line}:{end_column}, {text:?})")
    }
}

/// An error or a warning about a text.
#[pyclass(module = "illuminator", frozen, get_all)]
#[derive(Clone)]
pub(crate) struct Diagnostic {
    /// `"error"` or `"warning"`.
    severity: &'static str,
    /// What is wrong, in one sentence.
    message: String,
    /// The name of the text: a path, or what the caller calls it.
    file: String,
    /// Where it is, if it has a place.
    line: Option<usize>,
    column: Option<usize>,
    /// All places with remarks; the first is the main one.
    places: Vec<Place>,
    /// What was expected, or the likely fix.
    help: Vec<String>,
    /// The message with the marked line of the text, as a terminal shows it.
    text: String,
}

#[pymethods]
impl Diagnostic {
    #[new]
    fn made(is_error: bool, message: String, file: String, places: Vec<Py<Place>>, help: Vec<String>, text: String) -> Self {
        let places: Vec<Place> = places.iter().map(|place| place.get().clone()).collect();
        let first = places.first().map(|place| (place.line, place.column));
        Self {
            severity: if is_error { "error" } else { "warning" },
            message,
            file,
            line: first.map(|(line, _)| line),
            column: first.map(|(_, column)| column),
            places,
            help,
            text,
        }
    }

    /// Diagnostics can be pickled, so that errors of other processes arrive.
    fn __getnewargs__(&self) -> (bool, &str, &str, Vec<Place>, Vec<String>, &str) {
        (self.is_error(), &self.message, &self.file, self.places.clone(), self.help.clone(), &self.text)
    }

    fn __str__(&self) -> String {
        self.text.clone()
    }

    fn __repr__(&self) -> String {
        let place = self.line.zip(self.column).map(|(line, column)| format!(":{line}:{column}")).unwrap_or_default();
        format!("<{} {}{place}: {}>", self.severity, self.file, self.message)
    }
}

impl Diagnostic {
    fn new(diagnostic: &EngineDiagnostic, source: &Source) -> Self {
        let places: Vec<Place> = diagnostic
            .labels()
            .iter()
            .map(|label| {
                let mark = source.mark(label.span);
                let [(line, column), (end_line, end_column)] = [mark.start, mark.end].map(|at| source.position(at as u32));
                Place { line, column, end_line, end_column, text: label.text.clone() }
            })
            .collect();
        let text = format!("{:#}", Diagnostics::from(diagnostic.clone()).located(source)).trim_end().to_owned();
        Self {
            severity: match diagnostic.severity() {
                Severity::Warning => "warning",
                Severity::Error => "error",
            },
            message: diagnostic.message().to_owned(),
            file: source.name().to_owned(),
            line: places.first().map(|place| place.line),
            column: places.first().map(|place| place.column),
            places,
            help: diagnostic.hints().to_vec(),
            text,
        }
    }

    /// The same with arguments of Python in place of options of the command line.
    fn in_terms_of_python(mut self) -> Self {
        for text in [&mut self.message, &mut self.text].into_iter().chain(&mut self.help) {
            *text = text.replace("`--memory SIZE` allows", "`memory=` allows").replace("--material ", "materials: ");
        }
        self
    }

    fn is_error(&self) -> bool {
        self.severity == "error"
    }
}

/// Collects what is found while texts are read.
#[derive(Default)]
pub(crate) struct Found {
    list: Vec<Diagnostic>,
}

impl Listener for Found {
    fn diagnostics(&mut self, diagnostics: &Diagnostics, source: &Source) {
        self.list.extend(diagnostics.iter().map(|diagnostic| Diagnostic::new(diagnostic, source)));
    }

    fn message(&mut self, diagnostic: EngineDiagnostic) {
        self.list.push(Diagnostic::new(&diagnostic, &Source::new("", "")));
    }

    /// Which values are kept is what the caller asked for.
    fn remark(&mut self, _: &str) {}
}

impl Found {
    /// The result, with a Python warning for each warning; or an exception with all errors.
    pub(crate) fn settle<T>(self, py: Python<'_>, outcome: Result<T, OpenProjectError>) -> PyResult<T> {
        let Self { mut list } = self;
        let failure = match outcome {
            Ok(value) => {
                list.iter().try_for_each(|found| warn(py, &found.text))?;
                return Ok(value);
            }
            Err(failure) => failure,
        };
        if let OpenProjectError::Input(diagnostic) | OpenProjectError::Request(diagnostic) = failure {
            list.push(Diagnostic::new(&diagnostic, &Source::new("", "")).in_terms_of_python());
        }
        Err(text_error(py, list.into_iter().filter(Diagnostic::is_error).collect()))
    }
}

/// An exception with these errors.
fn text_error(py: Python<'_>, errors: Vec<Diagnostic>) -> PyErr {
    let text = errors.iter().map(|error| error.text.as_str()).collect::<Vec<_>>().join("\n\n");
    let error = TextError::new_err(text);
    let value = error.value(py);
    let first = errors.first().cloned();
    let set = || -> PyResult<()> {
        value.setattr("file", first.as_ref().map(|first| first.file.clone()))?;
        value.setattr("line", first.as_ref().and_then(|first| first.line))?;
        value.setattr("column", first.as_ref().and_then(|first| first.column))?;
        value.setattr("diagnostics", errors)
    };
    match set() {
        Ok(()) => error,
        Err(other) => other,
    }
}

/// An exception without a place.
pub(crate) fn failure(error: impl std::fmt::Display) -> PyErr {
    IlluminatorError::new_err(error.to_string())
}

/// The exception for an error of the engine.
pub(crate) fn engine_failure(error: EngineError) -> PyErr {
    let hint = if error.is_memory() { "; `memory=` allows more" } else { "" };
    IlluminatorError::new_err(format!("{error}{hint}"))
}

/// Gives a warning of Python.
pub(crate) fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<IlluminatorWarning>(), &text, 1)
}

/// How many warnings about values are given one by one.
const MOST_WARNINGS: usize = 5;

/// Gives warnings of Python: the first few, and how many more there are.
pub(crate) fn warn_of_several(py: Python<'_>, texts: &[String]) -> PyResult<()> {
    texts.iter().take(MOST_WARNINGS).try_for_each(|text| warn(py, text))?;
    match texts.len().saturating_sub(MOST_WARNINGS) {
        0 => Ok(()),
        more => warn(py, &format!("{more} more values are not used as given")),
    }
}

/// What is wrong with a text, as a list; empty if nothing is. `kind` is `"formula"`, `"scene"`, `"session"` or
/// `"material"`; without it, the first words of the text tell. Files that the text names are not read.
#[pyfunction]
#[pyo3(signature = (text, *, kind=None, name=None))]
pub(crate) fn check(text: String, kind: Option<&str>, name: Option<String>) -> PyResult<Vec<Diagnostic>> {
    let kind = match kind {
        Some(word) => FileKind::ALL.into_iter().find(|kind| kind.word() == word).ok_or_else(|| {
            let words = FileKind::ALL.map(|kind| format!("\"{}\"", kind.word())).join(", ");
            failure(format!("there is no kind of text \"{word}\"; the kinds are {words}"))
        })?,
        None => kind_of(&text)
            .ok_or_else(|| failure("the text does not tell what it is; give `kind=`, for instance `kind=\"formula\"`"))?,
    };
    let source = Source::new(name.unwrap_or_else(|| kind.word().to_owned()), text);
    fn said<T>(outcome: Result<(T, Diagnostics), Diagnostics>) -> Diagnostics {
        outcome.map_or_else(|errors| errors, |(_, warnings)| warnings)
    }
    let found = match kind {
        FileKind::Formula => said(Formula::parse(&source)),
        FileKind::Scene => said(Scene::parse(&source)),
        FileKind::Session => said(Session::parse(&source)),
        FileKind::Material => said(Library::parse(&source)),
    };
    Ok(found.iter().map(|diagnostic| Diagnostic::new(diagnostic, &source)).collect())
}

//! Formulas and scenes that Python names: by a path, by `preset:NAME`, or by their text.

use crate::diagnostics::{Found, failure};
use illuminator::files::Readable;
use illuminator::lang::diagnostic::Diagnostics;
use illuminator::lang::source::Source;
use illuminator::workspace::project::accept;
use illuminator::workspace::{FileKind, Location, kind_of};
use pyo3::prelude::*;
use std::path::PathBuf;

/// The name of the class for texts of a kind, if there is one.
fn class_of(kind: FileKind) -> Option<&'static str> {
    match kind {
        FileKind::Formula => Some("Formula"),
        FileKind::Scene => Some("Scene"),
        FileKind::Session | FileKind::Material => None,
    }
}

/// The location that Python gives for a text of a kind.
pub(crate) fn location(given: &Bound<'_, PyAny>, kind: FileKind) -> PyResult<Location> {
    let class = class_of(kind);
    let path = given.extract::<PathBuf>().map_err(|_| {
        let shown = given.repr().map_or_else(|_| "that".to_owned(), |text| text.to_string());
        let object = class.map(|class| format!(", or a {class}")).unwrap_or_default();
        failure(format!("{shown} is no {}; give a path, `preset:NAME`{object}", kind.noun()))
    })?;
    // A text in place of a path is an easy mistake.
    match path.to_str().and_then(kind_of) {
        Some(found) => {
            let way = class.map_or_else(|| "write it to a file".to_owned(), |class| format!("use `{class}.parse(text)`"));
            Err(failure(format!("that is the text of a {}; {way}", found.noun())))
        }
        None => Ok(Location::new(path)),
    }
}

/// Reads a text, if Python does not give it, and parses it. Python gets its warnings, and its errors as an exception.
pub(crate) fn read<T>(
    py: Python<'_>,
    location: &Location,
    kind: FileKind,
    text: Option<String>,
    parse: impl FnOnce(&Source) -> Result<(T, Diagnostics), Diagnostics>,
) -> PyResult<(Source, T)> {
    let mut found = Found::default();
    let source = match text {
        Some(text) => Ok(Source::new(location.to_string(), text)),
        None => location.read(kind, Readable::Regular).map_err(Into::into),
    };
    let outcome = source.and_then(|source| Ok((accept(parse(&source), &source, &mut found)?, source)));
    let (parsed, source) = found.settle(py, outcome)?;
    Ok((source, parsed))
}

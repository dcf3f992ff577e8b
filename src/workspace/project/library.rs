//! The material library that a formula names: where it is, and what is wrong with it, marked where the formula names
//! it.

use crate::files::Readable;
use crate::formula::Formula;
use crate::lang::diagnostic::{Diagnostic, Severity};
use crate::lang::display_text::one_line;
use crate::lang::parser::parse;
use crate::lang::source::Source;
use crate::workspace::Location;
use crate::workspace::materials::{LibraryLocation, Materials};
use crate::workspace::project::{Listener, OpenProjectError, Read, Request};
use std::path::Path;

/// Marks a mistake where the formula names its library.
fn at_uses(mistake: Diagnostic, source: &Source, label: &str) -> Diagnostic {
    match parse(source).0.uses {
        Some((_, span)) => mistake.at(span, label),
        None => mistake,
    }
}

/// What is wrong with the material library that a formula names, if it names one. A file need not exist yet. Pipes are
/// not read.
pub fn library_mistake(formula: &Formula, location: &Location, source: &Source, data: Option<&Path>) -> Option<Diagnostic> {
    let uses = formula.uses.as_deref()?;
    let library = match LibraryLocation::find(Some(uses), Some(location), data) {
        Ok(library) => library,
        Err(reason) => return Some(at_uses(reason, source, "unknown")),
    };
    let is_file_or_folder = |path: &Path| path.metadata().is_ok_and(|found| found.is_file() || found.is_dir());
    if library.file().is_some_and(|path| path.exists() && !is_file_or_folder(path)) {
        return None;
    }
    let name = library.to_string();
    let found = Materials::open(library, Readable::Regular).err()?;
    if found.source.text().is_empty() {
        return found.diagnostics.iter().next().cloned().map(|mistake| at_uses(mistake, source, "named here"));
    }
    let errors = found.diagnostics.iter().filter(|found| found.severity() == Severity::Error).count();
    let number = if errors == 1 { "an error".to_owned() } else { format!("{errors} errors") };
    let mistake = Diagnostic::error(format!("the material library {name} has {number}"));
    let help = format!("`illuminator check {}` shows what is wrong", one_line(found.source.name()));
    Some(at_uses(mistake.help(help), source, "named here"))
}

/// Reads the materials of a formula.
pub(super) fn open_materials(
    read: &Read,
    location: &Location,
    request: &Request,
    listener: &mut dyn Listener,
) -> Result<Materials, OpenProjectError> {
    let (formula, source) = (&read.formula, &read.formula_text);
    let library = LibraryLocation::find(formula.uses.as_deref(), Some(location), request.data.as_deref()).map_err(|reason| {
        if formula.uses.is_none() {
            return OpenProjectError::Request(reason);
        }
        listener.diagnostics(&at_uses(reason, source, "unknown").into(), source);
        OpenProjectError::Reported
    })?;
    match Materials::open(library, request.readable) {
        Ok((materials, found)) => {
            listener.diagnostics(&found.diagnostics, &found.source);
            Ok(materials)
        }
        Err(found) => {
            // A mistake without a text is about the file as a whole.
            match found.diagnostics.iter().next().filter(|_| found.source.text().is_empty()) {
                Some(mistake) => listener.diagnostics(&at_uses(mistake.clone(), source, "named here").into(), source),
                None => listener.diagnostics(&found.diagnostics, &found.source),
            }
            Err(OpenProjectError::Reported)
        }
    }
}

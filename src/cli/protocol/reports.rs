//! Diagnostics in the form of the Language Server Protocol: what the server tells editors, and `check --json` prints.

use crate::cli::protocol::positions::Positions;
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use illuminator::lang::source::Source;
use illuminator::workspace::Location;
use illuminator::workspace::project::Listener;
use lsp_types::{self as lsp, DiagnosticRelatedInformation, DiagnosticSeverity, Uri};
use serde::Serialize;
use std::path::Path;
use std::str::FromStr;

/// The name under which editors show who has found a mistake.
const TOOL: &str = "illuminator";

/// The URI of a file.
pub(in crate::cli) fn file_uri(path: &Path) -> Option<Uri> {
    let path = std::path::absolute(path).ok()?;
    let mut text = String::from("file://");
    for byte in path.as_os_str().as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~".contains(byte) {
            text.push(char::from(*byte));
        } else {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    Uri::from_str(&text).ok()
}

/// The path in the URI of a file, with `%XX` read.
pub(in crate::cli) fn path_in(uri: &Uri) -> String {
    uri.path().as_estr().decode().into_string_lossy().into_owned()
}

/// A diagnostic with its places. Those beside the main one need the URI of the text.
pub(in crate::cli) fn report(
    diagnostic: &Diagnostic,
    source: &Source,
    positions: &Positions,
    uri: Option<&Uri>,
) -> lsp::Diagnostic {
    let range = |span| positions.range(source.mark(span));
    let place = |span| uri.map(|uri| lsp::Location { uri: uri.clone(), range: range(span) });
    let others = diagnostic.labels().iter().skip(1).filter_map(|label| {
        let message = if label.text.is_empty() { "here".to_owned() } else { label.text.clone() };
        place(label.span).map(|location| DiagnosticRelatedInformation { location, message })
    });
    let others: Vec<_> = others.collect();
    let remark = diagnostic.labels().first().map(|label| label.text.as_str()).filter(|text| !text.is_empty());
    lsp::Diagnostic {
        range: diagnostic.span().map_or_else(lsp::Range::default, range),
        severity: Some(match diagnostic.severity() {
            Severity::Error => DiagnosticSeverity::ERROR,
            Severity::Warning => DiagnosticSeverity::WARNING,
        }),
        source: Some(TOOL.to_owned()),
        message: diagnostic.message().to_owned(),
        related_information: (!others.is_empty()).then_some(others),
        data: Some(serde_json::json!({ "remark": remark, "hints": diagnostic.hints() })),
        ..lsp::Diagnostic::default()
    }
}

/// A diagnostic for an editor that shows nothing but its message: with its remark and hints on lines of their own.
pub(in crate::cli) fn full_report(
    diagnostic: &Diagnostic,
    source: &Source,
    positions: &Positions,
    uri: Option<&Uri>,
) -> lsp::Diagnostic {
    let mut found = report(diagnostic, source, positions, uri);
    let remark = diagnostic.labels().first().map(|label| label.text.as_str()).filter(|text| !text.is_empty());
    let hints = diagnostic.hints().iter().map(|hint| format!("help: {hint}"));
    for line in remark.map(str::to_owned).into_iter().chain(hints) {
        found.message.push('\n');
        found.message.push_str(&line);
    }
    found
}

/// A file as `check --json` prints it.
#[derive(Serialize)]
pub(in crate::cli) struct CheckedFile {
    uri: Option<Uri>,
    path: String,
    diagnostics: Vec<lsp::Diagnostic>,
}

/// Collects what is wrong with files.
#[derive(Default)]
pub(in crate::cli) struct CheckedFiles {
    files: Vec<CheckedFile>,
    /// The index of the file that is being checked. Messages without a place belong to it.
    current: usize,
}

impl CheckedFiles {
    /// Begins with a file that was named. A file may be named twice, or have been named by a session before.
    pub(in crate::cli) fn begin(&mut self, location: &Location) {
        self.current = self.file(&location.to_string());
    }

    /// Every file that was checked, in order.
    pub(in crate::cli) fn report(&self) -> &[CheckedFile] {
        &self.files
    }

    /// The index of a file, which is added if it is new.
    fn file(&mut self, name: &str) -> usize {
        let known = self.files.iter().position(|file| file.path == name);
        known.unwrap_or_else(|| {
            let uri = match Location::new(name) {
                Location::File(path) => file_uri(&path),
                Location::Preset(_) => Uri::from_str(name).ok(),
            };
            self.files.push(CheckedFile { uri, path: name.to_owned(), diagnostics: Vec::new() });
            self.files.len() - 1
        })
    }

    fn add(&mut self, index: usize, found: lsp::Diagnostic) {
        let list = &mut self.files[index].diagnostics;
        if !list.contains(&found) {
            list.push(found);
        }
    }
}

impl Listener for CheckedFiles {
    fn diagnostics(&mut self, diagnostics: &Diagnostics, source: &Source) {
        let index = self.file(source.name());
        let (positions, uri) = (Positions::of_file(source.text()), self.files[index].uri.clone());
        diagnostics.iter().for_each(|one| self.add(index, report(one, source, &positions, uri.as_ref())));
    }

    fn message(&mut self, diagnostic: Diagnostic) {
        let source = Source::new("", "");
        self.add(self.current, report(&diagnostic, &source, &Positions::of_file(""), None));
    }

    /// Notes say which values are carried over into another model. Files that are checked carry nothing.
    fn remark(&mut self, _text: &str) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_survive_as_uris() {
        let path = "/tmp/a b/č#?%25.formula";
        let uri = file_uri(Path::new(path)).unwrap();
        assert_eq!(uri.as_str(), "file:///tmp/a%20b/%C4%8D%23%3F%2525.formula");
        assert_eq!(path_in(&uri), path);
    }
}

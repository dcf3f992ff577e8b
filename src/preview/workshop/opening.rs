//! Opens a session in the workshop, and collects everything that is reported.

use crate::files::Readable;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::source::Source;
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::project::{Listener, OpenProjectError, Project, Request, SessionText};
use std::path::Path;

/// An open session, and its warnings.
#[derive(Debug)]
pub struct OpenedSession {
    /// The session.
    pub project: Project,
    /// Warnings about what is not used as given, for the user.
    pub warnings: Vec<String>,
}

/// Collects errors and warnings.
#[derive(Default)]
struct ReportCollector {
    errors: Vec<String>,
    warnings: Vec<String>,
}

impl Listener for ReportCollector {
    fn diagnostics(&mut self, diagnostics: &Diagnostics, source: &Source) {
        if diagnostics.iter().any(|diagnostic| diagnostic.severity() == Severity::Error) {
            self.errors.push(format!("{:#}", diagnostics.located(source)));
        } else {
            self.warnings.extend(diagnostics.iter().map(text));
        }
    }

    fn message(&mut self, diagnostic: Diagnostic) {
        let list = if diagnostic.severity() == Severity::Error { &mut self.errors } else { &mut self.warnings };
        list.push(text(&diagnostic));
    }
}

impl OpenedSession {
    /// Opens a session with its files. `readable` says which types of file the session itself may be. The files that
    /// it names must be regular.
    ///
    /// # Errors
    /// The errors of the files, as lines of text with the places marked.
    pub fn open(location: &Location, readable: Readable) -> Result<OpenedSession, String> {
        let session = Some(SessionText::At(location.clone()));
        Self::open_request(&Request { session, session_readable: readable, ..Request::default() })
    }

    /// Opens a session from its text, in `folder`. `other` has texts to use instead of those of its formula and its
    /// scene.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn from_text(
        source: &Source,
        folder: &Path,
        other: &dyn Fn(FileKind) -> Option<Source>,
    ) -> Result<OpenedSession, String> {
        let session = SessionText::Text(source.clone(), folder.to_owned());
        Self::open_request(&Request { session: Some(session), texts: Some(other), ..Request::default() })
    }

    /// Opens what a request says.
    pub(super) fn open_request(request: &Request) -> Result<OpenedSession, String> {
        let mut collector = ReportCollector::default();
        match Project::open(request, &mut collector) {
            Ok(project) => Ok(OpenedSession { project, warnings: collector.warnings }),
            Err(error) => {
                let mut errors = collector.errors;
                if let OpenProjectError::Input(diagnostic) | OpenProjectError::Request(diagnostic) = error {
                    errors.push(text(&diagnostic));
                }
                Err(errors.join("\n"))
            }
        }
    }
}

/// The text of a diagnostic, without its place.
fn text(diagnostic: &Diagnostic) -> String {
    let hints = diagnostic.hints().iter().map(|hint| format!(" ({hint})"));
    std::iter::once(diagnostic.message().to_owned()).chain(hints).collect()
}

//! Opens a session in the workshop, and collects everything that is reported.

use crate::engine::Task;
use crate::files::Readable;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::source::Source;
use crate::workspace::AssetStore;
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::materials::SourceDiagnostics;
use crate::workspace::project::{Listener, OpenProjectError, PartialProject, Project, Request, SessionMistakes, SessionText};
use std::fmt;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// An open session, and what is to be said about it.
#[derive(Debug)]
pub struct OpenedSession {
    /// The session. Something stands in for a text that cannot be used.
    pub project: Project,
    /// Warnings about what is not used as given, for the user.
    pub warnings: Vec<String>,
    /// What is wrong with its texts.
    pub mistakes: SessionMistakes,
}

/// Why a session was not opened: errors with the texts that they are in.
#[derive(Debug, Clone, PartialEq)]
pub struct OpeningErrors(pub Vec<SourceDiagnostics>);

impl From<Diagnostic> for OpeningErrors {
    /// An error without a place in a text.
    fn from(diagnostic: Diagnostic) -> Self {
        OpeningErrors(vec![SourceDiagnostics { source: Source::new("", ""), diagnostics: diagnostic.into() }])
    }
}

/// The errors as lines of text. Those with a place have the line of the text with a mark.
impl fmt::Display for OpeningErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, found) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            if found.source.name().is_empty() {
                f.write_str(&found.diagnostics.iter().map(text).collect::<Vec<_>>().join("\n"))?;
            } else {
                write!(f, "{found:#}")?;
            }
        }
        Ok(())
    }
}

/// Collects errors and warnings.
#[derive(Default)]
struct ReportCollector {
    errors: Vec<SourceDiagnostics>,
    warnings: Vec<String>,
}

impl ReportCollector {
    fn add_error(&mut self, diagnostic: Diagnostic) {
        self.errors.push(SourceDiagnostics { source: Source::new("", ""), diagnostics: diagnostic.into() });
    }
}

impl Listener for ReportCollector {
    fn diagnostics(&mut self, diagnostics: &Diagnostics, source: &Source) {
        if diagnostics.has_errors() {
            self.errors.push(SourceDiagnostics { source: source.clone(), diagnostics: diagnostics.clone() });
        } else {
            self.warnings.extend(diagnostics.iter().map(text));
        }
    }

    fn message(&mut self, diagnostic: Diagnostic) {
        match diagnostic.severity() {
            Severity::Error => self.add_error(diagnostic),
            Severity::Warning => self.warnings.push(text(&diagnostic)),
        }
    }

    /// The window opens sessions with their own texts, so there is nothing to remark.
    fn remark(&mut self, _: &str) {}
}

impl OpenedSession {
    /// Opens what can be used of a session and its files. `readable` says which types of file the session itself may
    /// be. The files that it names must be regular. `assets` keeps what the
    /// files hold that its scene names.
    ///
    /// # Errors
    /// The session itself cannot be read, or does not say what it is of.
    pub fn open(location: &Location, readable: Readable, assets: &AssetStore) -> Result<OpenedSession, OpeningErrors> {
        let session = Some(SessionText::At(location.clone()));
        Self::open_request(&Request { session, session_readable: readable, assets: Some(assets), ..Request::default() })
    }

    /// Opens a session without the files that its scene names, which are to be read afterwards. Until then an empty
    /// scene stands in for it, a text without errors.
    ///
    /// # Errors
    /// As for [`open`](Self::open).
    pub fn open_before_files(location: &Location, readable: Readable, assets: &AssetStore) -> Result<Self, OpeningErrors> {
        let session = Some(SessionText::At(location.clone()));
        let cancelled = AtomicBool::new(true);
        let task = Some(Task { cancelled: &cancelled, ..Task::UNWATCHED });
        let request = Request { session, session_readable: readable, assets: Some(assets), task, ..Request::default() };
        let mut opened = Self::open_request(&request)?;
        let scenes = opened.mistakes.unusable.iter_mut().filter(|text| text.kind == FileKind::Scene && text.is_read);
        scenes.for_each(|text| text.found.diagnostics = Diagnostics::default());
        Ok(opened)
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
        assets: &AssetStore,
    ) -> Result<OpenedSession, OpeningErrors> {
        let session = SessionText::Text(source.clone(), folder.to_owned());
        Self::open_request(&Request { session: Some(session), texts: Some(other), assets: Some(assets), ..Request::default() })
    }

    /// Opens what a request says.
    pub(super) fn open_request(request: &Request) -> Result<OpenedSession, OpeningErrors> {
        let mut collector = ReportCollector::default();
        match Project::open_in_parts(request, &mut collector) {
            Ok(PartialProject { project, mistakes }) => Ok(OpenedSession { project, warnings: collector.warnings, mistakes }),
            Err(error) => {
                if let OpenProjectError::Input(diagnostic) | OpenProjectError::Request(diagnostic) = error {
                    collector.add_error(diagnostic);
                }
                Err(OpeningErrors(collector.errors))
            }
        }
    }
}

/// The text of a diagnostic, without its place.
fn text(diagnostic: &Diagnostic) -> String {
    let hints = diagnostic.hints().iter().map(|hint| format!(" ({hint})"));
    std::iter::once(diagnostic.message().to_owned()).chain(hints).collect()
}

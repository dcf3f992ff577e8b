//! Opening what can be used of a session whose texts have mistakes. Something else stands in for a formula or a scene
//! that cannot be used, so that the rest can be shown.

use crate::formula::Formula;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::source::Source;
use crate::scene::Scene;
use crate::workspace::materials::SourceDiagnostics;
use crate::workspace::project::{
    Listener, OpenProjectError, OpenSession, Project, Read, Request, SessionText, locations, read_scene, read_text,
    session_source,
};
use crate::workspace::session::{NamedValue, Session};
use crate::workspace::textures::parse_formula;
use crate::workspace::{FileKind, Location};
use crate::world::Assets;

/// Shows the bodies in their colours, by their predefined parameters alone.
const PLAIN_FORMULA: &str = "formula; = IL*Cd*max(0, N.L);";

/// A scene without bodies and lights.
const EMPTY_SCENE: &str = "bodies; lights; camera; position <0, 0, 5>; gaze <0, 0, -1>; up <0, 1, 0>; fov 40;";

/// A formula or a scene that cannot be used.
#[derive(Debug, Clone, PartialEq)]
pub struct UnusableText {
    /// What it is.
    pub kind: FileKind,
    /// Where it is, or should be.
    pub location: Location,
    /// Its errors. If it was not read, there is one, without a text.
    pub found: SourceDiagnostics,
    /// Whether it was read.
    pub is_read: bool,
}

impl UnusableText {
    /// How many errors it has.
    pub fn errors(&self) -> usize {
        self.found.diagnostics.iter().filter(|one| one.severity() == Severity::Error).count()
    }

    /// Whether it is a scene without errors, whose files are not read yet.
    pub fn waits_for_files(&self) -> bool {
        self.is_read && self.kind == FileKind::Scene && self.errors() == 0
    }

    /// The error for somebody who needs the text. Errors with a place in it go to the listener.
    pub(super) fn report(self, listener: &mut dyn Listener) -> OpenProjectError {
        if self.is_read {
            listener.diagnostics(&self.found.diagnostics, &self.found.source);
            return OpenProjectError::Reported;
        }
        self.found.diagnostics.into_iter().next().map_or(OpenProjectError::Reported, OpenProjectError::Input)
    }
}

/// What could be opened of a session.
#[derive(Debug)]
pub struct PartialProject {
    /// The session, with a plain matte formula in place of one that cannot be used, and an empty scene in place of one
    /// that cannot be used.
    pub project: Project,
    /// What is wrong with it.
    pub mistakes: SessionMistakes,
}

/// The mistakes of a session that was opened in parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SessionMistakes {
    /// The formula or the scene that cannot be used, or both.
    pub unusable: Vec<UnusableText>,
    /// The errors in the text of the session itself, if there are any. What they are about has its default.
    pub session_errors: Option<SourceDiagnostics>,
    /// The values of the session that do not fit, because the text that they are of cannot be used.
    pub waiting: Vec<NamedValue>,
}

impl SessionMistakes {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.unusable.is_empty() && self.session_errors.is_none()
    }
}

impl Project {
    /// Opens what can be used of a session. Without mistakes, this is [`open`](Self::open).
    ///
    /// # Errors
    /// The session itself cannot be read, or does not say which formula and which scene it is of; or the request has
    /// errors.
    pub fn open_in_parts(request: &Request, listener: &mut dyn Listener) -> Result<PartialProject, OpenProjectError> {
        let (session, session_errors) = match &request.session {
            Some(text) => {
                let (session, errors) = read_session(text, request, listener)?;
                (Some(session), errors)
            }
            None => (None, None),
        };
        let [formula, scene] = locations(request, session.as_ref())?;
        let mut unusable = Vec::new();
        let formula_read = read_text(request, &formula, FileKind::Formula, &parse_formula, listener);
        let scene_read = read_scene(request, &scene, listener);
        let stands_in = [formula_read.is_err(), scene_read.is_err()];
        let (formula_text, checked) = or_stand_in(formula_read, PLAIN_FORMULA, Formula::parse, &mut unusable)?;
        let empty = |source: &Source| Scene::parse(source).map(|(scene, warnings)| ((scene, Assets::NONE), warnings));
        let (scene_text, (declared, assets)) = or_stand_in(scene_read, EMPTY_SCENE, empty, &mut unusable)?;
        let read = Read { formula_text, formula: checked, scene_text, scene: declared, assets, stands_in };
        let project = Self::assemble(request, read, [formula, scene], session.as_ref(), listener)?;
        let waiting = match &session {
            Some(open) if !unusable.is_empty() => {
                let table = project.values.table();
                open.session.values.iter().filter(|value| value.assignment(table).is_err()).cloned().collect()
            }
            Some(_) | None => Vec::new(),
        };
        Ok(PartialProject { project, mistakes: SessionMistakes { unusable, session_errors, waiting } })
    }
}

/// Reads what can be used of a session.
fn read_session(
    text: &SessionText,
    request: &Request,
    listener: &mut dyn Listener,
) -> Result<(OpenSession, Option<SourceDiagnostics>), OpenProjectError> {
    let (source, folder) = session_source(text, request.session_readable)?;
    let (session, diagnostics) = Session::parse_in_parts(&source);
    let Some(session) = session else {
        listener.diagnostics(&diagnostics, &source);
        return Err(OpenProjectError::Reported);
    };
    let errors = if diagnostics.has_errors() {
        Some(SourceDiagnostics { source: source.clone(), diagnostics })
    } else {
        listener.diagnostics(&diagnostics, &source);
        None
    };
    Ok((OpenSession { session: session.with_paths_from(folder.as_deref()), source }, errors))
}

/// A text and what it was parsed into; or the text as far as it was read, and what stands in for it.
fn or_stand_in<T>(
    read: Result<(Source, T), UnusableText>,
    stand_in: &str,
    parse: impl Fn(&Source) -> Result<(T, Diagnostics), Diagnostics>,
    unusable: &mut Vec<UnusableText>,
) -> Result<(Source, T), OpenProjectError> {
    let text = match read {
        Ok(read) => return Ok(read),
        Err(text) => text,
    };
    // What stands in has no errors.
    let (parsed, _) = parse(&Source::new("stand-in", stand_in))
        .map_err(|_| OpenProjectError::Input(Diagnostic::error(format!("the {} cannot be used", text.kind.noun()))))?;
    let source = text.found.source.clone();
    unusable.push(text);
    Ok((source, parsed))
}

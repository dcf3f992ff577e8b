//! Opening a session: a formula on a scene, with values, materials and a view. The command line and the window both do
//! it here.
//!
//! Everything that is found wrong is passed to a [`Listener`], text by text, as diagnostics with their source. The
//! listener decides how it is shown. `partial` opens what can be used of a session with mistakes.

mod given;
mod library;
mod partial;
mod scene;

use crate::engine::{Subject, Task};
use crate::files::Readable;
use crate::formula::Formula;
use crate::formula::layout::Layout;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::memory_size::MemorySize;
use crate::lang::source::Source;
use crate::scene::Scene;
use crate::trace::{View, ViewError, usable_memory};
use crate::workspace::FileKind;
use crate::workspace::assignment::Assignment;
use crate::workspace::materials::{MaterialAssignment, SourceDiagnostics};
use crate::workspace::session::{MissingTarget, PictureSettings, Session};
use crate::workspace::textures::parse_formula;
use crate::workspace::{AssetStore, Location, kind_of};
use crate::workspace::{NamedAssignment, OwnerId, ParameterTable, ValueWarning, Values};
use crate::world::Assets;
use given::given_values;
pub use library::library_mistake;
use library::open_materials;
pub use partial::{PartialProject, SessionMistakes, UnusableText};
pub use scene::{parse_scene_with_assets, scene_of_session};
use std::path::{Path, PathBuf};

/// Bytes that each parameter value needs while it is read, checked and stored.
const BYTES_PER_NUMBER: u64 = 16;

/// A hint on how material libraries are used.
const LIBRARIES: &str = "a formula names its material library with `#uses FILE;`, and `--material BODY=NAME` takes from it";

/// An open session.
#[derive(Debug)]
pub struct Project {
    /// Where the formula is.
    pub formula_location: Location,
    /// Its text.
    pub formula_text: Source,
    /// Where the scene is.
    pub scene_location: Location,
    /// Its text.
    pub scene_text: Source,
    /// The formula on the scene, as seen by the view of the picture settings.
    pub subject: Subject,
    /// The values of all parameters.
    pub values: Values,
    /// What they were made from.
    given: GivenValues,
    /// Size, depth and the like.
    pub picture: PictureSettings,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// The values that a session and a request give.
#[derive(Debug)]
struct GivenValues {
    /// Those of the session.
    kept: Vec<Assignment>,
    /// Those of the request.
    set: Vec<Assignment>,
    /// Whether the session is for another formula or scene.
    carried_over: bool,
}

impl GivenValues {
    /// The values of all parameters.
    fn values(&self, formula: &Formula, scene: &Scene) -> (Values, Vec<ValueWarning>) {
        let GivenValues { kept, set, carried_over } = self;
        if *carried_over {
            Values::carried_over(formula, scene, kept, set)
        } else {
            Values::new(formula, scene, &[kept.as_slice(), set].concat())
        }
    }
}

/// Where a session comes from.
#[derive(Debug, Clone)]
pub enum SessionText {
    /// A file.
    At(Location),
    /// A text; its paths are relative to this folder.
    Text(Source, PathBuf),
}

/// What to open. Without a session, and with both files, every value is its default.
#[derive(Default)]
pub struct Request<'r> {
    /// The session.
    pub session: Option<SessionText>,
    /// A formula to use instead of the session's.
    pub formula: Option<Location>,
    /// A scene to use instead of the session's.
    pub scene: Option<Location>,
    /// Texts to use instead of those in the files, for instance unsaved ones.
    pub texts: Option<&'r dyn Fn(FileKind) -> Option<Source>>,
    /// The folder for what users save for built-in formulas, if there is one.
    pub data: Option<PathBuf>,
    /// Materials for bodies.
    pub materials: &'r [MaterialAssignment],
    /// Values that override those of the session and of materials.
    pub set: &'r [NamedAssignment],
    /// Changes the picture settings of the session.
    pub picture: Option<&'r dyn Fn(&mut PictureSettings)>,
    /// The colour of rays that hit nothing, linear RGB. The settings override it.
    pub background: Option<[f32; 3]>,
    /// The memory that parameter values may take, in bytes.
    pub memory: Option<u64>,
    /// What was read before of the files that scenes name, and is kept.
    pub assets: Option<&'r AssetStore>,
    /// Who watches the reading of the files that the scene names, and can cancel it.
    pub task: Option<Task<'r>>,
    /// Which files the session may be read from.
    pub session_readable: Readable,
    /// Which files formula, scene and materials may be read from.
    pub readable: Readable,
}

/// Receives what is found while a session is opened.
pub trait Listener {
    /// Diagnostics of a text; there may be none.
    fn diagnostics(&mut self, diagnostics: &Diagnostics, source: &Source);

    /// An error or a warning without a place in a text.
    fn message(&mut self, diagnostic: Diagnostic);

    /// A line that is neither: which values of a session another formula or scene has.
    fn remark(&mut self, text: &str);
}

/// Why a session was not opened.
#[derive(Debug)]
pub enum OpenProjectError {
    /// The listener has received the errors.
    Reported,
    /// The input has an error.
    Input(Diagnostic),
    /// The request has an error: values or materials that do not fit the formula and the scene.
    Request(Diagnostic),
}

impl From<Diagnostic> for OpenProjectError {
    fn from(diagnostic: Diagnostic) -> Self {
        OpenProjectError::Input(diagnostic)
    }
}

/// The view that picture settings mean.
///
/// # Errors
/// A setting is out of range.
pub fn view(picture: &PictureSettings) -> Result<View, ViewError> {
    let [width, height] = picture.size;
    View::new(width, height)?.with_depth(picture.depth)?.with_shadows(picture.shadows).with_default_index(picture.default_index)
}

impl Project {
    /// Opens a session, completely or not at all.
    ///
    /// # Errors
    /// The files or the request have errors.
    pub fn open(request: &Request, listener: &mut dyn Listener) -> Result<Self, OpenProjectError> {
        let session =
            request.session.as_ref().map(|text| OpenSession::read(text, request.session_readable, listener)).transpose()?;
        let [formula, scene] = locations(request, session.as_ref())?;
        let read = Read::both(request, &formula, &scene, listener)?;
        Self::assemble(request, read, [formula, scene], session.as_ref(), listener)
    }

    /// The project of texts that were read.
    fn assemble(
        request: &Request,
        read: Read,
        [formula_location, scene_location]: [Location; 2],
        session: Option<&OpenSession>,
        listener: &mut dyn Listener,
    ) -> Result<Self, OpenProjectError> {
        check_numbers(&read, request.memory)?;
        let materials = match request.materials {
            [] => None,
            _ => Some(open_materials(&read, &formula_location, request, listener)?),
        };
        let mut picture = session.map(|open| open.session.picture).unwrap_or_default();
        if let Some(change) = request.picture {
            change(&mut picture);
        }
        // Values from a session or a request were checked when they were parsed.
        let view = view(&picture).map_err(|error| Diagnostic::error(error.to_string()))?;
        let given = given_values(request, &read, session, materials.as_ref(), listener)?;
        let (values, warnings) = given.values(&read.formula, &read.scene);
        warnings.iter().for_each(|warning| listener.message(Diagnostic::warning(warning.to_string())));
        let session_file = request.session.as_ref().and_then(|text| match text {
            SessionText::At(location) => location.file(),
            SessionText::Text(..) => None,
        });
        let library = materials.as_ref().and_then(|materials| materials.location().file());
        let files = [session_file, formula_location.file(), scene_location.file(), library];
        let files = files.into_iter().flatten().map(Path::to_owned).collect();
        let Read { formula_text, formula, scene_text, scene, assets, .. } = read;
        // They are those of this scene.
        let subject = Subject::new(formula, scene, &assets, view).map_err(|error| Diagnostic::error(error.to_string()))?;
        Ok(Self { formula_location, formula_text, scene_location, scene_text, subject, values, given, picture, files })
    }

    /// The values if the request had also given these, last. There are all warnings of [`Values::new`], also those that
    /// were reported when the session was opened.
    pub fn values_with(&self, further: &[Assignment]) -> (Values, Vec<ValueWarning>) {
        let GivenValues { kept, set, carried_over } = &self.given;
        let set = [set.as_slice(), further].concat();
        let given = GivenValues { kept: kept.clone(), set, carried_over: *carried_over };
        given.values(&self.subject.formula, self.subject.world.scene())
    }

    /// Checks whether the files that a session names have no errors. Returns how many warnings its values gave.
    pub fn check_session(session: &Session, source: &Source, listener: &mut dyn Listener) -> Result<usize, OpenProjectError> {
        let request = Request { readable: Readable::RegularOrPipe, ..Request::default() };
        let read = Read::both(&request, &session.formula, &session.scene, listener)?;
        let open = OpenSession { session: session.clone(), source: source.clone() };
        let table = ParameterTable::new(&read.formula, &read.scene);
        let (given, leftovers) = open.values(&table, &[], [false; 2], listener)?;
        let (_, warnings) = Values::new(&read.formula, &read.scene, &given);
        let count = leftovers + warnings.len();
        warnings.iter().for_each(|warning| listener.message(Diagnostic::warning(warning.to_string())));
        Ok(count)
    }
}

/// Where the formula and the scene of a request are.
fn locations(request: &Request, session: Option<&OpenSession>) -> Result<[Location; 2], OpenProjectError> {
    let location_of = |given: &Option<Location>, own: fn(&Session) -> &Location| {
        given.clone().or_else(|| session.map(|open| own(&open.session).clone()))
    };
    let formula = location_of(&request.formula, |session| &session.formula);
    let scene = location_of(&request.scene, |session| &session.scene);
    match (formula, scene) {
        (Some(formula), Some(scene)) => Ok([formula, scene]),
        _ => Err(OpenProjectError::Request(Diagnostic::error("give a formula and a scene, or a session"))),
    }
}

/// A formula and a scene with their texts.
struct Read {
    formula_text: Source,
    formula: Formula,
    scene_text: Source,
    scene: Scene,
    assets: Assets,
    /// Whether something stands in for the formula, and for the scene, because they have errors.
    stands_in: [bool; 2],
}

impl Read {
    /// Reads the formula and the scene. The errors of both are reported.
    fn both(
        request: &Request,
        formula: &Location,
        scene: &Location,
        listener: &mut dyn Listener,
    ) -> Result<Self, OpenProjectError> {
        let formula = read_text(request, formula, FileKind::Formula, &parse_formula, listener);
        let scene = read_scene(request, scene, listener);
        match (formula, scene) {
            (Ok((formula_text, formula)), Ok((scene_text, (scene, assets)))) => {
                Ok(Self { formula_text, formula, scene_text, scene, assets, stands_in: [false; 2] })
            }
            (formula, scene) => {
                let mut errors: Vec<OpenProjectError> =
                    [formula.err(), scene.err()].into_iter().flatten().map(|text| text.report(listener)).collect();
                let last = errors.pop().unwrap_or(OpenProjectError::Reported);
                for error in errors {
                    if let OpenProjectError::Input(diagnostic) | OpenProjectError::Request(diagnostic) = error {
                        listener.message(diagnostic);
                    }
                }
                Err(last)
            }
        }
    }
}

/// Reads and parses a scene, and reads the files that it names.
fn read_scene(
    request: &Request,
    location: &Location,
    listener: &mut dyn Listener,
) -> Result<(Source, (Scene, Assets)), UnusableText> {
    let own = AssetStore::default();
    let (store, task) = (request.assets.unwrap_or(&own), request.task.unwrap_or(Task::UNWATCHED));
    let memory = request.memory.unwrap_or_else(usable_memory);
    let parse = |source: &Source, location: &Location| parse_scene_with_assets(source, location, store, memory, &task);
    read_text(request, location, FileKind::Scene, &parse, listener)
}

/// What parses a text at a location: the result with the warnings, or all errors.
type Parse<'p, T> = dyn Fn(&Source, &Location) -> Result<(T, Diagnostics), Diagnostics> + 'p;

/// Reads and parses the text of a formula or a scene. Its warnings are reported.
fn read_text<T>(
    request: &Request,
    location: &Location,
    kind: FileKind,
    parse: &Parse<T>,
    listener: &mut dyn Listener,
) -> Result<(Source, T), UnusableText> {
    let unread = |reason: Diagnostic| {
        let found = SourceDiagnostics { diagnostics: reason.into(), source: Source::new("", "") };
        UnusableText { kind, location: location.clone(), found, is_read: false }
    };
    let source = match request.texts.and_then(|texts| texts(kind)) {
        Some(text) => text,
        None => location.read(kind, request.readable).map_err(unread)?,
    };
    let hint = match kind_of(source.text()) {
        Some(FileKind::Session) => Some((FileKind::Session, "give a session without an option in front of it")),
        Some(FileKind::Material) => Some((FileKind::Material, LIBRARIES)),
        Some(FileKind::Formula | FileKind::Scene) | None => None,
    };
    if let Some((found, hint)) = hint.filter(|_| source.name().ends_with(".toml")) {
        let diagnostic = Diagnostic::error(format!("`{location}` looks like a {}, not a {}", found.noun(), kind.noun()));
        return Err(unread(diagnostic.help(hint)));
    }
    match parse(&source, location) {
        Ok((parsed, warnings)) => {
            listener.diagnostics(&warnings, &source);
            Ok((source, parsed))
        }
        Err(diagnostics) => {
            let found = SourceDiagnostics { diagnostics, source };
            Err(UnusableText { kind, location: location.clone(), found, is_read: true })
        }
    }
}

/// Reports the diagnostics of a text, and returns what it was parsed into if there were no errors.
///
/// # Errors
/// There were errors, which the listener has received.
pub fn accept<T>(
    outcome: Result<(T, Diagnostics), Diagnostics>,
    source: &Source,
    listener: &mut dyn Listener,
) -> Result<T, OpenProjectError> {
    match outcome {
        Ok((value, warnings)) => {
            listener.diagnostics(&warnings, source);
            Ok(value)
        }
        Err(errors) => {
            listener.diagnostics(&errors, source);
            Err(OpenProjectError::Reported)
        }
    }
}

/// A session that was read, with its text.
struct OpenSession {
    session: Session,
    source: Source,
}

impl OpenSession {
    /// Reads a session. Its paths become relative to the working directory.
    fn read(text: &SessionText, readable: Readable, listener: &mut dyn Listener) -> Result<Self, OpenProjectError> {
        let (source, folder) = session_source(text, readable)?;
        let session = accept(Session::parse(&source), &source, listener)?;
        Ok(Self { session: session.with_paths_from(folder.as_deref()), source })
    }

    /// The values of the session for owners and parameters that exist, but not those that others override, and the
    /// number of warnings about values that do not fit. There are no warnings about parameters and owners that are
    /// missing because the formula or the scene is `replaced`. An image that cannot be read is an error.
    fn values(
        &self,
        table: &ParameterTable,
        overriding: &[Assignment],
        replaced: [bool; 2],
        listener: &mut dyn Listener,
    ) -> Result<(Vec<Assignment>, usize), OpenProjectError> {
        let (mut assignments, leftovers) = self.session.assignments(table);
        let is_overridden = |owner: Option<OwnerId>, name: &str| {
            let names = |given: &&Assignment| table.parameter(given.parameter).name == name;
            overriding.iter().filter(names).any(|given| Some(given.owner) == owner)
        };
        assignments.retain(|own| !is_overridden(Some(own.owner), &table.parameter(own.parameter).name));
        let mut warnings = Diagnostics::new();
        for leftover in leftovers {
            let [formula_is_other, scene_is_other] = replaced;
            let expected = match leftover.missing {
                MissingTarget::Owner => scene_is_other,
                MissingTarget::Parameter => formula_is_other,
            };
            // What is there and cannot be read is never expected.
            let expected = expected && leftover.warning.severity() == Severity::Warning;
            if !expected && !is_overridden(leftover.owner, &leftover.parameter) {
                warnings.push(leftover.warning);
            }
        }
        listener.diagnostics(&warnings, &self.source);
        if warnings.has_errors() { Err(OpenProjectError::Reported) } else { Ok((assignments, warnings.len())) }
    }
}

/// The text of a session, and the folder for its paths if there is one.
fn session_source(text: &SessionText, readable: Readable) -> Result<(Source, Option<PathBuf>), OpenProjectError> {
    let location = match text {
        SessionText::Text(source, folder) => return Ok((source.clone(), Some(folder.clone()))),
        SessionText::At(location) => location,
    };
    let source = location.read(FileKind::Session, readable)?;
    if let Some(kind) = kind_of(source.text()).filter(|kind| *kind != FileKind::Session) {
        let diagnostic = Diagnostic::error(format!("`{location}` looks like a {}, not a session", kind.noun()));
        return Err(OpenProjectError::Input(match kind {
            FileKind::Material => diagnostic.help(LIBRARIES),
            FileKind::Formula | FileKind::Scene | FileKind::Session => {
                diagnostic.help(format!("give it after `--{}`", kind.noun()))
            }
        }));
    }
    Ok((source, location.file().map(|path| path.parent().unwrap_or(Path::new("")).to_owned())))
}

/// Checks that the values of all parameters fit into the memory.
fn check_numbers(read: &Read, memory: Option<u64>) -> Result<(), OpenProjectError> {
    let numbers = Layout::new(&read.formula, read.scene.bodies.len(), read.scene.lights.len()).len() as u64;
    let (needed, allowed) = (numbers.saturating_mul(BYTES_PER_NUMBER), memory.unwrap_or(u64::MAX));
    if needed <= allowed {
        return Ok(());
    }
    let (needed, allowed) = (MemorySize(needed), MemorySize(allowed));
    let message =
        format!("{numbers} parameter values of all bodies and lights take {needed} of memory, and {allowed} may be used");
    Err(Diagnostic::error(message).help("`--memory SIZE` allows more").into())
}

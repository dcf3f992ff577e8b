//! From options to what the engine works on: session, formula, scene and values, with everything said that is wrong about them.

use crate::cli::options::{Colour, InputOptions};
use crate::cli::report::{Failure, accept, explain, say, warn};
use illuminator::files::Readable;
use illuminator::formula::Formula;
use illuminator::formula::layout::Layout;
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics};
use illuminator::lang::parser::parse;
use illuminator::lang::source::Source;
use illuminator::lang::variables::Predefined;
use illuminator::picture::Transfer;
use illuminator::presets::{DEFAULT_SESSION, Kind};
use illuminator::scene::Scene;
use illuminator::trace::{View, usable_memory};
use illuminator::workspace::files::{Location, kind_of};
use illuminator::workspace::materials::{Place, data_folder};
use illuminator::workspace::session::{Lacking, PictureSettings};
use illuminator::workspace::{Assignment, OwnerId, Roster, Session, Shelf, Values};
use illuminator::world::World;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes that each parameter value takes while it is read, checked and kept.
const BYTES_PER_NUMBER: u64 = 16;

/// How a library of materials is used.
const LIBRARIES: &str = "a formula names its material library with `#uses FILE;`, and `--material BODY=NAME` takes from it";

/// What the engine works on.
pub(super) struct Input {
    /// The text of the formula.
    pub(super) formula_source: Source,
    /// The formula.
    pub(super) formula: Arc<Formula>,
    /// The scene, ready for rays.
    pub(super) world: Arc<World>,
    /// The files that were read.
    pub(super) files: Vec<PathBuf>,
    /// The values of all parameters.
    pub(super) values: Values,
    /// Size, depth and the like.
    pub(super) view: View,
    /// How the session wants colours stored.
    pub(super) transfer: Transfer,
}

/// A session that was read, with its text.
pub(super) struct OpenSession {
    pub(super) session: Session,
    pub(super) source: Source,
}

/// Reads a session; its paths are then relative to the working directory.
pub(super) fn open_session(location: &Location) -> Result<OpenSession, Failure> {
    let source = location.read(Kind::Session, Readable::RegularOrPipe).map_err(Failure::Input)?;
    let other = kind_of(source.text()).filter(|kind| *kind != Kind::Session);
    if let Some(kind) = other {
        let diagnostic = Diagnostic::error(format!("`{location}` looks like a {}, not a session", kind.noun()));
        return Err(Failure::Input(match kind {
            Kind::Material => diagnostic.help(LIBRARIES),
            Kind::Formula | Kind::Scene | Kind::Session => diagnostic.help(format!("give it behind `--{}`", kind.noun())),
        }));
    }
    let mut session = accept(Session::parse(&source), &source)?;
    if let Location::File(path) = location {
        let folder = path.parent().unwrap_or(Path::new(""));
        session.formula = session.formula.from_folder(folder);
        session.scene = session.scene.from_folder(folder);
    }
    Ok(OpenSession { session, source })
}

/// Reads formula and scene; what is wrong with either is said before giving up.
pub(super) fn open_both(formula: &Location, scene: &Location) -> Result<(Source, Formula, Scene), Failure> {
    let formula = open(formula, Kind::Formula, Formula::parse);
    let scene = open(scene, Kind::Scene, Scene::parse);
    match (formula, scene) {
        (Ok((source, formula)), Ok((_, scene))) => Ok((source, formula, scene)),
        (Err(first), Err(second)) => {
            first.report();
            Err(second)
        }
        (Err(failure), Ok(_)) | (Ok(_), Err(failure)) => Err(failure),
    }
}

fn open<T>(
    location: &Location,
    kind: Kind,
    parse: fn(&Source) -> Result<(T, Diagnostics), Diagnostics>,
) -> Result<(Source, T), Failure> {
    let source = location.read(kind, Readable::RegularOrPipe).map_err(Failure::Input)?;
    let hint = match kind_of(source.text()) {
        Some(Kind::Session) => Some((Kind::Session, "give a session without an option in front of it")),
        Some(Kind::Material) => Some((Kind::Material, LIBRARIES)),
        Some(Kind::Formula | Kind::Scene) | None => None,
    };
    if let Some((found, hint)) = hint.filter(|_| source.name().ends_with(".toml")) {
        let diagnostic = Diagnostic::error(format!("`{location}` looks like a {}, not a {}", found.noun(), kind.noun()));
        return Err(Failure::Input(diagnostic.help(hint)));
    }
    let parsed = accept(parse(&source), &source)?;
    Ok((source, parsed))
}

/// Loads everything that the options name.
pub(super) fn load(options: &InputOptions) -> Result<Input, Failure> {
    let given = |text: &Option<std::ffi::OsString>| text.as_ref().map(Location::new);
    let (formula, scene) = (given(&options.formula), given(&options.scene));
    let session = match (&options.session, &formula, &scene) {
        // With both files given and no session, every value is its default.
        (None, Some(_), Some(_)) => None,
        (None, ..) => Some(open_session(&Location::Preset(DEFAULT_SESSION.to_owned()))?),
        (Some(session), ..) => Some(open_session(&Location::new(session))?),
    };
    let replaced = Replaced { formula: formula.is_some(), scene: scene.is_some() };
    let of_session = |part: fn(&Session) -> &Location| session.as_ref().map(|open| part(&open.session).clone());
    let (Some(formula), Some(scene)) =
        (formula.or(of_session(|session| &session.formula)), scene.or(of_session(|session| &session.scene)))
    else {
        // Without a session both were given.
        return Err(Failure::command_line("give a formula and a scene, or a session"));
    };
    let read = [options.session.as_ref().map(Location::new), Some(formula.clone()), Some(scene.clone())];
    let files = read.into_iter().flatten().filter_map(|location| match location {
        Location::File(path) => Some(path),
        Location::Preset(_) => None,
    });
    let formula_location = formula;
    let (formula_source, formula, scene) = open_both(&formula_location, &scene)?;
    let numbers = Layout::new(&formula, scene.bodies.len(), scene.lights.len()).len() as u64;
    if numbers.saturating_mul(BYTES_PER_NUMBER) > options.machine.memory.unwrap_or_else(usable_memory) {
        let message =
            format!("{numbers} parameter values, those of all bodies and lights together, take more memory than may be used");
        return Err(Failure::Input(Diagnostic::error(message).help("`--memory SIZE` allows more")));
    }
    let shelf = match options.materials.as_slice() {
        [] => None,
        _ => Some(open_shelf(&formula, &formula_location, &formula_source)?),
    };
    let library = shelf.as_ref().and_then(|shelf| shelf.place().file()).map(Path::to_owned);
    let files = files.chain(library).collect();
    let picture = picture_settings(options, session.as_ref().map(|open| open.session.picture).unwrap_or_default());
    let view = view(&picture)?;
    let values = values(&formula, &scene, session.as_ref(), replaced, shelf.as_ref(), options)?;
    Ok(Input {
        formula_source,
        formula: Arc::new(formula),
        world: Arc::new(World::new(scene)),
        files,
        values,
        view,
        transfer: picture.transfer(),
    })
}

/// Which of a session's files the command line replaces.
#[derive(Debug, Clone, Copy)]
struct Replaced {
    formula: bool,
    scene: bool,
}

fn values(
    formula: &Formula,
    scene: &Scene,
    session: Option<&OpenSession>,
    replaced: Replaced,
    shelf: Option<&Shelf>,
    options: &InputOptions,
) -> Result<Values, Failure> {
    let roster = Roster::new(formula, scene);
    let mut set = match shelf {
        Some(shelf) => material_values(options, shelf, &roster)?,
        None => Vec::new(),
    };
    set.extend(set_values(options, formula, &roster)?);
    let kept = session.map_or_else(Vec::new, |open| session_values(open, &roster, replaced).0);
    let (values, warnings) = if replaced.formula || replaced.scene {
        let (mut values, mut warnings) = Values::keeping(formula, scene, &kept);
        warnings.extend(values.assign(&set));
        (values, warnings)
    } else {
        Values::new(formula, scene, &[kept, set].concat())
    };
    warnings.iter().for_each(|warning| warn(warning.to_string()));
    Ok(values)
}

/// The values that a session has for a formula on a scene.
/// With them comes how many warnings were given.
pub(super) fn session_values_of(open: &OpenSession, roster: &Roster) -> (Vec<Assignment>, usize) {
    session_values(open, roster, Replaced { formula: false, scene: false })
}

fn session_values(open: &OpenSession, roster: &Roster, replaced: Replaced) -> (Vec<Assignment>, usize) {
    let (assignments, leftovers) = open.session.assignments(roster);
    let mut warnings = Diagnostics::new();
    for leftover in leftovers {
        // Where a file was replaced it is no surprise that some values have no place in the other one.
        let expected = match leftover.lacking {
            Lacking::Owner => replaced.scene,
            Lacking::Parameter => replaced.formula,
        };
        if !expected {
            warnings.push(leftover.warning);
        }
    }
    explain(&warnings, &open.source);
    (assignments, warnings.len())
}

/// Where the materials of a formula are, or why there are none, marked in its text where it names a place.
pub(super) fn place_of(formula: &Formula, location: &Location, source: &Source) -> Result<Place, Diagnostic> {
    Place::of(formula.uses.as_deref(), Some(location), data_folder().as_deref()).map_err(|reason| match parse(source).0.uses {
        Some((_, span)) => reason.at(span, "not known"),
        None => reason,
    })
}

/// Reads the materials of a formula.
fn open_shelf(formula: &Formula, location: &Location, source: &Source) -> Result<Shelf, Failure> {
    let place = place_of(formula, location, source).map_err(|reason| {
        if formula.uses.is_none() {
            return Failure::CommandLine(reason);
        }
        explain(&reason.into(), source);
        Failure::Reported
    })?;
    match Shelf::open(place, Readable::RegularOrPipe) {
        Ok((shelf, found)) => {
            explain(&found.diagnostics, &found.source);
            Ok(shelf)
        }
        Err(found) => {
            explain(&found.diagnostics, &found.source);
            Err(Failure::Reported)
        }
    }
}

/// The values of the materials that the command line gives to bodies.
fn material_values(options: &InputOptions, shelf: &Shelf, roster: &Roster) -> Result<Vec<Assignment>, Failure> {
    let mut assignments = Vec::new();
    let mut failed = FirstToLast::default();
    for choice in &options.materials {
        match choice.resolve(shelf, roster) {
            Ok((given, warnings)) => {
                explain(&warnings, shelf.source_of(&choice.material));
                assignments.extend(given);
            }
            Err(error) => failed.add(format!("--material {choice}: {error}")),
        }
    }
    failed.end(assignments)
}

/// What is wrong with several options: all of it is said, the last as the reason for giving up.
#[derive(Default)]
struct FirstToLast(Option<Diagnostic>);

impl FirstToLast {
    fn add(&mut self, message: String) {
        if let Some(earlier) = self.0.replace(Diagnostic::error(message)) {
            say(&earlier);
        }
    }

    fn end<T>(self, outcome: T) -> Result<T, Failure> {
        self.0.map_or(Ok(outcome), |last| Err(Failure::CommandLine(last)))
    }
}

/// The values that the command line gives.
fn set_values(options: &InputOptions, formula: &Formula, roster: &Roster) -> Result<Vec<Assignment>, Failure> {
    let mut assignments = Vec::new();
    if let Some(Colour(value)) = options.background {
        let parameter = formula.predefined(Predefined::Background);
        assignments.push(Assignment { owner: OwnerId::Global, parameter, value });
    }
    let mut failed = FirstToLast::default();
    for setting in &options.settings {
        match setting.resolve(roster) {
            Ok(resolved) => assignments.extend(resolved),
            Err(error) => failed.add(format!("--set {setting}: {error}")),
        }
    }
    failed.end(assignments)
}

/// A session's settings with what the command line says instead.
fn picture_settings(options: &InputOptions, session: PictureSettings) -> PictureSettings {
    PictureSettings {
        size: options.size.unwrap_or(session.size),
        depth: options.depth.unwrap_or(session.depth),
        shadows: if options.no_shadows { false } else { options.shadows || session.shadows },
        default_index: options.ior.unwrap_or(session.default_index),
        srgb: session.srgb,
    }
}

fn view(picture: &PictureSettings) -> Result<View, Failure> {
    let [width, height] = picture.size;
    View::new(width, height)
        .and_then(|view| view.with_depth(picture.depth))
        .and_then(|view| view.with_default_index(picture.default_index))
        .map(|view| view.with_shadows(picture.shadows))
        // Of the options, each was looked at when it was read.
        .map_err(|error| Failure::input(error.to_string()))
}

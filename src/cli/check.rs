//! `illuminator check`: reports what is wrong with files.

use crate::cli::input::{Speaker, data_folder, read_of_kind};
use crate::cli::progress::Progress;
use crate::cli::protocol::reports::CheckedFiles;
use crate::cli::report::{Failure, count, number, print, print_json};
use clap::{Args, ValueEnum};
use illuminator::engine::Task;
use illuminator::formula::Formula;
use illuminator::lang::diagnostic::Diagnostics;
use illuminator::lang::display_text::one_line;
use illuminator::lang::source::Source;
use illuminator::scene::Scene;
use illuminator::trace::usable_memory;
use illuminator::workspace::project::{Listener, OpenProjectError, Project, library_mistake, parse_scene_with_assets};
use illuminator::workspace::textures::read_defaults;
use illuminator::workspace::{AssetStore, FileKind, Library, Location, Session, presets};
use illuminator::world::Assets;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::Path;

/// Options of `check`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Files to check
    #[arg(required = true, value_name = "FILE")]
    files: Vec<OsString>,
    /// What the files are, if their first words do not tell
    #[arg(long, value_enum)]
    kind: Option<KindName>,
    /// Warn where a macro would give another value if it stood for its text, as in the thesis
    #[arg(long)]
    thesis: bool,
    /// Print what is wrong as JSON, in the form of the Language Server Protocol
    #[arg(long)]
    json: bool,
}

/// The kinds of files.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum KindName {
    Formula,
    Scene,
    Session,
    Material,
}

/// Checks all files, even if the first ones have errors.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let mut wrong = false;
    let mut collected = CheckedFiles::default();
    for file in &options.files {
        let given = options.kind.map(|kind| match kind {
            KindName::Formula => FileKind::Formula,
            KindName::Scene => FileKind::Scene,
            KindName::Session => FileKind::Session,
            KindName::Material => FileKind::Material,
        });
        let location = built_in_if_missing(Location::new(file), given, options.json)?;
        for kind in kinds_of(&location, given) {
            if options.json {
                collected.begin(&location);
                wrong |= check(&location, kind, options.thesis, &mut collected).is_none_or(|checked| !checked.is_valid());
            } else {
                let checked = check(&location, kind, options.thesis, &mut Speaker);
                wrong |= checked.as_ref().is_none_or(|checked| !checked.is_valid());
                checked.map_or(Ok(()), |checked| print(&checked.summary(&location)))?;
            }
        }
    }
    if options.json {
        print_json(&collected.report())?;
    }
    if wrong { Err(Failure::Reported) } else { Ok(()) }
}

/// What was found in a file.
struct CheckOutcome {
    kind: FileKind,
    diagnostics: Diagnostics,
    /// How many warnings the values of a session gave.
    value_warnings: usize,
    /// Whether the files that a session names have no errors.
    files_are_valid: bool,
}

impl CheckOutcome {
    fn of(kind: FileKind, diagnostics: Diagnostics) -> Self {
        Self { kind, diagnostics, value_warnings: 0, files_are_valid: true }
    }

    fn is_valid(&self) -> bool {
        !self.diagnostics.has_errors() && self.files_are_valid
    }

    /// The numbers of errors and warnings, as a line.
    fn summary(&self, location: &Location) -> String {
        let [errors, warnings] = count(&self.diagnostics);
        let [errors_found, warnings_found] = [number(errors, "error"), number(warnings + self.value_warnings, "warning")];
        let named_files = if errors == 0 && !self.files_are_valid { "; a file that it names has errors" } else { "" };
        let name = one_line(&location.to_string());
        format!("{name}: {}, {errors_found}, {warnings_found}{named_files}\n", self.kind.noun())
    }
}

/// The location, or the built-in files of its name if there is no such file.
fn built_in_if_missing(location: Location, given: Option<FileKind>, silent: bool) -> Result<Location, Failure> {
    let Location::File(path) = &location else { return Ok(location) };
    let missing = path.symlink_metadata().is_err_and(|error| error.kind() == ErrorKind::NotFound);
    let is_named = |kind: &FileKind, name: &str| given.is_none_or(|given| given == *kind) && presets::text(*kind, name).is_some();
    let named = path.to_str().filter(|name| missing && FileKind::ALL.iter().any(|kind| is_named(kind, name)));
    let Some(name) = named.map(str::to_owned) else { return Ok(location) };
    let built_in = Location::Preset(name.clone());
    if !silent {
        print(&format!("{name}: there is no such file; the built-in `{built_in}` is checked instead\n"))?;
    }
    Ok(built_in)
}

/// The kinds as which a file is checked. Built-in files of several kinds may have one name: then all are checked.
fn kinds_of(location: &Location, given: Option<FileKind>) -> Vec<Option<FileKind>> {
    let Location::Preset(name) = location else { return vec![given] };
    let named: Vec<Option<FileKind>> =
        FileKind::ALL.into_iter().filter(|kind| presets::text(*kind, name).is_some()).map(Some).collect();
    if given.is_some() || named.is_empty() { vec![given] } else { named }
}

/// Checks one file, and tells the listener. `None` if it cannot be read.
fn check(location: &Location, given: Option<FileKind>, thesis: bool, listener: &mut dyn Listener) -> Option<CheckOutcome> {
    let (kind, source) = match read_of_kind(location, given) {
        Ok(found) => found,
        Err(diagnostic) => {
            listener.message(diagnostic);
            return None;
        }
    };
    Some(match kind {
        FileKind::Formula => CheckOutcome::of(kind, told(check_formula(location, &source, thesis), &source, listener)),
        FileKind::Scene => CheckOutcome::of(kind, told(check_scene(location, &source), &source, listener)),
        FileKind::Session => check_session(location, &source, listener),
        FileKind::Material => CheckOutcome::of(kind, told(check_library(location, &source), &source, listener)),
    })
}

/// Tells the diagnostics of a text and returns them.
fn told<T>(outcome: Result<(T, Diagnostics), Diagnostics>, source: &Source, listener: &mut dyn Listener) -> Diagnostics {
    match outcome {
        Ok((_, diagnostics)) | Err(diagnostics) => {
            listener.diagnostics(&diagnostics, source);
            diagnostics
        }
    }
}

/// Checks a formula, and whether what it names as its material library is one. A file need not exist yet.
fn check_formula(location: &Location, source: &Source, thesis: bool) -> Result<(Formula, Diagnostics), Diagnostics> {
    let parse = if thesis { Formula::parse_as_thesis } else { Formula::parse };
    let (mut formula, mut diagnostics) = parse(source)?;
    read_defaults(&mut formula, location, &mut diagnostics);
    if let Some(mistake) = library_mistake(&formula, location, source, data_folder().as_deref()) {
        diagnostics.push(mistake);
        diagnostics.sort();
    }
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok((formula, diagnostics)) }
}

/// Checks a scene and the files that it names.
fn check_scene(location: &Location, source: &Source) -> Result<((Scene, Assets), Diagnostics), Diagnostics> {
    let progress = Progress::new("reading files");
    let tell = |share: f64| progress.tell(share);
    parse_scene_with_assets(source, location, &AssetStore::default(), usable_memory(), &Task::watched(&tell))
}

/// Checks a material library and its images.
fn check_library(location: &Location, source: &Source) -> Result<(Library, Diagnostics), Diagnostics> {
    let (library, mut diagnostics) = Library::parse(source)?;
    diagnostics.extend(library.unreadable_images(location));
    diagnostics.sort();
    if diagnostics.has_errors() { Err(diagnostics) } else { Ok((library, diagnostics)) }
}

/// What is wrong with a text itself. The files that a session or a scene names are not looked at.
pub(super) fn diagnostics_of(kind: FileKind, location: &Location, source: &Source) -> Diagnostics {
    fn found<T>(outcome: Result<(T, Diagnostics), Diagnostics>) -> Diagnostics {
        outcome.map_or_else(|errors| errors, |(_, warnings)| warnings)
    }
    match kind {
        FileKind::Formula => found(check_formula(location, source, false)),
        FileKind::Scene => found(Scene::parse(source)),
        FileKind::Session => found(Session::parse(source)),
        FileKind::Material => found(check_library(location, source)),
    }
}

/// Checks a session and the files that it names.
fn check_session(location: &Location, source: &Source, listener: &mut dyn Listener) -> CheckOutcome {
    let kind = FileKind::Session;
    let (mut session, diagnostics) = match Session::parse(source) {
        Ok(read) => read,
        Err(diagnostics) => {
            listener.diagnostics(&diagnostics, source);
            return CheckOutcome { files_are_valid: false, ..CheckOutcome::of(kind, diagnostics) };
        }
    };
    if let Location::File(path) = location {
        let folder = path.parent().unwrap_or(Path::new(""));
        session = session.with_paths_from(Some(folder));
    }
    listener.diagnostics(&diagnostics, source);
    match Project::check_session(&session, source, listener) {
        Ok(value_warnings) => CheckOutcome { value_warnings, ..CheckOutcome::of(kind, diagnostics) },
        Err(error) => {
            match error {
                OpenProjectError::Reported => {}
                OpenProjectError::Input(diagnostic) | OpenProjectError::Request(diagnostic) => listener.message(diagnostic),
            }
            CheckOutcome { files_are_valid: false, ..CheckOutcome::of(kind, diagnostics) }
        }
    }
}

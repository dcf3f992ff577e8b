//! `illuminator check`: reports what is wrong with files.

use crate::cli::input::{Speaker, data_folder};
use crate::cli::report::{Failure, count, explain, print, say};
use clap::{Args, ValueEnum};
use illuminator::files::Readable;
use illuminator::formula::Formula;
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics};
use illuminator::lang::display_text::one_line;
use illuminator::lang::source::Source;
use illuminator::scene::Scene;
use illuminator::workspace::project::{Project, library_location};
use illuminator::workspace::{FileKind, Location, kind_of, read_source, unknown_preset};
use illuminator::workspace::{Library, Session, presets};
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
    for file in &options.files {
        let given = options.kind.map(|kind| match kind {
            KindName::Formula => FileKind::Formula,
            KindName::Scene => FileKind::Scene,
            KindName::Session => FileKind::Session,
            KindName::Material => FileKind::Material,
        });
        let location = built_in_if_missing(Location::new(file), given)?;
        for kind in kinds_of(&location, given) {
            wrong |= !check(&location, kind, options.thesis)?;
        }
    }
    if wrong { Err(Failure::Reported) } else { Ok(()) }
}

/// The location, or the built-in files of its name if there is no such file.
fn built_in_if_missing(location: Location, given: Option<FileKind>) -> Result<Location, Failure> {
    let Location::File(path) = &location else { return Ok(location) };
    let missing = path.symlink_metadata().is_err_and(|error| error.kind() == ErrorKind::NotFound);
    let is_named = |kind: &FileKind, name: &str| given.is_none_or(|given| given == *kind) && presets::text(*kind, name).is_some();
    let named = path.to_str().filter(|name| missing && FileKind::ALL.iter().any(|kind| is_named(kind, name)));
    let Some(name) = named.map(str::to_owned) else { return Ok(location) };
    let built_in = Location::Preset(name.clone());
    print(&format!("{name}: there is no such file; the built-in `{built_in}` is checked instead\n"))?;
    Ok(built_in)
}

/// The kinds as which a file is checked. Built-in files of several kinds may have one name: then all are checked.
fn kinds_of(location: &Location, given: Option<FileKind>) -> Vec<Option<FileKind>> {
    let Location::Preset(name) = location else { return vec![given] };
    let named: Vec<Option<FileKind>> =
        FileKind::ALL.into_iter().filter(|kind| presets::text(*kind, name).is_some()).map(Some).collect();
    if given.is_some() || named.is_empty() { vec![given] } else { named }
}

/// Checks one file. Returns whether it has no errors.
fn check(location: &Location, given: Option<FileKind>, thesis: bool) -> Result<bool, Failure> {
    let (kind, source) = match read(location, given) {
        Ok(found) => found,
        Err(diagnostic) => {
            say(&diagnostic);
            return Ok(false);
        }
    };
    let (diagnostics, value_warnings, files_are_valid) = match kind {
        FileKind::Formula => (check_formula(location, &source, thesis), 0, true),
        FileKind::Scene => (explained(Scene::parse(&source), &source), 0, true),
        FileKind::Session => check_session(location, &source),
        FileKind::Material => (explained(Library::parse(&source), &source), 0, true),
    };
    let [errors, warnings] = count(&diagnostics);
    let warnings = warnings + value_warnings;
    let number = |count: usize, what: &str| format!("{count} {what}{}", if count == 1 { "" } else { "s" });
    let [errors_found, warnings_found] = [number(errors, "error"), number(warnings, "warning")];
    let named_files = if errors == 0 && !files_are_valid { "; a file that it names has errors" } else { "" };
    let name = one_line(&location.to_string());
    print(&format!("{name}: {}, {errors_found}, {warnings_found}{named_files}\n", kind.noun()))?;
    Ok(errors == 0 && files_are_valid)
}

/// Reads a file, and finds out what it is if no kind is given.
fn read(location: &Location, given: Option<FileKind>) -> Result<(FileKind, Source), Diagnostic> {
    if let Some(kind) = given {
        return Ok((kind, location.read(kind, Readable::RegularOrPipe)?));
    }
    match location {
        Location::File(path) => {
            let source = read_source(path, None, Readable::RegularOrPipe)?;
            let suffix = match path.extension().and_then(|suffix| suffix.to_str()) {
                Some("formula") => Some(FileKind::Formula),
                Some("scene") => Some(FileKind::Scene),
                Some("toml") => Some(FileKind::Session),
                Some(_) | None => None,
            };
            // A formula or a scene with a mistake in its first line may look like TOML. For a file of unknown kind the
            // parser of formulas has the best messages.
            let told = kind_of(source.text()).filter(|kind| match kind {
                FileKind::Formula | FileKind::Scene => true,
                FileKind::Session | FileKind::Material => suffix.is_none_or(|suffix| suffix == FileKind::Session),
            });
            Ok((told.or(suffix).unwrap_or(FileKind::Formula), source))
        }
        // A name that some kind has comes with that kind.
        Location::Preset(name) => Err(unknown_preset(None, name)),
    }
}

/// Writes the diagnostics of a text and returns them.
fn explained<T>(outcome: Result<(T, Diagnostics), Diagnostics>, source: &Source) -> Diagnostics {
    match outcome {
        Ok((_, diagnostics)) | Err(diagnostics) => {
            explain(&diagnostics, source);
            diagnostics
        }
    }
}

/// Checks a formula, and whether the built-in material library that it may name exists. A file need not exist yet.
fn check_formula(location: &Location, source: &Source, thesis: bool) -> Diagnostics {
    let parse = if thesis { Formula::parse_as_thesis } else { Formula::parse };
    let outcome = parse(source).map(|(formula, mut diagnostics)| {
        if formula.uses.is_some()
            && let Err(unknown) = library_location(&formula, location, source, data_folder().as_deref())
        {
            diagnostics.push(unknown);
            diagnostics.sort();
        }
        (formula, diagnostics)
    });
    explained(outcome, source)
}

/// Checks a session and the files that it names. Returns the diagnostics of its text, the number of warnings about its
/// values, and whether the files are valid.
fn check_session(location: &Location, source: &Source) -> (Diagnostics, usize, bool) {
    let (mut session, diagnostics) = match Session::parse(source) {
        Ok(read) => read,
        Err(diagnostics) => {
            explain(&diagnostics, source);
            return (diagnostics, 0, false);
        }
    };
    if let Location::File(path) = location {
        let folder = path.parent().unwrap_or(Path::new(""));
        session.formula = session.formula.from_folder(folder);
        session.scene = session.scene.from_folder(folder);
    }
    explain(&diagnostics, source);
    match Project::check_session(&session, source, &mut Speaker) {
        Ok(warnings) => (diagnostics, warnings, true),
        Err(error) => {
            Failure::from(error).report();
            (diagnostics, 0, false)
        }
    }
}

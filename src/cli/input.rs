//! Opens what the options name, and reports everything that is wrong with it.

use crate::cli::options::{ColourArgument, InputOptions, PassOptions};
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, explain, say, say_lines};
use illuminator::engine::Task;
use illuminator::files::Readable;
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics};
use illuminator::lang::source::Source;
use illuminator::trace::usable_memory;
use illuminator::user_data::Folders;
use illuminator::workspace::presets::DEFAULT_SESSION;
use illuminator::workspace::project::{Listener, OpenProjectError, Project, Request, SessionText};
use illuminator::workspace::session::PictureSettings;
use illuminator::workspace::{FileKind, Location, kind_of_file, read_source, unknown_preset};
use std::path::PathBuf;

/// Reports diagnostics on standard error.
pub(super) struct Speaker;

impl Listener for Speaker {
    fn diagnostics(&mut self, diagnostics: &Diagnostics, source: &Source) {
        explain(diagnostics, source);
    }

    fn message(&mut self, diagnostic: Diagnostic) {
        say(&diagnostic);
    }

    fn remark(&mut self, text: &str) {
        say_lines(&format!("Note: {text}"));
    }
}

impl From<OpenProjectError> for Failure {
    fn from(error: OpenProjectError) -> Self {
        match error {
            OpenProjectError::Reported => Failure::Reported,
            OpenProjectError::Input(diagnostic) => Failure::Input(diagnostic),
            OpenProjectError::Request(diagnostic) => Failure::CommandLine(diagnostic),
        }
    }
}

/// The folder for what users save, such as materials for built-in formulas. A user without a home has none.
pub(super) fn data_folder() -> Option<PathBuf> {
    Folders::platform().map(|folders| folders.data).ok()
}

/// Opens the session, formula and scene that the options name.
pub(super) fn load(options: &InputOptions, passes: &PassOptions) -> Result<Project, Failure> {
    let given = |text: &Option<std::ffi::OsString>| text.as_ref().map(Location::new);
    let (formula, scene) = (given(&options.formula), given(&options.scene));
    let session = match (&options.session, &formula, &scene) {
        // With both files given and no session, every value is its default.
        (None, Some(_), Some(_)) => None,
        (None, ..) => Some(Location::Preset(DEFAULT_SESSION.to_owned())),
        (Some(session), ..) => Some(Location::new(session)),
    };
    let progress = Progress::new("reading files");
    let tell = |share: f64| progress.tell(share);
    let request = Request {
        session: session.map(SessionText::At),
        formula,
        scene,
        materials: &options.materials,
        data: data_folder(),
        set: &options.settings,
        picture: Some(&|picture| change_picture(options, passes, picture)),
        background: options.background.map(|ColourArgument(value)| value),
        memory: Some(options.machine.memory.unwrap_or_else(usable_memory)),
        task: Some(Task::watched(&tell)),
        session_readable: Readable::RegularOrPipe,
        readable: Readable::RegularOrPipe,
        ..Request::default()
    };
    Ok(Project::open(&request, &mut Speaker)?)
}

/// The picture settings of the command line.
fn change_picture(options: &InputOptions, passes: &PassOptions, picture: &mut PictureSettings) {
    picture.size = options.size.unwrap_or(picture.size);
    picture.depth = options.depth.unwrap_or(picture.depth);
    picture.shadows = !options.no_shadows && (options.shadows || picture.shadows);
    picture.samples = passes.samples.or(picture.samples);
    picture.default_index = options.ior.unwrap_or(picture.default_index);
}

/// Reads a file, and finds out what it is if no kind is given.
pub(super) fn read_of_kind(location: &Location, given: Option<FileKind>) -> Result<(FileKind, Source), Diagnostic> {
    if let Some(kind) = given {
        return Ok((kind, location.read(kind, Readable::RegularOrPipe)?));
    }
    match location {
        Location::File(path) => {
            let source = read_source(path, None, Readable::RegularOrPipe)?;
            Ok((kind_of_file(path, source.text()), source))
        }
        // A name that some kind has comes with that kind.
        Location::Preset(name) => Err(unknown_preset(None, name)),
    }
}

//! `preview`: the workshop window.

use crate::cli::report::{Failure, explain, say_lines, warn};
#[cfg(unix)]
use crate::cli::signals;
use illuminator::preview::app::App;
use illuminator::preview::window::screen::Screen;
use illuminator::preview::window::{WindowError, WindowExit, WindowOptions, run as show};
use illuminator::preview::workshop::OpeningErrors;
use illuminator::user_data::folders::Folders;
use illuminator::workspace::presets::DEFAULT_SESSION;
use illuminator::workspace::{FileKind, Location};
use std::ffi::OsString;

#[derive(clap::Args, Default)]
pub(super) struct Options {
    /// Session file, or a formula or scene for the built-in session [default: the startup session of the settings]
    session: Option<OsString>,

    /// Also print the log on standard error
    #[arg(long)]
    log: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let location = options.session.as_ref().map(Location::new);
    let folders = Folders::platform();
    let text = location.as_ref().and_then(|location| Some((kind_of_text(location)?, location.clone())));
    let built_in = Location::Preset(DEFAULT_SESSION.to_owned());
    let session = if text.is_some() { Some(&built_in) } else { location.as_ref() };
    let mut app = App::new(session, folders.as_ref().ok()).map_err(refuse)?;
    if let Some((kind, location)) = text {
        app.open(kind, location);
    }
    if let Err(reason) = &folders {
        app.notify_no_user_data(reason);
    }
    if options.log {
        app.set_log_listener(say_lines);
    }
    let screen = Screen::of_display();
    if let Some(screen) = &screen {
        app.start_on_screen(screen.size(), screen.suggested_scale());
    }
    let size = app.window_size();
    let exit = WindowExit::new(app.last_resort());
    #[cfg(unix)]
    signals::close_first(exit.clone());
    let shown = show(&mut app, WindowOptions { size }, &exit);
    app.closing_errors().iter().for_each(warn);
    shown.map_err(|error| {
        let kept = error == WindowError::DisplayLost && app.closing_errors().is_empty();
        Failure::input(format!("{error}{}", if kept { "; unsaved work is kept and offered at the next start" } else { "" }))
    })
}

#[cfg(unix)]
impl signals::Closing for WindowExit {
    fn close(&self) {
        WindowExit::close(self);
    }

    fn last_resort(&self) {
        WindowExit::last_resort(self);
    }
}

/// The kind of a file whose suffix is that of a formula or a scene, as file managers open them.
fn kind_of_text(location: &Location) -> Option<FileKind> {
    let Location::File(path) = location else { return None };
    let suffix = path.extension()?;
    [FileKind::Formula, FileKind::Scene].into_iter().find(|kind| suffix == kind.suffix())
}

/// Reports why the window cannot open.
fn refuse(OpeningErrors(errors): OpeningErrors) -> Failure {
    errors.iter().for_each(|found| explain(&found.diagnostics, &found.source));
    Failure::Reported
}

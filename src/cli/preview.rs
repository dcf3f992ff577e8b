//! `preview`: the workshop window.

use crate::cli::report::{Failure, explain, say_lines, warn};
#[cfg(unix)]
use crate::cli::signals;
use illuminator::preview::app::App;
use illuminator::preview::window::screen::Screen;
use illuminator::preview::window::{WindowError, WindowExit, WindowOptions, run as show};
use illuminator::preview::workshop::OpeningErrors;
use illuminator::user_data::folders::Folders;
use illuminator::workspace::Location;
use std::ffi::OsString;

#[derive(clap::Args, Default)]
pub(super) struct Options {
    /// Session file [default: the startup session of the settings]
    session: Option<OsString>,

    /// Also print the log on standard error
    #[arg(long)]
    log: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let location = options.session.as_ref().map(Location::new);
    let folders = Folders::platform();
    let mut app = App::new(location.as_ref(), folders.as_ref().ok()).map_err(refuse)?;
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

/// Reports why the window cannot open.
fn refuse(OpeningErrors(errors): OpeningErrors) -> Failure {
    errors.iter().for_each(|found| explain(&found.diagnostics, &found.source));
    Failure::Reported
}

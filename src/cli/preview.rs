//! `preview`: the workshop window.

use crate::cli::report::Failure;
use illuminator::preview::app::App;
use illuminator::preview::window::{WindowOptions, run as show};
use illuminator::workspace::files::Location;
use illuminator::workspace::folders::Folders;
use std::ffi::OsString;
use std::io::Write;

#[derive(clap::Args, Default)]
pub(super) struct Options {
    /// Session file [default: the startup session of the settings]
    session: Option<OsString>,

    /// Print the lines of the log, as they come, on standard error too
    #[arg(long)]
    log: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let location = options.session.as_ref().map(Location::new);
    // Without a home nothing is remembered.
    let folders = Folders::platform().ok();
    let mut app = App::new(location.as_ref(), folders.as_ref()).map_err(Failure::input)?;
    if options.log {
        // A pipe that is closed does not end the window.
        app.repeat_log(|line| drop(writeln!(std::io::stderr(), "{line}")));
    }
    let size = app.window_size();
    show(&mut app, WindowOptions { size }).map_err(|error| Failure::input(error.to_string()))
}

//! What the program says: diagnostics on the standard error, coloured on a terminal; results on the standard output.

use illuminator::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use illuminator::lang::source::Source;
use std::io::{self, ErrorKind, IsTerminal, Write};

/// Why a command could not do its work.
#[derive(Debug)]
pub(super) enum Failure {
    /// The input was wrong, or the machine did not suffice for it.
    Input(Diagnostic),
    /// The command line was wrong.
    CommandLine(Diagnostic),
    /// The input was wrong, and what is wrong has been said already.
    Reported,
}

impl Failure {
    /// The input was wrong in a way that has no place in a text.
    pub(super) fn input(message: impl Into<String>) -> Self {
        Failure::Input(Diagnostic::error(message))
    }

    /// The command line was wrong.
    pub(super) fn command_line(message: impl Into<String>) -> Self {
        Failure::CommandLine(Diagnostic::error(message))
    }

    /// Says what is wrong.
    pub(super) fn report(&self) {
        match self {
            Failure::Input(diagnostic) | Failure::CommandLine(diagnostic) => say(diagnostic),
            Failure::Reported => {}
        }
    }
}

/// Whether the standard error may be coloured.
fn colour() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    io::stderr().is_terminal() && !set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|terminal| terminal != "dumb")
}

/// Writes to the standard error; nobody can be told where that fails.
fn complain(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// Says a diagnostic that has no place in a text.
pub(super) fn say(diagnostic: &Diagnostic) {
    complain(&diagnostic.render(&Source::new("", ""), colour()));
}

/// Says a warning that has no place in a text.
pub(super) fn warn(message: impl Into<String>) {
    say(&Diagnostic::warning(message));
}

/// Says what was found in a text.
pub(super) fn explain(diagnostics: &Diagnostics, source: &Source) {
    if !diagnostics.is_empty() {
        complain(&diagnostics.render(source, colour()));
    }
}

/// How many errors and warnings there are.
pub(super) fn count(diagnostics: &Diagnostics) -> [usize; 2] {
    [Severity::Error, Severity::Warning]
        .map(|severity| diagnostics.iter().filter(|diagnostic| diagnostic.severity() == severity).count())
}

/// Writes a result to the standard output. A reader that has read enough and is gone is no failure.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut output = io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::input(format!("cannot write the output: {error}"))),
        Ok(()) | Err(_) => Ok(()),
    }
}

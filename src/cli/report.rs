//! The program's output: diagnostics on standard error, coloured on a terminal; results on standard output.
//!
//! Text leaves the program here only. It never contains characters that control a terminal:
//! [`display_text`](illuminator::lang::display_text) escapes and shortens messages, and this module escapes results.

use crate::cli::draw::{draw, draw_all};
use clap::error::{ContextKind, ContextValue};
use illuminator::engine::Subject;
use illuminator::evaluate::review::{PictureSummary, ReviewedPicture, review};
use illuminator::files::reason;
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use illuminator::lang::display_text::{escaped_lines, is_hidden, one_line};
use illuminator::lang::source::Source;
use illuminator::picture::{Frame, ViewTransform};
use illuminator::workspace::project::Project;
use serde::Serialize;
use std::io::{self, ErrorKind, IsTerminal, Write};

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Status {
    /// The command did its work; there may have been warnings.
    Success = 0,
    /// The input was wrong.
    Input = 1,
    /// The command line was wrong.
    CommandLine = 2,
}

/// Why a command could not do its work.
#[derive(Debug)]
pub(super) enum Failure {
    /// The input was wrong, or too large for the machine.
    Input(Diagnostic),
    /// The command line was wrong.
    CommandLine(Diagnostic),
    /// The input was wrong, and the errors have been reported.
    Reported,
}

impl Failure {
    /// An error of the input without a place in a text.
    pub(super) fn input(message: impl AsRef<str>) -> Self {
        Failure::Input(Diagnostic::error(message))
    }

    /// An error of the command line.
    pub(super) fn command_line(message: impl AsRef<str>) -> Self {
        Failure::CommandLine(Diagnostic::error(message))
    }

    /// The exit status for it.
    pub(super) fn status(&self) -> Status {
        match self {
            Failure::Input(_) | Failure::Reported => Status::Input,
            Failure::CommandLine(_) => Status::CommandLine,
        }
    }

    /// Writes the error, unless that has been done.
    pub(super) fn report(&self) {
        match self {
            Failure::Input(diagnostic) | Failure::CommandLine(diagnostic) => say(diagnostic),
            Failure::Reported => {}
        }
    }
}

/// Whether text on the standard error may be coloured.
fn colour() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    io::stderr().is_terminal() && !set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|terminal| terminal != "dumb")
}

/// Writes safe text to the standard error. If that fails, there is nobody to tell.
fn write_error(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// Writes a diagnostic that has no place in a text.
pub(super) fn say(diagnostic: &Diagnostic) {
    write_error(&draw(diagnostic, &Source::new("", ""), colour()));
}

/// Writes a message of one or more lines.
pub(super) fn say_lines(text: &str) {
    let text = illuminator::lang::display_text::many_lines(text);
    write_error(&text);
    if !text.ends_with('\n') {
        write_error("\n");
    }
}

/// Writes a warning that has no place in a text.
pub(super) fn warn(message: impl AsRef<str>) {
    say(&Diagnostic::warning(message));
}

/// Warns of what is remarkable about a picture that still has its NaN.
pub(super) fn warn_of_picture(project: &Project, frame: &Frame, transform: ViewTransform) {
    let Subject { formula, world, view } = &project.subject;
    let (passes, numbers) = (project.picture.passes(), project.values.numbers());
    let picture = ReviewedPicture { formula, world, view, passes, numbers, transform };
    let Some(finding) = review(&picture, &PictureSummary::of(frame)) else { return };
    let look = |([x, y], pass): ([u32; 2], Option<u32>)| {
        let pass = pass.map_or_else(String::new, |pass| format!(" --pass {pass}"));
        format!("`illuminator dump --stage rays --pixel {x},{y}{pass}`, with the same input, shows the numbers there")
    };
    say(&Diagnostic::warning(finding.message()).help_if(finding.pixel().map(look)));
}

/// Writes the message of the argument parser: an error, or help. Returns the exit status.
pub(super) fn say_arguments(error: clap::Error) -> Status {
    let error = with_safe_context(error);
    // A closed terminal or pipe is not an error here.
    let _ = error.print();
    // Help goes to standard output.
    if error.use_stderr() { Status::CommandLine } else { Status::Success }
}

/// The error with the user's words, which are in its context, escaped and shortened.
fn with_safe_context(mut error: clap::Error) -> clap::Error {
    let context: Vec<(ContextKind, ContextValue)> = error.context().map(|(kind, value)| (kind, value.clone())).collect();
    for (kind, value) in context {
        let safe = if let ContextValue::String(text) = &value {
            ContextValue::String(one_line(text))
        } else if let ContextValue::Strings(texts) = &value {
            ContextValue::Strings(texts.iter().map(|text| one_line(text)).collect())
        } else {
            continue;
        };
        if safe != value {
            error.insert(kind, safe);
            // The suggestions contain the word too.
            error.remove(ContextKind::Suggested);
        }
    }
    error
}

/// Writes the diagnostics of a text.
pub(super) fn explain(diagnostics: &Diagnostics, source: &Source) {
    if !diagnostics.is_empty() {
        write_error(&draw_all(diagnostics, source, colour()));
    }
}

/// The numbers of errors and of warnings.
pub(super) fn count(diagnostics: &Diagnostics) -> [usize; 2] {
    [Severity::Error, Severity::Warning]
        .map(|severity| diagnostics.iter().filter(|diagnostic| diagnostic.severity() == severity).count())
}

/// A number of things: "1 error", "2 errors".
pub(super) fn number(count: usize, what: &str) -> String {
    let plural = if what.ends_with('s') { "es" } else { "s" };
    format!("{count} {what}{}", if count == 1 { "" } else { plural })
}

/// Writes a result to standard output. It is not a failure if the reader has closed the pipe.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    print_bytes(escaped_lines(text).as_bytes())
}

/// Writes a result as JSON to standard output. Hidden characters are written as JSON writes them.
pub(super) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::input(error.to_string()))?;
    print_bytes(escaped_json(&text).as_bytes())
}

/// JSON with a line feed at its end, in which the hidden characters of texts are escapes.
fn escaped_json(text: &str) -> String {
    let mut written = String::with_capacity(text.len() + 1);
    for character in text.chars() {
        if character != '\n' && is_hidden(character) {
            let mut units = [0; 2];
            written.extend(character.encode_utf16(&mut units).iter().map(|unit| format!("\\u{unit:04x}")));
        } else {
            written.push(character);
        }
    }
    written.push('\n');
    written
}

/// Writes a result that is no text to standard output. It is not a failure if the reader has closed the pipe.
pub(super) fn print_bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut output = io::stdout().lock();
    match output.write_all(bytes).and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("cannot write the output: {}", reason(&error))))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}

/// Whether standard output is a terminal.
pub(super) fn prints_to_terminal() -> bool {
    io::stdout().is_terminal()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_stay_json() {
        let name = "a\u{202e}b\u{e0001}\t\u{9b}\n";
        let written = escaped_json(&serde_json::to_string_pretty(&[name]).unwrap());
        assert!(!written.chars().any(|character| character != '\n' && is_hidden(character)), "{written}");
        assert_eq!(serde_json::from_str::<[String; 1]>(&written).unwrap(), [name]);
    }
}

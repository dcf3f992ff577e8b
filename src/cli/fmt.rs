//! `illuminator fmt`: gives formulas and scenes a regular layout.

use crate::cli::input::read_of_kind;
use crate::cli::report::{Failure, count, explain, number, print, print_bytes, prints_to_terminal, say};
use clap::Args;
use illuminator::files::{reason, replace_text};
use illuminator::lang::diagnostic::{Diagnostic, Diagnostics};
use illuminator::lang::display_text::one_line;
use illuminator::lang::format::formatted;
use illuminator::lang::parser;
use illuminator::lang::source::Source;
use illuminator::scene::Scene;
use illuminator::workspace::{FileKind, Location, kind_of, presets};
use std::ffi::OsString;
use std::io::Read;
use std::path::Path;

/// The name of standard input on the command line.
const STANDARD_INPUT: &str = "-";

/// Options of `fmt`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Formulas and scenes; - formats standard input and prints it
    #[arg(required = true, value_name = "FILE")]
    files: Vec<OsString>,
    /// Change nothing; fail if a file would be changed
    #[arg(long, conflicts_with = "stdout")]
    check: bool,
    /// Print the formatted text, and change nothing
    #[arg(id = "stdout", long = "stdout")]
    prints: bool,
}

/// Formats all files, even if the first ones have errors.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let mut failed = false;
    for file in &options.files {
        let location = Location::new(file);
        failed |= !format(&location, options)?;
    }
    if failed { Err(Failure::Reported) } else { Ok(()) }
}

/// Formats a file, or standard input. Returns whether that was possible and, with `--check`, whether nothing was to be
/// done.
fn format(location: &Location, options: &Options) -> Result<bool, Failure> {
    let is_input = matches!(location, Location::File(path) if path.as_os_str() == STANDARD_INPUT);
    let read = if is_input { standard_input() } else { read_of_kind(location, kind_of_preset(location)) };
    let (kind, source) = match read {
        Ok(read) => read,
        Err(diagnostic) => {
            say(&diagnostic);
            return Ok(false);
        }
    };
    let name = one_line(source.name());
    let text = match laid_out(kind, &source) {
        Some(Ok(text)) => text,
        Some(Err(diagnostics)) => {
            explain(&diagnostics, &source);
            let [errors, _] = count(&diagnostics);
            say(&Diagnostic::error(format!("`{name}` is left as it is: it has {}", number(errors, "error"))));
            return Ok(false);
        }
        None => {
            say(&Diagnostic::error(format!("`{name}` is a {}, not a formula or a scene", kind.noun()))
                .help("only formulas and scenes are formatted"));
            return Ok(false);
        }
    };
    if options.prints || is_input && !options.check {
        if prints_to_terminal() {
            print(&text)?;
        } else {
            print_bytes(text.as_bytes())?;
        }
        return Ok(true);
    }
    let is_regular = text == source.text();
    if options.check {
        let state = if is_regular { "already formatted" } else { "not formatted" };
        print(&format!("{name}: {state}\n"))?;
        return Ok(is_regular);
    }
    let Location::File(path) = location else {
        say(&Diagnostic::error(format!("`{name}` is built in and cannot be changed"))
            .help("`--stdout` prints the formatted text"));
        return Ok(false);
    };
    if !is_regular && let Err(diagnostic) = overwrite(path, &name, &text) {
        say(&diagnostic);
        return Ok(false);
    }
    print(&format!("{name}: {}\n", if is_regular { "unchanged" } else { "formatted" }))?;
    Ok(true)
}

/// The text of standard input, and what it is.
fn standard_input() -> Result<(FileKind, Source), Diagnostic> {
    let name = "standard input";
    let mut text = String::new();
    match std::io::stdin().read_to_string(&mut text) {
        Ok(_) => Ok((kind_of(&text).unwrap_or(FileKind::Formula), Source::new(name, text))),
        Err(error) => Err(Diagnostic::error(format!("cannot read {name}: {}", reason(&error)))),
    }
}

/// Writes a formatted text over a file that may be written. The file is replaced by another one, which its write
/// protection would not prevent.
fn overwrite(path: &Path, name: &str, text: &str) -> Result<(), Diagnostic> {
    if path.metadata().is_ok_and(|found| found.permissions().readonly()) {
        let error = Diagnostic::error(format!("`{name}` is read-only and is left as it is"));
        return Err(error.help("`--stdout` prints the formatted text"));
    }
    replace_text(path, text).map_err(|error| Diagnostic::error(format!("cannot write `{name}`: {}", reason(&error))))
}

/// The kind of a built-in file. Formulas and scenes come first if files of several kinds have one name.
fn kind_of_preset(location: &Location) -> Option<FileKind> {
    let Location::Preset(name) = location else { return None };
    FileKind::ALL.into_iter().find(|kind| presets::text(*kind, name).is_some())
}

/// The formatted text of a formula or a scene, or its errors; `None` for other kinds.
pub(super) fn laid_out(kind: FileKind, source: &Source) -> Option<Result<String, Diagnostics>> {
    let diagnostics = match kind {
        // Names and types do not matter.
        FileKind::Formula => parser::parse(source).1,
        FileKind::Scene => Scene::parse(source).err().unwrap_or_default(),
        FileKind::Session | FileKind::Material => return None,
    };
    Some(if diagnostics.has_errors() { Err(diagnostics) } else { formatted(source) })
}

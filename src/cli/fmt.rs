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
use illuminator::workspace::{FileKind, Location, presets};
use std::ffi::OsString;

/// Options of `fmt`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Formulas and scenes
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

/// Formats a file. Returns whether that was possible and, with `--check`, whether nothing was to be done.
fn format(location: &Location, options: &Options) -> Result<bool, Failure> {
    let (kind, source) = match read_of_kind(location, kind_of_preset(location)) {
        Ok(read) => read,
        Err(diagnostic) => {
            say(&diagnostic);
            return Ok(false);
        }
    };
    let name = one_line(&location.to_string());
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
    if options.prints {
        if prints_to_terminal() {
            print(&text)?;
        } else {
            print_bytes(text.as_bytes())?;
        }
        return Ok(true);
    }
    let is_regular = text == source.text();
    if options.check {
        let state = if is_regular { "formatted" } else { "not formatted" };
        print(&format!("{name}: {state}\n"))?;
        return Ok(is_regular);
    }
    let Location::File(path) = location else {
        say(&Diagnostic::error(format!("`{name}` is built in and cannot be changed"))
            .help("`--stdout` prints the formatted text"));
        return Ok(false);
    };
    if !is_regular && let Err(error) = replace_text(path, &text) {
        say(&Diagnostic::error(format!("cannot write `{name}`: {}", reason(&error))));
        return Ok(false);
    }
    print(&format!("{name}: {}\n", if is_regular { "unchanged" } else { "formatted" }))?;
    Ok(true)
}

/// The kind of a built-in formula or scene.
fn kind_of_preset(location: &Location) -> Option<FileKind> {
    let Location::Preset(name) = location else { return None };
    [FileKind::Formula, FileKind::Scene].into_iter().find(|kind| presets::text(*kind, name).is_some())
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

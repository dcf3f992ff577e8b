//! `illuminator export`: writes a formula in another language.

use crate::cli::input::read_of_kind;
use crate::cli::output::{check_distinct, check_folder};
use crate::cli::report::{Failure, explain, print, print_bytes, prints_to_terminal};
use clap::Args;
use clap::builder::PossibleValuesParser;
use clap::builder::{PossibleValue, TypedValueParser};
use illuminator::export::{ExportTarget, export};
use illuminator::files::{reason, replace_text};
use illuminator::formula::Formula;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::display_text::one_line;
use illuminator::workspace::{FileKind, Location};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Options of `export`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Formula: a file, or preset:NAME
    formula: OsString,
    /// Language to write
    #[arg(long, value_name = "LANGUAGE", value_parser = languages())]
    to: ExportTarget,
    /// File to write, which is replaced [default: standard output]
    #[arg(long = "output", short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The names of the languages.
fn languages() -> impl TypedValueParser<Value = ExportTarget> {
    let values = ExportTarget::all().map(|target| PossibleValue::new(target.name()).help(target.doc()));
    PossibleValuesParser::new(values).try_map(|name| ExportTarget::named(&name).ok_or("no such language"))
}

/// Writes the formula.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let location = Location::new(&options.formula);
    if let (Some(output), Location::File(path)) = (&options.output, &location) {
        check_distinct(output, std::slice::from_ref(path))?;
    }
    let given = matches!(location, Location::Preset(_)).then_some(FileKind::Formula);
    let (kind, source) = read_of_kind(&location, given).map_err(Failure::Input)?;
    let name = one_line(source.name());
    if kind != FileKind::Formula {
        let error = Diagnostic::error(format!("`{name}` is a {}, not a formula", kind.noun()));
        return Err(Failure::Input(error.help("only formulas are written in other languages")));
    }
    let formula = match Formula::parse(&source) {
        Ok((formula, warnings)) => {
            explain(&warnings, &source);
            formula
        }
        Err(errors) => {
            explain(&errors, &source);
            return Err(Failure::Reported);
        }
    };
    let function = match &location {
        Location::Preset(name) => name.clone(),
        Location::File(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
    };
    let text = export(&formula, &function, &name, options.to).map_err(|error| Failure::input(error.to_string()))?;
    let Some(output) = &options.output else {
        return if prints_to_terminal() { print(&text) } else { print_bytes(text.as_bytes()) };
    };
    check_folder(output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")))?;
    replace_text(output, &text)
        .map_err(|error| Failure::input(format!("cannot write `{}`: {}", output.display(), reason(&error))))?;
    print(&format!("{}: {name} in {}\n", one_line(&output.display().to_string()), options.to.doc()))
}

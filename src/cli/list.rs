//! `illuminator list`: names the built-in files.

use crate::cli::report::{Failure, print};
use illuminator::workspace::{FileKind, presets};

/// Lists the built-in files.
pub(super) fn run() -> Result<(), Failure> {
    print(&format!("{}\nAnywhere in place of a file, `preset:NAME` names a built-in one.\n", listed()))
}

/// The names of the built-in files of each kind, with a line for each.
pub(super) fn listed() -> String {
    let kinds = [
        ("Sessions (a formula, a scene and values)", FileKind::Session),
        ("Formulas", FileKind::Formula),
        ("Scenes", FileKind::Scene),
        ("Material libraries", FileKind::Material),
    ];
    let width = kinds.iter().flat_map(|(_, kind)| presets::names(*kind)).map(str::len).max().unwrap_or(0);
    let line = |preset: &presets::Preset| format!("  preset:{:width$}  {}\n", preset.name, preset.about);
    let section =
        |(title, kind): (&str, FileKind)| format!("{title}:\n{}", presets::all(kind).iter().map(line).collect::<String>());
    kinds.map(section).join("\n")
}

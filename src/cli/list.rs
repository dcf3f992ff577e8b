//! `illuminator list`: names the built-in files.

use crate::cli::report::{Failure, print};
use illuminator::environment;
use illuminator::workspace::{FileKind, presets};

/// Lists the built-in files.
pub(super) fn run() -> Result<(), Failure> {
    print(&format!("{}\nAnywhere in place of a file, `preset:NAME` names a built-in one.\n", listed()))
}

/// The names of the built-in files of each kind, with a line for each.
pub(super) fn listed() -> String {
    let texts = [
        ("Sessions (a formula, a scene and values)", FileKind::Session),
        ("Formulas", FileKind::Formula),
        ("Scenes", FileKind::Scene),
        ("Material libraries", FileKind::Material),
    ];
    type Named = (&'static str, &'static str);
    let texts = texts.map(|(title, kind)| {
        let named = presets::all(kind).iter().map(|preset| (preset.name, preset.about));
        (title, Vec::from_iter(named))
    });
    let environments = Vec::from_iter(environment::PRESETS.iter().map(|preset| (preset.name, preset.about)));
    let meshes = Vec::from_iter(presets::MESHES.iter().map(|mesh| (mesh.name, mesh.about)));
    let assets = [("Environments, which scenes name", environments), ("Meshes, which scenes name", meshes)];
    let sections: Vec<(&str, Vec<Named>)> = texts.into_iter().chain(assets).collect();
    let width = sections.iter().flat_map(|(_, named)| named).map(|(name, _)| name.len()).max().unwrap_or(0);
    let line = |(name, about): &Named| format!("  preset:{name:width$}  {about}\n");
    let section = |(title, named): &(&str, Vec<Named>)| format!("{title}:\n{}", named.iter().map(line).collect::<String>());
    sections.iter().map(section).collect::<Vec<_>>().join("\n")
}

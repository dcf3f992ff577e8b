//! The files that are built into the program, so it works from any folder. `preset:NAME` names them.

use crate::workspace::file_kind::FileKind;

/// The session that opens if none is named.
pub const DEFAULT_SESSION: &str = "default";

macro_rules! files {
    ($folder:literal, $suffix:literal: $($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../presets/", $folder, "/", $name, ".", $suffix))),)*]
    };
}

/// The name and the text of each file, in the order of menus and lists.
const FORMULAS: &[(&str, &str)] =
    files!("formula", "formula": "phong", "phong-thesis", "lambert", "blinn-phong", "strauss", "strauss-thesis");
const SCENES: &[(&str, &str)] = files!("scene", "scene": "studio", "glass", "highlights", "sunset", "crystals", "dozen");
const SESSIONS: &[(&str, &str)] =
    files!("session", "toml": "default", "studio", "glass", "highlights", "sunset", "crystals", "dozen");
const MATERIALS: &[(&str, &str)] = files!("material", "toml": "phong", "blinn-phong", "strauss");

/// The built-in files of a kind.
fn files_of(kind: FileKind) -> &'static [(&'static str, &'static str)] {
    match kind {
        FileKind::Formula => FORMULAS,
        FileKind::Scene => SCENES,
        FileKind::Session => SESSIONS,
        FileKind::Material => MATERIALS,
    }
}

/// The text of a built-in file.
pub fn text(kind: FileKind, name: &str) -> Option<&'static str> {
    files_of(kind).iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The names of all built-in files of a kind.
pub fn names(kind: FileKind) -> impl Iterator<Item = &'static str> {
    files_of(kind).iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::lang::source::Source;
    use crate::scene::Scene;
    use crate::workspace::{Library, Session};

    fn sources(kind: FileKind) -> impl Iterator<Item = Source> {
        names(kind).map(move |name| Source::new(name, text(kind, name).unwrap()))
    }

    #[test]
    fn all_built_in_files_are_sound() {
        for source in sources(FileKind::Formula) {
            Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(FileKind::Scene) {
            Scene::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(FileKind::Session) {
            Session::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(FileKind::Material) {
            let (library, warnings) = Library::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
            assert!(warnings.is_empty() && library.len() >= 6, "{}", source.name());
        }
        assert!(text(FileKind::Session, DEFAULT_SESSION).is_some());
    }
}

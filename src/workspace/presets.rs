//! The files that are built into the program, so it works from any folder. `preset:NAME` names them.

use crate::workspace::file_kind::FileKind;

/// The session that opens if none is named.
pub const DEFAULT_SESSION: &str = "default";

/// A built-in file.
#[derive(Debug)]
pub struct Preset {
    /// Its name, without `preset:`.
    pub name: &'static str,
    /// What it shows or describes: one line, for lists and menus.
    pub about: &'static str,
    text: &'static str,
}

macro_rules! files {
    ($folder:literal, $suffix:literal: $($name:literal = $about:literal),* $(,)?) => {
        &[$(Preset {
            name: $name,
            about: $about,
            text: include_str!(concat!("../../presets/", $folder, "/", $name, ".", $suffix)),
        },)*]
    };
}

// The files, in the order of menus and lists.
const FORMULAS: &[Preset] = files!("formula", "formula":
    "phong" = "Phong (1975): matte, with a highlight around the mirror direction",
    "phong-thesis" = "Phong's model as the thesis writes it",
    "lambert" = "Lambert (1760): perfectly matte",
    "blinn-phong" = "Blinn (1977): the highlight by the half-way vector",
    "strauss" = "Strauss (1990): smooth, metallic, transparent",
    "strauss-thesis" = "Strauss's model as the thesis prints it",
);
const SCENES: &[Preset] = files!("scene", "scene":
    "studio" = "two balls under three lights, for a new formula",
    "glass" = "glass before a wall, and a mirror",
    "highlights" = "fifteen balls of plastic, copper and steel, to compare highlights",
    "sunset" = "water, silver, glass and a soap bubble at sunset",
    "crystals" = "balls of glass and mirrors before a fan of colours",
    "dozen" = "twelve coloured balls around a mirror",
);
const SESSIONS: &[Preset] = files!("session", "toml":
    "default" = "the crystals with Phong's model: what opens if nothing is named",
    "studio" = "two balls in a studio, with Phong's model",
    "glass" = "glass and a mirror, with Phong's model",
    "highlights" = "plastic, copper and steel, with Strauss's model",
    "sunset" = "water, silver and glass at sunset, with Phong's model",
    "crystals" = "glass and mirrors before a fan of colours, with Blinn's model",
    "dozen" = "twelve balls around a mirror, with Blinn's model",
);
const MATERIALS: &[Preset] = files!("material", "toml":
    "phong" = "materials for Phong's model",
    "blinn-phong" = "materials for Blinn's model",
    "strauss" = "materials for Strauss's model",
);

/// The built-in files of a kind, in the order of menus and lists.
pub fn all(kind: FileKind) -> &'static [Preset] {
    match kind {
        FileKind::Formula => FORMULAS,
        FileKind::Scene => SCENES,
        FileKind::Session => SESSIONS,
        FileKind::Material => MATERIALS,
    }
}

/// The text of a built-in file.
pub fn text(kind: FileKind, name: &str) -> Option<&'static str> {
    all(kind).iter().find(|preset| preset.name == name).map(|preset| preset.text)
}

/// The names of all built-in files of a kind.
pub fn names(kind: FileKind) -> impl Iterator<Item = &'static str> {
    all(kind).iter().map(|preset| preset.name)
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

//! The files that are built into the program, so that it works from any folder: `preset:NAME` names them.

/// The kinds of built-in files, each with a folder of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Illumination models.
    Formula,
    /// Scenes.
    Scene,
    /// Sessions.
    Session,
    /// Libraries of materials.
    Material,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Kind; 4] = [Kind::Formula, Kind::Scene, Kind::Session, Kind::Material];

    /// As messages call it.
    pub fn noun(self) -> &'static str {
        match self {
            Kind::Formula => "formula",
            Kind::Scene => "scene",
            Kind::Session => "session",
            Kind::Material => "material library",
        }
    }

    /// As files that tell kinds apart call it.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Formula => "formula",
            Kind::Scene => "scene",
            Kind::Session => "session",
            Kind::Material => "material",
        }
    }

    fn table(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Kind::Formula => FORMULAS,
            Kind::Scene => SCENES,
            Kind::Session => SESSIONS,
            Kind::Material => MATERIALS,
        }
    }
}

/// The session that is opened where none is named.
pub const DEFAULT_SESSION: &str = "default";

macro_rules! files {
    ($folder:literal, $suffix:literal: $($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../presets/", $folder, "/", $name, ".", $suffix))),)*]
    };
}

/// Name and text of each, in the order in which they are listed.
const FORMULAS: &[(&str, &str)] =
    files!("formula", "formula": "phong", "phong-thesis", "lambert", "blinn-phong", "strauss", "strauss-thesis");
const SCENES: &[(&str, &str)] = files!("scene", "scene": "studio", "glass", "highlights", "sunset", "crystals", "dozen");
const SESSIONS: &[(&str, &str)] =
    files!("session", "toml": "default", "studio", "glass", "highlights", "sunset", "crystals", "dozen");
const MATERIALS: &[(&str, &str)] = files!("material", "toml": "phong", "blinn-phong", "strauss");

/// The text of a built-in file.
pub fn text(kind: Kind, name: &str) -> Option<&'static str> {
    kind.table().iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The names of all built-in files of a kind.
pub fn names(kind: Kind) -> impl Iterator<Item = &'static str> {
    kind.table().iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::lang::source::Source;
    use crate::scene::Scene;
    use crate::workspace::{Library, Session};

    fn sources(kind: Kind) -> impl Iterator<Item = Source> {
        names(kind).map(move |name| Source::new(name, text(kind, name).unwrap()))
    }

    #[test]
    fn all_built_in_files_are_sound() {
        for source in sources(Kind::Formula) {
            Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(Kind::Scene) {
            Scene::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(Kind::Session) {
            Session::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(Kind::Material) {
            let (library, warnings) = Library::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
            assert!(warnings.is_empty() && library.len() >= 6, "{}", source.name());
        }
        assert!(text(Kind::Session, DEFAULT_SESSION).is_some());
    }
}

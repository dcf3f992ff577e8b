//! The kinds of files that users write.

/// The kinds of files that users write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FileKind {
    /// Illumination models.
    Formula,
    /// Scenes.
    Scene,
    /// Sessions.
    Session,
    /// Libraries of materials.
    Material,
}

impl FileKind {
    /// Every kind.
    pub const ALL: [FileKind; 4] = [FileKind::Formula, FileKind::Scene, FileKind::Session, FileKind::Material];

    /// What messages call it.
    pub fn noun(self) -> &'static str {
        match self {
            FileKind::Formula => "formula",
            FileKind::Scene => "scene",
            FileKind::Session => "session",
            FileKind::Material => "material library",
        }
    }

    /// The suffix of its files, without the dot.
    pub fn suffix(self) -> &'static str {
        match self {
            FileKind::Formula => "formula",
            FileKind::Scene => "scene",
            FileKind::Session | FileKind::Material => "toml",
        }
    }

    /// The word for it in files that name kinds.
    pub fn word(self) -> &'static str {
        match self {
            FileKind::Formula => "formula",
            FileKind::Scene => "scene",
            FileKind::Session => "session",
            FileKind::Material => "material",
        }
    }
}

//! What the files hold that a scene names. A scene only names them; whoever reads files gives them to the world.

use crate::world::meshes::Meshes;

/// What a scene names, ready for rays. A copy is cheap.
#[derive(Debug, Clone, Default)]
pub struct Assets {
    /// The meshes of its bodies.
    pub meshes: Meshes,
}

impl Assets {
    /// Nothing: for scenes that name nothing.
    pub const NONE: Assets = Assets { meshes: Meshes::NONE };

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty()
    }

    /// The memory that all of them take, in bytes. What several share counts once.
    pub fn memory(&self) -> u64 {
        self.meshes.memory()
    }
}

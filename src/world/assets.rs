//! What the files hold that a scene names. A scene only names them; whoever reads files gives them to the world.

use crate::environment::RadianceMap;
use crate::scene::light::EnvironmentLight;
use crate::world::meshes::Meshes;
use crate::world::missing_asset::MissingAsset;
use std::sync::{Arc, LazyLock};

/// What a scene names, ready for rays. A copy is cheap.
#[derive(Debug, Clone, Default)]
pub struct Assets {
    /// The meshes of its bodies.
    pub meshes: Meshes,
    /// The map of its environment.
    pub environment: Option<NamedMap>,
}

/// A map of radiance by the name that a scene has for it.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedMap {
    /// The name in the scene, see [`NamedFile::path`](crate::scene::NamedFile::path).
    pub path: String,
    /// The map.
    pub map: Arc<RadianceMap>,
}

impl Assets {
    /// Nothing: for scenes that name nothing.
    pub const NONE: Assets = Assets { meshes: Meshes::NONE, environment: None };

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty() && self.environment.is_none()
    }

    /// The memory that all of them take, in bytes. What several share counts once.
    pub fn memory(&self) -> u64 {
        self.meshes.memory() + self.environment.as_ref().map_or(0, |environment| environment.map.memory())
    }

    /// The map of an environment, which is the light of this name.
    pub(super) fn map_of(&self, light: &str, environment: &EnvironmentLight) -> Result<Arc<RadianceMap>, MissingAsset> {
        static WHITE: LazyLock<Arc<RadianceMap>> = LazyLock::new(|| Arc::new(RadianceMap::WHITE));
        let Some(image) = environment.image() else { return Ok(Arc::clone(&WHITE)) };
        let given = self.environment.as_ref().filter(|given| given.path == image.path());
        let missing = || MissingAsset::Map { light: light.to_owned(), path: image.path().to_owned() };
        given.map(|given| Arc::clone(&given.map)).ok_or_else(missing)
    }
}

//! Reading the files that scenes name: meshes, and the images of environments.
//!
//! A path in a scene is relative to the folder of the scene, and `preset:NAME` names a built-in mesh or environment. A
//! store keeps what it has read, also the mistakes, by the path, length and time of modification of the file. So a file
//! is read again if it has changed, and only then. Of a glTF file, the files that it names are not watched.

mod maps;
mod meshes;
mod named;
#[cfg(test)]
mod tests;

use crate::lang::diagnostic::Diagnostics;
use crate::mesh::Reading;
use crate::scene::Scene;
use crate::workspace::Location;
use crate::world::Assets;
use maps::{KeptMaps, image_of};
use meshes::KeptMeshes;
use named::AssetOrigin;

/// What was read of files that scenes name. It can be shared between threads.
#[derive(Debug, Default)]
pub struct AssetStore {
    meshes: KeptMeshes,
    maps: KeptMaps,
}

/// Why the files that a scene names were not read.
#[derive(Debug, Clone, PartialEq)]
pub enum AssetLoadError {
    /// The work was cancelled.
    Cancelled,
    /// What is wrong, at the names in the text of the scene.
    Unusable(Diagnostics),
}

/// Work that was cancelled.
struct Cancelled;

impl AssetStore {
    /// What the files hold that a scene at `scene_location` names, with warnings at their names in the text of the
    /// scene.
    ///
    /// ```
    /// # use illuminator::{lang::source::Source, mesh::Reading, scene::Scene, trace::View};
    /// # use illuminator::{engine::Subject, formula::Formula, workspace::{AssetStore, Location}};
    /// let text = "bodies; stone: mesh, \"preset:gem\", fit <0,0,0> 2; lights; key: point, <3,4,5>;
    ///     camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;";
    /// let (scene, _) = Scene::parse(&Source::new("gem.scene", text)).map_err(|errors| errors.len()).unwrap();
    /// let (store, place) = (AssetStore::default(), Location::new("gem.scene"));
    /// let (assets, _) = store.load(&scene, &place, &Reading::unwatched(1 << 30)).unwrap();
    /// let (formula, _) = Formula::parse(&Source::new("lambert", "formula; = IL*Cd*max(0, N.L);")).unwrap();
    /// let subject = Subject::new(formula, scene, &assets, View::new(64, 48)?)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A file cannot be used, or the work was cancelled.
    pub fn load(
        &self,
        scene: &Scene,
        scene_location: &Location,
        reading: &Reading,
    ) -> Result<(Assets, Diagnostics), AssetLoadError> {
        let (mut assets, mut found) = (Assets::NONE, Diagnostics::default());
        // Each file is a part of the work.
        let meshes = assets.meshes.missing(scene).len() as f64;
        let images = if image_of(scene).is_some() { 1.0 } else { 0.0 };
        let of_meshes = meshes / (meshes + images).max(1.0);
        let tell_of_meshes = |share: f64| (reading.progress)(of_meshes * share);
        let tell_of_image = |share: f64| (reading.progress)(of_meshes + (1.0 - of_meshes) * share);
        let [part, last] = [Reading { progress: &tell_of_meshes, ..*reading }, Reading { progress: &tell_of_image, ..*reading }];
        self.meshes
            .load(scene, scene_location, &part, &mut assets.meshes, &mut found)
            .and_then(|()| self.maps.load(scene, scene_location, &last, &mut assets, &mut found))
            .map_err(|Cancelled| AssetLoadError::Cancelled)?;
        found.sort();
        if found.has_errors() { Err(AssetLoadError::Unusable(found)) } else { Ok((assets, found)) }
    }

    /// How many bytes of files would be read for a scene at `scene_location`. What is built in, and what is kept,
    /// counts nothing.
    pub fn bytes_to_read(&self, scene: &Scene, scene_location: &Location) -> u64 {
        self.unread(scene, scene_location).iter().map(AssetOrigin::length).sum()
    }

    /// Whether a file that a scene at `scene_location` names is another one than was read.
    pub fn has_changed(&self, scene: &Scene, scene_location: &Location) -> bool {
        !self.unread(scene, scene_location).is_empty()
    }

    /// Forgets what was too large for the memory. It is tried again.
    pub fn forget_refused(&self) {
        self.meshes.forget_refused();
        self.maps.forget_refused();
    }

    /// The files that a scene names and of which nothing is kept.
    fn unread(&self, scene: &Scene, scene_location: &Location) -> Vec<AssetOrigin> {
        let mut unread = self.meshes.unread(scene, scene_location);
        unread.extend(self.maps.unread(scene, scene_location));
        unread
    }
}

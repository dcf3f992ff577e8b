//! What the project promises, tested through its public interface.
#![allow(clippy::expect_used, clippy::panic, reason = "a test that cannot go on has failed")]

mod agreement;
mod export;
#[cfg(feature = "gpu")]
mod gpu_shaders;
mod grammars;
mod house;
mod inspection;
mod lights;
mod materials;
mod models;
mod packaging;
mod presets;
mod reference;
mod round_trip;
mod shaderball;

use illuminator::mesh::Reading;
use illuminator::scene::Scene;
use illuminator::workspace::{AssetStore, Location};
use illuminator::world::World;

/// The world of a scene whose meshes are built in.
fn world_of(scene: Scene) -> World {
    let loaded = AssetStore::default().load(&scene, &Location::new(""), &Reading::unwatched(1 << 30));
    World::new(scene, &loaded.expect("built-in meshes").0).expect("its meshes")
}

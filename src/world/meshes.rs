//! The meshes of a scene, ready for rays. A scene only names them; whoever reads files gives them to the world.

use crate::bvh::MeshTree;
use crate::mesh::TriangleMesh;
use crate::scene::{Body, MeshShading, Scene};
use crate::world::missing_asset::MissingAsset;
use std::sync::Arc;

/// Meshes by the names that scenes have for them. A copy is cheap: it shares the triangles.
#[derive(Debug, Clone, Default)]
pub struct Meshes {
    meshes: Vec<GivenMesh>,
}

#[derive(Debug, Clone)]
struct GivenMesh {
    key: MeshKey,
    tree: Arc<MeshTree>,
}

/// Which mesh a body needs.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct MeshKey {
    /// The name in the scene, see [`NamedMesh::path`](crate::scene::shape::NamedMesh::path).
    pub path: String,
    /// Whether it needs normals of its vertices even if the file has none.
    pub needs_normals: bool,
}

impl MeshKey {
    /// The mesh that a body needs; `None` if it is no mesh.
    pub fn of(body: &Body) -> Option<Self> {
        let mesh = body.form.shape.mesh()?;
        Some(Self { path: mesh.path().to_owned(), needs_normals: body.shading == Some(MeshShading::Smooth) })
    }
}

impl Meshes {
    /// No meshes: for scenes that name none.
    pub const NONE: Meshes = Meshes { meshes: Vec::new() };

    /// Adds a mesh. If the key needs normals, [`TriangleMesh::smooth`] has made them.
    pub fn insert(&mut self, key: MeshKey, tree: Arc<MeshTree>) {
        self.meshes.retain(|given| given.key != key);
        self.meshes.push(GivenMesh { key, tree });
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.meshes.is_empty()
    }

    /// The mesh of that key.
    pub fn get(&self, key: &MeshKey) -> Option<&Arc<MeshTree>> {
        self.meshes.iter().find(|given| given.key == *key).map(|given| &given.tree)
    }

    /// Those that a scene needs and that are not here yet, each once.
    pub fn missing<'s>(&self, scene: &'s Scene) -> Vec<(&'s Body, MeshKey)> {
        let mut missing: Vec<(&Body, MeshKey)> = Vec::new();
        for body in &scene.bodies {
            let Some(key) = MeshKey::of(body) else { continue };
            if self.get(&key).is_none() && missing.iter().all(|(_, other)| *other != key) {
                missing.push((body, key));
            }
        }
        missing
    }

    /// The mesh of a body, and whether it is shaded smoothly.
    pub(super) fn of_body(&self, body: &Body, path: &str) -> Result<(Arc<MeshTree>, bool), MissingAsset> {
        let missing = || MissingAsset::Mesh { body: body.name.clone(), path: path.to_owned() };
        let tree = MeshKey::of(body).and_then(|key| self.get(&key)).ok_or_else(missing)?;
        let has_normals = !tree.mesh().normals().is_empty();
        Ok((Arc::clone(tree), has_normals && body.shading != Some(MeshShading::Flat)))
    }

    /// The memory that all of them take, in bytes. What several share counts once.
    pub fn memory(&self) -> u64 {
        let mut trees: Vec<&Arc<MeshTree>> = Vec::new();
        let mut meshes: Vec<&Arc<TriangleMesh>> = Vec::new();
        for GivenMesh { tree, .. } in &self.meshes {
            if !trees.iter().any(|other| Arc::ptr_eq(other, tree)) {
                trees.push(tree);
            }
            if !meshes.iter().any(|other| Arc::ptr_eq(other, tree.mesh())) {
                meshes.push(tree.mesh());
            }
        }
        trees.iter().map(|tree| tree.memory()).sum::<u64>() + meshes.iter().map(|mesh| mesh.memory()).sum::<u64>()
    }
}

//! The tree of nodes of a glTF document (glTF 2.0, chapter 3.5).

use crate::mesh::error::Fault;
use crate::mesh::gltf::document::{GltfDocument, GltfNode};
use glam::{DMat4, DQuat, DVec3};

/// A node of the file's scene, or a mesh of a file without nodes.
pub(super) struct PlacedNode {
    /// Its index; `None` in a file without nodes.
    pub(super) node: Option<usize>,
    /// Its mesh, with the transform of the mesh.
    pub(super) mesh: Option<(usize, DMat4)>,
    /// Its transform to world coordinates.
    pub(super) transform: DMat4,
}

/// Where a primitive stands in the document and in the world.
pub(super) struct PrimitivePlace {
    pub(super) node: Option<usize>,
    pub(super) mesh: usize,
    pub(super) number: usize,
    pub(super) transform: DMat4,
}

/// Gives each node of the scene, in the order of the file.
pub(super) fn for_each_node(document: &GltfDocument, mut give: impl FnMut(PlacedNode) -> Result<(), Fault>) -> Result<(), Fault> {
    let nodes = &document.nodes;
    if nodes.is_empty() && document.scenes.is_empty() {
        let transform = DMat4::IDENTITY;
        let alone = |mesh| PlacedNode { node: None, mesh: Some((mesh, transform)), transform };
        return (0..document.meshes.len()).try_for_each(|mesh| give(alone(mesh)));
    }
    let roots: Vec<usize> = match document.scenes.get(document.scene.unwrap_or(0)) {
        Some(scene) => scene.nodes.clone(),
        None if document.scenes.is_empty() => {
            let mut is_child = vec![false; nodes.len()];
            for child in nodes.iter().flat_map(|node| &node.children) {
                if let Some(place) = is_child.get_mut(*child) {
                    *place = true;
                }
            }
            (0..nodes.len()).filter(|node| !is_child[*node]).collect()
        }
        None => return Err(Fault::new(format!("the file has {} scenes, and `scene` names none of them", document.scenes.len()))),
    };
    let mut visited = vec![false; nodes.len()];
    let mut waiting: Vec<(usize, DMat4)> = roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((place, parent)) = waiting.pop() {
        let Some(node) = nodes.get(place) else {
            return Err(Fault::new(format!("there is no nodes[{place}]: the file has {}", nodes.len())));
        };
        if std::mem::replace(&mut visited[place], true) {
            return Err(Fault::new(format!("nodes[{place}] stands twice in the tree of nodes")));
        }
        let transform = parent * local_transform(node);
        // The joints of a skin move its mesh, not the node (glTF 2.0, chapter 3.7.3.3).
        let mesh = node.mesh.map(|mesh| (mesh, if node.skin.is_some() { DMat4::IDENTITY } else { transform }));
        give(PlacedNode { node: Some(place), mesh, transform })?;
        waiting.extend(node.children.iter().rev().map(|child| (*child, transform)));
    }
    Ok(())
}

fn local_transform(node: &GltfNode) -> DMat4 {
    if let Some(matrix) = &node.matrix {
        return DMat4::from_cols_array(matrix);
    }
    let rotation = node.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    let scale = node.scale.map_or(DVec3::ONE, DVec3::from_array);
    let translation = node.translation.map_or(DVec3::ZERO, DVec3::from_array);
    DMat4::from_scale_rotation_translation(scale, rotation, translation)
}

//! The camera and the lights of a glTF file in world coordinates, and the names and materials of its parts.

use crate::mesh::error::Fault;
use crate::mesh::gltf::document::GltfDocument;
use crate::mesh::gltf::looks::{GltfCamera, GltfLightKind, GltfLooks};
use crate::mesh::gltf::nodes::{PlacedNode, PrimitivePlace, for_each_node};
use crate::mesh::model::{LightSource, ModelCamera, ModelContents, ModelLight};
use crate::mesh::triangle_mesh::is_coordinate;
use glam::{DMat4, DVec3};

/// All but the parts.
pub(super) fn read(document: &GltfDocument, looks: &GltfLooks) -> Result<ModelContents, Fault> {
    let mut contents = ModelContents { materials: looks.materials(), omissions: looks.omissions(), ..ModelContents::default() };
    let (mut more, mut parallel) = (0, 0);
    for_each_node(document, |PlacedNode { node, transform, .. }| {
        let Some(node) = node else { return Ok(()) };
        if let Some(light) = looks.light_of(node)? {
            let source = match light.kind {
                GltfLightKind::Point => LightSource::Point(point(&transform, node, "light")?),
                GltfLightKind::Spot => LightSource::Spot {
                    place: point(&transform, node, "light")?,
                    direction: forward(&transform, node, "light")?,
                    angles: [light.spot.inner_cone_angle, light.spot.outer_cone_angle],
                },
                GltfLightKind::Directional => LightSource::Directional(forward(&transform, node, "light")?),
            };
            let of_node = || looks.nodes.get(node).map(|node| node.name.clone()).unwrap_or_default();
            let name = if light.name.is_empty() { of_node() } else { light.name.clone() };
            contents.lights.push(ModelLight { name, source, color: light.color, intensity: light.intensity });
        }
        let Some(camera) = looks.nodes.get(node).and_then(|node| node.camera) else { return Ok(()) };
        let Some(found) = looks.cameras.get(camera) else {
            return Err(Fault::new(format!("nodes[{node}] has the camera {camera}: the file has {}", looks.cameras.len())));
        };
        match placed(found, &transform, node)? {
            Some(placed) if contents.camera.is_none() => contents.camera = Some(placed),
            Some(_) => more += 1,
            None => parallel += 1,
        }
        Ok(())
    })?;
    contents.omissions.add(more, "other camera(s)", "the first one is used");
    contents.omissions.add(parallel, "camera(s) without perspective", "");
    Ok(contents)
}

/// The camera of a node; `None` if its view is no perspective of an angle below 180 degrees.
fn placed(camera: &GltfCamera, transform: &DMat4, node: usize) -> Result<Option<ModelCamera>, Fault> {
    let fov = |yfov: f64| Some(yfov.to_degrees()).filter(|fov| *fov > 0.0 && *fov < 180.0);
    let Some((view, fov)) = camera.perspective.as_ref().and_then(|view| Some((view, fov(view.yfov)?))) else { return Ok(None) };
    Ok(Some(ModelCamera {
        position: point(transform, node, "camera")?,
        gaze: forward(transform, node, "camera")?,
        up: direction(transform, DVec3::Y, node, "camera")?,
        fov,
        aspect: view.aspect_ratio.filter(|aspect| *aspect > 0.0 && aspect.is_finite()),
    }))
}

/// Where a node is.
fn point(transform: &DMat4, node: usize, what: &str) -> Result<DVec3, Fault> {
    let place = transform.w_axis.truncate();
    if place.to_array().into_iter().all(is_coordinate) { Ok(place) } else { Err(nowhere(node, what)) }
}

/// Where cameras and lights of a node look: along their negative z axis.
fn forward(transform: &DMat4, node: usize, what: &str) -> Result<DVec3, Fault> {
    direction(transform, DVec3::NEG_Z, node, what)
}

fn direction(transform: &DMat4, axis: DVec3, node: usize, what: &str) -> Result<DVec3, Fault> {
    transform.transform_vector3(axis).try_normalize().ok_or_else(|| nowhere(node, what))
}

fn nowhere(node: usize, what: &str) -> Fault {
    Fault::new(format!("the transform of nodes[{node}] gives its {what} no place or no direction"))
        .help("a scale of it may be 0, or a number too large")
}

/// What a primitive is called, and its material: an index below `materials`.
pub(super) fn name_and_material(
    looks: &GltfLooks,
    place: &PrimitivePlace,
    materials: usize,
) -> Result<(String, Option<usize>), Fault> {
    let mesh = looks.meshes.get(place.mesh);
    let primitive = mesh.and_then(|mesh| mesh.primitives.get(place.number));
    let material = primitive.and_then(|primitive| primitive.material);
    if let Some(wrong) = material.filter(|material| *material >= materials) {
        return Err(Fault::new(format!("there is no materials[{wrong}]: the file has {materials}")));
    }
    let names = [place.node.and_then(|node| looks.nodes.get(node)).map(|node| &node.name), mesh.map(|mesh| &mesh.name)];
    let name = names.into_iter().flatten().find(|name| !name.is_empty()).cloned().unwrap_or_default();
    Ok((name, material))
}

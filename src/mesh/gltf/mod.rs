//! glTF 2.0 files, as JSON or in a binary container (GLB).
//!
//! [`read`] makes one mesh of all meshes of the file's scene, with the transforms of their nodes. [`read_model`] keeps
//! them apart, with materials, camera and lights. Animations are passed over; skins and morph targets are not applied.

mod accessor;
mod container;
mod document;
mod looks;
mod nodes;
mod scenery;
#[cfg(test)]
pub(super) mod tests;
mod textures;

use crate::mesh::MeshFile;
use crate::mesh::error::{Fault, Places};
use crate::mesh::ledger::Ledger;
use crate::mesh::model::{ModelContents, PartContents};
use crate::mesh::triangle_mesh::{MeshParts, is_coordinate, wrong_coordinate};
use crate::mesh::weld::index;
use accessor::Accessors;
use container::Container;
use document::{GltfDocument, GltfPrimitive};
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};
use looks::GltfLooks;
use nodes::{PlacedNode, PrimitivePlace, for_each_node};
use std::collections::BTreeSet;
use textures::ImageReader;

/// Reads a file.
pub(super) fn read(file: &MeshFile, ledger: &mut Ledger) -> Result<MeshParts, Fault> {
    let container = Container::split(file)?;
    let document = GltfDocument::read(container.json, container.json_start, ledger)?;
    let buffers = container.buffers(&document, file.path, ledger)?;
    let accessors = Accessors { document: &document, buffers: &buffers };
    let mut parts = MeshParts::default();
    for_each_primitive(&document, ledger, |place, primitive, ledger| {
        add(primitive, &accessors, &place.transform, &mut parts, ledger)
    })?;
    // Meshes without normals or surface coordinates may follow others.
    let count = parts.positions.len();
    pad(&mut parts.normals, count, Vec3::ZERO, ledger)?;
    pad(&mut parts.uvs, count, Vec2::ZERO, ledger)?;
    Ok(parts)
}

/// Reads a file as parts: the primitives of the mesh of each node.
pub(super) fn read_model(file: &MeshFile, ledger: &mut Ledger) -> Result<ModelContents, Fault> {
    let container = Container::split(file)?;
    let document = GltfDocument::read(container.json, container.json_start, ledger)?;
    let looks = GltfLooks::read(container.json, container.json_start, ledger)?;
    let buffers = container.buffers(&document, file.path, ledger)?;
    let accessors = Accessors { document: &document, buffers: &buffers };
    let mut contents = scenery::read(&document, &looks)?;
    let mut images = ImageReader::new(looks.textures(), file, &document, &buffers);
    let mut asked = BTreeSet::new();
    for_each_primitive(&document, ledger, |place, primitive, ledger| {
        let mut parts = MeshParts::default();
        add(primitive, &accessors, &place.transform, &mut parts, ledger)?;
        if parts.triangles.is_empty() {
            contents.omissions.add(1, "part(s) of points or lines", "");
            return Ok(());
        }
        let (name, material) = scenery::name_and_material(&looks, place, contents.materials.len())?;
        if let Some((material, texture)) = material.and_then(|material| Some((material, looks.base_texture(material)?))) {
            if !asked.contains(&material) {
                asked.insert(material);
                contents.materials[material].image = images.image_of(texture, &mut contents.omissions, ledger)?;
            }
            if let Some(transform) = texture.transform() {
                parts.uvs.iter_mut().for_each(|uv| *uv = transform.apply(*uv));
            }
        }
        // The names of nodes may be long, and stand at several primitives.
        ledger.charge(name.len() as u64)?;
        ledger.push(&mut contents.parts, PartContents { name, material, is_smooth: false, parts })
    })?;
    contents.images = images.found.images;
    Ok(contents)
}

/// A container tells places by bytes.
pub(super) fn places(file: &MeshFile, _: usize) -> Places {
    if container::is_binary(file.bytes) { Places::Offsets } else { Places::Lines }
}

/// Gives the primitives of all meshes of the scene.
fn for_each_primitive(
    document: &GltfDocument,
    ledger: &mut Ledger,
    mut give: impl FnMut(&PrimitivePlace, &GltfPrimitive, &mut Ledger) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut done = 0;
    for_each_node(document, |PlacedNode { node, mesh, .. }| {
        let Some((mesh, transform)) = mesh else { return Ok(()) };
        let Some(found) = document.meshes.get(mesh) else {
            return Err(Fault::new(format!("there is no meshes[{mesh}]: the file has {}", document.meshes.len())));
        };
        for (number, primitive) in found.primitives.iter().enumerate() {
            ledger.tell_parsing(done, document.meshes.len())?;
            let place = PrimitivePlace { node, mesh, number, transform };
            give(&place, primitive, ledger).map_err(|fault| fault.within(&format!("meshes[{mesh}].primitives[{number}]")))?;
        }
        // A mesh may stand at several nodes.
        done = (done + 1).min(document.meshes.len());
        Ok(())
    })
}

/// Adds the triangles of a primitive; points and lines have none.
fn add(
    primitive: &GltfPrimitive,
    accessors: &Accessors,
    transform: &DMat4,
    parts: &mut MeshParts,
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    let mode = primitive.mode.unwrap_or(4);
    if mode < 4 {
        return Ok(());
    }
    let Some(position) = primitive.attributes.position else { return Ok(()) };
    let first = parts.positions.len();
    let count = accessors.count(position)?;
    index(first.saturating_add(count))?;
    extend(&mut parts.positions, first + count, DVec3::ZERO, ledger)?;
    accessors.each(position, |number, coordinates: [f64; 3]| {
        ledger.check(number)?;
        let moved = transform.transform_point3(DVec3::from_array(coordinates));
        if let Some(wrong) = moved.to_array().into_iter().find(|coordinate| !is_coordinate(*coordinate)) {
            return Err(Fault::new(format!("vertex {number}: {}", wrong_coordinate(wrong))));
        }
        parts.positions[first + number] = moved;
        Ok(())
    })?;
    let linear = DMat3::from_mat4(*transform);
    let mirrors = linear.determinant() < 0.0;
    if let Some(normal) = primitive.attributes.normal {
        same_count(accessors, normal, count)?;
        // Normals stay perpendicular under the inverse of the transposed matrix, here without its scale.
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear;
        let turn = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * if mirrors { -1.0 } else { 1.0 };
        extend(&mut parts.normals, first + count, Vec3::ZERO, ledger)?;
        accessors.each(normal, |number, normal: [f64; 3]| {
            let turned = (turn * DVec3::from_array(normal)).try_normalize().unwrap_or(DVec3::ZERO);
            parts.normals[first + number] = turned.as_vec3();
            Ok(())
        })?;
    }
    if let Some(uv) = primitive.attributes.uv {
        same_count(accessors, uv, count)?;
        extend(&mut parts.uvs, first + count, Vec2::ZERO, ledger)?;
        accessors.each(uv, |number, uv: [f64; 2]| {
            // In glTF files v goes down from the upper edge of the image (glTF 2.0, chapter 3.8.1).
            parts.uvs[first + number] = Vec2::new(uv[0] as f32, (1.0 - uv[1]) as f32);
            Ok(())
        })?;
    }
    let mut corners = Vec::new();
    match primitive.indices {
        Some(indices) => {
            ledger.reserve(&mut corners, accessors.count(indices)?)?;
            accessors.each_index(indices, |vertex| {
                if vertex as usize >= count {
                    return Err(Fault::new(format!("there is no vertex {vertex}: there are {count}")));
                }
                ledger.push(&mut corners, first as u32 + vertex)
            })?;
        }
        None => {
            ledger.reserve(&mut corners, count)?;
            corners.extend((0..count).map(|vertex| (first + vertex) as u32));
        }
    }
    add_triangles(mode, &corners, mirrors, &mut parts.triangles, ledger)?;
    ledger.release(corners);
    Ok(())
}

/// Adds triangles of corners in a mode: a list of triangles, a strip or a fan.
fn add_triangles(
    mode: u32,
    corners: &[u32],
    mirrors: bool,
    triangles: &mut Vec<[u32; 3]>,
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    let mut push = |[a, b, c]: [u32; 3]| ledger.push(triangles, if mirrors { [a, c, b] } else { [a, b, c] });
    match mode {
        4 => {
            let (whole, rest) = corners.as_chunks();
            if !rest.is_empty() {
                return Err(Fault::new(format!("{} corners are not three for each triangle", corners.len())));
            }
            whole.iter().try_for_each(|triangle| push(*triangle))
        }
        5 => corners.windows(3).enumerate().try_for_each(|(number, three)| match number % 2 {
            0 => push([three[0], three[1], three[2]]),
            _ => push([three[1], three[0], three[2]]),
        }),
        6 => (2..corners.len()).try_for_each(|last| push([corners[0], corners[last - 1], corners[last]])),
        _ => Err(Fault::new(format!("the mode {mode} is not known")).help("4 is triangles, 5 a strip and 6 a fan")),
    }
}

fn same_count(accessors: &Accessors, index: usize, count: usize) -> Result<(), Fault> {
    match accessors.count(index)? {
        same if same == count => Ok(()),
        other => Err(Fault::new(format!("accessors[{index}] has {other} elements for {count} vertices"))),
    }
}

/// Lengthens a list.
fn extend<T: Clone>(list: &mut Vec<T>, length: usize, element: T, ledger: &mut Ledger) -> Result<(), Fault> {
    let more = length.saturating_sub(list.len());
    // Many small meshes do not copy the list each time.
    let more = if more > list.capacity() - list.len() { more.max(list.capacity()) } else { more };
    ledger.reserve(list, more)?;
    list.resize(length.max(list.len()), element);
    Ok(())
}

/// Lengthens a list that is not empty.
fn pad<T: Clone>(list: &mut Vec<T>, length: usize, element: T, ledger: &mut Ledger) -> Result<(), Fault> {
    if list.is_empty() { Ok(()) } else { extend(list, length, element, ledger) }
}

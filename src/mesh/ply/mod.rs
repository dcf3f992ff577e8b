//! PLY files (Polygon File Format, Turk 1994): a header that says what each record has, and records as text or binary.
//!
//! The elements `vertex`, `face` and `tristrips` are read, and all others are passed over.
//! [`write_ply`] writes meshes.

mod header;
mod values;
mod write;

use crate::mesh::error::{Fault, Places};
use crate::mesh::ledger::Ledger;
use crate::mesh::polygon::triangulate;
use crate::mesh::triangle_mesh::{MeshParts, is_coordinate, wrong_coordinate};
use crate::mesh::{MeshFile, count_behind};
use glam::{DVec3, Vec2, Vec3};
use header::{ElementHeader, Encoding, PlyHeader};
use values::PlyValues;
pub use write::write_ply;

/// The names of a vertex's values: position, normal, and surface coordinates in the ways of different programs.
const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
const UVS: [[&str; 2]; 5] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"], ["s0", "t0"]];
/// The names of the list of a face's vertices.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads a file.
pub(super) fn read(file: &MeshFile, ledger: &mut Ledger) -> Result<MeshParts, Fault> {
    let header = PlyHeader::read(file.bytes, ledger)?;
    let mut parts = MeshParts::default();
    let mut values = PlyValues::new(file.bytes, header.end, header.encoding);
    // Faces may stand before the vertices.
    let vertices = header.elements.iter().filter(|element| element.name == "vertex").map(|element| element.count).sum();
    for element in header.elements.iter().filter(|element| !element.properties.is_empty()) {
        values.check_place(element)?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut values, &mut parts, ledger)?,
            "face" => read_faces(element, &mut values, vertices, &mut parts, ledger)?,
            "tristrips" => read_strips(element, &mut values, vertices, &mut parts, ledger)?,
            _ => {
                let mut list = Vec::new();
                for index in 0..element.count {
                    values.tell(index, ledger)?;
                    values.record(element, index, |_, _| Ok(()), &mut list, None, ledger)?;
                }
                ledger.release(list);
            }
        }
    }
    parts.bytes_behind = count_behind(&file.bytes[values.offset()..]);
    Ok(parts)
}

/// The header is a text, and the rest is what it says.
pub(super) fn places(file: &MeshFile, at: usize) -> Places {
    match header::end_and_encoding(file.bytes) {
        Some((end, Encoding::Little | Encoding::Big)) if at >= end => Places::Offsets,
        Some(_) | None => Places::Lines,
    }
}

fn read_vertices(
    element: &ElementHeader,
    values: &mut PlyValues,
    parts: &mut MeshParts,
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    let Some(position) = element.places(POSITION) else {
        return Err(Fault::at(element.at.clone(), "a vertex has no position: the properties x, y and z are missing"));
    };
    let normal = element.places(NORMAL);
    let uv = UVS.into_iter().find_map(|names| element.places(names));
    let count = element.count as usize;
    ledger.reserve(&mut parts.positions, count)?;
    ledger.reserve(&mut parts.normals, if normal.is_some() { count } else { 0 })?;
    ledger.reserve(&mut parts.uvs, if uv.is_some() { count } else { 0 })?;
    let mut record = vec![0.0; element.properties.len()];
    let mut list = Vec::new();
    for index in 0..element.count {
        values.tell(index, ledger)?;
        let start = values.offset();
        let store = |property: usize, value: f64| {
            record[property] = value;
            if position.contains(&property) && !is_coordinate(value) {
                return Err(Fault::new(wrong_coordinate(value)));
            }
            Ok(())
        };
        values.record(element, index, store, &mut list, None, ledger).map_err(|fault| fault.or_at(values.since(start)))?;
        ledger.push(&mut parts.positions, DVec3::from_array(position.map(|place| record[place])))?;
        if let Some(normal) = normal {
            ledger.push(&mut parts.normals, Vec3::from_array(normal.map(|place| record[place] as f32)))?;
        }
        if let Some(uv) = uv {
            ledger.push(&mut parts.uvs, Vec2::from_array(uv.map(|place| record[place] as f32)))?;
        }
    }
    Ok(())
}

fn read_faces(
    element: &ElementHeader,
    values: &mut PlyValues,
    vertices: u64,
    parts: &mut MeshParts,
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    let corners = element.list(CORNERS).ok_or_else(|| no_corners(element))?;
    ledger.reserve(&mut parts.triangles, element.count as usize)?;
    let (mut list, mut outline) = (Vec::new(), Vec::new());
    for index in 0..element.count {
        values.tell(index, ledger)?;
        let start = values.offset();
        values.record(element, index, |_, _| Ok(()), &mut list, Some(corners), ledger)?;
        let place = |fault: Fault, values: &PlyValues| fault.or_at(values.since(start));
        for corner in &list {
            vertex(*corner, vertices).map_err(|fault| place(fault, values))?;
        }
        if list.len() == 3 {
            ledger.push(&mut parts.triangles, [0, 1, 2].map(|corner| list[corner] as u32))?;
            continue;
        }
        outline.clear();
        for corner in &list {
            // Faces that stand before their vertices are cut as if they were convex.
            let position = parts.positions.get(*corner as usize).copied().unwrap_or(DVec3::ZERO);
            ledger.push(&mut outline, position)?;
        }
        let mut outcome = Ok(());
        let cut = triangulate(&outline, |triangle| {
            if outcome.is_ok() {
                outcome = ledger.push(&mut parts.triangles, triangle.map(|corner| list[corner] as u32));
            }
        });
        outcome?;
        cut.map_err(|error| error.at(values.since(start)))?;
    }
    ledger.release(list);
    ledger.release(outline);
    Ok(())
}

/// Strips of triangles: each vertex makes a triangle with the two before it, and -1 begins a new strip.
fn read_strips(
    element: &ElementHeader,
    values: &mut PlyValues,
    vertices: u64,
    parts: &mut MeshParts,
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    let corners = element.list(CORNERS).ok_or_else(|| no_corners(element))?;
    let mut list = Vec::new();
    for index in 0..element.count {
        let start = values.offset();
        values.record(element, index, |_, _| Ok(()), &mut list, Some(corners), ledger)?;
        let mut before = 0;
        for place in 0..list.len() {
            values.tell(place as u64, ledger)?;
            if list[place] == -1.0 {
                before = 0;
                continue;
            }
            let last = vertex(list[place], vertices).map_err(|fault| fault.or_at(values.since(start)))?;
            if before >= 2 {
                let [one, two] = [list[place - 2] as u32, list[place - 1] as u32];
                // Every second triangle of a strip goes the other way round.
                let triangle = if before % 2 == 0 { [one, two, last] } else { [two, one, last] };
                ledger.push(&mut parts.triangles, triangle)?;
            }
            before += 1;
        }
    }
    ledger.release(list);
    Ok(())
}

fn no_corners(element: &ElementHeader) -> Fault {
    Fault::at(element.at.clone(), format!("the element `{}` has no list `vertex_indices`", element.name))
}

/// The index of a vertex.
fn vertex(number: f64, vertices: u64) -> Result<u32, Fault> {
    if number >= 0.0 && number < vertices as f64 && number.fract() == 0.0 && number < f64::from(u32::MAX) {
        return Ok(number as u32);
    }
    Err(Fault::new(format!("there is no vertex {number}: the file has {vertices}")).help("the indices of vertices count from 0"))
}

//! Triangles that share vertices, checked.

use crate::mesh::error::{Fault, MeshError, Places};
use crate::mesh::ledger::{Ledger, PARSING, Reading};
use crate::mesh::normals::{angle_weighted, front_normal};
use glam::{DVec3, Vec2, Vec3};
use std::ops::Add;

/// The largest coordinate of a vertex.
pub const LARGEST_COORDINATE: f64 = 1e30;

/// What a mesh is made of. The corners of triangles go counter-clockwise seen from the front, as in files.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshParts {
    /// The positions of the vertices.
    pub positions: Vec<DVec3>,
    /// None, or a normal for each vertex. It may have any length; 0 stands for none.
    pub normals: Vec<Vec3>,
    /// None, or surface coordinates for each vertex, with v upwards.
    pub uvs: Vec<Vec2>,
    /// Three vertices for each triangle, as indices of positions.
    pub triangles: Vec<[u32; 3]>,
    /// The bytes of the file behind the records that it counts. They are not read.
    pub bytes_behind: u64,
}

/// Triangles that share vertices.
///
/// The corners of each triangle go *clockwise seen from the front*, as those of every surface of a scene: the front
/// normal of the triangle ABC is normalize((C − A) × (B − A)). Files have them counter-clockwise and were turned.
///
/// There is at least one triangle, each has an area, every vertex is part of one, coordinates are finite, and normals
/// have unit length.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleMesh {
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
}

/// What was left out or replaced when a mesh was made. The picture is right; the file is not quite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MeshRepairs {
    /// Triangles without area, which were dropped.
    pub degenerate_triangles: u64,
    /// Vertices without a usable normal beside others that have one. They got the mean of the normals of their
    /// triangles.
    pub missing_normals: u64,
    /// Surface coordinates that are infinite or not a number. They became 0.
    pub unusable_uvs: u64,
    /// Bytes of the file behind the records that it counts. They were left out.
    pub bytes_behind: u64,
}

impl MeshParts {
    /// Whether any triangle has an area.
    pub(super) fn has_area(&self) -> bool {
        let corner = |vertex: u32| self.positions.get(vertex as usize).copied().unwrap_or(DVec3::ZERO);
        self.triangles.iter().any(|triangle| front_normal(triangle.map(corner)).is_some())
    }
}

impl Add for MeshRepairs {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            degenerate_triangles: self.degenerate_triangles + other.degenerate_triangles,
            missing_normals: self.missing_normals + other.missing_normals,
            unusable_uvs: self.unusable_uvs + other.unusable_uvs,
            bytes_behind: self.bytes_behind + other.bytes_behind,
        }
    }
}

impl TriangleMesh {
    /// A mesh from its parts, which are checked. `name` stands in messages.
    ///
    /// # Errors
    /// A coordinate is not finite or too large, an index is out of range, no triangle has an area, there is not a
    /// normal for each vertex, the memory does not suffice, or the work was cancelled.
    pub fn new(name: &str, parts: MeshParts, reading: &Reading) -> Result<(Self, MeshRepairs), MeshError> {
        Self::complete(parts, &mut Ledger::new(reading)).map_err(|fault| fault.in_file(name, &[], |_| Places::Offsets))
    }

    /// Checks the parts, turns the triangles, drops what nothing uses, and completes the normals.
    pub(super) fn complete(parts: MeshParts, ledger: &mut Ledger) -> Result<(Self, MeshRepairs), Fault> {
        check(&parts)?;
        ledger.tell(PARSING.0 + PARSING.1)?;
        let MeshParts { mut positions, mut normals, mut uvs, mut triangles, bytes_behind } = parts;
        let mut repairs = MeshRepairs { bytes_behind, ..MeshRepairs::default() };
        let count = triangles.len();
        triangles.retain_mut(|triangle| {
            triangle.swap(1, 2);
            front_normal(triangle.map(|vertex| positions[vertex as usize])).is_some()
        });
        if triangles.is_empty() {
            return Err(match count {
                0 => Fault::new("it has no triangles").help("a mesh needs faces; points, lines and curves are not drawn"),
                1 => Fault::new("its only triangle has no area"),
                _ => Fault::new(format!("none of its {count} triangles has an area")),
            });
        }
        repairs.degenerate_triangles = (count - triangles.len()) as u64;
        drop_unused(&mut positions, &mut normals, &mut uvs, &mut triangles, ledger)?;
        ledger.tell(0.85)?;
        for uv in uvs.iter_mut().filter(|uv| !uv.is_finite()) {
            *uv = Vec2::ZERO;
            repairs.unusable_uvs += 1;
        }
        let mut missing = 0;
        for normal in &mut normals {
            *normal = unit(*normal);
            missing += usize::from(*normal == Vec3::ZERO);
        }
        if missing == normals.len() {
            normals = Vec::new();
        } else if missing > 0 {
            let computed = angle_weighted(&positions, &triangles, ledger)?;
            for (normal, computed) in normals.iter_mut().zip(&computed).filter(|(normal, _)| **normal == Vec3::ZERO) {
                *normal = *computed;
            }
            ledger.release(computed);
            repairs.missing_normals = missing as u64;
        }
        ledger.tell(1.0)?;
        Ok((Self { positions, normals, uvs, triangles }, repairs))
    }

    /// The same mesh with a normal for each vertex: those of the file, or else the mean of the normals of the triangles
    /// around it, weighted by their angles.
    ///
    /// # Errors
    /// The memory does not suffice. `name` stands in the message.
    pub fn smooth(self, name: &str, reading: &Reading) -> Result<Self, MeshError> {
        self.smoothed(&mut Ledger::new(reading)).map_err(|fault| fault.in_file(name, &[], |_| Places::Offsets))
    }

    /// The same mesh with a normal for each vertex, see [`smooth`](Self::smooth).
    pub(super) fn smoothed(mut self, ledger: &mut Ledger) -> Result<Self, Fault> {
        if self.normals.is_empty() {
            self.normals = angle_weighted(&self.positions, &self.triangles, ledger)?;
        }
        Ok(self)
    }

    /// The positions of the vertices.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The unit normals of the vertices, towards the front; empty if the file has none.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// The surface coordinates of the vertices, with v upwards; empty if the file has none.
    pub fn uvs(&self) -> &[Vec2] {
        &self.uvs
    }

    /// The triangles as indices of vertices, clockwise seen from the front.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of the smallest box along the axes that holds the mesh: the lowest coordinates and the highest ones.
    pub fn bounding_box(&self) -> [DVec3; 2] {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.positions.iter().fold(start, |[low, high], position| [low.min(*position), high.max(*position)])
    }

    /// The memory that the mesh takes, in bytes.
    pub fn memory(&self) -> u64 {
        let sizes = [size_of_val(&*self.positions), size_of_val(&*self.normals), size_of_val(&*self.uvs)];
        (sizes.iter().sum::<usize>() + size_of_val(&*self.triangles)) as u64
    }
}

/// Whether a number can be a coordinate.
pub(super) fn is_coordinate(number: f64) -> bool {
    number.abs() <= LARGEST_COORDINATE
}

/// What is wrong with a number that cannot be a coordinate.
pub(super) fn wrong_coordinate(number: f64) -> String {
    if number.is_finite() {
        format!("the coordinate {number:e} is too large: {LARGEST_COORDINATE:e} is the largest")
    } else {
        format!("a coordinate is {}", if number.is_nan() { "not a number" } else { "infinite" })
    }
}

/// Indices are in range, and coordinates are numbers. Readers have checked this with better messages.
fn check(parts: &MeshParts) -> Result<(), Fault> {
    let count = parts.positions.len();
    for list in [parts.normals.len(), parts.uvs.len()] {
        if list != 0 && list != count {
            return Err(Fault::new(format!("{list} normals or surface coordinates for {count} vertices")));
        }
    }
    let mut coordinates = parts.positions.iter().flat_map(|position| position.to_array());
    if let Some(number) = coordinates.find(|number| !is_coordinate(*number)) {
        return Err(Fault::new(wrong_coordinate(number)));
    }
    match parts.triangles.iter().flatten().find(|vertex| **vertex as usize >= count) {
        Some(vertex) => Err(Fault::new(format!("a triangle has the vertex {vertex}, but there are only {count}"))),
        None => Ok(()),
    }
}

/// A vector at unit length; 0 where it has no direction.
fn unit(vector: Vec3) -> Vec3 {
    let long = vector.as_dvec3();
    long.try_normalize().map_or(Vec3::ZERO, |unit| unit.as_vec3())
}

/// Drops vertices that are part of no triangle, so that they do not enlarge the bounding box.
fn drop_unused(
    positions: &mut Vec<DVec3>,
    normals: &mut Vec<Vec3>,
    uvs: &mut Vec<Vec2>,
    triangles: &mut [[u32; 3]],
    ledger: &mut Ledger,
) -> Result<(), Fault> {
    const UNUSED: u32 = u32::MAX;
    let mut places = Vec::new();
    ledger.reserve(&mut places, positions.len())?;
    places.resize(positions.len(), UNUSED);
    triangles.iter().flatten().for_each(|vertex| places[*vertex as usize] = 0);
    let mut count = 0;
    for place in places.iter_mut().filter(|place| **place != UNUSED) {
        *place = count;
        count += 1;
    }
    if (count as usize) < positions.len() {
        retain_used(positions, &places, UNUSED);
        retain_used(normals, &places, UNUSED);
        retain_used(uvs, &places, UNUSED);
        triangles.iter_mut().flatten().for_each(|vertex| *vertex = places[*vertex as usize]);
    }
    ledger.release(places);
    Ok(())
}

fn retain_used<T>(list: &mut Vec<T>, places: &[u32], unused: u32) {
    let mut places = places.iter();
    list.retain(|_| places.next().is_some_and(|place| *place != unused));
}

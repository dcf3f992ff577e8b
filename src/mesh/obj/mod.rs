//! Wavefront OBJ files: texts with positions, texture coordinates, normals and polygons.
//!
//! [`read`] makes one mesh of all objects and groups. [`read_model`] keeps them apart by material. Lines, points and
//! curves are passed over.

mod mtl;
mod parts;
#[cfg(test)]
mod tests;

use crate::mesh::MeshFile;
use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use crate::mesh::model::ModelContents;
use crate::mesh::polygon::triangulate;
use crate::mesh::text::{TextCursor, TextWord};
use crate::mesh::triangle_mesh::MeshParts;
use crate::mesh::weld::index;
use glam::{DVec3, Vec2, Vec3};
use parts::ObjParts;

/// Stands for no index.
const NONE: u32 = u32::MAX;

/// A vertex of the mesh: indices of a position, of texture coordinates and of a normal, and the next vertex with the
/// same position.
struct ObjVertex {
    position: u32,
    uv: u32,
    normal: u32,
    next: u32,
}

/// What has been read.
#[derive(Default)]
struct ObjContents {
    positions: Vec<DVec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// For each position, the first vertex at it.
    first: Vec<u32>,
    vertices: Vec<ObjVertex>,
    triangles: Vec<[u32; 3]>,
    /// The polygon that is being read.
    corners: Vec<u32>,
    outline: Vec<DVec3>,
}

/// Reads a file.
pub(super) fn read(file: &MeshFile, ledger: &mut Ledger) -> Result<MeshParts, Fault> {
    let mut contents = ObjContents::default();
    read_lines(file, ledger, |keyword, cursor, ledger| contents.read_line(keyword, cursor, ledger))?;
    contents.into_parts(ledger)
}

/// Reads a file as parts: the faces of each object or group with one material.
pub(super) fn read_model(file: &MeshFile, ledger: &mut Ledger) -> Result<ModelContents, Fault> {
    let (mut contents, mut parts) = (ObjContents::default(), ObjParts::default());
    read_lines(file, ledger, |keyword, cursor, ledger| {
        parts.read_line(keyword, cursor.clone(), contents.triangles.len(), ledger)?;
        contents.read_line(keyword, cursor, ledger)
    })?;
    parts.into_model(contents, file.path, ledger)
}

/// Gives the keyword of each line, and what is behind it.
fn read_lines(
    file: &MeshFile,
    ledger: &mut Ledger,
    mut give: impl FnMut(&TextWord, &mut TextCursor, &mut Ledger) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut cursor = TextCursor::new(file.bytes, file.text_start());
    let mut line = 0;
    while !cursor.is_at_end() {
        ledger.tell_record(line, cursor.offset(), file.bytes.len())?;
        if let Some(keyword) = cursor.word_in_line() {
            give(&keyword, &mut cursor, ledger)?;
        }
        cursor.skip_line();
        line += 1;
    }
    Ok(())
}

impl ObjContents {
    fn read_line(&mut self, keyword: &TextWord, cursor: &mut TextCursor, ledger: &mut Ledger) -> Result<(), Fault> {
        match keyword.bytes {
            b"v" => {
                let [x, y, z] = three(keyword, cursor, "a position has three coordinates", |word| word.coordinate())?;
                ledger.push(&mut self.first, NONE)?;
                ledger.push(&mut self.positions, DVec3::new(x, y, z))
            }
            b"vn" => {
                let normal = three(keyword, cursor, "a normal has three components", |word| word.number())?;
                ledger.push(&mut self.normals, Vec3::from_array(normal.map(|number| number as f32)))
            }
            b"vt" => {
                let missing = || Fault::at(keyword.at.clone(), "`vt` has no texture coordinate after it");
                let u = cursor.word_in_line().ok_or_else(missing)?.number()?;
                let v = cursor.word_in_line().map_or(Ok(0.0), |word| word.number())?;
                ledger.push(&mut self.uvs, Vec2::new(u as f32, v as f32))
            }
            b"f" | b"fo" => self.read_face(keyword, cursor, ledger),
            _ if keyword.bytes[0] == b'#' || keyword.bytes.iter().all(|byte| byte.is_ascii_graphic()) => Ok(()),
            _ => Err(Fault::at(keyword.at.clone(), format!("`{}` begins no line of an OBJ file", keyword.shown()))
                .help("the file is damaged, or of another format than its suffix says")),
        }
    }

    fn read_face(&mut self, keyword: &TextWord, cursor: &mut TextCursor, ledger: &mut Ledger) -> Result<(), Fault> {
        self.corners.clear();
        self.outline.clear();
        while let Some(word) = cursor.word_in_line() {
            if word.bytes[0] == b'#' {
                break;
            }
            let vertex = self.corner(&word, ledger)?;
            ledger.push(&mut self.corners, vertex)?;
            let position = self.positions[self.vertices[vertex as usize].position as usize];
            ledger.push(&mut self.outline, position)?;
        }
        if self.corners.len() < 3 {
            let count = self.corners.len();
            let message = format!("a face has at least three corners, and this one has {count}");
            return Err(Fault::at(keyword.at.start..cursor.offset(), message)
                .help("the line may be cut off; lines and points begin with `l` and `p`"));
        }
        let (corners, triangles) = (&self.corners, &mut self.triangles);
        let mut outcome = Ok(());
        let cut = triangulate(&self.outline, |triangle| {
            if outcome.is_ok() {
                outcome = ledger.push(triangles, triangle.map(|corner| corners[corner]));
            }
        });
        outcome?;
        cut.map_err(|error| error.at(keyword.at.start..cursor.offset()))
    }

    /// The vertex for a corner `POSITION`, `POSITION/UV`, `POSITION//NORMAL` or `POSITION/UV/NORMAL`.
    fn corner(&mut self, word: &TextWord, ledger: &mut Ledger) -> Result<u32, Fault> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut indices = [NONE; 3];
        let mut start = word.at.start;
        for (which, part) in word.bytes.split(|byte| *byte == b'/').enumerate() {
            let part = TextWord { bytes: part, at: start..start + part.len() };
            start = part.at.end + 1;
            match (which, part.bytes.is_empty()) {
                (1.., true) => {}
                (0..3, _) => indices[which] = absolute(&part, which, counts[which])?,
                (_, _) => return Err(Fault::at(part.at, "a corner has at most three indices: position/uv/normal")),
            }
        }
        let [position, uv, normal] = indices;
        let mut known = self.first[position as usize];
        while known != NONE {
            let vertex = &self.vertices[known as usize];
            if (vertex.uv, vertex.normal) == (uv, normal) {
                return Ok(known);
            }
            known = vertex.next;
        }
        let new = index(self.vertices.len())?;
        let next = std::mem::replace(&mut self.first[position as usize], new);
        ledger.push(&mut self.vertices, ObjVertex { position, uv, normal, next })?;
        Ok(new)
    }

    fn into_parts(mut self, ledger: &mut Ledger) -> Result<MeshParts, Fault> {
        ledger.release(std::mem::take(&mut self.first));
        let mut parts = MeshParts { triangles: std::mem::take(&mut self.triangles), ..MeshParts::default() };
        self.fill(&self.vertices, &mut parts, ledger)?;
        self.release(ledger);
        Ok(parts)
    }

    /// Adds positions, normals and surface coordinates of these vertices.
    fn fill<'v>(
        &self,
        vertices: impl IntoIterator<Item = &'v ObjVertex, IntoIter: ExactSizeIterator + Clone>,
        parts: &mut MeshParts,
        ledger: &mut Ledger,
    ) -> Result<(), Fault> {
        let vertices = vertices.into_iter();
        let count = vertices.len();
        ledger.reserve(&mut parts.positions, count)?;
        parts.positions.extend(vertices.clone().map(|vertex| self.positions[vertex.position as usize]));
        if vertices.clone().any(|vertex| vertex.normal != NONE) {
            ledger.reserve(&mut parts.normals, count)?;
            let normal = |vertex: &ObjVertex| self.normals.get(vertex.normal as usize).copied().unwrap_or(Vec3::ZERO);
            parts.normals.extend(vertices.clone().map(normal));
        }
        if vertices.clone().any(|vertex| vertex.uv != NONE) {
            ledger.reserve(&mut parts.uvs, count)?;
            let uv = |vertex: &ObjVertex| self.uvs.get(vertex.uv as usize).copied().unwrap_or(Vec2::ZERO);
            parts.uvs.extend(vertices.map(uv));
        }
        Ok(())
    }

    /// Frees everything.
    fn release(self, ledger: &mut Ledger) {
        let Self { positions, uvs, normals, first, vertices, triangles, corners, outline } = self;
        ledger.release(positions);
        ledger.release(uvs);
        ledger.release(normals);
        ledger.release(first);
        ledger.release(vertices);
        ledger.release(triangles);
        ledger.release(corners);
        ledger.release(outline);
    }
}

/// Three numbers behind a keyword.
fn three(
    keyword: &TextWord,
    cursor: &mut TextCursor,
    expected: &str,
    read: impl Fn(&TextWord) -> Result<f64, Fault>,
) -> Result<[f64; 3], Fault> {
    let mut numbers = [0.0; 3];
    for number in &mut numbers {
        let Some(word) = cursor.word_in_line() else {
            return Err(Fault::at(keyword.at.start..cursor.offset(), format!("a number is missing: {expected}")));
        };
        *number = read(&word)?;
    }
    Ok(numbers)
}

/// The index from 0 that an index of a file means: it counts from 1, or if it is negative, back from the last one.
fn absolute(word: &TextWord, which: usize, count: usize) -> Result<u32, Fault> {
    const NOUNS: [&str; 3] = ["position", "texture coordinate", "normal"];
    let written: i64 = word.parse().ok_or_else(|| {
        Fault::at(word.at.clone(), format!("`{}` is not an index", word.shown()))
            .help("a corner is an index, or indices of a position, a texture coordinate and a normal: `1/2/3`")
    })?;
    let index = if written < 0 { (count as i64).checked_add(written) } else { written.checked_sub(1) };
    match index.and_then(|index| u32::try_from(index).ok()) {
        Some(index) if (index as usize) < count && index != NONE => Ok(index),
        Some(_) | None => {
            let noun = NOUNS[which];
            Err(Fault::at(word.at.clone(), format!("there is no {noun} {written}: {count} stand before this line"))
                .help("indices count from 1; negative ones count back from the last line before the face"))
        }
    }
}

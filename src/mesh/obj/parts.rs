//! The parts of an OBJ file: objects, groups, and the materials of their faces.

use crate::mesh::error::Fault;
use crate::mesh::images::ImageList;
use crate::mesh::ledger::Ledger;
use crate::mesh::model::{ModelContents, ModelMaterial, Omissions, PartContents};
use crate::mesh::obj::mtl::{self, MaterialLibraries, MtlMaterial};
use crate::mesh::obj::{NONE, ObjContents};
use crate::mesh::text::{TextCursor, TextWord};
use crate::mesh::triangle_mesh::MeshParts;
use std::collections::BTreeMap;
use std::path::Path;

/// The memory for a name or a part beside its text, at most, in bytes: entries of a map, and a material.
const BYTES_PER_NAME: u64 = 512;

/// What lines say about the faces behind them: object, group and material, as indices of names.
type PartKey = [Option<u32>; 3];

/// Triangles of one part that follow each other.
struct ObjRun {
    first: usize,
    part: u32,
    smoothing: Option<u32>,
}

/// Which triangles belong together.
#[derive(Default)]
pub(super) struct ObjParts {
    names: Vec<String>,
    known: BTreeMap<String, u32>,
    /// Files of materials, as named.
    libraries: Vec<String>,
    current: PartKey,
    /// The name of the group of faces that are smooth together, if one is open.
    smoothing: Option<u32>,
    parts: Vec<PartKey>,
    numbers: BTreeMap<PartKey, u32>,
    runs: Vec<ObjRun>,
    omissions: Omissions,
}

/// Elements of an OBJ file that are not drawn.
const NOT_DRAWN: [(&str, &str); 6] = [
    ("l", "line element(s)"),
    ("p", "point element(s)"),
    ("curv", "curve(s)"),
    ("curv2", "curve(s)"),
    ("surf", "curved surface(s)"),
    ("sp", "special point(s)"),
];

impl ObjParts {
    /// Reads what a line says about parts. `triangles` is the number of triangles before it.
    pub(super) fn read_line(
        &mut self,
        keyword: &TextWord,
        mut cursor: TextCursor,
        triangles: usize,
        ledger: &mut Ledger,
    ) -> Result<(), Fault> {
        match keyword.bytes {
            b"o" => self.current[0] = self.name(&cursor.rest_of_line(), ledger)?,
            b"g" => self.current[1] = self.name(&cursor.rest_of_line(), ledger)?,
            b"usemtl" => self.current[2] = self.name(&cursor.rest_of_line(), ledger)?,
            b"s" => {
                let group = cursor.rest_of_line();
                let is_off = group.is("off") || group.bytes == b"0";
                self.smoothing = if is_off { None } else { self.name(&group, ledger)? };
            }
            b"mtllib" => {
                if let Some(name) = self.name(&cursor.rest_of_line(), ledger)? {
                    ledger.push(&mut self.libraries, self.names[name as usize].clone())?;
                }
            }
            b"f" | b"fo" => self.begin_run(triangles, ledger)?,
            _ => {
                if let Some((_, what)) = NOT_DRAWN.iter().find(|(word, _)| keyword.bytes == word.as_bytes()) {
                    self.omissions.add(1, what, "");
                }
            }
        }
        Ok(())
    }

    /// The index of a name; `None` if it is empty.
    fn name(&mut self, word: &TextWord, ledger: &mut Ledger) -> Result<Option<u32>, Fault> {
        if word.bytes.is_empty() {
            return Ok(None);
        }
        let name = String::from_utf8_lossy(word.bytes);
        if let Some(known) = self.known.get(name.as_ref()) {
            return Ok(Some(*known));
        }
        // It is in the list, in the map, and maybe in the name of a part and of a material.
        ledger.charge(BYTES_PER_NAME + 4 * name.len() as u64)?;
        let index = self.names.len() as u32;
        self.names.push(name.clone().into_owned());
        self.known.insert(name.into_owned(), index);
        Ok(Some(index))
    }

    /// Begins a run at a face, unless it belongs to the same part as the face before.
    fn begin_run(&mut self, first: usize, ledger: &mut Ledger) -> Result<(), Fault> {
        let is_same = |run: &ObjRun| self.parts[run.part as usize] == self.current && run.smoothing == self.smoothing;
        if self.runs.last().is_some_and(is_same) {
            return Ok(());
        }
        let part = match self.numbers.get(&self.current) {
            Some(known) => *known,
            None => {
                ledger.charge(BYTES_PER_NAME)?;
                let new = self.parts.len() as u32;
                self.parts.push(self.current);
                self.numbers.insert(self.current, new);
                new
            }
        };
        ledger.push(&mut self.runs, ObjRun { first, part, smoothing: self.smoothing })
    }

    /// The model of what has been read. The path is that of the OBJ file.
    pub(super) fn into_model(mut self, contents: ObjContents, path: &Path, ledger: &mut Ledger) -> Result<ModelContents, Fault> {
        let MaterialLibraries { materials: found, mut omissions } = mtl::read_all(&self.libraries, path, ledger)?;
        let mut materials: Vec<ModelMaterial> = Vec::new();
        let mut images = ImageList::default();
        let mut indices = BTreeMap::new();
        let mut missing = 0;
        // Those that faces use, in the order of their use.
        for name in self.parts.iter().filter_map(|key| key[2]) {
            if indices.contains_key(&name) {
                continue;
            }
            let place = match found.get(&self.names[name as usize]) {
                Some(MtlMaterial { look, image }) => {
                    let image = image.as_ref().map(|file| images.add_file(file, ledger, &mut omissions)).transpose()?.flatten();
                    materials.push(ModelMaterial { name: self.names[name as usize].clone(), look: look.clone(), image });
                    Some(materials.len() - 1)
                }
                None => None,
            };
            missing += u64::from(place.is_none());
            indices.insert(name, place);
        }
        let parts = self.split(&contents, &indices, ledger)?;
        self.omissions.add(missing, "material(s) that no file describes", "their bodies have the default colour");
        let all = self.omissions.with(omissions);
        contents.release(ledger);
        Ok(ModelContents { parts, materials, images: images.images, omissions: all, ..ModelContents::default() })
    }

    /// The triangles and vertices of each part.
    fn split(
        &self,
        contents: &ObjContents,
        materials: &BTreeMap<u32, Option<usize>>,
        ledger: &mut Ledger,
    ) -> Result<Vec<PartContents>, Fault> {
        let mut runs: Vec<Vec<std::ops::Range<usize>>> = vec![Vec::new(); self.parts.len()];
        let ends = self.runs.iter().skip(1).map(|run| run.first).chain([contents.triangles.len()]);
        // A part is smooth if all its faces are in one group.
        let mut smoothing: Vec<Option<Option<u32>>> = vec![None; self.parts.len()];
        for (run, end) in self.runs.iter().zip(ends) {
            let group = smoothing[run.part as usize].get_or_insert(run.smoothing);
            *group = group.filter(|group| Some(*group) == run.smoothing);
            ledger.push(&mut runs[run.part as usize], run.first..end)?;
        }
        // The place of each vertex in the part at hand.
        let mut places = Vec::new();
        ledger.reserve(&mut places, contents.vertices.len())?;
        places.resize(contents.vertices.len(), NONE);
        let mut used = Vec::new();
        let mut split = Vec::new();
        for ((key, runs), smoothing) in self.parts.iter().zip(runs).zip(smoothing) {
            let mut parts = MeshParts::default();
            let count = runs.iter().map(std::ops::Range::len).sum();
            ledger.reserve(&mut parts.triangles, count)?;
            for (number, triangle) in runs.iter().flat_map(|run| &contents.triangles[run.clone()]).enumerate() {
                ledger.check(number)?;
                for vertex in triangle {
                    let place = &mut places[*vertex as usize];
                    if *place == NONE {
                        // No more than the vertices of the file.
                        *place = used.len() as u32;
                        ledger.push(&mut used, *vertex)?;
                    }
                }
                parts.triangles.push(triangle.map(|vertex| places[vertex as usize]));
            }
            contents.fill(used.iter().map(|vertex: &u32| &contents.vertices[*vertex as usize]), &mut parts, ledger)?;
            used.drain(..).for_each(|vertex| places[vertex as usize] = NONE);
            let material = key[2].and_then(|name| materials.get(&name).copied().flatten());
            split.push(PartContents { name: self.part_name(key), material, is_smooth: smoothing.flatten().is_some(), parts });
        }
        ledger.release(places);
        ledger.release(used);
        Ok(split)
    }

    /// Object and group together.
    fn part_name(&self, key: &PartKey) -> String {
        let mut names: Vec<&str> = key[..2].iter().flatten().map(|name| self.names[*name as usize].as_str()).collect();
        names.dedup();
        names.join(" ")
    }
}

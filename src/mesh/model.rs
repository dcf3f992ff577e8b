//! Files as parts with materials, with their cameras and lights, as the files say it.

use crate::mesh::error::Fault;
use crate::mesh::ledger::Ledger;
use crate::mesh::triangle_mesh::{MeshParts, MeshRepairs, TriangleMesh};
use glam::DVec3;

/// A file of several parts, in world coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshModel {
    /// The parts in the order of the file. Each has triangles.
    pub parts: Vec<ModelPart>,
    /// The materials that parts name by their indices.
    pub materials: Vec<ModelMaterial>,
    /// The images that materials name by their indices.
    pub images: Vec<ModelImage>,
    /// The first camera with a perspective view.
    pub camera: Option<ModelCamera>,
    /// The lights.
    pub lights: Vec<ModelLight>,
    /// What was repaired, in all parts together.
    pub repairs: MeshRepairs,
    /// What else the file has.
    pub omissions: Omissions,
}

/// A part of a file: triangles of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelPart {
    /// Its name in the file, which may be any text.
    pub name: String,
    /// Its material, an index into [`MeshModel::materials`].
    pub material: Option<usize>,
    /// Its triangles.
    pub mesh: TriangleMesh,
}

/// A material.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelMaterial {
    /// Its name in the file; empty if it has none.
    pub name: String,
    /// How it looks.
    pub look: ModelLook,
    /// The image by which its base or matte colour is multiplied, an index into [`MeshModel::images`].
    pub image: Option<usize>,
}

/// An image, not decoded.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelImage {
    /// Its name in the file, or the name of its own file without the suffix; it may be any text.
    pub name: String,
    /// The suffix of files in its format, in small letters.
    pub suffix: &'static str,
    /// The file.
    pub bytes: Vec<u8>,
}

/// How a material looks, in the terms of its file. Colours are linear RGB.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelLook {
    /// As glTF describes materials.
    Physical(PhysicalLook),
    /// As MTL files describe materials.
    Phong(PhongLook),
}

/// A material of glTF: metal or not, and rough or not. All numbers are as the file has them, and may be out of range.
#[derive(Debug, Clone, PartialEq)]
pub struct PhysicalLook {
    /// The base colour.
    pub base: [f64; 3],
    /// How much the surface covers: 1 but for materials that are blended.
    pub coverage: f64,
    /// 0 for dielectrics, 1 for metals.
    pub metallic: f64,
    /// The roughness.
    pub roughness: f64,
    /// The strength of the reflection of dielectrics.
    pub specular: f64,
    /// The colour of this reflection.
    pub specular_color: [f64; 3],
    /// How much of the surface has a clear coat.
    pub coat: f64,
    /// The roughness of the coat.
    pub coat_roughness: f64,
    /// How much light passes the surface.
    pub transmission: f64,
    /// The index of refraction.
    pub index: f64,
    /// Whether the surface is a thin pane, which bends no light.
    pub is_thin: bool,
}

/// A material of an MTL file. All numbers are as the file has them, and may be out of range.
#[derive(Debug, Clone, PartialEq)]
pub struct PhongLook {
    /// Kd, the matte colour.
    pub diffuse: [f64; 3],
    /// Ks, the colour of highlights and reflections.
    pub specular: [f64; 3],
    /// Ns, the sharpness of highlights.
    pub sharpness: f64,
    /// Ni, the index of refraction.
    pub index: Option<f64>,
    /// d, how much the surface covers.
    pub coverage: f64,
    /// Tf, the colour of what passes the surface.
    pub filter: [f64; 3],
    /// The illumination model, 0..=10.
    pub illumination: u32,
}

/// A camera with a perspective view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelCamera {
    /// Its position.
    pub position: DVec3,
    /// The direction in which it looks.
    pub gaze: DVec3,
    /// The direction upwards in its picture.
    pub up: DVec3,
    /// The vertical field of view in degrees.
    pub fov: f64,
    /// Width divided by height of its picture, greater than 0.
    pub aspect: Option<f64>,
}

/// A light.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelLight {
    /// Its name in the file; empty if it has none.
    pub name: String,
    /// Where it is, or from where it shines.
    pub source: LightSource,
    /// Its colour, linear RGB.
    pub color: [f64; 3],
    /// Candela, or lux of a directional light.
    pub intensity: f64,
}

/// How a light of a file shines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightSource {
    /// From a point.
    Point(DVec3),
    /// From a point, within a cone.
    Spot {
        /// The point.
        place: DVec3,
        /// The direction of the middle of the cone, of unit length.
        direction: DVec3,
        /// The angles in radians between the middle and where the light begins to get weaker, and the edge. They are as
        /// the file has them, and may be out of range.
        angles: [f64; 2],
    },
    /// From far away, in this direction of unit length.
    Directional(DVec3),
}

/// What a file has and the model has not, each with its number.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Omissions(Vec<Omission>);

/// Things of one sort that were left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Omission {
    /// How many.
    pub count: u64,
    /// What. `(s)` stands behind the noun.
    what: String,
    /// What follows from it; empty if that is clear.
    pub note: String,
}

impl Omissions {
    /// Notes what was left out. In `what`, `(s)` stands behind the noun, as in `part(s) of lines`.
    pub(crate) fn add(&mut self, count: u64, what: &str, note: &str) {
        if count == 0 {
            return;
        }
        match self.0.iter_mut().find(|known| known.what == what && known.note == note) {
            Some(known) => known.count += count,
            None => self.0.push(Omission { count, what: what.to_owned(), note: note.to_owned() }),
        }
    }

    /// These and others.
    pub(crate) fn with(mut self, others: Self) -> Self {
        others.0.iter().for_each(|other| self.add(other.count, &other.what, &other.note));
        self
    }

    /// All of them, in the order in which they were found.
    pub fn iter(&self) -> impl Iterator<Item = &Omission> {
        self.0.iter()
    }
}

impl std::fmt::Display for Omission {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.count, self.what.replacen("(s)", if self.count == 1 { "" } else { "s" }, 1))?;
        if self.note.is_empty() { Ok(()) } else { write!(f, ": {}", self.note) }
    }
}

/// What a reader makes of a file: the same, with parts that are not checked.
#[derive(Default)]
pub(super) struct ModelContents {
    pub(super) parts: Vec<PartContents>,
    pub(super) materials: Vec<ModelMaterial>,
    pub(super) images: Vec<ModelImage>,
    pub(super) camera: Option<ModelCamera>,
    pub(super) lights: Vec<ModelLight>,
    pub(super) omissions: Omissions,
}

/// A part that is not checked.
pub(super) struct PartContents {
    pub(super) name: String,
    pub(super) material: Option<usize>,
    /// Whether it gets normals if it has none.
    pub(super) is_smooth: bool,
    pub(super) parts: MeshParts,
}

impl ModelContents {
    /// Checks and completes the parts. Those that have no triangle with an area are left out.
    pub(super) fn complete(self, ledger: &mut Ledger) -> Result<MeshModel, Fault> {
        let Self { parts: all, materials, images, camera, lights, mut omissions } = self;
        let (count, mut parts, mut repairs) = (all.len(), Vec::new(), MeshRepairs::default());
        ledger.reserve(&mut parts, count)?;
        for (index, PartContents { name, material, is_smooth, parts: contents }) in all.into_iter().enumerate() {
            ledger.tell_completing(index, count)?;
            if !contents.has_area() {
                omissions.add(1, "part(s)", "its triangles have no area");
                continue;
            }
            let (mesh, repaired) =
                ledger.quietly(|ledger| TriangleMesh::complete(contents, ledger)).map_err(|fault| fault.within(&name))?;
            repairs = repairs + repaired;
            let mesh = if is_smooth { mesh.smoothed(ledger)? } else { mesh };
            parts.push(ModelPart { name, material, mesh });
        }
        if parts.is_empty() {
            return Err(
                Fault::new("it has no triangles with an area").help("a mesh needs faces; points, lines and curves are not drawn")
            );
        }
        Ok(MeshModel { parts, materials, images, camera, lights, repairs, omissions })
    }
}

//! Scenes from files of other programs: a body for each part of a file, its camera and lights, and a session with its
//! colours. Formulas from files of BRDF Explorer.
//!
//! [`plan`] turns a [`MeshModel`] into texts and meshes, and [`ImportPlan::write`] writes them. What the languages of
//! this program cannot say is left out or simplified, and listed.

mod brdf;
mod looks;
mod names;
mod target;
#[cfg(test)]
mod tests;
mod textures;
mod view;

pub use brdf::{BrdfFormula, formula_of_brdf};
pub use target::{ImportError, ImportTarget};

use crate::lang::ast::Constant;
use crate::lang::display_text::one_line;
use crate::lang::format::formatted;
use crate::lang::source::{MAX_BYTES, Source, SourceSpan};
use crate::mesh::{MeshModel, ModelLook, Omissions, TriangleMesh};
use crate::picture::{Transfer, ViewTransform};
use crate::scene::shape::NamedMesh;
use crate::scene::{Body, Scene, Shape};
use crate::workspace::session::{NamedValue, OwnerName, PictureSettings};
use crate::workspace::{FileValue, Location, Session};
use glam::DVec3;
use looks::ImportedLook;
use names::UniqueNames;
use std::path::{Path, PathBuf};
use textures::ImageFiles;
use view::ImportedLight;

/// What is to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportPlan {
    /// The text of the formula, if bodies have images. Otherwise the formula is a built-in one.
    pub formula: Option<String>,
    /// The images of bodies: the names of their files, and what is in them.
    pub images: Vec<(String, Vec<u8>)>,
    /// The text of the scene.
    pub scene: String,
    /// The session.
    pub session: Session,
    /// The meshes, by the names of their bodies.
    pub meshes: Vec<(String, TriangleMesh)>,
    /// The number of lights, and whether they are those of the file.
    pub lights: (usize, bool),
    /// Whether the camera is that of the file.
    pub has_camera: bool,
    /// What looks another way than in the file.
    pub simplified: Omissions,
    /// What the file has and the scene has not.
    pub left_out: Omissions,
}

/// A body of the scene, without its triangles.
struct ImportedBody {
    name: String,
    look: ImportedLook,
    /// The file of its image.
    image: Option<PathBuf>,
}

impl ImportedBody {
    /// The body in the scene; `None` if the scene cannot write the name of its mesh.
    fn in_scene(self, target: &ImportTarget) -> Option<Body> {
        let mesh = NamedMesh::new(target.mesh_in_scene(&self.name))?;
        Some(Body {
            name: self.name,
            name_span: SourceSpan::default(),
            form: Shape::Mesh(mesh).into(),
            refractive_index: self.look.refractive_index,
            opaque: self.look.is_opaque,
            matte: self.look.is_matte,
            shading: None,
        })
    }
}

/// What to write for a model. `source` names its file.
///
/// # Errors
/// The model is so large that no camera shows it, or has more parts than a text can hold.
pub fn plan(mut model: MeshModel, source: &str, target: &ImportTarget) -> Result<ImportPlan, ImportError> {
    let bounds = bounding_box(&model);
    let (mut simplified, mut left_out) = (Omissions::default(), model.omissions.clone());
    let (camera, size, has_camera) = view::camera(model.camera.as_ref(), &model.parts, bounds, &mut simplified)?;
    let mut names = UniqueNames::default();
    let repairs = model.repairs;
    left_out.add(repairs.degenerate_triangles, "triangle(s) without area", "");
    simplified.add(repairs.missing_normals, "missing normal(s)", "the mean of the triangles around is used");
    simplified.add(repairs.unusable_uvs, "wrong texture coordinate(s)", "0 is used");
    let mut bodies = Vec::new();
    let mut meshes = Vec::new();
    let mut images = ImageFiles::default();
    for part in std::mem::take(&mut model.parts) {
        let image = images.of_part(&part, &model, &mut left_out).map(|file| target.textures().join(file));
        let material = part.material.and_then(|material| model.materials.get(material));
        let material_name = material.map_or("", |material| material.name.as_str());
        let name = names.take(&part.name, material_name, "part");
        let look = ImportedLook::new(material.map(|material| &material.look));
        bodies.push(ImportedBody { name: name.clone(), look, image });
        meshes.push((name, part.mesh));
    }
    let lights = view::lights(&model.lights, bounds, &camera, &mut names, &mut simplified);
    let is_physical = model.materials.iter().any(|material| matches!(material.look, ModelLook::Physical(_)));
    let preset = if is_physical { looks::PHYSICAL_FORMULA } else { looks::PHONG_FORMULA };
    let images = images.with_contents(&mut model);
    let formula = if images.is_empty() { None } else { textures::formula(preset, &one_line(source)) };
    let session = Session {
        formula: match formula {
            Some(_) => Location::File(target.formula()),
            None => Location::Preset(preset.to_owned()),
        },
        scene: Location::File(target.scene().to_owned()),
        picture: PictureSettings {
            size,
            view: ViewTransform { transfer: Transfer::Srgb, ..ViewTransform::default() },
            ..PictureSettings::default()
        },
        values: values(&bodies, &lights),
    };
    let bodies = bodies.into_iter().map(|body| body.in_scene(target)).collect::<Option<Vec<_>>>();
    let bodies = bodies.ok_or_else(|| target.refused("scenes cannot write the names of its meshes"))?;
    let (count, is_own) = (lights.len(), !model.lights.is_empty());
    let lights = lights.into_iter().map(ImportedLight::in_scene).collect();
    let scene = scene_text(source, &Scene { bodies, lights, camera });
    let session_length = session.to_toml(target.scene().parent().unwrap_or(Path::new(""))).map_or(0, |text| text.len());
    if scene.len().max(session_length) > MAX_BYTES {
        return Err(ImportError::TooManyParts(meshes.len()));
    }
    Ok(ImportPlan { formula, images, scene, session, meshes, lights: (count, is_own), has_camera, simplified, left_out })
}

/// The lowest and the highest coordinates of all parts.
fn bounding_box(model: &MeshModel) -> [DVec3; 2] {
    let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    model
        .parts
        .iter()
        .map(|part| part.mesh.bounding_box())
        .fold(start, |[low, high], [other_low, other_high]| [low.min(other_low), high.max(other_high)])
}

/// The background, in linear RGB: parts in the shade stand out from it.
const BACKGROUND: [f32; 3] = [0.1, 0.11, 0.13];

/// All values for the session.
fn values(bodies: &[ImportedBody], lights: &[ImportedLight]) -> Vec<NamedValue> {
    let file_value = |owner: OwnerName, parameter: &str, value: FileValue| NamedValue {
        owner,
        parameter: parameter.to_owned(),
        value,
        spans: [SourceSpan::default(); 2],
    };
    let value = |owner, parameter: &str, value| file_value(owner, parameter, FileValue::Constant(value));
    let of_bodies = bodies.iter().flat_map(|ImportedBody { name, look, image }| {
        let owner = || OwnerName::Body(name.clone());
        let numbers = look.values.iter().map(move |(parameter, number)| value(owner(), parameter, *number));
        numbers.chain(image.iter().map(move |file| file_value(owner(), textures::PARAMETER, FileValue::Image(file.clone()))))
    });
    let of_lights = lights.iter().flat_map(|light| {
        let owner = || OwnerName::Light(light.name.clone());
        [value(owner(), "ki", Constant::Scalar(light.intensity)), value(owner(), "IL", Constant::Vector(light.color))]
    });
    let background = value(OwnerName::Global, "background", Constant::Vector(BACKGROUND));
    std::iter::once(background).chain(of_bodies).chain(of_lights).collect()
}

/// The scene in the scene language.
fn scene_text(source: &str, scene: &Scene) -> String {
    let text = format!("// Made from {} by `illuminator import`.\n\n{scene}", one_line(source));
    formatted(&Source::new("scene", text.as_str())).unwrap_or(text)
}

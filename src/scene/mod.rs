//! Scenes: bodies, lights and a camera, as a text declares them (thesis 3.2.6, 9.3).
//!
//! Holds what a scene *says*, how it is read from the scene language and printed in it. Each shape and each kind of
//! light has a file of its own (`shape/sphere`, `light/point`) and a row in the table of its enumeration, see `syntax`.
//! Where rays meet bodies is computed in [`crate::world`]. How bodies look is up to the formula.

mod body_form;
mod body_motion;
mod camera;
pub mod edit;
mod foreign;
pub mod light;
mod movable;
mod named_file;
pub(crate) mod naming;
mod parser;
mod print;
pub mod shape;
mod syntax;
mod transform;
mod values;

pub use body_form::BodyForm;
pub use camera::{Camera, CameraError, ViewSide};
pub use light::{Light, LightKind};
pub use named_file::NamedFile;
pub use shape::Shape;
pub use syntax::Syntax;
pub use transform::Transform;

use crate::lang::diagnostic::Diagnostics;
use crate::lang::source::{Source, SourceSpan};
use glam::DVec3;

/// The largest coordinate and length of a scene. Squares and cubes of such numbers are far from overflow.
pub const MAX_COORDINATE: f64 = 1e30;
/// The smallest radius, edge and length of a direction. Squares of such numbers are far from underflow.
pub const MIN_LENGTH: f64 = 1e-30;

/// A body, by its index in the list of bodies of the scene: from 0, in the order of declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BodyId(pub u32);

/// A light, by its index in the list of lights of the scene: from 0, in the order of declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightId(pub u32);

impl BodyId {
    /// The id as an index into [`Scene::bodies`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl LightId {
    /// The id as an index into [`Scene::lights`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A body: its form, and the properties that decide where rays go (thesis 9.3.1). Colours are not part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name, unique among bodies and lights.
    pub name: String,
    /// Where the name stands in the text.
    pub name_span: SourceSpan,
    /// Its shape, with the transforms behind it.
    pub form: BodyForm,
    /// Its index of refraction, greater than 0; `None`: the default index of the view under which the scene is traced.
    pub refractive_index: Option<f64>,
    /// Never refracts: no refracted ray is traced from it.
    pub opaque: bool,
    /// Never reflects: no reflected ray is traced from it.
    pub matte: bool,
    /// How a mesh is shaded; `None` for other bodies, and where the file decides.
    pub shading: Option<MeshShading>,
}

/// How the triangles of a mesh are shaded. Without it, those of files with normals are smooth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MeshShading {
    /// Each by its own normal.
    Flat,
    /// By normals that are interpolated between the corners.
    Smooth,
}

/// A scene in right-handed world coordinates (thesis 9.3). It may have no bodies and no lights.
///
/// `Display` prints it in the scene language. The text reads back as the same scene, number by number.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The bodies in the order of declaration; a [`BodyId`] is an index into it.
    pub bodies: Vec<Body>,
    /// The lights in the order of declaration; a [`LightId`] is an index into it.
    pub lights: Vec<Light>,
    /// The camera.
    pub camera: Camera,
}

impl Scene {
    /// Parses a scene, and returns it with the warnings.
    ///
    /// # Errors
    /// Every independent error of the text, together with the warnings, in the order of their places.
    pub fn parse(source: &Source) -> Result<(Scene, Diagnostics), Diagnostics> {
        parser::parse(source)
    }

    /// The body of that id.
    ///
    /// # Panics
    /// If the id is another scene's, and this one has fewer bodies.
    pub fn body(&self, id: BodyId) -> &Body {
        &self.bodies[id.index()]
    }

    /// The light of that id.
    ///
    /// # Panics
    /// If the id is another scene's, and this one has fewer lights.
    pub fn light(&self, id: LightId) -> &Light {
        &self.lights[id.index()]
    }

    /// The ids of all bodies, in the order of declaration.
    pub fn body_ids(&self) -> impl Iterator<Item = BodyId> + use<> {
        // Texts have at most a few megabytes, which cannot declare 2³² bodies.
        (0..self.bodies.len() as u32).map(BodyId)
    }

    /// The ids of all lights, in the order of declaration.
    pub fn light_ids(&self) -> impl Iterator<Item = LightId> + use<> {
        // As for bodies.
        (0..self.lights.len() as u32).map(LightId)
    }
}

/// Whether a point is within the reach of scenes: no coordinate is beyond [`MAX_COORDINATE`], or NaN.
fn is_within_reach(point: DVec3) -> bool {
    point.is_finite() && point.abs().max_element() <= MAX_COORDINATE
}

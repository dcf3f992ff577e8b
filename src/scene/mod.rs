//! Scenes: bodies, point lights and a camera, as text and as geometry (thesis 3.2.6, 9.3).
//!
//! Holds what a scene *is*, how it is read from the scene language and printed in it, and where a ray meets one body.
//! Which body a ray meets first, how it goes on from there and who is in shadow is not decided here but in [`crate::trace`];
//! what the bodies look like is the formula's business.

mod camera;
mod parser;
mod print;
mod shape;

pub use camera::{Camera, CameraError};
pub use shape::{Ray, Rectangle, Shape, ShapeError, Side, Sphere};

use crate::lang::diagnostic::Diagnostics;
use crate::lang::source::{Source, Span};
use glam::DVec3;

/// The largest coordinate and length of a scene: far below where squares and cubes of such numbers overflow.
pub const MAX_COORDINATE: f64 = 1e30;
/// The smallest radius, edge and length of a direction: far above where their squares vanish.
pub const MIN_LENGTH: f64 = 1e-30;

/// A body by its place in the scene's list of bodies, from 0 in the order of declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BodyId(pub u32);

/// A light by its place in the scene's list of lights, from 0 in the order of declaration.
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

/// A body: its shape and what of its surface decides where rays go (thesis 9.3.1). Colours are not part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name, unique among bodies and lights.
    pub name: String,
    /// Where the name stands in the text.
    pub name_span: Span,
    /// Its shape.
    pub shape: Shape,
    /// Its index of refraction, greater than 0; `None`: the default index that is given when the scene is traced.
    pub refractive_index: Option<f64>,
    /// Never refracts: no refracted ray is traced from it.
    pub opaque: bool,
    /// Never reflects: no reflected ray is traced from it.
    pub matte: bool,
}

/// A point light that shines in all directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// Its name, unique among bodies and lights.
    pub name: String,
    /// Where the name stands in the text.
    pub name_span: Span,
    /// Its place in world coordinates.
    pub position: DVec3,
}

/// A scene in right-handed world coordinates (thesis 9.3). It may have no bodies and no lights.
///
/// Printed, it is a text of the scene language that reads back as the same scene, number by number.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The bodies in the order of declaration; a [`BodyId`] is an index into it.
    pub bodies: Vec<Body>,
    /// The lights in the order of declaration; a [`LightId`] is an index into it.
    pub lights: Vec<Light>,
    /// From where the scene is seen.
    pub camera: Camera,
}

impl Scene {
    /// Reads a scene; with it come the warnings.
    ///
    /// # Errors
    /// Every independent error of the text, and the warnings among them, in the order of their places.
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
        // A text of a few megabytes, the most that is read, cannot declare 2³² bodies.
        (0..self.bodies.len() as u32).map(BodyId)
    }

    /// The ids of all lights, in the order of declaration.
    pub fn light_ids(&self) -> impl Iterator<Item = LightId> + use<> {
        // As with bodies.
        (0..self.lights.len() as u32).map(LightId)
    }

    /// The size of the scene: the diagonal of the bounding box of its bodies, in world units; 0 without bodies.
    ///
    /// Lights and camera are left out: it measures how finely the surfaces that rays start from must be told apart,
    /// and a sun set far away does not make them coarser.
    pub fn extent(&self) -> f64 {
        self.bodies
            .iter()
            .map(|body| body.shape.bounds())
            .reduce(|(low, high), (lower, higher)| (low.min(lower), high.max(higher)))
            .map_or(0.0, |(low, high)| (high - low).length())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(text: &str) -> Scene {
        Scene::parse(&Source::new("t", text)).unwrap().0
    }

    #[test]
    fn the_extent_is_that_of_the_bodies() {
        let camera = "camera; position <9,9,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
        let one = scene(&format!("bodies; s: sphere, center <1,2,3>, radius 2; lights; l: point, <1e9,0,0>; {camera}"));
        assert_eq!(one.extent(), 4.0 * 3f64.sqrt());
        let two = scene(&format!(
            "bodies; s: sphere, center <0,0,0>, radius 1; r: rectangle, <2,0,0>, <3,0,0>, <3,4,0>; lights; {camera}"
        ));
        assert_eq!(two.extent(), DVec3::new(4.0, 5.0, 2.0).length());
        assert_eq!(scene(&format!("bodies; lights; {camera}")).extent(), 0.0);
    }
}

//! One step of a ray: which body it meets first, what the surface is like there, which lights reach it, and where the
//! reflected and the refracted ray go (thesis 3.2.1 to 3.2.5), all in f64.
//!
//! How steps follow one another is said in [`super::walk`], what formulas see of a hit in [`super::variables`].

#[cfg(test)]
mod tests;

use crate::scene::{BodyId, Light, LightId, Ray, Scene, Side};
use crate::trace::View;
use glam::DVec3;

/// The distance, as a share of the scene's extent, within which two different surfaces are one: a ray that leaves one does
/// not meet the other, and of two met it is the one declared first.
const CLEARANCE: f64 = 1e-9;

/// A ray with the surface that it leaves, if it is not the camera's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Where it starts and goes.
    pub ray: Ray,
    /// The body it starts on, and the side of its surface to which it leaves.
    pub leaves: Option<(BodyId, Side)>,
}

/// A hit worked out: where a ray met a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// The body.
    pub body: BodyId,
    /// The side of its surface that was met.
    pub side: Side,
    /// The point, in world coordinates.
    pub point: DVec3,
    /// The normal, of unit length, turned to the side where the ray came from.
    pub normal: DVec3,
    /// To where the ray came from, of unit length; `normal` · `view` ≥ 0.
    pub view: DVec3,
    /// The way from where the ray came from, in world units.
    pub distance: f64,
}

impl Surface {
    /// The front normal: outwards on a sphere.
    pub fn front_normal(&self) -> DVec3 {
        match self.side {
            Side::Front => self.normal,
            Side::Back => -self.normal,
        }
    }

    /// The unit direction to the light and the distance from it; a light in the very point is taken to be along the normal.
    pub fn toward(&self, light: &Light) -> (DVec3, f64) {
        let way = light.position - self.point;
        (way.try_normalize().unwrap_or(self.normal), way.length())
    }
}

/// The laws of light in one scene as one view asks for them.
#[derive(Debug, Clone, Copy)]
pub struct Optics<'s> {
    scene: &'s Scene,
    view: View,
    clearance: f64,
}

impl<'s> Optics<'s> {
    /// The optics of `scene` under `view`.
    pub fn new(scene: &'s Scene, view: &View) -> Self {
        Self { scene, view: *view, clearance: CLEARANCE * scene.extent() }
    }

    /// The scene.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The view.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The primary ray of a pixel.
    pub fn primary(&self, pixel: u32) -> Beam {
        Beam { ray: self.view.primary_ray(&self.scene.camera, pixel), leaves: None }
    }

    /// Where the beam meets this one body, whatever else is in between.
    pub fn meets(&self, beam: &Beam, id: BodyId) -> Option<f64> {
        let shape = &self.scene.body(id).shape;
        match beam.leaves {
            Some((body, side)) if body == id => shape.intersect_leaving(&beam.ray, side),
            Some(_) | None => shape.intersect(&beam.ray, self.clearance),
        }
    }

    /// The body that the beam meets first, and the distance; of several at equal distance the one declared first.
    pub fn nearest(&self, beam: &Beam) -> Option<(BodyId, f64)> {
        self.scene.body_ids().filter_map(|id| Some((id, self.meets(beam, id)?))).reduce(|best, next| {
            // Equal but for rounding is equal: else coincident surfaces would show in patches.
            if next.1 < best.1 - self.clearance { next } else { best }
        })
    }

    /// The surface of a body where the beam meets it at `distance`.
    pub fn surface(&self, beam: &Beam, body: BodyId, distance: f64) -> Surface {
        let direction = beam.ray.direction;
        let (point, front) = self.scene.body(body).shape.settle(beam.ray.at(distance), direction);
        let (side, normal) = if front.dot(direction) <= 0.0 { (Side::Front, front) } else { (Side::Back, -front) };
        Surface { body, side, point, normal, view: -direction, distance }
    }

    /// Whether the light reaches the hit: always without shadow rays; with them, if it is on the side where the ray came from
    /// and no body, this one and transparent ones too, lies strictly between (thesis 3.2.1).
    pub fn reaches(&self, light: LightId, surface: &Surface) -> bool {
        if !self.view.shadows() {
            return true;
        }
        let toward = surface.toward(self.scene.light(light));
        surface.normal.dot(toward.0) > 0.0 && self.between(surface, toward).next().is_none()
    }

    /// Whether the light is on the side of the surface where the ray came from: N·L > 0.
    pub fn faces(&self, light: LightId, surface: &Surface) -> bool {
        surface.normal.dot(surface.toward(self.scene.light(light)).0) > 0.0
    }

    /// The bodies that lie strictly between a hit and a light that it faces, in the order of declaration, each with its distance from the
    /// hit in world units; whether shadow rays are sent or not.
    pub fn obstacles(&self, light: LightId, surface: &Surface) -> impl Iterator<Item = (BodyId, f64)> {
        self.between(surface, surface.toward(self.scene.light(light)))
    }

    fn between(&self, surface: &Surface, (direction, distance): (DVec3, f64)) -> impl Iterator<Item = (BodyId, f64)> {
        let ray = Ray { origin: surface.point, direction };
        let beam = Beam { ray, leaves: Some((surface.body, surface.side)) };
        let met = self.scene.body_ids().filter_map(move |id| Some((id, self.meets(&beam, id)?)));
        // A lamp may be fixed to a body without being buried in it.
        met.filter(move |(_, met)| *met < distance - self.clearance)
    }

    /// The reflected ray, 2(N·V)N − V (thesis 3.2.4); none from a matte body.
    pub fn reflected(&self, surface: &Surface) -> Option<Beam> {
        if self.scene.body(surface.body).matte {
            return None;
        }
        let direction = 2.0 * surface.normal.dot(surface.view) * surface.normal - surface.view;
        let ray = Ray { origin: surface.point, direction: direction.normalize() };
        Some(Beam { ray, leaves: Some((surface.body, surface.side)) })
    }

    /// The refracted ray by Snell's law (thesis 3.2.5); none beyond the critical angle, and none into an opaque body.
    pub fn refracted(&self, surface: &Surface) -> Option<Beam> {
        let body = self.scene.body(surface.body);
        if body.opaque {
            return None;
        }
        let ratio = self.ratio(surface);
        let cosine = surface.normal.dot(surface.view);
        let square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        if square < 0.0 {
            return None;
        }
        let direction = (ratio * cosine - square.sqrt()) * surface.normal - ratio * surface.view;
        let ray = Ray { origin: surface.point, direction: direction.normalize() };
        Some(Beam { ray, leaves: Some((surface.body, surface.side.opposite())) })
    }

    /// n₁/n₂ for the ray that met this surface: from 1 into the body at its front, else the reverse; whether it is refracted or not.
    pub fn ratio(&self, surface: &Surface) -> f64 {
        let index = self.scene.body(surface.body).refractive_index.unwrap_or(self.view.default_index());
        match surface.side {
            Side::Front => 1.0 / index,
            Side::Back => index,
        }
    }
}

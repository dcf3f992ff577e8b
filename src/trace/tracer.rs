//! One ray: where a pixel's ray starts, what a ray hits, which emitters reach the hit, and where its reflected and
//! refracted rays go (thesis 3.2.1 to 3.2.5). All in f64.
//!
//! How rays follow one another is decided in [`super::walk`], what formulas see of a hit in [`super::variables`].

/// The cosine of the refracted ray with the normal, from that of the ray (0..1) and n₁/n₂; none beyond the critical
/// angle.
pub(super) fn refraction(cosine: f64, relative_index: f64) -> Option<f64> {
    let square = 1.0 - relative_index * relative_index * (1.0 - cosine * cosine);
    (square >= 0.0).then(|| square.sqrt())
}

#[cfg(test)]
mod tests;

use crate::lang::variables::EvaluatedLights;
use crate::sampling::SampleKey;
use crate::scene::BodyId;
use crate::trace::View;
use crate::world::{EmitterId, Intersection, LightSample, PrimitiveId, Ray, Side, SurfaceHit, World};

/// An emitter for which a formula is evaluated at a hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeLight {
    /// The emitter.
    pub emitter: EmitterId,
    /// Whether no body lies between the hit and the emitter.
    pub visible: bool,
}

/// Traces single rays in a world under a view. It is cheap to make.
#[derive(Debug, Clone, Copy)]
pub struct Tracer<'w> {
    world: &'w World,
    view: &'w View,
}

impl<'w> Tracer<'w> {
    /// Traces rays in `world` as `view` asks for them.
    pub fn new(world: &'w World, view: &'w View) -> Self {
        Self { world, view }
    }

    /// The world.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// The view.
    pub fn view(&self) -> &'w View {
        self.view
    }

    /// The primary ray of a pixel, counted row by row from the top left.
    pub fn primary(&self, pixel: u32) -> Ray {
        self.view.primary_ray(&self.world.scene().camera, pixel)
    }

    /// The surface that the ray hits first; `None` where it leaves the scene.
    #[inline]
    pub fn hit(&self, ray: &Ray) -> Option<SurfaceHit> {
        self.world.nearest(ray).map(|intersection| self.world.surface_hit(ray, &intersection))
    }

    /// The surface of this body where the ray meets it, whatever else is in between. A body whose parts are
    /// [searched](World::is_searched) is met in this part, if it is known.
    pub fn hit_on(&self, ray: &Ray, body: BodyId, part: Option<PrimitiveId>) -> Option<SurfaceHit> {
        let met = part.map_or_else(|| self.world.intersect(ray, body), |part| self.world.intersect_part(ray, body, part));
        met.map(|intersection| self.world.surface_hit(ray, &intersection))
    }

    /// The sample of an emitter that a hit takes.
    #[inline]
    pub fn sample(&self, emitter: EmitterId, hit: &SurfaceHit, key: &SampleKey) -> LightSample {
        self.world.emitter(emitter).sample(hit, key)
    }

    /// Whether the light of an emitter reaches the hit: it sends something there, and with shadow rays the hit
    /// [faces](SurfaceHit::faces) it and no body, this one and transparent ones too, lies strictly between (thesis
    /// 3.2.1).
    #[inline]
    pub fn reaches(&self, emitter: EmitterId, hit: &SurfaceHit, key: &SampleKey) -> bool {
        let sample = self.sample(emitter, hit, key);
        let LightSample { direction, distance, .. } = sample;
        if !self.view.shadows() {
            return sample.is_lit();
        }
        sample.is_lit() && hit.faces(direction) && !self.world.is_occluded(&hit.ray(direction, hit.side), distance)
    }

    /// The emitters that reach the hit, in the order of their lights.
    pub fn emitters(&self, hit: &SurfaceHit, key: &SampleKey) -> impl Iterator<Item = EmitterId> {
        self.world.emitter_ids().filter(move |emitter| self.reaches(*emitter, hit, key))
    }

    /// Whether no body lies strictly between the hit and an emitter; always without shadow rays.
    ///
    /// The emitter may be behind the surface. A flat body does not hide it then, but a closed body does with its far
    /// side. For an emitter that the hit faces and that sends something there, this is the test of
    /// [`reaches`](Self::reaches).
    pub fn is_visible(&self, emitter: EmitterId, hit: &SurfaceHit, key: &SampleKey) -> bool {
        if !self.view.shadows() {
            return true;
        }
        let LightSample { direction, distance, .. } = self.sample(emitter, hit, key);
        !self.world.is_occluded(&hit.ray(direction, hit.side_towards(direction)), distance)
    }

    /// The emitters for which a formula is evaluated at the hit, in the order of their lights, and whether each is
    /// visible.
    pub fn evaluated(&self, lights: EvaluatedLights, hit: &SurfaceHit, key: &SampleKey) -> impl Iterator<Item = NodeLight> {
        self.world.emitter_ids().filter_map(move |emitter| match lights {
            EvaluatedLights::Reaching => self.reaches(emitter, hit, key).then_some(NodeLight { emitter, visible: true }),
            EvaluatedLights::All => Some(NodeLight { emitter, visible: self.is_visible(emitter, hit, key) }),
        })
    }

    /// Whether the emitter is on the side of the surface from which the ray came.
    pub fn faces(&self, emitter: EmitterId, hit: &SurfaceHit, key: &SampleKey) -> bool {
        hit.faces(self.sample(emitter, hit, key).direction)
    }

    /// Whether it takes a shadow ray to find out whether an emitter [reaches](Self::reaches) the hit.
    pub(super) fn takes_shadow_ray(&self, emitter: EmitterId, hit: &SurfaceHit, key: &SampleKey) -> bool {
        let sample = self.sample(emitter, hit, key);
        sample.is_lit() && hit.faces(sample.direction)
    }

    /// What lies strictly between a hit and an emitter, in the order of declaration of the bodies; distances are from
    /// the hit. It does not matter whether shadow rays are on.
    pub fn occluders(&self, emitter: EmitterId, hit: &SurfaceHit, key: &SampleKey) -> Vec<Intersection> {
        let sample = self.sample(emitter, hit, key);
        self.world.occluders(&hit.ray(sample.direction, hit.side_towards(sample.direction)), sample.distance).collect()
    }

    /// The reflected ray, 2(N·V)N − V (thesis 3.2.4); none from a matte body.
    #[inline]
    pub fn reflected(&self, hit: &SurfaceHit) -> Option<Ray> {
        if self.world.scene().body(hit.body).matte {
            return None;
        }
        let normal = hit.shading_normal;
        let direction = 2.0 * normal.dot(hit.view) * normal - hit.view;
        Some(hit.ray(direction.normalize(), hit.side))
    }

    /// The refracted ray by Snell's law (thesis 3.2.5); none beyond the critical angle, and none into an opaque body.
    #[inline]
    pub fn refracted(&self, hit: &SurfaceHit) -> Option<Ray> {
        if self.world.scene().body(hit.body).opaque {
            return None;
        }
        let normal = hit.shading_normal;
        let ratio = self.relative_index(hit);
        let cosine = normal.dot(hit.view);
        let inner = refraction(cosine, ratio)?;
        let direction = (ratio * cosine - inner) * normal - ratio * hit.view;
        Some(hit.ray(direction.normalize(), hit.side.opposite()))
    }

    /// n₁/n₂ for the ray that met this surface, whether it is refracted or not: on the front it goes from index 1 into
    /// the body, on the back the reverse.
    #[inline]
    pub fn relative_index(&self, hit: &SurfaceHit) -> f64 {
        let index = self.world.scene().body(hit.body).refractive_index.unwrap_or(self.view.default_index());
        match hit.side {
            Side::Front => 1.0 / index,
            Side::Back => index,
        }
    }
}

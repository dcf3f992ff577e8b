//! Spheres that emit light.

use super::point::PointEmitter;
use super::{Emit, LightSample};
use crate::scene::light::{PointLight, SphereLight};
use crate::world::hit::SurfaceHit;

/// A point light that is spread over a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SphereEmitter {
    middle: PointEmitter,
}

impl SphereEmitter {
    /// The emitter of such a light.
    pub(super) fn new(light: &SphereLight) -> Self {
        Self { middle: PointEmitter::new(&PointLight::new(light.sphere().center())) }
    }
}

impl Emit for SphereEmitter {
    #[inline]
    fn sample(&self, hit: &SurfaceHit) -> LightSample {
        self.middle.sample(hit)
    }
}

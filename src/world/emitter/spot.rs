//! Points that emit light within a cone.

use super::point::PointEmitter;
use super::{Emit, LightSample};
use crate::scene::light::{PointLight, SpotLight};
use crate::world::hit::SurfaceHit;

/// A point that shines within a cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpotEmitter {
    middle: PointEmitter,
}

impl SpotEmitter {
    /// The emitter of such a light.
    pub(super) fn new(light: &SpotLight) -> Self {
        Self { middle: PointEmitter::new(&PointLight::new(light.position())) }
    }
}

impl Emit for SpotEmitter {
    #[inline]
    fn sample(&self, hit: &SurfaceHit) -> LightSample {
        self.middle.sample(hit)
    }
}

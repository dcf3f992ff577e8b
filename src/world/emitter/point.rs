//! Points that emit light in all directions.

use super::{Emit, LightSample};
use crate::sampling::Draw;
use crate::scene::light::PointLight;
use crate::world::hit::SurfaceHit;
use glam::DVec3;

/// A point of light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PointEmitter {
    position: DVec3,
}

impl PointEmitter {
    /// The emitter of a point light.
    pub(super) fn new(light: &PointLight) -> Self {
        Self { position: light.position() }
    }
}

impl Emit for PointEmitter {
    #[inline]
    fn sample(&self, hit: &SurfaceHit, _: &Draw) -> LightSample {
        LightSample::of_point(self.position, hit)
    }
}

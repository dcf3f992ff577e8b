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
    /// A light in the very point of the hit is taken to be in the direction of the normal.
    #[inline]
    fn sample(&self, hit: &SurfaceHit, _: &Draw) -> LightSample {
        let way = self.position - hit.point;
        let distance = way.length();
        let inverse = distance.recip();
        let direction = if inverse > 0.0 && inverse.is_finite() { inverse * way } else { hit.shading_normal };
        LightSample::whole(direction, distance)
    }
}

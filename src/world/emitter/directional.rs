//! Light that comes from infinitely far away.

use super::{Emit, INFINITELY_FAR, LightSample};
use crate::sampling::Draw;
use crate::scene::light::DirectionalLight;
use crate::world::hit::SurfaceHit;
use glam::DVec3;

/// Parallel light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DirectionalEmitter {
    /// From every hit to the light, of unit length.
    towards: DVec3,
}

impl DirectionalEmitter {
    /// The emitter of a directional light.
    pub(super) fn new(light: &DirectionalLight) -> Self {
        Self { towards: -light.direction().normalize() }
    }
}

impl Emit for DirectionalEmitter {
    #[inline]
    fn sample(&self, _: &SurfaceHit, _: &Draw) -> LightSample {
        LightSample::whole(self.towards, INFINITELY_FAR)
    }
}

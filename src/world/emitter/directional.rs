//! Light that comes from infinitely far away.

use super::{Emit, LightSample};
use crate::scene::light::DirectionalLight;
use crate::world::hit::SurfaceHit;
use glam::DVec3;

/// The distance of a light that is infinitely far away. Its square fits no `f32`, so that light which gets weaker with
/// the square of the distance is 0.
const INFINITELY_FAR: f64 = 1e30;

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
    fn sample(&self, _: &SurfaceHit) -> LightSample {
        LightSample { direction: self.towards, distance: INFINITELY_FAR }
    }
}

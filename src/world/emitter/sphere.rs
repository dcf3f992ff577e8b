//! Spheres that emit light from all of their surface.

use super::{Emit, LightSample};
use crate::sampling::Draw;
use crate::scene::light::SphereLight;
use crate::world::hit::SurfaceHit;
use glam::DVec3;
use std::f64::consts::TAU;

/// A point light that is spread evenly over a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SphereEmitter {
    center: DVec3,
    radius: f64,
}

impl SphereEmitter {
    /// The emitter of a sphere light.
    pub(super) fn new(light: &SphereLight) -> Self {
        Self { center: light.sphere().center(), radius: light.sphere().radius() }
    }

    /// A point of the surface. Equal areas of the unit square become equal areas of the sphere: the zones between two
    /// parallel planes are as large as the planes are apart (Archimedes).
    fn point(&self, [height, turn]: [f64; 2]) -> DVec3 {
        let y = 1.0 - 2.0 * height;
        let (sine, cosine) = (TAU * turn).sin_cos();
        let parallel = (1.0 - y * y).max(0.0).sqrt();
        self.center + self.radius * DVec3::new(parallel * sine, y, parallel * cosine)
    }
}

impl Emit for SphereEmitter {
    #[inline]
    fn sample(&self, hit: &SurfaceHit, draw: &Draw) -> LightSample {
        LightSample::of_point(self.point(draw.point()), hit)
    }
}

//! Points that emit light within a cone.

use super::{Emit, LightSample};
use crate::sampling::Draw;
use crate::scene::light::SpotLight;
use crate::world::hit::SurfaceHit;
use glam::DVec3;

/// A point that shines within a cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpotEmitter {
    position: DVec3,
    /// The direction of the middle of the cone, of unit length.
    axis: DVec3,
    /// The angle between the axis and the edge, in radians.
    edge: f64,
    /// The angle from which the light gets weaker, in radians, at most `edge`.
    full: f64,
}

impl SpotEmitter {
    /// The emitter of a spot light.
    pub(super) fn new(light: &SpotLight) -> Self {
        Self {
            position: light.position(),
            axis: (light.target() - light.position()).normalize(),
            edge: light.angle().to_radians(),
            full: (light.angle() - light.soft()).to_radians(),
        }
    }

    /// The factor of the light in a direction from the light, of unit length: 1 within the cone, 0 outside, and a
    /// smooth step between them over the soft part.
    fn factor(&self, direction: DVec3) -> f32 {
        // Exact for small angles too, where the cosine is not.
        let angle = self.axis.cross(direction).length().atan2(self.axis.dot(direction));
        if angle <= self.full {
            return 1.0;
        }
        if angle >= self.edge {
            return 0.0;
        }
        let inside = (self.edge - angle) / (self.edge - self.full);
        (inside * inside * (3.0 - 2.0 * inside)) as f32
    }
}

impl Emit for SpotEmitter {
    #[inline]
    fn sample(&self, hit: &SurfaceHit, _: &Draw) -> LightSample {
        let whole = LightSample::of_point(self.position, hit);
        LightSample { radiance: [self.factor(-whole.direction); 3], ..whole }
    }

    /// The soft part of the cone gets less, and formulas that read `visible` are evaluated outside the cone too.
    fn is_whole(&self) -> bool {
        false
    }
}

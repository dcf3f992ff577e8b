//! Rectangles that emit light.

use super::point::PointEmitter;
use super::{Emit, LightSample};
use crate::scene::light::{PointLight, RectangleLight};
use crate::world::hit::SurfaceHit;

/// A point light that is spread over a rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RectangleEmitter {
    middle: PointEmitter,
}

impl RectangleEmitter {
    /// The emitter of such a light.
    pub(super) fn new(light: &RectangleLight) -> Self {
        Self {
            middle: PointEmitter::new(&PointLight::new(light.rectangle().corners()[0].midpoint(light.rectangle().corners()[2]))),
        }
    }
}

impl Emit for RectangleEmitter {
    #[inline]
    fn sample(&self, hit: &SurfaceHit) -> LightSample {
        self.middle.sample(hit)
    }
}

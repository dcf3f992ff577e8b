//! Rectangles that emit light to both sides.

use super::{Emit, LightSample};
use crate::sampling::Draw;
use crate::scene::light::RectangleLight;
use crate::world::hit::SurfaceHit;
use glam::DVec3;

/// A point light that is spread evenly over a rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RectangleEmitter {
    corner: DVec3,
    /// From A to B, and from B to C.
    sides: [DVec3; 2],
}

impl RectangleEmitter {
    /// The emitter of a rectangle light.
    pub(super) fn new(light: &RectangleLight) -> Self {
        let [a, b, c] = light.rectangle().corners();
        Self { corner: a, sides: [b - a, c - b] }
    }
}

impl Emit for RectangleEmitter {
    #[inline]
    fn sample(&self, hit: &SurfaceHit, draw: &Draw) -> LightSample {
        let [along, across] = draw.point();
        LightSample::of_point(self.corner + along * self.sides[0] + across * self.sides[1], hit)
    }
}

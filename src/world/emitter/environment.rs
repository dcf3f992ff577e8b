//! Light that comes from all around.

use super::{Emit, INFINITELY_FAR, LightSample};
use crate::sampling::Draw;
use crate::world::environment::Environment;
use crate::world::hit::SurfaceHit;
use std::f64::consts::PI;

/// The environment: a hit sees one direction of it in each pass, drawn in proportion to the radiance.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EnvironmentEmitter {
    /// `None`: nothing is sent.
    environment: Option<Environment>,
}

impl EnvironmentEmitter {
    /// The emitter of the environment of a scene.
    pub(super) fn new(environment: Option<&Environment>) -> Self {
        Self { environment: environment.cloned() }
    }
}

impl Emit for EnvironmentEmitter {
    /// The sum over all directions is ∫ local·Le dω / π. A direction of density p stands for 1/(π·p) of it, so that a
    /// matte surface under a white environment has its own colour.
    #[inline]
    fn sample(&self, hit: &SurfaceHit, draw: &Draw) -> LightSample {
        let drawn = self.environment.as_ref().and_then(|environment| environment.sample(draw.point()));
        // Of a black environment no direction is drawn. Formulas that are evaluated all the same get that of the
        // normal.
        let (direction, radiance, weight) = drawn.map_or((hit.shading_normal, [0.0; 3], 0.0), |drawn| {
            (drawn.direction, drawn.radiance, (PI * drawn.density).recip() as f32)
        });
        LightSample { direction, distance: INFINITELY_FAR, radiance, weight }
    }

    fn is_whole(&self) -> bool {
        false
    }
}

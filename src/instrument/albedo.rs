//! How much light a model reflects, by the angle of the light.

use crate::instrument::Reflectance;
use crate::instrument::hemisphere::{HemisphereIntegral, Integration, integrate};
use rayon::prelude::*;

/// How wrong a share of the light may be.
pub const ACCURACY: f64 = 2e-4;
/// Of two models, or of a model in two directions, shares that differ by less are called equal.
pub const EQUAL: f64 = 1e-3;
/// The greatest share of the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreatestAlbedo {
    /// The share.
    pub share: f64,
    /// How wrong it may be.
    pub error: f64,
    /// Its component: 0 red, 1 green, 2 blue.
    pub component: usize,
    /// Polar angle and azimuth of the fixed direction, in degrees.
    pub angles: [f64; 2],
    /// The polar angles in degrees from which and to which the share is above 1 at this azimuth; none if nowhere.
    pub above_one: Option<[f64; 2]>,
}

/// The component with the greatest share; of equal ones the first.
pub fn greatest_component(integral: &HemisphereIntegral) -> (usize, f64) {
    let components = integral.value.iter().copied().enumerate().rev();
    components.max_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0, 0.0))
}

/// The integrals for fixed directions with these polar angles and azimuths in degrees.
pub fn albedos(model: &dyn Reflectance, over: Integration, angles: &[[f64; 2]]) -> Vec<HemisphereIntegral> {
    angles.par_iter().map(|angles| integrate(model, over, *angles, ACCURACY)).collect()
}

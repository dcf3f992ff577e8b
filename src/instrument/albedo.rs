//! How much light a model reflects, by the angle of the light.

use crate::instrument::direction::STEEPEST;
use crate::instrument::hemisphere::{HemisphereIntegral, Integration, integrate};
use crate::instrument::{DirectionPair, Reflectance};
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
    /// The most that a share may be that was integrated with full care: the greatest sum of a share and its error.
    pub at_most: f64,
    /// Its component: 0 red, 1 green, 2 blue.
    pub component: usize,
    /// Polar angle and azimuth of the fixed direction, in degrees.
    pub angles: [f64; 2],
    /// The pair of directions that adds most to the share.
    pub top: Option<DirectionPair>,
    /// The polar angles in degrees from which and to which the share is above 1 at this azimuth; none if nowhere.
    pub above_one: Option<[f64; 2]>,
}

impl GreatestAlbedo {
    /// Whether its error reaches so far across 1 that nothing can be told.
    pub fn is_uncertain(&self) -> bool {
        self.above_one.is_none() && self.at_most > 1.0 + EQUAL
    }

    /// Whether it is at the greatest angle that is looked at, so it may be greater beyond.
    pub fn is_at_end(&self) -> bool {
        self.angles[0] > STEEPEST - 1e-3
    }

    /// Takes shares into account that were integrated with full care, so that none of them is greater.
    pub fn raised(mut self, shares: &[SharePlace]) -> Self {
        for place in shares {
            let (component, share) = greatest_component(&place.integral);
            if share > self.share {
                (self.share, self.error, self.component, self.angles) = (share, place.integral.error, component, place.angles);
                self.top = place.integral.top.map(|(pair, _)| pair);
            }
            self.at_most = self.at_most.max(share + place.integral.error);
            let polar = place.angles[0];
            if let Some([from, to]) = self.above_one.filter(|_| place.is_above(0.0)) {
                self.above_one = Some([from.min(polar), to.max(polar)]);
            } else if place.is_above(0.0) {
                self.above_one = Some([polar; 2]);
            }
        }
        self
    }
}

/// A share at a polar angle and an azimuth in degrees.
#[derive(Debug, Clone)]
pub struct SharePlace {
    /// The polar angle and the azimuth.
    pub angles: [f64; 2],
    /// The share.
    pub integral: HemisphereIntegral,
}

impl SharePlace {
    /// The share of the component where it is greatest.
    pub fn share(&self) -> f64 {
        greatest_component(&self.integral).1
    }

    /// Whether a share of this component may be the same as another one, by the errors of both. It may be anything if
    /// values are missing.
    pub fn agrees_with(&self, share: f64, error: f64, component: usize) -> bool {
        let own = self.integral.value[component];
        self.integral.not_finite.is_some()
            || (own - share).abs() <= 2.0 * (self.integral.error + error) + EQUAL * own.abs().max(share.abs()).max(1.0)
    }

    /// Whether it is above 1, whatever its error, and whatever part of it may be wrong beside that.
    pub fn is_above(&self, part: f64) -> bool {
        self.share() > 1.0 + (self.integral.error + part * self.share()).max(0.5 * EQUAL)
    }
}

/// The component with the greatest share; of equal ones the first.
pub fn greatest_component(integral: &HemisphereIntegral) -> (usize, f64) {
    let components = integral.value.iter().copied().enumerate().rev();
    components.max_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0, 0.0))
}

/// The shares for fixed directions with these polar angles and azimuths in degrees, with full care.
pub fn shares_at(model: &dyn Reflectance, over: Integration, angles: &[[f64; 2]]) -> Vec<SharePlace> {
    let integrals = albedos(model, over, angles);
    angles.iter().zip(integrals).map(|(angles, integral)| SharePlace { angles: *angles, integral }).collect()
}

/// The integrals for fixed directions with these polar angles and azimuths in degrees.
pub fn albedos(model: &dyn Reflectance, over: Integration, angles: &[[f64; 2]]) -> Vec<HemisphereIntegral> {
    angles.par_iter().map(|angles| integrate(model, over, *angles, ACCURACY)).collect()
}

//! The pairs of directions at which a material is compared with a formula.
//!
//! They are spread as the samples of a MERL file are (Matusik, Pfister, Brand and McMillan 2003): over the half and
//! difference angles of Rusinkiewicz (1998), dense around the highlight. Each pair counts as much as the solid angles
//! that it stands for.

use crate::instrument::DirectionPair;
use crate::sampling::EvenSequence;
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::RangeInclusive;

/// Beyond this angle to the normal, in degrees, measured data are not reliable (Ngan, Durand and Matusik 2005).
pub const LARGEST_ANGLE: f64 = 80.0;

/// How many pairs there are if nobody says.
pub const USUAL_PAIRS: usize = 10_000;

/// How many pairs can be asked for.
pub const PAIR_COUNTS: RangeInclusive<usize> = 100..=1_000_000;

/// Up to which angles from the normal pairs can be asked for, in degrees.
pub const PAIR_ANGLES: RangeInclusive<u32> = 10..=89;

/// A pair of directions, and what it counts: the product of the solid angles of both, in steradians squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedPair {
    /// The directions.
    pub pair: DirectionPair,
    /// What it counts.
    pub weight: f64,
}

/// About this many pairs with both directions within `largest` degrees of the normal, the same at every call. Their
/// weights add up to the square of the solid angle of that cap.
pub fn pairs(count: usize, largest: f64) -> Vec<WeightedPair> {
    let sequence = EvenSequence::new(4);
    let limit = largest.to_radians().cos();
    let mut found = Vec::with_capacity(count);
    let mut tried = 0_u32;
    while found.len() < count && (tried as usize) < 64 * count.max(16) {
        tried += 1;
        let [root, half_turn, difference, turn] = sequence.point(tried);
        let (half, half_azimuth) = (FRAC_PI_2 * root * root, TAU * half_turn);
        let (difference, azimuth) = (FRAC_PI_2 * difference, TAU * turn);
        let [light, view] = from_half_difference(half, half_azimuth, difference, azimuth);
        if light.z < limit || view.z < limit {
            continue;
        }
        // dω of both = 4 · cos θd · sin θd · sin θh · dθh · dφh · dθd · dφd.
        let density = PI * root * TAU * FRAC_PI_2 * TAU;
        let weight = 4.0 * difference.cos() * difference.sin() * half.sin() * density;
        found.push(WeightedPair { pair: DirectionPair { light: light.as_vec3().into(), view: view.as_vec3().into() }, weight });
    }
    let tried = f64::from(tried.max(1));
    found.iter_mut().for_each(|pair| pair.weight /= tried);
    found
}

/// Light and view from half and difference angles, in radians (Rusinkiewicz 1998, section 3).
fn from_half_difference(half: f64, half_azimuth: f64, difference: f64, azimuth: f64) -> [DVec3; 2] {
    let around = DMat3::from_rotation_z(half_azimuth) * DMat3::from_rotation_y(half);
    let (sine, cosine) = difference.sin_cos();
    let light = around * DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine);
    let middle = around * DVec3::Z;
    [light, 2.0 * middle.dot(light) * middle - light]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_add_up_to_the_square_of_the_cap() {
        for largest in [30.0, 60.0, 80.0] {
            let cap = TAU * (1.0 - f64::to_radians(largest).cos());
            let sum: f64 = pairs(40_000, largest).iter().map(|pair| pair.weight).sum();
            assert!((sum / (cap * cap) - 1.0).abs() < 0.01, "{largest}: {sum} {}", cap * cap);
        }
    }

    #[test]
    fn pairs_integrate_functions_of_both_directions() {
        // The integral of cos θ over both hemispheres is π each, and of (H·N)² it is less.
        let pairs = pairs(40_000, 89.999);
        let sum: f64 = pairs.iter().map(|pair| pair.weight * f64::from(pair.pair.light[2] * pair.pair.view[2])).sum();
        assert!((sum / (PI * PI) - 1.0).abs() < 0.01, "{sum}");
        assert!(pairs.len() == 40_000 && pairs.iter().all(|pair| pair.weight > 0.0));
    }
}

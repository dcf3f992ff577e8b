//! Whether a model is reciprocal: whether light takes the same way back.

use crate::instrument::direction::brdf;
use crate::instrument::{DirectionPair, Reflectance};

/// Values below this part of the greatest one are not compared: there, rounding is most of the difference.
pub(super) const FAINTEST: f64 = 1e-5;

/// Where a model is least reciprocal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReciprocityError {
    /// The difference of both values, relative to the greater one: 0 to 1, or 2 if they have different signs.
    pub error: f64,
    /// The directions, as they were taken first.
    pub pair: DirectionPair,
}

/// The difference of two values relative to the greater one, for the component where it is largest. None if a value is
/// not finite.
pub(super) fn difference(one: &[f64; 3], other: &[f64; 3], faintest: f64) -> Option<f64> {
    let of_component = |(one, other): (&f64, &f64)| {
        let scale = one.abs().max(other.abs());
        if scale <= faintest { 0.0 } else { (one - other).abs() / scale }
    };
    let is_finite = one.iter().chain(other).all(|value| value.is_finite());
    is_finite.then(|| one.iter().zip(other).map(of_component).fold(0.0, f64::max))
}

/// The relative difference of the BRDF of each pair and the exchanged pair, for the component where it is largest. NaN
/// where one of both is not finite.
pub fn differences(model: &dyn Reflectance, pairs: &[DirectionPair]) -> Vec<f64> {
    let back: Vec<DirectionPair> = pairs.iter().map(DirectionPair::exchanged).collect();
    let brdfs = |pairs: &[DirectionPair]| -> Vec<[f64; 3]> {
        pairs.iter().zip(model.values(pairs)).map(|(pair, value)| brdf(pair, value)).collect()
    };
    let (there, back) = (brdfs(pairs), brdfs(&back));
    let all = there.iter().chain(&back).flatten();
    let greatest = all.filter(|value| value.is_finite()).fold(0.0_f64, |greatest, value| greatest.max(value.abs()));
    let of_pair = |(there, back): (&[f64; 3], &[f64; 3])| difference(there, back, FAINTEST * greatest).unwrap_or(f64::NAN);
    there.iter().zip(&back).map(of_pair).collect()
}

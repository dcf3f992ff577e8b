//! The error that single precision adds to an integral.
//!
//! A difference of nearly equal numbers has few correct digits. Where a narrow lobe is computed from `1 − (N.H)²`, all
//! its values may be wrong in the same direction, and so is the integral. Double precision tells by how much.

use crate::instrument::{DirectionPair, Reflectance};

/// A point of an integral.
pub(super) struct WeighedPair {
    pub(super) pair: DirectionPair,
    /// The integral is the mean of values times weights.
    pub(super) weight: f64,
}

/// The error of an integral by rounding: the mean difference of both precisions at these points, plus twice its
/// standard error. 0 if the model has only one precision.
pub(super) fn error_of_rounding(model: &dyn Reflectance, points: &[WeighedPair]) -> f64 {
    let pairs: Vec<DirectionPair> = points.iter().map(|point| point.pair).collect();
    let Some(exact) = model.exact_values(&pairs) else { return 0.0 };
    let values = model.values(&pairs);
    let of_component = |component: usize| {
        let differences = points.iter().zip(values.iter().zip(&exact)).map(|(point, (value, exact))| {
            let difference = point.weight * (f64::from(value[component]) - exact[component]);
            if difference.is_finite() { difference } else { 0.0 }
        });
        let count = points.len().max(2) as f64;
        let (sum, squares) = differences.fold((0.0, 0.0), |(sum, squares), one| (sum + one, squares + one * one));
        let mean = sum / count;
        let variance = (squares / count - mean * mean).max(0.0);
        mean.abs() + 2.0 * (variance / (count - 1.0)).sqrt()
    };
    (0..3).map(of_component).fold(0.0, f64::max)
}

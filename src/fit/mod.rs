//! Fitting: values of parameters with which a formula comes near to data.
//!
//! [`unknowns`] says which numbers may move, within their ranges and invariants. A [`Misfit`] says how far the formula
//! is from the data, with derivatives: [`samples`] for reflectance at pairs of directions, [`picture`] for a picture of
//! the same scene. [`solve`] minimises it by the method of Levenberg and Marquardt from several starts.
//! [`directions`] chooses where a measured material is compared, and [`metric`] how. [`request`] knows the values of a
//! project, and makes the misfits for them.
//!
//! [`words`] and [`charts`] say what came out. Where that is shown is not known here.

mod certainty;
#[cfg(feature = "plot")]
pub mod charts;
pub mod directions;
pub mod metric;
pub mod normal;
pub mod picture;
pub mod request;
pub mod samples;
pub mod solve;
pub mod unknowns;
pub mod words;

use crate::fit::normal::NormalEquations;

/// How far a formula is from data, for values of its unknown numbers.
pub trait Misfit: Sync {
    /// The residuals at these values and their derivatives by each of them, multiplied out and added to `none`, which
    /// has no data.
    fn evaluate_into(&self, values: &[f64], none: &NormalEquations) -> NormalEquations;

    /// The residuals at these values and their derivatives by each of them, multiplied out.
    fn evaluate(&self, values: &[f64]) -> NormalEquations {
        self.evaluate_into(values, &NormalEquations::new(values.len()))
    }
}

#[cfg(test)]
mod tests;

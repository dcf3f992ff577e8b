//! Instruments: what a model of reflection is, as numbers. They look at the formula itself, without rays: at its value
//! for pairs of directions.
//!
//! [`model`] evaluates a formula, and its derivatives, for many pairs of directions at once. [`hemisphere`] integrates,
//! `rounding` judges single precision, [`survey`] looks at pairs all over, [`search`] finds the greatest share,
//! `closer` looks where a model is narrow, and [`measurement`] says what there is to say about a model. [`view`] makes
//! charts of it. Files are not known here.

pub mod albedo;
mod closer;
pub mod direction;
#[cfg(feature = "plot")]
mod draft;
pub mod expressions;
pub mod held;
pub mod hemisphere;
pub mod measured;
pub mod measurement;
pub mod model;
mod peaks;
pub mod reciprocity;
mod rounding;
pub mod search;
pub mod survey;
#[cfg(feature = "plot")]
pub mod view;

/// Directions of light and viewer in the frame of the surface: normal +z, tangent +x, bitangent +y. Both have unit
/// length and point away from the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionPair {
    /// To the light.
    pub light: [f32; 3],
    /// To the viewer.
    pub view: [f32; 3],
}

impl DirectionPair {
    /// The same directions with light and viewer exchanged.
    pub fn exchanged(&self) -> Self {
        Self { light: self.view, view: self.light }
    }
}

/// A model of reflection that instruments look at.
pub trait Reflectance: Send + Sync {
    /// For each pair of directions π · f · cos θ in linear RGB, where f is the BRDF in 1/sr and θ the angle between
    /// normal and light. This is the value of a formula for white light of intensity 1 (IL = ki = 1).
    fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]>;

    /// The same in double precision, for the directions made exactly as long as 1. It takes microseconds for each pair,
    /// and judges what rounding does to the values. None if the model knows no other precision.
    fn exact_values(&self, _pairs: &[DirectionPair]) -> Option<Vec<[f64; 3]>> {
        None
    }
}

#[cfg(test)]
pub(crate) mod tests;

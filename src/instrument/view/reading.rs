//! The numbers of models for single pairs of directions: one viewer, and each light of a view.

use crate::instrument::view::settings::{NamedModel, Shown, ViewSettings};

/// The numbers of a model for light from one angle, and one viewer.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectionReading {
    /// The index of the model.
    pub model: usize,
    /// The polar angle of the light, in degrees.
    pub light: f64,
    /// The BRDF in 1/sr.
    pub brdf: [f64; 3],
    /// The value of the formula for white light: π · BRDF · cos θ of the light.
    pub value: [f64; 3],
}

/// The numbers of all models for each of the lights of the settings, and a viewer at an angle in the plane of outgoing
/// directions, in degrees: positive at the side of the mirror direction.
pub fn readings(models: &[NamedModel], settings: &ViewSettings, viewer: f64) -> Vec<DirectionReading> {
    let mut found = Vec::new();
    for (model, named) in models.iter().enumerate() {
        for light in &settings.light_polar {
            let pairs = [settings.pair(*light, viewer)];
            let numbers = |shown: Shown| shown.of(named.model.as_ref(), &pairs).first().copied().unwrap_or([f64::NAN; 3]);
            let [brdf, value] = [Shown::Brdf, Shown::Value].map(numbers);
            found.push(DirectionReading { model, light: *light, brdf, value });
        }
    }
    found
}

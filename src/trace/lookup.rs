//! The variables of the language: which number of a hit each of them is.

use crate::lang::variables::Variable;
use crate::trace::{HitVariables, LightVariables};

impl HitVariables {
    /// The value of a variable of the hit, a scalar three times; `None` for a variable that depends on the light too.
    pub fn value(&self, variable: Variable) -> Option<[f32; 3]> {
        Some(match variable {
            Variable::Normal => self.normal.to_array(),
            Variable::ToViewer => self.view.to_array(),
            Variable::Gamma => [self.gamma; 3],
            Variable::Point => self.point.to_array(),
            Variable::Tangent => self.tangent.to_array(),
            Variable::Bitangent => self.bitangent.to_array(),
            Variable::GeometricNormal => self.geometric_normal.to_array(),
            Variable::SurfaceU => [self.coordinates.x; 3],
            Variable::SurfaceV => [self.coordinates.y; 3],
            Variable::RelativeIndex => [self.relative_index; 3],
            Variable::TotalReflection => [self.total_reflection; 3],
            Variable::ToLight
            | Variable::Mirrored
            | Variable::Alpha
            | Variable::Beta
            | Variable::Halfway
            | Variable::Distance
            | Variable::Visible
            | Variable::Radiance
            | Variable::SampleWeight
            | Variable::WeightedRadiance => return None,
        })
    }
}

/// The value of any variable at a hit for a light, a scalar three times. Units and ranges are those of
/// [`HitVariables`] and [`LightVariables`].
pub fn variable(variable: Variable, hit: &HitVariables, light: &LightVariables) -> [f32; 3] {
    match variable {
        Variable::ToLight => light.light.to_array(),
        Variable::Mirrored => light.mirrored.to_array(),
        Variable::Alpha => [light.alpha; 3],
        Variable::Beta => [light.beta; 3],
        Variable::Halfway => light.half.to_array(),
        Variable::Distance => [light.distance; 3],
        Variable::Visible => [light.visible; 3],
        Variable::Radiance => light.radiance.to_array(),
        Variable::SampleWeight => [light.weight; 3],
        Variable::WeightedRadiance => (light.weight * light.radiance).to_array(),
        Variable::Normal
        | Variable::ToViewer
        | Variable::Gamma
        | Variable::Point
        | Variable::Tangent
        | Variable::Bitangent
        | Variable::GeometricNormal
        | Variable::SurfaceU
        | Variable::SurfaceV
        | Variable::RelativeIndex
        | Variable::TotalReflection => hit.value(variable).unwrap_or_default(),
    }
}

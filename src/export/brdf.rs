//! Files of BRDF Explorer (Walt Disney Animation Studios): parameters, and a function in GLSL.
//!
//! A model there is a bidirectional reflectance distribution function. A formula gives the light that leaves a hit.
//! That is the function times the cosine of the angle between normal and light, and times π: a white matte surface is
//! 1 here, not 1/π.

use crate::export::parameters::{ParameterBlock, note};
use crate::lang::types::Type;
use crate::lang::variables::Variable;
use std::fmt::Write;

/// Why a formula cannot be written in a language.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// The formula reads a variable that the language does not know.
    #[error("the formula reads `{0}`, which BRDF Explorer does not have")]
    Variable(&'static str),
    /// The formula has a texture, and the language has none.
    #[error("the formula has the texture `{0}`, and BRDF Explorer has none")]
    Texture(String),
    /// The formula has a measured material, and other languages have none.
    #[error("the formula has the measured material `{0}`, which cannot be exported")]
    Measured(String),
}

/// The function that BRDF Explorer calls, for a function of a formula with these arguments.
///
/// # Errors
/// One of them is not known there.
pub(super) fn entry(function: &str, arguments: &[Variable]) -> Result<String, ExportError> {
    let given = |variable: &Variable| match variable {
        Variable::Normal | Variable::GeometricNormal => Ok("N"),
        Variable::ToLight => Ok("L"),
        Variable::ToViewer => Ok("V"),
        Variable::Tangent => Ok("X"),
        Variable::Visible => Ok("1.0"),
        other @ (Variable::Mirrored
        | Variable::Alpha
        | Variable::Beta
        | Variable::Gamma
        | Variable::Point
        | Variable::RelativeIndex
        | Variable::TotalReflection
        | Variable::Halfway
        | Variable::Bitangent
        | Variable::SurfaceU
        | Variable::SurfaceV
        | Variable::Distance
        | Variable::Radiance
        | Variable::SampleWeight
        | Variable::WeightedRadiance) => Err(ExportError::Variable(other.name())),
    };
    let arguments = arguments.iter().map(given).collect::<Result<Vec<_>, _>>()?;
    Ok(format!(
        "// What BRDF Explorer plots: the light without the cosine, over pi.\n\
         vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) {{\n    float cosine = dot(N, L);\n    \
         if (cosine <= 0.0) {{ return vec3(0.0, 0.0, 0.0); }}\n    \
         return {function}({}) / (3.14159265 * cosine);\n}}\n",
        arguments.join(", ")
    ))
}

/// The file with this header, in which comments begin with `//`.
///
/// # Errors
/// A parameter is a texture.
pub(super) fn file(header: &str, block: &ParameterBlock, shader: &str) -> Result<String, ExportError> {
    let mut text = format!(
        "analytic\n\n{}\n::begin parameters\n",
        header.lines().map(|line| line.replacen("//", "#", 1) + "\n").collect::<String>()
    );
    for (id, name) in &block.members {
        let parameter = block.formula.parameter(*id);
        // A slider has ends.
        let default = parameter.default[0];
        let end = (2.0 * default.abs().max(0.5)).min(f32::MAX);
        let [low, high] = parameter.range.unwrap_or(if default < 0.0 { [-end, 0.0] } else { [0.0, end] });
        let [first, second, third] = parameter.default;
        let line = match parameter.ty {
            Type::Vector => format!("color {name} {first} {second} {third}"),
            Type::Scalar | Type::Truth if parameter.switch => format!("bool {name} {}", u8::from(first != 0.0)),
            Type::Scalar | Type::Truth => format!("float {name} {low} {high} {first}"),
            Type::Texture => return Err(ExportError::Texture(parameter.name.clone())),
        };
        // Writing to a string does not fail.
        let _ = writeln!(text, "# {}\n{line}", note(parameter));
    }
    Ok(format!("{text}::end parameters\n\n::begin shader\n\n{shader}\n::end shader\n"))
}

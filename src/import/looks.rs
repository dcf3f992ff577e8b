//! Values of bodies from the materials of files.
//!
//! Materials of glTF become values of the formula `openpbr`, which has their parameters. Those of MTL files become
//! values of `blinn-phong`, which is what the format describes. Mirrors and glass become kr and kt.

use crate::lang::ast::Constant;
use crate::mesh::{ModelLook, PhongLook, PhysicalLook};

/// The built-in formula for materials of glTF.
pub(super) const PHYSICAL_FORMULA: &str = "openpbr";
/// The built-in formula for materials of MTL files.
pub(super) const PHONG_FORMULA: &str = "blinn-phong";

/// Weaker reflections are left out, so that their rays need not be traced.
const WEAKEST: f64 = 0.01;
/// Values are written with four digits behind the point.
const STEPS: f64 = 1e4;

/// How a body looks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ImportedLook {
    /// The values for the session, by parameter.
    pub(super) values: Vec<(&'static str, Constant)>,
    /// The index of refraction, if light passes the body.
    pub(super) refractive_index: Option<f64>,
    pub(super) is_opaque: bool,
    pub(super) is_matte: bool,
}

impl ImportedLook {
    /// The look of a material; without one, that of the defaults of the formula.
    pub(super) fn new(look: Option<&ModelLook>) -> Self {
        match look {
            Some(ModelLook::Physical(look)) => physical(look),
            Some(ModelLook::Phong(look)) => phong(look),
            None => Self { values: Vec::new(), refractive_index: None, is_opaque: true, is_matte: true },
        }
    }

    fn with_rays(mut values: Vec<(&'static str, Constant)>, weights: RayWeights, index: f64) -> Self {
        let RayWeights { kr, kt } = weights;
        let given = [("kr", kr), ("kt", kt)].into_iter().filter(|(_, weight)| *weight > 0.0);
        values.extend(given.map(|(name, weight)| (name, Constant::Scalar(weight as f32))));
        Self { values, refractive_index: (kt > 0.0).then_some(index), is_opaque: kt == 0.0, is_matte: kr == 0.0 }
    }
}

/// The weights of reflected and refracted rays, 1 together at most.
#[derive(Clone, Copy)]
struct RayWeights {
    kr: f64,
    kt: f64,
}

impl RayWeights {
    fn new(kr: f64, kt: f64) -> Self {
        let kr = if kr < WEAKEST { 0.0 } else { rounded(kr) };
        Self { kr, kt: complement(kt, kr) }
    }
}

/// A material of glTF. Rough surfaces have no clear mirror image, so kr falls with the square of the smoothness.
fn physical(look: &PhysicalLook) -> ImportedLook {
    let [metallic, roughness, coverage, transmission] =
        [look.metallic, look.roughness, look.coverage, look.transmission].map(|share| share.clamp(0.0, 1.0));
    let index = at_least_one(look.index);
    // What is blended is a veil. Neither it nor a thin pane bends light.
    let is_veil = coverage < 1.0;
    let passes = if is_veil { 1.0 - coverage } else { transmission * (1.0 - metallic) };
    let of_metal = metallic * brightest(look.base);
    let of_glass = if passes > 0.0 && !is_veil { (1.0 - metallic) * reflectance(index) } else { 0.0 };
    let weights = RayWeights::new((of_metal + of_glass) * (1.0 - roughness).powi(2), passes);
    let mut values = vec![("Cd", color(look.base)), ("specular_roughness", scalar(roughness))];
    let mut put = |name: &'static str, value: f64, default: f64| {
        if differs(value, default) {
            values.push((name, scalar(value)));
        }
    };
    put("base_weight", 1.0 - passes, 1.0);
    put("base_metalness", metallic, 0.0);
    put("specular_weight", look.specular, 1.0);
    put("coat_weight", look.coat, 0.0);
    if look.coat > 0.0 {
        put("coat_roughness", look.coat_roughness, 0.1);
    }
    let index_of_highlights = index.min(3.0);
    if index_of_highlights != 1.5 {
        values.push(("specular_ior", Constant::Scalar(((index_of_highlights * STEPS).round() / STEPS) as f32)));
    }
    if look.specular_color != [1.0; 3] {
        values.push(("specular_color", color(look.specular_color)));
    }
    ImportedLook::with_rays(values, weights, if is_veil || look.is_thin { 1.0 } else { index })
}

/// A material of an MTL file. The sum of kd and ks is 1 at most, so the matte part gives way.
fn phong(look: &PhongLook) -> ImportedLook {
    let ks = rounded(brightest(look.specular));
    let index = look.index.filter(|index| *index > 0.0).unwrap_or(1.0);
    // 6 and 7 refract; in all others, only d lets light pass.
    let filtered = if matches!(look.illumination, 6 | 7) { brightest(look.filter) } else { 0.0 };
    let passes = (1.0 - look.coverage.clamp(0.0, 1.0)).max(filtered);
    // 3 to 9 reflect other bodies.
    let mirrored = match look.illumination {
        3..=9 if passes > 0.0 => reflectance(index),
        3..=9 => ks,
        _ => 0.0,
    };
    let weights = RayWeights::new(mirrored, passes);
    let kd = complement(1.0 - weights.kt, ks);
    let mut values = vec![("Cd", color(look.diffuse)), ("kd", scalar(kd)), ("ks", scalar(ks))];
    if ks > 0.0 {
        values.push(("Cs", color(look.specular.map(|component| component / ks))));
        values.push(("h", Constant::Scalar(look.sharpness.clamp(1.0, 1000.0) as f32)));
    }
    ImportedLook::with_rays(values, weights, index)
}

/// The share of light that a smooth surface of this index reflects straight back (Fresnel's law).
fn reflectance(index: f64) -> f64 {
    ((index - 1.0) / (index + 1.0)).powi(2)
}

/// An index of refraction. glTF allows 0, which stands for no refraction.
fn at_least_one(index: f64) -> f64 {
    if index >= 1.0 { index } else { 1.0 }
}

fn brightest(color: [f64; 3]) -> f64 {
    color.into_iter().fold(0.0, f64::max).min(1.0)
}

fn rounded(share: f64) -> f64 {
    (share.clamp(0.0, 1.0) * STEPS).round() / STEPS
}

/// Whether a share is written, because it is not the default.
fn differs(share: f64, default: f64) -> bool {
    rounded(share) != default
}

/// As much of a share as another one leaves of 1.
fn complement(share: f64, taken: f64) -> f64 {
    rounded(share).min(rounded(1.0 - taken))
}

fn scalar(share: f64) -> Constant {
    Constant::Scalar(rounded(share) as f32)
}

fn color(color: [f64; 3]) -> Constant {
    Constant::Vector(color.map(|component| rounded(component) as f32))
}

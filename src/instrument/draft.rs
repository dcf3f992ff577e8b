//! Quick integrals over the hemisphere, for charts that follow a slider: always at the same points, and within a tenth
//! for usual models. [`hemisphere`](super::hemisphere) has the accurate ones.
//!
//! The points are spread over the hemisphere by the cosine, and around the mirror direction and the direction of the
//! light itself, the denser the nearer. Each counts by the density of all of these together (the balance heuristic of
//! Veach and Guibas 1995), so a lobe is sampled well wherever it is, and the points do not depend on the model.

use crate::instrument::Reflectance;
use crate::instrument::direction::{STEEPEST, direction};
use crate::instrument::hemisphere::{Integration, values_of_all};
use crate::sampling::EvenSequence;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Points by each way of spreading.
const POINTS: u32 = 384;
/// What cosines to the power of this are for: the sharpest lobes that are sampled well, and wider ones.
const EXPONENTS: [f64; 3] = [30.0, 600.0, 12_000.0];

/// The shares for fixed directions, each with polar angle and azimuth in degrees.
pub(super) fn shares(model: &dyn Reflectance, over: Integration, angles: &[[f64; 2]]) -> Vec<[f64; 3]> {
    // Directions with the same polar angle have the same points, turned about the normal.
    let mut polars: Vec<f64> = angles.iter().map(|[polar, _]| polar.min(STEEPEST)).collect();
    polars.sort_by(f64::total_cmp);
    polars.dedup();
    let sets: Vec<Vec<(DVec3, f64)>> = polars.par_iter().map(|polar| points(direction(*polar, 0.0))).collect();
    let set = |polar: f64| &sets[polars.partition_point(|other| *other < polar.min(STEEPEST))];
    let turned = |[polar, azimuth]: &[f64; 2]| {
        let turn = DMat3::from_rotation_z(azimuth.to_radians());
        let fixed = turn * direction(polar.min(STEEPEST), 0.0);
        set(*polar).iter().map(move |(moving, _)| [fixed, turn * *moving])
    };
    let directions: Vec<[DVec3; 2]> = angles.iter().flat_map(turned).collect();
    let mut values = values_of_all(model, over, &directions).into_iter();
    let share = |[polar, _]: &[f64; 2]| {
        let mut sum = [0.0; 3];
        for ((_, weight), value) in set(*polar).iter().zip(values.by_ref()) {
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    };
    angles.iter().map(share).collect()
}

/// Directions above the horizon, with the solid angles that they stand for.
fn points(fixed: DVec3) -> Vec<(DVec3, f64)> {
    let mirrored = DVec3::new(-fixed.x, -fixed.y, fixed.z);
    let lobes: Vec<(DMat3, f64)> =
        EXPONENTS.iter().map(|exponent| (frame(mirrored), *exponent)).chain([(frame(fixed), EXPONENTS[1])]).collect();
    // The density of the cosine, and of a power of the cosine around each lobe.
    let density = |at: DVec3| {
        let around = |(frame, exponent): &(DMat3, f64)| (exponent + 1.0) / TAU * frame.z_axis.dot(at).max(0.0).powf(*exponent);
        at.z / PI + lobes.iter().map(around).sum::<f64>()
    };
    let mut found = Vec::with_capacity(POINTS as usize * (lobes.len() + 1));
    for index in 0..POINTS {
        let [share, around] = EvenSequence::SQUARE.point(index);
        let turn = TAU * around;
        let spread = |frame: DMat3, height: f64| {
            let radius = (1.0 - height * height).max(0.0).sqrt();
            frame * DVec3::new(radius * turn.cos(), radius * turn.sin(), height)
        };
        let even = spread(DMat3::IDENTITY, (1.0 - share).sqrt());
        let around = lobes.iter().map(|(frame, exponent)| spread(*frame, (1.0 - share).powf(1.0 / (exponent + 1.0))));
        found.extend(std::iter::once(even).chain(around).filter(|at| at.z > 1e-4));
    }
    found.into_iter().map(|at| (at, 1.0 / (f64::from(POINTS) * density(at)))).collect()
}

/// A frame whose third axis is a direction.
fn frame(axis: DVec3) -> DMat3 {
    let (one, other) = axis.any_orthonormal_pair();
    DMat3::from_cols(one, other, axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::instrument::hemisphere::integrate;
    use crate::instrument::model::{FormulaModel, ModelProgram, Place, default_numbers};
    use crate::lang::source::Source;
    use std::sync::Arc;

    fn model(text: &str) -> FormulaModel {
        let (formula, _) = Formula::parse(&Source::new("test", format!("formula; {text}"))).unwrap();
        FormulaModel::new(Arc::new(ModelProgram::new(&formula)), default_numbers(&formula), Place::default())
    }

    #[test]
    fn drafts_are_near_the_integrals_for_matte_and_glossy_models() {
        let texts = [
            "= IL*0.8*Cd*max(0, N.L);",
            "a = 0.05; D = a^2/(pi*((N.H)^2*(a^2 - 1) + 1)^2); G(x) = 2/(1 + sqrt(1 + a^2*(1 - x^2)/x^2)); \
             = IL*<pi*D*G(N.L)*G(N.V)/(4*(N.V))>;",
            "= IL*<(30 + 2)/2*max(0, R.V)^30>*max(0, N.L);",
            "= IL*<(200 + 2)/2*max(0, L.V)^200>*max(0, N.L);",
        ];
        for text in texts {
            let model = model(text);
            let angles = [[0.0, 0.0], [30.0, 0.0], [60.0, 90.0], [80.0, 10.0]];
            for over in [Integration::OverViews, Integration::OverLights] {
                for (angles, draft) in angles.iter().zip(shares(&model, over, &angles)) {
                    let wanted = integrate(&model, over, *angles, 1e-3).value[0];
                    assert!((draft[0] - wanted).abs() < 0.08 * wanted.max(0.1), "{text} at {angles:?}: {} {wanted}", draft[0]);
                }
            }
        }
    }
}

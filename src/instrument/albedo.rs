//! How much light a model reflects, by the angle of the light; and where that is most.

use crate::instrument::direction::{STEEPEST, direction, pair};
use crate::instrument::hemisphere::{HemisphereIntegral, Integration, integrate};
use crate::instrument::{DirectionPair, Reflectance};
use glam::{DQuat, DVec3};
use rayon::prelude::*;

/// How wrong a share of the light may be.
pub const ACCURACY: f64 = 2e-4;
/// Of two models, or of a model in two directions, shares that differ by less are called equal.
pub const EQUAL: f64 = 1e-3;
/// The polar angles at which the greatest share is looked for, in degrees.
const SEARCHED: [f64; 23] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0, 80.0, 84.0, 87.0, 88.5, 89.5,
    89.9, STEEPEST,
];
/// The azimuths at which a model is looked at that depends on them.
const AZIMUTHS: [f64; 4] = [0.0, 45.0, 90.0, 135.0];

/// The greatest share of the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GreatestAlbedo {
    /// The share.
    pub share: f64,
    /// How wrong it may be.
    pub error: f64,
    /// Its component: 0 red, 1 green, 2 blue.
    pub component: usize,
    /// Polar angle and azimuth of the fixed direction, in degrees.
    pub angles: [f64; 2],
    /// The polar angle from which the share is above 1, in degrees, if it is anywhere.
    pub above_one_from: Option<f64>,
}

/// The component with the greatest share; of equal ones the first.
pub fn greatest_component(integral: &HemisphereIntegral) -> (usize, f64) {
    let components = integral.value.iter().copied().enumerate().rev();
    components.max_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0, 0.0))
}

/// Whether the values of a model change when both directions turn about the normal.
pub fn depends_on_azimuth(model: &dyn Reflectance) -> bool {
    let mut pairs: Vec<[DirectionPair; 2]> = Vec::new();
    for (index, light) in (0..8).map(|index| (index, direction(5.0 + 10.0 * f64::from(index), 7.0))) {
        for step in 0..24 {
            let view = direction(3.0 + 3.5 * f64::from(step), 15.0 * f64::from(step) + 40.0 * f64::from(index));
            let turn = DQuat::from_axis_angle(DVec3::Z, 0.7 + 0.9 * f64::from(step));
            pairs.push([pair(light, view), pair(turn * light, turn * view)]);
        }
    }
    let values = model.values(pairs.as_flattened());
    let greatest = values.iter().flatten().filter(|value| value.is_finite()).fold(0.0_f32, |most, value| most.max(value.abs()));
    let differs = |one: f32, other: f32| (one - other).abs() > 1e-3 * (one.abs().max(other.abs()) + 1e-2 * greatest);
    let (of_pairs, _) = values.as_chunks::<2>();
    of_pairs.iter().any(|[one, other]| one.iter().zip(other).any(|(one, other)| differs(*one, *other)))
}

/// The integrals for fixed directions with these polar angles and azimuths in degrees.
pub fn albedos(model: &dyn Reflectance, over: Integration, angles: &[[f64; 2]]) -> Vec<HemisphereIntegral> {
    angles.par_iter().map(|angles| integrate(model, over, *angles, ACCURACY)).collect()
}

/// The shares along one azimuth.
struct SearchedColumn {
    azimuth: f64,
    found: Vec<HemisphereIntegral>,
    /// The row of the greatest share.
    best: usize,
}

impl SearchedColumn {
    fn new(model: &dyn Reflectance, over: Integration, azimuth: f64) -> Self {
        let found = albedos(model, over, &SEARCHED.map(|polar| [polar, azimuth]));
        let shares = found.iter().map(|integral| greatest_component(integral).1).enumerate();
        let best = shares.max_by(|one, other| one.1.total_cmp(&other.1)).map_or(0, |(row, _)| row);
        Self { azimuth, found, best }
    }

    fn share(&self) -> f64 {
        greatest_component(&self.found[self.best]).1
    }

    /// Whether most of its integrals are not accurate.
    fn is_rough(&self) -> bool {
        2 * self.found.iter().filter(|integral| !integral.is_accurate).count() > self.found.len()
    }
}

/// The greatest share of the light, over all directions. A model that is too rough to be integrated is looked at with
/// less care, so that the answer does not take minutes.
pub fn greatest(model: &dyn Reflectance, over: Integration, depends_on_azimuth: bool) -> GreatestAlbedo {
    let mut column = SearchedColumn::new(model, over, AZIMUTHS[0]);
    let is_rough = column.is_rough();
    if depends_on_azimuth && !is_rough {
        for azimuth in &AZIMUTHS[1..] {
            let other = SearchedColumn::new(model, over, *azimuth);
            if other.share() > column.share() {
                column = other;
            }
        }
    }
    let SearchedColumn { azimuth, found, best: row } = &column;
    let at = |polar: f64| integrate(model, over, [polar, *azimuth], ACCURACY);
    let around = [SEARCHED[row.saturating_sub(1)], *SEARCHED.get(row + 1).unwrap_or(&STEEPEST)];
    let best = (SEARCHED[*row], found[*row].clone());
    let top = if is_rough { best } else { highest(around, best, &at) };
    let (component, share) = greatest_component(&top.1);
    let is_above = |integral: &HemisphereIntegral| greatest_component(integral).1 > 1.0 + integral.error.max(0.5 * EQUAL);
    let above_one_from = is_above(&top.1).then(|| {
        let first = found.iter().position(is_above).map_or(top.0, |first| SEARCHED[first].min(top.0));
        let below = SEARCHED.iter().copied().zip(found).rfind(|(polar, integral)| *polar < first && !is_above(integral));
        below.filter(|_| !is_rough).map_or(first, |(below, _)| crossing([below, first], |polar| is_above(&at(polar))))
    });
    GreatestAlbedo { share, error: top.1.error, component, angles: [top.0, *azimuth], above_one_from }
}

/// Looks for the greatest share between two angles, by thirds.
fn highest(
    [mut low, mut high]: [f64; 2],
    mut best: (f64, HemisphereIntegral),
    at: &dyn Fn(f64) -> HemisphereIntegral,
) -> (f64, HemisphereIntegral) {
    const STEPS: u32 = 6;
    for _ in 0..STEPS {
        let third = (high - low) / 3.0;
        let [one, other] = [low + third, high - third].map(|polar| (polar, at(polar)));
        let rises = greatest_component(&one.1).1 < greatest_component(&other.1).1;
        if rises {
            low = one.0
        } else {
            high = other.0
        }
        let better = if rises { other } else { one };
        if greatest_component(&better.1).1 > greatest_component(&best.1).1 {
            best = better;
        }
    }
    best
}

/// The angle between two angles at which `is_above` becomes true, to a tenth of a degree, and better near the horizon.
fn crossing([mut below, mut above]: [f64; 2], is_above: impl Fn(f64) -> bool) -> f64 {
    while above - below > (0.05 * (90.0 - below)).min(0.1) {
        let middle = 0.5 * (below + above);
        if is_above(middle) { above = middle } else { below = middle }
    }
    above
}

//! A survey of a model: its values for many pairs of directions, spread evenly over both hemispheres. It says what can
//! be told without integrals, and where integrals should look.
//!
//! Each pair is taken in three ways: as it is, turned about the normal, and with light and viewer exchanged. Where the
//! values differ, they are computed again for slightly turned pairs, so that rounding is not taken for a difference.

use crate::instrument::direction::{STEEPEST, brdf};
use crate::instrument::expressions::spread_pairs;
use crate::instrument::hemisphere::Integration;
use crate::instrument::peaks::{at_place, beside};
use crate::instrument::reciprocity::{FAINTEST, ReciprocityError, difference};
use crate::instrument::{DirectionPair, Reflectance};
use crate::sampling::EvenSequence;
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// How many pairs are spread over the hemispheres.
const PAIRS: u32 = 65_536;
/// Values that differ by less, relative to the greater one, are called equal.
const EQUAL: f64 = 1e-3;
/// How many differences are looked at again.
const LOOKED_AT: usize = 48;
/// How many pairs of each kind a closer look begins at.
const SUSPECTS: usize = 16;
/// The most places where a model is large.
const MOST_PEAKS: usize = 12;

/// What a survey found.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelSurvey {
    /// Whether values change when both directions turn about the normal.
    pub depends_on_azimuth: bool,
    /// Whether values change when both directions make half a turn about the normal.
    pub differs_after_half_turn: bool,
    /// Where the model is least reciprocal; none if it has no finite values.
    pub reciprocity: Option<ReciprocityError>,
    /// The smallest value, π · f · cos θ, of a component, and where it is; none if there is no finite value.
    pub least: Option<(f64, DirectionPair)>,
    /// A pair of directions where a value is not finite.
    pub not_finite: Option<DirectionPair>,
    /// The part of all pairs that have a value which is not finite.
    pub part_not_finite: f64,
    /// The greatest BRDF of a component.
    pub(super) greatest_brdf: f64,
    /// Where values are small, and where they change most if directions turn or change places.
    pub(super) suspects: Vec<DirectionPair>,
    /// Where the model is largest, for a beam and for a furnace.
    peaks: [Vec<DirectionPair>; 2],
}

impl ModelSurvey {
    /// Surveys a model.
    pub fn of(model: &dyn Reflectance) -> Self {
        let known = spread_pairs();
        let sequence = EvenSequence::new(4);
        let pairs: Vec<DirectionPair> = known.iter().copied().chain((0..PAIRS).map(|index| even_pair(sequence, index))).collect();
        let around: Vec<DirectionPair> = pairs.iter().enumerate().map(|(index, pair)| turned(pair, turn_of(index))).collect();
        let back: Vec<DirectionPair> = pairs.iter().map(DirectionPair::exchanged).collect();
        let [values, of_turned, of_back] = [&pairs, &around, &back].map(|pairs| model.values(pairs));
        let all_pairs = || pairs.iter().chain(&around).chain(&back);
        let all_values = || values.iter().chain(&of_turned).chain(&of_back);
        let numbers = all_pairs().zip(all_values()).flat_map(|(pair, value)| value.map(|number| (f64::from(number), *pair)));
        let least = numbers.filter(|(number, _)| number.is_finite()).min_by(|one, other| one.0.total_cmp(&other.0));
        let is_odd = |value: &[f32; 3]| !value.iter().all(|number| number.is_finite());
        // Known pairs have directions that are special, such as the normal. The others stand for all.
        let part_not_finite = values[known.len()..].iter().filter(|value| is_odd(value)).count() as f64 / f64::from(PAIRS);
        let not_finite = all_pairs().zip(all_values()).find(|(_, value)| is_odd(value)).map(|(pair, _)| *pair);
        let turns = |pair: &DirectionPair, index: usize| turned(pair, turn_of(index));
        let by_azimuth = least.map(|_| largest_differences(model, [&pairs, &around], [&values, &of_turned], &turns));
        let exchanges = |pair: &DirectionPair, _: usize| pair.exchanged();
        let exchanged = least.map(|_| largest_differences(model, [&pairs, &back], [&values, &of_back], &exchanges));
        let peaks = [Integration::OverViews, Integration::OverLights].map(|over| {
            let sized = all_pairs().zip(all_values()).map(|(pair, value)| (*pair, weight(over, pair, value)));
            climbed(model, over, largest(over, sized.filter(|(_, size)| *size > 0.0).collect()))
        });
        let depends_on_azimuth = by_azimuth.as_ref().is_some_and(LargestDifferences::is_different);
        let differs_after_half_turn = depends_on_azimuth && { differs(model, &pairs, &values, &|pair, _| turned(pair, PI)) };
        let mut suspects = smallest(&pairs, &values);
        suspects.extend(by_azimuth.iter().chain(&exchanged).flat_map(|found| found.pairs.iter().take(SUSPECTS)));
        let greatest_brdf = exchanged.as_ref().map_or(0.0, |found| found.greatest);
        let reciprocity = exchanged.and_then(|found| found.worst);
        let part_not_finite = if least.is_some() { part_not_finite } else { 1.0 };
        Self {
            depends_on_azimuth,
            differs_after_half_turn,
            reciprocity,
            least,
            not_finite,
            part_not_finite,
            greatest_brdf,
            suspects,
            peaks,
        }
    }

    /// Pairs of directions where the model is largest, for one of both integrals.
    pub fn peaks(&self, over: Integration) -> &[DirectionPair] {
        match over {
            Integration::OverViews => &self.peaks[0],
            Integration::OverLights => &self.peaks[1],
        }
    }
}

/// A pair of a sequence in four dimensions, which covers all pairs evenly.
fn even_pair(sequence: EvenSequence, index: u32) -> DirectionPair {
    let [cosine, turn, view_cosine, view_turn] = sequence.point(index);
    let direction = |cosine: f64, turn: f64| at_place([cosine, turn]).as_vec3().to_array();
    DirectionPair { light: direction(cosine, turn), view: direction(view_cosine, view_turn) }
}

/// By how much a pair is turned, in radians.
fn turn_of(index: usize) -> f64 {
    0.3 + (TAU - 0.6) * (0.618_033_988_749_895 * index as f64).fract()
}

fn moved(pair: &DirectionPair, by: impl Fn(DVec3) -> DVec3) -> DirectionPair {
    let [light, view] = [pair.light, pair.view].map(|direction| by(Vec3::from(direction).as_dvec3()).as_vec3().to_array());
    DirectionPair { light, view }
}

/// Whether values change when both directions of these pairs turn about the normal.
pub fn depends_on_azimuth(model: &dyn Reflectance, pairs: &[DirectionPair]) -> bool {
    differs(model, pairs, &model.values(pairs), &|pair, index| turned(pair, turn_of(index)))
}

/// Whether values of a few pairs change when both directions turn about the normal. That tells apart what an eye can.
pub fn seems_to_depend_on_azimuth(model: &dyn Reflectance) -> bool {
    let pairs: Vec<DirectionPair> = spread_pairs().into_iter().step_by(41).collect();
    depends_on_azimuth(model, &pairs)
}

/// Whether values of pairs and of the same pairs in another way differ. `way` makes the other pair of one with this
/// number.
fn differs(
    model: &dyn Reflectance,
    pairs: &[DirectionPair],
    values: &[[f32; 3]],
    way: &dyn Fn(&DirectionPair, usize) -> DirectionPair,
) -> bool {
    let others: Vec<DirectionPair> = pairs.iter().enumerate().map(|(index, pair)| way(pair, index)).collect();
    largest_differences(model, [pairs, &others], [values, &model.values(&others)], way).is_different()
}

/// Both directions turned about the normal.
fn turned(pair: &DirectionPair, turn: f64) -> DirectionPair {
    let turn = DQuat::from_axis_angle(DVec3::Z, turn);
    moved(pair, |direction| turn * direction)
}

/// Where values of pairs and of the same pairs in another way differ most.
struct LargestDifferences {
    /// The largest difference that is no rounding.
    worst: Option<ReciprocityError>,
    /// The pairs with the largest ones, from large to small, whatever made them.
    pairs: Vec<DirectionPair>,
    /// The greatest BRDF of a component.
    greatest: f64,
}

impl LargestDifferences {
    fn is_different(&self) -> bool {
        self.worst.is_some_and(|worst| worst.error > EQUAL)
    }
}

/// The smallest finite component of a value.
pub(super) fn least_component(value: &[f32; 3]) -> f32 {
    value.iter().filter(|number| number.is_finite()).fold(f32::INFINITY, |least, number| least.min(*number))
}

/// Some pairs with the smallest values.
fn smallest(pairs: &[DirectionPair], values: &[[f32; 3]]) -> Vec<DirectionPair> {
    let mut order: Vec<(usize, f32)> = values.iter().map(least_component).enumerate().collect();
    if order.len() > SUSPECTS {
        order.select_nth_unstable_by(SUSPECTS, |one, other| one.1.total_cmp(&other.1));
        order.truncate(SUSPECTS);
    }
    order.iter().map(|(index, _)| pairs[*index]).collect()
}

/// Where the BRDF of pairs and of the same pairs in another way differs most, relative to the greater value. `way`
/// makes the other pair of one with this number.
fn largest_differences(
    model: &dyn Reflectance,
    [pairs, others]: [&[DirectionPair]; 2],
    [values, other_values]: [&[[f32; 3]]; 2],
    way: &dyn Fn(&DirectionPair, usize) -> DirectionPair,
) -> LargestDifferences {
    let brdfs = |pairs: &[DirectionPair], values: &[[f32; 3]]| -> Vec<[f64; 3]> {
        pairs.iter().zip(values).map(|(pair, value)| brdf(pair, *value)).collect()
    };
    let (there, back) = (brdfs(pairs, values), brdfs(others, other_values));
    let finite = there.iter().chain(&back).flatten().filter(|value| value.is_finite());
    let greatest = finite.fold(0.0_f64, |greatest, value| greatest.max(value.abs()));
    let faintest = FAINTEST * greatest;
    let differences = there.iter().zip(&back).map(|(one, other)| difference(one, other, faintest)).enumerate();
    let mut order: Vec<(usize, f64)> = differences.filter_map(|(index, found)| Some((index, found?))).collect();
    order.sort_by(|one, other| other.1.total_cmp(&one.1));
    order.truncate(LOOKED_AT);
    let steady = order.iter().map(|(index, _)| steady_difference(model, &pairs[*index], &|pair| way(pair, *index), faintest));
    let found = order.iter().zip(steady).map(|((index, _), error)| ReciprocityError { error, pair: pairs[*index] });
    let worst = found.max_by(|one, other| one.error.total_cmp(&other.error));
    LargestDifferences { worst, pairs: order.iter().map(|(index, _)| pairs[*index]).collect(), greatest }
}

/// The difference of the means over pairs that are slightly turned, relative to the greater one; 0 if the difference
/// itself is as uncertain as large.
pub(super) fn steady_difference(
    model: &dyn Reflectance,
    pair: &DirectionPair,
    way: &dyn Fn(&DirectionPair) -> DirectionPair,
    faintest: f64,
) -> f64 {
    const TIMES: u32 = 12;
    let slightly = |time: u32| {
        let turn = DQuat::from_axis_angle(DVec3::new(0.3, 0.5, 0.8).normalize(), 2e-6 * f64::from(time));
        moved(pair, |direction| {
            let turned = turn * direction;
            DVec3::new(turned.x, turned.y, turned.z.max(STEEPEST.to_radians().cos())).normalize()
        })
    };
    let there: Vec<DirectionPair> = (0..TIMES).map(slightly).collect();
    let back: Vec<DirectionPair> = there.iter().map(way).collect();
    let both = there.iter().zip(model.values(&there)).zip(back.iter().zip(model.values(&back)));
    let brdfs: Vec<[[f64; 3]; 2]> = both.map(|((one, value), (other, back))| [brdf(one, value), brdf(other, back)]).collect();
    let count = f64::from(TIMES);
    let of_component = |component: usize| {
        let mean = |of: &dyn Fn(&[[f64; 3]; 2]) -> f64| brdfs.iter().map(of).sum::<f64>() / count;
        let scale = mean(&|both| both[0][component]).abs().max(mean(&|both| both[1][component]).abs());
        let difference = |both: &[[f64; 3]; 2]| both[0][component] - both[1][component];
        let middle = mean(&difference);
        let deviation = mean(&|both| (difference(both) - middle).powi(2)).sqrt();
        let is_certain = scale > faintest && middle.abs() > 1.5 * deviation;
        if is_certain { middle.abs() / scale } else { 0.0 }
    };
    (0..3).map(of_component).filter(|found| found.is_finite()).fold(0.0, f64::max)
}

/// How much a pair adds to an integral. Near the horizon the BRDF of many models grows without limit, so it is kept in
/// bounds there.
fn weight(over: Integration, pair: &DirectionPair, value: &[f32; 3]) -> f64 {
    const LOWEST: f32 = 0.1;
    let weight = match over {
        Integration::OverViews => pair.view[2] / pair.light[2].max(LOWEST),
        Integration::OverLights => 1.0,
    };
    let greatest = value.iter().filter(|number| number.is_finite()).fold(0.0_f32, |most, number| most.max(number.abs()));
    f64::from(weight) * f64::from(greatest)
}

/// Of pairs with their weights, some of the largest that are not near to each other.
fn largest(over: Integration, mut sized: Vec<(DirectionPair, f64)>) -> Vec<(DirectionPair, f64)> {
    const APART: f64 = 0.2;
    const LOOKED_THROUGH: usize = 4000;
    if sized.len() > LOOKED_THROUGH {
        sized.select_nth_unstable_by(LOOKED_THROUGH, |one, other| other.1.total_cmp(&one.1));
        sized.truncate(LOOKED_THROUGH);
    }
    sized.sort_by(|one, other| other.1.total_cmp(&one.1));
    let mut kept: Vec<(DirectionPair, f64)> = Vec::new();
    for (pair, size) in sized {
        let directions = over.directions(&pair);
        let is_near =
            |other: &DirectionPair| directions.iter().zip(over.directions(other)).all(|(one, other)| one.distance(other) < APART);
        if kept.len() < MOST_PEAKS && !kept.iter().any(|(other, _)| is_near(other)) {
            kept.push((pair, size));
        }
    }
    kept
}

/// Climbs from pairs to the tops beside them, by moving both directions.
fn climbed(model: &dyn Reflectance, over: Integration, mut tops: Vec<(DirectionPair, f64)>) -> Vec<DirectionPair> {
    const ROUNDS: i32 = 16;
    const AROUND: u32 = 24;
    for round in 0..ROUNDS {
        let distance = 0.1 * 0.65_f64.powi(round);
        let near = |pair: &DirectionPair, step: u32| {
            let part = |by: f64| (0.5 + by * f64::from(step) + 0.37 * f64::from(round)).fract();
            let [light, view] = [(pair.light, 0.381_966), (pair.view, 0.754_878)].map(|(direction, by)| {
                let distance = distance * part(by * 0.569_84 + 0.1);
                beside(Vec3::from(direction).as_dvec3(), distance, TAU * part(by)).as_vec3().to_array()
            });
            DirectionPair { light, view }
        };
        let tried: Vec<DirectionPair> = tops.iter().flat_map(|(pair, _)| (0..AROUND).map(|step| near(pair, step))).collect();
        let values = model.values(&tried);
        for (top, tried) in tops.iter_mut().zip(tried.iter().zip(&values).collect::<Vec<_>>().chunks(AROUND as usize)) {
            for (pair, value) in tried {
                let size = weight(over, pair, value);
                if size > top.1 {
                    *top = (**pair, size);
                }
            }
        }
    }
    tops.sort_by(|one, other| other.1.total_cmp(&one.1));
    tops.into_iter().map(|(pair, _)| pair).collect()
}

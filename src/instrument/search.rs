//! Where the share of the light is greatest, over all directions.
//!
//! Rough estimates over a fine, irregular grid say where to look, and so do the places where a survey found the model
//! to be large. There the share is integrated with some care, and at a grid of polar angles, at several azimuths if
//! they matter. From the best places the search climbs in both angles. Shares that are already known take part, so the
//! greatest one is never below them.

use crate::instrument::albedo::{ACCURACY, GreatestAlbedo, SharePlace, greatest_component, shares_at};
use crate::instrument::direction::{STEEPEST, angles, direction};
use crate::instrument::hemisphere::{Integration, IntegrationCare, integrate_with, values_of};
use crate::instrument::peaks::{spread, spread_directions};
use crate::instrument::survey::ModelSurvey;
use crate::instrument::{DirectionPair, Reflectance};
use glam::DVec3;
use rayon::prelude::*;

/// The polar angles at which the share is integrated in any case, in degrees.
const POLAR: [f64; 23] = [
    0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 65.0, 70.0, 75.0, 80.0, 84.0, 87.0, 88.5, 89.5,
    89.9, STEEPEST,
];
/// Estimates of a model that does not depend on the azimuth, and of one that does.
const ESTIMATES: [u32; 2] = [360, 3000];
/// Directions of an estimate.
const DIRECTIONS: u32 = 256;
/// How many of the best estimates are integrated.
const INTEGRATED: usize = 16;
/// From how many places the search climbs.
const CLIMBED: usize = 3;
/// How wrong a share may be that is compared with others.
const ROUGH: f64 = 2e-3;
/// Shares that differ by less, relative to the greater one, are equal but for rounding.
const LEVEL: f64 = 1e-6;

/// The azimuths at which the share is integrated if they matter: of a model that is the same after half a turn, the
/// first half.
const AZIMUTHS: [f64; 8] = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0];

/// A search in work.
struct AlbedoSearch<'m> {
    model: &'m dyn Reflectance,
    over: Integration,
    /// Directions near which the model may be large.
    hints: Vec<DVec3>,
    depends_on_azimuth: bool,
    /// The model has narrow lobes, so integrals that are compared take more care.
    is_narrow: bool,
    /// The model is too rough to be integrated well, so it is looked at with less care.
    is_rough: bool,
}

/// The greatest share of the light, over all directions. `known` are shares at some of them, with full care.
pub fn greatest(model: &dyn Reflectance, over: Integration, survey: &ModelSurvey, known: &[SharePlace]) -> GreatestAlbedo {
    let pairs = survey.peaks(over);
    let hints = pairs.iter().take(4).map(|pair| over.directions(pair)[1]).collect();
    let is_narrow = known.iter().any(|place| place.integral.is_narrow);
    let depends_on_azimuth = survey.depends_on_azimuth;
    let mut search = AlbedoSearch { model, over, hints, depends_on_azimuth, is_narrow, is_rough: false };
    let mut places = search.at(&POLAR.map(|polar| [polar, 0.0]), search.quick(ROUGH));
    let rough = places.iter().filter(|place| !place.integral.is_accurate).count();
    search.is_rough = 2 * rough > places.len();
    if !search.is_rough {
        let mut wanted = ends(over, pairs);
        if depends_on_azimuth {
            let half = AZIMUTHS.len() / if survey.differs_after_half_turn { 1 } else { 2 };
            let around = AZIMUTHS[1..half].iter();
            wanted.extend(around.flat_map(|azimuth| POLAR.iter().skip(2).step_by(2).map(|polar| [*polar, *azimuth])));
        } else {
            wanted.iter_mut().for_each(|angles| angles[1] = 0.0);
        }
        wanted.extend(search.estimated());
        places.extend(search.at(&wanted, search.quick(ROUGH)));
    }
    places.extend_from_slice(known);
    let top = search.best(&places);
    let shares: Vec<&SharePlace> = known.iter().chain([&top]).collect();
    let most = shares.iter().map(|place| place.share()).fold(0.0, f64::max);
    // Of equal ones the first, which is nearest to the normal.
    let best = shares.iter().find(|place| place.share() >= most - LEVEL * most).map_or(&top, |place| place);
    let column = search.column(&places, best);
    let (component, share) = greatest_component(&best.integral);
    let is_above = shares.iter().any(|place| place.is_above(0.0));
    GreatestAlbedo {
        share,
        error: best.integral.error,
        at_most: shares.iter().map(|place| place.share() + place.integral.error).fold(0.0, f64::max),
        component,
        angles: best.angles,
        top: best.integral.top.map(|(pair, _)| pair),
        above_one: is_above.then(|| search.interval(&column, best)),
    }
}

fn direction_of(place: &SharePlace) -> DVec3 {
    direction(place.angles[0], place.angles[1])
}

/// The directions at both ends of the largest pairs, and their mirror directions, in degrees.
fn ends(over: Integration, pairs: &[DirectionPair]) -> Vec<[f64; 2]> {
    let mut kept: Vec<DVec3> = Vec::new();
    for end in pairs.iter().flat_map(|pair| over.directions(pair)) {
        for end in [end, DVec3::new(-end.x, -end.y, end.z)] {
            if kept.len() < INTEGRATED && kept.iter().all(|other| other.distance(end) > 0.03) {
                kept.push(end);
            }
        }
    }
    let angles = kept.into_iter().map(|end| angles(end.as_vec3().to_array()));
    angles.map(|[polar, azimuth]| [polar.min(STEEPEST), azimuth]).collect()
}

impl AlbedoSearch<'_> {
    /// The care for shares that are compared.
    fn quick(&self, accuracy: f64) -> IntegrationCare {
        if self.is_narrow { IntegrationCare::quick_for_narrow(accuracy) } else { IntegrationCare::quick(accuracy) }
    }

    /// The shares at these angles.
    fn at(&self, wanted: &[[f64; 2]], care: IntegrationCare) -> Vec<SharePlace> {
        let one = |angles: &[f64; 2]| SharePlace {
            angles: *angles,
            integral: integrate_with(self.model, self.over, *angles, care, &self.hints),
        };
        wanted.par_iter().map(one).collect()
    }

    /// Where rough estimates are largest. They take the same moving directions everywhere.
    fn estimated(&self) -> Vec<[f64; 2]> {
        let count = ESTIMATES[usize::from(self.depends_on_azimuth)];
        let place = |index: u32| {
            let [one, other] = spread(index);
            if self.depends_on_azimuth { [STEEPEST * one, 360.0 * other] } else { [STEEPEST * one, 0.0] }
        };
        let grid: Vec<[f64; 2]> = (0..count).map(place).collect();
        let moving: Vec<DVec3> = spread_directions(DIRECTIONS).collect();
        let sum = |angles: &[f64; 2]| {
            let fixed = direction(angles[0], angles[1]);
            let values = values_of(self.model, self.over, fixed, &moving);
            let sums = values.iter().fold([0.0_f64; 3], |sums, value| std::array::from_fn(|index| sums[index] + value[index]));
            (*angles, sums.into_iter().fold(f64::NEG_INFINITY, f64::max))
        };
        let mut sums: Vec<([f64; 2], f64)> = grid.par_iter().map(sum).collect();
        sums.sort_by(|one, other| other.1.total_cmp(&one.1));
        let mut kept: Vec<[f64; 2]> = Vec::new();
        for (angles, _) in sums {
            let at = direction(angles[0], angles[1]);
            // Three degrees.
            let is_far = |other: &[f64; 2]| direction(other[0], other[1]).distance(at) > 0.05;
            if kept.len() < INTEGRATED && kept.iter().all(is_far) {
                kept.push(angles);
            }
        }
        kept
    }

    /// The best place that is found from these, climbing from some of them.
    fn best(&self, places: &[SharePlace]) -> SharePlace {
        let mut order: Vec<&SharePlace> = places.iter().collect();
        order.sort_by(|one, other| other.share().total_cmp(&one.share()));
        let mut starts: Vec<SharePlace> = Vec::new();
        let most = if self.is_rough { 1 } else { CLIMBED };
        for place in order {
            let is_far = |start: &SharePlace| direction_of(start).distance(direction_of(place)) > 0.05;
            if starts.len() < most && starts.iter().all(is_far) {
                starts.push(place.clone());
            }
        }
        if self.is_rough {
            return shares_at(self.model, self.over, &[starts[0].angles]).swap_remove(0);
        }
        let tops: Vec<SharePlace> = starts.into_iter().map(|start| self.climb(start)).collect();
        let best = tops.iter().max_by(|one, other| one.share().total_cmp(&other.share())).map_or([0.0; 2], |top| top.angles);
        let best = self.at(&[best], IntegrationCare::full(ACCURACY)).swap_remove(0);
        if self.is_refined() { self.refined(best) } else { best }
    }

    /// Climbs from a place with full care, until the share is level to its accuracy.
    fn refined(&self, mut top: SharePlace) -> SharePlace {
        const ROUNDS: u32 = 16;
        let mut step = 4.0;
        for _ in 0..ROUNDS {
            let found = self.at(&self.beside(&top, step), IntegrationCare::full(ACCURACY));
            let level = top.share() - ACCURACY * top.share().max(1.0);
            let is_level = found.iter().all(|place| place.share() > level);
            match found.into_iter().max_by(|one, other| one.share().total_cmp(&other.share())) {
                Some(better) if better.share() > top.share() => top = better,
                _ if is_level => break,
                _ => step *= 0.4,
            }
            if step < 0.03 {
                break;
            }
        }
        settled(top)
    }

    /// The angles on both sides of a place.
    fn beside(&self, place: &SharePlace, step: f64) -> Vec<[f64; 2]> {
        let [polar, azimuth] = place.angles;
        let around = (step / direction(polar.max(1.0), 0.0).x).min(45.0);
        // Near the horizon, steps that are ratios of the distance to it.
        let upwards = step.min(0.5 * (90.0 - polar));
        let mut wanted = vec![[polar - step, azimuth], [polar + upwards, azimuth]];
        if self.depends_on_azimuth {
            wanted.extend([[polar, azimuth - around], [polar, azimuth + around]]);
        }
        wanted.iter_mut().for_each(|angles| angles[0] = angles[0].clamp(0.0, STEEPEST));
        wanted
    }

    /// Climbs from a place, by steps that become smaller.
    fn climb(&self, mut top: SharePlace) -> SharePlace {
        const ROUNDS: u32 = 12;
        let mut step = 2.0;
        for _ in 0..ROUNDS {
            let found = self.at(&self.beside(&top, step), self.quick(0.5 * ROUGH));
            match found.into_iter().max_by(|one, other| one.share().total_cmp(&other.share())) {
                Some(better) if better.share() > top.share() => top = better,
                _ => step *= 0.4,
            }
            // The rest is left to the climb with full care, if there will be one.
            if step < if self.is_refined() { 0.5 } else { 0.03 } {
                break;
            }
        }
        settled(top)
    }

    /// Whether the best place is looked for with full care.
    fn is_refined(&self) -> bool {
        self.is_narrow || self.depends_on_azimuth
    }

    /// The shares along the azimuth of the best place, from the normal to the horizon.
    fn column(&self, places: &[SharePlace], best: &SharePlace) -> Vec<SharePlace> {
        if places.iter().chain([best]).all(|place| !place.is_above(0.0)) {
            return Vec::new();
        }
        let azimuth = best.angles[1];
        let mut column: Vec<SharePlace> = if self.is_rough {
            places.to_vec()
        } else {
            let between = (0..60).map(|index| [90.0 * spread(index)[0], azimuth]);
            let wanted: Vec<[f64; 2]> = POLAR.iter().map(|polar| [*polar, azimuth]).chain(between).collect();
            let is_there = |place: &&SharePlace| !self.depends_on_azimuth || place.angles[1] == azimuth;
            let known = places.iter().filter(is_there).cloned();
            self.at(&wanted, self.quick(ROUGH)).into_iter().chain(known).collect()
        };
        column.push(best.clone());
        column.sort_by(|one, other| one.angles[0].total_cmp(&other.angles[0]));
        column
    }

    /// The polar angles from which and to which the share is above 1, along the azimuth of the best place.
    fn interval(&self, column: &[SharePlace], best: &SharePlace) -> [f64; 2] {
        let azimuth = best.angles[1];
        // Rounding was judged at the best place alone, and is of the same order beside it.
        let part = best.integral.rounding / best.share().max(1.0);
        let is_above = |place: &SharePlace| place.is_above(if place.integral.rounding > 0.0 { 0.0 } else { part });
        let Some(first) = column.iter().position(is_above) else { return [best.angles[0]; 2] };
        let last = column.iter().rposition(is_above).unwrap_or(first);
        let care = IntegrationCare::full(ACCURACY);
        let edge = |inside: usize, outside: Option<usize>| {
            let inside = column[inside].angles[0];
            let outside = outside.and_then(|index| column.get(index)).map(|place| place.angles[0]);
            match outside.filter(|_| !self.is_rough) {
                None => inside,
                Some(outside) => crossing([outside, inside], |polar| is_above(&self.at(&[[polar, azimuth]], care)[0])),
            }
        };
        [edge(first, first.checked_sub(1)), edge(last, Some(last + 1))]
    }
}

/// The place with its azimuth from 0 to 360; at the normal there is none.
fn settled(mut place: SharePlace) -> SharePlace {
    place.angles[1] = if place.angles[0] == 0.0 { 0.0 } else { place.angles[1].rem_euclid(360.0) };
    place
}

/// The angle between two angles, the first one outside, the second one inside, at which `is_inside` becomes true: to a
/// tenth of a degree, and better near the horizon.
fn crossing([mut outside, mut inside]: [f64; 2], is_inside: impl Fn(f64) -> bool) -> f64 {
    while (inside - outside).abs() > (0.05 * (90.0 - outside.min(inside))).min(0.1) {
        let middle = 0.5 * (outside + inside);
        if is_inside(middle) { inside = middle } else { outside = middle }
    }
    inside
}

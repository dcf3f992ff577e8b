//! A closer look at a model where it is narrow: pairs of directions inside of its lobes, and beside them.
//!
//! Pairs that are spread over both hemispheres seldom meet a lobe whose width is a thousandth of a radian. Integrals
//! halve their cells until they see it, so they know pairs inside of it. From such pairs, the look climbs to where the
//! model is least reciprocal, and down to where it is smallest.

use crate::instrument::direction::{STEEPEST, brdf, direction, pair};
use crate::instrument::peaks::{LOWEST, beside};
use crate::instrument::reciprocity::{FAINTEST, ReciprocityError, difference};
use crate::instrument::survey::{ModelSurvey, least_component, steady_difference};
use crate::instrument::{DirectionPair, Reflectance};
use crate::sampling::EvenSequence;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// Polar angles in degrees at which lobes around the mirror direction and around the light are looked at. The cosine,
/// by which a value is divided, changes fastest near the horizon.
const POLAR: [f64; 8] = [45.0, 75.0, 85.0, 88.0, 89.0, 89.6, 89.9, STEEPEST];
/// The azimuths there.
const AZIMUTHS: [f64; 3] = [0.0, 90.0, 217.0];
/// How far beside a pair others are tried, in radians.
const BESIDE: [f64; 9] = [0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5];
/// From how many pairs a difference is climbed, and how many tops are computed again.
const CLIMBED: usize = 16;

/// A closer look in work.
pub(super) struct CloserLook<'m> {
    model: &'m dyn Reflectance,
    /// The greatest BRDF that was seen.
    greatest: f64,
}

/// A pair that moves to where a number grows.
struct PairClimb {
    pair: DirectionPair,
    size: f64,
    /// How far the directions move in radians: each on its own, and both together.
    steps: [f64; 2],
}

/// A way to move a pair.
#[derive(Clone, Copy, PartialEq)]
enum PairMove {
    /// Each direction on its own.
    Apart,
    /// The light alone.
    Light,
    /// So that the viewer stays beside the mirror direction.
    Mirrored,
    /// So that the viewer stays beside the light.
    Parallel,
}

impl PairMove {
    const ALL: [Self; 4] = [Self::Apart, Self::Light, Self::Mirrored, Self::Parallel];

    /// Which step of a climb it takes.
    fn family(self) -> usize {
        match self {
            PairMove::Apart | PairMove::Light => 0,
            PairMove::Mirrored | PairMove::Parallel => 1,
        }
    }

    /// The pair moved by at most a step. The numbers from 0 to 1 choose how far and where to.
    fn moved(self, from: &DirectionPair, step: f64, [far, turn, view_far, view_turn]: [f64; 4]) -> DirectionPair {
        let [light, view] = [from.light, from.view].map(|direction| Vec3::from(direction).as_dvec3());
        let moved = beside(light, step * far, TAU * turn);
        let by = moved - light;
        let shifted = |by: DVec3| {
            let shifted = view + by;
            shifted.with_z(shifted.z.max(LOWEST)).normalize()
        };
        let view = match self {
            PairMove::Apart => beside(view, step * view_far, TAU * view_turn),
            PairMove::Light => view,
            PairMove::Mirrored => shifted(DVec3::new(-by.x, -by.y, by.z)),
            PairMove::Parallel => shifted(by),
        };
        pair(moved, view)
    }
}

/// Moves pairs to where a number grows. A climb from each pair begins with each of these steps.
fn climbed(
    starts: &[DirectionPair],
    first_steps: &[f64],
    size: &dyn Fn(&[DirectionPair]) -> Vec<f64>,
) -> Vec<(DirectionPair, f64)> {
    const ROUNDS: u32 = 24;
    const TRIED: u32 = 16;
    const LARGEST_STEP: f64 = 0.3;
    let sequence = EvenSequence::new(4);
    let begun = starts.iter().zip(size(starts)).flat_map(|(pair, size)| {
        first_steps.iter().map(move |step| PairClimb { pair: *pair, size, steps: [*step, 0.05_f64.max(*step)] })
    });
    let mut climbs: Vec<PairClimb> = begun.collect();
    for round in 0..ROUNDS {
        let way = |step: u32| PairMove::ALL[(step % 4) as usize];
        let tried_by = |climb: &PairClimb| -> Vec<DirectionPair> {
            let point = |step: u32| sequence.point(round * TRIED + step + 1);
            (0..TRIED).map(|step| way(step).moved(&climb.pair, climb.steps[way(step).family()], point(step))).collect()
        };
        let tried: Vec<DirectionPair> = climbs.iter().flat_map(tried_by).collect();
        let sizes = size(&tried);
        let of_climbs = tried.chunks(TRIED as usize).zip(sizes.chunks(TRIED as usize));
        for (climb, (pairs, sizes)) in climbs.iter_mut().zip(of_climbs) {
            let before = climb.size;
            let mut grew = [false; 2];
            for ((step, pair), size) in (0..TRIED).zip(pairs).zip(sizes) {
                grew[way(step).family()] |= *size > before;
                if *size > climb.size {
                    (climb.pair, climb.size) = (*pair, *size);
                }
            }
            for (step, grew) in climb.steps.iter_mut().zip(grew) {
                *step = if grew { (2.0 * *step).min(LARGEST_STEP) } else { 0.5 * *step };
            }
        }
    }
    climbs.into_iter().map(|climb| (climb.pair, climb.size)).collect()
}

/// From large to small.
fn sort_by_size(found: &mut [(DirectionPair, f64)]) {
    found.sort_by(|one, other| other.1.total_cmp(&one.1));
}

/// Pairs around the mirror direction and around the light.
fn known_pairs() -> Vec<DirectionPair> {
    let at = |polar: f64, azimuth: f64| {
        let light = direction(polar, azimuth);
        [DVec3::new(-light.x, -light.y, light.z), light].map(|view| pair(light, view))
    };
    POLAR.iter().flat_map(|polar| AZIMUTHS.iter().flat_map(move |azimuth| at(*polar, *azimuth))).collect()
}

impl<'m> CloserLook<'m> {
    /// A look at a model that was surveyed.
    pub(super) fn new(model: &'m dyn Reflectance, survey: &ModelSurvey) -> Self {
        Self { model, greatest: survey.greatest_brdf }
    }

    /// Where the model is least reciprocal, near these pairs and in lobes at usual places. None if it is reciprocal
    /// there.
    pub(super) fn reciprocity(&mut self, inside: &[DirectionPair]) -> Option<ReciprocityError> {
        let known = known_pairs();
        let starts: Vec<DirectionPair> = inside.iter().chain(&known).copied().collect();
        let [there, back] = self.brdfs(&starts);
        let finite = there.iter().chain(&back).flatten().filter(|value| value.is_finite());
        self.greatest = finite.fold(self.greatest, |greatest, value| greatest.max(value.abs()));
        let around = |pair: &DirectionPair| -> Vec<DirectionPair> {
            let beside = |far: f64, turn: u32| PairMove::Light.moved(pair, far, [1.0, 0.25 * f64::from(turn), 0.0, 0.0]);
            BESIDE.iter().flat_map(|far| (0..4).map(move |turn| beside(*far, turn))).chain([*pair]).collect()
        };
        let tried: Vec<Vec<DirectionPair>> = starts.iter().map(around).collect();
        let sizes = self.differences(&tried.concat());
        let mut best: Vec<(DirectionPair, f64)> = Vec::new();
        for (pairs, sizes) in tried.iter().zip(sizes.chunks(4 * BESIDE.len() + 1)) {
            best.extend(pairs.iter().copied().zip(sizes.iter().copied()).max_by(|one, other| one.1.total_cmp(&other.1)));
        }
        sort_by_size(&mut best);
        best.truncate(CLIMBED);
        let begun: Vec<DirectionPair> = best.iter().map(|(pair, _)| *pair).collect();
        let mut tops = climbed(&begun, &[3e-3], &|pairs| self.differences(pairs));
        // What rounding made of a difference may be more than the difference, so both ends of climbs are judged.
        tops.extend(best);
        let judged = tops
            .iter()
            .filter(|(_, size)| *size > 0.0)
            .map(|(pair, _)| ReciprocityError { error: self.exact(pair), pair: *pair });
        judged.filter(|found| found.error > 0.0).max_by(|one, other| one.error.total_cmp(&other.error))
    }

    /// The smallest value of a component near these pairs.
    ///
    /// A value has the cosine of the light as a factor, so the way down leads to the horizon. The BRDF has the same
    /// sign without this factor, and leads into a gap.
    pub(super) fn least(&self, starts: &[DirectionPair]) -> Option<(f64, DirectionPair)> {
        let smallness = |pairs: &[DirectionPair], of: &dyn Fn(&DirectionPair, f64) -> f64| -> Vec<f64> {
            let values = self.model.values(pairs);
            pairs.iter().zip(&values).map(|(pair, value)| -of(pair, f64::from(least_component(value)))).collect()
        };
        let of_values = |pairs: &[DirectionPair]| smallness(pairs, &|_, least| least);
        let of_brdfs = |pairs: &[DirectionPair]| smallness(pairs, &|pair, least| least / f64::from(pair.light[2]));
        let mut gaps = climbed(starts, &[0.02, 4e-3], &of_brdfs);
        sort_by_size(&mut gaps);
        let gaps: Vec<DirectionPair> = gaps.iter().take(CLIMBED).map(|(pair, _)| *pair).collect();
        let mut tops = climbed(starts, &[0.05], &of_values);
        tops.extend(climbed(&gaps, &[1e-3], &of_values));
        sort_by_size(&mut tops);
        // Rounding may make a number negative that is not.
        let is_sure = |pair: &DirectionPair, least: f64| {
            let exact = || self.model.exact_values(&[*pair]);
            least >= 0.0 || exact().is_none_or(|values| values.as_flattened().iter().any(|number| *number < 0.0))
        };
        let found = tops.into_iter().map(|(pair, size)| (-size, pair)).filter(|(least, _)| least.is_finite());
        found.take(CLIMBED).find(|(least, pair)| is_sure(pair, *least))
    }

    /// The BRDF of pairs, and of the exchanged pairs.
    fn brdfs(&self, pairs: &[DirectionPair]) -> [Vec<[f64; 3]>; 2] {
        let back: Vec<DirectionPair> = pairs.iter().map(DirectionPair::exchanged).collect();
        [pairs, &back].map(|pairs| pairs.iter().zip(self.model.values(pairs)).map(|(pair, value)| brdf(pair, value)).collect())
    }

    /// How much the BRDF of pairs and of the exchanged ones differ, relative to the greater; 0 where one is not finite.
    fn differences(&self, pairs: &[DirectionPair]) -> Vec<f64> {
        let [there, back] = self.brdfs(pairs);
        let faintest = FAINTEST * self.greatest;
        there.iter().zip(&back).map(|(one, other)| difference(one, other, faintest).unwrap_or(0.0)).collect()
    }

    /// The difference in double precision; where there is none, the one that stays for pairs beside it.
    fn exact(&self, pair: &DirectionPair) -> f64 {
        let faintest = FAINTEST * self.greatest;
        let both = [*pair, pair.exchanged()];
        match self.model.exact_values(&both) {
            Some(values) => {
                let [there, back] = [0, 1].map(|index| values[index].map(|value| value / f64::from(both[index].light[2])));
                // The greatest BRDF is that in 1/sr.
                difference(&there, &back, faintest * PI).unwrap_or(0.0)
            }
            None => steady_difference(self.model, pair, &DirectionPair::exchanged, faintest),
        }
    }
}

//! Where a model is large for a fixed direction: places near which cells of an integral must be small.
//!
//! A scan looks at points that are spread evenly over the hemisphere, climbs from the largest values, and finds out how
//! narrow the tops are. It also estimates the integral, with an error that says whether another estimate missed much.

use crate::instrument::direction::STEEPEST;
use crate::sampling::EvenSequence;
use glam::DVec3;
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// The least cosine of a direction that is tried.
pub(super) const LOWEST: f64 = 1.75e-4;

/// How many points a scan looks at.
const POINTS: u32 = 2048;
/// The most tops that are climbed, beside the given places.
const MOST_TOPS: usize = 4;
/// Tops that are nearer to each other count as one while they are chosen, in radians.
const APART: f64 = 0.15;
/// How narrow a top may be, in radians, from wide to narrow. Wider ones need no care.
/// GGX with a roughness of 0.001 needs the narrowest when light comes along the surface.
const WIDTHS: [f64; 10] = [0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 4e-4, 1e-4, 3e-5, 1e-5];

/// A narrow top.
#[derive(Debug, Clone, Copy)]
pub(super) struct NarrowPeak {
    /// Polar angle and azimuth in radians.
    pub(super) place: [f64; 2],
    /// How far from it values are much smaller, in radians.
    pub(super) width: f64,
}

/// What a scan found.
pub(super) struct HemisphereScan {
    pub(super) peaks: Vec<NarrowPeak>,
    /// The integral by the mean of the points, and its standard error, each for red, green and blue.
    pub(super) estimate: [[f64; 2]; 3],
}

/// A point on a square, of those that are spread evenly.
pub(super) fn spread(index: u32) -> [f64; 2] {
    EvenSequence::SQUARE.point(index)
}

/// Directions spread evenly over the hemisphere, by solid angle.
pub(super) fn spread_directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(|index| at_place(spread(index)))
}

/// The direction with a cosine of the polar angle, and a part of the whole turn.
pub(super) fn at_place([cosine, turn]: [f64; 2]) -> DVec3 {
    let cosine = cosine.max(STEEPEST.to_radians().cos());
    let sine = (1.0 - cosine * cosine).sqrt();
    let (up, along) = (TAU * turn).sin_cos();
    DVec3::new(sine * along, sine * up, cosine)
}

/// A direction at a distance from another one, turned around it; kept above the surface.
pub(super) fn beside(middle: DVec3, distance: f64, turn: f64) -> DVec3 {
    let (one, other) = middle.any_orthonormal_pair();
    let (sine, cosine) = turn.sin_cos();
    let mut moved = middle + distance * (cosine * one + sine * other);
    moved.z = moved.z.max(LOWEST);
    moved.normalize()
}

static DIRECTIONS: LazyLock<Vec<DVec3>> = LazyLock::new(|| spread_directions(POINTS).collect());

fn size(value: &[f64; 3]) -> f64 {
    value.iter().fold(0.0, |largest, component| largest.max(component.abs()))
}

/// Scans the hemisphere. `integrand` gives the values for each steradian. `hints` are places that may be tops.
pub(super) fn scan(integrand: &dyn Fn(&[DVec3]) -> Vec<[f64; 3]>, hints: &[DVec3]) -> HemisphereScan {
    let directions: &[DVec3] = &DIRECTIONS;
    let values = integrand(directions);
    let count = f64::from(POINTS);
    let estimate = std::array::from_fn(|component| {
        let mean = values.iter().map(|value| value[component]).sum::<f64>() / count;
        let variance = values.iter().map(|value| (value[component] - mean).powi(2)).sum::<f64>() / count;
        [TAU * mean, TAU * (variance / count).sqrt()]
    });
    let mut order: Vec<usize> = (0..values.len()).filter(|index| size(&values[*index]) > 0.0).collect();
    order.sort_by(|one, other| size(&values[*other]).total_cmp(&size(&values[*one])));
    let mut starts: Vec<DVec3> = Vec::new();
    for index in order.into_iter().take(256) {
        if starts.len() < MOST_TOPS && starts.iter().all(|start| start.distance(directions[index]) > APART) {
            starts.push(directions[index]);
        }
    }
    starts.extend(hints);
    HemisphereScan { peaks: widths(integrand, climbed(integrand, starts)), estimate }
}

/// Climbs from each place to a top beside it.
fn climbed(integrand: &dyn Fn(&[DVec3]) -> Vec<[f64; 3]>, starts: Vec<DVec3>) -> Vec<(DVec3, f64)> {
    const ROUNDS: i32 = 10;
    const AROUND: u32 = 8;
    let mut tops: Vec<(DVec3, f64)> = integrand(&starts).iter().map(size).zip(starts).map(|(size, at)| (at, size)).collect();
    for round in 0..ROUNDS {
        let distance = 0.06 * 0.5_f64.powi(round);
        let turn = |step: u32| TAU * (f64::from(step) + 0.5 * f64::from(round % 2)) / f64::from(AROUND);
        let around = |(at, _): &(DVec3, f64)| -> Vec<DVec3> {
            (0..AROUND).map(|step| beside(*at, distance * if step % 2 == 0 { 1.0 } else { 0.5 }, turn(step))).collect()
        };
        let tried: Vec<DVec3> = tops.iter().flat_map(around).collect();
        let values = integrand(&tried);
        let of_tops = tried.chunks(AROUND as usize).zip(values.chunks(AROUND as usize));
        for (top, (places, values)) in tops.iter_mut().zip(of_tops) {
            for (place, value) in places.iter().zip(values) {
                if size(value) > top.1 {
                    *top = (*place, size(value));
                }
            }
        }
    }
    tops.retain(|top| top.1 > 0.0);
    tops.sort_by(|one, other| other.1.total_cmp(&one.1));
    let mut kept: Vec<(DVec3, f64)> = Vec::new();
    for top in tops {
        if kept.iter().all(|other| other.0.distance(top.0) > 2e-3) {
            kept.push(top);
        }
    }
    kept
}

/// How narrow tops are; wide ones are left out.
fn widths(integrand: &dyn Fn(&[DVec3]) -> Vec<[f64; 3]>, tops: Vec<(DVec3, f64)>) -> Vec<NarrowPeak> {
    /// A value this much smaller is beside the top.
    const MUCH_SMALLER: f64 = 0.3;
    const AROUND: u32 = 8;
    let ring = |at: DVec3, width: f64| (0..AROUND).map(move |step| beside(at, width, TAU * f64::from(step) / f64::from(AROUND)));
    let tried: Vec<DVec3> = tops.iter().flat_map(|(at, _)| WIDTHS.iter().flat_map(move |width| ring(*at, *width))).collect();
    let values = integrand(&tried);
    let of_tops = values.chunks(AROUND as usize * WIDTHS.len());
    let peaks = tops.iter().zip(of_tops).map(|((at, top), values)| {
        let is_within = |ring: &[[f64; 3]]| ring.iter().all(|value| size(value) >= MUCH_SMALLER * top);
        let first = values.chunks(AROUND as usize).position(is_within);
        let width = first.map_or(WIDTHS[WIDTHS.len() - 1], |index| WIDTHS[index]);
        NarrowPeak { place: [at.z.clamp(-1.0, 1.0).acos(), at.y.atan2(at.x)], width }
    });
    peaks.filter(|peak| peak.width < WIDTHS[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_top_is_found_with_its_place_and_width() {
        let middle = DVec3::new(0.3, 0.8, 1.0).normalize();
        for sharpness in [1e3, 1e5] {
            let integrand = |places: &[DVec3]| -> Vec<[f64; 3]> {
                places.iter().map(|at| [f64::from((sharpness * (middle.dot(*at) - 1.0)).exp() as f32); 3]).collect()
            };
            let found = scan(&integrand, &[]);
            let peak = found.peaks[0];
            let at = DVec3::new(
                peak.place[0].sin() * peak.place[1].cos(),
                peak.place[0].sin() * peak.place[1].sin(),
                peak.place[0].cos(),
            );
            // It falls to the 1/e-th part at √(2/sharpness).
            assert!(at.distance(middle) < 5e-4, "{}", at.distance(middle));
            let wanted = (2.0 / sharpness).sqrt();
            assert!(peak.width < 1.5 * wanted && peak.width > 0.2 * wanted, "{} {wanted}", peak.width);
        }
        let flat = scan(&|places| places.iter().map(|at| [at.z; 3]).collect(), &[DVec3::Z]);
        assert!(flat.peaks.is_empty(), "{:?}", flat.peaks);
        // ∫ cos dω = π.
        assert!((flat.estimate[0][0] - TAU / 2.0).abs() < flat.estimate[0][1], "{:?}", flat.estimate);
    }
}

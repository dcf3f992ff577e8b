//! Integrals of a model over the hemisphere, by adaptive cubature.
//!
//! The hemisphere is cut into cells of polar angle and azimuth. Each cell has a Gauss rule of five by five points, and
//! the difference to rules of three points on the same places says how wrong it may be, and along which side. In each
//! round the cells with the largest errors are halved along that side, and the points of all new cells are evaluated
//! together. A lobe may be so narrow that no point of the first cells sees it. So cells at the places where lobes are
//! known to be (the mirror direction and the direction of the light itself, the normal, the horizon) are halved first,
//! whatever they say. So are cells at the narrow tops that a scan (`peaks`) finds. Its estimate of the integral
//! also tells if cells missed something: then all of them are halved.

use crate::instrument::direction::{STEEPEST, angles, direction, pair};
use crate::instrument::peaks::{HemisphereScan, NarrowPeak, scan};
use crate::instrument::rounding::{WeighedPair, error_of_rounding};
use crate::instrument::{DirectionPair, Reflectance};
use glam::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Over which direction is integrated, while the other one is fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integration {
    /// The share of a beam of light that is reflected: ∫ f cos θ over the directions of the viewer.
    OverViews,
    /// What a viewer sees of a surface if the light is 1 from everywhere, as in a white furnace: ∫ f cos θ over the
    /// directions of the light. It is the same if the model is reciprocal.
    OverLights,
}

/// How much work an integral is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntegrationCare {
    /// How wrong the integral may be, and relative to it, if it is greater than 1.
    pub accuracy: f64,
    /// The most evaluations.
    pub evaluations: usize,
    /// Whether cells at the places of lobes are halved even if the scan saw no narrow top there.
    pub refines_places: bool,
    /// Whether the number is told: ridges are looked for.
    pub is_told: bool,
    /// Whether the error counts how single precision rounds values. That takes values in double precision, each as long
    /// as hundreds of others.
    pub judges_rounding: bool,
}

impl IntegrationCare {
    /// Care for numbers that are told. A smooth model takes about 20,000 evaluations, and GGX with a roughness of
    /// 0.001 takes 80,000 at 89 degrees.
    pub const fn full(accuracy: f64) -> Self {
        Self { accuracy, evaluations: 150_000, refines_places: true, is_told: true, judges_rounding: true }
    }

    /// Care for numbers that are compared with each other.
    pub const fn quick(accuracy: f64) -> Self {
        Self { accuracy, evaluations: 30_000, refines_places: false, is_told: false, judges_rounding: false }
    }

    /// The same for a model whose lobes are narrow.
    pub const fn quick_for_narrow(accuracy: f64) -> Self {
        Self { accuracy, evaluations: 60_000, refines_places: true, is_told: false, judges_rounding: false }
    }
}

impl Integration {
    /// The pair of the fixed and the moving direction.
    fn pair(self, fixed: DVec3, moving: DVec3) -> DirectionPair {
        match self {
            Integration::OverViews => pair(fixed, moving),
            Integration::OverLights => pair(moving, fixed),
        }
    }

    /// The fixed and the moving direction of a pair.
    pub fn directions(self, pair: &DirectionPair) -> [DVec3; 2] {
        let [light, view] = [pair.light, pair.view].map(|direction| Vec3::from(direction).as_dvec3());
        match self {
            Integration::OverViews => [light, view],
            Integration::OverLights => [view, light],
        }
    }

    /// The cosine of the moving direction of a pair.
    fn cosine(self, pair: &DirectionPair) -> f64 {
        self.directions(pair)[1].z
    }
}

/// Cells at the mirror direction are halved until they are this small, in radians: small enough for a point to see a
/// lobe of GGX with a roughness of 0.001, or a cosine to the power of 100,000.
const MIRROR_SIZE: f64 = 4e-4;
/// The same at the other places.
const PLACE_SIZE: f64 = 4e-3;
/// And along the plane of incidence.
const PLANE_SIZE: f64 = 0.06;
/// A smooth model takes at most this many rounds.
const SMOOTH_ROUNDS: u32 = 4;
/// All cells are halved until they are this small if something was missed, or may have been.
const FINE_SIZE: f64 = 0.07;
/// A lobe is narrow if values are much smaller at this distance from its top, in radians.
const NARROW: f64 = 0.05;
/// Narrower lobes may be ridges: GGX with a small roughness, for light along the surface.
const RIDGE: f64 = 2e-4;
/// Smaller cells are not halved, because directions have 24 bits.
const LEAST_SIZE: f64 = 2e-6;

/// The places and weights of the Gauss rule of five points on −1..1, and the weights of the rule of degree 3 on the
/// first, the third and the fifth of these places.
const PLACES: [f64; 5] = [-0.906_179_845_938_664, -0.538_469_310_105_683, 0.0, 0.538_469_310_105_683, 0.906_179_845_938_664];
const WEIGHTS: [f64; 5] =
    [0.236_926_885_056_189, 0.478_628_670_499_366, 0.568_888_888_888_889, 0.478_628_670_499_366, 0.236_926_885_056_189];
const COARSE_END: f64 = 1.0 / (3.0 * PLACES[4] * PLACES[4]);
const COARSE: [f64; 5] = [COARSE_END, 0.0, 2.0 - 2.0 * COARSE_END, 0.0, COARSE_END];

/// An integral over the hemisphere.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HemisphereIntegral {
    /// Red, green and blue.
    pub value: [f64; 3],
    /// How wrong the components may be; the estimate is on the safe side.
    pub error: f64,
    /// What part of the error comes from single precision, if that was judged.
    pub rounding: f64,
    /// Whether the model has a narrow lobe there.
    pub is_narrow: bool,
    /// Whether the error is as small as asked for.
    pub is_accurate: bool,
    /// How many values of the model it took.
    pub evaluations: usize,
    /// A pair of directions where the model has no finite value. Such values count as 0.
    pub not_finite: Option<DirectionPair>,
    /// Where the integrand was largest, and how large.
    pub top: Option<(DirectionPair, f64)>,
    /// Where a component of the integrand was smallest, and how small.
    pub bottom: Option<(DirectionPair, f64)>,
}

/// A part of the hemisphere.
#[derive(Clone, Copy)]
struct SkyCell {
    /// Polar angles in radians.
    polar: [f64; 2],
    /// Azimuths in radians.
    azimuth: [f64; 2],
    sum: [f64; 3],
    error: f64,
    /// Whether it is halved between its polar angles, not between its azimuths.
    halves_polar: bool,
}

impl SkyCell {
    fn new(polar: [f64; 2], azimuth: [f64; 2]) -> Self {
        Self { polar, azimuth, sum: [0.0; 3], error: 0.0, halves_polar: true }
    }

    /// How long its sides are on the unit sphere.
    fn sides(&self) -> [f64; 2] {
        let farthest = self.polar[1].sin();
        [self.polar[1] - self.polar[0], farthest * (self.azimuth[1] - self.azimuth[0])]
    }

    fn size(&self) -> f64 {
        let [one, other] = self.sides();
        one.max(other)
    }

    /// Whether a place is nearer than this, in radians on the unit sphere.
    fn is_near(&self, place: [f64; 2], distance: f64) -> bool {
        if self.touches(place) {
            return true;
        }
        let [polar, azimuth] = place;
        let turn = (azimuth - self.azimuth[0]).rem_euclid(TAU);
        let width = self.azimuth[1] - self.azimuth[0];
        // The edge that is nearer, if the azimuth is outside.
        let beside = if turn <= width {
            turn
        } else if turn - width < TAU - turn {
            width
        } else {
            0.0
        };
        let at = |polar: f64, azimuth: f64| direction(polar.to_degrees(), azimuth.to_degrees());
        let nearest = at(polar.clamp(self.polar[0], self.polar[1]), self.azimuth[0] + beside);
        nearest.distance(at(polar, azimuth)) <= distance
    }

    /// Whether a place is in it or at its edge.
    fn touches(&self, [polar, azimuth]: [f64; 2]) -> bool {
        const NEAR: f64 = 1e-9;
        let within = |[low, high]: [f64; 2], at: f64| at >= low - NEAR && at <= high + NEAR;
        let turned = (0..3).any(|turn| within(self.azimuth, azimuth + TAU * f64::from(turn - 1)));
        within(self.polar, polar) && (turned || polar < NEAR)
    }

    fn halves(&self, halves_polar: bool) -> [SkyCell; 2] {
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        if halves_polar {
            let at = middle(self.polar);
            [[self.polar[0], at], [at, self.polar[1]]].map(|polar| SkyCell::new(polar, self.azimuth))
        } else {
            let at = middle(self.azimuth);
            [[self.azimuth[0], at], [at, self.azimuth[1]]].map(|azimuth| SkyCell::new(self.polar, azimuth))
        }
    }

    /// Polar angle and azimuth of its points.
    fn points(&self) -> impl Iterator<Item = [f64; 2]> {
        let at = |[low, high]: [f64; 2], place: f64| 0.5 * (low + high) + 0.5 * (high - low) * place;
        let (polar, azimuth) = (self.polar, self.azimuth);
        PLACES.into_iter().flat_map(move |row| PLACES.into_iter().map(move |column| [at(polar, row), at(azimuth, column)]))
    }

    /// Takes the sums of the integrand at its points.
    fn settle(&mut self, integrand: &[[f64; 3]]) {
        let area = 0.25 * (self.polar[1] - self.polar[0]) * (self.azimuth[1] - self.azimuth[0]);
        let sum = |rows: &[f64; 5], columns: &[f64; 5], component: usize| {
            let weight = |index: usize| rows[index / 5] * columns[index % 5];
            area * integrand.iter().enumerate().map(|(index, value)| weight(index) * value[component]).sum::<f64>()
        };
        let mut largest = [0.0_f64; 2];
        for component in 0..3 {
            let fine = sum(&WEIGHTS, &WEIGHTS, component);
            self.sum[component] = fine;
            let coarse = [sum(&COARSE, &WEIGHTS, component), sum(&WEIGHTS, &COARSE, component)];
            for (largest, coarse) in largest.iter_mut().zip(coarse) {
                *largest = largest.max((coarse - fine).abs());
            }
        }
        let scale = self.sum.iter().fold(0.0_f64, |scale, sum| scale.max(sum.abs())).max(f64::MIN_POSITIVE);
        // The fine rule is of degree 9, so its own error is much smaller than the difference, once that is small.
        let difference = largest[0] + largest[1];
        self.error = difference.min(scale * (10.0 * difference / scale).powf(1.5));
        let [one, other] = self.sides();
        // Cells do not become needles.
        self.halves_polar = if one > 16.0 * other {
            true
        } else if other > 16.0 * one {
            false
        } else {
            largest[0] >= largest[1]
        };
    }
}

/// Integrates a model over the hemisphere. The fixed direction has this polar angle and this azimuth, in degrees.
/// `accuracy` is how wrong the integral may be, and relative to it, if it is greater than 1.
pub fn integrate(model: &dyn Reflectance, over: Integration, angles: [f64; 2], accuracy: f64) -> HemisphereIntegral {
    integrate_with(model, over, angles, IntegrationCare::full(accuracy), &[])
}

/// The same with this care. `hints` are directions near which the model may be large, whatever the fixed one is.
pub fn integrate_with(
    model: &dyn Reflectance,
    over: Integration,
    [polar, azimuth]: [f64; 2],
    care: IntegrationCare,
    hints: &[DVec3],
) -> HemisphereIntegral {
    let fixed = [polar.clamp(0.0, STEEPEST), azimuth];
    let scanned = scanned(model, over, fixed, hints);
    let narrowest = scanned.peaks.iter().map(|peak| peak.width).fold(1.0, f64::min);
    // A ridge this narrow passes between the points of cells beside its top. They show it when errors are small.
    let accuracy = care.accuracy * if care.is_told && narrowest < RIDGE { 0.1 } else { 1.0 };
    let is_narrow = narrowest < NARROW;
    let mut waiting = first_cells(fixed.map(f64::to_radians), care, &scanned.peaks);
    let mut done: Vec<SkyCell> = Vec::new();
    let mut result = HemisphereIntegral { is_narrow, ..HemisphereIntegral::default() };
    let mut may_halve_all = true;
    let mut rounds = 0;
    loop {
        rounds += 1;
        evaluate(model, over, fixed, &mut waiting, &mut result);
        done.append(&mut waiting);
        // Cells are always summed in the same order, from small to large errors.
        done.sort_by(|one, other| one.error.total_cmp(&other.error));
        result.value = std::array::from_fn(|component| done.iter().map(|cell| cell.sum[component]).sum());
        result.error = done.iter().map(|cell| cell.error).sum();
        let goal = accuracy * result.value.iter().fold(1.0_f64, |scale, value| scale.max(value.abs()));
        let missed = missed(&result.value, &scanned).filter(|missed| *missed > goal);
        // A model that is not smooth may have steps between the points of cells whose errors seem to be small.
        let is_in_doubt = missed.is_some() || care.refines_places && rounds > SMOOTH_ROUNDS;
        let halves_all = result.error <= goal && is_in_doubt && may_halve_all;
        result.is_accurate = result.error <= goal && missed.is_none() && !halves_all;
        if result.is_accurate || result.evaluations >= care.evaluations {
            break result.error = result.error.max(missed.unwrap_or(0.0));
        }
        if halves_all {
            may_halve_all = false;
            let (large, small) = done.into_iter().partition(|cell| cell.size() > FINE_SIZE);
            done = small;
            waiting = halved(large, |cell| cell.size() > FINE_SIZE);
        }
        // The cells with the largest errors, until the others together are accurate enough.
        let mut rest = result.error;
        while let Some(cell) = done.last().filter(|cell| rest > 0.5 * goal && cell.size() > LEAST_SIZE) {
            rest -= cell.error;
            waiting.extend(cell.halves(cell.halves_polar));
            done.pop();
        }
        if waiting.is_empty() {
            break result.error = result.error.max(missed.unwrap_or(0.0));
        }
    }
    if care.judges_rounding {
        done.append(&mut waiting);
        result.rounding = rounding(model, over, fixed, &done, is_narrow);
        result.error += result.rounding;
    }
    result
}

/// How wrong an integral may be because of single precision: at some points of its cells, more of those that matter.
fn rounding(model: &dyn Reflectance, over: Integration, fixed: [f64; 2], cells: &[SkyCell], is_narrow: bool) -> f64 {
    let count = if is_narrow { 512 } else { 24 };
    let size = |cell: &SkyCell| cell.sum.iter().fold(0.0_f64, |size, sum| size.max(sum.abs()));
    let total: f64 = cells.iter().map(size).sum();
    let fixed = direction(fixed[0], fixed[1]);
    let mut samples: Vec<WeighedPair> = Vec::new();
    let mut passed = 0.0;
    for cell in cells {
        passed += size(cell) / total * f64::from(count);
        // Cells are taken in proportion to their sums, and one point after the other in each.
        while (samples.len() as f64) < passed - 0.5 {
            let index = samples.len() * 7 % (PLACES.len() * PLACES.len());
            let Some([polar, azimuth]) = cell.points().nth(index) else { break };
            let moving = direction(polar.to_degrees(), azimuth.to_degrees());
            let pair = over.pair(fixed, moving);
            let area = (cell.polar[1] - cell.polar[0]) * (cell.azimuth[1] - cell.azimuth[0]) * polar.sin();
            let gauss = 0.25 * WEIGHTS[index / 5] * WEIGHTS[index % 5] * (PLACES.len() * PLACES.len()) as f64;
            let weight = area * gauss * total / size(cell) * weight(over, &pair, polar.cos());
            samples.push(WeighedPair { pair, weight });
        }
    }
    error_of_rounding(model, &samples)
}

/// How much less an integral is than the estimate of a scan, if that is too much to be chance. It may be more: few
/// points of a scan see a lobe that cells were made for.
fn missed(value: &[f64; 3], scanned: &HemisphereScan) -> Option<f64> {
    let differences = value.iter().zip(&scanned.estimate).filter_map(|(value, [estimate, error])| {
        let difference = estimate - value;
        (difference > 5.0 * error).then_some(difference)
    });
    differences.max_by(f64::total_cmp)
}

/// Looks at the whole hemisphere before it is cut into cells.
fn scanned(model: &dyn Reflectance, over: Integration, [polar, azimuth]: [f64; 2], hints: &[DVec3]) -> HemisphereScan {
    let fixed = direction(polar, azimuth);
    let mirrored = DVec3::new(-fixed.x, -fixed.y, fixed.z);
    let places: Vec<DVec3> = hints.iter().copied().chain([mirrored, fixed]).collect();
    scan(&|moving| values_of(model, over, fixed, moving), &places)
}

/// The integrand for each steradian, for moving directions.
pub(super) fn values_of(model: &dyn Reflectance, over: Integration, fixed: DVec3, moving: &[DVec3]) -> Vec<[f64; 3]> {
    let directions: Vec<[DVec3; 2]> = moving.iter().map(|moving| [fixed, *moving]).collect();
    values_of_all(model, over, &directions)
}

/// The integrand for each steradian, for pairs of a fixed and a moving direction.
pub(super) fn values_of_all(model: &dyn Reflectance, over: Integration, directions: &[[DVec3; 2]]) -> Vec<[f64; 3]> {
    let pairs: Vec<DirectionPair> = directions.iter().map(|[fixed, moving]| over.pair(*fixed, *moving)).collect();
    let weighted = |(pair, value)| weighted(over, pair, value, over.cosine(pair));
    pairs.iter().zip(model.values(&pairs)).map(weighted).collect()
}

/// A value of a model as the integrand for each steradian. The value is π · f · cos θ of the light; `cosine` is that of
/// the moving direction.
fn weighted(over: Integration, pair: &DirectionPair, value: [f32; 3], cosine: f64) -> [f64; 3] {
    let weight = weight(over, pair, cosine);
    value.map(|component| if component.is_finite() { f64::from(component) * weight } else { 0.0 })
}

/// By what a value is multiplied to be the integrand for each steradian.
fn weight(over: Integration, pair: &DirectionPair, cosine: f64) -> f64 {
    match over {
        Integration::OverViews => cosine / (PI * f64::from(pair.light[2])),
        Integration::OverLights => 1.0 / PI,
    }
}

/// Halves cells along their longer side, as long as `is_large`.
fn halved(mut open: Vec<SkyCell>, is_large: impl Fn(&SkyCell) -> bool) -> Vec<SkyCell> {
    let mut cells = Vec::new();
    while let Some(cell) = open.pop() {
        if is_large(&cell) {
            let [one, other] = cell.sides();
            open.extend(cell.halves(one >= other));
        } else {
            cells.push(cell);
        }
    }
    cells
}

/// The cells of the first round. The plane of incidence and the polar angle of the fixed direction are edges.
fn first_cells([polar, azimuth]: [f64; 2], care: IntegrationCare, peaks: &[NarrowPeak]) -> Vec<SkyCell> {
    const ROWS: u32 = 6;
    const COLUMNS: u32 = 12;
    let mut edges: Vec<f64> = (0..=ROWS).map(|row| FRAC_PI_2 * f64::from(row) / f64::from(ROWS)).collect();
    if edges.iter().all(|edge| (edge - polar).abs() > 0.02) {
        edges.push(polar);
        edges.sort_by(f64::total_cmp);
    }
    let column = |index: u32| azimuth + TAU * f64::from(index) / f64::from(COLUMNS);
    let cells = edges.windows(2).flat_map(|rows| {
        let rows = [rows[0], rows[1]];
        (0..COLUMNS).map(move |index| SkyCell::new(rows, [column(index), column(index + 1)]))
    });
    let known = [
        ([polar, azimuth + PI], MIRROR_SIZE),
        ([polar, azimuth], PLACE_SIZE),
        ([0.0, azimuth], PLACE_SIZE),
        ([FRAC_PI_2, azimuth + PI], PLACE_SIZE),
        ([FRAC_PI_2, azimuth], PLACE_SIZE),
    ];
    let known = known.into_iter().filter(|_| care.refines_places);
    let places: Vec<([f64; 2], f64)> = known.chain(peaks.iter().map(|peak| (peak.place, peak.width))).collect();
    halved(cells.collect(), |cell| {
        let size = cell.size();
        // A lobe reaches into the cells beside that of its top.
        let at_place = places.iter().any(|(place, least)| size > *least && cell.is_near(*place, *least));
        let at_plane = || {
            let middle = 0.5 * (cell.polar[0] + cell.polar[1]);
            size > PLANE_SIZE && [azimuth, azimuth + PI].iter().any(|plane| cell.touches([middle, *plane]))
        };
        at_place || care.refines_places && at_plane()
    })
}

/// Evaluates the model at the points of cells, all together.
fn evaluate(
    model: &dyn Reflectance,
    over: Integration,
    [polar, azimuth]: [f64; 2],
    cells: &mut [SkyCell],
    result: &mut HemisphereIntegral,
) {
    let fixed = direction(polar, azimuth);
    let pairs: Vec<DirectionPair> = cells
        .iter()
        .flat_map(SkyCell::points)
        .map(|point| {
            let [polar, azimuth] = point.map(f64::to_degrees);
            let moving = direction(polar, azimuth);
            over.pair(fixed, moving)
        })
        .collect();
    let values = model.values(&pairs);
    result.evaluations += pairs.len();
    let mut integrand = [[0.0; 3]; PLACES.len() * PLACES.len()];
    let points_of_cells = pairs.chunks(integrand.len()).zip(values.chunks(integrand.len()));
    for (cell, (pairs, values)) in cells.iter_mut().zip(points_of_cells) {
        for (((point, pair), value), target) in cell.points().zip(pairs).zip(values).zip(&mut integrand) {
            if !value.iter().all(|component| component.is_finite()) {
                result.not_finite.get_or_insert(*pair);
            }
            // The area of the sphere shrinks towards the normal.
            let integrand = weighted(over, pair, *value, point[0].cos());
            *target = integrand.map(|component| component * point[0].sin());
            let [red, green, blue] = integrand;
            let (most, least) = (red.max(green).max(blue), red.min(green).min(blue));
            if result.top.is_none_or(|(_, top)| most > top) {
                result.top = Some((*pair, most));
            }
            if result.bottom.is_none_or(|(_, bottom)| least < bottom) {
                result.bottom = Some((*pair, least));
            }
        }
        cell.settle(&integrand);
    }
}

/// The polar angle and the azimuth of both directions of a pair, in degrees: of the light, then of the viewer.
pub fn angles_of(pair: &DirectionPair) -> [[f64; 2]; 2] {
    [angles(pair.light), angles(pair.view)]
}

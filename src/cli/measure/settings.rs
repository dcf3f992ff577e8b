//! `measure --all`: the same over the ranges of the parameters.

use crate::cli::model::ValuedFormula;
use crate::cli::progress::Progress;
use illuminator::formula::{Parameter, ParameterId, Term};
use illuminator::instrument::Reflectance;
use illuminator::instrument::albedo::{GreatestAlbedo, greatest_component, shares_at};
use illuminator::instrument::expressions::spread_pairs;
use illuminator::instrument::hemisphere::{Integration, IntegrationCare, integrate_with};
use illuminator::instrument::measurement::TOLD_ANGLES;
use illuminator::instrument::search::greatest;
use illuminator::instrument::survey::{ModelSurvey, depends_on_azimuth};
use illuminator::lang::types::Type;
use illuminator::lang::variables::{Owner, Predefined};
use illuminator::sampling::EvenSequence;
use illuminator::workspace::assignment::Assignment;
use illuminator::workspace::{OwnerId, Values};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The most corners of the ranges that are taken.
const MOST_CORNERS: u32 = 64;
/// Settings inside the ranges.
const INSIDE: u32 = 32;
/// The angles at which settings are compared, and how wrong the shares may be there.
const COMPARED: [f64; 6] = [0.0, 45.0, 70.0, 83.0, 88.0, 89.9];
/// The azimuths at which settings are compared for which azimuths matter.
const AZIMUTHS: [f64; 4] = [0.0, 45.0, 90.0, 135.0];
const COARSE: f64 = 5e-3;

/// What was found over the ranges.
pub(super) struct RangeFindings {
    /// The names of the parameters that were moved.
    pub(super) moved: Vec<String>,
    /// How many settings were tried.
    pub(super) settings: usize,
    /// How many of them reflect more than all of a beam.
    pub(super) above_one: usize,
    /// The greatest share of all, and the values there.
    pub(super) greatest: Option<(GreatestAlbedo, String)>,
    /// The smallest value of all, and the values of parameters there.
    pub(super) smallest: Option<(f64, String)>,
    /// The values of parameters for which a value is not finite.
    pub(super) not_finite: Option<String>,
}

/// What one setting does.
struct Tried {
    values: Values,
    share: f64,
    smallest: f64,
    is_finite: bool,
}

/// The parameters that are moved: those that the formula reads and that have a range, but not the light, nor what is
/// added to a picture beside the formula.
fn moved(valued: &ValuedFormula) -> Vec<(OwnerId, ParameterId)> {
    let formula = &valued.formula;
    let is_read = |id: ParameterId| formula.terms.iter().any(|term| matches!(term, Term::Parameter(read) if *read == id));
    let owner = |id: ParameterId| match formula.parameter(id).owner {
        Owner::Global => Some(OwnerId::Global),
        Owner::Body => valued.owners[0],
        Owner::Light => valued.owners[1],
    };
    let is_moved = |id: ParameterId| {
        let parameter = formula.parameter(id);
        let is_colour = parameter.predefined == Some(Predefined::BodyColour);
        let is_number = matches!(parameter.ty, Type::Scalar | Type::Vector);
        parameter.range.is_some() && is_number && is_read(id) && (parameter.predefined.is_none() || is_colour)
    };
    let ids = formula.parameter_ids().filter(|id| is_moved(*id));
    let owned = ids.filter_map(|id| Some((owner(id)?, id)));
    owned.filter(|(owner, id)| valued.values.lock_of(*owner, *id).is_none()).collect()
}

/// Where a parameter is at a part of its range.
fn at(parameter: &Parameter, share: f64) -> f32 {
    let [low, high] = parameter.range.unwrap_or([0.0, 1.0]).map(f64::from);
    // A range that spans decades, such as that of an exponent, is covered evenly by ratios.
    let value = if low > 0.0 && high > 50.0 * low { low * (high / low).powf(share) } else { low + share * (high - low) };
    parameter.clamp(value as f32).0
}

/// The settings: corners of the ranges, and some inside.
fn settings(valued: &ValuedFormula, moved: &[(OwnerId, ParameterId)]) -> Vec<Vec<Assignment>> {
    let corners = 1_u32.checked_shl(moved.len() as u32).unwrap_or(u32::MAX).min(MOST_CORNERS);
    let corner = |index: u32| {
        // Of more corners than are taken, these are spread over all of them.
        let bits = if moved.len() > 6 { index.wrapping_mul(0x9E37_79B1).rotate_left(9) ^ index } else { index };
        let share = move |place: usize, _: usize| f64::from(bits >> (place % 32) & 1);
        setting(valued, moved, &share)
    };
    let sequence = EvenSequence::new(3 * moved.len().max(1));
    let inside = |index: u32| {
        let share = move |place: usize, component: usize| sequence.coordinate(index + 1, 3 * place + component);
        setting(valued, moved, &share)
    };
    (0..corners).map(corner).chain((0..INSIDE).map(inside)).collect()
}

/// The values at parts of the ranges.
fn setting(valued: &ValuedFormula, moved: &[(OwnerId, ParameterId)], share: &dyn Fn(usize, usize) -> f64) -> Vec<Assignment> {
    let assignment = |(place, (owner, parameter)): (usize, &(OwnerId, ParameterId))| Assignment {
        owner: *owner,
        parameter: *parameter,
        value: std::array::from_fn(|component| at(valued.formula.parameter(*parameter), share(place, component))),
    };
    moved.iter().enumerate().map(assignment).collect()
}

/// Looks at a formula over the ranges of its parameters.
pub(super) fn over_ranges(valued: &ValuedFormula) -> RangeFindings {
    let moved = moved(valued);
    let settings = settings(valued, &moved);
    let pairs: Vec<_> = spread_pairs().into_iter().step_by(3).collect();
    let progress = Progress::new("measuring settings");
    let done = AtomicUsize::new(0);
    let try_one = |given: &Vec<Assignment>| {
        let mut values = valued.values.clone();
        values.assign(given);
        let model = valued.model(&values);
        let azimuths = if depends_on_azimuth(&model, &pairs) { &AZIMUTHS[..] } else { &AZIMUTHS[..1] };
        let compared = COMPARED.into_iter().flat_map(|polar| azimuths.iter().map(move |azimuth| [polar, *azimuth]));
        // Errors of settings are not told.
        let care = IntegrationCare { judges_rounding: false, ..IntegrationCare::full(COARSE) };
        let integral = |angles| integrate_with(&model, Integration::OverViews, angles, care, &[]);
        let shares = compared.map(|angles| greatest_component(&integral(angles)).1);
        let share = shares.fold(0.0, f64::max);
        let numbers = model.values(&pairs);
        let smallest =
            numbers.iter().flatten().filter(|number| number.is_finite()).fold(f32::INFINITY, |least, number| least.min(*number));
        let is_finite = numbers.iter().flatten().all(|number| number.is_finite());
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress.tell(done as f64 / settings.len() as f64);
        Tried { values, share, smallest: f64::from(smallest), is_finite }
    };
    let tried: Vec<Tried> = settings.par_iter().map(try_one).collect();
    let said = |tried: &Tried| said(valued, &moved, &tried.values);
    let worst = tried.iter().max_by(|one, other| one.share.total_cmp(&other.share));
    let least = tried.iter().min_by(|one, other| one.smallest.total_cmp(&other.smallest));
    let greatest = worst.map(|worst| {
        let model = valued.model(&worst.values);
        let known = shares_at(&model, Integration::OverViews, &TOLD_ANGLES.map(|polar| [polar, 0.0]));
        (greatest(&model, Integration::OverViews, &ModelSurvey::of(&model), &known), said(worst))
    });
    RangeFindings {
        moved: moved.iter().map(|(_, id)| valued.formula.parameter(*id).name.clone()).collect(),
        settings: tried.len(),
        above_one: tried.iter().filter(|tried| tried.share > 1.0 + COARSE).count(),
        greatest,
        smallest: least.filter(|least| least.smallest.is_finite()).map(|least| (least.smallest, said(least))),
        not_finite: tried.iter().find(|tried| !tried.is_finite).map(said),
    }
}

/// Values as arguments of `--set` have them.
fn said(valued: &ValuedFormula, moved: &[(OwnerId, ParameterId)], values: &Values) -> String {
    let number = |value: &f32| format!("{}", (f64::from(*value) * 1e4).round() / 1e4);
    let one = |(owner, id): &(OwnerId, ParameterId)| {
        let numbers: Vec<String> = values.get(*owner, *id).iter().map(number).collect();
        let name = &valued.formula.parameter(*id).name;
        match numbers.as_slice() {
            [number] => format!("{name}={number}"),
            numbers => format!("{name}=<{}>", numbers.join(",")),
        }
    };
    moved.iter().map(one).collect::<Vec<_>>().join(" ")
}

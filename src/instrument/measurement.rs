//! What there is to say about a model: how much it reflects, whether it is reciprocal, and where its values are odd.

use crate::instrument::albedo::{EQUAL, GreatestAlbedo, SharePlace, shares_at};
use crate::instrument::closer::CloserLook;
use crate::instrument::hemisphere::Integration;
use crate::instrument::reciprocity::ReciprocityError;
use crate::instrument::search::greatest;
use crate::instrument::survey::ModelSurvey;
use crate::instrument::{DirectionPair, Reflectance};

/// The incoming angles for which shares are told, in degrees.
pub const TOLD_ANGLES: [f64; 11] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0, 89.0];

/// The shares of the light for one polar angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlbedoRow {
    /// The polar angle of the fixed direction, in degrees.
    pub polar: f64,
    /// Its azimuth, in degrees.
    pub azimuth: f64,
    /// The share of a beam from there that is reflected: red, green, blue.
    pub beam: [f64; 3],
    /// What a viewer there sees in a white furnace.
    pub furnace: [f64; 3],
    /// How wrong these may be.
    pub error: f64,
}

/// What was measured of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelMeasurement {
    /// The shares by polar angle, at azimuth 0; then those at the azimuth of the greatest share of a beam, if azimuths
    /// differ.
    pub rows: Vec<AlbedoRow>,
    /// The greatest share of a beam that is reflected.
    pub beam: GreatestAlbedo,
    /// The most that is seen in a white furnace.
    pub furnace: GreatestAlbedo,
    /// Whether values change when both directions turn about the normal.
    pub depends_on_azimuth: bool,
    /// Where the model is least reciprocal; none if it has no finite values.
    pub reciprocity: Option<ReciprocityError>,
    /// The smallest value, π · f · cos θ, of a component, and where it is; none if there is no finite value.
    pub least: Option<(f64, DirectionPair)>,
    /// A pair of directions where a value is not finite.
    pub not_finite: Option<DirectionPair>,
    /// The part of all pairs that have a value which is not finite.
    pub part_not_finite: f64,
    /// Whether a beam and a furnace have the same shares, as far as errors let it be told.
    shares_agree: bool,
}

/// Values that are not finite are in isolated directions if they are a smaller part of all pairs. A larger part may
/// hold more light than all others.
const ISOLATED: f64 = 5e-4;

/// Whether a model conserves energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EnergyVerdict {
    /// No more light leaves than comes.
    Conserves,
    /// There is no finite value.
    Unknown,
    /// The greatest share may be above 1 or not: its error reaches across 1.
    Uncertain,
    /// More light leaves than comes.
    DoesNot(GreatestAlbedo),
}

impl ModelMeasurement {
    /// Measures a model.
    pub fn of(model: &dyn Reflectance) -> Self {
        let survey = ModelSurvey::of(model);
        let told = |azimuth: f64| {
            let angles = TOLD_ANGLES.map(|polar| [polar, azimuth]);
            [Integration::OverViews, Integration::OverLights].map(|over| shares_at(model, over, &angles))
        };
        let mut tables = vec![told(0.0)];
        let mut look = CloserLook::new(model, &survey);
        let mut reciprocity = greater(survey.reciprocity, look.reciprocity(&inside(&survey, &tables[0])));
        let beam = greatest(model, Integration::OverViews, &survey, &tables[0][0]);
        reciprocity = greater(reciprocity, look.reciprocity(beam.top.as_slice()));
        // Both are the same integral if the model is reciprocal.
        let other = shares_at(model, Integration::OverLights, &[beam.angles]);
        let shares_agree =
            agree(&tables[0]) && other.iter().all(|place| place.agrees_with(beam.share, beam.error, beam.component));
        let is_same = shares_agree && reciprocity.is_some_and(|worst| worst.error < EQUAL);
        let furnace = if is_same { beam } else { greatest(model, Integration::OverLights, &survey, &tables[0][1]) };
        if !is_same {
            reciprocity = greater(reciprocity, look.reciprocity(furnace.top.as_slice()));
        }
        let worst = Some(beam.angles[1]).filter(|azimuth| survey.depends_on_azimuth && *azimuth > 0.5);
        tables.extend(worst.map(told));
        // No row has more than what is called the greatest share.
        let [beam, furnace] = match tables.get(1) {
            Some([beams, _]) if is_same => [beam.raised(beams); 2],
            Some([beams, furnaces]) => [beam.raised(beams), furnace.raised(furnaces)],
            None => [beam, furnace],
        };
        let places = || tables.iter().flatten().flatten();
        let not_finite = survey.not_finite.or_else(|| places().find_map(|place| place.integral.not_finite));
        let low = places().filter_map(|place| Some(place.integral.bottom?.0)).chain(survey.suspects.iter().copied());
        let different = reciprocity.iter().flat_map(|worst| [worst.pair, worst.pair.exchanged()]);
        let least = smaller(survey.least, look.least(&low.chain(different).collect::<Vec<_>>()));
        let rows = tables.iter().flat_map(|[beams, furnaces]| beams.iter().zip(furnaces).map(row)).collect();
        let ModelSurvey { depends_on_azimuth, part_not_finite, .. } = survey;
        Self { rows, beam, furnace, depends_on_azimuth, reciprocity, least, not_finite, part_not_finite, shares_agree }
    }

    /// Whether so few values are not finite that the others stand for the model.
    pub fn is_mostly_finite(&self) -> bool {
        self.part_not_finite <= ISOLATED
    }

    /// Whether the model is reciprocal, as far as rounding lets it be told; none if it cannot be told.
    pub fn is_reciprocal(&self) -> Option<bool> {
        match self.reciprocity {
            Some(worst) if worst.error >= EQUAL => Some(false),
            Some(_) if self.is_mostly_finite() && self.shares_agree => Some(true),
            Some(_) | None => None,
        }
    }

    /// Whether values change when both directions turn about the normal; none if it cannot be told.
    pub fn azimuth_matters(&self) -> Option<bool> {
        if self.depends_on_azimuth { Some(true) } else { self.is_mostly_finite().then_some(false) }
    }

    /// Whether the model conserves energy: whether it reflects at most all of any beam.
    pub fn verdict(&self) -> EnergyVerdict {
        match (self.least, self.beam.above_one) {
            (None, _) => EnergyVerdict::Unknown,
            (_, Some(_)) => EnergyVerdict::DoesNot(self.beam),
            (_, None) if self.beam.is_uncertain() || !self.is_mostly_finite() || self.is_absurd() => EnergyVerdict::Uncertain,
            (_, None) => EnergyVerdict::Conserves,
        }
    }

    /// Whether a share is far below 0, or its error larger than all of the light. Then values cancel each other, and
    /// what remains says nothing.
    fn is_absurd(&self) -> bool {
        self.rows.iter().any(|row| row.error > 1.0 || row.beam.iter().any(|share| *share < -ABSURD))
    }
}

/// A share below its negative is absurd.
const ABSURD: f64 = 100.0;

/// Pairs inside of the lobes that integrals found, and where the survey found differences.
fn inside(survey: &ModelSurvey, table: &[Vec<SharePlace>; 2]) -> Vec<DirectionPair> {
    let tops = table.iter().flatten().filter_map(|place| Some(place.integral.top?.0));
    let peaks = [Integration::OverViews, Integration::OverLights].into_iter().flat_map(|over| survey.peaks(over));
    tops.chain(peaks.copied()).chain(survey.suspects.iter().copied()).collect()
}

fn greater(one: Option<ReciprocityError>, other: Option<ReciprocityError>) -> Option<ReciprocityError> {
    // A model without finite values has no difference, wherever it is looked at.
    let other = other.filter(|other| one.is_some_and(|one| other.error > one.error));
    other.or(one)
}

fn smaller(one: Option<(f64, DirectionPair)>, other: Option<(f64, DirectionPair)>) -> Option<(f64, DirectionPair)> {
    let other = other.filter(|other| one.is_some_and(|one| other.0 < one.0));
    other.or(one)
}

/// Whether the shares of beams and in furnaces are the same.
fn agree([beams, furnaces]: &[Vec<SharePlace>; 2]) -> bool {
    let same = |(beam, furnace): (&SharePlace, &SharePlace)| {
        let is_missing = beam.integral.not_finite.is_some();
        is_missing || (0..3).all(|component| furnace.agrees_with(beam.integral.value[component], beam.integral.error, component))
    };
    beams.iter().zip(furnaces).all(same)
}

/// A row of the table, from the shares of a beam and in a furnace.
fn row((beam, furnace): (&SharePlace, &SharePlace)) -> AlbedoRow {
    AlbedoRow {
        polar: beam.angles[0],
        azimuth: beam.angles[1],
        beam: beam.integral.value,
        furnace: furnace.integral.value,
        error: beam.integral.error.max(furnace.integral.error),
    }
}

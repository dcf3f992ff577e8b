//! What there is to say about a model: how much it reflects, whether it is reciprocal, and where its values are odd.

use crate::instrument::albedo::{EQUAL, GreatestAlbedo, SharePlace, shares_at};
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
}

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
        let beam = greatest(model, Integration::OverViews, &survey, &tables[0][0]);
        // Both are the same integral if the model is reciprocal.
        let is_reciprocal = survey.reciprocity.is_some_and(|worst| worst.error < EQUAL);
        let furnace = if is_reciprocal { beam } else { greatest(model, Integration::OverLights, &survey, &tables[0][1]) };
        let worst = Some(beam.angles[1]).filter(|azimuth| survey.depends_on_azimuth && *azimuth > 0.5);
        tables.extend(worst.map(told));
        // No row has more than what is called the greatest share.
        let [beam, furnace] = match tables.get(1) {
            Some([beams, _]) if is_reciprocal => [beam.raised(beams); 2],
            Some([beams, furnaces]) => [beam.raised(beams), furnace.raised(furnaces)],
            None => [beam, furnace],
        };
        let in_integrals = || tables.iter().flatten().flatten().find_map(|place| place.integral.not_finite);
        let not_finite = survey.not_finite.or_else(in_integrals);
        let rows = tables.iter().flat_map(|[beams, furnaces]| beams.iter().zip(furnaces).map(row)).collect();
        let ModelSurvey { depends_on_azimuth, reciprocity, least, .. } = survey;
        Self { rows, beam, furnace, depends_on_azimuth, reciprocity, least, not_finite }
    }

    /// Whether the model is reciprocal, as far as rounding lets it be told.
    pub fn is_reciprocal(&self) -> bool {
        self.reciprocity.is_some_and(|worst| worst.error < EQUAL)
    }

    /// Whether the model conserves energy: whether it reflects at most all of any beam.
    pub fn verdict(&self) -> EnergyVerdict {
        match (self.least, self.beam.above_one) {
            (None, _) => EnergyVerdict::Unknown,
            (_, Some(_)) => EnergyVerdict::DoesNot(self.beam),
            (_, None) if self.beam.is_uncertain() => EnergyVerdict::Uncertain,
            (_, None) => EnergyVerdict::Conserves,
        }
    }
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

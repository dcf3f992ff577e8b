//! What there is to say about a model: how much it reflects, whether it is reciprocal, and where its values are odd.

use crate::instrument::albedo::{EQUAL, GreatestAlbedo, albedos};
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
    /// More light leaves than comes.
    DoesNot(GreatestAlbedo),
}

impl ModelMeasurement {
    /// Measures a model.
    pub fn of(model: &dyn Reflectance) -> Self {
        let survey = ModelSurvey::of(model);
        let beam = greatest(model, Integration::OverViews, &survey);
        // Both are the same integral if the model is reciprocal.
        let is_reciprocal = survey.reciprocity.is_some_and(|worst| worst.error < EQUAL);
        let furnace = if is_reciprocal { beam } else { greatest(model, Integration::OverLights, &survey) };
        let worst = Some(beam.angles[1]).filter(|azimuth| survey.depends_on_azimuth && *azimuth > 0.5);
        let azimuths = std::iter::once(0.0).chain(worst);
        let angles: Vec<[f64; 2]> = azimuths.flat_map(|azimuth| TOLD_ANGLES.map(|polar| [polar, azimuth])).collect();
        let beams = albedos(model, Integration::OverViews, &angles);
        let furnaces = albedos(model, Integration::OverLights, &angles);
        let in_integrals = || beams.iter().chain(&furnaces).find_map(|integral| integral.not_finite);
        let not_finite = survey.not_finite.or_else(in_integrals);
        let rows = angles.iter().zip(beams.iter().zip(&furnaces)).map(|([polar, azimuth], (beam, furnace))| AlbedoRow {
            polar: *polar,
            azimuth: *azimuth,
            beam: beam.value,
            furnace: furnace.value,
            error: beam.error.max(furnace.error),
        });
        let ModelSurvey { depends_on_azimuth, reciprocity, least, .. } = survey;
        Self { rows: rows.collect(), beam, furnace, depends_on_azimuth, reciprocity, least, not_finite }
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
            (_, None) => EnergyVerdict::Conserves,
        }
    }
}

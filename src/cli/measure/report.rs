//! What `measure --json` prints. Angles are in degrees: from the normal, and around it from the tangent.

use crate::cli::measure::settings::RangeFindings;
use illuminator::instrument::DirectionPair;
use illuminator::instrument::albedo::{ACCURACY, EQUAL, GreatestAlbedo};
use illuminator::instrument::expressions::ExpressionRange;
use illuminator::instrument::hemisphere::angles_of;
use illuminator::instrument::measurement::{EnergyVerdict, ModelMeasurement};
use serde::Serialize;

/// The names of the components of colours.
pub(super) const COMPONENTS: [&str; 3] = ["red", "green", "blue"];

/// What was measured of a model.
#[derive(Serialize)]
pub(super) struct MeasurementReport {
    /// The model.
    pub(super) model: String,
    /// Whether at most all of any beam of light is reflected; null if that cannot be told.
    pub(super) conserves_energy: Option<bool>,
    /// The same in words: `conserved`, `not conserved`, `cannot be told` or `no finite value`.
    pub(super) energy: &'static str,
    /// The greatest share of a beam that is reflected.
    pub(super) greatest_albedo: GreatestReport,
    /// The most that a viewer sees in a white furnace.
    pub(super) greatest_in_furnace: GreatestReport,
    /// The shares by the angle of the beam, or of the viewer, at azimuth 0; then those at the azimuth of the greatest
    /// share, if azimuths differ.
    pub(super) albedo: Vec<AlbedoReport>,
    /// Whether values change when both directions turn about the normal; null if that cannot be told.
    pub(super) depends_on_azimuth: Option<bool>,
    /// Whether values are the same if light and viewer change places; null if that cannot be told.
    pub(super) is_reciprocal: Option<bool>,
    /// Where they differ most; null if there is no finite value.
    pub(super) reciprocity: Option<ReciprocityReport>,
    /// The smallest value, π · BRDF · cos θ; null if there is no finite value.
    pub(super) smallest: Option<SmallestReport>,
    /// A pair of directions where a value is not finite; null if there is none.
    pub(super) not_finite: Option<PairReport>,
    /// The part of all pairs of directions for which a value is not finite.
    pub(super) part_not_finite: f64,
    /// Whether this part is so small that the others stand for the model.
    #[serde(skip)]
    pub(super) is_mostly_finite: bool,
    /// How many pairs of directions the expressions were evaluated for.
    pub(super) pairs: usize,
    /// The macros and the result of the formula.
    pub(super) expressions: Vec<ExpressionReport>,
    /// The same over the ranges of parameters, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) ranges: Option<RangeReport>,
}

/// What was found over the ranges of parameters. Values are written as for `--set`.
#[derive(Serialize)]
pub(super) struct RangeReport {
    /// The parameters that were moved.
    pub(super) parameters: Vec<String>,
    /// How many settings were tried, and how many of them reflect more than all of a beam.
    pub(super) settings: usize,
    pub(super) above_one: usize,
    /// The greatest share of a beam, and the values there.
    pub(super) greatest_albedo: Option<GreatestReport>,
    pub(super) greatest_with: Option<String>,
    /// The smallest value, and the values of parameters there.
    pub(super) smallest: Option<f64>,
    pub(super) smallest_with: Option<String>,
    /// Values of parameters for which a value is not finite; null if there are none.
    pub(super) not_finite_with: Option<String>,
}

impl RangeReport {
    fn new(found: RangeFindings) -> Self {
        let (greatest, greatest_with) = found.greatest.unzip();
        let (smallest, smallest_with) = found.smallest.unzip();
        Self {
            parameters: found.moved,
            settings: found.settings,
            above_one: found.above_one,
            greatest_albedo: greatest.as_ref().map(GreatestReport::new),
            greatest_with,
            smallest,
            smallest_with,
            not_finite_with: found.not_finite,
        }
    }
}

/// The greatest share of the light.
#[derive(Serialize)]
pub(super) struct GreatestReport {
    pub(super) share: f64,
    /// How wrong it may be.
    pub(super) error: f64,
    pub(super) component: &'static str,
    pub(super) theta: f64,
    pub(super) phi: f64,
    /// The angles from which and to which it is above 1; null if it is not.
    pub(super) above_one_from: Option<f64>,
    pub(super) above_one_to: Option<f64>,
    /// Whether the error reaches across 1, so that it cannot be told whether it is above 1.
    pub(super) is_uncertain: bool,
    /// Whether it is at the greatest angle that is looked at, so it may be greater beyond.
    pub(super) at_last_angle: bool,
}

/// The shares of the light for one angle.
#[derive(Serialize)]
pub(super) struct AlbedoReport {
    pub(super) theta: f64,
    pub(super) phi: f64,
    /// The share of a beam that is reflected: red, green, blue.
    pub(super) beam: [f64; 3],
    /// What a viewer sees in a white furnace.
    pub(super) furnace: [f64; 3],
    pub(super) error: f64,
}

/// Two directions: angles from the normal and around it.
#[derive(Serialize)]
pub(super) struct PairReport {
    pub(super) light: [f64; 2],
    pub(super) view: [f64; 2],
}

#[derive(Serialize)]
pub(super) struct ReciprocityReport {
    /// The difference relative to the greater value.
    pub(super) error: f64,
    #[serde(flatten)]
    pub(super) at: PairReport,
}

#[derive(Serialize)]
pub(super) struct SmallestReport {
    pub(super) value: f64,
    #[serde(flatten)]
    pub(super) at: PairReport,
}

/// The range of an expression.
#[derive(Serialize)]
pub(super) struct ExpressionReport {
    /// The name of the macro; `=` for the result.
    pub(super) name: String,
    /// The least and the greatest finite number, over all components; null if there is none.
    pub(super) least: Option<f64>,
    pub(super) greatest: Option<f64>,
    /// For how many pairs of directions it is not a number, and one of them.
    pub(super) not_numbers: usize,
    pub(super) not_a_number_at: Option<PairReport>,
    /// For how many it is infinite, and one of them.
    pub(super) infinite: usize,
    pub(super) infinite_at: Option<PairReport>,
}

/// Rounds to what the accuracy of shares allows to be told.
fn share(value: f64) -> f64 {
    (value * 1e5).round() / 1e5
}

/// Rounds an angle to thousandths of a degree.
fn angle(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

impl GreatestReport {
    fn new(greatest: &GreatestAlbedo) -> Self {
        let [theta, phi] = greatest.angles;
        Self {
            share: share(greatest.share),
            error: greatest.error,
            component: COMPONENTS[greatest.component % COMPONENTS.len()],
            theta: angle(theta),
            phi: angle(phi),
            above_one_from: greatest.above_one.map(|[from, _]| angle(from)),
            above_one_to: greatest.above_one.map(|[_, to]| angle(to)),
            is_uncertain: greatest.is_uncertain(),
            at_last_angle: greatest.is_at_end(),
        }
    }
}

impl PairReport {
    fn new(pair: &DirectionPair) -> Self {
        let [light, view] = angles_of(pair).map(|angles| angles.map(angle));
        Self { light, view }
    }
}

impl MeasurementReport {
    pub(super) fn new(
        model: &str,
        measured: &ModelMeasurement,
        (expressions, pairs): (&[ExpressionRange], usize),
        ranges: Option<RangeFindings>,
    ) -> Self {
        let (conserves_energy, energy) = match measured.verdict() {
            EnergyVerdict::Conserves => (Some(true), "conserved"),
            EnergyVerdict::DoesNot(_) => (Some(false), "not conserved"),
            EnergyVerdict::Uncertain => (None, "cannot be told"),
            EnergyVerdict::Unknown => (None, "no finite value"),
        };
        let rows = measured.rows.iter().map(|row| AlbedoReport {
            theta: row.polar,
            phi: angle(row.azimuth),
            beam: row.beam.map(share),
            furnace: row.furnace.map(share),
            error: row.error,
        });
        let expression = |range: &ExpressionRange| ExpressionReport {
            name: range.name.clone(),
            least: range.range.map(|[least, _]| least),
            greatest: range.range.map(|[_, greatest]| greatest),
            not_numbers: range.not_numbers.0,
            not_a_number_at: range.not_numbers.1.as_ref().map(PairReport::new),
            infinite: range.infinite.0,
            infinite_at: range.infinite.1.as_ref().map(PairReport::new),
        };
        Self {
            model: model.to_owned(),
            conserves_energy,
            energy,
            greatest_albedo: GreatestReport::new(&measured.beam),
            greatest_in_furnace: GreatestReport::new(&measured.furnace),
            albedo: rows.collect(),
            depends_on_azimuth: measured.azimuth_matters(),
            is_reciprocal: measured.is_reciprocal(),
            reciprocity: measured
                .reciprocity
                .map(|worst| ReciprocityReport { error: worst.error, at: PairReport::new(&worst.pair) }),
            smallest: measured.least.map(|(value, pair)| SmallestReport { value, at: PairReport::new(&pair) }),
            not_finite: measured.not_finite.as_ref().map(PairReport::new),
            part_not_finite: share(measured.part_not_finite),
            is_mostly_finite: measured.is_mostly_finite(),
            pairs,
            expressions: expressions.iter().map(expression).collect(),
            ranges: ranges.map(RangeReport::new),
        }
    }

    /// How wrong shares may be, if that is more than is usual: a model may be too rough to be integrated.
    pub(super) fn large_error(&self) -> Option<f64> {
        let of_rows = self.albedo.iter().map(|row| (row.error, row.beam.iter().chain(&row.furnace).copied().fold(1.0, f64::max)));
        let greatest =
            [&self.greatest_albedo, &self.greatest_in_furnace].map(|greatest| (greatest.error, greatest.share.max(1.0)));
        let large = of_rows.chain(greatest).filter(|(error, scale)| *error > 1.5 * ACCURACY * scale);
        large.map(|(error, _)| error).max_by(f64::total_cmp)
    }

    /// Whether red, green and blue are the same everywhere, so one column tells all.
    pub(super) fn is_grey(&self) -> bool {
        let same = |[red, green, blue]: [f64; 3]| (red - green).abs() < EQUAL && (green - blue).abs() < EQUAL;
        self.albedo.iter().all(|row| same(row.beam) && same(row.furnace))
    }
}

//! The verdict on energy: whether a model reflects more light than it gets, in words.

use crate::instrument::DirectionPair;
use crate::instrument::albedo::EQUAL;
use crate::instrument::direction::{STEEPEST, angle_text, angles};
use crate::instrument::measurement::{EnergyVerdict, ModelMeasurement};

/// What is said of a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct VerdictWords {
    /// One line.
    pub(super) text: String,
    /// Whether something is wrong.
    pub(super) is_warning: bool,
    /// Further lines: what else was measured.
    pub(super) details: String,
}

/// A share as a percentage. Near the whole, tenths matter. What is far above it is told as a multiple.
fn percent(share: f64) -> String {
    if share >= 100.0 {
        return format!("{share:.0} times as much");
    }
    let decimals = usize::from((share - 1.0).abs() < 0.01);
    format!("{:.decimals$} %", 100.0 * share)
}

/// Beyond this angle, in degrees, a direction is along the surface.
const ALONG: f64 = 89.0;

/// An angle, with more digits along the surface.
fn degrees(angle: f64) -> String {
    let decimals = if angle > ALONG { 2 } else { 0 };
    format!("{angle:.decimals$}°")
}

/// Rounding makes numbers this small of either sign.
const ROUNDING: f64 = -1e-6;

impl VerdictWords {
    /// The words for a measurement.
    pub(super) fn new(measured: &ModelMeasurement) -> Self {
        let best = measured.beam;
        let has_colour = measured.rows.iter().any(|row| row.beam.iter().any(|share| (share - row.beam[0]).abs() > 1e-3));
        let light = if has_colour { [" red", " green", " blue"][best.component.min(2)] } else { "" };
        let [polar, azimuth] = best.angles;
        let around = if measured.depends_on_azimuth { format!(", azimuth {azimuth:.0}°") } else { String::new() };
        let at = if is_level(measured) { "every angle".to_owned() } else { format!("{}{around}", degrees(polar)) };
        let verdict = measured.verdict();
        let mut text = match verdict {
            EnergyVerdict::Unknown => "Has no finite value".to_owned(),
            EnergyVerdict::Conserves if best.share <= 0.0 => "Reflects no light".to_owned(),
            EnergyVerdict::Conserves => {
                let share = percent(best.share);
                format!("Conserves energy: at most {share} of the{light} light is reflected (at {at})")
            }
            EnergyVerdict::Uncertain if !measured.is_mostly_finite() => {
                "Energy cannot be told: many values are not finite".to_owned()
            }
            EnergyVerdict::Uncertain => {
                let (share, error) = (percent(best.share), percent(best.error));
                format!("Energy cannot be told: about {share} ± {error} of the{light} light is reflected (at {at})")
            }
            EnergyVerdict::DoesNot(_) => {
                let from = match best.above_one.map(|[from, _]| from) {
                    _ if is_level(measured) => String::new(),
                    Some(from) if from > ALONG => format!("; only along the surface, above 100 % from {}", degrees(from)),
                    Some(from) if from >= 0.5 => format!("; above 100 % from {}", degrees(from)),
                    Some(_) => "; above 100 % from 0°".to_owned(),
                    None => String::new(),
                };
                format!("Gives out more{light} light than it gets: {} at {at}{from}", percent(best.share))
            }
        };
        let is_negative = measured.least.is_some_and(|(least, _)| least < ROUNDING);
        for (is_so, words) in [(is_negative, "; negative somewhere"), (measured.not_finite.is_some(), "; no number somewhere")] {
            if is_so {
                text.push_str(words);
            }
        }
        let is_warning = verdict != EnergyVerdict::Conserves || is_negative || measured.not_finite.is_some();
        Self { text, is_warning, details: details(measured) }
    }
}

/// Whether the share is the same at all angles.
fn is_level(measured: &ModelMeasurement) -> bool {
    let component = measured.beam.component.min(2);
    let is_equal = |share: f64| (share - measured.beam.share).abs() < EQUAL * measured.beam.share;
    measured.rows.iter().all(|row| is_equal(row.beam[component]))
}

/// Where light and viewer are.
fn place(pair: &DirectionPair) -> String {
    let [[light, around], [view, view_around]] = [pair.light, pair.view].map(angles);
    let azimuth = angle_text((view_around - around).rem_euclid(360.0).round());
    format!("for light at {} and the viewer at {}, {azimuth} around from it", degrees(light), degrees(view))
}

fn details(measured: &ModelMeasurement) -> String {
    let mut lines = Vec::new();
    let furnace = measured.furnace;
    lines.push(format!(
        "In a white furnace it shows at most {} of the light, at {}.",
        percent(furnace.share),
        degrees(furnace.angles[0])
    ));
    lines.push(match measured.reciprocity {
        Some(_) if measured.is_reciprocal() == Some(true) => "It is reciprocal: light and viewer may change places.".to_owned(),
        Some(_) if measured.is_reciprocal().is_none() => "Whether it is reciprocal cannot be told.".to_owned(),
        Some(worst) => format!("It is not reciprocal: values differ by up to {:.0} %.", 100.0 * worst.error),
        None => "It has no finite values.".to_owned(),
    });
    if measured.beam.is_at_end() {
        lines.push(format!("Beams are looked at up to {STEEPEST}° from the normal; the share may be greater beyond."));
    }
    if measured.depends_on_azimuth {
        lines.push("It is anisotropic.".to_owned());
    }
    if let Some((least, pair)) = measured.least.filter(|(least, _)| *least < ROUNDING) {
        lines.push(format!("Its least value is {least:.4}, {}.", place(&pair)));
    }
    if let Some(pair) = measured.not_finite {
        lines.push(format!("It has no finite value, for instance, {}.", place(&pair)));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::Reflectance;

    /// A matte surface of this albedo.
    struct Matte([f32; 3]);

    impl Reflectance for Matte {
        fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]> {
            pairs.iter().map(|pair| self.0.map(|albedo| albedo * pair.light[2])).collect()
        }
    }

    /// Reflects twice the light in half of the directions, in stripes that are too narrow to be integrated.
    struct Striped;

    impl Reflectance for Striped {
        fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]> {
            let stripe = |x: f32| if (99_999.0 * x).fract() < 0.5 { 2.0 } else { 0.0 };
            pairs.iter().map(|pair| [stripe(pair.view[0] + 1.0) * pair.light[2]; 3]).collect()
        }
    }

    #[test]
    fn the_verdict_has_the_albedo_of_matte_surfaces() {
        let of = |albedo: [f32; 3]| VerdictWords::new(&ModelMeasurement::of(&Matte(albedo)));
        let half = of([0.5; 3]);
        assert!(half.text.starts_with("Conserves energy: at most 50 % of the light is reflected"), "{}", half.text);
        assert!(!half.is_warning && half.details.contains("It is reciprocal"));
        let more = of([0.2, 1.5, 0.3]);
        assert!(more.text.starts_with("Gives out more green light than it gets: 150 % at "), "{}", more.text);
        assert!(more.is_warning && more.text.ends_with("150 % at every angle"), "{}", more.text);
        assert!(of([3000.0; 3]).text.ends_with("3000 times as much at every angle"));
        assert_eq!(of([0.0; 3]).text, "Reflects no light");
        assert_eq!([89.94, 45.2].map(degrees), ["89.94°", "45°"]);
        let words = VerdictWords::new(&ModelMeasurement::of(&Striped));
        assert!(words.is_warning && words.text.starts_with("Energy cannot be told: about "), "{}", words.text);
        let odd = of([f32::NAN; 3]);
        assert!(odd.is_warning && odd.text.ends_with("no number somewhere"), "{}", odd.text);
    }
}

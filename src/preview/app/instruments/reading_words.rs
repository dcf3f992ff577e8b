//! The numbers for the viewer and the lights of a chart, in words.

use crate::instrument::direction::angle_text;
use crate::instrument::view::{DirectionReading, NamedModel};
use crate::preview::app::instruments::plots::colour_text;

/// What is read out above a chart.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct ReadingWords {
    /// One line.
    pub(super) line: String,
    /// The same, with a line for each light and model.
    pub(super) details: String,
}

impl ReadingWords {
    /// The words for these numbers. `viewer` is the angle of the viewer in degrees.
    pub(super) fn new(models: &[NamedModel], viewer: f64, readings: &[DirectionReading]) -> Self {
        let viewer = format!("viewer {}", angle_text(viewer));
        let entry = |reading: &DirectionReading| {
            let name = models.get(reading.model).map(|model| model.name.as_str()).filter(|_| models.len() > 1);
            let name = name.map(|name| format!("{name}, ")).unwrap_or_default();
            let [brdf, value] = [reading.brdf, reading.value].map(|colour| colour_text(colour).replace('-', "−"));
            format!("{name}light {}: BRDF {brdf}, value {value}", angle_text(reading.light))
        };
        let entries: Vec<String> = readings.iter().map(entry).collect();
        let line = format!("{viewer}; {}", entries.join("; "));
        let details = format!(
            "{viewer}, in the plane of the curves\n{}\nBRDF in 1/sr; the value is π · BRDF · cos θ of the light",
            entries.join("\n")
        );
        Self { line, details }
    }
}

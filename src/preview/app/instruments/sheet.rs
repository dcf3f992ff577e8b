//! Charts made on another thread: the numbers, and the drawing where egui draws none itself. And charts as files.

use crate::files::{reason, replace_file};
use crate::instrument::view::{InstrumentView, NamedModel, ViewSettings, readings};
use crate::picture::Bitmap;
use crate::plot::{Chart, ChartFormat, ChartHeading, ChartTheme, painted};
use crate::preview::app::instruments::reading_words::ReadingWords;
use egui::ColorImage;
use std::io::Write;
use std::path::Path;
use std::time::{Duration, Instant};

/// What a chart is wanted of.
pub(super) struct SheetRequest {
    /// Grows from request to request.
    pub(super) number: u64,
    pub(super) view: &'static InstrumentView,
    pub(super) models: Vec<NamedModel>,
    pub(super) settings: ViewSettings,
    /// The angle of a viewer whose numbers are read out, in degrees.
    pub(super) viewer: Option<f64>,
    /// Width and height in points.
    pub(super) size: [u32; 2],
    /// Pixels per point.
    pub(super) scale: f64,
    pub(super) theme: ChartTheme,
}

/// A chart, ready to be shown.
pub(super) struct DrawnChart {
    pub(super) number: u64,
    /// The name of the view.
    pub(super) view: &'static str,
    /// Its heading is taken out.
    pub(super) chart: Chart,
    pub(super) heading: ChartHeading,
    /// What is read out above it; empty without a viewer.
    pub(super) reading: ReadingWords,
    /// The width and height that it was asked for, in points.
    pub(super) size: [u32; 2],
    /// The drawing, of charts that egui does not draw itself.
    pub(super) image: Option<ColorImage>,
    pub(super) time: Duration,
}

impl DrawnChart {
    /// Makes a chart.
    pub(super) fn new(request: &SheetRequest) -> Self {
        let start = Instant::now();
        let mut chart = request.view.chart(&request.models, &request.settings);
        let heading = std::mem::take(chart.heading_mut());
        let image = match &chart {
            Chart::Cartesian(_) | Chart::Polar(_) => None,
            Chart::Map(_) | Chart::Lobe(_) => {
                let figure = chart.figure(request.size, request.theme).scaled(request.scale);
                painted(&figure).ok().map(|bitmap| image_of(&bitmap))
            }
        };
        let read =
            |viewer: f64| ReadingWords::new(&request.models, viewer, &readings(&request.models, &request.settings, viewer));
        let reading = request.viewer.map(read).unwrap_or_default();
        let (number, view, size) = (request.number, request.view.name, request.size);
        Self { number, view, chart, heading, reading, size, image, time: start.elapsed() }
    }
}

fn image_of(bitmap: &Bitmap) -> ColorImage {
    ColorImage::from_rgb(bitmap.size().map(|side| side as usize), bitmap.bytes())
}

/// The size of saved drawings, in units of the drawing.
const SAVED_SIZE: [u32; 2] = [800, 600];
/// Pixels of a saved picture for each unit.
const SAVED_SCALE: u32 = 2;

/// Saves the chart of a request, on white paper, in the format of the suffix.
///
/// # Errors
/// The suffix names no format, or the file cannot be written. The error is for the user. An existing file is then
/// unchanged.
pub(super) fn save(request: &SheetRequest, path: &Path) -> Result<(), String> {
    let name = path.display();
    let format = ChartFormat::of(path)
        .ok_or_else(|| format!("`{name}` names no format of charts; their suffixes are {}", ChartFormat::suffixes()))?;
    let unwritten = |error: std::io::Error| format!("cannot write the chart `{name}`: {}", reason(&error));
    let chart = request.view.chart(&request.models, &request.settings);
    // A picture has more pixels than a drawing has units, so that it is sharp in a document.
    let scale = if format == ChartFormat::Png { SAVED_SCALE } else { 1 };
    let bytes = format.bytes(&chart, SAVED_SIZE.map(|side| scale * side), ChartTheme::Light)?;
    replace_file(path, |file| file.write_all(&bytes)).map_err(unwritten)
}

//! The formats in which charts are saved.

use crate::picture::{Format, bitmap_file_bytes};
use crate::plot::chart::Chart;
use crate::plot::raster::painted;
use crate::plot::solid::buffer_memory;
use crate::plot::svg::svg;
use crate::plot::theme::ChartTheme;
use std::path::Path;

/// A format of saved charts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChartFormat {
    /// A picture of pixels.
    Png,
    /// A picture of lines.
    Svg,
    /// The numbers.
    Csv,
}

impl ChartFormat {
    /// All of them. The first one is suggested.
    pub const ALL: [ChartFormat; 3] = [ChartFormat::Png, ChartFormat::Svg, ChartFormat::Csv];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            ChartFormat::Png => "PNG",
            ChartFormat::Svg => "SVG",
            ChartFormat::Csv => "CSV, the numbers",
        }
    }

    /// The suffix of its files, without a dot.
    pub fn suffix(self) -> &'static str {
        match self {
            ChartFormat::Png => "png",
            ChartFormat::Svg => "svg",
            ChartFormat::Csv => "csv",
        }
    }

    /// The suffixes of all formats, as in `.png, .svg, .csv`.
    pub fn suffixes() -> String {
        Self::ALL.map(|format| format!(".{}", format.suffix())).join(", ")
    }

    /// The format of a path.
    pub fn of(path: &Path) -> Option<Self> {
        let suffix = path.extension()?;
        Self::ALL.into_iter().find(|format| suffix.eq_ignore_ascii_case(format.suffix()))
    }

    /// How much memory a file of a chart of this many pixels takes while it is made, in bytes. It counts what grows
    /// with the pixels.
    pub fn memory(self, chart: &Chart, [width, height]: [u32; 2]) -> u64 {
        /// A canvas of four bytes, a picture of three that may have room for twice as many, and the file.
        const PAINTED: u64 = 16;
        /// A picture in a figure, and a canvas to fit it into its place.
        const PICTURE: u64 = 10;
        /// The same as a file, in the letters of SVG.
        const WRITTEN: u64 = 15;
        let pixels = u64::from(width) * u64::from(height);
        let of_lobes = if matches!(chart, Chart::Lobe(_)) { buffer_memory(pixels) + PICTURE * pixels } else { 0 };
        match self {
            ChartFormat::Csv => 0,
            ChartFormat::Svg if of_lobes > 0 => of_lobes + WRITTEN * pixels,
            ChartFormat::Svg => 0,
            ChartFormat::Png => of_lobes + PAINTED * pixels,
        }
    }

    /// The bytes of a file of a chart, of this many pixels.
    ///
    /// # Errors
    /// There is no memory for the picture. The text is a message for the user.
    pub fn bytes(self, chart: &Chart, size: [u32; 2], theme: ChartTheme) -> Result<Vec<u8>, String> {
        match self {
            ChartFormat::Csv => Ok(chart.table().csv().into_bytes()),
            ChartFormat::Svg => Ok(svg(&chart.figure(size, theme)).into_bytes()),
            ChartFormat::Png => {
                let bitmap = painted(&chart.figure(size, theme))?;
                bitmap_file_bytes(&bitmap, Format::Png).map_err(|error| format!("cannot encode the chart: {error}"))
            }
        }
    }
}

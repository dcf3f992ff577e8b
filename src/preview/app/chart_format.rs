//! The formats in which charts are saved.

use std::path::Path;

/// A format of saved charts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ChartFormat {
    /// A picture of pixels.
    Png,
    /// A picture of lines.
    Svg,
    /// The numbers.
    Csv,
}

impl ChartFormat {
    /// All of them. The first one is suggested.
    pub(super) const ALL: [ChartFormat; 3] = [ChartFormat::Png, ChartFormat::Svg, ChartFormat::Csv];

    /// Its name.
    pub(super) fn name(self) -> &'static str {
        match self {
            ChartFormat::Png => "PNG",
            ChartFormat::Svg => "SVG",
            ChartFormat::Csv => "CSV, the numbers",
        }
    }

    /// The suffix of its files, without a dot.
    pub(super) fn suffix(self) -> &'static str {
        match self {
            ChartFormat::Png => "png",
            ChartFormat::Svg => "svg",
            ChartFormat::Csv => "csv",
        }
    }

    /// The format of a path.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let suffix = path.extension()?;
        Self::ALL.into_iter().find(|format| suffix.eq_ignore_ascii_case(format.suffix()))
    }
}

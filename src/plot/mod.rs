//! Charts: from numbers to drawings, and from drawings to files.
//!
//! A [`Chart`] is what is shown, as numbers with names. It becomes a [`Figure`], which is a list of paths, texts and
//! images with places, and a [`NumberTable`], which is the same numbers as text. A figure is written as SVG
//! ([`svg`]) or painted ([`painted`]), so both look the same. The fonts are built in. Nothing here knows what the
//! numbers mean: [`instrument`](crate::instrument) does.

mod axis;
mod cartesian;
mod chart;
mod colours;
mod curve;
mod figure;
mod format;
mod layout;
mod lobe;
mod map;
mod number_table;
mod panels;
mod polar;
mod raster;
mod solid;
mod svg;
mod theme;
mod ticks;
mod typeface;

pub use axis::ChartAxis;
pub use cartesian::{CartesianChart, ReferenceLine};
pub use chart::Chart;
pub use colours::false_colour;
pub use curve::{ChartHeading, Curve, Dashes};
#[cfg(test)]
pub use figure::text_rectangles;
pub use figure::{Anchor, Figure, FigureMark, Ink, Stroke};
pub use format::ChartFormat;
pub use lobe::{Lobe, LobeChart};
pub use map::{MapChart, MapPanel, MapPixel, MapReading, MapValues};
pub use number_table::NumberTable;
pub use polar::PolarChart;
pub use raster::painted;
pub use svg::svg;
pub use theme::{CURVE_COLOURS, ChartTheme};
pub use typeface::{plain, subscript};

//! All kinds of charts.

use crate::plot::cartesian::CartesianChart;
use crate::plot::curve::ChartHeading;
use crate::plot::figure::Figure;
use crate::plot::lobe::LobeChart;
use crate::plot::map::MapChart;
use crate::plot::number_table::NumberTable;
use crate::plot::polar::PolarChart;
use crate::plot::theme::ChartTheme;

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub enum Chart {
    /// Curves over two axes.
    Cartesian(CartesianChart),
    /// Curves over an angle.
    Polar(PolarChart),
    /// Pictures over two axes.
    Map(MapChart),
    /// Lobes.
    Lobe(LobeChart),
}

impl Chart {
    /// The drawing, of this many pixels.
    pub fn figure(&self, size: [u32; 2], theme: ChartTheme) -> Figure {
        match self {
            Chart::Cartesian(chart) => chart.figure(size, theme),
            Chart::Polar(chart) => chart.figure(size, theme),
            Chart::Map(chart) => chart.figure(size, theme),
            Chart::Lobe(chart) => chart.figure(size, theme),
        }
    }

    /// What stands over it. Where that is written elsewhere, it may be taken away.
    pub fn heading_mut(&mut self) -> &mut ChartHeading {
        match self {
            Chart::Cartesian(chart) => &mut chart.heading,
            Chart::Polar(chart) => &mut chart.heading,
            Chart::Map(chart) => &mut chart.heading,
            Chart::Lobe(chart) => &mut chart.heading,
        }
    }

    /// The numbers.
    pub fn table(&self) -> NumberTable {
        match self {
            Chart::Cartesian(chart) => chart.table(),
            Chart::Polar(chart) => chart.table(),
            Chart::Map(chart) => chart.table(),
            Chart::Lobe(chart) => chart.table(),
        }
    }
}

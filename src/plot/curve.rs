//! What charts are made from beside axes: headings and curves.

/// What stands over a chart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChartHeading {
    /// What is shown.
    pub title: String,
    /// Of what, and how.
    pub subtitle: String,
}

impl ChartHeading {
    /// Says more below the title.
    pub fn add(&mut self, words: &str) {
        let separator = if self.subtitle.is_empty() { "" } else { "; " };
        self.subtitle.push_str(&format!("{separator}{words}"));
    }
}

/// How the line of a curve is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dashes {
    /// It is not.
    Solid,
    /// Dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dashes and dots.
    DashDotted,
}

impl Dashes {
    /// All of them, in the order in which they are used.
    pub const ALL: [Dashes; 4] = [Dashes::Solid, Dashes::Dashed, Dashes::Dotted, Dashes::DashDotted];

    /// The lengths of dashes and gaps, in widths of the line.
    pub(super) fn lengths(self, width: f64) -> Vec<f64> {
        let lengths: &[f64] = match self {
            Dashes::Solid => &[],
            Dashes::Dashed => &[3.5, 2.2],
            Dashes::Dotted => &[1.2, 1.6],
            Dashes::DashDotted => &[4.5, 1.8, 1.2, 1.8],
        };
        lengths.iter().map(|length| length * width).collect()
    }
}

/// A curve through points.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// What the legend says.
    pub name: String,
    /// The points. A point with a number that is not finite is a gap.
    pub points: Vec<[f64; 2]>,
    /// The number of its colour, counted from 0.
    pub colour: usize,
    /// How its line is broken.
    pub dashes: Dashes,
}

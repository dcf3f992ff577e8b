//! Axes: what they measure, and where a number is along them.

use crate::plot::ticks::{Tick, linear, logarithmic, widened};

/// How many decades a logarithmic axis shows below the greatest number, if its range is not given.
const MOST_DECADES: f64 = 6.0;

/// An axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChartAxis {
    /// What it measures.
    pub title: String,
    /// The unit of the numbers; empty if they have none. Angles are in degrees, which the ticks say.
    pub unit: String,
    /// The least and the greatest number; none to follow from the numbers.
    pub range: Option<[f64; 2]>,
    /// Whether equal distances are equal ratios.
    pub is_log: bool,
    /// Whether the numbers are angles in degrees.
    pub is_angle: bool,
}

impl ChartAxis {
    /// An axis of angles in degrees from `low` to `high`.
    pub fn angles(title: &str, [low, high]: [f64; 2]) -> Self {
        Self { title: title.to_owned(), range: Some([low, high]), is_angle: true, ..Self::default() }
    }

    /// An axis whose range follows from the numbers.
    pub fn numbers(title: &str, unit: &str, is_log: bool) -> Self {
        Self { title: title.to_owned(), unit: unit.to_owned(), is_log, ..Self::default() }
    }

    /// The title with the unit.
    pub fn full_title(&self) -> String {
        if self.unit.is_empty() { self.title.clone() } else { format!("{} ({})", self.title, self.unit) }
    }

    /// The heading of the column of a table: the title with the unit.
    pub(super) fn column(&self) -> String {
        if self.is_angle { format!("{} (°)", self.title) } else { self.full_title() }
    }

    /// The axis for these numbers, with about `most` ticks.
    pub(super) fn fitted(&self, numbers: impl Iterator<Item = f64> + Clone, most: f64) -> FittedAxis {
        let finite = numbers.filter(|number| number.is_finite());
        let range = if let Some(range) = self.range {
            range
        } else if self.is_log {
            let positive = finite.filter(|number| *number > 0.0);
            let greatest = positive.clone().fold(f64::NEG_INFINITY, f64::max);
            let least = positive.fold(f64::INFINITY, f64::min);
            if greatest.is_finite() {
                let high = (greatest.log10() - 1e-9).ceil();
                let low = (least.log10() + 1e-9).floor().clamp(high - MOST_DECADES, high - 1.0);
                [10_f64.powf(low), 10_f64.powf(high)]
            } else {
                [0.1, 1.0]
            }
        } else {
            let high = finite.clone().fold(0.0, f64::max);
            widened([finite.fold(0.0, f64::min), high], most)
        };
        let ticks = if self.is_log { logarithmic(range, most) } else { linear(range, most, self.is_angle) };
        FittedAxis { range, is_log: self.is_log, ticks }
    }
}

/// An axis with its range and ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FittedAxis {
    pub(super) range: [f64; 2],
    is_log: bool,
    pub(super) ticks: Vec<Tick>,
}

impl FittedAxis {
    /// Where a number is: 0 at the beginning of the axis, 1 at its end, and beyond. What a logarithmic axis has no
    /// place for is far before its beginning. NaN is NaN.
    pub(super) fn place(&self, number: f64) -> f64 {
        let [low, high] = self.range;
        if !self.is_log {
            return (number - low) / (high - low);
        }
        if number <= 0.0 {
            return -1.0;
        }
        ((number / low).log10() / (high / low).log10()).max(-1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_places() {
        let angles = ChartAxis::angles("angle", [-90.0, 90.0]).fitted(std::iter::empty(), 7.0);
        assert_eq!([-90.0, 0.0, 45.0].map(|angle| angles.place(angle)), [0.0, 0.5, 0.75]);
        let log = ChartAxis::numbers("f", "1/sr", true).fitted([0.02, 0.0, 30.0, f64::NAN].into_iter(), 7.0);
        assert_eq!(log.range.map(|end| (end * 1e6).round() / 1e6), [0.01, 100.0]);
        assert!((log.place(1.0) - 0.5).abs() < 1e-12 && log.place(0.0) == -1.0 && log.place(-3.0) == -1.0);
        let plain = ChartAxis::numbers("f", "1/sr", false).fitted([0.02, 0.93].into_iter(), 5.0);
        assert_eq!((plain.range, plain.place(0.25)), ([0.0, 1.0], 0.25));
        let empty = ChartAxis::numbers("f", "", true).fitted([0.0, f64::INFINITY].into_iter(), 5.0);
        assert_eq!(empty.range, [0.1, 1.0]);
    }
}

//! Charts of curves over two axes at right angles.

use crate::plot::axis::{ChartAxis, FittedAxis};
use crate::plot::curve::{ChartHeading, Curve};
use crate::plot::figure::{Anchor, Figure, Stroke};
use crate::plot::layout::{ChartArea, ChartSheet};
use crate::plot::number_table::NumberTable;
use crate::plot::theme::ChartTheme;
use crate::plot::typeface::width;

/// A number that is marked by a line across the chart.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceLine {
    /// The number.
    pub value: f64,
    /// What is written at the line.
    pub label: String,
}

/// Curves over two axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CartesianChart {
    /// What stands over it.
    pub heading: ChartHeading,
    /// The axis to the right.
    pub x: ChartAxis,
    /// The axis upwards.
    pub y: ChartAxis,
    /// The curves, from back to front.
    pub curves: Vec<Curve>,
    /// Numbers of the upward axis that are marked.
    pub lines: Vec<ReferenceLine>,
}

/// Where numbers are on the sheet.
struct CartesianFrame {
    area: ChartArea,
    x: FittedAxis,
    y: FittedAxis,
}

impl CartesianFrame {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (x, y) = (self.x.place(x), self.y.place(y));
        [self.area.left + x * self.area.width, self.area.bottom() - y * self.area.height]
    }
}

impl CartesianChart {
    /// The drawing.
    pub fn figure(&self, size: [u32; 2], theme: ChartTheme) -> Figure {
        let mut sheet = ChartSheet::new(size, theme, &self.heading);
        sheet.legend(&self.curves);
        let label = sheet.label_size();
        let numbers = |axis: usize| self.curves.iter().flat_map(move |curve| curve.points.iter().map(move |point| point[axis]));
        let most = (sheet.area.height / (4.2 * label)).clamp(2.0, 10.0);
        // A marked line has room above it.
        let marked = self.lines.iter().map(|line| 1.05 * line.value);
        let y = self.y.fitted(numbers(1).chain(marked), most);
        let x = self.x.fitted(numbers(0), (sheet.area.width / (4.8 * label)).clamp(2.0, 13.0));
        let widest = y.ticks.iter().map(|tick| width(&tick.label, label)).fold(0.0, f64::max);
        let margins = [1.9 * label + widest + 8.0 * sheet.unit, 0.6 * label, 1.2 * label, 3.6 * label];
        let frame = CartesianFrame { area: sheet.area.without(margins), x, y };
        self.draw_grid(&mut sheet, &frame);
        self.draw_titles(&mut sheet, &frame);
        for line in &self.lines {
            draw_reference(&mut sheet, &frame, line);
        }
        for curve in &self.curves {
            let places: Vec<[f64; 2]> = curve.points.iter().map(|point| frame.at(*point)).collect();
            let stroke = sheet.stroke(curve.colour, curve.dashes);
            for piece in pieces_within(&places, &frame.area) {
                sheet.figure.line(piece, stroke.clone());
            }
        }
        sheet.finish()
    }

    fn draw_grid(&self, sheet: &mut ChartSheet, frame: &CartesianFrame) {
        let (area, unit, theme) = (frame.area, sheet.unit, sheet.theme);
        for tick in &frame.x.ticks {
            let [x, _] = frame.at([tick.value, frame.y.range[0]]);
            let colour = if tick.label.is_empty() { theme.faint() } else { theme.grid() };
            sheet.figure.line(vec![[x, area.top], [x, area.bottom()]], Stroke::solid(colour, unit));
            let below = area.bottom() + 0.95 * sheet.label_size();
            sheet.label(tick.label.as_str(), [x, below], Anchor::Middle);
        }
        for tick in &frame.y.ticks {
            let [_, y] = frame.at([frame.x.range[0], tick.value]);
            let colour = if tick.label.is_empty() { theme.faint() } else { theme.grid() };
            sheet.figure.line(vec![[area.left, y], [area.right(), y]], Stroke::solid(colour, unit));
            sheet.label(tick.label.as_str(), [area.left - 8.0 * unit, y], Anchor::End);
        }
        sheet.figure.frame([area.left, area.top], [area.width, area.height], Stroke::solid(theme.frame(), unit));
    }

    fn draw_titles(&self, sheet: &mut ChartSheet, frame: &CartesianFrame) {
        let (size, area) = (sheet.title_size(), &frame.area);
        let below = sheet.area.bottom() - 0.4 * size;
        sheet.title(&self.x.full_title(), [area.left + 0.5 * area.width, below]);
        sheet.upright_title(&self.y.full_title(), [sheet.area.left + size, area.top + 0.5 * area.height]);
    }

    /// The numbers: a column for the axis to the right, and one for each curve. Where curves have other places than the
    /// first one, the rows are those of all curves in turn.
    pub fn table(&self) -> NumberTable {
        columns_of(&self.x, &self.curves)
    }
}

/// The numbers of curves over an axis.
pub(super) fn columns_of(axis: &ChartAxis, curves: &[Curve]) -> NumberTable {
    let columns = std::iter::once(axis.column()).chain(curves.iter().map(|curve| curve.name.clone())).collect();
    let mut places: Vec<f64> = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point[0])).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let mut table = NumberTable { columns, ..NumberTable::default() };
    for (row, place) in places.iter().enumerate() {
        let mut numbers = vec![*place];
        for curve in curves {
            let found = curve.points.binary_search_by(|point| point[0].total_cmp(place)).ok();
            if found.is_none() {
                table.empty.insert([row, numbers.len()]);
            }
            numbers.push(found.map_or(f64::NAN, |index| curve.points[index][1]));
        }
        table.rows.push(numbers);
    }
    table
}

/// A marked number, with what is written at it.
fn draw_reference(sheet: &mut ChartSheet, frame: &CartesianFrame, line: &ReferenceLine) {
    let place = frame.y.place(line.value);
    if !(0.0..=1.0).contains(&place) {
        return;
    }
    let y = frame.area.bottom() - place * frame.area.height;
    let colour = sheet.theme.warning();
    let width = 1.4 * sheet.unit;
    let stroke = Stroke { dashes: vec![6.0 * sheet.unit, 4.0 * sheet.unit], ..Stroke::solid(colour, width) };
    sheet.figure.line(vec![[frame.area.left, y], [frame.area.right(), y]], stroke);
    let size = sheet.label_size();
    let above = y - frame.area.top > 1.5 * size;
    let y = if above { y - 0.4 * size } else { y + 1.1 * size };
    sheet.figure.text(line.label.as_str(), [frame.area.left + 0.6 * size, y], Anchor::Start, (size, colour));
}

/// The parts of a line that are in an area. A point that is not finite ends a part.
pub(super) fn pieces_within(points: &[[f64; 2]], area: &ChartArea) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut goes_on = false;
    for pair in points.windows(2) {
        let Some(([from, to], ends_inside)) = clipped(pair[0], pair[1], area) else {
            goes_on = false;
            continue;
        };
        match pieces.last_mut().filter(|_| goes_on) {
            Some(piece) => piece.push(to),
            None => pieces.push(vec![from, to]),
        }
        goes_on = ends_inside;
    }
    pieces
}

/// The part of a straight line that is in an area, and whether its end is there (Liang and Barsky 1984).
fn clipped(from: [f64; 2], to: [f64; 2], area: &ChartArea) -> Option<([[f64; 2]; 2], bool)> {
    let (low, high) = ([area.left, area.top], [area.right(), area.bottom()]);
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (start, way) = (from[axis], to[axis] - from[axis]);
        if !(start.is_finite() && way.is_finite()) {
            return None;
        }
        for (distance, speed) in [(start - low[axis], -way), (high[axis] - start, way)] {
            if speed == 0.0 {
                if distance < 0.0 {
                    return None;
                }
            } else if speed < 0.0 {
                enters = enters.max(distance / speed);
            } else {
                leaves = leaves.min(distance / speed);
            }
        }
    }
    let at = |share: f64| std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]));
    (enters <= leaves).then(|| ([at(enters), at(leaves)], leaves >= 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::curve::Dashes;

    #[test]
    fn lines_are_cut_at_the_area() {
        let area = ChartArea { left: 0.0, top: 0.0, width: 10.0, height: 10.0 };
        let up = [[1.0, 5.0], [5.0, -5.0], [9.0, 5.0], [f64::NAN, 5.0], [2.0, 2.0], [3.0, 2.0]];
        let pieces = pieces_within(&up, &area);
        assert_eq!(pieces, [vec![[1.0, 5.0], [3.0, 0.0]], vec![[7.0, 0.0], [9.0, 5.0]], vec![[2.0, 2.0], [3.0, 2.0]]]);
        assert!(pieces_within(&[[-5.0, -1.0], [20.0, -1.0]], &area).is_empty());
    }

    #[test]
    fn tables_have_a_column_for_each_curve() {
        let curve = |name: &str, points: Vec<[f64; 2]>| Curve { name: name.into(), points, colour: 0, dashes: Dashes::Solid };
        let chart = CartesianChart {
            x: ChartAxis::angles("angle", [0.0, 90.0]),
            curves: vec![curve("a", vec![[0.0, 1.0], [10.0, 2.0]]), curve("b", vec![[5.0, 3.0], [10.0, 4.0]])],
            ..CartesianChart::default()
        };
        let table = chart.table();
        assert_eq!(table.columns, ["angle (°)", "a", "b"]);
        assert_eq!(table.csv(), "angle (°),a,b\n0,1,\n5,,3\n10,2,4\n");
    }
}

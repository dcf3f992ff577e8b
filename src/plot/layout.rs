//! What all charts have: a heading, a legend below it, and the area that remains.

use crate::plot::curve::{ChartHeading, Curve, Dashes};
use crate::plot::figure::{Anchor, Figure, FigureMark, Stroke};
use crate::plot::theme::ChartTheme;
use crate::plot::typeface::{shortened, width};

/// The size of labels in a chart of the usual size.
const LABEL_SIZE: f64 = 13.0;
/// The usual size of a chart, for which sizes and widths are given.
const USUAL_SIZE: [f64; 2] = [800.0, 600.0];

/// The least size of a unit: labels stay legible in small charts.
const LEAST_UNIT: f64 = 0.8;

/// A rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChartArea {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl ChartArea {
    /// Its right edge.
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Its lower edge.
    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// The area without margins at the left, top, right and bottom. Something always remains.
    pub(super) fn without(&self, [left, top, right, bottom]: [f64; 4]) -> Self {
        let (width, height) = ((self.width - left - right).max(4.0), (self.height - top - bottom).max(4.0));
        Self { left: self.left + left, top: self.top + top, width, height }
    }
}

/// Whether two rectangles, each with its left, top, right and bottom, have more than an edge in common.
fn overlap(one: &[f64; 4], other: &[f64; 4]) -> bool {
    (0..2).all(|axis| one[axis] < other[axis + 2] - 1.0 && other[axis] < one[axis + 2] - 1.0)
}

/// A figure in work, with the area that is left of it.
pub(super) struct ChartSheet {
    pub(super) figure: Figure,
    pub(super) theme: ChartTheme,
    /// Units of the figure for each unit of a chart of the usual size.
    pub(super) unit: f64,
    pub(super) area: ChartArea,
    /// Labels, of which those are drawn that have room.
    labels: Vec<FigureMark>,
}

impl ChartSheet {
    /// A sheet with its heading.
    pub(super) fn new(size: [u32; 2], theme: ChartTheme, heading: &ChartHeading) -> Self {
        let [width, height] = size.map(f64::from);
        let unit = (width / USUAL_SIZE[0]).min(height / USUAL_SIZE[1]).clamp(LEAST_UNIT, 8.0);
        let title =
            if heading.subtitle.is_empty() { heading.title.clone() } else { format!("{}: {}", heading.title, heading.subtitle) };
        let figure = Figure::new(size, theme.paper(), &title);
        let margin = 18.0 * unit;
        let area = ChartArea { left: 0.0, top: 0.0, width, height }.without([margin, 14.0 * unit, margin, 12.0 * unit]);
        let mut sheet = Self { figure, theme, unit, area, labels: Vec::new() };
        for (text, size, colour) in [(&heading.title, 20.0, theme.text()), (&heading.subtitle, 13.5, theme.muted())] {
            if text.is_empty() {
                continue;
            }
            let size = size * unit;
            let text = shortened(text, size, sheet.area.width);
            sheet.figure.text(text, [sheet.area.left, sheet.area.top + size], Anchor::Start, (size, colour));
            sheet.take_top(1.42 * size);
        }
        sheet.take_top(4.0 * unit);
        sheet
    }

    /// The size of labels.
    pub(super) fn label_size(&self) -> f64 {
        LABEL_SIZE * self.unit
    }

    /// The distance from the middle of a line of labels down to its baseline.
    pub(super) fn to_baseline(&self) -> f64 {
        0.35 * self.label_size()
    }

    /// A label in the muted colour. Its middle is at this height. It is left out where there is no room for it; earlier
    /// ones have it first.
    pub(super) fn label(&mut self, text: impl Into<String>, [x, y]: [f64; 2], anchor: Anchor) {
        let (size, colour, text) = (self.label_size(), self.theme.muted(), text.into());
        let at = [x, y + self.to_baseline()];
        self.labels.push(FigureMark::Text { at, anchor, upwards: false, size, colour, text });
    }

    /// The figure, without texts that would be cut off or overlap others.
    pub(super) fn finish(self) -> Figure {
        let Self { mut figure, labels, .. } = self;
        let [width, height] = figure.size;
        let mut taken: Vec<[f64; 4]> = Vec::new();
        figure.marks.extend(labels);
        figure.marks.retain(|mark| {
            let Some(place) = mark.text_rectangle() else { return true };
            let [left, top, right, bottom] = place;
            let is_whole = left >= 0.0 && top >= 0.0 && right <= width && bottom <= height;
            let has_room = is_whole && !taken.iter().any(|other| overlap(&place, other));
            taken.extend(has_room.then_some(place));
            has_room
        });
        figure
    }

    /// The size of the titles of axes.
    pub(super) fn title_size(&self) -> f64 {
        1.06 * self.label_size()
    }

    /// The title of an axis, on one line about this place. It stays on the sheet, and is shortened where it is too
    /// long.
    pub(super) fn title(&mut self, text: &str, [x, baseline]: [f64; 2]) {
        let style = (self.title_size(), self.theme.text());
        let text = shortened(text, style.0, self.area.width);
        let half = 0.5 * width(&text, style.0).min(self.area.width);
        let x = x.clamp(self.area.left + half, self.area.right() - half);
        self.figure.text(text, [x, baseline], Anchor::Middle, style);
    }

    /// The title of an axis, upwards about this place. It is shortened where it is higher than the area.
    pub(super) fn upright_title(&mut self, text: &str, [x, y]: [f64; 2]) {
        let (size, colour) = (self.title_size(), self.theme.text());
        let text = shortened(text, size, self.area.height);
        let half = 0.5 * width(&text, size).min(self.area.height);
        let at = [x, y.clamp(self.area.top + half, self.area.bottom() - half)];
        self.figure.marks.push(FigureMark::Text { at, anchor: Anchor::Middle, upwards: true, size, colour, text });
    }

    /// Makes the area smaller from the top.
    pub(super) fn take_top(&mut self, height: f64) {
        self.area = self.area.without([0.0, height, 0.0, 0.0]);
    }

    /// The line of a curve.
    pub(super) fn stroke(&self, colour: usize, dashes: Dashes) -> Stroke {
        let width = 2.2 * self.unit;
        Stroke { dashes: dashes.lengths(width), ..Stroke::solid(self.theme.curve(colour), width) }
    }

    /// A legend of curves, in lines below the heading. One curve alone needs none.
    pub(super) fn legend(&mut self, curves: &[Curve]) {
        if curves.len() < 2 {
            return;
        }
        let (size, unit) = (self.label_size(), self.unit);
        let (sample, gap, line) = (24.0 * unit, 7.0 * unit, 1.6 * size);
        let (mut x, mut y) = (self.area.left, self.area.top + 0.5 * line);
        for curve in curves {
            let name = shortened(&curve.name, size, self.area.width - sample - gap);
            let wide = sample + gap + width(&name, size) + 18.0 * unit;
            if x > self.area.left && x + wide - 18.0 * unit > self.area.right() {
                (x, y) = (self.area.left, y + line);
            }
            let stroke = self.stroke(curve.colour, curve.dashes);
            self.figure.line(vec![[x, y], [x + sample, y]], stroke);
            let style = (size, self.theme.text());
            self.figure.text(name, [x + sample + gap, y + self.to_baseline()], Anchor::Start, style);
            x += wide;
        }
        self.take_top(y + 0.5 * line - self.area.top + 4.0 * unit);
    }
}

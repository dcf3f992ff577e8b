//! Charts of curves over an angle, in a half disc: the normal points up.

use crate::plot::axis::{ChartAxis, FittedAxis};
use crate::plot::cartesian::columns_of;
use crate::plot::curve::{ChartHeading, Curve};
use crate::plot::figure::{Anchor, Figure, Ink, Stroke};
use crate::plot::layout::ChartSheet;
use crate::plot::number_table::NumberTable;
use crate::plot::theme::ChartTheme;
use crate::plot::typeface::width;

/// Curves over an angle from −90 to 90 degrees, measured from upwards to the right.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PolarChart {
    /// What stands over it.
    pub heading: ChartHeading,
    /// The angles.
    pub angle: ChartAxis,
    /// The distance from the middle.
    pub radius: ChartAxis,
    /// The curves, as pairs of angle and distance.
    pub curves: Vec<Curve>,
    /// Angles from which an arrow points to the middle, each with the number of its colour.
    pub arrows: Vec<(f64, usize)>,
}

/// The half disc on the sheet.
struct HalfDisc {
    middle: [f64; 2],
    radius: f64,
    axis: FittedAxis,
}

impl HalfDisc {
    /// The place at an angle in degrees and a part of the radius.
    fn at(&self, degrees: f64, share: f64) -> [f64; 2] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        [self.middle[0] + self.radius * share * sine, self.middle[1] - self.radius * share * cosine]
    }

    /// The place of a point of a curve.
    fn point(&self, [angle, distance]: [f64; 2]) -> [f64; 2] {
        let share = self.axis.place(distance);
        // Beyond the rim a curve runs along it.
        self.at(angle, if share.is_nan() { f64::NAN } else { share.clamp(0.0, 1.0) })
    }

    fn arc(&self, share: f64) -> Vec<[f64; 2]> {
        (-90..=90).map(|degrees| self.at(f64::from(degrees), share)).collect()
    }
}

impl PolarChart {
    /// The drawing.
    pub fn figure(&self, size: [u32; 2], theme: ChartTheme) -> Figure {
        let mut sheet = ChartSheet::new(size, theme, &self.heading);
        sheet.legend(&self.curves);
        let label = sheet.label_size();
        let area = sheet.area.without([2.6 * label, 1.8 * label, 2.6 * label, 3.8 * label]);
        let radius = (0.5 * area.width).min(area.height);
        let middle = [area.left + 0.5 * area.width, area.top + 0.5 * (area.height - radius) + radius];
        let distances = self.curves.iter().flat_map(|curve| curve.points.iter().map(|point| point[1]));
        let axis = self.radius.fitted(distances, (radius / (4.5 * label)).clamp(2.0, 6.0));
        let disc = HalfDisc { middle, radius, axis };
        self.draw_grid(&mut sheet, &disc);
        for (angle, colour) in &self.arrows {
            draw_arrow(&mut sheet, &disc, *angle, *colour);
        }
        for curve in &self.curves {
            let stroke = sheet.stroke(curve.colour, curve.dashes);
            for piece in curve.points.split(|point| !point.iter().all(|number| number.is_finite())) {
                if piece.len() > 1 {
                    let points = piece.iter().map(|point| disc.point(*point)).collect();
                    sheet.figure.line(points, stroke.clone());
                }
            }
        }
        sheet.finish()
    }

    fn draw_grid(&self, sheet: &mut ChartSheet, disc: &HalfDisc) {
        let (unit, theme, label) = (sheet.unit, sheet.theme, sheet.label_size());
        for degrees in (-75..=75).step_by(15) {
            let degrees = f64::from(degrees);
            sheet.figure.line(vec![disc.middle, disc.at(degrees, 1.0)], Stroke::solid(theme.grid(), unit));
        }
        for tick in &disc.axis.ticks {
            let share = disc.axis.place(tick.value);
            let colour = if tick.label.is_empty() { theme.faint() } else { theme.grid() };
            if share > 0.01 && share < 0.99 {
                sheet.figure.line(disc.arc(share), Stroke::solid(colour, unit));
            }
        }
        // Values may be negative: then 0 is a circle, and not the middle.
        let zero = disc.axis.place(0.0);
        if !self.radius.is_log && zero > 0.01 && zero < 0.99 {
            sheet.figure.line(disc.arc(zero), Stroke::solid(theme.muted(), 1.6 * unit));
        }
        let mut rim = disc.arc(1.0);
        rim.extend([disc.at(-90.0, 1.0)]);
        sheet.figure.line(rim, Stroke::solid(theme.frame(), unit));
        // The numbers stand along the rim, so they need that much of it.
        let has_room = |step: &usize| disc.radius * (*step as f64).to_radians() > 1.9 * label;
        let step = [15, 30, 45].into_iter().find(has_room).unwrap_or(90);
        for degrees in (-90..=90).step_by(step) {
            let [x, y] = disc.at(f64::from(degrees), 1.0);
            let (sine, cosine) = f64::from(degrees).to_radians().sin_cos();
            let anchor = if degrees == 0 {
                Anchor::Middle
            } else if degrees < 0 {
                Anchor::End
            } else {
                Anchor::Start
            };
            let text = format!("{degrees}°").replace('-', "−");
            sheet.label(text, [x + 0.55 * label * sine, y - 0.85 * label * cosine], anchor);
        }
        self.draw_radii(sheet, disc);
    }

    /// The numbers of the circles, below the half disc, and its titles.
    fn draw_radii(&self, sheet: &mut ChartSheet, disc: &HalfDisc) {
        let label = sheet.label_size();
        for tick in disc.axis.ticks.iter().filter(|tick| !tick.label.is_empty()) {
            let [x, y] = disc.at(90.0, disc.axis.place(tick.value));
            sheet.figure.line(vec![[x, y], [x, y + 0.35 * label]], Stroke::solid(sheet.theme.frame(), sheet.unit));
            sheet.label(tick.label.as_str(), [x, y + 1.1 * label], Anchor::Middle);
        }
        let (title, y) = (self.radius.full_title(), disc.middle[1] + 2.9 * label);
        sheet.title(&title, [disc.middle[0] + 0.5 * disc.radius, y]);
        // The numbers at the rim say that they are angles.
        let both = [title.as_str(), &self.angle.title].map(|text| width(text, sheet.title_size())).iter().sum::<f64>();
        if 0.5 * both + label < disc.radius {
            sheet.title(&self.angle.title, [disc.middle[0] - 0.5 * disc.radius, y]);
        }
    }

    /// The numbers: a column for the angle, and one for each curve.
    pub fn table(&self) -> NumberTable {
        columns_of(&self.angle, &self.curves)
    }
}

/// An arrow to the middle.
fn draw_arrow(sheet: &mut ChartSheet, disc: &HalfDisc, degrees: f64, colour: usize) {
    let colour = sheet.theme.curve(colour);
    let unit = sheet.unit;
    let head = (13.0 * unit / disc.radius).min(0.2);
    let from = disc.at(degrees, 1.0);
    let stroke = Stroke { ink: Ink { colour, opacity: 0.75 }, ..Stroke::solid(colour, 1.3 * unit) };
    sheet.figure.line(vec![from, disc.at(degrees, head)], stroke);
    let [x, y] = disc.at(degrees, head);
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let (wide, points) = (4.2 * unit, disc.middle);
    let corners = vec![points, [x + wide * cosine, y + wide * sine], [x - wide * cosine, y - wide * sine]];
    sheet.figure.polygon(corners, Ink::solid(colour));
}

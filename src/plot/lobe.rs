//! Charts of lobes: how much leaves into each direction, as the distance of a surface from the middle.

use crate::plot::axis::ChartAxis;
use crate::plot::colours::mixed;
use crate::plot::curve::ChartHeading;
use crate::plot::figure::{Anchor, Figure, FigureMark};
use crate::plot::layout::ChartSheet;
use crate::plot::number_table::NumberTable;
use crate::plot::panels::{arranged, caption};
use crate::plot::solid::{SolidCorner, SolidPicture, turned};
use crate::plot::theme::ChartTheme;
use crate::plot::typeface::{plain, shortened, width};
use glam::{DVec2, DVec3};
use std::collections::HashSet;

/// How long the arrow of the light is, where the greatest number is 1 long.
const ARROW: f64 = 0.9;
/// How high the normal is.
const NORMAL: f64 = 0.75;

/// A lobe.
#[derive(Debug, Clone, PartialEq)]
pub struct Lobe {
    /// Its name; empty for none.
    pub name: String,
    /// The number of its colour.
    pub colour: usize,
    /// From where light comes: polar angle and azimuth in degrees.
    pub light: [f64; 2],
    /// Polar angles in degrees, growing.
    pub polar: Vec<f64>,
    /// Azimuths in degrees, growing, all around: the last one is the first one again.
    pub azimuths: Vec<f64>,
    /// The numbers, azimuth by azimuth for each polar angle.
    pub values: Vec<f64>,
}

/// Lobes side by side, in one scale.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LobeChart {
    /// What stands over it.
    pub heading: ChartHeading,
    /// The distance from the middle.
    pub radius: ChartAxis,
    /// From where they are seen: azimuth and elevation in degrees.
    pub seen_from: [f64; 2],
    /// Whether it is drawn quickly, without smooth edges.
    pub is_draft: bool,
    /// The lobes.
    pub lobes: Vec<Lobe>,
}

fn direction(polar: f64, azimuth: f64) -> DVec3 {
    let (polar, azimuth) = (polar.to_radians(), azimuth.to_radians());
    DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
}

impl Lobe {
    /// The corners of its surface, with distances by `place`.
    fn corners(&self, place: &dyn Fn(f64) -> f64) -> Vec<DVec3> {
        let mut corners = Vec::with_capacity(self.values.len());
        for (row, polar) in self.polar.iter().enumerate() {
            for (column, azimuth) in self.azimuths.iter().enumerate() {
                let value = self.values.get(row * self.azimuths.len() + column).copied().unwrap_or(0.0);
                let distance = place(value);
                corners.push(direction(*polar, *azimuth) * if distance.is_finite() { distance.clamp(0.0, 1.0) } else { 0.0 });
            }
        }
        corners
    }

    /// Draws the surface with these corners.
    fn draw(&self, picture: &mut SolidPicture, corners: &[DVec3], colour: [u8; 3]) {
        let columns = self.azimuths.len();
        if columns < 2 || self.polar.len() < 2 {
            return;
        }
        let at = |row: usize, column: usize| corners[row * columns + column];
        let last = columns - 1;
        let normal = |row: usize, column: usize| {
            // The first azimuth is also the last one.
            let (before, after) = (if column == 0 { last - 1 } else { column - 1 }, if column == last { 1 } else { column + 1 });
            let (above, below) = (row.saturating_sub(1), (row + 1).min(self.polar.len() - 1));
            let cross = (at(below, column) - at(above, column)).cross(at(row, after) - at(row, before));
            cross.try_normalize().unwrap_or_else(|| direction(self.polar[row], self.azimuths[column]))
        };
        let corner = |row: usize, column: usize| SolidCorner {
            at: at(row, column),
            normal: normal(row, column),
            ruling: DVec2::new(self.polar[row] / 15.0, self.azimuths[column] / 15.0),
        };
        let grid: Vec<SolidCorner> = (0..self.polar.len())
            .flat_map(|row| (0..columns).map(move |column| (row, column)))
            .map(|(row, column)| corner(row, column))
            .collect();
        let corner = |row: usize, column: usize| grid[row * columns + column];
        for row in 0..self.polar.len() - 1 {
            for column in 0..last {
                let [a, b] = [corner(row, column), corner(row, column + 1)];
                let [c, d] = [corner(row + 1, column), corner(row + 1, column + 1)];
                picture.triangle([a, c, d], colour);
                picture.triangle([a, d, b], colour);
            }
        }
    }
}

impl LobeChart {
    /// The drawing.
    pub fn figure(&self, size: [u32; 2], theme: ChartTheme) -> Figure {
        let mut sheet = ChartSheet::new(size, theme, &self.heading);
        let label = sheet.label_size();
        let numbers = self.lobes.iter().flat_map(|lobe| lobe.values.iter().copied());
        let greatest = numbers.clone().filter(|number| number.is_finite()).fold(0.0, f64::max);
        let fitted = self.radius.fitted(numbers, 4.0);
        // The longest direction is 1 long.
        let high = if greatest > fitted.range[0] { greatest } else { fitted.range[1] };
        let axis = ChartAxis { range: Some([fitted.range[0], high]), ..self.radius.clone() }.fitted(std::iter::empty(), 4.0);
        let place = |number: f64| axis.place(number);
        let has_names = self.lobes.iter().any(|lobe| !lobe.name.is_empty());
        let margins = [0.5 * label, if has_names { 2.0 * label } else { 0.0 }, 0.5 * label, 1.6 * label];
        let turn = turned(self.seen_from[0], self.seen_from[1]);
        let surfaces: Vec<Vec<DVec3>> = self.lobes.iter().map(|lobe| lobe.corners(&place)).collect();
        let widest = surfaces.iter().flatten().map(|at| at.truncate().length()).fold(0.0, f64::max);
        let rim = (1.15 * widest).clamp(0.5, 1.12);
        let all_around = (0..72).map(|step| direction(90.0, 5.0 * f64::from(step)) * (rim + 0.1));
        let arrows = self.lobes.iter().map(|lobe| direction(lobe.light[0], lobe.light[1]) * (ARROW + 0.02));
        let points: Vec<DVec3> =
            surfaces.iter().flatten().copied().chain(all_around).chain(arrows).chain([DVec3::Z * NORMAL]).collect();
        let places = arranged(&sheet.area, self.lobes.len(), 1.3, margins);
        for ((lobe, corners), area) in self.lobes.iter().zip(&surfaces).zip(places.areas) {
            let pixels = [area.width, area.height].map(|side| side.ceil().max(1.0) as u32);
            let mut picture = SolidPicture::new((pixels, self.is_draft), turn, &points, theme.paper());
            let rings: Vec<f64> = axis.ticks.iter().filter(|tick| !tick.label.is_empty()).map(|tick| place(tick.value)).collect();
            lobe.draw(&mut picture, corners, theme.curve(lobe.colour));
            draw_light(&mut picture, lobe, corners, theme);
            // Behind the rest, so the most of it is hidden and need not be drawn.
            picture.plane(rim, |at, pixel| plane_colour([at.x, at.y], [pixel, rim], &rings, theme));
            let (at, size) = ([area.left, area.top], [area.width, area.height]);
            sheet.figure.marks.push(FigureMark::Image { at, size, bitmap: picture.bitmap(), smooth: true });
            let on_sheet = |at: DVec3| {
                let [x, y] = picture.share(at);
                [area.left + x * area.width, area.top + y * area.height]
            };
            for (azimuth, name) in [(0.0, "T"), (90.0, "B")] {
                let [x, y] = on_sheet(direction(90.0, azimuth) * (rim + 0.07));
                sheet.figure.text(name, [x, y + sheet.to_baseline()], Anchor::Middle, (label, sheet.theme.text()));
            }
            // The outermost number comes first: it says the most if not all have room.
            for tick in axis.ticks.iter().rev().filter(|tick| !tick.label.is_empty()) {
                let radius = place(tick.value);
                let [x, y] = on_sheet(direction(90.0, self.seen_from[0] - 20.0) * radius);
                if radius > 0.12 && radius < rim {
                    sheet.label(tick.label.as_str(), [x, y + 0.6 * label], Anchor::Middle);
                }
            }
            caption(&mut sheet, &area, places.cell_width, &lobe.name);
        }
        let at = [sheet.area.left + 0.5 * sheet.area.width, sheet.area.bottom() - 0.6 * label];
        let text = self.legend(label, sheet.area.width);
        sheet.label(text, at, Anchor::Middle);
        sheet.finish()
    }

    /// What the signs in the drawing are, as much as a line of this width can say.
    fn legend(&self, size: f64, widest: f64) -> String {
        let rings = format!("rings: {}", self.radius.full_title());
        let whole = format!("{rings}; the arrow is the light; T and B: tangent and bitangent");
        let shorter = format!("{rings}; arrow: light");
        let texts = [whole, shorter];
        texts.into_iter().find(|text| width(text, size) <= widest).unwrap_or_else(|| shortened(&rings, size, widest))
    }

    /// The numbers: a row for each direction, with its angles and its numbers. The lobes have the same directions, or
    /// each has a table of its own below the others.
    pub fn table(&self) -> NumberTable {
        let named = self.lobes.iter().zip(1..).filter(|(lobe, _)| !lobe.name.is_empty());
        let names: Vec<String> = named.map(|(lobe, number)| format!("{number}: {}", plain(&lobe.name))).collect();
        let lobe = if names.is_empty() { "lobe".to_owned() } else { format!("lobe ({})", names.join("; ")) };
        let angles = ["incoming angle (°)", "outgoing angle (°)", "outgoing azimuth (°)"].map(str::to_owned);
        let columns = std::iter::once(lobe).chain(angles);
        let columns = columns.chain([self.radius.full_title()]).collect();
        let mut rows = Vec::new();
        for (number, lobe) in self.lobes.iter().enumerate() {
            for (row, polar) in lobe.polar.iter().enumerate() {
                for (column, azimuth) in lobe.azimuths.iter().enumerate() {
                    let value = lobe.values.get(row * lobe.azimuths.len() + column).copied().unwrap_or(f64::NAN);
                    rows.push(vec![number as f64 + 1.0, lobe.light[0], *polar, *azimuth, value]);
                }
            }
        }
        NumberTable { columns, rows, empty: HashSet::new() }
    }
}

/// The colour of a place of the plane: circles at round numbers, lines at azimuths, and a rim.
fn plane_colour([x, y]: [f64; 2], [pixel, rim]: [f64; 2], rings: &[f64], theme: ChartTheme) -> [u8; 3] {
    let radius = x.hypot(y);
    let on = |distance: f64| distance < 2.0 * pixel;
    const HALF: f64 = 0.866_025_403_784_438_6;
    // The directions at 0, 30 and so on up to 150 degrees.
    let rays = [[1.0, 0.0], [HALF, 0.5], [0.5, HALF], [0.0, 1.0], [-0.5, HALF], [-HALF, 0.5]];
    let from_ray = rays.iter().map(|[along, up]| (x * up - y * along).abs()).fold(f64::INFINITY, f64::min);
    if on(rim - radius) {
        theme.frame()
    } else if rings.iter().any(|ring| on((radius - ring).abs())) {
        mixed(theme.grid(), theme.frame(), 0.5)
    } else if on(from_ray) && radius > 0.02 {
        theme.grid()
    } else {
        mixed(theme.faint(), theme.paper(), 0.25)
    }
}

/// The arrow along which the light comes, down to the surface of the lobe, and the normal.
fn draw_light(picture: &mut SolidPicture, lobe: &Lobe, corners: &[DVec3], theme: ChartTheme) {
    let light = direction(lobe.light[0], lobe.light[1]);
    let near = corners.iter().filter(|at| at.normalize_or_zero().dot(light) > 0.995).map(|at| at.length());
    let tip = near.fold(0.0, f64::max).min(ARROW - 0.2) + 0.015;
    let colour = [235, 160, 20];
    picture.rod([light * ARROW, light * (tip + 0.1)], [0.01, 0.01], colour);
    picture.rod([light * (tip + 0.1), light * tip], [0.03, 0.0], colour);
    picture.rod([DVec3::ZERO, DVec3::Z * NORMAL], [0.004, 0.004], theme.muted());
}

//! Charts of numbers or colours over two axes: pictures.

use crate::picture::{Bitmap, Transfer, quantise};
use crate::plot::axis::{ChartAxis, FittedAxis};
use crate::plot::colours::false_colour;
use crate::plot::curve::ChartHeading;
use crate::plot::figure::{Anchor, Figure, FigureMark, Stroke};
use crate::plot::layout::{ChartArea, ChartSheet};
use crate::plot::number_table::NumberTable;
use crate::plot::panels::{PanelPlaces, arranged, caption};
use crate::plot::theme::ChartTheme;
use crate::plot::typeface::width;
use std::collections::HashSet;

/// What is shown at each place, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub enum MapValues {
    /// Numbers, in false colours.
    Numbers(Vec<f64>),
    /// Linear colours, red, green, blue, which are shown as they are: 1 is the brightest. NaN is magenta.
    Colours(Vec<[f32; 3]>),
}

/// One picture.
#[derive(Debug, Clone, PartialEq)]
pub struct MapPanel {
    /// Its name; empty for none.
    pub name: String,
    /// Its width and height in pixels.
    pub size: [u32; 2],
    /// Its pixels, width × height of them.
    pub values: MapValues,
}

/// Pictures over two axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MapChart {
    /// What stands over it.
    pub heading: ChartHeading,
    /// The axes, to the right and upwards. None for a picture of a thing.
    pub axes: Option<[ChartAxis; 2]>,
    /// What the numbers are. Colours have no bar, but the title is part of the names of their columns.
    pub bar: ChartAxis,
    /// The pictures.
    pub panels: Vec<MapPanel>,
}

/// One pixel of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MapPixel {
    /// A number.
    Number(f64),
    /// A linear colour.
    Colour([f32; 3]),
}

/// What a drawing shows at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapReading {
    /// The index of the picture.
    pub panel: usize,
    /// The numbers of both axes at the middle of the pixel.
    pub place: [f64; 2],
    /// The pixel.
    pub pixel: MapPixel,
}

/// Where everything is on a sheet.
struct MapArrangement {
    /// Where the pictures are.
    places: PanelPlaces,
    /// The bar, if there are numbers.
    bar: Option<FittedAxis>,
    /// The width of the widest label of the bar.
    widest: f64,
    /// The right edge of what pictures and bar may take.
    right: f64,
}

impl MapPanel {
    /// The places of the pixels along an axis: the middles of the pixels, in the order of the rows or columns.
    fn place(index: u32, side: u32, [low, high]: [f64; 2]) -> f64 {
        low + (f64::from(index) + 0.5) / f64::from(side.max(1)) * (high - low)
    }

    fn bitmap(&self, bar: Option<&FittedAxis>) -> Bitmap {
        let place = |number: f64| bar.map_or(number, |bar| bar.place(number));
        let bytes = match &self.values {
            MapValues::Colours(colours) => {
                let mut bytes = quantise(colours, Transfer::Srgb);
                let (pixels, _) = bytes.as_chunks_mut::<3>();
                let odd = pixels.iter_mut().zip(colours).filter(|(_, colour)| colour.iter().any(|number| number.is_nan()));
                odd.for_each(|(pixel, _)| *pixel = false_colour(f64::NAN));
                bytes
            }
            MapValues::Numbers(numbers) => numbers.iter().flat_map(|number| false_colour(place(*number))).collect(),
        };
        Bitmap::of_bytes(self.size, bytes)
    }
}

impl MapChart {
    /// The drawing.
    pub fn figure(&self, size: [u32; 2], theme: ChartTheme) -> Figure {
        let mut sheet = ChartSheet::new(size, theme, &self.heading);
        let label = sheet.label_size();
        let MapArrangement { places, bar, widest, right: most } = self.arranged(&sheet);
        for (panel, place) in self.panels.iter().zip(&places.areas) {
            let bitmap = panel.bitmap(bar.as_ref());
            // Few pixels stay squares; many blend.
            let smooth = place.width < 3.0 * f64::from(panel.size[0]);
            let (at, size) = ([place.left, place.top], [place.width, place.height]);
            sheet.figure.marks.push(FigureMark::Image { at, size, bitmap, smooth });
            if let Some([x, y]) = &self.axes {
                draw_axes(&mut sheet, place, x, y);
            }
            caption(&mut sheet, place, places.cell_width, &panel.name);
        }
        if let Some(bar) = bar {
            let (top, bottom) = places
                .areas
                .iter()
                .fold((f64::INFINITY, 0.0_f64), |(top, bottom), place| (top.min(place.top), bottom.max(place.bottom())));
            let right = places.areas.iter().map(ChartArea::right).fold(0.0, f64::max);
            let left = (right + 1.6 * label).min(most);
            let place = ChartArea { left, top, width: 1.2 * label, height: bottom - top };
            self.draw_bar(&mut sheet, &place, &bar, widest);
        }
        sheet.finish()
    }

    /// What the drawing of this size shows at a point; none beside the pictures.
    pub fn reading(&self, size: [u32; 2], [x, y]: [f64; 2]) -> Option<MapReading> {
        // Places do not depend on colours.
        let places = self.arranged(&ChartSheet::new(size, ChartTheme::Light, &self.heading)).places.areas;
        let is_within = |place: &ChartArea| (place.left..place.right()).contains(&x) && (place.top..place.bottom()).contains(&y);
        let panel = places.iter().position(is_within)?;
        let (area, shown) = (places[panel], self.panels.get(panel)?);
        let [columns, rows] = shown.size;
        let index = |share: f64, side: u32| ((share * f64::from(side)) as u32).min(side.saturating_sub(1));
        let (column, row) = (index((x - area.left) / area.width, columns), index((y - area.top) / area.height, rows));
        let range = |axis: usize| self.axes.as_ref().and_then(|axes| axes[axis].range).unwrap_or([-1.0, 1.0]);
        let place = [MapPanel::place(column, columns, range(0)), MapPanel::place(rows.saturating_sub(1) - row, rows, range(1))];
        let at = row as usize * columns as usize + column as usize;
        let pixel = match &shown.values {
            MapValues::Numbers(numbers) => MapPixel::Number(*numbers.get(at)?),
            MapValues::Colours(colours) => MapPixel::Colour(*colours.get(at)?),
        };
        Some(MapReading { panel, place, pixel })
    }

    /// Where pictures and bar are.
    fn arranged(&self, sheet: &ChartSheet) -> MapArrangement {
        let label = sheet.label_size();
        let numbers = self.panels.iter().flat_map(|panel| match &panel.values {
            MapValues::Numbers(numbers) => numbers.as_slice(),
            MapValues::Colours(_) => &[],
        });
        let numbers = numbers.copied();
        let has_bar = numbers.clone().next().is_some();
        let bar = self.bar.fitted(numbers, (sheet.area.height / (4.5 * label)).clamp(2.0, 8.0));
        let widest = bar.ticks.iter().map(|tick| width(&tick.label, label)).fold(0.0, f64::max);
        let bar_width = if has_bar { widest + 6.0 * label } else { 0.0 };
        let [left, bottom] = if self.axes.is_some() { [4.9 * label, 3.6 * label] } else { [0.3 * label; 2] };
        let has_names = self.panels.iter().any(|panel| !panel.name.is_empty());
        let top = if has_names { 2.0 * label } else { 0.5 * label };
        let area = sheet.area.without([0.0, 0.0, bar_width, 0.0]);
        let aspect = self.panels.first().map_or(1.0, |panel| f64::from(panel.size[0]) / f64::from(panel.size[1].max(1)));
        let places = arranged(&area, self.panels.len(), aspect, [left, top, 1.1 * label, bottom]);
        MapArrangement { places, bar: has_bar.then_some(bar), widest, right: area.right() }
    }

    /// The bar that says which colour is which number.
    fn draw_bar(&self, sheet: &mut ChartSheet, place: &ChartArea, bar: &FittedAxis, widest: f64) {
        const STEPS: u32 = 256;
        let bytes = (0..STEPS).rev().flat_map(|step| false_colour(f64::from(step) / f64::from(STEPS - 1))).collect();
        let bitmap = Bitmap::of_bytes([1, STEPS], bytes);
        let (at, size) = ([place.left, place.top], [place.width, place.height]);
        sheet.figure.marks.push(FigureMark::Image { at, size, bitmap, smooth: false });
        let (label, unit, frame) = (sheet.label_size(), sheet.unit, sheet.theme.frame());
        sheet.figure.frame(at, size, Stroke::solid(frame, unit));
        for tick in bar.ticks.iter().filter(|tick| !tick.label.is_empty()) {
            let y = place.bottom() - bar.place(tick.value) * place.height;
            sheet.figure.line(vec![[place.right(), y], [place.right() + 0.35 * label, y]], Stroke::solid(frame, unit));
            sheet.label(tick.label.as_str(), [place.right() + 0.6 * label, y], Anchor::Start);
        }
        let (size, colour) = (1.06 * label, sheet.theme.text());
        let at = [place.right() + widest + 2.1 * label, place.top + 0.5 * place.height];
        let text = self.bar.full_title();
        sheet.figure.marks.push(FigureMark::Text { at, anchor: Anchor::Middle, upwards: true, size, colour, text });
    }

    /// The numbers: a row for each pixel, with its place and its number or colour.
    pub fn table(&self) -> NumberTable {
        let [x, y] = self.axes.clone().unwrap_or_else(|| {
            ["x", "y"].map(|title| ChartAxis { range: Some([-1.0, 1.0]), ..ChartAxis::numbers(title, "", false) })
        });
        let mut columns = vec![x.column(), y.column()];
        for panel in &self.panels {
            let name = |what: &str| if panel.name.is_empty() { what.to_owned() } else { format!("{} {what}", panel.name) };
            match panel.values {
                MapValues::Numbers(_) => columns.push(name(&self.bar.full_title())),
                MapValues::Colours(_) if self.bar.title.is_empty() => columns.extend(["red", "green", "blue"].map(name)),
                MapValues::Colours(_) => {
                    let of_bar = |component: &str| name(&format!("{component}, {}", self.bar.full_title()));
                    columns.extend(["red", "green", "blue"].map(of_bar));
                }
            }
        }
        let [columns_of_pixels, rows_of_pixels] = self.panels.first().map_or([0; 2], |panel| panel.size);
        let mut rows = Vec::new();
        for row in 0..rows_of_pixels {
            for column in 0..columns_of_pixels {
                let range = |axis: &ChartAxis| axis.range.unwrap_or([0.0, 1.0]);
                let upwards = rows_of_pixels - 1 - row;
                let mut numbers = vec![
                    MapPanel::place(column, columns_of_pixels, range(&x)),
                    MapPanel::place(upwards, rows_of_pixels, range(&y)),
                ];
                let index = row as usize * columns_of_pixels as usize + column as usize;
                for panel in &self.panels {
                    match &panel.values {
                        MapValues::Numbers(values) => numbers.push(values.get(index).copied().unwrap_or(f64::NAN)),
                        MapValues::Colours(values) => {
                            let colour = values.get(index).copied().unwrap_or([f32::NAN; 3]);
                            numbers.extend(colour.map(f64::from));
                        }
                    }
                }
                rows.push(numbers);
            }
        }
        NumberTable { columns, rows, empty: HashSet::new() }
    }
}

/// The axes around a picture.
fn draw_axes(sheet: &mut ChartSheet, place: &ChartArea, x: &ChartAxis, y: &ChartAxis) {
    let (label, unit, frame) = (sheet.label_size(), sheet.unit, sheet.theme.frame());
    sheet.figure.frame([place.left, place.top], [place.width, place.height], Stroke::solid(frame, unit));
    let most = |side: f64| (side / (4.2 * label)).clamp(2.0, 9.0);
    let across = x.fitted(std::iter::empty(), most(place.width));
    for tick in &across.ticks {
        let at = place.left + across.place(tick.value) * place.width;
        sheet.figure.line(vec![[at, place.bottom()], [at, place.bottom() + 0.35 * label]], Stroke::solid(frame, unit));
        sheet.label(tick.label.as_str(), [at, place.bottom() + 1.1 * label], Anchor::Middle);
    }
    let upwards = y.fitted(std::iter::empty(), most(place.height));
    for tick in &upwards.ticks {
        let at = place.bottom() - upwards.place(tick.value) * place.height;
        sheet.figure.line(vec![[place.left - 0.35 * label, at], [place.left, at]], Stroke::solid(frame, unit));
        sheet.label(tick.label.as_str(), [place.left - 0.6 * label, at], Anchor::End);
    }
    sheet.title(&x.full_title(), [place.left + 0.5 * place.width, place.bottom() + 2.9 * label]);
    sheet.upright_title(&y.full_title(), [place.left - 3.6 * label, place.top + 0.5 * place.height]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_of_the_drawing_has_the_number_of_its_pixel() {
        // Two pictures of 2 × 2 pixels, row by row from the top.
        let panel =
            |numbers: [f64; 4]| MapPanel { name: "one".to_owned(), size: [2, 2], values: MapValues::Numbers(numbers.to_vec()) };
        let chart = MapChart {
            axes: Some([ChartAxis::angles("x", [0.0, 90.0]), ChartAxis::angles("y", [0.0, 90.0])]),
            bar: ChartAxis::numbers("f", "", false),
            panels: vec![panel([1.0, 2.0, 3.0, 4.0]), panel([5.0, 6.0, 7.0, 8.0])],
            ..MapChart::default()
        };
        let size = [800, 400];
        // The drawing itself says where its pictures are.
        let figure = chart.figure(size, ChartTheme::Light);
        let images = figure.marks.iter().filter_map(|mark| {
            let FigureMark::Image { at, size, bitmap, .. } = mark else { return None };
            (bitmap.size() == [2, 2]).then_some((*at, *size))
        });
        let images: Vec<_> = images.collect();
        assert_eq!(images.len(), 2);
        for (panel, (at, side)) in images.into_iter().enumerate() {
            let reading = |across: f64, down: f64| chart.reading(size, [at[0] + across * side[0], at[1] + down * side[1]]);
            let first = 4.0 * panel as f64;
            let found = |place, number| Some(MapReading { panel, place, pixel: MapPixel::Number(first + number) });
            assert_eq!(reading(0.25, 0.25), found([22.5, 67.5], 1.0));
            assert_eq!(reading(0.9, 0.1), found([67.5, 67.5], 2.0));
            assert_eq!(reading(0.1, 0.9), found([22.5, 22.5], 3.0));
            assert_eq!(reading(0.99, 0.99), found([67.5, 22.5], 4.0));
            assert_eq!(reading(-0.01, 0.5), None);
        }
    }
}

//! Curves in the window: over two axes, and over an angle in a half disc. They can be zoomed, and tell their numbers
//! under the pointer. The colours are those of saved charts.

use crate::plot::{CartesianChart, ChartAxis, ChartTheme, Curve, Dashes, PolarChart, plain};
use egui::{Align2, Color32, Rangef, RichText, Ui};
use egui_plot::{AxisHints, GridMark, HLine, HoverPosition, Line, LineStyle, Plot, PlotPoint, PlotPoints, PlotUi, Text, VLine};

/// How many decades a logarithmic axis shows below the greatest number.
const MOST_DECADES: f64 = 6.0;
/// The width of a curve, in points.
const WIDTH: f32 = 2.0;

/// How numbers of an axis become coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PlotScale {
    /// The power of ten that stands at 0, if equal distances are equal ratios.
    lowest: Option<f64>,
}

impl PlotScale {
    fn new(axis: &ChartAxis, curves: &[Curve]) -> Self {
        let numbers = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point[1]));
        let positive = numbers.filter(|number| number.is_finite() && *number > 0.0);
        let greatest = positive.clone().fold(f64::NEG_INFINITY, f64::max);
        let least = positive.fold(f64::INFINITY, f64::min);
        let lowest = if greatest.is_finite() {
            let high = greatest.log10().ceil();
            least.log10().floor().clamp(high - MOST_DECADES, high - 1.0)
        } else {
            -1.0
        };
        Self { lowest: axis.is_log.then_some(lowest) }
    }

    /// The coordinate of a number. What a logarithmic axis has no place for is at its beginning.
    fn place(self, number: f64) -> f64 {
        match self.lowest {
            None => number,
            Some(lowest) if number > 0.0 => (number.log10() - lowest).max(0.0),
            Some(_) if number.is_nan() => number,
            Some(_) => 0.0,
        }
    }

    /// The number at a coordinate.
    fn number(self, place: f64) -> f64 {
        self.lowest.map_or(place, |lowest| 10_f64.powf(place + lowest))
    }
}

/// A number for people: four digits, with a power of ten if it is very small or large.
pub(super) fn number_text(number: f64) -> String {
    let size = number.abs();
    if number == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&size) {
        let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{number:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{number:.2e}")
    }
}

/// A colour as one number if red, green and blue are the same, as far as it is written; otherwise as three.
pub(super) fn colour_text(colour: [f64; 3]) -> String {
    let [red, green, blue] = colour.map(number_text);
    if red == green && green == blue { red } else { format!("({red}, {green}, {blue})") }
}

pub(super) fn colour_of([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

fn style_of(dashes: Dashes) -> LineStyle {
    match dashes {
        Dashes::Solid => LineStyle::Solid,
        Dashes::Dashed => LineStyle::Dashed { length: 9.0 },
        Dashes::Dotted => LineStyle::Dotted { spacing: 5.0 },
        Dashes::DashDotted => LineStyle::Dashed { length: 4.0 },
    }
}

/// Adds curves whose points are put in their places. A point that is not finite is a gap.
fn add_curves(plot: &mut PlotUi<'_>, curves: &[Curve], theme: ChartTheme, place: impl Fn([f64; 2]) -> [f64; 2]) {
    for curve in curves {
        for piece in curve.points.split(|point| !point.iter().all(|number| number.is_finite())) {
            if piece.len() > 1 {
                let points: Vec<[f64; 2]> = piece.iter().map(|point| place(*point)).collect();
                let line = Line::new(plain(&curve.name), PlotPoints::from(points)).width(WIDTH);
                plot.line(line.color(colour_of(theme.curve(curve.colour))).style(style_of(curve.dashes)));
            }
        }
    }
}

fn plot<'p>(name: &str) -> Plot<'p> {
    Plot::new(name).allow_scroll(false).set_margin_fraction(egui::vec2(0.045, 0.04))
}

/// The most curves whose numbers are told under the pointer.
const MOST_TOLD: usize = 8;

/// The numbers of curves over a point of the axis to the right, a line each. `axis` is the name of the other axis.
fn numbers_at(curves: &[Curve], x: f64, axis: &str) -> String {
    let line = |curve: &Curve| {
        let name = if curves.len() == 1 { axis.to_owned() } else { plain(&curve.name) };
        number_at(&curve.points, x).map(|number| format!("{name} {}", number_text(number)))
    };
    curves.iter().filter_map(line).take(MOST_TOLD).collect::<Vec<_>>().join("\n")
}

/// The number of a curve between two of its points; none beside it and at gaps.
fn number_at(points: &[[f64; 2]], x: f64) -> Option<f64> {
    let after = points.partition_point(|point| point[0] < x);
    let [high, low] = [points.get(after)?, points.get(after.saturating_sub(1))?];
    let share = if high[0] > low[0] { (x - low[0]) / (high[0] - low[0]) } else { 1.0 };
    let number = low[1] + share * (high[1] - low[1]);
    (x >= low[0] && number.is_finite()).then_some(number)
}

/// Draws curves over two axes. `marks` are numbers of the axis to the right that are marked, each with a name.
pub(super) fn cartesian_ui(ui: &mut Ui, chart: &CartesianChart, theme: ChartTheme, mark: Option<(f64, &str)>) {
    let scale = PlotScale::new(&chart.y, &chart.curves);
    let (x_name, y_name) = (plain(&chart.x.title), plain(&chart.y.title));
    let small = |text: String| RichText::new(text).small();
    let x_axis = AxisHints::new_x()
        .label(small(plain(&chart.x.full_title())))
        .formatter(|mark: GridMark, _| format!("{}°", (10.0 * mark.value).round() / 10.0).replace('-', "−"))
        .label_spacing(Rangef::new(26.0, 34.0));
    let y_axis = AxisHints::new_y().label(small(plain(&chart.y.full_title()))).label_spacing(Rangef::new(18.0, 26.0)).formatter(
        move |mark: GridMark, _| {
            let is_whole = scale.lowest.is_none() || (mark.value - mark.value.round()).abs() < 1e-6;
            if is_whole { number_text(scale.number(mark.value)).replace('-', "−") } else { String::new() }
        },
    );
    let curves = &chart.curves;
    let mut plot = plot("cartesian")
        .custom_x_axes(vec![x_axis])
        .custom_y_axes(vec![y_axis])
        .grid_color(colour_of(theme.grid()))
        .label_formatter(move |at: &HoverPosition<'_>| {
            let position = match at {
                HoverPosition::NearDataPoint { position, .. } | HoverPosition::Elsewhere { position } => position,
            };
            Some(format!("{x_name} {:.1}°\n{}", position.x, numbers_at(curves, position.x, &y_name)))
        });
    if chart.x.is_angle {
        let range = chart.x.range;
        plot = plot.x_grid_spacer(move |input| angle_marks(input.bounds, input.base_step_size, range));
    }
    if let Some([low, high]) = chart.x.range {
        plot = plot.include_x(low).include_x(high);
    }
    if scale.lowest.is_some() {
        plot = plot.y_grid_spacer(|input| decade_marks(input.bounds));
    }
    plot = plot.include_y(0.0);
    if let Some(highest) = chart.lines.iter().map(|line| line.value).reduce(f64::max) {
        // Room for what is written at the line.
        plot = plot.include_y(scale.place(1.12 * highest));
    }
    plot.show(ui, |plot| {
        for line in &chart.lines {
            let colour = colour_of(theme.warning());
            let style = LineStyle::Dashed { length: 7.0 };
            let height = scale.place(line.value);
            plot.hline(HLine::new("", height).color(colour).width(1.4).style(style));
            let label = RichText::new(format!("{} ", line.label)).small();
            let at = PlotPoint::new(chart.x.range.map_or(0.0, |[_, high]| high), height);
            plot.text(Text::new("", at, label).color(colour).anchor(Align2::RIGHT_BOTTOM).allow_hover(false));
        }
        if let Some((angle, name)) = mark {
            plot.vline(
                VLine::new(name, angle).color(colour_of(theme.muted())).width(1.2).style(LineStyle::Dashed { length: 4.0 }),
            );
        }
        // What is beyond the range runs along its end.
        let highest = chart.y.range.map_or(f64::INFINITY, |[_, high]| high);
        add_curves(plot, &chart.curves, theme, |[x, y]| [x, scale.place(y.min(highest))]);
    });
}

/// Marks of an axis of angles: each 15 degrees, or finer if it is zoomed. `step` is the least distance that is legible.
/// Beyond the range of the axis there are none.
fn angle_marks((low, high): (f64, f64), step: f64, range: Option<[f64; 2]>) -> Vec<GridMark> {
    const STEPS: [f64; 8] = [0.1, 0.5, 1.0, 5.0, 15.0, 30.0, 90.0, 180.0];
    let size = STEPS.into_iter().find(|size| *size >= 3.5 * step).unwrap_or(360.0);
    let (first, last) = ((low / size).floor() as i64, (high / size).ceil() as i64);
    let count = (last - first).clamp(0, 2000);
    let is_within = |value: &f64| range.is_none_or(|[least, most]| (least - 1e-9..=most + 1e-9).contains(value));
    let values = (first..=first + count).map(|index| size * index as f64).filter(is_within);
    values.map(|value| GridMark { value, step_size: size }).collect()
}

/// Marks of a logarithmic axis: each decade that is in view.
fn decade_marks((low, high): (f64, f64)) -> Vec<GridMark> {
    let (first, last) = (low.ceil().clamp(-400.0, 400.0) as i32, high.floor().clamp(-400.0, 400.0) as i32);
    (first..=last).map(|decade| GridMark { value: f64::from(decade), step_size: 1.0 }).collect()
}

/// Where a point at an angle from upwards, in degrees, and a distance is.
fn polar_place(angle: f64, distance: f64) -> [f64; 2] {
    let (sine, cosine) = angle.to_radians().sin_cos();
    [distance * sine, distance * cosine]
}

/// Distances at which rings stand: round numbers up to the greatest distance, or decades.
fn rings(scale: PlotScale, greatest: f64) -> Vec<f64> {
    let step = if scale.lowest.is_some() {
        1.0
    } else {
        let rough = greatest / 4.0;
        let power = 10_f64.powf(rough.log10().floor());
        let steps = [1.0, 2.0, 2.5, 5.0, 10.0];
        steps.into_iter().map(|step| step * power).find(|step| *step >= rough).unwrap_or(rough)
    };
    let count = (greatest / step - 1e-9).ceil().clamp(1.0, 12.0) as u32;
    (1..=count).map(|index| step * f64::from(index)).collect()
}

/// Draws curves over an angle. `mark` is an angle that is marked, with a name.
pub(super) fn polar_ui(ui: &mut Ui, chart: &PolarChart, theme: ChartTheme, mark: Option<(f64, &str)>) {
    let scale = PlotScale::new(&chart.radius, &chart.curves);
    let (angle_name, radius_name) = (plain(&chart.angle.title), plain(&chart.radius.title));
    let places = chart.curves.iter().flat_map(|curve| curve.points.iter().map(|point| scale.place(point[1])));
    let greatest = places.filter(|place| place.is_finite()).fold(0.0, f64::max);
    let rings = rings(scale, if greatest > 0.0 { greatest } else { 1.0 });
    let rim = rings.last().copied().unwrap_or(1.0);
    let plot = plot("polar")
        .data_aspect(1.0)
        .show_axes(false)
        .show_grid(false)
        .include_x(-1.2 * rim)
        .include_x(1.2 * rim)
        .include_y(-0.1 * rim)
        .include_y(1.1 * rim)
        .label_formatter(move |at: &HoverPosition<'_>| {
            let (name, PlotPoint { x, y }) = match at {
                HoverPosition::NearDataPoint { plot_name, position, .. } => (format!("{plot_name}\n"), *position),
                HoverPosition::Elsewhere { position } => (String::new(), *position),
            };
            let angle = x.atan2(y).to_degrees();
            Some(format!("{name}{angle_name} {angle:.1}°\n{radius_name} {}", number_text(scale.number(x.hypot(y)))))
        });
    plot.show(ui, |plot| {
        draw_disc(plot, (&rings, rim), scale, theme);
        for (angle, colour) in &chart.arrows {
            draw_arrow(plot, *angle, rim, colour_of(theme.curve(*colour)));
        }
        if let Some((angle, name)) = mark {
            let points = vec![[0.0, 0.0], polar_place(angle, rim)];
            let line = Line::new(name, points).color(colour_of(theme.muted())).width(1.2);
            plot.line(line.style(LineStyle::Dashed { length: 4.0 }).allow_hover(false));
        }
        add_curves(plot, &chart.curves, theme, |[angle, number]| polar_place(angle, scale.place(number)));
    });
}

/// The rings, the spokes and their labels.
fn draw_disc(plot: &mut PlotUi<'_>, (rings, rim): (&[f64], f64), scale: PlotScale, theme: ChartTheme) {
    let [grid, frame, muted] = [theme.grid(), theme.frame(), theme.muted()].map(colour_of);
    let line = |points: Vec<[f64; 2]>, colour: Color32| Line::new("", points).color(colour).width(1.0).allow_hover(false);
    let label = |text: String, at: [f64; 2], anchor: Align2| {
        let text = RichText::new(text).small();
        Text::new("", PlotPoint::new(at[0], at[1]), text).color(muted).anchor(anchor).allow_hover(false)
    };
    for degrees in (-75..=75).step_by(15) {
        plot.line(line(vec![[0.0, 0.0], polar_place(f64::from(degrees), rim)], grid));
    }
    for ring in rings {
        let arc = (-90..=90).step_by(2).map(|degrees| polar_place(f64::from(degrees), *ring)).collect();
        plot.line(line(arc, if *ring == rim { frame } else { grid }));
        plot.text(label(number_text(scale.number(*ring)), [*ring, -0.015 * rim], Align2::CENTER_TOP));
    }
    if scale.lowest.is_some() {
        plot.text(label(number_text(scale.number(0.0)), [0.0, -0.015 * rim], Align2::CENTER_TOP));
    }
    plot.line(line(vec![[-rim, 0.0], [rim, 0.0]], frame));
    for degrees in (-90..=90).step_by(30) {
        let anchor = match degrees {
            0 => Align2::CENTER_BOTTOM,
            -90..0 => Align2::RIGHT_CENTER,
            _ => Align2::LEFT_CENTER,
        };
        plot.text(label(format!("{degrees}°").replace('-', "−"), polar_place(f64::from(degrees), 1.03 * rim), anchor));
    }
}

/// The direction from which light comes: an arrow at the rim that points to the middle.
fn draw_arrow(plot: &mut PlotUi<'_>, angle: f64, rim: f64, colour: Color32) {
    let tip = polar_place(angle, 0.84 * rim);
    let line = |points: Vec<[f64; 2]>| Line::new("", points).color(colour).width(1.6).allow_hover(false);
    plot.line(line(vec![polar_place(angle, rim), tip]));
    let barbs = [-2.2, 2.2].map(|aside| polar_place(angle + aside, 0.9 * rim));
    plot.line(line(vec![barbs[0], tip, barbs[1]]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_put_numbers_and_read_them_back() {
        let curve = |numbers: &[f64]| Curve {
            name: String::new(),
            points: numbers.iter().map(|number| [0.0, *number]).collect(),
            colour: 0,
            dashes: Dashes::Solid,
        };
        let curves = [curve(&[0.02, 30.0, 0.0, f64::NAN])];
        let log = PlotScale::new(&ChartAxis::numbers("f", "", true), &curves);
        assert_eq!(log.lowest, Some(-2.0));
        assert!((log.place(1.0) - 2.0).abs() < 1e-12 && log.place(-1.0) == 0.0 && (log.number(3.0) - 10.0).abs() < 1e-9);
        let linear = PlotScale::new(&ChartAxis::numbers("f", "", false), &curves);
        assert_eq!((linear.place(0.25), linear.number(0.25)), (0.25, 0.25));
    }

    #[test]
    fn the_numbers_of_curves_are_told_at_an_angle() {
        let points = [[0.0, 1.0], [10.0, 3.0], [20.0, f64::NAN], [30.0, 5.0]];
        let found = [-1.0, 0.0, 2.5, 10.0, 15.0, 30.0, 31.0].map(|x| number_at(&points, x));
        assert_eq!(found, [None, Some(1.0), Some(1.5), Some(3.0), None, None, None]);
        assert_eq!(number_at(&[], 1.0), None);
    }

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, 1.0, 0.312_34, 12.5, 1234.56, 1e-7, 2e9].map(number_text);
        assert_eq!(texts, ["0", "1", "0.3123", "12.5", "1235", "1.00e-7", "2.00e9"]);
    }

    #[test]
    fn an_axis_has_no_marks_beyond_its_range() {
        let values =
            |bounds, step, range| -> Vec<f64> { angle_marks(bounds, step, range).iter().map(|mark| mark.value).collect() };
        // The plot has a margin of 4 degrees.
        assert_eq!(values((-4.0, 94.0), 4.0, Some([0.0, 90.0])), [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0]);
        assert_eq!(values((-98.0, 98.0), 8.0, Some([-90.0, 90.0])).len(), 7);
        assert_eq!(values((-4.0, 94.0), 4.0, None)[0], -15.0);
    }

    #[test]
    fn rings_are_round_and_reach_the_greatest_number() {
        let linear = PlotScale { lowest: None };
        assert_eq!(rings(linear, 0.93), [0.25, 0.5, 0.75, 1.0]);
        assert_eq!(rings(linear, 20.0), [5.0, 10.0, 15.0, 20.0]);
        assert_eq!(rings(PlotScale { lowest: Some(-3.0) }, 2.4), [1.0, 2.0, 3.0]);
    }
}

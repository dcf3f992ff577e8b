//! The legend of the curves of a chart: beside or above it, never over the curves.

use crate::plot::{ChartTheme, Curve, Dashes, plain};
use crate::preview::app::instruments::plots::colour_of;
use egui::{Align2, Rect, ScrollArea, Sense, Shape, Stroke, TextStyle, Ui, UiBuilder, pos2, vec2};
use std::collections::BTreeSet;

/// A chart of at least this width has its legend at its right.
const WIDE: f32 = 430.0;
/// A narrower chart of at least this height has it above.
const HIGH: f32 = 260.0;
/// The most that it takes of the width beside the chart, and of the height above it.
const MOST: f32 = 0.3;
/// The widest column of names, in points.
const WIDEST: f32 = 240.0;
/// The length of the sample of a line, and the gaps around it, in points.
const SAMPLE: f32 = 22.0;
const GAP: f32 = 6.0;
/// The height of an entry, in points.
const ROW: f32 = 15.0;

/// The legend. A click on an entry hides its curve.
#[derive(Default)]
pub(super) struct CurveLegend {
    /// The names of hidden curves.
    hidden: BTreeSet<String>,
}

impl CurveLegend {
    /// The curves that are not hidden.
    pub(super) fn shown(&self, curves: &[Curve]) -> Vec<Curve> {
        curves.iter().filter(|curve| !self.hidden.contains(&curve.name)).cloned().collect()
    }

    /// Takes all free space, draws the legend where there is room for it, and returns what is left for the chart. One
    /// curve alone needs no legend.
    pub(super) fn ui(&mut self, ui: &mut Ui, curves: &[Curve], theme: ChartTheme) -> Rect {
        let (room, _) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
        if curves.len() < 2 {
            // A curve of this name may come back among others, but alone it is seen.
            self.hidden.retain(|name| curves.iter().all(|curve| curve.name != *name));
            return room;
        }
        let widths: Vec<f32> = curves.iter().map(|curve| entry_width(ui, &curve.name)).collect();
        let widest = widths.iter().copied().fold(0.0, f32::max);
        let Some((chart, legend)) = places(room, &widths) else { return room };
        let is_beside = legend.left() > chart.left();
        ui.scope_builder(UiBuilder::new().max_rect(legend), |ui| {
            ui.spacing_mut().item_spacing = vec2(0.0, 1.0);
            ui.spacing_mut().interact_size.y = ROW;
            let list = ScrollArea::vertical().id_salt("legend").auto_shrink(false).max_height(legend.height());
            list.show(ui, |ui| {
                if is_beside {
                    curves.iter().for_each(|curve| self.entry_ui(ui, curve, theme, widest.min(legend.width())));
                } else {
                    ui.horizontal_wrapped(|ui| {
                        for (curve, width) in curves.iter().zip(&widths) {
                            self.entry_ui(ui, curve, theme, width.min(legend.width()));
                        }
                    });
                }
            });
        });
        chart
    }

    /// Draws an entry of this width.
    fn entry_ui(&mut self, ui: &mut Ui, curve: &Curve, theme: ChartTheme, width: f32) {
        let name = plain(&curve.name);
        let (rect, response) = ui.allocate_exact_size(vec2(width, ROW), Sense::click());
        let is_hidden = self.hidden.contains(&curve.name);
        let fade = if is_hidden { 0.3 } else { 1.0 };
        let painter = ui.painter_at(rect);
        let ends = [pos2(rect.left() + 1.0, rect.center().y), pos2(rect.left() + SAMPLE, rect.center().y)];
        let stroke = Stroke::new(2.0, colour_of(theme.curve(curve.colour)).gamma_multiply(fade));
        painter.extend(match curve.dashes {
            Dashes::Solid => vec![Shape::line_segment(ends, stroke)],
            Dashes::Dashed => Shape::dashed_line(&ends, stroke, 7.0, 4.0),
            Dashes::Dotted => Shape::dotted_line(&ends, stroke.color, 5.0, 1.2),
            Dashes::DashDotted => Shape::dashed_line(&ends, stroke, 3.5, 2.5),
        });
        let colour = ui.visuals().text_color().gamma_multiply(fade);
        let at = pos2(rect.left() + SAMPLE + GAP, rect.center().y);
        let words = shortened(&name, |text| entry_width(ui, text) <= width + GAP);
        painter.text(at, Align2::LEFT_CENTER, words, TextStyle::Small.resolve(ui.style()), colour);
        response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Checkbox, true, !is_hidden, &name));
        let about = if is_hidden { "hidden; click to show it" } else { "click to hide it" };
        if response.on_hover_text(format!("{name}\n{about}")).clicked() && !self.hidden.remove(&curve.name) {
            self.hidden.insert(curve.name.clone());
        }
    }
}

/// A name that is shortened until it fits. Its last part, behind a comma, is kept: it tells curves of one model apart.
fn shortened(name: &str, fits: impl Fn(&str) -> bool) -> String {
    if fits(name) {
        return name.to_owned();
    }
    let (front, last) = name.rsplit_once(", ").map_or((name, String::new()), |(front, last)| (front, format!(", {last}")));
    let lengths = (0..=front.chars().count()).rev();
    let cut = |length: usize| format!("{}…{last}", front.chars().take(length).collect::<String>().trim_end());
    lengths.map(cut).find(|text| fits(text)).unwrap_or_else(|| format!("…{last}"))
}

/// The width of an entry that shows all of a name.
fn entry_width(ui: &Ui, name: &str) -> f32 {
    let font = TextStyle::Small.resolve(ui.style());
    let text = ui.painter().layout_no_wrap(plain(name), font, ui.visuals().text_color());
    SAMPLE + GAP + text.size().x + 2.0 * GAP
}

/// The places of the chart and of the legend, whose entries have these widths; none if the chart is too small for one.
fn places(room: Rect, widths: &[f32]) -> Option<(Rect, Rect)> {
    if room.width() >= WIDE {
        let widest = widths.iter().copied().fold(0.0, f32::max);
        // A bar to scroll stands beside the entries.
        let width = (widest + 2.0 * GAP).min(MOST * room.width()).min(WIDEST);
        let (chart, legend) = room.split_left_right_at_x(room.right() - width);
        return Some((chart, legend.with_min_x(legend.left() + GAP)));
    }
    if room.height() < HIGH {
        return None;
    }
    let mut rows = 1;
    let mut used = 0.0;
    for width in widths.iter().map(|width| width.min(room.width())) {
        if used > 0.0 && used + width > room.width() {
            (rows, used) = (rows + 1, 0.0);
        }
        used += width;
    }
    let height = (rows as f32 * (ROW + 1.0) + GAP).min(MOST * room.height());
    let (legend, chart) = room.split_top_bottom_at_y(room.top() + height);
    Some((chart, legend))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_part_of_a_long_name_stays() {
        let short = |name: &str| shortened(name, |text| text.chars().count() <= 16);
        assert_eq!(short("a beam from there, red"), "a beam fro…, red");
        assert_eq!(short("a name without commas"), "a name without…");
        assert_eq!(short("short, red"), "short, red");
    }

    #[test]
    fn legend_and_chart_never_overlap_and_the_chart_has_most_of_the_room() {
        for (size, is_there) in [([700.0, 100.0], true), ([1200.0, 280.0], true), ([300.0, 400.0], true), ([300.0, 100.0], false)]
        {
            let room = Rect::from_min_size(pos2(10.0, 20.0), vec2(size[0], size[1]));
            let found = places(room, &[150.0; 9]);
            assert_eq!(found.is_some(), is_there, "{size:?}");
            if let Some((chart, legend)) = found {
                assert!(!chart.shrink(0.1).intersects(legend.shrink(0.1)), "{chart} {legend}");
                assert!(room.contains_rect(chart) && room.contains_rect(legend), "{chart} {legend}");
                assert!(chart.area() >= 0.69 * room.area(), "{chart}");
            }
        }
    }
}

//! The pane of the chart: its heading, the chart as it was made last, and what is read out of it.

use crate::instrument::view::LightUse;
use crate::plot::{CartesianChart, Chart, ChartAxis, ChartTheme, MapChart, MapPixel, PolarChart, plain};
use crate::preview::app::instruments::plots::{self, colour_text, number_text};
use crate::preview::app::instruments::sheet::DrawnChart;
use crate::preview::app::instruments::{InstrumentPanel, SheetKey};
use egui::text::LayoutJob;
use egui::{Color32, CursorIcon, Label, Rect, Response, RichText, Sense, TextStyle, TextureOptions, Ui, UiBuilder, pos2, vec2};

/// The height of a line above the chart, in points.
const LINE: f32 = 18.0;
/// What is read out takes one line for this much of the height, in points, and at most this many.
const HEIGHT_FOR_ROW: f32 = 110.0;
const MOST_ROWS: usize = 4;

impl InstrumentPanel {
    /// Takes the chart that was made, if there is a new one.
    fn take_sheet(&mut self, ui: &Ui) {
        let Some(mut sheet) = self.sheets.take() else { return };
        if let Some(image) = sheet.image.take() {
            match &mut self.texture {
                Some(texture) => texture.set(image, TextureOptions::LINEAR),
                None => self.texture = Some(ui.ctx().load_texture("chart", image, TextureOptions::LINEAR)),
            }
        }
        self.sheet = Some(sheet);
        // Axes know only after a frame how much room their labels need.
        ui.ctx().request_repaint();
    }

    /// Asks for the present chart, unless it was asked for.
    fn ask_sheet(&mut self, ui: &Ui, size: [u32; 2]) {
        let (scale, theme) = (ui.ctx().pixels_per_point(), theme_of(ui));
        let Some(subject) = &self.subject else { return };
        let key = SheetKey {
            view: self.controls.view().name,
            settings: self.settings(),
            viewer: self.controls.viewer(),
            size,
            scale,
            theme,
            held: subject.held.clone(),
            overlays: self.overlays_version,
        };
        if self.asked.as_ref() != Some(&key) {
            self.asked = Some(key);
            self.number += 1;
            let request = self.request(size, scale, theme);
            self.sheets.ask(request);
        }
    }

    /// Draws what stands above the chart: what it shows, and what is read out for the viewer.
    fn heading_ui(&self, ui: &mut Ui, sheet: &DrawnChart) {
        let words = [&sheet.heading.title, &sheet.heading.subtitle].map(|text| plain(text));
        let words = words.into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join("; ");
        let is_behind = sheet.number != self.number && self.sheets.is_busy();
        let words = if is_behind { format!("{words} …") } else { words };
        let about = format!("{words}\nDrawn in {:.1} ms", 1e3 * sheet.time.as_secs_f64());
        ui.add(Label::new(RichText::new(words).small().weak()).truncate()).on_hover_text(about);
        if self.controls.viewer().is_some() {
            let font = TextStyle::Small.resolve(ui.style());
            let mut job = LayoutJob::simple(sheet.reading.line.clone(), font, ui.visuals().text_color(), ui.available_width());
            // A low chart needs the room itself.
            job.wrap.max_rows = ((ui.available_height() / HEIGHT_FOR_ROW) as usize).clamp(1, MOST_ROWS);
            let words = ui.painter().layout_job(job);
            ui.add(Label::new(words)).on_hover_text(&sheet.reading.details);
        }
    }

    /// Draws the chart into the rest of the panel.
    pub(super) fn chart_ui(&mut self, ui: &mut Ui) {
        self.take_sheet(ui);
        // A chart of another view would be taken for this one.
        let shown = |sheet: &&DrawnChart| sheet.view == self.controls.view().name;
        let is_there = self.sheet.as_ref().filter(shown).map(|sheet| self.heading_ui(ui, sheet)).is_some();
        let room = ui.available_size() - if is_there { vec2(0.0, 0.0) } else { vec2(0.0, 2.0 * LINE) };
        self.ask_sheet(ui, [room.x, room.y].map(|side| side.round().clamp(60.0, 2400.0) as u32));
        let theme = theme_of(ui);
        let mark = self.controls.viewer().map(|angle| (angle, "viewer"));
        let Some(sheet) = self.sheet.as_ref().filter(|_| is_there) else {
            ui.centered_and_justified(|ui| ui.weak("Drawing…"));
            return;
        };
        match (&sheet.chart, &self.texture) {
            (Chart::Cartesian(chart), _) => {
                let mark = mark.filter(|_| self.controls.view().lights == LightUse::Several);
                let room = self.legend.ui(ui, &chart.curves, theme);
                let chart = CartesianChart { curves: self.legend.shown(&chart.curves), ..chart.clone() };
                ui.scope_builder(UiBuilder::new().max_rect(room), |ui| plots::cartesian_ui(ui, &chart, theme, mark));
            }
            (Chart::Polar(chart), _) => {
                let room = self.legend.ui(ui, &chart.curves, theme);
                let chart = PolarChart { curves: self.legend.shown(&chart.curves), ..chart.clone() };
                ui.scope_builder(UiBuilder::new().max_rect(room), |ui| plots::polar_ui(ui, &chart, theme, mark));
            }
            (Chart::Map(chart), Some(texture)) => {
                let response = picture_ui(ui, texture);
                if let Some(words) = response.hover_pos().and_then(|at| words_at(chart, sheet.size, at - response.rect.min)) {
                    response.on_hover_text_at_pointer(words).on_hover_cursor(CursorIcon::Crosshair);
                }
            }
            (Chart::Lobe(_), Some(texture)) => {
                let response = picture_ui(ui, texture);
                self.is_turning = response.dragged();
                if self.is_turning {
                    self.controls.turn(response.drag_delta().into());
                    ui.ctx().request_repaint();
                }
                response.on_hover_text_at_pointer("Drag to turn").on_hover_cursor(CursorIcon::Grab);
            }
            (Chart::Map(_) | Chart::Lobe(_), None) => {}
        }
    }
}

/// Draws a drawing in its own size.
fn picture_ui(ui: &mut Ui, texture: &egui::TextureHandle) -> Response {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let points = texture.size_vec2() / ui.ctx().pixels_per_point();
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter_at(rect).image(texture.id(), Rect::from_min_size(rect.min, points), whole, Color32::WHITE);
    response
}

/// What a picture over two angles shows at a point of its drawing, in words: the model, the angles and the number.
fn words_at(chart: &MapChart, size: [u32; 2], at: egui::Vec2) -> Option<String> {
    let [x, y] = chart.axes.as_ref()?;
    let reading = chart.reading(size, [f64::from(at.x), f64::from(at.y)])?;
    let name = &chart.panels.get(reading.panel)?.name;
    let line = |axis: &ChartAxis, angle: f64| format!("{} {angle:.1}°", plain(&axis.title));
    let [across, upwards] = reading.place;
    // Colours are π times the BRDF, so that 1 is a matte white.
    let number = match reading.pixel {
        MapPixel::Number(number) => format!("{} {}", plain(&chart.bar.title), number_text(number)),
        MapPixel::Colour(colour) => format!("{} {}", plain(&chart.bar.title), colour_text(colour.map(f64::from))),
    };
    let lines = [name.clone(), line(x, across), line(y, upwards), number];
    Some(lines.into_iter().filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n"))
}

/// The colours of charts that suit the window.
pub(super) fn theme_of(ui: &Ui) -> ChartTheme {
    if ui.visuals().dark_mode { ChartTheme::Dark } else { ChartTheme::Light }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{MapPanel, MapValues};

    #[test]
    fn a_slice_says_its_angles_and_its_number() {
        let map = |values: MapValues| MapChart {
            axes: Some(["half angle", "difference angle"].map(|title| ChartAxis::angles(title, [0.0, 90.0]))),
            bar: ChartAxis::numbers("BRDF", "1/sr", false),
            panels: vec![MapPanel { name: "matte".to_owned(), size: [1, 1], values }],
            ..MapChart::default()
        };
        // The only pixel takes the middle of the drawing.
        let said = |chart: &MapChart| words_at(chart, [400, 300], vec2(190.0, 120.0));
        let numbers = map(MapValues::Numbers(vec![0.25]));
        assert_eq!(said(&numbers).unwrap(), "matte\nhalf angle 45.0°\ndifference angle 45.0°\nBRDF 0.25");
        let colours = map(MapValues::Colours(vec![[0.5, 0.25, 0.125]]));
        assert!(said(&colours).unwrap().ends_with("\nBRDF (0.5, 0.25, 0.125)"));
        assert_eq!(words_at(&numbers, [400, 300], vec2(1.0, 1.0)), None);
        // A ball has no angles to tell.
        assert_eq!(said(&MapChart { axes: None, ..numbers }), None);
    }
}

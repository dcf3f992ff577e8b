//! The instruments: charts of the formula itself, which follow its values, and a verdict on its energy.
//!
//! Charts and verdicts are made on threads of their own, each for the newest values. So the window never waits for
//! them. What they show is known in `instrument` and `plot`.

mod actions;
mod controls;
mod hit;
mod legend;
mod overlays;
mod plots;
mod sheet;
mod verdict;

pub(super) use hit::InstrumentPlace;

use crate::instrument::held::{CompiledModel, HeldFormula};
use crate::instrument::measurement::ModelMeasurement;
use crate::instrument::model::Place;
use crate::instrument::view::{LightUse, NamedModel, ViewSettings};
use crate::plot::{CartesianChart, Chart, ChartTheme, PolarChart};
use crate::preview::app::panel_sizes::remember;
use crate::preview::app::{Action, InstrumentAction};
use crate::preview::latest::LatestWorker;
use crate::preview::workshop::Workshop;
use crate::scene::{BodyId, LightId};
use crate::user_data::settings::{PanelSide, PanelSizes};
use crate::workspace::OwnerId;
use controls::ChartControls;
use egui::{
    Align, Button, CentralPanel, Color32, Frame, Id, Label, Layout, Margin, Panel, Rect, RichText, ScrollArea, Sense,
    TextureHandle, TextureOptions, Ui, UiBuilder, vec2,
};
use legend::CurveLegend;
use overlays::Overlays;
use sheet::{DrawnChart, SheetRequest};
use std::sync::Arc;
use std::time::{Duration, Instant};
use verdict::VerdictWords;

/// The least height of the panel, in points.
const LEAST_HEIGHT: f32 = 180.0;
/// The least height that is left for the picture, in points.
const LEAST_PICTURE: f32 = 250.0;
/// The width of the choices beside the chart, in points.
const CONTROLS_WIDTH: f32 = 178.0;
/// A verdict that takes longer waits until the slider is let go.
const QUICK_VERDICT: Duration = Duration::from_millis(120);

/// What the charts are of.
struct InstrumentSubject {
    held: HeldFormula,
    /// The name of the formula.
    formula: String,
    /// Of which body and light, in words.
    about: String,
}

/// What a chart was asked for: if this changes, another one is needed.
#[derive(PartialEq)]
struct SheetKey {
    view: &'static str,
    settings: ViewSettings,
    size: [u32; 2],
    scale: f32,
    theme: ChartTheme,
    held: HeldFormula,
    overlays: u64,
}

/// What is known of the energy.
struct KnownVerdict {
    words: VerdictWords,
    held: HeldFormula,
}

/// The panel.
pub(super) struct InstrumentPanel {
    /// Whether it is open.
    pub(super) open: bool,
    controls: ChartControls,
    legend: CurveLegend,
    body: Option<BodyId>,
    light: Option<LightId>,
    /// A point of the picture, if one was chosen.
    place: Option<InstrumentPlace>,
    compiled: Option<Arc<CompiledModel>>,
    subject: Option<InstrumentSubject>,
    overlays: Overlays,
    /// Grows when the models beside the formula change.
    overlays_version: u64,
    /// Whether a slider is held, so that charts are drafts.
    is_moving: bool,
    sheets: LatestWorker<SheetRequest, DrawnChart>,
    asked: Option<SheetKey>,
    number: u64,
    sheet: Option<DrawnChart>,
    texture: Option<TextureHandle>,
    verdicts: LatestWorker<HeldFormula, (KnownVerdict, Duration)>,
    asked_verdict: Option<HeldFormula>,
    verdict: Option<KnownVerdict>,
    verdict_time: Duration,
}

impl InstrumentPanel {
    /// The panel. `wake` wakes the window.
    pub(super) fn new(open: bool, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let wake = Arc::new(wake);
        let also = Arc::clone(&wake);
        let measure = |held: HeldFormula| {
            let start = Instant::now();
            let words = VerdictWords::new(&ModelMeasurement::of(&held));
            (KnownVerdict { words, held }, start.elapsed())
        };
        Self {
            open,
            controls: ChartControls::default(),
            legend: CurveLegend::default(),
            body: None,
            light: None,
            place: None,
            compiled: None,
            subject: None,
            overlays: Overlays::default(),
            overlays_version: 0,
            is_moving: false,
            sheets: LatestWorker::new(|request| DrawnChart::new(&request), move || wake()),
            asked: None,
            number: 0,
            sheet: None,
            texture: None,
            verdicts: LatestWorker::new(measure, move || also()),
            asked_verdict: None,
            verdict: None,
            verdict_time: Duration::ZERO,
        }
    }

    /// Takes the directions and the surface of a hit.
    pub(super) fn look_at(&mut self, place: InstrumentPlace) {
        self.open = true;
        self.controls.look(place.light_angles, place.view_angles);
        (self.body, self.light) = (Some(place.body), Some(place.light));
        self.place = Some(place);
    }

    /// Draws the panel below the picture, with the current values. `selected` is the owner whose values are in view.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        workshop: &Workshop,
        (selected, formula): (OwnerId, &str),
        sizes: &mut PanelSizes,
        actions: &mut Vec<Action>,
    ) {
        if !self.open {
            return;
        }
        self.follow(workshop, selected, formula);
        let room = ui.available_height();
        // The picture keeps some, too.
        let most = (room - LEAST_PICTURE).min(0.62 * room).max(LEAST_HEIGHT);
        let id = Id::new("instruments");
        let panel = Panel::bottom(id).resizable(true).default_size(sizes.get(PanelSide::Instruments));
        panel.size_range(LEAST_HEIGHT..=most).show(ui, |ui| {
            self.header_ui(ui, workshop);
            ui.horizontal_wrapped(|ui| self.controls.views_ui(ui));
            ui.add_space(2.0);
            let side = Panel::left("instrument controls").resizable(false).exact_size(CONTROLS_WIDTH);
            side.frame(Frame::NONE.inner_margin(Margin { left: 0, right: 8, top: 4, bottom: 0 })).show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.controls_ui(ui, actions));
            });
            CentralPanel::default()
                .frame(Frame::NONE.inner_margin(Margin { left: 8, right: 0, top: 2, bottom: 0 }))
                .show(ui, |ui| self.chart_ui(ui));
        });
        remember(ui.ctx(), id, PanelSide::Instruments, sizes);
    }

    /// Takes the formula and its values, and asks for a verdict on them.
    fn follow(&mut self, workshop: &Workshop, selected: OwnerId, formula: &str) {
        let scene = workshop.scene();
        match selected {
            OwnerId::Body(body) => self.body = Some(body),
            OwnerId::Light(light) => self.light = Some(light),
            OwnerId::Global => {}
        }
        self.body = self.body.filter(|body| body.index() < scene.bodies.len()).or_else(|| scene.body_ids().next());
        self.light = self.light.filter(|light| light.index() < scene.lights.len()).or_else(|| scene.light_ids().next());
        // A point of the picture is of one body.
        self.place = self.place.take().filter(|place| Some(place.body) == self.body);
        let is_same = |compiled: &&Arc<CompiledModel>| Arc::ptr_eq(&compiled.formula, workshop.formula());
        let compiled = match self.compiled.as_ref().filter(is_same) {
            Some(compiled) => Arc::clone(compiled),
            None => Arc::new(CompiledModel::new(Arc::clone(workshop.formula()))),
        };
        self.compiled = Some(Arc::clone(&compiled));
        let mut about = self.body.map(|body| scene.body(body).name.clone()).unwrap_or_default();
        if let Some(light) = self.light {
            let separator = if about.is_empty() { "" } else { ", " };
            about.push_str(&format!("{separator}light {}", scene.light(light).name));
        }
        let place = self.place.as_ref().map_or_else(Place::default, |place| place.place.clone());
        let numbers = workshop.reflection_numbers(self.body, self.light);
        let held = HeldFormula { compiled, numbers, place, keeps_pairs: false };
        self.is_moving = workshop.held().is_some();
        self.ask_verdict(&held, self.is_moving);
        self.subject = Some(InstrumentSubject { held, formula: formula.to_owned(), about });
    }

    fn ask_verdict(&mut self, held: &HeldFormula, is_slider_held: bool) {
        if let Some((verdict, time)) = self.verdicts.take() {
            (self.verdict, self.verdict_time) = (Some(verdict), time);
        }
        let waits = is_slider_held && self.verdict_time > QUICK_VERDICT;
        if self.asked_verdict.as_ref() != Some(held) && !waits {
            self.asked_verdict = Some(held.clone());
            self.verdicts.ask(held.clone());
        }
    }

    /// Draws the verdict, and the button that closes the panel.
    fn header_ui(&mut self, ui: &mut Ui, workshop: &Workshop) {
        ui.horizontal(|ui| {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.small_button("×").on_hover_text("Close the instruments (Ctrl+I)").clicked() {
                    self.open = false;
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    if workshop.formula().parameter_ids().next().is_none() {
                        return;
                    }
                    let Some(KnownVerdict { words, held }) = &self.verdict else {
                        ui.add(Label::new(RichText::new("Measuring the energy…").weak()).truncate());
                        return;
                    };
                    let is_stale = self.subject.as_ref().is_none_or(|subject| subject.held != *held);
                    let sign = if words.is_warning { "⚠ " } else { "" };
                    let text = RichText::new(format!("{sign}{}", words.text)).strong();
                    let text = match (is_stale, words.is_warning) {
                        (true, _) => text.color(ui.visuals().weak_text_color()),
                        (false, true) => text.color(ui.visuals().warn_fg_color),
                        (false, false) => text,
                    };
                    let button = ui.add(Button::new(text).frame(false).truncate());
                    if button
                        .on_hover_text(format!(
                            "{}\n{}\nClick for the share of the light over the angle.",
                            words.text, words.details
                        ))
                        .clicked()
                    {
                        self.controls.choose("albedo");
                    }
                });
            });
        });
    }

    /// Draws what is chosen, the models beside the formula, and the buttons.
    fn controls_ui(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let theme = theme_of(ui);
        if let Some(subject) = &self.subject {
            let about = "What the charts are of. Select another body or light in the list of parameters or in the picture.";
            ui.add(Label::new(RichText::new(&subject.about).strong()).truncate()).on_hover_text(about);
        }
        if let Some(place) = &self.place {
            let is_left = ui.horizontal(|ui| {
                let leave = ui.small_button("×").on_hover_text("Leave this point").clicked();
                ui.add(Label::new(RichText::new(&place.words).small()).truncate()).on_hover_text(&place.details);
                leave
            });
            if is_left.inner {
                self.place = None;
            }
        }
        self.controls.ui(ui);
        ui.separator();
        ui.horizontal_wrapped(|ui| {
            let has_room = self.overlays.has_room();
            let keep = ui.add_enabled(has_room, Button::new("Keep"));
            if keep.on_hover_text("Keep the formula with these values beside the present ones").clicked()
                && let Some(subject) = &self.subject
            {
                self.overlays.keep(&subject.formula, &subject.about, subject.held.clone());
                self.overlays_version += 1;
            }
            let load = ui.add_enabled(has_room, Button::new("Load measured…"));
            if load.on_hover_text("Show a measured material beside it: MERL (.binary) or RGL (.bsdf)").clicked() {
                actions.push(Action::Instruments(InstrumentAction::ShowMeasuredDialog));
            }
            if ui.button("Save…").on_hover_text("Save the chart as PNG or SVG, or its numbers as CSV").clicked() {
                actions.push(Action::Instruments(InstrumentAction::ShowSaveDialog));
            }
        });
        let now = self.subject.as_ref().map(|subject| subject.formula.clone()).unwrap_or_default();
        let (is_changed, compared) = self.overlays.ui(ui, &format!("{now}, now"), theme);
        self.overlays_version += u64::from(is_changed);
        actions.extend(compared.map(|path| Action::Instruments(InstrumentAction::Compare(path))));
    }

    /// The models in their order: the formula first.
    fn models(&self) -> Vec<NamedModel> {
        let Some(subject) = &self.subject else { return Vec::new() };
        // Integrals choose their pairs by the values, so they seldom ask for the same ones again; drafts do not.
        let keeps_pairs = self.controls.view().lights != LightUse::Integrated || self.is_moving;
        let name = format!("{}, now", subject.formula);
        let now = NamedModel { name, model: Arc::new(HeldFormula { keeps_pairs, ..subject.held.clone() }) };
        std::iter::once(now).chain(self.overlays.named(keeps_pairs)).collect()
    }

    /// What the present chart shows, and how.
    fn settings(&self) -> ViewSettings {
        ViewSettings { is_draft: self.is_moving, ..self.controls.settings() }
    }

    /// What the present chart is asked for.
    fn request(&self, size: [u32; 2], scale: f32, theme: ChartTheme) -> SheetRequest {
        let settings = self.settings();
        let (number, view) = (self.number, self.controls.view());
        SheetRequest { number, view, models: self.models(), settings, size, scale: f64::from(scale), theme }
    }

    /// Asks for the present chart, unless it was asked for, and takes what was made.
    fn ask_sheet(&mut self, ui: &Ui, size: [u32; 2]) {
        let (scale, theme) = (ui.ctx().pixels_per_point(), theme_of(ui));
        let Some(subject) = &self.subject else { return };
        let key = SheetKey {
            view: self.controls.view().name,
            settings: self.settings(),
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
        if let Some(mut sheet) = self.sheets.take() {
            if let Some(image) = sheet.image.take() {
                match &mut self.texture {
                    Some(texture) => texture.set(image, TextureOptions::LINEAR),
                    None => self.texture = Some(ui.ctx().load_texture("chart", image, TextureOptions::LINEAR)),
                }
            }
            self.sheet = Some(sheet);
        }
    }

    /// Draws the chart into the rest of the panel.
    fn chart_ui(&mut self, ui: &mut Ui) {
        /// The height of the line above the chart, in points.
        const HEADING: f32 = 18.0;
        let room = ui.available_size();
        let size = [room.x, room.y - HEADING].map(|side| side.round().clamp(60.0, 2400.0) as u32);
        self.ask_sheet(ui, size);
        let theme = theme_of(ui);
        let mark = self.place.as_ref().map(|place| (place.view_angles[0], "viewer"));
        // A chart of another view would be taken for this one.
        let Some(sheet) = self.sheet.as_ref().filter(|sheet| sheet.view == self.controls.view().name) else {
            ui.centered_and_justified(|ui| ui.weak("Drawing…"));
            return;
        };
        let words = [&sheet.heading.title, &sheet.heading.subtitle].map(|text| plots::plain(text));
        let words = words.into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join("; ");
        let is_behind = sheet.number != self.number && self.sheets.is_busy();
        let words = if is_behind { format!("{words} …") } else { words };
        let about = format!("{words}\nDrawn in {:.1} ms", 1e3 * sheet.time.as_secs_f64());
        ui.add(Label::new(RichText::new(words).small().weak()).truncate()).on_hover_text(about);
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
            (Chart::Map(_) | Chart::Lobe(_), Some(texture)) => {
                let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
                let points = texture.size_vec2() / ui.ctx().pixels_per_point();
                let shown = Rect::from_min_size(rect.min, points);
                let whole = Rect::from_min_size(egui::Pos2::ZERO, vec2(1.0, 1.0));
                ui.painter_at(rect).image(texture.id(), shown, whole, Color32::WHITE);
                let turns = matches!(sheet.chart, Chart::Lobe(_));
                if turns && response.dragged() {
                    self.controls.turn(response.drag_delta().into());
                    ui.ctx().request_repaint();
                }
                if turns {
                    response.on_hover_text_at_pointer("Drag to turn").on_hover_cursor(egui::CursorIcon::Grab);
                }
            }
            (Chart::Map(_) | Chart::Lobe(_), None) => {}
        }
    }

    /// Whether the chart and the verdict are those of the present values.
    #[cfg(test)]
    pub(super) fn is_settled(&self) -> bool {
        let is_known = |subject: &InstrumentSubject| self.verdict.as_ref().is_some_and(|known| known.held == subject.held);
        !self.sheets.is_busy()
            && !self.verdicts.is_busy()
            && self.sheet.as_ref().is_some_and(|sheet| sheet.number == self.number)
            && self.subject.as_ref().is_some_and(is_known)
    }

    /// The name of the view.
    #[cfg(test)]
    pub(super) fn controls_view(&self) -> &'static str {
        self.controls.view().name
    }

    /// How many models are beside the formula.
    #[cfg(test)]
    pub(super) fn overlay_count(&self) -> usize {
        self.overlays.models.len()
    }

    /// The value of the formula for the directions of the chosen point, and the angle of the light there.
    #[cfg(test)]
    pub(super) fn value_at_place(&self) -> Option<([f32; 3], f64)> {
        use crate::instrument::Reflectance;
        use crate::instrument::direction::{direction, pair};
        let (place, subject) = (self.place.as_ref()?, self.subject.as_ref()?);
        let [light, view] = [place.light_angles, place.view_angles].map(|[polar, azimuth]| direction(polar, azimuth));
        Some((*subject.held.values(&[pair(light, view)]).first()?, place.light_angles[0]))
    }
}

/// The colours of charts that suit the window.
fn theme_of(ui: &Ui) -> ChartTheme {
    if ui.visuals().dark_mode { ChartTheme::Dark } else { ChartTheme::Light }
}

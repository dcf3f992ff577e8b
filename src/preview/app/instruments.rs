//! The instruments: charts of the formula itself, which follow its values, and a verdict on its energy.
//!
//! Charts and verdicts are made on threads of their own, each for the newest values. So the window never waits for
//! them. What they show is known in `instrument` and `plot`.

mod actions;
mod chart_pane;
mod controls;
mod hit;
mod legend;
mod overlays;
mod placement;
mod plots;
mod reading_words;
mod sheet;
mod verdict;

pub(super) use hit::InstrumentPlace;

use crate::instrument::held::{CompiledModel, HeldFormula};
use crate::instrument::measurement::ModelMeasurement;
use crate::instrument::model::{Place, reads_coordinates};
use crate::instrument::view::{LightUse, NamedModel, ViewSettings};
use crate::plot::ChartTheme;
use crate::preview::app::{Action, InstrumentAction};
use crate::preview::latest::LatestWorker;
use crate::preview::workshop::Workshop;
use crate::scene::{BodyId, LightId};
use crate::user_data::settings::{InstrumentDock, WindowSettings};
use crate::workspace::OwnerId;
use chart_pane::theme_of;
use controls::ChartControls;
use egui::text::{LayoutJob, TextWrapping};
use egui::{Align, Button, FontSelection, Galley, Label, Layout, RichText, TextStyle, TextureHandle, Ui};
use legend::CurveLegend;
use overlays::Overlays;
use sheet::{DrawnChart, SheetRequest};
use std::sync::Arc;
use std::time::{Duration, Instant};
use verdict::VerdictWords;

/// How many rows a verdict takes and has at most.
const VERDICT_ROWS: usize = 2;
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
    viewer: Option<f64>,
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
    /// Where the user wants it.
    pub(super) dock: InstrumentDock,
    /// Whether it was over the picture in the last frame.
    was_over: bool,
    controls: ChartControls,
    legend: CurveLegend,
    body: Option<BodyId>,
    light: Option<LightId>,
    /// A point of the picture, if one was chosen.
    place: Option<InstrumentPlace>,
    compiled: Option<Arc<CompiledModel>>,
    subject: Option<InstrumentSubject>,
    overlays: Overlays,
    /// The file of the material that is compared in the picture, if one is.
    compared: Option<std::path::PathBuf>,
    /// Grows when the models beside the formula change.
    overlays_version: u64,
    /// Whether a slider is held, so that charts are drafts.
    is_moving: bool,
    /// Whether a lobe is turned with the mouse.
    is_turning: bool,
    /// Whether the formula reads coordinates of the surface.
    reads_coordinates: bool,
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
    pub(super) fn new(settings: &WindowSettings, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let wake = Arc::new(wake);
        let also = Arc::clone(&wake);
        let measure = |held: HeldFormula| {
            let start = Instant::now();
            let words = VerdictWords::new(&ModelMeasurement::of(&held));
            (KnownVerdict { words, held }, start.elapsed())
        };
        Self {
            open: settings.instruments,
            dock: settings.instruments_at,
            was_over: false,
            controls: ChartControls::default(),
            legend: CurveLegend::default(),
            body: None,
            light: None,
            place: None,
            compiled: None,
            subject: None,
            overlays: Overlays::default(),
            compared: None,
            overlays_version: 0,
            is_moving: false,
            is_turning: false,
            reads_coordinates: false,
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

    /// The body whose values the charts have.
    pub(super) fn body(&self) -> Option<BodyId> {
        self.body
    }

    /// Takes the directions and the surface of a hit.
    pub(super) fn look_at(&mut self, place: InstrumentPlace) {
        self.open = true;
        self.controls.look(place.light_angles, place.view_angles);
        self.controls.place_at(place.coordinates);
        (self.body, self.light) = (Some(place.body), Some(place.light));
        self.place = Some(place);
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
        let mut place = self.place.as_ref().map_or_else(Place::default, |place| place.place.clone());
        self.reads_coordinates = reads_coordinates(workshop.formula());
        if self.reads_coordinates {
            place = place.at_coordinates(self.controls.coordinates());
        }
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

    /// Draws the verdict, and the buttons that close and move the panel. `fits_right` says whether there is room at the
    /// right of the picture.
    fn header_ui(&mut self, ui: &mut Ui, workshop: &Workshop, fits_right: bool) {
        ui.horizontal(|ui| {
            // What is below does not move while the words change. All of them are in the tooltip, too.
            ui.set_min_height(VERDICT_ROWS as f32 * ui.text_style_height(&TextStyle::Body));
            ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
                if ui.small_button("×").on_hover_text("Close the instruments (Ctrl+I)").clicked() {
                    self.open = false;
                }
                self.place_menu(ui, fits_right);
                ui.with_layout(Layout::left_to_right(Align::Min), |ui| {
                    if workshop.formula().parameter_ids().next().is_none() {
                        return;
                    }
                    let subject = self.subject.as_ref().map(|subject| &subject.held);
                    // A verdict on another formula says nothing of this one.
                    let of_formula = |known: &&KnownVerdict| {
                        subject.is_some_and(|subject| Arc::ptr_eq(&subject.compiled, &known.held.compiled))
                    };
                    let Some(KnownVerdict { words, held }) = self.verdict.as_ref().filter(of_formula) else {
                        ui.add(Label::new(RichText::new("Measuring the energy…").weak()).truncate());
                        return;
                    };
                    let is_stale = subject != Some(held);
                    let sign = if words.is_warning { "⚠ " } else { "" };
                    let text = RichText::new(format!("{sign}{}", words.text)).strong();
                    let text = match (is_stale, words.is_warning) {
                        (true, _) => text.color(ui.visuals().weak_text_color()),
                        (false, true) => text.color(ui.visuals().warn_fg_color),
                        (false, false) => text,
                    };
                    let button = ui.add(Button::new(in_verdict_rows(ui, text)).frame(false));
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

    /// Draws what is chosen.
    fn choices_ui(&mut self, ui: &mut Ui) {
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
        self.controls.ui(ui, self.reads_coordinates);
    }

    /// Draws the models beside the formula, and the buttons.
    fn models_ui(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let theme = theme_of(ui);
        ui.horizontal_wrapped(|ui| {
            let has_room = self.overlays.has_room();
            let full = "There are as many models as charts can show: remove one of them below";
            let keep = ui.add_enabled(has_room, Button::new("Keep")).on_disabled_hover_text(full);
            if keep.on_hover_text("Keep the formula with these values beside the present ones").clicked()
                && let Some(subject) = &self.subject
            {
                self.overlays.keep(&subject.formula, &subject.about, subject.held.clone());
                self.overlays_version += 1;
            }
            let load = ui.add_enabled(has_room, Button::new("Load measured…")).on_disabled_hover_text(full);
            if load.on_hover_text("Show a measured material beside it: MERL (.binary) or RGL (.bsdf)").clicked() {
                actions.push(Action::Instruments(InstrumentAction::ShowMeasuredDialog));
            }
            if ui.button("Save…").on_hover_text("Save the chart as PNG or SVG, or its numbers as CSV").clicked() {
                actions.push(Action::Instruments(InstrumentAction::ShowSaveDialog));
            }
        });
        let now = self.subject.as_ref().map(|subject| subject.formula.clone()).unwrap_or_default();
        let (is_changed, compared) = self.overlays.ui(ui, &format!("{now}, now"), theme, self.compared.as_deref());
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
        ViewSettings { is_draft: self.is_moving || self.is_turning, ..self.controls.settings() }
    }

    /// What the present chart is asked for.
    fn request(&self, size: [u32; 2], scale: f32, theme: ChartTheme) -> SheetRequest {
        let settings = self.settings();
        let (number, view, viewer) = (self.number, self.controls.view(), self.controls.viewer());
        SheetRequest { number, view, models: self.models(), settings, viewer, size, scale: f64::from(scale), theme }
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

    /// The size of the chart, in pixels of the screen.
    #[cfg(test)]
    pub(super) fn chart_size(&self) -> [u32; 2] {
        self.asked.as_ref().map(|asked| asked.size).unwrap_or_default()
    }

    /// What is read out above the chart.
    #[cfg(test)]
    pub(super) fn reading(&self) -> String {
        self.sheet.as_ref().map(|sheet| sheet.reading.line.clone()).unwrap_or_default()
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

/// A text within the free width, in at most as many rows as a verdict has.
fn in_verdict_rows(ui: &Ui, text: RichText) -> Arc<Galley> {
    let mut job = LayoutJob::default();
    text.append_to(&mut job, ui.style(), FontSelection::Default, Align::Center);
    job.wrap = TextWrapping { max_width: ui.available_width(), max_rows: VERDICT_ROWS, ..TextWrapping::default() };
    ui.fonts_mut(|fonts| fonts.layout_job(job))
}

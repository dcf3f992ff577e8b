//! The panel for fits: values of parameters with which the formula comes near to measured reflectance, or its picture
//! to another picture.
//!
//! What is fitted and how is known in `fit`. A fit runs on threads of its own, and so does reading its data.

mod actions;
mod choices;
mod data;
mod result;
mod sketch;
mod work;

use crate::fit::directions::{LARGEST_ANGLE, PAIR_ANGLES, PAIR_COUNTS, USUAL_PAIRS};
use crate::fit::metric::{METRICS, Metric};
use crate::fit::request::FittedOwners;
use crate::fit::solve::FitOptions;
use crate::lang::display_text::{many_lines, one_line};
use crate::preview::app::comparison::{PAIRS, PaneMode, SNAPSHOTS};
use crate::preview::app::panel_sizes::{remember, wanted_size};
use crate::preview::app::theme::main_button;
use crate::preview::latest::LatestWorker;
use crate::preview::workshop::Workshop;
use crate::scene::{BodyId, LightId};
use crate::trace::MAX_PASSES;
use crate::user_data::settings::{PanelSide, PanelSizes};
use crate::workspace::OwnerId;
use choices::FreeChoices;
use data::{FittingData, compared};
use egui::{
    Align, CentralPanel, ComboBox, DragValue, Frame, Grid, Id, Label, Layout, Margin, Panel, ProgressBar, RichText, ScrollArea,
    Ui,
};
use result::{FittingResult, FittingSide};
use sketch::FittingSketch;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use work::{FittingSettings, FittingTask, RunningFit};

/// The least height of the panel, in points.
const LEAST_HEIGHT: f32 = 200.0;
/// The width of what is chosen beside the page, in points.
const CONTROLS_WIDTH: f32 = 178.0;
/// In less room than this, in points, choices and page are below each other.
const NARROW_PANEL: f32 = 440.0;
/// The width of the names of the pages, in points.
const PAGES_WIDTH: f32 = 330.0;
/// The most starts of a fit.
const MOST_STARTS: u32 = 1000;

/// What the panel shows beside the choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FittingPage {
    /// What may move.
    Free,
    /// The table of the result.
    Result,
    /// The data, before and after.
    Chart,
}

/// What the user wants.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FittingOrder {
    ChooseData,
    Begin,
    Cancel,
    Set(FittingSide),
    Look(PaneMode),
}

/// The panel.
pub(super) struct FittingPanel {
    /// Whether it is open.
    pub(super) open: bool,
    body: Option<BodyId>,
    light: Option<LightId>,
    reader: LatestWorker<PathBuf, Result<FittingData, String>>,
    data: Option<Arc<FittingData>>,
    choices: FreeChoices,
    metric: Metric,
    starts: u32,
    /// At how many pairs of directions a measured material is compared.
    directions: usize,
    /// Up to which angle from the normal, in degrees.
    within: u32,
    /// How many passes a picture is the mean of; none: as many as the picture in view.
    passes: Option<u32>,
    running: Option<RunningFit>,
    /// Why there is no data or no result, for the user.
    trouble: Option<String>,
    result: Option<FittingResult>,
    page: FittingPage,
    sketch: FittingSketch,
    /// The snapshot of the picture before values were applied.
    slot: Option<usize>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl FittingPanel {
    /// The panel. `wake` wakes the window.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let wake: Arc<dyn Fn() + Send + Sync> = Arc::new(wake);
        let (of_reader, of_sketch) = (Arc::clone(&wake), Arc::clone(&wake));
        Self {
            open: false,
            body: None,
            light: None,
            reader: LatestWorker::new(|path: PathBuf| FittingData::read(&path), move || of_reader()),
            data: None,
            choices: FreeChoices::default(),
            metric: METRICS[0],
            starts: FitOptions::default().starts,
            directions: USUAL_PAIRS,
            within: LARGEST_ANGLE as u32,
            passes: None,
            running: None,
            trouble: None,
            result: None,
            page: FittingPage::Free,
            sketch: FittingSketch::new(move || of_sketch()),
            slot: None,
            wake,
        }
    }

    /// Reads what is fitted to, in the background.
    pub(super) fn read(&mut self, path: &Path) {
        self.open = true;
        self.trouble = None;
        self.reader.ask(path.to_owned());
    }

    /// The file of the data.
    fn data_file(&self) -> Option<&Path> {
        self.data.as_ref().map(|data| data.path.as_path())
    }

    /// The body and the light whose values are fitted.
    fn owners(&self) -> FittedOwners {
        FittedOwners { body: self.body.map(OwnerId::Body), light: self.light.map(OwnerId::Light) }
    }

    fn is_picture(&self) -> bool {
        self.data.as_ref().is_some_and(|data| data.is_picture())
    }

    /// Takes what was read and what was fitted, and the present formula and values.
    fn follow(&mut self, workshop: &Workshop, selected: OwnerId) {
        if let Some(read) = self.reader.take() {
            match read {
                Ok(data) => {
                    (self.data, self.trouble) = (Some(Arc::new(data)), None);
                    // An earlier result is of other data.
                    (self.result, self.page) = (None, FittingPage::Free);
                }
                // The data before stay.
                Err(why) => self.trouble = Some(many_lines(&why)),
            }
        }
        if let Some(running) = &self.running {
            running.set_waiting(workshop.held().is_some() || workshop.moving().is_some());
            if let Some(answer) = running.take() {
                match answer {
                    Ok(found) => {
                        self.result = Some(FittingResult::new(&running.task, found));
                        self.page = FittingPage::Result;
                    }
                    Err(why) => self.trouble = Some(many_lines(&why)),
                }
                self.running = None;
            }
        }
        match selected {
            OwnerId::Body(body) => self.body = Some(body),
            OwnerId::Light(light) => self.light = Some(light),
            OwnerId::Global => {}
        }
        let scene = workshop.scene();
        self.body = self.body.filter(|body| body.index() < scene.bodies.len()).or_else(|| scene.body_ids().next());
        self.light = self.light.filter(|light| light.index() < scene.lights.len()).or_else(|| scene.light_ids().next());
        self.choices.follow(workshop.formula(), workshop.values(), self.owners(), self.is_picture());
    }

    /// Begins a fit, or notes why it cannot.
    fn begin(&mut self, workshop: &Workshop, formula: &str) {
        let Some(data) = &self.data else { return };
        let (scene, passes) = (workshop.scene(), self.passes.unwrap_or_else(|| workshop.samples()));
        let body = self.body.map(|body| format!(" with {}", one_line(&scene.body(body).name))).unwrap_or_default();
        let described = format!("{formula}{body}, fitted to {}", data.name());
        let (directions, within) = (self.directions, self.within);
        let settings = FittingSettings { metric: self.metric, starts: self.starts, directions, within, passes };
        let free = self.choices.free(workshop.values());
        if let Some(fixed) = free.iter().find(|free| free.range.is_some_and(|[low, high]| low >= high)) {
            let name = &workshop.formula().parameter(fixed.parameter).name;
            self.trouble = Some(format!("The bounds of {name} are one number: give it a range, or take its mark away"));
            return;
        }
        let task = FittingTask::new(workshop, self.owners(), data, &free, settings, described);
        match task.and_then(|task| RunningFit::start(task, &self.wake)) {
            Ok(running) => (self.running, self.trouble) = (Some(running), None),
            Err(why) => self.trouble = Some(many_lines(&why)),
        }
    }

    /// Draws the panel below the picture, at most so high. `mode` is what the pane of the picture shows.
    fn ui(
        &mut self,
        ui: &mut Ui,
        (workshop, mode): (&Workshop, PaneMode),
        most: f32,
        sizes: &mut PanelSizes,
    ) -> Vec<FittingOrder> {
        let mut orders = Vec::new();
        let most = most.min(0.62 * ui.available_height()).max(LEAST_HEIGHT);
        let id = Id::new("fitting");
        let size = wanted_size(ui.ctx(), id, PanelSide::Fitting, sizes);
        let panel = Panel::bottom(id).resizable(true).default_size(size);
        panel.size_range(LEAST_HEIGHT..=most).show(ui, |ui| {
            let is_narrow = ui.available_width() < NARROW_PANEL;
            self.header_ui(ui, workshop, is_narrow);
            ui.add_space(2.0);
            if is_narrow {
                self.narrow_ui(ui, workshop, mode, &mut orders);
                return;
            }
            let side = Panel::left("fitting controls").resizable(false).exact_size(CONTROLS_WIDTH);
            side.frame(Frame::NONE.inner_margin(Margin { left: 0, right: 8, top: 4, bottom: 0 })).show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.controls_ui(ui, workshop, &mut orders));
            });
            let page = Frame::NONE.inner_margin(Margin { left: 8, right: 0, top: 2, bottom: 0 });
            CentralPanel::default().frame(page).show(ui, |ui| self.page_ui(ui, workshop, mode, &mut orders));
        });
        remember(ui.ctx(), id, PanelSide::Fitting, sizes);
        orders
    }

    /// Draws choices and page below each other, where there is no room for both side by side.
    fn narrow_ui(&mut self, ui: &mut Ui, workshop: &Workshop, mode: PaneMode, orders: &mut Vec<FittingOrder>) {
        if self.page != FittingPage::Free && self.result.is_some() {
            return self.page_ui(ui, workshop, mode, orders);
        }
        ScrollArea::both().auto_shrink(false).show(ui, |ui| {
            self.controls_ui(ui, workshop, orders);
            ui.separator();
            self.trouble_ui(ui);
            self.choices.ui(ui, workshop.values());
        });
    }

    /// Draws the title, the choice of the page, and the button that closes the panel.
    fn header_ui(&mut self, ui: &mut Ui, workshop: &Workshop, is_narrow: bool) {
        ui.horizontal(|ui| {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.small_button("×").on_hover_text("Close the panel; a fit that runs goes on").clicked() {
                    self.open = false;
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    let title = match self.body {
                        Some(body) => format!("Fit {} to data", one_line(&workshop.scene().body(body).name)),
                        None => "Fit to data".to_owned(),
                    };
                    let about = "Which body: select another one in the list of parameters or in the picture";
                    let rest = if is_narrow { 0.0 } else { PAGES_WIDTH };
                    ui.scope(|ui| {
                        ui.set_max_width((ui.available_width() - rest).max(40.0));
                        ui.add(Label::new(RichText::new(title).strong()).truncate()).on_hover_text(about);
                    });
                    if !is_narrow {
                        ui.separator();
                        self.pages_ui(ui);
                    }
                });
            });
        });
        if is_narrow {
            ui.horizontal_wrapped(|ui| self.pages_ui(ui));
        }
    }

    /// Draws the choice of the page.
    fn pages_ui(&mut self, ui: &mut Ui) {
        for (page, name) in
            [(FittingPage::Free, "What may move"), (FittingPage::Result, "Result"), (FittingPage::Chart, "Before and after")]
        {
            let can = page == FittingPage::Free || self.result.is_some();
            if ui.add_enabled(can, egui::Button::selectable(self.page == page, name)).clicked() {
                self.page = page;
            }
        }
    }

    /// Draws the data, how they are compared, and the button that begins a fit or its progress.
    fn controls_ui(&mut self, ui: &mut Ui, workshop: &Workshop, orders: &mut Vec<FittingOrder>) {
        let is_running = self.running.is_some();
        let about = "Measured reflectance (.binary of MERL, .bsdf of RGL, .csv), or a picture of this scene (.exr, .png, .bmp)";
        let choose = ui.add_enabled(!is_running, egui::Button::new("Choose data…")).on_hover_text(about);
        if choose.clicked() {
            orders.push(FittingOrder::ChooseData);
        }
        match &self.data {
            _ if self.reader.is_busy() => {
                ui.weak("Reading…");
            }
            Some(data) => {
                let path = one_line(&data.path.display().to_string());
                ui.add(Label::new(RichText::new(data.name()).strong()).truncate()).on_hover_text(path);
                ui.add(Label::new(RichText::new(data.about()).small().weak()).wrap());
            }
            None => {
                ui.add(Label::new(RichText::new("No data yet").small().weak()).wrap());
            }
        }
        ui.add_space(4.0);
        ui.add_enabled_ui(!is_running, |ui| self.settings_ui(ui, workshop));
        ui.add_space(6.0);
        match &self.running {
            Some(running) => progress_ui(ui, running, orders),
            None => {
                let can = self.data.is_some() && !self.reader.is_busy();
                let button = ui.add_enabled(can, main_button(ui, "Start fit"));
                let button = button.on_hover_text("Look for the values that come nearest to the data");
                if button.on_disabled_hover_text("Choose data first").clicked() {
                    orders.push(FittingOrder::Begin);
                }
            }
        }
    }

    /// Draws how the data are compared.
    fn settings_ui(&mut self, ui: &mut Ui, workshop: &Workshop) {
        let is_picture = self.is_picture();
        Grid::new("fitting settings").num_columns(2).show(ui, |ui| {
            ui.label("Compare");
            let combo = ComboBox::from_id_salt("fitting metric").width(104.0).selected_text(compared(self.metric, is_picture));
            combo.show_ui(ui, |ui| {
                for metric in METRICS {
                    ui.selectable_value(&mut self.metric, metric, compared(metric, is_picture)).on_hover_text(metric.doc);
                }
            });
            ui.end_row();
            let about =
                "The values at hand, and others spread over the bounds: a search can end in a minimum that is not the lowest";
            ui.label("Starts").on_hover_text(about);
            ui.add(DragValue::new(&mut self.starts).range(1..=MOST_STARTS).speed(0.1).update_while_editing(false));
            ui.end_row();
            if self.data.as_ref().is_some_and(|data| data.is_material()) {
                ui.label("Directions").on_hover_text("At how many pairs of directions the formula and the material are compared");
                ui.add(DragValue::new(&mut self.directions).range(PAIR_COUNTS).speed(100).update_while_editing(false));
                ui.end_row();
                ui.label("Within").on_hover_text("Up to this angle from the normal; beyond it, measured data are not reliable");
                ui.add(DragValue::new(&mut self.within).range(PAIR_ANGLES).speed(0.2).suffix("°").update_while_editing(false));
                ui.end_row();
            }
            if is_picture {
                ui.label("Passes").on_hover_text("The picture that is compared is the mean of this many passes");
                let mut passes = self.passes.unwrap_or_else(|| workshop.samples());
                let field = DragValue::new(&mut passes).range(1..=MAX_PASSES).speed(0.1).update_while_editing(false);
                if ui.add(field).changed() {
                    self.passes = Some(passes);
                }
                ui.end_row();
            }
        });
    }

    /// Draws the page, below what is wrong.
    fn page_ui(&mut self, ui: &mut Ui, workshop: &Workshop, mode: PaneMode, orders: &mut Vec<FittingOrder>) {
        self.trouble_ui(ui);
        match (self.page, &self.result) {
            (FittingPage::Result, Some(result)) => {
                result_buttons_ui(ui, workshop, result, (self.slot, mode), orders);
                result.ui(ui, workshop);
            }
            (FittingPage::Chart, Some(result)) => self.sketch.ui(ui, &result.chart),
            (FittingPage::Free, _) | (_, None) => {
                ScrollArea::both().auto_shrink(false).show(ui, |ui| self.choices.ui(ui, workshop.values()));
            }
        }
    }

    /// Draws what is wrong.
    fn trouble_ui(&self, ui: &mut Ui) {
        if let Some(trouble) = &self.trouble {
            ui.add(Label::new(RichText::new(trouble).color(ui.visuals().error_fg_color)).wrap());
            ui.add_space(4.0);
        }
    }

    /// The result, for tests.
    #[cfg(test)]
    pub(super) fn result_sentences(&self) -> Option<&[String]> {
        self.result.as_ref().map(FittingResult::sentences)
    }

    /// Whether nothing is read, fitted or drawn, for tests.
    #[cfg(test)]
    pub(super) fn is_at_rest(&self) -> bool {
        let is_drawn = self.page != FittingPage::Chart || self.sketch.is_drawn();
        self.running.is_none() && !self.reader.is_busy() && is_drawn
    }

    /// Lets a parameter move, for tests.
    #[cfg(test)]
    pub(super) fn free(&mut self, owner: &str, parameter: &str) {
        self.choices.choose(owner, parameter);
    }

    /// How much of a fit that runs is done, for tests.
    #[cfg(test)]
    pub(super) fn share(&self) -> Option<f64> {
        self.running.as_ref().map(|running| running.state().share)
    }

    /// What is wrong, for tests.
    #[cfg(test)]
    pub(super) fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }
}

/// Draws how far a fit is, and the button that ends it.
fn progress_ui(ui: &mut Ui, running: &RunningFit, orders: &mut Vec<FittingOrder>) {
    let state = running.state();
    let words = match state.residual {
        Some(residual) => format!("Fitting: residual {residual:.2e}"),
        None if running.task.data.is_picture() => "Tracing…".to_owned(),
        None => "Preparing…".to_owned(),
    };
    ui.label(RichText::new(words).small());
    ui.add(ProgressBar::new(state.share as f32).desired_height(8.0));
    let is_ending = running.is_cancelled();
    let name = if is_ending { "Ending…" } else { "Cancel" };
    let button = ui.add_enabled(!is_ending, egui::Button::new(name));
    if button.on_hover_text("End the fit, and keep the best values so far").clicked() {
        orders.push(FittingOrder::Cancel);
    }
}

/// Draws the buttons that set values, and those that compare the picture before with the present one.
fn result_buttons_ui(
    ui: &mut Ui,
    workshop: &Workshop,
    result: &FittingResult,
    (slot, mode): (Option<usize>, PaneMode),
    orders: &mut Vec<FittingOrder>,
) {
    ui.horizontal_wrapped(|ui| {
        for (side, name, about) in [
            (FittingSide::After, "Apply", "Set the values that were found, as one step of undo"),
            (FittingSide::Before, "Revert", "Set the values that the fit began with, as one step of undo"),
        ] {
            let can = !result.is_at(side, workshop);
            let button = if side == FittingSide::After { main_button(ui, name) } else { egui::Button::new(name) };
            let button = ui.add_enabled(can, button).on_hover_text(about);
            if button.on_disabled_hover_text("The values are set").clicked() {
                orders.push(FittingOrder::Set(side));
            }
        }
        let Some(slot) = slot.filter(|slot| workshop.snapshot(*slot).is_some()) else { return };
        let Some(pair) = PAIRS.get(slot) else { return };
        ui.separator();
        let kept = format!("The picture before is {} of the menu Compare", SNAPSHOTS[slot]);
        for (choice, name) in
            [(PaneMode::Snapshot(slot), "Before"), (PaneMode::Current, "Now"), (PaneMode::Split(*pair), "Side by side")]
        {
            if ui.selectable_label(mode == choice, name).on_hover_text(&kept).clicked() {
                orders.push(FittingOrder::Look(choice));
            }
        }
    });
    ui.add_space(2.0);
}

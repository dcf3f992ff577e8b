//! Where the instruments are: below the picture, at its right, or over it as a small window.

use crate::preview::app::Action;
use crate::preview::app::instruments::InstrumentPanel;
use crate::preview::app::panel_sizes::{remember, wanted_size};
use crate::preview::workshop::Workshop;
use crate::user_data::settings::{InstrumentDock, PanelSide, PanelSizes};
use crate::workspace::OwnerId;
use egui::containers::menu::MenuButton;
use egui::{Button, CentralPanel, Context, Frame, Id, Margin, Panel, Rect, ScrollArea, Ui, Window, vec2};

/// The least height of the panel below the picture, in points.
const LEAST_HEIGHT: f32 = 180.0;
/// The least width of the panel at the right of the picture, and of the picture then, in points.
const LEAST_WIDTH: f32 = 220.0;
const LEAST_PICTURE_WIDTH: f32 = 150.0;
/// At least this wide, choices and models have a column each.
const TWO_COLUMNS: f32 = 360.0;
/// The most of the height that choices above the chart take.
const MOST_CHOICES: f32 = 0.45;
/// The width of the choices beside the chart, in points.
const CONTROLS_WIDTH: f32 = 178.0;
/// The distance of the window over the picture from the corner where it appears, in points.
const FROM_CORNER: f32 = 8.0;

impl InstrumentPanel {
    /// Takes the current values, and draws the panel below the picture or at its right. `selected` is the owner whose
    /// values are in view. `beside` is the width that the picture and the panel at its right have together,
    /// and `most` the greatest height of the panel below it.
    pub(in crate::preview::app) fn ui(
        &mut self,
        ui: &mut Ui,
        (workshop, (selected, formula)): (&Workshop, (OwnerId, &str)),
        (beside, most): (f32, f32),
        sizes: &mut PanelSizes,
        actions: &mut Vec<Action>,
    ) {
        if !self.open {
            return;
        }
        self.follow(workshop, selected, formula);
        match self.dock_within(beside) {
            InstrumentDock::Below => self.below_ui(ui, (workshop, fits_right(beside)), most, (sizes, actions)),
            InstrumentDock::Right => self.right_ui(ui, workshop, sizes, actions),
            InstrumentDock::Over => {}
        }
    }

    /// Where the panel is, if picture and panel have this width together: not at the right if that is too narrow.
    pub(in crate::preview::app) fn dock_within(&self, width: f32) -> InstrumentDock {
        if self.dock == InstrumentDock::Right && !fits_right(width) { InstrumentDock::Below } else { self.dock }
    }

    /// Draws the panel below the picture: choices at the left of the chart. `fits_right` says whether it could be at
    /// the right of the picture, and `most` how high it is at most.
    fn below_ui(
        &mut self,
        ui: &mut Ui,
        (workshop, fits_right): (&Workshop, bool),
        most: f32,
        (sizes, actions): (&mut PanelSizes, &mut Vec<Action>),
    ) {
        let room = ui.available_height();
        let most = most.min(0.62 * room).max(LEAST_HEIGHT);
        let id = Id::new("instruments");
        let size = wanted_size(ui.ctx(), id, PanelSide::Instruments, sizes);
        let panel = Panel::bottom(id).resizable(true).default_size(size);
        panel.size_range(LEAST_HEIGHT..=most).show(ui, |ui| {
            self.header_ui(ui, workshop, fits_right);
            ui.horizontal_wrapped(|ui| self.controls.views_ui(ui));
            ui.add_space(2.0);
            let side = Panel::left("instrument controls").resizable(false).exact_size(CONTROLS_WIDTH);
            side.frame(Frame::NONE.inner_margin(Margin { left: 0, right: 8, top: 4, bottom: 0 })).show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    self.choices_ui(ui);
                    ui.separator();
                    self.models_ui(ui, actions);
                });
            });
            CentralPanel::default()
                .frame(Frame::NONE.inner_margin(Margin { left: 8, right: 0, top: 2, bottom: 0 }))
                .show(ui, |ui| self.chart_ui(ui));
        });
        remember(ui.ctx(), id, PanelSide::Instruments, sizes);
    }

    /// Draws the panel at the right of the picture: choices above the chart.
    fn right_ui(&mut self, ui: &mut Ui, workshop: &Workshop, sizes: &mut PanelSizes, actions: &mut Vec<Action>) {
        let most = (ui.available_width() - LEAST_PICTURE_WIDTH).max(LEAST_WIDTH);
        let id = Id::new("instruments at the right");
        let size = wanted_size(ui.ctx(), id, PanelSide::InstrumentsAtRight, sizes);
        let panel = Panel::right(id).resizable(true).default_size(size);
        panel.size_range(LEAST_WIDTH..=most).show(ui, |ui| {
            self.header_ui(ui, workshop, true);
            ui.horizontal_wrapped(|ui| self.controls.views_ui(ui));
            ui.separator();
            self.scrolled_choices_ui(ui, actions);
            ui.separator();
            self.chart_ui(ui);
        });
        remember(ui.ctx(), id, PanelSide::InstrumentsAtRight, sizes);
    }

    /// Draws choices in the scrolled part of a column.
    fn scrolled_choices_ui(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        let choices = ScrollArea::vertical().auto_shrink([false, true]).max_height(MOST_CHOICES * ui.available_height());
        choices.show(ui, |ui| {
            if ui.available_width() < TWO_COLUMNS {
                self.choices_ui(ui);
                ui.separator();
                return self.models_ui(ui, actions);
            }
            ui.columns(2, |columns| {
                self.choices_ui(&mut columns[0]);
                self.models_ui(&mut columns[1], actions);
            });
        });
    }

    /// Takes the current values, and draws the panel over the picture, which has this area. It appears in the lower
    /// right corner. See [`ui`](Self::ui).
    pub(in crate::preview::app) fn over_ui(
        &mut self,
        context: &Context,
        (workshop, (selected, formula)): (&Workshop, (OwnerId, &str)),
        area: Rect,
        sizes: &mut PanelSizes,
        actions: &mut Vec<Action>,
    ) {
        if !self.open || self.dock != InstrumentDock::Over {
            self.was_over = false;
            return;
        }
        if !std::mem::replace(&mut self.was_over, true) {
            // The picture takes the room that the panel leaves in the next frame.
            return context.request_repaint();
        }
        self.follow(workshop, selected, formula);
        let wanted = [PanelSide::InstrumentsOverWidth, PanelSide::InstrumentsOverHeight].map(|side| sizes.get(side));
        let most = (area.size() - vec2(2.0, 2.0) * FROM_CORNER).max(vec2(LEAST_WIDTH, LEAST_HEIGHT));
        let corner = area.right_bottom() - vec2(FROM_CORNER, FROM_CORNER);
        let window = Window::new("Instruments").id(Id::new("instruments over the picture")).title_bar(false);
        let window = window.pivot(egui::Align2::RIGHT_BOTTOM).default_pos(corner).constrain_to(area);
        let window = window.default_size(wanted).min_size([LEAST_WIDTH, LEAST_HEIGHT]).max_size(most);
        window.show(context, |ui| {
            // A window that is smaller than the picture has the size that the user gave it.
            let size = ui.available_size();
            if size.x < most.x {
                sizes.set(PanelSide::InstrumentsOverWidth, size.x);
            }
            if size.y < most.y {
                sizes.set(PanelSide::InstrumentsOverHeight, size.y);
            }
            self.header_ui(ui, workshop, fits_right(area.width()));
            ui.horizontal_wrapped(|ui| self.controls.views_ui(ui));
            // Most of the window is for the chart.
            egui::CollapsingHeader::new("Choices").show(ui, |ui| self.scrolled_choices_ui(ui, actions));
            self.chart_ui(ui);
        });
    }

    /// Draws the menu that moves the panel. `fits_right` says whether there is room at the right of the picture.
    pub(super) fn place_menu(&mut self, ui: &mut Ui, fits_right: bool) {
        let (menu, _) = MenuButton::from_button(Button::new("Place").small()).ui(ui, |ui| {
            for (dock, name) in [
                (InstrumentDock::Below, "Below the picture"),
                (InstrumentDock::Right, "At the right of the picture"),
                (InstrumentDock::Over, "Over the picture"),
            ] {
                let can_move = fits_right || dock != InstrumentDock::Right;
                let entry = ui.add_enabled(can_move, egui::RadioButton::new(self.dock == dock, name));
                let why = "There is no room at the right of the picture: make the window wider, or a panel narrower";
                if entry.on_disabled_hover_text(why).clicked() {
                    self.dock = dock;
                    ui.close();
                }
            }
        });
        menu.on_hover_text("Where the instruments are");
    }
}

/// Whether there is room for the panel at the right of the picture, if both have this width together.
fn fits_right(width: f32) -> bool {
    width >= LEAST_WIDTH + LEAST_PICTURE_WIDTH
}

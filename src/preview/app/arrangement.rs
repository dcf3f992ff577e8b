//! Where the panels of the window are: texts at the left, parameters at the right, and the inspector, the instruments
//! and the panel for fits around the picture. What is in them is known in their own modules.
//!
//! Panels below the picture are as wide as the picture. Where that is too narrow for them, they are below the texts,
//! too.

use crate::preview::app::panel_sizes::{remember, wanted_size};
use crate::preview::app::{Action, App};
use crate::user_data::settings::{InstrumentDock, PanelSide, PanelSizes};
use crate::workspace::OwnerId;
use egui::{Id, Panel, Ui};

/// Windows narrower than this, in points, get narrower panels: otherwise there would be no room for the picture.
const NARROW: f32 = 860.0;

/// The least widths of the panels and of the picture between them, in points.
const LEAST_TEXTS: f32 = 220.0;
const LEAST_PARAMETERS: f32 = 240.0;
const LEAST_PICTURE: f32 = 160.0;

/// The least height of the picture above other panels, in points.
const LEAST_PICTURE_HEIGHT: f32 = 220.0;
/// The least height of each panel below the picture if there are several, in points.
const LEAST_BELOW_HEIGHT: f32 = 200.0;

/// Panels that are less wide than this, in points, are below the texts, too.
const LEAST_BELOW: f32 = 430.0;

/// The widths of the panels at the sides.
struct SidePanels {
    /// Whether the window is narrow. It has panels of its own then, so the others keep their width until there is room
    /// again.
    is_narrow: bool,
    texts: f32,
    parameters: f32,
}

impl SidePanels {
    fn new(ui: &Ui, sizes: &PanelSizes) -> Self {
        let is_narrow = ui.ctx().content_rect().width() < NARROW;
        if is_narrow {
            return Self { is_narrow, texts: 260.0, parameters: 250.0 };
        }
        let width = |side: PanelSide| wanted_size(ui.ctx(), Self::id(side, is_narrow), side, sizes);
        Self { is_narrow, texts: width(PanelSide::Texts), parameters: width(PanelSide::Parameters) }
    }

    fn id(side: PanelSide, is_narrow: bool) -> Id {
        Id::new((side.key(), is_narrow))
    }

    /// Notes the width of a panel that the user has dragged.
    fn remember(&self, ui: &Ui, side: PanelSide, sizes: &mut PanelSizes) {
        if !self.is_narrow {
            remember(ui.ctx(), Self::id(side, self.is_narrow), side, sizes);
        }
    }
}

impl App {
    /// Draws the panels around the picture, which gets the rest. Keys do nothing while something `waits` for them.
    pub(super) fn panels_ui(&mut self, ui: &mut Ui, waits: bool, actions: &mut Vec<Action>) {
        let mut sizes = self.user_state.settings.window.panels;
        let sides = SidePanels::new(ui, &sizes);
        self.inspector.set_passes(self.workshop.renderer().passes());
        let width = |is_open: bool, width: f32| if is_open { width } else { 0.0 };
        let sides_width = width(self.panels.texts, sides.texts) + width(self.panels.parameters, sides.parameters);
        let picture = ui.available_width() - sides_width;
        if self.panels.texts && picture < LEAST_BELOW && self.has_panel_below(picture) {
            self.parameters_ui(ui, &sides, LEAST_TEXTS, (&mut sizes, actions));
            self.around_picture_ui(ui, (waits, picture), &mut sizes, actions);
            self.texts_panel_ui(ui, &sides, 0.0, (&mut sizes, actions));
        } else {
            self.texts_panel_ui(ui, &sides, width(self.panels.parameters, LEAST_PARAMETERS), (&mut sizes, actions));
            self.parameters_ui(ui, &sides, 0.0, (&mut sizes, actions));
            self.around_picture_ui(ui, (waits, ui.available_width()), &mut sizes, actions);
        }
        self.user_state.settings.window.panels = sizes;
    }

    /// Whether a panel is below the picture, if picture and instruments have this width together.
    fn has_panel_below(&self, width: f32) -> bool {
        let dock = Some(self.instruments.dock_within(width)).filter(|_| self.instruments.open);
        dock != Some(InstrumentDock::Right) && (self.inspector.open || self.fitting.open || dock == Some(InstrumentDock::Below))
    }

    /// Draws the texts. The picture keeps some room, and so does a panel that follows, if it needs `others`.
    fn texts_panel_ui(
        &mut self,
        ui: &mut Ui,
        sides: &SidePanels,
        others: f32,
        (sizes, actions): (&mut PanelSizes, &mut Vec<Action>),
    ) {
        if !self.panels.texts {
            return;
        }
        let most = ui.available_width() - LEAST_PICTURE - others;
        let panel = Panel::left(SidePanels::id(PanelSide::Texts, sides.is_narrow)).resizable(true).default_size(sides.texts);
        panel.size_range(LEAST_TEXTS..=most.max(LEAST_TEXTS)).show(ui, |ui| self.texts_ui(ui, actions));
        sides.remember(ui, PanelSide::Texts, sizes);
    }

    /// Draws the parameters. The picture keeps some room, and so does a panel that follows, if it needs `others`.
    fn parameters_ui(
        &mut self,
        ui: &mut Ui,
        sides: &SidePanels,
        others: f32,
        (sizes, actions): (&mut PanelSizes, &mut Vec<Action>),
    ) {
        if !self.panels.parameters {
            return;
        }
        let most = (ui.available_width() - LEAST_PICTURE - others).max(LEAST_PARAMETERS);
        let id = SidePanels::id(PanelSide::Parameters, sides.is_narrow);
        let panel = Panel::right(id).resizable(true).default_size(sides.parameters);
        panel.size_range(LEAST_PARAMETERS..=most).show(ui, |ui| {
            let shared = (self.pane.selected(), &mut *sizes);
            self.parameters.ui(ui, &mut self.workshop, &mut self.materials, shared);
        });
        sides.remember(ui, PanelSide::Parameters, sizes);
        actions.append(&mut self.materials.take_actions());
        actions.append(&mut self.parameters.take_actions());
    }

    /// Draws the inspector, the instruments and the panel for fits. Keys do nothing while something `waits` for them.
    /// `beside` is the width that the picture and the instruments at its right have together.
    fn around_picture_ui(
        &mut self,
        ui: &mut Ui,
        (waits, beside): (bool, f32),
        sizes: &mut PanelSizes,
        actions: &mut Vec<Action>,
    ) {
        self.follow_sensitivity(ui, waits);
        // At the right, the instruments have the height of all panels together.
        let dock = self.instruments.dock_within(beside);
        if dock == InstrumentDock::Right {
            self.instruments_ui(ui, (beside, ui.available_height()), sizes, actions);
        }
        let is_open = [self.inspector.open, self.instruments.open && dock == InstrumentDock::Below, self.fitting.open];
        let shown = self.below.shown(ui, is_open);
        self.below.tabs_ui(ui, is_open);
        let most = |ui: &Ui, panel: usize| {
            let others = shown[panel + 1..].iter().filter(|is_shown| **is_shown).count();
            ui.available_height() - LEAST_PICTURE_HEIGHT - others as f32 * LEAST_BELOW_HEIGHT
        };
        let of = self.parameter_of_interest();
        if shown[INSPECTOR] {
            self.inspector.ui(ui, &self.workshop, (of, most(ui, INSPECTOR)), sizes);
        }
        if let Some(place) = self.inspector.take_place() {
            self.parameters.select(OwnerId::Body(place.body));
            self.instruments.look_at(place);
        }
        if shown[INSTRUMENTS] {
            self.instruments_ui(ui, (beside, most(ui, INSTRUMENTS)), sizes, actions);
        }
        self.fitting_ui(ui, (shown[FITTING], most(ui, FITTING)), sizes);
    }
}

/// The indices of the panels below the picture, in their order from below.
const INSPECTOR: usize = 0;
const INSTRUMENTS: usize = 1;
const FITTING: usize = 2;

/// Their names.
const BELOW: [&str; 3] = ["Pixel inspector", "Instruments", "Fit"];

/// Which of the panels below the picture are in view. Where there is no room for all that are open, it is one of them,
/// and tabs choose it.
#[derive(Default)]
pub(super) struct PanelsBelow {
    /// Which were open in the last frame.
    was_open: [bool; BELOW.len()],
    /// The one that was opened or chosen last.
    chosen: usize,
}

impl PanelsBelow {
    /// Whether there are tabs.
    fn has_tabs(ui: &Ui, is_open: [bool; BELOW.len()]) -> bool {
        let count = is_open.into_iter().filter(|is_open| *is_open).count();
        count > 1 && ui.available_height() < LEAST_PICTURE_HEIGHT + count as f32 * LEAST_BELOW_HEIGHT
    }

    /// Which of the open panels are shown.
    fn shown(&mut self, ui: &Ui, is_open: [bool; BELOW.len()]) -> [bool; BELOW.len()] {
        let opened = (0..BELOW.len()).find(|index| is_open[*index] && !self.was_open[*index]);
        self.chosen = opened.unwrap_or(self.chosen);
        if !is_open[self.chosen] {
            self.chosen = is_open.iter().position(|is_open| *is_open).unwrap_or(self.chosen);
        }
        self.was_open = is_open;
        if Self::has_tabs(ui, is_open) { std::array::from_fn(|index| index == self.chosen) } else { is_open }
    }

    /// Draws the tabs, if there are any.
    fn tabs_ui(&mut self, ui: &mut Ui, is_open: [bool; BELOW.len()]) {
        if !Self::has_tabs(ui, is_open) {
            return;
        }
        Panel::bottom("tabs of panels").show(ui, |ui| {
            ui.horizontal(|ui| {
                for (index, name) in BELOW.iter().enumerate().filter(|(index, _)| is_open[*index]) {
                    let tab = ui.selectable_label(index == self.chosen, *name);
                    if tab.on_hover_text("There is no room for all open panels: this one is shown").clicked() {
                        self.chosen = index;
                    }
                }
            });
        });
    }
}

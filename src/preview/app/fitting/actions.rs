//! What the app does for fits: their panel, the dialog for data, and the values that they found.

use crate::preview::app::App;
use crate::preview::app::comparison::{PaneMode, SNAPSHOTS};
use crate::preview::app::fitting::FittingOrder;
use crate::preview::app::fitting::result::FittingSide;
use crate::preview::app::tab::TextTab;
use crate::user_data::settings::PanelSizes;
use crate::workspace::Location;
use egui::Ui;
use std::path::Path;

impl App {
    /// Follows a fit that runs, draws the panel for fits if it is open, and does what the user wants there.
    pub(in crate::preview::app) fn fitting_ui(&mut self, ui: &mut Ui, (is_shown, most): (bool, f32), sizes: &mut PanelSizes) {
        self.fitting.follow(&self.workshop, self.parameters.selected());
        if !is_shown {
            return;
        }
        for order in self.fitting.ui(ui, (&self.workshop, self.pane.mode), most, sizes) {
            match order {
                FittingOrder::ChooseData => {
                    let near = self.fitting.data_file().or_else(|| self.session.as_ref().and_then(Location::file));
                    let near = near.and_then(Path::parent).map(Path::to_owned);
                    self.dialogs.files.choose_fitting_data(near.as_deref());
                }
                FittingOrder::Begin => {
                    let name = self.documents[TextTab::Formula].short_name();
                    self.fitting.begin(&self.workshop, &name);
                }
                FittingOrder::Cancel => self.fitting.running.iter().for_each(|running| running.cancel()),
                FittingOrder::Set(side) => self.set_fitted(side),
                FittingOrder::Look(mode) => self.pane.mode = mode,
            }
            ui.ctx().request_repaint();
        }
    }

    /// Sets the fitted values to those before or after the fit. The picture before is kept, so that it can be compared.
    fn set_fitted(&mut self, side: FittingSide) {
        let Some(result) = &self.fitting.result else { return };
        if side == FittingSide::After {
            // A snapshot of the user is left alone where there is room beside it.
            let is_free = |slot: &usize| self.workshop.snapshot(*slot).is_none();
            let slot = self.fitting.slot.or_else(|| (0..SNAPSHOTS.len()).find(is_free)).unwrap_or(0);
            self.workshop.take_snapshot(slot);
            self.fitting.slot = Some(slot);
        }
        self.pane.mode = PaneMode::Current;
        let missing = result.set(side, &mut self.workshop);
        let what = if side == FittingSide::After { "the fitted values are set" } else { "the values before the fit are set" };
        self.confirm(match missing {
            0 => what.to_owned(),
            1 => format!("{what}; 1 parameter of them exists no longer"),
            _ => format!("{what}; {missing} parameters of them exist no longer"),
        });
    }
}

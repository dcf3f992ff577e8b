//! What the app does for the instruments: their panel, files of charts and of measured materials.

use crate::lang::diagnostic::Diagnostic;
use crate::lang::display_text::one_line;
use crate::measured::{MeasuredMaterial, kept};
use crate::plot::ChartTheme;
use crate::preview::app::file_dialogs::Suggestion;
use crate::preview::app::instruments::sheet;
use crate::preview::app::jobs::JobResult;
use crate::preview::app::tab::TextTab;
use crate::preview::app::{Action, App, InstrumentAction};
use crate::user_data::settings::PanelSizes;
use crate::workspace::{Location, measured_files};
use egui::{Context, Ui};
use std::path::{Path, PathBuf};
use std::sync::Arc;

impl App {
    /// Performs an action on the instruments.
    pub(in crate::preview::app) fn perform_on_instruments(&mut self, action: InstrumentAction) {
        match action {
            InstrumentAction::ShowSaveDialog => self.show_save_chart_dialog(),
            InstrumentAction::Save(path) => self.save_chart(path),
            InstrumentAction::ShowMeasuredDialog => self.show_measured_dialog(),
            InstrumentAction::AddMeasured(path) => self.add_measured(path),
            InstrumentAction::Compare(path) => self.compare_measured(&path),
            InstrumentAction::ShowSensitivity(of) => self.show_sensitivity(of),
        }
    }

    /// The name of the formula, without a suffix.
    fn formula_name(&self) -> String {
        let name = match self.documents[TextTab::Formula].location() {
            Some(Location::File(path)) => path.file_stem().map(|stem| stem.to_string_lossy().into_owned()),
            Some(Location::Preset(name)) => Some(name.clone()),
            None => None,
        };
        one_line(&name.unwrap_or_else(|| "formula".to_owned()))
    }

    /// Draws the instruments, if they are open. `beside` is the width that the picture and the panel at its right have
    /// together, and `most` the greatest height of the panel below it.
    pub(in crate::preview::app) fn instruments_ui(
        &mut self,
        ui: &mut Ui,
        (beside, most): (f32, f32),
        sizes: &mut PanelSizes,
        actions: &mut Vec<Action>,
    ) {
        if !self.instruments.open {
            return;
        }
        let name = self.formula_name();
        let of = (self.parameters.selected(), name.as_str());
        self.instruments.compared = self.compared_material().map(Path::to_owned);
        self.instruments.ui(ui, (&self.workshop, of), (beside, most), sizes, actions);
        let window = &mut self.user_state.settings.window;
        (window.instruments, window.instruments_at) = (self.instruments.open, self.instruments.dock);
    }

    /// Draws the instruments over the picture, if they are there.
    pub(in crate::preview::app) fn instruments_over_ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        self.instruments.compared = self.compared_material().map(Path::to_owned);
        if !self.instruments.open {
            return;
        }
        let name = self.formula_name();
        let of = (self.parameters.selected(), name.as_str());
        let window = &mut self.user_state.settings.window;
        self.instruments.over_ui(context, (&self.workshop, of), self.pane.area(), &mut window.panels, actions);
        (window.instruments, window.instruments_at) = (self.instruments.open, self.instruments.dock);
    }

    /// Shows the dialog that saves the chart, with a name of the formula and the view.
    pub(in crate::preview::app) fn show_save_chart_dialog(&mut self) {
        let name = format!("{}-{}.png", self.formula_name(), self.instruments.controls.view().name);
        let file = self.documents[TextTab::Formula].location().and_then(Location::file);
        let folder = file.or_else(|| self.session.as_ref().and_then(Location::file)).and_then(Path::parent);
        let folder = folder.filter(|folder| !folder.as_os_str().is_empty()).map(Path::to_owned);
        self.dialogs.files.save_chart(&Suggestion { name, folder });
    }

    /// Saves the chart of the present values, in the background.
    pub(in crate::preview::app) fn save_chart(&mut self, path: PathBuf) {
        let selected = self.parameters.selected();
        let name = self.formula_name();
        self.instruments.follow(&self.workshop, selected, &name);
        let mut request = self.instruments.request([0, 0], 1.0, ChartTheme::Light);
        request.settings.is_draft = false;
        if let Some(subject) = &self.instruments.subject {
            request.settings.subtitle = format!("{name} of {}", subject.about);
        }
        self.run_job(move || {
            Some(match sheet::save(&request, &path) {
                Ok(()) => JobResult::Done(format!("saved {}", path.display())),
                Err(error) => JobResult::ChartNotSaved(error),
            })
        });
    }

    /// Shows the dialog that chooses a measured material.
    pub(in crate::preview::app) fn show_measured_dialog(&mut self) {
        let last = self.instruments.overlays.last_measured();
        let near = last.or_else(|| self.session.as_ref().and_then(Location::file)).and_then(Path::parent);
        self.dialogs.files.choose_measured(near.map(Path::to_owned).as_deref());
    }

    /// Reads a measured material in the background.
    pub(in crate::preview::app) fn add_measured(&mut self, path: PathBuf) {
        self.log.add(format!("reading {}", path.display()));
        self.run_job(move || {
            let read = measured_files::load(&path).and_then(|number| {
                let material = kept::numbered(number).map(Arc::clone);
                material.ok_or_else(|| Diagnostic::error(format!("`{}` was not kept", path.display())))
            });
            Some(JobResult::MeasuredRead(path, read))
        });
    }

    /// Shows a measured material that was read beside the formula, or says why there is none.
    pub(in crate::preview::app) fn take_measured(&mut self, path: &Path, read: Result<Arc<MeasuredMaterial>, Diagnostic>) {
        match read {
            Ok(material) => {
                self.instruments.overlays.add(path, material);
                self.instruments.overlays_version += 1;
                self.instruments.open = true;
                self.confirm(format!("{} is shown beside the formula", path.display()));
            }
            Err(error) => {
                let help: String = error.hints().iter().map(|hint| format!("\n{hint}")).collect();
                self.dialogs.show_message("The measured material was not read", format!("{}{help}", error.message()));
            }
        }
    }
}

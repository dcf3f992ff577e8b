//! The dialog for settings, which new sessions start with.

use crate::lang::types::Type;
use crate::lang::variables::Predefined;
use crate::preview::app::dialogs::modal;
use crate::trace::{MAX_DEPTH, MAX_SIDE};
use crate::user_data::settings::Settings;
use egui::{Context, DragValue, Grid, ScrollArea, Slider, Ui};

/// The dialog.
#[derive(Default)]
pub(super) struct SettingsDialog {
    /// The edited settings, while the dialog is open.
    edited: Option<Settings>,
}

impl SettingsDialog {
    /// Opens the dialog.
    pub(super) fn open(&mut self, settings: &Settings) {
        self.edited = Some(settings.clone());
    }

    /// Draws the dialog. Returns the settings when the user saves them.
    pub(super) fn ui(&mut self, context: &Context) -> Option<Settings> {
        let edited = self.edited.as_mut()?;
        let shown = modal(context, "Settings", |ui| {
            ui.set_width(430.0);
            ui.weak("Settings for new sessions. Existing sessions keep their own.");
            ui.add_space(8.0);
            ScrollArea::vertical().max_height(460.0).show(ui, |ui| fields(ui, edited));
            ui.add_space(10.0);
            let mut choice = None;
            ui.horizontal(|ui| {
                for (name, keep) in [("Save", true), ("Cancel", false)] {
                    if ui.button(name).clicked() {
                        choice = Some(keep);
                    }
                }
                if ui.button("Defaults").on_hover_text("Restore the original settings, except those of the window").clicked() {
                    *edited = Settings { window: edited.window, startup: edited.startup.clone(), ..Settings::default() };
                }
            });
            choice
        });
        let closed = shown.should_close();
        match shown.inner {
            Some(true) => self.edited.take().map(|edited| edited.within_ranges()),
            Some(false) => {
                self.edited = None;
                None
            }
            None => {
                if closed {
                    self.edited = None;
                }
                None
            }
        }
    }
}

fn fields(ui: &mut Ui, settings: &mut Settings) {
    Grid::new("settings").num_columns(2).spacing([24.0, 6.0]).show(ui, |ui| {
        ui.label("Shadow rays");
        ui.checkbox(&mut settings.shadows, "");
        ui.end_row();
        ui.label("Depth").on_hover_text("The longest path of rays; 1 means no reflection and no refraction");
        ui.add(Slider::new(&mut settings.depth, 1..=MAX_DEPTH));
        ui.end_row();
        ui.label("Picture");
        ui.horizontal(|ui| {
            let [width, height] = &mut settings.size;
            ui.add(DragValue::new(width).range(1..=MAX_SIDE));
            ui.label("×");
            ui.add(DragValue::new(height).range(1..=MAX_SIDE));
        });
        ui.end_row();
        ui.label("Refractive index").on_hover_text("For bodies without one of their own");
        ui.add(DragValue::new(&mut settings.default_index).range(0.1..=10.0).speed(0.01));
        ui.end_row();
        for parameter in Predefined::ALL.iter().copied() {
            ui.label(parameter.name()).on_hover_text(parameter.doc());
            let mut value = [0.0; 3];
            settings.defaults.of(parameter).iter().zip(&mut value).for_each(|(from, to)| *to = *from);
            let before = value;
            ui.horizontal(|ui| match parameter.ty() {
                Type::Vector => {
                    for component in &mut value {
                        ui.add(DragValue::new(component).speed(0.01).max_decimals(3));
                    }
                }
                Type::Scalar | Type::Truth => {
                    ui.add(DragValue::new(&mut value[0]).speed(0.01).max_decimals(3));
                }
            });
            if value != before {
                // `set` keeps the value within its range.
                settings.defaults.set(parameter, value);
            }
            ui.end_row();
        }
    });
}

//! The dialog for settings: those of the program, and the default values of new sessions.

use crate::backends::CHOICES;
use crate::lang::types::Type;
use crate::lang::variables::Predefined;
use crate::picture::Transfer;
use crate::preview::app::colours::{picker_ui, swatch_button};
use crate::preview::app::modal::modal;
use crate::preview::app::number_field::{NUMBER_WIDTH, component_ui};
use crate::preview::app::theme;
use crate::trace::{MAX_DEPTH, MAX_PASSES, MAX_SIDE};
use crate::user_data::settings::{MEMORY, SCALES, Settings, ThemeSetting};
use crate::workspace::{FileKind, Location, presets};
use egui::{ComboBox, Context, DragValue, Grid, Popup, PopupCloseBehavior, RichText, ScrollArea, Slider, Ui};

/// The dialog.
#[derive(Default)]
pub(super) struct SettingsDialog {
    /// The edited settings, while the dialog is open.
    edited: Option<Settings>,
    page: Page,
    /// The open session, which can become the startup session.
    session: Option<Location>,
}

/// A page of the dialog.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Page {
    #[default]
    Program,
    NewSessions,
    DefaultValues,
}

impl Page {
    const ALL: [(Page, &str); 3] =
        [(Page::Program, "Program"), (Page::NewSessions, "New sessions"), (Page::DefaultValues, "Default values")];
}

/// The height of the pages, in points, if there is room.
const PAGE_HEIGHT: f32 = 340.0;

impl SettingsDialog {
    /// Opens the dialog.
    pub(super) fn open(&mut self, settings: &Settings, session: Option<&Location>) {
        self.edited = Some(settings.clone());
        self.session = session.cloned();
    }

    /// Draws the dialog. Returns the settings when the user saves them.
    pub(super) fn ui(&mut self, context: &Context) -> Option<Settings> {
        let Self { edited, page, session } = self;
        let settings = edited.as_mut()?;
        let height = PAGE_HEIGHT.min(context.content_rect().height() - 190.0).max(80.0);
        let shown = modal(context, "Settings", |ui| {
            ui.set_width(470.0);
            ui.horizontal(|ui| {
                for (other, name) in Page::ALL {
                    ui.selectable_value(page, other, name);
                }
            });
            ui.separator();
            let pages = ScrollArea::vertical().id_salt(page.name()).auto_shrink(false).max_height(height);
            pages.min_scrolled_height(height).show(ui, |ui| match page {
                Page::Program => program_ui(ui, settings, session.as_ref()),
                Page::NewSessions => new_sessions_ui(ui, settings),
                Page::DefaultValues => default_values_ui(ui, settings),
            });
            ui.separator();
            buttons_ui(ui, settings)
        });
        let closed = shown.should_close();
        match shown.inner {
            Some(true) => edited.take().map(|edited| edited.within_ranges()),
            Some(false) => {
                *edited = None;
                None
            }
            None => {
                if closed {
                    *edited = None;
                }
                None
            }
        }
    }
}

impl Page {
    fn name(self) -> &'static str {
        Page::ALL.into_iter().find(|(page, _)| *page == self).map_or("", |(_, name)| name)
    }
}

/// Draws the buttons. Returns whether to save, if the dialog ends.
fn buttons_ui(ui: &mut Ui, settings: &mut Settings) -> Option<bool> {
    let mut ends = None;
    ui.horizontal(|ui| {
        if ui.add(theme::main_button(ui, "Save")).clicked() {
            ends = Some(true);
        }
        if ui.button("Cancel").clicked() {
            ends = Some(false);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let defaults = ui.button("Restore defaults");
            if defaults.on_hover_text("All pages as they were at the first start, but for the startup session").clicked() {
                let usual = Settings::default();
                let window = crate::user_data::settings::WindowSettings {
                    log: settings.window.log,
                    size: settings.window.size,
                    panels: settings.window.panels,
                    scale: settings.window.scale,
                    ..usual.window
                };
                *settings = Settings { window, startup: settings.startup.clone(), ..usual };
            }
        });
    });
    ends
}

/// A grid of settings with their names.
fn grid(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    Grid::new(name).num_columns(2).min_col_width(150.0).spacing([20.0, 9.0]).show(ui, content);
}

fn program_ui(ui: &mut Ui, settings: &mut Settings, session: Option<&Location>) {
    grid(ui, "program", |ui| {
        ui.label("Theme");
        ui.horizontal(|ui| {
            for theme in ThemeSetting::ALL {
                ui.radio_value(&mut settings.window.theme, theme, theme::setting_name(theme));
            }
        });
        ui.end_row();
        ui.label("Scale").on_hover_text("The size of texts and widgets");
        let mut percent = 100.0 * settings.window.scale;
        if ui.add(Slider::new(&mut percent, 100.0 * SCALES[0]..=100.0 * SCALES[1]).step_by(5.0).suffix(" %")).changed() {
            settings.window.scale = percent / 100.0;
        }
        ui.end_row();
        ui.label("Startup session").on_hover_text("What opens if the program starts without a session");
        startup_ui(ui, settings, session);
        ui.end_row();
        ui.label("Gallery");
        ui.checkbox(&mut settings.window.gallery, "Show it at the start");
        ui.end_row();
        ui.label("Texts");
        ui.checkbox(&mut settings.window.apply_as_you_type, "Apply as you type");
        ui.end_row();
        ui.label("Backend").on_hover_text("How formulas are evaluated");
        ui.horizontal(|ui| {
            for backend in CHOICES.iter().copied() {
                ui.radio_value(&mut settings.backend, backend, backend.title);
            }
        });
        ui.end_row();
        ui.label("Memory of a picture").on_hover_text("A picture that needs more is not made, and a message says so");
        memory_ui(ui, settings);
        ui.end_row();
        ui.label("Passes of a picture").on_hover_text("For sessions without `samples`: more passes make smoother pictures");
        ui.add(DragValue::new(&mut settings.samples).range(1..=MAX_PASSES).speed(0.2).update_while_editing(false));
        ui.end_row();
    });
}

/// Draws the list of sessions that can be opened at the start.
fn startup_ui(ui: &mut Ui, settings: &mut Settings, session: Option<&Location>) {
    let shown = crate::lang::display_text::one_line(&settings.startup.to_string());
    ComboBox::from_id_salt("startup").selected_text(shown).width(260.0).truncate().show_ui(ui, |ui| {
        let open = session.cloned().map(|location| match location {
            Location::File(path) => Location::File(std::path::absolute(&path).unwrap_or(path)),
            Location::Preset(name) => Location::Preset(name),
        });
        let files = [Some(settings.startup.clone()), open].into_iter().flatten();
        let presets = presets::names(FileKind::Session).map(|name| Location::Preset(name.to_owned()));
        let mut all: Vec<Location> = files.chain(presets).collect();
        all.sort_by_key(|location| location.file().is_none());
        all.dedup();
        let mut offered: Vec<&Location> = Vec::new();
        for location in &all {
            if !offered.contains(&location) {
                offered.push(location);
                let name = crate::lang::display_text::one_line(&location.to_string());
                ui.selectable_value(&mut settings.startup, location.clone(), name);
            }
        }
    });
}

/// Draws the memory limit.
fn memory_ui(ui: &mut Ui, settings: &mut Settings) {
    ui.horizontal(|ui| {
        let mut limited = settings.memory.is_some();
        ui.radio_value(&mut limited, false, "Half of what is free");
        ui.radio_value(&mut limited, true, "At most");
        if limited != settings.memory.is_some() {
            settings.memory = limited.then_some(2048);
        }
        let mut memory = settings.memory.unwrap_or(2048);
        let field =
            DragValue::new(&mut memory).range(MEMORY[0]..=MEMORY[1]).speed(16.0).suffix(" MiB").update_while_editing(false);
        if ui.add_enabled(limited, field).changed() {
            settings.memory = Some(memory);
        }
    });
}

fn new_sessions_ui(ui: &mut Ui, settings: &mut Settings) {
    ui.weak("New sessions start with these. Existing sessions keep their own.");
    ui.add_space(6.0);
    grid(ui, "new sessions", |ui| {
        ui.label("Transfer").on_hover_text("How linear colours are stored and displayed");
        ui.horizontal(|ui| {
            ui.radio_value(&mut settings.transfer, Transfer::Srgb, "sRGB").on_hover_text("As screens expect it");
            ui.radio_value(&mut settings.transfer, Transfer::Linear, "Linear").on_hover_text("As in the thesis");
        });
        ui.end_row();
        ui.label("Picture");
        ui.horizontal(|ui| {
            let [width, height] = &mut settings.size;
            ui.add(DragValue::new(width).range(1..=MAX_SIDE));
            ui.label("×");
            ui.add(DragValue::new(height).range(1..=MAX_SIDE));
            ui.label("pixels");
        });
        ui.end_row();
        ui.label("Depth").on_hover_text("The longest path of rays; 1 means no reflection and no refraction");
        ui.add(Slider::new(&mut settings.depth, 1..=MAX_DEPTH));
        ui.end_row();
        ui.label("Shadows");
        ui.checkbox(&mut settings.shadows, "Send shadow rays");
        ui.end_row();
        ui.label("Refractive index").on_hover_text("For bodies without one of their own");
        ui.add(DragValue::new(&mut settings.default_index).range(0.1..=10.0).speed(0.01));
        ui.end_row();
    });
}

fn default_values_ui(ui: &mut Ui, settings: &mut Settings) {
    ui.weak("The values that parameters have in new sessions, each from 0 to 1.");
    ui.add_space(6.0);
    let transfer = settings.transfer;
    Grid::new("default values").num_columns(3).spacing([16.0, 9.0]).show(ui, |ui| {
        for parameter in Predefined::ALL.iter().copied() {
            ui.label(RichText::new(parameter.name()).strong());
            let (doc, _) = parameter.doc().split_once(';').unwrap_or((parameter.doc(), ""));
            ui.label(doc);
            let mut value = [0.0; 3];
            settings.defaults.of(parameter).iter().zip(&mut value).for_each(|(from, to)| *to = *from);
            let before = value;
            ui.push_id(parameter.name(), |ui| {
                ui.horizontal(|ui| match parameter.ty() {
                    Type::Vector => {
                        let swatch = swatch_button(ui, transfer, value);
                        let picker = Popup::menu(&swatch).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
                        picker.show(|ui| {
                            if let Some((picked, _)) = picker_ui(ui, transfer, value) {
                                value = picked;
                            }
                        });
                    }
                    Type::Scalar | Type::Truth | Type::Texture => {
                        ui.add(Slider::new(&mut value[0], 0.0..=1.0).show_value(false));
                        component_ui(ui, NUMBER_WIDTH, &mut value[0]);
                    }
                });
            });
            if value != before {
                // `set` keeps the value within its range.
                settings.defaults.set(parameter, value);
            }
            ui.end_row();
        }
    });
}

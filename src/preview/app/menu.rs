//! The menus.

use crate::backends::CHOICES;
use crate::lang::display_text::one_line;
use crate::preview::app::action::{PanelId, PictureOverlay, shortcut_of};
use crate::preview::app::comparison::{GAINS, PAIRS, Pair, PaneMode, SNAPSHOTS, obstacle};
use crate::preview::app::menu_entries::{check_entry, entry, entry_if};
use crate::preview::app::pane::Zoom;
use crate::preview::app::scene_menu;
use crate::preview::app::tab::TextTab;
use crate::preview::app::thumbnail_key::ThumbnailKey;
use crate::preview::app::{Action, App, InstrumentAction, SceneAction, theme};
use crate::preview::editor::{PossibleEdits, edit_menu_ui};
use crate::user_data::settings::ThemeSetting;
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::presets::{self, Preset};
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{
    Align, Button, Label, Layout, MenuBar, PopupCloseBehavior, Rect, RichText, ScrollArea, Sense, Ui, UiBuilder, Vec2,
    WidgetInfo, WidgetType, vec2,
};

/// The height that a menu needs beside its entries: the menu bar, and margins.
const EXTRA_HEIGHT: f32 = 70.0;

/// A menu that stays open while the user changes something in it.
fn persistent_menu(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    MenuButton::new(name).config(config).ui(ui, |ui| scrolled(ui, content));
}

/// Content that scrolls if it is higher than the window.
fn scrolled(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    let room = (ui.ctx().content_rect().height() - EXTRA_HEIGHT).max(60.0);
    ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, content);
}

/// Draws the menu bar.
pub(super) fn bar(app: &mut App, ui: &mut Ui, actions: &mut Vec<Action>) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| scrolled(ui, |ui| file(ui, app, actions)));
        ui.menu_button("Edit", |ui| {
            let texts = app.panels.texts;
            let can = if texts { app.editor.possible_edits(&app.documents[app.tab]) } else { PossibleEdits::default() };
            actions.extend(edit_menu_ui(ui, can).map(Action::EditText));
            ui.separator();
            let [undo, redo] = app.undo_and_redo_names();
            for (name, verb, action) in [(undo, "Undo", Action::Undo), (redo, "Redo", Action::Redo)] {
                let title = name.as_ref().map_or_else(|| format!("{verb} value change"), |of| format!("{verb} change of {of}"));
                entry_if(ui, name.is_some(), &one_line(&title), action, actions);
            }
            ui.separator();
            entry(ui, &format!("Apply {}", app.tab.kind().noun()), Action::Apply, actions);
            let mut typing = app.user_state.settings.window.apply_as_you_type;
            if ui.checkbox(&mut typing, "Apply as you type").changed() {
                actions.push(Action::ApplyAsYouType(typing));
            }
        });
        ui.menu_button("Scene", |ui| scrolled(ui, |ui| scene_menu::entries(ui, app, actions)));
        persistent_menu(ui, "Picture", |ui| picture(ui, app, actions));
        persistent_menu(ui, "Compare", |ui| compare(ui, app, actions));
        persistent_menu(ui, "View", |ui| view(ui, app, actions));
        ui.menu_button("Help", |ui| {
            entry(ui, "Gallery", Action::ShowGallery, actions);
            entry(ui, "Language reference", Action::TogglePanel(PanelId::Reference), actions);
            entry(ui, "Shortcuts", Action::ShowShortcuts, actions);
        });
    });
}

fn file(ui: &mut Ui, app: &mut App, actions: &mut Vec<Action>) {
    for kind in TextTab::ALL.map(TextTab::kind) {
        entry(ui, &format!("New {}", kind.noun()), Action::New(kind), actions);
    }
    entry(ui, "New session", Action::NewSession, actions);
    ui.separator();
    entry(ui, "Gallery", Action::ShowGallery, actions);
    for kind in [FileKind::Formula, FileKind::Scene, FileKind::Session] {
        entry(ui, &format!("Open {}…", kind.noun()), Action::ShowOpenDialog(kind), actions);
    }
    for kind in [FileKind::Formula, FileKind::Scene, FileKind::Session] {
        ui.menu_button(format!("Built-in {}s", kind.noun()), |ui| {
            scrolled(ui, |ui| {
                for preset in presets::all(kind) {
                    preset_ui(ui, app, kind, preset, actions);
                }
            });
        });
    }
    ui.menu_button("Recent", |ui| {
        let mut none = true;
        for kind in [FileKind::Session, FileKind::Formula, FileKind::Scene] {
            for path in app.user_state.recent(kind) {
                none = false;
                let name = one_line(&path.display().to_string());
                entry(ui, &name, Action::Open(kind, Location::File(path)), actions);
            }
        }
        if none {
            ui.weak("No files yet");
        }
    });
    ui.separator();
    let kind = app.tab.kind();
    entry(ui, &format!("Save {}", kind.noun()), Action::Save, actions);
    entry(ui, &format!("Save {} as…", kind.noun()), Action::ShowSaveDialog(kind), actions);
    entry(ui, "Save session", Action::SaveSession, actions);
    entry(ui, "Save session as…", Action::ShowSaveDialog(FileKind::Session), actions);
    entry(ui, "Save picture as…", Action::ShowSavePictureDialog, actions);
    entry(ui, "Copy picture", Action::CopyPicture, actions);
    entry(ui, "Use as startup session", Action::UseAsStartupSession, actions);
    entry(ui, "Settings…", Action::ShowSettings, actions);
    ui.separator();
    entry_if(ui, !app.user_state.draft_names().is_empty(), "Unsaved work of earlier runs…", Action::OfferDrafts, actions);
    entry(ui, "Quit", Action::Quit, actions);
}

/// An entry for a built-in file: a thumbnail, its name, and a line.
fn preset_ui(ui: &mut Ui, app: &mut App, kind: FileKind, preset: &Preset, actions: &mut Vec<Action>) {
    const SIZE: Vec2 = vec2(80.0, 60.0);
    let (rect, response) = ui.allocate_exact_size(vec2(360.0, SIZE.y + 6.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, preset.name));
    if response.hovered() {
        ui.painter().rect_filled(rect, 4.0, ui.visuals().widgets.hovered.weak_bg_fill);
    }
    let picture = Rect::from_min_size(rect.min + vec2(3.0, 3.0), SIZE);
    app.thumbnails.paint(ui, picture, &ThumbnailKey::preset(kind, preset.name));
    let texts = Rect::from_min_max(picture.right_top() + vec2(10.0, 6.0), rect.max - vec2(6.0, 2.0));
    let mut inner = ui.new_child(UiBuilder::new().max_rect(texts).layout(Layout::top_down(Align::LEFT)));
    inner.spacing_mut().item_spacing.y = 2.0;
    inner.add(Label::new(RichText::new(preset.name).strong()).selectable(false));
    inner.add(Label::new(RichText::new(preset.about).small()).selectable(false).wrap());
    if response.clicked() {
        actions.push(Action::Open(kind, Location::Preset(preset.name.to_owned())));
        ui.close();
    }
}

fn picture(ui: &mut Ui, app: &mut App, actions: &mut Vec<Action>) {
    let mut settings = app.workshop.settings();
    let before = settings;
    ui.horizontal(|ui| {
        ui.label("Size").on_hover_text("The size of the session's picture, in pixels");
        let [width, height] = &mut settings.size;
        ui.add(egui::DragValue::new(width).range(1..=crate::trace::MAX_SIDE).update_while_editing(false));
        ui.label("×");
        ui.add(egui::DragValue::new(height).range(1..=crate::trace::MAX_SIDE).update_while_editing(false));
    });
    ui.horizontal(|ui| {
        ui.label("Depth").on_hover_text("The longest path of rays; 1 means no reflection and no refraction");
        ui.add(egui::Slider::new(&mut settings.depth, 1..=crate::trace::MAX_DEPTH));
    });
    ui.horizontal(|ui| {
        ui.label("Passes").on_hover_text("The picture is the mean of its passes: more make smoother edges and softer shadows");
        let default = app.user_state.settings.samples;
        let mut passes = app.workshop.samples();
        let range = 1..=crate::trace::MAX_PASSES;
        if ui.add(egui::DragValue::new(&mut passes).range(range).speed(0.2).update_while_editing(false)).changed() {
            settings.samples = Some(passes);
        }
        let mut is_default = settings.samples.is_none();
        let about = format!("The session gives no number, so the picture has the {default} passes of the settings");
        if ui.checkbox(&mut is_default, format!("as in the settings ({default})")).on_hover_text(about).changed() {
            settings.samples = (!is_default).then_some(passes);
        }
    });
    ui.checkbox(&mut settings.shadows, "Shadow rays");
    ui.horizontal(|ui| {
        ui.label("Refractive index of bodies without their own");
        ui.add(egui::DragValue::new(&mut settings.default_index).range(0.1..=10.0).speed(0.01).update_while_editing(false));
    });
    if settings != before {
        // The widgets keep the values within their ranges.
        let _ = app.workshop.set_picture(settings);
    }
    ui.separator();
    zoom_entries(ui, app, actions);
    ui.separator();
    for backend in CHOICES.iter().copied() {
        if ui.radio(app.backend() == backend, backend.title).clicked() {
            actions.push(Action::SetBackend(backend));
        }
    }
}

/// The entries for how large the picture is.
fn zoom_entries(ui: &mut Ui, app: &App, actions: &mut Vec<Action>) {
    for (zoom, name, about) in [
        (Zoom::Fit, "Fit into the pane", "The whole picture in the size of the session, scaled to the pane"),
        (Zoom::ACTUAL, "Actual size", "One pixel of the screen for each pixel of the picture"),
        (Zoom::Pane, "As large as its pane", "The picture is made in the size of the pane. The session keeps its size"),
    ] {
        let action = Action::Zoom(zoom);
        let button = Button::selectable(app.pane.zoom == zoom, name).right_text(shortcut_of(&action, ui));
        if ui.add(button).on_hover_text(about).clicked() {
            actions.push(action);
        }
    }
    for (steps, name) in [(1, "Zoom in"), (-1, "Zoom out")] {
        entry(ui, name, Action::ZoomBy(steps), actions);
    }
}

fn compare(ui: &mut Ui, app: &mut App, actions: &mut Vec<Action>) {
    for (slot, name) in SNAPSHOTS.into_iter().enumerate() {
        entry(ui, &format!("Keep as {name}"), Action::TakeSnapshot(slot), actions);
        let is_taken = app.workshop.snapshot(slot).is_some();
        entry_if(ui, is_taken, &format!("Go back to {name}"), Action::RestoreSnapshot(slot), actions);
    }
    ui.separator();
    let mut chosen = ui.radio_value(&mut app.pane.mode, PaneMode::Current, "Current picture").clicked();
    for (slot, name) in SNAPSHOTS.into_iter().enumerate() {
        ui.add_enabled_ui(app.workshop.snapshot(slot).is_some(), |ui| {
            let mode = PaneMode::Snapshot(slot);
            chosen |= ui.radio_value(&mut app.pane.mode, mode, format!("{name} alone")).clicked();
        });
    }
    ui.separator();
    ui.weak("Side by side");
    for pair in PAIRS {
        chosen |= compare_entry(ui, app, pair, PaneMode::Split(pair), "|");
    }
    ui.separator();
    ui.weak("Difference");
    let gain = match app.pane.mode {
        PaneMode::Difference(_, gain) => gain,
        PaneMode::Current | PaneMode::Snapshot(_) | PaneMode::Sensitivity | PaneMode::Split(_) => GAINS[0],
    };
    for pair in PAIRS {
        chosen |= compare_entry(ui, app, pair, PaneMode::Difference(pair, gain), "−");
    }
    if let PaneMode::Difference(_, gain) = &mut app.pane.mode {
        ui.horizontal(|ui| {
            ui.label("Amplified");
            for choice in GAINS {
                chosen |= ui.selectable_value(gain, choice, format!("×{choice}")).clicked();
            }
        });
    }
    if chosen {
        ui.close();
    }
}

/// An entry that compares two pictures. Returns whether it was chosen.
fn compare_entry(ui: &mut Ui, app: &mut App, pair: Pair, mode: PaneMode, between: &str) -> bool {
    let obstacle = obstacle(pair, &app.workshop);
    let [one, other] = pair.map(|side| side.name());
    let radio = egui::RadioButton::new(app.pane.mode == mode, format!("{one} {between} {other}"));
    let response = ui.add_enabled(obstacle.is_none(), radio);
    let response = response.on_disabled_hover_text(obstacle.unwrap_or_default());
    if response.clicked() {
        app.pane.mode = mode;
    }
    response.clicked()
}

/// The entry that shows which pixels depend on the parameter that was moved last.
fn sensitivity_entry(ui: &mut Ui, app: &App, actions: &mut Vec<Action>) {
    let is_seen = app.pane.mode == PaneMode::Sensitivity;
    let Some(of) = app.parameter_of_interest() else { return };
    let (owner, id) = if is_seen { app.sensitivity.shown().unwrap_or(of) } else { of };
    let name = format!("Sensitivity to {}", one_line(&app.workshop.values().table().label(owner, id)));
    let action = Action::Instruments(InstrumentAction::ShowSensitivity((!is_seen).then_some((owner, id))));
    if check_entry(ui, is_seen, &name, action, actions) {
        // The menu would cover the legend.
        ui.close();
    }
}

fn view(ui: &mut Ui, app: &mut App, actions: &mut Vec<Action>) {
    let panels = app.panels;
    for (panel, name, seen) in [
        (PanelId::Texts, "Texts", panels.texts),
        (PanelId::Parameters, "Parameters", panels.parameters),
        (PanelId::Log, "Log", panels.log),
        (PanelId::Reference, "Language reference", panels.reference),
        (PanelId::Inspector, "Pixel inspector", app.inspector.open),
        (PanelId::Instruments, "Instruments", app.instruments.open),
        (PanelId::Fitting, "Fit to data", app.fitting.open),
    ] {
        check_entry(ui, seen, name, Action::TogglePanel(panel), actions);
    }
    ui.separator();
    for (overlay, name, seen) in [
        (PictureOverlay::Clipping, "Marks of clipped pixels", app.pane.clipping),
        (PictureOverlay::Histogram, "Histogram", app.pane.histogram),
    ] {
        check_entry(ui, seen, name, Action::ToggleOverlay(overlay), actions);
    }
    sensitivity_entry(ui, app, actions);
    check_entry(ui, app.hand.markers, "Markers in the picture", Action::Scene(SceneAction::ToggleMarkers), actions);
    ui.separator();
    zoom_entries(ui, app, actions);
    ui.separator();
    for theme in ThemeSetting::ALL {
        if ui.radio(app.user_state.settings.window.theme == theme, theme::setting_name(theme)).clicked() {
            actions.push(Action::SetTheme(theme));
        }
    }
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("Scale");
        for scale in [1.0, 1.25, 1.5, 2.0] {
            if ui.selectable_label(app.scale == scale, format!("{:.0} %", 100.0 * scale)).clicked() {
                actions.push(Action::SetScale(scale));
            }
        }
    });
}

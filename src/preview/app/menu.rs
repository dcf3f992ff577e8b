//! The menus.

use crate::backends::CHOICES;
use crate::lang::display_text::one_line;
use crate::preview::app::command::{Panel, shortcut_of};
use crate::preview::app::pane::{SNAPSHOTS, Seen};
use crate::preview::app::tab::TextTab;
use crate::preview::app::theme::Theme;
use crate::preview::app::{App, Command};
use crate::workspace::Location;
use crate::workspace::{FileKind, presets};
use egui::containers::menu::{MenuButton, MenuConfig};
use egui::{Button, MenuBar, PopupCloseBehavior, ScrollArea, Ui};

/// A menu entry with its shortcut.
fn entry(ui: &mut Ui, name: &str, command: Command, commands: &mut Vec<Command>) {
    entry_if(ui, true, name, command, commands);
}

fn entry_if(ui: &mut Ui, enabled: bool, name: &str, command: Command, commands: &mut Vec<Command>) {
    let button = Button::new(name).shortcut_text(shortcut_of(&command, ui));
    if ui.add_enabled(enabled, button).clicked() {
        commands.push(command);
        ui.close();
    }
}

/// The height that a menu needs beside its entries: the menu bar, and margins.
const BESIDE: f32 = 70.0;

/// A menu that stays open while the user changes something in it.
fn staying(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    let config = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    MenuButton::new(name).config(config).ui(ui, |ui| scrolled(ui, content));
}

/// Content that scrolls if it is higher than the window.
fn scrolled(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    let room = (ui.ctx().content_rect().height() - BESIDE).max(60.0);
    ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, content);
}

/// Draws the menu bar.
pub(super) fn bar(app: &mut App, ui: &mut Ui, commands: &mut Vec<Command>) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| scrolled(ui, |ui| file(ui, app, commands)));
        ui.menu_button("Edit", |ui| {
            let [undo, redo] = app.workshop.can_undo_and_redo();
            entry_if(ui, undo, "Undo value change", Command::Undo, commands);
            entry_if(ui, redo, "Redo value change", Command::Redo, commands);
            ui.separator();
            entry(ui, "Apply text", Command::Apply, commands);
            let mut typing = app.remembered.settings.window.apply_as_you_type;
            if ui.checkbox(&mut typing, "Apply as you type").changed() {
                commands.push(Command::ApplyAsYouType(typing));
            }
        });
        staying(ui, "Picture", |ui| picture(ui, app, commands));
        staying(ui, "Compare", |ui| compare(ui, app, commands));
        staying(ui, "View", |ui| view(ui, app, commands));
        ui.menu_button("Help", |ui| {
            entry(ui, "Reference of the language", Command::Toggle(Panel::Reference), commands);
            entry(ui, "Shortcuts", Command::ShowShortcuts, commands);
        });
    });
}

fn file(ui: &mut Ui, app: &App, commands: &mut Vec<Command>) {
    for kind in TextTab::ALL.map(TextTab::kind) {
        entry(ui, &format!("New {}", kind.noun()), Command::New(kind), commands);
    }
    entry(ui, "New session", Command::NewSession, commands);
    ui.separator();
    for kind in [FileKind::Formula, FileKind::Scene, FileKind::Session] {
        entry(ui, &format!("Open {}…", kind.noun()), Command::AskToOpen(kind), commands);
    }
    for kind in [FileKind::Formula, FileKind::Scene, FileKind::Session] {
        ui.menu_button(format!("Built-in {}s", kind.noun()), |ui| {
            for name in presets::names(kind) {
                entry(ui, name, Command::Open(kind, Location::Preset(name.to_owned())), commands);
            }
        });
    }
    ui.menu_button("Recent", |ui| {
        let mut none = true;
        for kind in [FileKind::Session, FileKind::Formula, FileKind::Scene] {
            for path in app.remembered.recent(kind) {
                none = false;
                let name = one_line(&path.display().to_string());
                entry(ui, &name, Command::Open(kind, Location::File(path)), commands);
            }
        }
        if none {
            ui.weak("No files yet");
        }
    });
    ui.separator();
    let kind = app.tab.kind();
    entry(ui, &format!("Save {}", kind.noun()), Command::Save, commands);
    entry(ui, &format!("Save {} as…", kind.noun()), Command::AskToSave(kind), commands);
    entry(ui, "Save session", Command::SaveSession, commands);
    entry(ui, "Save session as…", Command::AskToSave(FileKind::Session), commands);
    entry(ui, "Save picture as…", Command::AskToSavePicture, commands);
    entry(ui, "Copy picture", Command::CopyPicture, commands);
    entry(ui, "Start with this session", Command::StartWithThis, commands);
    entry(ui, "Settings…", Command::AskForSettings, commands);
    ui.separator();
    entry_if(ui, !app.remembered.left().is_empty(), "Unsaved work of last time…", Command::AskForLeft, commands);
    entry(ui, "Quit", Command::Quit, commands);
}

fn picture(ui: &mut Ui, app: &mut App, commands: &mut Vec<Command>) {
    let mut settings = app.workshop.settings();
    let before = settings;
    ui.checkbox(&mut app.pane.follows, "As large as its pane");
    ui.add_enabled_ui(!app.pane.follows, |ui| {
        ui.horizontal(|ui| {
            ui.label("Size");
            let [width, height] = &mut settings.size;
            ui.add(egui::DragValue::new(width).range(1..=crate::trace::MAX_SIDE).update_while_editing(false));
            ui.label("×");
            ui.add(egui::DragValue::new(height).range(1..=crate::trace::MAX_SIDE).update_while_editing(false));
        });
    });
    ui.horizontal(|ui| {
        ui.label("Depth").on_hover_text("How often rays are reflected or refracted; 1: not at all");
        ui.add(egui::Slider::new(&mut settings.depth, 1..=crate::trace::MAX_DEPTH));
    });
    ui.checkbox(&mut settings.shadows, "Shadow rays");
    ui.horizontal(|ui| {
        ui.label("Refractive index of bodies that give none");
        ui.add(egui::DragValue::new(&mut settings.default_index).range(0.1..=10.0).speed(0.01).update_while_editing(false));
    });
    ui.checkbox(&mut settings.srgb, "sRGB transfer").on_hover_text("Linear values through the sRGB curve; brighter on screens");
    if settings != before {
        // The widgets keep the values within their ranges.
        let _ = app.workshop.set_picture(settings);
    }
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("Zoom");
        for zoom in [1, 2, 4, 8, 16] {
            ui.selectable_value(&mut app.pane.zoom, zoom, format!("{zoom}×"));
        }
    });
    ui.separator();
    for backend in CHOICES {
        if ui.radio(app.backend() == backend, backend.title).clicked() {
            commands.push(Command::Evaluate(backend));
        }
    }
}

fn compare(ui: &mut Ui, app: &mut App, commands: &mut Vec<Command>) {
    for (place, name) in SNAPSHOTS.into_iter().enumerate() {
        entry(ui, &format!("Keep as {name}"), Command::Keep(place), commands);
        let kept = app.workshop.kept(place).is_some();
        entry_if(ui, kept, &format!("Go back to {name}"), Command::GoBackTo(place), commands);
    }
    ui.separator();
    ui.radio_value(&mut app.pane.seen, Seen::Now, "Picture as it is now");
    for (place, name) in SNAPSHOTS.into_iter().enumerate() {
        let kept = app.workshop.kept(place).is_some();
        ui.add_enabled_ui(kept, |ui| {
            ui.radio_value(&mut app.pane.seen, Seen::Kept(place), name);
            ui.radio_value(&mut app.pane.seen, Seen::Split(place), format!("{name} | now"));
        });
    }
}

fn view(ui: &mut Ui, app: &mut App, commands: &mut Vec<Command>) {
    let panels = app.panels;
    for (panel, name, seen) in [
        (Panel::Texts, "Texts", panels.texts),
        (Panel::Parameters, "Parameters", panels.parameters),
        (Panel::Log, "Log", panels.log),
        (Panel::Reference, "Reference of the language", panels.reference),
        (Panel::Inspector, "Pixel inspector", app.inspecting.open),
    ] {
        let mut seen = seen;
        if ui.checkbox(&mut seen, name).changed() {
            commands.push(Command::Toggle(panel));
        }
    }
    ui.separator();
    for theme in [Theme::Dark, Theme::Light] {
        if ui.radio(app.theme == theme, theme.name()).clicked() {
            commands.push(Command::Look(theme));
        }
    }
    ui.separator();
    ui.horizontal(|ui| {
        ui.label("Scale");
        for scale in [1.0, 1.25, 1.5, 2.0] {
            if ui.selectable_label(app.scale == scale, format!("{:.0} %", 100.0 * scale)).clicked() {
                commands.push(Command::Scale(scale));
            }
        }
    });
}

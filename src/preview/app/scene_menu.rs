//! The menu of the scene: what can be done with the selected body or light, what can be added, and views.

use crate::lang::display_text::one_line;
use crate::preview::app::menu_entries::{check_entry, entry, entry_if};
use crate::preview::app::scene_actions::{HandleTool, SceneAction, side_name};
use crate::preview::app::{Action, App};
use crate::scene::{LightKind, Shape, ViewSide};
use egui::Ui;

/// The keyword of meshes, whose files are chosen in a dialog.
const MESH: &str = "mesh";

/// The menu of the scene, also for a right click into the picture.
pub(super) fn entries(ui: &mut Ui, app: &App, actions: &mut Vec<Action>) {
    let act = |ui: &mut Ui, enabled: bool, name: &str, action: SceneAction, actions: &mut Vec<Action>| {
        entry_if(ui, enabled, &one_line(name), Action::Scene(action), actions);
    };
    let selected = app.selected_object();
    let name = selected.map_or_else(|| "the selected".to_owned(), |object| app.name_of(object));
    act(ui, selected.is_some(), &format!("Frame {name}"), SceneAction::Frame, actions);
    act(ui, selected.is_some(), &format!("Duplicate {name}"), SceneAction::Duplicate, actions);
    act(ui, selected.is_some(), &format!("Remove {name}"), SceneAction::Remove, actions);
    ui.separator();
    ui.menu_button("Add body", |ui| {
        for shape in Shape::SYNTAX.iter().filter(|shape| shape.keyword.word != MESH) {
            act(ui, true, &capitalised(shape.keyword.word), SceneAction::AddBody(shape.keyword.word), actions);
        }
        ui.separator();
        entry(ui, "Mesh…", Action::ShowMeshDialog, actions);
        act(ui, true, "Gem", SceneAction::AddBody(MESH), actions);
    });
    ui.menu_button("Add light", |ui| {
        for kind in LightKind::SYNTAX {
            let word = kind.keyword.word;
            let is_there = || app.workshop.scene().lights.iter().any(|light| light.kind.keyword().word == word);
            act(ui, !(kind.is_single && is_there()), &capitalised(word), SceneAction::AddLight(word), actions);
        }
    });
    ui.separator();
    act(ui, true, "Frame everything", SceneAction::FrameAll, actions);
    ui.menu_button("View from", |ui| {
        for side in ViewSide::ALL {
            act(ui, true, side_name(side), SceneAction::View(side), actions);
        }
    });
    act(ui, true, "Reset camera", SceneAction::ResetCamera, actions);
    ui.separator();
    ui.menu_button("Handles", |ui| {
        for tool in HandleTool::ALL {
            let action = Action::Scene(SceneAction::Handles(tool));
            if check_entry(ui, app.hand.tool() == tool, tool.name(), action, actions) {
                ui.close();
            }
        }
    });
    let markers = Action::Scene(SceneAction::ToggleMarkers);
    if check_entry(ui, app.hand.markers, "Markers in the picture", markers, actions) {
        ui.close();
    }
}

/// A word with a capital letter.
fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

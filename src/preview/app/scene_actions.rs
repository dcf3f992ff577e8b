//! The actions on the scene with their keys, and the help for the mouse in the picture. Menus offer the actions, and
//! the keys work while no text is edited.

use crate::scene::ViewSide;
use egui::{Key, KeyboardShortcut, Modifiers};

/// An action on the scene. Those without an object are for the selected body or light.
#[derive(Debug, Clone, PartialEq)]
pub enum SceneAction {
    /// See the selected body or light as large as possible; everything if nothing is selected.
    Frame,
    /// See everything as large as possible.
    FrameAll,
    /// View the scene from a side.
    View(ViewSide),
    /// Put the camera where the saved text has it.
    ResetCamera,
    /// Add a body whose shape has this keyword.
    AddBody(&'static str),
    /// Add a light whose kind has this keyword.
    AddLight(&'static str),
    /// Add a copy of the selected body or light.
    Duplicate,
    /// Remove the selected body or light.
    Remove,
    /// Show or hide the markers in the picture.
    ToggleMarkers,
}

/// The name of a side in menus.
pub(super) fn side_name(side: ViewSide) -> &'static str {
    match side {
        ViewSide::Front => "Front",
        ViewSide::Back => "Back",
        ViewSide::Right => "Right",
        ViewSide::Left => "Left",
        ViewSide::Top => "Top",
        ViewSide::Bottom => "Bottom",
    }
}

/// Every shortcut: its key, its action, and a description.
pub(super) fn scene_shortcuts() -> Vec<(KeyboardShortcut, SceneAction, &'static str)> {
    let plain = |key| KeyboardShortcut::new(Modifiers::NONE, key);
    let sides = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6].into_iter().zip(ViewSide::ALL);
    let about = |side| match side {
        ViewSide::Front => "View from the front",
        ViewSide::Back => "View from the back",
        ViewSide::Right => "View from the right",
        ViewSide::Left => "View from the left",
        ViewSide::Top => "View from above",
        ViewSide::Bottom => "View from below",
    };
    let mut all = vec![
        (plain(Key::F), SceneAction::Frame, "Frame the selected body or light"),
        (KeyboardShortcut::new(Modifiers::SHIFT, Key::F), SceneAction::FrameAll, "Frame everything"),
        (plain(Key::Home), SceneAction::ResetCamera, "Put the camera where the saved text has it"),
    ];
    all.extend(sides.map(|(key, side)| (plain(key), SceneAction::View(side), about(side))));
    all.extend([
        (KeyboardShortcut::new(Modifiers::COMMAND, Key::D), SceneAction::Duplicate, "Duplicate the selected body or light"),
        (plain(Key::Delete), SceneAction::Remove, "Remove the selected body or light"),
        (plain(Key::M), SceneAction::ToggleMarkers, "Show or hide the markers in the picture"),
    ]);
    all
}

/// What the mouse does in the picture, for the list of shortcuts.
pub(super) const MOUSE_HELP: [(&str, &str); 14] = [
    ("Click", "Select the body or the light under the pointer; the background selects the scene"),
    ("Drag", "Orbit about the point under the pointer; about the selected body over the background"),
    (
        "Drag the selected",
        "Move a body or a light parallel to the picture; hold X, Y or Z for an axis, or drag an arrow (a floor: only so)",
    ),
    ("Drag the square", "Change the radius of the selected sphere"),
    ("Middle drag", "Pan; also Shift + drag"),
    ("Right drag", "Go closer or back (dolly); also Ctrl + drag"),
    ("Shift + right drag", "Field of view; also Ctrl + Shift + drag"),
    ("Alt + drag", "Orbit, whatever is under the pointer"),
    ("Wheel", "Go closer or back"),
    ("Ctrl + wheel", "Zoom the picture"),
    ("Space + drag", "Move a picture that is larger than its pane"),
    ("Right click", "Menu of the scene"),
    ("Escape", "Give up a drag: everything is as before"),
    ("Arrow keys", "Orbit; with Shift pan; Page Up and Page Down go closer and back"),
];

//! The actions on the scene with their keys. Menus offer the actions, and the keys work while no text is edited.

use crate::preview::app::key_groups::{KeyGroup, Shortcut};
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
    /// Let the handles of what is selected do this.
    Handles(HandleTool),
}

/// Where a mesh that is added stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshSpot {
    /// The point of the image plane that shows where it stands.
    pub at: [f64; 2],
    /// Its place among those that are added together, from the left.
    pub rank: u32,
    /// How many are added together.
    pub count: u32,
}

impl MeshSpot {
    /// In the middle of the picture.
    pub(super) const MIDDLE: MeshSpot = MeshSpot { at: [0.0; 2], rank: 0, count: 1 };
}

/// What the handles over the picture do with the selected body or light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HandleTool {
    /// Arrows move it.
    #[default]
    Move,
    /// Rings turn it.
    Rotate,
    /// Handles along its own axes scale it.
    Scale,
}

impl HandleTool {
    /// Every tool, in the order of the keys.
    pub const ALL: [HandleTool; 3] = [HandleTool::Move, HandleTool::Rotate, HandleTool::Scale];

    /// The name in menus.
    pub(super) fn name(self) -> &'static str {
        match self {
            HandleTool::Move => "Move",
            HandleTool::Rotate => "Rotate",
            HandleTool::Scale => "Scale",
        }
    }
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

/// Every shortcut of an action on the scene.
pub(super) fn scene_shortcuts() -> Vec<Shortcut<SceneAction>> {
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
    let mut camera = vec![
        (plain(Key::F), SceneAction::Frame, "Frame the selected body or light"),
        (KeyboardShortcut::new(Modifiers::SHIFT, Key::F), SceneAction::FrameAll, "Frame everything"),
        (plain(Key::Home), SceneAction::ResetCamera, "Put the camera where the saved text has it"),
    ];
    camera.extend(sides.map(|(key, side)| (plain(key), SceneAction::View(side), about(side))));
    let handles = |tool| match tool {
        HandleTool::Move => (plain(Key::W), SceneAction::Handles(tool), "Handles that move the selected body or light"),
        HandleTool::Rotate => (plain(Key::E), SceneAction::Handles(tool), "Handles that rotate it"),
        HandleTool::Scale => (plain(Key::R), SceneAction::Handles(tool), "Handles that scale it"),
    };
    let mut scene: Vec<_> = HandleTool::ALL.map(handles).into();
    scene.extend([
        (KeyboardShortcut::new(Modifiers::COMMAND, Key::D), SceneAction::Duplicate, "Duplicate the selected body or light"),
        (plain(Key::Delete), SceneAction::Remove, "Remove the selected body or light"),
        (plain(Key::M), SceneAction::ToggleMarkers, "Show or hide the markers in the picture"),
    ]);
    Shortcut::all_of(KeyGroup::Camera, camera).chain(Shortcut::all_of(KeyGroup::Scene, scene)).collect()
}

//! The groups of keys, and the keys that are no shortcuts of actions: those of the mouse, of texts and of sliders.

use egui::KeyboardShortcut;

/// A group in the list of keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KeyGroup {
    /// Opening and saving.
    Files,
    /// Texts and undoing.
    Editing,
    /// How the picture is shown.
    Picture,
    /// Where the scene is seen from.
    Camera,
    /// Bodies and lights.
    Scene,
    /// Values.
    Sliders,
    /// Panels.
    Window,
}

impl KeyGroup {
    /// Every group, in the order of the list.
    pub(super) const ALL: [Self; 7] =
        [Self::Files, Self::Editing, Self::Sliders, Self::Window, Self::Picture, Self::Camera, Self::Scene];

    /// The heading of the group.
    pub(super) fn title(self) -> &'static str {
        match self {
            KeyGroup::Files => "Files",
            KeyGroup::Editing => "Editing",
            KeyGroup::Picture => "Picture",
            KeyGroup::Camera => "Camera",
            KeyGroup::Scene => "Bodies and lights",
            KeyGroup::Sliders => "Sliders and numbers",
            KeyGroup::Window => "Window",
        }
    }
}

/// A key that performs an action.
pub(super) struct Shortcut<A> {
    /// The key.
    pub(super) keys: KeyboardShortcut,
    /// The action.
    pub(super) action: A,
    /// Where it stands in the list of keys.
    pub(super) group: KeyGroup,
    /// What it does.
    pub(super) about: &'static str,
}

impl<A> Shortcut<A> {
    /// The shortcuts of a group.
    pub(super) fn all_of(group: KeyGroup, keys: Vec<(KeyboardShortcut, A, &'static str)>) -> impl Iterator<Item = Self> {
        keys.into_iter().map(move |(keys, action, about)| Self { keys, action, group, about })
    }
}

/// What else the keyboard and the mouse do: the group, the keys, and a description.
pub(super) const OTHER_KEYS: [(KeyGroup, &str, &str); 28] = [
    (KeyGroup::Editing, "Ctrl+F", "Find and replace"),
    (KeyGroup::Editing, "Ctrl+Space", "Complete the word"),
    (KeyGroup::Editing, "Ctrl+Z", "Undo in the text"),
    (KeyGroup::Editing, "Ctrl+Y", "Redo in the text"),
    (KeyGroup::Editing, "Ctrl+/", "Comment lines out, or in again"),
    (KeyGroup::Editing, "Tab", "Indent; with Shift unindent"),
    (KeyGroup::Sliders, "Click a number", "Type it"),
    (KeyGroup::Sliders, "Drag a number", "Change it; with Shift in small steps"),
    (KeyGroup::Sliders, "Double-click a name", "Its default value"),
    (KeyGroup::Sliders, "Right-click a name", "Menu: copy the value to all of its kind"),
    (KeyGroup::Picture, "Ctrl+Wheel", "Zoom the picture"),
    (KeyGroup::Picture, "Space+Drag", "Move a picture that is larger than its pane"),
    (KeyGroup::Camera, "Drag", "Orbit about the point under the pointer; about the selected body over the background"),
    (KeyGroup::Camera, "Alt+Drag", "Orbit, whatever is under the pointer"),
    (KeyGroup::Camera, "Middle drag", "Pan; also Shift+Drag"),
    (KeyGroup::Camera, "Right drag", "Go closer or back (dolly); also Ctrl+Drag"),
    (KeyGroup::Camera, "Shift+Right drag", "Field of view; also Ctrl+Shift+Drag"),
    (KeyGroup::Camera, "Wheel", "Go closer or back"),
    (KeyGroup::Camera, "Arrow keys", "Orbit; with Shift pan"),
    (KeyGroup::Camera, "Page Up, Page Down", "Go closer and back"),
    (KeyGroup::Camera, "Escape", "Give up a drag: everything is as before"),
    (KeyGroup::Scene, "Click", "Select the body or the light under the pointer; the background selects the scene"),
    (
        KeyGroup::Scene,
        "Drag the selected",
        "Move a body or a light parallel to the picture; hold X, Y or Z for an axis, or drag an arrow (a floor: only so)",
    ),
    (KeyGroup::Scene, "Drag the square", "Change the radius of a round body or light; on the target of a spot, move that"),
    (KeyGroup::Scene, "Drag a ring", "Rotate the selected body or light about an axis of the scene"),
    (KeyGroup::Scene, "Drag a small box", "Scale it along one of its own axes; the one in the middle scales it as a whole"),
    (KeyGroup::Scene, "Ctrl+Drag a handle", "Snap to 15 degrees, to tenths of the size, or to round distances"),
    (KeyGroup::Scene, "Right click", "Menu of the scene"),
];

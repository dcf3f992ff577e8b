//! The actions of the user interface, which menus, keys, buttons and dialogs cause.

use crate::backends::BackendChoice;
use crate::preview::app::instrument_actions::InstrumentAction;
use crate::preview::app::key_groups::{KeyGroup, Shortcut};
use crate::preview::app::pane::Zoom;
use crate::preview::app::scene_actions::{MeshSpot, SceneAction, scene_shortcuts};
use crate::preview::editor::EditorCommand;
use crate::scene::BodyId;
use crate::user_data::settings::{Settings, ThemeSetting};
use crate::workspace::FileKind;
use crate::workspace::Location;
use crate::workspace::OwnerId;
use crate::workspace::materials::{LibraryLocation, Material};
use egui::{Key, KeyboardShortcut, Modifiers, Ui};
use std::path::PathBuf;

/// An action.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Start a new text of this kind.
    New(FileKind),
    /// Perform this action, although unsaved work is lost.
    Confirmed(Box<Action>),
    /// Show the dialog that opens a file of this kind.
    ShowOpenDialog(FileKind),
    /// Open a file of this kind.
    Open(FileKind, Location),
    /// Show the dialog that chooses the image of the texture of this name of an owner.
    ShowImageDialog(OwnerId, String),
    /// Give the texture of this name of an owner the image in this file, if there is one. While the dialog was open,
    /// the formula may have changed.
    SetImage(OwnerId, String, PathBuf),
    /// Show the dialog that chooses a mesh to be added to the scene.
    ShowMeshDialog,
    /// Add the mesh in a file to the scene.
    AddMesh(PathBuf, MeshSpot),
    /// Save the text in view.
    Save,
    /// Show the dialog that saves something of this kind.
    ShowSaveDialog(FileKind),
    /// Save something of this kind to a path; the picture if there is no kind.
    SaveTo(Option<FileKind>, PathBuf),
    /// Save work of these kinds one after the other, and then perform an action.
    SaveAll {
        /// The kinds of work, the session last.
        kinds: Vec<FileKind>,
        /// What is done when all is saved.
        then: Option<Box<Action>>,
    },
    /// Leave the rest of what is saved in turn: the dialog for a file was cancelled.
    StopSaving,
    /// Perform a command of the text editor.
    EditText(EditorCommand),
    /// Save the values of a body as a material, unless there is one of this name: then ask.
    SaveMaterial {
        /// The name.
        name: String,
        /// The body.
        body: BodyId,
    },
    /// Save the values of a body as a material, in place of the one of this name.
    ReplaceMaterial {
        /// The name.
        name: String,
        /// The body.
        body: BodyId,
    },
    /// Delete the material of this name.
    DeleteMaterial(String),
    /// Take back the deletion or the replacement of a material.
    RestoreMaterial(Box<MaterialChange>),
    /// Show the dialog that saves the picture.
    ShowSavePictureDialog,
    /// Fit values to the data in a file, measured reflectance or a picture, when the user begins the fit.
    FitTo(PathBuf),
    /// Copy the picture in view to the clipboard.
    CopyPicture,
    /// Save the session to its file.
    SaveSession,
    /// Apply the text in view to the picture.
    Apply,
    /// Apply texts while they are typed, whenever they have no errors; or stop doing so.
    ApplyAsYouType(bool),
    /// Undo the last change of a value.
    Undo,
    /// Redo the change that was undone last.
    Redo,
    /// Keep the picture and its values as a snapshot.
    TakeSnapshot(usize),
    /// Restore the values of a snapshot.
    RestoreSnapshot(usize),
    /// Show the picture this large.
    Zoom(Zoom),
    /// Show or hide something over the picture.
    ToggleOverlay(PictureOverlay),
    /// Zoom in by this many steps; out if it is negative.
    ZoomBy(i32),
    /// Do something with the instruments.
    Instruments(InstrumentAction),
    /// Do something with the scene.
    Scene(SceneAction),
    /// Evaluate with this backend.
    SetBackend(BackendChoice),
    /// Use this theme.
    SetTheme(ThemeSetting),
    /// Draw widgets at this scale, in pixels per point.
    SetScale(f32),
    /// Show or hide a panel.
    TogglePanel(PanelId),
    /// Open the drafts of earlier runs.
    RestoreDrafts,
    /// Discard the drafts of earlier runs.
    DiscardDrafts,
    /// Ask what to do with the drafts of earlier runs.
    OfferDrafts,
    /// Open this session at the next start.
    UseAsStartupSession,
    /// Start a new session: the same formula and scene, with the values of the settings.
    NewSession,
    /// Show the dialog for settings.
    ShowSettings,
    /// Save these settings.
    SaveSettings(Box<Settings>),
    /// Show the gallery.
    ShowGallery,
    /// Show a pixel in the inspector.
    InspectPixel([u32; 2]),
    /// Show the list of shortcuts.
    ShowShortcuts,
    /// End the program.
    Quit,
}

/// The deletion or the replacement of a material of the user.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialChange {
    /// The name of the material.
    pub name: String,
    /// The library that it is in.
    pub library: LibraryLocation,
    /// The material before; `None` if there was only a built-in one of the name.
    pub before: Option<Material>,
    /// The material after; `None` if it was deleted.
    pub after: Option<Material>,
}

/// Something over the picture that can be hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureOverlay {
    /// Marks of pixels that are too bright to be shown, or black.
    Clipping,
    /// The histogram.
    Histogram,
}

/// A panel that can be hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PanelId {
    /// The texts.
    Texts,
    /// The parameters.
    Parameters,
    /// The log.
    Log,
    /// The reference of the language.
    Reference,
    /// The pixel inspector.
    Inspector,
    /// The instruments.
    Instruments,
    /// The panel for fits.
    Fitting,
}

/// Every shortcut of an action that is not on the scene.
pub(super) fn shortcuts() -> Vec<Shortcut<Action>> {
    let ctrl = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
    let ctrl_shift = |key| KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key);
    let plain = |key| KeyboardShortcut::new(Modifiers::NONE, key);
    let undo = KeyboardShortcut::new(Modifiers::ALT, Key::Z);
    let redo = KeyboardShortcut::new(Modifiers::ALT.plus(Modifiers::SHIFT), Key::Z);
    let undo_doc = "Undo a change of a value, the exposure, the scene or a material; also Ctrl+Z while no text is edited";
    let redo_doc = "Redo what was undone; also Ctrl+Shift+Z or Ctrl+Y while no text is edited";
    let zoom_out = KeyboardShortcut::new(Modifiers::SHIFT, Key::F8);
    let clipping = Action::ToggleOverlay(PictureOverlay::Clipping);
    let histogram = Action::ToggleOverlay(PictureOverlay::Histogram);
    let panel = Action::TogglePanel;
    let groups = [
        (
            KeyGroup::Files,
            vec![
                (ctrl(Key::S), Action::Save, "Save the text in view"),
                (ctrl_shift(Key::S), Action::SaveSession, "Save the session"),
                (ctrl(Key::O), Action::ShowOpenDialog(FileKind::Formula), "Open a formula"),
                (ctrl_shift(Key::O), Action::ShowOpenDialog(FileKind::Session), "Open a session"),
                (ctrl(Key::Q), Action::Quit, "Quit"),
            ],
        ),
        (
            KeyGroup::Editing,
            vec![
                (ctrl(Key::Enter), Action::Apply, "Apply the text in view"),
                (undo, Action::Undo, undo_doc),
                (redo, Action::Redo, redo_doc),
            ],
        ),
        (
            KeyGroup::Picture,
            vec![
                (plain(Key::F6), Action::Zoom(Zoom::Fit), "Fit the picture into its pane"),
                (plain(Key::F7), Action::Zoom(Zoom::ACTUAL), "Show the picture in its actual size"),
                (plain(Key::F8), Action::ZoomBy(1), "Zoom in"),
                (zoom_out, Action::ZoomBy(-1), "Zoom out"),
                (plain(Key::F9), Action::Zoom(Zoom::Pane), "Make the picture as large as its pane"),
                (plain(Key::F10), clipping, "Mark pixels that are too bright, or black"),
                (plain(Key::F11), histogram, "Show or hide the histogram"),
                (ctrl(Key::E), Action::ShowSavePictureDialog, "Save the picture"),
                (ctrl_shift(Key::E), Action::CopyPicture, "Copy the picture to the clipboard"),
            ],
        ),
        (
            KeyGroup::Window,
            vec![
                (plain(Key::F1), Action::ShowShortcuts, "Show these shortcuts"),
                (plain(Key::F2), panel(PanelId::Reference), "Show or hide the language reference"),
                (plain(Key::F3), panel(PanelId::Texts), "Show or hide the texts"),
                (plain(Key::F4), panel(PanelId::Parameters), "Show or hide the parameters"),
                (plain(Key::F5), panel(PanelId::Inspector), "Show or hide the pixel inspector"),
                (plain(Key::F12), panel(PanelId::Log), "Show or hide the log"),
                (ctrl(Key::I), panel(PanelId::Instruments), "Show or hide the instruments: views of the formula itself"),
            ],
        ),
    ];
    groups.into_iter().flat_map(|(group, keys)| Shortcut::all_of(group, keys)).collect()
}

/// The shortcuts that undo and redo value changes while no text is edited. The text editor has its own undo.
fn beside_texts() -> [(KeyboardShortcut, Action); 3] {
    let ctrl = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
    [
        (KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z), Action::Redo),
        (ctrl(Key::Y), Action::Redo),
        (ctrl(Key::Z), Action::Undo),
    ]
}

/// The shortcut of an action for the user; empty if there is none.
pub(super) fn shortcut_of(action: &Action, ui: &Ui) -> String {
    let found = if let Action::Scene(own) = action {
        scene_shortcuts().into_iter().find(|one| one.action == *own).map(|one| one.keys)
    } else {
        shortcuts().into_iter().find(|one| one.action == *action).map(|one| one.keys)
    };
    found.map(|shortcut| ui.ctx().format_shortcut(&shortcut)).unwrap_or_default()
}

/// The actions whose shortcuts were pressed. `typing` says whether a text is edited.
pub(super) fn pressed(ui: &Ui, typing: bool) -> Vec<Action> {
    let mut all = shortcuts();
    // Shortcuts with Shift come first, because the ones without it would match too.
    all.sort_by_key(|one| std::cmp::Reverse(one.keys.modifiers.shift));
    let mut actions = Vec::new();
    ui.input_mut(|input| {
        for one in all {
            if input.consume_shortcut(&one.keys) {
                actions.push(one.action);
            }
        }
        for (shortcut, action) in beside_texts() {
            if !typing && input.consume_shortcut(&shortcut) {
                actions.push(action);
            }
        }
        let mut of_scene = scene_shortcuts();
        of_scene.sort_by_key(|one| std::cmp::Reverse(one.keys.modifiers.shift));
        for one in of_scene {
            if !typing && input.consume_shortcut(&one.keys) {
                actions.push(Action::Scene(one.action));
            }
        }
    });
    actions
}

//! The actions of the user interface, which menus, keys, buttons and dialogs cause.

use crate::backends::BackendChoice;
use crate::preview::app::theme::Theme;
use crate::user_data::settings::Settings;
use crate::workspace::FileKind;
use crate::workspace::Location;
use egui::{Key, KeyboardShortcut, Modifiers, Ui};
use std::path::PathBuf;

/// An action.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Start a new text of this kind.
    New(FileKind),
    /// Perform this action, although unsaved work is lost.
    Surely(Box<Command>),
    /// Show the dialog that opens a file of this kind.
    AskToOpen(FileKind),
    /// Open a file of this kind.
    Open(FileKind, Location),
    /// Save the text in view.
    Save,
    /// Show the dialog that saves something of this kind.
    AskToSave(FileKind),
    /// Save something of this kind to a path; the picture if there is no kind.
    SaveTo(Option<FileKind>, PathBuf),
    /// Show the dialog that saves the picture.
    AskToSavePicture,
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
    Keep(usize),
    /// Restore the values of a snapshot.
    GoBackTo(usize),
    /// Evaluate with this backend.
    Evaluate(BackendChoice),
    /// Use this theme.
    Look(Theme),
    /// Draw widgets at this scale, in pixels per point.
    Scale(f32),
    /// Show or hide a panel.
    Toggle(Panel),
    /// Open the drafts of earlier runs, or discard them.
    TakeLeft(bool),
    /// Ask what to do with the drafts of earlier runs.
    AskForLeft,
    /// Open this session at the next start.
    StartWithThis,
    /// Start a new session: the same formula and scene, with the values of the settings.
    NewSession,
    /// Show the dialog for settings.
    AskForSettings,
    /// Save these settings.
    Settle(Box<Settings>),
    /// Show the list of shortcuts.
    ShowShortcuts,
    /// End the program.
    Quit,
}

/// A panel that can be hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Panel {
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
}

/// Every shortcut: its key, its action, and a description.
pub(super) fn shortcuts() -> Vec<(KeyboardShortcut, Command, &'static str)> {
    let command = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
    let shifted = |key| KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key);
    let plain = |key| KeyboardShortcut::new(Modifiers::NONE, key);
    vec![
        (command(Key::Enter), Command::Apply, "Apply the text that is seen to the picture"),
        (command(Key::S), Command::Save, "Save the text that is seen"),
        (shifted(Key::S), Command::SaveSession, "Save the session"),
        (command(Key::O), Command::AskToOpen(FileKind::Formula), "Open a formula"),
        (shifted(Key::O), Command::AskToOpen(FileKind::Session), "Open a session"),
        (command(Key::E), Command::AskToSavePicture, "Save the picture"),
        (shifted(Key::E), Command::CopyPicture, "Copy the picture to the clipboard"),
        (
            KeyboardShortcut::new(Modifiers::ALT, Key::Z),
            Command::Undo,
            "Undo a change of a value; Ctrl+Z too, where no text is typed",
        ),
        (KeyboardShortcut::new(Modifiers::ALT.plus(Modifiers::SHIFT), Key::Z), Command::Redo, "Do it again"),
        (plain(Key::F1), Command::ShowShortcuts, "Show these shortcuts"),
        (plain(Key::F2), Command::Toggle(Panel::Reference), "Show or hide the reference of the language"),
        (plain(Key::F3), Command::Toggle(Panel::Texts), "Show or hide the texts"),
        (plain(Key::F4), Command::Toggle(Panel::Parameters), "Show or hide the parameters"),
        (plain(Key::F5), Command::Toggle(Panel::Inspector), "Show or hide the pixel inspector"),
        (plain(Key::F12), Command::Toggle(Panel::Log), "Show or hide the log"),
        (command(Key::Q), Command::Quit, "Quit"),
    ]
}

/// The shortcuts that undo and redo value changes while no text is edited. The text editor has its own undo.
fn beside_texts() -> [(KeyboardShortcut, Command); 3] {
    let command = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
    [
        (KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z), Command::Redo),
        (command(Key::Y), Command::Redo),
        (command(Key::Z), Command::Undo),
    ]
}

/// The shortcut of an action for the user; empty if there is none.
pub(super) fn shortcut_of(command: &Command, ui: &Ui) -> String {
    let found = shortcuts().into_iter().find(|(_, other, _)| other == command);
    found.map(|(shortcut, ..)| ui.ctx().format_shortcut(&shortcut)).unwrap_or_default()
}

/// The actions whose shortcuts were pressed. `typing` says whether a text is edited.
pub(super) fn pressed(ui: &Ui, typing: bool) -> Vec<Command> {
    let mut all = shortcuts();
    // Shortcuts with Shift come first, because the ones without it would match too.
    all.sort_by_key(|(shortcut, ..)| std::cmp::Reverse(shortcut.modifiers.shift));
    let mut commands = Vec::new();
    ui.input_mut(|input| {
        for (shortcut, command, _) in all {
            if input.consume_shortcut(&shortcut) {
                commands.push(command);
            }
        }
        for (shortcut, command) in beside_texts() {
            if !typing && input.consume_shortcut(&shortcut) {
                commands.push(command);
            }
        }
    });
    commands
}

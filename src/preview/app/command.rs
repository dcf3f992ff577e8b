//! What can be done in the workshop, whoever asks for it: a menu, a key, a button, a dialog.

use crate::backends::BackendChoice;
use crate::preview::app::theme::Theme;
use crate::user_data::settings::Settings;
use crate::workspace::FileKind;
use crate::workspace::Location;
use egui::{Key, KeyboardShortcut, Modifiers, Ui};
use std::path::PathBuf;

/// Something to be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Begin a new text of this kind.
    New(FileKind),
    /// Do this although a text that is not saved is lost by it.
    Surely(Box<Command>),
    /// Ask for a file of this kind, and open it.
    AskToOpen(FileKind),
    /// Open a file of this kind.
    Open(FileKind, Location),
    /// Save the text that is seen.
    Save,
    /// Ask where to save what is seen, of this kind.
    AskToSave(FileKind),
    /// Save it there; the picture where there is no kind.
    SaveTo(Option<FileKind>, PathBuf),
    /// Ask where to save the picture.
    AskToSavePicture,
    /// Copy the picture that is seen to the clipboard.
    CopyPicture,
    /// Save the session where it is.
    SaveSession,
    /// Take the text that is seen for the picture.
    Apply,
    /// Apply texts while they are typed, whenever they are sound; or not.
    ApplyAsYouType(bool),
    /// Undo the last change of a value.
    Undo,
    /// Do it again.
    Redo,
    /// Keep the picture with its values in a place.
    Keep(usize),
    /// Go back to what is kept there.
    GoBackTo(usize),
    /// Evaluate by this backend.
    Evaluate(BackendChoice),
    /// Look like this.
    Look(Theme),
    /// Draw widgets so large, in pixels a point.
    Scale(f32),
    /// Show or hide a panel.
    Toggle(Panel),
    /// Open the unsaved texts that a program left behind, or throw them away.
    TakeLeft(bool),
    /// Ask what to do with what was left unsaved.
    AskForLeft,
    /// Open the session that is open now at the next start.
    StartWithThis,
    /// Begin a new session: the same formula and scene, and values as the settings have them.
    NewSession,
    /// Ask for settings.
    AskForSettings,
    /// Keep these settings.
    Settle(Box<Settings>),
    /// Show the shortcuts.
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

/// Every shortcut: the key, what it does, and how that is said.
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

/// What undoes and redoes where no text is typed, which has its own undo.
fn beside_texts() -> [(KeyboardShortcut, Command); 3] {
    let command = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
    [
        (KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z), Command::Redo),
        (command(Key::Y), Command::Redo),
        (command(Key::Z), Command::Undo),
    ]
}

/// The shortcut of a command, as people read it; empty where there is none.
pub(super) fn shortcut_of(command: &Command, ui: &Ui) -> String {
    let found = shortcuts().into_iter().find(|(_, other, _)| other == command);
    found.map(|(shortcut, ..)| ui.ctx().format_shortcut(&shortcut)).unwrap_or_default()
}

/// The commands whose keys were pressed, while a text is typed or not.
pub(super) fn pressed(ui: &Ui, typing: bool) -> Vec<Command> {
    let mut all = shortcuts();
    // Those with more modifiers first: a shorter one would match too.
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

//! The menu of edits, in the menu bar and on right click.

use super::{Document, Editor, EditorCommand};
use egui::{Button, Key, KeyboardShortcut, Modifiers, Ui};

/// Which edits a document allows now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PossibleEdits {
    /// Whether a change of the text can be undone.
    pub undo: bool,
    /// Whether a change of the text can be redone.
    pub redo: bool,
    /// Whether text is selected.
    pub selected: bool,
    /// Whether a text is in view.
    pub text: bool,
}

impl Editor {
    /// Which edits a document allows now.
    pub fn possible_edits(&self, document: &Document) -> PossibleEdits {
        let selection = if self.shown == Some(document.id()) {
            self.selection
        } else {
            self.selections.get(&document.id()).copied().unwrap_or_default()
        };
        let selected = !selection.range().is_empty();
        PossibleEdits { undo: document.can_undo(), redo: document.can_redo(), selected, text: true }
    }
}

/// Draws the entries of the menu. Returns the command that was chosen.
pub fn edit_menu_ui(ui: &mut Ui, can: PossibleEdits) -> Option<EditorCommand> {
    let shortcut = |key| KeyboardShortcut::new(Modifiers::COMMAND, key);
    let undoing = [
        (EditorCommand::Undo, "Undo in the text", Key::Z, can.text && can.undo),
        (EditorCommand::Redo, "Redo in the text", Key::Y, can.text && can.redo),
    ];
    let copying = [
        (EditorCommand::Cut, "Cut", Key::X, can.text && can.selected),
        (EditorCommand::Copy, "Copy", Key::C, can.text && can.selected),
        (EditorCommand::Paste, "Paste", Key::V, can.text),
        (EditorCommand::SelectAll, "Select all", Key::A, can.text),
    ];
    let finding = [(EditorCommand::Find, "Find and replace", Key::F, can.text)];
    let mut chosen = None;
    for (index, entries) in [&undoing[..], &copying[..], &finding[..]].into_iter().enumerate() {
        if index > 0 {
            ui.separator();
        }
        for (command, name, key, possible) in entries {
            let button = Button::new(*name).right_text(ui.ctx().format_shortcut(&shortcut(*key)));
            if ui.add_enabled(*possible, button).clicked() {
                chosen = Some(*command);
                ui.close();
            }
        }
    }
    chosen
}

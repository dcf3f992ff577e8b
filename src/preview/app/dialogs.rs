//! Dialogs: for files, messages, questions, and the list of shortcuts.

use crate::lang::display_text::{many_lines, one_line};
use crate::picture::Format;
use crate::preview::app::Action;
use crate::preview::app::action::shortcuts;
use crate::workspace::FileKind;
use crate::workspace::Location;
use egui::{Align2, Context, Frame, Grid, Key, Modal, ModalResponse, Modifiers, ScrollArea, Ui};
use egui_file_dialog::{DialogState, FileDialog};
use std::collections::VecDeque;

/// The height that a dialog needs beside its content: title, button and margins.
const EXTRA_HEIGHT: f32 = 150.0;

/// A modal dialog with margins and a title.
pub(super) fn modal<R>(context: &Context, title: &str, content: impl FnOnce(&mut Ui) -> R) -> ModalResponse<R> {
    let frame = Frame::popup(&context.global_style()).inner_margin(18.0);
    Modal::new(egui::Id::new(("modal", title))).frame(frame).show(context, |ui| {
        ui.heading(title);
        ui.add_space(6.0);
        content(ui)
    })
}

/// A file dialog in the middle of the window.
fn file_dialog(title: &str) -> FileDialog {
    FileDialog::new().title(title).anchor(Align2::CENTER_CENTER, [0.0, 0.0])
}

/// More shortcuts, which the text editor has.
const EDITOR_SHORTCUTS: [(&str, &str); 4] = [
    ("Ctrl+F", "Find and replace"),
    ("Ctrl+Space", "Complete the word"),
    ("Ctrl+Z", "Undo in the text"),
    ("Ctrl+Y", "Redo in the text"),
];

/// What a file dialog is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    Open(FileKind),
    Save(Option<FileKind>),
}

/// The dialogs.
#[derive(Default)]
pub(super) struct Dialogs {
    file: Option<(FileDialog, Purpose)>,
    /// Messages that wait to be read, each with a title.
    messages: VecDeque<(String, String)>,
    shortcuts: bool,
    /// The drafts that the dialog offers.
    offered_drafts: Vec<String>,
    /// An action that waits for a confirmation, and the question.
    question: Option<(Action, String)>,
}

impl Dialogs {
    /// Shows the dialog that opens a file.
    pub(super) fn show_open_dialog(&mut self, kind: FileKind) {
        let mut dialog = file_dialog(&format!("Open {}", kind.noun()));
        dialog.pick_file();
        self.file = Some((dialog, Purpose::Open(kind)));
    }

    /// Shows the dialog that saves something of this kind, or the picture.
    pub(super) fn show_save_dialog(&mut self, kind: Option<FileKind>, name: &str) {
        let picture = || format!("picture ({})", Format::suffixes());
        let title = format!("Save {}", kind.map_or_else(picture, |kind| kind.noun().to_owned()));
        let mut dialog = file_dialog(&title).default_file_name(name);
        dialog.save_file();
        self.file = Some((dialog, Purpose::Save(kind)));
    }

    /// Shows a message that the user must not miss.
    pub(super) fn show_message(&mut self, title: impl AsRef<str>, text: impl AsRef<str>) {
        let message = (one_line(title.as_ref()), many_lines(text.as_ref()));
        if !self.messages.contains(&message) {
            self.messages.push_back(message);
        }
    }

    /// Asks whether to perform an action although work is lost, as the text says.
    pub(super) fn ask_to_confirm(&mut self, text: impl AsRef<str>, action: Action) {
        self.question = Some((action, many_lines(text.as_ref())));
    }

    /// Offers the drafts of earlier runs.
    pub(super) fn offer_drafts(&mut self, left: Vec<String>) {
        self.offered_drafts = left.iter().map(|text| one_line(text)).collect();
    }

    /// Shows the shortcuts.
    pub(super) fn show_shortcuts(&mut self) {
        self.shortcuts = true;
    }

    /// The newest message, if there is one.
    #[cfg(test)]
    pub(super) fn message(&self) -> Option<&str> {
        self.messages.back().map(|(_, text)| text.as_str())
    }

    /// Whether a file dialog is open, which is not one of egui's modal dialogs.
    pub(super) fn file_dialog_is_open(&self) -> bool {
        self.file.as_ref().is_some_and(|(dialog, _)| *dialog.state() == DialogState::Open)
    }

    /// Draws all open dialogs.
    pub(super) fn ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        self.file_ui(context, actions);
        self.message_ui(context);
        self.question_ui(context, actions);
        self.offer_ui(context, actions);
        self.shortcuts_ui(context);
    }

    /// Draws the file dialog.
    fn file_ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        if let Some((dialog, purpose)) = &mut self.file {
            // The search field is black in any theme, so its text would be unreadable in the light theme.
            dialog.config_mut().show_search = context.global_style().visuals.dark_mode;
            dialog.update(context);
            if let Some(path) = dialog.take_picked() {
                actions.push(match *purpose {
                    Purpose::Open(kind) => Action::Open(kind, Location::File(path)),
                    Purpose::Save(kind) => Action::SaveTo(kind, path),
                });
                self.file = None;
            }
        }
    }

    /// Draws the oldest message.
    fn message_ui(&mut self, context: &Context) {
        if let Some((title, text)) = self.messages.front() {
            let modal = modal(context, title, |ui| {
                ui.set_max_width(640.0);
                // Markers stand below the marked places, so this needs a monospaced font.
                if text.contains("\n    ") {
                    ui.monospace(text)
                } else {
                    ui.label(text)
                };
                ui.add_space(8.0);
                ui.button("OK").clicked()
            });
            let entered = context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter));
            if modal.inner || entered || modal.should_close() {
                self.messages.pop_front();
            }
        }
    }

    /// Draws the question whether to perform an action although work is lost.
    fn question_ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        if let Some((action, text)) = &self.question {
            let mut answer = None;
            let shown = modal(context, "Not saved", |ui| {
                ui.set_max_width(560.0);
                ui.label(text);
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    for (name, sure) in [("Cancel", false), ("Throw it away", true)] {
                        if ui.button(name).clicked() {
                            answer = Some(sure);
                        }
                    }
                });
            });
            if answer == Some(true) {
                actions.push(Action::Confirmed(Box::new(action.clone())));
            }
            if answer.is_some() || shown.should_close() {
                self.question = None;
            }
        }
    }

    /// Draws the offer of drafts.
    fn offer_ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        if !self.offered_drafts.is_empty() {
            modal(context, "Unsaved work", |ui| {
                ui.label("When Illuminator was closed last, this was unsaved, and has been kept:");
                for left in &self.offered_drafts {
                    ui.label(format!("   {left}"));
                }
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    for (name, action) in [("Open it again", Action::RestoreDrafts), ("Throw it away", Action::DiscardDrafts)] {
                        if ui.button(name).clicked() {
                            actions.push(action);
                            self.offered_drafts.clear();
                        }
                    }
                    if ui.button("Later").clicked() {
                        self.offered_drafts.clear();
                    }
                });
            });
        }
    }

    /// Draws the list of shortcuts.
    fn shortcuts_ui(&mut self, context: &Context) {
        if self.shortcuts {
            let modal = modal(context, "Shortcuts", |ui| {
                let room = (ui.ctx().content_rect().height() - EXTRA_HEIGHT).max(60.0);
                ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, |ui| {
                    Grid::new("shortcuts").num_columns(2).spacing([24.0, 5.0]).show(ui, |ui| {
                        for (shortcut, _, description) in shortcuts() {
                            ui.monospace(ui.ctx().format_shortcut(&shortcut));
                            ui.label(description);
                            ui.end_row();
                        }
                        for (keys, description) in EDITOR_SHORTCUTS {
                            ui.monospace(keys);
                            ui.label(description);
                            ui.end_row();
                        }
                    });
                });
                ui.add_space(8.0);
                ui.button("Close").clicked()
            });
            if modal.inner || modal.should_close() {
                self.shortcuts = false;
            }
        }
    }
}

//! Dialogs: for files, messages, questions, drafts, and the list of shortcuts.

use crate::lang::display_text::{many_lines, one_line};
use crate::preview::app::Action;
use crate::preview::app::file_dialogs::FileDialogs;
use crate::preview::app::key_list::key_list_ui;
use crate::preview::app::modal::modal;
use crate::preview::app::question::Question;
use egui::{Context, Key, Modifiers};
use std::collections::VecDeque;

/// The dialogs.
#[derive(Default)]
pub(super) struct Dialogs {
    /// The dialogs for files.
    pub(super) files: FileDialogs,
    /// Messages that wait to be read, each with a title.
    messages: VecDeque<(String, String)>,
    shortcuts: bool,
    /// The drafts that the dialog offers.
    offered_drafts: Vec<String>,
    /// Questions that wait for an answer.
    questions: VecDeque<Question>,
}

impl Dialogs {
    /// Shows a message that the user must not miss.
    pub(super) fn show_message(&mut self, title: impl AsRef<str>, text: impl AsRef<str>) {
        let message = (one_line(title.as_ref()), many_lines(text.as_ref()));
        if !self.messages.contains(&message) {
            self.messages.push_back(message);
        }
    }

    /// Asks a question, after those that wait already.
    pub(super) fn ask(&mut self, question: Question) {
        if !self.questions.contains(&question) {
            self.questions.push_back(question);
        }
    }

    /// Offers the drafts of earlier runs.
    pub(super) fn offer_drafts(&mut self, left: Vec<String>) {
        self.offered_drafts = left.iter().map(|text| one_line(text)).collect();
    }

    /// Shows the shortcuts.
    pub(super) fn show_shortcuts(&mut self) {
        self.shortcuts = true;
    }

    /// The newest question or message, if there is one.
    #[cfg(test)]
    pub(super) fn message(&self) -> Option<&str> {
        self.questions.back().map(Question::text).or(self.messages.back().map(|(_, text)| text.as_str()))
    }

    /// Whether one of them waits for an answer, also if it is not in view yet.
    pub(super) fn are_waiting(&self) -> bool {
        let unread = !self.messages.is_empty() || !self.questions.is_empty() || !self.offered_drafts.is_empty();
        unread || self.shortcuts || self.files.is_open()
    }

    /// Draws all open dialogs.
    pub(super) fn ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        if let Some(question) = self.files.ui(context, actions) {
            self.ask(question);
        }
        self.message_ui(context);
        if self.questions.front().is_some_and(|question| question.ui(context, actions)) {
            self.questions.pop_front();
        }
        self.offer_ui(context, actions);
        self.shortcuts = self.shortcuts && !key_list_ui(context);
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

    /// Draws the offer of drafts.
    fn offer_ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        if !self.offered_drafts.is_empty() {
            let shown = modal(context, "Unsaved work", |ui| {
                ui.label("When Illuminator was closed last, this was unsaved, and has been kept:");
                for left in &self.offered_drafts {
                    ui.label(format!("   {left}"));
                }
                ui.add_space(8.0);
                ui.horizontal(|ui| {
                    for (name, action) in [("Open it again", Action::RestoreDrafts), ("Discard", Action::DiscardDrafts)] {
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
            // Escape and a click beside the dialog mean *Later*.
            if shown.should_close() {
                self.offered_drafts.clear();
            }
        }
    }
}

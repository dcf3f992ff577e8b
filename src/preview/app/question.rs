//! Questions: dialogs that wait for one of a few answers.

use crate::lang::display_text::{many_lines, one_line};
use crate::preview::app::modal::modal;
use crate::preview::app::{Action, theme};
use egui::{Context, Key, Modifiers};

/// A question. Escape and a click beside it dismiss it, and so does an answer without an action.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Question {
    title: String,
    text: String,
    answers: Vec<Answer>,
    dismissal: Option<Action>,
}

/// An answer: a button.
#[derive(Debug, Clone, PartialEq)]
struct Answer {
    label: &'static str,
    action: Option<Action>,
}

impl Question {
    /// A question without answers.
    pub(super) fn new(title: impl AsRef<str>, text: impl AsRef<str>) -> Self {
        Self { title: one_line(title.as_ref()), text: many_lines(text.as_ref()), answers: Vec::new(), dismissal: None }
    }

    /// The question with one more answer, which performs an action. The first answer stands out, and Enter gives it.
    pub(super) fn answer(mut self, label: &'static str, action: Action) -> Self {
        self.answers.push(Answer { label, action: Some(action) });
        self
    }

    /// The question with one more answer, which does nothing.
    pub(super) fn or(mut self, label: &'static str) -> Self {
        self.answers.push(Answer { label, action: None });
        self
    }

    /// The question with an action for the case that it is dismissed.
    pub(super) fn dismissed(self, action: Action) -> Self {
        Self { dismissal: Some(action), ..self }
    }

    /// What is asked.
    #[cfg(test)]
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Draws the question. Returns whether it was answered.
    pub(super) fn ui(&self, context: &Context, actions: &mut Vec<Action>) -> bool {
        let mut given = None;
        let shown = modal(context, &self.title, |ui| {
            ui.set_max_width(560.0);
            // Markers stand below the marked places, so this needs a monospaced font.
            if self.text.contains("\n    ") {
                ui.monospace(&self.text);
            } else {
                ui.label(&self.text);
            }
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                for (index, answer) in self.answers.iter().enumerate() {
                    let button = if index == 0 { theme::main_button(ui, answer.label) } else { egui::Button::new(answer.label) };
                    if ui.add(button).clicked() {
                        given = Some(answer);
                    }
                }
            });
        });
        if context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter)) {
            given = given.or(self.answers.first());
        }
        let is_closed = given.is_some() || shown.should_close();
        if is_closed {
            actions.extend(given.and_then(|answer| answer.action.clone()).or_else(|| self.dismissal.clone()));
        }
        is_closed
    }
}

//! The confirmation: a line that says for a few seconds what was done, perhaps with a button to undo it.

use crate::lang::display_text::one_line;
use crate::preview::app::Action;
use egui::{Align2, Area, Context, Frame, Id, Order, vec2};
use std::time::Duration;

/// How long a confirmation stays, in seconds; longer if it can be undone.
const SHOWN_FOR: f64 = 4.0;
const UNDO_SHOWN_FOR: f64 = 12.0;

/// The space below a confirmation, in points: the status bar, the controls under the picture, and some air.
const SPACE_BELOW: f32 = 98.0;

/// The newest confirmation.
#[derive(Default)]
pub(super) struct Confirmation {
    text: String,
    /// The label of the button and what it does.
    undo: Option<(&'static str, Action)>,
    /// When it goes away, in seconds of egui's clock; `None` if it was not drawn yet.
    until: Option<f64>,
}

impl Confirmation {
    /// Says that something was done.
    pub(super) fn say(&mut self, text: impl AsRef<str>) {
        *self = Self { text: one_line(text.as_ref()), undo: None, until: None };
    }

    /// Says that something was done, with a button that performs an action.
    pub(super) fn say_with(&mut self, text: impl AsRef<str>, label: &'static str, action: Action) {
        self.say(text);
        self.undo = Some((label, action));
    }

    /// The text in view, if there is one.
    #[cfg(test)]
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Draws the confirmation above the status bar while it is new.
    pub(super) fn ui(&mut self, context: &Context, actions: &mut Vec<Action>) {
        if self.text.is_empty() {
            return;
        }
        let now = context.input(|input| input.time);
        let span = if self.undo.is_some() { UNDO_SHOWN_FOR } else { SHOWN_FOR };
        let rest = *self.until.get_or_insert(now + span) - now;
        if rest <= 0.0 {
            *self = Self::default();
            return;
        }
        context.request_repaint_after(Duration::from_secs_f64(rest));
        let area = Area::new(Id::new("confirmation")).order(Order::Foreground);
        let area = area.anchor(Align2::CENTER_BOTTOM, vec2(0.0, -SPACE_BELOW)).interactable(self.undo.is_some());
        let mut done = false;
        area.show(context, |ui| {
            Frame::popup(ui.style()).inner_margin(egui::Margin::symmetric(12, 7)).show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.label(&self.text);
                    if let Some((label, action)) = &self.undo
                        && ui.button(*label).clicked()
                    {
                        actions.push(action.clone());
                        done = true;
                    }
                });
            });
        });
        if done {
            *self = Self::default();
        }
    }
}

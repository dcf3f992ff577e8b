//! A ring around the widget that has the keyboard, if it was reached with the keyboard.

use egui::{Context, Event, Key, Stroke, StrokeKind, TextEdit};

/// Whether the keyboard leads from widget to widget.
#[derive(Default)]
pub(super) struct FocusRing {
    by_keys: bool,
}

impl FocusRing {
    /// Draws the ring. Fields and texts have a cursor, so they need none.
    pub(super) fn ui(&mut self, context: &Context) {
        context.input(|input| {
            for event in &input.events {
                let tab = matches!(event, Event::Key { key: Key::Tab, pressed: true, .. });
                let pressed = matches!(event, Event::PointerButton { pressed: true, .. });
                self.by_keys = (self.by_keys || tab) && !pressed;
            }
        });
        let focused = context.memory(|memory| memory.focused()).filter(|_| self.by_keys);
        let Some(response) = focused.and_then(|id| context.read_response(id)) else { return };
        if TextEdit::load_state(context, response.id).is_some() {
            return;
        }
        if response.gained_focus() {
            // The widget may be scrolled out of view: its next frame shows it.
            context.request_repaint();
        }
        let visuals = &context.global_style().visuals;
        let painter = context.layer_painter(response.layer_id).with_clip_rect(response.interact_rect.expand(4.0));
        for (width, colour) in [(4.0, visuals.window_fill), (2.0, visuals.selection.bg_fill)] {
            painter.rect_stroke(response.rect.expand(1.0), 5.0, Stroke::new(width, colour), StrokeKind::Middle);
        }
    }
}

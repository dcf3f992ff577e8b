//! The queue of input events, which is split into frames.
//!
//! egui determines what is under the pointer once per pass, and a widget can be clicked once per pass. So a pass gets
//! at most one click, and no movement after a press. It gets no key after a click either: the clicked widget has the
//! keyboard from the next pass on.

use egui::Event;
use std::collections::VecDeque;
use std::time::Instant;

/// The queue.
#[derive(Debug, Default)]
pub(super) struct InputQueue {
    queue: VecDeque<(Event, Instant)>,
}

/// The input of one frame.
#[derive(Debug, Default, PartialEq)]
pub(super) struct FrameInput {
    pub(super) events: Vec<Event>,
    /// When its earliest pointer movement arrived.
    pub(super) motion: Option<Instant>,
}

impl InputQueue {
    pub(super) fn push(&mut self, event: Event, at: Instant) {
        self.queue.push_back((event, at));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Whether the queue has anything but pointer movements.
    pub(super) fn is_urgent(&self) -> bool {
        self.queue.iter().any(|(event, _)| !matches!(event, Event::PointerMoved(_)))
    }

    /// Takes the input of the next frame.
    pub(super) fn next_frame(&mut self) -> FrameInput {
        let mut frame = FrameInput::default();
        let [mut pressed, mut released] = [false, false];
        while let Some((event, at)) = self.queue.pop_front() {
            let is_movement = matches!(event, Event::PointerMoved(_));
            let is_key = matches!(event, Event::Key { .. } | Event::Text(_) | Event::Paste(_) | Event::Copy | Event::Cut);
            let is_button = |down| matches!(event, Event::PointerButton { pressed, .. } if pressed == down);
            if (is_movement && (pressed || released)) || ((is_key || is_button(true)) && released) {
                self.queue.push_front((event, at));
                break;
            }
            pressed |= is_button(true);
            released |= is_button(false);
            if is_movement {
                frame.motion.get_or_insert(at);
                if let Some(Event::PointerMoved(_)) = frame.events.last() {
                    frame.events.pop();
                }
            }
            frame.events.push(event);
        }
        frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Modifiers, PointerButton, pos2};

    fn moved(x: f32) -> Event {
        Event::PointerMoved(pos2(x, 0.0))
    }

    fn button(pressed: bool) -> Event {
        Event::PointerButton { pos: pos2(1.0, 1.0), button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    fn frames(events: impl IntoIterator<Item = Event>) -> Vec<Vec<Event>> {
        let mut incoming = InputQueue::default();
        events.into_iter().for_each(|event| incoming.push(event, Instant::now()));
        std::iter::from_fn(|| (!incoming.is_empty()).then(|| incoming.next_frame().events)).collect()
    }

    #[test]
    fn every_click_is_seen_by_a_frame_of_its_own() {
        let clicks = (0..6).map(|at| button(at % 2 == 0));
        assert_eq!(frames(clicks), vec![vec![button(true), button(false)]; 3]);
    }

    #[test]
    fn movements_run_together_but_not_past_a_press() {
        let events = [moved(1.0), moved(2.0), button(true), moved(3.0), moved(4.0), button(false), moved(5.0)];
        let expected = vec![vec![moved(2.0), button(true)], vec![moved(4.0), button(false)], vec![moved(5.0)]];
        assert_eq!(frames(events), expected);
    }

    #[test]
    fn keys_after_a_click_go_to_what_was_clicked() {
        let text = Event::Text("a".into());
        let events = [button(true), button(false), text.clone(), text.clone()];
        assert_eq!(frames(events), vec![vec![button(true), button(false)], vec![text.clone(), text]]);
    }

    #[test]
    fn keys_keep_their_place() {
        let events = [Event::Text("a".into()), moved(1.0), Event::Text("b".into()), button(true)];
        assert_eq!(frames(events.clone()), vec![events.to_vec()]);
    }
}

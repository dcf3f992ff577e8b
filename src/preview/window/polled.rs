//! The pointer as minifb reports it, if there is no second connection: its current position and buttons. A click
//! between two polls is lost.

use super::display::PointerInput;
use egui::PointerButton;
use minifb::{MouseButton, MouseMode, Window};

const BUTTONS: [(MouseButton, PointerButton); 5] = [
    (MouseButton::Left, PointerButton::Primary),
    (MouseButton::Middle, PointerButton::Middle),
    (MouseButton::Right, PointerButton::Secondary),
    (MouseButton::Back, PointerButton::Extra1),
    (MouseButton::Forward, PointerButton::Extra2),
];

/// The state at the last poll.
#[derive(Debug, Default)]
pub(super) struct PolledPointer {
    at: Option<[f32; 2]>,
    down: [bool; BUTTONS.len()],
}

impl PolledPointer {
    /// The changes since the last poll.
    pub(super) fn poll(&mut self, window: &Window) -> Vec<PointerInput> {
        let mut events = Vec::new();
        let held = self.down.contains(&true);
        // While a button is held, the pointer is followed outside the window.
        let mode = if held { MouseMode::Pass } else { MouseMode::Discard };
        let at = window.get_unscaled_mouse_pos(mode).map(|(x, y)| [x, y]);
        if at != self.at {
            events.push(at.map_or(PointerInput::Left, PointerInput::Moved));
            self.at = at;
        }
        let Some(at) = at else { return events };
        for ((theirs, button), down) in BUTTONS.into_iter().zip(&mut self.down) {
            let pressed = window.get_mouse_down(theirs);
            if pressed != *down {
                *down = pressed;
                events.push(PointerInput::Button { at, button, pressed });
            }
        }
        events.extend(window.get_scroll_wheel().map(|(x, y)| PointerInput::Wheel([x, y])));
        events
    }
}

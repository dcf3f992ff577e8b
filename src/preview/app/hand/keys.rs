//! Keys that lead the camera, and the help on the mouse.

use super::gesture::Motion;
use crate::preview::app::App;
use egui::{Key, Modifiers, Response, Ui};

/// An orbit by one key, in radians.
const TURN: f64 = 7.5 / 180.0 * std::f64::consts::PI;
/// A movement by one key, as a part of the picture's half height.
const SHIFT: f64 = 0.08;
/// One key makes the distance this many times as large.
const CLOSER: f64 = 0.88;

/// What the mouse does in the picture, for the list of shortcuts.
pub(in crate::preview::app) const MOUSE_HELP: [(&str, &str); 14] = [
    ("Click", "Select the body or the light under the pointer; the background selects the scene"),
    ("Drag", "Orbit about the point under the pointer; about the selected body over the background"),
    ("Drag the selected", "Move a body or a light parallel to the picture; hold X, Y or Z for an axis, or drag an arrow"),
    ("Drag the square", "Change the radius of the selected sphere"),
    ("Middle drag", "Pan; also Shift + drag"),
    ("Right drag", "Go closer or back (dolly); also Ctrl + drag"),
    ("Shift + right drag", "Field of view; also Ctrl + Shift + drag"),
    ("Alt + drag", "Orbit, whatever is under the pointer"),
    ("Wheel", "Go closer or back"),
    ("Ctrl + wheel", "Zoom the picture"),
    ("Space + drag", "Move a picture that is larger than its pane"),
    ("Right click", "Menu of the scene"),
    ("Escape", "Give up a drag: everything is as before"),
    ("Arrow keys", "Orbit; with Shift pan; Page Up and Page Down go closer and back"),
];

impl App {
    /// Begins gestures by keys, while no widget has the keyboard.
    pub(super) fn begin_by_keys(&mut self, ui: &Ui, response: &Response) {
        if ui.memory(|memory| memory.focused().is_some_and(|id| id != response.id)) {
            return;
        }
        let at = self.scene_view().picture().center();
        let moves = [
            (Key::ArrowLeft, [-1.0, 0.0]),
            (Key::ArrowRight, [1.0, 0.0]),
            (Key::ArrowUp, [0.0, 1.0]),
            (Key::ArrowDown, [0.0, -1.0]),
        ];
        for (key, [across, up]) in moves {
            let presses = |modifiers| ui.input_mut(|input| input.count_and_consume_key(modifiers, key)) as f64;
            let panned = presses(Modifiers::SHIFT) * SHIFT;
            if panned > 0.0 {
                // The camera goes to where the arrow points, so the picture moves the other way.
                self.pulse(ui, Motion::Pan, at, [-across * panned, -up * panned]);
            }
            let turned = presses(Modifiers::NONE) * TURN;
            if turned > 0.0 {
                self.pulse(ui, Motion::Orbit, at, [across * turned, up * turned]);
            }
        }
        for (key, factor) in [(Key::PageUp, CLOSER), (Key::PageDown, 1.0 / CLOSER)] {
            let presses = ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key)) as f64;
            if presses > 0.0 {
                self.pulse(ui, Motion::Dolly, at, [0.0, presses * factor.ln()]);
            }
        }
    }
}

//! Keys that lead the camera.

use super::gesture::Motion;
use crate::preview::app::App;
use egui::{Key, Modifiers, Response, Ui};

/// An orbit by one key, in radians.
const TURN: f64 = 7.5 / 180.0 * std::f64::consts::PI;
/// A movement by one key, as a part of the picture's half height.
const SHIFT: f64 = 0.08;
/// One key makes the distance this many times as large.
const CLOSER: f64 = 0.88;

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

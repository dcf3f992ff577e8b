//! Nothing is cut off, whatever the size of the window.

use super::*;
use crate::preview::app::action::PanelId;
use egui::Rect;

/// The rectangles of widgets with these labels.
fn rects(harness: &Harness<'_, App>, labels: &[&str]) -> Vec<Rect> {
    let rect = |label: &&str| harness.get_all_by_label(label).next().unwrap_or_else(|| panic!("no {label}")).rect();
    labels.iter().map(rect).collect()
}

#[test]
fn every_control_is_within_its_panel_at_every_size() {
    let mut harness = harness();
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    for size in [[700.0, 480.0], [860.0, 560.0], [1024.0, 640.0], [1280.0, 800.0], [1707.0, 960.0]] {
        harness.set_size(egui::vec2(size[0], size[1]));
        for inspector in [false, true] {
            if harness.state().inspector.open != inspector {
                harness.state_mut().perform(Action::TogglePanel(PanelId::Inspector));
            }
            harness.run_steps(4);
            let window = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(size[0], size[1]));
            let pane = harness.state().pane.area();
            let controls = ["Fit", "1:1", "−", "+", "Exposure", "Auto", "sRGB", "Clipping", "Histogram"];
            for (rect, name) in rects(&harness, &controls).into_iter().zip(controls) {
                let inside = rect.left() >= pane.left() - 1.0 && rect.right() <= pane.right() + 1.0;
                assert!(inside && rect.bottom() < window.bottom(), "{name} at {size:?}: {rect:?}, pane {pane:?}");
            }
            let parameters = ["Ambient light", "Cd", "Save material", "Delete"];
            for (rect, name) in rects(&harness, &parameters).into_iter().zip(parameters) {
                let inside = rect.left() >= pane.right() && rect.right() <= window.right();
                assert!(inside && rect.bottom() < window.bottom(), "{name} at {size:?}: {rect:?}, window {window:?}");
            }
            assert!(pane.height() > 60.0 && pane.width() >= 150.0, "the picture keeps room at {size:?}: {pane:?}");
        }
    }
}

//! The pane of the picture: snapshots beside it, its size and its zoom.

use super::*;
use crate::workspace::session::PictureSettings;

#[test]
fn a_snapshot_is_compared_with_the_picture_along_a_line_that_moves() {
    let mut harness = harness();
    let kept = settle(&mut harness);
    harness.state_mut().perform(Action::TakeSnapshot(0));
    let workshop = &mut harness.state_mut().workshop;
    let id = workshop.formula().predefined(crate::lang::variables::Predefined::Ambient);
    workshop.set(crate::workspace::OwnerId::Global, id, [1.0; 3]);
    let now = settle(&mut harness);
    harness.state_mut().pane.mode = comparison::PaneMode::Split(comparison::PAIRS[0]);
    harness.run_steps(2);
    // How many columns of the last row, which is the floor's, are those of the snapshot.
    let last = 64 * 47..64 * 48;
    let columns = |harness: &Harness<'_, App>| {
        let app = harness.state();
        let row = &app.pane.picture(&app.workshop).pixels[last.clone()];
        let (kept, now) = (&kept[last.clone()], &now[last.clone()]);
        assert!(row[63] == now[63] && now.iter().zip(kept).all(|(now, kept)| now != kept));
        row.iter().zip(kept).take_while(|(seen, kept)| seen == kept).count()
    };
    assert_eq!(columns(&harness), 32);
    let line = harness.state().pane.area().center();
    harness.drag_at(line);
    harness.run_steps(2);
    harness.hover_at(line + egui::vec2(16.0, 0.0));
    harness.run_steps(2);
    harness.drop_at(line + egui::vec2(16.0, 0.0));
    harness.run_steps(2);
    assert_eq!(columns(&harness), 48);
}

#[test]
fn a_picture_beside_a_snapshot_has_its_size_whatever_the_pane_has() {
    let mut harness = harness();
    harness.state_mut().pane.zoom = pane::Zoom::Pane;
    let size = |harness: &mut Harness<'_, App>| {
        // The pane's size is taken over after a while.
        harness.run_steps(40);
        settle(harness);
        harness.state().workshop.size()
    };
    let wide = size(&mut harness);
    harness.state_mut().perform(Action::TakeSnapshot(0));
    harness.state_mut().perform(Action::TogglePanel(action::PanelId::Log));
    let narrow = size(&mut harness);
    assert!(narrow[1] < wide[1]);
    harness.state_mut().pane.mode = comparison::PaneMode::Split(comparison::PAIRS[0]);
    assert_eq!(size(&mut harness), wide);
    let app = harness.state();
    assert_eq!(app.pane.picture(&app.workshop).full_size, wide);
    harness.state_mut().pane.mode = comparison::PaneMode::Current;
    assert_eq!(size(&mut harness), narrow);
}

#[test]
fn the_wheel_zooms_to_what_is_pointed_at() {
    let mut harness = harness();
    let large = PictureSettings { size: [900, 700], depth: 1, ..harness.state().workshop.settings() };
    harness.state_mut().workshop.set_picture(large).expect("a size in range");
    settle(&mut harness);
    harness.hover_at(harness.state().pane.area().center() + egui::vec2(60.0, -40.0));
    harness.run_steps(2);
    let pointed = |harness: &Harness<'_, App>| harness.state().pane.pointed().expect("a pixel");
    let before = pointed(&harness);
    for (turned, zoom) in [(1.0, 1.5), (1.0, 2.0), (-1.0, 1.5), (1.0, 2.0)] {
        let modifiers = egui::Modifiers::CTRL;
        let (unit, delta, phase) = (egui::MouseWheelUnit::Line, egui::vec2(0.0, turned), egui::TouchPhase::Move);
        harness.event(egui::Event::MouseWheel { unit, delta, phase, modifiers });
        harness.run_steps(3);
        assert_eq!(harness.state().pane.zoom, pane::Zoom::Fixed(zoom));
        let after = pointed(&harness);
        assert!(before.iter().zip(after).all(|(before, after)| before.abs_diff(after) <= 1), "{before:?} {after:?}");
    }
}

#[test]
fn a_drag_that_leads_no_camera_says_so() {
    let mut harness = harness();
    settle(&mut harness);
    harness.state_mut().perform(Action::TakeSnapshot(0));
    let drags = |harness: &mut Harness<'_, App>, mode| {
        harness.state_mut().pane.mode = mode;
        harness.run_steps(2);
        let area = harness.state().pane.area();
        let at = area.lerp_inside([0.25, 0.3]);
        harness.drag_at(at);
        harness.run_steps(2);
        harness.hover_at(at + egui::vec2(30.0, 10.0));
        harness.run_steps(2);
        let (moves, in_vain) = (harness.state().workshop.moving().is_some(), harness.state().pane.drags_in_vain());
        harness.drop_at(at + egui::vec2(30.0, 10.0));
        harness.run_steps(2);
        settle(harness);
        (moves, in_vain)
    };
    let beside = comparison::PaneMode::Split(comparison::PAIRS[0]);
    assert_eq!(drags(&mut harness, beside), (false, true));
    assert!(!harness.state().pane.drags_in_vain(), "the drag has ended");
    assert_eq!(drags(&mut harness, comparison::PaneMode::Current), (true, false));
}

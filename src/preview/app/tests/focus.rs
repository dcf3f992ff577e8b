//! Who has the keyboard.

use super::*;
use egui::Key;

/// A harness with the caret in the formula.
fn typing() -> Harness<'static, App> {
    let mut harness = harness();
    harness.state_mut().editor.focus();
    harness.run_steps(3);
    assert!(harness.state().typing);
    harness
}

#[test]
fn keys_that_are_held_while_the_picture_is_dragged_are_not_typed() {
    let mut harness = typing();
    let before = harness.state().documents.formula.text().to_owned();
    let at = harness.state().pane.area().center();
    harness.drag_at(at);
    harness.run_steps(2);
    assert!(!harness.state().typing);
    harness.key_down(Key::X);
    harness.event(egui::Event::Text("x".to_owned()));
    harness.hover_at(at + egui::vec2(12.0, 3.0));
    harness.run_steps(2);
    harness.key_up(Key::X);
    harness.drop_at(at + egui::vec2(12.0, 3.0));
    harness.run_steps(2);
    assert_eq!(harness.state().documents.formula.text(), before);
}

#[test]
fn a_dragged_slider_is_undone_by_the_key_although_a_text_was_edited_before() {
    let mut harness = typing();
    let before = harness.state().workshop.values().numbers().to_vec();
    let pane = harness.state().pane.area();
    let slider = harness.get_all_by_role(Role::Slider).map(|node| node.rect()).find(|rect| rect.left() > pane.right());
    let at = slider.expect("a slider").center();
    harness.drag_at(at);
    harness.run_steps(2);
    harness.hover_at(at + egui::vec2(30.0, 0.0));
    harness.run_steps(2);
    harness.drop_at(at + egui::vec2(30.0, 0.0));
    harness.run_steps(2);
    assert_ne!(harness.state().workshop.values().numbers(), before);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, Key::Z);
    harness.run_steps(2);
    assert_eq!(harness.state().workshop.values().numbers(), before);
}

//! Menus, the list of keys, and the dialog for files.

use super::*;
use crate::preview::app::comparison::PaneMode;
use egui::Key;

#[test]
fn every_entry_with_a_key_shows_it() {
    let mut harness = harness();
    for (menu, keys) in [
        ("View", &["F2", "F3", "F4", "F5", "F6", "F7", "F8", "F9", "F10", "F11", "F12"][..]),
        ("Picture", &["F6", "F7", "F8", "F9"]),
        ("File", &["Ctrl+S", "Ctrl+Q"]),
        ("Help", &["F1", "F2"]),
    ] {
        harness.get_by_label(menu).click();
        harness.run_steps(3);
        for key in keys {
            assert!(harness.query_all_by_label_contains(key).next().is_some(), "{key} in {menu}");
        }
        harness.key_press(Key::Escape);
        harness.run_steps(3);
    }
}

#[test]
fn the_menu_of_comparisons_closes_after_a_choice() {
    let mut harness = harness();
    harness.state_mut().perform(Action::TakeSnapshot(0));
    harness.get_by_label("Compare").click();
    harness.run_steps(3);
    harness.get_by_label("A alone").click();
    harness.run_steps(3);
    assert_eq!(harness.state().pane.mode, PaneMode::Snapshot(0));
    assert!(harness.query_by_label("A alone").is_none());
}

#[test]
fn one_escape_closes_the_dialog_for_files_though_its_field_has_the_keyboard() {
    let mut harness = harness();
    for action in [Action::ShowSaveDialog(FileKind::Session), Action::ShowOpenDialog(FileKind::Session)] {
        harness.state_mut().perform(action.clone());
        harness.run_steps(5);
        assert!(harness.state().dialogs.files.is_open());
        harness.key_press(Key::Escape);
        harness.run_steps(3);
        assert!(!harness.state().dialogs.files.is_open(), "{action:?}");
    }
}

#[test]
fn every_key_is_listed_under_its_heading() {
    let mut harness = harness();
    harness.key_press(Key::F1);
    harness.run_steps(3);
    for heading in ["Files", "Editing", "Picture", "Camera", "Bodies and lights", "Sliders and numbers", "Window"] {
        assert!(harness.query_all_by_label(heading).next().is_some(), "{heading}");
    }
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label("Sliders and numbers").is_none());
}

#[test]
fn the_session_gives_a_number_of_passes_or_leaves_it_to_the_settings() {
    let mut harness = harness();
    let samples = |harness: &Harness<'_, App>| harness.state().workshop.settings().samples;
    let default = harness.state().user_state.settings.samples;
    assert_eq!(samples(&harness), Some(1));
    let click = |harness: &mut Harness<'_, App>| {
        harness.get_by_label("Picture").click();
        harness.run_steps(3);
        harness.get_by_label(&format!("as in the settings ({default})")).click();
        harness.run_steps(3);
        harness.key_press(Key::Escape);
        harness.run_steps(3);
    };
    click(&mut harness);
    assert_eq!((samples(&harness), harness.state().workshop.samples()), (None, default));
    assert!(harness.state().session_is_unsaved());
    click(&mut harness);
    assert_eq!(samples(&harness), Some(default), "a number of its own, the same at first");
}

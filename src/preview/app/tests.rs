//! The workshop driven without a window.

use super::*;
use crate::workspace::OwnerId;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

mod comparing;
mod drafts;
mod drops;
mod environments;
mod fitting;
mod focus;
mod images;
mod instruments;
mod layout;
mod light;
mod menus;
mod meshes;
mod mistakes;
mod picture;
mod rows;
mod safety;
mod start;

fn harness() -> Harness<'static, App> {
    harness_in(None)
}

fn harness_in(folders: Option<&Folders>) -> Harness<'static, App> {
    let app = App::new(Some(&Location::Preset("studio".to_owned())), folders).expect("a built-in session");
    let mut harness =
        Harness::builder().with_size(egui::vec2(1100.0, 700.0)).build_ui_state(|ui, app: &mut App| app.draw(ui), app);
    harness.state_mut().pane.zoom = pane::Zoom::ACTUAL;
    // One pass: then nothing changes once there is a picture.
    let settings = harness.state().workshop.settings();
    let small = crate::workspace::session::PictureSettings { size: [64, 48], depth: 2, samples: Some(1), ..settings };
    harness.state_mut().workshop.set_picture(small).expect("a size in range");
    settle(&mut harness);
    harness
}

/// Waits until the picture is that of the values.
pub(super) fn settle(harness: &mut Harness<'_, App>) -> Vec<u32> {
    for _ in 0..30_000 {
        harness.step();
        if harness.state().workshop.is_up_to_date() {
            return harness.state().workshop.shown().pixels.clone();
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("no picture came");
}

#[test]
fn a_wrong_formula_is_marked_and_the_picture_stays_until_it_is_right() {
    let mut harness = harness();
    let first = settle(&mut harness);
    harness.state_mut().documents.formula.replace_text("formula;\n= N.L;\n");
    harness.get_by_label("Apply formula").click();
    assert!(settle(&mut harness) == first);
    harness.step();
    assert!(harness.query_by_label_contains("the formula yields a scalar").is_some(), "the list says what is wrong");
    // A click on it leads there, and what is typed then goes there.
    harness.get_by_label_contains("the formula yields a scalar").click();
    harness.run_steps(3);
    harness.event(egui::Event::Text("IL*Cd*".to_owned()));
    harness.run_steps(3);
    assert!(harness.state().documents.formula.text().contains("IL*Cd*"), "{}", harness.state().documents.formula.text());
    harness.state_mut().documents.formula.replace_text("formula;\n= IL*Cd*max(0, N.L);\n");
    harness.get_by_label("Apply formula").click();
    harness.step();
    assert!(settle(&mut harness) != first);
    assert!(harness.state().is_unsaved() && harness.state().title().contains('•'));
}

#[test]
fn bodies_are_chosen_and_locked_values_say_why() {
    let mut harness = harness();
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.step();
    harness.step();
    assert!(harness.query_all_by_label_contains("ball").count() >= 2, "the name of whose values are shown");
    let text = "body_specific; kd: scalar, constraint 0..1, slider; ks: scalar, constraint 0..1, slider;
        invariants; kd + ks = 1; formula; = kd*IL*Cd*max(0, N.L) + ks*IL;";
    harness.state_mut().documents.formula.replace_text(text);
    harness.get_by_label("Apply formula").click();
    settle(&mut harness);
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.step();
    harness.step();
    assert!(harness.query_by_label_contains("locked: ks").is_some());
}

#[test]
fn the_last_movement_counts_though_the_slider_is_let_go_with_it() {
    let mut harness = harness();
    let slider = harness.get_all_by_role(Role::Slider).next().expect("the slider of ka").rect();
    let at = |x: f32| slider.left_center() + egui::vec2(x, 0.0);
    let button = |pos: egui::Pos2, pressed: bool| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    let mut ended = Vec::new();
    // In a frame of its own, and in that in which the button goes up.
    for last in [vec![], vec![egui::Event::PointerMoved(at(90.0))]] {
        harness.input_mut().events.extend([egui::Event::PointerMoved(at(30.0)), button(at(30.0), true)]);
        harness.step();
        harness.input_mut().events.push(egui::Event::PointerMoved(at(60.0)));
        harness.step();
        if last.is_empty() {
            harness.input_mut().events.push(egui::Event::PointerMoved(at(90.0)));
            harness.step();
        }
        harness.input_mut().events.extend(last);
        harness.input_mut().events.push(button(at(90.0), false));
        harness.step();
        harness.step();
        assert!(harness.state().workshop.held().is_none());
        ended.push(harness.state().workshop.values().numbers().to_vec());
    }
    assert_eq!(ended[0], ended[1]);
    assert!(harness.state_mut().workshop.undo() && harness.state_mut().workshop.undo());
}

#[test]
fn a_number_that_cannot_be_is_brought_back_with_a_word() {
    let mut harness = harness();
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    let enter = |harness: &mut Harness<'_, App>, number: &str| {
        let beside = harness.get_by_label("kd").rect().center().y;
        let is_beside = |field: &egui_kittest::Node<'_>| (field.rect().center().y - beside).abs() < 6.0;
        harness.get_all_by_role(Role::SpinButton).find(is_beside).expect("a field beside its name").click();
        harness.run_steps(3);
        // Entering begins with the number that is there, selected.
        harness.event(egui::Event::Text(number.to_owned()));
        harness.key_press(egui::Key::Enter);
        harness.run_steps(4);
    };
    let said = |harness: &Harness<'_, App>| {
        let mut notes = harness.query_all_by_label_contains(" here");
        notes.next().and_then(|note| note.value())
    };
    assert_eq!(said(&harness), None);
    enter(&mut harness, "0.97");
    let note = said(&harness).expect("a word");
    assert!(note.starts_with("kd is from 0 to 0.") && note.ends_with(": the invariants allow no more"), "{note}");
    enter(&mut harness, "0.25");
    assert_eq!(said(&harness), None);
    enter(&mut harness, "-3");
    assert!(said(&harness).is_some());
}

#[test]
fn the_last_entry_of_a_menu_is_seen_at_once_where_there_is_room() {
    let mut harness = harness();
    harness.get_by_label("File").click();
    harness.run_steps(3);
    let quit = harness.get_by_label_contains("Quit").rect();
    assert!(quit.bottom() < 640.0 && harness.get_by_label_contains("New session").rect().top() > 20.0, "{quit:?}");
    harness.get_by_label_contains("Quit").click();
    harness.run_steps(3);
    assert!(harness.state().closing);
}

#[test]
fn nothing_is_done_behind_a_dialog_and_enter_answers_a_message() {
    let mut harness = harness();
    let toggled = |harness: &mut Harness<'_, App>| {
        let before = harness.state().panels.log;
        harness.key_press(egui::Key::F12);
        harness.run_steps(3);
        harness.state().panels.log != before
    };
    assert!(toggled(&mut harness));
    harness.state_mut().perform(Action::ShowSettings);
    harness.run_steps(3);
    assert!(!toggled(&mut harness), "behind the settings");
    harness.get_by_label("Cancel").click();
    harness.run_steps(3);
    harness.state_mut().perform(Action::ShowOpenDialog(FileKind::Scene));
    harness.run_steps(3);
    assert!(!toggled(&mut harness), "behind the dialog for files");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    harness.state_mut().dialogs.show_message("A title", "a text");
    harness.run_steps(3);
    assert!(!toggled(&mut harness), "behind a message");
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    assert!(harness.state().dialogs.message().is_none() && toggled(&mut harness));
}

#[test]
fn ambient_light_has_an_entry_of_its_own_and_the_scene_has_all() {
    let mut harness = harness();
    assert!(["ka", "Ia", "background"].iter().all(|name| harness.query_by_label(name).is_some()));
    harness.get_by_label("Ambient light").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("ka").is_some() && harness.query_by_label("background").is_none());
    let in_list = |entry: &egui_kittest::Node<'_>| entry.rect().left() > 700.0;
    harness.get_all_by_label("Scene").find(in_list).expect("an entry").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("background").is_some());
}

#[test]
fn sessions_and_texts_are_saved_and_come_back() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    let [session, formula] = ["my.toml", "my.formula"].map(|name| folder.path().join(name));
    let app = harness.state_mut();
    app.documents.formula.replace_text("formula;\n= IL*Cd*max(0, N.L);\n");
    app.perform(Action::Apply);
    app.perform(Action::SaveTo(Some(FileKind::Formula), formula.clone()));
    app.perform(Action::SaveTo(Some(FileKind::Session), session.clone()));
    assert!(!app.is_unsaved(), "{:?}", app.dialogs.message());
    let before = settle(&mut harness);
    let app = harness.state_mut();
    app.perform(Action::Open(FileKind::Session, Location::Preset("glass".to_owned())));
    app.perform(Action::Open(FileKind::Session, Location::File(session.clone())));
    assert!(!app.is_unsaved());
    assert_eq!(app.documents.formula.text(), "formula;\n= IL*Cd*max(0, N.L);\n");
    assert!(settle(&mut harness) == before);
    let app = harness.state_mut();
    app.perform(Action::Open(FileKind::Session, Location::new("nowhere.toml")));
    assert!(app.dialogs.message().is_some_and(|told| told.contains("nowhere.toml")));
    app.perform(Action::SaveTo(Some(FileKind::Session), folder.path().join("no/such/folder.toml")));
    assert!(app.dialogs.message().is_some_and(|told| told.contains("unharmed")));
    let picture = folder.path().join("picture.png");
    app.perform(Action::SaveTo(None, picture.clone()));
    app.jobs.finish();
    assert!(std::fs::read(picture).is_ok_and(|bytes| bytes.starts_with(&[0x89, b'P', b'N', b'G'])));
}

#[test]
fn materials_are_given_to_bodies_and_undone() {
    let mut harness = harness();
    let before = settle(&mut harness);
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    let numbers = harness.state().workshop.values().numbers().to_vec();
    let app = harness.state_mut();
    let shelf = crate::workspace::materials::LibraryLocation::find(Some("preset:phong"), None, None)
        .map(|location| crate::workspace::materials::Materials::open(location, Readable::Regular));
    let (shelf, _) = shelf.expect("a location").expect("a library");
    let (owner, gold) = (app.workshop.values().table().owners().named("ball"), shelf.get("gold").expect("a material"));
    let Some(crate::workspace::OwnerId::Body(body)) = owner else { panic!("a body") };
    let (given, _) = gold.assignments(app.workshop.values().table(), body);
    app.workshop.change(|values| {
        values.assign(&given);
    });
    assert!(settle(&mut harness) != before);
    harness.state_mut().perform(Action::Undo);
    assert!(settle(&mut harness) == before && harness.state().workshop.values().numbers() == numbers);
}

#[test]
fn a_slider_is_dragged_and_reported_of_and_undone_by_keys() {
    let mut harness = harness();
    let before = settle(&mut harness);
    let lines = Rc::new(RefCell::new(Vec::new()));
    let told = Rc::clone(&lines);
    harness.state_mut().set_log_listener(move |line| told.borrow_mut().push(line.to_owned()));
    let slider = harness.get_all_by_role(Role::Slider).next().expect("the slider of ka").rect();
    harness.drag_at(slider.left_center() + egui::vec2(30.0, 0.0));
    harness.run_steps(2);
    for step in 0..10 {
        harness.hover_at(slider.left_center() + egui::vec2(30.0 + 8.0 * step as f32, 0.0));
        harness.run_steps(1);
        // Each step has its picture: the first is drawn before there is anything to draw it quickly with.
        settle(&mut harness);
        // As the window asks for it, with the picture of the values as they are.
        harness.state_mut().picture();
    }
    assert!(harness.state().workshop.held().is_some());
    let held = settle(&mut harness);
    harness.drop_at(slider.left_center() + egui::vec2(102.0, 0.0));
    harness.run_steps(2);
    assert!(harness.state().workshop.held().is_none());
    assert!(settle(&mut harness) == held && held != before);
    harness.run_steps(3);
    assert!(lines.borrow().iter().any(|line| line.starts_with("dragged ka: images")), "{:?}", lines.borrow());
    harness.key_press_modifiers(egui::Modifiers::ALT, egui::Key::Z);
    harness.run_steps(2);
    assert!(settle(&mut harness) == before);
    // Where no text is typed, the usual keys do it too.
    harness.key_press_modifiers(egui::Modifiers::COMMAND | egui::Modifiers::SHIFT, egui::Key::Z);
    harness.run_steps(2);
    assert!(settle(&mut harness) == held);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    harness.run_steps(2);
    assert!(settle(&mut harness) == before);
    // In the text they undo what was typed.
    harness.state_mut().editor.focus();
    harness.run_steps(2);
    let text = harness.state().documents.formula.text().to_owned();
    harness.event(egui::Event::Text("x".to_owned()));
    harness.run_steps(2);
    assert_ne!(harness.state().documents.formula.text(), text);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
    harness.run_steps(2);
    assert_eq!(harness.state().documents.formula.text(), text);
    assert!(harness.state().workshop.can_undo_and_redo()[1]);
}

#[test]
fn a_session_is_saved_after_its_texts_or_not_at_all() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    let app = harness.state_mut();
    app.perform(Action::SaveTo(Some(FileKind::Session), folder.path().join("one.toml")));
    assert!(!app.dialogs.files.is_open());
    // The changes of a built-in text need a file.
    let text = "formula;\n= IL*Cd*max(0, N.L);\n";
    app.documents.formula.replace_text(text);
    let session = folder.path().join("other.toml");
    app.perform(Action::SaveTo(Some(FileKind::Session), session.clone()));
    assert!(app.dialogs.files.is_open() && !session.exists());
    // As the dialog does when it is cancelled.
    app.perform(Action::StopSaving);
    assert_eq!(app.confirmation.text(), "not saved: the formula and the session other.toml");
    let formula = folder.path().join("other.formula");
    app.perform(Action::SaveTo(Some(FileKind::Formula), formula.clone()));
    assert!(formula.exists() && !session.exists(), "the session is no longer waited for");
    assert_eq!(app.documents.formula.text(), text);
}

#[test]
fn a_material_is_saved_under_a_name_and_given_again() {
    let home = tempfile::tempdir().expect("a folder");
    let mut harness = harness_in(Some(&Folders::below(home.path())));
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    let kept = settle(&mut harness);
    fn materials<'h>(harness: &'h Harness<'_, App>) -> egui_kittest::Node<'h> {
        let panel = |node: &egui_kittest::Node<'_>| node.rect().left() > 790.0;
        harness.get_all_by_role(Role::ComboBox).find(panel).expect("the list of materials")
    }
    let button = harness.get_by_label("Save material").rect().center().y;
    let beside = |node: &egui_kittest::Node<'_>| (node.rect().center().y - button).abs() < 4.0;
    let field = harness.get_all_by_role(Role::TextInput).rfind(beside).expect("the field for the name");
    field.focus();
    field.type_text("my own");
    harness.run_steps(3);
    harness.get_by_label("Save material").click();
    harness.run_steps(3);
    let app = harness.state_mut();
    let ball = app.workshop.values().table().owners().named("ball").expect("a body");
    let kd = app.workshop.values().table().parameter_named("kd").expect("a parameter");
    app.workshop.set(ball, kd, [0.0; 3]);
    assert!(settle(&mut harness) != kept);
    // The list of materials, and in it the one of that name.
    materials(&harness).click();
    harness.run_steps(3);
    harness.get_by_label("my own").scroll_to_me();
    harness.run_steps(20);
    harness.get_by_label("my own").click();
    harness.run_steps(3);
    assert!(settle(&mut harness) == kept);
    // It outlives the window.
    harness.state_mut().closing();
    drop(harness);
    let mut harness = harness_in(Some(&Folders::below(home.path())));
    assert!(harness.state().user_state.draft_names().len() == 1 && !harness.state().user_state.has_important_drafts());
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    materials(&harness).click();
    harness.run_steps(3);
    assert!(harness.query_by_label("my own").is_some());
}

#[test]
fn new_sessions_begin_as_the_settings_say() {
    let mut harness = harness();
    let app = harness.state_mut();
    let mut settings = crate::user_data::settings::Settings { depth: 1, size: [40, 30], ..app.user_state.settings.clone() };
    settings.defaults.set(crate::lang::variables::Predefined::Background, [0.25, 0.5, 0.75]);
    app.perform(Action::SaveSettings(Box::new(settings)));
    app.perform(Action::NewSession);
    assert_eq!((app.workshop.settings().depth, app.workshop.settings().size), (1, [40, 30]));
    let background = app.workshop.formula().predefined(crate::lang::variables::Predefined::Background);
    assert_eq!(app.workshop.values().global(background), [0.25, 0.5, 0.75]);
    assert_eq!(settle(&mut harness).len(), 40 * 30);
    // The dialog shows what is kept, and keeps nothing that is cancelled.
    harness.state_mut().perform(Action::ShowSettings);
    harness.run_steps(3);
    harness.get_by_label("Cancel").click();
    harness.run_steps(3);
    assert!(harness.query_by_label("Cancel").is_none() && harness.state().user_state.settings.depth == 1);
}

#[test]
fn a_text_that_is_not_saved_is_not_lost_without_asking() {
    let mut harness = harness();
    harness.state_mut().documents.formula.replace_text("formula;\n= IL;\n");
    for action in [Action::New(FileKind::Formula), Action::Open(FileKind::Session, Location::Preset("glass".to_owned()))] {
        harness.state_mut().perform(action);
        harness.run_steps(3);
        harness.get_by_label("Cancel").click();
        harness.run_steps(3);
        assert_eq!(harness.state().documents.formula.text(), "formula;\n= IL;\n");
    }
    // The scene is as it was: nothing is lost by another one.
    harness.state_mut().perform(Action::New(FileKind::Scene));
    assert!(harness.query_by_label("Discard").is_none());
    harness.state_mut().perform(Action::New(FileKind::Formula));
    harness.run_steps(3);
    harness.get_by_label("Discard").click();
    harness.run_steps(3);
    assert!(harness.state().documents.formula.text().contains("max(0, N.L)"));
}

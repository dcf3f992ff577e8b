//! The workshop driven without a window.

use super::*;
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

mod comparing;
mod focus;
mod layout;
mod light;
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
    let small = crate::workspace::session::PictureSettings { size: [64, 48], depth: 2, ..harness.state().workshop.settings() };
    harness.state_mut().workshop.set_picture(small).expect("a size in range");
    settle(&mut harness);
    harness
}

/// Waits until the picture is that of the values.
fn settle(harness: &mut Harness<'_, App>) -> Vec<u32> {
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
    assert!(note.starts_with("kd is from 0 to 0.") && note.ends_with(", by invariants"), "{note}");
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
fn what_is_unsaved_is_offered_again_and_settings_last() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let mut app = App::new(Some(&Location::Preset("studio".to_owned())), Some(&folders)).expect("a built-in session");
    app.documents.formula.replace_text("formula;\n= N;\n");
    app.perform(Action::SetTheme(crate::user_data::settings::ThemeSetting::Light));
    app.perform(Action::ApplyAsYouType(true));
    app.perform(Action::UseAsStartupSession);
    app.closing();
    drop(app);
    let mut app = App::new(None, Some(&folders)).expect("the startup session");
    assert_eq!((app.theme, app.session.clone()), (Theme::Light, Some(Location::Preset("studio".to_owned()))));
    assert!(app.user_state.settings.window.apply_as_you_type && app.user_state.draft_names().len() == 1);
    app.perform(Action::RestoreDrafts);
    assert_eq!(app.documents.formula.text(), "formula;\n= N;\n");
    assert!(app.documents.formula.unsaved() && app.user_state.draft_names().is_empty());
}

#[test]
fn values_that_are_unsaved_are_offered_again_with_the_texts_that_they_are_of() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let session = Location::Preset("studio".to_owned());
    let mut app = App::new(Some(&session), Some(&folders)).expect("a built-in session");
    // A parameter that only the unsaved text has, of a text without a file.
    app.perform(Action::New(FileKind::Formula));
    app.documents.formula.replace_text("body_specific; own: scalar, constraint 0..1; formula; = own*IL*Cd;");
    app.perform(Action::Apply);
    let label = |app: &App, wanted: &str| {
        let values = app.workshop.values();
        let mut all = values.iter();
        all.find(|(owner, id, _)| values.table().label(*owner, *id) == wanted).map(|(owner, id, _)| (owner, id)).expect(wanted)
    };
    let (owner, own) = label(&app, "ball.own");
    app.workshop.set(owner, own, [0.625; 3]);
    let (scene, ka) = label(&app, "ka");
    app.workshop.set(scene, ka, [0.375; 3]);
    let numbers = app.workshop.values().numbers().to_vec();
    app.closing();
    drop(app);
    let mut app = App::new(None, Some(&folders)).expect("the startup session");
    assert_eq!(app.user_state.draft_names(), ["formula without a file", "values of the session preset:studio"]);
    assert!(app.workshop.values().numbers() != numbers);
    app.perform(Action::RestoreDrafts);
    assert_eq!(app.workshop.values().numbers(), numbers);
    assert_eq!((app.session.as_ref(), app.documents.scene.location()), (Some(&session), Some(&session)));
    assert!(app.is_unsaved() && app.user_state.draft_names().is_empty());
    // What is saved is not offered.
    let path = home.path().join("own.formula");
    app.perform(Action::SaveTo(Some(FileKind::Formula), path));
    app.perform(Action::SaveTo(Some(FileKind::Session), home.path().join("own.toml")));
    assert!(!app.is_unsaved());
    app.closing();
    drop(app);
    assert!(App::new(None, Some(&folders)).expect("the startup session").user_state.draft_names().is_empty());
}

#[test]
fn values_of_built_in_sessions_are_left_once_and_not_asked_for() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    for name in ["studio", "sunset"] {
        let mut app = App::new(Some(&Location::Preset(name.to_owned())), Some(&folders)).expect("a built-in session");
        let ambient = app.workshop.formula().predefined(crate::lang::variables::Predefined::Ambient);
        app.workshop.set(crate::workspace::OwnerId::Global, ambient, [1.0; 3]);
        app.closing();
        drop(app);
        let app = App::new(None, Some(&folders)).expect("the startup session");
        assert!(
            app.user_state.draft_names().len() == 1 && !app.user_state.has_important_drafts(),
            "{:?}",
            app.user_state.draft_names()
        );
    }
}

/// Autosave, as it runs every few seconds.
fn keep(app: &mut App) {
    app.note_unsaved(&DraftSlot::ALL, app.unsaved_states());
    app.write_drafts();
    app.jobs.wait();
    app.jobs.results().into_iter().for_each(|result| app.handle_job_result(result));
}

/// Where drafts go, with something in the way of their folder.
fn obstructed() -> (tempfile::TempDir, Folders) {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    std::fs::create_dir_all(&folders.state).expect("a folder");
    std::fs::write(folders.state.join("drafts"), "").expect("a file");
    (home, folders)
}

/// The size of the picture is not saved in the other harnesses, which is unsaved work too.
fn harness_without_unsaved_work(folders: &Folders) -> Harness<'static, App> {
    let mut harness = harness_in(Some(folders));
    let app = harness.state_mut();
    app.note_saved_session();
    keep(app);
    app.notices.clear(Topic::Drafts);
    harness.run_steps(2);
    harness
}

#[test]
fn what_endangers_work_is_in_view_until_it_is_dismissed_or_over() {
    let (_home, folders) = obstructed();
    let mut harness = harness_without_unsaved_work(&folders);
    let seen = |harness: &mut Harness<'_, App>| {
        harness.run_steps(2);
        harness.query_by_label_contains("Unsaved work is not kept").is_some()
    };
    // What was left by earlier runs cannot be looked for either.
    assert!(harness.query_by_label_contains("Unsaved work of earlier runs may be missing").is_some());
    harness.get_by_label("Dismiss").click();
    harness.run_steps(2);
    assert!(!seen(&mut harness));
    harness.state_mut().documents.formula.replace_text("formula;\n= N;\n");
    keep(harness.state_mut());
    assert!(seen(&mut harness));
    harness.run_steps(30);
    assert!(seen(&mut harness), "it stays");
    assert!(harness.query_by_label_contains("cannot save the draft in").is_some(), "why");
    harness.get_by_label("Dismiss").click();
    harness.run_steps(2);
    assert!(!seen(&mut harness));
    keep(harness.state_mut());
    assert!(!seen(&mut harness), "the same is not said again");
    std::fs::remove_file(folders.state.join("drafts")).expect("the file");
    keep(harness.state_mut());
    assert!(!harness.state().user_state.is_behind(harness.state().unsaved_states()));
    // A new failure is news.
    std::fs::remove_dir_all(folders.state.join("drafts")).expect("the drafts");
    std::fs::write(folders.state.join("drafts"), "").expect("a file");
    harness.state_mut().documents.formula.replace_text("formula;\n= V;\n");
    keep(harness.state_mut());
    assert!(seen(&mut harness));
    // What is over goes by itself.
    std::fs::remove_file(folders.state.join("drafts")).expect("the file");
    keep(harness.state_mut());
    assert!(!seen(&mut harness));
}

#[test]
fn several_notices_are_stacked_and_dismissed_together() {
    let (_home, folders) = obstructed();
    std::fs::create_dir_all(&folders.configuration).expect("a folder");
    std::fs::write(folders.configuration.join("settings.toml"), "depth = [").expect("a file");
    std::fs::write(folders.state.join("recent.toml"), "scene = 3").expect("a file");
    let mut harness = harness_without_unsaved_work(&folders);
    harness.run_steps(2);
    let titles: Vec<String> = harness.state().notices.shown().iter().map(|notice| notice.title.clone()).collect();
    assert_eq!(titles.len(), 3);
    for title in &titles {
        assert!(harness.query_by_label(title).is_some(), "{title}");
    }
    assert!(harness.query_by_label("3 notices").is_some());
    harness.get_by_label("Dismiss all").click();
    harness.run_steps(2);
    assert!(harness.state().notices.is_empty() && harness.query_by_label("Dismiss").is_none());
}

#[test]
fn quitting_asks_where_work_cannot_be_kept() {
    let (_home, folders) = obstructed();
    for folders in [Some(&folders), None] {
        let mut harness = harness_in(folders);
        harness.state_mut().documents.formula.replace_text("formula;\n= N;\n");
        harness.state_mut().perform(Action::Quit);
        harness.run_steps(3);
        assert!(!harness.state().closing);
        assert!(harness.query_by_label_contains("They cannot be kept for the next start").is_some());
        harness.get_by_label("Cancel").click();
        harness.run_steps(3);
        harness.state_mut().perform(Action::Quit);
        harness.run_steps(3);
        harness.get_by_label("Discard").click();
        harness.run_steps(3);
        assert!(harness.state().closing);
        // Whoever closes the window in another way is at least told on the terminal.
        harness.state_mut().closing();
        assert!(
            harness.state().closing_errors()[0].starts_with("unsaved work is lost: "),
            "{:?}",
            harness.state().closing_errors()
        );
    }
}

#[test]
fn what_is_typed_is_noted_at_once_and_written_where_the_window_does_not_close() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let mut harness = harness_in(Some(&folders));
    harness.state_mut().documents.formula.replace_text("formula;\n= N;\n");
    harness.step();
    let last_resort = harness.state().last_resort();
    std::thread::spawn(last_resort).join().expect("an end");
    // The window is still there, as where Xlib ends the program; its lock goes with it.
    harness.state_mut().user_state = user_state::UserState::default();
    let app = App::new(None, Some(&folders)).expect("the startup session");
    assert!(app.user_state.draft_names().contains(&"formula preset:phong".to_owned()), "{:?}", app.user_state.draft_names());
}

#[cfg(unix)]
#[test]
fn pipes_in_place_of_what_the_window_reads_by_itself_do_not_hold_it_up() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let pipe = |path: &std::path::Path| {
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).expect("a pipe");
    };
    pipe(&folders.state.join("recent.toml"));
    pipe(&folders.state.join("drafts/1-a/lock"));
    pipe(&folders.state.join("drafts/2-b/0.toml"));
    pipe(&folders.data.join("materials/phong.toml"));
    let startup = home.path().join("startup.toml");
    pipe(&startup);
    std::fs::create_dir_all(&folders.configuration).expect("a folder");
    let settings = format!("version = 1\nstartup = {:?}\n", startup.display().to_string());
    std::fs::write(folders.configuration.join("settings.toml"), settings).expect("a file");
    let app = App::new(None, Some(&folders)).expect("the built-in session");
    let details = |app: &App, topic| {
        let notice = app.notices.shown().iter().find(|notice| notice.topic == topic);
        notice.unwrap_or_else(|| panic!("{topic:?}")).details.clone()
    };
    for topic in [Topic::Recent, Topic::LeftDrafts, Topic::Startup, Topic::Materials] {
        assert!(details(&app, topic).contains("a pipe"), "{}", details(&app, topic));
    }
    drop(app);
    // A session whose texts are pipes, one with a formula whose library is one, and pipes that are chosen in the
    // window.
    let session = home.path().join("session.toml");
    std::fs::write(&session, "version = 1\nformula = \"startup.toml\"\nscene = \"startup.toml\"\n").expect("a file");
    assert!(App::new(Some(&Location::File(session)), None).is_err_and(|error| error.contains("is a pipe, not a formula")));
    let formula = home.path().join("own.formula");
    std::fs::write(&formula, "#uses startup.toml;\nformula;\n= IL*Cd;\n").expect("a file");
    let mut app = App::new(Some(&Location::Preset("studio".to_owned())), None).expect("a built-in session");
    app.perform(Action::Open(FileKind::Formula, Location::File(formula)));
    assert!(details(&app, Topic::Materials).contains("is a pipe, not a material library"));
    for kind in [FileKind::Formula, FileKind::Scene, FileKind::Session] {
        app.perform(Action::Open(kind, Location::File(startup.clone())));
        assert!(app.dialogs.message().is_some_and(|told| told.contains("is a pipe")), "{:?}", app.dialogs.message());
    }
    app.perform(Action::SaveTo(Some(FileKind::Formula), startup.clone()));
    assert!(app.dialogs.message().is_some_and(|told| told.contains("is a pipe")), "{:?}", app.dialogs.message());
    // The settings themselves.
    std::fs::remove_file(folders.configuration.join("settings.toml")).expect("the file");
    pipe(&folders.configuration.join("settings.toml"));
    let app = App::new(None, Some(&folders)).expect("the built-in session");
    assert!(details(&app, Topic::Settings).contains("is a pipe"));
}

#[test]
fn texts_that_could_not_be_kept_are_kept_as_soon_as_that_is_possible() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let mut app = App::new(Some(&Location::Preset("studio".to_owned())), Some(&folders)).expect("a built-in session");
    let lines = Rc::new(RefCell::new(Vec::new()));
    let told = Rc::clone(&lines);
    app.set_log_listener(move |line| told.borrow_mut().push(line.to_owned()));
    // Something is in the way of the folder.
    std::fs::create_dir_all(&folders.state).expect("a folder");
    let path = folders.state.join("drafts");
    std::fs::write(&path, "").expect("a file");
    app.documents.formula.replace_text("formula;\n= N;\n");
    keep(&mut app);
    assert!(lines.borrow().iter().any(|line| line.starts_with("Unsaved work is not kept")), "{:?}", lines.borrow());
    assert!(app.user_state.is_behind(app.unsaved_states()));
    std::fs::remove_file(&path).expect("the file");
    keep(&mut app);
    assert!(!app.user_state.is_behind(app.unsaved_states()));
    drop(app);
    let app = App::new(None, Some(&folders)).expect("the startup session");
    assert_eq!(app.user_state.draft_names().len(), 1);
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
fn a_session_is_saved_with_a_word_of_what_is_not_in_it() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    let app = harness.state_mut();
    app.perform(Action::SaveTo(Some(FileKind::Session), folder.path().join("one.toml")));
    assert_eq!(app.dialogs.message(), None);
    app.documents.formula.replace_text("formula;\n= IL*Cd*max(0, N.L);\n");
    app.perform(Action::SaveTo(Some(FileKind::Session), folder.path().join("other.toml")));
    let asked = app.dialogs.message().expect("a question");
    assert!(asked.contains("What you changed in the formula is in no file yet"), "{asked}");
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

//! Unsaved work that is kept, and what is told when it cannot be.

use super::*;
use crate::preview::app::autosave::DraftSlot;

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
fn a_text_comes_back_in_the_session_that_it_was_open_in() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let path = home.path().join("own.toml");
    let mut app = App::new(Some(&Location::Preset("sunset".to_owned())), Some(&folders)).expect("a built-in session");
    app.perform(Action::SaveTo(Some(FileKind::Session), path.clone()));
    assert!(!app.is_unsaved());
    app.documents.formula.replace_text("formula;\n= N;\n");
    app.closing();
    drop(app);
    let mut app = App::new(None, Some(&folders)).expect("the startup session");
    assert_eq!(app.user_state.draft_names().len(), 1, "the session is saved");
    app.perform(Action::RestoreDrafts);
    assert_eq!((app.session.as_ref(), app.documents.formula.text()), (Some(&Location::File(path)), "formula;\n= N;\n"));
    assert_eq!(app.documents.scene.location(), Some(&Location::Preset("sunset".to_owned())));
    assert!(app.documents.formula.unsaved());
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
    let app = App::new(Some(&Location::File(session)), None).expect("a session that can be read");
    assert!(details(&app, Topic::Mistakes).contains("is a pipe, not a formula"), "{}", details(&app, Topic::Mistakes));
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

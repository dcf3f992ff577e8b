//! Sessions with mistakes are open as far as they can be used, wherever they come from. Pictures that are black say
//! why.

use super::*;
use crate::workspace::OwnerId;
use std::path::Path;

const FORMULA: &str = "body_specific;
kd: scalar, constraint 0..1, default 0.5;
formula;
= kd*IL*Cd*max(0, N.L);
";
const SCENE: &str = "bodies;
ball: sphere, center <0,0,0>, radius 1;
lights;
key: point, <4,6,5>;
camera;
position <0,1,6>; gaze <0,-0.15,-1>; up <0,1,0>; fov 40;
";
const SESSION: &str = "version = 1
formula = \"own.formula\"
scene = \"own.scene\"
size = [48, 36]
depth = 2
[bodies.ball]
Cd = [1.0, 0.5, 0.25]
kd = 0.125
";

/// A folder with a session of these texts; an empty text is no file. Returns the location of the session.
fn session_in(folder: &Path, formula: &str, scene: &str, session: &str) -> Location {
    for (name, text) in [("own.formula", formula), ("own.scene", scene), ("own.toml", session)] {
        if !text.is_empty() {
            std::fs::write(folder.join(name), text).expect("a file");
        }
    }
    Location::File(folder.join("own.toml"))
}

fn harness_of(app: App) -> Harness<'static, App> {
    let mut harness =
        Harness::builder().with_size(egui::vec2(1100.0, 700.0)).build_ui_state(|ui, app: &mut App| app.draw(ui), app);
    settle(&mut harness);
    harness.run_steps(2);
    harness
}

fn notice(app: &App) -> Option<&Notice> {
    app.notices.shown().iter().find(|notice| notice.topic == Topic::Mistakes)
}

/// The value of kd of the ball.
fn kd(app: &App) -> Vec<f32> {
    let values = app.workshop.values();
    let ball = values.table().owners().named("ball").expect("a body");
    values.get(ball, values.table().parameter_named("kd").expect("a parameter")).to_vec()
}

#[test]
fn a_wrong_formula_is_marked_in_its_text_however_the_session_is_opened() {
    let folder = tempfile::tempdir().expect("a folder");
    let wrong = FORMULA.replace("N.L", "N.Lx");
    let session = session_in(folder.path(), &wrong, SCENE, SESSION);
    let folders = Folders::below(&folder.path().join("home"));
    std::fs::create_dir_all(&folders.configuration).expect("a folder");
    let startup = format!("version = 1\nstartup = {:?}\n", session.to_string());
    std::fs::write(folders.configuration.join("settings.toml"), startup).expect("a file");
    let from_menu = || {
        let mut app = App::new(Some(&Location::Preset("studio".to_owned())), None).expect("a built-in session");
        app.perform(Action::Open(FileKind::Session, session.clone()));
        app
    };
    let apps = [App::new(Some(&session), None).expect("a session"), from_menu(), App::new(None, Some(&folders)).expect("one")];
    for app in apps {
        let mut harness = harness_of(app);
        let app = harness.state();
        assert_eq!((app.session.as_ref(), app.documents.formula.text()), (Some(&session), wrong.as_str()));
        assert_eq!((app.documents.formula.counts(), app.tab), ([1, 0], TextTab::Formula));
        assert!(!app.is_unsaved() && !app.documents.formula.is_applied() && app.documents.scene.is_applied());
        let told = notice(app).expect("a notice");
        assert!(told.title.ends_with("own.toml is open with mistakes"), "{}", told.title);
        assert!(told.details.contains("own.formula has a mistake. It is marked in the text."), "{}", told.details);
        assert!(told.details.contains("The values of kd are kept for that."), "{}", told.details);
        assert!(harness.query_by_label_contains("`Lx` is not known").is_some(), "the list of problems");
        let plain = harness.state().workshop.shown().pixels.clone();
        assert!(plain.iter().any(|pixel| pixel & 0xff_0000 > 0x40_0000), "the scene is seen");
        let note = harness.state().pane.note.clone().expect("a note on the picture");
        assert!(note.text.starts_with("The scene with a plain matte formula") && !note.is_central, "{note:?}");
        // The values come with the text.
        harness.state_mut().documents.formula.replace_text(FORMULA);
        harness.state_mut().perform(Action::Apply);
        assert!(settle(&mut harness) != plain);
        let app = harness.state();
        assert_eq!(kd(app), [0.125]);
        assert!(notice(app).is_none() && app.documents.formula.unsaved() && !app.session_is_unsaved());
        harness.run_steps(2);
        assert_eq!(harness.state().pane.note, None);
    }
}

#[test]
fn a_session_of_a_wrong_scene_keeps_its_values_even_if_it_is_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let session = session_in(folder.path(), FORMULA, &SCENE.replace("radius 1", "radius -1"), SESSION);
    let mut harness = harness_of(App::new(Some(&session), None).expect("a session"));
    assert_eq!(harness.state().tab, TextTab::Scene);
    let note = harness.state().pane.note.clone().expect("a note in place of the picture");
    assert!(note.is_central && note.text.contains("There is no picture") && note.text.contains("own.scene"), "{note:?}");
    harness.state_mut().perform(Action::SaveSession);
    let saved = std::fs::read_to_string(folder.path().join("own.toml")).expect("a file");
    assert!(saved.contains("kd = 0.125") && saved.contains("own.scene"), "{saved}");
    harness.state_mut().documents.scene.replace_text(SCENE);
    harness.state_mut().perform(Action::Apply);
    settle(&mut harness);
    harness.run_steps(2);
    assert_eq!((kd(harness.state()), harness.state().pane.note.clone()), (vec![0.125], None));
}

#[test]
fn a_missing_text_says_where_it_was_looked_for_and_can_be_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let session = session_in(folder.path(), "", SCENE, SESSION);
    let mut harness = harness_of(App::new(Some(&session), None).expect("a session"));
    let app = harness.state_mut();
    let path = folder.path().join("own.formula");
    let details = notice(app).expect("a notice").details.clone();
    assert!(details.contains(&path.display().to_string()) && details.contains("there is no such file"), "{details}");
    assert!(app.documents.formula.diagnostics()[0].message().starts_with("cannot read the formula"));
    app.perform(Action::Apply);
    assert!(app.documents.formula.diagnostics()[0].message().starts_with("cannot read the formula"));
    app.documents.formula.replace_text(FORMULA);
    app.perform(Action::Apply);
    app.perform(Action::Save);
    assert_eq!(std::fs::read_to_string(path).expect("a file"), FORMULA);
    assert_eq!(kd(app), [0.125]);
    assert!(!app.is_unsaved() && notice(app).is_none());
}

#[test]
fn a_file_that_cannot_be_read_is_not_overwritten_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let session = session_in(folder.path(), "", SCENE, SESSION);
    let path = folder.path().join("own.formula");
    std::fs::write(&path, b"// \xe9t\xe9\nformula;\n= Cd;\n").expect("a file");
    let mut app = App::new(Some(&session), None).expect("a session");
    assert!(notice(&app).expect("a notice").details.contains("is not UTF-8"));
    app.documents.formula.replace_text(FORMULA);
    app.perform(Action::Save);
    assert!(app.dialogs.files.is_open());
    assert!(std::fs::read(&path).expect("a file").starts_with(b"// \xe9"));
}

#[test]
fn mistakes_in_the_session_itself_are_listed_and_its_file_is_not_overwritten_unasked() {
    let folder = tempfile::tempdir().expect("a folder");
    let wrong = SESSION.replace("depth = 2", "depth = \"deep\"");
    let session = session_in(folder.path(), FORMULA, SCENE, &wrong);
    let mut app = App::new(Some(&session), None).expect("a session");
    assert_eq!((kd(&app), app.workshop.settings().depth), (vec![0.125], 5));
    let details = &notice(&app).expect("a notice").details;
    assert!(details.contains("own.toml:5:9: error: expected a whole number from 1 to 9"), "{details}");
    app.perform(Action::SaveSession);
    assert!(app.dialogs.files.is_open());
    app.perform(Action::SaveTo(Some(FileKind::Session), folder.path().join("own.toml")));
    assert!(notice(&app).is_none() && !app.is_unsaved());
    // A text that is no session at all leaves everything as it was.
    std::fs::write(folder.path().join("torn.toml"), "version = 1\nformula = \"x").expect("a file");
    app.perform(Action::Open(FileKind::Session, Location::File(folder.path().join("torn.toml"))));
    assert!(app.dialogs.message().is_some_and(|told| told.contains("torn.toml:2:")), "{:?}", app.dialogs.message());
    assert_eq!(app.session, Some(session));
}

#[test]
fn values_of_parameters_that_are_gone_for_a_while_come_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let session = session_in(folder.path(), FORMULA, SCENE, SESSION);
    let mut app = App::new(Some(&session), None).expect("a session");
    let lines = Rc::new(RefCell::new(Vec::new()));
    let told = Rc::clone(&lines);
    app.set_log_listener(move |line| told.borrow_mut().push(line.to_owned()));
    for text in [&FORMULA.replace("kd", "diffuse"), FORMULA] {
        app.documents.formula.replace_text(text);
        app.perform(Action::Apply);
    }
    assert_eq!(kd(&app), [0.125]);
    let lines = lines.borrow();
    let carried: Vec<&String> = lines.iter().filter(|line| line.contains("values kept by name")).collect();
    assert!(carried[0].ends_with("; the formula has no kd") && carried[0].contains("Cd"), "{carried:?}");
}

#[test]
fn a_black_picture_says_why_until_it_is_not_black() {
    let mut harness = harness();
    let values = harness.state().workshop.values().clone();
    let id = |name: &str| values.table().parameter_named(name).expect("a parameter");
    for name in ["ka", "background"] {
        harness.state_mut().workshop.set(OwnerId::Global, id(name), [0.0; 3]);
    }
    for light in values.table().owners().of_kind(crate::lang::variables::Owner::Light) {
        harness.state_mut().workshop.set(light, id("ki"), [0.0; 3]);
    }
    settle(&mut harness);
    // The review comes after the picture.
    for _ in 0..1000 {
        harness.step();
        if harness.state().pane.note.is_some() {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let note = harness.state().pane.note.clone().expect("a note");
    assert_eq!(note.text, "The picture is black: ki, ka are 0 everywhere; another value of any of them shows something");
    harness.state_mut().workshop.set(OwnerId::Global, id("ka"), [0.5; 3]);
    settle(&mut harness);
    for _ in 0..1000 {
        harness.step();
        if harness.state().pane.note.is_none() {
            return;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("{:?}", harness.state().pane.note);
}

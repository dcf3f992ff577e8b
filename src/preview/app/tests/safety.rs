//! Nothing is lost by a slip: saving before something is replaced, materials that are deleted or overwritten, and what
//! is said about it.

use super::*;
use crate::workspace::OwnerId;
use crate::workspace::materials::{LibraryLocation, Materials};

const CHANGED: &str = "formula;\n= IL*Cd*max(0, N.L);\n";

fn click(harness: &mut Harness<'_, App>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

#[test]
fn what_would_be_lost_is_saved_before_the_action_goes_on() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    let own = folder.path().join("own.formula");
    let app = harness.state_mut();
    app.perform(Action::SaveTo(Some(FileKind::Formula), own.clone()));
    app.note_saved_session();
    app.documents.formula.replace_text(CHANGED);
    app.perform(Action::Open(FileKind::Session, Location::Preset("glass".to_owned())));
    harness.run_steps(3);
    click(&mut harness, "Save");
    assert_eq!(std::fs::read_to_string(&own).expect("a file"), CHANGED);
    assert_eq!(harness.state().session, Some(Location::Preset("glass".to_owned())));
    assert!(harness.query_by_label_contains("saved").is_some(), "a confirmation is in view");
}

#[test]
fn what_has_no_file_is_asked_for_and_cancelling_stops() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    harness.state_mut().note_saved_session();
    harness.state_mut().documents.formula.replace_text(CHANGED);
    let glass = Action::Open(FileKind::Session, Location::Preset("glass".to_owned()));
    harness.state_mut().perform(glass.clone());
    harness.run_steps(3);
    click(&mut harness, "Save");
    assert!(harness.state().dialogs.files.is_open());
    // The first leaves the field with the name.
    for _ in 0..2 {
        harness.key_press(egui::Key::Escape);
        harness.run_steps(3);
    }
    assert!(!harness.state().dialogs.files.is_open() && harness.state().documents.formula.unsaved());
    assert!(harness.state().pending_save.is_none());
    // A file that is saved later does not go on with what was cancelled.
    let own = folder.path().join("own.formula");
    harness.state_mut().perform(Action::SaveTo(Some(FileKind::Formula), own.clone()));
    assert_eq!(harness.state().session, Some(Location::Preset("studio".to_owned())));
    // With a name, the action goes on.
    harness.state_mut().documents.formula.replace_text("formula;\n= IL;\n");
    harness.state_mut().note_saved_session();
    harness.state_mut().perform(glass);
    harness.run_steps(3);
    click(&mut harness, "Save");
    assert_eq!(std::fs::read_to_string(own).expect("a file"), "formula;\n= IL;\n");
    assert_eq!(harness.state().session, Some(Location::Preset("glass".to_owned())));
}

#[test]
fn a_session_of_a_text_without_a_file_saves_the_text_first() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    let [session, formula] = ["my.toml", "my.formula"].map(|name| folder.path().join(name));
    let app = harness.state_mut();
    app.perform(Action::New(FileKind::Formula));
    app.perform(Action::SaveTo(Some(FileKind::Session), session.clone()));
    assert!(app.dialogs.files.is_open() && !session.exists());
    harness.run_steps(3);
    let is_suggested = |field: egui_kittest::Node<'_>| field.value().is_some_and(|name| name == "my.formula");
    assert!(harness.get_all_by_role(Role::TextInput).any(is_suggested), "the name of the session");
    let app = harness.state_mut();
    // As the dialog does when a name was entered.
    app.perform(Action::SaveTo(Some(FileKind::Formula), formula.clone()));
    assert!(formula.exists() && std::fs::read_to_string(session).is_ok_and(|text| text.contains("my.formula")));
    assert!(!app.is_unsaved());
}

#[test]
fn a_session_is_saved_after_a_changed_text() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    let [session, formula] = ["my.toml", "my.formula"].map(|name| folder.path().join(name));
    let app = harness.state_mut();
    app.perform(Action::SaveTo(Some(FileKind::Formula), formula.clone()));
    app.documents.formula.replace_text(CHANGED);
    app.perform(Action::SaveTo(Some(FileKind::Session), session.clone()));
    assert_eq!(std::fs::read_to_string(formula).expect("a file"), CHANGED);
    assert!(session.exists() && !harness.state().is_unsaved());
}

#[test]
fn the_rest_is_saved_after_a_file_that_was_saved_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let [session, formula] = ["my.toml", "my.formula"].map(|name| folder.path().join(name));
    for answer in ["Save elsewhere…", "Close"] {
        let mut harness = harness();
        let app = harness.state_mut();
        app.perform(Action::New(FileKind::Formula));
        app.perform(Action::SaveTo(Some(FileKind::Session), session.clone()));
        app.perform(Action::SaveTo(Some(FileKind::Formula), folder.path().join("no/such/folder.formula")));
        harness.run_steps(3);
        click(&mut harness, answer);
        harness.state_mut().perform(Action::SaveTo(Some(FileKind::Formula), formula.clone()));
        assert!(formula.exists());
        assert_eq!(session.exists(), answer == "Save elsewhere…", "{answer}");
        let _ = std::fs::remove_file(&session);
    }
}

#[test]
fn a_file_that_cannot_be_written_is_saved_elsewhere() {
    let mut harness = harness();
    let folder = tempfile::tempdir().expect("a folder");
    harness.state_mut().perform(Action::SaveTo(Some(FileKind::Formula), folder.path().join("no/such/folder.formula")));
    harness.run_steps(3);
    click(&mut harness, "Save elsewhere…");
    assert!(harness.state().dialogs.files.is_open());
}

/// A workshop with the body `ball` selected, and the number of its material row.
fn with_ball(folders: &Folders) -> (Harness<'static, App>, crate::scene::BodyId) {
    let mut harness = harness_in(Some(folders));
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    let Some(OwnerId::Body(ball)) = harness.state().workshop.values().table().owners().named("ball") else { panic!("a body") };
    (harness, ball)
}

/// The names of the materials that the user has saved, in the file.
fn saved_names(folders: &Folders) -> Vec<String> {
    let location = LibraryLocation::find(Some("preset:phong"), None, Some(&folders.data)).expect("a location");
    let (materials, _) = Materials::open(location, Readable::Regular).expect("a library");
    let all = materials.library().iter().map(|material| material.name().to_owned());
    all.filter(|name| !materials.is_built_in(name)).collect()
}

#[test]
fn a_deleted_material_comes_back() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let (mut harness, body) = with_ball(&folders);
    harness.state_mut().perform(Action::SaveMaterial { name: "my own".to_owned(), body });
    harness.run_steps(3);
    assert_eq!(saved_names(&folders), ["my own"]);
    click(&mut harness, "Delete");
    assert_eq!(saved_names(&folders), [""; 0]);
    assert!(harness.query_by_label("deleted the material my own").is_some());
    // Another formula, with another library, may be applied in between.
    harness.state_mut().perform(Action::Open(FileKind::Formula, Location::Preset("strauss".to_owned())));
    harness.run_steps(3);
    click(&mut harness, "Undo");
    assert_eq!(saved_names(&folders), ["my own"]);
}

#[test]
fn a_deleted_material_is_undone_and_redone_by_keys_in_order_with_values() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let (mut harness, body) = with_ball(&folders);
    harness.state_mut().perform(Action::SaveMaterial { name: "my own".to_owned(), body });
    harness.run_steps(3);
    let press = |harness: &mut Harness<'_, App>, key: egui::Key| {
        harness.key_press_modifiers(egui::Modifiers::COMMAND, key);
        harness.run_steps(3);
    };
    click(&mut harness, "Delete");
    let id = harness.state().workshop.formula().parameter_named("kd").expect("a parameter");
    let before = harness.state().workshop.values().clone();
    harness.state_mut().workshop.set(OwnerId::Body(body), id, [0.123; 3]);
    harness.run_steps(3);
    // The value was changed later, so it is undone first.
    press(&mut harness, egui::Key::Z);
    assert!(*harness.state().workshop.values() == before && saved_names(&folders).is_empty());
    assert_eq!(harness.state().undo_and_redo_names()[0].as_deref(), Some("the material my own"));
    press(&mut harness, egui::Key::Z);
    assert_eq!(saved_names(&folders), ["my own"]);
    assert_eq!(harness.state().confirmation.text(), "restored the material my own");
    press(&mut harness, egui::Key::Y);
    assert!(saved_names(&folders).is_empty());
    harness.key_press_modifiers(egui::Modifiers::ALT, egui::Key::Z);
    harness.run_steps(3);
    assert_eq!(saved_names(&folders), ["my own"]);
    // The button takes the same step back, and only once.
    click(&mut harness, "Delete");
    click(&mut harness, "Undo");
    assert_eq!(saved_names(&folders), ["my own"]);
    assert_eq!(harness.state().undo_and_redo_names()[0], None);
    // Another session has nothing to undo.
    click(&mut harness, "Delete");
    harness.state_mut().perform(Action::Open(FileKind::Session, Location::Preset("glass".to_owned())));
    harness.state_mut().perform(Action::Undo);
    assert!(saved_names(&folders).is_empty());
}

#[test]
fn a_replaced_material_is_undone_and_a_built_in_one_comes_back() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let (mut harness, body) = with_ball(&folders);
    let kd = harness.state().workshop.formula().parameter_named("kd").expect("a parameter");
    let saved = |name: &str| {
        let location = LibraryLocation::find(Some("preset:phong"), None, Some(&folders.data)).expect("a location");
        Materials::open(location, Readable::Regular).expect("a library").0.get(name).cloned().expect("a material")
    };
    let replace = |harness: &mut Harness<'_, App>, name: &str| {
        harness.state_mut().workshop.set(OwnerId::Body(body), kd, [0.0625; 3]);
        harness.state_mut().perform(Action::ReplaceMaterial { name: name.to_owned(), body });
        harness.run_steps(3);
    };
    harness.state_mut().perform(Action::SaveMaterial { name: "my own".to_owned(), body });
    for name in ["my own", "gold"] {
        let before = saved(name);
        replace(&mut harness, name);
        let after = saved(name);
        assert_ne!(after.properties, before.properties);
        harness.state_mut().perform(Action::Undo);
        assert_eq!(saved(name).properties, before.properties, "{name}");
        harness.state_mut().perform(Action::Redo);
        assert_eq!(saved(name).properties, after.properties, "{name}");
    }
}

#[test]
fn a_material_is_replaced_only_when_the_user_says_so() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let (mut harness, body) = with_ball(&folders);
    for (name, asked) in [("gold", true), ("my own", false), ("my own", true)] {
        let before = saved_names(&folders);
        harness.state_mut().perform(Action::SaveMaterial { name: name.to_owned(), body });
        harness.run_steps(3);
        assert_eq!(harness.query_by_label("Replace").is_some(), asked, "{name}");
        if asked {
            click(&mut harness, "Cancel");
            assert_eq!(saved_names(&folders), before);
        }
    }
    harness.state_mut().perform(Action::SaveMaterial { name: "gold".to_owned(), body });
    harness.run_steps(3);
    click(&mut harness, "Replace");
    assert!(saved_names(&folders).contains(&"gold".to_owned()));
}

#[test]
fn the_selector_shows_the_material_that_the_body_has() {
    let home = tempfile::tempdir().expect("a folder");
    let (mut harness, body) = with_ball(&Folders::below(home.path()));
    let shown = |harness: &mut Harness<'_, App>| {
        harness.run_steps(3);
        let in_panel = |node: &egui_kittest::Node<'_>| node.rect().left() > 790.0;
        harness.get_all_by_role(Role::ComboBox).find(in_panel).and_then(|node| node.value()).unwrap_or_default()
    };
    let first = shown(&mut harness);
    let location = LibraryLocation::find(Some("preset:phong"), None, None).expect("a location");
    let (materials, _) = Materials::open(location, Readable::Regular).expect("a library");
    let give = |harness: &mut Harness<'_, App>, name: &str| {
        let workshop = &mut harness.state_mut().workshop;
        let (given, _) = materials.get(name).expect("a material").assignments(workshop.values().table(), body);
        workshop.change(|values| {
            values.assign(&given);
        });
    };
    give(&mut harness, "gold");
    assert_eq!(shown(&mut harness), "gold");
    give(&mut harness, "jade");
    assert_eq!(shown(&mut harness), "jade");
    harness.state_mut().perform(Action::Undo);
    assert_eq!(shown(&mut harness), "gold");
    harness.state_mut().perform(Action::Undo);
    assert_eq!(shown(&mut harness), first);
    harness.state_mut().perform(Action::Redo);
    assert_eq!(shown(&mut harness), "gold");
    let id = harness.state().workshop.formula().parameter_named("kd").expect("a parameter");
    harness.state_mut().workshop.set(OwnerId::Body(body), id, [0.123; 3]);
    assert_eq!(shown(&mut harness), "own values");
    assert_eq!(harness.state().workshop.undo_and_redo_names(), [Some("ball.kd".to_owned()), None]);
}

#[test]
fn apply_stands_out_only_while_the_text_differs() {
    let mut harness = harness();
    assert!(harness.state().documents.formula.is_applied());
    let before = harness.state().documents.formula.text().to_owned();
    harness.state_mut().documents.formula.replace_text(CHANGED);
    assert!(!harness.state().documents.formula.is_applied());
    click(&mut harness, "Apply formula");
    assert!(harness.state().documents.formula.is_applied());
    harness.state_mut().documents.formula.replace_text("formula;\n= N.L;\n");
    click(&mut harness, "Apply formula");
    assert!(!harness.state().documents.formula.is_applied(), "a text with a mistake is not applied");
    harness.state_mut().documents.formula.replace_text(&before);
    assert!(!harness.state().documents.formula.is_applied(), "the text from before was replaced");
}

#[test]
fn confirmations_go_away_by_themselves() {
    let mut harness = harness();
    harness.state_mut().confirm("saved something");
    harness.run_steps(2);
    assert!(harness.query_by_label("saved something").is_some());
    assert_eq!(harness.state().log.lines_with("saved something"), 1);
    // Steps of a quarter of a second.
    harness.run_steps(30);
    assert!(harness.query_by_label("saved something").is_none());
    assert_eq!(harness.state().confirmation.text(), "");
}

#[test]
fn the_menu_edits_the_text_and_undoes_values_by_name() {
    let mut harness = harness();
    let text = harness.state().documents.formula.text().to_owned();
    let choose = |harness: &mut Harness<'_, App>, entry: &str| {
        harness.get_by_label("Edit").click();
        harness.run_steps(3);
        harness.get_by_label_contains(entry).click();
        harness.run_steps(4);
    };
    choose(&mut harness, "Select all");
    choose(&mut harness, "Cut");
    assert_eq!(harness.state().documents.formula.text(), "");
    choose(&mut harness, "Undo in the text");
    assert_eq!(harness.state().documents.formula.text(), text);
    choose(&mut harness, "Redo in the text");
    assert_eq!(harness.state().documents.formula.text(), "");
    let ambient = harness.state().workshop.formula().predefined(crate::lang::variables::Predefined::Ambient);
    harness.state_mut().workshop.set(OwnerId::Global, ambient, [0.75; 3]);
    choose(&mut harness, "Undo change of ka");
    assert!(harness.state().workshop.values().global(ambient) != [0.75]);
}

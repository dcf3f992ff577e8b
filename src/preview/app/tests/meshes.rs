//! Meshes of scenes: large ones are read in the background, and changed files are noticed.

use super::*;
use std::fmt::Write;
use std::fs;
use std::path::Path;

const CAMERA: &str = "lights; key: point, <3,4,9>; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";

/// A square of this many cells a side, as an OBJ file.
fn grid(path: &Path, cells: usize) {
    let mut text = String::new();
    for row in 0..=cells {
        for column in 0..=cells {
            writeln!(text, "v {}.0000 {}.0000 0.0000", column, row).expect("memory");
        }
    }
    for row in 0..cells {
        for column in 1..=cells {
            let (low, high) = (row * (cells + 1) + column, (row + 1) * (cells + 1) + column);
            writeln!(text, "f {low} {} {} {high}", low + 1, high + 1).expect("memory");
        }
    }
    fs::write(path, text).expect("a file");
}

fn triangles(harness: &Harness<'_, App>) -> usize {
    let world = harness.state().workshop.world();
    let key = crate::world::MeshKey::of(&world.scene().bodies[0]).expect("a mesh");
    world.assets().meshes.get(&key).expect("its triangles").mesh().triangles().len()
}

/// Waits until something is so.
pub(super) fn until(what: &str, harness: &mut Harness<'_, App>, is_so: impl Fn(&App) -> bool) {
    for _ in 0..10_000 {
        harness.step();
        if is_so(harness.state()) {
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("never: {what}");
}

#[test]
fn a_large_mesh_is_read_while_the_window_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, scene) = (folder.path().join("grid.obj"), folder.path().join("grid.scene"));
    grid(&mesh, 260);
    assert!(fs::metadata(&mesh).expect("a file").len() > 2 << 20);
    fs::write(&scene, format!("bodies; sheet: mesh, \"grid.obj\", fit <0,0,0> 3;\n{CAMERA}")).expect("a file");
    let mut harness = harness();
    let before = harness.state().workshop.shown().version;
    harness.state_mut().perform(Action::Open(FileKind::Scene, Location::File(scene)));
    // The old picture stays, and the bar says what is done.
    assert_eq!(harness.state().workshop.scene().bodies.len(), 3, "the scene before");
    harness.step();
    assert!(harness.state().asset_loading.progress().is_some() && harness.query_by_label("reading files").is_some());
    assert!(harness.state().workshop.shown().version >= before);
    until("the mesh is read", &mut harness, |app| app.workshop.scene().bodies.len() == 1);
    assert_eq!((triangles(&harness), harness.state().asset_loading.progress()), (2 * 260 * 260, None));
    settle(&mut harness);
    // Another session ends the reading of a scene.
    fs::write(&mesh, fs::read_to_string(&mesh).expect("a file") + "\n").expect("a file");
    harness.state_mut().apply(TextTab::Scene);
    assert!(harness.state().asset_loading.progress().is_some());
    let open = Action::Open(FileKind::Session, Location::Preset("glass".to_owned()));
    harness.state_mut().perform(Action::Confirmed(Box::new(open)));
    assert_eq!(harness.state().asset_loading.progress(), None);
    assert!(harness.state().workshop.world().assets().is_empty());
}

#[test]
fn a_changed_mesh_is_noticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let (mesh, scene) = (folder.path().join("grid.obj"), folder.path().join("grid.scene"));
    grid(&mesh, 2);
    fs::write(&scene, format!("bodies; sheet: mesh, \"grid.obj\", fit <0,0,0> 3;\n{CAMERA}")).expect("a file");
    let mut harness = harness();
    harness.state_mut().perform(Action::Open(FileKind::Scene, Location::File(scene)));
    assert_eq!(triangles(&harness), 8, "small files are read at once");
    settle(&mut harness);
    grid(&mesh, 3);
    until("the changed file is read", &mut harness, |app| {
        app.workshop.assets().bytes_to_read(app.workshop.scene(), &app.documents.scene.place()) == 0
    });
    assert_eq!(triangles(&harness), 18);
    // A damaged file is an error in the text. The picture stays.
    fs::write(&mesh, "v 0 0 0\nf 1 2 3\n").expect("a file");
    until("a mistake is marked", &mut harness, |app| app.documents.scene.counts()[0] == 1);
    assert_eq!(triangles(&harness), 18);
    // Mended, and applied by hand.
    grid(&mesh, 4);
    until("no mistake is marked", &mut harness, |app| app.documents.scene.counts()[0] == 0);
    assert_eq!(triangles(&harness), 32);
}

#[test]
fn a_mesh_is_added_and_moved_by_hand() {
    let mut harness = harness();
    harness.state_mut().perform(Action::Scene(SceneAction::AddBody("mesh")));
    let scene = harness.state().workshop.scene().clone();
    let added = scene.bodies.last().expect("a body");
    assert!(added.form.to_string().starts_with("mesh, \"preset:gem\", fit <"), "{}", added.form);
    let world = harness.state().workshop.world().clone();
    let moved = added.form.moved(glam::DVec3::X).expect("a place");
    let mut other = (*scene).clone();
    other.bodies.last_mut().expect("a body").form = moved;
    harness.state_mut().workshop.show_moving("gem", other);
    let id = crate::scene::BodyId(scene.bodies.len() as u32 - 1);
    let [before, after] = [&world, harness.state().workshop.world()].map(|world| world.bounds(id).low);
    assert!((after - before).abs_diff_eq(glam::DVec3::X, 1e-9), "{before} {after}");
}

#[test]
fn the_window_is_open_before_the_meshes_of_its_session_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let [mesh, scene, session] = ["grid.obj", "grid.scene", "grid.toml"].map(|name| folder.path().join(name));
    grid(&mesh, 260);
    fs::write(&scene, format!("bodies; sheet: mesh, \"grid.obj\", fit <0,0,0> 3;\n{CAMERA}")).expect("a file");
    let values = "[bodies.sheet]\nkd = 0.25\n[lights.key]\nki = 0.75\n";
    fs::write(&session, format!("version = 1\nformula = \"preset:phong\"\nscene = \"grid.scene\"\nsize = [48, 32]\n{values}"))
        .expect("a file");
    let location = Location::File(session.clone());
    let app = App::new(Some(&location), None).expect("a session");
    assert!(app.workshop.scene().bodies.is_empty() && app.asset_loading.progress().is_some(), "nothing is read yet");
    let builder = Harness::builder().with_size(egui::vec2(1100.0, 700.0));
    let mut harness = builder.build_ui_state(|ui, app: &mut App| app.draw(ui), app);
    let context = harness.ctx.clone();
    harness.state_mut().started(&context);
    let state = harness.state();
    assert!(state.documents.scene.text().contains("grid.obj") && state.documents.scene.counts() == [0, 0]);
    assert!(state.notices.is_empty() && !state.is_unsaved() && state.session == Some(location.clone()));
    if state.asset_loading.progress().is_some() {
        let note = state.note_on_picture().expect("a note").text;
        assert!(note.starts_with("Reading the files of ") && note.contains("grid.scene: "), "{note}");
    }
    until("the mesh is read", &mut harness, |app| app.workshop.scene().bodies.len() == 1);
    let state = harness.state();
    assert_eq!((triangles(&harness), state.note_on_picture(), state.is_unsaved()), (2 * 260 * 260, None, false));
    let table = state.workshop.values().table();
    let value = |owner: &str, name: &str| {
        let (owner, id) = (table.owners().named(owner).expect("an owner"), table.parameter_named(name).expect("a parameter"));
        state.workshop.values().get(owner, id)[0]
    };
    assert_eq!([value("sheet", "kd"), value("key", "ki")], [0.25, 0.75], "values have waited");
    assert!(state.workshop.can_undo_and_redo() == [false, false] && state.undo_and_redo_names()[0].is_none());
    // A mesh that cannot be used is marked, as it is elsewhere.
    fs::write(&mesh, fs::read_to_string(&mesh).expect("a file") + "f 1 2 99999999\n").expect("a file");
    let app = App::new(Some(&location), None).expect("a session");
    let mut harness = Harness::builder().build_ui_state(|ui, app: &mut App| app.draw(ui), app);
    until("a mistake is marked", &mut harness, |app| app.documents.scene.counts()[0] == 1);
    assert!(harness.state().workshop.scene().bodies.is_empty());
}

//! Files that are dropped on the window, and meshes that are added from files.

use super::*;
use crate::scene::BodyId;
use egui::{DroppedFile, HoveredFile, pos2};
use std::fs;
use std::path::{Path, PathBuf};

#[derive(Debug)]
struct Dropped(PathBuf);

impl DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("not by the window".to_owned())
    }
}

fn drop_on(harness: &mut Harness<'_, App>, paths: &[&Path]) {
    for path in paths {
        harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.to_path_buf())));
    }
    harness.step();
    harness.run_steps(4);
}

/// A box of these sides with a corner at the origin, as a PLY file.
fn write_box(path: &Path, [x, y, z]: [f64; 3]) {
    let mut text = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                    element face 6\nproperty list uchar int vertex_index\nend_header\n"
        .to_owned();
    for corner in 0..8 {
        let side = |bit: u32, length: f64| if corner >> bit & 1 == 1 { length } else { 0.0 };
        text += &format!("{} {} {}\n", side(0, x), side(1, y), side(2, z));
    }
    text += "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";
    fs::write(path, text).expect("a file");
}

const SCENE: &str = "bodies;
floor: rectangle, <-8, 0, -8>, <8, 0, -8>, <8, 0, 8>;
lights;
key: point, <3, 4, 9>;
camera;
position <0, 2, 9>; gaze <0, -0.2, -1>; up <0, 1, 0>; fov 45;
";

#[test]
fn a_dropped_mesh_becomes_a_body_that_stands_where_it_was_dropped() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scene, mesh, other] = ["a.scene", "Long box (2).ply", "cube.PLY"].map(|name| folder.path().join(name));
    fs::write(&scene, SCENE).expect("a file");
    write_box(&mesh, [4.0, 2.0, 1.0]);
    write_box(&other, [1.0, 1.0, 1.0]);
    let mut harness = harness();
    drop_on(&mut harness, &[&scene]);
    settle(&mut harness);
    let at = harness.state().pane.area().center() + egui::vec2(12.0, 10.0);
    let point = {
        let view = harness.state().scene_view();
        crate::preview::app::hand::sight::seen_at(view.world, view.image_point(at)).expect("the floor").1
    };
    harness.input_mut().events.push(egui::Event::PointerMoved(at));
    drop_on(&mut harness, &[&mesh, &other]);
    let app = harness.state();
    let bodies = &app.workshop.scene().bodies;
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["floor", "Long_box_2", "cube"], "{:?}", app.dialogs.message());
    let world = app.workshop.world();
    let bounds = world.bounds(BodyId(1));
    let sides = bounds.high - bounds.low;
    // On the floor under the pointer, half as high as it is long.
    assert!(bounds.low.y.abs() < 0.01 && (sides.x / sides.y - 2.0).abs() < 1e-6, "{bounds:?}");
    let beside = world.bounds(BodyId(2));
    let middles = [bounds, beside].map(|bounds| bounds.low.midpoint(bounds.high));
    let middle = middles[0].midpoint(middles[1]);
    assert!((middle.x - point.x).abs() < 0.01 && (middle.z - point.z).abs() < 0.01, "{middle} {point}");
    // The second one is beside the first, and does not stand on it.
    assert!(beside.low.x > bounds.high.x && beside.low.y.abs() < 0.01, "{beside:?} {bounds:?}");
    let text = app.documents.scene.text();
    assert!(text.contains("\nLong_box_2: mesh, \"Long box (2).ply\", fit <"), "{text}");
    assert_eq!(app.selected_object().map(|object| app.name_of(object)).as_deref(), Some("cube"));
    // Each is one step.
    harness.state_mut().perform(Action::Undo);
    harness.state_mut().perform(Action::Undo);
    assert_eq!(harness.state().documents.scene.text(), SCENE);
}

#[test]
fn a_mesh_in_a_scene_without_a_folder_has_an_absolute_path_and_a_bad_one_is_not_added() {
    let folder = tempfile::tempdir().expect("a folder");
    let [mesh, bad, quoted] = ["cube.ply", "bad.obj", "a\"b.ply"].map(|name| folder.path().join(name));
    write_box(&mesh, [1.0, 1.0, 1.0]);
    write_box(&quoted, [1.0, 1.0, 1.0]);
    fs::write(&bad, "v 0 0 0\nf 1 2 3\n").expect("a file");
    let mut harness = harness();
    let before = harness.state().documents.scene.text().to_owned();
    for (path, part) in [(&bad, "bad.obj"), (&quoted, "quotation mark"), (&folder.path().join("none.stl"), "no such file")] {
        harness.state_mut().perform(Action::AddMesh(path.clone(), MeshSpot::MIDDLE));
        let told = harness.state().dialogs.message().expect("a message").to_owned();
        assert!(told.contains(part), "{told}");
        assert!(harness.state().documents.scene.text() == before && harness.state().documents.scene.counts() == [0, 0]);
    }
    harness.state_mut().perform(Action::AddMesh(mesh.clone(), MeshSpot::MIDDLE));
    let text = harness.state().documents.scene.text();
    assert!(text.contains(&format!("cube: mesh, \"{}\", fit <", mesh.display())), "{text}");
    // In view, and a good part of the picture.
    let app = harness.state();
    let view = app.scene_view();
    let bounds = app.workshop.world().bounds(BodyId(app.workshop.scene().bodies.len() as u32 - 1));
    let [low, high] = [bounds.low, bounds.high].map(|point| view.project(point).expect("in view"));
    assert!(view.picture().contains(low) && view.picture().contains(high));
    assert!((low.y - high.y).abs() > 0.15 * view.picture().height(), "{low} {high}");
}

#[test]
fn dropped_texts_are_opened_after_one_another_and_questions_come_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let [scene, formula, mesh, image, letter] =
        ["my.scene", "my.formula", "cube.ply", "wood.png", "letter.txt"].map(|name| folder.path().join(name));
    fs::write(&scene, SCENE).expect("a file");
    fs::write(&formula, "formula;\n= IL*Cd;\n").expect("a file");
    fs::write(&letter, "Dear friend,\n").expect("a file");
    write_box(&mesh, [1.0, 1.0, 1.0]);
    let mut harness = harness();
    harness.state_mut().documents.scene.replace_text(&format!("{SCENE}// mine\n"));
    // In any order: the mesh belongs to the scene that comes with it.
    drop_on(&mut harness, &[&mesh, &formula, &scene]);
    assert_eq!(harness.state().workshop.scene().bodies.len(), 3, "nothing is lost without a question");
    assert!(harness.state().documents.formula.text() != "formula;\n= IL*Cd;\n");
    harness.get_by_label("Discard").click();
    harness.run_steps(8);
    let app = harness.state();
    assert_eq!(app.documents.formula.text(), "formula;\n= IL*Cd;\n");
    let names: Vec<&str> = app.workshop.scene().bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["floor", "cube"]);
    assert!(app.documents.scene.text().contains("mesh, \"cube.ply\""), "{}", app.documents.scene.text());
    // What cannot be opened says what to do with it.
    drop_on(&mut harness, &[&image, &letter]);
    let told = harness.state().dialogs.message().expect("a message").to_owned();
    assert!(told.contains("wood.png is an image. Images are for textures") && told.contains("letter.txt is no"), "{told}");
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    let session = folder.path().join("mine.session");
    fs::write(&session, "version = 1\nformula = \"preset:phong\"\nscene = \"my.scene\"\n").expect("a file");
    harness.state_mut().documents.scene.replace_text(SCENE);
    drop_on(&mut harness, &[&session]);
    if harness.query_by_label("Discard").is_some() {
        harness.get_by_label("Discard").click();
        harness.run_steps(4);
    }
    assert_eq!(harness.state().session, Some(Location::File(session)));
}

#[test]
fn the_menu_opens_the_dialog_for_meshes() {
    let mut harness = harness();
    let in_bar = |entry: &egui_kittest::Node<'_>| entry.rect().top() < 20.0;
    harness.get_all_by_label("Scene").find(in_bar).expect("a menu").click();
    harness.run_steps(3);
    harness.get_by_label_contains("Add body").click();
    harness.run_steps(3);
    harness.get_by_label_contains("Mesh…").click();
    harness.run_steps(3);
    assert!(harness.state().dialogs.files.is_open() && harness.query_by_label("Add a mesh").is_some());
}

#[test]
fn files_over_the_window_are_announced() {
    let mut harness = harness();
    harness.run_steps(2);
    let painted = |harness: &Harness<'_, App>| {
        let mut found = Vec::new();
        for clipped in &harness.output().shapes {
            if let egui::Shape::Text(text) = &clipped.shape {
                found.push(text.galley.text().to_owned());
            }
        }
        found
    };
    let file = |name: &str| HoveredFile { path: Some(PathBuf::from(name)), ..HoveredFile::default() };
    harness.input_mut().hovered_files = vec![file("/a/cow.obj"), file("/a/b.scene")];
    harness.event(egui::Event::PointerMoved(pos2(500.0, 300.0)));
    harness.step();
    let announced = "Add cow.obj to the scene\nOpen the scene b.scene".to_owned();
    assert!(painted(&harness).contains(&announced), "{:?}", painted(&harness));
    harness.input_mut().hovered_files.clear();
    harness.step();
    assert!(!painted(&harness).contains(&announced));
}

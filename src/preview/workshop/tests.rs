//! What the buttons of the workshop do, tested without a window.

use super::*;
use crate::files::Readable;
use crate::lang::source::Source;
use std::time::Duration;

fn workshop() -> Workshop {
    let mut opened = OpenedSession::open(&Location::Preset("studio".to_owned()), Readable::Regular, &AssetStore::default())
        .expect("a built-in session");
    opened.project.picture.size = [64, 48];
    opened.project.picture.depth = 2;
    Workshop::new(&opened.project, Arc::default(), || {}).expect("threads")
}

/// Waits until the picture is that of the values.
fn settle(workshop: &mut Workshop) -> Vec<u32> {
    for _ in 0..30_000 {
        workshop.refresh();
        if workshop.is_up_to_date() {
            return workshop.shown().pixels.clone();
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("no picture came");
}

fn slider(workshop: &Workshop, label: &str) -> (OwnerId, ParameterId) {
    let values = workshop.values();
    let found = values.iter().find(|(owner, id, _)| values.table().label(*owner, *id) == label);
    found.map(|(owner, id, _)| (owner, id)).expect("a slider")
}

#[test]
fn sliders_move_the_picture_and_changes_are_undone_drag_by_drag() {
    let mut workshop = workshop();
    let first = settle(&mut workshop);
    let (owner, id) = slider(&workshop, "ball.kd");
    for step in 0..10 {
        workshop.drag(owner, id, [0.05 * step as f32; 3]);
    }
    workshop.release();
    let second = settle(&mut workshop);
    assert!(first != second);
    workshop.set(owner, id, [0.0; 3]);
    let third = settle(&mut workshop);
    assert!(third != second && workshop.can_undo_and_redo() == [true, false]);
    assert!(workshop.undo() && settle(&mut workshop) == second);
    assert!(workshop.undo() && settle(&mut workshop) == first);
    assert!(!workshop.undo() && workshop.redo() && settle(&mut workshop) == second);
}

#[test]
fn a_failed_apply_leaves_everything_as_it_was() {
    let mut workshop = workshop();
    let first = settle(&mut workshop);
    let values = workshop.values().clone();
    let errors = workshop.apply_formula(&Source::new("new", "formula; = IL*Cd*N.L;"), None).expect_err("a mistake");
    assert!(errors.has_errors() && settle(&mut workshop) == first && *workshop.values() == values);
    workshop.apply_scene(&Source::new("new", "bodies; ball: sphere;"), &Location::new("")).expect_err("a mistake");
    assert!(settle(&mut workshop) == first);
    // A good one keeps values by owner and name.
    let (owner, id) = slider(&workshop, "ball.Cd");
    let colour = workshop.values().get(owner, id).to_vec();
    workshop.apply_formula(&Source::new("new", "formula; = IL*Cd*max(0, N.L);"), None).expect("no mistake");
    assert!(settle(&mut workshop) != first);
    let (owner, id) = slider(&workshop, "ball.Cd");
    assert_eq!(workshop.values().get(owner, id), colour);
}

#[test]
fn changes_are_undone_across_formulas_by_owner_and_name() {
    let mut workshop = workshop();
    let (owner, colour) = slider(&workshop, "ball.Cd");
    let before = workshop.values().get(owner, colour).to_vec();
    workshop.set(owner, colour, [0.25, 0.5, 0.75]);
    workshop.apply_formula(&Source::new("new", "formula; = IL*Cd*max(0, N.L);"), None).expect("no mistake");
    let (owner, colour) = slider(&workshop, "ball.Cd");
    assert_eq!(workshop.values().get(owner, colour), [0.25, 0.5, 0.75]);
    assert!(workshop.undo());
    assert_eq!(workshop.values().get(owner, colour), before);
    // Of what the formula has, and of nothing else.
    let labels: Vec<String> = workshop.values().iter().map(|(owner, id, _)| workshop.values().table().label(owner, id)).collect();
    assert!(labels.contains(&"ball.Cd".to_owned()) && !labels.contains(&"ball.kd".to_owned()), "{labels:?}");
    let undone = settle(&mut workshop);
    assert!(workshop.redo() && settle(&mut workshop) != undone);
    assert_eq!(workshop.values().get(owner, colour), [0.25, 0.5, 0.75]);
}

#[test]
fn snapshots_bring_values_and_formulas_back() {
    let mut workshop = workshop();
    let first = settle(&mut workshop);
    workshop.take_snapshot(0);
    let (owner, id) = slider(&workshop, "ball.kd");
    workshop.set(owner, id, [0.0; 3]);
    let second = settle(&mut workshop);
    workshop.take_snapshot(1);
    workshop.apply_formula(&Source::new("new", "formula; = IL*Cd*max(0, N.L);"), None).expect("no mistake");
    settle(&mut workshop);
    workshop.restore_snapshot(0);
    assert!(settle(&mut workshop) == first);
    workshop.restore_snapshot(1);
    assert!(settle(&mut workshop) == second);
    assert!(workshop.snapshot(0).is_some_and(|kept| kept.picture.pixels == first));
}

#[test]
fn a_snapshot_of_a_held_slider_has_all_pixels_and_one_of_a_coarse_picture_gets_them() {
    let mut workshop = workshop();
    settle(&mut workshop);
    let (owner, id) = slider(&workshop, "ball.kd");
    // On the screen, the picture has a quarter of its size.
    workshop.renderer().show_scaled(Some([16, 12]));
    workshop.drag(owner, id, [0.25; 3]);
    for _ in 0..30_000 {
        workshop.refresh();
        if workshop.shown().values == workshop.stamp() {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(workshop.shown().pixels.len(), 16 * 12);
    workshop.take_snapshot(0);
    assert!(workshop.held().is_some(), "the slider is still held");
    let kept = workshop.snapshot(0).expect("a snapshot").picture.clone();
    assert!(kept.is_full() && kept.pixels.len() == 64 * 48);
    workshop.release();
    let released = settle(&mut workshop);
    let near = |(one, other): (&u32, &u32)| [0, 8, 16].iter().all(|at| (one >> at & 0xff).abs_diff(other >> at & 0xff) <= 1);
    assert!(kept.pixels.iter().zip(&released).all(near));
    // The picture in view is still that before the change.
    workshop.set(owner, id, [0.75; 3]);
    let before = workshop.shown().version;
    workshop.take_snapshot(1);
    assert_eq!(workshop.snapshot(1).expect("a snapshot").picture.version, before);
    let changed = settle(&mut workshop);
    assert!(changed != released && workshop.snapshot(1).expect("a snapshot").picture.pixels == changed);
    assert!(workshop.snapshot(0).expect("a snapshot").picture.pixels == kept.pixels);
}

#[test]
fn a_value_is_copied_to_all_bodies_and_a_session_holds_everything() {
    let mut workshop = workshop();
    settle(&mut workshop);
    let (owner, id) = slider(&workshop, "ball.h");
    workshop.set(owner, id, [123.0; 3]);
    workshop.copy_to_all(owner, id);
    let values = workshop.values();
    assert!(values.table().owners().of_kind(owner.kind()).all(|body| values.get(body, id) == [123.0]));
    workshop.set_default_samples(5);
    assert_eq!(workshop.samples(), 5, "the session does not say");
    workshop.set_picture(PictureSettings { samples: Some(3), ..workshop.settings() }).expect("settings");
    assert_eq!(workshop.samples(), 3);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("my.toml");
    let [formula, scene] = ["phong", "studio"].map(|name| Location::Preset(name.to_owned()));
    workshop.save_session(&path, formula, scene).expect("saved");
    let opened = OpenedSession::open(&Location::File(path), Readable::Regular, &AssetStore::default()).expect("a session");
    assert_eq!(opened.project.values.numbers(), workshop.values().numbers());
    assert_eq!((opened.project.picture, opened.warnings), (workshop.settings(), Vec::new()));
    let missing = OpenedSession::open(&Location::new("nowhere.toml"), Readable::Regular, &AssetStore::default())
        .expect_err("no such file")
        .to_string();
    assert!(missing.contains("nowhere.toml"), "{missing}");
    assert!(workshop.set_picture(PictureSettings { depth: 10, ..workshop.settings() }).is_err());
    settle(&mut workshop);
}

#[test]
fn a_scene_is_moved_by_hand_and_put_back() {
    let mut workshop = workshop();
    let first = settle(&mut workshop);
    let values = workshop.values().clone();
    let start = Arc::clone(workshop.scene());
    for step in 1..5 {
        let mut scene = Scene::clone(&start);
        scene.camera = scene.camera.orbited(glam::DVec3::ZERO, 0.1 * f64::from(step), 0.0).expect("a camera");
        workshop.show_moving("the camera", scene);
    }
    assert_eq!(workshop.moving(), Some("the camera"));
    let moved = settle(&mut workshop);
    assert!(moved != first && *workshop.values() == values && workshop.can_undo_and_redo() == [false, false]);
    workshop.put_back();
    assert!(settle(&mut workshop) == first && workshop.moving().is_none() && Arc::ptr_eq(workshop.scene(), &start));
    // What is applied stays.
    workshop.show_moving("the camera", Scene::clone(&start));
    workshop.apply_scene(&Source::new("scene", start.to_string()), &Location::new("")).expect("a scene");
    workshop.put_back();
    assert!(workshop.moving().is_none() && !Arc::ptr_eq(workshop.scene(), &start));
}

#[test]
fn a_body_that_comes_back_has_its_values_and_a_copy_those_of_the_original() {
    let mut workshop = workshop();
    let (owner, colour) = slider(&workshop, "ball.Cd");
    workshop.set(owner, colour, [0.25, 0.5, 0.75]);
    let text = workshop.scene().to_string();
    let line = text.lines().find(|line| line.starts_with("ball:")).expect("a line").to_owned();
    let apply = |workshop: &mut Workshop, text: String| {
        workshop.apply_scene(&Source::new("scene", text), &Location::new("")).expect("a scene")
    };
    apply(&mut workshop, text.replace(&line, ""));
    assert!(workshop.values().table().owners().named("ball").is_none());
    apply(&mut workshop, text.clone());
    let value = |workshop: &Workshop, label: &str| {
        let (owner, id) = slider(workshop, label);
        workshop.values().get(owner, id).to_vec()
    };
    assert_eq!(value(&workshop, "ball.Cd"), [0.25, 0.5, 0.75]);
    apply(&mut workshop, text.replace(&line, &format!("{line}\n{}", line.replace("ball", "ball2"))));
    let [from, to] = ["ball.Cd", "ball2.Cd"].map(|label| slider(&workshop, label).0);
    assert!(value(&workshop, "ball2.Cd") != value(&workshop, "ball.Cd"));
    workshop.copy_values(from, to);
    assert_eq!(value(&workshop, "ball2.Cd"), [0.25, 0.5, 0.75]);
    assert_eq!(value(&workshop, "ball2.kd"), value(&workshop, "ball.kd"));
    // A new body of a name that is forgotten has defaults.
    apply(&mut workshop, text.replace(&line, ""));
    workshop.forget_values(crate::lang::variables::Owner::Body, "ball");
    apply(&mut workshop, text);
    assert_eq!(value(&workshop, "ball.Cd"), workshop.values().table().parameter(colour).default);
}

#[test]
fn the_saved_picture_is_the_one_in_view_with_its_passes() {
    let mut workshop = workshop();
    workshop.set_default_samples(5);
    settle(&mut workshop);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("seen.png");
    let saved = |workshop: &mut Workshop| {
        let export = workshop.export().expect("a picture");
        assert_eq!(export.save(&path), Ok(0));
        let pixels = image::open(&path).expect("a picture").into_rgb8();
        let words = pixels.pixels().map(|pixel| u32::from_be_bytes([0, pixel.0[0], pixel.0[1], pixel.0[2]]));
        (export.passes(), words.collect::<Vec<u32>>())
    };
    let mut counts = Vec::new();
    for _ in 0..30_000 {
        let seen = settle(&mut workshop);
        let (passes, pixels) = saved(&mut workshop);
        assert!(pixels == seen, "{passes} passes");
        if counts.last() != Some(&passes) {
            counts.push(passes);
        }
        if passes == 5 {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(counts.is_sorted() && counts.last() == Some(&5), "{counts:?}");
    // A held slider: the picture of the values of the slider, of as many passes.
    let (owner, id) = slider(&workshop, "ball.kd");
    workshop.drag(owner, id, [0.2; 3]);
    settle(&mut workshop);
    let (passes, held) = saved(&mut workshop);
    assert_eq!(passes, 5);
    workshop.release();
    let released = settle(&mut workshop);
    let alone = workshop.renderer().passes();
    assert!(alone == [5; 2] && held == released);
    // A pane of another size.
    workshop.show_size(Some([20, 10]));
    let seen = settle(&mut workshop);
    assert!(seen.len() == 200 && saved(&mut workshop).1 == seen);
}

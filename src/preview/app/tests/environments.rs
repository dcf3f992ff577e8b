//! Environments of scenes: added and removed by hand, and large images that are read in the background.

use super::meshes::until;
use super::*;
use crate::scene::edit::SceneObject;
use image::{Rgb, Rgb32FImage};
use std::fs;

fn act(harness: &mut Harness<'_, App>, action: SceneAction) {
    harness.state_mut().perform(Action::Scene(action));
    harness.run_steps(2);
}

/// Width and height of the map of the environment, in texels.
fn map_size(app: &App) -> Option<[u32; 2]> {
    app.workshop.world().assets().environment.as_ref()?.map.size()
}

#[test]
fn an_environment_is_added_once_and_removed() {
    let mut harness = harness();
    let written = harness.state().documents.scene.text().to_owned();
    act(&mut harness, SceneAction::AddLight("environment"));
    assert!(harness.state().documents.scene.text().contains("light: environment, \"preset:sky\";"));
    let size = map_size(harness.state());
    assert_eq!(size, Some([1024, 512]));
    let Some(SceneObject::Light(light)) = harness.state().selected_object() else { panic!("it is selected") };
    assert_eq!(harness.state().workshop.world().environment().map(crate::world::Environment::light), Some(light));
    // It has values of its own, and is in the list.
    let owners = harness.state().workshop.values().table().owners();
    assert!(owners.named("light").is_some());
    assert!(harness.query_all_by_label("light").next().is_some());
    let count = harness.state().workshop.scene().lights.len();
    // A copy would be a second one.
    let with_sky = harness.state().documents.scene.text().to_owned();
    act(&mut harness, SceneAction::Duplicate);
    assert_eq!(
        (harness.state().documents.scene.text(), harness.state().workshop.scene().lights.len()),
        (with_sky.as_str(), count)
    );
    assert!(harness.query_by_label_contains("at most one environment").is_some());
    act(&mut harness, SceneAction::Frame);
    act(&mut harness, SceneAction::Remove);
    assert!(harness.state().workshop.world().environment().is_none());
    // Added, framed, removed.
    for _ in 0..3 {
        harness.state_mut().perform(Action::Undo);
    }
    assert_eq!(harness.state().documents.scene.text(), written);
}

#[test]
fn a_large_image_is_read_while_the_window_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let (image, scene) = (folder.path().join("sky.hdr"), folder.path().join("sky.scene"));
    let write = |width: u32| {
        let noise =
            |x: u32, y: u32| 0.5 + (x.wrapping_mul(2_654_435_761).wrapping_add(y.wrapping_mul(40_503)) >> 16 & 0xff) as f32;
        let pixels = Rgb32FImage::from_fn(width, width / 2, |x, y| Rgb([noise(x, y), noise(y, x), noise(x + y, x)]));
        pixels.save(&image).expect("a file");
    };
    write(1200);
    assert!(fs::metadata(&image).expect("a file").len() > 2 << 20);
    let camera = "camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    fs::write(&scene, format!("bodies;\nlights; sky: environment, \"sky.hdr\";\n{camera}")).expect("a file");
    let mut harness = harness();
    harness.state_mut().perform(Action::Open(FileKind::Scene, Location::File(scene)));
    assert_eq!(harness.state().workshop.scene().bodies.len(), 3, "the scene before");
    harness.step();
    assert!(harness.state().asset_loading.progress().is_some() && harness.query_by_label("reading files").is_some());
    until("the image is read", &mut harness, |app| map_size(app) == Some([1200, 600]));
    assert_eq!(harness.state().asset_loading.progress(), None);
    settle(&mut harness);
    // Another image in its place, of less than 2 MiB.
    write(64);
    until("the changed image is read", &mut harness, |app| map_size(app) == Some([64, 32]));
    // A damaged one is an error in the text. The picture stays.
    fs::write(&image, "#?RADIANCE\n").expect("a file");
    until("a mistake is marked", &mut harness, |app| app.documents.scene.counts()[0] == 1);
    assert_eq!(map_size(harness.state()), Some([64, 32]));
}

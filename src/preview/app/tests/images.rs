//! The rows of textures.

use super::*;
use crate::texture;
use crate::workspace::OwnerId;
use image::{Rgb, RgbImage};

/// The path of the image of `wood` of the body `ball`.
fn wood(app: &App) -> (OwnerId, Option<std::path::PathBuf>) {
    let values = app.workshop.values();
    let owner = values.table().owners().named("ball").expect("a body");
    let id = values.table().parameter_named("wood").expect("a parameter");
    (owner, texture::path_of(values.get(owner, id)[0]).map(std::path::Path::to_owned))
}

#[test]
fn an_image_is_chosen_shown_cleared_and_taken_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("oak.png");
    RgbImage::from_pixel(3, 2, Rgb([120, 80, 40])).save(&path).expect("a file");
    std::fs::write(folder.path().join("torn.png"), "no image").expect("a file");
    let mut harness = harness();
    harness.state_mut().documents.formula.replace_text("body_specific; wood: texture; formula; = IL*Cd*wood(u, v);");
    harness.state_mut().perform(Action::Apply);
    settle(&mut harness);
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    harness.get_by_label("Choose an image…").click();
    harness.run_steps(3);
    assert!(harness.state().dialogs.files.is_open());
    let owner = wood(harness.state()).0;
    let set = |name: &str| Action::SetImage(owner, "wood".to_owned(), folder.path().join(name));
    let mut harness = {
        harness.state_mut().perform(set("oak.png"));
        harness.state().jobs.wait();
        harness.run_steps(3);
        harness
    };
    assert_eq!(wood(harness.state()).1, Some(path.clone()));
    assert!(harness.query_by_label("oak.png").is_some());
    harness.state_mut().perform(set("torn.png"));
    harness.state().jobs.wait();
    harness.run_steps(3);
    assert!(harness.state().dialogs.message().expect("a message").contains("torn.png"));
    assert_eq!(wood(harness.state()).1, Some(path.clone()), "the image stays");
    // A parameter that is gone, or is no texture, is left alone.
    harness.state_mut().perform(Action::SetImage(owner, "oak".to_owned(), path.clone()));
    harness.state_mut().perform(Action::SetImage(owner, "kr".to_owned(), path));
    harness.state().jobs.wait();
    harness.run_steps(3);
    assert_eq!(wood(harness.state()).1, Some(folder.path().join("oak.png")));
    harness.state_mut().perform(Action::Undo);
    harness.run_steps(3);
    assert_eq!(wood(harness.state()).1, None);
}

//! A pixel's tree of rays, exactly as the program prints it.

use crate::{folder, told, write};

#[test]
fn glass_and_shadows() {
    // A ray through the glass and the bubble in it, with total reflection and a floor in shadow.
    let text = told(folder().path(), "dump preset:glass --size 64x36 --depth 4 --stage rays --pixel 16,17");
    insta::assert_snapshot!("glass", text);
}

#[test]
fn passes_of_a_pixel_at_an_edge() {
    let folder = folder();
    let lights = crate::SCENE.replace("key: point, <4,6,5>;", "lamp: sphere, center <4,6,5>, radius 1;");
    write(&folder, "sub/place.txt", &lights);
    let rays = |arguments: &str| told(folder.path(), &format!("dump session.toml --stage rays --pixel 21,12 {arguments}"));
    insta::assert_snapshot!("passes", rays("--samples 4"));
    insta::assert_snapshot!("pass", rays("--samples 4 --pass 2"));
    // The first pass is a picture of one pass.
    let first = rays("--samples 4 --pass 0");
    assert_eq!(first.replace(" in pass 0", ""), rays(""));
    assert!(rays("--samples 4").ends_with(&first));
}

#[test]
fn the_ball_of_the_session() {
    insta::assert_snapshot!("ball", told(folder().path(), "dump session.toml --stage rays --pixel 17,10"));
}

//! A pixel's tree of rays, exactly as the program prints it.

use crate::{folder, told};

#[test]
fn glass_and_shadows() {
    // A ray through the glass and the bubble in it, with total reflection and a floor in shadow.
    let text = told(folder().path(), "dump preset:glass --size 64x36 --depth 4 --stage rays --pixel 16,17");
    insta::assert_snapshot!("glass", text);
}

#[test]
fn the_ball_of_the_session() {
    insta::assert_snapshot!("ball", told(folder().path(), "dump session.toml --stage rays --pixel 17,10"));
}

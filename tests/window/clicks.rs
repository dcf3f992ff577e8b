//! Clicks of a real pointer: in the gallery, and in the menu of the editor.

use crate::{PICTURE, Screen, wait};
use std::collections::HashSet;

#[test]
fn a_click_in_the_gallery_opens_a_session() {
    let screen = Screen::new("");
    // The picture of the card of `glass`, once it is made: it has many colours.
    let card = ([330, 350], [60, 40]);
    wait("the gallery", || {
        let pixels = screen.pixels(card.0, card.1);
        pixels.chunks_exact(3).collect::<HashSet<&[u8]>>().len() > 100
    });
    assert!(!screen.title().contains("glass"));
    screen.mouse([card.0[0] + 28, card.0[1] + 30]);
    screen.run("xdotool", &["click", "1"]);
    wait("the session", || screen.title().contains("glass"));
    assert!(!screen.title().contains('•'));
    wait("a picture without the gallery over it", || {
        let pixels = screen.pixels(PICTURE.0, PICTURE.1);
        pixels.chunks_exact(3).collect::<HashSet<&[u8]>>().len() > 1000
    });
}

#[test]
fn text_is_pasted_from_the_menu_of_a_right_click() {
    let screen = Screen::new("preset:studio");
    screen.picture_at_rest();
    screen.mouse([200, 500]);
    screen.run("xdotool", &["click", "1"]);
    screen.run("xdotool", &["key", "ctrl+End"]);
    screen.run("xdotool", &["type", "--delay", "10", "// twice "]);
    wait("the mark of unsaved text", || screen.title().contains('•'));
    screen.run("xdotool", &["key", "shift+Home", "ctrl+c", "ctrl+End"]);
    std::thread::sleep(std::time::Duration::from_millis(300));
    screen.run("xdotool", &["click", "3"]);
    // The menu covers the background of the text.
    let menu = || screen.pixels([210, 630], [40, 20]);
    wait("the menu", || menu().chunks_exact(3).collect::<HashSet<&[u8]>>().len() > 4);
    screen.mouse([230, 639]);
    screen.run("xdotool", &["click", "1"]);
    wait("the text in the draft", || {
        let Ok(folders) = std::fs::read_dir(screen.home.path().join("state/drafts")) else { return false };
        let mut drafts = folders.filter_map(|folder| std::fs::read_to_string(folder.ok()?.path().join("0.toml")).ok());
        drafts.any(|draft| draft.contains("// twice // twice "))
    });
}

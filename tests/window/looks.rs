//! The colour picker and the borders of panels under a real pointer.

use crate::{Screen, wait};

/// Drags the pointer through these positions of the window.
fn drag(screen: &Screen, path: &[[i32; 2]]) {
    let (first, rest) = path.split_first().expect("a start");
    screen.mouse(*first);
    std::thread::sleep(std::time::Duration::from_millis(200));
    screen.run("xdotool", &["mousedown", "1"]);
    for at in rest {
        screen.mouse(*at);
        std::thread::sleep(std::time::Duration::from_millis(30));
    }
}

#[test]
fn a_colour_is_picked_live_and_undone_in_one_step() {
    let screen = Screen::new("preset:studio");
    screen.picture_at_rest();
    // A part of the ball without its outline, its arrows and markers.
    let pixels = || screen.pixels([565, 380], [20, 20]);
    let before = pixels();
    // The body `ball` in the list, its swatch, and then the square of the picker.
    screen.mouse([1100, 243]);
    screen.run("xdotool", &["click", "1"]);
    std::thread::sleep(std::time::Duration::from_millis(500));
    screen.mouse([1056, 395]);
    screen.run("xdotool", &["click", "1"]);
    std::thread::sleep(std::time::Duration::from_millis(500));
    let path: Vec<[i32; 2]> = (0..12).map(|step| [1230 - 12 * step, 440 + 9 * step]).collect();
    drag(&screen, &path);
    // The picture follows while the button is still pressed.
    wait("another colour", || pixels() != before);
    assert_eq!(screen.told("dragged"), 0, "the drag goes on");
    screen.run("xdotool", &["mouseup", "1"]);
    wait("a line of the log", || screen.told("dragged ball.Cd") == 1);
    screen.picture_at_rest();
    assert!(pixels() != before);
    screen.run("xdotool", &["key", "alt+z"]);
    wait("the colour before", || pixels() == before);
    assert_eq!(screen.told("dragged"), 1);
}

#[test]
fn a_border_that_was_dragged_is_there_at_the_next_start() {
    let mut screen = Screen::new("preset:studio");
    screen.picture_at_rest();
    drag(&screen, &[[382, 400], [360, 402], [330, 404], [302, 404], [300, 404]]);
    screen.run("xdotool", &["mouseup", "1"]);
    std::thread::sleep(std::time::Duration::from_millis(300));
    screen.run("xdotool", &["key", "ctrl+q"]);
    assert!(screen.window.wait().expect("an end").success());
    let settings = std::fs::read_to_string(screen.home.path().join("configuration/settings.toml")).expect("settings");
    let width = settings.lines().find_map(|line| line.strip_prefix("texts_width = ")).expect("a width");
    let width: f32 = width.parse().expect("a number");
    assert!((width - 300.0).abs() < 6.0, "{settings}");
}

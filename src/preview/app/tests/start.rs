//! The start: the gallery, thumbnails, and what the window says about the first picture.

use super::*;
use crate::workspace::presets;

/// A workshop that was started without a session.
fn started(folders: &Folders) -> Harness<'static, App> {
    let app = App::new(None, Some(folders)).expect("the startup session");
    let mut harness =
        Harness::builder().with_size(egui::vec2(1100.0, 700.0)).build_ui_state(|ui, app: &mut App| app.draw(ui), app);
    let context = harness.ctx.clone();
    harness.state_mut().started(&context);
    harness.run_steps(3);
    harness
}

fn is_open(harness: &Harness<'_, App>) -> bool {
    harness.state().gallery.is_open()
}

#[test]
fn the_gallery_is_there_at_the_start_and_never_in_the_way() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let mut harness = started(&folders);
    assert!(is_open(&harness) && harness.query_by_label("Open a session").is_some());
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    assert!(!is_open(&harness));
    // From the menu, and a click beside it.
    harness.state_mut().perform(Action::ShowGallery);
    harness.run_steps(3);
    harness.drag_at(egui::pos2(8.0, 690.0));
    harness.run_steps(2);
    harness.drop_at(egui::pos2(8.0, 690.0));
    harness.run_steps(3);
    assert!(!is_open(&harness));
    // A session that was named comes without it.
    assert!(!is_open(&harness_in(Some(&folders))));
    // The setting, here from the gallery itself.
    harness.state_mut().perform(Action::ShowGallery);
    harness.run_steps(3);
    harness.get_by_label("Show at the start").click();
    harness.run_steps(3);
    assert!(!harness.state().user_state.settings.window.gallery);
    harness.state_mut().closing();
    drop(harness);
    assert!(!is_open(&started(&folders)));
}

#[test]
fn a_card_opens_its_session_before_pictures_are_there() {
    let home = tempfile::tempdir().expect("a folder");
    let mut harness = started(&Folders::below(home.path()));
    harness.get_by_role_and_label(Role::Button, "glass").click();
    harness.run_steps(3);
    assert!(!is_open(&harness));
    assert_eq!(harness.state().session, Some(Location::Preset("glass".to_owned())));
}

#[test]
fn every_card_gets_its_picture_in_the_background() {
    let home = tempfile::tempdir().expect("a folder");
    let mut harness = started(&Folders::below(home.path()));
    let sessions = presets::names(FileKind::Session).count();
    for _ in 0..60_000 {
        harness.step();
        if harness.state().thumbnails.count() == sessions {
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("{} of {sessions} pictures came", harness.state().thumbnails.count());
}

#[test]
fn recent_files_are_in_the_gallery() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let mut harness = started(&folders);
    let own = home.path().join("mine.toml");
    harness.state_mut().perform(Action::SaveTo(Some(FileKind::Session), own.clone()));
    harness.state_mut().perform(Action::Open(FileKind::Session, Location::Preset("glass".to_owned())));
    harness.state_mut().perform(Action::ShowGallery);
    harness.run_steps(3);
    harness.get_by_label("mine.toml").scroll_to_me();
    harness.run_steps(10);
    harness.get_by_label("mine.toml").click();
    harness.run_steps(3);
    assert_eq!(harness.state().session, Some(Location::File(own)));
}

#[test]
fn nan_is_announced_and_leads_to_the_inspector() {
    let mut harness = harness();
    assert!(harness.query_by_label_contains("NaN").is_none());
    let text = "formula;\n= IL*sqrt(-max(0, N.L));\n";
    harness.state_mut().documents.formula.replace_text(text);
    harness.state_mut().perform(Action::Apply);
    settle(&mut harness);
    harness.run_steps(2);
    let (_, first) = harness.state().log.undefined().expect("pixels without a number");
    harness.get_by_label_contains("NaN in").click();
    harness.run_steps(3);
    assert!(harness.state().inspector.open);
    let [x, y] = first;
    assert!(harness.query_by_label_contains(&format!("({x}, {y})")).is_some(), "the inspector shows the pixel {first:?}");
    // A formula without NaN ends it.
    harness.state_mut().documents.formula.replace_text("formula;\n= IL*Cd*max(0, N.L);\n");
    harness.state_mut().perform(Action::Apply);
    settle(&mut harness);
    harness.run_steps(2);
    assert!(harness.query_by_label_contains("NaN in").is_none());
}

#[test]
fn nan_of_a_later_pass_is_explained() {
    let mut harness = harness();
    // The points of the first pass are the middles of pixels. A sphere in a corner of a pixel is met by later ones.
    let scene = "bodies;\nball: sphere, center <0.02, 0.02, 0>, radius 0.015;\nlights;\nkey: point, <0, 0, 9>;\ncamera;\n\
        position <0, 0, 5>; gaze <0, 0, -1>; up <0, 1, 0>; fov 40;\n";
    harness.state_mut().documents.scene.replace_text(scene);
    harness.state_mut().apply(TextTab::Scene);
    harness.state_mut().documents.formula.replace_text("formula;\n= IL*sqrt(-max(0.1, N.L));\n");
    harness.state_mut().perform(Action::Apply);
    let settings = harness.state().workshop.settings();
    let many = crate::workspace::session::PictureSettings { samples: Some(32), ..settings };
    harness.state_mut().workshop.set_picture(many).expect("settings in range");
    until_finding(&mut harness);
    let finding = harness.state().finding.as_ref().expect("a finding").message();
    assert!(finding.contains("in pass ") && finding.contains("it is `sqrt(-max(0.1, N.L))`"), "{finding}");
}

/// Waits until something remarkable is found about the picture.
fn until_finding(harness: &mut Harness<'_, App>) {
    for _ in 0..30_000 {
        harness.step();
        let told = harness.state().finding.as_ref().is_some_and(|finding| finding.message().contains("NaN"));
        if told && harness.state().workshop.renderer().passes() == [32; 2] {
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("nothing is found: {:?}", harness.state().finding);
}

//! Fits in the window.

use super::*;
use crate::preview::app::action::PanelId;
use crate::preview::app::comparison::{PAIRS, PaneMode};
use egui_kittest::kittest::NodeT;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// A window with a formula, in which the values of the ball are seen.
fn fitting(text: &str) -> Harness<'static, App> {
    let mut harness = harness();
    harness.state_mut().documents.formula.replace_text(text);
    harness.state_mut().perform(Action::Apply);
    let app = harness.state_mut();
    let ball = app.workshop.values().table().owners().named("ball").expect("a body");
    app.parameters.select(ball);
    app.perform(Action::TogglePanel(PanelId::Fitting));
    settle(&mut harness);
    harness.run_steps(3);
    harness
}

/// Waits until nothing is read or fitted.
fn rest(harness: &mut Harness<'_, App>) {
    for _ in 0..60_000 {
        harness.step();
        if harness.state().fitting.is_at_rest() {
            harness.run_steps(3);
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("the fit does not end");
}

fn choose(harness: &mut Harness<'_, App>, path: &Path) {
    harness.state_mut().perform(Action::FitTo(path.to_owned()));
    rest(harness);
}

fn click(harness: &mut Harness<'_, App>, label: &str) {
    harness.get_by_label(label).click();
    harness.run_steps(3);
}

/// A value of the ball.
fn value(harness: &Harness<'_, App>, name: &str) -> Vec<f32> {
    let values = harness.state().workshop.values();
    let ball = values.table().owners().named("ball").expect("a body");
    values.get(ball, values.table().parameter_named(name).expect("a parameter")).to_vec()
}

fn set(harness: &mut Harness<'_, App>, name: &str, value: f32) {
    let workshop = &mut harness.state_mut().workshop;
    let ball = workshop.values().table().owners().named("ball").expect("a body");
    let id = workshop.formula().parameter_named(name).expect("a parameter");
    workshop.set(ball, id, [value; 3]);
}

const PHONG: &str = "body_specific; kd: scalar, constraint 0..1, default 0.6, slider;
    ks: scalar, constraint 0..1, default 0.35, slider; h: scalar, constraint 1..500, default 60, slider;
    invariants; kd + ks <= 1; formula; = kd*IL*max(0, N.L) + ks*IL*max(0, R.V)^h;";

/// A list of samples of Phong's model (1975) in the plane of incidence, in closed form: the reflectance is
/// (kd + ks · cos(θo − θi)^h / cos θi) / π. `noise` changes every second sample by this part.
fn phong_samples(folder: &Path, [kd, ks, h]: [f64; 3], noise: f64) -> PathBuf {
    let mut text = "theta_i, phi_i, theta_o, phi_o, r, g, b\n".to_owned();
    for light in [0.0, 15.0, 30.0, 45.0, 60.0] {
        for (index, view) in (0..=70).step_by(5).enumerate() {
            let view = f64::from(view);
            let to_mirror = f64::to_radians(view - light).cos().max(0.0);
            let value = (kd + ks * to_mirror.powf(h) / f64::to_radians(light).cos()) / PI;
            let value = if index % 2 == 0 { value } else { value * (1.0 + noise) };
            text.push_str(&format!("{light}, 0, {view}, 180, {value}, {value}, {value}\n"));
        }
    }
    let path = folder.join("phong.csv");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn values_of_a_list_are_found_applied_undone_and_reverted() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = fitting(PHONG);
    assert!(harness.get_by_label("Start fit").accesskit_node().is_disabled(), "without data");
    // The values at hand leave no room for the wanted ones, as kd + ks never exceeds 1.
    let wanted = [0.15, 0.8, 25.0];
    choose(&mut harness, &phong_samples(folder.path(), wanted, 0.0));
    assert!(harness.query_by_label("phong.csv").is_some() && harness.query_by_label("a list of 75 samples").is_some());
    let before = harness.state().workshop.values().numbers().to_vec();
    click(&mut harness, "Start fit");
    rest(&mut harness);
    assert_eq!(harness.state().fitting.trouble(), None);
    assert!(harness.query_by_label_contains("Residual ").is_some() && harness.query_by_label("ball.h").is_some());
    assert!(harness.state().workshop.values().numbers() == before, "nothing is set before the user wants it");
    click(&mut harness, "Apply");
    for (name, wanted) in ["kd", "ks", "h"].into_iter().zip(wanted) {
        let found = f64::from(value(&harness, name)[0]);
        assert!((found - wanted).abs() <= 1e-3 * wanted.max(1.0), "{name}: {found}, {wanted}");
    }
    assert!(harness.get_by_label("Apply").accesskit_node().is_disabled());
    let after = harness.state().workshop.values().numbers().to_vec();
    // Only values of the ball are different.
    assert_eq!(before.iter().zip(&after).filter(|(one, other)| one != other).count(), 3);
    harness.state_mut().perform(Action::Undo);
    assert!(harness.state().workshop.values().numbers() == before, "one step of undo");
    harness.state_mut().perform(Action::Redo);
    harness.run_steps(3);
    click(&mut harness, "Revert");
    assert!(harness.state().workshop.values().numbers() == before);
    click(&mut harness, "Before and after");
    rest(&mut harness);
}

#[test]
fn a_cancelled_fit_keeps_the_best_so_far() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = fitting(PHONG);
    choose(&mut harness, &phong_samples(folder.path(), [0.2, 0.5, 30.0], 0.2));
    let row = harness.get_by_label("Starts").rect().center().y;
    let beside = |field: &egui_kittest::Node<'_>| (field.rect().center().y - row).abs() < 6.0 && field.rect().left() < 780.0;
    harness.get_all_by_role(Role::SpinButton).find(beside).expect("a field beside its name").click();
    harness.run_steps(3);
    harness.event(egui::Event::Text("1000".to_owned()));
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    harness.get_by_label("Start fit").click();
    // With 1000 starts it still runs when it is told to end.
    for _ in 0..10_000 {
        harness.step();
        if harness.query_by_label("Cancel").is_some() {
            break;
        }
    }
    // While a slider is held, it waits.
    let slider = harness.get_all_by_role(Role::Slider).next().expect("a slider").rect();
    harness.drag_at(slider.left_center() + egui::vec2(30.0, 0.0));
    harness.run_steps(2);
    harness.hover_at(slider.left_center() + egui::vec2(60.0, 0.0));
    harness.run_steps(3);
    assert!(harness.state().workshop.held().is_some());
    // An evaluation that was begun is finished.
    std::thread::sleep(Duration::from_millis(300));
    let share = harness.state().fitting.share().expect("a fit that runs");
    std::thread::sleep(Duration::from_millis(100));
    harness.step();
    assert_eq!(harness.state().fitting.share(), Some(share));
    harness.drop_at(slider.left_center() + egui::vec2(60.0, 0.0));
    let goes_on = |harness: &mut Harness<'_, App>| {
        std::thread::sleep(Duration::from_millis(1));
        harness.step();
        harness.state().fitting.share() != Some(share)
    };
    assert!((0..10_000).any(|_| goes_on(&mut harness)), "it goes on");
    click(&mut harness, "Cancel");
    rest(&mut harness);
    assert!(harness.query_by_label_contains("Values have changed since this fit began").is_some());
    assert!(harness.query_by_label_contains("The fit was cancelled; these are the best values so far").is_some());
    let sentences = harness.state().fitting.result_sentences().expect("a result").join(" ");
    assert!(!sentences.contains("of 1000 starts"), "{sentences}");
}

#[test]
fn what_is_wrong_is_told_in_the_panel() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = fitting("body_specific; = IL*max(0, N.L);");
    let mut harness_trouble = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        if !bytes.is_empty() {
            std::fs::write(&path, bytes).expect("a file");
        }
        choose(&mut harness, &path);
        harness.state().fitting.trouble().unwrap_or_default().to_owned()
    };
    let text = harness_trouble("half.csv", b"0, 0, 0, 180, 0.1, 0.1, 0.1\n10, 0, 10, 180, 0.1\n");
    assert!(text.contains("half.csv") && text.contains("line 2"), "{text}");
    let text = harness_trouble("missing.png", b"");
    assert!(text.contains("missing.png") && text.contains("there is no such file"), "{text}");
    let text = harness_trouble("cut.exr", &[0x76, 0x2f, 0x31, 0x01, 0x02]);
    assert!(text.starts_with("cannot read the picture") && text.contains("cut.exr"), "{text}");
    assert!(harness.get_by_label("Start fit").accesskit_node().is_disabled());
}

#[test]
fn locked_parameters_say_why_and_nothing_free_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "body_specific; kd: scalar, constraint 0..1, slider; ks: scalar, constraint 0..1, slider;
        invariants; kd + ks = 1; formula; = kd*IL*max(0, N.L) + ks*IL;";
    let mut harness = fitting(text);
    assert!(harness.query_by_label("follows: ks = 1 - kd").is_some());
    choose(&mut harness, &phong_samples(folder.path(), [0.2, 0.5, 30.0], 0.0));
    let check = |box_: &egui_kittest::Node<'_>| box_.rect().left() < 780.0;
    harness.get_all_by_role_and_label(Role::CheckBox, "kd").find(check).expect("a check box").click();
    harness.run_steps(3);
    click(&mut harness, "Start fit");
    rest(&mut harness);
    assert_eq!(harness.state().fitting.trouble(), Some("There is nothing to fit: no parameter is free to move."));
}

#[test]
fn a_result_for_an_earlier_formula_says_so_and_sets_what_is_left() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = fitting(PHONG);
    choose(&mut harness, &phong_samples(folder.path(), [0.25, 0.5, 20.0], 0.0));
    click(&mut harness, "Start fit");
    rest(&mut harness);
    let text = "body_specific; kd: scalar, constraint 0..1, default 0.6, slider; formula; = kd*IL*max(0, N.L);";
    harness.state_mut().documents.formula.replace_text(text);
    harness.state_mut().perform(Action::Apply);
    settle(&mut harness);
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("The formula has changed since this fit began").is_some());
    click(&mut harness, "Apply");
    assert!((value(&harness, "kd")[0] - 0.25).abs() < 1e-3);
    let said = harness.state().confirmation.text().to_owned();
    assert_eq!(said, "the fitted values are set; 2 parameters of them exist no longer");
}

#[test]
fn a_picture_of_another_size_gives_the_values_back_and_is_compared() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wanted.exr");
    let mut harness = fitting(PHONG);
    // That of the session.
    let mirrored = value(&harness, "ks")[0];
    set(&mut harness, "kd", 0.25);
    set(&mut harness, "h", 20.0);
    settle(&mut harness);
    harness.state_mut().perform(Action::SaveTo(None, path.clone()));
    harness.state_mut().jobs.wait();
    set(&mut harness, "kd", 0.6);
    set(&mut harness, "h", 60.0);
    let app = harness.state_mut();
    let settings = app.workshop.settings();
    let smaller = crate::workspace::session::PictureSettings { size: [32, 24], ..settings };
    app.workshop.set_picture(smaller).expect("a size in range");
    let before = settle(&mut harness);
    choose(&mut harness, &path);
    assert!(harness.query_by_label("a picture of 64×48 pixels, linear").is_some());
    assert!(harness.query_by_label("Passes").is_some(), "pictures are means of passes");
    click(&mut harness, "Start fit");
    rest(&mut harness);
    assert_eq!(harness.state().fitting.trouble(), None);
    click(&mut harness, "Apply");
    for (name, wanted) in [("kd", 0.25), ("ks", mirrored), ("h", 20.0)] {
        let found = value(&harness, name)[0];
        assert!((found - wanted).abs() <= 1e-3 * wanted.max(1.0), "{name}: {found}, {wanted}");
    }
    let after = settle(&mut harness);
    assert!(after != before);
    // The picture before is kept beside it.
    harness.run_steps(2);
    click(&mut harness, "Before");
    let app = harness.state();
    assert!(app.pane.mode == PaneMode::Snapshot(0) && app.pane.picture(&app.workshop).pixels == before);
    click(&mut harness, "Side by side");
    assert_eq!(harness.state().pane.mode, PaneMode::Split(PAIRS[0]));
    click(&mut harness, "Revert");
    assert!(settle(&mut harness) == before && harness.state().pane.mode == PaneMode::Current);
}

#[test]
fn values_of_another_body_may_move_where_the_data_are_a_picture() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wanted.exr");
    let mut harness = fitting(PHONG);
    let of_floor = |harness: &Harness<'_, App>| {
        let (table, formula) = (harness.state().workshop.values().table(), harness.state().workshop.formula());
        (table.owners().named("floor").expect("a body"), formula.parameter_named("kd").expect("a parameter"))
    };
    let (floor, kd) = of_floor(&harness);
    harness.state_mut().workshop.set(floor, kd, [0.25; 3]);
    settle(&mut harness);
    harness.state_mut().perform(Action::SaveTo(None, path.clone()));
    harness.state_mut().jobs.wait();
    harness.state_mut().workshop.set(floor, kd, [0.6; 3]);
    settle(&mut harness);
    let boxes = |harness: &Harness<'_, App>| {
        let of_panel = |node: &egui_kittest::Node<'_>| node.rect().left() < 780.0;
        harness.get_all_by_role_and_label(Role::CheckBox, "kd").filter(of_panel).count()
    };
    let before = boxes(&harness);
    choose(&mut harness, &path);
    let bodies = harness.state().workshop.scene().bodies.len();
    assert_eq!((before, boxes(&harness)), (1, bodies), "measured reflectance is of one body, and a picture of all");
    // Those of the ball that are free as usual, and one of the floor.
    harness.state_mut().fitting.free("floor", "kd");
    click(&mut harness, "Start fit");
    rest(&mut harness);
    assert_eq!(harness.state().fitting.trouble(), None);
    click(&mut harness, "Apply");
    let found = harness.state().workshop.values().get(floor, kd)[0];
    assert!((found - 0.25).abs() < 1e-3, "{found}");
}

#[test]
fn bounds_that_are_one_number_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut harness = fitting(PHONG);
    choose(&mut harness, &phong_samples(folder.path(), [0.2, 0.5, 30.0], 0.0));
    let row = harness.get_all_by_label("ks").map(|node| node.rect()).find(|rect| rect.left() < 780.0).expect("a row").center().y;
    let in_row = |field: &egui_kittest::Node<'_>| (field.rect().center().y - row).abs() < 6.0 && field.rect().left() < 780.0;
    harness.get_all_by_role(Role::SpinButton).find(in_row).expect("the lower bound").click();
    harness.run_steps(3);
    harness.event(egui::Event::Text("1".to_owned()));
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    click(&mut harness, "Start fit");
    let trouble = harness.state().fitting.trouble().map(str::to_owned);
    assert_eq!(trouble.as_deref(), Some("The bounds of ks are one number: give it a range, or take its mark away"));
    assert!(harness.state().fitting.share().is_none());
}

//! Rows of parameters, colours, and the sizes of panels.

use super::*;
use crate::evaluate::inspect::{Inspector, PassColours, figures};
use crate::formula::ParameterId;
use crate::picture::Transfer;
use crate::user_data::settings::PanelSide;
use crate::workspace::OwnerId;
use crate::workspace::session::PictureSettings;
use egui::{Pos2, Rect};

/// A harness with the body `ball` selected.
fn with_ball() -> Harness<'static, App> {
    let mut harness = harness();
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    harness
}

fn apply_formula(harness: &mut Harness<'_, App>, text: &str) {
    harness.state_mut().documents.formula.replace_text(text);
    harness.state_mut().perform(Action::Apply);
    settle(harness);
    harness.run_steps(2);
}

fn of_ball(app: &App, name: &str) -> (OwnerId, ParameterId) {
    let table = app.workshop.values().table();
    (table.owners().named("ball").expect("a body"), table.parameter_named(name).expect("a parameter"))
}

fn button(pos: Pos2, pressed: bool) -> egui::Event {
    let (button, modifiers) = (egui::PointerButton::Primary, egui::Modifiers::NONE);
    egui::Event::PointerButton { pos, button, pressed, modifiers }
}

fn rects(harness: &Harness<'_, App>, role: Role) -> Vec<Rect> {
    // Beside the picture: the menu and the editor have no such widgets, but the controls under the picture do.
    let pane = harness.state().pane.area();
    harness.get_all_by_role(role).map(|node| node.rect()).filter(|rect| rect.left() > pane.right()).collect()
}

#[test]
fn sliders_and_numbers_of_all_rows_are_below_each_other() {
    let mut harness = with_ball();
    apply_formula(
        &mut harness,
        "body_specific; kd: scalar, constraint 0..1, slider; ks: scalar, constraint 0..1, slider;
         quite_a_long_name_for_a_parameter_of_a_body: scalar, constraint 0..20000, default 12345;
         free: scalar, default 7; axis: vector, constraint -1..1;
         invariants; kd + ks = 1; formula; = kd*IL*Cd*max(0, N.L) + ks*IL;",
    );
    let ball = harness.get_all_by_label("ball").next().expect("a body");
    ball.click();
    harness.run_steps(3);
    for role in [Role::Slider, Role::SpinButton] {
        let found = rects(&harness, role);
        // Three of the colour and of the axis, and kr, kt, kd, ks, the long name and the one without a range.
        assert_eq!(found.len(), 12, "{role:?}");
        let first = found[0];
        for rect in &found {
            assert!((rect.left() - first.left()).abs() < 0.6 && (rect.width() - first.width()).abs() < 0.6, "{role:?} {found:?}");
        }
    }
    // A lock says why, and moves nothing.
    let tops: Vec<f32> = rects(&harness, Role::SpinButton).iter().map(|rect| rect.top()).collect();
    let steps: Vec<f32> = tops.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().all(|step| (step - steps[0]).abs() < 1.0), "{steps:?}");
    assert!(harness.query_by_label_contains("locked: ks").is_some());
}

#[test]
fn a_number_is_edited_with_all_its_digits() {
    let mut harness = with_ball();
    let (ball, kd) = of_ball(harness.state(), "kd");
    harness.state_mut().workshop.set(ball, kd, [0.123_456_7; 3]);
    harness.run_steps(2);
    let beside = harness.get_by_label("kd").rect().center().y;
    let is_beside = |field: &egui_kittest::Node<'_>| (field.rect().center().y - beside).abs() < 6.0;
    harness.get_all_by_role(Role::SpinButton).find(is_beside).expect("a field").click();
    harness.run_steps(3);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.state().workshop.values().get(ball, kd), [0.123_456_7], "leaving the field rounds nothing");
}

/// The field with the displayed colour of the selected body.
fn enter_hex(harness: &mut Harness<'_, App>, text: &str) {
    let row = harness.get_by_label("Cd").rect().center().y;
    let beside = |field: &egui_kittest::Node<'_>| (field.rect().center().y - row).abs() < 6.0;
    harness.get_all_by_role(Role::TextInput).find(beside).expect("a field").click();
    harness.run_steps(2);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.run_steps(2);
    harness.event(egui::Event::Text(text.to_owned()));
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
}

#[test]
fn a_hexadecimal_colour_is_the_displayed_one() {
    let mut harness = with_ball();
    let (ball, colour) = of_ball(harness.state(), "Cd");
    for (transfer, expected) in [(Transfer::Linear, 128.0 / 255.0), (Transfer::Srgb, 0.215_860_5)] {
        let mut settings = harness.state().workshop.settings();
        settings.view.transfer = transfer;
        // Exposure is light on the scene, not a part of the value.
        settings.view.exposure = 1.0;
        harness.state_mut().workshop.set_picture(settings).expect("a valid setting");
        harness.state_mut().workshop.set(ball, colour, [0.3; 3]);
        harness.run_steps(2);
        enter_hex(&mut harness, "#80ff00");
        let found = harness.state().workshop.values().get(ball, colour).to_vec();
        // The value of the byte 128 in the table of the standard IEC 61966-2-1.
        let near = (found[0] - expected).abs() < 1e-5 && (found[1] - 1.0).abs() < 1e-6 && found[2] == 0.0;
        assert!(near, "{transfer:?}: {found:?}");
        // What is no colour changes nothing.
        enter_hex(&mut harness, "80ff0");
        assert_eq!(harness.state().workshop.values().get(ball, colour), found);
    }
}

#[test]
fn a_drag_in_the_picker_is_live_and_one_undo_step() {
    let mut harness = with_ball();
    let (ball, colour) = of_ball(harness.state(), "Cd");
    let before = harness.state().workshop.values().get(ball, colour).to_vec();
    let swatch = harness.get_by_label("Colour");
    let rect = swatch.rect();
    swatch.click();
    harness.run_steps(3);
    // The square of the picker is below its swatch.
    let at = |x: f32, y: f32| Pos2::new(rect.left() + 30.0 + x, rect.bottom() + 40.0 + y);
    harness.input_mut().events.extend([egui::Event::PointerMoved(at(0.0, 0.0)), button(at(0.0, 0.0), true)]);
    harness.step();
    let mut seen = Vec::new();
    for step in 1..6 {
        harness.input_mut().events.push(egui::Event::PointerMoved(at(12.0 * step as f32, 8.0 * step as f32)));
        harness.step();
        assert_eq!(harness.state().workshop.held(), Some((ball, colour)), "held like a slider");
        seen.push(harness.state().workshop.values().get(ball, colour).to_vec());
        settle(&mut harness);
    }
    seen.dedup();
    assert_eq!(seen.len(), 5, "the value follows the pointer");
    harness.input_mut().events.push(button(at(60.0, 40.0), false));
    harness.run_steps(3);
    assert!(harness.state().workshop.held().is_none());
    assert_ne!(harness.state().workshop.values().get(ball, colour), before);
    settle(&mut harness);
    assert_eq!(harness.state().log.lines_with("dragged ball.Cd"), 1, "one line in the log");
    assert!(harness.state_mut().workshop.undo());
    assert_eq!(harness.state().workshop.values().get(ball, colour), before, "one step back");
    assert!(!harness.state_mut().workshop.undo());
}

#[test]
fn panels_keep_the_sizes_that_the_user_dragged() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let mut harness = harness_in(Some(&folders));
    let borders = |harness: &Harness<'_, App>| {
        let state = |name: &str| egui::panel::PanelState::load(&harness.ctx, egui::Id::new((name, false))).expect("a panel");
        let owners = egui::panel::PanelState::load(&harness.ctx, egui::Id::new("owners")).expect("a panel");
        let [texts, parameters] = [PanelSide::Texts, PanelSide::Parameters].map(|side| state(side.key()).outer_rect);
        let inside = egui::vec2(1.0, 0.0);
        [texts.right_center() - inside, parameters.left_center() + inside, owners.outer_rect.center_bottom()]
    };
    let sizes = |harness: &Harness<'_, App>| {
        let panels = harness.state().user_state.settings.window.panels;
        [PanelSide::Texts, PanelSide::Parameters, PanelSide::Owners].map(|side| panels.get(side))
    };
    let before = sizes(&harness);
    let by = [egui::vec2(-60.0, 0.0), egui::vec2(-50.0, 0.0), egui::vec2(0.0, 40.0)];
    for (index, by) in by.into_iter().enumerate() {
        let from = borders(&harness)[index];
        harness.input_mut().events.extend([egui::Event::PointerMoved(from), button(from, true)]);
        harness.step();
        for part in [0.5, 1.0, 1.0] {
            harness.input_mut().events.push(egui::Event::PointerMoved(from + by * part));
            harness.step();
        }
        harness.input_mut().events.push(button(from + by, false));
        harness.run_steps(2);
    }
    let after = sizes(&harness);
    let moved = [after[0] - before[0], after[1] - before[1], after[2] - before[2]];
    assert!(moved.iter().zip([-60.0, 50.0, 40.0]).all(|(found, wanted)| (found - wanted).abs() < 4.0), "{moved:?}");
    harness.state_mut().closing();
    drop(harness);
    let harness = harness_in(Some(&folders));
    assert_eq!(sizes(&harness), after);
    let texts = egui::panel::PanelState::load(&harness.ctx, egui::Id::new((PanelSide::Texts.key(), false))).expect("a panel");
    assert!((texts.size().x - after[0]).abs() < 2.0);
}

#[test]
fn the_first_start_suits_the_screen_and_later_ones_the_user() {
    let home = tempfile::tempdir().expect("a folder");
    let folders = Folders::below(home.path());
    let open = || App::new(Some(&Location::Preset("studio".to_owned())), Some(&folders)).expect("a built-in session");
    let mut app = open();
    app.start_on_screen([2560, 1440], 1.5);
    assert_eq!((app.scale, app.window_size()), (1.5, [1920, 1200]));
    app.closing();
    drop(app);
    let mut app = open();
    app.start_on_screen([1280, 800], 1.0);
    assert_eq!(app.scale, 1.5, "remembered");
    app.perform(Action::SetScale(1.25));
    app.closing();
    drop(app);
    let mut app = open();
    app.start_on_screen([2560, 1440], 1.5);
    assert_eq!(app.scale, 1.25, "the choice of the user wins");
    // On a small screen the window is not larger than it.
    let mut app = App::new(None, None).expect("the built-in session");
    app.start_on_screen([1024, 640], 1.0);
    assert_eq!(app.window_size(), [1024, 640]);
    let panels = app.user_state.settings.window.panels;
    assert!(panels.get(PanelSide::Texts) + panels.get(PanelSide::Parameters) < 600.0, "{panels:?}");
}

/// Waits until this many passes of the picture are traced.
fn with_passes(harness: &mut Harness<'_, App>, passes: u32) {
    let settings = PictureSettings { samples: Some(passes), ..harness.state().workshop.settings() };
    harness.state_mut().workshop.set_picture(settings).expect("settings in range");
    for _ in 0..30_000 {
        harness.step();
        if harness.state().workshop.renderer().passes() == [passes; 2] && harness.state().workshop.is_up_to_date() {
            harness.run_steps(10);
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("no passes came: {:?}", harness.state().workshop.renderer().passes());
}

#[test]
fn the_inspector_shows_the_mean_of_passes_or_the_rays_of_one() {
    let mut harness = harness();
    harness.key_press(egui::Key::F5);
    harness.run_steps(5);
    let pixel = [31, 20];
    harness.state_mut().perform(Action::InspectPixel(pixel));
    with_passes(&mut harness, 1);
    assert!(harness.query_by_label_contains("Mean").is_none(), "one pass has no mean");
    with_passes(&mut harness, 4);
    let workshop = &harness.state().workshop;
    let inspector = Inspector::new(workshop.formula(), workshop.world(), workshop.values().numbers());
    let view = workshop.view().expect("a view");
    let colours = PassColours { colours: inspector.pass_colours(&view, pixel, 0..4) };
    let text = |colour: [f32; 3]| format!("<{}>", colour.map(|component| figures(f64::from(component))).join(", "));
    let (texts, mean) = (colours.colours.iter().map(|colour| text(*colour)).collect::<Vec<_>>(), text(colours.mean()));
    assert!(texts.iter().any(|text| *text != mean), "{texts:?}");
    harness.get_by_label("Mean of 4");
    assert!(harness.query_by_label_contains("seen, weight 1").is_some(), "the rays of the first pass");
    harness.get_by_label("Colours of the passes").click();
    harness.run_steps(20);
    assert!(harness.query_all_by_label(&mean).next().is_some(), "{mean}");
    for (pass, text) in texts.iter().enumerate() {
        harness.get_by_label(&format!("pass {pass}"));
        assert!(harness.query_all_by_label(text).next().is_some(), "{text}");
    }
    harness.get_by_label("pass 2").click();
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("seen, weight 1").is_some());
    assert!(harness.query_all_by_label(&texts[2]).next().is_some() && harness.query_by_label("pass 3").is_none());
    // Fewer passes: the last of them is shown.
    with_passes(&mut harness, 2);
    assert!(harness.query_all_by_label(&texts[1]).next().is_some());
    harness.get_by_label("Mean").click();
    harness.run_steps(5);
    assert!(harness.query_by_label("pass 1").is_some() && harness.query_by_label("pass 2").is_none());
    with_passes(&mut harness, 1);
    assert!(harness.query_by_label_contains("seen, weight 1").is_some());
    assert!(harness.query_all_by_label(&texts[0]).next().is_some());
}

#[test]
fn the_inspector_is_below_the_picture_and_marks_its_pixel() {
    let mut harness = harness();
    harness.key_press(egui::Key::F5);
    harness.run_steps(5);
    let pane = harness.state().pane.area();
    let at = pane.center();
    harness.drag_at(at);
    harness.run_steps(2);
    harness.drop_at(at);
    harness.run_steps(3);
    let title = harness.get_by_label_contains("Pixel (").rect();
    let pane = harness.state().pane.area();
    assert!(title.top() >= pane.bottom(), "the clicked pixel stays in view");
    let panel = egui::panel::PanelState::load(&harness.ctx, egui::Id::new("inspector")).expect("a panel").outer_rect;
    assert!(title.bottom() - panel.top() < 36.0, "the title takes one row: {title:?} in {panel:?}");
    assert!(harness.get_by_label_contains("seen, weight 1").rect().bottom() < panel.bottom());
    harness.get_by_label("×").click();
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Pixel (").is_none() && !harness.state().inspector.open);
    assert!(harness.state().pane.area().height() > pane.height());
}

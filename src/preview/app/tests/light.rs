//! The picture as composed, and the controls of light under it.

use super::*;
use crate::picture::{ToneCurve, Transfer};
use crate::preview::app::action::{PanelId, PictureOverlay};
use crate::preview::app::pane::{Zoom, clipping};
use crate::workspace::Session;

/// The session that is saved now.
fn saved(app: &mut App) -> Session {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("saved.toml");
    app.perform(Action::SaveTo(Some(FileKind::Session), path.clone()));
    let text = std::fs::read_to_string(path).expect("a session");
    Session::parse(&crate::lang::source::Source::new("saved", text)).expect("a session").0
}

#[test]
fn the_picture_is_fitted_and_the_session_keeps_its_size() {
    let mut harness = harness();
    let size = harness.state().workshop.settings().size;
    harness.state_mut().perform(Action::Zoom(Zoom::Fit));
    harness.run_steps(2);
    let app = harness.state();
    let (pane, shown) = (app.pane.area().size(), app.pane.placement(&app.workshop).shown());
    let touches = |shown: u32, pane: f32| (shown as f32 - pane).abs() < 2.0;
    assert!(touches(shown[0], pane.x) || touches(shown[1], pane.y), "{shown:?} in {pane:?}");
    assert!(shown[0] as f32 <= pane.x + 1.0 && shown[1] as f32 <= pane.y + 1.0);
    // Another pane shows the same picture: nothing is traced.
    let stamp = app.workshop.stamp();
    harness.state_mut().perform(Action::TogglePanel(PanelId::Log));
    harness.run_steps(40);
    assert_eq!(harness.state().workshop.stamp(), stamp);
    // As large as its pane, the picture has another size, but the session does not.
    harness.state_mut().perform(Action::Zoom(Zoom::Pane));
    harness.run_steps(40);
    settle(&mut harness);
    assert_ne!(harness.state().workshop.size(), size);
    assert_eq!(saved(harness.state_mut()).picture.size, size);
    assert!(!harness.state().session_is_unsaved());
}

#[test]
fn exposure_and_curve_are_kept_in_the_session_and_evaluate_nothing() {
    let mut harness = harness();
    let before = settle(&mut harness);
    let mut settings = harness.state().workshop.settings();
    settings.view.exposure = 1.0;
    settings.view.curve = ToneCurve::Aces;
    harness.state_mut().workshop.set_picture(settings).expect("in range");
    let frames = harness.state().log.last_frame();
    let exposed = settle(&mut harness);
    assert_ne!(exposed, before);
    assert_eq!(harness.state().log.last_frame(), frames, "no frame was evaluated");
    let shown = harness.state().workshop.shown();
    let linear = &shown.linear.as_ref().expect("linear colours").linear;
    for (pixel, colour) in shown.pixels.iter().zip(linear) {
        for (byte, component) in pixel.to_be_bytes()[1..].iter().zip(colour) {
            let exact = 255.0 * settings.view.at(f64::from(*component));
            assert!((f64::from(*byte) - exact).abs() <= 0.51, "{byte} for {component}");
        }
    }
    assert_eq!(saved(harness.state_mut()).picture.view, settings.view);
}

#[test]
fn clipped_pixels_are_marked_on_demand() {
    let mut harness = harness();
    let mut settings = harness.state().workshop.settings();
    settings.view.exposure = 4.0;
    harness.state_mut().workshop.set_picture(settings).expect("in range");
    settle(&mut harness);
    harness.state_mut().perform(Action::ToggleOverlay(PictureOverlay::Clipping));
    harness.run_steps(2);
    let marked = |harness: &Harness<'_, App>| {
        let app = harness.state();
        app.pane.picture(&app.workshop).pixels.iter().filter(|pixel| **pixel == clipping::TOO_BRIGHT).count()
    };
    assert!(marked(&harness) > 100);
    harness.state_mut().perform(Action::ToggleOverlay(PictureOverlay::Clipping));
    harness.run_steps(2);
    assert_eq!(marked(&harness), 0);
}

#[test]
fn the_picture_is_copied_without_the_marks() {
    let mut harness = harness();
    let mut settings = harness.state().workshop.settings();
    settings.view.exposure = 4.0;
    harness.state_mut().workshop.set_picture(settings).expect("in range");
    let plain = settle(&mut harness);
    let context = harness.ctx.clone();
    harness.state_mut().started(&context);
    harness.state_mut().perform(Action::ToggleOverlay(PictureOverlay::Clipping));
    harness.run_steps(2);
    harness.state_mut().perform(Action::CopyPicture);
    let commands = context.output(|output| output.commands.clone());
    let copied = commands.into_iter().find_map(|command| match command {
        egui::OutputCommand::CopyImage(image) => Some(image),
        egui::OutputCommand::CopyText(_) | egui::OutputCommand::OpenUrl(_) => None,
    });
    let words = |image: egui::ColorImage| {
        image.pixels.iter().map(|pixel| u32::from_be_bytes([0, pixel.r(), pixel.g(), pixel.b()])).collect::<Vec<_>>()
    };
    assert!(words(copied.expect("a picture")) == plain);
    let app = harness.state();
    assert!(app.pane.picture(&app.workshop).pixels != plain, "the marks are still in view");
}

#[test]
fn a_pixel_that_is_no_number_is_called_nan_and_displayed_as_black() {
    let mut harness = harness();
    harness.state_mut().documents.formula.replace_text("formula;\n= IL*sqrt(-max(0, N.L));\n");
    harness.state_mut().perform(Action::Apply);
    settle(&mut harness);
    harness.run_steps(2);
    let (_, [x, y]) = harness.state().log.undefined().expect("pixels without a number");
    let app = harness.state();
    let at = app.pane.placement(&app.workshop).position_of([x as f32 + 0.5, y as f32 + 0.5]);
    harness.hover_at(at);
    harness.run_steps(3);
    assert_eq!(harness.state().pane.pointed(), Some([x, y]));
    assert!(harness.query_by_label("NaN NaN NaN").is_some() && harness.query_by_label("#000000").is_some());
    // Another exposure only encodes the picture again, and it is still known.
    let brighter = crate::picture::ViewTransform { exposure: 2.0, ..view(&harness) };
    harness.state_mut().workshop.set_view(brighter);
    settle(&mut harness);
    harness.run_steps(3);
    assert!(harness.query_by_label("NaN NaN NaN").is_some());
}

#[test]
fn a_new_session_is_exposed_by_its_first_picture_and_counts_as_saved() {
    let mut harness = harness();
    // Three lights of full intensity are too bright for this formula.
    harness.state_mut().documents.formula.replace_text("formula;\n= IL*Cd*max(0, N.L);\n");
    harness.state_mut().perform(Action::Apply);
    harness.state_mut().perform(Action::NewSession);
    for _ in 0..3 {
        settle(&mut harness);
    }
    let app = harness.state();
    let view = app.workshop.settings().view;
    assert!(view.exposure < -0.3, "{view:?}");
    let shown = app.workshop.shown();
    let brightest = |colour: &[f32; 3]| colour.iter().copied().fold(0.0, f32::max);
    let linear = &shown.linear.as_ref().expect("linear colours").linear;
    let clipped = linear.iter().filter(|colour| f64::from(brightest(colour)) * view.factor() > 1.0).count();
    assert!(clipped * 50 < linear.len(), "{clipped} of {} pixels are clipped", linear.len());
    assert!(!app.session_is_unsaved());
}

#[test]
fn the_switch_of_the_transfer_is_under_the_picture() {
    let mut harness = harness();
    assert_eq!(harness.state().workshop.settings().view.transfer, Transfer::Srgb);
    harness.get_by_label("sRGB").click();
    harness.run_steps(2);
    assert_eq!(harness.state().workshop.settings().view.transfer, Transfer::Linear);
}

#[test]
fn a_scene_opened_alone_has_colours_glass_and_a_sensible_exposure() {
    let mut harness = harness();
    harness.state_mut().perform(Action::Open(FileKind::Scene, Location::Preset("crystals".to_owned())));
    for _ in 0..3 {
        settle(&mut harness);
    }
    let app = harness.state();
    let values = app.workshop.values();
    let value = |body: &str, parameter: &str| {
        let owner = values.table().owners().named(body).expect("a body");
        values.get(owner, values.table().parameter_named(parameter).expect("a parameter")).to_vec()
    };
    assert_ne!(value("coral", "Cd"), value("ivory", "Cd"));
    assert_eq!(value("wall", "Cd"), [0.8; 3], "a wall is neutral");
    assert!(value("globe", "kt")[0] > 0.5 && value("coral", "kt") == [0.0]);
    let shown = app.workshop.shown();
    let white = shown.pixels.iter().filter(|pixel| **pixel == 0x00ff_ffff).count();
    let dark = shown.pixels.iter().filter(|pixel| pixel.to_be_bytes()[1..].iter().all(|byte| *byte < 8)).count();
    assert!(white * 50 < shown.pixels.len() && dark * 4 < shown.pixels.len(), "{white} white and {dark} dark pixels");
}

/// The exposure, the curve and the transfer.
fn view(harness: &Harness<'_, App>) -> crate::picture::ViewTransform {
    harness.state().workshop.settings().view
}

#[test]
fn exposure_curve_and_transfer_are_undone_step_by_step_and_values_in_order_with_them() {
    let mut harness = harness();
    let first = settle(&mut harness);
    let start = view(&harness);
    let beside = harness.get_by_label("EV").rect();
    let is_beside = |slider: &egui_kittest::Node<'_>| (slider.rect().center().y - beside.center().y).abs() < 6.0;
    let slider = harness.get_all_by_role(Role::Slider).find(is_beside).expect("the slider of the exposure").rect();
    // A drag is one step, however many movements it has.
    let at = |share: f32| slider.left_center() + egui::vec2(share * slider.width(), 0.0);
    harness.drag_at(at(0.5));
    harness.run_steps(2);
    for step in 0..5 {
        harness.hover_at(at(0.5 + 0.05 * step as f32));
        harness.run_steps(1);
    }
    harness.drop_at(at(0.75));
    harness.run_steps(2);
    let dragged = view(&harness);
    assert!(dragged.exposure > 1.0, "{dragged:?}");
    // A value in between.
    let app = harness.state_mut();
    let ambient = app.workshop.formula().predefined(crate::lang::variables::Predefined::Ambient);
    let before = app.workshop.values().clone();
    app.workshop.set(crate::workspace::OwnerId::Global, ambient, [0.9; 3]);
    settle(&mut harness);
    harness.get_by_label("Auto").click();
    harness.run_steps(2);
    let automatic = view(&harness);
    assert_ne!(automatic.exposure, dragged.exposure);
    harness.get_by_label("sRGB").click();
    harness.run_steps(2);
    let curved = crate::picture::ViewTransform { curve: ToneCurve::Aces, ..view(&harness) };
    harness.state_mut().workshop.set_view(curved);
    let last = view(&harness);
    assert_eq!((last.curve, last.transfer), (ToneCurve::Aces, Transfer::Linear));
    let undo = |harness: &mut Harness<'_, App>| {
        let [name, _] = harness.state().undo_and_redo_names();
        harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Z);
        harness.run_steps(2);
        name.expect("something to undo")
    };
    assert_eq!(undo(&mut harness), "the tone curve");
    assert_eq!(undo(&mut harness), "sRGB");
    assert_eq!(view(&harness), automatic);
    assert_eq!(undo(&mut harness), "the exposure");
    assert_eq!(view(&harness), dragged);
    // The exposure stays as it was when a value is undone.
    assert_eq!(undo(&mut harness), "ka");
    assert!(view(&harness) == dragged && *harness.state().workshop.values() == before);
    assert_eq!(undo(&mut harness), "the exposure");
    assert!(view(&harness) == start && settle(&mut harness) == first);
    assert_eq!(harness.state().workshop.can_undo_and_redo(), [false, true]);
    for _ in 0..5 {
        harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Y);
        harness.run_steps(2);
    }
    assert_eq!(view(&harness), last);
    assert_eq!(harness.state().workshop.can_undo_and_redo(), [true, false]);
}

#[test]
fn what_the_first_picture_chooses_is_no_step_and_undo_of_a_value_keeps_it() {
    let mut harness = harness();
    let app = harness.state_mut();
    let ambient = app.workshop.formula().predefined(crate::lang::variables::Predefined::Ambient);
    app.workshop.set(crate::workspace::OwnerId::Global, ambient, [0.9; 3]);
    app.perform(Action::Open(FileKind::Scene, Location::Preset("crystals".to_owned())));
    for _ in 0..3 {
        settle(&mut harness);
    }
    let chosen = view(&harness);
    harness.state_mut().perform(Action::Undo);
    assert_eq!((view(&harness), harness.state().workshop.can_undo_and_redo()), (chosen, [false, true]));
}

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

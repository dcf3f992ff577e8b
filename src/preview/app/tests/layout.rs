//! Nothing is cut off, whatever the size of the window.

use super::*;
use crate::preview::app::action::PanelId;
use crate::workspace::presets;
use egui::Rect;

/// The rectangles of widgets with these labels.
fn rects(harness: &Harness<'_, App>, labels: &[&str]) -> Vec<Rect> {
    let rect = |label: &&str| harness.get_all_by_label(label).next().unwrap_or_else(|| panic!("no {label}")).rect();
    labels.iter().map(rect).collect()
}

#[test]
fn every_control_is_within_its_panel_at_every_size() {
    let mut harness = harness();
    harness.get_all_by_label("ball").next().expect("a body").click();
    harness.run_steps(3);
    for size in [[700.0, 480.0], [860.0, 560.0], [1024.0, 640.0], [1280.0, 800.0], [1707.0, 960.0]] {
        harness.set_size(egui::vec2(size[0], size[1]));
        for inspector in [false, true] {
            if harness.state().inspector.open != inspector {
                harness.state_mut().perform(Action::TogglePanel(PanelId::Inspector));
            }
            harness.run_steps(4);
            let window = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(size[0], size[1]));
            let pane = harness.state().pane.area();
            let short = harness.query_by_label("Exposure").is_none();
            let named = if short { ["EV", "Clip", "Hist"] } else { ["Exposure", "Clipping", "Histogram"] };
            let controls = ["Fit", "1:1", "Pane", "−", "+", named[0], "Auto", "sRGB", named[1], named[2]];
            if !inspector {
                let mut centres: Vec<f32> = rects(&harness, &controls).iter().map(|rect| rect.center().y).collect();
                centres.sort_by(f32::total_cmp);
                let rows = 1 + centres.windows(2).filter(|pair| pair[1] - pair[0] > 12.0).count();
                let most = if size[0] >= 1280.0 { 1 } else { 2 };
                assert!(
                    size[0] < 1024.0 || rows <= most,
                    "the controls take {rows} rows at {size:?}, pane {pane:?}: {centres:?}"
                );
                assert_eq!(short, size[0] < 1700.0, "at {size:?}");
            }
            for (rect, name) in rects(&harness, &controls).into_iter().zip(controls) {
                let inside = rect.left() >= pane.left() - 1.0 && rect.right() <= pane.right() + 1.0;
                assert!(inside && rect.bottom() < window.bottom(), "{name} at {size:?}: {rect:?}, pane {pane:?}");
            }
            let parameters = ["Ambient light", "Cd", "Save material", "Delete"];
            for (rect, name) in rects(&harness, &parameters).into_iter().zip(parameters) {
                let inside = rect.left() >= pane.right() && rect.right() <= window.right();
                assert!(inside && rect.bottom() < window.bottom(), "{name} at {size:?}: {rect:?}, window {window:?}");
            }
            assert!(pane.height() > 60.0 && pane.width() >= 150.0, "the picture keeps room at {size:?}: {pane:?}");
        }
    }
}

#[test]
fn the_list_of_bodies_and_lights_shows_whole_rows() {
    let mut harness = harness();
    harness.state_mut().perform(Action::Open(FileKind::Scene, Location::Preset("crystals".to_owned())));
    for height in [560.0, 571.0, 583.0] {
        harness.set_size(egui::vec2(1100.0, height));
        harness.run_steps(4);
        let owners = harness.state().workshop.values().table().owners();
        let names: Vec<String> = owners.all().filter_map(|owner| owners.name(owner)).map(str::to_owned).collect();
        let pane = harness.state().pane.area();
        let material = harness.get_by_label("Material").rect().top();
        let of_list = |rect: &Rect| rect.left() > pane.right() && rect.height() > 15.0;
        let tops: Vec<f32> = names
            .iter()
            .flat_map(|name| harness.get_all_by_label(name).map(|node| node.rect()).filter(of_list).collect::<Vec<_>>())
            .map(|rect| rect.top())
            .collect();
        assert!(tops.len() > 4, "{tops:?}");
        let off = |top: &&f32| ((**top - tops[0]) / 22.0).fract().abs() > 0.01;
        assert_eq!(tops.iter().find(off), None, "rows of one height");
        assert!(tops[0] < material);
    }
}

#[test]
fn the_texts_of_cards_keep_off_their_edges() {
    let mut harness = harness();
    harness.set_size(egui::vec2(1280.0, 800.0));
    harness.state_mut().perform(Action::ShowGallery);
    harness.run_steps(4);
    for preset in presets::all(FileKind::Session) {
        let card = harness.get_by_role_and_label(Role::Button, preset.name).rect();
        let about = harness.get_by_role_and_label(Role::Label, preset.about).rect();
        assert!(about.bottom() <= card.bottom() - 6.0 && about.left() > card.left(), "{}: {about:?} in {card:?}", preset.name);
    }
}

#[test]
fn panels_get_their_sizes_back_when_there_is_room_again() {
    let mut harness = harness();
    let height = |harness: &mut Harness<'_, App>, size: [f32; 2]| {
        harness.set_size(egui::vec2(size[0], size[1]));
        harness.run_steps(6);
        let id = egui::Id::new("instruments");
        egui::panel::PanelState::load(&harness.ctx, id).expect("the instruments are open").size().y
    };
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    let before = height(&mut harness, [1280.0, 900.0]);
    assert_eq!(before, 380.0);
    harness.state_mut().perform(Action::TogglePanel(PanelId::Log));
    let small = height(&mut harness, [900.0, 600.0]);
    assert!(small < 0.7 * before, "{small}");
    harness.state_mut().perform(Action::TogglePanel(PanelId::Log));
    assert_eq!(height(&mut harness, [1280.0, 900.0]), before);
}

#[test]
fn charts_have_room_in_a_small_window() {
    let mut harness = harness();
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    for (size, least) in [([900.0, 600.0], [300, 110]), ([1024.0, 640.0], [400, 140]), ([1280.0, 800.0], [300, 200])] {
        harness.set_size(egui::vec2(size[0], size[1]));
        harness.run_steps(6);
        let chart = harness.state().instruments.chart_size();
        assert!(chart[0] >= least[0] && chart[1] >= least[1], "{chart:?} at {size:?}");
        let pane = harness.state().pane.area();
        assert!(pane.width() >= 150.0 && pane.height() >= 120.0, "{pane:?} at {size:?}");
    }
}

#[test]
fn panels_below_never_take_the_picture_and_become_tabs() {
    let mut harness = harness();
    for panel in [PanelId::Inspector, PanelId::Instruments, PanelId::Fitting] {
        harness.state_mut().perform(Action::TogglePanel(panel));
        harness.run_steps(2);
    }
    let tabs =
        |harness: &Harness<'_, App>| harness.query_by_label("Start fit").is_some() != harness.query_by_label("Keep").is_some();
    for (size, has_tabs) in [([900.0, 600.0], true), ([1024.0, 700.0], true), ([1440.0, 900.0], false)] {
        harness.set_size(egui::vec2(size[0], size[1]));
        harness.run_steps(6);
        let pane = harness.state().pane.area();
        assert!(pane.width() >= 150.0 && pane.height() >= 100.0, "{pane} at {size:?}");
        assert_eq!(tabs(&harness), has_tabs, "at {size:?}");
    }
    harness.set_size(egui::vec2(900.0, 600.0));
    harness.run_steps(6);
    // The panel that was opened last is in view, and a tab chooses another one.
    assert!(harness.query_by_label("Start fit").is_some() && harness.query_by_label("Keep").is_none());
    let tab = harness.query_all_by_label("Instruments").last().expect("a tab");
    tab.click();
    harness.run_steps(6);
    assert!(harness.query_by_label("Start fit").is_none() && harness.query_by_label("Keep").is_some());
}

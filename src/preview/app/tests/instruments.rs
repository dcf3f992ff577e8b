//! The instruments in the window.

use super::*;
use crate::instrument::view::VIEWS;
use crate::preview::app::action::PanelId;
use crate::preview::app::instruments::InstrumentPlace;

/// A window that shows a formula in the instruments.
fn instruments(text: &str) -> Harness<'static, App> {
    let mut harness = harness();
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    apply(&mut harness, text);
    settle_instruments(&mut harness);
    harness
}

fn apply(harness: &mut Harness<'_, App>, text: &str) {
    harness.state_mut().documents.formula.replace_text(text);
    harness.state_mut().perform(Action::Apply);
    settle(harness);
}

/// Waits until chart and verdict are those of the values.
fn settle_instruments(harness: &mut Harness<'_, App>) {
    for _ in 0..30_000 {
        harness.step();
        if harness.state().instruments.is_settled() {
            harness.run_steps(2);
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("no chart came");
}

const LAMBERT: &str = "body_specific; part: scalar, constraint 0..4, default 0.5, slider; formula; = part*IL*max(0, N.L);";

/// Sets a value of all bodies.
fn set_all(harness: &mut Harness<'_, App>, name: &str, value: f32) {
    let workshop = &mut harness.state_mut().workshop;
    let id = workshop.formula().parameter_named(name).expect("a parameter");
    let bodies: Vec<OwnerId> = workshop.scene().body_ids().map(OwnerId::Body).collect();
    bodies.into_iter().for_each(|body| workshop.set(body, id, [value; 3]));
}

/// Sets a colour of all lights.
fn set_all_of_lights(harness: &mut Harness<'_, App>, name: &str, value: [f32; 3]) {
    let workshop = &mut harness.state_mut().workshop;
    let id = workshop.formula().parameter_named(name).expect("a parameter");
    let lights: Vec<OwnerId> = workshop.scene().light_ids().map(OwnerId::Light).collect();
    lights.into_iter().for_each(|light| workshop.set(light, id, value));
}

#[test]
fn the_verdict_follows_a_value_and_leads_to_the_albedo() {
    let mut harness = instruments(LAMBERT);
    assert!(harness.query_by_label_contains("Conserves energy: at most 50 % of the light").is_some());
    set_all(&mut harness, "part", 1.2);
    settle_instruments(&mut harness);
    let verdict = harness.get_by_label_contains("Gives out more light than it gets: 120 % at");
    verdict.click();
    settle_instruments(&mut harness);
    assert_eq!(harness.state().instruments.controls_view(), "albedo");
}

#[test]
fn every_view_is_chosen_by_its_name_and_drawn() {
    let mut harness = instruments(LAMBERT);
    for view in &VIEWS {
        let mut title = view.name.to_owned();
        title[..1].make_ascii_uppercase();
        harness.get_by_label(&title).click();
        harness.step();
        settle_instruments(&mut harness);
        assert_eq!(harness.state().instruments.controls_view(), view.name);
        assert!(harness.query_by_label_contains("Drawing…").is_none(), "{}", view.name);
    }
}

#[test]
fn saved_numbers_are_those_of_the_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = instruments(LAMBERT);
    for name in ["chart.csv", "chart.svg", "chart.png", "chart.gif"] {
        harness.state_mut().perform(Action::Instruments(InstrumentAction::Save(folder.path().join(name))));
        harness.state_mut().jobs.wait();
        harness.step();
    }
    let message = harness.state().dialogs.message().unwrap_or_default().to_owned();
    assert!(message.contains("chart.gif` names no format of charts; their suffixes are .png, .svg, .csv"), "{message}");
    let text = std::fs::read_to_string(folder.path().join("chart.csv")).unwrap();
    let mut rows = text.lines();
    assert!(rows.next().unwrap().starts_with("outgoing angle (°),"), "{text}");
    let mut count = 0;
    // A matte BRDF is its albedo over π, in every direction.
    for row in rows {
        let numbers = row.split(',').skip(1).filter(|cell| !cell.is_empty()).map(|number| number.parse::<f64>().unwrap());
        for number in numbers {
            assert!((number - 0.5 / std::f64::consts::PI).abs() < 1e-5, "{row}");
            count += 1;
        }
    }
    assert!(count > 900, "{count}");
    let svg = std::fs::read_to_string(folder.path().join("chart.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.contains("Reflection in the plane of incidence"));
    let png = std::fs::read(folder.path().join("chart.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG") && !folder.path().join("chart.gif").exists());
}

#[test]
fn kept_models_stay_as_they_were() {
    let mut harness = instruments(LAMBERT);
    harness.get_by_label("Keep").click();
    harness.step();
    set_all(&mut harness, "part", 0.25);
    harness.get_by_label("Albedo").click();
    settle_instruments(&mut harness);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("albedo.csv");
    harness.state_mut().perform(Action::Instruments(InstrumentAction::Save(path.clone())));
    harness.state_mut().jobs.wait();
    let text = std::fs::read_to_string(path).unwrap();
    for row in text.lines().skip(1) {
        let shares: Vec<f64> = row.split(',').skip(1).map(|number| number.parse().unwrap()).collect();
        assert!(shares.len() == 2 && (shares[0] - 0.25).abs() < 1e-3 && (shares[1] - 0.5).abs() < 1e-3, "{row}");
    }
    for _ in 0..7 {
        harness.get_by_label("Keep").click();
        harness.step();
    }
    assert_eq!(harness.state().instruments.overlay_count(), 6);
}

#[test]
fn a_hit_gives_the_directions_and_the_place() {
    let mut harness = instruments("body_specific; p: scalar, default 1, slider; formula; = p*IL*<u, 0.5*v, 0.25>*max(0, N.L);");
    let pixel = [32, 24];
    let app = harness.state_mut();
    let view = app.workshop.view().unwrap();
    let world = std::sync::Arc::clone(app.workshop.world());
    let formula = std::sync::Arc::clone(app.workshop.formula());
    let numbers = app.workshop.values().numbers().to_vec();
    let inspection = crate::evaluate::inspect::Inspector::new(&formula, &world, &numbers).inspect(&view, pixel).unwrap();
    let hit = inspection.hit(0).expect("a body in the middle");
    let light = hit.lights.iter().find(|light| light.evaluated && light.variables.alpha < 1.5).expect("a light that reaches it");
    let place = InstrumentPlace::new(pixel, hit, light);
    app.parameters.select(OwnerId::Body(place.body));
    app.instruments.look_at(place);
    settle_instruments(&mut harness);
    let app = harness.state();
    let (value, angle) = app.instruments.value_at_place().expect("a value");
    // The instruments have white light, so this is the formula itself, for the angle of that light.
    let cosine = light.variables.alpha.cos();
    let [u, v] = hit.variables.coordinates.to_array();
    let wanted = [u * cosine, 0.5 * v * cosine, 0.25 * cosine];
    assert!(value.iter().zip(wanted).all(|(one, other)| (one - other).abs() < 1e-4), "{value:?} {wanted:?}");
    assert!((angle - f64::from(light.variables.alpha.to_degrees())).abs() < 1e-2);
}

/// The number in the field beside a label.
fn typed(harness: &mut Harness<'_, App>, label: &str, number: &str) {
    harness.get_by_role_and_label(Role::SpinButton, label).click();
    harness.run_steps(3);
    harness.event(egui::Event::Text(number.to_owned()));
    harness.key_press(egui::Key::Enter);
    harness.run_steps(3);
    settle_instruments(harness);
}

#[test]
fn a_viewer_that_is_typed_has_its_numbers_read_out_for_each_light_and_model() {
    let text = "body_specific; part: scalar, constraint 0..4, default 0.5, slider; formula;
        = part*IL*max(0, N.L)*<1, 0.5, N.V>;";
    let mut harness = instruments(text);
    typed(&mut harness, "Viewer at", "-60");
    // 0.5/π and 0.25/π; the third is 0.5/π · cos 60°. The value is π · BRDF · cos θ of the light.
    for words in [
        "viewer −60°; light 0°: BRDF (0.1592, 0.07958, 0.07958), value (0.5, 0.25, 0.25)",
        "light 60°: BRDF (0.1592, 0.07958, 0.07958), value (0.25, 0.125, 0.125)",
    ] {
        assert!(harness.query_by_label_contains(words).is_some(), "{:?}", harness.state().instruments.reading());
    }
    harness.get_by_label("Keep").click();
    harness.step();
    set_all(&mut harness, "part", 0.25);
    settle_instruments(&mut harness);
    let now = "now, light 0°: BRDF (0.07958, 0.03979, 0.03979)";
    let kept = "phong 1, light 0°: BRDF (0.1592, 0.07958, 0.07958)";
    let said = harness.state().instruments.reading();
    assert!(said.contains(now) && said.contains(kept), "{said}");
    // Other views with a viewer have it too, for their own light; those without one have no field.
    for (view, is_there) in [("Cartesian", true), ("Lobe", true), ("Slice", true), ("Reciprocity", false), ("Sphere", false)] {
        harness.get_by_label(view).click();
        harness.step();
        settle_instruments(&mut harness);
        assert_eq!(harness.query_all_by_label("Viewer at").count() > 0, is_there, "{view}");
        let said = harness.state().instruments.reading();
        assert_eq!(said.contains("viewer −60°"), is_there, "{view}: {said}");
    }
}

#[test]
fn coordinates_are_asked_for_if_the_formula_reads_them() {
    let mut harness = instruments(LAMBERT);
    assert!(harness.query_by_role_and_label(Role::SpinButton, "u").is_none());
    apply(&mut harness, "body_specific; p: scalar, default 1, slider; formula; = p*IL*<u, v, 1>*max(0, N.L);");
    settle_instruments(&mut harness);
    typed(&mut harness, "u", "0.25");
    typed(&mut harness, "v", "0.75");
    let said = harness.state().instruments.reading();
    assert!(said.contains("light 0°: BRDF (0.07958, 0.2387, 0.3183), value (0.25, 0.75, 1)"), "{said}");
}

/// Puts the instruments somewhere by their menu.
fn put(harness: &mut Harness<'_, App>, place: &str) {
    harness.get_by_label("Place").click();
    harness.run_steps(4);
    harness.get_by_label(place).click();
    harness.run_steps(4);
}

#[test]
fn the_panel_can_be_over_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let folders = Folders::below(folder.path());
    let mut harness = harness_in(Some(&folders));
    harness.set_size(egui::vec2(1400.0, 900.0));
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    settle_instruments(&mut harness);
    put(&mut harness, "Over the picture");
    settle_instruments(&mut harness);
    harness.get_by_label("Choices").click();
    harness.run_steps(20);
    let (pane, keep) = (harness.state().pane.area(), harness.get_by_label("Keep").rect());
    assert!(pane.contains_rect(keep), "{keep} {pane}");
    // It takes no room from the picture.
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    harness.run_steps(4);
    assert_eq!(harness.state().pane.area(), pane);
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    harness.run_steps(4);
    // The scene is led beside it, and not under it.
    for (at, leads) in [(keep.left_top() - egui::vec2(2.0, 2.0), false), (pane.left_top() + egui::vec2(40.0, 60.0), true)] {
        harness.drag_at(at);
        harness.run_steps(2);
        harness.hover_at(at + egui::vec2(12.0, 9.0));
        harness.run_steps(2);
        assert_eq!(harness.state().workshop.moving().is_some(), leads);
        harness.drop_at(at + egui::vec2(12.0, 9.0));
        harness.run_steps(2);
    }
    harness.state_mut().closing();
    drop(harness);
    let mut harness = harness_in(Some(&folders));
    harness.set_size(egui::vec2(1400.0, 900.0));
    settle_instruments(&mut harness);
    assert!(harness.state().pane.area().contains_rect(harness.get_by_label("Choices").rect()));
}

#[test]
fn the_panel_moves_to_the_right_and_stays_there() {
    let folder = tempfile::tempdir().unwrap();
    let folders = Folders::below(folder.path());
    let mut harness = harness_in(Some(&folders));
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    settle_instruments(&mut harness);
    let chart_below = harness.get_by_label("Keep").rect();
    assert!(chart_below.top() > harness.state().pane.area().bottom());
    put(&mut harness, "At the right of the picture");
    settle_instruments(&mut harness);
    let (pane, keep) = (harness.state().pane.area(), harness.get_by_label("Keep").rect());
    assert!(keep.left() > pane.right() && pane.width() > 140.0, "{keep} {pane}");
    assert!(keep.right() < harness.get_all_by_label("ka").next().expect("a parameter").rect().left());
    harness.state_mut().closing();
    drop(harness);
    let app = App::new(Some(&Location::Preset("studio".to_owned())), Some(&folders)).expect("a built-in session");
    assert_eq!(app.user_state.settings.window.instruments_at, crate::user_data::settings::InstrumentDock::Right);
}

/// Waits until the sensitivity in view is that of the values.
fn settle_sensitivity(harness: &mut Harness<'_, App>) {
    for _ in 0..30_000 {
        harness.step();
        if harness.state().sensitivity_is_settled() {
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("no sensitivity came");
}

#[test]
fn sensitivity_reaches_the_pixels_of_its_body_and_escape_ends_it() {
    let mut harness = harness();
    apply(&mut harness, LAMBERT);
    set_all(&mut harness, "part", 0.5);
    set_all(&mut harness, "kr", 0.0);
    set_all(&mut harness, "kt", 0.0);
    let picture = settle(&mut harness);
    let app = harness.state_mut();
    let id = app.workshop.formula().parameter_named("part").unwrap();
    let view = app.workshop.view().unwrap();
    let pixel = [32, 24];
    let body = pane::body_at(&app.workshop, pixel).expect("a body in the middle");
    let of = (OwnerId::Body(body), id);
    app.perform(Action::Instruments(InstrumentAction::ShowSensitivity(Some(of))));
    settle_sensitivity(&mut harness);
    let app = harness.state_mut();
    let shown = app.pane.picture(&app.workshop).clone();
    assert!(shown.pixels != picture && shown.pixels.len() == picture.len());
    let tracer_of = |index: usize| pane::body_at(&app.workshop, [index as u32 % 64, index as u32 / 64]);
    // No mirrors here: a pixel depends on the value only if it shows the body.
    let reached = |word: u32| word != 0x0014_1414;
    let is_right = |(index, word): (usize, &u32)| !reached(*word) || tracer_of(index) == Some(body);
    assert!(shown.pixels.iter().enumerate().all(is_right));
    assert!(shown.pixels.iter().any(|word| reached(*word)));
    // The inspector says the same of one pixel: the light that it has, over the value, as Lambert is linear in it.
    let numbers = app.workshop.values().numbers().to_vec();
    let formula = std::sync::Arc::clone(app.workshop.formula());
    let world = std::sync::Arc::clone(app.workshop.world());
    let inspection = crate::evaluate::inspect::Inspector::new(&formula, &world, &numbers).inspect(&view, pixel).unwrap();
    let hit = inspection.hit(0).unwrap();
    let lit: [f32; 3] = std::array::from_fn(|component| hit.lights.iter().map(|light| light.contribution[component]).sum());
    let slope = pixel_dependence::PixelDependence::default().slope(&app.workshop, &inspection, of).unwrap();
    assert!(slope.iter().zip(lit).all(|(slope, lit)| (slope - lit / 0.5).abs() < 1e-4), "{slope:?} {lit:?}");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    assert_eq!(harness.state().pane.mode, comparison::PaneMode::Current);
    assert!(settle(&mut harness) == picture);
}

/// Writes a MERL file of a matte material of this albedo. Components are stored with the scales of the format.
fn write_matte(path: &std::path::Path, albedo: f64) {
    let count = 90 * 90 * 180;
    let mut bytes = Vec::with_capacity(12 + 3 * 8 * count);
    [90_u32, 90, 180].iter().for_each(|size| bytes.extend(size.to_le_bytes()));
    for scale in [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0] {
        let stored: f64 = albedo / std::f64::consts::PI / scale;
        (0..count).for_each(|_| bytes.extend(stored.to_le_bytes()));
    }
    std::fs::write(path, bytes).unwrap();
}

/// A window with a matte formula, and the file of a material of the same albedo.
fn with_matte(folder: &std::path::Path) -> (Harness<'static, App>, std::path::PathBuf) {
    let path = folder.join("matte.binary");
    write_matte(&path, 0.5);
    let mut harness = instruments(LAMBERT);
    for (name, value) in [("part", 0.5), ("kr", 0.0), ("kt", 0.0)] {
        set_all(&mut harness, name, value);
    }
    settle(&mut harness);
    (harness, path)
}

#[test]
fn a_measured_material_is_beside_the_formula_and_in_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, path) = with_matte(folder.path());
    harness.state_mut().perform(Action::Instruments(InstrumentAction::AddMeasured(path.clone())));
    harness.state_mut().jobs.wait();
    harness.run_steps(2);
    assert!(harness.query_by_label("matte.binary").is_some() && harness.state().instruments.overlay_count() == 1);
    let numbers = folder.path().join("chart.csv");
    harness.state_mut().perform(Action::Instruments(InstrumentAction::Save(numbers.clone())));
    harness.state_mut().jobs.wait();
    let text = std::fs::read_to_string(numbers).unwrap();
    for row in text.lines().skip(1) {
        let found = row.split(',').skip(1).filter(|cell| !cell.is_empty()).map(|number| number.parse::<f64>().unwrap());
        found.for_each(|number| assert!((number - 0.5 / std::f64::consts::PI).abs() < 1e-5, "{row}"));
    }
    // The picture with the material is that of the formula, which has the same albedo.
    let now = settle(&mut harness);
    harness.state_mut().perform(Action::Instruments(InstrumentAction::Compare(path)));
    settle_measured(&mut harness);
    let [comparison::Compared::Measured, comparison::Compared::Now] = harness.state().pane.mode.pair().unwrap() else {
        panic!("{:?}", harness.state().pane.mode)
    };
    let measured = harness.state().workshop.measured_picture().unwrap().pixels.clone();
    assert!(largest_difference(&measured, &now) <= 1);
    // It is not that of another albedo.
    set_all(&mut harness, "part", 0.9);
    let brighter = settle(&mut harness);
    assert!(largest_difference(&measured, &brighter) > 20);
}

/// Waits until the picture with a measured material is that of the values.
fn settle_measured(harness: &mut Harness<'_, App>) {
    for _ in 0..30_000 {
        harness.step();
        if harness.state().measured_is_settled() {
            harness.run_steps(2);
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("no picture with the material came");
}

/// The largest difference of two pictures, in steps of a component.
fn largest_difference(one: &[u32], other: &[u32]) -> u32 {
    assert_eq!(one.len(), other.len());
    let steps = |(one, other): (&u32, &u32)| [0, 8, 16].map(|shift| (one >> shift & 0xff).abs_diff(other >> shift & 0xff));
    one.iter().zip(other).flat_map(steps).max().unwrap_or(0)
}

#[test]
fn the_picture_with_a_measured_material_follows_what_is_changed() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, path) = with_matte(folder.path());
    harness.state_mut().perform(Action::Instruments(InstrumentAction::Compare(path)));
    settle_measured(&mut harness);
    let twin = |harness: &Harness<'_, App>| harness.state().workshop.measured_picture().expect("a picture").clone();
    let first = twin(&harness).pixels;
    // The formula has the same albedo as the material, so both pictures are the same in whatever way they are changed.
    let same = |harness: &mut Harness<'_, App>| {
        let now = settle(harness);
        settle_measured(harness);
        assert!(largest_difference(&twin(harness).pixels, &now) <= 1);
    };
    same(&mut harness);
    // Another colour of all lights.
    set_all_of_lights(&mut harness, "IL", [0.9, 0.5, 0.1]);
    same(&mut harness);
    let coloured = twin(&harness).pixels;
    assert!(largest_difference(&coloured, &first) > 20);
    // Another camera.
    let scene = &mut harness.state_mut().documents.scene;
    let text = scene.text().to_owned();
    let moved = text.replace("fov 29", "fov 40");
    assert!(moved != text, "{text}");
    scene.replace_text(&moved);
    harness.state_mut().apply(TextTab::Scene);
    same(&mut harness);
    assert!(largest_difference(&twin(&harness).pixels, &coloured) > 20);
    // Another size of the picture, and another exposure.
    let mut settings = harness.state().workshop.settings();
    (settings.size, settings.view.exposure) = ([40, 30], -1.0);
    harness.state_mut().workshop.set_picture(settings).expect("a size in range");
    same(&mut harness);
    assert_eq!(twin(&harness).full_size, [40, 30]);
    // Not in view, nothing is made.
    let before = twin(&harness).version;
    harness.state_mut().pane.mode = comparison::PaneMode::Current;
    set_all(&mut harness, "part", 0.25);
    settle(&mut harness);
    harness.run_steps(5);
    assert_eq!(twin(&harness).version, before);
    // Another session ends it.
    harness.state_mut().pane.mode = comparison::PaneMode::Split([comparison::Compared::Measured, comparison::Compared::Now]);
    harness.state_mut().perform(Action::Open(FileKind::Session, Location::Preset("glass".to_owned())));
    harness.run_steps(3);
    harness.get_by_label("Discard").click();
    harness.run_steps(3);
    settle(&mut harness);
    settle_measured(&mut harness);
    assert!(harness.state().workshop.measured_picture().is_none());
}

#[test]
fn a_held_slider_waits_for_no_measured_picture_and_a_body_that_goes_ends_the_comparison() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("matte.binary");
    write_matte(&path, 0.5);
    let mut harness = instruments(LAMBERT);
    harness.state_mut().perform(Action::Instruments(InstrumentAction::Compare(path)));
    settle_measured(&mut harness);
    // The picture takes the size of its pane once that no longer changes.
    harness.run_steps(40);
    settle(&mut harness);
    settle_measured(&mut harness);
    let version = |harness: &Harness<'_, App>| harness.state().workshop.measured_picture().map(|picture| picture.version);
    let first = version(&harness);
    assert!(first.is_some());
    let slider = harness.get_all_by_role(Role::Slider).next().expect("a slider").rect().left_center();
    harness.drag_at(slider + egui::vec2(30.0, 0.0));
    harness.run_steps(2);
    harness.hover_at(slider + egui::vec2(60.0, 0.0));
    harness.run_steps(3);
    assert!(harness.state().workshop.held().is_some());
    settle(&mut harness);
    // Long enough for a picture of few pixels to be made.
    std::thread::sleep(Duration::from_millis(300));
    harness.run_steps(5);
    assert_eq!(version(&harness), first);
    harness.drop_at(slider + egui::vec2(60.0, 0.0));
    harness.run_steps(2);
    settle(&mut harness);
    settle_measured(&mut harness);
    assert!(version(&harness) > first);
    let scene = "bodies; other: sphere, center <0,0,0>, radius 1; lights; light: point, <0,0,9>;
        camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;";
    harness.state_mut().documents.scene.replace_text(scene);
    harness.state_mut().apply(TextTab::Scene);
    settle(&mut harness);
    settle_measured(&mut harness);
    assert_eq!((version(&harness), harness.state().pane.mode), (None, comparison::PaneMode::Current));
}

#[test]
fn a_file_that_is_no_material_is_refused_with_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.binary");
    std::fs::write(&path, [90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0, 1, 2]).unwrap();
    let mut harness = harness();
    harness.state_mut().perform(Action::Instruments(InstrumentAction::AddMeasured(path)));
    harness.state_mut().jobs.wait();
    harness.run_steps(2);
    let message = harness.state().dialogs.message().unwrap_or_default().to_owned();
    assert!(message.contains("short.binary"), "{message}");
    assert_eq!(harness.state().instruments.overlay_count(), 0);
}

#[test]
fn the_camera_is_led_while_a_measured_material_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, path) = with_matte(folder.path());
    harness.state_mut().perform(Action::Instruments(InstrumentAction::Compare(path)));
    settle_measured(&mut harness);
    let text = |harness: &Harness<'_, App>| harness.state().documents.scene.text().to_owned();
    let before = text(&harness);
    let area = harness.state().pane.area();
    // On the line, only the line moves.
    harness.drag_at(area.center());
    harness.run_steps(2);
    harness.hover_at(area.center() + egui::vec2(20.0, 0.0));
    harness.run_steps(2);
    harness.drop_at(area.center() + egui::vec2(20.0, 0.0));
    harness.run_steps(2);
    assert_eq!(text(&harness), before);
    // Beside it, the camera is led.
    let at = area.lerp_inside([0.25, 0.3]);
    harness.drag_at(at);
    harness.run_steps(2);
    harness.hover_at(at + egui::vec2(30.0, 10.0));
    harness.run_steps(2);
    let app = harness.state();
    assert!(app.workshop.moving().is_some());
    // Until the picture with the material shows the new scene, too, there is nothing to compare.
    let seen = app.pane.picture(&app.workshop);
    assert_eq!(seen.version, app.workshop.shown().version);
    harness.drop_at(at + egui::vec2(30.0, 10.0));
    let now = settle(&mut harness);
    settle_measured(&mut harness);
    assert_ne!(text(&harness), before);
    let app = harness.state();
    let twin = app.workshop.measured_picture().expect("a picture");
    assert!(app.workshop.measured_shows_scene() && largest_difference(&twin.pixels, &now) <= 1);
    assert_ne!(app.pane.picture(&app.workshop).version, app.workshop.shown().version, "the comparison is in view again");
}

#[test]
fn a_comparison_ends_by_its_button_and_makes_nothing_more() {
    let folder = tempfile::tempdir().unwrap();
    let (mut harness, path) = with_matte(folder.path());
    harness.state_mut().perform(Action::TogglePanel(PanelId::Instruments));
    harness.state_mut().perform(Action::Instruments(InstrumentAction::AddMeasured(path)));
    harness.state_mut().jobs.wait();
    harness.set_size(egui::vec2(1280.0, 1000.0));
    harness.run_steps(4);
    harness.get_by_label("Compare in the picture").click();
    harness.run_steps(2);
    settle_measured(&mut harness);
    assert!(harness.state().pane.mode.pair().is_some());
    harness.get_by_label("End the comparison").click();
    harness.run_steps(2);
    assert_eq!(harness.state().pane.mode, comparison::PaneMode::Current);
    assert!(harness.state().workshop.measured_picture().is_none() && harness.state().measured.progress().is_none());
    // Left by the menu while a picture is being made, nothing is made any more.
    harness.get_by_label("Compare in the picture").click();
    harness.run_steps(2);
    settle_measured(&mut harness);
    set_all(&mut harness, "part", 0.25);
    settle(&mut harness);
    harness.state_mut().pane.mode = comparison::PaneMode::Current;
    harness.run_steps(2);
    assert!(harness.state().measured.progress().is_none());
}

use super::{Component, InstrumentView, NamedModel, Shown, VIEWS, ViewSettings, readings};
use crate::instrument::tests::{ClosedForm, ggx};
use crate::plot::{Chart, ChartTheme, MapValues, painted, svg, text_rectangles};
use std::f64::consts::PI;
use std::sync::Arc;

fn matte(albedo: f64) -> NamedModel {
    NamedModel { name: format!("matte {albedo}"), model: Arc::new(ClosedForm(move |_, _| albedo / PI)) }
}

fn chart(view: &str, models: &[NamedModel], settings: &ViewSettings) -> Chart {
    InstrumentView::named(view).unwrap().chart(models, settings)
}

#[test]
fn every_view_is_drawn() {
    let rough = NamedModel { name: "rough".into(), model: Arc::new(ClosedForm(ggx(0.3))) };
    let models = [rough, matte(0.5)];
    for view in &VIEWS {
        for models in [&models[..1], &models[..]] {
            let chart = view.chart(models, &ViewSettings::default());
            let figure = chart.figure([240, 180], ChartTheme::Dark);
            let text = svg(&figure);
            assert!(text.starts_with("<svg") && text.ends_with("</svg>\n") && !text.contains("NaN"), "{}", view.name);
            let picture = painted(&figure).unwrap();
            let colours: std::collections::BTreeSet<&[u8]> = picture.bytes().chunks(3).collect();
            assert!(picture.size() == [240, 180] && colours.len() > 20, "{}", view.name);
            let table = chart.table();
            assert!(table.rows.len() > 30 && table.rows.iter().all(|row| row.len() == table.columns.len()), "{}", view.name);
        }
    }
}

#[test]
fn curves_have_the_brdf_or_the_value() {
    let settings = ViewSettings { light_polar: vec![60.0], ..ViewSettings::default() };
    let of = |settings: &ViewSettings| chart("cartesian", &[matte(0.5)], settings).table();
    let all_near = |table: &crate::plot::NumberTable, wanted: f64| table.rows.iter().all(|row| (row[1] - wanted).abs() < 1e-6);
    assert!(all_near(&of(&settings), 0.5 / PI));
    assert!(all_near(&of(&ViewSettings { shown: Shown::Value, ..settings.clone() }), 0.25));
    let parts = of(&ViewSettings { component: Some(Component::Each), ..settings });
    assert_eq!(parts.columns.len(), 4);
}

#[test]
fn a_lobe_is_at_the_side_of_the_mirror_direction() {
    let model = NamedModel { name: "sharp".into(), model: Arc::new(ClosedForm(ggx(0.02))) };
    let settings = ViewSettings { light_polar: vec![40.0], light_azimuth: 70.0, ..ViewSettings::default() };
    let table = chart("polar", &[model], &settings).table();
    let top = table.rows.iter().max_by(|one, other| one[1].total_cmp(&other[1])).unwrap();
    assert!((top[0] - 40.0).abs() < 0.1, "{top:?}");
    // D F G/(4 cos²) at the mirror direction, where masking is nearly 1.
    let wanted = 1.0 / (PI * 0.02 * 0.02) / (4.0 * 40_f64.to_radians().cos().powi(2));
    assert!((top[1] / wanted - 1.0).abs() < 2e-3, "{top:?} {wanted}");
}

#[test]
fn a_lossless_ball_vanishes_in_a_furnace() {
    let Chart::Map(map) = chart("furnace", &[matte(1.0), matte(0.5)], &ViewSettings::default()) else { panic!("no map") };
    let colours = |index: usize| match &map.panels[index].values {
        MapValues::Colours(colours) => colours.clone(),
        MapValues::Numbers(_) => panic!("numbers"),
    };
    let corner = colours(0)[0];
    assert!(colours(0).iter().all(|colour| (colour[0] - corner[0]).abs() < 1e-4));
    let middle = colours(1).len() / 2 + map.panels[1].size[0] as usize / 2;
    assert!((colours(1)[middle][0] - 0.5 * corner[0]).abs() < 1e-4);
}

#[test]
fn slices_and_reciprocity_have_their_numbers() {
    let settings = ViewSettings { false_colours: true, ..ViewSettings::default() };
    let table = chart("slice", &[matte(0.3)], &settings).table();
    assert!(table.rows.iter().all(|row| (row[2] - 0.3 / PI).abs() < 1e-5));
    let odd = NamedModel { name: "odd".into(), model: Arc::new(ClosedForm(|light: glam::DVec3, _| light.z)) };
    let table = chart("reciprocity", &[odd], &ViewSettings::default()).table();
    for row in table.rows.iter().step_by(997) {
        let [light, view] = [row[0], row[1]].map(|angle| angle.to_radians().cos());
        assert!((row[2] - (light - view).abs() / light.max(view)).abs() < 1e-4, "{row:?}");
    }
}

#[test]
fn one_viewer_has_the_numbers_of_every_light_and_model() {
    // The second one tells the side of the viewer: light at an azimuth of 0 is at +x, so its mirror direction is at −x.
    let side = NamedModel { name: "side".into(), model: Arc::new(ClosedForm(|_, view: glam::DVec3| view.x)) };
    let settings = ViewSettings { light_polar: vec![0.0, 60.0], ..ViewSettings::default() };
    let found = readings(&[matte(0.5), side], &settings, 30.0);
    let wanted = [(0, 0.0, 0.5 / PI, 0.5), (0, 60.0, 0.5 / PI, 0.25), (1, 0.0, -0.5, -0.5 * PI), (1, 60.0, -0.5, -0.25 * PI)];
    assert_eq!(found.len(), wanted.len());
    for (found, (model, light, brdf, value)) in found.iter().zip(wanted) {
        assert_eq!((found.model, found.light), (model, light));
        assert!(found.brdf.iter().all(|number| (number - brdf).abs() < 1e-6), "{found:?}");
        assert!(found.value.iter().all(|number| (number - value).abs() < 1e-6), "{found:?}");
    }
}

/// How some texts begin that a chart of any view must have.
fn needed(view: &str) -> &'static [&'static str] {
    match view {
        "polar" => &["BRDF (1/sr)", "0°", "90°", "−90°"],
        "cartesian" => &["BRDF (1/sr)", "outgoing angle", "0°", "90°"],
        "lobe" => &["rings: BRDF (1/sr)", "T", "B"],
        "slice" => &["half angle", "difference angle", "0°", "90°"],
        "albedo" => &["share of the light", "angle of the beam", "0°", "90°", "1"],
        "reciprocity" => &["angle of the light", "angle of the viewer", "relative difference"],
        _ => &[],
    }
}

#[test]
fn no_text_is_cut_or_overlaps_another() {
    let rough = |name: &str| NamedModel { name: name.into(), model: Arc::new(ClosedForm(ggx(0.3))) };
    let models = [rough("rough, floor under left"), matte(0.5), rough("another")];
    let settings = ViewSettings { is_draft: true, ..ViewSettings::default() };
    for view in &VIEWS {
        for count in 1..=models.len() {
            let chart = view.chart(&models[..count], &settings);
            for size in [[180, 180], [240, 180], [320, 240], [420, 200], [900, 340], [200, 600]] {
                let figure = chart.figure(size, ChartTheme::Light);
                let (texts, mut words) = (text_rectangles(&figure), Vec::new());
                for (index, (text, one)) in texts.iter().enumerate() {
                    let about = format!("{} of {count} at {size:?}: {text}", view.name);
                    let [width, height] = size.map(f64::from);
                    assert!(one[0] >= 0.0 && one[1] >= 0.0 && one[2] <= width && one[3] <= height, "{about} is cut, {one:?}");
                    for (other_text, other) in &texts[index + 1..] {
                        let apart = (0..2).any(|axis| one[axis] > other[axis + 2] - 1.0 || other[axis] > one[axis + 2] - 1.0);
                        assert!(apart, "{about} and {other_text} overlap, {one:?} {other:?}");
                    }
                    words.push(text.as_str());
                }
                // What is needed to read the chart is there.
                if size[0] >= 320 && size[1] >= 240 {
                    for wanted in needed(view.name) {
                        assert!(words.iter().any(|text| text.starts_with(wanted)), "{} at {size:?}: no {wanted}", view.name);
                    }
                }
            }
        }
    }
}

/// A mirror lobe that gives out too much in the last hundredth of a degree.
fn spike(from: f64) -> NamedModel {
    let least = from.to_radians().cos();
    let model = move |light: glam::DVec3, view: glam::DVec3| if light.z.min(view.z) < least { 4.0 / PI } else { 0.2 / PI };
    NamedModel { name: "spike".into(), model: Arc::new(ClosedForm(model)) }
}

#[test]
fn a_share_above_1_at_the_last_angle_is_in_the_chart() {
    for is_draft in [false, true] {
        let settings = ViewSettings { is_draft, ..ViewSettings::default() };
        let table = chart("albedo", &[spike(89.95)], &settings).table();
        let last = table.rows.last().expect("a row");
        assert!(last[0] > 89.98 && (last[1] - 4.0).abs() < 0.05, "{last:?}");
        assert!(table.rows.iter().rev().skip(1).all(|row| row[1] < 0.3));
    }
}

#[test]
fn the_azimuth_is_told_where_it_matters() {
    let stripes = ClosedForm(|light: glam::DVec3, view: glam::DVec3| {
        let half = (light + view).normalize();
        (0.5 + 0.4 * half.x * half.x) / PI
    });
    let stripes = NamedModel { name: "stripes".into(), model: Arc::new(stripes) };
    let title = |view: &str, model: &NamedModel, light_azimuth: f64| {
        let settings = ViewSettings { light_azimuth, ..ViewSettings::default() };
        chart(view, std::slice::from_ref(model), &settings).figure([800, 600], ChartTheme::Light).title
    };
    for view in ["polar", "cartesian", "lobe", "albedo"] {
        assert!(title(view, &stripes, 0.0).contains("azimuth 0°"), "{view}");
        assert!(title(view, &stripes, 40.0).contains("azimuth 40°"), "{view}");
        assert!(!title(view, &matte(0.5), 0.0).contains("azimuth"), "{view}");
    }
}

#[test]
fn a_spike_along_the_surface_does_not_flatten_the_chart_of_shares() {
    let y = |models: &[NamedModel]| match chart("albedo", models, &ViewSettings::default()) {
        Chart::Cartesian(chart) => (chart.y, chart.heading.subtitle),
        Chart::Polar(_) | Chart::Map(_) | Chart::Lobe(_) => panic!("no curves over two axes"),
    };
    let (axis, subtitle) = y(&[spike(89.95)]);
    assert_eq!(axis.range, Some([0.0, 1.4]));
    assert!(subtitle.contains("up to 4.000 at 89.99°, beyond the chart"), "{subtitle}");
    // What is above 1 from afar has all of its range.
    let (axis, subtitle) = y(&[matte(4.0)]);
    assert_eq!((axis.range, subtitle.as_str()), (None, ""));
}

#[test]
fn shares_of_several_coloured_models_are_their_greatest_component() {
    // Its luminance is 0.2126·1.5, far below 1.
    struct Red;
    impl crate::instrument::Reflectance for Red {
        fn values(&self, pairs: &[crate::instrument::DirectionPair]) -> Vec<[f32; 3]> {
            pairs.iter().map(|pair| [1.5 * pair.light[2].max(0.0), 0.0, 0.0]).collect()
        }
    }
    let red = NamedModel { name: "red".into(), model: Arc::new(Red) };
    let Chart::Cartesian(found) = chart("albedo", &[red, matte(0.5)], &ViewSettings::default()) else { panic!("no curves") };
    assert_eq!(found.y.title, "share of the light, greatest of red, green, blue");
    assert!(found.curves[0].points.iter().all(|[_, share]| (share - 1.5).abs() < 1e-3));
    assert!(found.curves[1].points.iter().all(|[_, share]| (share - 0.5).abs() < 1e-3));
}

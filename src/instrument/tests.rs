use super::albedo::ACCURACY;
use super::direction::{angles, direction};
use super::hemisphere::{Integration, integrate};
use super::measurement::{EnergyVerdict, ModelMeasurement};
use super::search::greatest;
use super::survey::ModelSurvey;
use super::{DirectionPair, Reflectance};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// A model in closed form: its BRDF for the directions to light and viewer.
pub(super) struct ClosedForm<F>(pub(super) F);

impl<F: Fn(DVec3, DVec3) -> f64 + Send + Sync> Reflectance for ClosedForm<F> {
    fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]> {
        let value = |pair: &DirectionPair| {
            let [light, view] = [pair.light, pair.view].map(|direction| Vec3::from(direction).as_dvec3().normalize());
            [(PI * light.z * (self.0)(light, view)) as f32; 3]
        };
        pairs.iter().map(value).collect()
    }
}

/// The cosine of the angle between the viewer and the mirrored light.
fn mirror_cosine(light: DVec3, view: DVec3) -> f64 {
    DVec3::new(-light.x, -light.y, light.z).dot(view).max(0.0)
}

/// Walter et al. (2007), equation 33, with the height-correlated masking of Heitz (2014), equation 99, and facets that
/// reflect everything. The sine comes from a cross product, which keeps its digits.
pub(super) fn ggx(alpha: f64) -> impl Fn(DVec3, DVec3) -> f64 {
    move |light, view| {
        let half = (light + view).normalize();
        let (squared, sine) = (alpha * alpha, DVec3::Z.cross(half).length_squared());
        let facets = squared / (PI * (squared * half.z * half.z + sine).powi(2));
        let lambda = |cosine: f64| ((1.0 + squared * (1.0 / (cosine * cosine) - 1.0)).sqrt() - 1.0) / 2.0;
        facets / ((1.0 + lambda(light.z) + lambda(view.z)) * 4.0 * light.z * view.z)
    }
}

fn beam(model: &dyn Reflectance, polar: f64) -> f64 {
    let integral = integrate(model, Integration::OverViews, [polar, 20.0], ACCURACY);
    assert!(integral.is_accurate && integral.error <= ACCURACY * integral.value[0].max(1.0), "{polar}: {integral:?}");
    integral.value[0]
}

fn furnace(model: &dyn Reflectance, polar: f64) -> f64 {
    let integral = integrate(model, Integration::OverLights, [polar, 20.0], ACCURACY);
    assert!(integral.is_accurate, "{polar}: {integral:?}");
    integral.value[0]
}

fn near(found: f64, wanted: f64, what: &str) {
    assert!((found - wanted).abs() <= ACCURACY * wanted.max(1.0), "{what}: {found}, not {wanted}");
}

#[test]
fn a_matte_surface_reflects_its_albedo() {
    let model = ClosedForm(|_, _| 0.73 / PI);
    for polar in [0.0, 30.0, 60.0, 85.0, 89.9] {
        assert!((beam(&model, polar) - 0.73).abs() < 1e-6, "{polar}");
        assert!((furnace(&model, polar) - 0.73).abs() < 1e-6, "{polar}");
    }
}

#[test]
fn phong_lobes_have_their_closed_forms() {
    // Lafortune and Willems (1994): (n + 2)/2π cosⁿ reflects everything at normal incidence, however narrow it is.
    for exponent in [1.0, 20.0, 500.0, 1e4, 1e5] {
        let model = ClosedForm(move |light, view| (exponent + 2.0) / (2.0 * PI) * mirror_cosine(light, view).powf(exponent));
        near(beam(&model, 0.0), 1.0, "a normalised lobe");
    }
    // Phong's own: the value is cosⁿ, so the BRDF is cosⁿ/(π cos θ).
    let phong = |exponent: f64| ClosedForm(move |light: DVec3, view| mirror_cosine(light, view).powf(exponent) / (PI * light.z));
    for exponent in [1.0, 7.0, 200.0] {
        near(beam(&phong(exponent), 0.0), 2.0 / (exponent + 2.0), "a beam");
        near(furnace(&phong(exponent), 0.0), 2.0 / (exponent + 1.0), "a furnace");
    }
    // Two cosines over the hemispheres of both: ∫ = 2/3 (sin θ + (π − θ) cos θ). The horizon cuts nothing that has
    // both.
    for polar in [0.0_f64, 30.0, 60.0, 80.0] {
        let angle = polar.to_radians();
        let wanted = 2.0 / 3.0 * (angle.sin() + (PI - angle) * angle.cos()) / (PI * angle.cos());
        near(beam(&phong(1.0), polar), wanted, "a wide lobe");
    }
    // A narrow lobe far above the horizon: ∫ cosⁿ dω = 2π/(n + 1) in the furnace, and 1/cos 45° times nearly that of
    // normal incidence in a beam: the mean of the cosine over the lobe is cos 45° (n + 1)/(n + 2).
    near(furnace(&phong(1e5), 45.0), 2.0 / 100_001.0, "a narrow lobe in a furnace");
    let bright = ClosedForm(|light: DVec3, view| 1e5 * mirror_cosine(light, view).powf(1e5) / (PI * light.z));
    near(beam(&bright, 45.0), 1e5 * 2.0 / 100_002.0, "a narrow lobe of a beam");
}

#[test]
fn blinn_lobes_have_their_closed_form() {
    // At normal incidence the half angle is half the angle of the viewer.
    for exponent in [1.0_f64, 10.0, 300.0] {
        let model = ClosedForm(move |light: DVec3, view: DVec3| (light + view).normalize().z.powf(exponent));
        let part = |more: f64| (1.0 - 2.0_f64.powf(-0.5 * (exponent + more))) / (exponent + more);
        near(beam(&model, 0.0), 8.0 * PI * (2.0 * part(4.0) - part(2.0)), "a lobe of half angles");
    }
}

#[test]
fn ggx_reflects_as_much_as_others_have_computed() {
    // Closed form for α = 1 at normal incidence: 1 − ln 2.
    near(beam(&ClosedForm(ggx(1.0)), 0.0), 1.0 - 2.0_f64.ln(), "the roughest");
    // `table_ggx_E` of Cycles (Blender 4, intern/cycles/scene/shader.tables): the cosine is row/31 and α is
    // (column/31)².
    let cycles = [
        (31, 16, 0.903_873),
        (31, 8, 0.995_072),
        (16, 31, 0.443_841),
        (16, 16, 0.847_421),
        (8, 10, 0.920_251),
        (8, 31, 0.591_195),
        (4, 5, 0.975_437),
        (1, 31, 0.888_202),
        (1, 5, 0.891_678),
    ];
    for (row, column, wanted) in cycles {
        let alpha = (f64::from(column) / 31.0).powi(2);
        let polar = (f64::from(row) / 31.0).acos().to_degrees();
        near(beam(&ClosedForm(ggx(alpha)), polar), wanted, "Cycles");
        near(furnace(&ClosedForm(ggx(alpha)), polar), wanted, "Cycles, the other way");
    }
}

#[test]
fn lobes_at_the_horizon_reflect_as_much_as_by_brute_force() {
    // tests/reference/albedo.py. Values are not multiplied by cos θ, so the BRDF grows towards the horizon.
    let blinn = ClosedForm(|light: DVec3, view: DVec3| (light + view).normalize().z.powi(200) / (PI * light.z));
    let phong = ClosedForm(|light: DVec3, view| mirror_cosine(light, view).powi(30) / (PI * light.z));
    for (polar, of_blinn, of_phong) in [
        (0.0, 0.038_827_5, 0.062_5),
        (60.0, 0.019_996_2, 0.062_509_1),
        (80.0, 0.008_958_9, 0.068_240_6),
        (89.0, 0.014_754_5, 0.291_106_7),
        (89.9, 0.114_547_9, 2.617_995_5),
    ] {
        near(beam(&blinn, polar), of_blinn, "Blinn");
        near(beam(&phong, polar), of_phong, "Phong");
    }
}

#[test]
fn narrow_lobes_are_not_missed() {
    // As the roughness goes to 0, a mirror remains; what is lost is of the order of α².
    for alpha in [0.001, 0.003, 0.01] {
        for polar in [0.0, 12.3, 45.0, 75.0] {
            let found = beam(&ClosedForm(ggx(alpha)), polar);
            assert!((found - 1.0).abs() < 2e-3, "{alpha} {polar}: {found}");
        }
    }
}

#[test]
fn values_that_are_not_numbers_are_found_and_left_out() {
    let model = ClosedForm(|_, view: DVec3| if view.z < 0.3 { f64::NAN } else { 1.0 / PI });
    let integral = integrate(&model, Integration::OverViews, [30.0, 0.0], ACCURACY);
    // The disc without its outer ring.
    near(integral.value[0], 1.0 - 0.09, "what remains");
    let pair = integral.not_finite.unwrap();
    assert!(pair.view[2] < 0.3);
    let measured = ModelMeasurement::of(&model);
    assert!(measured.not_finite.is_some_and(|pair| pair.view[2] < 0.3));
}

#[test]
fn the_verdict_says_where_light_is_made() {
    // Twice the cosine of the angle from the normal, doubled: 1 is passed at 60 degrees.
    let gain = ClosedForm(|light: DVec3, _| (1.5 - light.z) / PI);
    let found = ModelMeasurement::of(&gain);
    let EnergyVerdict::DoesNot(beam) = found.verdict() else { panic!("{found:?}") };
    assert!((beam.share - 1.5).abs() < 0.02 && beam.angles[0] > 88.0, "{beam:?}");
    assert!((beam.above_one.unwrap()[0] - 60.0).abs() < 0.3, "{beam:?}");
    // What a viewer sees is the mean over the light: ∫ (1.5 − c) 2c dc = 1.5 − 2/3.
    assert!(found.rows.iter().all(|row| (row.furnace[0] - (1.5 - 2.0 / 3.0)).abs() < 2e-4), "{found:?}");
    assert!(found.furnace.above_one.is_none() && found.is_reciprocal() == Some(false) && !found.depends_on_azimuth);
    assert_eq!(ModelMeasurement::of(&ClosedForm(|_, _| 1.0 / PI)).verdict(), EnergyVerdict::Conserves);
    assert_eq!(ModelMeasurement::of(&ClosedForm(ggx(0.1))).verdict(), EnergyVerdict::Conserves);
}

#[test]
fn reciprocity_and_negative_values_are_told_with_their_places() {
    let model = ClosedForm(|light: DVec3, view: DVec3| light.z - 2.0 * view.x.powi(2) + 0.0 * view.z);
    let found = ModelMeasurement::of(&model);
    let (least, pair) = found.least.unwrap();
    // π cos θ (cos θ − 2 x²) is least at x = 1, cos θ = 1: −π.
    assert!((least + PI).abs() < 0.02 && pair.light[2] > 0.99, "{least} {pair:?}");
    assert!(found.depends_on_azimuth && found.reciprocity.unwrap().error > 0.9);
    let found = ModelMeasurement::of(&ClosedForm(ggx(0.3)));
    assert!(found.is_reciprocal() == Some(true) && found.reciprocity.unwrap().error < 1e-4, "{:?}", found.reciprocity);
    assert!(found.least.unwrap().0 >= 0.0);
}

#[test]
fn models_that_depend_on_the_azimuth_are_known() {
    assert!(!ModelSurvey::of(&ClosedForm(ggx(0.05))).depends_on_azimuth);
    let brushed = ClosedForm(|light: DVec3, view: DVec3| {
        let half = (light + view).normalize();
        (-((half.x / 0.1).powi(2) + (half.y / 0.3).powi(2)) / (half.z * half.z)).exp()
    });
    assert!(ModelSurvey::of(&brushed).depends_on_azimuth);
    let stripes =
        ClosedForm(|light: DVec3, _| if light.z < 0.99 { 0.5 + (light.y / light.x).atan().cos().powi(2) } else { 0.0 } / PI);
    let found = greatest(&stripes, Integration::OverViews, &ModelSurvey::of(&stripes), &[]);
    assert!((found.share - 1.5).abs() < 1e-3 && found.angles[1] % 180.0 < 2.0, "{found:?}");
}

#[test]
fn angles_are_told_in_degrees() {
    assert_eq!(angles([0.0, 0.0, 1.0]), [0.0, 0.0]);
    let view = direction(50.0, 300.0).as_vec3().to_array();
    assert!(angles(view).iter().zip([50.0, 300.0]).all(|(found, wanted)| (found - wanted).abs() < 1e-4));
}

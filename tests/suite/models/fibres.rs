//! Fur and hair: Kajiya and Kay (1989), Marschner and others (2003), Scheuermann (2004).
//!
//! The fibres lie along +x, so a direction is given by its angle to the plane across them, and its azimuth around them.

use super::microfacets::{fresnel, pairs, sends_no_more_than_it_gets, straight};
use super::{Hit, Model, SINGLE, Triple, direction, near, sound_in_all_corners};
use std::f64::consts::PI;

/// A direction at an angle towards the tip of the fibres, at an azimuth from the normal around them, in degrees.
fn around(theta: f64, phi: f64) -> Triple {
    let (theta, phi) = (theta.to_radians(), phi.to_radians());
    [theta.sin(), theta.cos() * phi.sin(), theta.cos() * phi.cos()]
}

/// Fibres along +x that lie flat and are all the same, without a soft edge.
fn combed(name: &str) -> Model {
    Model::built_in(name).colour("comb", [1.0, 0.0, 0.0]).set("tousle", 0.0).set("soft", 0.0)
}

fn fur() -> Model {
    combed("kajiya-kay").set("lift", 0.0)
}

/// Only the first highlight of hair.
fn first() -> Model {
    combed("hair").set("kd", 0.0).set("trt", 0.0)
}

/// Only the second highlight of hair.
fn second() -> Model {
    combed("hair").set("kd", 0.0).set("r", 0.0)
}

/// Where something is largest as the viewer moves along the hairs, in degrees; the light stands straight above.
fn largest(mut of: impl FnMut(&Hit) -> f64) -> f64 {
    let mut seen = |tenths: i32| of(&Hit::new(around(0.0, 0.0), around(f64::from(tenths) / 10.0, 0.0)));
    let found: Vec<(f64, i32)> = (-400..=400).map(|tenths| (seen(tenths), tenths)).collect();
    let (_, tenths) = found.into_iter().max_by(|one, other| one.0.total_cmp(&other.0)).expect("some angles");
    f64::from(tenths) / 10.0
}

#[test]
fn colours_are_numbers_in_all_corners() {
    for name in ["kajiya-kay", "hair"] {
        sound_in_all_corners(name);
    }
}

#[test]
fn fur_is_matte_by_the_sine_of_the_angle_to_its_fibres() {
    let matte = fur().set("ks", 0.0).set("kd", 0.5);
    let from = |light| matte.shade(&Hit::new(light, direction(0.0, 0.0)))[0];
    for phi in [0.0, 45.0, 80.0] {
        near(from(around(0.0, phi)), 0.5 * 0.8, SINGLE);
        near(from(around(60.0, phi)), 0.5 * 0.8 * 0.5, SINGLE);
    }
    // Fibres that stand up by 30 degrees: nothing comes from a light along them.
    let risen = fur().set("ks", 0.0).set("lift", 30.0);
    near(risen.shade(&Hit::new(around(60.0, 0.0), direction(0.0, 0.0)))[0], 0.0, 1e-3);
}

#[test]
fn fur_mirrors_light_to_a_cone() {
    // On the cone the highlight is ks, and away from it by an angle, ks times the power of its cosine.
    let mut shine = fur().set("kd", 0.0).set("ks", 0.4).set("p", 30.0);
    for (theta, phi) in [(0.0, 30.0), (25.0, -40.0), (50.0, 10.0)] {
        for azimuth in [-70.0, 0.0, 55.0] {
            for off in [0.0, 10.0, -20.0] {
                let hit = Hit::new(around(theta, phi), around(off - theta, azimuth));
                near(shine.shade(&hit)[0], 0.4 * f64::to_radians(off).cos().powi(30), SINGLE);
            }
        }
    }
    for hit in pairs() {
        near(shine.value("SPECULAR", &hit)[0], shine.value("SPECULAR", &hit.swapped())[0], SINGLE);
    }
}

#[test]
fn fibres_lie_as_they_are_combed_along_the_surface() {
    for name in ["kajiya-kay", "hair"] {
        let along = combed(name);
        // What points into the surface or out of it does not matter, nor does the length.
        let slanted = combed(name).colour("comb", [0.2, 0.0, -0.9]);
        let lost = combed(name).colour("comb", [0.0, 0.0, 1.0]);
        for hit in pairs() {
            near(slanted.shade(&hit)[0], along.shade(&hit)[0], SINGLE);
            // Straight up there is no such way: the tangent is taken.
            near(lost.shade(&hit)[0], along.shade(&hit)[0], SINGLE);
        }
    }
}

#[test]
fn strands_hardly_vary_along_themselves() {
    let mut shaggy = Model::built_in("kajiya-kay").colour("comb", [1.0, 0.0, 0.0]).set("tousle", 0.1);
    let mut noise = |point| shaggy.value("NOISE", &Hit { point, ..straight() })[0];
    let here = noise([0.3, 0.2, 0.0]);
    assert!((noise([0.305, 0.2, 0.0]) - here).abs() < 0.03);
    assert!((noise([0.3, 0.22, 0.0]) - here).abs() > 0.05);
}

#[test]
fn hair_straight_on() {
    // First: pi g(beta; -alpha)/2 F(0)/4. Second: pi g(2 beta; 3/2 alpha)/2 (1 - F)^2 F exp(0.22) Cd^0.8, with F at 60
    // degrees.
    let gauss = |width: f64, x: f64| (-(x / width).powi(2) / 2.0).exp() / (width.to_radians() * (2.0 * PI).sqrt());
    let hit = straight();
    let shine = PI * gauss(8.0, 7.0) / 2.0 * (0.55_f64 / 2.55).powi(2) / 4.0;
    near(first().shade(&hit)[0], shine, SINGLE);
    let inside = fresnel(1.55, 0.0, 0.5);
    let colour = second().colour("Cd", [0.7, 0.3, 0.1]).shade(&hit);
    for (found, hair) in colour.into_iter().zip([0.7_f64, 0.3, 0.1]) {
        let wanted = PI * gauss(16.0, 10.5) / 2.0 * (1.0 - inside).powi(2) * inside * 0.22_f64.exp() * hair.powf(0.8);
        near(found, wanted, SINGLE);
    }
}

#[test]
fn highlights_are_moved_apart() {
    // theta_h is half of the viewer's angle: -7 degrees at -14, and 10.5 degrees at 21.
    let mut hair = combed("hair");
    near(largest(|hit| hair.value("M_R", hit)[0]), -14.0, 5e-3);
    near(largest(|hit| hair.value("M_TRT", hit)[0]), 21.0, 5e-3);
    let (first, second) = (first().set("law", 1.0), second().set("law", 1.0));
    near(largest(|hit| first.shade(hit)[0]), -14.0, 5e-3);
    near(largest(|hit| second.shade(hit)[0]), 21.0, 5e-3);
}

#[test]
fn scheuermanns_highlight_is_as_wide_as_marschners() {
    // At theta_h one width away from the maximum, cos(beta)^(1/beta^2) is near exp(-1/2).
    let short_cut = first().set("law", 1.0).set("alpha_R", 0.0).set("r", 1.0);
    let seen = |theta: f64| short_cut.shade(&Hit::new(around(0.0, 0.0), around(theta, 0.0)))[0];
    near(seen(0.0), 1.0, SINGLE);
    near(seen(16.0), f64::to_radians(8.0).cos().powf(1.0 / 8.0_f64.to_radians().powi(2)), SINGLE);
    near(seen(16.0), (-0.5_f64).exp(), 5e-3);
}

#[test]
fn a_hair_mirrors_what_fresnels_law_says() {
    // All the light of a narrow first highlight, over all directions of the light around the hair and along it, is the
    // mean of Fresnel's law over the width of the hair: the integral of cos(phi/2)/4 F(cos(phi/2)) over phi.
    let mut narrow = first().set("alpha_R", 0.0).set("beta_R", 2.0);
    let (rows, columns) = (60, 48);
    let (mut sum, mut wanted) = (0.0, 0.0);
    for column in 0..columns {
        let phi = (f64::from(column) + 0.5) / f64::from(columns) * 360.0 - 180.0;
        let half = (phi / 2.0).to_radians().cos();
        wanted += half / 4.0 * fresnel(1.55, 0.0, half) * 2.0 * PI / f64::from(columns);
        for row in 0..rows {
            let theta = (f64::from(row) + 0.5) / f64::from(rows) * 40.0 - 20.0;
            let hit = Hit::new(around(theta, phi), around(0.0, 0.0));
            let (cosine, difference) = (theta.to_radians().cos(), (theta / 2.0).to_radians().cos());
            let scattered = narrow.value("M_R", &hit)[0] * narrow.value("N_R", &hit)[0] / difference.powi(2);
            let solid_angle = cosine * f64::to_radians(40.0) / f64::from(rows) * 2.0 * PI / f64::from(columns);
            sum += scattered * cosine * solid_angle;
        }
    }
    near(sum / wanted, 1.0, 1e-2);
}

#[test]
fn hair_is_reciprocal_and_adds_no_light() {
    let mut hair = combed("hair");
    for hit in pairs() {
        // Divided by the cosine of the light's angle to the plane across the hair.
        let across = |direction: Triple| (1.0 - direction[0] * direction[0]).sqrt();
        let (there, back) = (hair.value("MARSCHNER", &hit), hair.value("MARSCHNER", &hit.swapped()));
        near(there[1] / across(hit.light), back[1] / across(hit.viewer), SINGLE);
    }
    let white = combed("hair").set("Cd", 1.0).set("kd", 0.0).set("beta_R", 8.0);
    sends_no_more_than_it_gets(&white, &[0.0, 45.0, 75.0], 0.0);
}

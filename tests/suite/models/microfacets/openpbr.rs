//! OpenPBR (2024): base and coat.

use super::{fresnel, mirror, pairs, reciprocal, sends_no_more_than_it_gets, straight};
use crate::models::{Hit, Model, SINGLE, direction, near};

fn model() -> Model {
    Model::built_in("openpbr")
}

#[test]
fn without_gloss_and_coat_the_base_is_eon() {
    // Smooth: Lambert's. Rough: white stays white (the paper's white furnace test).
    let matte = |roughness| model().set("specular_weight", 0.0).set("base_diffuse_roughness", roughness);
    for hit in pairs() {
        near(matte(0.0).shade(&hit)[0], 0.8 * hit.light[2], SINGLE);
    }
    for polar in [0.0, 60.0, 80.0] {
        near(matte(1.0).set("Cd", 1.0).albedo(polar, 28)[0], 1.0, 2e-3);
    }
}

#[test]
fn openpbr_straight_on() {
    // The width is the square of the roughness, so D/4 pi is 1/(4 r^4); the matte part loses the albedo of the gloss,
    // Karis's fit at n.v = 1.
    let (x, y): (f64, f64) = (0.7, 0.3);
    let karis = (-9.28_f64).exp2().min(x * x) * x + 0.0425 - 0.0275 * y;
    let albedo = 0.04 * (1.04 - 0.572 * y - 1.04 * karis) + (0.022 * y - 0.04 + 1.04 * karis);
    near(model().shade(&straight())[0], 0.04 / (4.0 * 0.0081) + 0.8 * (1.0 - albedo), SINGLE);
    // The weight of the gloss scales its reflectance straight on.
    let half = model().set("specular_weight", 0.5).set("Cd", 0.0);
    near(half.shade(&straight())[0], 0.02 / (4.0 * 0.0081), SINGLE);
}

#[test]
fn dielectrics_obey_fresnel() {
    for polar in [0.0, 45.0, 70.0] {
        let (cosine, sine) = (f64::to_radians(polar).cos(), f64::to_radians(polar).sin());
        // At the roughness sqrt(0.3) the width is 0.3; correlated masking of both directions.
        let gloss = model().set("Cd", 0.0).set("specular_roughness", 0.3_f64.sqrt()).set("specular_ior", 1.8);
        let lambda = ((1.0 + (0.3 * sine / cosine).powi(2)).sqrt() - 1.0) / 2.0;
        let lobe = 1.0 / (0.09 * 4.0 * cosine * (1.0 + 2.0 * lambda));
        near(gloss.shade(&mirror(polar))[0], lobe * fresnel(1.8, 0.0, cosine), SINGLE);
    }
}

#[test]
fn metals_take_their_colour_straight_on_and_their_tint_at_82_degrees() {
    let gold = [0.956, 0.792, 0.408];
    let metal = || {
        model()
            .colour("Cd", gold)
            .set("base_metalness", 1.0)
            .set("specular_roughness", 0.6)
            .colour("specular_color", [0.9, 0.5, 0.2])
    };
    let polar = (1.0_f64 / 7.0).acos().to_degrees();
    let sine = (1.0 - 1.0_f64 / 49.0).sqrt();
    let lambda = ((1.0 + (0.36 * sine * 7.0).powi(2)).sqrt() - 1.0) / 2.0;
    for channel in 0..3 {
        near(metal().shade(&straight())[channel], gold[channel] / (4.0 * 0.1296), SINGLE);
        // The tint times Schlick's reflectance at the cosine 1/7.
        let schlick = gold[channel] + (1.0 - gold[channel]) * (6.0_f64 / 7.0).powi(5);
        let lobe = 7.0 / (0.1296 * 4.0 * (1.0 + 2.0 * lambda));
        near(metal().shade(&mirror(polar))[channel], [0.9, 0.5, 0.2][channel] * schlick * lobe, SINGLE);
    }
}

#[test]
fn anisotropy_keeps_the_mean_square_of_the_widths() {
    // at = r^2 sqrt(2/(1 + (1 - a)^2)) and ab = (1 - a) at, so at^2 + ab^2 = 2 r^4; straight on F0/(4 at ab).
    let (r2, a): (f64, f64) = (0.25, 0.6);
    let at = r2 * (2.0 / (1.0 + (1.0 - a) * (1.0 - a))).sqrt();
    let gloss = model().set("Cd", 0.0).set("specular_roughness", 0.5).set("specular_roughness_anisotropy", a);
    near(gloss.shade(&straight())[0], 0.04 / (4.0 * at * (1.0 - a) * at), SINGLE);
}

#[test]
fn the_average_of_fresnels_law_is_near_the_integral() {
    for index in [1.1, 1.33, 1.5, 1.8, 2.5] {
        // 2 times the integral of F(c) c over the cosine c; midpoint rule.
        let steps = 2000;
        let term = |step: i32| (f64::from(step) + 0.5) / f64::from(steps);
        let sum: f64 = (0..steps).map(|step| fresnel(index, 0.0, term(step)) * term(step)).sum();
        let average = 2.0 * sum / f64::from(steps);
        // Below a coat of the base's own index K = 1 - (1 - average)/index^2, where the base is rough.
        let k = 1.0 - (1.0 - average) / (index * index);
        let found = model().set("coat_ior", index).value("K", &straight())[0];
        near(found, k, 3e-3);
    }
}

#[test]
fn a_coat_that_does_not_reflect_only_absorbs() {
    // Index 1: no reflection, no bounces; along the normal the light goes down and up again once.
    let coat = [0.9, 0.5, 0.2];
    let painted = || model().set("specular_weight", 0.0).set("coat_weight", 1.0).set("coat_ior", 1.0).colour("coat_color", coat);
    for (polar, azimuth) in [(0.0, 0.0), (50.0, 180.0)] {
        let hit = Hit::new(direction(polar, azimuth), direction(0.0, 0.0));
        let length = 0.5 + 0.5 / hit.light[2];
        for (channel, coat) in coat.into_iter().enumerate() {
            let wanted = 0.8 * hit.light[2] * f64::powf(coat, length);
            near(painted().set("coat_darkening", 0.0).shade(&hit)[channel], wanted, SINGLE);
        }
    }
}

#[test]
fn a_coat_darkens_and_saturates() {
    // (1 - K)/(1 - Cd K) for each colour: straight on, without gloss of the base, with and without the bounces.
    let red = [0.8, 0.2, 0.0];
    let coated = |darkening| {
        model()
            .colour("Cd", red)
            .set("specular_weight", 0.0)
            .set("coat_weight", 1.0)
            .set("coat_ior", 1.5)
            .set("coat_darkening", darkening)
            .set("coat_roughness", 1.0)
    };
    let k = coated(1.0).value("K", &straight())[0];
    // The light that comes back down inside: known for 1.5 to be about 0.6.
    near(k, 0.596, 5e-3);
    let (with, without) = (coated(1.0).shade(&straight()), coated(0.0).shade(&straight()));
    let coat = without[2];
    for channel in 0..2 {
        let darker = (with[channel] - coat) / (without[channel] - coat);
        near(darker, (1.0 - k) / (1.0 - red[channel] * k), 1e-3);
    }
}

#[test]
fn openpbr_sends_no_more_than_it_gets() {
    let white = || model().set("Cd", 1.0).set("specular_roughness", 0.6);
    sends_no_more_than_it_gets(&white(), &[0.0, 45.0, 75.0], 0.02);
    sends_no_more_than_it_gets(&white().set("base_metalness", 1.0), &[0.0, 45.0, 75.0], 0.0);
    let coated = white().set("coat_weight", 1.0).set("coat_roughness", 0.5);
    sends_no_more_than_it_gets(&coated, &[0.0, 45.0, 75.0], 0.02);
    // A metal has no layer whose albedo depends on the viewer alone.
    reciprocal(&white().set("base_metalness", 1.0).set("specular_roughness_anisotropy", 0.5));
}

//! Walter and others (2007): rough dielectrics, with three distributions of facets.

use super::{covered, fresnel, mirror, pairs, reciprocal, sends_no_more_than_it_gets, straight};
use crate::models::{Hit, Model, SINGLE, direction, near};
use std::f64::consts::PI;

const GGX: f64 = 0.0;
const BECKMANN: f64 = 1.0;
const PHONG: f64 = 2.0;

fn facets(distribution: f64, width: f64) -> Model {
    Model::built_in("ggx").set("dist_m", distribution).set("ag", width).set("kd", 0.0)
}

#[test]
fn all_distributions_have_the_same_height() {
    // D(n) = 1/(pi a^2), also for Phong's exponent 2/a^2 - 2; so F0/(4 a^2), and kd Cd (1 - F0)^2 from below.
    for distribution in [GGX, BECKMANN, PHONG] {
        near(facets(distribution, 0.3).shade(&straight())[0], 0.04 / 0.36, SINGLE);
        near(facets(distribution, 0.3).set("kd", 0.5).shade(&straight())[0], 0.04 / 0.36 + 0.5 * 0.8 * 0.96 * 0.96, SINGLE);
    }
}

#[test]
fn facets_by_angles() {
    // Equations 20, 22, 25, 27, 30, 33 and 34 with angles, worked out by a script in double precision; width 0.3.
    let wanted = [
        [0.0456554359560941, 0.06892838464960663, 0.06616433718808365],
        [0.002895303570664545, 3.854987537943647e-7, 3.1958058260340184e-5],
        [0.04603166082774716, 0.06315929079195702, 0.06250555434168964],
    ];
    for (hit, wanted) in pairs().iter().zip(wanted) {
        for (distribution, wanted) in [GGX, BECKMANN, PHONG].into_iter().zip(wanted) {
            // Relative, also where little light comes.
            near(facets(distribution, 0.3).shade(hit)[0] / wanted, 1.0, 2.0 * SINGLE);
        }
    }
}

#[test]
fn facets_cover_the_surface() {
    for distribution in [GGX, BECKMANN, PHONG] {
        near(covered(&mut facets(distribution, 0.3), "D", 96), 1.0, 2e-3);
    }
}

/// The error function, by its Maclaurin series.
fn erf(x: f64) -> f64 {
    let mut term = x;
    let mut sum = x;
    for n in 1..80 {
        term *= -x * x / f64::from(n);
        sum += term / f64::from(2 * n + 1);
    }
    2.0 / PI.sqrt() * sum
}

#[test]
fn beckmanns_masking_is_near_the_exact_one() {
    // Equation 27 for 26: "relative error less than 0.35%". The light stands straight above, where G1 is 1.
    let mut model = facets(BECKMANN, 0.5);
    for polar in [30.0, 45.0, 55.0, 65.0, 75.0, 85.0] {
        let a: f64 = 1.0 / (0.5 * f64::to_radians(polar).tan());
        let exact = 2.0 / (1.0 + erf(a) + (-a * a).exp() / (a * PI.sqrt()));
        let found = model.value("G", &Hit::new(direction(0.0, 0.0), direction(polar, 0.0)))[0];
        assert!((found / exact - 1.0).abs() < 0.0036, "{found} for {exact} at {polar}");
    }
}

#[test]
fn rough_dielectrics_obey_fresnel() {
    for index in [1.33, 1.5, 2.42] {
        for polar in [0.0, 45.0, 60.0, 80.0] {
            let cosine = f64::to_radians(polar).cos();
            let model = facets(GGX, 0.2).set("n", index);
            let tan = f64::to_radians(polar).tan();
            let masking = (2.0 / (1.0 + (1.0 + 0.04 * tan * tan).sqrt())).powi(2);
            near(model.shade(&mirror(polar))[0], fresnel(index, 0.0, cosine) * masking / (0.04 * 4.0 * cosine), SINGLE);
        }
    }
}

#[test]
fn rough_dielectrics_are_reciprocal_and_conserve_energy() {
    for distribution in [GGX, BECKMANN, PHONG] {
        reciprocal(&facets(distribution, 0.4).set("kd", 0.7));
        for width in [0.2, 0.7] {
            let white = facets(distribution, width).set("kd", 1.0).set("Cd", 1.0);
            sends_no_more_than_it_gets(&white, &[0.0, 60.0, 85.0], 0.0);
        }
    }
}

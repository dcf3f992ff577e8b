//! Torrance and Sparrow (1967), and Cook and Torrance (1982).

use super::{covered, fresnel, mirror, reciprocal, sends_no_more_than_it_gets, straight};
use crate::models::{Hit, Model, SINGLE, direction, near};
use std::f64::consts::PI;

const GOLD: [[f64; 3]; 2] = [[0.156, 0.424, 1.383], [3.602, 2.472, 1.915]];

#[test]
fn torrance_and_sparrow_straight_on() {
    // kd Cd + ks F0 (pi/4) b, where b = c^2/pi with c per radian.
    let b = (0.05 * 180.0 / PI).powi(2) / PI;
    let wanted = 0.3 * 0.8 + 0.7 * 0.04 * PI / 4.0 * b;
    near(Model::built_in("torrance-sparrow").shade(&straight())[0], wanted, SINGLE);
}

#[test]
fn torrance_and_sparrow_obey_fresnel() {
    let model = Model::built_in("torrance-sparrow").set("kd", 0.0).set("ks", 1.0).colour("n", GOLD[0]).colour("k", GOLD[1]);
    for polar in [0.0, 30.0, 60.0, 80.0] {
        let cosine = f64::to_radians(polar).cos();
        let shade = model.shade(&mirror(polar));
        for channel in 0..3 {
            // In the mirror direction the facet is level, nothing is masked, and G/cos(theta) is 1/cos(theta).
            let b = (0.05 * 180.0 / PI).powi(2) / PI;
            let wanted = fresnel(GOLD[0][channel], GOLD[1][channel], cosine) * PI * b / (4.0 * cosine);
            near(shade[channel], wanted, SINGLE);
        }
    }
}

#[test]
fn torrance_and_sparrow_peak_beyond_the_mirror_direction() {
    // The radiance over viewing angles in tenths of a degree: its peak and its value at 30 degrees. A script worked
    // them out from the formula of the paper with angles and a complex index, in double precision.
    let metal = [[1.558; 3], [7.712; 3]];
    let model = Model::built_in("torrance-sparrow").set("kd", 0.0).set("ks", 1.0).colour("n", metal[0]).colour("k", metal[1]);
    for (incidence, peak, value, at_30) in [
        (10.0, 13.3, 1.8962953102673343, 1.670654348728825),
        (30.0, 42.9, 2.281356449278634, 2.143635725830374),
        (45.0, 75.0, 4.012156050008479, 1.8598590129416248),
        (60.0, 80.0, 7.978591821873834, 1.2163763542466899),
    ] {
        let radiance =
            |tenths: i32| model.shade(&Hit::new(direction(incidence, 0.0), direction(f64::from(tenths) / 10.0, 180.0)))[0];
        let brightest = (0..899).max_by(|one, other| radiance(*one).total_cmp(&radiance(*other))).expect("some angles");
        assert!((f64::from(brightest) / 10.0 - peak).abs() < 0.25, "{brightest} at {incidence}");
        near(radiance(brightest), value, SINGLE);
        near(radiance(300), at_30, SINGLE);
    }
}

#[test]
fn torrance_and_sparrow_are_reciprocal_and_conserve_energy() {
    reciprocal(&Model::built_in("torrance-sparrow"));
    let mirrors = Model::built_in("torrance-sparrow").set("kd", 0.0).set("ks", 1.0).set("n", 0.05).set("k", 10.0);
    sends_no_more_than_it_gets(&mirrors, &[0.0, 45.0, 75.0], 0.0);
}

#[test]
fn cook_and_torrance_straight_on() {
    // d Cd + s F0 D/4, where D = 1/m^2; the printed factor is four times as much.
    let model = || Model::built_in("cook-torrance").set("m", 0.3);
    let highlight = 0.5 * 0.04 / (4.0 * 0.09);
    near(model().shade(&straight())[0], 0.5 * 0.8 + highlight, SINGLE);
    near(model().set("printed", 1.0).shade(&straight())[0], 0.5 * 0.8 + 4.0 * highlight, SINGLE);
    // Two sets of facets: the mean of both.
    let two = model().set("w", 0.4).set("m2", 0.1).shade(&straight())[0];
    near(two, 0.4 + 0.5 * 0.04 / 4.0 * (0.4 / 0.09 + 0.6 / 0.01), SINGLE);
}

#[test]
fn beckmanns_facets_cover_the_surface() {
    // The paper's D lacks the factor 1/pi.
    let mut model = Model::built_in("cook-torrance").set("m", 0.3).set("m2", 0.6).set("w", 0.3);
    near(covered(&mut model, "D", 64) / PI, 1.0, 1e-3);
}

#[test]
fn cook_and_torrance_obey_fresnel() {
    let metal = Model::built_in("cook-torrance").set("d", 0.0).set("s", 1.0).colour("n", GOLD[0]).colour("k", GOLD[1]);
    let plastic = Model::built_in("cook-torrance").set("d", 0.0).set("s", 1.0).colour("n", [1.333, 1.5, 2.42]);
    for polar in [0.0, 45.0, 56.31, 75.0, 85.0] {
        let cosine = f64::to_radians(polar).cos();
        // A level facet of the slope 0.25, not masked.
        let scale = 1.0 / (0.0625 * 4.0 * cosine);
        let (gold, clear) = (metal.shade(&mirror(polar)), plastic.shade(&mirror(polar)));
        for channel in 0..3 {
            near(gold[channel], scale * fresnel(GOLD[0][channel], GOLD[1][channel], cosine), SINGLE);
            near(clear[channel], scale * fresnel([1.333, 1.5, 2.42][channel], 0.0, cosine), SINGLE);
        }
    }
}

#[test]
fn cook_and_torrance_are_reciprocal_and_conserve_energy() {
    reciprocal(&Model::built_in("cook-torrance"));
    let mirrors = Model::built_in("cook-torrance").set("d", 0.0).set("s", 1.0).set("n", 0.05).set("k", 10.0).set("m", 0.3);
    sends_no_more_than_it_gets(&mirrors, &[0.0, 45.0, 75.0], 0.0);
}

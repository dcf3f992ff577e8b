//! Glass and coloured mirrors: the weights of their rays.

use super::{fresnel, mirror, straight};
use crate::models::{Hit, Model, SINGLE, direction, near};

/// A viewer at this angle in degrees, at a surface with this n1/n2.
fn crossing(polar: f64, eta: f64) -> Hit {
    Hit { eta, ..Hit::new(direction(0.0, 0.0), direction(polar, 0.0)) }
}

#[test]
fn glass_straight_on_reflects_four_parts_of_a_hundred() {
    let mut glass = Model::built_in("fresnel-glass").set("tint", 1.0);
    for eta in [1.0 / 1.5, 1.5] {
        near(glass.value("reflected", &crossing(0.0, eta))[0], 0.04, SINGLE);
        near(glass.value("refracted", &crossing(0.0, eta))[0], 0.96, SINGLE);
    }
    near(glass.value("reflected", &crossing(0.0, 1.0))[0], 0.0, SINGLE);
}

#[test]
fn glass_obeys_fresnel_on_both_sides() {
    let tint = [0.9, 0.6, 0.3];
    let mut glass = Model::built_in("fresnel-glass").colour("tint", tint);
    for index in [1.333, 1.5, 2.417] {
        for polar in [0.0, 20.0, 33.0, 45.0, 60.0, 80.0, 89.0] {
            let cosine = f64::to_radians(polar).cos();
            for eta in [1.0 / index, index] {
                // From inside beyond the critical angle the direct formula gives 1.
                let wanted = fresnel(1.0 / eta, 0.0, cosine);
                let hit = crossing(polar, eta);
                near(glass.value("reflected", &hit)[0], wanted, SINGLE);
                for (channel, tint) in tint.into_iter().enumerate() {
                    near(glass.value("refracted", &hit)[channel], (1.0 - wanted) * tint, SINGLE);
                }
            }
        }
    }
}

#[test]
fn light_may_go_either_way_through_glass() {
    // Stokes: the reflectance is the same from both sides, at the angles that belong together by Snell's law.
    let mut glass = Model::built_in("fresnel-glass");
    for polar in [10.0, 40.0, 56.31, 75.0, 85.0] {
        let inside = (f64::to_radians(polar).sin() / 1.5).asin().to_degrees();
        let outer = glass.value("reflected", &crossing(polar, 1.0 / 1.5))[0];
        near(glass.value("reflected", &crossing(inside, 1.5))[0], outer, SINGLE);
    }
    // Brewster's angle: ((n^2 - 1)/(n^2 + 1))^2/2. The critical angle of 1.5 is 41.81 degrees.
    let brewster = 1.5_f64.atan().to_degrees();
    near(glass.value("reflected", &crossing(brewster, 1.0 / 1.5))[0], (1.25_f64 / 3.25).powi(2) / 2.0, SINGLE);
    assert!(glass.value("reflected", &crossing(41.5, 1.5))[0] < 0.7);
    near(glass.value("reflected", &crossing(42.0, 1.5))[0], 1.0, SINGLE);
    near(glass.value("refracted", &crossing(42.0, 1.5))[0], 0.0, SINGLE);
}

#[test]
fn lamps_are_mirrored_by_the_same_law() {
    // The index of the highlight is a parameter: F/(4 a^2 cos) with Smith's masking of both directions.
    for polar in [0.0, 50.0, 75.0] {
        let (cosine, tan) = (f64::to_radians(polar).cos(), f64::to_radians(polar).tan());
        let masking = (2.0 / (1.0 + (1.0 + 0.09 * tan * tan).sqrt())).powi(2);
        let lobe = masking / (0.09 * 4.0 * cosine);
        let glass = Model::built_in("fresnel-glass").set("ag", 0.3).set("n", 1.8);
        near(glass.shade(&mirror(polar))[0], lobe * fresnel(1.8, 0.0, cosine), SINGLE);
        let metal = Model::built_in("coloured-mirror").set("ag", 0.3).set("n", 0.156).set("k", 3.602);
        near(metal.shade(&mirror(polar))[0], lobe * fresnel(0.156, 3.602, cosine), SINGLE);
    }
}

#[test]
fn mirrors_have_the_colours_of_metals() {
    let (n, k) = ([0.156, 0.424, 1.383], [3.602, 2.472, 1.915]);
    let mut gold = Model::built_in("coloured-mirror").colour("n", n).colour("k", k).set("kr", 0.9);
    for polar in [0.0, 45.0, 80.0, 88.0] {
        let found = gold.value("reflected", &crossing(polar, 1.0));
        for channel in 0..3 {
            near(found[channel], 0.9 * fresnel(n[channel], k[channel], f64::to_radians(polar).cos()), SINGLE);
        }
    }
    // Straight on, ((n - 1)^2 + k^2)/((n + 1)^2 + k^2).
    let red = ((0.156_f64 - 1.0).powi(2) + 3.602 * 3.602) / (1.156_f64.powi(2) + 3.602 * 3.602);
    near(gold.value("reflected", &straight())[0], 0.9 * red, SINGLE);
}

#[test]
fn mirrors_by_schlick_turn_white_at_the_edge() {
    let mut foil = Model::built_in("coloured-mirror").set("law", 1.0).colour("Cd", [0.1, 0.3, 0.95]);
    for (channel, colour) in [0.1, 0.3, 0.95].into_iter().enumerate() {
        near(foil.value("reflected", &crossing(0.0, 1.0))[channel], colour, SINGLE);
        // (1 - 1/2)^5 = 1/32 at 60 degrees.
        near(foil.value("reflected", &crossing(60.0, 1.0))[channel], colour + (1.0 - colour) / 32.0, SINGLE);
        assert!(foil.value("reflected", &crossing(89.9, 1.0))[channel] > 0.98);
    }
}

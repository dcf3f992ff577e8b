//! Burley (2012): Disney's principled model, and its diffuse part.

use super::{Model, covered, pairs, reciprocal, sends_no_more_than_it_gets, straight};
use crate::models::{Hit, SINGLE, direction, near};
use std::f64::consts::PI;

#[test]
fn disney_straight_on() {
    // No weight of Schlick's remains: Cd + 0.08 specular/(4 roughness^4).
    let model = || Model::built_in("disney").set("roughness", 0.5).set("specular", 0.5);
    near(model().shade(&straight())[0], 0.8 + 0.04 / (4.0 * 0.0625), SINGLE);
    // The shape below the surface: 1.25 (1/2 - 1/2 + 1/2).
    near(model().set("subsurface", 1.0).shade(&straight())[0], 0.625 * 0.8 + 0.16, SINGLE);
    // Metal: the base colour as F0, and no matte part.
    near(model().set("metallic", 1.0).shade(&straight())[0], 0.8 * 4.0, SINGLE);
    // A coat adds pi/4 * G 0.04 GTR1(1), with G = 1/4 and the width 0.1 of the satin end.
    let coat = PI / 4.0 * 0.25 * 0.04 * (0.01 - 1.0) / (PI * 0.01_f64.ln() * 0.01);
    near(model().set("clearcoat", 1.0).set("clearcoatGloss", 0.0).shade(&straight())[0], 0.8 + 0.16 + coat, SINGLE);
}

#[test]
fn disney_by_the_published_code() {
    // disney.brdf of Disney's BRDF Explorer, transcribed into a script in double precision; the factor pi n.l is ours.
    let colour = [0.8, 0.3, 0.1];
    let plain = Model::built_in("disney").colour("Cd", colour).set("roughness", 0.4);
    let metal = Model::built_in("disney")
        .colour("Cd", colour)
        .set("roughness", 0.5)
        .set("anisotropic", 0.8)
        .set("metallic", 0.6)
        .set("specularTint", 0.5)
        .set("sheen", 0.7);
    let coated = Model::built_in("disney")
        .colour("Cd", colour)
        .set("roughness", 0.8)
        .set("subsurface", 0.7)
        .set("clearcoat", 1.0)
        .set("clearcoatGloss", 0.3)
        .set("sheen", 1.0);
    let wanted = [
        [[0.6785585, 0.2690416, 0.1052348], [0.3390097, 0.128084, 0.0437137], [0.6208928, 0.2518194, 0.10419]],
        [[0.2766205, 0.1041822, 0.0352069], [0.1175898, 0.0441583, 0.0147858], [0.3056488, 0.1184344, 0.0435486]],
        [[0.7662789, 0.2983822, 0.1112235], [1.3798085, 0.5300891, 0.1902013], [0.7468235, 0.3020933, 0.1242013]],
    ];
    for (hit, wanted) in pairs().iter().zip(wanted) {
        for (model, wanted) in [&plain, &metal, &coated].into_iter().zip(wanted) {
            let found = model.shade(hit);
            for channel in 0..3 {
                near(found[channel], wanted[channel], SINGLE);
            }
        }
    }
}

#[test]
fn disneys_facets_cover_the_surface() {
    let mut model = Model::built_in("disney").set("roughness", 0.8).set("anisotropic", 0.6).set("clearcoatGloss", 0.0);
    near(covered(&mut model, "DS", 64), 1.0, 1e-3);
    // GTR with the exponent 1 has long tails, but it is normalized, too.
    near(covered(&mut model, "DC", 128), 1.0, 3e-3);
}

#[test]
fn disney_is_reciprocal() {
    reciprocal(&Model::built_in("disney").set("sheen", 0.5).set("clearcoat", 1.0).set("clearcoatGloss", 0.2));
    reciprocal(&Model::built_in("disney").set("metallic", 0.5).set("anisotropic", 0.7).set("subsurface", 0.4));
}

fn diffuse(form: f64, roughness: f64) -> Model {
    Model::built_in("disney-diffuse").set("Cd", 1.0).set("form", form).set("roughness", roughness)
}

#[test]
fn disneys_diffuse_part_sends_light_back_to_where_it_came_from() {
    // Seen from the light, (1 + (F90 - 1)(1 - cos)^5)^2 n.l with F90 = 0.5 + 2 roughness.
    for roughness in [0.0, 0.25, 0.7, 1.0] {
        for polar in [0.0, 60.0, 85.0] {
            let cosine = f64::to_radians(polar).cos();
            let hit = Hit::new(direction(polar, 0.0), direction(polar, 0.0));
            let edge = 1.0 + (2.0 * roughness - 0.5) * (1.0 - cosine).powi(5);
            near(diffuse(0.0, roughness).shade(&hit)[0], edge * edge * cosine, SINGLE);
        }
    }
    // "A reduction of 0.5 at grazing angles" for smooth surfaces: once on the way in and once on the way out.
    let grazing = Hit::new(direction(89.9, 0.0), direction(89.9, 0.0));
    near(diffuse(0.0, 0.0).shade(&grazing)[0] / grazing.light[2], 0.25, 0.01);
}

#[test]
fn frostbites_diffuse_part_conserves_energy_and_disneys_does_not() {
    for roughness in [0.0, 0.5, 1.0] {
        sends_no_more_than_it_gets(&diffuse(1.0, roughness), &[0.0, 45.0, 75.0, 85.0], 0.0);
    }
    assert!(diffuse(0.0, 1.0).albedo(80.0, 32)[0] > 1.0, "the reason for Frostbite's scale");
    // Straight on, its scale is that of the roughness alone.
    near(diffuse(1.0, 1.0).shade(&straight())[0], 1.0 / 1.51, SINGLE);
    near(diffuse(1.0, 0.0).shade(&straight())[0], 1.0, SINGLE);
}

#[test]
fn diffuse_parts_are_reciprocal_and_one_is_lamberts() {
    for form in [0.0, 1.0, 2.0] {
        reciprocal(&diffuse(form, 0.8));
    }
    for hit in pairs() {
        near(diffuse(2.0, 0.3).shade(&hit)[0], hit.light[2], SINGLE);
    }
    near(diffuse(2.0, 0.3).albedo(40.0, 48)[0], 1.0, 1e-3);
}

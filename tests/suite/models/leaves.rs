//! Leaves that light goes through: Bousquet and others (2005).

use super::microfacets::{covered, fresnel, mirror, sends_no_more_than_it_gets, straight};
use super::{Hit, Model, SINGLE, direction, near, sound_in_all_corners};

fn sheet() -> Model {
    Model::built_in("leaf").colour("tau", [0.2, 0.4, 0.05]).set("mottle", 0.0)
}

/// An outlined leaf of the length 2, its midrib along +x.
fn outlined() -> Model {
    sheet().set("shape", 1.0).set("width", 0.5).set("ribs", 0.0)
}

#[test]
fn colours_are_numbers_in_all_corners() {
    sound_in_all_corners("leaf");
}

#[test]
fn light_from_behind_goes_through_where_nothing_is_in_its_way() {
    for (polar, cosine) in [(180.0, 1.0), (120.0, 0.5), (90.0, 0.0)] {
        for viewer in [0.0, 60.0] {
            let hit = Hit::new(direction(polar, 30.0), direction(viewer, 0.0));
            let found = sheet().shade(&hit);
            for (found, through) in found.into_iter().zip([0.2, 0.4, 0.05]) {
                near(found, cosine * through, SINGLE);
            }
            near(sheet().shade(&Hit { visible: 0.0, ..hit })[0], 0.0, SINGLE);
        }
    }
}

#[test]
fn wax_straight_on() {
    // D = 1/(pi sigma^2), G = 1: F/(4 sigma^2), above the matte part.
    let found = sheet().set("Cd", 0.1).set("n", 1.5).set("sigma", 0.4).shade(&straight())[0];
    near(found, 0.1 + 0.04 / (4.0 * 0.16), SINGLE);
}

#[test]
fn wax_obeys_fresnel() {
    for polar in [30.0, 45.0, 60.0] {
        let cosine = f64::to_radians(polar).cos();
        // A level facet; 2 N.H N.V/V.H is 2, so nothing is masked.
        for (index, slope) in [(1.32, 0.56), (1.5, 0.25)] {
            let found = sheet().set("Cd", 0.0).set("n", index).set("sigma", slope).shade(&mirror(polar))[0];
            near(found, fresnel(index, 0.0, cosine) / (4.0 * slope * slope * cosine), SINGLE);
        }
    }
}

#[test]
fn facets_of_wax_cover_the_leaf() {
    for slope in [0.25, 0.55] {
        near(covered(&mut sheet().set("sigma", slope), "D", 64), 1.0, 2e-3);
    }
}

#[test]
fn a_leaf_sends_no_more_than_it_gets() {
    sends_no_more_than_it_gets(&sheet().set("Cd", 0.5), &[0.0, 60.0, 80.0], 0.0);
}

#[test]
fn around_its_outline_a_leaf_is_clear() {
    let mut leaf = outlined().set("kr", 0.5);
    let mut at = |point, name: &str| leaf.value(name, &Hit { point, ..straight() })[0];
    // Half of the width at the middle is 0.5; beyond the tip there is nothing.
    for point in [[0.0, 0.55, 0.0], [0.0, -0.55, 0.0], [1.2, 0.0, 0.0], [0.9, 0.4, 0.0]] {
        near(at(point, "refracted"), 1.0, SINGLE);
        near(at(point, "reflected"), 0.0, SINGLE);
        near(at(point, "ambient"), 0.0, SINGLE);
        let behind = Hit::new(direction(180.0, 0.0), direction(0.0, 0.0));
        near(outlined().shade(&Hit { point, ..behind })[0], 0.0, SINGLE);
    }
    // The edge is a little soft.
    near(at([0.0, 0.49, 0.0], "refracted"), 0.5, 1e-3);
    near(at([0.0, 0.4, 0.0], "refracted"), 0.0, SINGLE);
    near(at([0.0, 0.4, 0.0], "reflected"), 0.5, SINGLE);
    // Away from the origin, and twice as large.
    let mut other = outlined().set("size", 2.0).colour("centre", [3.0, 1.0, 0.0]);
    near(other.value("refracted", &Hit { point: [3.0, 1.9, 0.0], ..straight() })[0], 0.0, SINGLE);
    near(other.value("refracted", &Hit { point: [3.0, 2.1, 0.0], ..straight() })[0], 1.0, SINGLE);
}

#[test]
fn the_midrib_has_a_colour_of_its_own_and_a_whole_sheet_has_none() {
    let behind = Hit::new(direction(180.0, 0.0), direction(0.0, 0.0));
    let leaf = |model: Model| model.colour("veins", [0.9, 0.8, 0.7]).shade(&behind)[0];
    near(leaf(outlined()), 0.9, SINGLE);
    near(leaf(sheet()), 0.2, SINGLE);
    near(sheet().set("kt", 0.3).value("refracted", &behind)[0], 0.3, SINGLE);
}

#[test]
fn a_leaf_twice_as_thick_lets_the_square_through() {
    let behind = Hit { point: [0.21, 0.17, 0.0], ..Hit::new(direction(180.0, 0.0), direction(0.0, 0.0)) };
    let mut uneven = sheet().set("mottle", 1.0);
    let thickness = uneven.value("THICK", &behind)[0];
    assert!((thickness - 1.0).abs() > 0.01, "{thickness}");
    near(uneven.shade(&behind)[1], 0.4_f64.powf(thickness), SINGLE);
}

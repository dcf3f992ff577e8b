//! Rough matte surfaces, lobes that are fitted to measurements, films and lacquers.

mod layers;
mod lobes;
mod matte;

use super::{Hit, Model, SINGLE, Triple, direction, hemisphere, near, sound_in_all_corners};
use std::f64::consts::PI;

const UP: Triple = [0.0, 0.0, 1.0];

/// Values of parameters by name: one number, or the three of a vector.
type Given<'a> = &'a [(&'a str, &'a [f64])];

/// A built-in formula with values of some parameters.
fn model(name: &str, given: Given) -> Model {
    let mut model = Model::built_in(name);
    for (name, value) in given {
        model.assign(name, [0, 1, 2].map(|component| value[component.min(value.len() - 1)]));
    }
    model
}

/// A hit with light and viewer at these angles, in degrees: from the normal, and around it.
fn hit(light: (f64, f64), viewer: (f64, f64)) -> Hit {
    Hit::new(direction(light.0, light.1), direction(viewer.0, viewer.1))
}

/// Hits of all kinds: on the normal, slanted to the same and to opposite sides, across, and near the edge.
fn slanted() -> Vec<Hit> {
    let pairs = [
        ((0.0, 0.0), (0.0, 0.0)),
        ((30.0, 0.0), (0.0, 0.0)),
        ((0.0, 0.0), (70.0, 10.0)),
        ((40.0, 20.0), (40.0, 20.0)),
        ((35.0, 20.0), (50.0, 160.0)),
        ((70.0, 75.0), (40.0, 0.0)),
        ((20.0, 200.0), (65.0, 15.0)),
        ((80.0, 10.0), (75.0, 205.0)),
        ((85.0, 0.0), (10.0, 90.0)),
    ];
    pairs.into_iter().map(|(light, viewer)| hit(light, viewer)).collect()
}

#[track_caller]
fn close(found: f64, wanted: f64) {
    near(found, wanted, SINGLE);
}

#[track_caller]
fn all_close(found: Triple, wanted: Triple) {
    (0..3).for_each(|channel| close(found[channel], wanted[channel]));
}

/// Asserts that light and viewer may be exchanged.
#[track_caller]
fn reciprocal(model: &Model) {
    for hit in slanted() {
        let one_way = model.shade(&hit).map(|colour| colour / hit.light[2]);
        let other_way = model.shade(&hit.swapped()).map(|colour| colour / hit.viewer[2]);
        (0..3).for_each(|channel| near(one_way[channel], other_way[channel], 3.0 * SINGLE));
    }
}

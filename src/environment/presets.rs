//! The built-in environments. They are computed from formulas when they are needed; no images are stored.
//!
//! They are scaled to be about equally bright: a matte floor of colour 0.8 under one of them, with nothing around, has
//! components of 0.6 to 0.7.

mod clear_sky;
mod overcast;
mod softboxes;
mod sun;

use crate::environment::RadianceMap;
use crate::environment::latitude_longitude::direction;
use glam::DVec3;
use std::f64::consts::PI;

/// Width and height of the built-in maps, in texels.
const SIZE: [u32; 2] = [1024, 512];

/// A built-in environment, which scenes name as `preset:NAME`.
#[derive(Debug)]
pub struct EnvironmentPreset {
    /// Its name, without `preset:`.
    pub name: &'static str,
    /// What it is: one line.
    pub about: &'static str,
    make: fn() -> RadianceMap,
}

impl EnvironmentPreset {
    /// Computes its map: 1024×512 texels.
    pub fn map(&self) -> RadianceMap {
        (self.make)()
    }

    /// The bytes that its map takes.
    pub fn memory(&self) -> u64 {
        RadianceMap::memory_of(SIZE[0], SIZE[1])
    }
}

/// The built-in environments.
pub const PRESETS: &[EnvironmentPreset] = &[
    EnvironmentPreset { name: "softboxes", about: "a dark studio with three soft boxes", make: softboxes::map },
    EnvironmentPreset {
        name: "sky",
        about: "a clear sky with the sun, by Preetham, Shirley and Smits (1999)",
        make: clear_sky::map,
    },
    EnvironmentPreset {
        name: "overcast",
        about: "the standard overcast sky of the CIE, by Moon and Spencer (1942)",
        make: overcast::map,
    },
];

/// The map of a function that gives the radiance, linear RGB, from a direction of unit length.
fn map_of(radiance: impl Fn(DVec3) -> DVec3 + Sync) -> RadianceMap {
    let [width, height] = SIZE;
    let middle = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count);
    // The directions at the horizon. Those of other rows are the same, but shorter.
    let level: Vec<DVec3> = (0..width).map(|column| direction(middle(column, width), [1.0, 0.0])).collect();
    let write = |row: u32, texels: &mut [[f32; 3]]| {
        let (sine, cosine) = (PI * middle(row, height)).sin_cos();
        for (texel, level) in texels.iter_mut().zip(&level) {
            *texel = radiance(DVec3::new(sine * level.x, cosine, sine * level.z)).as_vec3().to_array();
        }
    };
    RadianceMap::of_rows(width, height, write).map_or(RadianceMap::WHITE, |(map, _)| map)
}

/// 0 up to `from`, 1 from `to` on, and smooth between them: t²(3 − 2t).
fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let share = ((x - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// The plain under a sky, with haze at the horizon: `sky` is the radiance at the horizon and `plain` that of the plain,
/// seen in a direction downwards.
fn plain_in_haze(direction: DVec3, sky: DVec3, plain: DVec3) -> DVec3 {
    /// Below this height of a direction there is no haze, about 3 degrees below the horizon.
    const HAZE: f64 = -0.05;
    sky.lerp(plain, smooth_step(0.0, HAZE, direction.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The radiance of a floor of colour 1, facing upwards: the integral of radiance times cosine, by π.
    fn floor(map: &RadianceMap) -> [f64; 3] {
        let (columns, rows) = (1024, 256);
        let mut total = [0.0; 3];
        for row in 0..rows {
            // Rows of equal parts of the projected hemisphere: the cosine is √(1 − share).
            let share = (f64::from(row) + 0.5) / f64::from(rows);
            let polar = [share.sqrt(), (1.0 - share).sqrt()];
            for column in 0..columns {
                let radiance = map.radiance(direction((f64::from(column) + 0.5) / f64::from(columns), polar));
                (0..3).for_each(|index| total[index] += f64::from(radiance[index]) / f64::from(columns * rows));
            }
        }
        total
    }

    #[test]
    fn a_floor_is_well_lit_by_each() {
        for preset in PRESETS {
            let map = preset.map();
            assert_eq!((map.size(), map.memory()), (Some(SIZE), preset.memory()));
            let lit = floor(&map).map(|component| 0.8 * component);
            assert!(lit.iter().all(|component| (0.59..0.70).contains(component)), "{}: {lit:?}", preset.name);
        }
    }

    #[test]
    fn names_are_different_and_known() {
        let names = Vec::from_iter(PRESETS.iter().map(|preset| preset.name));
        assert_eq!(names, ["softboxes", "sky", "overcast"]);
    }
}

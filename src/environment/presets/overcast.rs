//! The standard overcast sky.

use crate::environment::RadianceMap;
use crate::environment::presets::{map_of, plain_in_haze};
use glam::DVec3;

/// The radiance of the zenith. A floor of colour 1 has 7/9 of it.
const ZENITH: f64 = 0.75 * 9.0 / 7.0;
/// How much of the light the plain below reflects.
const ALBEDO: f64 = 0.2;

/// The radiance above the horizon, by the height of the direction, 0..=1: P. Moon, D. E. Spencer, Illumination from a
/// non-uniform sky, 1942; standard of the CIE since 1955: L = Lz·(1 + 2·sin(altitude))/3.
fn sky(height: f64) -> f64 {
    ZENITH * (1.0 + 2.0 * height) / 3.0
}

fn radiance(direction: DVec3) -> DVec3 {
    if direction.y >= 0.0 {
        DVec3::splat(sky(direction.y))
    } else {
        // The irradiance of the plain by π is ∫ L·cos dω / π = 7/9·Lz.
        plain_in_haze(direction, DVec3::splat(sky(0.0)), DVec3::splat(ALBEDO * ZENITH * 7.0 / 9.0))
    }
}

/// The map: white light of D65.
pub(super) fn map() -> RadianceMap {
    map_of(radiance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_zenith_is_three_times_as_bright_as_the_horizon() {
        let [zenith, horizon, half] = [DVec3::Y, DVec3::X, DVec3::new(0.0, 0.5, 0.75_f64.sqrt())].map(radiance);
        assert!((zenith[0] / horizon[0] - 3.0).abs() < 1e-12);
        // At an altitude of 30 degrees: (1 + 2·0.5)/3 = 2/3.
        assert!((half[1] / zenith[1] - 2.0 / 3.0).abs() < 1e-12);
        assert!((radiance(-DVec3::Y)[2] / zenith[2] - 0.2 * 7.0 / 9.0).abs() < 1e-12);
    }
}

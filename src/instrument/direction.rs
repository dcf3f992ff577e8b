//! Directions in the frame of the surface by angles, and what follows from a value for a pair of them.

use crate::instrument::DirectionPair;
use glam::DVec3;
use std::f64::consts::PI;

/// The greatest polar angle of a direction, in degrees: a direction along the surface has no value.
pub const STEEPEST: f64 = 89.99;

/// The direction at a polar angle from the normal and an azimuth from the tangent towards the bitangent, in degrees.
pub fn direction(polar: f64, azimuth: f64) -> DVec3 {
    let (polar, azimuth) = (polar.to_radians(), azimuth.to_radians());
    DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
}

/// The polar angle and the azimuth of a direction, in degrees; the azimuth is from 0 to 360.
pub fn angles(direction: [f32; 3]) -> [f64; 2] {
    let [x, y, z] = direction.map(f64::from);
    let azimuth = if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x).to_degrees().rem_euclid(360.0) };
    [x.hypot(y).atan2(z).to_degrees(), azimuth]
}

/// A pair of directions.
pub fn pair(light: DVec3, view: DVec3) -> DirectionPair {
    DirectionPair { light: light.as_vec3().to_array(), view: view.as_vec3().to_array() }
}

/// The BRDF in 1/sr that a value of a model for a pair means; the value is π · f · cos θ.
pub fn brdf(pair: &DirectionPair, value: [f32; 3]) -> [f64; 3] {
    let cosine = f64::from(pair.light[2]);
    value.map(|component| f64::from(component) / (PI * cosine))
}

/// The luminance of a linear colour, by the primaries of sRGB (ITU-R BT.709).
pub fn luminance([red, green, blue]: [f64; 3]) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// An angle in degrees for people: at most two decimals, and a minus sign.
pub fn angle_text(degrees: f64) -> String {
    let rounded = (100.0 * degrees).round() / 100.0;
    // Not −0.
    format!("{}°", rounded + 0.0).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_for_people_have_two_decimals_at_most() {
        let texts = [30.0, 84.611_396, -2.151_99, -0.001, 89.99].map(angle_text);
        assert_eq!(texts, ["30°", "84.61°", "−2.15°", "0°", "89.99°"]);
    }

    #[test]
    fn angles_and_directions_are_inverse() {
        for (polar, azimuth) in [(0.0, 0.0), (30.0, 45.0), (89.0, 359.0), (60.0, 180.0)] {
            let [found, around] = angles(direction(polar, azimuth).as_vec3().to_array());
            assert!((found - polar).abs() < 1e-4 && (around - azimuth).abs() < 1e-4, "{found} {around}");
        }
        assert!(direction(90.0, 90.0).abs_diff_eq(DVec3::Y, 1e-15));
    }

    #[test]
    fn a_matte_surface_has_the_same_brdf_everywhere() {
        let pair = pair(direction(60.0, 10.0), direction(20.0, 200.0));
        let [red, ..] = brdf(&pair, [0.5 * pair.light[2]; 3]);
        assert!((red - 0.5 / PI).abs() < 1e-9 && (luminance([red; 3]) - red).abs() < 1e-12);
    }
}

//! A clear sky with the sun: A. J. Preetham, P. Shirley, B. Smits, A practical analytic model for daylight, 1999,
//! appendix A.2. The sun is in `sun`.

use crate::environment::RadianceMap;
use crate::environment::presets::{map_of, plain_in_haze, smooth_step, sun};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// How much haze there is; 2 is very clear, and 6 is hazy.
const TURBIDITY: f64 = 2.2;
/// Where the sun is, of any length: in front of the built-in scenes at the left, 41 degrees high.
const TOWARDS_SUN: DVec3 = DVec3::new(-0.75, 0.82, 0.58);
/// The luminance that counts as 1, in kcd/m².
const UNIT: f64 = 33.0;

/// The solid angle of the sun: the paper takes a diameter of 1.39·10⁹ m at a distance of 1.5·10¹¹ m.
const SUN_SOLID_ANGLE: f64 = 0.25 * PI * (1.39 / 150.0) * (1.39 / 150.0);
/// The disc of the sun in the map is larger than the real one, of radius 0.27 degrees, and has the same power.
/// Otherwise it would be smaller than two texels. Its edge is soft between these angles, in degrees.
const DISC: [f64; 2] = [0.7, 1.3];

/// The part of the light that the plain below reflects: dry grass and soil.
const ALBEDO: DVec3 = DVec3::new(0.21, 0.19, 0.15);

/// The coefficients A to E of the distributions of luminance Y and chromaticity x and y, each as a factor of the
/// turbidity and a constant.
const DISTRIBUTIONS: [[[f64; 2]; 5]; 3] = [
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
];

/// The chromaticities x and y of the zenith: for T², T and 1, the factors of θ³, θ², θ and 1, where θ is the zenith
/// angle of the sun.
const ZENITH: [[[f64; 4]; 3]; 2] = [
    [[0.00166, -0.00375, 0.00209, 0.0], [-0.02903, 0.06377, -0.03202, 0.00394], [0.11693, -0.21196, 0.06052, 0.25886]],
    [[0.00275, -0.00610, 0.00317, 0.0], [-0.04214, 0.08970, -0.04153, 0.00516], [0.15346, -0.26756, 0.06670, 0.26688]],
];

/// Linear sRGB of CIE XYZ (IEC 61966-2-1). Colours that are beyond sRGB are cut off.
fn rgb(xyz: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = xyz;
    let red = 3.2406 * x - 1.5372 * y - 0.4986 * z;
    let green = -0.9689 * x + 1.8758 * y + 0.0415 * z;
    let blue = 0.0557 * x - 0.2040 * y + 1.0570 * z;
    DVec3::new(red, green, blue).max(DVec3::ZERO)
}

/// The distribution of R. Perez, R. Seals and J. Michalsky, 1993, by the cosine of the zenith angle of a direction, and
/// its angle to the sun with the cosine.
fn perez([a, b, c, d, e]: [f64; 5], cosine: f64, (to_sun, near_sun): (f64, f64)) -> f64 {
    (1.0 + a * (b / cosine).exp()) * (1.0 + c * (d * to_sun).exp() + e * near_sun * near_sun)
}

/// A sky for a place of the sun.
struct ClearSky {
    /// Towards the sun, of unit length.
    sun: DVec3,
    coefficients: [[f64; 5]; 3],
    /// What the distributions are multiplied by, for Y in kcd/m², x and y.
    factors: [f64; 3],
    turbidity: f64,
}

impl ClearSky {
    fn new(sun: DVec3, turbidity: f64) -> Self {
        let coefficients = DISTRIBUTIONS.map(|rows| rows.map(|[factor, constant]| factor * turbidity + constant));
        let angle = sun.y.clamp(-1.0, 1.0).acos();
        let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * angle);
        let luminance = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
        let cubic = |[a, b, c, d]: [f64; 4]| ((a * angle + b) * angle + c) * angle + d;
        let [x, y] =
            ZENITH.map(|[square, linear, constant]| (cubic(square) * turbidity + cubic(linear)) * turbidity + cubic(constant));
        let mut factors = [luminance, x, y];
        for (factor, coefficients) in factors.iter_mut().zip(coefficients) {
            *factor /= perez(coefficients, 1.0, (angle, sun.y));
        }
        Self { sun, coefficients, factors, turbidity }
    }

    /// Luminance in kcd/m² and chromaticity x, y of the sky in a direction of unit length, without the sun. Below the
    /// horizon it is that of the horizon.
    fn luminance(&self, direction: DVec3) -> [f64; 3] {
        let cosine = direction.y.max(1e-3);
        let near_sun = direction.dot(self.sun).clamp(-1.0, 1.0);
        let to_sun = (near_sun.acos(), near_sun);
        [0, 1, 2].map(|index| self.factors[index] * perez(self.coefficients[index], cosine, to_sun))
    }

    /// The radiance of the sky, linear RGB, without the sun.
    fn radiance(&self, direction: DVec3) -> DVec3 {
        let [luminance, x, y] = self.luminance(direction);
        let sum = luminance / (y * UNIT);
        rgb(sum * DVec3::new(x, y, 1.0 - x - y))
    }

    /// The irradiance of a plane that faces the sun, by the sun alone.
    fn of_sun(&self) -> DVec3 {
        let zenith = self.sun.y.clamp(-1.0, 1.0).acos();
        rgb(sun::radiance(zenith, self.turbidity) * SUN_SOLID_ANGLE / UNIT)
    }

    /// The irradiance of the plain by the sky alone: a sum over equal parts of the projected hemisphere.
    fn of_sky(&self) -> DVec3 {
        const STEPS: u32 = 48;
        let mut total = DVec3::ZERO;
        for (row, column) in (0..STEPS).flat_map(|row| (0..STEPS).map(move |column| (row, column))) {
            let share = (f64::from(row) + 0.5) / f64::from(STEPS);
            let (sine, cosine) = (TAU * (f64::from(column) + 0.5) / f64::from(STEPS)).sin_cos();
            let radius = share.sqrt();
            let radiance = self.radiance(DVec3::new(radius * sine, (1.0 - share).sqrt(), radius * cosine));
            total += radiance;
        }
        total * PI / f64::from(STEPS * STEPS)
    }
}

/// How much of the disc of the sun a direction shows whose cosine of the angle to the sun this is.
fn in_disc(cosine: f64) -> f64 {
    smooth_step(DISC[1].to_radians().cos(), DISC[0].to_radians().cos(), cosine)
}

/// The solid angle of the disc of the map, weighted by what it shows. For a smooth step of the cosine it is that of the
/// middle, because the step is symmetric and the solid angle of a cap is 2π times its height.
fn disc_solid_angle() -> f64 {
    let [inner, outer] = DISC.map(|angle| 1.0 - angle.to_radians().cos());
    TAU * 0.5 * (inner + outer)
}

/// The map.
pub(super) fn map() -> RadianceMap {
    let sky = ClearSky::new(TOWARDS_SUN.normalize(), TURBIDITY);
    let of_sun = sky.of_sun();
    let disc = of_sun / disc_solid_angle();
    let plain = ALBEDO * (sky.sun.y * of_sun + sky.of_sky()) / PI;
    map_of(|direction| {
        let radiance = sky.radiance(direction);
        if direction.y < 0.0 {
            return plain_in_haze(direction, radiance, plain);
        }
        radiance + in_disc(direction.dot(sky.sun)) * disc
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// The sun at a zenith angle in degrees.
    fn sky(zenith: f64, turbidity: f64) -> ClearSky {
        let (sine, cosine) = zenith.to_radians().sin_cos();
        ClearSky::new(DVec3::new(0.0, cosine, sine), turbidity)
    }

    #[test]
    fn the_zenith_has_the_luminance_and_colour_of_the_paper() {
        // By hand, for T = 2 and the sun at a zenith angle of 60°: χ = (4/9 − 2/120)·(π − 2π/3) = 0.447968,
        // tan χ = 0.480551, (8.0906 − 4.9710)·tan χ − 0.4310 + 2.4192 = 3.487327.
        let [luminance, x, y] = sky(60.0, 2.0).luminance(DVec3::Y);
        assert!((luminance - 3.487_327).abs() < 1e-5, "{luminance}");
        // θ = 1.047198: the polynomials of x and y.
        assert!((x - 0.238_013).abs() < 1e-5 && (y - 0.241_988).abs() < 1e-5, "{x} {y}");
    }

    #[test]
    fn the_sky_is_blue_and_brighter_at_the_horizon_and_around_the_sun() {
        let sky = sky(50.0, 2.2);
        let [zenith, horizon, beside] = [DVec3::new(0.0, 1.0, -0.2), DVec3::new(1.0, 0.05, 0.0), sky.sun]
            .map(|direction| sky.radiance(direction.normalize()));
        let ratio = |colour: DVec3| colour.z / colour.x;
        assert!(ratio(zenith) > 2.0 && ratio(horizon) < ratio(zenith), "{zenith:?} {horizon:?}");
        assert!(horizon.y > 1.5 * zenith.y && beside.y > 2.0 * zenith.y, "{beside} {zenith}");
        // On a clear day, with the sun 40 degrees high, a plain has 60 to 80 klx, most of it by the sun.
        let klx = |irradiance: DVec3| UNIT * irradiance.dot(DVec3::new(0.2126, 0.7152, 0.0722));
        let [of_sky, of_sun] = [klx(sky.of_sky()), sky.sun.y * klx(sky.of_sun())];
        assert!((60.0..80.0).contains(&(of_sky + of_sun)) && of_sun > 1.8 * of_sky, "{of_sky} {of_sun}");
    }

    #[test]
    fn the_disc_has_the_power_of_the_sun() {
        let map = map();
        let sun = TOWARDS_SUN.normalize();
        let sky = ClearSky::new(sun, TURBIDITY);
        let seen = |direction: DVec3| Vec3::from(map.radiance(direction)).as_dvec3();
        let (right, up) = (sun.cross(DVec3::Y).normalize(), sun.cross(DVec3::Y).normalize().cross(sun));
        let (steps, side) = (200, 0.1);
        let mut found = DVec3::ZERO;
        for (x, y) in (0..steps).flat_map(|x| (0..steps).map(move |y| (x, y))) {
            let [x, y] = [x, y].map(|step| side * ((f64::from(step) + 0.5) / f64::from(steps) - 0.5));
            let direction = (sun + x * right + y * up).normalize();
            // The part of the plane that a direction sees has this solid angle.
            let part = side * side / f64::from(steps * steps) * direction.dot(sun).powi(3);
            found += part * (seen(direction) - sky.radiance(direction));
        }
        assert!((found / sky.of_sun() - 1.0).abs().max_element() < 0.02, "{found} {}", sky.of_sun());
        // Its middle is as bright as a disc of radius 1.04 degrees.
        let radius = (0.5 * (DISC[0] * DISC[0] + DISC[1] * DISC[1])).sqrt().to_radians();
        let middle = sky.of_sun() / (PI * radius * radius);
        let brightest = seen(sun) - sky.radiance(sun);
        assert!((brightest.y / middle.y - 1.0).abs() < 0.05, "{brightest} {middle}");
    }
}

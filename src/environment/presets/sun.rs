//! The sun through a clear atmosphere: A. J. Preetham, P. Shirley, B. Smits, A practical analytic model for daylight,
//! 1999, appendix A.1 and table 2.

use glam::DVec3;

/// The wavelengths of the table, in nanometres: from this one on, every ten.
const FIRST: f64 = 380.0;

/// Table 2: the spectral radiance of the sun above the atmosphere, in 100 W/(m²·nm·sr), and the coefficients of
/// absorption of ozone and of water vapour per centimetre. Mixed gases absorb nothing at these wavelengths.
const TABLE: [[f64; 3]; 38] = [
    [165.5, 0.0, 0.0],
    [162.3, 0.0, 0.0],
    [211.2, 0.0, 0.0],
    [258.8, 0.0, 0.0],
    [258.2, 0.0, 0.0],
    [242.3, 0.0, 0.0],
    [267.6, 0.0, 0.0],
    [296.6, 0.003, 0.0],
    [305.4, 0.006, 0.0],
    [300.6, 0.009, 0.0],
    [306.6, 0.014, 0.0],
    [288.3, 0.021, 0.0],
    [287.1, 0.030, 0.0],
    [278.2, 0.040, 0.0],
    [271.0, 0.048, 0.0],
    [272.3, 0.063, 0.0],
    [263.6, 0.075, 0.0],
    [255.0, 0.085, 0.0],
    [250.6, 0.103, 0.0],
    [253.1, 0.120, 0.0],
    [253.5, 0.120, 0.0],
    [251.3, 0.115, 0.0],
    [246.3, 0.125, 0.0],
    [241.7, 0.120, 0.0],
    [236.8, 0.105, 0.0],
    [232.1, 0.090, 0.0],
    [228.2, 0.079, 0.0],
    [223.4, 0.067, 0.0],
    [219.7, 0.057, 0.0],
    [215.3, 0.048, 0.0],
    [211.0, 0.036, 0.0],
    [207.3, 0.028, 0.016],
    [202.4, 0.023, 0.024],
    [198.7, 0.018, 0.0125],
    [194.3, 0.014, 1.0],
    [190.7, 0.011, 0.87],
    [186.3, 0.010, 0.061],
    [182.6, 0.009, 0.001],
];

/// The ozone of the atmosphere and the water in it, as layers of this many centimetres.
const OZONE: f64 = 0.35;
const WATER: f64 = 2.0;

/// The part of the light of a wavelength in micrometres that reaches the surface of the Earth; `mass` is the relative
/// optical mass of the air.
fn transmittance(wavelength: f64, [_, ozone, water]: [f64; 3], mass: f64, turbidity: f64) -> f64 {
    let rayleigh = 0.008_735 * wavelength.powf(-4.08) * mass;
    let aerosols = (0.046_08 * turbidity - 0.045_86) * wavelength.powf(-1.3) * mass;
    let vapour = 0.2385 * water * WATER * mass / (1.0 + 20.07 * water * WATER * mass).powf(0.45);
    (-(rayleigh + aerosols + ozone * OZONE * mass + vapour)).exp()
}

/// The colour matching functions of the CIE 1931 observer at a wavelength in nanometres: C. Wyman, P.-P. Sloan,
/// P. Shirley, Simple analytic approximations to the CIE XYZ color matching functions, 2013, equation 4 (multi-lobe).
fn observer(wavelength: f64) -> DVec3 {
    let lobe = |peak: f64, below: f64, above: f64| {
        let distance = (wavelength - peak) / if wavelength < peak { below } else { above };
        (-0.5 * distance * distance).exp()
    };
    DVec3::new(
        1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
        0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
        1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8),
    )
}

/// The radiance of the disc of the sun at a zenith angle in radians, as CIE XYZ in kcd/m².
pub(super) fn radiance(zenith: f64, turbidity: f64) -> DVec3 {
    /// Lumens of a watt at a wavelength of 555 nm, in thousands; and the step of the table.
    const SCALE: f64 = 0.683 * 10.0;
    let mass = 1.0 / (zenith.cos() + 0.15 * (93.885 - zenith.to_degrees()).powf(-1.253));
    let mut total = DVec3::ZERO;
    for (index, row) in TABLE.into_iter().enumerate() {
        let wavelength = FIRST + 10.0 * index as f64;
        let radiance = 100.0 * row[0] * transmittance(wavelength / 1000.0, row, mass, turbidity);
        total += SCALE * radiance * observer(wavelength);
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_is_as_bright_as_it_is() {
        // Without an atmosphere: the solar illuminance constant is 128 to 134 klx (IES: 127.5), and the disc of
        // diameter 0.533° has 6.8e-5 sr.
        let above: f64 =
            TABLE.iter().enumerate().map(|(index, row)| 6.83e2 * row[0] * observer(380.0 + 10.0 * index as f64).y).sum();
        let klx = 6.8e-5 * above;
        assert!((120.0..140.0).contains(&klx), "{klx}");
        // High in a clear sky, direct sunlight has 80 to 110 klx. Low, it is weaker and redder.
        let [high, low] = [20.0_f64, 80.0].map(|zenith| radiance(zenith.to_radians(), 2.5));
        let klx = 6.8e-5 * high.y;
        assert!((80.0..110.0).contains(&klx), "{klx}");
        assert!(low.y < 0.5 * high.y && low.x / low.z > 1.5 * high.x / high.z, "{low:?} {high:?}");
    }

    #[test]
    fn the_observer_is_that_of_the_cie() {
        // Tables of CIE 1931, 2°: ȳ(555) = 1.0000, x̄(600) = 1.0622, z̄(450) = 1.7721.
        assert!((observer(555.0).y - 1.0).abs() < 0.02);
        assert!((observer(600.0).x - 1.0622).abs() < 0.02);
        assert!((observer(450.0).z - 1.7721).abs() < 0.03);
    }
}

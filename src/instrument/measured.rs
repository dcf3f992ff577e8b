//! A measured material as a [`Reflectance`].

use crate::instrument::{DirectionPair, Reflectance};
use crate::measured::MeasuredMaterial;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

impl Reflectance for MeasuredMaterial {
    fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]> {
        let value = |pair: &DirectionPair| {
            let [light, view] = [pair.light, pair.view].map(|direction| Vec3::from(direction).as_dvec3().normalize_or_zero());
            (PI * light.z.max(0.0) * self.value(light, view)).max(DVec3::ZERO).as_vec3().to_array()
        };
        pairs.par_iter().with_min_len(256).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::direction::{direction, pair};
    use crate::measured::{Measurement, merl};

    #[test]
    fn a_measured_matte_surface_has_the_value_of_one() {
        let bytes = merl::bytes(|_, _| DVec3::new(0.6, 0.3, 0.1) / PI);
        let Measurement::Material(material) = Measurement::of_bytes("matte.binary", &bytes).unwrap() else { panic!("samples") };
        let pair = pair(direction(40.0, 10.0), direction(25.0, 200.0));
        for (found, wanted) in material.values(&[pair])[0].into_iter().zip([0.6, 0.3, 0.1]) {
            assert!((f64::from(found) - wanted * 40_f64.to_radians().cos()).abs() < 1e-5, "{found}");
        }
    }
}

//! A measured material as a [`Reflectance`].

use crate::instrument::{DirectionPair, Reflectance};
use crate::measured::MeasuredMaterial;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// How many pairs a thread takes together.
const TOGETHER: usize = 256;

impl Reflectance for MeasuredMaterial {
    fn values(&self, pairs: &[DirectionPair]) -> Vec<[f32; 3]> {
        let unit = |direction: [f32; 3]| Vec3::from(direction).as_dvec3().normalize_or_zero();
        // An integral over lights has one view.
        let of_view = |pairs: &[DirectionPair], values: &mut [[f32; 3]]| {
            let seen = self.seen_from(unit(pairs[0].view));
            for (pair, value) in pairs.iter().zip(values) {
                let light = unit(pair.light);
                *value = (PI * light.z.max(0.0) * seen.value(light)).max(DVec3::ZERO).as_vec3().to_array();
            }
        };
        let mut values = vec![[0.0; 3]; pairs.len()];
        pairs.par_chunks(TOGETHER).zip(values.par_chunks_mut(TOGETHER)).for_each(|(pairs, mut values)| {
            for pairs in pairs.chunk_by(|one, other| one.view == other.view) {
                let (of_pairs, rest) = values.split_at_mut(pairs.len());
                of_view(pairs, of_pairs);
                values = rest;
            }
        });
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::direction::{direction, pair};
    use crate::measured::{Measurement, merl};

    #[test]
    fn values_of_many_pairs_are_those_of_each() {
        let bytes = merl::bytes(|light, view| DVec3::new(light.dot(view), 0.5, (light + view).z));
        let Measurement::Material(material) = Measurement::of_bytes("any.binary", &bytes).unwrap() else { panic!("samples") };
        // Runs of one view, and views that differ.
        let view = |index: usize| if index < 300 { 40.0 } else { (index / (index % 3 + 1)) as f64 * 0.1 };
        let pairs: Vec<DirectionPair> =
            (0..700).map(|index| pair(direction(0.11 * index as f64, 10.0), direction(view(index), 200.0))).collect();
        let alone: Vec<[f32; 3]> = pairs.iter().map(|pair| material.values(&[*pair])[0]).collect();
        assert_eq!(material.values(&pairs), alone);
        assert!(alone.windows(2).filter(|both| both[0] != both[1]).count() > 300);
    }

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

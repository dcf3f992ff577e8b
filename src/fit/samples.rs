//! The misfit of a formula to reflectance at pairs of directions.

use crate::fit::Misfit;
use crate::fit::directions::{WeightedPair, pairs};
use crate::fit::metric::Metric;
use crate::fit::normal::NormalEquations;
use crate::fit::unknowns::FitNumber;
use crate::formula::{Formula, ParameterId};
use crate::instrument::model::{ModelProgram, ParameterNumbers, Place, PreparedPairs};
use crate::instrument::{DirectionPair, Reflectance};
use crate::measured::MeasuredMaterial;
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// What was measured at a pair of directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitSample {
    /// The directions.
    pub pair: DirectionPair,
    /// f · cos θ of the light, in 1/sr, linear RGB.
    pub value: [f64; 3],
    /// What the sample counts.
    pub weight: f64,
}

/// Samples of a model, at this many pairs of directions within `largest` degrees of the normal.
pub fn samples_of(model: &dyn Reflectance, count: usize, largest: f64) -> Vec<FitSample> {
    at_pairs(model, &pairs(count, largest))
}

/// Samples of a measured material, at about this many pairs of directions within `largest` degrees of the normal. If it
/// is a table, they are entries of the table, so that nothing is interpolated.
pub fn samples_of_material(material: &MeasuredMaterial, count: usize, largest: f64) -> Vec<FitSample> {
    let limit = largest.to_radians().cos();
    let entry = |weighted: &WeightedPair| {
        let [light, view] = [weighted.pair.light, weighted.pair.view].map(|direction| Vec3::from(direction).as_dvec3());
        let [light, view] = material.nearest_sample(light, view).unwrap_or([light, view]);
        let pair = DirectionPair { light: light.as_vec3().to_array(), view: view.as_vec3().to_array() };
        (light.z >= limit && view.z >= limit).then_some(WeightedPair { pair, ..*weighted })
    };
    let entries: Vec<WeightedPair> = pairs(count, largest).iter().filter_map(entry).collect();
    at_pairs(material, &entries)
}

fn at_pairs(model: &dyn Reflectance, pairs: &[WeightedPair]) -> Vec<FitSample> {
    let plain: Vec<DirectionPair> = pairs.iter().map(|weighted| weighted.pair).collect();
    let values = model.values(&plain);
    let sample = |(weighted, value): (&WeightedPair, &[f32; 3])| FitSample {
        pair: weighted.pair,
        value: value.map(|component| f64::from(component) / PI),
        weight: weighted.weight,
    };
    pairs.iter().zip(&values).map(sample).collect()
}

/// A formula that is compared with samples.
pub struct SampleMisfit {
    program: ModelProgram,
    pairs: PreparedPairs,
    /// The values of all parameters; the unknown ones are replaced.
    numbers: ParameterNumbers,
    unknowns: Vec<FitNumber>,
    metric: Metric,
    /// The samples by the metric, and their weights.
    wanted: Vec<([f64; 3], f64)>,
}

/// Samples that a thread takes at once. Sums are taken in this order on any number of threads.
const AT_ONCE: usize = 2048;

impl SampleMisfit {
    /// A formula with these numbers at a place, compared with samples. The unknown numbers are given at each
    /// evaluation.
    pub fn new(
        formula: &Formula,
        numbers: ParameterNumbers,
        place: &Place,
        unknowns: Vec<FitNumber>,
        samples: &[FitSample],
        metric: Metric,
    ) -> Self {
        let by: Vec<(ParameterId, u8)> = unknowns.iter().map(|number| (number.parameter, number.component)).collect();
        let program = ModelProgram::with_derivatives(formula, &by);
        let pairs: Vec<DirectionPair> = samples.iter().map(|sample| sample.pair).collect();
        let pairs = program.prepare(&pairs, place);
        let wanted = samples.iter().map(|sample| (sample.value.map(|value| metric.apply(value)[0]), sample.weight)).collect();
        Self { program, pairs, numbers, unknowns, metric, wanted }
    }

    /// The numbers of all parameters where the unknown ones have these values.
    pub fn numbers(&self, values: &[f64]) -> ParameterNumbers {
        let mut numbers = self.numbers.clone();
        for (number, value) in self.unknowns.iter().zip(values) {
            let target = &mut numbers[number.parameter.0 as usize];
            target[usize::from(number.component)] = *value as f32;
        }
        numbers
    }

    /// At how many samples the formula is no finite number.
    pub fn undefined(&self, values: &[f64]) -> usize {
        let found = self.program.run(&self.pairs, &self.numbers(values));
        found.chunks_exact(self.program.outputs()).filter(|found| !found[..3].iter().all(|value| value.is_finite())).count()
    }
}

impl Misfit for SampleMisfit {
    /// Where the formula is no number, it counts as 0, so that such values are not taken for good ones.
    fn evaluate_into(&self, values: &[f64], none: &NormalEquations) -> NormalEquations {
        let found = self.program.run(&self.pairs, &self.numbers(values));
        let (outputs, unknowns) = (self.program.outputs(), self.unknowns.len());
        let part = |(found, wanted): (&[f32], &[([f64; 3], f64)])| {
            let mut equations = none.clone();
            let mut row = vec![0.0; unknowns + 1];
            for (found, (wanted, weight)) in found.chunks_exact(outputs).zip(wanted) {
                for (component, wanted) in wanted.iter().enumerate() {
                    let value = f64::from(found[component]) / PI;
                    let defined = value.is_finite();
                    let [value, slope] = self.metric.apply(if defined { value } else { 0.0 });
                    for (index, entry) in row[..unknowns].iter_mut().enumerate() {
                        let change = f64::from(found[3 + 3 * index + component]) / PI * slope;
                        *entry = if defined && change.is_finite() { change } else { 0.0 };
                    }
                    row[unknowns] = value - wanted;
                    equations.add(*weight, &row);
                }
                equations.count(3, 3.0 * weight);
            }
            equations
        };
        let parts: Vec<NormalEquations> =
            found.par_chunks(AT_ONCE * outputs).zip(self.wanted.par_chunks(AT_ONCE)).map(part).collect();
        parts.iter().fold(none.clone(), NormalEquations::join)
    }
}

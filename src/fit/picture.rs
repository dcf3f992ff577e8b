//! The misfit of the picture of a formula on a scene to another picture of the same scene.

use crate::fit::Misfit;
use crate::fit::metric::Metric;
use crate::fit::normal::NormalEquations;
use crate::picture::Frame;
use crate::sensitivity::Sensitivity;
use rayon::prelude::*;

/// A picture that is to be reached.
#[derive(Debug, Clone, PartialEq)]
pub struct TargetPicture {
    /// Linear RGB, of the size of the picture that is fitted.
    pub frame: Frame,
    /// Where colours end, as in a file with bytes: what is brighter looks the same. `None`: nowhere.
    pub end: Option<f32>,
}

/// A picture that is compared with another.
pub struct PictureMisfit {
    sensitivity: Sensitivity,
    /// All parameter numbers; the unknown ones are replaced.
    numbers: Vec<f32>,
    /// The indices of the unknown numbers.
    unknowns: Vec<usize>,
    target: TargetPicture,
    metric: Metric,
}

/// Pixels that a thread takes at once. Sums are taken in this order on any number of threads.
const AT_ONCE: usize = 8192;

impl PictureMisfit {
    /// The picture of these parameter numbers, compared with a target. `unknowns` are the indices of the numbers that
    /// are given at each evaluation.
    pub fn new(sensitivity: Sensitivity, numbers: Vec<f32>, unknowns: Vec<usize>, target: TargetPicture, metric: Metric) -> Self {
        Self { sensitivity, numbers, unknowns, target, metric }
    }

    /// All parameter numbers where the unknown ones have these values.
    pub fn numbers(&self, values: &[f64]) -> Vec<f32> {
        let mut numbers = self.numbers.clone();
        self.unknowns.iter().zip(values).for_each(|(index, value)| numbers[*index] = *value as f32);
        numbers
    }

    /// The picture at these values.
    pub fn picture(&self, values: &[f64]) -> Frame {
        self.sensitivity.picture(&self.numbers(values))
    }

    /// Adds the residual of each component of some pixels that begin at `first`.
    fn add(&self, equations: &mut NormalEquations, first: usize, pixels: &[[f32; 3]], changes: &[Frame]) {
        let unknowns = self.unknowns.len();
        let mut row = vec![0.0; unknowns + 1];
        for (index, colour) in pixels.iter().enumerate() {
            let wanted = self.target.frame.linear[first + index];
            for (component, (value, wanted)) in colour.iter().zip(wanted).enumerate() {
                if !wanted.is_finite() {
                    continue;
                }
                equations.count(1, 1.0);
                let defined = value.is_finite();
                let beyond = self.target.end.is_some_and(|end| *value > end);
                let shown = match self.target.end {
                    Some(end) if beyond => end,
                    Some(_) | None if defined => *value,
                    Some(_) | None => 0.0,
                };
                let [found, slope] = self.metric.apply(f64::from(shown));
                for (entry, change) in row[..unknowns].iter_mut().zip(changes) {
                    let change = f64::from(change.linear[first + index][component]) * slope;
                    *entry = if defined && !beyond && change.is_finite() { change } else { 0.0 };
                }
                row[unknowns] = found - self.metric.apply(f64::from(wanted))[0];
                equations.add(1.0, &row);
            }
        }
    }
}

impl Misfit for PictureMisfit {
    fn evaluate_into(&self, values: &[f64], none: &NormalEquations) -> NormalEquations {
        let numbers = self.numbers(values);
        let picture = self.sensitivity.picture(&numbers);
        let one = |index: &usize| self.sensitivity.change(&numbers, &[(*index, 1.0)]);
        let changes: Vec<Frame> = self.unknowns.iter().map(one).collect();
        let part = |(index, pixels): (usize, &[[f32; 3]])| {
            let mut equations = none.clone();
            self.add(&mut equations, index * AT_ONCE, pixels, &changes);
            equations
        };
        let parts: Vec<NormalEquations> = picture.linear.par_chunks(AT_ONCE).enumerate().map(part).collect();
        parts.iter().fold(none.clone(), NormalEquations::join)
    }
}

//! What data say of each number: how exact it is, and whether it is determined at all.

use crate::fit::Misfit;
use crate::fit::normal::NormalEquations;
use crate::fit::unknowns::{FitNumber, Unknowns};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Directions of less curvature, with all numbers scaled alike, are flat.
const FLAT: f64 = 1e-9;

/// How exact the free numbers are.
#[derive(Debug, Clone, Default)]
pub(super) struct Certainty {
    /// Their standard deviations; `None` if they are not determined.
    pub(super) deviations: Vec<Option<f64>>,
    /// Groups of numbers that are determined only together, or, alone in a group, not at all.
    pub(super) undetermined: Vec<Vec<FitNumber>>,
}

impl Certainty {
    /// From the equations at a solution, with their scatter, in terms of all numbers.
    ///
    /// The covariance is that of White (1980): K⁺·S·K⁺ with the curvature K = JᵀJ and the scatter S. It holds too if
    /// the noise of some data is larger than that of others.
    pub(super) fn new(unknowns: &Unknowns, equations: &NormalEquations) -> Self {
        let (numbers, moving, slopes) = (unknowns.numbers(), unknowns.moving(), unknowns.slopes());
        let own = equations.in_terms_of(&slopes);
        let curvature = own.curvature();
        let has_effect = effects(unknowns, &own);
        let alone = (0..moving.len()).filter(|column| !has_effect[*column]).map(|column| vec![numbers[moving[column]]]);
        let mut result = Self { deviations: vec![None; unknowns.free()], undetermined: alone.collect() };
        let others: Vec<usize> = (0..moving.len()).filter(|column| has_effect[*column]).collect();
        let scale: Vec<f64> = others.iter().map(|column| curvature[(*column, *column)].sqrt()).collect();
        let scaled = |matrix: &DMatrix<f64>| {
            DMatrix::from_fn(others.len(), others.len(), |row, column| {
                matrix[(others[row], others[column])] / (scale[row] * scale[column])
            })
        };
        let curvature = scaled(&curvature);
        if others.is_empty() || curvature.iter().any(|value| !value.is_finite()) {
            return result;
        }
        let eigen = SymmetricEigen::new(curvature);
        let part = |is_part: &dyn Fn(f64) -> bool, weight: &dyn Fn(f64) -> f64| {
            let columns = (0..others.len()).filter(|column| is_part(eigen.eigenvalues[*column]));
            let product = |column: usize| {
                let vector = eigen.eigenvectors.column(column);
                vector * vector.transpose() * weight(eigen.eigenvalues[column])
            };
            columns.map(product).fold(DMatrix::zeros(others.len(), others.len()), |sum, product| sum + product)
        };
        let flat = part(&|value| value < FLAT, &|_| 1.0);
        let blocks = blocks(&flat);
        let is_flat = |row: usize| blocks.iter().any(|block| block.contains(&row));
        let name = |row: &usize| numbers[moving[others[*row]]];
        result.undetermined.extend(blocks.iter().map(|block| block.iter().map(name).collect()));
        let Some(scatter) = own.scatter() else { return result };
        let inverse = part(&|value| value >= FLAT, &f64::recip);
        let covariance = &inverse * scaled(&scatter) * &inverse;
        for (index, deviation) in result.deviations.iter_mut().enumerate() {
            let row = slopes.row(index);
            let depends = |column: usize| row[column] != 0.0;
            let is_known = (0..others.len()).all(|at| !depends(others[at]) || !is_flat(at))
                && (0..moving.len()).all(|column| !depends(column) || has_effect[column]);
            let change = DVector::from_iterator(others.len(), (0..others.len()).map(|at| row[others[at]] / scale[at]));
            if is_known && change.iter().any(|slope| *slope != 0.0) {
                let own = (&covariance * &change).dot(&change).max(0.0).sqrt();
                // Where it may be anywhere in its range, nothing is known of it.
                *deviation = Some(own).filter(|deviation| *deviation < unknowns.width(index));
            }
        }
        result
    }
}

/// Whether each number that has a variable has an effect, from equations in terms of these.
fn effects(unknowns: &Unknowns, own: &NormalEquations) -> Vec<bool> {
    let curvature = own.curvature();
    let effect = |(column, at): (usize, &usize)| curvature[(column, column)].sqrt() * unknowns.width(*at);
    let effects: Vec<f64> = unknowns.moving().iter().enumerate().map(effect).collect();
    let largest = effects.iter().copied().fold(0.0, f64::max);
    effects.iter().map(|effect| *effect > FLAT * largest).collect()
}

/// The groups of numbers that belong together in a flat space, from the projection onto it.
fn blocks(projection: &DMatrix<f64>) -> Vec<Vec<usize>> {
    /// The smallest part of a number in the space that counts.
    const PART: f64 = 1e-3;
    /// Numbers whose parts have less in common are independent: what is left is rounding.
    const COMMON: f64 = 1e-2;
    let part = |row: usize| projection[(row, row)].max(0.0).sqrt();
    let mut left: Vec<usize> = (0..projection.nrows()).filter(|row| part(*row) > PART).collect();
    let mut blocks = Vec::new();
    while !left.is_empty() {
        let mut block = vec![left.remove(0)];
        let mut next = 0;
        while next < block.len() {
            let from = block[next];
            let is_near = |row: &usize| projection[(from, *row)].abs() > COMMON * part(from) * part(*row);
            block.extend(left.iter().copied().filter(is_near));
            left.retain(|row| !block.contains(row));
            next += 1;
        }
        block.sort_unstable();
        blocks.push(block);
    }
    blocks
}

/// Values that are put in another place wherever that makes the misfit no larger.
pub(super) struct Placing<'p> {
    pub(super) misfit: &'p dyn Misfit,
    pub(super) unknowns: &'p Unknowns,
    /// A difference of squares that is nothing but rounding.
    pub(super) rounding: f64,
}

impl Placing<'_> {
    /// Puts numbers that are near a bound there, so that it shows what has no effect there.
    pub(super) fn at_bounds(&self, values: &mut Vec<f64>) {
        for index in 0..self.unknowns.free() {
            if let Some(end) = self.unknowns.bound_at(index, values[index]) {
                let place = self.unknowns.ends(index, values[index])[end];
                self.place(values, index, place);
            }
        }
    }

    /// Puts numbers without an effect where they were at the start.
    pub(super) fn at_start(&self, values: &mut Vec<f64>, undetermined: &[Vec<FitNumber>]) {
        let (start, numbers) = (self.unknowns.start(), self.unknowns.numbers());
        for index in 0..self.unknowns.free() {
            if undetermined.iter().any(|group| *group == [numbers[index]]) {
                self.place(values, index, start[index]);
            }
        }
    }

    fn place(&self, values: &mut Vec<f64>, index: usize, place: f64) {
        /// How much larger a square is that is taken for the same.
        const SAME: f64 = 1e-6;
        let mut moved = values.clone();
        moved[index] = place;
        let moved = self.unknowns.settled(&moved);
        if moved == *values {
            return;
        }
        let [here, there] = [&*values, &moved].map(|values| self.misfit.evaluate(values));
        if there.is_finite() && there.square() <= (1.0 + SAME) * here.square() + self.rounding {
            *values = moved;
        }
    }

    /// Of the numbers without an effect at these values, those that have an effect in steps over their range, and
    /// those that have a smooth one elsewhere.
    pub(super) fn lone_effects(&self, values: &[f64], undetermined: &[Vec<FitNumber>]) -> [Vec<FitNumber>; 2] {
        /// Where in its range a number is tried.
        const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
        let numbers = self.unknowns.numbers();
        let here = self.misfit.evaluate(values).square();
        let [mut stepwise, mut elsewhere] = [Vec::new(), Vec::new()];
        for (column, index) in self.unknowns.moving().iter().enumerate() {
            let number = numbers[*index];
            if !undetermined.iter().any(|group| *group == [number]) {
                continue;
            }
            let [low, high] = self.unknowns.ends(*index, values[*index]);
            let (mut is_smooth, mut has_steps) = (false, false);
            for share in SHARES {
                // Beyond invariants too: other numbers that give way would have an effect of their own.
                let mut moved = values[..self.unknowns.free()].to_vec();
                moved[*index] = low + share * (high - low);
                let there = self.misfit.evaluate(&self.unknowns.with_followers(moved));
                is_smooth |= effects(self.unknowns, &there.in_terms_of(&self.unknowns.slopes()))[column];
                has_steps |= (there.square() - here).abs() > 1e-9 * here.max(there.square()) + self.rounding;
            }
            if is_smooth {
                elsewhere.push(number);
            } else if has_steps {
                stepwise.push(number);
            }
        }
        [stepwise, elsewhere]
    }
}

//! The minimum of a misfit by the method of Levenberg (1944) and Marquardt (1963), from several starts.

use crate::fit::Misfit;
use crate::fit::normal::NormalEquations;
use crate::fit::unknowns::{FitNumber, Unknowns};
use crate::sampling::EvenSequence;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};
use std::cell::{Cell, RefCell};
use std::sync::atomic::{AtomicBool, Ordering};

/// How a fit is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FitOptions {
    /// How many starts there are: the values at hand, and others spread over the ranges. At least 1.
    pub starts: u32,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { starts: 8 }
    }
}

/// How far a fit is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitProgress {
    /// The share of the work that is done, 0..=1: an estimate.
    pub share: f64,
    /// The smallest root mean square of residuals so far.
    pub residual: f64,
}

/// What a start led to.
#[derive(Debug, Clone, PartialEq)]
pub struct StartOutcome {
    /// The values at its end.
    pub values: Vec<f64>,
    /// The root mean square of residuals there.
    pub residual: f64,
    /// How often the misfit was evaluated.
    pub evaluations: usize,
}

/// The result of a fit. Values are in the order of [`Unknowns::numbers`].
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The values that fit best.
    pub values: Vec<f64>,
    /// The root mean square of residuals before and after.
    pub residuals: [f64; 2],
    /// How exact each free value is: its standard deviation, if the residuals are noise. `None` for numbers that the
    /// data do not determine.
    pub deviations: Vec<Option<f64>>,
    /// Groups of free numbers that the data determine only together, or, alone in a group, not at all.
    pub undetermined: Vec<Vec<FitNumber>>,
    /// Those of [`undetermined`](Self::undetermined) that have an effect in steps, such as thresholds. Their derivative
    /// is 0, so they did not move.
    pub stepwise: Vec<FitNumber>,
    /// The outcome of each start, in their order.
    pub starts: Vec<StartOutcome>,
    /// Whether it was cancelled. The values are the best so far.
    pub cancelled: bool,
}

/// Fits the unknowns to a misfit. `progress` is called from time to time.
pub fn solve(
    misfit: &dyn Misfit,
    unknowns: &Unknowns,
    options: FitOptions,
    progress: &dyn Fn(FitProgress),
    cancelled: &AtomicBool,
) -> Solution {
    let start = unknowns.start();
    let before = misfit.evaluate(&start);
    let context = Context {
        misfit,
        unknowns,
        strictness: 100.0 * before.square().max(1e-12),
        progress,
        cancelled,
        starts: options.starts.max(1),
        best: Cell::new(before.root_mean_square()),
        best_values: RefCell::new(start.clone()),
    };
    let mut starts: Vec<StartOutcome> = Vec::new();
    let sequence = EvenSequence::new(unknowns.free().max(1));
    for index in 0..context.starts {
        if cancelled.load(Ordering::Relaxed) {
            break;
        }
        let variables = if index == 0 {
            unknowns.variables(&start)
        } else {
            let place: Vec<f64> = (0..unknowns.free()).map(|axis| sequence.coordinate(index, axis)).collect();
            unknowns.start_at(&place)
        };
        starts.push(context.descend(variables, index, ROUGH));
        let exact = 1e-7 * before.root_mean_square().max(1e-12);
        if starts.last().is_some_and(|outcome| outcome.residual <= exact) {
            break;
        }
    }
    let best = starts.iter().filter(|outcome| outcome.residual.is_finite());
    let best = best.min_by(|one, other| one.residual.total_cmp(&other.residual)).map(|outcome| outcome.values.clone());
    let mut values = best.unwrap_or_else(|| start.clone());
    if !cancelled.load(Ordering::Relaxed) {
        let finished = context.descend(unknowns.variables_exactly(&values), context.starts, FINE);
        values = finished.values;
    }
    if cancelled.load(Ordering::Relaxed) {
        // A start that was given up ends at values that it was only trying.
        values = context.best_values.take();
    }
    values = unknowns.settled(&values);
    let mut after = misfit.evaluate(&values);
    if before.root_mean_square() < after.root_mean_square() || !after.is_finite() {
        values = start;
        after = before.clone();
    }
    let (deviations, undetermined) = certainty(unknowns, &after);
    let stepwise = stepwise(misfit, unknowns, &values, &undetermined);
    progress(FitProgress { share: 1.0, residual: after.root_mean_square() });
    Solution {
        residuals: [before.root_mean_square(), after.root_mean_square()],
        values,
        deviations,
        undetermined,
        stepwise,
        starts,
        cancelled: cancelled.load(Ordering::Relaxed),
    }
}

/// How closely a minimum is approached.
#[derive(Clone, Copy)]
struct Closeness {
    tolerance: f64,
    /// The most evaluations, as a multiple of the number of unknowns.
    patience: usize,
}

/// For comparing starts.
const ROUGH: Closeness = Closeness { tolerance: 1e-6, patience: 12 };
/// For the result.
const FINE: Closeness = Closeness { tolerance: 1e-12, patience: 60 };

/// What all starts share.
struct Context<'c> {
    misfit: &'c dyn Misfit,
    unknowns: &'c Unknowns,
    strictness: f64,
    progress: &'c dyn Fn(FitProgress),
    cancelled: &'c AtomicBool,
    starts: u32,
    /// The least residual so far, and the values that have it.
    best: Cell<f64>,
    best_values: RefCell<Vec<f64>>,
}

impl Context<'_> {
    /// Goes down from a start.
    fn descend(&self, variables: Vec<f64>, index: u32, closeness: Closeness) -> StartOutcome {
        let problem = VariableProblem {
            context: self,
            index,
            limit: closeness.patience * (self.unknowns.free() + 1),
            variables: DVector::from_vec(variables),
            equations: RefCell::default(),
            evaluations: Cell::new(0),
        };
        let solver = LevenbergMarquardt::new().with_tol(closeness.tolerance).with_patience(closeness.patience);
        let (problem, _) = solver.minimize(problem);
        let values = self.unknowns.values(problem.variables.as_slice());
        let residual = problem.equations().map_or(f64::INFINITY, |equations| equations.root_mean_square());
        StartOutcome { values, residual, evaluations: problem.evaluations.get() }
    }
}

/// The misfit as the solver sees it: a Jacobian of one more row than there are unknowns.
struct VariableProblem<'p> {
    context: &'p Context<'p>,
    index: u32,
    /// How many evaluations are expected at most.
    limit: usize,
    variables: DVector<f64>,
    /// The equations at the variables.
    equations: RefCell<Option<NormalEquations>>,
    evaluations: Cell<usize>,
}

impl VariableProblem<'_> {
    /// The equations at the variables; `None` if they are no numbers, or the fit is cancelled.
    fn equations(&self) -> Option<NormalEquations> {
        if self.equations.borrow().is_none() {
            let Context { misfit, unknowns, strictness, .. } = *self.context;
            let variables = self.variables.as_slice();
            let equations = misfit.evaluate(&unknowns.values(variables));
            let equations = unknowns.in_variables(&equations, variables, strictness);
            self.evaluations.set(self.evaluations.get() + 1);
            self.tell(&equations);
            *self.equations.borrow_mut() = Some(equations);
        }
        self.equations.borrow().clone().filter(NormalEquations::is_finite)
    }

    fn tell(&self, equations: &NormalEquations) {
        let context = self.context;
        let residual = equations.root_mean_square();
        if residual < context.best.get() {
            context.best.set(residual);
            *context.best_values.borrow_mut() = context.unknowns.values(self.variables.as_slice());
        }
        let own = (self.evaluations.get() as f64 / self.limit as f64).min(1.0);
        let share = (f64::from(self.index) + own) / f64::from(context.starts + 1);
        (context.progress)(FitProgress { share: share.min(1.0), residual: context.best.get() });
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for VariableProblem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, variables: &DVector<f64>) {
        self.variables.copy_from(variables);
        *self.equations.borrow_mut() = None;
    }

    fn params(&self) -> DVector<f64> {
        self.variables.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        if self.context.cancelled.load(Ordering::Relaxed) {
            return None;
        }
        Some(self.equations()?.reduced().1)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.equations()?.reduced().0)
    }
}

/// The numbers without a derivative that change the misfit if they move far.
fn stepwise(misfit: &dyn Misfit, unknowns: &Unknowns, values: &[f64], undetermined: &[Vec<FitNumber>]) -> Vec<FitNumber> {
    let numbers = unknowns.numbers();
    let here = misfit.evaluate(values).square();
    let has_effect = |number: &FitNumber| {
        let Some(index) = numbers.iter().position(|known| known == number) else { return false };
        let ends = unknowns.ends(index, values[index]);
        let places = [ends[0], 0.5 * (ends[0] + ends[1]), ends[1]];
        places.into_iter().any(|place| {
            let mut moved = values.to_vec();
            moved[index] = place;
            let there = misfit.evaluate(&unknowns.settled(&moved)).square();
            (there - here).abs() > 1e-9 * here.max(there)
        })
    };
    let alone = undetermined.iter().filter_map(|group| if let [one] = group.as_slice() { Some(*one) } else { None });
    alone.filter(has_effect).collect()
}

/// The standard deviations of the free values, and the groups that the data do not determine.
fn certainty(unknowns: &Unknowns, equations: &NormalEquations) -> (Vec<Option<f64>>, Vec<Vec<FitNumber>>) {
    /// Directions of less curvature, with all numbers scaled alike, are flat.
    const FLAT: f64 = 1e-9;
    /// The smallest part of a number in a flat direction that counts.
    const PART: f64 = 1e-3;
    let free = unknowns.free();
    let own = equations.in_terms_of(&unknowns.slopes());
    let curvature = own.curvature();
    let scale: Vec<f64> = (0..free).map(|index| curvature[(index, index)].sqrt()).collect();
    let largest = (0..free).map(|index| scale[index] * unknowns.width(index)).fold(0.0, f64::max);
    let without_effect = |index: usize| scale[index] * unknowns.width(index) <= FLAT * largest;
    let numbers = unknowns.numbers();
    let mut groups: Vec<Vec<FitNumber>> =
        (0..free).filter(|index| without_effect(*index)).map(|index| vec![numbers[index]]).collect();
    let others: Vec<usize> = (0..free).filter(|index| !without_effect(*index)).collect();
    let scaled = DMatrix::from_fn(others.len(), others.len(), |row, column| {
        let (row, column) = (others[row], others[column]);
        curvature[(row, column)] / (scale[row] * scale[column])
    });
    let mut deviations = vec![None; free];
    if others.is_empty() || scaled.iter().any(|value| !value.is_finite()) {
        return (deviations, groups);
    }
    let eigen = SymmetricEigen::new(scaled);
    let mut flat = vec![false; others.len()];
    for column in (0..others.len()).filter(|column| eigen.eigenvalues[*column] < FLAT) {
        let members: Vec<usize> = (0..others.len()).filter(|row| eigen.eigenvectors[(*row, column)].abs() > PART).collect();
        members.iter().for_each(|row| flat[*row] = true);
        groups.push(members.into_iter().map(|row| numbers[others[row]]).collect());
    }
    let Some(variance) = own.variance() else { return (deviations, groups) };
    for (row, index) in others.iter().enumerate().filter(|(row, _)| !flat[*row]) {
        let inverse = (0..others.len())
            .filter(|column| eigen.eigenvalues[*column] >= FLAT)
            .map(|column| eigen.eigenvectors[(row, column)].powi(2) / eigen.eigenvalues[column])
            .sum::<f64>();
        let deviation = (variance * inverse).sqrt() / scale[*index];
        // Where it may be anywhere in its range, nothing is known of it.
        deviations[*index] = Some(deviation).filter(|deviation| *deviation < unknowns.width(*index));
    }
    (deviations, groups)
}

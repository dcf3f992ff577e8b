//! The minimum of a misfit by the method of Levenberg (1944) and Marquardt (1963), from several starts.

use crate::fit::Misfit;
use crate::fit::certainty::{Certainty, Placing};
use crate::fit::normal::NormalEquations;
use crate::fit::unknowns::{FitNumber, LimitOrigin, Unknowns};
use crate::sampling::EvenSequence;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
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
    /// How exact each free value is: its standard deviation, if the residuals are noise, which may be larger for some
    /// data than for others. `None` for numbers that the data do not determine.
    pub deviations: Vec<Option<f64>>,
    /// Groups of free numbers that the data determine only together, or, alone in a group, not at all.
    pub undetermined: Vec<Vec<FitNumber>>,
    /// Those of [`undetermined`](Self::undetermined) that have an effect in steps, such as thresholds. Their derivative
    /// is 0, so they did not move.
    pub stepwise: Vec<FitNumber>,
    /// Those of [`undetermined`](Self::undetermined) that have no effect at these values, but one elsewhere in their
    /// range.
    pub elsewhere: Vec<FitNumber>,
    /// At which end of its range each free number stands: the lower or the upper one.
    pub ends: Vec<Option<usize>>,
    /// The limits by invariants that bind, each with the index of its bound.
    pub binding: Vec<(LimitOrigin, usize)>,
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
    let mut best: Option<Descent> = None;
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
        let descent = context.descend(variables, index, ROUGH);
        starts.push(descent.outcome.clone());
        let exact = descent.outcome.residual <= 1e-7 * before.root_mean_square().max(1e-12);
        best = lower(best, descent);
        if exact {
            break;
        }
    }
    if let (Some(found), false) = (&best, cancelled.load(Ordering::Relaxed)) {
        let finished = context.descend(unknowns.variables_exactly(&found.outcome.values), context.starts, FINE);
        best = lower(best, finished);
    }
    let found = match best {
        Some(best) if !cancelled.load(Ordering::Relaxed) => (best.outcome.values, best.unknowns),
        // A start that was given up ends at values that it was only trying.
        Some(_) | None => (unknowns.settled(&context.best_values.take()), unknowns.clone()),
    };
    let told = context.told(found, &before);
    progress(FitProgress { share: 1.0, residual: told.residuals[1] });
    Solution { starts, cancelled: cancelled.load(Ordering::Relaxed), ..told }
}

/// The lower one of two ends.
fn lower(known: Option<Descent>, other: Descent) -> Option<Descent> {
    match known {
        Some(known) if known.outcome.residual.total_cmp(&other.outcome.residual).is_le() => Some(known),
        Some(known) if !other.outcome.residual.is_finite() => Some(known),
        Some(_) | None => Some(other).filter(|other| other.outcome.residual.is_finite()),
    }
}

/// How closely a minimum is approached.
#[derive(Clone, Copy)]
struct Closeness {
    tolerance: f64,
    /// Whether numbers at a bound begin there, not a little inside.
    is_exact: bool,
    /// The most evaluations, as a multiple of the number of unknowns.
    patience: usize,
}

/// For comparing starts.
const ROUGH: Closeness = Closeness { tolerance: 1e-6, is_exact: false, patience: 12 };
/// For the result.
const FINE: Closeness = Closeness { tolerance: 1e-12, is_exact: true, patience: 60 };

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

/// Where a start ended.
struct Descent {
    outcome: StartOutcome,
    /// The unknowns with the limits that bind there.
    unknowns: Unknowns,
}

impl Context<'_> {
    /// Goes down from a start. Limits that are exceeded there are equalities from then on.
    fn descend(&self, variables: Vec<f64>, index: u32, closeness: Closeness) -> Descent {
        let mut unknowns = self.unknowns.clone();
        let (mut variables, mut evaluations) = self.descend_within(&unknowns, variables, (index, 0), closeness);
        while let Some(bound) = unknowns.bound(&variables) {
            let settled = self.unknowns.settled(&unknowns.values(&variables));
            unknowns = bound;
            variables = match closeness.is_exact {
                true => unknowns.variables_exactly(&settled),
                false => unknowns.variables(&settled),
            };
            if !unknowns.moving().is_empty() {
                (variables, evaluations) = self.descend_within(&unknowns, variables, (index, evaluations), closeness);
            }
        }
        let values = self.unknowns.settled(&unknowns.values(&variables));
        let equations = self.misfit.evaluate(&values);
        let residual = if equations.is_finite() { equations.root_mean_square() } else { f64::INFINITY };
        if !self.cancelled.load(Ordering::Relaxed) {
            self.note(&values, residual);
        }
        Descent { outcome: StartOutcome { values, residual, evaluations: evaluations + 1 }, unknowns }
    }

    /// Keeps values if they are the best so far.
    fn note(&self, values: &[f64], residual: f64) {
        if residual < self.best.get() {
            self.best.set(residual);
            *self.best_values.borrow_mut() = values.to_vec();
        }
    }

    /// What the values that were found mean, beside the starts that led to them.
    fn told(&self, (mut values, mut unknowns): (Vec<f64>, Unknowns), before: &NormalEquations) -> Solution {
        let misfit = self.misfit;
        let whole = |values: &[f64]| misfit.evaluate_into(values, &NormalEquations::with_scatter(values.len()));
        let start = self.unknowns.start();
        let after = misfit.evaluate(&values);
        if before.root_mean_square() < after.root_mean_square() || !after.is_finite() {
            (values, unknowns) = (start, self.unknowns.clone());
        }
        let placing = Placing { misfit, unknowns: self.unknowns, rounding: 1e-13 * before.square() };
        placing.at_bounds(&mut values);
        let mut after = whole(&values);
        let mut certainty = Certainty::new(&unknowns, &after);
        let found = values.clone();
        placing.at_start(&mut values, &certainty.undetermined);
        if values != found {
            after = whole(&values);
            certainty = Certainty::new(&unknowns, &after);
        }
        let Certainty { deviations, undetermined } = certainty;
        let [stepwise, elsewhere] = Placing { unknowns: &unknowns, ..placing }.lone_effects(&values, &undetermined);
        let numbers = unknowns.numbers();
        let end = |free: usize| {
            let has_effect = !undetermined.iter().any(|group| *group == [numbers[free]]);
            let end = unknowns.bound_at(free, values[free]).or_else(|| unknowns.sole_end(free));
            end.filter(|_| has_effect)
        };
        Solution {
            residuals: [before.root_mean_square(), after.root_mean_square()],
            ends: (0..unknowns.free()).map(end).collect(),
            binding: unknowns.binding(),
            values,
            deviations,
            undetermined,
            stepwise,
            elsewhere,
            starts: Vec::new(),
            cancelled: false,
        }
    }

    /// Goes down from variables of unknowns. Returns those at the end, and the number of evaluations up to there.
    fn descend_within(
        &self,
        unknowns: &Unknowns,
        variables: Vec<f64>,
        (index, evaluations): (u32, usize),
        closeness: Closeness,
    ) -> (Vec<f64>, usize) {
        let problem = VariableProblem {
            context: self,
            unknowns,
            index,
            limit: closeness.patience * (unknowns.moving().len() + 1),
            variables: DVector::from_vec(variables),
            equations: RefCell::default(),
            evaluations: Cell::new(evaluations),
        };
        let solver = LevenbergMarquardt::new().with_tol(closeness.tolerance).with_patience(closeness.patience);
        let (problem, _) = solver.minimize(problem);
        (problem.variables.as_slice().to_vec(), problem.evaluations.get())
    }
}

/// The misfit as the solver sees it: a Jacobian of one more row than there are unknowns.
struct VariableProblem<'p> {
    context: &'p Context<'p>,
    unknowns: &'p Unknowns,
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
            let (misfit, strictness, unknowns) = (self.context.misfit, self.context.strictness, self.unknowns);
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
        let variables = self.variables.as_slice();
        // Values outside of the invariants are no result.
        if self.unknowns.keeps_limits(variables) {
            context.note(&self.unknowns.values(variables), equations.root_mean_square());
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

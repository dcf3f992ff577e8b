//! The numbers that a fit may move: components of parameters within their ranges, and what follows from them by
//! invariants.
//!
//! A number with bounds is a smooth function of a variable without: a sine between the bounds (as in MINUIT, James and
//! Roos 1975), of the logarithm if the bounds are far apart. So the method of Levenberg and Marquardt, which knows no
//! bounds, stays within them.
//!
//! An invariant `<=` that the search would leave becomes an equality, see `binding`.

mod binding;

use crate::fit::normal::NormalEquations;
use crate::formula::invariants::InvariantSystem;
use crate::formula::{Formula, ParameterId};
use crate::lang::ast::Relation;
use crate::lang::types::Type;
use crate::lang::variables::Owner;
use nalgebra::{DMatrix, RowDVector};
use thiserror::Error;

/// A component of a parameter of a body, of a light, or of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FitNumber {
    /// The parameter.
    pub parameter: ParameterId,
    /// The index of the body or light among its kind; 0 for the scene.
    pub owner: usize,
    /// The component; 0 for a scalar.
    pub component: u8,
}

/// A parameter that a fit may move, and within which bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeParameter {
    /// The parameter.
    pub parameter: ParameterId,
    /// The index of the body or light among its kind; 0 for the scene.
    pub owner: usize,
    /// Bounds that replace those of the parameter.
    pub range: Option<[f32; 2]>,
}

/// Why parameters cannot be fitted.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UnknownsError {
    /// There is nothing to move.
    #[error("no parameter is free to move")]
    Nothing,
    /// A texture or a whole number.
    #[error("`{0}` cannot be fitted: it is {1}; only numbers and colours can move smoothly")]
    NotSmooth(String, &'static str),
    /// It follows from others.
    #[error("`{0}` follows from others by an invariant ({1}); free those")]
    Locked(String, String),
    /// Bounds that contradict each other, or the range of the parameter.
    #[error("the bounds {1} of `{0}` do not lie within its range, {2}")]
    Bounds(String, String, String),
    /// Bounds in the wrong order.
    #[error("the bounds {1} of `{0}` are in the wrong order")]
    Order(String, String),
    /// A parameter is named twice.
    #[error("`{0}` is named twice")]
    Twice(String),
}

/// How a number follows from a variable without bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum VariableScale {
    Free { unit: f64 },
    Bounded,
    Logarithmic,
}

#[derive(Debug, Clone, PartialEq)]
struct FreeNumber {
    number: FitNumber,
    low: f64,
    high: f64,
    scale: VariableScale,
}

/// A number that is `constant` + Σ factor · free number.
#[derive(Debug, Clone, PartialEq)]
struct LinearSum {
    constant: f64,
    terms: Vec<(usize, f64)>,
}

impl LinearSum {
    fn of(&self, free: &[f64]) -> f64 {
        self.constant + self.terms.iter().map(|(at, factor)| factor * free[*at]).sum::<f64>()
    }
}

/// Where a limit comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum LimitOrigin {
    /// An invariant `<=` of these parameters.
    Sum(Vec<FitNumber>),
    /// The range of a number that follows by an invariant.
    Follower(FitNumber),
    /// The range of a number that would be free without an invariant that binds.
    Own(FitNumber),
}

/// A sum that has to stay between two bounds.
#[derive(Debug, Clone, PartialEq)]
struct SumLimit {
    sum: LinearSum,
    ends: [f64; 2],
    origin: LimitOrigin,
}

impl SumLimit {
    /// How far the sum is above the upper bound, or, negative, below the lower one.
    fn outside(&self, free: &[f64]) -> f64 {
        let value = self.sum.of(free);
        value - value.clamp(self.ends[0], self.ends[1])
    }
}

/// The unknown numbers of a fit. *Values* are those of all [`numbers`](Self::numbers), as parameters have them.
/// *Variables* are what is solved for: one for each free number that no binding invariant holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknowns {
    free: Vec<FreeNumber>,
    followers: Vec<(FitNumber, LinearSum)>,
    limits: Vec<SumLimit>,
    /// The indices of the free numbers that have variables.
    moving: Vec<usize>,
    /// The other free numbers, and how they follow from those.
    held: Vec<(usize, LinearSum)>,
    /// The limits that bind, each with the index of the bound that is reached.
    binding: Vec<(usize, usize)>,
    start: Vec<f64>,
}

/// Bounds whose quotient is larger are far apart.
const FAR: f64 = 50.0;

impl Unknowns {
    /// The unknowns where these parameters are free. `value` gives the values of all parameters at the start.
    ///
    /// # Errors
    /// A parameter cannot move smoothly, follows from others, or its bounds are wrong.
    pub fn new(
        formula: &Formula,
        free: &[FreeParameter],
        value: &dyn Fn(ParameterId, usize) -> [f32; 3],
    ) -> Result<Self, UnknownsError> {
        let systems = invariant_systems(formula);
        let mut numbers: Vec<FreeNumber> = Vec::new();
        for FreeParameter { parameter: id, owner, range } in free {
            let parameter = formula.parameter(*id);
            let name = || parameter.name.clone();
            if parameter.ty == Type::Texture {
                return Err(UnknownsError::NotSmooth(name(), "a texture"));
            }
            if parameter.is_whole() {
                return Err(UnknownsError::NotSmooth(name(), "a choice"));
            }
            if let Some(explanation) = systems.iter().find_map(|system| system.explanation(*id)) {
                return Err(UnknownsError::Locked(name(), explanation));
            }
            let own = parameter.range.unwrap_or([f32::MIN, f32::MAX]);
            let [low, high] = range.unwrap_or(own);
            if low > high {
                return Err(UnknownsError::Order(name(), format!("{low}..{high}")));
            }
            if low < own[0] || high > own[1] {
                return Err(UnknownsError::Bounds(name(), format!("{low}..{high}"), format!("{}..{}", own[0], own[1])));
            }
            if numbers.iter().any(|known| known.number.parameter == *id && known.number.owner == *owner) {
                return Err(UnknownsError::Twice(name()));
            }
            let bounded = parameter.range.is_some() || range.is_some();
            for component in 0..parameter.ty.slots() as u8 {
                let start = f64::from(value(*id, *owner)[usize::from(component)]);
                let (low, high) = (f64::from(low), f64::from(high));
                let scale = match bounded {
                    false => VariableScale::Free { unit: start.abs().max(1.0) },
                    true if low > 0.0 && high / low >= FAR => VariableScale::Logarithmic,
                    true => VariableScale::Bounded,
                };
                let number = FitNumber { parameter: *id, owner: *owner, component };
                if low < high {
                    numbers.push(FreeNumber { number, low, high, scale });
                }
            }
        }
        if numbers.is_empty() {
            return Err(UnknownsError::Nothing);
        }
        let mut unknowns = Self {
            moving: (0..numbers.len()).collect(),
            free: numbers,
            followers: Vec::new(),
            limits: Vec::new(),
            held: Vec::new(),
            binding: Vec::new(),
            start: Vec::new(),
        };
        unknowns.follow(formula, &systems, value);
        let starts = unknowns.free.iter().map(|free| {
            let FitNumber { parameter, owner, component } = free.number;
            let start = f64::from(value(parameter, owner)[usize::from(component)]);
            start.clamp(free.low, free.high)
        });
        unknowns.start = starts.collect();
        Ok(unknowns)
    }

    /// Takes in what invariants say of the free numbers.
    fn follow(&mut self, formula: &Formula, systems: &[InvariantSystem], value: &dyn Fn(ParameterId, usize) -> [f32; 3]) {
        let mut owners: Vec<(Owner, usize)> = Vec::new();
        for FitNumber { parameter, owner, .. } in self.free.iter().map(|free| free.number) {
            let owner = (formula.parameter(parameter).owner, owner);
            if !owners.contains(&owner) {
                owners.push(owner);
            }
        }
        for (kind, owner) in owners {
            let of_kind = |id: ParameterId| formula.parameter(id).owner == kind;
            let dependents = systems.iter().flat_map(InvariantSystem::dependents);
            let dependents: Vec<_> = dependents.filter(|dependent| of_kind(dependent.parameter)).collect();
            for dependent in &dependents {
                let follower = self.sum(owner, dependent.constant, &dependent.terms, value);
                if !follower.terms.is_empty() {
                    let number = FitNumber { parameter: dependent.parameter, owner, component: 0 };
                    let origin = LimitOrigin::Follower(number);
                    self.limits.push(SumLimit { sum: follower.clone(), ends: [0.0, 1.0], origin });
                    self.followers.push((number, follower));
                }
            }
            for line in formula.invariants.iter().filter(|line| line.relation == Relation::AtMost) {
                let (mut constant, mut terms): (f64, Vec<(ParameterId, f64)>) = (0.0, Vec::new());
                for id in line.terms.iter().copied().filter(|id| of_kind(*id)) {
                    match dependents.iter().find(|dependent| dependent.parameter == id) {
                        Some(dependent) => {
                            constant += dependent.constant;
                            terms.extend(&dependent.terms);
                        }
                        None => terms.push((id, 1.0)),
                    }
                }
                let sum = self.sum(owner, constant, &terms, value);
                if !sum.terms.is_empty() {
                    let number = |parameter: &ParameterId| FitNumber { parameter: *parameter, owner, component: 0 };
                    let origin = LimitOrigin::Sum(line.terms.iter().map(number).collect());
                    self.limits.push(SumLimit { sum, ends: [f64::NEG_INFINITY, 1.0], origin });
                }
            }
        }
    }

    /// A sum of parameters of an owner. Those that are not free have their values.
    fn sum(
        &self,
        owner: usize,
        constant: f64,
        terms: &[(ParameterId, f64)],
        value: &dyn Fn(ParameterId, usize) -> [f32; 3],
    ) -> LinearSum {
        let mut sum = LinearSum { constant, terms: Vec::new() };
        for (id, factor) in terms {
            let position = |free: &FreeNumber| free.number.parameter == *id && free.number.owner == owner;
            match self.free.iter().position(position) {
                Some(index) => sum.terms.push((index, *factor)),
                None => sum.constant += factor * f64::from(value(*id, owner)[0]),
            }
        }
        sum
    }

    /// All numbers that move: the free ones, then those that follow.
    pub fn numbers(&self) -> Vec<FitNumber> {
        self.free.iter().map(|free| free.number).chain(self.followers.iter().map(|(number, _)| *number)).collect()
    }

    /// How many numbers are free.
    pub fn free(&self) -> usize {
        self.free.len()
    }

    /// The values at the start.
    pub fn start(&self) -> Vec<f64> {
        self.with_followers(self.start.clone())
    }

    /// All values, from those of the free numbers.
    pub fn with_followers(&self, mut values: Vec<f64>) -> Vec<f64> {
        let followers: Vec<f64> = self.followers.iter().map(|(_, sum)| sum.of(&values).clamp(0.0, 1.0)).collect();
        values.extend(followers);
        values
    }

    /// The values that follow from variables.
    pub fn values(&self, variables: &[f64]) -> Vec<f64> {
        let mut values = self.unclamped(variables);
        values.iter_mut().zip(&self.free).for_each(|(value, free)| *value = value.clamp(free.low, free.high));
        self.with_followers(values)
    }

    /// The free numbers that follow from variables. Those that an invariant holds may be beyond their ranges.
    fn unclamped(&self, variables: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.free.len()];
        self.moving.iter().zip(variables).for_each(|(at, variable)| values[*at] = self.free[*at].value(*variable)[0]);
        let held: Vec<f64> = self.held.iter().map(|(_, sum)| sum.of(&values)).collect();
        self.held.iter().zip(held).for_each(|((at, _), value)| values[*at] = value);
        values
    }

    /// Variables for values of the free numbers. At a bound, a number could not move: it is moved a little inside.
    pub fn variables(&self, values: &[f64]) -> Vec<f64> {
        self.moving.iter().map(|at| self.free[*at].variable(values[*at])).collect()
    }

    /// Variables for values of the free numbers, also at bounds.
    pub fn variables_exactly(&self, values: &[f64]) -> Vec<f64> {
        self.moving.iter().map(|at| self.free[*at].variable_exactly(values[*at])).collect()
    }

    /// The indices of the free numbers that have variables, in the order of these.
    pub fn moving(&self) -> &[usize] {
        &self.moving
    }

    /// How fast all numbers move with each one that has a variable: a row for each of [`numbers`](Self::numbers).
    pub fn slopes(&self) -> DMatrix<f64> {
        let free = self.free.len();
        let mut change = DMatrix::zeros(free + self.followers.len(), self.moving.len());
        self.moving.iter().enumerate().for_each(|(column, at)| change[(*at, column)] = 1.0);
        for (at, sum) in &self.held {
            let row = self.slopes_of(sum, &change);
            change.set_row(*at, &row);
        }
        for (index, (_, sum)) in self.followers.iter().enumerate() {
            let row = self.slopes_of(sum, &change);
            change.set_row(free + index, &row);
        }
        change
    }

    fn slopes_of(&self, sum: &LinearSum, change: &DMatrix<f64>) -> RowDVector<f64> {
        let zero = RowDVector::zeros(self.moving.len());
        sum.terms.iter().fold(zero, |row, (at, factor)| row + change.row(*at) * *factor)
    }

    /// Moves values into the region where every invariant holds, if rounding or the search left it a little.
    pub fn settled(&self, values: &[f64]) -> Vec<f64> {
        /// Several limits may need several rounds.
        const ROUNDS: usize = 64;
        let mut free: Vec<f64> = self.free.iter().zip(values).map(|(free, value)| value.clamp(free.low, free.high)).collect();
        for _ in 0..ROUNDS {
            let mut inside = true;
            for limit in &self.limits {
                let outside = limit.outside(&free);
                if outside.abs() <= 1e-12 {
                    continue;
                }
                inside = false;
                let terms = &limit.sum.terms;
                let square: f64 = terms.iter().map(|(_, factor)| factor * factor).sum();
                for (at, factor) in terms {
                    free[*at] = (free[*at] - outside * factor / square).clamp(self.free[*at].low, self.free[*at].high);
                }
            }
            if inside {
                break;
            }
        }
        self.with_followers(free)
    }

    /// At which of its bounds a free number is: the lower or the upper one.
    pub fn bound_at(&self, free: usize, value: f64) -> Option<usize> {
        /// How near to a bound, as a part of the range, is at it.
        const NEAR: f64 = 1e-4;
        let number = &self.free[free];
        let near = NEAR * (number.high - number.low);
        match number.scale {
            VariableScale::Free { .. } => None,
            VariableScale::Bounded | VariableScale::Logarithmic if value - number.low <= near => Some(0),
            VariableScale::Bounded | VariableScale::Logarithmic if number.high - value <= near => Some(1),
            VariableScale::Bounded | VariableScale::Logarithmic => None,
        }
    }

    /// The ends of the range of a free number; without bounds, its value and a unit more.
    pub fn ends(&self, free: usize, value: f64) -> [f64; 2] {
        let number = &self.free[free];
        match number.scale {
            VariableScale::Free { unit } => [value - unit, value + unit],
            VariableScale::Bounded | VariableScale::Logarithmic => [number.low, number.high],
        }
    }

    /// The width of the range of a free number; without bounds, its usual size.
    pub fn width(&self, free: usize) -> f64 {
        let free = &self.free[free];
        match free.scale {
            VariableScale::Free { unit } => unit,
            VariableScale::Bounded | VariableScale::Logarithmic => free.high - free.low,
        }
    }

    /// Variables for a point of the unit cube, for further starts.
    pub fn start_at(&self, point: &[f64]) -> Vec<f64> {
        let variable = |(at, share): (&usize, &f64)| self.free[*at].variable(self.free[*at].at_share(*share));
        self.moving.iter().zip(point).map(variable).collect()
    }

    /// Normal equations in variables, from those in values: with the rule for chains of functions, and with a residual
    /// of this weight for each invariant that is violated.
    pub fn in_variables(&self, equations: &NormalEquations, variables: &[f64], strictness: f64) -> NormalEquations {
        let mut change = self.slopes();
        for ((mut column, at), variable) in change.column_iter_mut().zip(&self.moving).zip(variables) {
            column *= self.free[*at].value(*variable)[1];
        }
        let mut result = equations.in_terms_of(&change);
        let free = self.unclamped(variables);
        for limit in &self.limits {
            let outside = limit.outside(&free);
            if outside != 0.0 {
                let slopes = self.slopes_of(&limit.sum, &change);
                let mut row: Vec<f64> = slopes.iter().copied().collect();
                row.push(outside);
                result.add(strictness, &row);
            }
        }
        result
    }
}

impl FreeNumber {
    /// The value for a variable, and its derivative.
    fn value(&self, variable: f64) -> [f64; 2] {
        let (share, slope) = ((1.0 + variable.sin()) / 2.0, variable.cos() / 2.0);
        match self.scale {
            VariableScale::Free { unit } => [unit * variable, unit],
            VariableScale::Bounded => [self.low + (self.high - self.low) * share, (self.high - self.low) * slope],
            VariableScale::Logarithmic => {
                let ratio = (self.high / self.low).ln();
                let value = self.low * (ratio * share).exp();
                [value.min(self.high), value * ratio * slope]
            }
        }
    }

    /// The variable of a value; at a bound, of one that is a little inside.
    fn variable(&self, value: f64) -> f64 {
        /// How far inside the bounds a number starts, as a part of the range.
        const INSIDE: f64 = 0.01;
        match self.share(value) {
            Some(share) => (2.0 * share.clamp(INSIDE, 1.0 - INSIDE) - 1.0).asin(),
            None => self.variable_exactly(value),
        }
    }

    fn variable_exactly(&self, value: f64) -> f64 {
        match (self.share(value), self.scale) {
            (Some(share), _) => (2.0 * share.clamp(0.0, 1.0) - 1.0).asin(),
            (None, VariableScale::Free { unit }) => value / unit,
            (None, VariableScale::Bounded | VariableScale::Logarithmic) => value,
        }
    }

    /// Where in the range a value is, 0..1. `None` without bounds.
    fn share(&self, value: f64) -> Option<f64> {
        match self.scale {
            VariableScale::Free { .. } => None,
            VariableScale::Bounded => Some((value - self.low) / (self.high - self.low)),
            VariableScale::Logarithmic => Some((value / self.low).ln() / (self.high / self.low).ln()),
        }
    }

    /// The value at a share of the range, 0..1. Without bounds it is the share itself, as on a slider.
    fn at_share(&self, share: f64) -> f64 {
        match self.scale {
            VariableScale::Free { unit } => unit * share,
            VariableScale::Bounded => self.low + (self.high - self.low) * share,
            VariableScale::Logarithmic => self.low * (self.high / self.low).powf(share),
        }
    }
}

/// The invariants of each kind of owner, solved. A checked formula has no contradictory ones.
fn invariant_systems(formula: &Formula) -> Vec<InvariantSystem> {
    let system = |owner| InvariantSystem::new(&formula.parameters, &formula.invariants, owner).ok();
    Owner::ALL.into_iter().filter_map(system).map(|(system, _)| system).collect()
}

#[cfg(test)]
mod tests;

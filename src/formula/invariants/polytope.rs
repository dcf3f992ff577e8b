//! The values that linear conditions allow: points of the unit cube at which sums lie within bounds.
//!
//! There are no parameters here: coordinates are indices. Linear programs give the answers. Values are `f32` and
//! conditions hold only up to rounding, so all answers are relative to a *slack* by which a condition may be violated.

use microlp::{ComparisonOp, LinearExpr, OptimizationDirection, Problem, Variable};

/// The error that a sum may have. Values are `f32`, so 0.6 + 0.4 is not exactly 1.
pub(super) const TOLERANCE: f64 = 5e-7;

/// A condition: `low <= constant + Σ coefficient · coordinate <= high`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Condition {
    pub(super) constant: f64,
    /// Coordinates with their coefficients, each coordinate at most once, no coefficient 0.
    pub(super) terms: Vec<(usize, f64)>,
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Condition {
    /// The sum at a point.
    pub(super) fn sum(&self, point: impl Fn(usize) -> f64) -> f64 {
        self.constant + self.terms.iter().map(|(coordinate, factor)| factor * point(*coordinate)).sum::<f64>()
    }

    /// How far a point violates the bounds; 0 if it does not.
    fn miss(&self, point: impl Fn(usize) -> f64) -> f64 {
        let sum = self.sum(point);
        (sum - self.high).max(self.low - sum).max(0.0)
    }
}

/// The points of the unit cube that satisfy all conditions.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Polytope {
    pub(super) coordinates: usize,
    pub(super) conditions: Vec<Condition>,
}

impl Polytope {
    /// How far a point violates the condition that it violates most.
    pub(super) fn miss(&self, point: impl Fn(usize) -> f64) -> f64 {
        self.conditions.iter().map(|condition| condition.miss(&point)).fold(0.0, f64::max)
    }

    /// The interval in which one coordinate of a point may move while the others stay. An empty interval becomes the
    /// point itself, which then already violates a condition.
    pub(super) fn reach(&self, coordinate: usize, point: impl Fn(usize) -> f64) -> [f64; 2] {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        for condition in &self.conditions {
            let Some((_, factor)) = condition.terms.iter().find(|(term, _)| *term == coordinate) else { continue };
            let rest = condition.sum(|other| if other == coordinate { 0.0 } else { point(other) });
            let ends = [(condition.low - rest) / factor, (condition.high - rest) / factor];
            low = low.max(ends[0].min(ends[1]));
            high = high.min(ends[0].max(ends[1]));
        }
        let here = point(coordinate).clamp(0.0, 1.0);
        [low.min(here), high.max(here)]
    }

    /// The smallest slack for which a point exists with the first coordinates `fixed`.
    pub(super) fn least_slack(&self, fixed: &[f64]) -> f64 {
        let mut program = LinearProgram::new(self, fixed, OptimizationDirection::Minimize, None);
        let slack = program.problem.add_var(1.0, (0.0, f64::INFINITY));
        program.add_conditions(Some(slack), 0.0);
        match program.problem.solve() {
            Ok(solution) => solution.objective().max(0.0),
            // With enough slack there is always a point, so only a numerical failure of the solver gets here.
            Err(_) => f64::INFINITY,
        }
    }

    /// The interval of the next coordinate after the `fixed` ones, over the points that violate no condition by more
    /// than `slack`. `None` if there is no such point.
    pub(super) fn interval(&self, fixed: &[f64], slack: f64) -> Option<[f64; 2]> {
        let end = |direction| {
            let mut program = LinearProgram::new(self, fixed, direction, Some(fixed.len()));
            program.add_conditions(None, slack);
            program.problem.solve().ok().map(|solution| solution.objective())
        };
        Some([end(OptimizationDirection::Minimize)?, end(OptimizationDirection::Maximize)?])
    }
}

/// A linear program over the coordinates after the fixed ones.
struct LinearProgram<'a> {
    polytope: &'a Polytope,
    fixed: &'a [f64],
    problem: Problem,
    variables: Vec<Variable>,
}

impl<'a> LinearProgram<'a> {
    /// A program without conditions. The objective is one coordinate, or nothing yet.
    fn new(polytope: &'a Polytope, fixed: &'a [f64], direction: OptimizationDirection, objective: Option<usize>) -> Self {
        let mut problem = Problem::new(direction);
        let variables = (fixed.len()..polytope.coordinates)
            .map(|coordinate| problem.add_var(if objective == Some(coordinate) { 1.0 } else { 0.0 }, (0.0, 1.0)))
            .collect();
        LinearProgram { polytope, fixed, problem, variables }
    }

    /// Adds the conditions, each loosened by a number and by the variable `slack`, if there is one.
    fn add_conditions(&mut self, slack: Option<Variable>, loosened: f64) {
        for condition in &self.polytope.conditions {
            let known = condition.sum(|coordinate| self.fixed.get(coordinate).copied().unwrap_or(0.0));
            let sides = [(condition.high, ComparisonOp::Le, 1.0), (condition.low, ComparisonOp::Ge, -1.0)];
            for (bound, comparison, outwards) in sides {
                if bound.is_infinite() {
                    continue;
                }
                let mut sum = LinearExpr::empty();
                let mut open = false;
                for (coordinate, factor) in &condition.terms {
                    if let Some(ahead) = coordinate.checked_sub(self.fixed.len()) {
                        sum.add(self.variables[ahead], *factor);
                        open = true;
                    }
                }
                if let Some(slack) = slack {
                    sum.add(slack, -outwards);
                    open = true;
                }
                // A condition on fixed coordinates alone already holds.
                if open {
                    self.problem.add_constraint(sum, comparison, bound - known + outwards * loosened);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_most_one(coordinates: &[usize]) -> Condition {
        Condition {
            constant: 0.0,
            terms: coordinates.iter().map(|coordinate| (*coordinate, 1.0)).collect(),
            low: f64::NEG_INFINITY,
            high: 1.0,
        }
    }

    #[test]
    fn intervals_look_ahead() {
        // a + b <= 1 and 1 - b within 0.7..1, so b <= 0.3.
        let far = Condition { constant: 1.0, terms: vec![(1, -1.0)], low: 0.7, high: 1.0 };
        let polytope = Polytope { coordinates: 2, conditions: vec![at_most_one(&[0, 1]), far] };
        assert_eq!(polytope.interval(&[], 0.0), Some([0.0, 1.0]));
        let [low, high] = polytope.interval(&[0.9], 0.0).unwrap();
        assert!(low.abs() < 1e-9 && (high - 0.1).abs() < 1e-9, "{low} {high}");
        assert!(polytope.least_slack(&[]) < 1e-12);
        assert!((polytope.least_slack(&[0.0, 0.5]) - 0.2).abs() < 1e-9);
    }

    #[test]
    fn the_reach_is_that_of_one_coordinate_alone() {
        let polytope = Polytope { coordinates: 2, conditions: vec![at_most_one(&[0, 1])] };
        let [low, high] = polytope.reach(0, |coordinate| [0.2, 0.75][coordinate]);
        assert_eq!([low, high], [0.0, 0.25]);
    }
}

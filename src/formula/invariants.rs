//! Invariants: sums of parameters that are to be 1, or at most 1 (thesis 4.2.7, 8.2).
//!
//! The `=` lines of one kind of owner form a linear system. Each line makes one parameter follow from the others. The
//! other parameters are free within the bounds of ranges and `<=` lines. This module solves the system and adjusts
//! given values. The workspace keeps the values, and reports adjustments.

mod elimination;
mod polytope;

use crate::formula::{Invariant, Parameter, ParameterId};
use crate::lang::ast::Relation;
use crate::lang::variables::Owner;
use elimination::{Locked, NamedSum, Sum, consistent, eliminate, irreducible, substituted};
use polytope::{Condition, Polytope, TOLERANCE};
use std::collections::BTreeMap;

/// A parameter that follows from free ones: constant + Σ coefficient · parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Dependent {
    /// The locked parameter.
    pub parameter: ParameterId,
    /// Its value if the free ones are 0.
    pub constant: f64,
    /// The free parameters that it follows from, with their coefficients, in the order of naming.
    pub terms: Vec<(ParameterId, f64)>,
}

impl Dependent {
    /// Its value, within 0..1.
    fn value(&self, values: impl Fn(ParameterId) -> f32) -> f32 {
        let sum = self.terms.iter().map(|(parameter, factor)| factor * f64::from(values(*parameter))).sum::<f64>();
        (self.constant + sum).clamp(0.0, 1.0) as f32
    }
}

/// Invariants that cannot all hold with every parameter in 0..1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inconsistent {
    /// Indices into the list of invariants. Without any one of these, the others can hold.
    pub invariants: Vec<usize>,
}

/// A default that the invariants change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DefaultConflict {
    /// The parameter.
    pub parameter: ParameterId,
    /// Its default.
    pub given: f32,
    /// The value that it becomes.
    pub settled: f32,
}

/// The invariants of one kind of owner, solved.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InvariantSystem {
    /// The free parameters in the order of naming: the polytope's coordinates.
    free: Vec<ParameterId>,
    /// The locked parameters, in the order of the lines that lock them.
    dependents: Vec<Dependent>,
    /// The values that the free parameters may have.
    polytope: Polytope,
    /// The names of all parameters in it.
    names: BTreeMap<ParameterId, String>,
}

impl InvariantSystem {
    /// Solves the invariants of one kind of owner. Also returns the indices of redundant `=` lines, which follow from
    /// the lines before them. Indices are into `invariants`. Lines of other owners are ignored.
    ///
    /// # Errors
    /// The lines contradict each other, or leave no values within 0..1.
    pub fn new(
        parameters: &[Parameter],
        invariants: &[Invariant],
        owner: Owner,
    ) -> Result<(InvariantSystem, Vec<usize>), Inconsistent> {
        let owned = |id: &ParameterId| parameters.get(id.0 as usize).is_some_and(|parameter| parameter.owner == owner);
        let lines: Vec<(usize, &Invariant)> =
            invariants.iter().enumerate().filter(|(_, line)| !line.terms.is_empty() && line.terms.iter().all(owned)).collect();
        let mut order: Vec<ParameterId> = Vec::new();
        let mut unknowns: BTreeMap<ParameterId, usize> = BTreeMap::new();
        for term in lines.iter().flat_map(|(_, line)| &line.terms) {
            unknowns.entry(*term).or_insert_with(|| {
                order.push(*term);
                order.len() - 1
            });
        }
        let named: Vec<NamedSum> = lines
            .iter()
            .map(|(index, line)| NamedSum {
                index: *index,
                relation: line.relation,
                unknowns: line.terms.iter().map(|term| unknowns[term]).collect(),
            })
            .collect();
        if !consistent(&named, order.len()) {
            return Err(Inconsistent { invariants: irreducible(named, order.len()) });
        }
        let (locked, redundant) = eliminate(&named);
        let system = Self::assemble(&order, &named, &locked, parameters);
        Ok((system, redundant))
    }

    fn assemble(order: &[ParameterId], lines: &[NamedSum], locked: &[Locked], parameters: &[Parameter]) -> Self {
        let free: Vec<usize> = (0..order.len()).filter(|unknown| locked.iter().all(|(pivot, ..)| pivot != unknown)).collect();
        let coordinates: BTreeMap<usize, usize> = free.iter().enumerate().map(|(index, unknown)| (*unknown, index)).collect();
        let terms = |sum: &Sum| sum.iter().map(|(unknown, factor)| (coordinates[unknown], *factor)).collect();
        let dependents = locked.iter().map(|(pivot, constant, sum)| Dependent {
            parameter: order[*pivot],
            constant: *constant,
            terms: sum.iter().map(|(unknown, factor)| (order[*unknown], *factor)).collect(),
        });
        let ranges =
            locked.iter().map(|(_, constant, sum)| Condition { constant: *constant, terms: terms(sum), low: 0.0, high: 1.0 });
        let at_most = lines.iter().filter(|line| line.relation == Relation::AtMost).map(|line| {
            let (constant, sum) = substituted(line, locked);
            Condition { constant, terms: terms(&sum), low: f64::NEG_INFINITY, high: 1.0 }
        });
        InvariantSystem {
            dependents: dependents.collect(),
            polytope: Polytope { coordinates: free.len(), conditions: ranges.chain(at_most).collect() },
            free: free.iter().map(|unknown| order[*unknown]).collect(),
            names: order.iter().map(|id| (*id, parameters[id.0 as usize].name.clone())).collect(),
        }
    }

    /// The locked parameters and what they follow from.
    pub fn dependents(&self) -> &[Dependent] {
        &self.dependents
    }

    /// The free parameters that invariants name, in the order of naming.
    pub fn free(&self) -> &[ParameterId] {
        &self.free
    }

    /// Whether the parameter follows from others.
    pub fn is_locked(&self, parameter: ParameterId) -> bool {
        self.dependent(parameter).is_some()
    }

    fn dependent(&self, parameter: ParameterId) -> Option<&Dependent> {
        self.dependents.iter().find(|dependent| dependent.parameter == parameter)
    }

    /// How a locked parameter follows, such as `kd = 1 - ks`. `None` for a free one.
    pub fn explanation(&self, parameter: ParameterId) -> Option<String> {
        let dependent = self.dependent(parameter)?;
        let mut text = format!("{} =", self.names[&parameter]);
        let mut first = true;
        let mut add = |number: f64, name: Option<&str>| {
            let sign = match (first, number < 0.0) {
                (true, false) => " ",
                (true, true) => " -",
                (false, false) => " + ",
                (false, true) => " - ",
            };
            first = false;
            let size = short(number.abs() as f32);
            text.push_str(sign);
            text.push_str(&match name {
                None => size,
                Some(name) if size == "1" => name.to_owned(),
                Some(name) => format!("{size}*{name}"),
            });
        };
        if dependent.constant.abs() > elimination::CANCELLED || dependent.terms.is_empty() {
            add(dependent.constant, None);
        }
        dependent.terms.iter().for_each(|(term, factor)| add(*factor, Some(&self.names[term])));
        Some(text)
    }

    /// The range of a free parameter while the other free ones keep their `values`: every parameter of the owner stays
    /// in 0..1 and every `<=` holds. The range of a locked parameter is its value. `None` if no invariant names it.
    pub fn range_of(&self, parameter: ParameterId, values: impl Fn(ParameterId) -> f32) -> Option<[f32; 2]> {
        if let Some(dependent) = self.dependent(parameter) {
            return Some([dependent.value(values); 2]);
        }
        let coordinate = self.free.iter().position(|free| *free == parameter)?;
        let [low, high] = self.polytope.reach(coordinate, |index| f64::from(values(self.free[index])));
        Some([tidy(low), tidy(high)])
    }

    /// The parameters that move with a parameter, and the parameter itself. While the other free ones stay, the value
    /// of each is an affine function of it with this slope. Empty for a locked parameter, which cannot be moved.
    pub fn moved_with(&self, parameter: ParameterId) -> Vec<(ParameterId, f64)> {
        if self.is_locked(parameter) {
            return Vec::new();
        }
        let followers = self.dependents.iter().filter_map(|dependent| {
            let (_, factor) = dependent.terms.iter().find(|(term, _)| *term == parameter)?;
            Some((dependent.parameter, *factor))
        });
        std::iter::once((parameter, 1.0)).chain(followers).collect()
    }

    /// Moves a free parameter to a value, or as near to it as its range allows. Returns all values that change, its own
    /// first. Does nothing for a locked parameter.
    pub fn move_one(&self, parameter: ParameterId, value: f32, values: impl Fn(ParameterId) -> f32) -> Vec<(ParameterId, f32)> {
        if self.is_locked(parameter) {
            return Vec::new();
        }
        let value = match self.range_of(parameter, &values) {
            // If rounding has crossed the ends of an interval, it is a point.
            Some([low, high]) => value.max(low).min(high),
            None => value,
        };
        let moved = |id: ParameterId| if id == parameter { value } else { values(id) };
        let followers = self
            .dependents
            .iter()
            .filter(|dependent| dependent.terms.iter().any(|(term, _)| *term == parameter))
            .map(|dependent| (dependent.parameter, dependent.value(moved)));
        std::iter::once((parameter, value)).chain(followers).collect()
    }

    /// Adjusts values that arrive together. Each free parameter, in the order of naming, gets the nearest value for
    /// which the later ones can still satisfy all conditions. The locked ones follow. Returns the values of all
    /// parameters that invariants name, free ones first.
    pub fn settle(&self, wanted: impl Fn(ParameterId) -> f32) -> Vec<(ParameterId, f32)> {
        let wanted: Vec<f32> = self.free.iter().map(|id| within_unit(wanted(*id))).collect();
        let settled = if self.polytope.miss(|index| f64::from(wanted[index])) <= TOLERANCE {
            wanted
        } else {
            self.settle_in_order(&wanted)
        };
        let values: BTreeMap<ParameterId, f32> = self.free.iter().copied().zip(settled).collect();
        let locked = self.dependents.iter().map(|dependent| (dependent.parameter, dependent.value(|id| values[&id])));
        self.free.iter().map(|id| (*id, values[id])).chain(locked).collect()
    }

    fn settle_in_order(&self, wanted: &[f32]) -> Vec<f32> {
        let mut fixed: Vec<f64> = Vec::with_capacity(wanted.len());
        let mut slack = self.polytope.least_slack(&fixed);
        for &value in wanted {
            fixed.push(f64::from(value));
            let accepted = self.polytope.least_slack(&fixed);
            if accepted <= TOLERANCE {
                slack = accepted;
                continue;
            }
            fixed.pop();
            // Slightly more than the smallest slack, because the program is also solved in floating point.
            let interval = [1e-9, 1e-6].iter().find_map(|hair| self.polytope.interval(&fixed, slack + hair));
            let nearest = match interval {
                Some([low, high]) => tidy(f64::from(value).max(low).min(high)),
                None => value,
            };
            fixed.push(f64::from(nearest));
            slack = self.polytope.least_slack(&fixed);
        }
        // These values were `f32` before.
        fixed.into_iter().map(|value| value as f32).collect()
    }
}

/// The defaults that the invariants change, and defaults of locked parameters that differ from the value that follows.
/// Inconsistent invariants change none.
pub fn default_conflicts(parameters: &[Parameter], invariants: &[Invariant]) -> Vec<DefaultConflict> {
    let given = |id: ParameterId| parameters[id.0 as usize].default[0];
    Owner::ALL
        .iter()
        .filter_map(|owner| InvariantSystem::new(parameters, invariants, *owner).ok())
        .flat_map(|(system, _)| system.settle(given))
        .filter(|(parameter, settled)| differ(given(*parameter), *settled))
        .map(|(parameter, settled)| DefaultConflict { parameter, given: given(parameter), settled })
        .collect()
}

/// Whether two values differ by more than rounding.
pub fn differ(one: f32, other: f32) -> bool {
    (f64::from(one) - f64::from(other)).abs() > 2.0 * TOLERANCE
}

/// A number for messages, with at most six digits.
pub(crate) fn short(number: f32) -> String {
    let rounded = format!("{:.6}", number);
    let digits = rounded.trim_end_matches('0').trim_end_matches('.');
    if number != 0.0 && (number.abs() < 1e-4 || number.abs() >= 1e7) {
        format!("{number:e}")
    } else if digits == "-0" {
        "0".to_owned()
    } else {
        digits.to_owned()
    }
}

/// A bound without rounding noise. Seven decimals are as fine as `f32` near 1.
fn tidy(value: f64) -> f32 {
    ((value * 1e7).round() / 1e7).clamp(0.0, 1.0) as f32
}

/// The nearest value in 0..1; NaN is 0.
fn within_unit(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests;

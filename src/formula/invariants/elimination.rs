//! Solves lines of sums as a linear system: which unknowns follow from others, and which lines contradict each other.
//!
//! Here a parameter is an unknown, numbered in the order of naming. Its name and its value do not matter.

use crate::formula::invariants::polytope::{Condition, Polytope, TOLERANCE};
use crate::lang::ast::Relation;
use std::collections::BTreeMap;

/// Coefficients nearer to 0 than this have cancelled.
pub(super) const CANCELLED: f64 = 1e-9;

/// A sum of unknowns, each with its coefficient.
pub(super) type Sum = BTreeMap<usize, f64>;

/// An unknown that follows: constant + sum over free unknowns.
pub(super) type Locked = (usize, f64, Sum);

/// An invariant over unknowns.
#[derive(Debug, Clone)]
pub(super) struct NamedSum {
    /// Its index in the list of all invariants.
    pub(super) index: usize,
    pub(super) relation: Relation,
    pub(super) unknowns: Vec<usize>,
}

impl NamedSum {
    fn sum(&self) -> Sum {
        let mut sum = Sum::new();
        self.unknowns.iter().for_each(|unknown| *sum.entry(*unknown).or_insert(0.0) += 1.0);
        sum
    }
}

/// Whether some values in 0..1 satisfy all lines.
pub(super) fn consistent(lines: &[NamedSum], parameters: usize) -> bool {
    let conditions = lines.iter().map(|line| Condition {
        constant: 0.0,
        terms: line.sum().into_iter().collect(),
        low: match line.relation {
            Relation::Equal => 1.0,
            Relation::AtMost => f64::NEG_INFINITY,
        },
        high: 1.0,
    });
    Polytope { coordinates: parameters, conditions: conditions.collect() }.least_slack(&[]) <= TOLERANCE
}

/// A minimal inconsistent part of inconsistent lines: without any one of them, the rest is consistent.
pub(super) fn irreducible(mut lines: Vec<NamedSum>, parameters: usize) -> Vec<usize> {
    let mut at = 0;
    while at < lines.len() {
        let line = lines.remove(at);
        if consistent(&lines, parameters) {
            lines.insert(at, line);
            at += 1;
        }
    }
    lines.into_iter().map(|line| line.index).collect()
}

/// A line's sum in terms of free parameters: the constant part and the rest.
pub(super) fn substituted(line: &NamedSum, locked: &[Locked]) -> (f64, Sum) {
    let mut constant = 0.0;
    let mut sum = Sum::new();
    for (unknown, count) in line.sum() {
        match locked.iter().find(|(pivot, ..)| *pivot == unknown) {
            None => *sum.entry(unknown).or_insert(0.0) += count,
            Some((_, known, terms)) => {
                constant += count * known;
                terms.iter().for_each(|(term, factor)| *sum.entry(*term).or_insert(0.0) += count * factor);
            }
        }
    }
    sum.retain(|_, factor| factor.abs() > CANCELLED);
    (constant, sum)
}

/// Solves the `=` lines in their order. Returns the unknowns that follow, each with its constant and its sum over free
/// unknowns, and the redundant lines.
pub(super) fn eliminate(lines: &[NamedSum]) -> (Vec<Locked>, Vec<usize>) {
    let mut locked: Vec<Locked> = Vec::new();
    let mut redundant = Vec::new();
    for line in lines.iter().filter(|line| line.relation == Relation::Equal) {
        let (constant, sum) = substituted(line, &locked);
        let is_free = |unknown: &&usize| locked.iter().all(|(pivot, ..)| pivot != *unknown);
        // The last named unknown that is free. If substitution has cancelled it, the last of the remaining ones.
        let last_named = line.unknowns.iter().rev().find(is_free).filter(|unknown| sum.contains_key(unknown)).copied();
        let Some(pivot) = last_named.or_else(|| sum.keys().next_back().copied()) else {
            redundant.push(line.index);
            continue;
        };
        let factor = sum[&pivot];
        let own_constant = (1.0 - constant) / factor;
        let own: Sum =
            sum.iter().filter(|(unknown, _)| **unknown != pivot).map(|(unknown, other)| (*unknown, -other / factor)).collect();
        for (_, constant, terms) in &mut locked {
            if let Some(share) = terms.remove(&pivot) {
                *constant += share * own_constant;
                own.iter().for_each(|(unknown, factor)| *terms.entry(*unknown).or_insert(0.0) += share * factor);
                terms.retain(|_, factor| factor.abs() > CANCELLED);
            }
        }
        locked.push((pivot, own_constant, own));
    }
    (locked, redundant)
}

//! Limits of sums that bind. A limit that the search would leave becomes an equality, and one of its numbers then
//! follows from the others.

use crate::fit::unknowns::{LimitOrigin, LinearSum, SumLimit, Unknowns, VariableScale};

/// Less is rounding: parameters have about seven digits.
const ROUNDING: f64 = 1e-7;

impl Unknowns {
    /// Whether these variables keep every limit, but for rounding.
    pub fn keeps_limits(&self, variables: &[f64]) -> bool {
        let free = self.unclamped(variables);
        self.limits.iter().all(|limit| limit.outside(&free).abs() <= ROUNDING)
    }

    /// The same unknowns where the limit that these variables exceed the most is an equality. `None` if none is
    /// exceeded, or no number is left that could follow from it.
    pub fn bound(&self, variables: &[f64]) -> Option<Self> {
        let free = self.unclamped(variables);
        let outside = |limit: &SumLimit| limit.outside(&free);
        let mut exceeded: Vec<(usize, f64)> = self.limits.iter().map(outside).enumerate().collect();
        exceeded.retain(|(_, outside)| outside.abs() > ROUNDING);
        exceeded.sort_by(|(_, one), (_, other)| other.abs().total_cmp(&one.abs()));
        exceeded.iter().find_map(|(limit, outside)| self.bound_by(*limit, usize::from(*outside > 0.0), &free))
    }

    fn bound_by(&self, limit: usize, end: usize, free: &[f64]) -> Option<Self> {
        let reduced = self.limits[limit].sum.resolved(&self.held);
        // The number that has the most room follows, so that its own range is not the next limit.
        let room = |(at, _): &&(usize, f64)| {
            let number = &self.free[*at];
            (free[*at] - number.low).min(number.high - free[*at]) / self.width(*at)
        };
        let (pivot, factor) = *reduced.terms.iter().max_by(|one, other| room(one).total_cmp(&room(other)))?;
        let rest = reduced.terms.iter().filter(|(at, _)| *at != pivot);
        let follows = LinearSum {
            constant: (self.limits[limit].ends[end] - reduced.constant) / factor,
            terms: rest.map(|(at, other)| (*at, -other / factor)).collect(),
        };
        let mut bound = self.clone();
        let own = [(pivot, follows.clone())];
        bound.held.iter_mut().for_each(|(_, sum)| *sum = sum.resolved(&own));
        bound.held.push((pivot, follows));
        bound.moving.retain(|at| *at != pivot);
        bound.binding.push((limit, end));
        let number = &self.free[pivot];
        if !matches!(number.scale, VariableScale::Free { .. }) {
            let sum = LinearSum { constant: 0.0, terms: vec![(pivot, 1.0)] };
            bound.limits.push(SumLimit { sum, ends: [number.low, number.high], origin: LimitOrigin::Own(number.number) });
        }
        Some(bound)
    }

    /// The limits that bind, each with the index of the bound that is reached: the lower or the upper one.
    pub fn binding(&self) -> Vec<(LimitOrigin, usize)> {
        self.binding.iter().map(|(limit, end)| (self.limits[*limit].origin.clone(), *end)).collect()
    }

    /// At which end of what the binding limits leave to it a free number stands, if they leave one value only.
    pub fn sole_end(&self, free: usize) -> Option<usize> {
        let (_, sum) = self.held.iter().find(|(at, _)| *at == free)?;
        let of = |(limit, end): &(usize, usize)| {
            let factor = self.limits[*limit].sum.terms.iter().find(|(at, _)| *at == free)?.1;
            Some(if factor > 0.0 { *end } else { 1 - *end })
        };
        sum.terms.is_empty().then(|| self.binding.iter().find_map(of)).flatten()
    }
}

impl LinearSum {
    /// The same sum where some numbers are replaced by what they follow from.
    fn resolved(&self, held: &[(usize, LinearSum)]) -> Self {
        /// What is left of factors that cancel.
        const CANCELLED: f64 = 1e-9;
        let mut result = Self { constant: self.constant, terms: Vec::new() };
        let mut add = |at: usize, factor: f64| match result.terms.iter_mut().find(|(known, _)| *known == at) {
            Some((_, known)) => *known += factor,
            None => result.terms.push((at, factor)),
        };
        let mut constant = 0.0;
        for (at, factor) in &self.terms {
            match held.iter().find(|(known, _)| known == at) {
                Some((_, sum)) => {
                    constant += factor * sum.constant;
                    sum.terms.iter().for_each(|(at, own)| add(*at, factor * own));
                }
                None => add(*at, *factor),
            }
        }
        result.constant += constant;
        result.terms.retain(|(_, factor)| factor.abs() > CANCELLED);
        result
    }
}

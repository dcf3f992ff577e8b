//! Variants of a formula for the conditions that are known once a frame.
//!
//! A formula with several models chooses by a switch, a choice or another parameter, so its condition is uniform: one
//! value for each pair of a body and a light. Code that computes all branches and selects one is as slow as all models
//! together. In a *variant* the conditions have known values, and only the branches that are taken are left.

use crate::formula::Formula;
use crate::formula::binding::{Bindings, Frontier};
use crate::formula::binding_time::BindingTime;
use crate::formula::graph::{Node, NodeId};
use crate::formula::rewrite::specialise;
use crate::lang::scalars::Primitive;
use std::collections::HashMap;

/// With more conditions than this, the others are computed for each record.
pub const MOST_CONDITIONS: usize = 32;

impl Bindings {
    /// The uniform conditions by which dynamic values are selected, at most [`MOST_CONDITIONS`].
    pub fn uniform_conditions(&self) -> Vec<NodeId> {
        let mut found = Vec::new();
        let mut seen = vec![false; self.graph.len()];
        let mut pending = self.contribution.to_vec();
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) || self.time(id) != BindingTime::Dynamic {
                continue;
            }
            let node = self.graph.node(id);
            if let Node::Apply(Primitive::Select, [condition, ..]) = node
                && self.time(condition) == BindingTime::Uniform
            {
                found.push(condition);
            }
            pending.extend_from_slice(node.operands());
        }
        found.sort_unstable();
        found.dedup();
        found.truncate(MOST_CONDITIONS);
        found
    }

    /// The nodes that are 1 where each condition holds, and 0 elsewhere. They are added.
    pub fn condition_numbers(&mut self, conditions: &[NodeId]) -> Vec<NodeId> {
        let [one, zero] = [1.0, 0.0].map(|number| self.constant(number));
        conditions.iter().map(|condition| self.record(Primitive::Select, &[*condition, one, zero])).collect()
    }

    /// The variant in which these conditions hold or not, and the static values of all branches as nodes of its graph.
    /// The variant reads a part of them, or values that can be computed from them.
    pub fn variant(&self, formula: &Formula, conditions: &[(NodeId, bool)]) -> (Bindings, Frontier) {
        let known: HashMap<NodeId, bool> = conditions.iter().copied().collect();
        let frontier = &self.frontier;
        let columns: Vec<NodeId> = frontier.hits.iter().chain(&frontier.records).copied().collect();
        let (graph, contribution, columns) = specialise(&self.graph, &known, self.contribution, &columns, formula);
        let (hits, records) = columns.split_at(frontier.hits.len());
        let given = Frontier { hits: hits.to_vec(), records: records.to_vec(), uniforms: Vec::new() };
        (Bindings::analysed(graph, &contribution), given)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    #[test]
    fn a_variant_is_as_short_as_the_branch_alone() {
        let source = |result: &str| {
            let text = format!(
                "body_specific; model: scalar, choices \"Lambert\", \"Phong\", \"Blinn\"; h: scalar, constraint 1..500; formula;
                 D = Cd*max(0, N.L); P = Cd*pow(max(0, R.V), h); B = Cd*pow(max(0, N.H), h); = {result};"
            );
            Formula::parse(&Source::new("test", text)).expect("a formula").0
        };
        let formula = source("IL*if(model == 0, D, if(model == 1, P, B))");
        let all = Bindings::new(&formula);
        let conditions = all.uniform_conditions();
        assert_eq!(conditions.len(), 2);
        for (holds, alone) in [([true, false], "IL*D"), ([false, true], "IL*P"), ([false, false], "IL*B")] {
            let known: Vec<(NodeId, bool)> = conditions.iter().copied().zip(holds).collect();
            let (variant, given) = all.variant(&formula, &known);
            let alone = Bindings::new(&source(alone));
            let dynamic = |bindings: &Bindings| {
                let (mut count, mut pending, mut seen) = (0, bindings.contribution.to_vec(), std::collections::HashSet::new());
                while let Some(id) = pending.pop() {
                    if bindings.time(id) == BindingTime::Dynamic && seen.insert(id) {
                        count += 1;
                        pending.extend_from_slice(bindings.graph.node(id).operands());
                    }
                }
                count
            };
            assert_eq!(dynamic(&variant), dynamic(&alone), "{holds:?}");
            // It reads as many columns as the branch alone. They are computed from those of all branches.
            assert_eq!(variant.frontier.records.len(), alone.frontier.records.len(), "{holds:?}");
            assert_eq!(given.records.len(), all.frontier.records.len());
        }
    }

    #[test]
    fn conditions_that_vary_from_hit_to_hit_stay() {
        let (formula, _) = Formula::parse(&Source::new(
            "test",
            "body_specific; s: scalar, switch; formula; = if(N.V > 0.5, s*Cd, IL) + if(s && N.L > 0, IL, Cd);",
        ))
        .expect("a formula");
        assert!(Bindings::new(&formula).uniform_conditions().is_empty());
    }
}

//! A formula for lights whose samples do not all count the same: spots and environments.
//!
//! A light sends its colour `IL` times a radiance to a hit, and a sample of it has a weight. The mean of `weight ·
//! formula(IL · radiance)` over the samples is what the light adds. So the formula becomes another formula, which reads
//! both as variables. It has the same parameters.

use crate::formula::graph::Graph;
use crate::formula::power::power;
use crate::formula::{Formula, SurfaceTerms, Term, TermId};
use crate::lang::builtins::Operation;
use crate::lang::variables::{Predefined, Variable};
use std::sync::Arc;

impl Formula {
    /// The formula for samples of lights that have a radiance and a weight. If the result is proportional to `IL`, as
    /// most are, it reads the product of both, which is one value less.
    #[must_use]
    pub fn for_weighted_samples(&self) -> Arc<Formula> {
        let colour = self.predefined(Predefined::LightColour);
        let graph = Graph::new(self);
        let is_proportional = graph.result().into_iter().all(|node| power(&graph, node, |id| id == colour) == Some(1));
        let mut terms = Vec::with_capacity(self.terms.len() + 4);
        // Where each expression is now.
        let mut moved: Vec<TermId> = Vec::with_capacity(self.terms.len());
        let next = |terms: &Vec<Term>| TermId(terms.len() as u32);
        for term in &self.terms {
            let operands = |operands: &[TermId]| operands.iter().map(|id| moved[id.0 as usize]).collect::<Vec<_>>();
            match term {
                Term::Parameter(parameter) if *parameter == colour => {
                    let own = next(&terms);
                    let radiance = if is_proportional { Variable::WeightedRadiance } else { Variable::Radiance };
                    terms.extend([term.clone(), Term::Variable(radiance)]);
                    terms.push(Term::Apply(Operation::MulVV, vec![own, TermId(own.0 + 1)]));
                }
                Term::Number(_) | Term::Variable(_) | Term::Parameter(_) | Term::Material(_) => terms.push(term.clone()),
                Term::Apply(operation, all) => terms.push(Term::Apply(*operation, operands(all))),
                Term::ByComponents(operation, all) => terms.push(Term::ByComponents(*operation, operands(all))),
            }
            moved.push(TermId(terms.len() as u32 - 1));
        }
        let mut result = moved[self.result.0 as usize];
        if !is_proportional {
            let weight = next(&terms);
            terms.push(Term::Variable(Variable::SampleWeight));
            terms.push(Term::Apply(Operation::MulVS, vec![result, weight]));
            result = TermId(weight.0 + 1);
        }
        let mut surface = SurfaceTerms::default();
        self.surface.iter().for_each(|(term, id)| surface.set(term, moved[id.0 as usize]));
        let macros = self.macros.iter().map(|(name, id)| (name.clone(), moved[id.0 as usize])).collect();
        Arc::new(Formula { terms, macros, result, surface, ..self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    fn variables(text: &str) -> Vec<Variable> {
        let (formula, _) = Formula::parse(&Source::new("formula", format!("formula; {text}"))).expect("a formula");
        let weighted = formula.for_weighted_samples();
        let used = weighted.terms_of(weighted.result);
        let internal = [Variable::Radiance, Variable::SampleWeight, Variable::WeightedRadiance];
        internal.into_iter().filter(|one| used.iter().any(|id| *weighted.term(*id) == Term::Variable(*one))).collect()
    }

    #[test]
    fn a_formula_that_is_proportional_to_the_colour_of_the_light_reads_one_value() {
        for proportional in [
            "= IL*Cd*max(0, N.L);",
            "D = 0.5*IL*Cd*max(0, N.L); S = IL*pow(max(0, R.V), 20); = D + S;",
            "= if(N.L > 0.5, IL*Cd, 2*IL);",
            "= <1, 0.5, 0.2>*(IL.<0.2, 0.7, 0.1>);",
            "= IL/<2>*Cd - IL;",
        ] {
            assert_eq!(variables(proportional), [Variable::WeightedRadiance], "{proportional}");
        }
        for other in ["= IL*IL;", "= IL + Cd;", "= sqrt(IL);", "= max(IL, Cd);", "= IL*Cd/(IL.<1,1,1>);"] {
            assert_eq!(variables(other), [Variable::Radiance, Variable::SampleWeight], "{other}");
        }
        assert_eq!(variables("= Cd*max(0, N.L);"), [Variable::SampleWeight]);
    }
}

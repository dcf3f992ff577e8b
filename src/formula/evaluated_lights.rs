//! The lights for which a formula is evaluated: all of them if it reads `visible`.

use crate::formula::{Formula, Term};
use crate::lang::variables::{EvaluatedLights, Variable};

impl Formula {
    /// The lights for which the formula is evaluated at a hit. Only what the result uses counts: a macro that reads
    /// `visible` and that nothing uses changes nothing.
    pub fn evaluated_lights(&self) -> EvaluatedLights {
        if self.reads(Variable::Visible) { EvaluatedLights::All } else { EvaluatedLights::Reaching }
    }

    /// Whether the result uses a variable, directly or through macros.
    fn reads(&self, variable: Variable) -> bool {
        let used = self.terms_of(self.result);
        used.into_iter().any(|id| *self.term(id) == Term::Variable(variable))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    fn lights(formula: &str) -> EvaluatedLights {
        let text = format!("body_specific; p: scalar; formula; {formula}");
        Formula::parse(&Source::new("formula", text)).expect("a formula").0.evaluated_lights()
    }

    #[test]
    fn only_a_result_that_reads_visible_is_evaluated_for_all_lights() {
        use EvaluatedLights::{All, Reaching};
        assert_eq!(lights("= Cd*max(0, N.L);"), Reaching);
        assert_eq!(lights("= Cd*visible;"), All);
        assert_eq!(lights("LIT = p*visible; WRAP = if(p > 0, LIT, 1); = Cd*WRAP;"), All);
        assert_eq!(lights("UNUSED = visible; = Cd;"), Reaching);
        assert_eq!(lights("visible = p; = Cd*visible;"), Reaching);
    }
}

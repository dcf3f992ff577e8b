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
        let mut is_used = vec![false; self.terms.len()];
        is_used[self.result.0 as usize] = true;
        // Operands come before their users.
        for (index, term) in self.terms.iter().enumerate().rev() {
            match term {
                Term::Variable(read) if is_used[index] && *read == variable => return true,
                Term::Apply(_, operands) if is_used[index] => {
                    operands.iter().for_each(|operand| is_used[operand.0 as usize] = true);
                }
                Term::Number(_) | Term::Variable(_) | Term::Parameter(_) | Term::Apply(..) => {}
            }
        }
        false
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

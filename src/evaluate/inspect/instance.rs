//! The formula at one hit for one light, with its numbers: what the thesis would write (4.2.1).

use crate::evaluate::inspect::figures::Quantity;
use crate::formula::{Formula, Term, TermId};
use crate::lang::builtins::{Form, Operation};
use std::collections::HashMap;

/// The formula with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Instance {
    /// The macros in the order of the file, and last the result.
    pub lines: Vec<InstanceLine>,
}

/// A macro or the result of the formula with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct InstanceLine {
    /// The macro's name; `None`: the result.
    pub name: Option<String>,
    /// The expression as in the formula, without parentheses that change nothing: `kd*IL*Cd*max(0, N.L)`.
    pub written: String,
    /// The same with rounded numbers for names: `0.6*<1, 1, 1>*<0.9, 0.2, 0.1>*max(0, 0.8333)`. The dot product of two variables, a cosine
    /// mostly, is one number.
    pub numbers: String,
    /// What it yields; to be written, it is rounded likewise.
    pub value: Quantity,
}

impl Instance {
    /// The formula with these values of its terms, scalars three times.
    pub(super) fn new(formula: &Formula, values: &[[f32; 3]]) -> Self {
        let quantity = |id: TermId| Quantity::new(formula.ty(id), values[id.0 as usize]);
        // Of macros that are one another's names the first counts as the one that is written out.
        let mut names: HashMap<TermId, &str> = HashMap::new();
        for (name, id) in &formula.macros {
            names.entry(*id).or_insert(name);
        }
        let line = |name: Option<&str>, root: TermId| {
            // Its own name would say nothing of it.
            let named = |id: TermId| names.get(&id).filter(|known| id != root || name != Some(**known));
            let written = formula.written(root, |id| named(id).map(|name| (*name).to_owned()));
            let number = |id: TermId| (named(id).is_some() || is_leaf(formula, id)).then(|| quantity(id).to_string());
            let numbers = formula.written(root, number);
            InstanceLine { name: name.map(str::to_owned), written, numbers, value: quantity(root) }
        };
        let mut lines: Vec<InstanceLine> = formula.macros.iter().map(|(name, id)| line(Some(name), *id)).collect();
        lines.push(line(None, formula.result));
        Self { lines }
    }
}

/// Whether a number is written for a term: for whatever is known by a name, and for the dot product of two variables.
fn is_leaf(formula: &Formula, id: TermId) -> bool {
    match formula.term(id) {
        Term::Number(_) => false,
        Term::Variable(_) | Term::Parameter(_) => true,
        Term::Apply(Operation::DotVV, operands) => {
            operands.iter().all(|operand| matches!(formula.term(*operand), Term::Variable(_)))
        }
        Term::Apply(operation, _) => matches!(operation.form(), Form::Constant(_)),
    }
}

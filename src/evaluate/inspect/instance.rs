//! The formula at one hit for one light, with numbers in place of names, as in the thesis (4.2.1).

use crate::evaluate::inspect::figures::Quantity;
use crate::formula::{Formula, Term, TermId};
use crate::lang::builtins::{Form, Operation};
use crate::lang::token::Mark;
use std::collections::{HashMap, HashSet};

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
    /// The same with rounded numbers for names: `0.6*<1, 1, 1>*<0.9, 0.2, 0.1>*max(0, 0.8333)`. The dot product of two
    /// variables, a cosine mostly, is one number.
    pub numbers: String,
    /// Its value. It is rounded in the same way when it is written.
    pub value: Quantity,
}

impl Instance {
    /// The formula with these values of its terms, scalars three times.
    pub(super) fn new(formula: &Formula, values: &[[f32; 3]]) -> Self {
        let quantity = |id: TermId| Quantity::new(formula.ty(id), values[id.0 as usize]);
        // If macros are names of each other, the first one is written out.
        let mut names: HashMap<TermId, &str> = HashMap::new();
        for (name, id) in &formula.macros {
            names.entry(*id).or_insert(name);
        }
        let behind = behind_operators(formula);
        let number = |id: TermId| match quantity(id) {
            Quantity::Scalar(value) if value < 0.0 && behind.contains(&id) => format!("({})", Quantity::Scalar(value)),
            value @ (Quantity::Scalar(_) | Quantity::Vector(_)) => value.to_string(),
        };
        let line = |name: Option<&str>, root: TermId| {
            // The expression of a macro does not use the macro's own name.
            let named = |id: TermId| names.get(&id).filter(|known| id != root || name != Some(**known));
            let written = formula.written(root, |id| named(id).map(|name| (*name).to_owned()));
            let numbers = formula.written(root, |id| (named(id).is_some() || is_leaf(formula, id)).then(|| number(id)));
            InstanceLine { name: name.map(str::to_owned), written, numbers, value: quantity(root) }
        };
        let mut lines: Vec<InstanceLine> = formula.macros.iter().map(|(name, id)| line(Some(name), *id)).collect();
        lines.push(line(None, formula.result));
        Self { lines }
    }
}

/// Terms behind an operator, and bases of powers. A negative number in such a place is easier to read in parentheses.
fn behind_operators(formula: &Formula) -> HashSet<TermId> {
    let mut behind = HashSet::new();
    for term in &formula.terms {
        let (Term::Apply(operation, operands) | Term::ByComponents(operation, operands)) = term else { continue };
        match operation.form() {
            Form::Prefix(_) | Form::Infix(Mark::Caret) => behind.extend(operands),
            Form::Infix(_) | Form::UnitDot => behind.extend(operands.get(1)),
            Form::Function(_) | Form::Constant(_) | Form::Vector | Form::Conditional => {}
        }
    }
    behind
}

/// Whether a number is written for a term: for everything that has a name, and for the dot product of two variables.
fn is_leaf(formula: &Formula, id: TermId) -> bool {
    match formula.term(id) {
        Term::Number(_) => false,
        Term::Variable(_) | Term::Parameter(_) => true,
        Term::Apply(Operation::DotVV | Operation::UnitDotVV, operands) => {
            operands.iter().all(|operand| matches!(formula.term(*operand), Term::Variable(_)))
        }
        Term::Apply(operation, _) => matches!(operation.form(), Form::Constant(_)),
        Term::ByComponents(..) => false,
    }
}

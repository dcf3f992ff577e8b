//! Checks the syntax tree and makes a [`Formula`]: the meaning of names, the types of expressions, parameters and
//! invariants.
//!
//! All mistakes are reported together. An expression with a mistake has no type, and expressions that use it are not
//! reported.

mod expressions;
mod invariants;
mod names;
mod parameters;
mod substitution;

use crate::formula::Formula;
use crate::lang::ast::FormulaFile;
use crate::lang::diagnostic::Diagnostics;
use crate::lang::parser;
use crate::lang::source::Source;

impl Formula {
    /// Parses and checks a formula file. Returns the formula and the warnings.
    ///
    /// # Errors
    /// All errors and warnings of the text.
    pub fn parse(source: &Source) -> Result<(Formula, Diagnostics), Diagnostics> {
        let (file, diagnostics) = parser::parse(source);
        check(&file, diagnostics)
    }
}

/// Checks a formula file. `diagnostics` are those of the parser. Returns the formula and the warnings.
fn check(file: &FormulaFile, mut diagnostics: Diagnostics) -> Result<(Formula, Diagnostics), Diagnostics> {
    let parameters = parameters::parameters(file, &mut diagnostics);
    let names = names::Names::collect(file, &parameters, &mut diagnostics);
    let invariants = invariants::invariants(file, &parameters, &names, &mut diagnostics);
    invariants::solve(file, &parameters, &invariants, &mut diagnostics);
    let expressions = expressions::check(file, &parameters, &names, &mut diagnostics);
    substitution::warn(file, &names, &expressions, &mut diagnostics);
    let formula = expressions.result.map(|result| Formula {
        uses: file.uses.as_ref().map(|(path, _)| path.clone()),
        parameters,
        invariants: invariants.into_iter().map(|(invariant, _)| invariant).collect(),
        macros: expressions.macros,
        terms: expressions.terms,
        result,
    });
    diagnostics.sort();
    match formula {
        Some(formula) if !diagnostics.has_errors() => Ok((formula, diagnostics)),
        _ => Err(diagnostics),
    }
}

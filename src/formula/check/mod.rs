//! Syntax into a [`Formula`]: whose each name is, of what type each expression, whether parameters and invariants make
//! sense.
//!
//! Everything that can be found wrong is reported in one go; an expression that holds a mistake has no type, and
//! nothing more is said of what uses it.

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
    /// Reads and checks a formula file; with the formula come the warnings.
    ///
    /// # Errors
    /// Everything wrong with the text that can be found in one go, warnings among it.
    pub fn parse(source: &Source) -> Result<(Formula, Diagnostics), Diagnostics> {
        let (file, diagnostics) = parser::parse(source);
        check(&file, diagnostics)
    }
}

/// Checks a formula file, after the `diagnostics` of parsing it; with the formula come the warnings.
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
